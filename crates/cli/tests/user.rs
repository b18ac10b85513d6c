//! `user`: manages the users of a station.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, all_shown_on_terminal, interrupted_on_terminal, run, run_with};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Output;

const PASSWORD: &str = "tin whisker plateau";

/// A folder with a station's file.
fn station_file() -> (Folder, String) {
    let folder = Folder::new();
    let file = folder.name("plant.toml");
    fs::write(&file, "[[segment]]\nname = \"a\"\nport = \"/dev/null\"\n").unwrap();
    (folder, file)
}

fn add(name: &str, role: &str, file: &str, password: &str) -> Output {
    run_with(&["user", "add", name, "--role", role, file, "--password-stdin"], password)
}

fn stderr_of(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn list(file: &str) -> String {
    String::from_utf8(run(&["user", "list", file]).stdout).unwrap()
}

#[test]
fn users_are_added_changed_and_removed() {
    let (folder, file) = station_file();
    let users = folder.path("plant.users.toml");
    assert!(stderr_of(&run(&["user", "list", &file])).contains("there are no users"));
    assert!(!users.exists());
    for (name, role) in [("ada", "engineer"), ("wall.1", "viewer")] {
        let added = add(name, role, &file, PASSWORD);
        assert!(added.status.success(), "{}", stderr_of(&added));
        assert_eq!(stderr_of(&added).contains("this is the first user"), name == "ada");
    }
    assert_eq!(list(&file), "ada     engineer\nwall.1  viewer\n");
    let text = fs::read_to_string(&users).unwrap();
    assert_eq!(text.matches("$argon2id$v=19$m=19456,t=2,p=1$").count(), 2);
    assert!(!text.contains("whisker"));
    assert_eq!(fs::metadata(&users).unwrap().permissions().mode() & 0o777, 0o600);
    assert!(run(&["user", "role", "ada", "operator", &file]).status.success());
    assert!(
        run_with(&["user", "password", "ada", &file, "--password-stdin"], "orchid ladder seventeen\r\n")
            .status
            .success()
    );
    let changed = fs::read_to_string(&users).unwrap();
    assert_eq!(changed.lines().zip(text.lines()).filter(|(new, old)| new != old).count(), 2);
    assert!(run(&["user", "remove", "wall.1", &file]).status.success());
    assert_eq!(list(&file), "ada  operator\n");
}

#[test]
fn a_wall_display_is_a_viewer_that_is_listed_and_removed() {
    let (folder, file) = station_file();
    assert!(add("ada", "engineer", &file, PASSWORD).status.success());
    let wall = run_with(&["user", "wall", "screen", &file, "--password-stdin"], PASSWORD);
    assert!(wall.status.success(), "{}", stderr_of(&wall));
    assert_eq!(list(&file), "ada     engineer\nscreen  viewer, wall display\n");
    let refused = run(&["user", "role", "screen", "operator", &file]);
    let sentence = "profivac: screen is a wall display, which stays logged in for a year: expected the role viewer\n";
    assert_eq!((refused.status.code(), stderr_of(&refused).as_str()), (Some(2), sentence));
    let twice = run_with(&["user", "wall", "Ada", &file, "--password-stdin"], PASSWORD);
    assert!(stderr_of(&twice).contains("there is already a user Ada"), "{}", stderr_of(&twice));
    let text = fs::read_to_string(folder.path("plant.users.toml")).unwrap();
    assert_eq!(text.matches("wall = true").count(), 1);
    assert!(run(&["user", "remove", "screen", &file]).status.success());
    assert_eq!(list(&file), "ada  engineer\n");
}

#[test]
fn a_user_is_added_whom_the_file_names_already() {
    for table in ["[epics.write]\nuser = \"ada\"\n", "[opcua]\nwrite = true\n"] {
        let (_folder, file) = station_file();
        let text = fs::read_to_string(&file).unwrap();
        fs::write(&file, format!("{text}{table}")).unwrap();
        let added = add("ada", "operator", &file, PASSWORD);
        assert!(added.status.success(), "{}", stderr_of(&added));
        assert_eq!(list(&file), "ada  operator\n");
    }
}

#[test]
fn a_refused_change_is_explained_and_changes_nothing() {
    let (folder, file) = station_file();
    let users = folder.path("plant.users.toml");
    for (name, role, password, sentence) in [
        ("ada", "engineer", "short", "expected a password of at least 8 characters, better 15, found 5"),
        ("ada", "engineer", "password1", "this password is easily guessed: this is a very common password"),
        ("lovelace", "engineer", "lovelace", "this password is easily guessed"),
        ("ada", "boss", PASSWORD, "expected viewer, operator or engineer"),
        (
            "a b",
            "viewer",
            PASSWORD,
            "expected a name of 1 to 32 letters (a to z), digits, dots, dashes and underscores, neither . nor .., found \"a b\"",
        ),
    ] {
        let refused = add(name, role, &file, password);
        assert_eq!(refused.status.code(), Some(2));
        assert!(stderr_of(&refused).contains(sentence), "{}", stderr_of(&refused));
        assert!(!users.exists(), "{sentence}");
    }
    assert!(add("ada", "viewer", &file, PASSWORD).status.success());
    let before = fs::read_to_string(&users).unwrap();
    assert!(stderr_of(&add("Ada", "viewer", &file, PASSWORD)).contains("there is already a user Ada"));
    for arguments in [vec!["remove", "eve"], vec!["role", "eve", "viewer"], vec!["password", "eve"]] {
        let refused = run(&[&["user"], &arguments[..], &[file.as_str()]].concat());
        assert_eq!(
            (refused.status.code(), stderr_of(&refused).as_str()),
            (Some(2), "profivac: there is no user \"eve\"\n")
        );
    }
    assert!(stderr_of(&run(&["user", "password", "ada", &file])).contains("add --password-stdin"));
    assert_eq!(fs::read_to_string(&users).unwrap(), before);
    fs::set_permissions(&users, fs::Permissions::from_mode(0o640)).unwrap();
    let refused = run(&["user", "list", &file]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        stderr_of(&refused).contains("plant.users.toml holds secrets and is open to others (mode 640): chmod 600 ")
    );
}

#[test]
fn a_password_is_asked_twice_on_the_terminal_without_echo() {
    let (folder, file) = station_file();
    let arguments = ["user", "add", "ada", "--role", "engineer", &file];
    let prompt = "Password for ada: ";
    let (code, shown) = all_shown_on_terminal(&arguments, prompt, &format!("{PASSWORD}\n{PASSWORD} \n"));
    assert_eq!(code, 2, "{shown}");
    assert!(shown.contains("the two passwords differ; nothing was changed") && !shown.contains("whisker"), "{shown}");
    assert!(!folder.path("plant.users.toml").exists());
    let (code, shown) = all_shown_on_terminal(&arguments, prompt, &format!("{PASSWORD}\n{PASSWORD}\n"));
    assert_eq!(code, 0, "{shown}");
    assert!(shown.starts_with("Password for ada: \r\nRepeat: \r\nprofivac: this is the first user"), "{shown}");
    assert_eq!(list(&file), "ada  engineer\n");
}

#[test]
fn an_interrupted_command_changes_nothing() {
    let (folder, file) = station_file();
    let (code, _, said) =
        interrupted_on_terminal(&["user", "add", "ada", "--role", "viewer", &file], "Password for ada: ");
    assert_eq!((code, folder.path("plant.users.toml").exists()), (3, false));
    assert!(said.contains("profivac: interrupted by a signal; nothing was changed"), "{said}");
}
