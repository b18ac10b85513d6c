//! The files of a station: `plant.toml`, and its users. A wrong file is refused with line and column.

use profivac_web_server::auth::users::Users;
use std::path::Path;

/// Runs the target.
pub fn run(octets: &[u8]) {
    let Ok(text) = std::str::from_utf8(octets) else { return };
    if let Err(error) = profivac_config::parse(text, Path::new("/nonexistent/plant.toml")) {
        assert!((1..=text.lines().count() + 1).contains(&error.line), "line {} of {text:?}", error.line);
        assert!(error.column >= 1, "column {}", error.column);
        assert!(!error.to_string().is_empty(), "a refusal without a message");
    }
}

/// The file of the users: what is read is the same when it is written and read again.
pub fn users(octets: &[u8]) {
    let Ok(text) = std::str::from_utf8(octets) else { return };
    let file = Path::new("/nonexistent/plant.users.toml");
    match Users::parse(text, file) {
        Ok(users) => {
            let written = users.text();
            let again = Users::parse(&written, file).expect("a file that this program has written");
            assert_eq!(again.text(), written);
        }
        Err(error) => {
            assert!((1..=text.lines().count() + 1).contains(&error.line), "line {} of {text:?}", error.line);
            assert!(error.column >= 1 && !error.to_string().is_empty(), "{error:?}");
        }
    }
}
