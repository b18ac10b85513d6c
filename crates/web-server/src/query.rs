//! Checks of query parameters.

use crate::problem::Problem;
use axum::extract::Query;
use axum::extract::rejection::QueryRejection;
use profivac_recorder::Micros;
use std::error::Error;

/// The parameters of a query, or a problem that names the parameter.
///
/// # Errors
/// 400: a parameter is missing, unknown or malformed.
pub fn parsed_query<T>(query: Result<Query<T>, QueryRejection>) -> Result<T, Problem> {
    // The text of the rejection itself begins with words for programmers.
    let sentence =
        |rejection: &QueryRejection| rejection.source().map_or_else(|| rejection.body_text(), ToString::to_string);
    query.map(|Query(query)| query).map_err(|rejection| Problem::bad_request(sentence(&rejection)))
}

/// A parameter that is no time.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MomentError {
    /// The query does not have the parameter.
    #[error("expected {name} in milliseconds since 1970, found nothing")]
    Missing {
        /// The parameter.
        name: &'static str,
    },
    /// The value is no whole number of 64 bits.
    #[error("expected {name} in milliseconds since 1970, found {found:?}")]
    NoNumber {
        /// The parameter.
        name: &'static str,
        /// Its value.
        found: String,
    },
}

/// Parses the time of a parameter, in milliseconds since 1970.
///
/// # Errors
/// [`MomentError::NoNumber`].
pub fn moment(name: &'static str, value: &str) -> Result<i64, MomentError> {
    value.parse().map_err(|_| MomentError::NoNumber { name, found: value.to_owned() })
}

/// A time range whose end is after its beginning, from milliseconds since 1970.
///
/// # Errors
/// 400: the end is not after the beginning.
pub fn time_range(from: i64, to: i64) -> Result<(Micros, Micros), Problem> {
    if from >= to {
        return Err(Problem::bad_request(format!("expected from to lie before to, found {from} and {to}")));
    }
    Ok((Micros(from.saturating_mul(1000)), Micros(to.saturating_mul(1000))))
}

/// A finite number above 0.
///
/// # Errors
/// 400: it is another number.
pub fn positive(name: &'static str, given: f64) -> Result<f64, Problem> {
    if given.is_finite() && given > 0.0 {
        Ok(given)
    } else {
        Err(Problem::bad_request(format!("expected {name} above 0, found {given}")))
    }
}

/// The accuracy of a gauge as a fraction of the reading, if it is given.
///
/// # Errors
/// 400: it is not from 0 to 1.
pub fn checked_accuracy(given: Option<f64>) -> Result<Option<f64>, Problem> {
    match given {
        Some(accuracy) if !(0.0..=1.0).contains(&accuracy) => {
            Err(Problem::bad_request(format!("expected an accuracy from 0 to 1 (0.15 is 15 %), found {accuracy}")))
        }
        given => Ok(given),
    }
}

/// A number from 1 to `max`.
///
/// # Errors
/// 400: it is another number.
pub fn checked_range(name: &'static str, given: u32, max: u32) -> Result<u32, Problem> {
    if (1..=max).contains(&given) {
        Ok(given)
    } else {
        Err(Problem::bad_request(format!("expected {name} from 1 to {max}, found {given}")))
    }
}
