//! Frames of bodies in the extended XYZ format.
//!
//! Input: the time, positions and momenta of bodies in up to three dimensions, their names and the
//! box. Output: a frame: the number of bodies, a line that describes the columns, and a line for
//! each body. Invariant: numbers are written with the digits that give back their bits.
//!
//! Source: the specification of the format, <https://github.com/libAtoms/extxyz>.

use std::io::{self, Write};

/// The names of bodies and their box, for frames in the extended XYZ format, which `OVITO`, `VMD`
/// and `ASE` read.
///
/// A frame has the columns `species`, `pos` and `momenta`. Coordinates that bodies in one or two
/// dimensions lack are 0.
///
/// ```
/// use sve_runtime::Xyz;
///
/// # fn main() -> std::io::Result<()> {
/// let xyz = Xyz::new().periodic([4.0, 3.0]).species(["Ar", "Kr"]);
/// let mut file = Vec::new();
/// xyz.write_frame(&mut file, 0.5, &[[1.0, 2.0], [3.0, 0.1]], &[[0.0, 1.0], [0.0, -1.0]])?;
/// assert_eq!(String::from_utf8_lossy(&file), "2
/// Lattice=\"4.0 0.0 0.0 0.0 3.0 0.0 0.0 0.0 1.0\" pbc=\"T T F\" Properties=species:S:1:pos:R:3:momenta:R:3 Time=0.5
/// Ar 1.0 2.0 0.0 0.0 1.0 0.0
/// Kr 3.0 0.1 0.0 0.0 -1.0 0.0
/// ");
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Xyz<const D: usize> {
    /// Length of the box along each axis; infinite if the axis is open.
    lengths: [f64; D],
    /// A name for all bodies, or one for each.
    species: Vec<String>,
}

impl<const D: usize> Default for Xyz<D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const D: usize> Xyz<D> {
    /// Returns frames without a box, of bodies of the name `X`.
    #[must_use]
    pub fn new() -> Self {
        const {
            assert!(
                1 <= D && D <= 3,
                "a frame has bodies in 1, 2 or 3 dimensions"
            );
        };
        Self {
            lengths: [f64::INFINITY; D],
            species: vec!["X".to_owned()],
        }
    }

    /// Sets the lengths of a periodic box. An axis whose length is not finite is open.
    #[must_use]
    pub fn periodic(self, lengths: [f64; D]) -> Self {
        Self { lengths, ..self }
    }

    /// Sets the names of the bodies in their order, or one name for all of them.
    #[must_use]
    pub fn species<T: Into<String>>(self, names: impl IntoIterator<Item = T>) -> Self {
        let species = names.into_iter().map(Into::into).collect();
        Self { species, ..self }
    }

    /// Writes a frame: the bodies at a time, their positions `q` and momenta `p`, arrays or vectors
    /// of numbers. The frames of a file follow one another.
    ///
    /// # Errors
    /// An error of the kind [`InvalidInput`](io::ErrorKind::InvalidInput), before anything is
    /// written, if there is another number of momenta or of names than of bodies, or if a name is
    /// empty or has white space; the errors of the writer.
    pub fn write_frame(
        &self,
        mut to: impl Write,
        t: f64,
        q: &[impl Copy + Into<[f64; D]>],
        p: &[impl Copy + Into<[f64; D]>],
    ) -> io::Result<()> {
        let species = self.names_of(q.len(), p.len())?;
        writeln!(to, "{}", q.len())?;
        if let Some(lattice) = self.lattice() {
            write!(to, "Lattice=\"{lattice}\" ")?;
        }
        let periodic: [_; 3] = core::array::from_fn(|axis| match self.length(axis) {
            Some(_) => "T",
            None => "F",
        });
        let columns = "species:S:1:pos:R:3:momenta:R:3";
        let periodic = periodic.join(" ");
        writeln!(to, "pbc=\"{periodic}\" Properties={columns} Time={t:?}")?;
        for ((&q, &p), name) in q.iter().zip(p).zip(species) {
            let [[x, y, z], [p_x, p_y, p_z]] = [Into::into(q), Into::into(p)].map(in_space);
            writeln!(to, "{name} {x:?} {y:?} {z:?} {p_x:?} {p_y:?} {p_z:?}")?;
        }
        Ok(())
    }

    /// Returns the length of the box along an axis of space, if it is periodic.
    fn length(&self, axis: usize) -> Option<f64> {
        let length = self.lengths.get(axis).copied();
        length.filter(|length| length.is_finite())
    }

    /// Returns the vectors of the box; `None` if all axes are open. An open axis has the length 1,
    /// since programs want vectors that span space.
    fn lattice(&self) -> Option<String> {
        (0..3).find_map(|axis| self.length(axis))?;
        let entry = |k: usize| match (k % 4, self.length(k / 4)) {
            (0, length) => format!("{:?}", length.unwrap_or(1.0)),
            _ => "0.0".to_owned(),
        };
        Some((0..9).map(entry).collect::<Vec<_>>().join(" "))
    }

    /// Returns the name of each body.
    fn names_of(&self, bodies: usize, momenta: usize) -> io::Result<impl Iterator<Item = &str>> {
        let invalid = |text: String| Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        if momenta != bodies {
            return invalid(format!("there are {momenta} momenta for {bodies} bodies"));
        }
        let names = self.species.len();
        if names != 1 && names != bodies {
            return invalid(format!(
                "there are {names} names for {bodies} bodies: give one name for all, or one for each"
            ));
        }
        let is_no_word = |name: &&String| name.is_empty() || name.contains(char::is_whitespace);
        if let Some(name) = self.species.iter().find(is_no_word) {
            return invalid(format!(
                "the name {name:?} of a body must have no white space, and at least one letter"
            ));
        }
        Ok(self.species.iter().cycle().map(String::as_str))
    }
}

/// Returns a vector in three dimensions.
fn in_space<const D: usize>(vector: [f64; D]) -> [f64; 3] {
    core::array::from_fn(|axis| vector.get(axis).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::Xyz;
    use nalgebra::Vector3;

    fn frame<const D: usize>(xyz: &Xyz<D>, q: &[[f64; D]]) -> String {
        let mut text = Vec::new();
        xyz.write_frame(&mut text, 0.25, q, q).unwrap();
        String::from_utf8(text).unwrap()
    }

    /// Reads the numbers of a frame again.
    #[test]
    fn numbers_keep_their_bits() {
        let q = [[1.0 / 3.0, -5e-324, 1e300], [0.1 + 0.2, f64::NAN, -0.0]];
        let text = frame(&Xyz::new(), &q);
        let lines: Vec<_> = text.lines().collect();
        assert_eq!((lines[0], lines.len()), ("2", 4));
        for (line, q) in lines[2..].iter().zip(q) {
            let (name, numbers) = line.split_once(' ').unwrap();
            let numbers: Vec<f64> = numbers.split(' ').map(|x| x.parse().unwrap()).collect();
            assert_eq!((name, numbers.len()), ("X", 6));
            for (read, written) in numbers.iter().zip(q.iter().chain(&q)) {
                assert_eq!(read.to_bits(), written.to_bits());
            }
        }
    }

    #[test]
    fn boxes_say_which_axes_are_periodic() {
        let head = |text: String| text.lines().nth(1).unwrap().to_owned();
        let columns = "Properties=species:S:1:pos:R:3:momenta:R:3 Time=0.25";
        assert_eq!(
            head(frame(&Xyz::new(), &[[0.0]])),
            format!("pbc=\"F F F\" {columns}")
        );
        let slab = Xyz::new().periodic([2.0, f64::INFINITY, 0.5]);
        assert_eq!(
            head(frame(&slab, &[[0.0; 3]])),
            format!("Lattice=\"2.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 0.5\" pbc=\"T F T\" {columns}")
        );
    }

    #[test]
    fn vectors_and_no_bodies_are_frames() {
        let mut text = Vec::new();
        let q = [Vector3::new(1.0, 2.0, 3.0)];
        Xyz::new().write_frame(&mut text, 0.0, &q, &q).unwrap();
        assert!(text.ends_with(b"\nX 1.0 2.0 3.0 1.0 2.0 3.0\n"));
        assert!(frame(&Xyz::<2>::new(), &[]).starts_with("0\n"));
    }

    #[test]
    fn wrong_names_and_numbers_are_errors() {
        let error = |xyz: &Xyz<1>, p: &[[f64; 1]]| {
            let mut text = Vec::new();
            let error = xyz.write_frame(&mut text, 0.0, &[[0.0]; 2], p).unwrap_err();
            assert!(text.is_empty() && error.kind() == std::io::ErrorKind::InvalidInput);
            error.to_string()
        };
        let p = [[0.0]; 2];
        assert!(error(&Xyz::new(), &p[..1]).contains("1 momenta for 2 bodies"));
        assert!(error(&Xyz::new().species(["A"; 3]), &p).contains("3 names for 2 bodies"));
        assert!(error(&Xyz::new().species(["A", "B C"]), &p).contains("\"B C\""));
        assert!(error(&Xyz::new().species([""]), &p).contains("\"\""));
    }
}
