//! The pages of ensembles and studies: the description of the run, readable numbers, no empty
//! table.

use std::path::PathBuf;

use sve_runtime::baseline::EulerMaruyama;
use sve_runtime::ensemble::Summary;
use sve_runtime::plot::page::with_error;
use sve_runtime::prelude::*;
use sve_runtime::study::Study;

#[derive(Clone, Copy)]
struct Oscillator {
    omega: f64,
    kicks: [f64; 2],
}

#[variational(midpoint)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * (self.omega * q).powi(2)
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.kicks[0] * q + self.kicks[1] * q * q
    }
}

type Method = Integrator<Oscillator, Midpoint>;

fn method() -> Method {
    let kicks = [0.1 + 0.2, 1.5e-7];
    Integrator::new(Oscillator { omega: 1.25, kicks }, Midpoint)
}

fn ensemble(method: &Method) -> Ensemble<'_, Method> {
    Ensemble::new(method)
        .paths(100)
        .seed(77)
        .steps(0.05, 40)
        .every(10)
        .start(State::new([1.0], [0.0]))
}

fn scratch(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn page(summary: &Summary, name: &str) -> String {
    let path = scratch(name);
    summary.write_html(&path).unwrap();
    std::fs::read_to_string(path).unwrap()
}

/// Returns the texts of a page, without its markup and style.
fn texts(page: &str) -> Vec<String> {
    let body = page.split_once("<body>").unwrap().1;
    let parts = body.split('<').filter_map(|part| part.split_once('>'));
    let texts = parts.map(|(_, text)| text.trim().to_owned());
    texts.filter(|text| !text.is_empty()).collect()
}

/// Asserts that numbers are written without `e` and `inf`, with a typographic minus.
fn assert_readable(page: &str) {
    for text in texts(page) {
        let characters: Vec<char> = text.chars().collect();
        for part in characters.windows(3) {
            let is_exponent = part[0].is_ascii_digit() && part[1] == 'e';
            let is_exponent = is_exponent && (part[2].is_ascii_digit() || part[2] == '-');
            let is_minus = part[0] == ' ' && part[1] == '-' && part[2].is_ascii_digit();
            assert!(!is_exponent && !is_minus, "{text}");
        }
        assert!(!text.contains("inf·") && !text.contains("NaN"), "{text}");
    }
}

#[test]
fn a_page_says_what_was_run() {
    let method = method();
    let summary = ensemble(&method).observe("q", |_, s| s.q[0]).run().unwrap();
    let page = page(&summary, "run.html");
    for part in [
        "<code>Oscillator</code>",
        "<code>omega</code> = 1.25",
        "<code>kicks[0]</code> = 0.30000000000000004",
        "<code>kicks[1]</code> = 1.5·10⁻⁷",
        "<th>method</th><td>midpoint</td>",
        "40 steps of h = 0.05",
        "<th>paths</th><td>100 paths</td>",
        "normal increments",
        "<th>seed</th><td>77</td>",
    ] {
        assert!(page.contains(part), "{part}: {page}");
    }
    assert_readable(&page);
    let q = &summary["q"];
    let (mean, error) = with_error(
        *q.mean().last().unwrap(),
        *q.standard_error().last().unwrap(),
    );
    let cell = |text: &str| format!("<td class=\"number\">{text}</td>");
    assert!(
        page.contains(&(cell(&mean) + &cell(&error))),
        "{mean}: {page}"
    );
    // Other settings are described too.
    let shard = ensemble(&method).noise(ThreePoint::new(5));
    let shard = shard.start(Starts::each(|_, rng| State::new([rng.normal()], [0.0])));
    let shard = shard
        .shard(0, 2)
        .observe("q", |_, s| s.q[0])
        .bound("q", ..=1.0);
    let page = self::page(&shard.run().unwrap(), "shard.html");
    for part in [
        "increments of three values",
        "5 of the noise, 77 of the starts",
        "64 paths, of 100, of which ",
    ] {
        assert!(page.contains(part), "{part}: {page}");
    }
}

#[test]
fn a_page_of_first_passages_has_their_rate_and_no_empty_table() {
    let method = method();
    let summary = ensemble(&method)
        .stop_at("left", |_, s| s.q[0] - 0.5)
        .run()
        .unwrap();
    let page = page(&summary, "passages.html");
    let rate = summary.passage("left").unwrap().rate(0);
    assert!(rate.events > 50, "{rate:?}");
    let (value, error) = with_error(rate.value, rate.standard_error);
    let texts = texts(&page);
    for part in ["rate", &value, &error, "passed", "left"] {
        assert!(texts.iter().any(|text| text == part), "{part}: {texts:?}");
    }
    assert!(
        !texts.iter().any(|text| text == "standard deviation"),
        "{texts:?}"
    );
    assert!(!page.contains("<tbody>\n</tbody>"), "{page}");
    assert_readable(&page);
}

#[test]
fn hostile_observables_are_readable() {
    let method = method();
    let summary = ensemble(&method)
        .observe("tiny", |_, s| s.q[0] * 1e-310)
        .observe("far", |_, s| s.q[0] * 1e-3 + 1e9)
        .observe("huge", |_, s| s.q[0] * 1e300)
        .observe("constant", |_, _| 1e-320)
        .observe(LONG, |_, s| s.q[0])
        .run()
        .unwrap();
    let page = page(&summary, "hostile.html");
    assert_readable(&page);
    let escaped = LONG
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;");
    assert!(page.contains(&format!("<td>{escaped}</td>")), "{page}");
    assert!(page.contains("far − 1000000000"), "{page}");
    // The least and the greatest value are distinguishable.
    let row = page.split("<td>far</td>").nth(1).unwrap();
    let cells: Vec<&str> = row.split("<td class=\"number\">").skip(1).take(6).collect();
    assert_ne!(cells[4], cells[5]);
    // A single path has no standard error.
    let single = ensemble(&method).paths(1).observe("q", |_, s| s.q[0]).run();
    let page = self::page(&single.unwrap(), "single.html");
    assert!(page.contains("<td>–</td>") && page.contains("Ensemble of 1 path "));
    assert_readable(&page);
}

#[test]
fn a_page_of_a_study_says_what_was_measured() {
    let method = method();
    let euler = EulerMaruyama::new(*method.system());
    let report = Study::new("oscillator")
        .start(State::new([1.0], [0.0]))
        .horizon(1.0)
        .step_counts([4, 8, 16])
        .paths(20)
        .seed(5)
        .method("midpoint", &method)
        .method("Euler's method", &euler)
        .fine(&method, 4)
        .observe("q", |_, s| s.q[0])
        .repeats(0)
        .run()
        .unwrap();
    let path = scratch("study.html");
    report.write_html(&path).unwrap();
    let page = std::fs::read_to_string(path).unwrap();
    for part in [
        "<code>Oscillator</code>",
        "<code>omega</code> = 1.25",
        "midpoint, Euler's method (EulerMaruyama",
        "midpoint in steps 4 times shorter than the finest ones",
        "<th>paths</th><td>20 paths</td>",
        "<th>seed</th><td>5</td>",
        "Weak error of q against step size",
        "step size h",
        "± standard error",
    ] {
        assert!(page.contains(part), "{part}: {page}");
    }
    // No times were measured.
    assert!(!page.contains("ns a step"), "{page}");
    assert_readable(&page);
}

/// A text of a picture with the corners of its box: left, top, right, bottom.
type Placed = (String, [f64; 4]);

/// Returns the value of an attribute in the opening tag of an element.
fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = tag.split_once(&format!(" {name}=\""))?;
    Some(rest.split_once('"')?.0)
}

/// Returns about the width of a text, in units of its size.
fn width(text: &str) -> f64 {
    let of = |character: char| match character {
        'i' | 'j' | 'l' | 'I' | '.' | ',' | ':' | '\'' | '|' => 0.28,
        'f' | 't' | 'r' | ' ' | '(' | ')' | '-' | '·' | '/' => 0.36,
        'm' | 'w' | 'M' | 'W' | '−' => 0.85,
        _ => 0.6,
    };
    text.chars().map(of).sum()
}

/// Returns the texts of a picture, and its size.
fn placed(svg: &str) -> (Vec<Placed>, [f64; 2]) {
    let number = |tag: &str, name: &str| -> f64 {
        let value = attribute(tag, name).unwrap_or_else(|| panic!("no {name}: {tag}"));
        value.parse().unwrap()
    };
    let view = attribute(svg, "viewBox").unwrap();
    let view: Vec<f64> = view.split(' ').map(|x| x.parse().unwrap()).collect();
    let text = |element: &str| {
        let (tag, content) = element.split_once('>').unwrap();
        let (size, x, y) = (number(tag, "font-size"), number(tag, "x"), number(tag, "y"));
        let parts = content.split('<').enumerate();
        let plain = parts.map(|(k, part)| match (k, part.split_once('>')) {
            (0, _) | (_, None) => part,
            (_, Some((_, text))) => text,
        });
        let plain = plain.collect::<String>().trim().replace("&lt;", "<");
        let plain = plain.replace("&gt;", ">").replace("&amp;", "&");
        let long = size * width(&plain);
        let left = match attribute(tag, "text-anchor").unwrap() {
            "start" => 0.0,
            "middle" => -0.5 * long,
            _ => -long,
        };
        // Capitals and digits; texts hang from their place or are centred on it.
        let top = match attribute(tag, "dy").unwrap() {
            "0.76em" => 0.0,
            _ => -0.4 * size,
        };
        let corners = if attribute(tag, "transform").is_some() {
            // turned by 270°
            [x + top, y - left - long, x + top + 0.8 * size, y - left]
        } else {
            [x + left, y + top, x + left + long, y + top + 0.8 * size]
        };
        (plain, corners)
    };
    let elements = svg.split("<text").skip(1);
    let elements = elements.map(|rest| rest.split_once("</text>").unwrap().0);
    (elements.map(text).collect(), [view[2], view[3]])
}

/// Asserts that no texts of a picture of a page overlap, and that all are inside of it. Returns the
/// number of pictures.
fn assert_apart(page: &str) -> usize {
    let pictures = page.split("<svg").skip(1);
    let pictures = pictures.map(|rest| rest.split_once("</svg>").unwrap().0);
    let mut count = 0;
    for svg in pictures {
        let (texts, [width, height]) = placed(svg);
        assert!(texts.len() > 4, "{texts:?}");
        for (number, (text, [left, top, right, bottom])) in texts.iter().enumerate() {
            let is_inside = *left >= 0.0 && *top >= 0.0 && *right <= width && *bottom <= height;
            assert!(is_inside, "{text:?} leaves the picture: {texts:#?}");
            for (other, [west, north, east, south]) in &texts[..number] {
                let is_apart = right <= west || east <= left || bottom <= north || south <= top;
                assert!(is_apart, "{text:?} overlaps {other:?}: {texts:#?}");
            }
        }
        count += 1;
    }
    count
}

const LONG: &str = "the square of the distance of the particle from the place at which it was at the start, with <markup> & all";

#[test]
fn texts_of_hostile_ensembles_are_apart() {
    let method = method();
    let observed = ensemble(&method)
        .observe("subnormal", |_, s| s.q[0] * 1e-310)
        .observe("far", |_, s| s.q[0] * 1e-3 + 1e9)
        .observe("huge", |_, s| s.q[0] * 1e300)
        .observe("constant", |_, _| 1e-320)
        .observe(
            "an_unbroken_name_of_an_observable_that_is_longer_than_its_axis",
            |_, s| s.q[0],
        )
        .observe(LONG, |_, s| s.q[0])
        .histogram(LONG, -2.0..2.0, 16)
        .histogram("far", 1e9 - 1e-2..1e9 + 1e-2, 16)
        .first_passage(&LONG[4..], |_, s| s.q[0] - 0.5);
    let text = page(&observed.run().unwrap(), "apart.html");
    assert_eq!(assert_apart(&text), 9);
    // A single path has no standard error.
    let single = ensemble(&method).paths(1).observe("q", |_, s| s.q[0]);
    let text = page(&single.run().unwrap(), "apart_single.html");
    assert_eq!(assert_apart(&text), 1);
    // A path on which an observable is not a number fails.
    let refused =
        ensemble(&method).observe("q", |_, s| if s.q[0] > 0.5 { s.q[0] } else { f64::NAN });
    let text = page(&refused.run().unwrap(), "apart_refused.html");
    assert_eq!(assert_apart(&text), 1);
    assert!(text.contains("failed"), "{text}");
}

/// Returns the page of a study with long names. `observed` maps the position at the end to the
/// observable; a path on which the position gets below `least` fails.
fn page_of_study(
    name: &str,
    observed: impl Fn(f64) -> f64 + Sync,
    paths: u64,
    least: f64,
) -> String {
    let method = method();
    let euler = EulerMaruyama::new(*method.system());
    let report = Study::new(LONG)
        .start(State::new([1.0], [0.0]))
        .horizon(1.0)
        .step_counts([4, 8, 16])
        .paths(paths)
        .seed(5)
        .method(LONG, &method)
        .method("Euler's method", &euler)
        .fine(&method, 4)
        .observe(name, |_, s| observed(s.q[0]))
        .invariant(|_, s| if s.q[0] < least { f64::NAN } else { s.q[0] })
        .repeats(1)
        .run()
        .unwrap();
    let path = scratch("apart_study.html");
    report.write_html(&path).unwrap();
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn texts_of_hostile_studies_are_apart() {
    let all = f64::NEG_INFINITY;
    for (name, scale, offset, paths) in [
        ("q", 1.0, 0.0, 20),
        ("subnormal", 1e-310, 0.0, 20),
        (LONG, 1e300, 0.0, 20),
        ("far", 1e-3, 1e9, 20),
        // A single path has no standard error.
        (LONG, 1.0, 0.0, 1),
    ] {
        let page = page_of_study(name, |q| scale * q + offset, paths, all);
        assert_eq!(assert_apart(&page), 6, "{name}");
        assert_readable(&page);
    }
}

#[test]
fn texts_of_studies_with_failing_paths_are_apart() {
    // Some paths fail.
    let page = page_of_study("q", |q| q, 20, 0.4);
    assert_eq!(assert_apart(&page), 6);
    assert_readable(&page);
    // All paths fail, so no errors and no times are known.
    let page = page_of_study("q", |q| q, 20, 2.0);
    assert_eq!(assert_apart(&page), 2);
    assert_readable(&page);
    assert!(texts(&page).iter().any(|text| text == "20"), "{page}");
}
