//! `gripd man`: manual pages of the program and of each of its commands.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, CommandFactory};
use clap_mangen::Man;

use super::output::Output;
use super::{Arguments, Failure};

/// The same for all.
const EXIT_STATUS: &str = "\
.SH \"EXIT STATUS\"
.TP
\\fB0\\fR
Done.
.TP
\\fB1\\fR
The work failed; the reason is on the standard error.
.TP
\\fB2\\fR
Bad usage or configuration.
";

/// What stands at the foot of each page.
const SOURCE: &str = concat!("gripd ", env!("CARGO_PKG_VERSION"));

/// Writes gripd.1 and gripd-COMMAND.1, from what `--help` tells.
#[derive(Args)]
pub struct Pages {
    /// The folder to write them into; it is made if it is not there.
    folder: PathBuf,
}

impl Pages {
    /// Writes them.
    pub fn run(self) -> Result<(), Failure> {
        std::fs::create_dir_all(&self.folder)
            .map_err(|e| Failure::work(format_args!("cannot make {}: {e}", self.folder.display())))?;
        // `gripd help` has no page of its own.
        let mut program = Arguments::command().disable_help_subcommand(true);
        program.build();
        for command in program.get_subcommands() {
            // Built, a command knows that it is `gripd map` on the line and gripd-map as a page, as git has it.
            let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
            page(&self.folder, &name, Man::new(command.clone()).source(SOURCE))?;
        }
        page(&self.folder, "gripd", Man::new(program).source(SOURCE))
    }
}

fn page(folder: &Path, name: &str, page: Man) -> Result<(), Failure> {
    let mut output = Output::create(&folder.join(format!("{name}.1")))?;
    page.render(&mut output)?;
    output.write_all(EXIT_STATUS.as_bytes())?;
    output.finish()
}
