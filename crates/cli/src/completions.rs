//! `profivac completions`: prints completions for a shell.

use crate::failure::Failure;
use clap::{Args, Command};
use clap_complete::{Shell, generate};

/// Print completions for a shell: commands, options and values.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The shell to complete for
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

const EXAMPLES: &str = "\
Examples:
  profivac completions bash > ~/.local/share/bash-completion/completions/profivac
  profivac completions zsh > ~/.zfunc/_profivac
  profivac completions fish > ~/.config/fish/completions/profivac.fish";

/// Prints them.
pub fn run(arguments: &Arguments, mut command: Command) -> Result<(), Failure> {
    let mut text = Vec::new();
    generate(arguments.shell, &mut command, "profivac", &mut text);
    crate::output::out(String::from_utf8_lossy(&text).trim_end());
    Ok(())
}
