//! Rules for passwords, and password hashes by argon2id with a salt for each.
//!
//! The rules follow OWASP ASVS 5.0, 6.2: at least eight characters, no rules about their kinds, and no password that is easily
//! guessed. Every build knows the common ones (`common_passwords`). With the feature `passwords` zxcvbn also estimates the number of
//! guesses; it knows names, words, dates and keyboard patterns.

pub use super::common_passwords::SHORTEST;
use super::common_passwords::weakness;
use argon2::password_hash::PasswordHasher;
use argon2::password_hash::phc::{Output, PasswordHash};
use argon2::{Algorithm, Argon2, Block, Params, Version};
use std::fmt;
use std::ops::RangeInclusive;
use std::sync::{Arc, Mutex, PoisonError};

/// The advised number of characters.
pub const ADVISED: usize = 15;

/// The most octets. chosen: longer than a typed password, short enough to hash at once.
pub const LONGEST: usize = 512;

/// Memory in KiB, passes and lanes. chosen: the first set for argon2id in OWASP's password storage cheat sheet.
const COST: (u32, u32, u32) = (19 << 10, 2, 1);

/// The costs of a hash that the station verifies: memory in KiB, passes, lanes, and the product of memory and passes. A hash in the users'
/// file must neither use up memory and processor nor be guessed cheaply. The minima are those of OWASP's password storage cheat sheet.
const MEMORY_KIB: RangeInclusive<u32> = 7 << 10..=64 << 10;
const PASSES: RangeInclusive<u32> = 1..=10;
const LANES: RangeInclusive<u32> = 1..=4;
const WORK: RangeInclusive<u32> = 35 << 10..=256 << 10;

/// The octets of a salt, and of a hash.
const SALT_OCTETS: RangeInclusive<usize> = 8..=48;
const HASH_OCTETS: RangeInclusive<usize> = 16..=64;

/// Words that an attacker tries first at this program.
const OUR_WORDS: [&str; 6] = ["profivac", "profibus", "vacuum", "gauge", "station", "engineer"];

/// Octets of salt.
const SALT: usize = 16;

/// Memory blocks of earlier hashes, for reuse, overwritten: their contents are derived from passwords. The allocator keeps 19 MiB for each
/// thread that ever hashed a password, and the thread pool has many threads: without reuse, guesses would make the station grow by a
/// gigabyte.
static BLOCKS: Mutex<Vec<Vec<Block>>> = Mutex::new(Vec::new());

/// The number of memory blocks that are kept: as many as hashes run at once. chosen.
const MAX_KEPT: usize = 2;

/// The reason why a password is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PasswordError {
    /// Too few characters.
    #[error("expected a password of at least {SHORTEST} characters, better {ADVISED}, found {0}")]
    Short(usize),
    /// Too many octets.
    #[error("expected a password of at most {LONGEST} octets, found {0}")]
    Long(usize),
    /// Few guesses find the password; the reason, if there is one.
    #[error("this password is easily guessed: {}", .0.as_deref().unwrap_or("use some words that do not belong together"))]
    Guessed(Option<String>),
    /// The operating system supplies no random numbers.
    #[error("the password cannot be hashed: no random numbers: {0}")]
    Random(getrandom::Error),
    /// argon2 refuses the password.
    #[error("the password cannot be hashed: {0}")]
    Hash(String),
}

/// The reason why a text is not used as a password hash. The hash itself is never repeated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HashProblem {
    /// It is no complete hash by argon2id.
    #[error("expected a password hash as `profivac user` writes it")]
    Form,
    /// Its costs are out of range.
    #[error(
        "expected a password hash with a memory of {} to {} KiB, {} to {} passes, {} to {} lanes, and {} to {} KiB times passes, found \
         m={memory},t={passes},p={lanes}; delete this user from the file and add it again with `profivac user add`",
        MEMORY_KIB.start(), MEMORY_KIB.end(), PASSES.start(), PASSES.end(), LANES.start(), LANES.end(), WORK.start(), WORK.end()
    )]
    Cost {
        /// In KiB.
        memory: u32,
        /// The number of passes.
        passes: u32,
        /// The number of lanes.
        lanes: u32,
    },
}

/// Checks a new password for the user `name`.
///
/// # Errors
/// [`PasswordError`] says why it is refused.
pub fn check(password: &str, name: &str) -> Result<(), PasswordError> {
    let length = password.chars().count();
    if length < SHORTEST {
        return Err(PasswordError::Short(length));
    }
    if password.len() > LONGEST {
        return Err(PasswordError::Long(password.len()));
    }
    let words: Vec<&str> = OUR_WORDS.into_iter().chain([name]).collect();
    if let Some(weakness) = weakness(password, &words) {
        return Err(PasswordError::Guessed(Some(weakness.text().to_owned())));
    }
    guesses(password, &words)
}

/// Whether an attacker who tries `words` first needs too many guesses, as zxcvbn estimates them.
#[cfg(feature = "passwords")]
fn guesses(password: &str, words: &[&str]) -> Result<(), PasswordError> {
    let estimate = zxcvbn::zxcvbn(password, words);
    if estimate.score() >= zxcvbn::Score::Three {
        return Ok(());
    }
    let warning = estimate.feedback().and_then(|feedback| feedback.warning());
    Err(PasswordError::Guessed(warning.map(|warning| warning.to_string().trim_end_matches('.').to_lowercase())))
}

/// Nothing estimates guesses in this build.
#[cfg(not(feature = "passwords"))]
const fn guesses(_password: &str, _words: &[&str]) -> Result<(), PasswordError> {
    Ok(())
}

/// A password hash in PHC string format.
#[derive(Clone, PartialEq, Eq)]
pub struct Hash(Arc<str>);

impl Hash {
    /// The hash of a new password, with a new salt.
    ///
    /// # Errors
    /// [`PasswordError::Random`] and [`PasswordError::Hash`].
    pub fn of(password: &str) -> Result<Self, PasswordError> {
        let failed = |error: &dyn fmt::Display| PasswordError::Hash(error.to_string());
        let mut salt = [0; SALT];
        getrandom::fill(&mut salt).map_err(PasswordError::Random)?;
        let (memory, passes, lanes) = COST;
        let params = Params::new(memory, passes, lanes, None).map_err(|error| failed(&error))?;
        let argon2 = Argon2::new(Algorithm::Argon2id, Version::V0x13, params);
        let hash = argon2.hash_password_with_salt(password.as_bytes(), &salt);
        hash.map(|hash| Self(Arc::from(hash.to_string()))).map_err(|error| failed(&error))
    }

    /// Parses a hash by argon2id.
    ///
    /// # Errors
    /// [`HashProblem`] for other algorithms and incomplete hashes, and for costs out of range.
    pub fn parse(text: &str) -> Result<Self, HashProblem> {
        let hash = PasswordHash::new(text).map_err(|_| HashProblem::Form)?;
        let params = Params::try_from(&hash).map_err(|_| HashProblem::Form)?;
        let is_long_enough =
            |octets: Option<usize>, range: RangeInclusive<usize>| octets.is_some_and(|n| range.contains(&n));
        let has_salt = is_long_enough(hash.salt.as_ref().map(|salt| salt.as_ref().len()), SALT_OCTETS);
        let has_hash = is_long_enough(hash.hash.as_ref().map(Output::len), HASH_OCTETS);
        if hash.algorithm.as_str() != "argon2id" || !has_salt || !has_hash {
            return Err(HashProblem::Form);
        }
        let (memory, passes, lanes) = (params.m_cost(), params.t_cost(), params.p_cost());
        let is_in_range = MEMORY_KIB.contains(&memory) && PASSES.contains(&passes) && LANES.contains(&lanes);
        if is_in_range && WORK.contains(&memory.saturating_mul(passes)) {
            Ok(Self(Arc::from(text)))
        } else {
            Err(HashProblem::Cost { memory, passes, lanes })
        }
    }

    /// The hash in PHC string format.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Whether `password` has this hash. Takes some ten milliseconds of a processor and 19 MiB with the costs of
    /// [`Hash::of`], up to 64 MiB with others.
    #[must_use]
    pub fn matches(&self, password: &str) -> bool {
        password.len() <= LONGEST && self.verify(password).unwrap_or(false)
    }

    /// `None` if the text is not a complete hash, which [`parse`](Self::parse) excludes.
    fn verify(&self, password: &str) -> Option<bool> {
        let hash = PasswordHash::new(&self.0).ok()?;
        let (salt, expected) = (hash.salt?, hash.hash?);
        let params = Params::try_from(&hash).ok()?;
        let version = hash.version.map_or(Ok(Version::V0x13), Version::try_from).ok()?;
        let block_count = params.block_count();
        let argon2 = Argon2::new(Algorithm::Argon2id, version, params);
        let mut computed = vec![0; expected.len()];
        let hashed = with_blocks(block_count, |blocks| {
            argon2.hash_password_into_with_memory(password.as_bytes(), salt.as_ref(), &mut computed, blocks)
        });
        hashed.ok()?;
        // `Output` compares in constant time.
        Some(Output::new(&computed).ok()? == expected)
    }
}

/// Runs `work` with `count` memory blocks, from an earlier hash if there are some.
fn with_blocks<T>(count: usize, work: impl FnOnce(&mut [Block]) -> T) -> T {
    let kept = || BLOCKS.lock().unwrap_or_else(PoisonError::into_inner);
    let mut blocks = kept().pop().unwrap_or_default();
    let default_count = COST.0 as usize;
    blocks.resize(count.max(default_count), Block::default());
    let result = work(blocks.get_mut(..count).unwrap_or_default());
    blocks.fill(Block::default());
    blocks.truncate(default_count);
    blocks.shrink_to_fit();
    let mut kept = kept();
    if kept.len() < MAX_KEPT {
        kept.push(blocks);
    }
    result
}

/// Hides the hash, so that no log contains it.
impl fmt::Debug for Hash {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("Hash")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_memory_that_is_kept_has_nothing_of_a_password() {
        with_blocks(3, |blocks| blocks.iter_mut().for_each(|block| block.as_mut().fill(7)));
        with_blocks(3, |blocks| {
            assert!(blocks.iter().flat_map(|block| block.as_ref()).all(|word| *word == 0));
        });
    }

    #[test]
    fn a_password_is_stored_as_argon2id_with_its_own_salt() {
        let (one, other) = (Hash::of("tin whisker plateau").unwrap(), Hash::of("tin whisker plateau").unwrap());
        assert!(one.as_str().starts_with("$argon2id$v=19$m=19456,t=2,p=1$"), "{}", one.as_str());
        assert_ne!(one, other);
        assert!(one.matches("tin whisker plateau"));
        assert!(!one.matches("Tin whisker plateau") && !one.matches("tin whisker plateau "));
        assert_eq!(Hash::parse(one.as_str()), Ok(one.clone()));
        assert_eq!(format!("{one:?}"), "Hash");
    }

    #[test]
    fn other_algorithms_and_incomplete_hashes_are_refused() {
        let hash = Hash::of("tin whisker plateau").unwrap();
        let text = hash.as_str();
        let (head, short) = text.rsplit_once('$').unwrap();
        for wrong in [
            "",
            "tin whisker plateau",
            &text.replace("argon2id", "argon2d"),
            &text.replace("argon2id", "argon2i"),
            &text.replace("m=19456", "m=99999999999"),
            &text.replace(",p=1", ",p=0"),
            head,
            &format!("{head}${}", &short[..12]),
        ] {
            assert_eq!(Hash::parse(wrong), Err(HashProblem::Form), "{wrong}");
        }
    }

    #[test]
    fn a_hash_with_costs_out_of_range_is_refused_before_it_is_used() {
        let hash = Hash::of("tin whisker plateau").unwrap();
        let with = |memory: u32, passes: u32, lanes: u32| {
            Hash::parse(&hash.as_str().replace("m=19456,t=2,p=1", &format!("m={memory},t={passes},p={lanes}")))
        };
        for (memory, passes, lanes) in
            [(47_104, 1, 1), (19_456, 2, 1), (12_288, 3, 1), (9_216, 4, 1), (7_168, 5, 1), (65_536, 3, 4)]
        {
            assert!(with(memory, passes, lanes).is_ok(), "{memory} {passes} {lanes}");
        }
        for (memory, passes, lanes) in [
            (8, 1, 1),
            (7_167, 10, 1),
            (65_537, 1, 1),
            (1 << 20, 1, 1),
            (u32::MAX, 1, 1),
            (7_168, 1, 1),
            (19_456, 1, 1),
            (7_168, 11, 1),
            (19_456, u32::MAX, 1),
            (65_536, 5, 1),
            (19_456, 2, 5),
        ] {
            let found = with(memory, passes, lanes);
            assert_eq!(found, Err(HashProblem::Cost { memory, passes, lanes }));
            assert!(found.unwrap_err().to_string().contains(&format!("found m={memory},t={passes},p={lanes};")));
        }
    }

    #[test]
    fn a_common_or_guessable_password_is_refused() {
        for common in [
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
            assert!(matches!(check(common, "adalovelace"), Err(PasswordError::Guessed(_))), "{common}");
        }
        assert_eq!(check("k8%xQz!", "ada"), Err(PasswordError::Short(7)));
        assert_eq!(check(&"ä".repeat(300), "ada"), Err(PasswordError::Long(600)));
    }

    #[test]
    fn a_password_may_have_any_characters_and_any_typed_length() {
        for accepted in [
            "kqzvhwtmrb",
            "tin whisker plateau",
            "Flöße treiben südwärts",
            "气压计阀门真空泵房间",
            &"tin whisker plateau ".repeat(6),
        ] {
            assert_eq!(check(accepted, "ada"), Ok(()), "{accepted}");
        }
    }
}
