//! A bus and its gauges.

use crate::cyclic::{self, Cyclic};
use crate::devices;
use crate::failure::Failure;
use crate::settings;
use crate::values::{self, CommandRow, ParameterRow, ReadingRow};
use crate::waiting::{Owned, wait};
use crate::whole::Whole;
use profivac_client::class1::Class1Session;
use profivac_client::cyclic::{ChannelValue, CyclicSlave};
use profivac_client::records::{RecordError, Records};
use profivac_client::{AsyncBus, AsyncGauge, Bus as BlockingBus, BusBuilder, ClientError, identify};
use profivac_client::{Gauge as ClientGauge, ParameterReading, PreparedWrite, WriteResult};
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::{AccessPath, Model};
use profivac_dp::link::Baud;
use profivac_host::scan::{self, FoundStation};
use profivac_host::session::BusSession;
use profivac_virtual::open;
use profivac_wire::control::StationType;
use pyo3::prelude::*;
use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// The shortest and the longest time that an unused connection is kept. chosen.
const MIN_IDLE: Duration = Duration::from_millis(100);
const MAX_IDLE: Duration = Duration::from_secs(3600);

/// Address, kind, ident number, devices, state, owner.
type StationRow = (u8, &'static str, Option<u16>, Vec<&'static str>, Option<String>, Option<u8>);

/// Pascal, quality, cause, end of the range in Pa, instance.
pub type PressureRow = (Option<f64>, &'static str, Option<String>, Option<f64>, u8);

/// Name, the value sent, before, after.
type WriteRow = (String, String, Option<ReadingRow>, Option<ReadingRow>);

/// How a program is a master on a line.
#[derive(Clone, Copy)]
pub struct Line {
    /// The rate.
    pub baud: Baud,
    /// The address of this program.
    pub master: u8,
    /// How long a request waits for the line and for an answer.
    pub timeout: Duration,
    /// The devices that are known.
    pub devices: KnownDevices,
}

impl Line {
    /// A line with numbers of a user.
    pub fn new(baud: u32, master: u8, timeout_s: f64) -> Result<Self, Failure> {
        let rates = || Baud::ALL.map(|baud| baud.bits_per_second().to_string()).join(", ");
        let baud = Baud::from_bits_per_second(baud)
            .ok_or_else(|| Failure::usage(format!("expected a PROFIBUS rate, one of {}, got {baud}", rates())))?;
        let timeout = Duration::try_from_secs_f64(timeout_s)
            .ok()
            .filter(|timeout| !timeout.is_zero() && *timeout <= Duration::from_secs(3600))
            .ok_or_else(|| Failure::usage(format!("expected a timeout above 0 s, up to 3600 s, got {timeout_s}")))?;
        Ok(Self { baud, master, timeout, devices: KnownDevices::BUILT_IN })
    }

    /// The same line, on which these devices are known.
    pub const fn knowing(self, devices: KnownDevices) -> Self {
        Self { devices, ..self }
    }

    fn open(self, bus: BusBuilder) -> Result<AsyncBus, ClientError> {
        bus.baud(self.baud).master(self.master).timeout(self.timeout).devices(self.devices).open_async()
    }
}

/// A master on a line, in a thread of its own.
#[pyclass(frozen, module = "profivac._profivac")]
pub struct Bus(Owned<AsyncBus>, Line, Mutex<Receiver<()>>);

thread_local! {
    /// Dropped at the end of the thread of a bus, after its port.
    static THREAD_END: RefCell<Option<Sender<()>>> = const { RefCell::new(None) };
}

impl Bus {
    /// A master on an open port.
    pub fn on(py: Python<'_>, port: Box<dyn profivac_host::port::Port>, line: Line) -> PyResult<Self> {
        let bus = py.detach(|| line.open(BlockingBus::on(port))).map_err(Failure::from)?;
        let (alive, end) = channel();
        let marked = bus.submit(move |_| THREAD_END.with(|thread| thread.replace(Some(alive))));
        wait(py, marked)?.map_err(Failure::from)?;
        Ok(Self(Owned::new(bus, "bus"), line, Mutex::new(end)))
    }
}

#[pymethods]
impl Bus {
    /// Opens the port of this name.
    #[staticmethod]
    fn open(
        py: Python<'_>,
        port: &str,
        baud: Whole<u32>,
        master: Whole<u8>,
        timeout: f64,
        device_files: Vec<PathBuf>,
    ) -> PyResult<Self> {
        let line = Line::new(baud.0, master.0, timeout)?.knowing(devices::known(&device_files)?);
        let opened = py.detach(|| open::port(port, line.baud).map_err(|error| Failure::line(&error)));
        Self::on(py, opened?, line)
    }

    /// The stations that answer at the addresses from `first` to `last`.
    fn scan(&self, py: Python<'_>, first: u8, last: u8) -> PyResult<Vec<StationRow>> {
        let (bus, own) = (self.0.get()?, self.1.master);
        let found = bus.submit(move |session| {
            let mut found = Vec::new();
            let others = (first..=last).filter(|address| *address != own);
            scan::probe_all(session, others, &mut found).map(|()| found).map_err(ClientError::from)
        });
        let found = wait(py, found)?.map_err(Failure::from)?.map_err(Failure::from)?;
        Ok(found.iter().map(|found| station(found, self.1.devices)).collect())
    }

    /// The gauge at this address. Sends nothing.
    fn gauge(&self, address: u8, via: &str) -> PyResult<Gauge> {
        let bus = self.0.get()?;
        let access = match via {
            "ms2" => Access::Shared(bus.gauge(address)),
            "ms1" => Access::Owning { bus, path: AccessPath::Class1 },
            "pkw" => Access::Owning { bus, path: AccessPath::ParameterChannel },
            _ => return Err(Failure::usage(format!("expected via to be one of ms2, ms1, pkw, got {via:?}")).into()),
        };
        Ok(Gauge { access: Owned::new(access, "gauge"), address, line: self.1 })
    }

    /// Takes ownership of the gauge at this address and begins its cyclic data.
    fn exchange(&self, py: Python<'_>, address: u8) -> PyResult<Cyclic> {
        Cyclic::begin(py, self.0.get()?, address, self.1)
    }

    /// Ends the master, and waits until the port is released, at most for the timeout. The gauges are closed first.
    fn close(&self, py: Python<'_>) {
        if self.0.close(py) {
            py.detach(|| self.2.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(self.1.timeout).ok());
        }
    }
}

fn station(found: &FoundStation, known: KnownDevices) -> StationRow {
    let kind = match found.station_type {
        StationType::Slave => "slave",
        StationType::MasterNotReady => "master, not ready",
        StationType::MasterReady => "master, ready for the ring",
        StationType::MasterInRing => "master",
    };
    let slave = found.slave;
    let devices = slave.map(|slave| known.names_with_ident(slave.ident).collect()).unwrap_or_default();
    let (ident, owner) = (slave.map(|slave| slave.ident), slave.and_then(|slave| slave.owner));
    (found.address, kind, ident, devices, slave.map(|slave| slave.state_text()), owner)
}

/// A reading of one instance or channel.
pub fn pressure_row(value: &ChannelValue) -> PressureRow {
    let cause = value.cause.map(|cause| cause.to_string());
    (value.pa, value.quality.word(), cause, value.limit_pa, value.instance)
}

/// How a gauge is reached.
#[derive(Clone)]
enum Access {
    /// Over MS2, which takes no ownership.
    Shared(AsyncGauge),
    /// Over MS1 or the parameter channel: each request takes ownership and releases the slave.
    Owning { bus: AsyncBus, path: AccessPath },
}

/// A gauge of a bus.
#[pyclass(frozen, module = "profivac._profivac")]
pub struct Gauge {
    access: Owned<Access>,
    address: u8,
    line: Line,
}

/// A request to a gauge.
enum Request {
    Model,
    Pressure(Option<String>),
    Read(String),
    Write { name: String, value: String, force: bool, confirmed: bool },
    Command { words: String, confirmed: bool },
    Dump,
    Differences(String),
    Restore { text: String, force: bool },
    RestoreSelector,
}

/// The answer to a request.
enum Answer {
    Model(&'static Model),
    Pressure(ChannelValue),
    Reading(ParameterReading, Option<f64>),
    Written(Box<WriteResult>),
    Text(String),
    Rows(Vec<settings::Row>),
    Done,
}

impl Request {
    fn execute<R: Records>(self, gauge: &mut ClientGauge<R>) -> Result<Answer, Failure> {
        Ok(match self {
            Self::Model => Answer::Model(gauge.model()),
            Self::Pressure(None) => Answer::Pressure(gauge.pressure()?),
            Self::Pressure(Some(name)) => {
                let named = gauge.find(&name)?;
                Answer::Pressure(gauge.pressure_of(&named)?)
            }
            Self::Read(name) => {
                let reading = gauge.read(&name)?;
                let pa = gauge.pressure_pa(&reading);
                Answer::Reading(reading, pa)
            }
            Self::Write { name, value, force, confirmed } => {
                let named = gauge.find_whole(&name)?;
                let write = if force { gauge.prepare_forced(&named, &value) } else { gauge.prepare(&named, &value) }?;
                execute_confirmed(gauge, write, confirmed)?
            }
            Self::Command { words, confirmed } => {
                let names = gauge.names();
                let found = names.command(&words).map_err(ClientError::from)?;
                let (named, code) = found.ok_or_else(|| unknown_command(gauge.model().name, &words))?;
                let write = gauge.prepare(named, code.name)?;
                execute_confirmed(gauge, write, confirmed)?
            }
            Self::Dump => Answer::Text(profivac_client::settings::dump(gauge)?.to_toml()),
            Self::Differences(text) => {
                let found = settings::differences(gauge, &text)?;
                let row = |it: profivac_client::settings::Difference| {
                    (it.write.named.name.clone(), it.current.text, Some(it.write.text), None)
                };
                Answer::Rows(found.into_iter().map(row).collect())
            }
            Self::Restore { text, force } => Answer::Rows(settings::restore(gauge, &text, force)?),
            Self::RestoreSelector => {
                gauge.restore_selector()?;
                Answer::Done
            }
        })
    }
}

fn unknown_command(device: &str, words: &str) -> Failure {
    Failure::usage(format!("{device} has no command {words:?}; Gauge.commands lists those it has"))
}

/// Sends a write. A command that can do damage needs the word of the user.
fn execute_confirmed<R: Records>(
    gauge: &mut ClientGauge<R>,
    write: PreparedWrite,
    confirmed: bool,
) -> Result<Answer, Failure> {
    let risk = write.code.map_or("", |code| code.risk);
    if !risk.is_empty() && !confirmed {
        let (named, text) = (&write.named, &write.text);
        return Err(Failure::usage(format!("{named} {text} {risk}; nothing was sent; to send it pass confirm=True")));
    }
    Ok(Answer::Written(Box::new(gauge.execute(write).map_err(Failure::of_write)?)))
}

impl Gauge {
    fn request(&self, py: Python<'_>, request: Request) -> PyResult<Answer> {
        let access = self.access.get()?;
        let answer = match &access {
            Access::Shared(gauge) => wait(py, gauge.with(move |gauge| Ok(request.execute(gauge))))?,
            Access::Owning { bus, path } => {
                let (address, line, path) = (self.address, self.line, *path);
                wait(py, bus.submit(move |session| Ok(owning(session, address, line, path, request))))?
                    .and_then(|answer| answer)
            }
        };
        // A handle that `close` has left to this request ends without the interpreter lock.
        py.detach(|| drop(access));
        Ok(answer.map_err(Failure::from)??)
    }
}

/// Takes ownership of a slave that no other master owns, keeps its unit, executes the request, and releases the slave.
fn owning(
    session: &mut BusSession,
    address: u8,
    line: Line,
    path: AccessPath,
    request: Request,
) -> Result<Answer, Failure> {
    let slave = identify::wait_for_slave(session, address)?;
    if let Some(owner) = slave.owner.filter(|owner| *owner != line.master) {
        return Err(Failure::refused(format!(
            "address {address} is owned by master {owner}; ms1 and pkw need ownership: use via=\"ms2\", or release the gauge in its owner"
        )));
    }
    if let Request::Pressure(None) = request {
        // The Process Values of a TPG are in its cyclic data only.
        let values = cyclic::once(session, address, line)?;
        let chosen = values.iter().find(|value| value.is_valid()).or(values.first()).copied();
        return chosen
            .map(Answer::Pressure)
            .ok_or_else(|| Failure::refused(format!("address {address} has no channel")));
    }
    let cyclic = CyclicSlave::find_among(line.devices, session, address, line.master)?;
    let records = Class1Session::open(session, &cyclic, path).map_err(|error| match error {
        RecordError::Session(error) | RecordError::NotSent(error) => Failure::from(ClientError::from(error)),
        RecordError::Interrupted(reason) => Failure::line(format!("address {address}: {reason}")),
        error => Failure::refused(format!("address {address}: {error}")),
    })?;
    let mut gauge = ClientGauge::with_model(records, address, cyclic.model).with_unit(cyclic.unit);
    let answer = request.execute(&mut gauge)?;
    gauge.restore_selector()?;
    Ok(answer)
}

#[pymethods]
impl Gauge {
    /// Name, title, manual, ident number.
    fn model(&self, py: Python<'_>) -> PyResult<(&'static str, &'static str, &'static str, u16)> {
        let Answer::Model(model) = self.request(py, Request::Model)? else { return Err(unexpected()) };
        Ok((model.name, model.title, model.manual, model.ident))
    }

    /// The parameters and the commands of the device.
    fn tables(&self, py: Python<'_>) -> PyResult<(Vec<ParameterRow>, Vec<CommandRow>)> {
        let Answer::Model(model) = self.request(py, Request::Model)? else { return Err(unexpected()) };
        Ok(values::tables(model))
    }

    /// The pressure of the gauge, or of one Process Value.
    fn pressure(&self, py: Python<'_>, name: Option<String>) -> PyResult<PressureRow> {
        let Answer::Pressure(value) = self.request(py, Request::Pressure(name))? else { return Err(unexpected()) };
        Ok(pressure_row(&value))
    }

    /// A parameter.
    fn read(&self, py: Python<'_>, name: String) -> PyResult<ReadingRow> {
        let Answer::Reading(reading, pa) = self.request(py, Request::Read(name))? else { return Err(unexpected()) };
        values::reading(py, &reading, pa)
    }

    /// Writes a parameter.
    fn write(&self, py: Python<'_>, name: String, value: String, force: bool, confirmed: bool) -> PyResult<WriteRow> {
        self.written(py, Request::Write { name, value, force, confirmed })
    }

    /// Sends a command.
    fn command(&self, py: Python<'_>, words: String, confirmed: bool) -> PyResult<WriteRow> {
        self.written(py, Request::Command { words, confirmed })
    }

    /// All values as a settings file.
    fn dump(&self, py: Python<'_>) -> PyResult<String> {
        let Answer::Text(text) = self.request(py, Request::Dump)? else { return Err(unexpected()) };
        Ok(text)
    }

    /// The settings that differ from a settings file.
    fn diff(&self, py: Python<'_>, text: String) -> PyResult<Vec<settings::Row>> {
        self.rows(py, Request::Differences(text))
    }

    /// Writes the settings that differ.
    fn restore(&self, py: Python<'_>, text: String, force: bool) -> PyResult<Vec<settings::Row>> {
        self.rows(py, Request::Restore { text, force })
    }

    /// Moves the Channel Instance Selector back.
    fn restore_selector(&self, py: Python<'_>) -> PyResult<()> {
        self.request(py, Request::RestoreSelector).map(|_| ())
    }

    /// Keeps the MS2 connection open until it was not used for `idle` seconds; closes it without a number.
    fn keep_connection(&self, py: Python<'_>, idle: Option<f64>) -> PyResult<()> {
        let idle = idle.map(|seconds| {
            Duration::try_from_secs_f64(seconds)
                .ok()
                .filter(|idle| (MIN_IDLE..=MAX_IDLE).contains(idle))
                .ok_or_else(|| Failure::usage(format!("expected an idle time from 0.1 s to 3600 s, got {seconds}")))
        });
        let idle = idle.transpose()?;
        match self.access.get()? {
            Access::Shared(gauge) => {
                let done = wait(py, gauge.keep_connection(idle));
                py.detach(|| drop(gauge));
                Ok(done?.map_err(Failure::from)?)
            }
            Access::Owning { .. } => {
                Err(Failure::usage("only MS2 has connections that can be kept: use via=\"ms2\"").into())
            }
        }
    }

    /// Restores the selector and ends the gauge.
    fn close(&self, py: Python<'_>) {
        let bus = match self.access.get() {
            Ok(Access::Shared(gauge)) => Some(gauge.bus().clone()),
            Ok(Access::Owning { .. }) | Err(_) => None,
        };
        // The end of the gauge submits the restoration; a request behind it waits for that.
        if let (true, Some(bus)) = (self.access.close(py), bus) {
            py.detach(|| bus.submit(|_| ()).wait().ok());
        }
    }
}

impl Gauge {
    fn written(&self, py: Python<'_>, request: Request) -> PyResult<WriteRow> {
        let Answer::Written(written) = self.request(py, request)? else { return Err(unexpected()) };
        let row = |reading: &Option<ParameterReading>| {
            reading.as_ref().map(|reading| values::reading(py, reading, None)).transpose()
        };
        Ok((written.named.name.clone(), written.text.clone(), row(&written.before)?, row(&written.after)?))
    }

    fn rows(&self, py: Python<'_>, request: Request) -> PyResult<Vec<settings::Row>> {
        let Answer::Rows(rows) = self.request(py, request)? else { return Err(unexpected()) };
        Ok(rows)
    }
}

/// An answer of another kind than its request, which no request gives.
fn unexpected() -> PyErr {
    pyo3::exceptions::PyRuntimeError::new_err("an answer of another kind than its request")
}
