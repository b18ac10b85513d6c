//! A master and one device on a line in bit times: telegram after telegram, nothing waits for a clock.

use profivac_devices::model::{Address, Configuration, Field, Model, NumberType, Row};
use profivac_devices::{Instrument, Principle};
use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Station};
use profivac_dp::master::{
    self, Handle, Master, Mode, Ms1Parameters, Ms2Parameters, PkwParameters, Settings, SlaveParameters, pkw,
};
use profivac_host::bench::Unit;
use profivac_host::instrument::Spec;
use profivac_host::memory::Memory;
use profivac_wire::Telegram;
use std::fmt;

const BAUD: Baud = Baud::B1500000;
const SLAVE: u8 = 5;

/// Ten seconds of the bus: longer than any time-out.
const LIMIT_TBIT: u64 = 15_000_000;

/// A way to a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    Ms2,
    Ms1,
    Pkw,
}

/// What became of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Told {
    /// The octets read, or what the parameter channel shows after a write.
    Octets(Vec<u8>),
    Written,
    /// The sentence for a refusal.
    Refused(String),
}

impl fmt::Display for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Octets(octets) => {
                octets.iter().try_for_each(|octet| write!(f, "{octet:02X}"))?;
                Ok(())
            }
            Self::Written => f.write_str("written"),
            Self::Refused(why) => write!(f, "refused: {why}"),
        }
    }
}

pub struct Rig {
    pub model: &'static Model,
    station: Active<Master<1, 244>>,
    unit: Box<dyn Unit>,
    now: BitTime,
    connection: Option<Handle>,
    pkw: PkwParameters,
}

impl Rig {
    pub fn new(model: &'static Model) -> Self {
        let spec: Spec = format!("{}@{SLAVE}", model.name).parse().unwrap();
        let mut unit = spec.build(Memory::volatile(), BAUD).unwrap();
        evacuate(unit.instrument_mut());
        // The GAP is small: this is about something else.
        let bus = BusParameters { hsa: 2, ..BusParameters::new(2, BAUD) };
        let station = Master::on(bus, Settings::new(BAUD), BitTime(0));
        Self { model, station, unit, now: BitTime(0), connection: None, pkw: PkwParameters::GAUGE }
    }

    /// One telegram of the master, and its answer.
    fn step(&mut self) {
        self.now = self.now.max(self.station.wake_at().unwrap());
        let Some(transmit) = self.station.poll(self.now) else { return };
        let octets = transmit.octets.to_vec();
        self.now = self.now.max(transmit.not_before) + octets.len() as u64 * CHARACTER_TBIT;
        self.station.sent(self.now);
        if self.unit.wake_at().is_some_and(|due| due <= self.now) {
            self.unit.poll(self.now);
        }
        let Some(answer) = self.unit.telegram(self.now, &Telegram::parse(&octets).unwrap()) else { return };
        let octets = answer.octets.to_vec();
        self.now = self.now.max(answer.not_before) + octets.len() as u64 * CHARACTER_TBIT;
        self.unit.sent(self.now);
        self.station.telegram(self.now, &Telegram::parse(&octets).unwrap());
    }

    fn until<T>(&mut self, what: &str, mut done: impl FnMut(&mut Master<1, 244>) -> Option<T>) -> T {
        let limit = self.now + LIMIT_TBIT;
        loop {
            if let Some(done) = done(&mut self.station.user) {
                return done;
            }
            assert!(self.now < limit, "{}: {what} takes too long", self.model.name);
            self.step();
        }
    }

    /// The configuration with a parameter channel, with floats where there is a choice.
    fn configuration(&self) -> &'static Configuration {
        let has_channel = |it: &&'static Configuration| {
            it.outputs.is_some_and(|telegram| telegram.fields.contains(&Field::ParameterChannel))
        };
        let all = || self.model.configurations.iter().filter(has_channel);
        all().find(|it| it.number() == Some(NumberType::Float)).or_else(|| all().next()).unwrap()
    }

    /// Into data exchange, with DP-V1 where the device has it.
    pub fn bring_up(&mut self) {
        let configuration = self.configuration();
        let mut user_prm = self.model.user_prm[0].octets.to_vec();
        if let Some(status) = user_prm.first_mut() {
            *status |= self.model.dpv1_status & 0x80;
        }
        let parameters = SlaveParameters::new(SLAVE, self.model.ident, configuration.octets);
        self.station.user.add(&SlaveParameters { user_prm: &user_prm, ..parameters }).unwrap();
        self.station.user.set_mode(Mode::Operate);
        self.until("bring-up", |master| master.inputs(SLAVE).map(drop));
        let byte = self.model.dialect.instructions.iter().find(|(_, it)| match it {
            profivac_devices::model::Instruction::Write(lengths) => lengths.contains(&1),
            profivac_devices::model::Instruction::Read => false,
        });
        let at = |telegram: Option<&'static profivac_devices::model::Telegram>| {
            telegram.unwrap().layout().find(|(_, field)| *field == Field::ParameterChannel).unwrap().0
        };
        let (outputs_at, inputs_at) = (at(configuration.outputs), at(configuration.inputs));
        self.pkw = PkwParameters { outputs_at, inputs_at, byte_ak: byte.unwrap().0, ..PkwParameters::GAUGE };
    }

    /// Opens MS2; on a device without it that is refused.
    pub fn open(&mut self) {
        let parameters = Ms2Parameters { pace_tbit: 0, ..Ms2Parameters::new(BAUD) };
        let connection = self.station.user.ms2_open(SLAVE, &parameters).unwrap();
        let opened = self.until("opening", |master| match master.outcome(connection)? {
            master::Outcome::Opened(_) => Some(true),
            master::Outcome::Ended(_) => Some(false),
            other => panic!("{other:?}"),
        });
        assert_eq!(opened, self.model.features.dpv1, "{}: MS2", self.model.name);
        self.connection = opened.then_some(connection);
    }

    /// Which ways there are.
    pub fn ways(&self) -> Vec<Way> {
        let exchanging = self.station.user.exchanging() > 0;
        let mut ways = Vec::new();
        ways.extend(self.connection.map(|_| Way::Ms2));
        ways.extend((exchanging && self.model.features.ms1).then_some(Way::Ms1));
        ways.extend(exchanging.then_some(Way::Pkw));
        ways
    }

    /// Lets the slot show this instance.
    pub fn select(&mut self, address: &Address) {
        if address.instance != 0 {
            assert_eq!(self.write(Way::Ms2, 1, 46, &[address.instance]), Told::Written);
        }
    }

    fn told(&mut self, handle: Handle) -> Told {
        use master::Outcome;
        let told = self.until("a request", |master| {
            Some(match master.outcome(handle)? {
                Outcome::Read(record) => Told::Octets(record.to_vec()),
                Outcome::Value(value) => Told::Octets(value.octets()[4 - value.width()..].to_vec()),
                Outcome::Written => Told::Written,
                Outcome::Refused(negative) => Told::Refused(format!("{}, {}", negative.code_1, negative.code_2)),
                Outcome::Denied(error) => Told::Refused(error.to_string()),
                other => panic!("{other:?}"),
            })
        });
        // What follows by itself has followed.
        self.unit.instrument_mut().settle();
        told
    }

    pub fn read(&mut self, way: Way, slot: u8, index: u8) -> Told {
        let master = &mut self.station.user;
        let handle = match way {
            Way::Ms2 => self.connection.inspect(|it| master.ms2_read(*it, slot, index, 240).unwrap()).unwrap(),
            Way::Ms1 => {
                let parameters = Ms1Parameters { pace_tbit: 0, ..Ms1Parameters::new(BAUD) };
                master.ms1_read(SLAVE, slot, index, 240, &parameters).unwrap()
            }
            Way::Pkw => master.pkw_read(SLAVE, slot, index, None, &self.pkw).unwrap(),
        };
        self.told(handle)
    }

    pub fn write(&mut self, way: Way, slot: u8, index: u8, octets: &[u8]) -> Told {
        let master = &mut self.station.user;
        let handle = match way {
            Way::Ms2 => self.connection.inspect(|it| master.ms2_write(*it, slot, index, octets).unwrap()).unwrap(),
            Way::Ms1 => {
                let parameters = Ms1Parameters { pace_tbit: 0, ..Ms1Parameters::new(BAUD) };
                master.ms1_write(SLAVE, slot, index, octets, &parameters).unwrap()
            }
            Way::Pkw => {
                let Some(value) = pkw::Value::from_octets(octets) else { return Told::Refused("no width".to_owned()) };
                master.pkw_write(SLAVE, slot, index, value, &self.pkw).unwrap()
            }
        };
        match (way, self.told(handle)) {
            // The channel answers a write with what was written.
            (Way::Pkw, Told::Octets(echo)) => {
                assert_eq!(echo, octets, "{} {slot}/{index}", self.model.name);
                Told::Written
            }
            (_, told) => told,
        }
    }

    /// Every row at every address.
    pub fn rows(&self) -> Vec<(&'static Address, &'static Row)> {
        let places = self.model.places.iter();
        let each = |place: &'static profivac_devices::model::Place| {
            place.addresses.iter().flat_map(move |address| place.block.rows.iter().map(move |row| (address, row)))
        };
        places.flat_map(each).collect()
    }
}

/// Every sensor in a good vacuum, where everything can be switched on.
fn evacuate(instrument: &mut dyn Instrument) {
    instrument.settle();
    for part in 0..instrument.parts().len() {
        if instrument.parts()[part].principle != Principle::Atmosphere {
            instrument.sense(part, 1e-4);
        }
    }
    instrument.settle();
}
