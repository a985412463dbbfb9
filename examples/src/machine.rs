//! The machine on which the times were measured.

use std::fs;
use std::process::Command;

/// Returns the name of the processor, if the system tells it.
pub fn processor() -> String {
    fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        })
        .unwrap_or_else(|| "unknown processor".to_owned())
}

/// Returns processor, number of cores, compiler and versions, as far as they are known.
pub fn description() -> String {
    let processor = processor();
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let compiler = Command::new("rustc")
        .arg("--version")
        .output()
        .ok()
        .and_then(|output| String::from_utf8(output.stdout).ok())
        .map_or_else(|| "unknown compiler".to_owned(), |s| s.trim().to_owned());
    format!(
        "{processor} ({}), {cores} cores, {}; sve {}; {compiler}",
        std::env::consts::ARCH,
        std::env::consts::OS,
        env!("CARGO_PKG_VERSION"),
    )
}
