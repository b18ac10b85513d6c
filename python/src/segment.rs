//! Virtual gauges in memory, with their controls: a chamber for notebooks and tests.

use crate::bus::{Bus, Line};
use crate::devices;
use crate::failure::Failure;
use crate::plant_model::{PlaceRow, PlantModel};
use crate::waiting::Owned;
use crate::whole::Whole;
use profivac_client::Pressure;
use profivac_devices::catalog::KnownDevices;
use profivac_dp::link::Baud;
use profivac_host::port::{PortError, Stream};
use profivac_host::readiness::{WakeSource, Waker, waker};
use profivac_host::segment::Segment as HostSegment;
use profivac_vacuum::Gas;
use profivac_virtual::action_text::ActionText;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::{DeviceSpec, check_addresses, parse_address};
use profivac_virtual::gas_pressure::GasPressure;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use pyo3::prelude::*;
use std::os::unix::net::UnixStream;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// The baud rate in whose bit times the delays of the devices count.
const BAUD: Baud = Baud::B19200;

/// The longest `advance`: thirty years.
const MAX_SECONDS: f64 = 1e9;

/// The longest wait of the thread without a request.
const IDLE_WAIT: Duration = Duration::from_secs(1);

type Job = Box<dyn FnOnce(&mut Vec<VirtualDevice>) + Send>;

/// The other side of the thread that serves the devices.
#[derive(Clone)]
struct Handle {
    jobs: Sender<Job>,
    wake: Waker,
}

/// Virtual gauges on a line in memory.
#[pyclass(frozen, module = "profivac._profivac")]
pub struct Segment {
    handle: Owned<Handle>,
    /// One gas for all devices; `None` where a plant has the pressures.
    conditions: Option<Mutex<GasConditions>>,
    /// The devices that its bus knows: the twelve, and those of the device files of the segment.
    known: KnownDevices,
    port: Mutex<Option<UnixStream>>,
}

#[pymethods]
impl Segment {
    /// Switches the devices on, in a chamber with one gas.
    #[new]
    fn new(
        devices: Vec<String>,
        pressure: &str,
        atmosphere: &str,
        gas: &str,
        seed: Option<Whole<u64>>,
    ) -> PyResult<Self> {
        let conditions =
            GasConditions { pressure: chamber(pressure)?, atmosphere: chamber(atmosphere)?, gas: gas_named(gas)? };
        let (devices, known) = switched_on(&devices, conditions)?;
        let real = |device: VirtualDevice| match seed {
            Some(Whole(seed)) => device.with_real_sensors(seed),
            None => device,
        };
        Self::of(devices.into_iter().map(real).collect(), Some(conditions), known)
    }

    /// Switches devices on in a plant: each with the number of its volume, and those of its other measuring parts by instance.
    #[staticmethod]
    fn in_plant(
        py: Python<'_>,
        plant: PyRef<'_, PlantModel>,
        devices: Vec<String>,
        places: Vec<PlaceRow>,
        seed: Option<Whole<u64>>,
    ) -> PyResult<Self> {
        // The plant gives each device its own environment.
        let any = GasConditions {
            pressure: Pressure::from_mbar(1000.0),
            atmosphere: Pressure::from_mbar(1000.0),
            gas: Gas::N2,
        };
        let (devices, known) = switched_on(&devices, any)?;
        let placed = plant.with(py, |world| world.place(devices, &places, seed.map(|seed| seed.0)))?;
        Self::of(placed, None, known)
    }

    /// Makes this program a master on the line of the devices. The line has one.
    fn bus(&self, py: Python<'_>, master: Whole<u8>, timeout: f64) -> PyResult<Bus> {
        let line = Line::new(BAUD.bits_per_second(), master.0, timeout)?.knowing(self.known);
        let port = self.port.lock().unwrap_or_else(PoisonError::into_inner).take();
        let port = port.ok_or_else(|| Failure::usage("the segment has a master already; make another segment"))?;
        Bus::on(py, Box::new(Stream::new("sim".to_owned(), port, Vec::new())), line)
    }

    /// Sets pressure, atmosphere or gas. The devices settle.
    fn set(&self, py: Python<'_>, quantity: &str, value: &str) -> PyResult<()> {
        let conditions = {
            let common = self.conditions.as_ref();
            let common = common.ok_or_else(|| Failure::usage("the plant has the pressures; change its parts"))?;
            let mut conditions = common.lock().unwrap_or_else(PoisonError::into_inner);
            match quantity {
                "pressure" => conditions.pressure = chamber(value)?,
                "atmosphere" => conditions.atmosphere = chamber(value)?,
                "gas" => conditions.gas = gas_named(value)?,
                _ => {
                    return Err(
                        Failure::usage(format!("expected pressure, atmosphere or gas, got {quantity:?}")).into()
                    );
                }
            }
            *conditions
        };
        self.run(py, move |devices| {
            devices.iter_mut().for_each(|device| device.settle_in(conditions));
            Ok(())
        })
    }

    /// Lets time pass for the devices: timers, run hours, ignition.
    fn advance(&self, py: Python<'_>, seconds: f64) -> PyResult<()> {
        if !(0.0..=MAX_SECONDS).contains(&seconds) {
            return Err(Failure::usage(format!("expected seconds from 0 to {MAX_SECONDS:e}, got {seconds}")).into());
        }
        self.run(py, move |devices| {
            devices.iter_mut().for_each(|device| device.advance(seconds));
            Ok(())
        })
    }

    /// Switches a device on or off.
    fn power(&self, py: Python<'_>, address: Whole<u8>, on: bool) -> PyResult<()> {
        self.at(py, address.0, move |device| {
            device.set_power(on);
            Ok(())
        })
    }

    /// Sets or clears a fault.
    fn fault(&self, py: Python<'_>, address: Whole<u8>, name: String, present: bool) -> PyResult<()> {
        self.at(py, address.0, move |device| {
            let (device_name, address) = (device.device().name(), device.switch_address());
            device
                .operate_text(ActionText::Fault { name: &name, present })
                .map_err(|unknown| Failure::usage(format!("{device_name} at address {address} has {unknown}")))
        })
    }

    /// Ends the devices when their line is closed, too.
    fn close(&self, py: Python<'_>) {
        self.handle.close(py);
        drop(self.port.lock().unwrap_or_else(PoisonError::into_inner).take());
    }
}

impl Segment {
    fn of(devices: Vec<VirtualDevice>, conditions: Option<GasConditions>, known: KnownDevices) -> PyResult<Self> {
        let (ours, handle) = serve(devices).map_err(Failure::line)?;
        Ok(Self {
            handle: Owned::new(handle, "segment"),
            conditions: conditions.map(Mutex::new),
            known,
            port: Mutex::new(Some(ours)),
        })
    }

    /// Runs `work` in the thread of the devices, without the interpreter lock.
    pub fn run<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Vec<VirtualDevice>) -> Result<T, Failure> + Send + 'static,
    ) -> PyResult<T> {
        let handle = self.handle.get()?;
        let (done, result) = channel();
        // If the thread has ended, the job is dropped with its sender.
        let job: Job = Box::new(move |devices| {
            done.send(work(devices)).ok();
        });
        handle.jobs.send(job).ok();
        handle.wake.wake();
        let result = py.detach(move || result.recv());
        Ok(result.map_err(|_| Failure::line("the line of the segment is closed; make another segment"))??)
    }

    fn at(
        &self,
        py: Python<'_>,
        address: u8,
        work: impl FnOnce(&mut VirtualDevice) -> Result<(), Failure> + Send + 'static,
    ) -> PyResult<()> {
        self.run(py, move |devices| {
            let named = |device: &VirtualDevice| format!("{} ({})", device.switch_address(), device.device().name());
            let known: Vec<_> = devices.iter().map(named).collect();
            let device = devices.iter_mut().find(|device| device.switch_address() == address);
            work(device.ok_or_else(|| {
                Failure::usage(format!("no device at address {address}; known: {}", known.join(", ")))
            })?)
        })
    }
}

fn chamber(text: &str) -> Result<Pressure, Failure> {
    Ok(text.parse::<GasPressure>().map_err(Failure::usage)?.0)
}

fn gas_named(text: &str) -> Result<Gas, Failure> {
    text.parse().map_err(Failure::usage)
}

/// The devices, and those that their bus knows.
fn switched_on(specs: &[String], around: GasConditions) -> Result<(Vec<VirtualDevice>, KnownDevices), Failure> {
    let parsed: Result<Vec<DeviceSpec>, _> = specs.iter().map(|spec| spec.parse()).collect();
    let parsed = parsed.map_err(Failure::usage)?;
    check_addresses(&parsed).map_err(Failure::usage)?;
    let build = |spec: &DeviceSpec| {
        parse_address(&spec.address.to_string()).map_err(Failure::usage)?;
        let unit = spec.build(NonvolatileMemory::volatile(), BAUD).map_err(Failure::usage)?;
        Ok(VirtualDevice::new(unit, spec.address, BAUD, around))
    };
    let switched_on = parsed.iter().map(build).collect::<Result<Vec<_>, Failure>>()?;
    Ok((switched_on, devices::of(parsed.iter().map(|spec| spec.model))))
}

/// Serves the devices in a thread. It ends with the line of the master.
fn serve(devices: Vec<VirtualDevice>) -> Result<(UnixStream, Handle), PortError> {
    let failed = |source| PortError::System { name: "sim".to_owned(), source };
    let (ours, theirs) = UnixStream::pair().map_err(failed)?;
    for socket in [&ours, &theirs] {
        socket.set_nonblocking(true).map_err(failed)?;
    }
    let (wake, source) = waker().map_err(failed)?;
    let (jobs, work) = channel();
    let port = Box::new(Stream::new("sim".to_owned(), theirs, Vec::new()));
    let segment = HostSegment::new(port, BAUD, false, devices);
    thread::Builder::new().name("sim".to_owned()).spawn(move || live(segment, &work, source)).map_err(failed)?;
    Ok((ours, Handle { jobs, wake }))
}

/// Serves the line and runs the jobs until the line is closed. Between two jobs the line is served once: a plant that advances sends one
/// job after the other.
fn live(mut segment: HostSegment<Vec<VirtualDevice>>, work: &Receiver<Job>, mut wake: WakeSource) {
    let mut has_controls = true;
    loop {
        let mut wait = IDLE_WAIT;
        if has_controls {
            match work.try_recv() {
                Ok(job) => {
                    job(segment.stations_mut());
                    wait = Duration::ZERO;
                }
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => has_controls = false,
            }
        }
        let served = if has_controls { segment.serve(&[wake.readiness()], wait) } else { segment.serve(&[], wait) };
        let Ok(readable) = served else { return };
        if readable.first() == Some(&true) {
            has_controls = wake.clear();
        }
    }
}
