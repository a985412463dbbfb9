//! Cases measured in turn, by the time of the processor for this thread.

#[repr(C)]
struct Time {
    seconds: i64,
    nanoseconds: i64,
}

/// Returns the time of the processor for this thread, in seconds.
#[cfg(target_os = "linux")]
pub(crate) fn now() -> f64 {
    unsafe extern "C" {
        fn clock_gettime(clock: i32, time: *mut Time) -> i32;
    }
    let mut time = Time {
        seconds: 0,
        nanoseconds: 0,
    };
    // Safety: the function writes to the structure that it is given.
    unsafe { clock_gettime(3, &raw mut time) };
    time.seconds as f64 + 1e-9 * time.nanoseconds as f64
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn now() -> f64 {
    use std::sync::OnceLock;
    use std::time::Instant;
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

/// A case: its name, sites times steps of a call, and the call.
pub(crate) type Case<'a> = (&'static str, f64, Box<dyn FnMut() + 'a>);

/// Median times of a case, in nanoseconds a unit, and the median of its ratio to the first case
/// within a round.
#[derive(Clone, Copy)]
pub(crate) struct Medians {
    pub time: f64,
    pub ratio: f64,
}

/// Measures the cases one after the other, in so many rounds.
pub(crate) fn medians(cases: &mut [Case<'_>], rounds: usize) -> Vec<Medians> {
    let mut repeats = Vec::new();
    for (_, _, call) in &mut *cases {
        let mut count = 1;
        loop {
            let start = now();
            (0..count).for_each(|_| call());
            let time = now() - start;
            if time > 0.003 {
                break;
            }
            count *= 2;
        }
        repeats.push(count);
    }
    let mut times = vec![Vec::new(); cases.len()];
    for _ in 0..rounds {
        for (at, (_, units, call)) in cases.iter_mut().enumerate() {
            let start = now();
            (0..repeats[at]).for_each(|_| call());
            times[at].push((now() - start) * 1e9 / (f64::from(repeats[at]) * *units));
        }
    }
    let median = |mut of: Vec<f64>| {
        of.sort_by(f64::total_cmp);
        of[of.len() / 2]
    };
    let of_case = |own: &Vec<f64>| {
        let ratios = own.iter().zip(&times[0]).map(|(time, first)| time / first);
        Medians {
            time: median(own.clone()),
            ratio: median(ratios.collect()),
        }
    };
    times.iter().map(of_case).collect()
}

/// Measures the cases of a group, and prints the medians.
pub(crate) fn compare(title: &str, is_asked: &dyn Fn(&str) -> bool, mut cases: Vec<Case<'_>>) {
    if !is_asked(title) {
        return;
    }
    let medians = medians(&mut cases, 15);
    println!("{title}");
    for ((name, ..), Medians { time, ratio }) in cases.iter().zip(medians) {
        println!("  {name:<32} {time:>8.3} ns  {ratio:.3}");
    }
}
