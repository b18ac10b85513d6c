//! A master: it brings slaves into data exchange, keeps them there and reports why one is not. profibus-wire 2 and 3.10.
//!
//! [`Master`] is the FDL user of an [`Active`] station. In each cycle it sends every slave one request, in the order in which
//! they were added: the one that the slave's handler needs next. Beside the cycle the user submits one raw request at a time
//! ([`Master::submit_request`]) and takes its confirmation ([`Master::take_confirmation`]); a master without slaves, or in
//! [`Mode::Stop`], sends nothing else. MS2, MS1 and the parameter channel have handles: [`Master::ms2_open`],
//! [`Master::ms1_read`], [`Master::pkw_read`] and [`Master::outcome`].
//!
//! ```
//! use profivac_dp::link::active::BusParameters;
//! use profivac_dp::link::{Baud, BitTime, Station};
//! use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};
//!
//! // Room for 8 slaves with up to 32 octets each way.
//! let bus = BusParameters::new(2, Baud::B19200).check()?;
//! let mut station = Master::<8, 32>::on(bus, Settings::new(Baud::B19200), BitTime(0));
//! // Two octets in and two octets out.
//! station.user.add(&SlaveParameters::new(8, 0x1234, &[0x11, 0x21]))?;
//! station.user.set_mode(Mode::Operate);
//!
//! // The line has been idle for T_TO: the master takes the token.
//! let due = station.wake_at().expect("listening has a time limit");
//! assert_eq!(station.poll(due).map(|token| token.octets.to_vec()), Some(vec![0xDC, 2, 2]));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

mod acyclic;
mod control;
mod cycle;
mod event;
mod ext_diag;
mod handler;
pub mod ms1;
pub mod ms2;
mod parameters;
pub mod pkw;
mod raw_request;
mod requests;
mod scheduler;
pub mod services;
mod slave_list;
mod state;

pub use acyclic::{AcyclicEvent, AcyclicId, Cause, ConnectionEnd, Handle, ResponseMismatch, Service, SubmitError};
pub use control::{ControlError, MAX_PENDING_COMMANDS};
pub use event::{Event, EventKind, ExchangeError};
pub use ext_diag::{ExtDiag, ExtDiagEntry};
pub use ms1::Ms1Parameters;
pub use ms2::{Ms2Parameters, Opened, Phase};
pub use parameters::{Settings, SlaveData, SlaveListError, SlaveParameters, watchdog_factors};
pub use pkw::PkwParameters;
pub use raw_request::Busy;
pub use scheduler::Operation;
pub use state::{Counters, HandlerState};

use crate::link::BitTime;
use crate::link::active::{Active, CheckedBus, Confirmation, FdlUser, Priority, Request};
use control::{ControlMessage, Controls};
use core::fmt;
use event::Events;
use handler::{Change, Context, Handler};
use heapless::Vec;
use profivac_wire::diag::SlaveDiag;
use profivac_wire::{MAX_DU, Sap};
use raw_request::RawRequest;
use scheduler::{QueueIndex, Scheduler};
use state::CyclicRequest;

/// The highest address of a slave that can be parameterised.
const MAX_ADDRESS: u8 = 125;

/// The index of an address without a slave.
const NO_SLAVE: u8 = u8::MAX;

/// The outputs in Clear.
const ZEROS: [u8; MAX_DU] = [0; MAX_DU];

/// The mode of a master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// No requests of the cycle: the watchdogs of the slaves expire.
    Stop,
    /// Data exchange with safe outputs; inputs are valid.
    Clear,
    /// Data exchange.
    Operate,
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stop => "STOP",
            Self::Clear => "CLEAR",
            Self::Operate => "OPERATE",
        })
    }
}

/// The request whose confirmation is awaited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pending {
    Nothing,
    Control(ControlMessage),
    Slave(usize, CyclicRequest),
    RawRequest,
    Acyclic(QueueIndex),
}

/// A master with room for `SLAVES` slaves, each with up to `OCTETS` octets of inputs, outputs, configuration, user parameters
/// and extended diagnosis. The event queue holds `EVENTS` events. Up to `ACYCLIC` MS2 connections, as many MS1 requests and as
/// many tasks in parameter channels are under way at the same time.
#[derive(Clone, Debug)]
pub struct Master<const SLAVES: usize, const OCTETS: usize, const EVENTS: usize = 64, const ACYCLIC: usize = 4> {
    address: u8,
    settings: Settings,
    mode: Mode,
    slaves: Vec<Handler<OCTETS>, SLAVES>,
    /// The index in `slaves` for each address.
    index_by_address: [u8; MAX_ADDRESS as usize + 1],
    exchanging: usize,
    pending: Pending,
    /// The index of the next slave in the cycle; `None` between two cycles.
    next_in_list: Option<usize>,
    cycles: u32,
    /// The beginning of the present cycle, and the duration of the one before, from beginning to beginning.
    began: BitTime,
    cycle_tbit: u64,
    controls: Controls,
    /// When the last request to a slave was sent.
    requested_at: BitTime,
    /// The master is stopping and sends its slaves safe outputs before: since the cycle that began then.
    shutdown: Option<Option<BitTime>>,
    /// The master polls one absent slave per cycle, so that they do not slow down the others: the next is at this index or a
    /// later one.
    offline_from: usize,
    offline_polled: bool,
    events: Events<EVENTS>,
    raw_request: RawRequest,
    acyclic: Scheduler<ACYCLIC>,
    /// The last message beside the cycle was the raw request.
    raw_request_was_last: bool,
    du: [u8; MAX_DU],
    now: BitTime,
}

impl<const SLAVES: usize, const OCTETS: usize, const EVENTS: usize, const ACYCLIC: usize>
    Master<SLAVES, OCTETS, EVENTS, ACYCLIC>
{
    /// An active station with a master that begins to listen at `now`: without slaves, in [`Mode::Stop`].
    pub const fn on(bus: CheckedBus, settings: Settings, now: BitTime) -> Active<Self> {
        Active::new(bus, Self::new(bus.get().address, settings, now), now)
    }

    const fn new(address: u8, settings: Settings, now: BitTime) -> Self {
        Self {
            address,
            settings,
            mode: Mode::Stop,
            slaves: Vec::new(),
            index_by_address: [NO_SLAVE; MAX_ADDRESS as usize + 1],
            exchanging: 0,
            pending: Pending::Nothing,
            next_in_list: None,
            cycles: 0,
            began: now,
            cycle_tbit: 0,
            controls: Controls::new(),
            requested_at: now,
            shutdown: None,
            offline_from: 0,
            offline_polled: false,
            events: Events::new(),
            raw_request: RawRequest::new(),
            acyclic: Scheduler::new(),
            raw_request_was_last: false,
            du: [0; MAX_DU],
            now,
        }
    }

    /// Adds a slave at the end of the cycle.
    ///
    /// # Errors
    /// [`SlaveListError`] when the list is full or the parameters are impossible.
    pub fn add(&mut self, parameters: &SlaveParameters<'_>) -> Result<(), SlaveListError> {
        let address = parameters.address;
        let full = SlaveListError::Full { capacity: SLAVES };
        let index = u8::try_from(self.slaves.len()).map_err(|_| full)?;
        let entry = self
            .index_by_address
            .get_mut(usize::from(address))
            .filter(|_| address != self.address)
            .ok_or(SlaveListError::Address(address))?;
        if *entry != NO_SLAVE {
            return Err(SlaveListError::Taken(address));
        }
        self.slaves.push(Handler::new(parameters)?).map_err(|_| full)?;
        *entry = index;
        Ok(())
    }

    /// Takes a slave out of the cycle and unlocks it, if this master may own it. The slave reaches
    /// [`HandlerState::Inactive`] in [`Mode::Clear`] and [`Mode::Operate`] only.
    pub fn release(&mut self, address: u8) {
        self.with(address, |slave, context| slave.release(context));
    }

    /// Restarts a slave as if it had just been added.
    pub fn restart(&mut self, address: u8) {
        self.with(address, |slave, context| slave.start(context));
    }

    /// The mode.
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// Changes the mode. The master sends it to the slaves with the next message, and then repeatedly.
    ///
    /// Before [`Mode::Stop`] the master sends every slave in data exchange safe outputs once more: a slave without a watchdog
    /// would keep its last outputs.
    pub fn set_mode(&mut self, mode: Mode) {
        self.shutdown = (mode == Mode::Stop && self.mode != Mode::Stop && self.exchanging > 0).then_some(None);
        self.mode = mode;
        self.controls.mode_due = true;
        if mode == Mode::Stop {
            self.controls.forget();
            self.next_in_list = None;
        }
    }

    /// The slaves, in the order of the cycle.
    pub fn addresses(&self) -> impl Iterator<Item = u8> {
        self.slaves.iter().map(|slave| slave.address)
    }

    /// The state of a slave; `None` if this master has no such slave.
    pub fn state(&self, address: u8) -> Option<HandlerState> {
        self.slave(address).map(Handler::state)
    }

    /// The reason why a slave does not exchange data; `None` if it does, or if the reason is not known yet.
    pub fn exchange_error(&self, address: u8) -> Option<ExchangeError> {
        self.slave(address)?.error()
    }

    /// The counters of a slave.
    pub fn counters(&self, address: u8) -> Option<&Counters> {
        self.slave(address).map(Handler::counters)
    }

    /// The last diagnosis of a slave. [`ext_diag`](Self::ext_diag) returns the entries behind its fixed octets.
    pub fn diagnosis(&self, address: u8) -> Option<SlaveDiag<'_>> {
        self.slave(address)?.diagnosis()
    }

    /// The inputs of a slave from its last answer. `None` unless it exchanges data.
    pub fn inputs(&self, address: u8) -> Option<&[u8]> {
        self.slave(address).filter(|_| self.mode != Mode::Stop)?.inputs()
    }

    /// The time of the last answer with inputs: inputs become old while another master uses the line. `None` unless the slave
    /// exchanges data.
    pub fn exchanged_at(&self, address: u8) -> Option<BitTime> {
        self.slave(address)?.exchanged_at()
    }

    /// The outputs of a slave, sent with the next exchange in [`Mode::Operate`]. The configuration determines their length.
    pub fn outputs_mut(&mut self, address: u8) -> Option<&mut [u8]> {
        let index = self.index_of(address)?;
        self.slaves.get_mut(index).map(Handler::outputs_mut)
    }

    /// The number of slaves that exchange data.
    pub const fn exchanging(&self) -> usize {
        self.exchanging
    }

    /// The number of cycles begun.
    pub const fn cycles(&self) -> u32 {
        self.cycles
    }

    /// The duration of the last cycle, from its start to the start of the next, in bit times.
    pub const fn cycle_tbit(&self) -> u64 {
        self.cycle_tbit
    }

    /// Takes the oldest event.
    pub fn next_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    /// Whether events were lost since the last call, because the queue was full.
    pub fn take_overflow(&mut self) -> bool {
        self.events.take_overflow()
    }

    /// Submits a raw request, to be sent once beside the cycle with low priority. See [`services`]. It uses the same frame
    /// count as all requests to that station.
    ///
    /// # Errors
    /// [`Busy`] until the confirmation of the previous request was taken.
    pub fn submit_request(&mut self, request: &Request<'_>) -> Result<(), Busy> {
        self.raw_request.submit(request)
    }

    /// Takes the confirmation of the raw request.
    pub fn take_confirmation(&mut self) -> Option<Confirmation<'_>> {
        self.raw_request.take()
    }

    fn slave(&self, address: u8) -> Option<&Handler<OCTETS>> {
        self.slaves.get(self.index_of(address)?)
    }

    fn with(&mut self, address: u8, action: impl FnOnce(&mut Handler<OCTETS>, &mut Context<'_>)) {
        if let Some(index) = self.index_of(address) {
            self.with_index(index, action);
        }
    }

    fn with_index(&mut self, index: usize, action: impl FnOnce(&mut Handler<OCTETS>, &mut Context<'_>)) -> Change {
        let mut context = Context {
            now: self.now,
            address: self.address,
            settings: &self.settings,
            events: self.events.sink(),
            exchanging: &mut self.exchanging,
            control_due: &mut self.controls.mode_due,
            requested_at: self.requested_at,
            change: Change::Nothing,
        };
        if let Some(slave) = self.slaves.get_mut(index) {
            action(slave, &mut context);
        }
        context.change
    }

    /// Evaluates any confirmation of a request to a slave.
    #[inline(never)]
    fn confirm_slave(&mut self, index: usize, request: CyclicRequest, confirmation: Confirmation<'_>) {
        let change = self.with_index(index, |slave, context| slave.confirmed(request, confirmation, context));
        if change != Change::Nothing {
            self.changed(index, change);
        }
    }

    /// The next request beside the cycle: the raw request and the acyclic ones in turn. Kept out of the cycle, whose code stays
    /// short.
    #[inline(never)]
    fn next_beside(&mut self, now: BitTime) -> Option<Request<'_>> {
        self.elapse(now);
        let raw_is_waiting = self.raw_request.is_waiting();
        let raw_is_next = raw_is_waiting && !self.raw_request_was_last;
        let acyclic = if raw_is_next { None } else { self.acyclic.due(now) };
        self.raw_request_was_last = raw_is_waiting && acyclic.is_none();
        match acyclic {
            Some(index) => {
                self.pending = Pending::Acyclic(index);
                self.acyclic.message(index)
            }
            None if raw_is_waiting => {
                self.pending = Pending::RawRequest;
                self.raw_request.start()
            }
            None => None,
        }
    }

    /// Evaluates the parameter channel of a slave that has just exchanged data.
    #[inline(never)]
    fn channel_exchanged(&mut self, index: usize, request: CyclicRequest) {
        let Some(slave) = self.slaves.get(index).filter(|slave| slave.exchanged_at() == Some(self.now)) else { return };
        if let (CyclicRequest::DataExch, Some(inputs)) = (request, slave.inputs()) {
            self.acyclic.exchanged(self.now, slave.address, inputs, &mut self.events.sink());
        }
    }

    /// The request to a slave.
    #[inline]
    fn message(&mut self, index: usize, request: CyclicRequest) -> Option<Request<'_>> {
        let slave = self.slaves.get(index)?;
        let da = slave.address;
        Some(match request {
            CyclicRequest::DataExch => services::data_exchange(
                da,
                match self.mode {
                    Mode::Operate if !self.controls.is_cleared(slave.group) && self.acyclic.is_idle() => {
                        slave.outputs()
                    }
                    Mode::Operate if !self.controls.is_cleared(slave.group) => {
                        self.acyclic.with_channel(da, slave.outputs(), &mut self.du)
                    }
                    Mode::Operate | Mode::Clear | Mode::Stop => ZEROS.get(..slave.cleared_outputs())?,
                },
            ),
            CyclicRequest::SlaveDiag => services::slave_diag(da),
            CyclicRequest::FdlStatus => services::fdl_status(da),
            CyclicRequest::ChkCfg => services::ms0(da, Sap::ChkCfg, slave.cfg()),
            CyclicRequest::SetPrm | CyclicRequest::Unlock => {
                let prm = if request == CyclicRequest::Unlock { slave.unlock() } else { slave.set_prm() };
                let length = prm.emit(&mut self.du).ok()?;
                services::ms0(da, Sap::SetPrm, self.du.get(..length)?)
            }
        })
    }
}

impl<const SLAVES: usize, const OCTETS: usize, const EVENTS: usize, const ACYCLIC: usize> FdlUser
    for Master<SLAVES, OCTETS, EVENTS, ACYCLIC>
{
    #[inline]
    fn next_request(&mut self, priority: Priority, now: BitTime) -> Option<Request<'_>> {
        self.now = now;
        match priority {
            Priority::High => {
                self.pending = self.next_in_cycle(now)?;
                match self.pending {
                    Pending::Slave(index, request) => {
                        self.requested_at = now;
                        self.message(index, request)
                    }
                    Pending::Control(control) => self.global_control(control),
                    Pending::RawRequest | Pending::Acyclic(_) | Pending::Nothing => None,
                }
            }
            Priority::Low => self.next_beside(now),
        }
    }

    #[inline]
    fn confirm(&mut self, now: BitTime, confirmation: Confirmation<'_>) {
        self.now = now;
        match core::mem::replace(&mut self.pending, Pending::Nothing) {
            Pending::Slave(index, request) => {
                let requested_at = self.requested_at;
                let usual = self
                    .slaves
                    .get_mut(index)
                    .is_some_and(|slave| slave.accept_inputs(request, &confirmation, now, requested_at));
                if !usual {
                    self.confirm_slave(index, request, confirmation);
                }
                if !self.acyclic.is_idle() {
                    self.channel_exchanged(index, request);
                }
            }
            Pending::Control(control) => self.controls.confirmed(control, confirmation == Confirmation::Sent),
            Pending::RawRequest => self.raw_request.finish(confirmation),
            Pending::Acyclic(due) => self.acyclic.confirmed(due, now, confirmation, &mut self.events.sink()),
            Pending::Nothing => {}
        }
    }

    fn stray(&mut self, now: BitTime, sender: u8) {
        self.now = now;
        self.with(sender, Handler::stray_answer);
    }
}
