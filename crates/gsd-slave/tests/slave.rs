//! Octets and places of a slave.

use profivac_dp::link::Baud;
use profivac_gsd::GsdFile;
use profivac_gsd_slave::{Direction, GsdSlave, Modules, Selection, SlaveError};
use std::sync::Arc;

fn slave(lines: &str, modules: &str) -> Result<GsdSlave, SlaveError> {
    let file = GsdFile::read(format!("#Profibus_DP\nModular_Station=1\nMax_Module=9\n{lines}\n").as_bytes());
    let modules = if modules.is_empty() { Modules::Preset } else { modules.parse().unwrap() };
    GsdSlave::new(Arc::new(file), &Selection { modules, changes: Vec::new() })
}

/// 1: two octets in; 2: one octet out and two words in, then one octet in; 3: without identifier; 4: two octets out.
const MODULES: &str = "Ident_Number=0x1234
Module=\"2DI\" 0x11\n1\nEndModule
Module=\"mixed\" 0xC0,0x80,0x41,0x10\n2\nEndModule
Module=\"power\"\n3\nEndModule
Module=\"2DO\" 0x21\n4\nEndModule";

#[test]
fn every_octet_belongs_to_a_module() {
    let slave = slave(MODULES, "1+3+2+4").unwrap();
    let layout = slave.layout();
    let data = |direction| -> Vec<_> {
        layout.data(direction).map(|data| (data.module.slot, data.start, data.octets)).collect()
    };
    assert_eq!(data(Direction::Input), [(1, 0, 2), (3, 2, 5)]);
    assert_eq!(data(Direction::Output), [(3, 0, 1), (4, 1, 2)]);
    assert_eq!(layout.name_of(Direction::Input, 6).as_deref(), Some("slot 3 mixed octet 4"));
    assert_eq!(layout.name_of(Direction::Input, 7), None);
    assert_eq!(layout.name_of(Direction::Output, 1).as_deref(), Some("slot 4 2DO octet 0"));
    assert_eq!((slave.lengths().inputs, slave.lengths().outputs), (7, 3));
}

#[test]
fn identifiers_are_counted_apart_from_modules() {
    let slave = slave(MODULES, "1+3+2+4").unwrap();
    let slot = |identifier| slave.layout().module_of_identifier(identifier).map(|module| module.slot);
    assert_eq!([0, 1, 2, 3, 4].map(slot), [Some(1), Some(3), Some(3), Some(4), None]);
    let areas = &slave.layout().in_slot(3).unwrap().areas;
    let widths: Vec<_> = areas.iter().map(|area| (area.identifier, area.words, area.consistent)).collect();
    assert_eq!(widths, [(1, false, true), (1, true, false), (2, false, false)]);
}

#[test]
fn the_octets_of_a_module_are_cut_from_an_image_and_missing_in_a_short_one() {
    let slave = slave(MODULES, "1+2").unwrap();
    let mixed = slave.layout().inputs().nth(1).unwrap();
    assert_eq!(mixed.of(&[0, 1, 2, 3, 4, 5, 6]), Some(&[2, 3, 4, 5, 6][..]));
    assert_eq!(mixed.of(&[0, 1, 2, 3, 4, 5]), None);
}

#[test]
fn a_dpv1_slave_has_the_three_octets_of_its_status() {
    let plain = slave(MODULES, "1").unwrap();
    assert!(plain.user_prm().is_empty() && !plain.is_dpv1());
    let dpv1 = slave(&format!("DPV1_Slave=1\n{MODULES}"), "1").unwrap();
    assert_eq!(dpv1.user_prm(), [0, 0, 0]);
    assert!(dpv1.parameters(9, Baud::B19200).dpv1);
    let own = format!("DPV1_Slave=1\nFail_Safe_required=1\nUser_Prm_Data_Len=4\nUser_Prm_Data=0x84,0,0,7\n{MODULES}");
    let own = slave(&own, "1").unwrap();
    assert_eq!(own.user_prm(), [0xC4, 0, 0, 7]);
    let parameters = own.parameters(9, Baud::B19200);
    assert!(parameters.fail_safe);
    let [first, second] = parameters.watchdog.unwrap();
    assert_eq!(u32::from(first) * u32::from(second), 1000, "in 1 ms, as WD_Base_1ms says");
}

#[test]
fn the_interval_and_the_late_diagnoses_are_the_files() {
    let lines = format!("Min_Slave_Intervall=20\nDiag_Update_Delay=3\nMax_Diag_Data_Len=32\n{MODULES}");
    let slave = slave(&lines, "1").unwrap();
    let parameters = slave.parameters(9, Baud::B500000);
    assert_eq!(parameters.min_interval_tbit, 1000, "2 ms at 500 kbit/s");
    assert_eq!((parameters.diag_update_delay, parameters.ident), (3, 0x1234));
    assert_eq!(slave.max_diag_len(), 32);
}

#[test]
fn a_file_without_ident_or_with_cut_identifiers_makes_no_slave() {
    assert_eq!(slave("Module=\"m\" 0x10\n1\nEndModule", "1").unwrap_err(), SlaveError::NoIdent);
    let cut = slave("Ident_Number=1\nModule=\"m\" 0xC0,0x80\n1\nEndModule", "1").unwrap_err();
    assert!(cut.to_string().contains("gsd check"), "{cut}");
}

#[test]
fn modules_and_parameters_are_there_again_after_the_configuration_is_gone() {
    let file = GsdFile::read(
        b"#Profibus_DP\nIdent_Number=1\nExtUserPrmData=1 \"p\"\nUnsigned8 0 0-9\nEndExtUserPrmData
Ext_User_Prm_Data_Ref(0)=1\nModule=\"m\" 0x10\n1\nEndModule\nModule=\"m\" 0x20\n1\nEndModule\n",
    );
    let second = profivac_gsd::Configuration::of(file.device(), vec![&file.device().modules[1]]).unwrap();
    assert_eq!(profivac_gsd::Configuration::again(file.device(), &second.chosen()).chk_cfg(), [0x20]);
    let selection = Selection { modules: "1".parse().unwrap(), changes: vec!["p=7".parse().unwrap()] };
    let slave = GsdSlave::new(Arc::new(file), &selection).unwrap();
    assert_eq!(slave.configuration().parameters()[0].value, 7);
}

/// The last identifier of the first module announces an octet that is the identifier of the second.
#[test]
fn a_module_whose_identifier_is_cut_does_not_take_octets_of_the_next_module() {
    let lines = "Ident_Number=1\nModule=\"cut\" 0x80\n1\nEndModule\nModule=\"2DO\" 0x21\n2\nEndModule";
    let error = slave(lines, "1+2").unwrap_err();
    assert!(matches!(error, SlaveError::Cfg(_)), "{error}");
    assert!(slave(lines, "2").is_ok());
}
