//! The GSD files of the devices, as an engineering tool gets them.

use crate::golden;
use profivac_client::gsd::files;
use profivac_devices::catalog::MODELS;

#[test]
fn the_gsd_files_change_only_on_purpose() {
    let written = MODELS.iter().filter_map(|model| files(model).into_iter().next());
    let texts: Vec<_> = written.map(|(_, octets)| String::from_utf8_lossy(&octets).into_owned()).collect();
    assert_eq!(texts.len(), MODELS.len());
    golden::compare("crates/client/tests/golden/gsd.txt", &texts.concat());
}
