//! The part that a parameter plays for a client, whatever the manual calls it.

/// What a parameter is for. A client finds a parameter by its role, because its printed name differs between manuals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Role {
    /// The pressure of a measuring part, a channel or a relay.
    ProcessValue,
    /// Whether the pressure of the same location is valid.
    ReadingValid,
    /// Validity and range of the pressure of the same location.
    StatusExtension,
    /// The instance that measures now.
    PvSelector,
    /// The instance that a slot shows.
    InstanceSelector,
    /// The unit of the pressures.
    Unit,
    /// How the device writes pressures: integer or float.
    NumberType,
    /// Whether the emission is on.
    EmissionStatus,
    /// Whether a degas runs.
    DegasStatus,
    /// The highest pressure of a measuring part.
    FullScale,
    /// The highest valid pressure of a measuring part.
    Overrange,
    /// The lowest valid pressure of a measuring part.
    Underrange,
    /// The number of the block.
    BlockType,
    /// The fitted parts, as text.
    DeviceConfiguration,
    /// A difference of two pressures, not a pressure.
    PressureDifference,
    /// The alarms of all groups in one record.
    AlarmDetail,
    /// The alarms of a measuring part or of a channel.
    SensorAlarm,
    /// Opens a set of parameters for changes, and closes it.
    SetLock,
}

/// The names that the manuals print for the parameters with a role.
const PRINTED: [(&str, Role); 28] = [
    ("Process Value (PV)", Role::ProcessValue),
    ("ProcessValue (PV)", Role::ProcessValue),
    ("Reading Valid", Role::ReadingValid),
    ("Status Extension", Role::StatusExtension),
    ("One Of N Status Extension", Role::StatusExtension),
    ("OneOfN Status Extension", Role::StatusExtension),
    ("PV Selector", Role::PvSelector),
    ("OneOfN PV Selector", Role::PvSelector),
    ("Channel Instance Selector", Role::InstanceSelector),
    ("Data Unit", Role::Unit),
    ("Data Units", Role::Unit),
    ("Pressure unit", Role::Unit),
    ("Data Type", Role::NumberType),
    ("Emission Status", Role::EmissionStatus),
    ("Degas Status", Role::DegasStatus),
    ("Full Scale", Role::FullScale),
    ("Overrange", Role::Overrange),
    ("Underrange", Role::Underrange),
    ("Block Type", Role::BlockType),
    ("Block Type ID", Role::BlockType),
    ("Block-Type", Role::BlockType),
    ("Device Configuration", Role::DeviceConfiguration),
    ("Hysteresis", Role::PressureDifference),
    ("High Trip Point Hysteresis", Role::PressureDifference),
    ("Low Trip Point Hysteresis", Role::PressureDifference),
    ("Exception Detail Alarm", Role::AlarmDetail),
    ("Sensor Alarm", Role::SensorAlarm),
    ("Threshold validation", Role::SetLock),
];

impl Role {
    /// The role of a parameter with this printed name.
    ///
    /// ```
    /// use profivac_devices::model::Role;
    ///
    /// assert_eq!(Role::of_printed_name("Process Value (PV)"), Some(Role::ProcessValue));
    /// assert_eq!(Role::of_printed_name("Filter time constant"), None);
    /// ```
    #[must_use]
    pub fn of_printed_name(name: &str) -> Option<Self> {
        PRINTED.iter().find(|(printed, _)| *printed == name).map(|(_, role)| *role)
    }
}

/// The role of the parameter with this identifier in a block table. The tables use one identifier for one role.
#[doc(hidden)]
#[macro_export]
macro_rules! role {
    (ProcessValue) => {
        Some($crate::model::Role::ProcessValue)
    };
    (ReadingValid) => {
        Some($crate::model::Role::ReadingValid)
    };
    (StatusExtension) => {
        Some($crate::model::Role::StatusExtension)
    };
    (PvSelector) => {
        Some($crate::model::Role::PvSelector)
    };
    (ChannelInstanceSelector) => {
        Some($crate::model::Role::InstanceSelector)
    };
    (DataUnit) => {
        Some($crate::model::Role::Unit)
    };
    (DataUnits) => {
        Some($crate::model::Role::Unit)
    };
    (PressureUnit) => {
        Some($crate::model::Role::Unit)
    };
    (DataType) => {
        Some($crate::model::Role::NumberType)
    };
    (EmissionStatus) => {
        Some($crate::model::Role::EmissionStatus)
    };
    (DegasStatus) => {
        Some($crate::model::Role::DegasStatus)
    };
    (FullScale) => {
        Some($crate::model::Role::FullScale)
    };
    (Overrange) => {
        Some($crate::model::Role::Overrange)
    };
    (Underrange) => {
        Some($crate::model::Role::Underrange)
    };
    (BlockType) => {
        Some($crate::model::Role::BlockType)
    };
    (DeviceConfiguration) => {
        Some($crate::model::Role::DeviceConfiguration)
    };
    (AlarmDetail) => {
        Some($crate::model::Role::AlarmDetail)
    };
    (ExceptionDetailAlarm) => {
        Some($crate::model::Role::AlarmDetail)
    };
    (SensorAlarm) => {
        Some($crate::model::Role::SensorAlarm)
    };
    (Hysteresis) => {
        Some($crate::model::Role::PressureDifference)
    };
    (HighTripPointHysteresis) => {
        Some($crate::model::Role::PressureDifference)
    };
    (LowTripPointHysteresis) => {
        Some($crate::model::Role::PressureDifference)
    };
    (Validation) => {
        Some($crate::model::Role::SetLock)
    };
    ($other:ident) => {
        None
    };
}

#[doc(hidden)]
pub use role;

#[cfg(test)]
mod tests {
    use super::{PRINTED, Role};
    use crate::catalog::MODELS;
    use crate::model::{DataType, Row};

    fn rows(role: Role) -> impl Iterator<Item = (&'static str, &'static Row)> {
        let rows = |model: &'static crate::model::Model| {
            model.blocks.iter().flat_map(|placed| placed.block.rows.iter()).map(|row| (model.name, row))
        };
        MODELS.into_iter().flat_map(rows).filter(move |(_, row)| row.role == Some(role))
    }

    /// A row that an editor renames or adds gets the role of its identifier: the names and types that the manuals print for
    /// each role.
    #[test]
    fn every_role_has_the_rows_that_the_manuals_print_for_it() {
        for model in MODELS {
            for row in model.blocks.iter().flat_map(|placed| placed.block.rows) {
                assert_eq!(Role::of_printed_name(row.name), row.role, "{} {}", model.name, row.name);
            }
        }
        for (printed, role) in PRINTED {
            assert!(rows(role).any(|(_, row)| row.name == printed), "no manual prints {printed}");
        }
        for (role, data_type) in [
            (Role::ProcessValue, DataType::ByType),
            (Role::ReadingValid, DataType::Boolean),
            (Role::StatusExtension, DataType::Uint8),
            (Role::PvSelector, DataType::Uint8),
            (Role::InstanceSelector, DataType::Uint8),
            (Role::NumberType, DataType::Uint8),
            (Role::FullScale, DataType::ByType),
            (Role::Overrange, DataType::ByType),
            (Role::Underrange, DataType::ByType),
            (Role::BlockType, DataType::OctetString(4)),
            (Role::DeviceConfiguration, DataType::Visible(50)),
            (Role::PressureDifference, DataType::ByType),
            (Role::SensorAlarm, DataType::Array(2)),
            (Role::SetLock, DataType::Int8),
        ] {
            for (model, row) in rows(role) {
                assert_eq!(row.data_type, data_type, "{model} {}", row.name);
            }
        }
    }
}
