//! `gripd completions`: what a shell needs to complete gripd's arguments.

use std::io::{self, Write};

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};

use super::{Arguments, Failure};

/// For bash, source it, or put it into /usr/share/bash-completion/completions/gripd; for zsh, as `_gripd` into a
/// folder of $fpath; for fish, into ~/.config/fish/completions/gripd.fish.
#[derive(Args)]
pub struct Completions {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    /// Writes them to the standard output.
    pub fn run(self) -> Result<(), Failure> {
        // Gathered first: the generator panics where its output is closed.
        let mut text = Vec::new();
        generate(self.shell, &mut Arguments::command(), "gripd", &mut text);
        if self.shell == Shell::Bash {
            text = with_lists(&String::from_utf8_lossy(&text)).into_bytes();
        }
        let mut out = io::stdout().lock();
        out.write_all(&text)?;
        Ok(out.flush()?)
    }
}

/// The script for bash, which completes what comes behind a comma, too, where an option takes a list.
fn with_lists(script: &str) -> String {
    script.replace("complete -F _gripd ", "complete -F _gripd_lists ") + LISTS
}

const LISTS: &str = r#"
_gripd_lists() {
    local before=""
    if [[ "$3" == --parameters && "$2" == *,* ]]; then
        before="${2%,*},"
        COMP_WORDS[COMP_CWORD]="${2##*,}"
    fi
    _gripd "$1" "${2#"$before"}" "$3"
    COMPREPLY=("${COMPREPLY[@]/#/$before}")
}
"#;
