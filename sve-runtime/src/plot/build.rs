//! Functions that make axes, panels, layers and pens of a figure.

use std::ops::Range;

use super::figure::{Axis, Corner, Layer, Note, Panel, Pen, Scale, Shape, Spread, Stroke, Symbols};
use super::palette::{CYCLE, Color};

impl Axis {
    /// Returns a linear axis.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Axis, Scale};
    /// let axis = Axis::new("time, seconds", 0.0..10.0);
    /// assert_eq!((axis.scale, axis.labels), (Scale::Linear, 6));
    /// ```
    pub fn new(name: impl Into<String>, range: Range<f64>) -> Self {
        Self {
            name: name.into(),
            range,
            scale: Scale::Linear,
            labels: 6,
        }
    }

    /// Returns an axis of decimal exponents.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Axis, Scale};
    /// // from 0.001 to 1
    /// assert_eq!(Axis::powers("error", -3.0..0.0).scale, Scale::Powers);
    /// ```
    pub fn powers(name: impl Into<String>, exponents: Range<f64>) -> Self {
        Self {
            scale: Scale::Powers,
            ..Self::new(name, exponents)
        }
    }

    /// Returns an axis of angles in radians.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Axis, Scale};
    /// // labelled 0, π/2, π …
    /// let axis = Axis::angle("angle", 0.0..core::f64::consts::TAU);
    /// assert_eq!(axis.scale, Scale::Angle);
    /// ```
    pub fn angle(name: impl Into<String>, range: Range<f64>) -> Self {
        Self {
            scale: Scale::Angle,
            ..Self::new(name, range)
        }
    }
}

impl Panel {
    /// Returns an empty panel.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Axis, Panel};
    /// let panel = Panel::new("Orbit", Axis::new("x", -1.0..1.0), Axis::new("y", -1.0..1.0));
    /// assert!(panel.layers.is_empty() && panel.legend.is_none());
    /// ```
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            equal: false,
            layers: Vec::new(),
            legend: None,
            notes: Vec::new(),
        }
    }

    /// Returns the panel with the same scale on both axes.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Axis, Panel};
    /// let axes = ["x", "y"].map(|name| Axis::new(name, -1.0..1.0));
    /// let [x, y] = axes;
    /// let panel = Panel::new("Orbit", x, y).equal();
    /// assert!(panel.equal);
    /// ```
    #[must_use]
    pub fn equal(mut self) -> Self {
        self.equal = true;
        self
    }

    /// Returns the panel with a legend.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Axis, Corner, Panel};
    /// let panel = Panel::new("Orbit", Axis::new("x", -1.0..1.0), Axis::new("y", -1.0..1.0))
    ///     .legend(Corner::Outside);
    /// assert_eq!(panel.legend, Some(Corner::Outside));
    /// ```
    #[must_use]
    pub fn legend(mut self, corner: Corner) -> Self {
        self.legend = Some(corner);
        self
    }

    /// Returns the panel with one more layer on top.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Axis, Layer, Panel, Pen};
    /// let panel = Panel::new("Orbit", Axis::new("x", -1.0..1.0), Axis::new("y", -1.0..1.0))
    ///     .with(Layer::new("planet", vec![(1.0, 0.0), (0.0, 1.0)], Pen::series(0)));
    /// assert_eq!(panel.layers[0].label, "planet");
    /// ```
    #[must_use]
    pub fn with(mut self, layer: Layer) -> Self {
        self.layers.push(layer);
        self
    }

    /// Returns the panel with a text.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Axis, Panel};
    /// use sve_runtime::plot::palette::BLUE;
    /// let panel = Panel::new("Orbit", Axis::new("x", -1.0..1.0), Axis::new("y", -1.0..1.0))
    ///     .note((0.0, 0.0), "sun", BLUE);
    /// assert_eq!(panel.notes[0].text, "sun");
    /// ```
    #[must_use]
    pub fn note(mut self, at: (f64, f64), text: impl Into<String>, color: Color) -> Self {
        self.notes.push(Note {
            at,
            text: text.into(),
            color,
        });
        self
    }
}

impl Layer {
    /// Returns a layer that the legend lists.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Layer, Pen};
    /// let layer = Layer::new("midpoint", vec![(0.0, 1.0), (0.1, 0.9)], Pen::series(0));
    /// assert!(layer.listed);
    /// ```
    pub fn new(label: impl Into<String>, points: Vec<(f64, f64)>, pen: Pen) -> Self {
        Self {
            label: label.into(),
            points,
            pen,
            listed: true,
            spread: Spread::None,
        }
    }

    /// Returns the layer with a bar at each point between two values, for example the mean less and
    /// plus two standard errors.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Layer, Pen, Spread};
    /// let (means, errors) = ([1.0, 0.9], [0.01, 0.02]);
    /// let points = vec![(0.0, means[0]), (0.1, means[1])];
    /// let ends = means.iter().zip(errors).map(|(m, e)| (m - 2.0 * e, m + 2.0 * e)).collect();
    /// let layer = Layer::new("mean ± 2 standard errors", points, Pen::series(0)).bars(ends);
    /// assert!(matches!(layer.spread, Spread::Bars(ends) if ends[0] == (0.98, 1.02)));
    /// ```
    #[must_use]
    pub fn bars(mut self, ends: Vec<(f64, f64)>) -> Self {
        self.spread = Spread::Bars(ends);
        self
    }

    /// Returns the layer with an area between two values at each point.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Layer, Pen, Spread};
    /// let layer = Layer::new("quartiles", vec![(0.0, 0.0), (1.0, 2.0)], Pen::series(0))
    ///     .band(vec![(-1.0, 1.0), (1.0, 3.0)]);
    /// assert!(matches!(layer.spread, Spread::Band(_)));
    /// ```
    #[must_use]
    pub fn band(mut self, ends: Vec<(f64, f64)>) -> Self {
        self.spread = Spread::Band(ends);
        self
    }

    /// Returns the layer with the area between the points and a value.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Layer, Pen, Spread};
    /// let layer = Layer::new("density", vec![(0.0, 0.3), (1.0, 0.7)], Pen::series(0)).filled(0.0);
    /// assert_eq!(layer.spread, Spread::Filled(0.0));
    /// ```
    #[must_use]
    pub fn filled(mut self, to: f64) -> Self {
        self.spread = Spread::Filled(to);
        self
    }

    /// Returns whether the layer has an area.
    pub(super) fn is_filled(&self) -> bool {
        matches!(self.spread, Spread::Band(_) | Spread::Filled(_))
    }

    /// Returns the layer without an entry in the legend.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Layer, Pen};
    /// let layer = Layer::new("second path", vec![(0.0, 0.0)], Pen::series(0)).unlisted();
    /// assert!(!layer.listed);
    /// ```
    #[must_use]
    pub fn unlisted(mut self) -> Self {
        self.listed = false;
        self
    }
}

impl Pen {
    /// Returns a solid line.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Pen};
    /// use sve_runtime::plot::palette::BLUE;
    /// let pen = Pen::line(BLUE, 2.0);
    /// assert!(pen.line.unwrap().dash.is_none() && pen.symbol.is_none());
    /// ```
    pub fn line(color: Color, width: f64) -> Self {
        Self {
            color,
            line: Some(Stroke { width, dash: None }),
            symbol: None,
        }
    }

    /// Returns a dashed line.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Pen};
    /// use sve_runtime::plot::palette::BLUE;
    /// // dashes of 7 pixels, gaps of 4
    /// assert_eq!(Pen::dashed(BLUE, 2.0, (7.0, 4.0)).line.unwrap().dash, Some((7.0, 4.0)));
    /// ```
    pub fn dashed(color: Color, width: f64, dash: (f64, f64)) -> Self {
        Self {
            line: Some(Stroke {
                width,
                dash: Some(dash),
            }),
            ..Self::line(color, width)
        }
    }

    /// Returns a dot on each point.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Pen};
    /// use sve_runtime::plot::palette::BLUE;
    /// assert!(Pen::dots(BLUE, 2.0).line.is_none());
    /// ```
    pub fn dots(color: Color, radius: f64) -> Self {
        Self {
            color,
            line: None,
            symbol: Some(Symbols {
                shape: Shape::Disc,
                radius,
                count: None,
            }),
        }
    }

    /// Returns the look of the series with this number, with a symbol on each point: the first
    /// seven differ in colour and symbol, later ones in their dashes.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Pen};
    /// assert_ne!(Pen::series(0).symbol.unwrap().shape, Pen::series(1).symbol.unwrap().shape);
    /// ```
    pub fn series(number: usize) -> Self {
        let shapes = [
            Shape::Disc,
            Shape::Square,
            Shape::Triangle,
            Shape::Cross,
            Shape::Circle,
        ];
        let color = CYCLE[number % CYCLE.len()];
        let dash = [None, Some((7.0, 4.0)), Some((2.0, 3.0))][number / CYCLE.len() % 3];
        Self {
            color,
            line: Some(Stroke { width: 1.6, dash }),
            symbol: Some(Symbols {
                shape: shapes[number % shapes.len()],
                radius: 3.2,
                count: None,
            }),
        }
    }

    /// Returns the pen with `count` symbols along the points.
    ///
    /// ```
    /// use sve_runtime::plot::figure::{Pen, Shape};
    /// use sve_runtime::plot::palette::BLUE;
    /// let pen = Pen::line(BLUE, 2.0).symbols(Shape::Diamond, 12);
    /// assert_eq!(pen.symbol.unwrap().count, Some(12));
    /// ```
    #[must_use]
    pub fn symbols(mut self, shape: Shape, count: usize) -> Self {
        self.symbol = Some(Symbols {
            shape,
            radius: 3.5,
            count: Some(count),
        });
        self
    }
}
