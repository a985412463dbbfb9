//! Tests of the labels of axes: their digits, and that their texts differ on every axis.

use super::*;

fn texts(range: Range<f64>, count: usize) -> Vec<String> {
    let labels = numbers(&range, count);
    labels.marks.into_iter().map(|(_, text)| text).collect()
}

#[test]
fn labels_stand_at_round_numbers() {
    let round = |range: Range<f64>| Round::of(&range, 6).floats();
    assert_eq!(round(0.0..2000.0), [0.0, 500.0, 1000.0, 1500.0, 2000.0]);
    assert_eq!(round(-1.5..1.5), [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5]);
    assert_eq!(
        round(-13.2..332.7),
        [0.0, 50.0, 100.0, 150.0, 200.0, 250.0, 300.0]
    );
}

#[test]
fn labels_are_short() {
    assert_eq!(texts(-0.5..0.5, 2), ["−0.5", "0", "0.5"]);
    assert_eq!(texts(0.0..2000.0, 4), ["0", "500", "1000", "1500", "2000"]);
    assert_eq!(texts(0.000_1..0.000_2, 2), ["0.0001", "0.00015", "0.0002"]);
    assert_eq!(texts(1e-6..2e-6, 2), ["1·10⁻⁶", "1.5·10⁻⁶", "2·10⁻⁶"]);
    assert_eq!(texts(-2e-7..0.0, 2), ["−2·10⁻⁷", "−1·10⁻⁷", "0"]);
    assert_eq!(texts(2e11..3e11, 2), ["2·10¹¹", "2.5·10¹¹", "3·10¹¹"]);
    let many = labels(&Axis::new("", 0.0..1.0), &(0.0..1.0), usize::MAX);
    assert!((100..10_000).contains(&many.marks.len()));
    assert_eq!(power(-10.0), "10⁻¹⁰");
}

#[test]
fn a_round_number_is_subtracted_from_long_labels() {
    for (range, offset, expected) in [
        (1e9..1e9 + 3.0, "− 1000000000", vec!["0", "1", "2", "3"]),
        (
            999_999_998.0..1_000_000_003.0,
            "− 1000000000",
            vec!["−2", "0", "2"],
        ),
        (
            -1e9 - 3.0..-1e9,
            "+ 1000000000",
            vec!["−3", "−2", "−1", "0"],
        ),
        (1e12..1e12 + 3.0, "− 10¹²", vec!["0", "1", "2", "3"]),
        (1_234_567.0..1_234_567.9, "− 1234567", vec!["0", "0.5"]),
        (
            1.0..1.0 + 3e-9,
            "− 1",
            vec!["0", "1·10⁻⁹", "2·10⁻⁹", "3·10⁻⁹"],
        ),
        (
            1e300..1e300 + 3e290,
            "− 10³⁰⁰",
            vec!["0", "1·10²⁹⁰", "2·10²⁹⁰", "3·10²⁹⁰"],
        ),
    ] {
        let labels = numbers(&range, 3);
        let texts: Vec<_> = labels.marks.iter().map(|mark| &mark.1).collect();
        assert_eq!(texts, expected, "{range:?}");
        assert_eq!(labels.name("q"), format!("q {offset}"));
        assert_eq!(labels.name(""), offset);
    }
    for range in [0.0..1e9, 1e9..2e9, 123_450.0..123_455.0] {
        assert_eq!(numbers(&range, 6).offset, None, "{range:?}");
    }
}

/// Checks that on every axis with a length there are labels within the axis, in order; all texts
/// differ, and denote finite numbers.
#[test]
fn texts_differ_on_every_axis() {
    let mut ends = vec![
        0.0,
        1.0,
        1e9,
        1e9 + 1.0,
        0.1,
        PI,
        1e-300,
        5e-324,
        1e-310,
        1e300,
        12345.678,
    ];
    ends.extend(ends.clone().iter().map(|x| -x));
    let mut lengths: Vec<f64> = (-323..=307).map(|k| float(3, k)).collect();
    lengths.extend([5e-324, 1e-323, 1.5e-323, f64::MAX]);
    let mut seen = 0;
    for &start in &ends {
        for &length in &lengths {
            for end in [start + length, start.next_up(), start.next_up().next_up()] {
                let range = start..end;
                if !(end > start && (end - start).is_finite()) {
                    continue;
                }
                for count in [1, 6, 40] {
                    seen += 1;
                    let labels = numbers(&range, count);
                    let all = format!("{range:?}: {labels:?}");
                    assert!(!all.contains("inf") && !all.contains("NaN"), "{all}");
                    assert!(count == 1 || !labels.marks.is_empty(), "{all}");
                    assert!(labels.marks.len() <= 4 * count + 1, "{all}");
                    assert!(labels.marks.is_sorted_by(|a, b| a.0 < b.0), "{all}");
                    let texts: std::collections::BTreeSet<_> =
                        labels.marks.iter().map(|mark| &mark.1).collect();
                    assert_eq!(texts.len(), labels.marks.len(), "{all}");
                    let longest = texts.iter().map(|text| text.chars().count()).max();
                    assert!(longest <= Some(16), "{all}");
                    let slack = 1e-6 * (end - start);
                    let is_inside = |at: f64| at >= start - slack && at <= end + slack;
                    assert!(labels.marks.iter().all(|mark| is_inside(mark.0)), "{all}");
                }
            }
        }
    }
    assert!(seen > 10_000, "{seen}");
}

#[test]
fn angles_are_parts_of_pi() {
    let labels = |range: Range<f64>| -> Vec<String> {
        let labels = labels(&Axis::angle("", 0.0..1.0), &range, 6);
        labels.marks.into_iter().map(|(_, label)| label).collect()
    };
    assert_eq!(labels(-PI..PI), ["−π", "−π/2", "0", "π/2", "π"]);
    assert_eq!(labels(0.0..1.0), ["0", "π/8", "π/4"]);
    assert_eq!(
        labels(0.0..40.0),
        ["0", "2π", "4π", "6π", "8π", "10π", "12π"]
    );
    assert_eq!(
        labels(0.0..0.01),
        [
            "0", "0.0005π", "0.001π", "0.0015π", "0.002π", "0.0025π", "0.003π"
        ]
    );
}

#[test]
fn short_axes_of_powers_are_labelled_within_their_decades() {
    let labels = |exponents: Range<f64>| -> Vec<String> {
        let axis = Axis::powers("", exponents.clone());
        let labels = labels(&axis, &exponents, 6);
        labels.marks.into_iter().map(|(_, label)| label).collect()
    };
    assert_eq!(labels(-3.1..-1.9), ["10⁻³", "10⁻²"]);
    assert_eq!(labels(-3.1..0.1), ["10⁻³", "10⁻²", "10⁻¹", "10⁰"]);
    let seven = ["10⁻¹²", "10⁻¹⁰", "10⁻⁸", "10⁻⁶", "10⁻⁴", "10⁻²", "10⁰"];
    assert_eq!(labels(-12.6..0.4), seven);
    assert_eq!(labels(-2.9..-1.4), ["0.002", "0.005", "0.01", "0.02"]);
    let one_power = ["0.2·10⁻⁶", "0.5·10⁻⁶", "1·10⁻⁶", "2·10⁻⁶"];
    assert_eq!(labels(-6.8..-5.6), one_power);
    // The range contains no multiple of 1, 2 or 5.
    let short = labels(-2.5..-2.4);
    assert!(short.len() > 2 && short[0] == "0.0032", "{short:?}");
    let short = labels(-320.5..-320.4);
    assert!(short.len() > 2 && short[0] == "3.2·10⁻³²¹", "{short:?}");
}

#[test]
fn ticks_stand_at_multiples_of_powers_or_at_powers() {
    let ticks = |exponents: Range<f64>| ticks(&Axis::powers("", exponents.clone()), &exponents);
    assert_eq!(ticks(-0.01..0.4), [0.0, 2_f64.log10()]);
    assert_eq!(ticks(-12.6..0.4).len(), 13);
    assert!(ticks(-320.0..0.0).is_empty());
}
