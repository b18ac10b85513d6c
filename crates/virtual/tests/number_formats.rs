//! Every number format of every device over its range, in every unit: no reading is valid and wrong.
//!
//! An integer is truncated to whole units and saturated (errata-bpg-bcg-tpg 69 and 70, errata-pxg55x-img400 16), so each reading of an
//! integer is compared with that of the same telegram with floats.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use profivac_client::Gauge;
use profivac_client::cyclic::{Cause, ChannelValue, CyclicSlave, ReportedChannels, unranged_instances};
use profivac_client::pressure::Pressure;
use profivac_client::records::{RecordError, Records, RefusalCodes};
use profivac_devices::catalog::MODELS;
use profivac_devices::model::{
    AccessPath, Configuration, Counts, Direction, Field, Model, NumberType, PressureFormat, Role, Scale, Unit,
};
use profivac_devices::reading::Quality;
use profivac_dp::link::Baud;
use profivac_dp::slave::{Outputs, Relation};
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::DeviceSpec;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use std::collections::BTreeSet;

const BAUD: Baud = Baud::B1500000;
const ADDRESS: u8 = 5;

/// A valid reading differs from the true pressure by this part at most: the coarsest count, and the sensors.
const TOLERANCE: f64 = 0.02;

/// A gauge in EXECUTING with a configuration and a unit.
struct Measuring {
    device: VirtualDevice,
    slave: CyclicSlave,
}

fn around(mbar: f64) -> GasConditions {
    let [pressure, atmosphere] = [mbar, 1013.25].map(Pressure::from_mbar);
    GasConditions { pressure, atmosphere, gas: Gas::N2 }
}

impl Measuring {
    fn new(model: &'static Model, configuration: &'static Configuration, unit: &'static Unit) -> Self {
        let mut measuring = Self::idle(model, configuration, unit);
        let simulated = measuring.device.device_mut();
        simulated.set_exchanging(true);
        simulated.outputs(Outputs::Data(&vec![0; configuration.output_octets()]));
        if model.name == "img400" {
            (1..=2).for_each(|slot| simulated.write(Relation::Ms2(0), slot, 14, &[3, 1]).unwrap());
        }
        simulated.settle();
        measuring
    }

    /// The gauge with its parameters and configuration, before the first exchange.
    fn idle(model: &'static Model, configuration: &'static Configuration, unit: &'static Unit) -> Self {
        let spec: DeviceSpec = format!("{}@{ADDRESS}:unit={}", model.name, unit.name).parse().unwrap();
        let built = spec.build(NonvolatileMemory::volatile(), BAUD).unwrap();
        let mut device = VirtualDevice::new(built, ADDRESS, BAUD, around(1e-6)).with_external_time();
        let channels = ReportedChannels::of_parts(model, device.ranges());
        let slave = CyclicSlave { address: ADDRESS, model, configuration, unit, channels };
        let is_prm = |code| model.user_prm.iter().find(move |prm| prm.unit_code() == code);
        let prm = if configuration.is_ttr() { is_prm(0) } else { is_prm(unit.code).or(is_prm(0)) };
        let simulated = device.device_mut();
        simulated.set_prm(prm.unwrap().octets).unwrap();
        simulated.chk_cfg(configuration.octets).unwrap();
        simulated.settle();
        Self { device, slave }
    }

    fn at(&mut self, mbar: f64) -> Vec<ChannelValue> {
        self.device.advance_in(around(mbar), 1.0);
        self.device.settle_in(around(mbar));
        self.device.device_mut().settle();
        let mut inputs = vec![0; self.slave.configuration.input_octets()];
        self.device.device_mut().inputs(&mut inputs);
        self.slave.decode_inputs(&inputs).values
    }
}

/// The pressures of a sweep in mbar: the whole range and beyond, and both ends of every integer format in every unit.
fn pressures(model: &Model) -> Vec<f64> {
    let decades = (-13..4).flat_map(|power| [1.0, 2.3, 5.1].map(|digit| digit * 10_f64.powi(power)));
    let ranges = model.parts.iter().flat_map(|spec| [spec.limits.under_pa, spec.limits.over_pa]);
    let around_ends = |mbar: f64| [mbar * (1.0 - 1e-6), mbar, mbar * (1.0 + 1e-6)];
    let of_units = model.units.iter().filter_map(|unit| match unit.scale {
        Scale::PerMbar(per_mbar) => Some(per_mbar),
        Scale::Counts => None,
    });
    let highest = f64::from(model.max_integer);
    let integers = of_units.flat_map(move |per_mbar| {
        let units =
            [1e-3, 0.5, 0.999, 1.0, 1.001, 2.0, highest - 1.0, highest - 0.5, highest, highest + 0.5, highest + 1.0];
        units.map(|number| number / per_mbar)
    });
    let named = [0.0, 900.0, 1013.25, 327.67, 655.35];
    decades.chain(ranges.flat_map(|pa| around_ends(pa / 100.0))).chain(integers).chain(named).collect()
}

/// The same telegrams with floats.
fn with_floats(configuration: &'static Configuration, model: &'static Model) -> &'static Configuration {
    let float = |field: &Field| match *field {
        Field::ProcessValue(_) => Field::ProcessValue(NumberType::Float),
        Field::ChannelValue(channel, _) => Field::ChannelValue(channel, NumberType::Float),
        field => field,
    };
    let wanted: Vec<Field> = configuration.inputs.unwrap().fields.iter().map(float).collect();
    let is_wanted = |other: &&Configuration| {
        other.outputs == configuration.outputs && other.inputs.is_some_and(|inputs| inputs.fields == wanted)
    };
    model.configurations.iter().find(is_wanted).unwrap()
}

/// The number that an integer would show if it had fraction and no ends.
fn number(slave: &CyclicSlave, value: &ChannelValue, pa: f64) -> (f64, bool) {
    let mut parts = slave.model.parts.iter();
    let counts = parts.find(|spec| value.instance == 0 || spec.part.instance == value.instance).unwrap().counts;
    let format = PressureFormat { unit: slave.unit, number: NumberType::Float, counts, max_integer: u16::MAX };
    let is_log = slave.unit.scale == Scale::Counts && matches!(counts, Counts::Log { .. });
    (format.number_from_pa(pa), is_log)
}

/// A valid reading is the true pressure, and a bound is one of it. A gauge without a range in the tables, and a telegram that does not name
/// its part, have a quality without a bound where the number is no pressure.
fn assert_true(model: &Model, value: &ChannelValue, mbar: f64, unit_pa: f64, context: &str) {
    let true_pa = mbar * 100.0;
    match (value.quality, value.pa, value.limit_pa) {
        (Quality::Valid, Some(pa), None) => {
            let (low, high) = (pa * (1.0 - TOLERANCE), (pa + unit_pa) * (1.0 + TOLERANCE));
            assert!((low..=high).contains(&true_pa), "valid and wrong: {context}");
        }
        (Quality::Overrange, None, Some(limit)) => assert!(true_pa >= limit * (1.0 - TOLERANCE), "{context}"),
        (Quality::Underrange, None, Some(limit)) => assert!(true_pa <= limit * (1.0 + TOLERANCE), "{context}"),
        (Quality::Overrange | Quality::Underrange, None, None) => assert!(!has_range(model, value), "{context}"),
        (Quality::Valid | Quality::Overrange | Quality::Underrange, ..) => {
            panic!("no pressure and no bound: {context}")
        }
        (_, pa, limit_pa) => assert_eq!((pa, limit_pa), (None, None), "{context}"),
    }
}

/// Whether the tables have the range of the part.
fn has_range(model: &Model, value: &ChannelValue) -> bool {
    model.parts.iter().any(|spec| spec.part.instance == value.instance)
        && !unranged_instances(model).contains(&value.instance)
}

/// As [`assert_true`], and a gauge that measures has no fault. Without a status of the value, an alarm or warning of the device leaves open
/// whether it concerns the value.
fn assert_measured(slave: &CyclicSlave, value: &ChannelValue, mbar: f64, unit_pa: f64, context: &str) {
    assert_true(slave.model, value, mbar, unit_pa, context);
    let is_status = |field: &Field| {
        matches!(field, Field::StatusExtension | Field::ChannelStatus | Field::MeasurementStatus(_) | Field::TtrValue)
    };
    let has_status = slave.configuration.inputs.unwrap().fields.iter().any(is_status);
    let is_open = !has_status && matches!(value.cause, Some(Cause::NoStatus | Cause::Alarms(_)));
    assert!(value.quality != Quality::Fault || is_open, "{context}");
}

/// One unit in Pa; 0 in COUNTS, whose truncation the tolerance covers.
fn unit_pa(slave: &CyclicSlave) -> f64 {
    match (slave.unit.scale, slave.configuration.number()) {
        (Scale::PerMbar(per_mbar), Some(NumberType::Integer)) => 100.0 / per_mbar,
        _ => 0.0,
    }
}

/// The configurations of a model with different inputs that have a pressure.
fn configurations(model: &'static Model) -> Vec<&'static Configuration> {
    let mut found: Vec<&Configuration> = Vec::new();
    let has_value = |configuration: &&Configuration| {
        let is_value = |field: &Field| {
            matches!(
                field,
                Field::ProcessValue(_) | Field::ChannelValue(..) | Field::ChannelMantissa(_) | Field::TtrValue
            )
        };
        configuration.inputs.is_some_and(|inputs| inputs.fields.iter().any(is_value))
    };
    for configuration in model.configurations.iter().filter(has_value) {
        if !found.iter().any(|other| other.inputs == configuration.inputs) {
            found.push(configuration);
        }
    }
    found
}

#[test]
fn no_reading_of_any_format_is_valid_and_wrong() {
    let (mut valid, mut formats) = (0, 0);
    for model in MODELS {
        for configuration in configurations(model) {
            for unit in model.units {
                let mut measuring = Measuring::new(model, configuration, unit);
                let unit_pa = unit_pa(&measuring.slave);
                for mbar in pressures(model) {
                    for value in measuring.at(mbar) {
                        let octets = configuration.octets;
                        let context =
                            format!("{} {octets:02X?} in {} at {mbar} mbar: {value:?}", model.name, unit.name);
                        assert_measured(&measuring.slave, &value, mbar, unit_pa, &context);
                        valid += usize::from(value.is_valid());
                    }
                }
                formats += 1;
            }
        }
    }
    assert!(formats > 300 && valid > 5000, "{formats} formats, {valid} valid readings");
}

/// A gauge that does not measure shows its Safe Value, here 0, and inputs that no gauge has filled are zeros.
#[test]
fn no_number_of_a_gauge_that_does_not_measure_is_a_pressure_or_a_bound() {
    let mut seen = 0;
    for model in MODELS.iter().filter(|model| !model.parts.is_empty()) {
        for (configuration, unit) in
            configurations(model).into_iter().flat_map(|it| model.units.iter().map(move |unit| (it, unit)))
        {
            let mut idle = Measuring::idle(model, configuration, unit);
            let context = |value: &ChannelValue| {
                format!("{} {:02X?} in {}: {value:?}", model.name, configuration.octets, unit.name)
            };
            for value in idle.slave.decode_inputs(&vec![0; configuration.input_octets()]).values {
                assert_eq!(
                    (value.quality, value.cause),
                    (Quality::Fault, Some(Cause::NoPressure)),
                    "{}",
                    context(&value)
                );
            }
            for mbar in [1e-6, 5e-3, 0.5, 40.0, 1013.25] {
                for value in idle.at(mbar) {
                    assert_true(model, &value, mbar, 0.0, &context(&value));
                    assert!(!value.is_valid(), "{}", context(&value));
                    let is_of_number = matches!(value.cause, Some(Cause::HighestInteger | Cause::BelowOneUnit));
                    assert!(!is_of_number, "{}", context(&value));
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 2000, "{seen}");
}

/// The quality and the bound of an integer whose telegram with floats has this reading.
fn expected_of(float: &ChannelValue, number: f64, is_log: bool, max: f64) -> (Quality, Option<Cause>) {
    match float.quality {
        Quality::Valid if number >= max => (Quality::Overrange, Some(Cause::HighestInteger)),
        Quality::Valid if number < 1.0 && !is_log => (Quality::Underrange, Some(Cause::BelowOneUnit)),
        quality => (quality, float.cause),
    }
}

/// An integer shows what the float beside it shows, or the end of its format.
#[test]
fn an_integer_is_valid_between_its_ends_and_out_of_range_at_them() {
    let mut ends = Vec::new();
    for model in MODELS {
        let integers = configurations(model).into_iter().filter(|it| it.number() == Some(NumberType::Integer));
        for (configuration, unit) in integers.flat_map(|it| model.units.iter().map(move |unit| (it, unit))) {
            let mut integer = Measuring::new(model, configuration, unit);
            let mut float = Measuring::new(model, with_floats(configuration, model), unit);
            let (mut highest, mut lowest) = (0, 0);
            for mbar in pressures(model) {
                let (of_integers, of_floats) = (integer.at(mbar), float.at(mbar));
                assert_eq!(of_integers.len(), of_floats.len());
                for (of_integer, of_float) in of_integers.into_iter().zip(of_floats) {
                    let octets = configuration.octets;
                    let context = format!(
                        "{} {octets:02X?} in {} at {mbar} mbar: {of_integer:?}, with floats {of_float:?}",
                        model.name, unit.name
                    );
                    let found = (of_integer.quality, of_integer.cause);
                    let Some(float_pa) = of_float.pa else {
                        assert_eq!(found, (of_float.quality, of_float.cause), "{context}");
                        assert_true(model, &of_integer, mbar, 0.0, &context);
                        let is_known = has_range(model, &of_float);
                        assert!(!is_known || of_integer.limit_pa == of_float.limit_pa, "{context}");
                        continue;
                    };
                    let max = f64::from(model.max_integer);
                    let (shown, is_log) = number(&integer.slave, &of_float, float_pa);
                    // A float of 32 bits may be rounded across an end, and an integer by a millionth of a unit.
                    let slack = 2e-6 + 2e-7 * shown;
                    let allowed =
                        [shown - slack, shown, shown + slack].map(|it| expected_of(&of_float, it, is_log, max));
                    assert!(allowed.contains(&found), "expected {allowed:?}: {context}");
                    let one_pa = 100.0 / if let Scale::PerMbar(per_mbar) = unit.scale { per_mbar } else { 1.0 };
                    match of_integer.quality {
                        Quality::Overrange => {
                            assert_eq!(of_integer.pa, None, "{context}");
                            assert!((of_integer.limit_pa.unwrap() / (max * one_pa) - 1.0).abs() < 1e-9, "{context}");
                            highest += 1;
                        }
                        Quality::Underrange => {
                            assert_eq!(of_integer.pa, None, "{context}");
                            let ratio = of_integer.limit_pa.unwrap() / one_pa;
                            assert!(unit.scale == Scale::Counts || (ratio - 1.0).abs() < 1e-9, "{context}");
                            lowest += 1;
                        }
                        _ => {
                            // Truncated to whole units: at most one unit below the float.
                            let (held, _) = number(&integer.slave, &of_integer, of_integer.pa.unwrap());
                            assert!((held - slack..=held + 1.0 + slack).contains(&shown), "{held} {shown}: {context}");
                            assert_eq!(of_integer.limit_pa, None, "{context}");
                        }
                    }
                }
            }
            ends.push((model.name, unit.name, highest > 0, lowest > 0));
        }
    }
    ends.sort_unstable();
    ends.dedup();
    let reached = |name: &str, unit_name: &str| {
        let of_both = ends.iter().filter(|(model, unit, ..)| *model == name && *unit == unit_name);
        let reached = of_both.map(|(_, _, highest, lowest)| (*highest, *lowest));
        reached.reduce(|one, other| (one.0 || other.0, one.1 || other.1))
    };
    for model in MODELS.iter().filter(|model| !model.parts.is_empty()) {
        assert_eq!(reached(model.name, "Pascal"), Some((true, true)), "{}", model.name);
        let mbar = model.unit_named("mbar").unwrap().name;
        assert_eq!(reached(model.name, mbar), Some((false, true)), "{}", model.name);
        assert!(reached(model.name, "COUNTS").is_none_or(|(highest, _)| !highest), "{}", model.name);
    }
    assert_eq!(reached("bcg450", "Micron"), Some((true, true)));
}

/// The records of a device, without a bus.
struct Direct<'a>(&'a mut VirtualDevice, AccessPath);

impl Records for Direct<'_> {
    fn via(&self) -> AccessPath {
        self.1
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        let mut record = [0; 240];
        let relation = if self.1 == AccessPath::Class1 { Relation::Ms1 } else { Relation::Ms2(0) };
        match self.0.device_mut().read(relation, slot, index, &mut record) {
            Ok(length) => Ok(record[..length].to_vec()),
            Err(error) => Err(RecordError::Refused(RefusalCodes { code_1: None, code: error.code_2 })),
        }
    }

    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        self.0.device_mut().write(Relation::Ms2(0), slot, index, octets).unwrap();
        Ok(())
    }
}

/// The pressures of all parts over MS1 and MS2, with the data type integer.
#[test]
fn no_process_value_that_is_read_as_an_integer_is_valid_and_wrong() {
    let (mut seen, mut refused) = (Vec::new(), BTreeSet::new());
    for model in MODELS.iter().filter(|model| model.features.dpv1) {
        let configuration =
            configurations(model).into_iter().find(|it| it.number() == Some(NumberType::Integer)).unwrap();
        for unit in model.units {
            let mut measuring = Measuring::new(model, configuration, unit);
            let unit_pa = unit_pa(&measuring.slave);
            for mbar in [0.0, 1e-12, 5e-6, 0.5e-2, 0.5, 0.9, 40.0, 44.0, 327.66, 327.68, 656.0, 900.0, 1013.25] {
                measuring.at(mbar);
                for via in [AccessPath::Class1, AccessPath::Class2] {
                    let mut gauge =
                        Gauge::with_model(Direct(&mut measuring.device, via), ADDRESS, model).with_unit(unit);
                    let names = gauge.names();
                    for named in names.all() {
                        let location = named.parameter.location;
                        let instance = if location.instance > 0 { location.instance } else { location.slot };
                        let part = model.parts.iter().find(|spec| spec.part.instance == instance);
                        let is_value = named.parameter.row.role == Some(Role::ProcessValue);
                        let is_ambient = named.name.starts_with("atm");
                        let is_readable = named.parameter.row.access.allows(via, Direction::Read);
                        if !is_value || part.is_none() || is_ambient || !is_readable {
                            continue;
                        }
                        let value = match gauge.pressure_of(named) {
                            Ok(value) => value,
                            Err(error) => {
                                refused.insert(format!("{} {via:?} {named}: {error}", model.name));
                                continue;
                            }
                        };
                        let context = format!("{} {named} in {} at {mbar} mbar: {value:?}", model.name, unit.name);
                        assert_true(model, &value, mbar, unit_pa, &context);
                        assert_ne!(value.quality, Quality::Fault, "{context}");
                        seen.push((model.name, unit.scale, value.cause));
                    }
                }
            }
        }
    }
    assert_eq!(refused, BTreeSet::new());
    let has = |wanted| assert!(seen.contains(&wanted), "{wanted:?}");
    for model in ["bcg450", "bpg400", "hpg400", "pcg550", "psg554", "img400"] {
        has((model, Scale::PASCAL, Some(Cause::HighestInteger)));
        has((model, Scale::MBAR, Some(Cause::BelowOneUnit)));
    }
}
