//! A passive DP station. profibus-wire 2 and 3.
//!
//! [`Slave`] joins the link layer's [`Responder`] to the services and a [`Device`].
//!
//! ```
//! use profivac_dp::link::{Baud, BitTime, Station};
//! use profivac_dp::slave::{CfgFault, Device, Features, Outputs, PrmFault, Slave, SlaveState};
//! use profivac_wire::{DataTelegram, Telegram, cfg};
//!
//! /// Two octets of outputs, which it returns as inputs.
//! struct Echo([u8; 2]);
//!
//! impl Device for Echo {
//!     fn ident_number(&self) -> u16 {
//!         0x1234
//!     }
//!     fn features(&self) -> Features {
//!         Features::default()
//!     }
//!     fn set_prm(&mut self, _user: &[u8]) -> Result<(), PrmFault> {
//!         Ok(())
//!     }
//!     fn chk_cfg(&mut self, cfg: &[u8]) -> Result<cfg::Lengths, CfgFault> {
//!         if cfg != self.get_cfg() {
//!             return Err(CfgFault);
//!         }
//!         cfg::lengths(cfg).map_err(|_| CfgFault)
//!     }
//!     fn get_cfg(&self) -> &[u8] {
//!         &[0x11, 0x21]
//!     }
//!     fn outputs(&mut self, outputs: Outputs<'_>) {
//!         self.0 = match outputs {
//!             Outputs::Data(data) => data.try_into().unwrap_or_default(),
//!             Outputs::Safe => [0; 2],
//!         };
//!     }
//!     fn inputs(&mut self, inputs: &mut [u8]) {
//!         inputs.copy_from_slice(&self.0);
//!     }
//! }
//!
//! let mut slave = Slave::new(Echo([0; 2]), 8, Baud::B19200);
//! // Master 2 asks for the FDL status; the telegram ended at 1000 bit times.
//! let request = Telegram::parse(&[0x10, 8, 2, 0x49, 0x53, 0x16]).expect("a telegram");
//! let answer = slave.telegram(BitTime(1000), &request).expect("an answer");
//! assert_eq!(answer.octets, [0x10, 2, 8, 0x00, 0x0A, 0x16]);
//! assert_eq!(answer.not_before, BitTime(1011), "min T_SDR");
//!
//! // Master 2 parameterises it: Lock_Req, no watchdog, min T_SDR of 11 bit times, Ident_Number.
//! let prm = [0x80, 0, 0, 11, 0x12, 0x34, 0];
//! let request = DataTelegram { da: 8, sa: 2, dsap: Some(61), ssap: Some(62), fc: 0x6D, du: &prm };
//! assert!(slave.telegram(BitTime(2000), &Telegram::Data(request)).is_some());
//! assert_eq!(slave.state().to_string(), "WAIT-CFG");
//! let owner = slave.state().owner().expect("a parameterised slave has an owner");
//! assert_eq!((owner.master, owner.watchdog), (2, None));
//! assert!(slave.state().is_locked_against(3) && !slave.state().is_exchanging());
//!
//! slave.power_up(8);
//! assert_eq!(*slave.state(), SlaveState::POWER_UP);
//! ```

mod acyclic;
mod device;
mod prepared;
mod server;
mod state;

pub use device::{CfgFault, Device, Diagnosis, Dpv1Error, Features, Outputs, PrmFault, Relation};
pub use server::MAX_INITIATE_PDU;
pub use state::{ExchangeState, Fault, Owner, SlaveState, Watchdog};

use crate::link::{Accepted, Baud, BitTime, Listening, Reply, Responder, Station, Transmit};
use prepared::Expected;
use profivac_wire::{DataTelegram, Telegram};
use server::{Exchange, MIN_TSDR_TBIT, Server};

/// The most MS2 connections: one for each access point from 0 to 48.
const MAX_CONNECTIONS: usize = 49;

/// A passive DP station with device `D` and room for `CONNECTIONS` MS2 connections, at most 49.
#[derive(Clone, Debug)]
pub struct Slave<D, const CONNECTIONS: usize = 2> {
    responder: Responder,
    server: Server<D, CONNECTIONS>,
    /// The request whose answer the responder has prepared.
    expected: Expected,
}

impl<D: Device> Slave<D> {
    /// A slave at `address` that has just been switched on.
    pub fn new(device: D, address: u8, baud: Baud) -> Self {
        Self::with_connections(device, address, baud)
    }
}

impl<D: Device, const CONNECTIONS: usize> Slave<D, CONNECTIONS> {
    /// As [`Slave::new`], with the number of MS2 connections of the type.
    pub fn with_connections(device: D, address: u8, baud: Baud) -> Self {
        const { assert!(CONNECTIONS <= MAX_CONNECTIONS, "access points 0 to 48 are for connections") }
        Self { responder: Responder::new(address), server: Server::new(device, baud), expected: Expected::NOTHING }
    }

    /// Power returns: the slave drops masters, parameters and answers. The caller resets the device.
    pub fn power_up(&mut self, address: u8) {
        self.expected.clear();
        self.server.enter_wait_prm(Fault::None);
        self.set_address(address);
        self.server.min_tsdr = MIN_TSDR_TBIT;
    }

    /// The bus was lost and found again, at `baud`: the slave drops frame counts and closes connections, MS0 keeps its state.
    /// A slave whose watchdog runs has lost its master before it could lose the rate. profibus-wire 3.6 and 3.2,
    /// transition 15. min T_SDR stays too, unless it is longer than `baud` allows. Times after this call are in bit times of `baud` and may
    /// start at any value.
    pub fn rate_found(&mut self, baud: Baud) {
        self.expected.clear();
        if self.watchdog_is_running() {
            self.server.enter_wait_prm(Fault::None);
        }
        self.server.set_baud(baud);
        self.set_address(self.responder.address());
    }

    /// Whether the response watchdog runs.
    pub fn watchdog_is_running(&self) -> bool {
        self.server.state.owner().is_some_and(|owner| owner.watchdog.is_some())
    }

    /// The application ends data exchange or requests new parameters: profibus-wire 3.2, transitions 16 and 17.
    pub fn return_to_wait_prm(&mut self) {
        self.expected.clear();
        self.server.enter_wait_prm(Fault::None);
    }

    /// As [`Responder::forget_answer`], for tests of a master.
    pub const fn forget_answer(&mut self) {
        self.responder.forget_answer();
    }

    /// The device.
    pub const fn device(&self) -> &D {
        &self.server.device
    }

    /// The device, to change its process values or its time. A prepared answer is dropped: its inputs may be old then.
    pub const fn device_mut(&mut self) -> &mut D {
        self.expected.clear();
        &mut self.server.device
    }

    /// The state.
    pub const fn state(&self) -> &SlaveState {
        &self.server.state
    }

    /// The station address.
    pub const fn address(&self) -> u8 {
        self.responder.address()
    }

    /// min T_SDR in bit times.
    pub const fn min_tsdr_tbit(&self) -> u8 {
        self.server.min_tsdr
    }

    /// Under a new address the station has no requesters and no connections. profibus-wire 1.9; chosen for MS2.
    fn set_address(&mut self, address: u8) {
        self.responder.set_address(address);
        self.server.close_connections();
    }
}

impl<D: Device, const CONNECTIONS: usize> Station for Slave<D, CONNECTIONS> {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        if !self.expected.lasts_at(end) {
            self.expected.clear();
        } else if let Some(du) = self.expected.outputs_in(telegram)
            && self.server.exchange_prepared(end, du)
        {
            self.expected.clear();
            return self.responder.release(end + u64::from(self.server.min_tsdr));
        } else if self.expected.is_touched_by(telegram) {
            self.expected.clear();
        }
        self.any_telegram(end, telegram)
    }

    /// The idle time after an answer: prepares the next one.
    fn sent(&mut self, _end: BitTime) {
        self.prepare();
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        if !self.expected.lasts_at(now) {
            self.expected.clear();
        }
        self.server.elapse(now);
        if self.expected.is_nothing() {
            self.prepare();
        }
        None
    }

    fn wake_at(&self) -> Option<BitTime> {
        self.server.wake_at()
    }

    fn listening(&self) -> Listening {
        Listening::Own(self.responder.address())
    }
}

impl<D: Device, const CONNECTIONS: usize> Slave<D, CONNECTIONS> {
    /// Processes any telegram. [`telegram`](Station::telegram) has a shorter way with the same result for the expected one.
    fn any_telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        let Self { responder, server, .. } = self;
        server.elapse(end);
        let Telegram::Data(data) = telegram else { return None };
        let not_before = end + u64::from(server.min_tsdr);
        let accepted = responder.accept(data);
        if !matches!(accepted, Accepted::Ignored) && data.da == responder.address() {
            server.restart_watchdog(data.sa);
        }
        let reply = match accepted {
            Accepted::Ignored => return None,
            Accepted::Unconfirmed(request) => {
                server.unconfirmed(&request);
                return None;
            }
            Accepted::Repetition => return responder.repeat(not_before),
            Accepted::LinkLayer(status) => Reply::Status(status),
            Accepted::Ident => server.ident(),
            Accepted::Confirmed(request) => server.serve(&request, responder),
        };
        responder.answer(data, reply, not_before)
    }

    /// Encodes the answer to the next Data_Exchange, if the device allows it.
    fn prepare(&mut self) {
        let Self { responder, server, expected } = self;
        expected.clear();
        let Some(Exchange { master, lengths }) = server.next_exchange() else { return };
        if let Some(fc) = responder.prepare(master, lengths.inputs, |du| server.next_inputs(du)) {
            let request = DataTelegram { da: responder.address(), sa: master, dsap: None, ssap: None, fc, du: &[] };
            *expected = Expected::new(&request, lengths.outputs, server.wake_at());
        }
    }
}
