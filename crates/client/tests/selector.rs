//! Reading restores the Channel Instance Selector, however the reading ended.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test")]

use profivac_client::records::{Interruption, RecordError, Records, RefusalCodes, UnrestoredRecord};
use profivac_client::{ClientError, Gauge};
use profivac_devices::catalog::model_named;
use profivac_devices::model::AccessPath;
use std::cell::RefCell;
use std::rc::Rc;

/// Slot and index of the Channel Instance Selector of a BCG450.
const SELECTOR: (u8, u8) = (1, 46);

/// Slot and index of Device State.
const DEVICE_STATE: (u8, u8) = (0, 25);

/// A gauge on a line that can be interrupted.
#[derive(Default)]
struct Line {
    selected: u8,
    /// The number of writes to the selector.
    writes: usize,
    /// No request is answered.
    is_lost: bool,
    /// The line is lost after this number of further requests.
    lost_after: Option<usize>,
    /// The gauge refuses records of this index.
    refused_index: Option<u8>,
    /// The part of the bus session that outlives a gauge.
    unrestored: Option<UnrestoredRecord>,
}

impl Line {
    fn request(&mut self) -> Result<(), RecordError> {
        if let Some(left) = &mut self.lost_after {
            self.is_lost |= *left == 0;
            *left = left.saturating_sub(1);
        }
        if self.is_lost { Err(Interruption::NoAnswer.into()) } else { Ok(()) }
    }
}

#[derive(Clone)]
struct Service(Rc<RefCell<Line>>);

impl Records for Service {
    fn via(&self) -> AccessPath {
        AccessPath::Class2
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        let mut line = self.0.borrow_mut();
        line.request()?;
        if line.refused_index == Some(index) {
            return Err(RecordError::Refused(RefusalCodes { code_1: None, code: 3 }));
        }
        Ok(match (slot, index) {
            SELECTOR => vec![line.selected],
            DEVICE_STATE => vec![2],
            _ => vec![0; 4],
        })
    }

    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        let mut line = self.0.borrow_mut();
        line.request()?;
        assert_eq!((slot, index), SELECTOR, "reading writes nothing else");
        line.selected = octets[0];
        line.writes += 1;
        Ok(())
    }

    fn keep_unrestored(&mut self, record: UnrestoredRecord) {
        self.0.borrow_mut().unrestored = Some(record);
    }

    fn take_unrestored(&mut self) -> Option<UnrestoredRecord> {
        self.0.borrow_mut().unrestored.take()
    }
}

fn line() -> Rc<RefCell<Line>> {
    Rc::new(RefCell::new(Line { selected: 1, ..Line::default() }))
}

fn gauge(line: &Rc<RefCell<Line>>) -> Gauge<Service> {
    let model = model_named("bcg450").unwrap();
    Gauge::with_model(Service(Rc::clone(line)), 5, model).with_unit(model.unit_named("mbar").unwrap())
}

/// Reads a parameter of instance 2, then one that fails, and leaves with `?` as a program does.
fn read_two(line: &Rc<RefCell<Line>>) -> Result<(), ClientError> {
    let mut gauge = gauge(line);
    gauge.read("ba.overrange")?;
    gauge.read("ba.underrange")?;
    Ok(())
}

#[test]
fn a_read_that_the_gauge_refuses_leaves_the_selector_at_the_original_instance() {
    let line = line();
    line.borrow_mut().refused_index = Some(model_index("ba.underrange"));
    let error = read_two(&line).unwrap_err();
    assert!(matches!(error, ClientError::Refused { .. }), "{error}");
    assert_eq!((line.borrow().selected, line.borrow().writes), (1, 2));
}

#[test]
fn a_read_without_errors_leaves_the_selector_at_the_original_instance() {
    let line = line();
    read_two(&line).unwrap();
    assert_eq!((line.borrow().selected, line.borrow().writes), (1, 2));
}

#[test]
fn a_gauge_without_instances_leaves_the_selector_alone() {
    let line = line();
    gauge(&line).read("device.device-state").unwrap();
    assert_eq!(line.borrow().writes, 0);
}

#[test]
fn a_panic_leaves_the_selector_at_the_original_instance() {
    let line = line();
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        let mut gauge = gauge(&line);
        gauge.read("ba.overrange").unwrap();
        panic!("a defect of the program");
    }));
    assert!(result.is_err());
    assert_eq!(line.borrow().selected, 1);
}

#[test]
fn the_next_gauge_restores_the_selector_when_the_line_was_lost_at_any_request() {
    for lost_after in 1..12 {
        let line = line();
        line.borrow_mut().lost_after = Some(lost_after);
        read_two(&line).ok();
        {
            let mut line = line.borrow_mut();
            (line.is_lost, line.lost_after) = (false, None);
        }
        gauge(&line).read("device.device-state").unwrap();
        assert_eq!(line.borrow().selected, 1, "lost after {lost_after} requests");
        assert_eq!(line.borrow().unrestored, None);
    }
}

#[test]
fn the_next_gauge_respects_a_selector_that_another_master_has_moved() {
    let line = line();
    line.borrow_mut().lost_after = Some(4);
    read_two(&line).unwrap_err();
    {
        let mut line = line.borrow_mut();
        assert_eq!(line.selected, 2, "the line was lost while instance 2 was selected");
        (line.is_lost, line.lost_after, line.selected) = (false, None, 3);
    }
    gauge(&line).read("device.device-state").unwrap();
    assert_eq!(line.borrow().selected, 3);
}

#[test]
fn a_gauge_that_is_dropped_respects_a_selector_that_another_master_has_moved() {
    let line = line();
    let mut gauge = gauge(&line);
    gauge.read("ba.overrange").unwrap();
    line.borrow_mut().selected = 3;
    drop(gauge);
    assert_eq!((line.borrow().selected, line.borrow().writes), (3, 1));
}

fn model_index(name: &'static str) -> u8 {
    let model = model_named("bcg450").unwrap();
    let names = profivac_client::names::ParameterNames::of(model);
    let named = names.all().iter().find(|named| named.name == name).expect("a parameter of the table");
    named.parameter.row.index
}
