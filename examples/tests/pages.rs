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
    let long = "the square of the distance of the particle from the place at which it was at the start, with <markup> & all";
    let summary = ensemble(&method)
        .observe("tiny", |_, s| s.q[0] * 1e-310)
        .observe("far", |_, s| s.q[0] * 1e-3 + 1e9)
        .observe("huge", |_, s| s.q[0] * 1e300)
        .observe("constant", |_, _| 1e-320)
        .observe(long, |_, s| s.q[0])
        .run()
        .unwrap();
    let page = page(&summary, "hostile.html");
    assert_readable(&page);
    let escaped = long
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
        "weak error of q",
    ] {
        assert!(page.contains(part), "{part}: {page}");
    }
    // No times were measured.
    assert!(!page.contains("ns a step"), "{page}");
    assert_readable(&page);
}
