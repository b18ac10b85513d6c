//! `profivac user`: manages the users of a station or of an archive.

use crate::console::{Key, Signals, Silence, Stdin, read, silence, stdin};
use crate::failure::Failure;
use crate::output::{notice, out};
use crate::values;
use clap::{Args, Subcommand};
use profivac_host::readiness::{Readiness, wait};
use profivac_web_server::auth::Role;
use profivac_web_server::auth::password::{self, ADVISED, Hash, LONGEST};
use profivac_web_server::auth::users::{AccountError, Users};
use std::io::{self, IsTerminal as _, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Manage the users of a station, or of an archive.
///
/// Names, roles and hashed passwords are in a file next to the station's file, which only its owner can read. A running station
/// sees a change within a second and ends the sessions of a user who was removed or got a new password.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(subcommand)]
    action: Action,
}

const EXAMPLES: &str = "\
A viewer reads. An operator also acknowledges alarms and sends commands to gauges. An engineer has all rights.

Examples:
  profivac user add ada --role engineer plant.toml
  profivac user add vera --role viewer plant.toml --password-stdin
  profivac user wall hall-screen plant.toml              # a wall display: its login lasts a year
  profivac user list plant.toml
  profivac user role ada operator plant.toml
  profivac user password ada plant.toml
  profivac user remove ada plant.toml";

#[derive(Debug, Subcommand)]
enum Action {
    /// Add a user
    #[command(
        after_help = "Examples:\n  profivac user add ada --role engineer plant.toml\n  profivac user add vera --role viewer plant.toml --password-stdin"
    )]
    Add {
        #[command(flatten)]
        who: UserArguments,
        /// The role: viewer, operator or engineer
        #[arg(long, value_parser = values::role)]
        role: Role,
        #[command(flatten)]
        typed: PasswordArguments,
    },
    /// Add a wall display: a viewer that logs in once a year
    ///
    /// Log in once in the browser of the display. The login lasts a year, also while the display or the station is off, and ends
    /// when the user is removed or gets a new password.
    #[command(after_help = "Examples:\n  profivac user wall hall-screen plant.toml")]
    Wall {
        #[command(flatten)]
        who: UserArguments,
        #[command(flatten)]
        typed: PasswordArguments,
    },
    /// Print the users with their roles, and mark the wall displays
    #[command(after_help = "Examples:\n  profivac user list plant.toml")]
    List {
        /// The file that describes the station
        #[arg(value_name = "FILE.toml")]
        file: PathBuf,
    },
    /// Remove a user
    #[command(after_help = "Examples:\n  profivac user remove ada plant.toml")]
    Remove {
        #[command(flatten)]
        who: UserArguments,
    },
    /// Change the role of a user
    #[command(after_help = "Examples:\n  profivac user role ada operator plant.toml")]
    Role {
        /// The name of the user
        #[arg(value_name = "NAME")]
        name: String,
        /// The new role: viewer, operator or engineer
        #[arg(value_parser = values::role)]
        role: Role,
        /// The file that describes the station
        #[arg(value_name = "FILE.toml")]
        file: PathBuf,
    },
    /// Set a new password for a user
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
    /// The name of the user: letters, digits, dots, dashes and underscores
    #[arg(value_name = "NAME")]
    name: String,
    /// The file that describes the station
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
}

#[derive(Args, Debug)]
struct PasswordArguments {
    /// Read the password from the first line of standard input instead of asking twice on the terminal
    #[arg(long)]
    password_stdin: bool,
}

/// Reads or changes the file of users.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.action {
        Action::Add { who, role, typed } => {
            add(who, typed, |users, hash| users.add(&who.name, *role, hash))?;
        }
        Action::Wall { who, typed } => add(who, typed, |users, hash| users.add_wall(&who.name, hash))?,
        Action::List { file } => list(&users(file)?)?,
        Action::Remove { who } => Users::change(&users(&who.file)?, |users| users.remove(&who.name))?,
        Action::Role { name, role, file } => {
            Users::change(&users(file)?, |users| users.set_role(name, *role))?;
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

/// Asks for a password and adds a user with it.
fn add(
    who: &UserArguments,
    typed: &PasswordArguments,
    add: impl FnOnce(&mut Users, Hash) -> Result<(), AccountError>,
) -> Result<(), Failure> {
    let file = users(&who.file)?;
    existing_users(&file)?.can_add(&who.name)?;
    let hash = typed.password(&who.name)?;
    let first = !file.exists();
    Users::change(&file, |users| add(users, hash))?;
    if first {
        notice(&"this is the first user; a running station asks for a login from now on");
    }
    Ok(())
}

/// The file of the users of a station, or of an archive.
fn users(file: &Path) -> Result<PathBuf, Failure> {
    #[cfg(feature = "archive")]
    {
        let found = profivac_archive::config::users_file(file);
        if let Some(users) = found.map_err(|error| Failure::usage(error.to_string()))? {
            return Ok(users);
        }
    }
    Ok(profivac_config::read_users_file(file)?)
}

/// The present users, to check a name before the password is asked for.
fn existing_users(file: &Path) -> Result<Users, Failure> {
    if file.exists() { Ok(Users::read(file)?) } else { Ok(Users::default()) }
}

fn list(file: &Path) -> Result<(), Failure> {
    if !file.exists() {
        notice(
            &"there are no users: every user of this computer may view the dashboard, and other computers are refused",
        );
        return Ok(());
    }
    let users = Users::read(file)?;
    let widest = users.iter().map(|user| user.name.len()).max().unwrap_or_default();
    users.iter().for_each(|user| {
        let wall = if user.is_wall { ", wall display" } else { "" };
        out(&format!("{:widest$}  {}{wall}", user.name, user.role));
    });
    Ok(())
}

impl PasswordArguments {
    /// Reads a password for the user `name`, checks and hashes it.
    fn password(&self, name: &str) -> Result<Hash, Failure> {
        let mut keyboard = PasswordInput::open()?;
        let password = if self.password_stdin { keyboard.line()? } else { keyboard.ask_twice(name)? };
        let unfit = |error: password::PasswordError| Failure::usage(error.to_string());
        password::check(&password, name).map_err(unfit)?;
        if password.chars().count() < ADVISED {
            notice(&format_args!("the password is accepted; {ADVISED} characters or more are better"));
        }
        Hash::of(&password).map_err(unfit)
    }
}

/// Standard input, without echo if it is a terminal. The terminal settings are restored when it is dropped.
struct PasswordInput {
    stdin: Stdin,
    signals: Signals,
    silence: Option<Silence>,
}

impl PasswordInput {
    fn open() -> Result<Self, Failure> {
        Ok(Self { stdin: stdin()?, signals: Signals::catch()?, silence: None })
    }

    /// Asks twice on the terminal.
    fn ask_twice(&mut self, name: &str) -> Result<String, Failure> {
        if !io::stdin().is_terminal() {
            return Err(Failure::usage(
                "expected a terminal to ask for the password; without one add --password-stdin",
            ));
        }
        self.silence = Some(silence()?);
        let first = self.ask(&format!("Password for {name}: "))?;
        let second = self.ask("Repeat: ")?;
        if first == second { Ok(first) } else { Err(Failure::usage("the two passwords differ; nothing was changed")) }
    }

    fn ask(&self, prompt: &str) -> Result<String, Failure> {
        let mut terminal = io::stderr().lock();
        write!(terminal, "{prompt}").and_then(|()| terminal.flush())?;
        let line = self.line();
        writeln!(terminal)?;
        line
    }

    /// Reads a line without changing it.
    fn line(&self) -> Result<String, Failure> {
        let (mut line, mut octet) = (Vec::new(), [0]);
        loop {
            let readable = wait(&[self.signals.readiness(), Readiness::of(&self.stdin)], Duration::MAX)?;
            if readable.first() == Some(&true) {
                return Err(Failure::interrupted_with("nothing was changed"));
            }
            if readable.get(1) != Some(&true) {
                continue;
            }
            let length = read(&self.stdin, &mut octet)?;
            if length == 0 || octet == [b'\n'] || line.len() > LONGEST {
                break;
            }
            match self.silence.as_ref().map_or(Key::Octet(octet[0]), |_| Silence::key(octet[0])) {
                Key::Octet(octet) => line.push(octet),
                Key::Delete => drop(line.pop()),
                Key::End => break,
                Key::Interrupt => return Err(Failure::interrupted_with("nothing was changed")),
            }
        }
        let text = String::from_utf8(line).map_err(|_| Failure::usage("expected a password in UTF-8"))?;
        Ok(text.strip_suffix('\r').map_or(text.clone(), str::to_owned))
    }
}
