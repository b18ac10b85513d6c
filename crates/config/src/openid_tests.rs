//! Tests of `[openid]` in the file of a station.

use profivac_station::config::Config;
use profivac_web_server::auth::openid::OpenIdSettings;
use profivac_web_server::auth::{Access, Role};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use tempfile::TempDir;

const SEGMENT: &str = "[[segment]]\nname = \"hall\"\nport = \"/dev/ttyUSB0\"\n";

const OPENID: &str = "[openid]\nissuer = \"https://login.example/realms/lab\"\nclient-id = \"profivac\"\n\
    client-secret-file = \"openid.secret\"\nroles-claim = \"realm_access.roles\"\n";

const ROLES: &str = "[openid.roles]\noperator = [\"vacuum\"]\nengineer = [\"vacuum-engineer\", \"staff of the lab\"]\n";

/// A folder with the secret.
fn folder(mode: u32) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("openid.secret");
    fs::write(&file, "s3cret: & more\n").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(mode)).unwrap();
    folder
}

fn parse(text: &str) -> Result<Config, String> {
    let folder = folder(0o600);
    let file = folder.path().join("hall.toml");
    crate::parse(text, &file).map_err(|error| error.to_string().replace(&file.display().to_string(), "hall.toml"))
}

#[test]
fn a_table_describes_a_provider() {
    let config = parse(&format!("{OPENID}{ROLES}{SEGMENT}")).unwrap();
    assert!(config.is_private(), "the file names a secret");
    assert!(matches!(config.access(), Access::Users(_)), "the users' file must exist");
    let settings = config.openid.unwrap();
    let OpenIdSettings { name, issuer, client_id, url, user_claim, roles_claim, scopes, .. } = &settings;
    assert_eq!((name.as_str(), issuer.as_str()), ("login.example", "https://login.example/realms/lab"));
    assert_eq!((client_id.as_str(), url), ("profivac", &None));
    assert_eq!((user_claim.as_str(), roles_claim.as_str()), ("preferred_username", "realm_access.roles"));
    assert_eq!(scopes, &["profile"]);
    assert_eq!(settings.client_secret.0, "s3cret: & more");
    let roles = [("vacuum", Role::Operator), ("vacuum-engineer", Role::Engineer), ("staff of the lab", Role::Engineer)];
    assert_eq!(settings.roles, roles.map(|(value, role)| (value.to_owned(), role)));
    assert!(!format!("{settings:?}").contains("s3cret"));
}

#[test]
fn wrong_values_are_errors_with_their_position() {
    let with = |line: &str| parse(&format!("{OPENID}{line}\n{ROLES}{SEGMENT}")).unwrap_err();
    let replaced = |old: &str, new: &str| parse(&format!("{OPENID}{ROLES}{SEGMENT}").replace(old, new)).unwrap_err();
    for issuer in [
        "http://login.example",
        "login.example",
        "https://",
        "https://a@login.example",
        "https://login.example?a",
        "https://login.example/#a",
        "ftp://login.example",
        "https://lög.example",
        "",
    ] {
        let error = replaced("https://login.example/realms/lab", issuer);
        assert!(error.starts_with("hall.toml:2:10: expected an issuer like https://"), "{issuer}: {error}");
    }
    for (line, expected) in [
        ("name = \"\"", "hall.toml:6:8: expected a name for the provider, found an empty string"),
        ("url = \"https://vacuum.example/dashboard\"", "hall.toml:6:7: expected the address of the dashboard like"),
        ("url = \"https://vacuum.example:443\"", "hall.toml:6:7: expected the address of the dashboard like"),
        ("url = \"http://vacuum.example\"", "hall.toml:6:7: expected the address of the dashboard like"),
        (
            "url = \"https://vacuum.example\"",
            "hall.toml:6:7: expected one of the names in hosts, found \"vacuum.example\"",
        ),
        ("user-claim = \"\"", "hall.toml:6:14: expected a claim of 1 to 255 visible ASCII characters, found \"\""),
        ("scopes = [\"a b\"]", "hall.toml:6:11: expected a scope of 1 to 255 visible ASCII characters, found \"a b\""),
        ("ca-file = \"none.pem\"", "none.pem cannot be read"),
        ("issuer-url = \"a\"", "hall.toml:6:1: unknown field `issuer-url`"),
    ] {
        let error = with(line);
        assert!(error.contains(expected), "{line}: {error}");
    }
    for (old, new, expected) in [
        ("\"profivac\"", "\"\"", "hall.toml:3:13: expected an identifier of 1 to 255 visible ASCII characters"),
        ("openid.secret", "none", "none cannot be read"),
        ("[\"vacuum\"]", "[\"vacuum-engineer\"]", "\"vacuum-engineer\" has two roles; delete one of both"),
        ("[\"vacuum\"]", "[\"a\\u0007\"]", "expected a value of the claim of 1 to 255"),
        ("engineer = [\"vacuum-engineer\", \"staff of the lab\"]\n", "boss = [\"a\"]\n", "unknown field `boss`"),
        ("roles-claim = \"realm_access.roles\"\n", "", "missing field `roles-claim`"),
    ] {
        let error = replaced(old, new);
        assert!(error.contains(expected), "{new}: {error}");
    }
    let none = parse(&format!("{OPENID}[openid.roles]\n{SEGMENT}")).unwrap_err();
    assert!(none.contains("expected in [openid.roles] at least one value"), "{none}");
    let long = with(&format!("name = \"{}\"", "x".repeat(121)));
    assert!(long.contains("6:8: expected a provider of at most 120 characters, found 121; shorten it"), "{long}");
}

#[test]
fn a_secret_that_others_can_read_is_refused() {
    let folder = folder(0o640);
    let error = crate::parse(&format!("{OPENID}{ROLES}{SEGMENT}"), &folder.path().join("hall.toml")).unwrap_err();
    assert!(
        error.to_string().contains("openid.secret is open to others (mode 640)")
            || error.to_string().contains("(mode 640): chmod 600"),
        "{error}"
    );
}

#[test]
fn the_address_is_one_under_which_the_station_answers() {
    let with = |station: &str, url: &str| {
        let url = if url.is_empty() { String::new() } else { format!("url = {url:?}\n") };
        parse(&format!("[station]\n{station}\n{OPENID}{url}{ROLES}{SEGMENT}")).map(|config| config.openid.unwrap().url)
    };
    let (hosts, public) = ("hosts = [\"vacuum.example\"]", "listen = \"0.0.0.0:8443\"");
    let found = |url: &str| Ok(Some(url.to_owned()));
    assert_eq!(with("", ""), Ok(None));
    assert_eq!(with("", "http://localhost:8080/"), found("http://localhost:8080"));
    assert_eq!(with(hosts, "https://vacuum.example"), found("https://vacuum.example"));
    assert_eq!(with(public, "https://any.example:8443"), found("https://any.example:8443"));
    for station in [hosts, public] {
        let error = with(station, "").unwrap_err();
        assert!(error.contains("expected url, the address of the dashboard"), "{station}: {error}");
    }
    for (station, url) in [(hosts, "https://other.example"), (public, "http://any.example:8443"), ("", "https://[::2]")]
    {
        with(station, url).unwrap_err();
    }
}
