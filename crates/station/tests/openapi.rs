//! The description of the API, as the dashboard's types are generated from it.

#![allow(clippy::unwrap_used, reason = "a test")]

use profivac_station::api::description;
use std::path::Path;

/// The dashboard builds without the station, so it needs the description as a file. `PROFIVAC_BLESS=1` writes it; afterwards
/// `npm run generate` in `crates/station/web` writes the types.
#[test]
fn the_description_in_the_dashboard_is_that_of_the_station() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("web/openapi.json");
    let described = description() + "\n";
    if std::env::var("PROFIVAC_BLESS").is_ok_and(|bless| bless == "1") {
        std::fs::write(&path, &described).unwrap();
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default();
    let line = golden.lines().zip(described.lines()).position(|(golden, described)| golden != described);
    let line = line.unwrap_or_else(|| golden.lines().count().min(described.lines().count())) + 1;
    assert!(golden == described, "{} differs from line {line} on; PROFIVAC_BLESS=1 writes it", path.display());
}
