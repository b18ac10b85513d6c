//! What a password must be, and how it is kept: argon2id, with a salt of its own.
//!
//! What it must be follows OWASP ASVS 5.0, 6.2: eight characters at least, no rules about which, and nothing that is easily
//! guessed. How easily is estimated by zxcvbn, which knows the usual passwords, names, words, dates, and patterns on keyboards.

use argon2::password_hash::PasswordHasher;
use argon2::password_hash::phc::{Output, PasswordHash};
use argon2::{Algorithm, Argon2, Block, Params, Version};
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};
use zxcvbn::{Score, zxcvbn};

/// The fewest characters.
pub const SHORTEST: usize = 8;

/// From so many characters on nobody is advised to take more.
pub const ADVISED: usize = 15;

/// The most octets. free choice: what nobody types, and what is hashed at once.
pub const LONGEST: usize = 512;

/// Memory in KiB, passes and lanes. free choice: the first of those that OWASP's cheat sheet on storing passwords gives for argon2id.
const COST: (u32, u32, u32) = (19 << 10, 2, 1);

/// Words that anybody tries first here.
const OUR_WORDS: [&str; 6] = ["profivac", "profibus", "vacuum", "gauge", "station", "engineer"];

/// Octets of salt.
const SALT: usize = 16;

/// Memory in which passwords were tried, to be used again. Each thread that gets its own from the system keeps it for good, and
/// many have their turn: whoever guesses would make the station grow by a gigabyte.
static ROOM: Mutex<Vec<Vec<Block>>> = Mutex::new(Vec::new());

/// So many passwords are usually tried at once; memory for more is given back. free choice.
const KEPT: usize = 2;

/// What is wrong with a password.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PasswordError {
    /// Too few characters.
    #[error("expected a password of at least {SHORTEST} characters, better {ADVISED}, got {0}")]
    Short(usize),
    /// Too many.
    #[error("expected a password of at most {LONGEST} octets, got {0}")]
    Long(usize),
    /// Others have it, or it can be guessed.
    #[error("this password is easily guessed: {0}")]
    Guessed(String),
    /// It cannot be hashed.
    #[error("the password cannot be hashed: {0}")]
    System(String),
}

/// Nothing, if this may become the password of whoever has this name.
///
/// # Errors
/// [`Unfit`] says what is wrong with it.
pub fn check(password: &str, name: &str) -> Result<(), PasswordError> {
    let length = password.chars().count();
    if length < SHORTEST {
        return Err(PasswordError::Short(length));
    }
    if password.len() > LONGEST {
        return Err(PasswordError::Long(password.len()));
    }
    let words: Vec<&str> = OUR_WORDS.into_iter().chain([name]).collect();
    let guessed = zxcvbn(password, &words);
    if guessed.score() >= Score::Three {
        return Ok(());
    }
    let warning = guessed.feedback().and_then(|feedback| feedback.warning());
    let usual = || "take some words that do not belong together".to_owned();
    Err(PasswordError::Guessed(
        warning.map_or_else(usual, |warning| warning.to_string().trim_end_matches('.').to_lowercase()),
    ))
}

/// A password as it is kept.
#[derive(Clone, PartialEq, Eq)]
pub struct Hash(Arc<str>);

impl Hash {
    /// Of a new password.
    ///
    /// # Errors
    /// [`Unfit::System`].
    pub fn of(password: &str) -> Result<Self, PasswordError> {
        let mut salt = [0; SALT];
        getrandom::fill(&mut salt).map_err(|error| PasswordError::System(error.to_string()))?;
        let (memory, passes, lanes) = COST;
        let params =
            Params::new(memory, passes, lanes, None).map_err(|error| PasswordError::System(error.to_string()))?;
        let argon2 = Argon2::new(Algorithm::Argon2id, Version::V0x13, params);
        let hash = argon2.hash_password_with_salt(password.as_bytes(), &salt);
        hash.map(|hash| Self(Arc::from(hash.to_string()))).map_err(|error| PasswordError::System(error.to_string()))
    }

    /// As it stands in a file; nothing, if this is no hash that argon2id makes.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let hash = PasswordHash::new(text).ok()?;
        let params = Params::try_from(&hash).ok()?;
        // What stands in a file must not take a day and all memory.
        let bearable = params.m_cost() <= 1 << 20 && params.t_cost() <= 64;
        let whole = hash.algorithm.as_str() == "argon2id" && hash.salt.is_some() && hash.hash.is_some();
        (bearable && whole).then(|| Self(Arc::from(text)))
    }

    /// As it stands in the file.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Whether this is the password. Takes some ten milliseconds of a processor and 19 MiB.
    #[must_use]
    pub fn matches(&self, password: &str) -> bool {
        password.len() <= LONGEST && self.tried(password).unwrap_or(false)
    }

    /// Nothing, if this is no hash, which [`parse`](Self::parse) has made sure of.
    fn tried(&self, password: &str) -> Option<bool> {
        let hash = PasswordHash::new(&self.0).ok()?;
        let (salt, wanted) = (hash.salt?, hash.hash?);
        let params = Params::try_from(&hash).ok()?;
        let version = hash.version.map_or(Ok(Version::V0x13), Version::try_from).ok()?;
        let blocks = params.block_count();
        let argon2 = Argon2::new(Algorithm::Argon2id, version, params);
        let mut made = vec![0; wanted.len()];
        let done = in_room(blocks, |room| {
            argon2.hash_password_into_with_memory(password.as_bytes(), salt.as_ref(), &mut made, room)
        });
        done.ok()?;
        // Compared in the same time wherever they differ.
        Some(Output::new(&made).ok()? == wanted)
    }
}

/// Does something with so many blocks of memory, that of somebody before if there is some.
fn in_room<T>(blocks: usize, work: impl FnOnce(&mut [Block]) -> T) -> T {
    let rooms = || ROOM.lock().unwrap_or_else(PoisonError::into_inner);
    let mut room = rooms().pop().unwrap_or_default();
    let usual = COST.0 as usize;
    room.resize(blocks.max(usual), Block::default());
    let done = work(room.get_mut(..blocks).unwrap_or_default());
    room.truncate(usual);
    room.shrink_to_fit();
    let mut rooms = rooms();
    if rooms.len() < KEPT {
        rooms.push(room);
    }
    done
}

/// Never in a log.
impl fmt::Debug for Hash {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("Hash")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_password_is_kept_as_argon2id_with_a_salt_of_its_own() {
        let (one, other) = (Hash::of("tin whisker plateau").unwrap(), Hash::of("tin whisker plateau").unwrap());
        assert!(one.as_str().starts_with("$argon2id$v=19$m=19456,t=2,p=1$"), "{}", one.as_str());
        assert_ne!(one, other);
        assert!(
            one.matches("tin whisker plateau")
                && !one.matches("Tin whisker plateau")
                && !one.matches("tin whisker plateau ")
        );
        assert_eq!(Hash::parse(one.as_str()), Some(one.clone()));
        assert_eq!(format!("{one:?}"), "Hash");
    }

    #[test]
    fn what_is_no_hash_of_ours_is_none() {
        let hash = Hash::of("tin whisker plateau").unwrap();
        let text = hash.as_str();
        for wrong in [
            "",
            "tin whisker plateau",
            &text.replace("argon2id", "argon2d"),
            &text.replace("m=19456", "m=999999999"),
            &text.replace("t=2", "t=1000"),
            text.rsplit_once('$').unwrap().0,
        ] {
            assert_eq!(Hash::parse(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn what_others_have_or_can_guess_is_refused() {
        for usual in [
            "password",
            "12345678",
            "qwertyuiop",
            "iloveyou",
            "sunshine1",
            "Password1!",
            "profivac1",
            "adalovelace",
            "aaaaaaaaaaaaaaaa",
            "1q2w3e4r5t",
            "vacuumgauge",
        ] {
            assert!(matches!(check(usual, "adalovelace"), Err(PasswordError::Guessed(_))), "{usual}");
        }
        assert_eq!(check("k8%xQz!", "ada"), Err(PasswordError::Short(7)));
        assert_eq!(check(&"ä".repeat(300), "ada"), Err(PasswordError::Long(600)));
    }

    #[test]
    fn any_characters_and_any_length_that_somebody_types_will_do() {
        for fit in [
            "kqzvhwtmrb",
            "tin whisker plateau",
            "Flöße treiben südwärts",
            "气压计阀门真空泵房间",
            &"tin whisker plateau ".repeat(6),
        ] {
            assert_eq!(check(fit, "ada"), Ok(()), "{fit}");
        }
    }
}
