//! The file with names, roles and passwords. `profivac user` writes it; a station that runs reads it again when it has changed.
//!
//! ```toml
//! [[user]]
//! name = "ada"
//! role = "engineer"
//! password = "$argon2id$v=19$m=19456,t=2,p=1$..."
//! ```

use super::file_permissions::{self, PermissionError};
use super::password::Hash;
use super::{Role, User};
use crate::config::ConfigError;
use profivac_host::text_file::line_and_column;
use serde::Deserialize;
use std::fmt::Write;
use std::fs::{self, File};
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::Spanned;

/// The longest name.
const MAX_NAME_LENGTH: usize = 32;

/// More than any group has. free choice.
const MAX_USERS: usize = 1000;

/// Somebody who may log in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Account {
    /// Their name.
    pub name: Arc<str>,
    /// What they may do.
    pub role: Role,
    /// Their password.
    pub password: Hash,
}

impl Account {
    /// As others see them.
    #[must_use]
    pub fn user(&self) -> User {
        User { name: Arc::clone(&self.name), role: self.role }
    }
}

/// Why there are no users.
#[derive(Debug, thiserror::Error)]
pub enum UsersError {
    /// What stands in the file.
    #[error(transparent)]
    File(#[from] ConfigError),
    /// There is none.
    #[error("there is no {file}: `profivac user add NAME --role engineer FILE.toml` makes it", file = .0.display())]
    NoFile(PathBuf),
    /// Others may read it.
    #[error(transparent)]
    Private(#[from] PermissionError),
    /// The system.
    #[error("{file}: {error}", file = .0.display(), error = .1)]
    System(PathBuf, std::io::Error),
    /// Somebody cannot have this name.
    #[error(
        "expected a name of 1 to {MAX_NAME_LENGTH} letters, digits, dots, dashes and underscores (a to z), got {0:?}"
    )]
    Name(String),
    /// The name is taken.
    #[error("there is already a user {0}")]
    Taken(String),
    /// Nobody has this name.
    #[error("there is no user {0:?}")]
    Unknown(String),
    /// Too many.
    #[error("there are {MAX_USERS} users already")]
    TooMany,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct UsersToml {
    #[serde(default)]
    user: Vec<AccountToml>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct AccountToml {
    name: Spanned<String>,
    role: Role,
    password: Spanned<String>,
}

/// All who may log in.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Users(Vec<Account>);

impl Users {
    /// Reads the file, which only its owner may read.
    ///
    /// # Errors
    /// [`UsersError`] says what is wrong with it.
    pub fn read(file: &Path) -> Result<Self, UsersError> {
        if !file.exists() {
            return Err(UsersError::NoFile(file.to_owned()));
        }
        file_permissions::check(file)?;
        let text = fs::read_to_string(file).map_err(|error| UsersError::System(file.to_owned(), error))?;
        Ok(Self::parse(&text, file)?)
    }

    /// What `text` says, as if it stood in `file`.
    ///
    /// # Errors
    /// [`ConfigError`] with the place. What stands there as a password is never repeated.
    pub fn parse(text: &str, file: &Path) -> Result<Self, ConfigError> {
        let at = |start, what: String| {
            let (line, column) = line_and_column(text, start);
            ConfigError { file: file.to_owned(), line, column, what }
        };
        let written: UsersToml = toml::from_str(text)
            .map_err(|error| at(error.span().unwrap_or_default().start, error.message().to_owned()))?;
        let mut users = Self::default();
        for AccountToml { name, role, password } in written.user {
            let start = password.span().start;
            let hash = Hash::parse(password.get_ref());
            let password = hash.ok_or_else(|| at(start, "expected what `profivac user` writes here".to_owned()))?;
            users.add(name.get_ref(), role, password).map_err(|error| at(name.span().start, error.to_string()))?;
        }
        Ok(users)
    }

    /// Changes the file, or makes it: as it is given to `change`, so it is written. Others who do so wait meanwhile.
    ///
    /// # Errors
    /// [`UsersError`] of the file or of `change`; nothing is written then.
    pub fn change<T>(file: &Path, change: impl FnOnce(&mut Self) -> Result<T, UsersError>) -> Result<T, UsersError> {
        let system = |error| UsersError::System(file.to_owned(), error);
        let beside = PathBuf::from(format!("{}-lock", file.display()));
        // Whoever could open it could hold it, and nobody would ever change anything again.
        let lock = File::options().create(true).append(true).mode(0o600).open(beside).map_err(system)?;
        lock.set_permissions(fs::Permissions::from_mode(0o600)).map_err(system)?;
        lock.lock().map_err(system)?;
        let mut users = if file.exists() { Self::read(file)? } else { Self::default() };
        let changed = change(&mut users)?;
        file_permissions::write(file, &users.text()).map_err(system)?;
        Ok(changed)
    }

    /// As the file says it.
    #[must_use]
    pub fn text(&self) -> String {
        let head =
            "# Who may log in. `profivac user` changes this file; a station that runs reads it again by itself.\n";
        self.0.iter().fold(head.to_owned(), |mut text, Account { name, role, password }| {
            let password = password.as_str();
            // Into memory: there is always room.
            let _ = write!(text, "\n[[user]]\nname = {name:?}\nrole = \"{role}\"\npassword = {password:?}\n");
            text
        })
    }

    /// All, in the order of the file.
    pub fn iter(&self) -> impl Iterator<Item = &Account> {
        self.0.iter()
    }

    /// Whether there is nobody.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whoever has this name; capital letters are the same as small ones.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Account> {
        self.0.iter().find(|user| user.name.eq_ignore_ascii_case(name))
    }

    /// Nothing, if somebody can be added under this name.
    ///
    /// # Errors
    /// [`UsersError`] when the name cannot be had.
    pub fn can_add(&self, name: &str) -> Result<(), UsersError> {
        let letter = |letter: char| letter.is_ascii_alphanumeric() || ".-_".contains(letter);
        if name.is_empty() || name.len() > MAX_NAME_LENGTH || !name.chars().all(letter) {
            return Err(UsersError::Name(name.chars().take(MAX_NAME_LENGTH).collect()));
        }
        if self.get(name).is_some() {
            return Err(UsersError::Taken(name.to_owned()));
        }
        if self.0.len() >= MAX_USERS {
            return Err(UsersError::TooMany);
        }
        Ok(())
    }

    /// One more.
    ///
    /// # Errors
    /// As [`Self::can_add`].
    pub fn add(&mut self, name: &str, role: Role, password: Hash) -> Result<(), UsersError> {
        self.can_add(name)?;
        self.0.push(Account { name: Arc::from(name), role, password });
        Ok(())
    }

    /// One less.
    ///
    /// # Errors
    /// [`UsersError::Unknown`].
    pub fn remove(&mut self, name: &str) -> Result<(), UsersError> {
        let place = self.0.iter().position(|user| user.name.eq_ignore_ascii_case(name));
        self.0.remove(place.ok_or_else(|| UsersError::Unknown(name.to_owned()))?);
        Ok(())
    }

    /// Whoever has this name, to be changed.
    ///
    /// # Errors
    /// [`UsersError::Unknown`].
    pub fn get_mut(&mut self, name: &str) -> Result<&mut Account, UsersError> {
        let user = self.0.iter_mut().find(|user| user.name.eq_ignore_ascii_case(name));
        user.ok_or_else(|| UsersError::Unknown(name.to_owned()))
    }

    /// What is different in `new`, in sentences.
    #[must_use]
    pub fn differences(&self, new: &Self) -> Vec<String> {
        let gone = self.iter().filter(|old| new.get(&old.name).is_none());
        let gone = gone.map(|old| format!("the user {} was removed", old.name));
        let changed = new.iter().flat_map(|user| match self.get(&user.name) {
            None => vec![format!("the user {} was added as {}", user.name, user.role)],
            Some(old) => {
                let role = (old.role != user.role).then(|| format!("the user {} is now {}", user.name, user.role));
                let password =
                    (old.password != user.password).then(|| format!("the password of {} was changed", user.name));
                role.into_iter().chain(password).collect()
            }
        });
        gone.chain(changed).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hash() -> Hash {
        Hash::of("tin whisker plateau").unwrap()
    }

    fn users() -> Users {
        let mut users = Users::default();
        users.add("ada", Role::Engineer, hash()).unwrap();
        users.add("Bob.2", Role::Viewer, hash()).unwrap();
        users
    }

    #[test]
    fn what_is_written_is_read() {
        let users = users();
        assert_eq!(Users::parse(&users.text(), Path::new("users.toml")).unwrap(), users);
    }

    #[test]
    fn a_name_is_one_word_and_belongs_to_one() {
        let mut users = users();
        for name in ["", "a b", "a\"b", "a\nb", "ä", &"a".repeat(33)] {
            assert!(matches!(users.add(name, Role::Viewer, hash()), Err(UsersError::Name(_))), "{name:?}");
        }
        assert!(matches!(users.add("ADA", Role::Viewer, hash()), Err(UsersError::Taken(_))));
        assert_eq!(users.get("bob.2").unwrap().role, Role::Viewer);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place_and_without_secrets() {
        let told = |text: &str| Users::parse(text, Path::new("users.toml")).unwrap_err().to_string();
        let plain = "[[user]]\nname = \"ada\"\nrole = \"engineer\"\npassword = \"tin whisker\"\n";
        assert_eq!(told(plain), "users.toml:4:12: expected what `profivac user` writes here");
        let hash = hash();
        let user = |name: &str, role: &str| {
            format!("[[user]]\nname = {name:?}\nrole = {role:?}\npassword = {:?}\n", hash.as_str())
        };
        assert!(
            told(&user("ada", "boss")).starts_with("users.toml:3:8: unknown variant `boss`, expected one of `viewer`")
        );
        assert_eq!(
            told(&(user("ada", "viewer") + &user("ada", "viewer"))),
            "users.toml:6:8: there is already a user ada"
        );
    }

    #[test]
    fn a_file_is_made_changed_and_stays_private() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("users.toml");
        Users::change(&file, |users| users.add("ada", Role::Viewer, hash())).unwrap();
        Users::change(&file, |users| users.get_mut("ada").map(|ada| ada.role = Role::Engineer)).unwrap();
        for file in [&file, &folder.path().join("users.toml-lock")] {
            assert_eq!(fs::metadata(file).unwrap().permissions().mode() & 0o777, 0o600, "{}", file.display());
        }
        assert_eq!(Users::read(&file).unwrap().get("ada").unwrap().role, Role::Engineer);
        assert!(matches!(Users::change(&file, |users| users.remove("bob")), Err(UsersError::Unknown(_))));
        fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
        assert!(matches!(Users::read(&file), Err(UsersError::Private(_))));
    }

    #[test]
    fn differences_are_sentences_without_secrets() {
        let (old, mut new) = (users(), users());
        new.0[0] = Account { role: Role::Viewer, ..old.0[0].clone() };
        new.remove("Bob.2").unwrap();
        new.add("eve", Role::Operator, hash()).unwrap();
        assert_eq!(
            old.differences(&new),
            ["the user Bob.2 was removed", "the user ada is now viewer", "the user eve was added as operator"]
        );
        new.0[0].password = hash();
        assert!(old.differences(&new).contains(&"the password of ada was changed".to_owned()));
    }
}
