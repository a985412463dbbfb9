//! Hard cases: a table with the difficulty of each case, the method and the outcome.
//!
//! Every row has the expected verdict; some methods are expected to stop. The program exits with
//! status 1 if another verdict came out. The tests `hard_cases` have the assertions with their
//! reasons.

use std::process::ExitCode;

mod blow_up;
mod long;
mod noisy;
mod orbits;
mod stiff;
mod table;

fn main() -> ExitCode {
    let mut table = table::Table::new();
    stiff::rows(&mut table);
    orbits::rows(&mut table);
    long::rows(&mut table);
    noisy::rows(&mut table);
    let as_expected = table.print();
    match table.write(&blow_up::figure()) {
        Ok(()) if as_expected => ExitCode::SUCCESS,
        Ok(()) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
