//! Tests of the texts of figures: for all numbers and names, texts do not overlap, and do not leave
//! their panel.

use std::convert::Infallible;
use std::ops::Range;

use plotters::prelude::*;
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

use super::draw;
use super::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row};
use super::render::SCALE;
use super::text::{LINE, prepare_font, width};

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

/// A text with the corners of its box: left, top, right, bottom.
type Placed = (String, [i32; 4]);

/// A backend that records the box of each text, and draws nothing.
struct Texts<'a> {
    size: (u32, u32),
    texts: &'a mut Vec<Placed>,
}

impl DrawingBackend for Texts<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }
    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }
    fn present(&mut self) -> Drawn {
        Ok(())
    }
    fn draw_pixel(&mut self, _: BackendCoord, _: BackendColor) -> Drawn {
        Ok(())
    }
    fn draw_line<S: BackendStyle>(&mut self, _: BackendCoord, _: BackendCoord, _: &S) -> Drawn {
        Ok(())
    }
    fn draw_rect<S: BackendStyle>(
        &mut self,
        _: BackendCoord,
        _: BackendCoord,
        _: &S,
        _: bool,
    ) -> Drawn {
        Ok(())
    }
    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        (x, y): BackendCoord,
    ) -> Drawn {
        let em = style.size() / LINE;
        let (width, height) = (
            (width(text, em / f64::from(SCALE)) * f64::from(SCALE)) as i32,
            em as i32,
        );
        let from_x = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Center => -width / 2,
            HPos::Right => -width,
        };
        let from_y = match style.anchor().v_pos {
            VPos::Top => 0,
            VPos::Center => -height / 2,
            VPos::Bottom => -height,
        };
        let transform = style.transform();
        let (u, v) = transform.transform(from_x, from_y);
        let (w, z) = transform.transform(from_x + width, from_y + height);
        let corners = [x + u.min(w), y + v.min(z), x + u.max(w), y + v.max(z)];
        self.texts.push((text.to_owned(), corners));
        Ok(())
    }
}

/// Returns the texts of a panel of this size in CSS pixels.
fn texts(panel: Panel, (width, height): (u32, u32)) -> Vec<Placed> {
    prepare_font();
    let row = Row {
        height,
        panels: vec![panel],
    };
    let figure = Figure {
        name: "",
        width,
        rows: vec![row],
    };
    let mut texts = Vec::new();
    let size = (width * SCALE, height * SCALE);
    let backend = Texts {
        size,
        texts: &mut texts,
    };
    let area = backend.into_drawing_area();
    draw::figure(&area, &figure, draw::Detail::Full).unwrap();
    drop(area);
    texts
}

/// Asserts that texts neither overlap nor leave the panel, and contain no infinite number.
fn assert_apart(texts: &[Placed], (width, height): (u32, u32)) {
    let (width, height) = ((width * SCALE) as i32, (height * SCALE) as i32);
    for (number, (text, [left, top, right, bottom])) in texts.iter().enumerate() {
        assert!(!text.contains("inf") && !text.contains("NaN"), "{text}");
        let is_inside = *left >= 0 && *top >= 0 && *right <= width && *bottom <= height;
        assert!(is_inside, "{text:?} leaves the panel: {texts:#?}");
        for (other, [west, north, east, south]) in &texts[..number] {
            let is_apart = right <= west || east <= left || bottom <= north || south <= top;
            assert!(is_apart, "{text:?} overlaps {other:?}: {texts:#?}");
        }
    }
}

const LONG: &str = "the square of the distance between the third and the seventeenth particle, relative to its mean at the start";
const UNBROKEN: &str = "distance_between_the_third_and_the_seventeenth_particle_relative_to_its_mean_at_the_start_of_the_run";

fn ranges() -> Vec<Range<f64>> {
    vec![
        0.0..1.0,
        -1.0..1.0,
        0.0..1e-310,
        5e-324..2e-323,
        -3e-320..1e-318,
        1e9..1e9 + 1.0,
        1e9..1e9 + 1e-5,
        -1e9 - 3e-6..-1e9,
        1e15..1e15 + 2.0,
        1.0..1.0 + 1e-12,
        -1.234_567e-7..9.87e-8,
        -1.7e300..1.6e300,
        1e300..1e300 + 1e286,
        12_345.6..12_345.7,
        -999_999.0..999_999.0,
    ]
}

#[test]
fn labels_of_hostile_ranges_are_apart() {
    let ranges = ranges();
    for (number, size) in [(540, 320), (270, 200), (1080, 320)]
        .into_iter()
        .enumerate()
    {
        for (x, y) in ranges.iter().zip(ranges.iter().cycle().skip(4 * number)) {
            let (x, y) = (Axis::new("x", x.clone()), Axis::new("y", y.clone()));
            assert_apart(&texts(Panel::new("title", x, y), size), size);
        }
    }
}

#[test]
fn labels_of_powers_and_angles_are_apart() {
    let size = (540, 320);
    for range in [
        -3.0..0.0,
        -2.45..-2.41,
        -320.0..-5.0,
        -320.5..-320.2,
        0.0..300.0,
        -1.2..-0.1,
        -15.6..-12.9,
    ] {
        let axis = |name: &str| Axis::powers(name, range.clone());
        let placed = texts(Panel::new("title", axis("x"), axis("y")), size);
        assert!(placed.len() > 6, "{placed:?}");
        assert_apart(&placed, size);
    }
    for range in [-3.2..3.2, 0.0..1e6, 1e6..1e6 + 1e-3, 0.0..1e-9] {
        let axis = |name: &str| Axis::angle(name, range.clone());
        assert_apart(
            &texts(Panel::new("title", axis("x"), axis("y")), size),
            size,
        );
    }
}

/// Checks that an axis has as many labels as it asks for, if they fit.
#[test]
fn thirteen_decades_are_labelled_at_every_second_decade() {
    let (x, y) = (Axis::new("x", 0.0..1.0), Axis::powers("y", -12.6..0.4));
    let placed = texts(Panel::new("title", x, y), (540, 320));
    let is_label = |label: &str| placed.iter().any(|(text, _)| text == label);
    assert!(
        ["10⁻¹²", "10⁻⁸", "10⁻²", "10⁰"].into_iter().all(is_label),
        "{placed:?}"
    );
}

#[test]
fn long_names_are_apart() {
    let size = (540, 380);
    let corners = [
        Corner::TopLeft,
        Corner::TopRight,
        Corner::BottomLeft,
        Corner::BottomRight,
        Corner::Below,
    ];
    for name in [LONG, UNBROKEN, "q", "", "ενέργεια του συστήματος"] {
        for range in [1e9..1e9 + 1e-5, 0.0..1e-310] {
            for corner in corners {
                let axis = || Axis::new(name, range.clone());
                let layer = |number| Layer::new(name, Vec::new(), Pen::series(number));
                let panel = Panel::new(name, axis(), axis()).legend(corner);
                let panel = panel.with(layer(0)).with(layer(1));
                assert_apart(&texts(panel, size), size);
            }
        }
    }
    let axis = || Axis::new(LONG, 0.0..1.0);
    let panel = Panel::new(LONG, axis(), axis()).legend(Corner::Outside);
    let panel = panel.with(Layer::new(UNBROKEN, Vec::new(), Pen::series(0)));
    assert_apart(&texts(panel, (780, 380)), (780, 380));
}

/// Checks that all words of a name are present, in their order, and the number that is subtracted
/// from the labels.
#[test]
fn names_say_what_is_subtracted() {
    let axis = |name: &str| Axis::new(name, 1e9..1e9 + 1.0);
    let placed = texts(Panel::new("", axis("q"), axis(LONG)), (540, 520));
    let all: Vec<_> = placed.iter().map(|(text, _)| text.as_str()).collect();
    assert!(all.contains(&"q − 1000000000"), "{all:?}");
    let name = format!("{LONG} − 1000000000");
    assert!(all.join(" ").contains(&name), "{all:?}");
    assert!(all.contains(&"0.2") && all.contains(&"0.8"), "{all:?}");
}
