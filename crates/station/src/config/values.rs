//! Values that several tables have: delays and priorities.

use super::error::{ConfigProblem, Located};
use crate::alarm::Priority;
use profivac_host::text_file::Parsed;
use std::time::Duration;
use toml::Spanned;

/// The longest delay. free choice.
const MAX_DELAY: Duration = Duration::from_secs(3600);

/// A delay of at most an hour, or its default.
pub fn delay(given: Option<&Spanned<Parsed<humantime::Duration>>>, default: Duration) -> Result<Duration, Located> {
    match given {
        Some(given) if Duration::from(given.get_ref().0) > MAX_DELAY => {
            Err(Located::new(given.span(), ConfigProblem::Delay(given.get_ref().0)))
        }
        Some(given) => Ok(given.get_ref().0.into()),
        None => Ok(default),
    }
}

/// A priority, or its default.
pub fn priority(given: Option<&Spanned<String>>, default: Priority) -> Result<Priority, Located> {
    given.map_or(Ok(default), |given| priority_word(given, false))
}

/// A priority; `None` for `off`.
pub fn priority_or_off(given: Option<&Spanned<String>>, default: Priority) -> Result<Option<Priority>, Located> {
    match given {
        Some(given) if given.get_ref() == "off" => Ok(None),
        Some(given) => priority_word(given, true).map(Some),
        None => Ok(Some(default)),
    }
}

fn priority_word(given: &Spanned<String>, may_be_off: bool) -> Result<Priority, Located> {
    let unknown = || {
        let found = given.get_ref().clone();
        Located::new(given.span(), ConfigProblem::UnknownPriority { found, may_be_off })
    };
    Priority::from_word(given.get_ref()).ok_or_else(unknown)
}
