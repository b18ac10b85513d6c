//! The function blocks in structured text, parsed by blark and executed: the decoders agree with [`CyclicSlave::decode_inputs`], and
//! the block for the parameter channel reads and writes parameters of the simulated devices.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

mod blocks;
mod constructs;
mod names;
mod page;
#[cfg(feature = "plcopen")]
mod plcopen;

use blocks::{Blocks, Outputs};
use profivac_client::cyclic::{CyclicSlave, ReportedChannels};
use profivac_client::st::{Dialect, st};
use profivac_devices::bcg450::Bcg450;
use profivac_devices::catalog::{MODELS, model_named};
use profivac_devices::model::{Configuration, Field, Model, NumberType, Scale, Telegram, Unit};
use profivac_devices::profile::Setup;
use profivac_devices::store::RamStore;
use profivac_devices::tpg::{Tpg, TpgGauge};
use profivac_devices::{SimulatedDevice, reading::Quality};
use profivac_dp::slave::Outputs as DeviceOutputs;
use std::collections::BTreeSet;

/// The numbers that every float and word takes: pressures in all units and COUNTS, and numbers that are none.
const NUMBERS: [f32; 18] = [
    2.5e-10,
    5.1e-10,
    3e-7,
    5.52e-3,
    5.54e-3,
    0.3,
    1.0,
    99.5,
    999.0,
    1.5e3,
    2.0e4,
    3.1e4,
    6.5e4,
    0.0,
    -1.0,
    f32::INFINITY,
    f32::NAN,
    2e30,
];

/// The words of integers: both ends of each format, and the words beside and beyond them.
const WORDS: [u16; 13] = [0, 1, 32767, 25_000, 65535, 2, 32766, 300, 65534, 7000, 32768, 20_480, 31_000];

const STATUSES: [u8; 8] = [0, 1, 2, 3, 4, 5, 6, 7];
/// Bit 7 is 0 in inputs that no gauge has filled.
const EXCEPTIONS: [u8; 8] = [0x80, 0x00, 0x81, 0x82, 0x84, 0x90, 0xA0, 0xC0];
const INSTANCES: [u8; 6] = [0, 1, 2, 3, 4, 9];

/// The inputs number `number`: every combination of number, status, exception and instance occurs, because the lengths of the lists
/// have no common factor with the steps.
fn inputs(telegram: &Telegram, number: usize) -> Vec<u8> {
    let mut inputs = vec![0; telegram.octets()];
    for (position, (start, field)) in telegram.layout().enumerate() {
        let turn = number.wrapping_mul(position.wrapping_mul(2).wrapping_add(1)).wrapping_add(number / 7);
        let of = |list: &[u8]| list[turn % list.len()];
        let value = NUMBERS[turn % NUMBERS.len()];
        let octets: Vec<u8> = match field {
            Field::ProcessValue(NumberType::Float) | Field::ChannelValue(_, NumberType::Float) => {
                value.to_be_bytes().to_vec()
            }
            Field::ProcessValue(_) | Field::ChannelValue(..) => WORDS[turn % WORDS.len()].to_be_bytes().to_vec(),
            Field::ChannelMantissa(_) => vec![[0x03, 0x00, 0xFF][turn % 3], 0x3E, [0xFB, 0x00, 0x03, 0xF6][turn % 4]],
            Field::TtrValue => vec![[0x00, 0x08, 0x83, 0x0F, 0x05][turn % 5], [0x00, 0x41, 0xFF][turn % 3]],
            Field::ExceptionStatus => vec![of(&EXCEPTIONS)],
            Field::StatusExtension | Field::MeasurementStatus(_) => vec![of(&STATUSES)],
            Field::ChannelStatus => {
                vec![of(&STATUSES) << 4 | of(&[1, 0, 2, 1, 4]), of(&STATUSES) | of(&[0x10, 0, 0x10])]
            }
            Field::PvSelector => vec![of(&INSTANCES)],
            Field::TripRelays(count) => (0..count).map(|relay| u8::from(turn >> relay & 1 == 1)).collect(),
            field => vec![0xA5; field.octets()],
        };
        inputs[start..start + octets.len()].copy_from_slice(&octets);
    }
    inputs
}

/// The configurations of a model with different telegrams that have a pressure.
fn configurations(model: &'static Model) -> Vec<&'static Configuration> {
    let mut found: Vec<&Configuration> = Vec::new();
    for configuration in model.configurations {
        let has_pressure =
            st(model, Dialect::Standard).contains(&format!("FUNCTION_BLOCK {}\n", name(model, configuration)));
        if has_pressure && !found.iter().any(|other| other.inputs == configuration.inputs) {
            found.push(configuration);
        }
    }
    found
}

fn name(model: &Model, configuration: &Configuration) -> String {
    let number = configuration.inputs.map_or(0, |telegram| telegram.number);
    format!("PV_{}_T{number}", model.name.to_uppercase())
}

/// The text of one block.
fn block(model: &Model, name: &str) -> String {
    let text = st(model, Dialect::Standard);
    let (_, text) = text.split_once(&format!("FUNCTION_BLOCK {name}\n")).unwrap();
    let (text, _) = text.split_once("END_FUNCTION_BLOCK").unwrap();
    format!("FUNCTION_BLOCK {name}\n{text}END_FUNCTION_BLOCK\n")
}

/// Compares one call of a block with the decoder of the master.
fn agrees(blocks: &mut Blocks, slave: &CyclicSlave, octets: &[u8]) -> Vec<Quality> {
    let name = name(slave.model, slave.configuration);
    let ttr = slave.configuration.inputs.is_some_and(|inputs| inputs.fields.contains(&Field::TtrValue));
    let unit = if ttr { String::new() } else { format!("UNIT={}", slave.unit.code) };
    let outputs =
        blocks.call(&name, "a", &format!("EXCHANGING=1 SUBSTITUTE_PA=-7 {unit} OCTETS={}", blocks::hex(octets)));
    let expected = slave.decode_inputs(octets);
    let context = || format!("{name} {} {octets:02X?}: {outputs:?}, expected {expected:?}", slave.unit.name);
    let (qualities, pressures) = (outputs.numbers("QUALITY"), outputs.numbers("PRESSURE_PA"));
    assert_eq!(qualities.len(), expected.values.len(), "{}", context());
    for ((value, quality), pressure) in expected.values.iter().zip(qualities).zip(pressures) {
        assert!((quality - f64::from(value.quality as u8)).abs() < 0.5, "{}", context());
        let pa = value.pa.unwrap_or(-7.0);
        // Below 1e-30 Pa a REAL has no digits left.
        assert!((pressure - pa).abs() <= pa.abs() * 1e-4 || (pressure.max(pa) < 2e-30 && pa > 0.0), "{}", context());
    }
    if slave.configuration.inputs.is_some_and(|inputs| inputs.fields.contains(&Field::ExceptionStatus)) {
        assert_eq!(outputs.number("ALARM") > 0.0, !expected.alarms().is_empty(), "{}", context());
    }
    expected.values.iter().map(|value| value.quality).collect()
}

fn slave(model: &'static Model, configuration: &'static Configuration, unit: &'static Unit) -> CyclicSlave {
    CyclicSlave { address: 5, model, configuration, unit, channels: ReportedChannels::default() }
}

/// The inputs in which COUNTS lie far beyond any gauge are left out: a REAL of a PLC has no room for the pressure.
fn is_comparable(unit: &Unit, telegram: &Telegram, octets: &[u8]) -> bool {
    let floats = telegram.layout().filter_map(|(start, field)| match field {
        Field::ProcessValue(NumberType::Float) | Field::ChannelValue(_, NumberType::Float) => {
            Some(f32::from_be_bytes(octets[start..start + 4].try_into().unwrap()))
        }
        _ => None,
    });
    unit.scale != Scale::Counts || floats.into_iter().all(|number| !number.is_finite() || number.abs() < 1e5)
}

/// Compares all inputs of a configuration in a unit; the qualities that occurred.
fn every_input(blocks: &mut Blocks, slave: &CyclicSlave) -> Vec<Quality> {
    let telegram = slave.configuration.inputs.unwrap();
    let zeros = std::iter::once(vec![0; telegram.octets()]);
    let all = (0..70).map(|number| inputs(telegram, number)).chain(zeros);
    let comparable = all.filter(|octets| is_comparable(slave.unit, telegram, octets));
    comparable.flat_map(|octets| agrees(blocks, slave, &octets)).collect()
}

#[test]
fn every_kind_of_decoder_agrees_with_the_master() {
    let mut seen = BTreeSet::new();
    let mut executed = BTreeSet::new();
    for model in MODELS {
        // Blocks that differ in numbers alone, such as places and ranges, are of one kind. Parsing takes a second for each, so one of a
        // kind is executed: the last, which has a parameter channel before the pressure.
        for configuration in configurations(model).into_iter().rev() {
            let text = block(model, &name(model, configuration));
            let (_, statements) = text.split_once("*)").unwrap();
            if executed.insert(statements.replace(|character: char| character.is_ascii_digit() || character == '.', ""))
            {
                let mut blocks = Blocks::start(&text);
                for unit in model.units {
                    seen.extend(every_input(&mut blocks, &slave(model, configuration, unit)));
                }
            }
        }
    }
    let all = [Quality::Valid, Quality::Overrange, Quality::Underrange, Quality::Fault, Quality::Off, Quality::Missing];
    assert!(seen.into_iter().eq(all), "every quality of a decoder occurs");
}

#[test]
fn a_slave_that_does_not_exchange_data_and_an_unknown_unit_have_no_pressure() {
    let mut blocks = Blocks::start(&block(model_named("bcg450").unwrap(), "PV_BCG450_T5"));
    let octets = "OCTETS=00000240A00000";
    let outputs = blocks.call("PV_BCG450_T5", "a", octets);
    assert_eq!((outputs.number("VALID"), outputs.number("QUALITY")), (0.0, 4.0), "not exchanging is the default");
    assert_eq!((outputs.number("PRESSURE_PA"), outputs.number("PRESSURE_MBAR")), (101_325.0, 1013.25));
    let outputs = blocks.call("PV_BCG450_T5", "a", "EXCHANGING=1 UNIT=1300");
    assert_eq!((outputs.number("VALID"), outputs.number("QUALITY")), (0.0, 3.0));
    let outputs = blocks.call("PV_BCG450_T5", "a", "UNIT=1309");
    assert_eq!((outputs.number("VALID"), outputs.number("PRESSURE_PA"), outputs.number("INSTANCE")), (1.0, 5.0, 2.0));
}

#[test]
fn the_relays_of_a_telegram_are_outputs() {
    let mut blocks = Blocks::start(&block(model_named("pcg550").unwrap(), "PV_PCG550_T202"));
    let outputs = blocks.call("PV_PCG550_T202", "a", "EXCHANGING=1 OCTETS=003F800000000001");
    assert_eq!(outputs.numbers("RELAY"), [0.0, 1.0]);
}

/// A device in data exchange with a PLC program that uses the block for its parameter channel.
struct Plc<D> {
    device: D,
    blocks: Blocks,
    name: &'static str,
    inputs: usize,
    /// Octets of the outputs behind the parameter channel.
    rest: usize,
    answer: String,
    calls: usize,
}

impl<D: SimulatedDevice> Plc<D> {
    fn new(mut device: D, device_name: &str, name: &'static str, prm: &[u8], cfg: &[u8]) -> Self {
        device.settle();
        device.set_prm(prm).unwrap();
        device.chk_cfg(cfg).unwrap();
        device.set_exchanging(true);
        let model = model_named(device_name).unwrap();
        let blocks = Blocks::start(&block(model, name));
        let configuration = model.configuration(cfg).unwrap();
        let rest = configuration.output_octets() - 8;
        Self { device, blocks, name, inputs: configuration.input_octets(), rest, answer: "00".repeat(8), calls: 0 }
    }

    /// One cycle of the PLC: the block, then the outputs and inputs of the device.
    fn cycle(&mut self, settings: &str) -> Outputs {
        let settings = format!("EXCHANGING=1 RESPONSE={} {settings}", self.answer);
        let outputs = self.blocks.call(self.name, "a", &settings);
        let mut request: Vec<u8> = outputs.numbers("REQUEST").into_iter().map(|octet| octet as u8).collect();
        request.extend(vec![0; self.rest]);
        self.device.outputs(DeviceOutputs::Data(&request));
        let mut inputs = vec![0; self.inputs];
        self.device.inputs(&mut inputs);
        self.answer = blocks::hex(&inputs[..8]);
        self.calls += 1;
        outputs
    }

    /// Executes a task and returns the outputs when it has ended.
    fn task(&mut self, settings: &str) -> Outputs {
        let mut outputs = self.cycle(&format!("EXECUTE=1 {settings}"));
        for _ in 0..20 {
            if outputs.number("BUSY") == 0.0 {
                break;
            }
            outputs = self.cycle("");
        }
        assert_eq!(outputs.number("DONE") + outputs.number("ERROR"), 1.0, "{settings}: {outputs:?}");
        let ended = self.cycle("EXECUTE=0 WRITE=0 IS_REAL=0");
        assert_eq!((ended.number("DONE"), ended.number("ERROR"), ended.number("BUSY")), (0.0, 0.0, 0.0));
        outputs
    }
}

fn gauge() -> Plc<Bcg450<RamStore>> {
    let cfg = [0xC6, 0x87, 0x8E, 0x0A, 0x0A, 0x05, 0x05, 0x05, 0x08];
    let device = Bcg450::new(RamStore::default(), Setup::new(5));
    Plc::new(device, "bcg450", "PV_BCG450_CHANNEL", &[0, 0, 0, 0x05, 0x1C], &cfg)
}

#[test]
fn the_channel_block_reads_and_writes_parameters_of_a_gauge() {
    let mut plc = gauge();
    let state = plc.task("SLOT=0 INDEX=25");
    assert_eq!((state.number("DONE"), state.number("RESULT_LENGTH"), state.number("RESULT_WHOLE")), (1.0, 1.0, 4.0));
    let unit = plc.task("SLOT=1 INDEX=22");
    assert_eq!((unit.number("RESULT_LENGTH"), unit.number("RESULT_WHOLE")), (2.0, 1308.0));
    // Channel Instance Selector: the Pirani, which has a Safe Value.
    plc.task("WRITE=1 SLOT=1 INDEX=46 LENGTH=1 WHOLE=1");
    for number in [1.5e-3_f32, 0.0, 999.9] {
        let written = plc.task(&format!("WRITE=1 IS_REAL=1 SLOT=1 INDEX=40 LENGTH=4 NUMBER={number}"));
        assert_eq!(written.number("DONE"), 1.0, "{written:?}");
        let read = plc.task("SLOT=1 INDEX=40");
        assert_eq!((read.number("RESULT_LENGTH"), read.number("RESULT_NUMBER") as f32), (4.0, number));
    }
    plc.task("WRITE=1 SLOT=1 INDEX=46 LENGTH=1 WHOLE=5");
    let percentage = plc.task("WRITE=1 SLOT=1 INDEX=202 LENGTH=2 WHOLE=500");
    assert_eq!((percentage.number("DONE"), percentage.number("RESULT_WHOLE")), (1.0, 500.0), "{percentage:?}");
}

#[test]
fn the_channel_block_reports_a_refusal_with_the_code_of_the_device() {
    let mut plc = gauge();
    let refused = plc.task("SLOT=0 INDEX=99");
    assert_eq!((refused.number("ERROR"), refused.number("ERROR_CODE")), (1.0, 3.0));
    let refused = plc.task("WRITE=1 SLOT=0 INDEX=25 LENGTH=1 WHOLE=1");
    assert_eq!((refused.number("ERROR"), refused.number("ERROR_CODE")), (1.0, 1.0));
}

#[test]
fn the_channel_block_works_with_a_controller() {
    let gauges =
        [Some(TpgGauge::Pirani), Some(TpgGauge::Pirani), Some(TpgGauge::ColdCathode), Some(TpgGauge::ColdCathode)];
    let model = model_named("tpg500").unwrap();
    let device = Tpg::new(model, <RamStore>::default(), Setup::new(5), gauges);
    let configuration =
        model.configurations.iter().find(|one| one.inputs.is_some_and(|inputs| inputs.octets() > 8)).unwrap();
    let mut plc = Plc::new(device, "tpg500", "PV_TPG500_CHANNEL", &[], configuration.octets);
    let unit = plc.task("WRITE=1 SLOT=1 INDEX=22 LENGTH=1 WHOLE=2");
    assert_eq!((unit.number("DONE"), unit.number("RESULT_WHOLE")), (1.0, 2.0), "{unit:?}");
    // A threshold can be written while the set is open: IF300P/IF301P manual 3.2.4.2, errata-bpg-bcg-tpg 136 to 138.
    let upper = "WRITE=1 IS_REAL=1 SLOT=10 INDEX=21 LENGTH=4 NUMBER=0.002";
    let refused = plc.task(upper);
    assert_eq!((refused.number("ERROR"), refused.number("ERROR_CODE")), (1.0, 17.0), "{refused:?}");
    plc.task("WRITE=1 SLOT=10 INDEX=20 LENGTH=1 WHOLE=0");
    let threshold = plc.task(upper);
    assert_eq!((threshold.number("DONE"), threshold.number("RESULT_NUMBER") as f32), (1.0, 0.002), "{threshold:?}");
    for settings in ["IS_REAL=1 INDEX=22 LENGTH=4 NUMBER=0.001", "INDEX=20 LENGTH=1 WHOLE=1"] {
        let written = plc.task(&format!("WRITE=1 SLOT=10 {settings}"));
        assert_eq!(written.number("DONE"), 1.0, "{settings}: {written:?}");
    }
}

#[test]
fn the_channel_block_refuses_inputs_that_do_not_fit_and_sends_nothing() {
    let mut plc = gauge();
    for settings in [
        "WRITE=1 SLOT=1 INDEX=46 LENGTH=3 WHOLE=1",
        "WRITE=1 SLOT=1 INDEX=46 LENGTH=1 WHOLE=256",
        "WRITE=1 SLOT=1 INDEX=46 LENGTH=2 WHOLE=65536",
        "WRITE=1 SLOT=1 INDEX=46 LENGTH=2 IS_REAL=1 NUMBER=1",
        "WRITE=1 SLOT=1 INDEX=46 LENGTH=4 IS_REAL=1 NUMBER=inf",
        "WRITE=1 SLOT=1 INDEX=46 LENGTH=4 IS_REAL=1 NUMBER=-inf",
        "SLOT=256 INDEX=46",
        "SLOT=1 INDEX=-1",
    ] {
        let calls = plc.calls;
        let refused = plc.task(settings);
        assert_eq!((refused.number("ERROR"), refused.number("ERROR_CODE")), (1.0, -1.0), "{settings}: {refused:?}");
        assert!(refused.numbers("REQUEST").iter().all(|octet| *octet == 0.0), "{settings}");
        assert_eq!(plc.calls - calls, 2, "{settings}");
    }
}

#[test]
fn the_channel_block_gives_up_without_an_answer_and_without_data_exchange() {
    let name = "PV_BCG450_CHANNEL";
    let mut blocks = Blocks::start(&block(model_named("bcg450").unwrap(), name));
    let start = "EXCHANGING=1 EXECUTE=1 SLOT=0 INDEX=25 TIMEOUT_CALLS=3 RESPONSE=0000000000000000";
    let mut outputs = blocks.call(name, "a", start);
    for _ in 0..3 {
        assert_eq!(outputs.number("BUSY"), 1.0);
        outputs = blocks.call(name, "a", "");
    }
    assert_eq!((outputs.number("BUSY"), outputs.number("ERROR_CODE")), (0.0, -2.0));
    assert!(outputs.numbers("REQUEST").iter().all(|octet| *octet == 0.0));
    blocks.call(name, "b", start);
    let outputs = blocks.call(name, "b", "EXCHANGING=0");
    assert_eq!((outputs.number("BUSY"), outputs.number("ERROR_CODE")), (0.0, -3.0));
}

/// A block counts calls. In a program without a cycle time they are so many that an `INT` would overflow.
#[test]
fn the_timeout_of_the_channel_block_is_any_number_of_calls() {
    let name = "PV_BCG450_CHANNEL";
    let mut blocks = Blocks::start(&block(model_named("bcg450").unwrap(), name));
    let start = "EXCHANGING=1 EXECUTE=1 SLOT=0 INDEX=25 RESPONSE=0000000000000000";
    for timeout in ["32767", "2147483647"] {
        let outputs = blocks.call(name, timeout, &format!("{start} TIMEOUT_CALLS={timeout}"));
        assert_eq!((outputs.number("BUSY"), outputs.number("ERROR")), (1.0, 0.0), "{timeout}");
    }
    blocks.call(name, "a", &format!("{start} TIMEOUT_CALLS=0"));
    let outputs = blocks.call(name, "a", "");
    assert_eq!((outputs.number("BUSY"), outputs.number("ERROR_CODE")), (0.0, -2.0), "no call is left");
}

/// IF300P/IF301P manual 3.2.1.2 and 3.2.4.1: no user parameter selects the unit of a controller, and a master or the operator can change it
/// during data exchange.
#[test]
fn a_controller_has_no_pressure_until_the_program_sets_its_unit() {
    let text = block(model_named("tpg500").unwrap(), "PV_TPG500_T11");
    assert!(text.contains("slot 1, index 22 (Pressure unit)"), "{text}");
    assert!(text.contains("can change during data exchange"), "{text}");
    assert!(!text.contains("user parameters select it"), "{text}");
    let mut blocks = Blocks::start(&text);
    // 5e-6 mbar, as a controller sends it in Torr.
    let torr = 5e-6_f32 * 0.750_061_7;
    let octets = format!("{}{}00", "00".repeat(8), blocks::hex(&torr.to_be_bytes()));
    let outputs = blocks.call("PV_TPG500_T11", "a", &format!("EXCHANGING=1 OCTETS={octets}"));
    assert_eq!((outputs.number("VALID"), outputs.number("QUALITY")), (0.0, 3.0));
    let outputs = blocks.call("PV_TPG500_T11", "a", "UNIT=2");
    assert_eq!(outputs.number("VALID"), 1.0);
    assert!((outputs.number("PRESSURE_MBAR") - 5e-6).abs() < 1e-10, "{outputs:?}");
    for model in MODELS.into_iter().filter(|model| !model.name.starts_with("tpg")) {
        let text = st(model, Dialect::Standard);
        assert!(
            text.contains("as its user parameters select it") && !text.contains("UNIT : INT := -1"),
            "{}",
            model.name
        );
    }
}

/// The heads for TIA Portal differ; the statements are those that the other tests execute.
#[test]
fn the_dialects_have_the_same_statements() {
    for model in MODELS {
        let tia = st(model, Dialect::Tia);
        let standard = tia.replace("\"\nVERSION : 0.1\n", "\n").replace("FUNCTION_BLOCK \"", "FUNCTION_BLOCK ");
        assert_eq!(standard.replace("\nBEGIN\n", "\n\n"), st(model, Dialect::Standard));
        assert!(tia.is_ascii() && tia.contains("FUNCTION_BLOCK \"PV_"), "{}", model.name);
    }
}
