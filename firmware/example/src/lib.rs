//! A Pirani gauge of one's own, outside the project: a table, and the behaviour behind it.
//!
//! | File | Contents |
//! |---|---|
//! | [`table`] | the table: parameters, telegrams, units, ident number, and what the GSD file needs |
//! | this file | the state of the gauge, and the value of each row |
#![no_std]
#![forbid(unsafe_code)]

pub mod table;

use profivac_devices::model::{
    AccessError, Fault, Field, Location, MeasuringRange, Model, Octets, Part, PressureFormat, Value,
};
use profivac_devices::profile::{
    Behaviour, BlockDevice, InputRow, MeasuringPart, ParameterAccess, ParameterRef, Presentation, ReadingCondition,
    SerialNumber, Setup,
};
use profivac_devices::store::Store;
use profivac_devices::{Drive, FrontPanel, StateReport};
use table::{COUNTS, DeviceBlock, FACTORY_UNIT, Faults, Heater, MODEL, PART, Parameter, Pressure};

/// The gauge with its nonvolatile memory `S`.
pub type ExampleGauge<S> = BlockDevice<Example, S>;

/// A gauge that has just been switched on.
#[must_use]
pub fn example_gauge<S: Store>(store: S, setup: Setup) -> ExampleGauge<S> {
    ExampleGauge::from_behaviour(Example::new(setup.serial), store, &setup)
}

/// It measures whenever it has power.
const MEASURING: ReadingCondition = ReadingCondition { executing: true, disturbed: false, alarmed: false };

static PARTS: [Part; 1] = [PART.part];

static FRONT_PANEL: FrontPanel = FrontPanel { switches: &[], buttons: 0, potentiometers: &[] };

/// The behaviour of the gauge.
#[derive(Clone, Debug)]
pub struct Example {
    serial: SerialNumber,
    presentation: Presentation,
    part: MeasuringPart,
    heater: Heater,
    filter_ms: u16,
    faults: Faults,
}

impl Example {
    fn new(serial: SerialNumber) -> Self {
        Self {
            serial,
            presentation: Presentation::new(&MODEL, FACTORY_UNIT),
            part: MeasuringPart::new(&PART),
            heater: Heater::On,
            filter_ms: 100,
            faults: Faults::NONE,
        }
    }
}

/// The parameters. Access, length, type and code are checked before `set`, and the value is stored after it.
impl ParameterAccess for Example {
    type Parameter = Parameter;

    fn is_visible(&self, _location: &Location) -> bool {
        true
    }

    fn format(&self, _at: &ParameterRef<Parameter>) -> PressureFormat {
        self.presentation.format(COUNTS)
    }

    fn get(&self, at: &ParameterRef<Parameter>) -> Value {
        match at.parameter {
            Parameter::Device(DeviceBlock::BlockType) => Value::octets(&DeviceBlock::BLOCK.type_octets()),
            Parameter::Device(DeviceBlock::DeviceType) => Value::text("EX1"),
            Parameter::Device(DeviceBlock::SerialNumber) => self.serial.value(),
            Parameter::Pressure(Pressure::ProcessValue) => Value::Pressure(self.part.process_value_pa(&MEASURING)),
            Parameter::Pressure(Pressure::ReadingValid) => Value::Boolean(self.part.is_valid(&MEASURING)),
            Parameter::Pressure(Pressure::Heater) => self.heater.code().into(),
            Parameter::Pressure(Pressure::Filter) => self.filter_ms.into(),
            // Rows that every gauge has.
            Parameter::Pressure(_) => self.part.input_row(at.row.index, &self.presentation),
        }
    }

    fn set(&mut self, at: &ParameterRef<Parameter>, value: &Value) -> Result<(), AccessError> {
        match at.parameter {
            Parameter::Pressure(Pressure::Heater) => self.heater = value.coded()?,
            Parameter::Pressure(Pressure::Filter) => {
                self.filter_ms = Some(value.integer()?).filter(|ms| *ms <= 1000).ok_or(AccessError::OutOfRange)?;
            }
            _ => match InputRow::from_index(at.row.index).ok_or(AccessError::NotWritable)? {
                row @ (InputRow::DataType | InputRow::DataUnits) => self.presentation.set_row(row, value)?,
                row => self.part.set_input(row, value)?,
            },
        }
        Ok(())
    }
}

impl Behaviour for Example {
    fn model(&self) -> &'static Model {
        &MODEL
    }

    fn presentation_mut(&mut self) -> Option<&mut Presentation> {
        Some(&mut self.presentation)
    }

    fn set_exchanging(&mut self, _running: bool) {}

    fn input(&self, field: Field) -> Octets {
        match field {
            Field::ProcessValue(_) => self.presentation.format(COUNTS).encode(self.part.process_value_pa(&MEASURING)),
            // In none of its telegrams.
            _ => Octets::EMPTY,
        }
    }

    fn start(&mut self) {
        *self = Self { part: self.part.restarted(), faults: self.faults, ..Self::new(self.serial) };
    }

    fn update(&mut self) {
        self.part.failed = self.faults.sensor;
        let measures = self.heater == Heater::On && !self.part.failed;
        self.part.reading_pa = measures.then(|| self.part.sensor.indicated_pa());
        self.part.remember(&MEASURING);
    }

    fn parts(&self) -> &[Part] {
        &PARTS
    }

    fn measuring_range(&self, _part: usize) -> MeasuringRange {
        self.part.measuring_range()
    }

    fn drive(&self, _part: usize) -> Drive {
        match self.heater {
            Heater::Off => Drive::Off,
            Heater::On => Drive::On,
        }
    }

    fn sense(&mut self, _part: usize, pa: f64) {
        self.part.sensor.sensed_pa = pa;
    }

    fn advance(&mut self, _seconds: f64) {}

    fn settle(&mut self) {}

    fn front_panel(&self) -> FrontPanel {
        FrontPanel { ..FRONT_PANEL }
    }

    fn set_fault(&mut self, fault: Fault, active: bool) {
        self.faults.set(fault, active);
    }

    fn has_alarm(&self) -> bool {
        self.part.failed
    }

    fn report(&self) -> StateReport {
        StateReport {
            indicated: core::iter::once(self.part.indicated(&MEASURING)).collect(),
            active_instance: 1,
            outputs_safe: self.part.is_safe(&MEASURING),
            ..StateReport::default()
        }
    }
}
