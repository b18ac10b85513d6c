//! The parameters of a connection, and the properties that the slave grants.

use crate::link::Baud;
use crate::master::acyclic::Timeouts;
use profivac_wire::acyclic::initiate::{AddAddr, Capabilities, Initiate};

/// The unit of times in MS2 PDUs, in milliseconds. profibus-wire 4.6.3.
const UNIT_MS: u64 = 10;

/// The parameters of an MS2 connection. Times in the PDUs are in units of 10 ms, profibus-wire 4.6.3 and 4.9.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ms2Parameters {
    /// The rate of the segment, to convert times of the PDUs to bit times.
    pub baud: Baud,
    /// Send_Timeout, in 10 ms. The connection uses the greater of this and the slave's minimum. After that time without a
    /// request the master sends an Idle.
    pub send_timeout: u16,
    /// C2_Response_Timeout of the GSD file, in 10 ms: the longest wait for a response, unless Send_Timeout is greater.
    pub response_timeout: u16,
    /// The least time between two messages, in bit times. At least the Min_Slave_Interval of the slave.
    pub pace_tbit: u64,
    /// How often in a row the slave may answer RR or UE before the master gives the connection up.
    pub rejections: u8,
    /// The capabilities of this master, and its profile.
    pub capabilities: Capabilities,
    /// API and SCL of the application at the slave: 0 and 0 unless a profile says otherwise.
    pub destination: (u8, u8),
}

impl Ms2Parameters {
    /// Read and Write, no profile; 5 s for everything.
    ///
    /// chosen: Send_Timeout is longer than the 4 s that slaves require at the slow rates (profibus-wire 4.6.2), polls
    /// are a millisecond apart, and RR or UE are accepted ten times.
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

    /// T for the minimum Send_Timeout of a slave, in bit times.
    pub(super) fn timeout_tbit(&self, minimum: u16) -> u64 {
        self.tbit(self.send_timeout.max(minimum))
    }

    /// profibus-wire 4.9, rules 4 and 6.
    pub(super) fn timeouts(&self, timeout_tbit: u64) -> Timeouts {
        Timeouts {
            response_tbit: self.tbit(self.response_timeout).max(timeout_tbit),
            lost_tbit: timeout_tbit,
            pace_tbit: self.pace_tbit,
            rejections: self.rejections,
            resends: true,
        }
    }

    fn tbit(&self, time: u16) -> u64 {
        self.baud.tbit_of_ms(u64::from(time).saturating_mul(UNIT_MS))
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

/// The properties of an open connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Opened {
    /// The access point of the connection at the slave, 0 to 48.
    pub server_sap: u8,
    /// Max_Len_Data_Unit: the most octets of a record in one request, 1 to 240.
    pub max_len_data_unit: u8,
    /// The Send_Timeout of the connection, in 10 ms.
    pub send_timeout: u16,
    /// The capabilities of the slave.
    pub capabilities: Capabilities,
}
