//! The gauge as a master sees it: exchange, parameters, nonvolatile values, and its GSD file.

use example_gauge::table::MODEL;
use example_gauge::{ExampleGauge, example_gauge};
use profivac_devices::model::Fault;
use profivac_devices::profile::Setup;
use profivac_devices::store::RamStore;
use profivac_devices::{Action, SimulatedDevice};
use profivac_dp::slave::{Device, Relation};

const CFG: &[u8] = &[0x41, 0x83, 0x08];
const PRM_MBAR: &[u8] = &[0x80, 0, 0, 5, 0x1C];
const SLOT: u8 = 1;
const READING_VALID: u8 = 23;
const SAFE_VALUE: u8 = 40;
const HEATER: u8 = 60;
const FILTER: u8 = 61;

fn gauge(store: RamStore) -> ExampleGauge<RamStore> {
    example_gauge(store, Setup::new(5))
}

fn read(gauge: &mut ExampleGauge<RamStore>, index: u8) -> Vec<u8> {
    let mut record = [0; 64];
    let length = gauge.read(Relation::Ms2(0), SLOT, index, &mut record).unwrap();
    record[..length].to_vec()
}

#[test]
fn a_master_parameterises_it_and_gets_its_pressure() {
    let mut gauge = gauge(RamStore::default());
    gauge.set_prm(PRM_MBAR).unwrap();
    assert_eq!(gauge.chk_cfg(CFG).unwrap().inputs, 4);
    gauge.sense(0, 1234.0);
    let mut inputs = [0; 4];
    gauge.inputs(&mut inputs);
    assert_eq!(f32::from_be_bytes(inputs), 12.34);
}

#[test]
fn a_value_of_a_master_survives_a_power_cut() {
    let mut gauge = gauge(RamStore::default());
    gauge.write(Relation::Ms2(0), SLOT, FILTER, &[0x01, 0xF4]).unwrap();
    gauge.write(Relation::Ms2(0), SLOT, SAFE_VALUE, &2.5f32.to_be_bytes()).unwrap();
    assert!(gauge.write(Relation::Ms2(0), SLOT, FILTER, &[0x03, 0xE9]).is_err(), "1001 ms is too long");
    gauge.set_power(false);
    gauge.set_power(true);
    assert_eq!(read(&mut gauge, FILTER), [0x01, 0xF4]);
    assert_eq!(read(&mut gauge, SAFE_VALUE), 2.5f32.to_be_bytes());
}

#[test]
fn a_broken_wire_and_a_cold_one_are_no_valid_reading() {
    let mut gauge = gauge(RamStore::default());
    gauge.sense(0, 1234.0);
    assert_eq!(read(&mut gauge, READING_VALID), [1]);
    gauge.operate(Action::Fault { fault: Fault::Sensor1, active: true }).unwrap();
    assert!(gauge.has_alarm());
    assert_eq!(read(&mut gauge, READING_VALID), [0]);
    gauge.operate(Action::Fault { fault: Fault::Sensor1, active: false }).unwrap();
    gauge.write(Relation::Ms1, SLOT, HEATER, &[0]).unwrap();
    assert_eq!(read(&mut gauge, READING_VALID), [0]);
    assert!(!gauge.has_alarm());
}

#[test]
fn its_gsd_file_has_its_ident_number_and_its_configuration() {
    let gsd = profivac_client::gsd::gsd(&MODEL);
    assert!(gsd.contains("0xFFFE"), "{gsd}");
    assert!(gsd.contains("0x41,0x83,0x08") || gsd.contains("0x41, 0x83, 0x08"), "{gsd}");
}
