//! What a connection is opened with, and what the slave says to it.

use crate::link::Baud;
use crate::master::acyclic::Timeouts;
use profivac_wire::acyclic::initiate::{AddAddr, Capabilities, Initiate};

/// How a connection is opened and supervised. Times on the wire count in 10 ms, profibus-wire 4.6.3 and 4.9.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ms2Parameters {
    /// The rate of the segment: times on the wire become bit times.
    pub baud: Baud,
    /// Send_Timeout, in 10 ms: the connection has the greater one of this and the slave's least. After so long without a
    /// request an Idle is sent.
    pub send_timeout: u16,
    /// C2_Response_Timeout of the GSD file, in 10 ms: a response comes no later, unless Send_Timeout is greater.
    pub response_timeout: u16,
    /// No message follows the one before sooner, in bit times. At least the Min_Slave_Interval of the slave.
    pub pace_tbit: u64,
    /// How often in a row the slave may answer RR or UE before the connection is given up.
    pub rejections: u8,
    /// What this master can do, and its profile.
    pub capabilities: Capabilities,
    /// API and SCL of the application at the slave: 0 and 0, except where a profile says otherwise.
    pub destination: (u8, u8),
}

impl Ms2Parameters {
    /// Read and Write, no profile; 5 s for everything.
    ///
    /// free choice: Send_Timeout is longer than the 4 s that slaves ask for at the slow rates (profibus-wire 4.6.2), polls
    /// are a millisecond apart, and RR or UE are taken ten times.
    #[must_use]
    pub const fn new(baud: Baud) -> Self {
        Self {
            baud,
            send_timeout: 500,
            response_timeout: 500,
            pace_tbit: baud.tbit_of_ms(1),
            rejections: 10,
            capabilities: Capabilities::READ_WRITE,
            destination: (0, 0),
        }
    }

    /// T for this least Send_Timeout of a slave, in bit times.
    pub(super) fn timeout_tbit(&self, least: u16) -> u64 {
        self.baud.tbit_of_ms(u64::from(self.send_timeout.max(least)).saturating_mul(10))
    }

    /// profibus-wire 4.9, rules 4 and 6.
    pub(super) fn timeouts(&self, timeout_tbit: u64) -> Timeouts {
        let response_tbit = self.baud.tbit_of_ms(u64::from(self.response_timeout).saturating_mul(10));
        Timeouts {
            response_tbit: response_tbit.max(timeout_tbit),
            lost_tbit: timeout_tbit,
            pace_tbit: self.pace_tbit,
            rejections: self.rejections,
        }
    }

    pub(super) fn initiate(&self) -> Initiate<'static> {
        let (api, scl) = self.destination;
        Initiate {
            send_timeout: self.send_timeout,
            capabilities: self.capabilities,
            source: AddAddr::default(),
            destination: AddAddr { api, scl, network: None },
        }
    }
}

/// What is known of a connection when it is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Opened {
    /// The access point of the connection at the slave, 0 to 48.
    pub server_sap: u8,
    /// Max_Len_Data_Unit: how many octets of a record one request carries, 1 to 240.
    pub max_len_data_unit: u8,
    /// The Send_Timeout of the connection, in 10 ms.
    pub send_timeout: u16,
    /// What the slave can do.
    pub capabilities: Capabilities,
}
