//! The start of each case by `mpirun`, with a time limit.

use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use super::{CASES, Case, Outcome};

/// Time limit of a case. A case takes a few seconds; a case that takes longer waits for a message
/// that does not come.
const LIMIT: Duration = Duration::from_secs(120);

/// Runs all cases, or those whose names are arguments.
pub(crate) fn all() {
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|arg| !arg.starts_with('-'))
        .collect();
    let is_wanted = |case: &&Case| wanted.is_empty() || wanted.iter().any(|name| case.name == name);
    let mut failed = 0;
    for case in CASES.iter().filter(is_wanted) {
        for &ranks in case.ranks {
            let start = Instant::now();
            let result = run(case, ranks);
            let seconds = start.elapsed().as_secs_f64();
            match result {
                Ok(()) => println!("{} on {ranks} ranks: ok, {seconds:.1} s", case.name),
                Err(why) => {
                    failed += 1;
                    println!("{} on {ranks} ranks: FAILED, {why}", case.name);
                }
            }
        }
    }
    if failed > 0 {
        println!("{failed} failed");
        std::process::exit(1);
    }
}

fn run(case: &Case, ranks: u32) -> Result<(), String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let mut command = Command::new("mpirun");
    command.arg("-n").arg(ranks.to_string()).arg(program);
    command.env("SVE_MPI_CASE", case.name);
    // Open MPI 4 and 5: more ranks than cores, and root in a container. Other implementations do
    // not read these.
    for (name, value) in [
        ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
        ("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe"),
        ("OMPI_MCA_hwloc_base_binding_policy", "none"),
        ("OMPI_MCA_mpi_yield_when_idle", "1"),
        ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
        ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
    ] {
        command.env(name, value);
    }
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = command
        .spawn()
        .map_err(|error| format!("mpirun: {error}"))?;
    let output = (reader(child.stdout.take()), reader(child.stderr.take()));
    let status = wait(&mut child);
    let texts = [output.0.join(), output.1.join()].map(Result::unwrap_or_default);
    let status = status.ok_or_else(|| format!("no end after {LIMIT:?}\n{}", texts.concat()))?;
    let is_expected = match case.outcome {
        Outcome::Passes => status,
        Outcome::Dies => !status && !texts[1].contains("failed on rank"),
    };
    if !is_expected {
        return Err(format!("its end was not expected\n{}", texts.concat()));
    }
    if case.name == "progress" {
        return progress_is_shown(&texts[1]);
    }
    Ok(())
}

/// Checks that the lines of progress on standard error increase up to all paths, once for the whole
/// run.
fn progress_is_shown(text: &str) -> Result<(), String> {
    let percents = text
        .lines()
        .filter_map(|line| line.split_once(" % of 640 paths"));
    let percents: Vec<u64> = percents
        .filter_map(|(percent, _)| percent.trim().parse().ok())
        .collect();
    let is_right = percents.is_sorted_by(|a, b| a < b) && percents.last() == Some(&100);
    is_right
        .then_some(())
        .ok_or_else(|| format!("no progress in\n{text}"))
}

fn reader(from: Option<impl std::io::Read + Send + 'static>) -> thread::JoinHandle<String> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut from) = from {
            let _ = from.read_to_end(&mut bytes);
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// Waits for the end of a run. Returns whether it succeeded; `None` after the time limit.
fn wait(child: &mut Child) -> Option<bool> {
    let start = Instant::now();
    while start.elapsed() < LIMIT {
        if let Ok(Some(status)) = child.try_wait() {
            return Some(status.success());
        }
        thread::sleep(Duration::from_millis(10));
    }
    let _ = child.kill();
    let _ = child.wait();
    None
}
