//! `cargo run -p experiments -- NAME`.

use std::process::ExitCode;

fn main() -> ExitCode {
    experiments::cli::run()
}
