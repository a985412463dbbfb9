//! Figures as data: rows of panels, panels of layers.
//!
//! Points may have any values: points that are not finite or outside of a panel's axes are not
//! drawn.

use std::fmt::Write as _;
use std::ops::Range;

use super::palette::Color;
use crate::table::csv::quoted;

/// A figure: rows of panels under each other.
#[derive(Clone, Debug)]
pub struct Figure {
    /// File name without extension.
    pub name: &'static str,
    /// Width in CSS pixels.
    pub width: u32,
    /// Rows, from the top.
    pub rows: Vec<Row>,
}

/// Panels beside each other, of equal width.
#[derive(Clone, Debug)]
pub struct Row {
    /// Height in CSS pixels.
    pub height: u32,
    /// Panels, from the left.
    pub panels: Vec<Panel>,
}

/// One pair of axes and its layers.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Title above the axes.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// True if one of the axes is widened so that both have the same scale.
    pub equal: bool,
    /// The layers, from the bottom to the top.
    pub layers: Vec<Layer>,
    /// The place of the legend, if there is one.
    pub legend: Option<Corner>,
    /// Texts at points of the axes.
    pub notes: Vec<Note>,
}

/// An axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Quantity and unit.
    pub name: String,
    /// The range of the axis; on an axis of powers, the range of the exponents.
    pub range: Range<f64>,
    /// The kind of its numbers.
    pub scale: Scale,
    /// Approximate number of labels; 0 for no labels.
    pub labels: usize,
}

/// The kind of numbers on an axis, which determines the places of its labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Numbers.
    Linear,
    /// Decimal exponents, labelled 10ˣ.
    Powers,
    /// Angles in radians, labelled in parts of π.
    Angle,
}

/// A place of a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corner {
    /// Top left.
    TopLeft,
    /// Top right.
    TopRight,
    /// Bottom left.
    BottomLeft,
    /// Bottom right.
    BottomRight,
    /// Right of the axes, which become shorter by its width.
    Outside,
    /// Below the axes, which become lower by its height.
    Below,
}

/// A text at a point of the axes.
#[derive(Clone, Debug)]
pub struct Note {
    /// The place of its left end.
    pub at: (f64, f64),
    /// The text.
    pub text: String,
    /// Its colour.
    pub color: Color,
}

/// Points and their look.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Name in the legend and in the data file.
    pub label: String,
    /// The points, in order.
    pub points: Vec<(f64, f64)>,
    /// The look of the points.
    pub pen: Pen,
    /// True if the legend lists the layer.
    pub listed: bool,
    /// The errors or the area drawn around the points.
    pub spread: Spread,
}

/// The drawing around or under the points of a layer.
#[derive(Clone, Debug, PartialEq)]
pub enum Spread {
    /// Nothing.
    None,
    /// A vertical bar at each point, between two values.
    Bars(Vec<(f64, f64)>),
    /// An area between two values at each point.
    Band(Vec<(f64, f64)>),
    /// An area between the points and a value.
    Filled(f64),
}

/// The look of points.
#[derive(Clone, Copy, Debug)]
pub struct Pen {
    /// Colour of line and symbols.
    pub color: Color,
    /// Line through the points.
    pub line: Option<Stroke>,
    /// Symbols on the points.
    pub symbol: Option<Symbols>,
}

/// A line.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    /// Width in CSS pixels.
    pub width: f64,
    /// Lengths of dash and gap in CSS pixels.
    pub dash: Option<(f64, f64)>,
}

/// Symbols on points.
#[derive(Clone, Copy, Debug)]
pub struct Symbols {
    /// Their shape.
    pub shape: Shape,
    /// Half their width in CSS pixels.
    pub radius: f64,
    /// Number of symbols, distributed evenly over the points; `None` for one symbol on each point.
    pub count: Option<usize>,
}

/// Shape of a symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A filled disc.
    Disc,
    /// An open square.
    Square,
    /// An open triangle.
    Triangle,
    /// A diagonal cross.
    Cross,
    /// An open circle.
    Circle,
    /// An open diamond.
    Diamond,
    /// An upright cross.
    Plus,
    /// An arrow downwards: the point is an upper limit.
    Limit,
}

impl Figure {
    /// Width and height in CSS pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.rows.iter().map(|row| row.height).sum())
    }

    /// Returns every point of every layer, one for each line.
    pub fn csv(&self) -> String {
        let mut text = String::from("panel,series,x,y\n");
        for panel in self.rows.iter().flat_map(|row| &row.panels) {
            for layer in &panel.layers {
                let head = format!("{},{}", quoted(&panel.title), quoted(&layer.label));
                for (x, y) in layer
                    .points
                    .iter()
                    .filter(|(x, y)| x.is_finite() && y.is_finite())
                {
                    // Writing into a String cannot fail.
                    let _ = writeln!(text, "{head},{x},{y}");
                }
            }
        }
        text
    }
}
