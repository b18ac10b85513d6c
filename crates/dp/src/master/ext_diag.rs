//! The extended diagnosis of a slave, entry by entry. profibus-wire 2.3.1 and 2.3.2.

use super::Master;
use core::fmt;
use profivac_wire::ext_diag::{Block, Blocks, Message};

/// One entry of the extended diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ExtDiagEntry<'a> {
    /// A device-related block of a DP-V1 slave: an alarm or a status.
    Message(Message<'a>),
    /// Any other block: identifier-related, channel-related, a revision, or one that only the manual of the device explains.
    Block(Block<'a>),
    /// The rest is no block: its length is 0 or exceeds the data. This is the last entry.
    Malformed,
}

impl fmt::Display for ExtDiagEntry<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Message(message) => message.fmt(f),
            Self::Block(block) => block.fmt(f),
            Self::Malformed => f.write_str("the rest is no block"),
        }
    }
}

/// An iterator over the entries of an extended diagnosis.
#[derive(Clone, Debug)]
pub struct ExtDiag<'a> {
    blocks: Blocks<'a>,
    dpv1: bool,
}

impl<'a> ExtDiag<'a> {
    /// Begins with the first block of `octets`. `dpv1` gives the meaning of device-related blocks: it is DPV1_Slave of the
    /// GSD file and not the mode of the slave's parameters.
    #[must_use]
    pub const fn new(octets: &'a [u8], dpv1: bool) -> Self {
        Self { blocks: Blocks::new(octets), dpv1 }
    }
}

impl<'a> Iterator for ExtDiag<'a> {
    type Item = ExtDiagEntry<'a>;

    fn next(&mut self) -> Option<Self::Item> {
        Some(match self.blocks.next()? {
            Ok(Block::Device(content)) if self.dpv1 => {
                Message::parse(content).map_or(ExtDiagEntry::Block(Block::Device(content)), ExtDiagEntry::Message)
            }
            Ok(block) => ExtDiagEntry::Block(block),
            Err(_) => ExtDiagEntry::Malformed,
        })
    }
}

impl<const SLAVES: usize, const OCTETS: usize, const EVENTS: usize, const ACYCLIC: usize>
    Master<SLAVES, OCTETS, EVENTS, ACYCLIC>
{
    /// The entries of the last extended diagnosis of a slave; none for an unknown slave.
    pub fn ext_diag(&self, address: u8) -> ExtDiag<'_> {
        let slave = self.slave(address);
        let octets = slave.and_then(|slave| slave.diagnosis()).map(|diag| diag.ext_diag);
        ExtDiag::new(octets.unwrap_or_default(), slave.is_some_and(|slave| slave.dpv1))
    }
}
