//! Records of a slave that this master owns: by MS1, and in the parameter channel. profibus-wire 4.2 to 4.5 and 6.1.
//!
//! Owning a slave means Set_Prm: it is parameterised with the unit it has, exchanges data, and is unlocked at the end.

use super::records::{RecordError, Records, RefusalCodes};
use crate::cyclic::CyclicSlave;
use crate::ms2;
use profivac_devices::model::{AccessPath, Configuration, Field, Model, NumberType, TaskKind, Telegram};
use profivac_dp::link::Baud;
use profivac_dp::master::{
    ExchangeError, HandlerState, Mode, Ms1Parameters, PkwParameters, SlaveParameters, SubmitError, ms1, pkw,
};
use profivac_host::session::{BusSession, SessionError, add_or_restart};
use profivac_wire::acyclic::record::MAX_RECORD_LENGTH;
use std::time::{Duration, Instant};

/// DPV1_Enable: without it a slave answers no MS1 request. profibus-wire 2.4.
const DPV1_ENABLE: u8 = 0x80;

/// How often a record is asked for when the slave leaves data exchange meanwhile: reading changes nothing.
const ATTEMPTS: usize = 3;

/// How long a slave is given to be unlocked.
const RELEASE_TIMEOUT: Duration = Duration::from_secs(1);

/// How long the line is served at a time.
const SLICE: Duration = Duration::from_millis(20);

/// A slave in data exchange with this master, until it is dropped.
pub struct Class1Session<'a> {
    tool: &'a mut BusSession,
    address: u8,
    service: Service,
}

/// How its records are asked for.
#[derive(Clone, Copy)]
enum Service {
    Ms1(Ms1Parameters),
    ParameterChannel(PkwParameters),
}

impl Drop for Class1Session<'_> {
    fn drop(&mut self) {
        self.release().ok();
    }
}

impl<'a> Class1Session<'a> {
    /// Takes a slave that was found free, and waits until it exchanges data.
    ///
    /// # Errors
    /// [`RecordError::NoWay`] when the device does not have this way, [`RecordError::Lost`] when no data are exchanged.
    pub fn open(tool: &'a mut BusSession, watched: &CyclicSlave, via: AccessPath) -> Result<Self, RecordError> {
        Self::open_unless(tool, watched, via, &|| false)
    }

    /// The same, until `is_stopped`: then the slave is unlocked at once.
    ///
    /// # Errors
    /// As [`take`](Self::take).
    pub fn open_unless(
        tool: &'a mut BusSession,
        watched: &CyclicSlave,
        via: AccessPath,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Self, RecordError> {
        let model = watched.model;
        let number = present_number(tool, watched);
        let (configuration, way) = service_of(model, watched.configuration, number, via, tool.baud())?;
        let usual = watched.parameters(tool.baud());
        let mut user_prm = usual.user_prm.to_vec();
        if let (Service::Ms1(_), Some(first)) = (&way, user_prm.first_mut()) {
            *first |= DPV1_ENABLE;
        }
        let parameters = SlaveParameters { user_prm: &user_prm, cfg: configuration.octets, ..usual };
        let mut owned = Self { tool, address: watched.address, service: way };
        add_or_restart(owned.tool.master(), &parameters)
            .map_err(|error| RecordError::Unavailable(error.to_string()))?;
        owned.tool.master().set_mode(Mode::Operate);
        owned.wait_for_data(is_stopped)?;
        Ok(owned)
    }

    fn wait_for_data(&mut self, is_stopped: &dyn Fn() -> bool) -> Result<(), RecordError> {
        let begun = Instant::now();
        while !self.exchanges() {
            self.serve()?;
            if is_stopped() {
                return Err(RecordError::Interrupted("interrupted by a signal".to_owned()));
            }
            if begun.elapsed() >= self.tool.timeout() {
                let trouble = self.tool.master().exchange_error(self.address);
                let reason = trouble.map_or_else(|| "it was not asked long enough".to_owned(), |it| it.to_string());
                let sentence = format!("no data are exchanged: {reason}");
                return Err(match trouble {
                    None | Some(ExchangeError::NoAnswer(_)) => RecordError::Interrupted(sentence),
                    Some(_) => RecordError::Unavailable(sentence),
                });
            }
        }
        Ok(())
    }

    /// Whether there are inputs: the first exchange is done.
    fn exchanges(&mut self) -> bool {
        let master = self.tool.master();
        matches!(master.state(self.address), Some(HandlerState::Data { .. }))
            && master.exchanged_at(self.address).is_some()
    }

    fn serve(&mut self) -> Result<(), RecordError> {
        self.tool.serve(&[], SLICE).map_err(SessionError::from)?;
        while self.tool.master().next_event().is_some() {}
        Ok(())
    }

    fn read_once(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        self.ensure_exchange()?;
        let (address, master) = (self.address, self.tool.master());
        match self.service {
            Service::Ms1(parameters) => {
                let wanted = u8::try_from(MAX_RECORD_LENGTH).unwrap_or(u8::MAX);
                let read = master.ms1_read(address, slot, index, wanted, &parameters).map_err(not_submitted)?;
                self.tool.wait_for_outcome(read, |record| record.map(<[u8]>::to_vec))?.map_err(ms1_error)
            }
            Service::ParameterChannel(parameters) => {
                let task = master.pkw_read(address, slot, index, None, &parameters).map_err(not_submitted)?;
                self.tool.wait_for_outcome(task, |value| value)?.map(octets).map_err(task_error)
            }
        }
    }

    fn write_once(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        let too_long =
            || RecordError::Unavailable("the parameter channel carries 1, 2 or 4 octets; say --via ms2".to_owned());
        let service = self.service;
        let value = match service {
            Service::Ms1(_) => None,
            Service::ParameterChannel(_) => Some(pkw::Value::from_octets(octets).ok_or_else(too_long)?),
        };
        self.ensure_exchange()?;
        let (address, master) = (self.address, self.tool.master());
        match (service, value) {
            (Service::ParameterChannel(parameters), Some(value)) => {
                let task = master.pkw_write(address, slot, index, value, &parameters).map_err(not_submitted)?;
                self.tool.wait_for_outcome(task, |value| value)?.map(drop).map_err(task_error)
            }
            (Service::Ms1(parameters), _) => {
                let write = master.ms1_write(address, slot, index, octets, &parameters).map_err(not_submitted)?;
                self.tool.wait_for_outcome(write, |written| written)?.map_err(ms1_error)
            }
            (Service::ParameterChannel(_), None) => Err(too_long()),
        }
    }

    /// Waits until the slave exchanges data, if it does not.
    fn ensure_exchange(&mut self) -> Result<(), RecordError> {
        if self.exchanges() { Ok(()) } else { self.wait_for_data(&|| false) }
    }

    /// Gives the slave back.
    fn release(&mut self) -> Result<(), RecordError> {
        let begun = Instant::now();
        self.tool.master().release(self.address);
        while self.tool.master().state(self.address) != Some(HandlerState::Inactive)
            && begun.elapsed() < RELEASE_TIMEOUT
        {
            self.serve()?;
        }
        Ok(())
    }
}

fn not_submitted(error: SubmitError) -> RecordError {
    RecordError::Interrupted(error.to_string())
}

fn ms1_error(error: ms1::RequestError) -> RecordError {
    match error {
        ms1::RequestError::Refused(negative) => RecordError::Refused(negative.into()),
        ms1::RequestError::Failed(_) | ms1::RequestError::LeftExchange => RecordError::Interrupted(error.to_string()),
    }
}

fn task_error(error: pkw::TaskError) -> RecordError {
    match error {
        pkw::TaskError::Refused(pkw::ErrorNumber(number)) => {
            RecordError::Refused(RefusalCodes { code_1: None, code: u8::try_from(number).unwrap_or(u8::MAX) })
        }
        _ => RecordError::Interrupted(error.to_string()),
    }
}

/// The octets of a value in the parameter channel.
fn octets(value: pkw::Value) -> Vec<u8> {
    value.octets().iter().skip(4_usize.saturating_sub(value.width())).copied().collect()
}

/// Data Type, as a class 2 master reads it: a configuration with another number would change it.
fn present_number(tool: &mut BusSession, watched: &CyclicSlave) -> Option<NumberType> {
    let places = watched.model.blocks.iter().filter(|_| watched.model.features.dpv1);
    let (slot, index) = places
        .filter_map(|place| {
            let row = place.block.rows.iter().find(|row| row.name == "Data Type")?;
            Some((place.locations.first()?.slot, row.index))
        })
        .next()?;
    let record = ms2::read(tool, watched.address, slot, index).ok()?;
    NumberType::from_code(*record.first()?)
}

/// The configuration for a way, and its parameters: the present one, or else one with the number type the device has.
fn service_of(
    model: &'static Model,
    present: &'static Configuration,
    number: Option<NumberType>,
    via: AccessPath,
    baud: Baud,
) -> Result<(&'static Configuration, Service), RecordError> {
    let way = |it: &'static Configuration| match via {
        AccessPath::Class1 => Some((it, Service::Ms1(Ms1Parameters::new(baud)))),
        AccessPath::ParameterChannel => Some((it, Service::ParameterChannel(channel(it, model)?))),
        AccessPath::Class2 => None,
    };
    let keeps = |it: &&Configuration| number.is_none() || it.number() == number;
    let all = || std::iter::once(present).chain(model.configurations.iter());
    let found = all().filter(keeps).find_map(way).or_else(|| all().find_map(way));
    match (via, found) {
        (AccessPath::Class1, _) if !model.features.ms1 => {
            Err(RecordError::Unavailable("it has no MS1; say --via pkw".to_owned()))
        }
        (_, Some(found)) => Ok(found),
        (_, None) => Err(RecordError::Unavailable("no configuration of it has a parameter channel".to_owned())),
    }
}

/// Where a configuration has the parameter channel, and how the device speaks in it.
fn channel(configuration: &Configuration, model: &Model) -> Option<PkwParameters> {
    let at = |telegram: Option<&'static Telegram>| {
        telegram?.layout().find(|(_, field)| *field == Field::ParameterChannel).map(|(start, _)| start)
    };
    let writes_octets =
        |(ak, it): &(u8, TaskKind)| matches!(it, TaskKind::Write(lengths) if lengths.contains(&1)).then_some(*ak);
    let byte_ak = model.channel_rules.tasks.iter().find_map(writes_octets)?;
    let (outputs_at, inputs_at) = (at(configuration.outputs)?, at(configuration.inputs)?);
    Some(PkwParameters { outputs_at, inputs_at, byte_ak, ..PkwParameters::GAUGE })
}

impl Records for Class1Session<'_> {
    fn via(&self) -> AccessPath {
        match self.service {
            Service::Ms1(_) => AccessPath::Class1,
            Service::ParameterChannel(_) => AccessPath::ParameterChannel,
        }
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        let mut read = self.read_once(slot, index);
        for _ in 1..ATTEMPTS {
            if !matches!(read, Err(RecordError::Interrupted(_))) {
                break;
            }
            read = self.read_once(slot, index);
        }
        read
    }

    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        self.write_once(slot, index, octets)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::catalog::MODELS;

    #[test]
    fn every_device_has_a_parameter_channel_where_its_manual_says() {
        for model in MODELS {
            let found =
                service_of(model, model.default_configuration, None, AccessPath::ParameterChannel, Baud::B19200);
            let Ok((configuration, Service::ParameterChannel(parameters))) = found else { panic!("{}", model.name) };
            let byte_ak = if model.ident == 0x05D9 { 2 } else { 10 };
            assert_eq!((parameters.outputs_at, parameters.inputs_at, parameters.byte_ak), (0, 0, byte_ak));
            assert!(configuration.output_octets() >= 8 && configuration.input_octets() >= 8);
            for number in [NumberType::Integer, NumberType::Float] {
                let model = model;
                let found = service_of(
                    model,
                    model.default_configuration,
                    Some(number),
                    AccessPath::ParameterChannel,
                    Baud::B19200,
                );
                let Ok((configuration, _)) = found else { panic!("{}", model.name) };
                assert!(!model.features.dpv1 || configuration.number() == Some(number), "{}", model.name);
            }
        }
    }

    #[test]
    fn a_value_has_as_many_octets_as_it_is_wide() {
        assert_eq!(octets(pkw::Value::Byte(4)), [4]);
        assert_eq!(octets(pkw::Value::Word(0x1308)), [0x13, 0x08]);
        assert_eq!(octets(pkw::Value::DoubleWord(1)), [0, 0, 0, 1]);
    }
}
