//! Another master changes the unit while a program keeps its gauge.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_client::records::{RecordError, Records};
use profivac_client::{ClientError, Gauge};
use profivac_devices::catalog::model_named;
use profivac_devices::model::AccessPath;
use std::cell::RefCell;
use std::rc::Rc;

/// Slot and index of Data Units.
const DATA_UNITS: (u8, u8) = (1, 22);

/// A BCG450 whose pressures are all 100 Pa, and whose unit another master changes.
struct Line {
    unit: &'static str,
    /// The other master changes between these units before each pressure is read.
    changes: Vec<&'static str>,
    written: Vec<Vec<u8>>,
}

#[derive(Clone)]
struct Service(Rc<RefCell<Line>>);

impl Records for Service {
    fn via(&self) -> AccessPath {
        AccessPath::Class2
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        let mut line = self.0.borrow_mut();
        let model = model_named("bcg450").unwrap();
        Ok(match (slot, index) {
            DATA_UNITS => model.unit_named(line.unit).unwrap().code.to_be_bytes().to_vec(),
            // Channel Instance Selector, PV Selector, Reading Valid, Status Extension of instance and gauge.
            (1, 46 | 47 | 23) => vec![1],
            (1, 102 | 120) | (0, 26) => vec![0],
            _ => {
                if let Some(unit) = line.changes.pop() {
                    line.unit = unit;
                }
                let number: f32 = if line.unit == "mbar" { 1.0 } else { 100.0 };
                number.to_be_bytes().to_vec()
            }
        })
    }

    fn write(&mut self, _slot: u8, _index: u8, octets: &[u8]) -> Result<(), RecordError> {
        self.0.borrow_mut().written.push(octets.to_vec());
        Ok(())
    }
}

fn gauge() -> (Gauge<Service>, Rc<RefCell<Line>>) {
    let line = Rc::new(RefCell::new(Line { unit: "mbar", changes: Vec::new(), written: Vec::new() }));
    (Gauge::with_model(Service(Rc::clone(&line)), 5, model_named("bcg450").unwrap()), line)
}

#[test]
fn a_gauge_that_is_kept_follows_the_unit_that_another_master_sets() {
    let (mut gauge, line) = gauge();
    for unit in ["mbar", "Pascal", "mbar"] {
        line.borrow_mut().unit = unit;
        let pa = gauge.pressure().unwrap().pa.unwrap();
        assert!((pa - 100.0).abs() < 1e-9, "{pa} Pa in {unit}");
        assert_eq!(gauge.read("pirani.full-scale").unwrap().unit, Some(unit));
    }
}

#[test]
fn a_unit_that_changes_while_a_pressure_is_read_gives_no_wrong_pressure() {
    let (mut gauge, line) = gauge();
    line.borrow_mut().changes = vec!["Pascal"];
    assert!((gauge.pressure().unwrap().pa.unwrap() - 100.0).abs() < 1e-9);
    line.borrow_mut().changes = ["Pascal", "mbar"].repeat(5);
    let error = gauge.read("pirani.process-value").unwrap_err();
    assert!(matches!(error, ClientError::Unavailable { .. }), "{error}");
}

#[test]
fn a_value_that_was_prepared_in_another_unit_is_not_sent() {
    let (mut gauge, line) = gauge();
    let named = gauge.find("pirani.safe-value").unwrap();
    let write = gauge.prepare(&named, "1 mbar").unwrap();
    line.borrow_mut().unit = "Pascal";
    let error = gauge.execute(write).unwrap_err();
    assert!(matches!(error, ClientError::UnitChanged { prepared: "mbar", present: "Pascal", .. }), "{error}");
    assert!(line.borrow().written.is_empty());
}
