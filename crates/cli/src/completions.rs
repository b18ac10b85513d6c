//! `profivac completions`: what a shell needs to complete this command line.

use crate::failure::Failure;
use clap::{Args, Command};
use clap_complete::{Shell, generate};

/// Print the completions of a shell: commands, options and what they take.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The shell
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
