//! The words of a device file for the types of the tables, read and written.

use super::error::{Located, problem};
use profivac_client::Pressure;
use profivac_client::suggestion::closest;
use profivac_devices::described::BlockBehaviour;
use profivac_devices::model::{
    Access, AccessError, Clipping, DataType, Field, NumberType, Precondition, Principle, Role, Storage,
};
use toml::Spanned;

pub const PRINCIPLES: [(&str, Principle); 5] = [
    ("pirani", Principle::Pirani),
    ("hot-cathode", Principle::HotCathode),
    ("cold-cathode", Principle::ColdCathode),
    ("diaphragm", Principle::Diaphragm),
    ("atmosphere", Principle::Atmosphere),
];

pub const BEHAVIOURS: [(&str, BlockBehaviour); 7] = [
    ("state-machine", BlockBehaviour::StateMachine),
    ("analog-input", BlockBehaviour::AnalogInput),
    ("pirani", BlockBehaviour::Pirani),
    ("diaphragm", BlockBehaviour::Diaphragm),
    ("hot-cathode", BlockBehaviour::HotCathode),
    ("cold-cathode", BlockBehaviour::ColdCathode),
    ("trip-point", BlockBehaviour::TripPoint),
];

pub const CLIPPINGS: [(&str, Clipping); 4] =
    [("both", Clipping::Both), ("above", Clipping::Above), ("below", Clipping::Below), ("never", Clipping::Never)];

pub const STORAGES: [(&str, Storage); 5] = [
    ("N", Storage::Nonvolatile),
    ("V", Storage::Volatile),
    ("R", Storage::OnRequest),
    ("D", Storage::Dynamic),
    ("-", Storage::Unstated),
];

/// `none` for a parameter that is not for what its name says.
pub const ROLES: [(&str, Option<Role>); 19] = [
    ("none", None),
    ("process-value", Some(Role::ProcessValue)),
    ("reading-valid", Some(Role::ReadingValid)),
    ("status-extension", Some(Role::StatusExtension)),
    ("pv-selector", Some(Role::PvSelector)),
    ("instance-selector", Some(Role::InstanceSelector)),
    ("unit", Some(Role::Unit)),
    ("number-type", Some(Role::NumberType)),
    ("emission-status", Some(Role::EmissionStatus)),
    ("degas-status", Some(Role::DegasStatus)),
    ("full-scale", Some(Role::FullScale)),
    ("overrange", Some(Role::Overrange)),
    ("underrange", Some(Role::Underrange)),
    ("block-type", Some(Role::BlockType)),
    ("device-configuration", Some(Role::DeviceConfiguration)),
    ("pressure-difference", Some(Role::PressureDifference)),
    ("alarm-detail", Some(Role::AlarmDetail)),
    ("sensor-alarm", Some(Role::SensorAlarm)),
    ("set-lock", Some(Role::SetLock)),
];

pub const ACCESS_ERRORS: [(&str, AccessError); 12] = [
    ("unknown-slot", AccessError::UnknownSlot),
    ("unknown-index", AccessError::UnknownIndex),
    ("not-readable", AccessError::NotReadable),
    ("not-writable", AccessError::NotWritable),
    ("not-in-channel", AccessError::NotInChannel),
    ("wrong-length", AccessError::WrongLength),
    ("wrong-mode", AccessError::WrongMode),
    ("already-in-state", AccessError::AlreadyInState),
    ("state-conflict", AccessError::StateConflict),
    ("out-of-range", AccessError::OutOfRange),
    ("storage-failed", AccessError::StorageFailed),
    ("unknown-task", AccessError::UnknownTask),
];

/// The word of a value.
pub fn word_of<T: PartialEq>(words: &[(&'static str, T)], value: &T) -> &'static str {
    words.iter().find(|(_, known)| known == value).map_or("unknown", |(word, _)| word)
}

/// The value of a word; `what` is the key.
pub fn value_of<T: Copy>(words: &[(&str, T)], text: &Spanned<String>, what: &str) -> Result<T, Located> {
    let found = words.iter().find(|(word, _)| word == text.get_ref());
    found.map(|(_, value)| *value).ok_or_else(|| {
        let known: Vec<_> = words.iter().map(|(word, _)| *word).collect();
        unknown(text, &format!("{what}, one of: {}", known.join(", ")), known)
    })
}

/// The error for a text that is none of `known`, with the most similar one.
pub fn unknown<'a>(text: &Spanned<String>, expected: &str, known: impl IntoIterator<Item = &'a str>) -> Located {
    let near = closest(text.get_ref(), known).map_or_else(String::new, |near| format!("; did you mean {near:?}?"));
    Located { span: text.span(), text: format!("expected {expected}; found {:?}{near}", text.get_ref()) }
}

/// The fields without a number.
pub const PLAIN_FIELDS: [(&str, Field); 8] = [
    ("parameter-channel", Field::ParameterChannel),
    ("transition-command", Field::TransitionCommand),
    ("sensor-on-off", Field::SensorOnOff),
    ("exception-status", Field::ExceptionStatus),
    ("status-extension", Field::StatusExtension),
    ("pv-selector", Field::PvSelector),
    ("channel-status", Field::ChannelStatus),
    ("ttr-value", Field::TtrValue),
];

/// The forms of the other fields, for an error.
const FIELD_FORMS: [&str; 7] = [
    "ignored OCTETS",
    "process-value float",
    "process-value integer",
    "channel-value CHANNEL float",
    "channel-mantissa CHANNEL",
    "measurement-status CHANNEL",
    "trip-relays RELAYS",
];

const fn number_word(number: NumberType) -> &'static str {
    match number {
        NumberType::Integer => "integer",
        NumberType::Float => "float",
    }
}

/// A field of a telegram in words.
pub fn field_words(field: Field) -> String {
    match field {
        Field::Ignored(octets) => format!("ignored {octets}"),
        Field::ProcessValue(number) => format!("process-value {}", number_word(number)),
        Field::ChannelValue(channel, number) => format!("channel-value {channel} {}", number_word(number)),
        Field::ChannelMantissa(channel) => format!("channel-mantissa {channel}"),
        Field::MeasurementStatus(channel) => format!("measurement-status {channel}"),
        Field::TripRelays(relays) => format!("trip-relays {relays}"),
        plain => word_of(&PLAIN_FIELDS, &plain).to_owned(),
    }
}

/// The field with these words.
pub fn field(text: &Spanned<String>) -> Result<Field, Located> {
    parse_field(text.get_ref()).ok_or_else(|| {
        let known = || PLAIN_FIELDS.iter().map(|(word, _)| *word).chain(FIELD_FORMS);
        unknown(text, &format!("a field, one of: {}", known().collect::<Vec<_>>().join(", ")), known())
    })
}

fn parse_field(text: &str) -> Option<Field> {
    let number = |word: &str| match word {
        "integer" => Some(NumberType::Integer),
        "float" => Some(NumberType::Float),
        _ => None,
    };
    let count = |word: &str| word.parse().ok().filter(|count| (1..=48_u8).contains(count));
    match *text.split_whitespace().collect::<Vec<_>>() {
        ["ignored", octets] => count(octets).map(Field::Ignored),
        ["process-value", word] => number(word).map(Field::ProcessValue),
        ["channel-value", channel, word] => Some(Field::ChannelValue(count(channel)?, number(word)?)),
        ["channel-mantissa", channel] => count(channel).map(Field::ChannelMantissa),
        ["measurement-status", channel] => count(channel).map(Field::MeasurementStatus),
        ["trip-relays", relays] => count(relays).map(Field::TripRelays),
        [plain] => PLAIN_FIELDS.iter().find(|(word, _)| *word == plain).map(|(_, field)| *field),
        _ => None,
    }
}

/// The octets of the longest parameter: a value holds no more.
const MAX_LENGTH: u8 = 50;

/// The data type as the manuals write it.
pub fn data_type(text: &Spanned<String>) -> Result<DataType, Located> {
    parse_data_type(text.get_ref()).map_or_else(
        || {
            let found = text.get_ref();
            problem(
                text.span(),
                format!(
                    "expected a type, one of: BOOLEAN, INT8, UINT8, INT16, UINT16, INT32, UINT32, FLOAT, BY_TYPE (a pressure in the unit \
                     and number type of the device), VSTRING(n), OSTRING(n), ARRAY(n), RECORD(n) with n from 1 to {MAX_LENGTH}; found \
                     {found:?}"
                ),
            )
        },
        Ok,
    )
}

fn parse_data_type(text: &str) -> Option<DataType> {
    let plain = [
        DataType::Boolean,
        DataType::Int8,
        DataType::Uint8,
        DataType::Int16,
        DataType::Uint16,
        DataType::Int32,
        DataType::Uint32,
        DataType::Float,
        DataType::ByType,
    ];
    if let Some(found) = plain.into_iter().find(|data_type| data_type.to_string() == text) {
        return Some(found);
    }
    let (name, length) = text.strip_suffix(')')?.split_once('(')?;
    let length = length.parse().ok().filter(|length| (1..=MAX_LENGTH).contains(length))?;
    match name {
        "VSTRING" => Some(DataType::Visible(length)),
        "OSTRING" => Some(DataType::OctetString(length)),
        "ARRAY" => Some(DataType::Array(length)),
        "RECORD" => Some(DataType::Record(length)),
        _ => None,
    }
}

const READ_BOTH: Access = Access::READ_1.union(Access::READ_2);
const WRITE_BOTH: Access = Access::WRITE_1.union(Access::WRITE_2);

/// The access marks of the manuals.
const MARKS: [(&str, Access); 17] = [
    ("0_XI", Access::CYCLIC_IN),
    ("0_XO", Access::CYCLIC_OUT),
    ("1/2_R/W", READ_BOTH.union(WRITE_BOTH)),
    ("1/2_R", READ_BOTH),
    ("1/2_W", WRITE_BOTH),
    ("1_R/W", Access::READ_1.union(Access::WRITE_1)),
    ("2_R/W", Access::READ_2.union(Access::WRITE_2)),
    ("2R/W", Access::READ_2.union(Access::WRITE_2)),
    ("2R", Access::READ_2),
    ("1_R", Access::READ_1),
    ("1_W", Access::WRITE_1),
    ("2_R", Access::READ_2),
    ("2_W", Access::WRITE_2),
    ("c_r", Access::CYCLIC_IN),
    ("c_w", Access::CYCLIC_OUT),
    ("ac_r", Access::READ_CHANNEL),
    ("ac_w", Access::WRITE_CHANNEL),
];

/// The mark for a parameter that only the user parameters set.
const USER_PRM_MARK: &str = "prm";

/// The access rights of the manual's marks.
pub fn access(text: &Spanned<String>) -> Result<Access, Located> {
    // Blanks around a stroke do not matter.
    let joined = text.get_ref().split('/').map(str::trim).collect::<Vec<_>>().join("/");
    let mut access = Access::empty();
    for mark in joined.split([' ', ',']).filter(|mark| !mark.is_empty()) {
        let found = MARKS.iter().find(|(known, _)| *known == mark).map(|(_, access)| *access);
        let found = found.or((mark == USER_PRM_MARK).then_some(Access::USER_PRM));
        access |= found.ok_or_else(|| {
            let marks = MARKS.map(|(known, _)| known).join(", ");
            let found = text.get_ref();
            Located {
                span: text.span(),
                text: format!(
                    "expected the access marks of the manual, of: {marks}, {USER_PRM_MARK}; found {mark:?} in {found:?}"
                ),
            }
        })?;
    }
    if access.is_empty() { problem(text.span(), "expected an access mark, for instance \"1/2_R\"") } else { Ok(access) }
}

/// A pressure with its unit, in Pa.
pub fn pressure_pa(text: &Spanned<String>) -> Result<f64, Located> {
    match text.get_ref().parse::<Pressure>() {
        Ok(pressure) if pressure.pa() <= 1e30 => Ok(pressure.pa()),
        Ok(_) => problem(text.span(), format!("expected a pressure of at most 1e30 Pa, found {}", text.get_ref())),
        Err(error) => problem(text.span(), error.to_string()),
    }
}

/// A pressure in mbar that is read as exactly this number of Pa, in its shortest form.
pub fn pressure_words(pa: f64) -> String {
    let mbar = pa / 100.0;
    let texts = [mbar, mbar.next_down(), mbar.next_up()].map(|mbar| format!("{} mbar", number_words(mbar)));
    let exact = texts.iter().filter(|text| text.parse::<Pressure>().is_ok_and(|pressure| pressure.pa() == pa));
    exact.min_by_key(|text| text.len()).unwrap_or(&texts[0]).clone()
}

/// A number as people write it: with an exponent where it would be long.
fn number_words(number: f64) -> String {
    if number != 0.0 && !(0.01..1e5).contains(&number.abs()) { format!("{number:e}") } else { format!("{number}") }
}

/// The forms of a condition.
const CONDITIONS: [&str; 6] = [
    "executing",
    "emission-on",
    "degas-off",
    "pressure below 1e-5 mbar",
    "pressure of instance 1 above 300 mbar",
    "pressure below 0.05 of full scale",
];

/// A condition in words.
pub fn condition_words(condition: Precondition) -> String {
    let of = |instance: Option<u8>| instance.map_or_else(String::new, |instance| format!(" of instance {instance}"));
    match condition {
        Precondition::Executing => "executing".to_owned(),
        Precondition::EmissionOn => "emission-on".to_owned(),
        Precondition::DegasOff => "degas-off".to_owned(),
        Precondition::PressureBelow(instance, pa) => format!("pressure{} below {}", of(instance), pressure_words(pa)),
        Precondition::PressureAbove(instance, pa) => format!("pressure{} above {}", of(instance), pressure_words(pa)),
        Precondition::BelowPartOfFullScale(part) => format!("pressure below {} of full scale", number_words(part)),
    }
}

/// The condition with these words.
pub fn condition(text: &Spanned<String>) -> Result<Precondition, Located> {
    parse_condition(text.get_ref())
        .ok_or_else(|| unknown(text, &format!("a condition like one of: {}", CONDITIONS.join(", ")), CONDITIONS))
}

fn parse_condition(text: &str) -> Option<Precondition> {
    match text {
        "executing" => return Some(Precondition::Executing),
        "emission-on" => return Some(Precondition::EmissionOn),
        "degas-off" => return Some(Precondition::DegasOff),
        _ => {}
    }
    let rest = text.strip_prefix("pressure ")?;
    if let Some(part) = rest.strip_prefix("below ").and_then(|rest| rest.strip_suffix(" of full scale")) {
        let part = part.parse().ok().filter(|part| (0.0..=1.0).contains(part))?;
        return Some(Precondition::BelowPartOfFullScale(part));
    }
    let (instance, rest) = match rest.strip_prefix("of instance ") {
        Some(rest) => {
            let (instance, rest) = rest.split_once(' ')?;
            (Some(instance.parse().ok()?), rest)
        }
        None => (None, rest),
    };
    let (side, pressure) = rest.split_once(' ')?;
    let pa = pressure.parse::<Pressure>().ok()?.pa();
    match side {
        "below" => Some(Precondition::PressureBelow(instance, pa)),
        "above" => Some(Precondition::PressureAbove(instance, pa)),
        _ => None,
    }
}

/// Octets as hexadecimal pairs with blanks between.
pub fn octets(text: &Spanned<String>) -> Result<Vec<u8>, Located> {
    let is_pair = |pair: &str| pair.len() == 2 && pair.bytes().all(|digit| digit.is_ascii_hexdigit());
    let octet = |pair: &str| if is_pair(pair) { u8::from_str_radix(pair, 16).ok() } else { None };
    text.get_ref().split_whitespace().map(octet).collect::<Option<Vec<u8>>>().map_or_else(
        || {
            let found = text.get_ref();
            problem(text.span(), format!("expected octets as hexadecimal pairs like \"44 86 05\", found {found:?}"))
        },
        Ok,
    )
}
