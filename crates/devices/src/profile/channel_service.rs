//! The tasks of the parameter channel, executed with the same access to parameters that serves DP-V1.
//!
//! A write is executed once, when its request arrives with the outputs. A read is executed whenever the slave collects
//! its inputs, so that the answer has the value of that cycle: errata-bpg-bcg-tpg 25.
//! [`ParameterChannel`](parameter_channel::ParameterChannel) holds the request between the two.

use super::behaviour::Behaviour;
use super::device::BlockDevice;
use super::parameter_channel::{self, Task, WriteTask};
use crate::model::AccessPath;
use crate::store::Store;

impl<B: Behaviour, S: Store> BlockDevice<B, S> {
    /// Accepts the octets of the channel in the outputs and executes a write.
    pub(super) fn accept_channel_request(&mut self, octets: [u8; parameter_channel::OCTETS]) {
        let Some(write) = self.channel.accept(octets) else { return };
        let octets = self.octets_of(&write);
        let result = self.set(AccessPath::ParameterChannel, write.slot, write.index, octets);
        self.channel.set_result(result.map(|()| octets));
    }

    /// The octets of the channel for the inputs; executes a read.
    pub(super) fn channel_answer(&mut self) -> [u8; parameter_channel::OCTETS] {
        if let Some(Task::Read { slot, index }) = self.channel.task() {
            let octets = self.get(AccessPath::ParameterChannel, slot, index);
            self.channel.set_result(octets.as_deref().map_err(|error| *error));
        }
        *self.channel.answer()
    }

    /// The octets that a write means: as many as the parameter has, if the AK allows that length.
    pub(super) fn octets_of<'a>(&self, write: &'a WriteTask) -> &'a [u8] {
        let own = self.length(write.slot, write.index).filter(|own| write.lengths.contains(own));
        let length = own.or(write.lengths.first().copied()).unwrap_or_default();
        write.value.split_at_checked(write.value.len().saturating_sub(length)).map_or(&[], |(_, low)| low)
    }
}
