//! Records of a slave that this master owns, by MS1 or the parameter channel. profibus-wire 4.2 to 4.5 and 6.1.
//!
//! [`Class1Session`] parameterises a slave with its present unit, exchanges data with it, and releases it at the end.
//! [`OwnedChannel`] uses the parameter channel of a slave that the master exchanges data with already.

use super::records::{Interruption, RecordError, Records, RefusalCodes, Unavailable, UnrestoredRecord};
use crate::cyclic::CyclicSlave;
use crate::ms2::Abandoned;
use crate::ms2::{Ms2, Ms2Error, Ms2Line};
use crate::records::read_code;
use profivac_devices::model::{AccessPath, Configuration, Field, Model, NumberType, Role, TaskKind, Telegram};
use profivac_dp::link::Baud;
use profivac_dp::master::{ExchangeError, HandlerState, Mode, Ms1Parameters, PkwParameters, SlaveParameters, ms1, pkw};
use profivac_host::session::{BusSession, SessionError, add_or_restart};
use profivac_wire::acyclic::record::MAX_RECORD_LENGTH;
use std::time::Duration;

/// DPV1_Enable: without it a slave answers no MS1 request. profibus-wire 2.4.
const DPV1_ENABLE: u8 = 0x80;

/// How often a record is read when the slave leaves data exchange meanwhile: reading changes nothing.
const ATTEMPTS: usize = 3;

/// The longest wait for the release of the slave.
const RELEASE_TIMEOUT: Duration = Duration::from_secs(1);

/// How long the line is served at a time.
const SLICE: Duration = Duration::from_millis(20);

/// A slave in data exchange with this master. Dropping the session releases the slave.
///
/// ```
/// # use profivac_client::Bus;
/// use profivac_client::class1::Class1Session;
/// use profivac_client::cyclic::CyclicSlave;
/// use profivac_client::records::Records;
/// use profivac_devices::model::AccessPath;
///
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["tpg300@7"])?).open()?;
/// let slave = CyclicSlave::find(bus.session(), 7, 0)?;
/// let mut records = Class1Session::open(bus.session(), &slave, AccessPath::ParameterChannel)?;
/// // Pressure unit of channel A1, slot 1 index 22.
/// assert_eq!(records.read(1, 22)?.len(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Class1Session<'a> {
    session: &'a mut BusSession,
    address: u8,
    service: Service,
    abandoned: Abandoned,
}

/// The service that carries the records.
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
    /// Parameterises a slave that no other master owns, and waits until it exchanges data.
    ///
    /// # Errors
    /// [`RecordError::Unavailable`] when the device does not have the service or refuses its parameters,
    /// [`RecordError::Interrupted`] when it does not exchange data in time, [`RecordError::NotSent`] at a cancellation of the session.
    pub fn open(session: &'a mut BusSession, slave: &CyclicSlave, via: AccessPath) -> Result<Self, RecordError> {
        let model = slave.model;
        let number = present_number(session, slave)?;
        let (configuration, service) = service_of(model, slave.configuration, number, via, session.baud())?;
        let default = slave.parameters(session.baud());
        let mut user_prm = default.user_prm.to_vec();
        if let (Service::Ms1(_), Some(first)) = (&service, user_prm.first_mut()) {
            *first |= DPV1_ENABLE;
        }
        let parameters = SlaveParameters { user_prm: &user_prm, cfg: configuration.octets, ..default };
        let mut opened = Self { session, address: slave.address, service, abandoned: Abandoned::NONE };
        add_or_restart(opened.session.master(), &parameters).map_err(Unavailable::Parameters)?;
        opened.session.master().set_mode(Mode::Operate);
        opened.wait_for_data()?;
        Ok(opened)
    }

    fn wait_for_data(&mut self) -> Result<(), RecordError> {
        let begun = self.session.now();
        while !self.exchanges() {
            self.serve()?;
            if self.session.is_cancelled() {
                return Err(RecordError::NotSent(SessionError::Interrupted));
            }
            if self.session.has_passed(self.session.timeout(), begun) {
                return Err(match self.session.master().exchange_error(self.address) {
                    error @ (None | Some(ExchangeError::NoAnswer(_))) => Interruption::NoExchange(error).into(),
                    Some(error) => Unavailable::NoExchange(error).into(),
                });
            }
        }
        Ok(())
    }

    /// Whether the first data exchange is done.
    fn exchanges(&mut self) -> bool {
        let master = self.session.master();
        master.state(self.address).is_some_and(HandlerState::is_exchanging)
            && master.exchanged_at(self.address).is_some()
    }

    fn serve(&mut self) -> Result<(), RecordError> {
        self.session.serve(&[], SLICE).map_err(SessionError::from)?;
        while self.session.master().next_event().is_some() {}
        Ok(())
    }

    fn read_once(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        self.prepare()?;
        let (address, master) = (self.address, self.session.master());
        match self.service {
            Service::Ms1(parameters) => {
                let wanted = u8::try_from(MAX_RECORD_LENGTH).unwrap_or(u8::MAX);
                let read = master.ms1_read(address, slot, index, wanted, &parameters);
                let read = read.map_err(Interruption::NotSubmitted)?;
                let record = self.abandoned.wait_for(self.session, read, |record| record.map(<[u8]>::to_vec))?;
                record.map_err(ms1_error)
            }
            Service::ParameterChannel(parameters) => {
                read_task(self.session, &mut self.abandoned, address, (slot, index), &parameters)
            }
        }
    }

    fn write_once(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        let address = self.address;
        match self.service {
            Service::Ms1(parameters) => {
                self.prepare()?;
                let write = self.session.master().ms1_write(address, slot, index, octets, &parameters);
                let write = write.map_err(Interruption::NotSubmitted)?;
                self.abandoned.wait_for(self.session, write, |written| written)?.map_err(ms1_error)
            }
            Service::ParameterChannel(parameters) => {
                let value = channel_value(octets)?;
                self.prepare()?;
                write_task(self.session, &mut self.abandoned, address, (slot, index), value, &parameters)
            }
        }
    }

    /// Waits for the end of a request that was given up, and until the slave exchanges data, if it does not.
    fn prepare(&mut self) -> Result<(), RecordError> {
        self.abandoned.finish(self.session).map_err(Ms2Error::before_request)?;
        if self.exchanges() { Ok(()) } else { self.wait_for_data() }
    }

    /// Releases the slave.
    fn release(&mut self) -> Result<(), RecordError> {
        let begun = self.session.now();
        self.session.master().release(self.address);
        while self.session.master().state(self.address) != Some(HandlerState::Inactive)
            && !self.session.has_passed(RELEASE_TIMEOUT, begun)
        {
            self.serve()?;
        }
        Ok(())
    }
}

/// The parameter channel of a slave that the master of `line` exchanges data with. It parameterises nothing and releases
/// nothing: the cyclic data continue, and their owner decides when they end.
///
/// Every request fails with [`Unavailable::NoParameterChannel`] if the configuration of the slave has no parameter channel, and with
/// [`Interruption::NotSubmitted`] while the slave does not exchange data.
///
/// ```
/// # use profivac_client::Bus;
/// use profivac_client::class1::OwnedChannel;
/// use profivac_client::cyclic::CyclicSlave;
/// use profivac_client::records::{RecordError, Records};
///
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["tpg300@7"])?).open()?;
/// let slave = CyclicSlave::find(bus.session(), 7, 0)?;
/// // The master does not exchange data with the controller.
/// let unread = OwnedChannel::new(bus.session(), &slave).read(1, 22);
/// assert!(matches!(unread, Err(RecordError::Interrupted(_))));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct OwnedChannel<'a, L: Ms2Line = BusSession> {
    line: &'a mut L,
    address: u8,
    parameters: Option<PkwParameters>,
    abandoned: Abandoned,
}

impl<'a, L: Ms2Line> OwnedChannel<'a, L> {
    /// The parameter channel of `slave`. Sends nothing.
    pub fn new(line: &'a mut L, slave: &CyclicSlave) -> Self {
        let parameters = channel(slave.configuration, slave.model);
        Self { line, address: slave.address, parameters, abandoned: Abandoned::NONE }
    }

    fn parameters(&self) -> Result<PkwParameters, RecordError> {
        self.parameters.ok_or_else(|| Unavailable::NoParameterChannel.into())
    }

    fn read_once(&mut self, location: (u8, u8), parameters: &PkwParameters) -> Result<Vec<u8>, RecordError> {
        self.abandoned.finish(self.line).map_err(Ms2Error::before_request)?;
        read_task(self.line, &mut self.abandoned, self.address, location, parameters)
    }
}

impl<L: Ms2Line> Records for OwnedChannel<'_, L> {
    fn via(&self) -> AccessPath {
        AccessPath::ParameterChannel
    }

    fn read(&mut self, slot: u8, index: u8) -> Result<Vec<u8>, RecordError> {
        let parameters = self.parameters()?;
        let mut read = self.read_once((slot, index), &parameters);
        for _ in 1..ATTEMPTS {
            if !matches!(read, Err(RecordError::Interrupted(Interruption::ParameterChannel(_)))) {
                break;
            }
            read = self.read_once((slot, index), &parameters);
        }
        read
    }

    fn write(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), RecordError> {
        let (parameters, value) = (self.parameters()?, channel_value(octets)?);
        self.abandoned.finish(self.line).map_err(Ms2Error::before_request)?;
        write_task(self.line, &mut self.abandoned, self.address, (slot, index), value, &parameters)
    }
}

/// Reads a parameter in the parameter channel of a slave in data exchange.
fn read_task(
    line: &mut impl Ms2Line,
    abandoned: &mut Abandoned,
    address: u8,
    (slot, index): (u8, u8),
    parameters: &PkwParameters,
) -> Result<Vec<u8>, RecordError> {
    let task = line.master().pkw_read(address, slot, index, None, parameters).map_err(Interruption::NotSubmitted)?;
    abandoned.wait_for(line, task, |value| value)?.map(octets).map_err(task_error)
}

/// Writes a parameter in the parameter channel of a slave in data exchange.
fn write_task(
    line: &mut impl Ms2Line,
    abandoned: &mut Abandoned,
    address: u8,
    (slot, index): (u8, u8),
    value: pkw::Value,
    parameters: &PkwParameters,
) -> Result<(), RecordError> {
    let task = line.master().pkw_write(address, slot, index, value, parameters).map_err(Interruption::NotSubmitted)?;
    abandoned.wait_for(line, task, |value| value)?.map(drop).map_err(task_error)
}

fn channel_value(octets: &[u8]) -> Result<pkw::Value, RecordError> {
    pkw::Value::from_octets(octets).ok_or_else(|| Unavailable::TooLongForChannel.into())
}

fn ms1_error(error: ms1::RequestError) -> RecordError {
    match error {
        ms1::RequestError::Refused(negative) => RecordError::Refused(negative.into()),
        _ => Interruption::Ms1(error).into(),
    }
}

fn task_error(error: pkw::TaskError) -> RecordError {
    match error {
        pkw::TaskError::Refused(pkw::ErrorNumber(number)) => {
            RecordError::Refused(RefusalCodes { code_1: None, code: u8::try_from(number).unwrap_or(u8::MAX) })
        }
        _ => Interruption::ParameterChannel(error).into(),
    }
}

/// The octets of a value in the parameter channel.
fn octets(value: pkw::Value) -> Vec<u8> {
    value.octets().iter().skip(4_usize.saturating_sub(value.width())).copied().collect()
}

/// Data Type, read over MS2: a configuration with another number type would change it. `None` for a device that has no such
/// parameter or refuses it; a lost answer is an error, not a guess.
fn present_number(session: &mut BusSession, slave: &CyclicSlave) -> Result<Option<NumberType>, RecordError> {
    let mut locations = slave.model.blocks.iter().filter(|_| slave.model.features.dpv1);
    let found = locations.find_map(|placed| {
        let row = placed.block.rows.iter().find(|row| row.role == Some(Role::NumberType))?;
        Some(((placed.locations.first()?.slot, row.index), row.data_type))
    });
    let Some((location, data_type)) = found else { return Ok(None) };
    let code = match read_code(&mut Ms2::new(session, slave.address), location, data_type) {
        Err(RecordError::Refused(_)) => None,
        code => code?,
    };
    Ok(code.and_then(|code| u8::try_from(code).ok()).and_then(NumberType::from_code))
}

/// The configuration that carries a service, and the parameters of the service: the present configuration, or one with the
/// number type of the device.
fn service_of(
    model: &'static Model,
    present: &'static Configuration,
    number: Option<NumberType>,
    via: AccessPath,
    baud: Baud,
) -> Result<(&'static Configuration, Service), RecordError> {
    let service = |it: &'static Configuration| match via {
        AccessPath::Class1 => Some((it, Service::Ms1(Ms1Parameters::new(baud)))),
        AccessPath::ParameterChannel => Some((it, Service::ParameterChannel(channel(it, model)?))),
        AccessPath::Class2 => None,
    };
    let keeps = |it: &&Configuration| number.is_none() || it.number() == number;
    let all = || std::iter::once(present).chain(model.configurations.iter());
    let found = all().filter(keeps).find_map(service).or_else(|| all().find_map(service));
    match (via, found) {
        (AccessPath::Class1, _) if !model.features.ms1 => Err(Unavailable::NoMs1.into()),
        (_, Some(found)) => Ok(found),
        (_, None) => Err(Unavailable::NoParameterChannel.into()),
    }
}

/// The position of the parameter channel in a configuration, and the rules of the device for it.
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

    fn keep_unrestored(&mut self, record: UnrestoredRecord) {
        self.session.keep_unrestored(self.address, record);
    }

    fn take_unrestored(&mut self) -> Option<UnrestoredRecord> {
        self.session.take_unrestored(self.address)
    }

    fn set_restoring(&mut self, is_restoring: bool) {
        self.session.set_restoring(is_restoring);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::catalog::MODELS;

    #[test]
    fn every_device_has_a_parameter_channel_at_the_position_of_its_manual() {
        for model in MODELS {
            let found =
                service_of(model, model.default_configuration, None, AccessPath::ParameterChannel, Baud::B19200);
            let Ok((configuration, Service::ParameterChannel(parameters))) = found else { panic!("{}", model.name) };
            let byte_ak = if model.ident == 0x05D9 { 2 } else { 10 };
            assert_eq!((parameters.outputs_at, parameters.inputs_at, parameters.byte_ak), (0, 0, byte_ak));
            assert!(configuration.output_octets() >= 8 && configuration.input_octets() >= 8);
            for number in [NumberType::Integer, NumberType::Float] {
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
    fn a_channel_value_has_the_octets_of_its_width() {
        assert_eq!(octets(pkw::Value::Byte(4)), [4]);
        assert_eq!(octets(pkw::Value::Word(0x1308)), [0x13, 0x08]);
        assert_eq!(octets(pkw::Value::DoubleWord(1)), [0, 0, 0, 1]);
    }
}
