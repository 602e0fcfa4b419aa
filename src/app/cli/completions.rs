//! `terrane completions`: scripts that teach a shell to complete the command line.

use super::{Cli, output::print};
use crate::app::Error;
use clap::{Args, CommandFactory};
use clap_complete::Shell;

/// Print a script with which a shell completes verbs, options, layers and files
///
/// bash: terrane completions bash > ~/.local/share/bash-completion/completions/terrane
///
/// zsh: terrane completions zsh > FOLDER/_terrane, for a FOLDER in $fpath
///
/// fish: terrane completions fish > ~/.config/fish/completions/terrane.fish
///
/// PowerShell: terrane completions powershell | Out-String | Invoke-Expression, in $PROFILE
///
/// elvish: eval (terrane completions elvish | slurp), in rc.elv
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Shell to write it for
    shell: Shell,
}

pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "terrane", &mut script);
    print(&script)
}
