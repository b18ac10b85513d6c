//! Records with another number of octets than the type of the parameter demands.

#![allow(clippy::unwrap_used, reason = "a test")]

use profivac_client::names::ParameterNames;
use profivac_client::records::{RecordError, Records};
use profivac_client::{ClientError, ErrorKind, Gauge, settings};
use profivac_devices::catalog::{MODELS, model_named};
use profivac_devices::model::{AccessPath, DataType, Direction, Length, Model, Unit};

/// Answers every read with this number of octets, or with the right number of them if it is `None`.
struct Answers {
    via: AccessPath,
    model: &'static Model,
    octets: Option<usize>,
}

impl Records for Answers {
    fn via(&self) -> AccessPath {
        self.via
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        let names = ParameterNames::shared(self.model);
        let data_type = names.at_index(slot, index).next().unwrap().parameter.row.data_type;
        Ok(vec![1; self.octets.unwrap_or_else(|| right_length(data_type))])
    }

    fn write(&mut self, _slot: u8, _index: u8, _octets: &[u8]) -> Result<(), RecordError> {
        Ok(())
    }
}

fn right_length(data_type: DataType) -> usize {
    match data_type.octets() {
        Length::Exactly(length) | Length::AtMost(length) => length.into(),
        Length::ByNumberType => 4,
    }
}

fn unit(model: &'static Model) -> &'static Unit {
    model.units.first().unwrap()
}

/// Every readable parameter of every device by every service; the unit is known and the location has one instance, so that
/// nothing else is read.
#[test]
fn a_record_of_another_length_is_refused_by_every_service() {
    for model in MODELS {
        for via in [AccessPath::Class2, AccessPath::Class1, AccessPath::ParameterChannel] {
            let mut gauge = Gauge::with_model(Answers { via, model, octets: None }, 5, model).with_unit(unit(model));
            for named in gauge.names().all().iter().filter(|named| named.parameter.location.instance == 0) {
                let row = named.parameter.row;
                if !row.access.allows(via, Direction::Read) || row.codes.is_command() {
                    continue;
                }
                for octets in [0, 1, 2, 3, 4, 5, 62, 240] {
                    gauge.records().octets = Some(octets);
                    let reading = gauge.read_parameter(named);
                    let allowed = row.data_type.octets().allows(octets);
                    assert_eq!(reading.is_ok(), allowed, "{} {named}, {octets} octets", model.name);
                    if let Err(error) = reading {
                        assert_eq!(error.kind(), ErrorKind::Refused, "{error}");
                        assert!(error.to_string().ends_with(&format!(", found {octets}")), "{error}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_boolean_of_62_octets_is_an_error_that_names_both_numbers() {
    let model = model_named("pcg550").unwrap();
    let answers = Answers { via: AccessPath::Class2, model, octets: Some(62) };
    let error = Gauge::with_model(answers, 5, model).read("trip-point.1/low-trip-enable").unwrap_err();
    assert_eq!(
        error.to_string(),
        "pcg550 at address 5, trip-point.1/low-trip-enable (slot 2, index 20): reading gave no value: expected 1 octet of BOOLEAN, found 62"
    );
}

#[test]
fn a_unit_a_selector_and_a_dump_of_another_length_are_no_values() {
    let model = model_named("bcg450").unwrap();
    let gauge = |octets| Gauge::with_model(Answers { via: AccessPath::Class2, model, octets }, 5, model);
    assert!(matches!(gauge(Some(62)).unit(), Err(ClientError::Malformed { .. })));
    assert!(matches!(gauge(Some(62)).read("1/46"), Err(ClientError::Malformed { .. })));
    assert!(matches!(gauge(Some(62)).read("ba.overrange"), Err(ClientError::Malformed { .. })));
    assert!(matches!(settings::dump(&mut gauge(Some(62))), Err(ClientError::Malformed { .. })));
    // With the right lengths, the same records are values.
    gauge(None).unit().unwrap();
    gauge(None).read("1/46").unwrap();
}
