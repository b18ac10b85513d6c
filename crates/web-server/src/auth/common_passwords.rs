//! Passwords that an attacker tries first: common ones, words of this program and the user's name, and characters in a row.
//!
//! `common_passwords.txt` has the passwords of at least eight characters from the list of 20,000 that Django 5.2 brings (file
//! `common-passwords.txt.gz`, BSD-3-Clause), in lower case and in the order of their octets. OWASP ASVS 5.0, 6.2.4, asks for 3,000.

use std::sync::LazyLock;

/// The fewest characters of a password.
pub const SHORTEST: usize = 8;

/// One password a line, in order.
static LINES: LazyLock<Vec<&str>> = LazyLock::new(|| include_str!("common_passwords.txt").lines().collect());

/// What makes a password easy to guess.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Weakness {
    /// It is in the list, if need be without digits and signs at its end.
    Common,
    /// Without the user's name and the words of this program, little is left.
    Words,
    /// Its characters are equal, or follow each other in the alphabet.
    Row,
}

impl Weakness {
    /// The sentence for the user.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Common => "this is a very common password",
            Self::Words => "it is made of the user's name, or of words of this program",
            Self::Row => "its characters repeat, or follow each other",
        }
    }
}

/// The first weakness of a password, if it has one. `words` are what an attacker tries first at this station.
pub(super) fn weakness(password: &str, words: &[&str]) -> Option<Weakness> {
    let lower = password.to_lowercase();
    let stem = lower.trim_end_matches(|character: char| !character.is_alphabetic());
    if is_listed(&lower) || is_listed(stem) {
        Some(Weakness::Common)
    } else if left_without(&lower, words) < SHORTEST && words.iter().any(|word| contains(&lower, word)) {
        Some(Weakness::Words)
    } else {
        is_row(&lower).then_some(Weakness::Row)
    }
}

/// Whether the list has this password.
fn is_listed(password: &str) -> bool {
    LINES.binary_search(&password).is_ok()
}

fn contains(password: &str, word: &str) -> bool {
    !word.is_empty() && password.contains(&word.to_lowercase())
}

/// The number of characters that are left without these words, the longest first: a short one may be a part of it.
fn left_without(password: &str, words: &[&str]) -> usize {
    let mut words: Vec<_> = words.iter().filter(|word| !word.is_empty()).collect();
    words.sort_by_key(|word| std::cmp::Reverse(word.len()));
    words.iter().fold(password.to_owned(), |left, word| left.replace(&word.to_lowercase(), "")).chars().count()
}

/// Whether every character is the one before, its successor or its predecessor.
fn is_row(password: &str) -> bool {
    password.chars().zip(password.chars().skip(1)).all(|(one, next)| u32::from(one).abs_diff(u32::from(next)) <= 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_has_more_than_3000_passwords_that_could_be_chosen_in_order() {
        assert!(LINES.len() > 3000, "{}", LINES.len());
        assert!(LINES.is_sorted_by(|one, next| one < next));
        assert!(LINES.iter().all(|line| line.chars().count() >= SHORTEST && *line == line.to_lowercase()));
    }

    #[test]
    fn a_weak_password_is_told_by_its_kind() {
        for (password, weakness) in [
            ("password", Some(Weakness::Common)),
            ("PassWord", Some(Weakness::Common)),
            ("Password2026!", Some(Weakness::Common)),
            ("adalovelace", Some(Weakness::Words)),
            ("Profivac-Ada-7", Some(Weakness::Words)),
            ("vacuumgauge99", Some(Weakness::Words)),
            ("mmmmmmmmmmmmmmmm", Some(Weakness::Row)),
            ("klmnopqrstu", Some(Weakness::Row)),
            ("utsrqponmlk", Some(Weakness::Row)),
            // Seven characters beside the words are too few, eight are enough.
            ("vacuum-kqzvhw", Some(Weakness::Words)),
            ("vacuum-kqzvhwt", None),
            ("tin whisker plateau", None),
        ] {
            assert_eq!(
                super::weakness(password, &["vacuum", "gauge", "profivac", "ada", "adalovelace", ""]),
                weakness,
                "{password}"
            );
        }
    }
}
