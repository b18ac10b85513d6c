//! `plant.toml`, the file of a station: a wrong file is refused with line and column.

use profivac_station::config::Config;
use std::path::Path;

/// Runs the target.
pub fn run(octets: &[u8]) {
    let Ok(text) = std::str::from_utf8(octets) else { return };
    if let Err(error) = Config::parse(text, Path::new("/nonexistent/plant.toml")) {
        assert!((1..=text.lines().count() + 1).contains(&error.line), "line {} of {text:?}", error.line);
        assert!(error.column >= 1, "column {}", error.column);
        assert!(!error.to_string().is_empty(), "a refusal without a message");
    }
}
