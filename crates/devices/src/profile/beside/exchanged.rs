//! The data that bus side and application copy to each other.

use crate::model::{AccessError, Configuration, MAX_COMMANDS, MAX_IMAGE, Octets, UserPrm};
use crate::profile::parameter_channel::WriteTask;
use profivac_dp::slave::Relation;

/// The changes of the outputs that are kept until the application takes them.
pub const MAX_CHANGES: usize = 4;

/// The outputs without the parameter channel; zeros after Clear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Commands {
    pub length: u8,
    pub octets: [u8; MAX_COMMANDS],
}

impl Commands {
    pub fn new(octets: &[u8]) -> Self {
        let mut copy = [0; MAX_COMMANDS];
        for (target, octet) in copy.iter_mut().zip(octets) {
            *target = *octet;
        }
        Self { length: u8::try_from(octets.len().min(MAX_COMMANDS)).unwrap_or_default(), octets: copy }
    }

    pub fn zeros(length: usize) -> Self {
        Self::new([0; MAX_COMMANDS].get(..length).unwrap_or(&[0; MAX_COMMANDS]))
    }

    pub fn as_slice(&self) -> &[u8] {
        self.octets.get(..usize::from(self.length)).unwrap_or_default()
    }
}

/// The source of an access, which gets its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Via {
    Relation(Relation),
    Channel,
    Address,
}

/// An access to a parameter.
#[derive(Clone, Copy, Debug)]
pub enum Access {
    Read {
        via: Relation,
        slot: u8,
        index: u8,
    },
    Write {
        via: Relation,
        slot: u8,
        index: u8,
        record: Record,
    },
    Channel(WriteTask),
    /// Stores the station address.
    Address {
        address: u8,
        locked: bool,
    },
}

/// The octets of the longest parameter that a master can write.
pub const MAX_WRITTEN: usize = 16;

/// The octets of a write. One that is longer than every parameter has only its length.
#[derive(Clone, Copy, Debug)]
pub struct Record {
    length: u8,
    octets: [u8; MAX_WRITTEN],
}

impl Record {
    pub fn new(record: &[u8]) -> Self {
        let mut octets = [0; MAX_WRITTEN];
        for (target, octet) in octets.iter_mut().zip(record) {
            *target = *octet;
        }
        Self { length: u8::try_from(record.len()).unwrap_or(u8::MAX), octets }
    }

    /// The octets; of a record that is too long one more than any parameter has.
    pub fn with<R>(&self, use_octets: impl FnOnce(&[u8]) -> R) -> R {
        match self.octets.get(..usize::from(self.length)) {
            Some(octets) => use_octets(octets),
            None => use_octets(&[0; MAX_WRITTEN.wrapping_add(1)]),
        }
    }
}

/// An access, its source and its number. A result is for the access of the same number only.
#[derive(Clone, Copy, Debug)]
pub struct Job {
    pub via: Via,
    pub number: u8,
    pub access: Access,
}

/// A parameter that the parameter channel reads in every cycle.
pub type ChannelRead = (u8, u8);

/// The requests of masters since the last copy, from the bus side to the application.
#[derive(Clone, Debug)]
pub struct Tasks {
    /// Counts the parameterisations. Inputs are valid for the present one only.
    pub(super) generation: u8,
    /// Data exchange has ended.
    pub(super) ended: bool,
    pub(super) user_prm: Option<&'static UserPrm>,
    pub(super) configuration: Option<&'static Configuration>,
    /// Data exchange has begun, after it had ended.
    pub(super) begun: bool,
    /// The outputs that have changed, oldest first.
    pub(super) changes: [Option<Commands>; MAX_CHANGES],
    /// The present outputs.
    pub(super) commands: Commands,
    pub(super) job: Option<Job>,
    pub(super) channel_read: Option<ChannelRead>,
}

/// The inputs and results since the last copy, from the application to the bus side.
#[derive(Clone, Debug)]
pub struct Snapshot {
    pub(super) generation: u8,
    pub(super) inputs: [u8; MAX_IMAGE],
    pub(super) channel_read: Option<(ChannelRead, Result<Octets, AccessError>)>,
    pub(super) done: Option<Done>,
    /// A factory reset has lifted No_Add_Chg.
    pub(super) unlocked: bool,
}

/// The result of a job: the octets of a read, or those that the parameter channel has written.
#[derive(Clone, Copy, Debug)]
pub struct Done {
    pub via: Via,
    pub number: u8,
    pub result: Result<Octets, AccessError>,
}
