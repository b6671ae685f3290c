//! The `gripd` command: parses its arguments, sets up logging, dispatches to one subcommand.

use std::process::ExitCode;

fn main() -> ExitCode {
    gripd::cli::main()
}
