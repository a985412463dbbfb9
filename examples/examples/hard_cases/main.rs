//! Hard cases: one table of what makes each hard, by which method it was run, and how that ended.
//!
//! Every row has the verdict that is expected of the method, for some of them that it stops; the program exits with status 1
//! where another one came out. The assertions with their reasons are the tests `hard_cases`.

use std::process::ExitCode;

mod blow_up;
mod long;
mod noisy;
mod orbits;
mod stiff;
mod table;

fn main() -> ExitCode {
    let mut table = table::Table::default();
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
