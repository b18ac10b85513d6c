//! The cyclic data: standard telegrams, and the configurations that choose them.

use super::codes::Codes;
use super::pressure::NumberType;
use super::value::DataType;
use profivac_wire::Reader;

/// One element of a cyclic telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// The parameter channel, either way.
    ParameterChannel,
    /// Transition Command and its value, to the device.
    TransitionCommand,
    /// Sensor On_Off, to the device.
    SensorOnOff,
    /// This number of octets that the device ignores, or that have [`CyclicValue`]s.
    Ignored(u8),
    /// Exception Status.
    ExceptionStatus,
    /// One Of N Status Extension.
    StatusExtension,
    /// One Of N PV Selector.
    PvSelector,
    /// The Process Value of the instance that the PV Selector names.
    ProcessValue(NumberType),
    /// The Process Value or Measured Value of a channel, counted from 1.
    ChannelValue(u8, NumberType),
    /// Measured Value of a channel as mantissa and exponent.
    ChannelMantissa(u8),
    /// The measurement status of a channel.
    MeasurementStatus(u8),
    /// Channel Status.
    ChannelStatus,
    /// The status of this number of trip relays, from relay 1 on.
    TripRelays(u8),
    /// Status and 12-bit value of the TTR compatibility mode.
    TtrValue,
}

/// Data type codes in a configuration: profibus-wire 2.6.3.
const OCTET_STRING: u8 = 0x0A;
const UINT8: u8 = 0x05;
const INTEGER16: u8 = NumberType::Integer.code();
const FLOAT: u8 = NumberType::Float.code();

impl Field {
    /// The name in the manuals.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ParameterChannel => "Parameter Channel",
            Self::TransitionCommand => "Transition Command and Value",
            Self::SensorOnOff => "Sensor On_Off",
            Self::Ignored(_) => "not processed",
            Self::ExceptionStatus => "Exception Status",
            Self::StatusExtension => "One Of N Status Extension",
            Self::PvSelector => "One Of N PV Selector",
            Self::ProcessValue(_) => "Process Value",
            Self::ChannelValue(..) | Self::ChannelMantissa(_) => "Measured Value",
            Self::MeasurementStatus(_) => "Measurement Status",
            Self::ChannelStatus => "Channel Status",
            Self::TripRelays(_) => "Trip Relays",
            Self::TtrValue => "Status and Measurement Value",
        }
    }

    /// The number of its octets.
    #[must_use]
    pub const fn octets(self) -> usize {
        match self {
            Self::ParameterChannel => 8,
            Self::TransitionCommand | Self::ChannelStatus | Self::TtrValue => 2,
            Self::SensorOnOff
            | Self::ExceptionStatus
            | Self::StatusExtension
            | Self::PvSelector
            | Self::MeasurementStatus(_) => 1,
            Self::ProcessValue(number) | Self::ChannelValue(_, number) => number.octets(),
            Self::ChannelMantissa(_) => 3,
            Self::Ignored(octets) | Self::TripRelays(octets) => octets as usize,
        }
    }

    /// Its type codes in a configuration of the special format; none if it is only in configurations of the general format.
    #[must_use]
    pub const fn codes(self) -> &'static [u8] {
        match self {
            Self::ParameterChannel | Self::ChannelStatus | Self::TripRelays(_) => &[OCTET_STRING],
            Self::TransitionCommand => &[UINT8, UINT8],
            Self::SensorOnOff
            | Self::ExceptionStatus
            | Self::StatusExtension
            | Self::PvSelector
            | Self::MeasurementStatus(_) => &[UINT8],
            Self::ProcessValue(NumberType::Integer) | Self::ChannelValue(_, NumberType::Integer) => &[INTEGER16],
            Self::ProcessValue(NumberType::Float) | Self::ChannelValue(_, NumberType::Float) => &[FLOAT],
            // Only in configurations of the general format, which has no type codes.
            Self::ChannelMantissa(_) | Self::Ignored(_) | Self::TtrValue => &[],
        }
    }
}

/// A standard telegram.
#[derive(Debug, PartialEq, Eq)]
pub struct Telegram {
    /// The manual's number.
    pub number: u8,
    /// Its fields, in order.
    pub fields: &'static [Field],
}

/// A standard telegram of a table.
#[must_use]
pub const fn telegram(number: u8, fields: &'static [Field]) -> Telegram {
    Telegram { number, fields }
}

impl Telegram {
    /// The number of its octets.
    #[must_use]
    pub const fn octets(&self) -> usize {
        octets_of(self.fields)
    }

    /// The offset of each field, and the field.
    pub fn layout(&self) -> impl Iterator<Item = (usize, Field)> {
        self.fields.iter().scan(0usize, |next, field| {
            let start = *next;
            *next = start.saturating_add(field.octets());
            Some((start, *field))
        })
    }
}

/// A value of the cyclic data that is no pressure: a speed, a flow, a state. Its octets are those of a [`Field::Ignored`].
#[derive(Debug, PartialEq)]
pub struct CyclicValue {
    /// The name.
    pub name: &'static str,
    /// Whether the master sends it; otherwise the device does.
    pub is_output: bool,
    /// The number of its telegram.
    pub telegram: u8,
    /// Its first octet in the telegram. The high octet is first.
    pub octet: u8,
    /// The bit of the octet that a Boolean is, 0 for the lowest.
    pub bit: u8,
    /// Its type: a Boolean, a whole number or a float.
    pub data_type: DataType,
    /// The meaning of its numbers: none, names, or a unit.
    pub codes: Codes,
}

/// A configuration of a device: Chk_Cfg chooses its telegrams.
#[derive(Debug, PartialEq, Eq)]
pub struct Configuration {
    /// Master to slave.
    pub outputs: Option<&'static Telegram>,
    /// Slave to master.
    pub inputs: Option<&'static Telegram>,
    /// The configuration data.
    pub octets: &'static [u8],
}

/// The octets of the longest inputs and outputs of a device. chosen: a firmware copies them.
pub const MAX_IMAGE: usize = 48;

/// The octets of the longest outputs without the parameter channel.
pub const MAX_COMMANDS: usize = 8;

/// A configuration of a table, checked against its telegrams at compile time.
///
/// # Panics
/// If the configuration data do not fit the telegrams, or a telegram is longer than [`MAX_IMAGE`] or [`MAX_COMMANDS`]: in a `static` or
/// `const`, which is where it belongs, that does not compile.
#[must_use]
pub const fn configuration(
    outputs: Option<&'static Telegram>,
    inputs: Option<&'static Telegram>,
    octets: &'static [u8],
) -> Configuration {
    let configuration = Configuration { outputs, inputs, octets };
    assert!(configuration.is_consistent(), "the configuration data do not fit the telegrams");
    assert!(
        configuration.is_short(),
        "at most 48 octets of inputs or outputs, 8 of outputs without the parameter channel"
    );
    configuration
}

/// The lengths of both directions that the octets announce.
struct Sums {
    outputs: usize,
    inputs: usize,
}

impl Configuration {
    /// The number of octets that the master sends.
    #[must_use]
    pub const fn output_octets(&self) -> usize {
        octets_of(fields_of(self.outputs))
    }

    /// The number of octets that the slave sends.
    #[must_use]
    pub const fn input_octets(&self) -> usize {
        octets_of(fields_of(self.inputs))
    }

    /// Whether it is the telegram of TTR compatibility mode.
    #[must_use]
    pub fn is_ttr(&self) -> bool {
        self.inputs.is_some_and(|telegram| telegram.fields == [Field::TtrValue])
    }

    /// The number type of the Process Value, if the inputs have one.
    #[must_use]
    pub fn number(&self) -> Option<NumberType> {
        self.inputs?.fields.iter().find_map(|field| match field {
            Field::ProcessValue(number) | Field::ChannelValue(_, number) => Some(*number),
            _ => None,
        })
    }

    /// Whether the inputs and outputs are not too long.
    const fn is_short(&self) -> bool {
        is_short(fields_of(self.outputs), fields_of(self.inputs))
    }

    /// Whether the octets announce the telegrams.
    const fn is_consistent(&self) -> bool {
        announces(self.octets, fields_of(self.outputs), fields_of(self.inputs))
    }
}

/// Whether an image has at most [`MAX_IMAGE`] octets, and outputs without the parameter channel at most [`MAX_COMMANDS`].
#[must_use]
pub const fn is_short(outputs: &[Field], inputs: &[Field]) -> bool {
    octets_of(inputs) <= MAX_IMAGE && octets_of(outputs) <= MAX_IMAGE && command_octets(outputs) <= MAX_COMMANDS
}

/// Whether configuration data announce these outputs and inputs: both lengths, consistency over the whole length
/// (errata-bpg-bcg-tpg 15) and, in the special format, the type of every element, outputs first.
#[must_use]
pub const fn announces(octets: &[u8], outputs: &[Field], inputs: &[Field]) -> bool {
    let mut reader = Reader::new(octets);
    let mut sums = Sums { outputs: 0, inputs: 0 };
    while let Ok(octet) = reader.octet() {
        let fits = if octet & 0x30 == 0 {
            special_fits(octet, &mut reader, &mut sums, outputs, inputs)
        } else {
            general(octet, &mut sums);
            true
        };
        if !fits {
            return false;
        }
    }
    sums.outputs == octets_of(outputs) && sums.inputs == octets_of(inputs)
}

/// An identifier of the special format carries both telegrams. profibus-wire 2.6.2.
const fn special_fits(
    octet: u8,
    reader: &mut Reader<'_>,
    sums: &mut Sums,
    outputs: &[Field],
    inputs: &[Field],
) -> bool {
    if octet & 0x80 != 0 {
        let Some(length) = length(reader) else { return false };
        sums.outputs = length;
    }
    if octet & 0x40 != 0 {
        let Some(length) = length(reader) else { return false };
        sums.inputs = length;
    }
    codes_follow(outputs, reader)
        && codes_follow(inputs, reader)
        && reader.is_empty()
        && octet & 0x0F == codes_of(outputs).saturating_add(codes_of(inputs))
}

const fn fields_of(telegram: Option<&Telegram>) -> &'static [Field] {
    match telegram {
        Some(telegram) => telegram.fields,
        None => &[],
    }
}

/// The number of octets of these fields.
#[must_use]
pub const fn octets_of(mut fields: &[Field]) -> usize {
    let mut sum = 0usize;
    while let [field, rest @ ..] = fields {
        sum = sum.saturating_add(field.octets());
        fields = rest;
    }
    sum
}

/// The octets of outputs without the parameter channel.
const fn command_octets(mut outputs: &[Field]) -> usize {
    let mut sum = 0usize;
    while let [field, rest @ ..] = outputs {
        sum = match field {
            Field::ParameterChannel => sum,
            _ => sum.saturating_add(field.octets()),
        };
        outputs = rest;
    }
    sum
}

/// A length octet of the special format: octets, consistent over the whole length.
const fn length(reader: &mut Reader<'_>) -> Option<usize> {
    match reader.octet() {
        Ok(octet) if octet & 0xC0 == 0x80 => Some((octet & 0x3F).wrapping_add(1) as usize),
        _ => None,
    }
}

/// An identifier of the general format: octets of one or both directions. profibus-wire 2.6.1.
const fn general(octet: u8, sums: &mut Sums) {
    let octets = (octet & 0x0F).wrapping_add(1) as usize;
    if octet & 0x20 != 0 {
        sums.outputs = sums.outputs.saturating_add(octets);
    }
    if octet & 0x10 != 0 {
        sums.inputs = sums.inputs.saturating_add(octets);
    }
}

/// Whether the type codes of these fields follow.
const fn codes_follow(mut fields: &[Field], reader: &mut Reader<'_>) -> bool {
    while let [field, rest @ ..] = fields {
        let mut codes = field.codes();
        while let [code, more @ ..] = codes {
            match reader.octet() {
                Ok(octet) if octet == *code => codes = more,
                _ => return false,
            }
        }
        fields = rest;
    }
    true
}

/// The number of type codes of these fields.
const fn codes_of(mut fields: &[Field]) -> u8 {
    let mut sum = 0u8;
    while let [field, rest @ ..] = fields {
        sum = sum.saturating_add(field.codes().len() as u8);
        fields = rest;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use NumberType::{Float, Integer};

    /// errata-pxg55x-img400, verified configuration strings: TTR mode, telegram 204, and IMG 400 configuration 14.
    static TTR_OUT: Telegram = telegram(206, &[Field::Ignored(2)]);
    static TTR_IN: Telegram = telegram(205, &[Field::TtrValue]);
    static CHANNEL: Telegram = telegram(2, &[Field::ParameterChannel]);
    static RELAYS: Telegram = telegram(
        204,
        &[
            Field::ParameterChannel,
            Field::ExceptionStatus,
            Field::ProcessValue(Float),
            Field::StatusExtension,
            Field::TripRelays(2),
        ],
    );
    static CHANNELS: Telegram = telegram(
        204,
        &[
            Field::ParameterChannel,
            Field::ExceptionStatus,
            Field::ChannelValue(1, Float),
            Field::ChannelValue(2, Float),
            Field::ChannelValue(3, Float),
            Field::ChannelValue(4, Float),
            Field::ChannelStatus,
            Field::TripRelays(7),
        ],
    );
    /// IF300P manual: parameter channel, two channels, device module.
    static MODULES_OUT: Telegram = telegram(0, &[Field::ParameterChannel, Field::SensorOnOff]);
    static MODULES_IN: Telegram = telegram(
        0,
        &[
            Field::ParameterChannel,
            Field::ChannelValue(1, Float),
            Field::MeasurementStatus(1),
            Field::ChannelMantissa(2),
            Field::MeasurementStatus(2),
        ],
    );

    const TTR: &[u8] = &[0xA1, 0x91];
    const PCG_204: &[u8] = &[0xC6, 0x87, 0x8F, 0x0A, 0x0A, 0x05, 0x08, 0x05, 0x0A];
    const IMG_14: &[u8] = &[0xC9, 0x87, 0xA1, 0x0A, 0x0A, 0x05, 0x08, 0x08, 0x08, 0x08, 0x0A, 0x0A];
    const MODULES: &[u8] = &[0x97, 0xA7, 0x94, 0x93, 0xA0];

    fn is_consistent(outputs: &'static Telegram, inputs: &'static Telegram, octets: &'static [u8]) -> bool {
        Configuration { outputs: Some(outputs), inputs: Some(inputs), octets }.is_consistent()
    }

    #[test]
    fn configurations_of_both_formats_fit_their_telegrams() {
        assert!(is_consistent(&TTR_OUT, &TTR_IN, TTR));
        assert!(is_consistent(&CHANNEL, &RELAYS, PCG_204));
        assert!(is_consistent(&CHANNEL, &CHANNELS, IMG_14));
        assert!(is_consistent(&MODULES_OUT, &MODULES_IN, MODULES));
    }

    #[test]
    fn telegrams_have_a_limit() {
        static SHORT: Telegram = telegram(1, &[Field::ParameterChannel, Field::Ignored(8)]);
        static LONG: Telegram = telegram(1, &[Field::Ignored(9)]);
        static IMAGE: Telegram = telegram(1, &[Field::Ignored(48)]);
        static LONG_IMAGE: Telegram = telegram(1, &[Field::Ignored(49)]);
        let is_short = |outputs, inputs| Configuration { outputs, inputs, octets: &[] }.is_short();
        assert!(is_short(Some(&SHORT), Some(&IMAGE)));
        assert!(!is_short(Some(&LONG), None));
        assert!(!is_short(None, Some(&LONG_IMAGE)));
    }

    #[test]
    fn a_misprinted_configuration_does_not_fit() {
        // errata-pxg55x-img400 114: one float too many.
        let printed = &[0xC9, 0x87, 0xA1, 0x0A, 0x0A, 0x05, 0x08, 0x08, 0x08, 0x08, 0x08, 0x0A, 0x0A];
        assert!(!is_consistent(&CHANNEL, &CHANNELS, printed));
        assert!(!is_consistent(&CHANNEL, &TTR_IN, PCG_204), "other inputs");
        assert!(!is_consistent(&TTR_OUT, &RELAYS, PCG_204), "other outputs");
        assert!(!is_consistent(&MODULES_OUT, &MODULES_IN, &[0x97, 0xA7, 0x94, 0x94, 0xA0]));
    }

    #[test]
    fn a_configuration_of_the_special_format_with_an_altered_octet_does_not_fit() {
        extern crate std;
        use std::vec::Vec;
        for position in 0..PCG_204.len() {
            for octet in (0..=255).filter(|octet| *octet != PCG_204[position]) {
                let mut altered = Vec::from(PCG_204);
                altered[position] = octet;
                assert!(!is_consistent(&CHANNEL, &RELAYS, altered.leak()), "{octet:02X} at {position}");
            }
        }
    }

    #[test]
    fn the_offsets_follow_from_the_list_of_fields() {
        let starts: [usize; 8] = [0, 8, 9, 13, 17, 21, 25, 27];
        assert!(CHANNELS.layout().map(|(start, _)| start).eq(starts));
        assert_eq!(CHANNELS.octets(), 34);
        let configuration = Configuration { outputs: None, inputs: Some(&CHANNELS), octets: &[] };
        assert_eq!((configuration.number(), configuration.output_octets()), (Some(Float), 0));
        static INTEGERS: Telegram = telegram(1, &[Field::ExceptionStatus, Field::ProcessValue(Integer)]);
        let configuration = Configuration { outputs: Some(&TTR_OUT), inputs: Some(&INTEGERS), octets: &[] };
        assert_eq!((configuration.number(), configuration.input_octets()), (Some(Integer), 3));
    }
}
