//! Zeros as the outputs of a slave that is no known gauge: what they are, and what they risk.

use crate::output::visible;
use profivac_client::values::hex;
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::Model;
use profivac_gsd_slave::{GsdSlave, ModuleData};
use profivac_wire::cfg;
use std::fmt;

/// The risk of zeros. A gauge has relays and a parameter channel as outputs; another slave can have anything.
pub const RISK: &str = "zeros can stop a pump or close a valve";

/// Whether a slave with this Ident_Number is a known gauge, which may get zeros. No device whose file names outputs is one.
pub fn is_gauge(devices: KnownDevices, ident: u16) -> bool {
    devices.knows(ident) && !devices.with_ident(ident).any(names_outputs)
}

/// Whether the file of a device names outputs.
pub fn names_outputs(model: &Model) -> bool {
    model.values.iter().any(|value| value.is_output)
}

/// The outputs of a slave, all zero.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Zeros {
    address: u8,
    length: usize,
    /// The outputs by module, if a GSD file names them.
    modules: Vec<String>,
}

impl Zeros {
    /// Those of a slave by its GSD file; `None` without outputs.
    pub fn of_slave(address: u8, slave: &GsdSlave) -> Option<Self> {
        let length = usize::from(slave.lengths().outputs);
        let zeros = vec![0; length];
        let of = |data: ModuleData<'_>| data.of(&zeros).map(|octets| format!("{}: {}", data.name(), hex(octets)));
        let modules = slave.layout().outputs().filter_map(of).map(|module| visible(&module)).collect();
        (length > 0).then_some(Self { address, length, modules })
    }

    /// Those that a configuration counts; `None` without outputs.
    pub fn of_cfg(address: u8, cfg: &[u8]) -> Option<Self> {
        let length = cfg::lengths(cfg).map_or(0, |lengths| usize::from(lengths.outputs));
        (length > 0).then_some(Self { address, length, modules: Vec::new() })
    }

    /// The octets.
    pub fn octets(&self) -> Vec<u8> {
        vec![0; self.length]
    }

    /// ` (slot 2 4DO: 00, slot 3 2AO: 00 00 00 00)`; empty if no GSD file names the modules.
    pub fn listed(&self) -> String {
        if self.modules.is_empty() { String::new() } else { format!(" ({})", self.modules.join(", ")) }
    }
}

/// The risk, as a question begins with it.
impl fmt::Display for Zeros {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { address, length, .. } = self;
        match self.listed().as_str() {
            "" => write!(f, "the slave at address {address} gets {length} octets of outputs, all zero; {RISK}"),
            listed => write!(f, "the slave at address {address} gets these outputs{listed}; {RISK}"),
        }
    }
}
