//! Checks of query parameters.

use super::problem::Problem;
use axum::extract::Query;
use axum::extract::rejection::QueryRejection;
use profivac_recorder::Micros;

/// The parameters of a query, or a problem that names the parameter.
pub fn parsed_query<T>(query: Result<Query<T>, QueryRejection>) -> Result<T, Problem> {
    query.map(|Query(query)| query).map_err(|rejection| Problem::bad_request(rejection.body_text()))
}

/// Parses the time of a parameter, in milliseconds since 1970.
///
/// # Errors
/// A sentence with the name of the parameter.
pub fn moment(name: &'static str, value: &str) -> Result<i64, String> {
    value.parse().map_err(|_| format!("expected {name} in milliseconds since 1970, found {value:?}"))
}

/// A time range whose end is after its beginning, from milliseconds since 1970.
pub fn time_range(from: i64, to: i64) -> Result<(Micros, Micros), Problem> {
    if from >= to {
        return Err(Problem::bad_request(format!("expected from to lie before to, found {from} and {to}")));
    }
    Ok((Micros(from.saturating_mul(1000)), Micros(to.saturating_mul(1000))))
}

/// A number from 1 to `max`.
pub fn checked_range(name: &'static str, given: u32, max: u32) -> Result<u32, Problem> {
    if (1..=max).contains(&given) {
        Ok(given)
    } else {
        Err(Problem::bad_request(format!("expected {name} from 1 to {max}, found {given}")))
    }
}
