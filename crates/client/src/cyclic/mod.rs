//! The cyclic data of a slave: the layout of its inputs, and the values in them.

mod channels;
mod integer_range;
mod numbers;
mod quality;

pub(crate) use channels::BLOCK_TYPE;
pub(crate) use channels::whole_range;
pub use channels::{ReportedChannels, open_instances, unranged_instances};
pub use integer_range::IntegerRange;
pub use numbers::{TtrReading, mantissa_number};
pub use quality::Cause;
pub(crate) use quality::ValueStatus;

use crate::gsd;
use crate::pressure::Pressure;
use profivac_devices::Principle;
use profivac_devices::model::{
    Configuration, Counts, Field, HeldPressure, Model, NumberType, PressureFormat, Unit, UserPrm,
};
use profivac_devices::profile::{ExceptionStatus, StatusExtension};
use profivac_devices::reading::Quality;
use profivac_dp::link::Baud;
use profivac_dp::master::SlaveParameters;
use quality::{Evidence, Range};

/// The data that a class 1 master needs to exchange data with a slave.
///
/// ```
/// use profivac_client::cyclic::{ReportedChannels, CyclicSlave};
/// use profivac_devices::catalog::model_named;
/// use profivac_dp::link::Baud;
///
/// let model = model_named("tpg300").ok_or("no such model")?;
/// let unit = model.unit_named("Pascal").ok_or("no such unit")?;
/// let configuration = model.default_configuration;
/// let slave = CyclicSlave { address: 7, model, configuration, unit, channels: ReportedChannels::default() };
/// assert_eq!(slave.parameters(Baud::B19200).cfg, configuration.octets);
/// // 8 octets of the parameter channel, then each channel with its pressure and status.
/// let channel = [&2.5_f32.to_be_bytes()[..], &[0]].concat();
/// let values = slave.decode_inputs(&[vec![0; 8], channel.repeat(4)].concat()).values;
/// assert_eq!(values.first().and_then(|value| value.pa), Some(2.5));
/// // The controller does not report which gauge is connected, and the manual defines its floating point numbers.
/// assert_eq!((slave.principle(1), slave.assumption()), (None, None));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct CyclicSlave {
    /// The address.
    pub address: u8,
    /// The model.
    pub model: &'static Model,
    /// The configuration.
    pub configuration: &'static Configuration,
    /// The unit of its pressures.
    pub unit: &'static Unit,
    /// The principles and ranges of its channels as the device reports them.
    pub channels: ReportedChannels,
}

impl CyclicSlave {
    /// The parameters that preserve the state of the slave at this baud rate: those of its GSD file with the present unit.
    #[must_use]
    pub fn parameters(&self, baud: Baud) -> SlaveParameters<'static> {
        let prm = self.model.user_prm.iter().find(|prm| prm.unit_code() == self.unit.code);
        SlaveParameters {
            user_prm: prm.map_or(&[], |prm: &UserPrm| prm.octets),
            min_interval_tbit: gsd::min_slave_interval_tbit(baud),
            dpv1: self.model.features.dpv1,
            ..SlaveParameters::new(self.address, self.model.ident, self.configuration.octets)
        }
    }

    /// The measuring principle of an instance or channel. `None` where neither the tables nor the device tell it, see
    /// [`ReportedChannels`].
    #[must_use]
    pub fn principle(&self, instance: u8) -> Option<Principle> {
        self.channels.principle(self.model, instance)
    }

    /// Decodes inputs.
    #[must_use]
    pub fn decode_inputs(&self, inputs: &[u8]) -> CyclicValues {
        let fields = Fields { configuration: self.configuration, inputs };
        let exception = ExceptionStatus::from_bits_retain(fields.octet(Field::ExceptionStatus).unwrap_or_default());
        // Bit 7 is always 1 (errata-pxg55x-img400 38, errata-bpg-bcg-tpg 51): without it no gauge has filled the inputs, and 0 is no pressure.
        let is_filled = exception.contains(ExceptionStatus::EXPANDED);
        let is_below = |held: &HeldPressure| matches!(held, HeldPressure::Below(_));
        let values = fields.all().filter_map(|(field, octets)| {
            let (instance, held, status) = match field {
                Field::ProcessValue(number) => {
                    let selector = fields.octet(Field::PvSelector);
                    let instance = selector.unwrap_or(NO_INSTANCE);
                    // chosen: a gauge that measures names its part, so 0 without a part is no pressure below one unit.
                    let is_named = selector != Some(NO_INSTANCE);
                    let is_credible = |held: &HeldPressure| is_filled && is_named || !is_below(held);
                    (instance, self.decode(number, octets, instance).filter(is_credible), fields.gauge_status())
                }
                Field::ChannelValue(channel, number) => {
                    let is_credible = |held: &HeldPressure| is_filled || !is_below(held);
                    (channel, self.decode(number, octets, channel).filter(is_credible), fields.channel_status(channel))
                }
                Field::ChannelMantissa(channel) => {
                    (channel, self.decode_mantissa(octets), fields.channel_status(channel))
                }
                Field::TtrValue => {
                    let TtrReading { has_error, pa, .. } = TtrReading::decode(octets)?;
                    // chosen: two zeros are no pressure, because the value 0 is below the range of each gauge, and a gauge shows the end
                    // of its range there.
                    let held = Some(HeldPressure::Exact(pa)).filter(|_| octets != [0, 0]);
                    (NO_INSTANCE, held, ValueStatus::Ttr { has_error })
                }
                Field::ParameterChannel
                | Field::TransitionCommand
                | Field::SensorOnOff
                | Field::Ignored(_)
                | Field::ExceptionStatus
                | Field::StatusExtension
                | Field::PvSelector
                | Field::MeasurementStatus(_)
                | Field::ChannelStatus
                | Field::TripRelays(_) => return None,
            };
            let others_measure = fields.has_measuring_channel();
            let reported = Reported { instance, held, status, exception, others_measure };
            Some(reported.value(self.model, &self.channels))
        });
        CyclicValues { values: values.collect(), exception }
    }

    /// What the manual leaves open about the numbers of the configuration, as a sentence.
    #[must_use]
    pub fn assumption(&self) -> Option<&'static str> {
        let mut fields = self.configuration.inputs?.fields.iter();
        fields.any(|field| matches!(field, Field::ChannelMantissa(_))).then_some(
            "the manual (i9973ber/a 3.2.4.1) does not define the Inficon floating point format; \
             a whole mantissa times a power of ten is assumed: compare a pressure with the display of the controller",
        )
    }

    /// The pressures that the integers of the configuration show. `None` for floats and for COUNTS.
    #[must_use]
    pub fn integer_range(&self) -> Option<IntegerRange> {
        IntegerRange::of(self.model, self.configuration, self.unit)
    }

    fn decode(&self, number: NumberType, octets: &[u8], instance: u8) -> Option<HeldPressure> {
        self.format(number, self.counts(instance)?).measured(octets)
    }

    fn decode_mantissa(&self, octets: &[u8]) -> Option<HeldPressure> {
        let number = mantissa_number(octets)?;
        self.format(NumberType::Float, CONTROLLER_COUNTS).pa_from_number(number).map(HeldPressure::Exact)
    }

    const fn format(&self, number: NumberType, counts: Counts) -> PressureFormat {
        PressureFormat { unit: self.unit, number, counts, max_integer: self.model.max_integer }
    }

    /// The COUNTS of an instance. Without PV Selector the telegram does not name the active one; those that can be active have the same.
    fn counts(&self, instance: u8) -> Option<Counts> {
        let mut parts = self.model.parts.iter();
        match parts.clone().next() {
            None => Some(CONTROLLER_COUNTS),
            Some(first) if instance == NO_INSTANCE => Some(first.counts),
            Some(_) => parts.find(|spec| spec.part.instance == instance).map(|spec| spec.counts),
        }
    }
}

/// The instance of a telegram that names none.
const NO_INSTANCE: u8 = 0;

/// A controller without ranges in its tables has no COUNTS either.
const CONTROLLER_COUNTS: Counts = Counts::Linear { per_mbar: 1.0 };

/// What a device sends about one instance or channel, cyclically or in its records.
pub(crate) struct Reported {
    /// The instance or channel.
    pub instance: u8,
    /// The number, in Pa. `None` for one that is no pressure.
    pub held: Option<HeldPressure>,
    /// The status of the number.
    pub status: ValueStatus,
    /// Exception Status of the device.
    pub exception: ExceptionStatus,
    /// Another channel of the controller measures.
    pub others_measure: bool,
}

impl Reported {
    /// The reading.
    pub fn value(self, model: &Model, channels: &ReportedChannels) -> ChannelValue {
        let Self { instance, held, status, exception, others_measure } = self;
        let principle = channels.principle(model, instance);
        let range = match status {
            ValueStatus::Ttr { .. } => whole_range(model),
            _ => channels.range(model, instance),
        };
        let range = range.map(Range::from);
        let shows_end = !unranged_instances(model).contains(&instance);
        let has_ion_part = model.parts.iter().any(|spec| spec.part.principle == Principle::HotCathode);
        let evidence = Evidence { status, exception, held, range, principle, shows_end, has_ion_part, others_measure };
        let quality::Verdict { quality, cause, limit_pa } = evidence.verdict();
        ChannelValue { instance, quality, cause, pa: evidence.pa().filter(|_| quality == Quality::Valid), limit_pa }
    }
}

/// Inputs with their layout.
struct Fields<'a> {
    configuration: &'static Configuration,
    inputs: &'a [u8],
}

impl<'a> Fields<'a> {
    fn all(&self) -> impl Iterator<Item = (Field, &'a [u8])> {
        let inputs = self.inputs;
        let layout = self.configuration.inputs.into_iter().flat_map(|telegram| telegram.layout());
        layout.filter_map(move |(start, field)| Some((field, inputs.get(start..)?.get(..field.octets())?)))
    }

    fn octets(&self, wanted: Field) -> Option<&'a [u8]> {
        self.all().find(|(field, _)| *field == wanted).map(|(_, octets)| octets)
    }

    fn octet(&self, wanted: Field) -> Option<u8> {
        self.octets(wanted)?.first().copied()
    }

    /// One Of N Status Extension.
    fn gauge_status(&self) -> ValueStatus {
        let octet = self.octet(Field::StatusExtension);
        octet.map_or(ValueStatus::None, |octet| ValueStatus::Gauge(StatusExtension::from_bits_retain(octet)))
    }

    /// The status of a channel: Measurement Status, i9973ber/a 3.2.4.1, or half an octet of Channel Status, BG 5530 4.4.1.
    fn channel_status(&self, channel: u8) -> ValueStatus {
        if let Some(status) = self.octet(Field::MeasurementStatus(channel)) {
            return ValueStatus::Measurement(status);
        }
        let octets = self.octets(Field::ChannelStatus).unwrap_or_default();
        let Some(octet) = octets.get(usize::from(channel.saturating_sub(1) / 2)) else { return ValueStatus::None };
        let bits = if channel.is_multiple_of(2) { octet >> 4 } else { octet & 0x0F };
        ValueStatus::Channel(StatusExtension::from_bits_retain(bits))
    }

    /// Whether Channel Status declares the reading of any channel valid.
    fn has_measuring_channel(&self) -> bool {
        let nibbles = self.octets(Field::ChannelStatus).unwrap_or_default().iter().flat_map(|it| [it & 0x0F, it >> 4]);
        nibbles.into_iter().any(|bits| !StatusExtension::from_bits_retain(bits).contains(StatusExtension::INVALID))
    }
}

/// The values in the inputs of a slave.
///
/// ```
/// use profivac_client::cyclic::CyclicValues;
/// use profivac_devices::profile::ExceptionStatus;
///
/// let exception = ExceptionStatus::ALARM_DEVICE | ExceptionStatus::WARNING_COMMON;
/// let values = CyclicValues { exception, ..CyclicValues::default() };
/// assert_eq!(values.exceptions(), ["device alarm", "common warning"]);
/// assert_eq!((values.alarms(), values.warnings()), (vec!["device alarm"], vec!["common warning"]));
/// assert!(values.has_fault());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CyclicValues {
    /// The pressures, one for each channel of the configuration.
    pub values: Vec<ChannelValue>,
    /// Exception Status.
    pub exception: ExceptionStatus,
}

/// The reading of a gauge or of a channel.
///
/// ```
/// use profivac_client::cyclic::{Cause, ChannelValue};
/// use profivac_devices::reading::Quality;
///
/// let cause = Some(Cause::GaugeError);
/// let reading = ChannelValue { instance: 2, quality: Quality::Fault, cause, pa: None, limit_pa: None };
/// assert_eq!((reading.is_valid(), reading.pressure()), (false, None));
/// assert_eq!(reading.text(), "fault: the gauge reports an error");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelValue {
    /// The instance or channel, 0 if the inputs do not contain it.
    pub instance: u8,
    /// Whether it is a pressure, and if not, why.
    pub quality: Quality,
    /// The cause of the quality, where the device reports more than the quality.
    pub cause: Option<Cause>,
    /// In Pa. `None` unless it is valid.
    pub pa: Option<f64>,
    /// The end of the range in Pa, or the end of the integers of the telegram, of a pressure below or above it.
    pub limit_pa: Option<f64>,
}

/// The names of the bits of Exception Status and of the status extension.
const EXCEPTIONS: [(ExceptionStatus, &str); 6] = [
    (ExceptionStatus::ALARM_COMMON, "common alarm"),
    (ExceptionStatus::ALARM_DEVICE, "device alarm"),
    (ExceptionStatus::ALARM_MANUFACTURER, "manufacturer alarm"),
    (ExceptionStatus::WARNING_COMMON, "common warning"),
    (ExceptionStatus::WARNING_DEVICE, "device warning"),
    (ExceptionStatus::WARNING_MANUFACTURER, "manufacturer warning"),
];

const EXTENSIONS: [(StatusExtension, &str); 3] = [
    (StatusExtension::INVALID, "invalid"),
    (StatusExtension::OVER, "overrange"),
    (StatusExtension::UNDER, "underrange"),
];

impl ChannelValue {
    /// The pressure with its units. `None` unless the value is valid.
    #[must_use]
    pub fn pressure(&self) -> Option<Pressure> {
        self.pa.map(Pressure::from_pa)
    }

    /// Whether the pressure is a measured one.
    #[must_use]
    pub const fn is_valid(&self) -> bool {
        matches!(self.quality, Quality::Valid)
    }

    /// The words for users: `valid`, `under range`, `fault: device alarm`.
    #[must_use]
    pub fn text(&self) -> String {
        let label = self.quality.label();
        self.cause.map_or_else(|| label.to_owned(), |cause| format!("{label}: {cause}"))
    }
}

/// The set bits of a status extension by name.
///
/// ```
/// use profivac_client::cyclic::extension_texts;
/// use profivac_devices::profile::StatusExtension;
///
/// assert_eq!(extension_texts(StatusExtension::INVALID | StatusExtension::UNDER), ["invalid", "underrange"]);
/// ```
#[must_use]
pub fn extension_texts(status: StatusExtension) -> Vec<&'static str> {
    EXTENSIONS.into_iter().filter(|(bit, _)| status.contains(*bit)).map(|(_, word)| word).collect()
}

/// The set bits of an Exception Status by name.
///
/// ```
/// use profivac_client::cyclic::exception_texts;
/// use profivac_devices::profile::ExceptionStatus;
///
/// assert_eq!(exception_texts(ExceptionStatus::WARNING_DEVICE), ["device warning"]);
/// ```
#[must_use]
pub fn exception_texts(exception: ExceptionStatus) -> Vec<&'static str> {
    EXCEPTIONS.into_iter().filter(|(bit, _)| exception.contains(*bit)).map(|(_, word)| word).collect()
}

impl Default for CyclicValues {
    /// No values.
    fn default() -> Self {
        Self { values: Vec::new(), exception: ExceptionStatus::empty() }
    }
}

impl CyclicValues {
    /// The set bits of the Exception Status by name.
    #[must_use]
    pub fn exceptions(&self) -> Vec<&'static str> {
        exception_texts(self.exception)
    }

    /// The alarms by name: defects of the device.
    #[must_use]
    pub fn alarms(&self) -> Vec<&'static str> {
        exception_texts(self.exception & ExceptionStatus::ALARM)
    }

    /// The warnings by name, without those that the qualities of the values explain: a device warning reports also that a
    /// reading is out of range or invalid (errata-bpg-bcg-tpg 44, errata-pxg55x-img400 126).
    #[must_use]
    pub fn warnings(&self) -> Vec<&'static str> {
        let mut warnings = self.exception.difference(ExceptionStatus::ALARM);
        if self.values.iter().any(|value| value.quality != Quality::Valid) {
            warnings.remove(ExceptionStatus::WARNING_DEVICE);
        }
        exception_texts(warnings)
    }

    /// Whether the device or one of its channels has a defect.
    #[must_use]
    pub fn has_fault(&self) -> bool {
        !self.alarms().is_empty() || self.values.iter().any(|value| value.quality == Quality::Fault)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::bcg450::table::MODEL;
    use profivac_devices::catalog::{MODELS, model_named};
    use profivac_devices::model::MeasuringRange;

    fn slave(configuration: usize, unit: &str) -> CyclicSlave {
        let unit = MODEL.unit_named(unit).unwrap();
        CyclicSlave {
            address: 5,
            model: &MODEL,
            configuration: &MODEL.configurations[configuration],
            unit,
            channels: ReportedChannels::default(),
        }
    }

    #[test]
    fn inputs_are_decoded_in_every_layout_and_unit() {
        let float = |value: f32| value.to_be_bytes().to_vec();
        for (configuration, unit, value, pa) in [
            (1, "mbar", float(1e-3), 0.1),
            (1, "Torr", float(1.0), 133.322),
            (5, "Pascal", float(2.5), 2.5),
            (0, "Micron", vec![0x03, 0xE8], 133.322),
            // COUNTS: 10^(25000/2000 - 12.5) mbar
            (4, "COUNTS", 25_000_u16.to_be_bytes().to_vec(), 100.0),
        ] {
            let channel = if configuration > 3 { vec![0; 8] } else { Vec::new() };
            let inputs = [channel, vec![0x80, 0x00, 0x02], value].concat();
            let CyclicValues { values, exception } = slave(configuration, unit).decode_inputs(&inputs);
            let [ChannelValue { instance: 2, pa: Some(read), quality, .. }] = &values[..] else { panic!("{values:?}") };
            assert!((read / pa - 1.0).abs() < 1e-5, "{configuration} {unit}: {read}");
            assert_eq!((exception, *quality), (ExceptionStatus::EXPANDED, Quality::Valid));
        }
    }

    #[test]
    fn an_invalid_value_has_no_pressure_but_a_quality() {
        let reading = slave(1, "mbar").decode_inputs(&[0xA2, 0x03, 0x02, 0x44, 0x7A, 0x00, 0x00]);
        let [value] = &reading.values[..] else { panic!("{reading:?}") };
        assert_eq!((value.instance, value.pa, value.text()), (2, None, "fault: device alarm".to_owned()));
        assert_eq!(reading.exceptions(), ["device alarm", "device warning"]);
        assert_eq!(slave(1, "mbar").decode_inputs(&[]), CyclicValues::default());
    }

    /// errata-bpg-bcg-tpg 3 and 70, errata-pxg55x-img400 15 and 16: 32767 or 65535 stands for all above, 0 for less than one unit.
    #[test]
    fn an_integer_is_a_pressure_only_between_its_two_ends() {
        let mut configurations = 0;
        for model in MODELS {
            let with_integers = |it: &&Configuration| it.number() == Some(NumberType::Integer);
            for (configuration, unit) in model
                .configurations
                .iter()
                .filter(with_integers)
                .flat_map(|configuration| model.units.iter().map(move |unit| (configuration, unit)))
            {
                let channels = ReportedChannels::default();
                let slave = CyclicSlave { address: 5, model, configuration, unit, channels };
                let telegram = configuration.inputs.unwrap();
                let is_log = unit.scale == profivac_devices::model::Scale::Counts;
                let quality = |word: u16, instance: u8| {
                    let mut inputs = vec![0; telegram.octets()];
                    for (start, field) in telegram.layout() {
                        match field {
                            Field::ProcessValue(_) | Field::ChannelValue(..) => {
                                inputs[start..start + 2].copy_from_slice(&word.to_be_bytes());
                            }
                            Field::PvSelector => inputs[start] = instance,
                            Field::ExceptionStatus => inputs[start] = ExceptionStatus::EXPANDED.bits(),
                            _ => {}
                        }
                    }
                    let values = slave.decode_inputs(&inputs).values;
                    let all: Vec<_> = values.iter().map(|value| (value.quality, value.cause)).collect();
                    assert!(all.iter().all(|one| *one == all[0]), "{}: {all:?}", model.name);
                    (all[0], values[0].limit_pa)
                };
                let context = format!("{} {:02X?} {}", model.name, configuration.octets, unit.name);
                let (highest, zero) = (quality(model.max_integer, 1), quality(0, 1));
                assert_eq!(highest.0, (Quality::Overrange, Some(Cause::HighestInteger)), "{context}");
                if is_log {
                    assert_eq!(zero, ((Quality::Fault, Some(Cause::NoPressure)), None), "{context}");
                } else {
                    let per_mbar = |number: f64| format_of(unit).pa_from_number(number).unwrap();
                    assert_eq!(highest.1, Some(per_mbar(model.max_integer.into())), "{context}");
                    assert_eq!(zero.0, (Quality::Underrange, Some(Cause::BelowOneUnit)), "{context}");
                    assert_eq!(zero.1, Some(per_mbar(1.0)), "{context}");
                }
                for word in [1, 2, model.max_integer - 1] {
                    assert_eq!(quality(word, 1), ((Quality::Valid, None), None), "{context}: {word}");
                }
                for word in [32_768, 40_000, u16::MAX].into_iter().filter(|word| *word > model.max_integer) {
                    let no_pressure = ((Quality::Fault, Some(Cause::NoPressure)), None);
                    assert_eq!(quality(word, 1), no_pressure, "{context}: {word}");
                }
                if telegram.fields.contains(&Field::PvSelector) {
                    assert_eq!(quality(0, NO_INSTANCE).0, (Quality::Fault, Some(Cause::NoPressure)), "{context}");
                }
                configurations += 1;
            }
        }
        assert!(configurations > 150, "{configurations}");
    }

    /// The buffers of a gateway or of an ASIC hold zeros until the gauge has filled them. Bit 7 of Exception Status is always 1
    /// (errata-pxg55x-img400 38), and no gauge shows the TTR value 0, which is below the range of each.
    #[test]
    fn inputs_that_no_gauge_has_filled_are_no_pressure_and_no_bound_of_one() {
        let mut decoded = 0;
        for model in MODELS {
            for (configuration, unit) in
                model.configurations.iter().flat_map(|it| model.units.iter().map(move |unit| (it, unit)))
            {
                let channels = ReportedChannels::default();
                let slave = CyclicSlave { address: 5, model, configuration, unit, channels };
                for value in slave.decode_inputs(&vec![0; configuration.input_octets()]).values {
                    let context = format!("{} {:02X?} in {}: {value:?}", model.name, configuration.octets, unit.name);
                    assert_eq!((value.quality, value.cause), (Quality::Fault, Some(Cause::NoPressure)), "{context}");
                    assert_eq!((value.pa, value.limit_pa), (None, None), "{context}");
                    decoded += 1;
                }
            }
        }
        assert!(decoded > 800, "{decoded}");
    }

    fn format_of(unit: &'static Unit) -> PressureFormat {
        PressureFormat { unit, number: NumberType::Float, counts: CONTROLLER_COUNTS, max_integer: u16::MAX }
    }

    /// A gauge that is below its range says so; the end of its range is a closer bound than one unit.
    #[test]
    fn the_status_of_a_gauge_counts_more_than_the_ends_of_its_integer() {
        let reading = |status: u8, word: u16, unit| {
            let [high, low] = word.to_be_bytes();
            slave(4, unit).decode_inputs(&[vec![0; 8], vec![0x80, status, 2, high, low]].concat()).values[0]
        };
        let under = reading(StatusExtension::UNDER.bits(), 0, "mbar");
        assert_eq!((under.quality, under.cause), (Quality::Underrange, None));
        assert!((under.limit_pa.unwrap() / 5e-8 - 1.0).abs() < 1e-9, "{under:?}");
        let off = reading(StatusExtension::INVALID.bits(), 0, "mbar");
        assert_eq!(
            (off.quality, off.limit_pa),
            (Quality::Off, None),
            "a Safe State of zero is no pressure below 1 mbar"
        );
    }

    /// 830 x 10^-5 mbar is the example of errata-bpg-bcg-tpg 126; errata-pxg55x-img400 50 has the formula of the TTR value.
    #[test]
    fn mantissas_and_ttr_values_are_pressures() {
        let model = &profivac_devices::tpg::table::TPG300;
        let (configuration, unit) = (&model.configurations[8], model.unit_named("mbar").unwrap());
        let slave = CyclicSlave { address: 7, model, configuration, unit, channels: ReportedChannels::default() };
        let channels = [[0x03, 0x3E, 0xFB, 0], [0x00, 0x64, 0x01, 0], [0x02, 0x0D, 0xF7, 1], [0, 0, 0, 5]].concat();
        let values = slave.decode_inputs(&[vec![0; 8], channels].concat()).values;
        let shown: Vec<_> = values.iter().map(|it| (it.instance, it.quality, it.pa.map(|pa| pa as f32))).collect();
        let expected = [
            (1, Quality::Valid, Some(0.83)),
            (2, Quality::Valid, Some(100_000.0)),
            (3, Quality::Underrange, None),
            (4, Quality::Missing, None),
        ];
        assert_eq!(shown, expected);
        assert!(slave.assumption().is_some_and(|it| it.contains("i9973ber/a 3.2.4.1")));
        let torr = CyclicSlave { unit: model.unit_named("Torr").unwrap(), ..slave };
        let read = torr.decode_inputs(&[vec![0; 8], [0x03, 0x3E, 0xFB, 0].repeat(4)].concat()).values[0].pa.unwrap();
        assert!((read / (8.3e-3 * 133.322_4) - 1.0).abs() < 1e-4, "{read}");

        for name in ["pcg550", "psg550"] {
            let model = model_named(name).unwrap();
            let configuration = model.configurations.iter().find(|it| it.octets == [0xA1, 0x91]).unwrap();
            for unit in model.units {
                let slave =
                    CyclicSlave { address: 7, model, configuration, unit, channels: ReportedChannels::default() };
                let value = |octets: [u8; 2]| slave.decode_inputs(&octets).values[0];
                assert_eq!(slave.decode_inputs(&[0x48, 0xFF]).values.len(), 1, "{name}");
                assert!((value([0x48, 0xFF]).pa.unwrap() / 100.0 - 1.0).abs() < 0.003, "1 mbar in {}", unit.name);
                assert_eq!(value([0x88, 0xFF]).text(), "fault: the gauge reports an error");
                assert_eq!((value([0, 1]).quality, value([0, 1]).pa), (Quality::Underrange, None));
                assert_eq!(value([0x0F, 0xFF]).quality, Quality::Overrange);
                assert_eq!(slave.assumption(), None);
            }
        }
    }

    /// Telegrams 1, 2, 7, 8 and 201 to 204 of the PCG55x and PSG55x have no PV Selector.
    #[test]
    fn a_pressure_without_pv_selector_is_decoded() {
        let mut decoded = 0;
        for model in MODELS.iter().filter(|model| !model.parts.is_empty()) {
            for configuration in model.configurations {
                let Some(inputs) = configuration.inputs else { continue };
                let has = |wanted| inputs.layout().find(|(_, field)| *field == wanted).map(|(start, _)| start);
                let (Some(start), None) = (has(Field::ProcessValue(NumberType::Float)), has(Field::PvSelector)) else {
                    continue;
                };
                let unit = model.unit_named("mbar").unwrap();
                let slave =
                    CyclicSlave { address: 7, model, configuration, unit, channels: ReportedChannels::default() };
                let mut octets = vec![0; inputs.octets()];
                octets[start..start + 4].copy_from_slice(&2.5_f32.to_be_bytes());
                let value = slave.decode_inputs(&octets).values[0];
                assert_eq!(
                    (value.quality, value.pa),
                    (Quality::Valid, Some(250.0)),
                    "{} {}",
                    model.name,
                    inputs.number
                );
                decoded += 1;
            }
        }
        // Telegrams 2, 8, 202 and 204 of six models.
        assert_eq!(decoded, 24);
    }

    /// Telegram 202 of the IMG 400: channel 2 is overrange, channel 3 invalid.
    #[test]
    fn every_channel_of_a_controller_has_its_own_value() {
        let model = &profivac_devices::img400::table::MODEL;
        let (configuration, unit) = (&model.configurations[9], model.unit_named("mbar").unwrap());
        let slave = CyclicSlave { address: 7, model, configuration, unit, channels: ReportedChannels::default() };
        let values = [1e-8_f32, 1e-2, 1e-3, 5.0].map(f32::to_be_bytes).concat();
        let inputs = [&[0x80][..], &values, &[0x20, 0x01], &[0; 7]].concat();
        let reading = slave.decode_inputs(&inputs);
        let qualities: Vec<_> = reading.values.iter().map(|value| (value.instance, value.quality)).collect();
        let expected = [Quality::Valid, Quality::Overrange, Quality::Missing, Quality::Valid];
        assert_eq!(qualities, [1, 2, 3, 4].into_iter().zip(expected).collect::<Vec<_>>());
        assert_eq!(reading.values[1].limit_pa, None, "the manual has no ranges of the gauges");
        let range = MeasuringRange { lowest_pa: 1e-10, highest_pa: 1e-2 };
        let slave = CyclicSlave { channels: ReportedChannels::default().with_range(2, range), ..slave };
        let reading = slave.decode_inputs(&inputs);
        assert_eq!(reading.values[1].limit_pa, Some(1e-2), "the device has reported its range");
        assert!((reading.values[3].pa.unwrap() - 500.0).abs() < 1e-9);
    }

    #[test]
    fn a_measurement_status_declares_the_validity_of_a_channel() {
        let model = &profivac_devices::tpg::table::TPG300;
        let (configuration, unit) = (model.default_configuration, model.unit_named("Pascal").unwrap());
        let slave = CyclicSlave { address: 7, model, configuration, unit, channels: ReportedChannels::default() };
        let channel = |pressure: f32, status: u8| [&pressure.to_be_bytes()[..], &[status]].concat();
        let channels = [channel(2.5, 0), channel(1e-3, 1), channel(5.0, 3), channel(0.0, 5)].concat();
        let reading = slave.decode_inputs(&[vec![0; 8], channels].concat());
        let qualities: Vec<_> = reading.values.iter().map(|value| (value.instance, value.quality)).collect();
        let expected = [Quality::Valid, Quality::Underrange, Quality::Fault, Quality::Missing];
        assert_eq!(qualities, [1, 2, 3, 4].into_iter().zip(expected).collect::<Vec<_>>());
        assert_eq!((reading.values[1].pa, reading.values[1].limit_pa.map(|pa| pa as f32)), (None, Some(1e-3)));
        assert_eq!(reading.values[0].pa, Some(2.5));
    }

    #[test]
    fn the_parameters_preserve_the_unit_and_the_configuration() {
        for (prm, unit) in MODEL.user_prm.iter().zip(MODEL.units) {
            let slave = slave(1, unit.name);
            let parameters = slave.parameters(Baud::B19200);
            assert_eq!((parameters.user_prm, parameters.cfg), (prm.octets, MODEL.configurations[1].octets));
        }
    }

    /// As the GSD files have it: Min_Slave_Intervall is 10 times 100 us, and the two oldest controllers have no DP-V1.
    #[test]
    fn the_parameters_are_those_of_the_gsd_file() {
        for model in MODELS {
            let Some(unit) = model.units.first() else { continue };
            let slave = CyclicSlave {
                address: 5,
                model,
                configuration: model.default_configuration,
                unit,
                channels: ReportedChannels::default(),
            };
            let file = gsd::gsd(model);
            let value_of =
                |keyword: &str| file.lines().find_map(|it| it.strip_prefix(keyword)?.trim().strip_prefix("= "));
            assert_eq!(value_of("Min_Slave_Intervall"), Some("10"), "{}", model.name);
            for (baud, tbit) in
                [(Baud::B9600, 10), (Baud::B19200, 20), (Baud::B1500000, 1500), (Baud::B12000000, 12_000)]
            {
                assert_eq!(slave.parameters(baud).min_interval_tbit, tbit, "{} at {baud}", model.name);
            }
            assert_eq!(slave.parameters(Baud::B19200).dpv1, value_of("DPV1_Slave") == Some("1"), "{}", model.name);
        }
    }
}
