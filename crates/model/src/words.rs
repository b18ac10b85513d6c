//! Enumerations with a word for each value: the one in the database, in files, in the API and in notifications.

use serde::{Serialize, Serializer};

/// An enumeration whose values have words. [`words!`](crate::words!) makes one.
pub trait Words: Copy + 'static {
    /// All values, in the order of their declaration.
    const ALL: &'static [Self];

    /// The word of the value.
    fn word(self) -> &'static str;

    /// The value with this word.
    #[must_use]
    fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|value| value.word() == word)
    }
}

/// Declares an enumeration with a word for each value.
///
/// ```
/// profivac_model::words! {
///     /// A direction.
///     pub enum Direction {
///         /// With the pressure.
///         Rising = "rising",
///         /// Against it.
///         Falling = "falling",
///     }
/// }
///
/// assert_eq!(Direction::ALL.map(Direction::word), ["rising", "falling"]);
/// assert_eq!(Direction::from_word("falling"), Some(Direction::Falling));
/// ```
#[macro_export]
macro_rules! words {
    ($(#[$meta:meta])* $visibility:vis enum $name:ident { $($(#[$of_value:meta])* $value:ident = $word:tt,)+ }) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
        $(#[$meta])*
        $visibility enum $name {
            $($(#[$of_value])* #[serde(rename = $word)] $value,)+
        }

        impl $name {
            /// All values, in the order of their declaration.
            pub const ALL: [Self; [$($word),+].len()] = [$(Self::$value),+];

            /// The word in the database, in the API and in notifications.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self { $(Self::$value => $word,)+ }
            }

            /// The value with this word.
            #[must_use]
            pub fn from_word(word: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|value| value.word() == word)
            }
        }

        impl $crate::Words for $name {
            const ALL: &'static [Self] = &Self::ALL;

            fn word(self) -> &'static str {
                self.word()
            }
        }
    };
}

/// Serializes a value of another crate as its word: `#[serde(serialize_with = "words::serialize")]`.
///
/// # Errors
/// Any error of the serializer.
pub fn serialize<T: Words, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(value.word())
}

/// The same for a value that may be absent.
///
/// # Errors
/// Any error of the serializer.
pub fn serialize_optional<T: Words, S: Serializer>(value: &Option<T>, serializer: S) -> Result<S::Ok, S::Error> {
    value.map(Words::word).serialize(serializer)
}

/// A word that was read: of a value that this program knows, or one that another version of the program wrote.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Word<T> {
    /// A value of this program.
    Known(T),
    /// The word of another version.
    Other(String),
}

impl<T: Words> Word<T> {
    /// The value with this word, or the word.
    #[must_use]
    pub fn read(word: String) -> Self {
        T::from_word(&word).map_or(Self::Other(word), Self::Known)
    }

    /// The word.
    #[must_use]
    pub fn as_str(&self) -> &str {
        match self {
            Self::Known(value) => value.word(),
            Self::Other(word) => word,
        }
    }
}

impl<T> From<T> for Word<T> {
    fn from(value: T) -> Self {
        Self::Known(value)
    }
}

impl<T: PartialEq> PartialEq<T> for Word<T> {
    fn eq(&self, value: &T) -> bool {
        matches!(self, Self::Known(own) if own == value)
    }
}

impl<T: Words> Serialize for Word<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AlarmChangeKind, AlarmState, AuditAction, ConditionKind, EventKind, PointKind, Priority};
    use serde::de::DeserializeOwned;
    use std::fmt::Debug;

    fn assert_one_word_each<T: Words + Debug + PartialEq + Serialize + DeserializeOwned>() {
        for value in T::ALL {
            assert_eq!(T::from_word(value.word()), Some(*value));
            assert_eq!(serde_json::to_value(value).unwrap(), value.word());
            assert_eq!(serde_json::from_value::<T>(value.word().into()).unwrap(), *value);
        }
    }

    #[test]
    fn each_value_has_a_word_of_its_own_which_is_its_json() {
        assert_one_word_each::<AlarmChangeKind>();
        assert_one_word_each::<AlarmState>();
        assert_one_word_each::<AuditAction>();
        assert_one_word_each::<ConditionKind>();
        assert_one_word_each::<EventKind>();
        assert_one_word_each::<PointKind>();
        assert_one_word_each::<Priority>();
    }

    #[test]
    fn a_word_of_another_version_stays_what_it_is() {
        for word in ["raised", "latched"] {
            let read = Word::<AlarmChangeKind>::read(word.to_owned());
            assert_eq!((read.as_str(), serde_json::to_value(&read).unwrap()), (word, word.into()));
            assert_eq!(matches!(read, Word::Known(_)), word == "raised");
        }
    }
}
