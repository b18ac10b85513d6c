//! Cyclic data of a gauge that this program owns.

use crate::bus::{Line, PressureRow, pressure_row};
use crate::failure::Failure;
use crate::waiting::{Owned, wait};
use profivac_client::cyclic::{ChannelValue, CyclicSlave};
use profivac_client::{AsyncBus, ClientError};
use profivac_dp::link::BitTime;
use profivac_dp::master::{HandlerState, Mode};
use profivac_host::session::{BusSession, SessionError, add_or_restart};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The longest wait between two looks at the slave.
const SLICE: Duration = Duration::from_millis(5);

/// The longest wait for the release of a slave. chosen: several cycles at the lowest rate.
const RELEASE_TIMEOUT: Duration = Duration::from_secs(1);

/// A slave that exchanges data until the last handle is dropped.
pub struct Exchange {
    bus: AsyncBus,
    slave: CyclicSlave,
    /// The time of the exchange that was returned last.
    last: Mutex<Option<BitTime>>,
}

impl Drop for Exchange {
    fn drop(&mut self) {
        let address = self.slave.address;
        self.bus.submit(move |session| release(session, address)).wait().ok();
    }
}

/// The cyclic data of a gauge.
#[pyclass(frozen, module = "profivac._profivac")]
pub struct Cyclic(Owned<Arc<Exchange>>);

impl Cyclic {
    /// Takes ownership of the slave and begins the exchange.
    pub fn begin(py: Python<'_>, bus: AsyncBus, address: u8, line: Line) -> PyResult<Self> {
        let slave = wait(py, bus.submit(move |session| begin(session, address, line)))?;
        let slave = slave.map_err(Failure::from)??;
        let exchange = Exchange { bus, slave, last: Mutex::new(None) };
        Ok(Self(Owned::new(Arc::new(exchange), "exchange")))
    }
}

#[pymethods]
impl Cyclic {
    /// The readings of the next exchange: one for each channel of the configuration.
    fn next(&self, py: Python<'_>) -> PyResult<Vec<PressureRow>> {
        let exchange = self.0.get()?;
        let last = *exchange.last.lock().unwrap_or_else(PoisonError::into_inner);
        let slave = exchange.slave;
        let next = wait(py, exchange.bus.submit(move |session| next(session, &slave, last)))?;
        let (at, values) = next.map_err(Failure::from)??;
        *exchange.last.lock().unwrap_or_else(PoisonError::into_inner) = Some(at);
        py.detach(|| drop(exchange));
        Ok(values.iter().map(pressure_row).collect())
    }

    /// Releases the slave.
    fn close(&self, py: Python<'_>) {
        self.0.close(py);
    }
}

/// Finds the slave, which no other master may own, and parameterises it with its present unit.
fn begin(session: &mut BusSession, address: u8, line: Line) -> Result<CyclicSlave, Failure> {
    let slave = CyclicSlave::find_among(line.devices, session, address, line.master)?;
    let parameters = slave.parameters(session.baud());
    add_or_restart(session.master(), &parameters).map_err(Failure::refused)?;
    session.master().set_mode(Mode::Operate);
    Ok(slave)
}

/// The readings of the first exchange after `last`.
fn next(
    session: &mut BusSession,
    slave: &CyclicSlave,
    last: Option<BitTime>,
) -> Result<(BitTime, Vec<ChannelValue>), Failure> {
    let (begun, address) = (Instant::now(), slave.address);
    loop {
        let master = session.master();
        while master.next_event().is_some() {}
        let is_exchanging = master.state(address).is_some_and(HandlerState::is_exchanging);
        let at = master.exchanged_at(address).filter(|at| is_exchanging && Some(*at) != last);
        if let (Some(at), Some(inputs)) = (at, master.inputs(address)) {
            return Ok((at, slave.decode_inputs(inputs).values));
        }
        if begun.elapsed() >= session.timeout() {
            let reason =
                session.master().exchange_error(address).map_or_else(String::new, |error| format!(": {error}"));
            return Err(Failure::line(format!("address {address} exchanges no data within the timeout{reason}")));
        }
        session.serve(&[], SLICE).map_err(|error| ClientError::from(SessionError::from(error)))?;
    }
}

/// Gives the slave up, so that another master may own it.
fn release(session: &mut BusSession, address: u8) {
    let begun = Instant::now();
    session.master().release(address);
    while session.master().state(address) != Some(HandlerState::Inactive) && begun.elapsed() < RELEASE_TIMEOUT {
        if session.serve(&[], SLICE).is_err() {
            return;
        }
        while session.master().next_event().is_some() {}
    }
}

/// One reading of each channel; the slave is released afterwards.
pub fn once(session: &mut BusSession, address: u8, line: Line) -> Result<Vec<ChannelValue>, Failure> {
    let slave = begin(session, address, line)?;
    let values = next(session, &slave, None);
    release(session, address);
    Ok(values?.1)
}
