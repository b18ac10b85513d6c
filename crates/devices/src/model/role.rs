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
    use super::Role;
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
        for (role, names, data_type) in [
            (Role::ProcessValue, &["Process Value (PV)", "ProcessValue (PV)"][..], Some(DataType::ByType)),
            (Role::ReadingValid, &["Reading Valid"], Some(DataType::Boolean)),
            (
                Role::StatusExtension,
                &["Status Extension", "One Of N Status Extension", "OneOfN Status Extension"],
                Some(DataType::Uint8),
            ),
            (Role::PvSelector, &["PV Selector", "OneOfN PV Selector"], Some(DataType::Uint8)),
            (Role::InstanceSelector, &["Channel Instance Selector"], Some(DataType::Uint8)),
            (Role::NumberType, &["Data Type"], Some(DataType::Uint8)),
            (Role::EmissionStatus, &["Emission Status"], None),
            (Role::DegasStatus, &["Degas Status"], None),
            (Role::FullScale, &["Full Scale"], Some(DataType::ByType)),
            (Role::Overrange, &["Overrange"], Some(DataType::ByType)),
            (Role::Underrange, &["Underrange"], Some(DataType::ByType)),
            (Role::BlockType, &["Block Type", "Block Type ID", "Block-Type"], Some(DataType::OctetString(4))),
            (Role::DeviceConfiguration, &["Device Configuration"], Some(DataType::Visible(50))),
            (
                Role::PressureDifference,
                &["Hysteresis", "High Trip Point Hysteresis", "Low Trip Point Hysteresis"],
                Some(DataType::ByType),
            ),
            (Role::AlarmDetail, &["Exception Detail Alarm"], None),
            (Role::SensorAlarm, &["Sensor Alarm"], Some(DataType::Array(2))),
            (Role::SetLock, &["Threshold validation"], Some(DataType::Int8)),
        ] {
            assert!(rows(role).count() > 0, "{role:?}");
            for (model, row) in rows(role) {
                assert!(names.contains(&row.name), "{model} {} is {role:?}", row.name);
                assert!(data_type.is_none_or(|data_type| row.data_type == data_type), "{model} {}", row.name);
            }
            for model in MODELS {
                for row in model.blocks.iter().flat_map(|placed| placed.block.rows) {
                    assert!(!names.contains(&row.name) || row.role == Some(role), "{} {}", model.name, row.name);
                }
            }
        }
    }
}
