//! The description of the API of the view, as its page's types are generated from it.

#![allow(clippy::unwrap_used, reason = "a test")]

use crate::golden;
use profivac_archive::view::description;

/// The page builds without the archive, so it needs the description as a file. `PROFIVAC_BLESS=1` writes it; afterwards
/// `npm run generate` in `crates/station/web` writes the types.
#[test]
fn the_description_in_the_page_is_that_of_the_archive() {
    golden::compare("crates/station/web/archive-openapi.json", &(description() + "\n"));
}
