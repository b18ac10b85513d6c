//! The device block of the gauges: identity, state and exceptions. Its first rows are the same in tira41d1 3.1,
//! tira36e1 3.1 and tira56e1 7.1; the copies of the exception details behind them differ.

use super::device::SerialNumber;
use super::exceptions::ExceptionStatus;
use super::state_machine::DeviceState;
use crate::model::{Block, Model, Value};

/// The rows that the device blocks of all gauges have, by their index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceRow {
    /// Device Block State Command.
    StateCommand,
    /// Block Type.
    BlockType,
    /// Device Type.
    DeviceType,
    /// Standard Revision Level.
    StandardRevision,
    /// Device Manufacturer Identifier.
    Manufacturer,
    /// Manufacturer Model Number.
    ModelNumber,
    /// Software or Firmware Revision Level.
    SoftwareRevision,
    /// Hardware Revision Level.
    HardwareRevision,
    /// Serial Number.
    SerialNumber,
    /// Device Configuration.
    DeviceConfiguration,
    /// Device State.
    DeviceState,
    /// Exception Status.
    ExceptionStatus,
    /// Exception Detail Alarm.
    AlarmDetail,
    /// Exception Detail Warning.
    WarningDetail,
}

impl DeviceRow {
    /// The row with this index, if all gauges have it.
    #[must_use]
    pub const fn from_index(index: u8) -> Option<Self> {
        Some(match index {
            15 => Self::StateCommand,
            16 => Self::BlockType,
            17 => Self::DeviceType,
            18 => Self::StandardRevision,
            19 => Self::Manufacturer,
            20 => Self::ModelNumber,
            21 => Self::SoftwareRevision,
            22 => Self::HardwareRevision,
            23 => Self::SerialNumber,
            24 => Self::DeviceConfiguration,
            25 => Self::DeviceState,
            26 => Self::ExceptionStatus,
            27 => Self::AlarmDetail,
            28 => Self::WarningDetail,
            _ => return None,
        })
    }
}

/// The texts of a gauge that never change.
#[derive(Clone, Copy, Debug)]
pub struct Identity {
    /// The tables.
    pub model: &'static Model,
    /// Device Type.
    pub device_type: &'static str,
    /// Manufacturer Model Number.
    pub model_number: &'static str,
    /// Software or Firmware Revision Level.
    pub software: &'static str,
    /// Device Configuration.
    pub configuration: &'static str,
}

/// Standard Revision Level of all gauges.
const STANDARD_REVISION: &str = "E54-0997";

/// A gauge with a device block.
pub trait DeviceBlockValues {
    /// The texts that never change.
    fn identity(&self) -> Identity;

    /// Serial Number.
    fn serial(&self) -> &SerialNumber;

    /// Device State.
    fn device_state(&self) -> DeviceState;

    /// Exception Status.
    fn exception_status(&self) -> ExceptionStatus;

    /// Exception Detail Alarm.
    fn alarm_record(&self) -> Value;

    /// Exception Detail Warning.
    fn warning_record(&self) -> Value;

    /// The value of the row with this index, one that all gauges have; `block` is the device's table.
    fn device_row(&self, block: &Block, index: u8) -> Value {
        let Some(row) = DeviceRow::from_index(index) else { return Value::NONE };
        match row {
            // A read shows that the command has been executed: errata-bpg-bcg-tpg 35, errata-pxg55x-img400 26.
            DeviceRow::StateCommand => Value::Integer(0),
            DeviceRow::BlockType => Value::octets(&block.type_octets()),
            DeviceRow::DeviceType => Value::text(self.identity().device_type),
            DeviceRow::StandardRevision => Value::text(STANDARD_REVISION),
            DeviceRow::Manufacturer => Value::text(self.identity().model.vendor),
            DeviceRow::ModelNumber => Value::text(self.identity().model_number),
            DeviceRow::SoftwareRevision => Value::text(self.identity().software),
            DeviceRow::HardwareRevision => Value::text(self.identity().model.gsd.hardware),
            DeviceRow::SerialNumber => self.serial().value(),
            DeviceRow::DeviceConfiguration => Value::text(self.identity().configuration),
            DeviceRow::DeviceState => self.device_state().code().into(),
            DeviceRow::ExceptionStatus => self.exception_status().bits().into(),
            DeviceRow::AlarmDetail => self.alarm_record(),
            DeviceRow::WarningDetail => self.warning_record(),
        }
    }
}
