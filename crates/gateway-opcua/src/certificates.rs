//! The folder of the certificates: that of the station, and those of clients that are trusted or were rejected.
//!
//! ```text
//! own/cert.der        the certificate of the station, for clients
//! private/private.pem its key
//! trusted/            clients that may connect
//! rejected/           clients that tried; the newest 100
//! ```

use crate::OpcuaError;
use opcua_crypto::{CertificateStore, X509Data};
use profivac_files::{make_folder_private, make_private};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The days for which the certificate of the station is valid: ten years, because no user renews it on a machine.
const VALID_DAYS: u32 = 3650;

/// The size of the key in bits, which all offered policies permit.
const KEY_BITS: u32 = 2048;

/// The most rejected certificates that are kept: unknown clients must not fill the disk.
const MAX_REJECTED: usize = 100;

/// The certificate of the station, in the folder.
pub const OWN: &str = "own/cert.der";

/// Its key, in the folder.
pub const KEY: &str = "private/private.pem";

/// Makes the folder, and in it the key and the certificate of the station if both are absent. A key takes a second.
///
/// # Errors
/// When the folder cannot be written, or one of both files is absent: the other may be one that a site has installed.
pub fn prepare(folder: &Path, application_uri: &str, host: &str) -> Result<(), OpcuaError> {
    let failed =
        |error: std::io::Error| OpcuaError::Certificates { folder: folder.to_owned(), error: error.to_string() };
    for part in ["own", "private", "trusted", "rejected"] {
        fs::create_dir_all(folder.join(part)).map_err(failed)?;
    }
    make_folder_private(&folder.join("private")).map_err(failed)?;
    let (certificate, key) = (folder.join(OWN), folder.join(KEY));
    let missing = match (certificate.exists(), key.exists()) {
        (true, true) => return Ok(()),
        (false, false) => None,
        (false, true) => Some((OWN, KEY)),
        (true, false) => Some((KEY, OWN)),
    };
    if let Some((missing, found)) = missing {
        let error = format!("{missing} is missing beside {found}: add it, or remove {found} and both are made");
        return Err(OpcuaError::Certificates { folder: folder.to_owned(), error });
    }
    let made = CertificateStore::create_certificate_and_key(&data(application_uri, host), true, &certificate, &key);
    made.map_err(|error| OpcuaError::Certificates { folder: folder.to_owned(), error })?;
    make_private(&key).map_err(failed)
}

fn data(application_uri: &str, host: &str) -> X509Data {
    let host = host.trim_matches(['[', ']']).to_owned();
    X509Data {
        key_size: KEY_BITS,
        common_name: "profivac".to_owned(),
        organization: "profivac".to_owned(),
        organizational_unit: "station".to_owned(),
        // A user-assigned code of ISO 3166: the place of the station is not known.
        country: "XX".to_owned(),
        state: "none".to_owned(),
        // The host of the URLs, localhost and the name of this computer; no addresses, which would ask the network.
        alt_host_names: X509Data::alt_host_names(application_uri, Some(vec![host]), true, true, false),
        certificate_duration_days: VALID_DAYS,
    }
}

/// Deletes all but the newest rejected certificates.
pub fn prune(folder: &Path) {
    let Ok(files) = fs::read_dir(folder.join("rejected")) else { return };
    let age = |path: &Path| fs::metadata(path).and_then(|it| it.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
    let mut files: Vec<(SystemTime, PathBuf)> = files.flatten().map(|file| (age(&file.path()), file.path())).collect();
    files.sort();
    let old = files.len().saturating_sub(MAX_REJECTED);
    for (_, file) in files.into_iter().take(old) {
        // A file that cannot be deleted now is tried again.
        fs::remove_file(file).ok();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt as _;

    #[test]
    fn a_certificate_without_its_key_stays_and_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir_all(folder.path().join("own")).unwrap();
        fs::write(folder.path().join(OWN), "of the site").unwrap();
        let error = prepare(folder.path(), "urn:hall", "localhost").unwrap_err().to_string();
        assert!(error.contains("private/private.pem is missing beside own/cert.der"), "{error}");
        assert_eq!(fs::read(folder.path().join(OWN)).unwrap(), b"of the site");
    }

    #[test]
    fn only_the_newest_rejected_certificates_stay() {
        let folder = tempfile::tempdir().unwrap();
        let rejected = folder.path().join("rejected");
        fs::create_dir(&rejected).unwrap();
        for number in 0..MAX_REJECTED + 20 {
            let file = fs::File::create(rejected.join(format!("{number:03}.der"))).unwrap();
            let at = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(number as u64);
            file.set_modified(at).unwrap();
        }
        prune(folder.path());
        assert_eq!(fs::read_dir(&rejected).unwrap().count(), MAX_REJECTED);
        assert!(!rejected.join("019.der").exists() && rejected.join("020.der").exists());
    }

    #[test]
    fn the_key_is_readable_by_its_owner_only_and_stays() {
        let folder = tempfile::tempdir().unwrap();
        let prepare = || prepare(folder.path(), "urn:profivac:server:hall", "127.0.0.1").unwrap();
        prepare();
        let key = folder.path().join(KEY);
        assert_eq!(fs::metadata(&key).unwrap().permissions().mode() & 0o777, 0o600);
        let (before, certificate) = (fs::read(&key).unwrap(), fs::read(folder.path().join(OWN)).unwrap());
        prepare();
        assert_eq!((fs::read(&key).unwrap(), fs::read(folder.path().join(OWN)).unwrap()), (before, certificate));
    }
}
