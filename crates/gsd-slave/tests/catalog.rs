//! Folders of files.

use profivac_gsd_slave::{Catalog, CatalogError, ChoiceError, MAX_OCTETS};
use std::fs;
use std::path::PathBuf;

const VALVE: &str = "#Profibus_DP\nVendor_Name = \"Acme\"\nModel_Name = \"Valve\"\nIdent_Number = 0x1234\n";

fn with(module: &str) -> String {
    format!("{VALVE}Module = \"m\" {module}\nEndModule\n")
}

fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    folder
}

fn read(folder: &tempfile::TempDir) -> Catalog {
    Catalog::read(&[folder.path().to_owned()]).unwrap()
}

#[test]
fn a_folder_is_read_with_its_folders_and_only_gsd_files() {
    let folder = folder(&[("a/VALVE.GSD", VALVE), ("b/readme.txt", VALVE), ("b/valve.gsdx", VALVE)]);
    let catalog = read(&folder);
    let [entry] = catalog.by_ident(0x1234) else { panic!("{catalog:?}") };
    assert_eq!(entry.path, folder.path().join("a/VALVE.GSD"));
    assert_eq!(entry.name(), "Acme Valve");
    assert!(catalog.by_ident(0x1235).is_empty());
}

#[test]
fn language_files_are_one_device_and_the_default_language_then_english_comes_first() {
    let german = VALVE.replace("Valve", "Ventil");
    let all = folder(&[("v.gsg", &german), ("V.GSE", VALVE), ("v.gsd", VALVE)]);
    let catalog = read(&all);
    let [entry] = catalog.by_ident(0x1234) else { panic!("{catalog:?}") };
    assert_eq!(entry.path, all.path().join("v.gsd"));
    assert_eq!(entry.others, [all.path().join("V.GSE"), all.path().join("v.gsg")]);

    let without_default = folder(&[("v.gsg", &german), ("v.gse", VALVE)]);
    assert_eq!(read(&without_default).by_ident(0x1234)[0].path, without_default.path().join("v.gse"));
}

#[test]
fn a_copy_in_another_folder_is_the_same_device() {
    let folder = folder(&[("a/v.gsd", VALVE), ("b/old.gsd", VALVE)]);
    let catalog = read(&folder);
    let entry = catalog.choose(0x1234, None).unwrap();
    assert_eq!(entry.others, [folder.path().join("b/old.gsd")]);
}

#[test]
fn two_devices_with_one_ident_are_both_named_and_get_cfg_tells_them_apart() {
    let folder = folder(&[("a.gsd", &with("0x10")), ("b.gsd", &with("0x20"))]);
    let catalog = read(&folder);
    assert_eq!(catalog.by_ident(0x1234).len(), 2);
    let error = catalog.choose(0x1234, None).unwrap_err().to_string();
    let names = ["a.gsd", "b.gsd"].map(|name| folder.path().join(name).display().to_string());
    assert!(names.iter().all(|name| error.contains(name)), "{error}");
    assert_eq!(catalog.choose(0x1234, Some(&[0x20])).unwrap().path, folder.path().join("b.gsd"));
    assert!(matches!(catalog.choose(0x1234, Some(&[0x11])), Err(ChoiceError::Several { .. })));
    assert_eq!(catalog.choose(0x4321, None).unwrap_err(), ChoiceError::Unknown(0x4321));
}

#[test]
fn a_file_of_a_folder_without_a_dp_slave_is_listed_and_a_named_one_is_refused() {
    let folder = folder(&[("a.gsd", VALVE), ("b.gsd", "#Profibus_FMS\nVendor_Name=\"x\"\n")]);
    let catalog = read(&folder);
    let [unread] = catalog.unread() else { panic!("{:?}", catalog.unread()) };
    assert_eq!(unread.path, folder.path().join("b.gsd"));
    let error = Catalog::read(std::slice::from_ref(&unread.path)).unwrap_err();
    assert!(error.to_string().contains("#Profibus_DP"), "{error}");
}

#[test]
fn a_file_beyond_the_limit_is_refused_and_one_at_the_limit_is_not() {
    let folder = folder(&[("a.gsd", VALVE)]);
    let path = folder.path().join("a.gsd");
    let file = fs::OpenOptions::new().append(true).open(&path).unwrap();
    file.set_len(MAX_OCTETS).unwrap();
    assert!(Catalog::read(std::slice::from_ref(&path)).is_ok());
    file.set_len(MAX_OCTETS + 1).unwrap();
    let error = Catalog::read(&[path]).unwrap_err().to_string();
    assert!(error.contains("at most 16 MiB"), "{error}");
}

#[test]
fn a_missing_file_and_an_empty_folder_are_errors_with_the_path() {
    let missing = PathBuf::from("missing.gsd");
    assert!(
        matches!(Catalog::read(std::slice::from_ref(&missing)), Err(CatalogError::Read { path, .. }) if path == missing)
    );
    let folder = folder(&[("readme.txt", "")]);
    let path = folder.path().to_owned();
    assert_eq!(Catalog::read(std::slice::from_ref(&path)).unwrap_err(), CatalogError::Empty { path });
}

#[cfg(unix)]
#[test]
fn links_to_the_folder_above_are_read_once() {
    let folder = folder(&[("a.gsd", VALVE)]);
    for name in ["above", "again", "once-more"] {
        std::os::unix::fs::symlink(folder.path(), folder.path().join(name)).unwrap();
    }
    let catalog = read(&folder);
    let [entry] = catalog.by_ident(0x1234) else { panic!("{catalog:?}") };
    assert_eq!(entry.others, [] as [PathBuf; 0]);
}

/// Reading a pipe would wait for its writer.
#[cfg(unix)]
#[test]
fn a_pipe_with_the_name_of_a_gsd_file_is_not_read() {
    let folder = folder(&[("a.gsd", VALVE)]);
    let socket = std::os::unix::net::UnixListener::bind(folder.path().join("b.gsd")).unwrap();
    let catalog = read(&folder);
    assert_eq!((catalog.by_ident(0x1234).len(), catalog.unread().len()), (1, 0));
    drop(socket);
}

#[test]
fn more_than_20000_files_are_refused() {
    let folder = folder(&[("a.gsd", VALVE)]);
    let path = folder.path().to_owned();
    (0..20_000).for_each(|number| drop(fs::File::create(path.join(format!("{number}.gsd"))).unwrap()));
    let error = Catalog::read(std::slice::from_ref(&path)).unwrap_err();
    assert_eq!(error, CatalogError::TooMany { path: path.clone() });
    fs::remove_file(path.join("0.gsd")).unwrap();
    assert_eq!(read(&folder).by_ident(0x1234).len(), 1);
}

/// The files are sparse, and none of them is read.
#[test]
fn files_of_more_than_256_mib_together_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let files: Vec<_> = (0..17).map(|number| folder.path().join(format!("{number}.gsd"))).collect();
    for path in &files {
        fs::File::create(path).unwrap().set_len(MAX_OCTETS).unwrap();
    }
    let path = folder.path().to_owned();
    assert_eq!(Catalog::read(std::slice::from_ref(&path)).unwrap_err(), CatalogError::TooLarge { path });
}
