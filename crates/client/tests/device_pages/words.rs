//! The contents of the tables as text.

use profivac_devices::Principle;
use profivac_devices::model::{
    AccessError, Clipping, Counts, DataType, Field, Location, NumberType, PressureFormat, Scale, TaskKind, Unit,
};

/// A field with its first and last octet.
pub fn placed(start: usize, field: Field) -> String {
    let octets = match field.octets() {
        1 => start.to_string(),
        octets => format!("{start}-{}", start + octets - 1),
    };
    format!("{octets} {}", self::field(field))
}

fn field(field: Field) -> String {
    let name = field.name();
    match field {
        Field::ProcessValue(number) => format!("{name} ({})", self::number(number)),
        Field::ChannelValue(channel, number) => format!("{name} {channel} ({})", self::number(number)),
        Field::ChannelMantissa(channel) => format!("{name} {channel} (mantissa and exponent)"),
        Field::MeasurementStatus(channel) => format!("{name} {channel}"),
        _ => name.to_owned(),
    }
}

const fn number(number: NumberType) -> &'static str {
    match number {
        NumberType::Integer => "integer",
        NumberType::Float => "float",
    }
}

/// The size of one mbar in a unit.
pub fn scale(scale: Scale) -> String {
    match scale {
        Scale::PerMbar(factor) => factor.to_string(),
        Scale::Counts => "different in each instance".to_owned(),
    }
}

pub const fn principle(principle: Principle) -> &'static str {
    match principle {
        Principle::Pirani => "Pirani",
        Principle::HotCathode => "hot cathode",
        Principle::ColdCathode => "cold cathode",
        Principle::Diaphragm => "capacitance diaphragm",
        Principle::Atmosphere => "atmosphere sensor",
    }
}

pub const fn shows(shows: Clipping) -> &'static str {
    match shows {
        Clipping::Both => "its range",
        Clipping::Above => "its range and below",
        Clipping::Below => "its range and above",
        Clipping::Never => "everything",
    }
}

pub fn counts(counts: Counts) -> String {
    match counts {
        Counts::Log { per_decade, at_1_mbar } => format!("{per_decade} x log10(p / mbar) + {at_1_mbar}"),
        Counts::Linear { per_mbar } => format!("{per_mbar} x p / mbar"),
        Counts::Distance { .. } => "counted from a point".to_owned(),
    }
}

/// Slot, instance if there are several, and name.
pub fn address(address: &Location) -> Vec<String> {
    let instance = match address.instance {
        0 => "-".to_owned(),
        instance => instance.to_string(),
    };
    vec![address.slot.to_string(), instance, address.name.to_owned()]
}

static MBAR: Unit = Unit { code: 0, name: "mbar", alias: "mbar", scale: Scale::PerMbar(1.0) };

/// The number of octets of a value, with either number type.
pub fn length(data_type: DataType) -> String {
    let [integer, float] = [NumberType::Integer, NumberType::Float].map(|number| {
        let counts = Counts::Linear { per_mbar: 1.0 };
        data_type.length(&PressureFormat { unit: &MBAR, number, counts, max_integer: u16::MAX })
    });
    if integer == float { integer.to_string() } else { "by type".to_owned() }
}

pub fn instruction(instruction: TaskKind) -> String {
    match instruction {
        TaskKind::Read => "read".to_owned(),
        TaskKind::Write(lengths) => {
            let lengths: Vec<_> = lengths.iter().map(usize::to_string).collect();
            let octets = if lengths == ["1"] { "octet" } else { "octets" };
            format!("write {} {octets}", lengths.join(" or "))
        }
    }
}

/// In the order of the checks.
pub const REFUSALS: [AccessError; 12] = [
    AccessError::UnknownSlot,
    AccessError::UnknownIndex,
    AccessError::NotReadable,
    AccessError::NotWritable,
    AccessError::NotInChannel,
    AccessError::WrongLength,
    AccessError::WrongMode,
    AccessError::AlreadyInState,
    AccessError::StateConflict,
    AccessError::OutOfRange,
    AccessError::StorageFailed,
    AccessError::UnknownTask,
];

pub const fn refusal(refusal: AccessError) -> &'static str {
    match refusal {
        AccessError::UnknownSlot => "no such slot",
        AccessError::UnknownIndex => "no such index in the slot, or not for the selected instance",
        AccessError::NotReadable => "not for reading, or not for this master",
        AccessError::NotWritable => "not for writing, or not for this master",
        AccessError::NotInChannel => "a text, which the parameter channel cannot carry",
        AccessError::WrongLength => "another length than the parameter's",
        AccessError::WrongMode => "the operating mode forbids it",
        AccessError::AlreadyInState => "already in the requested state",
        AccessError::StateConflict => "not in this state",
        AccessError::OutOfRange => "outside the range or the enumeration",
        AccessError::StorageFailed => "the nonvolatile memory failed; nothing is stored",
        AccessError::UnknownTask => "no such instruction",
        _ => "another reason",
    }
}

pub const fn is_of_channel_only(refusal: AccessError) -> bool {
    matches!(refusal, AccessError::NotInChannel | AccessError::UnknownTask)
}
