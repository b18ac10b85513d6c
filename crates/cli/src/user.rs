//! `profivac user`: who may log in to a station.

use crate::console::Signals;
use crate::failure::Failure;
use crate::output::{notice, out};
use clap::{Args, Subcommand};
use profivac_host::port::wait;
use profivac_station::auth::Role;
use profivac_station::auth::password::{self, ADVISED, Hash, LONGEST};
use profivac_station::auth::users::Users;
use profivac_station::config::Config;
use rustix::fd::AsFd;
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcsetattr};
use std::io::{self, IsTerminal, Stdin, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Who may log in to a station, and what they may do.
///
/// Names, roles and hashed passwords stand in a file beside the station's file, readable by its owner alone. A station that runs
/// sees a change by itself within a second. Sessions of somebody who is removed or gets a new password end then.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(subcommand)]
    action: Action,
}

const EXAMPLES: &str = "\
A viewer looks. An operator also acknowledges alarms and carries out commands of a gauge. An engineer may do everything.

Examples:
  profivac user add ada --role engineer plant.toml
  profivac user add wall --role viewer plant.toml --password-stdin
  profivac user list plant.toml
  profivac user role ada operator plant.toml
  profivac user password ada plant.toml
  profivac user remove ada plant.toml";

#[derive(Debug, Subcommand)]
enum Action {
    /// Let somebody in
    #[command(
        after_help = "Examples:\n  profivac user add ada --role engineer plant.toml\n  profivac user add wall --role viewer plant.toml --password-stdin"
    )]
    Add {
        #[command(flatten)]
        who: UserArguments,
        /// What they may do: viewer, operator or engineer
        #[arg(long, value_parser = role)]
        role: Role,
        #[command(flatten)]
        typed: PasswordArguments,
    },
    /// Print names and roles
    #[command(after_help = "Examples:\n  profivac user list plant.toml")]
    List {
        /// The file that describes the station
        #[arg(value_name = "FILE.toml")]
        file: PathBuf,
    },
    /// Let somebody in no longer
    #[command(after_help = "Examples:\n  profivac user remove ada plant.toml")]
    Remove {
        #[command(flatten)]
        who: UserArguments,
    },
    /// Change what somebody may do
    #[command(after_help = "Examples:\n  profivac user role ada operator plant.toml")]
    Role {
        /// Their name
        #[arg(value_name = "NAME")]
        name: String,
        /// What they may do from now on: viewer, operator or engineer
        #[arg(value_parser = role)]
        role: Role,
        /// The file that describes the station
        #[arg(value_name = "FILE.toml")]
        file: PathBuf,
    },
    /// Give somebody a new password
    #[command(after_help = "Examples:\n  profivac user password ada plant.toml")]
    Password {
        #[command(flatten)]
        who: UserArguments,
        #[command(flatten)]
        typed: PasswordArguments,
    },
}

#[derive(Args, Debug)]
struct UserArguments {
    /// Their name: letters, digits, dots, dashes and underscores
    #[arg(value_name = "NAME")]
    name: String,
    /// The file that describes the station
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
}

#[derive(Args, Debug)]
struct PasswordArguments {
    /// Take the first line of standard input as the password, instead of asking twice on the terminal
    #[arg(long)]
    password_stdin: bool,
}

fn role(text: &str) -> Result<Role, String> {
    let role = Role::ALL.into_iter().find(|role| role.word() == text);
    role.ok_or_else(|| "expected viewer, operator or engineer".to_owned())
}

/// Looks into the file of users or changes it.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.action {
        Action::Add { who, role, typed } => {
            let file = users(&who.file)?;
            existing_users(&file)?.can_add(&who.name)?;
            let hash = typed.password(&who.name)?;
            let first = !file.exists();
            Users::change(&file, |users| users.add(&who.name, *role, hash))?;
            if first {
                notice(
                    &"this is the first user: a station that runs without users takes them when it is started again",
                );
            }
        }
        Action::List { file } => list(&users(file)?)?,
        Action::Remove { who } => Users::change(&users(&who.file)?, |users| users.remove(&who.name))?,
        Action::Role { name, role, file } => {
            Users::change(&users(file)?, |users| users.get_mut(name).map(|user| user.role = *role))?;
        }
        Action::Password { who, typed } => {
            let file = users(&who.file)?;
            existing_users(&file)?.get_mut(&who.name)?;
            let hash = typed.password(&who.name)?;
            Users::change(&file, |users| users.get_mut(&who.name).map(|user| user.password = hash))?;
        }
    }
    Ok(())
}

fn users(station: &Path) -> Result<PathBuf, Failure> {
    Ok(Config::read(station)?.users.path)
}

/// Those there are before anything is asked: who asks for a password in vain annoys.
fn existing_users(file: &Path) -> Result<Users, Failure> {
    if file.exists() { Ok(Users::read(file)?) } else { Ok(Users::default()) }
}

fn list(file: &Path) -> Result<(), Failure> {
    if !file.exists() {
        notice(&"there are no users: everybody on this computer may look, and nobody else comes in");
        return Ok(());
    }
    let users = Users::read(file)?;
    let widest = users.iter().map(|user| user.name.len()).max().unwrap_or_default();
    users.iter().for_each(|user| out(&format!("{:widest$}  {}", user.name, user.role)));
    Ok(())
}

impl PasswordArguments {
    /// A password that will do, for whoever has this name.
    fn password(&self, name: &str) -> Result<Hash, Failure> {
        let mut keyboard = PasswordInput::open()?;
        let password = if self.password_stdin { keyboard.line()? } else { keyboard.ask_twice(name)? };
        let unfit = |error: password::PasswordError| Failure::usage(error.to_string());
        password::check(&password, name).map_err(unfit)?;
        if password.chars().count() < ADVISED {
            notice(&format_args!("this will do; {ADVISED} characters or more would be better"));
        }
        Hash::of(&password).map_err(unfit)
    }
}

/// Standard input, in silence if it is a terminal. Left as it was found, however the command ends.
struct PasswordInput {
    stdin: Stdin,
    signals: Signals,
    before: Option<Termios>,
}

impl PasswordInput {
    fn open() -> Result<Self, Failure> {
        Ok(Self { stdin: io::stdin(), signals: Signals::catch()?, before: None })
    }

    /// Asks twice on the terminal.
    fn ask_twice(&mut self, name: &str) -> Result<String, Failure> {
        if !self.stdin.is_terminal() {
            return Err(Failure::usage("there is no terminal to ask for the password on: say --password-stdin"));
        }
        self.disable_echo()?;
        let first = self.ask(&format!("Password for {name}: "))?;
        let second = self.ask("Once more: ")?;
        if first == second { Ok(first) } else { Err(Failure::usage("the two passwords are not the same")) }
    }

    fn disable_echo(&mut self) -> io::Result<()> {
        let before = tcgetattr(&self.stdin)?;
        let mut silent = before.clone();
        silent.local_modes.remove(LocalModes::ECHO);
        tcsetattr(&self.stdin, OptionalActions::Flush, &silent)?;
        self.before = Some(before);
        Ok(())
    }

    fn ask(&self, prompt: &str) -> Result<String, Failure> {
        let mut terminal = io::stderr().lock();
        write!(terminal, "{prompt}").and_then(|()| terminal.flush())?;
        let line = self.line();
        writeln!(terminal)?;
        line
    }

    /// A line, exactly as it comes.
    fn line(&self) -> Result<String, Failure> {
        let (mut line, mut octet) = (Vec::new(), [0]);
        loop {
            let said = wait(&[self.signals.as_fd(), self.stdin.as_fd()], Duration::MAX)?;
            if said.first() == Some(&true) {
                return Err(Failure::usage("nothing was changed"));
            }
            if said.get(1) != Some(&true) {
                continue;
            }
            let read = rustix::io::read(&self.stdin, &mut octet).map_err(io::Error::from)?;
            if read == 0 || octet == [b'\n'] || line.len() > LONGEST {
                break;
            }
            line.extend(octet);
        }
        let text = String::from_utf8(line).map_err(|_| Failure::usage("expected a password in UTF-8"))?;
        Ok(text.strip_suffix('\r').map_or(text.clone(), str::to_owned))
    }
}

impl Drop for PasswordInput {
    fn drop(&mut self) {
        if let Some(before) = &self.before {
            // There is nobody left to tell.
            tcsetattr(&self.stdin, OptionalActions::Now, before).ok();
        }
    }
}
