//! A master and devices on a line with any kind of time: bringing up, reading and writing by each service.

use profivac_devices::model::{
    Configuration, Field, Location, Model, NumberType, PlacedBlock, Row, TaskKind, Telegram,
};
use profivac_dp::link::Baud;
use profivac_dp::master::{
    self, Handle, Mode, Ms1Parameters, Ms2Parameters, Operation, PkwParameters, SlaveParameters, ms1, ms2, pkw,
};
use profivac_host::session::BusMaster;
use profivac_wire::acyclic::Negative;
use std::fmt;
use std::time::Duration;

pub const BAUD: Baud = Baud::B1500000;
/// The lowest address: this master claims the token first.
pub const MASTER: u8 = 0;

/// Longer than any timeout of the master: an operation that takes longer has failed.
const LIMIT: Duration = Duration::from_secs(30);

/// The time of a line.
pub trait Line {
    fn master(&mut self) -> &mut BusMaster;

    /// Advances to the next event.
    fn step(&mut self);

    /// The time since the start.
    fn elapsed(&self) -> Duration;

    /// Completes every process of the devices.
    fn settle(&mut self);
}

/// A service for parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    Ms2,
    Ms1,
    Pkw,
}

/// The result of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Told {
    /// The octets read, or the answer of the parameter channel to a write.
    Octets(Vec<u8>),
    Written,
    /// The text of a refusal.
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

/// Advances until a condition holds.
pub fn until<L: Line, T>(line: &mut L, what: &str, mut done: impl FnMut(&mut BusMaster) -> Option<T>) -> T {
    let limit = line.elapsed() + LIMIT;
    loop {
        if let Some(done) = done(line.master()) {
            return done;
        }
        assert!(line.elapsed() < limit, "{what} takes too long");
        line.step();
    }
}

/// The watchdog of a slave, longer than a thread may pause on a busy machine.
pub fn patient(address: u8, model: &'static Model, configuration: &'static Configuration) -> SlaveParameters<'static> {
    let watchdog = master::watchdog_factors(20_000, 10);
    SlaveParameters { watchdog, ..SlaveParameters::new(address, model.ident, configuration.octets) }
}

/// A device of a line with its services.
pub struct Rig<'a, L> {
    pub model: &'static Model,
    address: u8,
    line: &'a mut L,
    connection: Option<Handle<ms2::Connect>>,
    exchanging: bool,
    pkw: PkwParameters,
}

impl<'a, L: Line> Rig<'a, L> {
    pub fn new(line: &'a mut L, model: &'static Model, address: u8) -> Self {
        Self { model, address, line, connection: None, exchanging: false, pkw: PkwParameters::GAUGE }
    }

    fn until<T>(&mut self, what: &str, done: impl FnMut(&mut BusMaster) -> Option<T>) -> T {
        until(self.line, &format!("{}: {what}", self.model.name), done)
    }

    /// The configuration with a parameter channel, with floats if possible.
    fn configuration(&self) -> &'static Configuration {
        let has_channel = |it: &&'static Configuration| {
            it.outputs.is_some_and(|telegram| telegram.fields.contains(&Field::ParameterChannel))
        };
        let all = || self.model.configurations.iter().filter(has_channel);
        all().find(|it| it.number() == Some(NumberType::Float)).or_else(|| all().next()).unwrap()
    }

    /// Brings it into data exchange, with DP-V1 if the device has it.
    pub fn bring_up(&mut self) {
        let configuration = self.configuration();
        let mut user_prm = self.model.user_prm[0].octets.to_vec();
        if let Some(status) = user_prm.first_mut() {
            *status |= self.model.dpv1_status & 0x80;
        }
        let address = self.address;
        let parameters = patient(address, self.model, configuration);
        self.line.master().add(&SlaveParameters { user_prm: &user_prm, ..parameters }).unwrap();
        self.line.master().set_mode(Mode::Operate);
        self.until("bring-up", |master| master.inputs(address).map(drop));
        self.exchanging = true;
        let byte = self.model.channel_rules.tasks.iter().find(|(_, it)| match it {
            TaskKind::Write(lengths) => lengths.contains(&1),
            TaskKind::Read => false,
        });
        let at = |telegram: Option<&'static Telegram>| {
            telegram.unwrap().layout().find(|(_, field)| *field == Field::ParameterChannel).unwrap().0
        };
        let (outputs_at, inputs_at) = (at(configuration.outputs), at(configuration.inputs));
        self.pkw = PkwParameters { outputs_at, inputs_at, byte_ak: byte.unwrap().0, ..PkwParameters::GAUGE };
    }

    /// Opens MS2. A device without it refuses.
    pub fn open(&mut self) {
        let parameters = Ms2Parameters { pace_tbit: 0, ..Ms2Parameters::new(BAUD) };
        let connection = self.line.master().ms2_open(self.address, &parameters).unwrap();
        let opened = self.until("opening", |master| Some(master.outcome(connection)?.is_ok()));
        assert_eq!(opened, self.model.features.dpv1, "{}: MS2", self.model.name);
        self.connection = opened.then_some(connection);
    }

    /// Releases the device, so that the line is as before.
    pub fn leave(&mut self) {
        if let Some(connection) = self.connection.take() {
            self.line.master().ms2_close(connection).unwrap();
            self.until("closing", |master| master.outcome(connection)?.is_err().then_some(()));
        }
        let address = self.address;
        self.line.master().remove(address);
        self.until("giving back", |master| master.state(address).is_none().then_some(()));
        self.exchanging = false;
    }

    /// The services of the device.
    pub fn ways(&self) -> Vec<Way> {
        let mut ways = Vec::new();
        ways.extend(self.connection.map(|_| Way::Ms2));
        ways.extend((self.exchanging && self.model.features.ms1).then_some(Way::Ms1));
        ways.extend(self.exchanging.then_some(Way::Pkw));
        ways
    }

    /// Selects the instance that the slot shows.
    pub fn select(&mut self, address: &Location) {
        if address.instance != 0 {
            assert_eq!(self.write(Way::Ms2, 1, 46, &[address.instance]), Told::Written);
        }
    }

    /// Waits for the outcome of a request.
    fn told<O: Operation>(
        &mut self,
        what: &str,
        handle: Handle<O>,
        told: impl Fn(O::Outcome<'_>) -> Result<Told, String>,
    ) -> Told {
        let name = self.model.name;
        let outcome = self.until(what, |master| master.outcome(handle).map(&told));
        outcome.unwrap_or_else(|error| panic!("{name}: {what}: {error}"))
    }

    pub fn read(&mut self, way: Way, slot: u8, index: u8) -> Told {
        let what = format!("read {slot}/{index} by {way:?}");
        let master = self.line.master();
        match way {
            Way::Ms2 => {
                let read = self.connection.map(|it| master.ms2_read(it, slot, index, 240).unwrap()).unwrap();
                self.told(&what, read, |record| record.map(octets).or_else(ms2_refused))
            }
            Way::Ms1 => {
                let parameters = Ms1Parameters { pace_tbit: 0, ..Ms1Parameters::new(BAUD) };
                let read = master.ms1_read(self.address, slot, index, 240, &parameters).unwrap();
                self.told(&what, read, |record| record.map(octets).or_else(ms1_refused))
            }
            Way::Pkw => {
                let task = master.pkw_read(self.address, slot, index, None, &self.pkw).unwrap();
                self.told(&what, task, pkw_told)
            }
        }
    }

    pub fn write(&mut self, way: Way, slot: u8, index: u8, octets: &[u8]) -> Told {
        let what = format!("write {slot}/{index} by {way:?}");
        let master = self.line.master();
        let told = match way {
            Way::Ms2 => {
                let write = self.connection.map(|it| master.ms2_write(it, slot, index, octets).unwrap()).unwrap();
                self.told(&what, write, |written| written.map(|()| Told::Written).or_else(ms2_refused))
            }
            Way::Ms1 => {
                let parameters = Ms1Parameters { pace_tbit: 0, ..Ms1Parameters::new(BAUD) };
                let write = master.ms1_write(self.address, slot, index, octets, &parameters).unwrap();
                self.told(&what, write, |written| written.map(|()| Told::Written).or_else(ms1_refused))
            }
            Way::Pkw => {
                let Some(value) = pkw::Value::from_octets(octets) else { return Told::Refused("no width".to_owned()) };
                let task = master.pkw_write(self.address, slot, index, value, &self.pkw).unwrap();
                self.told(&what, task, pkw_told)
            }
        };
        self.line.settle();
        match (way, told) {
            // The channel answers a write with the value written.
            (Way::Pkw, Told::Octets(echo)) => {
                assert_eq!(echo, octets, "{} {slot}/{index}", self.model.name);
                Told::Written
            }
            (_, told) => told,
        }
    }

    /// Every row at every address.
    pub fn rows(&self) -> Vec<(&'static Location, &'static Row)> {
        rows(self.model)
    }
}

fn octets(record: &[u8]) -> Told {
    Told::Octets(record.to_vec())
}

fn refused(negative: Negative) -> Told {
    Told::Refused(format!("{}, {}", negative.code_1, negative.code_2))
}

fn ms2_refused(error: ms2::RequestError) -> Result<Told, String> {
    match error {
        ms2::RequestError::Refused(negative) => Ok(refused(negative)),
        ms2::RequestError::Ended(end) | ms2::RequestError::NotExecuted(end) => Err(end.to_string()),
    }
}

fn ms1_refused(error: ms1::RequestError) -> Result<Told, String> {
    match error {
        ms1::RequestError::Refused(negative) => Ok(refused(negative)),
        error => Err(error.to_string()),
    }
}

fn pkw_told(outcome: Result<pkw::Value, pkw::TaskError>) -> Result<Told, String> {
    match outcome {
        Ok(value) => Ok(Told::Octets(value.octets()[4 - value.width()..].to_vec())),
        Err(pkw::TaskError::Refused(number)) => Ok(Told::Refused(number.to_string())),
        Err(error) => Err(error.to_string()),
    }
}

/// Every row of a device at every address.
pub fn rows(model: &Model) -> Vec<(&'static Location, &'static Row)> {
    let each = |placed: &'static PlacedBlock| {
        placed.locations.iter().flat_map(move |address| placed.block.rows.iter().map(move |row| (address, row)))
    };
    model.blocks.iter().flat_map(each).collect()
}
