//! The description of the API, as the dashboard's types are generated from it.

#![allow(clippy::unwrap_used, reason = "a test")]

use crate::golden;
use profivac_station::api::description;

/// The dashboard builds without the station, so it needs the description as a file. `PROFIVAC_BLESS=1` writes it; afterwards
/// `npm run generate` in `crates/station/web` writes the types.
#[test]
fn the_description_in_the_dashboard_is_that_of_the_station() {
    golden::compare("crates/station/web/openapi.json", &(description() + "\n"));
}
