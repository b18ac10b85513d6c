//! What replaces the generated description of the API in a program without the feature `openapi`: the same description from the
//! repository. `tests/openapi.rs` compares both.

/// The description of the API as JSON.
#[must_use]
pub fn description() -> String {
    include_str!("../../web/openapi.json").trim_end().to_owned()
}
