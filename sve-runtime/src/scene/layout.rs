//! The facts about the loops of a scene that follow from its size.

use core::fmt;

use super::Scene;
use super::segments::Segments;
use super::work::MidpointSolution;

/// How the loops of a scene are made for a number of sites.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Layout {
    /// Number of sites.
    pub sites: usize,
    /// Number of instances of the loops whose derivatives are gathered from consecutive sites.
    pub instances: usize,
    /// Number of intervals of sites with the same neighbours.
    pub segments: usize,
    /// Fraction of the sites that do not get all contributions of an inner site, and are made
    /// contribution by contribution.
    pub border: f64,
    /// The loops that are made as they are written, because indices of consecutive instances are
    /// not consecutive: "the loop at line 9 of `lagrangian`".
    pub as_written: Vec<&'static str>,
    /// Bytes of tables and of the arrays that a single step and the steps so far need, beside the
    /// state.
    pub bytes: usize,
    /// How a step of `midpoint` from this state without noise is solved, the last one of a
    /// composition; `None` for explicit rules.
    pub midpoint: Option<MidpointSolution>,
}

impl Layout {
    pub(super) fn new<S: Scene>(sites: usize, segments: &Segments, bytes: usize) -> Self {
        let full = segments.pieces.iter().filter(|piece| piece.is_full);
        let full: usize = full.map(|piece| piece.nodes().len()).sum();
        let all: usize = segments
            .pieces
            .iter()
            .map(|piece| piece.nodes().len())
            .sum();
        Self {
            sites,
            instances: segments.instances,
            segments: segments.count,
            border: (all - full) as f64 / all.max(1) as f64,
            as_written: segments
                .nests
                .iter()
                .map(|&nest| S::LOOPS[nest].text)
                .collect(),
            bytes: bytes + segments.bytes(),
            midpoint: None,
        }
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            sites,
            instances,
            segments,
            border,
            as_written,
            bytes,
            midpoint,
        } = self;
        writeln!(f, "{sites} sites")?;
        writeln!(
            f,
            "{instances} instances gathered in {segments} segments, {:.1} % of the sites at borders",
            100.0 * border
        )?;
        for text in as_written {
            writeln!(f, "{text} as it is written")?;
        }
        write!(f, "{bytes} bytes beside the state")?;
        if let Some(MidpointSolution { bounds, sweeps }) = midpoint {
            let [lower, upper] = bounds;
            write!(
                f,
                "\n{sweeps} sweeps a step: h²/4 M⁻¹ ∂²V/∂q² lies between {lower:.4} and {upper:.4}"
            )?;
        }
        Ok(())
    }
}
