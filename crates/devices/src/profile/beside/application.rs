//! The measurement, the parameters and the nonvolatile memory of a device beside its slave.

use super::exchanged::{Access, ChannelRead, Commands, Done, Job, Snapshot, Tasks};
use crate::model::{AccessError, AccessPath, MAX_IMAGE, Octets};
use crate::profile::device::path_of;
use crate::profile::{Behaviour, BlockDevice};
use crate::store::Store;
use profivac_dp::slave::{Device, Outputs};

/// A device with its measurement, parameters and memory. No answer on the bus waits for it.
#[derive(Debug)]
pub struct Application<'a, B, S> {
    device: &'a mut BlockDevice<B, S>,
    generation: u8,
    done: Option<Done>,
    channel_read: Option<ChannelRead>,
    /// No_Add_Chg was set before the last job, and is not any more.
    unlocked: bool,
}

impl<'a, B: Behaviour, S: Store> Application<'a, B, S> {
    /// The application of this device.
    pub const fn new(device: &'a mut BlockDevice<B, S>) -> Self {
        Self { device, generation: 0, done: None, channel_read: None, unlocked: false }
    }

    /// The device.
    pub const fn device(&self) -> &BlockDevice<B, S> {
        self.device
    }

    /// The device, to change its pressures, faults and time.
    pub const fn device_mut(&mut self) -> &mut BlockDevice<B, S> {
        self.device
    }

    /// Does what masters have requested, with at most one access to a parameter. Returns when its values are durable.
    pub fn adopt(&mut self, tasks: &Tasks) {
        self.generation = tasks.generation;
        self.channel_read = tasks.channel_read;
        if tasks.ended {
            self.device.set_exchanging(false);
        }
        if let Some(prm) = tasks.user_prm {
            self.device.apply_event(&mut |behaviour| behaviour.apply_user_prm(prm));
        }
        if let Some(configuration) = tasks.configuration {
            self.device.adopt_configuration(configuration);
        }
        if tasks.begun {
            self.device.set_exchanging(true);
        }
        tasks.changes.iter().flatten().for_each(|commands| self.command(commands));
        self.command(&tasks.commands);
        let was_locked = self.device.address.is_locked();
        self.done = tasks.job.as_ref().map(|job| self.execute(job));
        self.unlocked = was_locked && !self.device.address.is_locked();
    }

    /// The inputs and results of the device at this moment. The result of an access is in the first snapshot after it.
    pub fn snapshot(&mut self) -> Snapshot {
        let mut inputs = [0; MAX_IMAGE];
        if let Some(image) = inputs.get_mut(..self.device.configuration.input_octets()) {
            self.device.inputs(image);
        }
        let read = |(slot, index)| ((slot, index), self.device.get(AccessPath::ParameterChannel, slot, index));
        Snapshot {
            generation: self.generation,
            inputs,
            channel_read: self.channel_read.map(read),
            done: self.done.take(),
            unlocked: core::mem::take(&mut self.unlocked),
        }
    }

    /// The outputs without the parameter channel, whose octets are zeros here.
    fn command(&mut self, commands: &Commands) {
        let mut image = [0; MAX_IMAGE];
        let fields = self.device.configuration.outputs.map_or(0, |telegram| telegram.octets());
        let rest = commands.as_slice();
        let Some(start) = fields.checked_sub(rest.len()) else { return };
        if let Some(target) = image.get_mut(start..fields) {
            target.copy_from_slice(rest);
        }
        self.device.outputs(Outputs::Data(image.get(..fields).unwrap_or_default()));
    }

    fn execute(&mut self, job: &Job) -> Done {
        let result = match &job.access {
            Access::Read { via, slot, index } => self.device.get(path_of(*via), *slot, *index),
            Access::Write { via, slot, index, record } => {
                record.with(|octets| self.device.set(path_of(*via), *slot, *index, octets)).map(|()| Octets::EMPTY)
            }
            Access::Channel(write) => {
                let octets = self.device.octets_of(write);
                let written = self.device.set(AccessPath::ParameterChannel, write.slot, write.index, octets);
                written.map(|()| Octets::new(octets))
            }
            Access::Address { address, locked } => self.device.put_address(*address, *locked),
        };
        Done { via: job.via, number: job.number, result }
    }
}

impl<B: Behaviour, S: Store> BlockDevice<B, S> {
    /// A memory that fails leaves the address valid until the next power-up.
    fn put_address(&mut self, address: u8, locked: bool) -> Result<Octets, AccessError> {
        let stored = self.address.put(&mut self.store, address, locked);
        stored.map(|()| Octets::EMPTY).map_err(|_| AccessError::StorageFailed)
    }
}
