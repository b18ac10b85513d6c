//! The users' file. `profivac user` writes it; a running station reads it again after each change.
//!
//! ```toml
//! [[user]]
//! name = "ada"
//! role = "engineer"
//! password = "$argon2id$v=19$m=19456,t=2,p=1$..."
//! ```
//!
//! A viewer with `wall = true` is a wall display: its login lasts a year.

use super::file_permissions::{self, PermissionError};
use super::password::{Hash, HashProblem};
use super::{Role, User};
use crate::visible_text::is_path;
use profivac_files::{make_private, open_private};
use profivac_host::text_file::line_and_column;
use serde::Deserialize;
use std::fmt::Write;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::Spanned;

/// The longest name.
const MAX_NAME_LENGTH: usize = 32;

/// The most users. chosen: far more than a vacuum group has.
const MAX_USERS: usize = 1000;

/// An account: a user and the password hash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Account {
    /// The name.
    pub name: Arc<str>,
    /// The role.
    pub role: Role,
    /// The password hash.
    pub password: Hash,
    /// Whether it is a wall display, always with the role viewer.
    pub is_wall: bool,
}

impl Account {
    /// The user, without the password hash.
    #[must_use]
    pub fn user(&self) -> User {
        User { name: Arc::clone(&self.name), role: self.role }
    }
}

/// An error in the text of the users' file, with its position.
#[derive(Debug, thiserror::Error)]
#[error("{file}:{line}:{column}: {problem}", file = file.display())]
pub struct UsersFileError {
    /// The users' file.
    pub file: PathBuf,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1.
    pub column: usize,
    /// The expected and the found text.
    pub problem: UsersFileProblem,
}

/// An error in the text of a users' file. A password or hash is never repeated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UsersFileProblem {
    /// The text is not TOML, or a key or role is unknown. Holds the message of the parser.
    #[error("{0}")]
    Syntax(String),
    /// A password is not a hash that the station uses.
    #[error(transparent)]
    Hash(HashProblem),
    /// The account cannot be added.
    #[error(transparent)]
    Account(AccountError),
}

/// The reason why an account cannot be added, changed or removed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AccountError {
    /// The name has a wrong length or contains other characters.
    #[error(
        "expected a name of 1 to {MAX_NAME_LENGTH} letters (a to z), digits, dots, dashes and underscores, neither . nor .., found {0:?}"
    )]
    Name(String),
    /// Another account has this name.
    #[error("there is already a user {0}")]
    Taken(String),
    /// No account has this name.
    #[error("there is no user {0:?}")]
    Unknown(String),
    /// A wall display would have another role than viewer.
    #[error("{0} is a wall display, which stays logged in for a year: expected the role viewer")]
    WallRole(String),
    /// The file has the maximum number of accounts.
    #[error("expected at most {MAX_USERS} users")]
    TooMany,
}

/// The reason why the users' file cannot be read or changed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UsersError {
    /// The text of the file is wrong.
    #[error(transparent)]
    File(#[from] UsersFileError),
    /// The file does not exist.
    #[error("{file} does not exist: `profivac user add NAME --role engineer FILE.toml` creates it", file = .0.display())]
    NoFile(PathBuf),
    /// Others have access to the file.
    #[error(transparent)]
    Private(#[from] PermissionError),
    /// The operating system refuses.
    #[error("{file}: {error}", file = .0.display(), error = .1)]
    System(PathBuf, std::io::Error),
    /// The change is not possible.
    #[error(transparent)]
    Account(#[from] AccountError),
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
    #[serde(default)]
    wall: bool,
}

/// All accounts, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Users(Vec<Account>);

/// A difference between two versions of the users' file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UsersChange {
    /// An account was removed.
    #[error("the user {0} was removed")]
    Removed(Arc<str>),
    /// An account was added.
    #[error("the user {0} was added as {1}")]
    Added(Arc<str>, Role),
    /// An account has a new role.
    #[error("the user {0} is now {1}")]
    NewRole(Arc<str>, Role),
    /// An account has a new password.
    #[error("the password of {0} was changed")]
    NewPassword(Arc<str>),
}

impl Users {
    /// Reads the file. Only its owner may have access to it.
    ///
    /// # Errors
    /// [`UsersError`].
    pub fn read(file: &Path) -> Result<Self, UsersError> {
        if !file.exists() {
            return Err(UsersError::NoFile(file.to_owned()));
        }
        file_permissions::check(file)?;
        let text = fs::read_to_string(file).map_err(|error| UsersError::System(file.to_owned(), error))?;
        Ok(Self::parse(&text, file)?)
    }

    /// Parses `text` as the contents of `file`.
    ///
    /// # Errors
    /// [`UsersFileError`] with the position.
    pub fn parse(text: &str, file: &Path) -> Result<Self, UsersFileError> {
        let at = |start, problem| {
            let (line, column) = line_and_column(text, start);
            UsersFileError { file: file.to_owned(), line, column, problem }
        };
        let syntax = |error: toml::de::Error| {
            let start = error.span().unwrap_or_default().start;
            at(start, UsersFileProblem::Syntax(error.message().to_owned()))
        };
        let parsed: UsersToml = toml::from_str(text).map_err(syntax)?;
        let mut users = Self::default();
        for AccountToml { name, role, password, wall } in parsed.user {
            let hash = Hash::parse(password.get_ref());
            let hash = hash.map_err(|problem| at(password.span().start, UsersFileProblem::Hash(problem)))?;
            let wrong = |error| at(name.span().start, UsersFileProblem::Account(error));
            users.add(name.get_ref(), role, hash).map_err(wrong)?;
            if wall {
                users.make_wall(name.get_ref()).map_err(wrong)?;
            }
        }
        Ok(users)
    }

    /// Reads the file or starts with no users, applies `change`, and replaces the file. A lock file keeps other processes from
    /// changing it at the same time.
    ///
    /// # Errors
    /// [`UsersError`] of the file, or the error of `change`. The file stays unchanged then.
    pub fn change<T>(file: &Path, change: impl FnOnce(&mut Self) -> Result<T, AccountError>) -> Result<T, UsersError> {
        let system = |error| UsersError::System(file.to_owned(), error);
        let mut lock_path = file.as_os_str().to_owned();
        lock_path.push("-lock");
        // Another user who could open the lock file could hold the lock for ever.
        let lock_path = PathBuf::from(lock_path);
        let lock = open_private(File::options().create(true).append(true), &lock_path).map_err(system)?;
        make_private(&lock_path).map_err(system)?;
        lock.lock().map_err(system)?;
        let mut users = if file.exists() { Self::read(file)? } else { Self::default() };
        let changed = change(&mut users)?;
        file_permissions::write(file, &users.text()).map_err(system)?;
        Ok(changed)
    }

    /// The text of the file.
    #[must_use]
    pub fn text(&self) -> String {
        let head = "# The users of a station. `profivac user` changes this file; a running station reads it again.\n";
        self.0.iter().fold(head.to_owned(), |mut text, Account { name, role, password, is_wall }| {
            let (password, wall) = (password.as_str(), if *is_wall { "wall = true\n" } else { "" });
            // Writing to a String cannot fail.
            let _ = write!(text, "\n[[user]]\nname = {name:?}\nrole = \"{role}\"\npassword = {password:?}\n{wall}");
            text
        })
    }

    /// All accounts, in the order of the file.
    pub fn iter(&self) -> impl Iterator<Item = &Account> {
        self.0.iter()
    }

    /// Whether there is no account.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The account of this name. Upper and lower case are equal.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Account> {
        self.0.iter().find(|account| account.name.eq_ignore_ascii_case(name))
    }

    /// Checks that an account can be added under this name.
    ///
    /// # Errors
    /// [`AccountError`] when the name is not permitted or taken, or when there are too many accounts.
    pub fn can_add(&self, name: &str) -> Result<(), AccountError> {
        let is_permitted = |letter: char| letter.is_ascii_alphanumeric() || ".-_".contains(letter);
        if name.is_empty() || name.len() > MAX_NAME_LENGTH || !name.chars().all(is_permitted) || is_path(name) {
            return Err(AccountError::Name(name.chars().take(MAX_NAME_LENGTH).collect()));
        }
        if self.get(name).is_some() {
            return Err(AccountError::Taken(name.to_owned()));
        }
        if self.0.len() >= MAX_USERS {
            return Err(AccountError::TooMany);
        }
        Ok(())
    }

    /// Adds an account.
    ///
    /// # Errors
    /// As [`Self::can_add`].
    pub fn add(&mut self, name: &str, role: Role, password: Hash) -> Result<(), AccountError> {
        self.can_add(name)?;
        self.0.push(Account { name: Arc::from(name), role, password, is_wall: false });
        Ok(())
    }

    /// Adds the account of a wall display, with the role viewer.
    ///
    /// # Errors
    /// As [`Self::can_add`].
    pub fn add_wall(&mut self, name: &str, password: Hash) -> Result<(), AccountError> {
        self.add(name, Role::Viewer, password)?;
        self.make_wall(name)
    }

    /// Makes the account of a viewer that of a wall display.
    fn make_wall(&mut self, name: &str) -> Result<(), AccountError> {
        let account = self.get_mut(name)?;
        if account.role != Role::Viewer {
            return Err(AccountError::WallRole(name.to_owned()));
        }
        account.is_wall = true;
        Ok(())
    }

    /// Changes the role of an account.
    ///
    /// # Errors
    /// [`AccountError::Unknown`], and [`AccountError::WallRole`] for a wall display.
    pub fn set_role(&mut self, name: &str, role: Role) -> Result<(), AccountError> {
        let account = self.get_mut(name)?;
        if account.is_wall && role != Role::Viewer {
            return Err(AccountError::WallRole(account.name.to_string()));
        }
        account.role = role;
        Ok(())
    }

    /// Removes an account.
    ///
    /// # Errors
    /// [`AccountError::Unknown`].
    pub fn remove(&mut self, name: &str) -> Result<(), AccountError> {
        let index = self.0.iter().position(|account| account.name.eq_ignore_ascii_case(name));
        self.0.remove(index.ok_or_else(|| AccountError::Unknown(name.to_owned()))?);
        Ok(())
    }

    /// The account of this name, to change it.
    ///
    /// # Errors
    /// [`AccountError::Unknown`].
    pub fn get_mut(&mut self, name: &str) -> Result<&mut Account, AccountError> {
        let account = self.0.iter_mut().find(|account| account.name.eq_ignore_ascii_case(name));
        account.ok_or_else(|| AccountError::Unknown(name.to_owned()))
    }

    /// The differences between this version and `new`, without secrets.
    #[must_use]
    pub fn differences(&self, new: &Self) -> Vec<UsersChange> {
        let removed = self.iter().filter(|old| new.get(&old.name).is_none());
        let removed = removed.map(|old| UsersChange::Removed(Arc::clone(&old.name)));
        let changed = new.iter().flat_map(|account| {
            let name = || Arc::clone(&account.name);
            let Some(old) = self.get(&account.name) else {
                return vec![UsersChange::Added(name(), account.role)];
            };
            let role = (old.role != account.role).then(|| UsersChange::NewRole(name(), account.role));
            let password = (old.password != account.password).then(|| UsersChange::NewPassword(name()));
            role.into_iter().chain(password).collect()
        });
        removed.chain(changed).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt as _;

    fn hash() -> Hash {
        Hash::of("tin whisker plateau").unwrap()
    }

    fn users() -> Users {
        let mut users = Users::default();
        users.add("ada", Role::Engineer, hash()).unwrap();
        users.add("Bob.2", Role::Viewer, hash()).unwrap();
        users
    }

    fn sentences(changes: &[UsersChange]) -> Vec<String> {
        changes.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_written_file_reads_back_unchanged() {
        let users = users();
        assert_eq!(Users::parse(&users.text(), Path::new("users.toml")).unwrap(), users);
    }

    #[test]
    fn a_wall_display_is_a_viewer() {
        let mut users = users();
        users.add_wall("wall", hash()).unwrap();
        assert_eq!(Users::parse(&users.text(), Path::new("users.toml")).unwrap(), users);
        assert!(users.get("wall").is_some_and(|wall| wall.is_wall && wall.role == Role::Viewer));
        for role in [Role::Operator, Role::Engineer] {
            assert_eq!(users.set_role("Wall", role), Err(AccountError::WallRole("wall".to_owned())));
        }
        let text = users.text().replace("wall = true", "");
        let text = text.replace("role = \"engineer\"", "role = \"engineer\"\nwall = true");
        let error = Users::parse(&text, Path::new("users.toml")).unwrap_err().to_string();
        assert!(
            error.ends_with("ada is a wall display, which stays logged in for a year: expected the role viewer"),
            "{error}"
        );
    }

    #[test]
    fn a_name_is_one_word_and_unique() {
        let mut users = users();
        for name in ["", "a b", "a\"b", "a\nb", "ä", ".", "..", "a\u{200B}", &"a".repeat(33)] {
            assert!(matches!(users.add(name, Role::Viewer, hash()), Err(AccountError::Name(_))), "{name:?}");
        }
        assert!(matches!(users.add("ADA", Role::Viewer, hash()), Err(AccountError::Taken(_))));
        assert_eq!(users.get("bob.2").unwrap().role, Role::Viewer);
    }

    #[test]
    fn an_error_in_the_file_has_its_position_and_no_secrets() {
        let error = |text: &str| Users::parse(text, Path::new("users.toml")).unwrap_err().to_string();
        let plain = "[[user]]\nname = \"ada\"\nrole = \"engineer\"\npassword = \"tin whisker\"\n";
        assert_eq!(error(plain), "users.toml:4:12: expected a password hash as `profivac user` writes it");
        let hash = hash();
        let user = |name: &str, role: &str| {
            format!("[[user]]\nname = {name:?}\nrole = {role:?}\npassword = {:?}\n", hash.as_str())
        };
        let unknown = "users.toml:3:8: unknown variant `boss`, expected one of `viewer`";
        assert!(error(&user("ada", "boss")).starts_with(unknown));
        let twice = user("ada", "viewer") + &user("ada", "viewer");
        assert_eq!(error(&twice), "users.toml:6:8: there is already a user ada");
    }

    #[test]
    fn a_file_is_created_and_changed_and_stays_private() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("users.toml");
        Users::change(&file, |users| users.add("ada", Role::Viewer, hash())).unwrap();
        Users::change(&file, |users| users.get_mut("ada").map(|ada| ada.role = Role::Engineer)).unwrap();
        for file in [&file, &folder.path().join("users.toml-lock")] {
            assert_eq!(fs::metadata(file).unwrap().permissions().mode() & 0o777, 0o600, "{}", file.display());
        }
        assert_eq!(Users::read(&file).unwrap().get("ada").unwrap().role, Role::Engineer);
        let removed = Users::change(&file, |users| users.remove("bob"));
        assert!(matches!(removed, Err(UsersError::Account(AccountError::Unknown(_)))));
        fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
        assert!(matches!(Users::read(&file), Err(UsersError::Private(_))));
    }

    #[test]
    fn differences_name_users_and_roles_and_no_secrets() {
        let (old, mut new) = (users(), users());
        new.0[0] = Account { role: Role::Viewer, ..old.0[0].clone() };
        new.remove("Bob.2").unwrap();
        new.add("eve", Role::Operator, hash()).unwrap();
        assert_eq!(
            sentences(&old.differences(&new)),
            ["the user Bob.2 was removed", "the user ada is now viewer", "the user eve was added as operator"]
        );
        new.0[0].password = hash();
        assert!(sentences(&old.differences(&new)).contains(&"the password of ada was changed".to_owned()));
    }
}
