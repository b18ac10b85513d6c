//! A TPG500 on the tester, in exchange with four floats.

use crate::support::{Tester, hex};
use crate::tpg::{Controller, controller};
use profivac_devices::model::Fault;
use profivac_devices::tpg::TpgGauge;
use profivac_devices::{Action, SimulatedDevice};

/// Slots. IF300P/IF301P manual 3.2.4.1 and 3.2.4.2.
pub const A1: u8 = 1;
pub const B1: u8 = 3;
pub const RELAY_1: u8 = 5;
pub const COLD_CATHODE_B: u8 = 10;

/// Indices of a threshold block.
pub const VALIDATION: u8 = 20;
pub const UPPER: u8 = 21;
pub const LOWER: u8 = 22;
pub const SOURCE: u8 = 23;
pub const SETPOINT_STATUS: u8 = 24;

/// Indices of the device block and of a channel.
pub const ACCESS_CODE: u8 = 24;
pub const UNDERRANGE_CONTROL: u8 = 25;
pub const VOLATILITY: u8 = 26;
pub const UNIT: u8 = 22;
pub const FILTER: u8 = 23;

/// The error code of a write, or `None`.
pub type Written = Result<(), u8>;

/// A master that exchanges data with the controller.
pub struct Exchange {
    pub tester: Tester<Controller>,
    /// Sensor On_Off, in every cycle.
    pub sensor_on_off: u8,
    /// The inputs of the last cycle.
    pub inputs: Vec<u8>,
}

impl Exchange {
    pub fn new(boards: [Option<TpgGauge>; 4]) -> Self {
        Self::with(controller(boards))
    }

    pub fn with(controller: Controller) -> Self {
        let mut exchange = Self { tester: Tester::new(controller), sensor_on_off: 0, inputs: Vec::new() };
        exchange.bring_up();
        exchange
    }

    pub fn bring_up(&mut self) {
        self.tester.bring_up(&[], &hex("97 A7 94 94 94 94 A0"));
        self.cycle([0; 8]);
    }

    /// One cycle with this request in the parameter channel; its answer.
    pub fn cycle(&mut self, request: [u8; 8]) -> [u8; 8] {
        self.inputs = self.tester.exchange(&[&request[..], &[self.sensor_on_off]].concat());
        self.inputs[..8].try_into().unwrap()
    }

    /// A dialogue of two lines: the request of the master and the expected answer.
    pub fn line(&mut self, request: &str, answer: &str) {
        let request: [u8; 8] = hex(request).try_into().unwrap();
        assert_eq!(self.cycle(request)[..], hex(answer), "{request:02X?}");
    }

    /// Reads four octets of value.
    pub fn read(&mut self, slot: u8, index: u8) -> Result<u32, u8> {
        let [pke, _, _, _, value @ ..] = self.cycle([0x10, slot, index, 0, 0, 0, 0, 0]);
        if pke == 0x70 { Err(value[3]) } else { Ok(u32::from_be_bytes(value)) }
    }

    pub fn read_float(&mut self, slot: u8, index: u8) -> f32 {
        f32::from_bits(self.read(slot, index).unwrap())
    }

    /// Writes a byte or a word with AK 2.
    pub fn write(&mut self, slot: u8, index: u8, value: u16) -> Written {
        let [high, low] = value.to_be_bytes();
        self.request([0x20, slot, index, 0, 0, 0, high, low])
    }

    /// Writes a float with AK 3.
    pub fn write_float(&mut self, slot: u8, index: u8, value: f32) -> Written {
        let [a, b, c, d] = value.to_be_bytes();
        self.request([0x30, slot, index, 0, a, b, c, d])
    }

    fn request(&mut self, request: [u8; 8]) -> Written {
        self.cycle([0; 8]);
        let answer = self.cycle(request);
        if answer[0] == 0x70 { Err(answer[7]) } else { Ok(()) }
    }

    /// Opens a block, writes a set in the present unit, and closes it.
    pub fn thresholds(&mut self, slot: u8, lower: f32, upper: f32, source: u8) -> Written {
        self.write(slot, VALIDATION, 0)?;
        self.write_float(slot, UPPER, upper)?;
        self.write_float(slot, LOWER, lower)?;
        self.write(slot, SOURCE, source.into())?;
        self.write(slot, VALIDATION, 1)
    }

    /// All gauges in one chamber, after the filters.
    pub fn pressure(&mut self, mbar: f64) {
        self.tester.pressure_mbar(mbar);
        self.tester.device().settle();
        self.cycle([0; 8]);
    }

    /// Sets Sensor On_Off for all following cycles.
    pub fn command(&mut self, sensor_on_off: u8) {
        self.sensor_on_off = sensor_on_off;
        self.cycle([0; 8]);
    }

    pub fn advance(&mut self, seconds: f64) {
        self.tester.device().advance(seconds);
        self.cycle([0; 8]);
    }

    pub fn fault(&mut self, fault: Fault, active: bool) {
        self.tester.device().operate(Action::Fault { fault, active }).unwrap();
    }

    /// Power is lost and returns, and the master starts data exchange again.
    pub fn power_cycle(&mut self) {
        self.tester.device().set_power(false);
        self.tester.device().set_power(true);
        self.tester.slave.power_up(5);
        self.sensor_on_off = 0;
        self.bring_up();
    }

    /// Status of A1, A2, B1, B2.
    pub fn statuses(&self) -> [u8; 4] {
        [12, 17, 22, 27].map(|position| self.inputs[position])
    }

    /// Measured value of A1, A2, B1, B2.
    pub fn values(&self) -> [f32; 4] {
        [8, 13, 18, 23].map(|at| f32::from_be_bytes(self.inputs[at..at + 4].try_into().unwrap()))
    }

    /// Setpoint status of a block: activated, which is 0 (errata-bpg-bcg-tpg 141).
    pub fn is_activated(&mut self, slot: u8) -> bool {
        self.read(slot, SETPOINT_STATUS) == Ok(0)
    }
}
