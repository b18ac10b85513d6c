//! Files as the operating system protects, identifies and stores them: everything in which Linux and Windows differ.
//!
//! | | Unix | Windows |
//! |---|---|---|
//! | only the owner has access | mode 600 | an access list with owner, system and administrators |
//! | one file under two names | device and inode | volume and file number |
//! | a name is durable | the folder is written to the disk | the file system keeps it in its journal |

#[cfg(unix)]
#[path = "unix.rs"]
mod system;
#[cfg(windows)]
#[path = "windows.rs"]
mod system;

pub use system::{
    FileIdentity, access_of_others, free_octets, identity, is_folder_writable, keep_owner, make_folder_private,
    make_private, open_private, read_exact_at, stamp, synchronise,
};

/// What changes with the contents of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// The number of the file.
    file: Option<FileIdentity>,
    /// When it was changed last, since 1970.
    changed: Option<std::time::Duration>,
    /// Its size in octets.
    size: u64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, OpenOptions};
    use std::io::Write as _;

    #[test]
    fn a_private_file_gives_others_no_access() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("secret");
        let mut options = OpenOptions::new();
        open_private(options.write(true).create_new(true), &file).unwrap().write_all(b"x").unwrap();
        assert_eq!(access_of_others(&file).unwrap(), None);
        let open = folder.path().join("open");
        fs::write(&open, "x").unwrap();
        make_private(&open).unwrap();
        assert_eq!(access_of_others(&open).unwrap(), None);
    }

    #[test]
    fn a_file_has_one_identity_until_another_takes_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let (one, other) = (folder.path().join("one"), folder.path().join("other"));
        fs::write(&one, "x").unwrap();
        fs::write(&other, "x").unwrap();
        let first = identity(&one);
        assert!(first.is_some() && first == identity(&one) && first != identity(&other));
        fs::rename(&other, &one).unwrap();
        assert_ne!(identity(&one), first);
        assert_eq!(identity(&other), None);
    }

    #[test]
    fn a_stamp_changes_with_the_contents() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        assert_eq!(stamp(&file), None);
        fs::write(&file, "x").unwrap();
        let before = stamp(&file);
        assert_eq!(stamp(&file), before);
        fs::write(&file, "xy").unwrap();
        assert_ne!(stamp(&file), before);
    }

    #[test]
    fn octets_are_read_at_a_position_and_files_and_folders_become_durable() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "abcdef").unwrap();
        let mut octets = [0; 3];
        read_exact_at(&fs::File::open(&file).unwrap(), &mut octets, 2).unwrap();
        assert_eq!(&octets, b"cde");
        assert!(read_exact_at(&fs::File::open(&file).unwrap(), &mut octets, 4).is_err());
        synchronise(&file).unwrap();
        synchronise(folder.path()).unwrap();
        assert!(free_octets(folder.path()).is_some_and(|free| free > 0));
        assert!(is_folder_writable(folder.path()) && !is_folder_writable(&folder.path().join("none")));
    }
}
