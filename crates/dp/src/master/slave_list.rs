//! Changes to the list of slaves during operation: removing a slave, giving it other parameters.

use super::handler::{Change, Handler};
use super::parameters::{SlaveListError, SlaveParameters};
use super::state::HandlerState;
use super::{Master, Mode, NO_SLAVE, Pending};

impl<const SLAVES: usize, const OCTETS: usize, const EVENTS: usize, const ACYCLIC: usize>
    Master<SLAVES, OCTETS, EVENTS, ACYCLIC>
{
    /// Takes a slave out of the cycle, unlocks it if this master may own it, and removes it from the list. An event,
    /// [`HandlerState::Inactive`], reports the end. In [`Mode::Stop`] the slave is removed at once and not unlocked.
    ///
    /// Returns whether the list has such a slave.
    pub fn remove(&mut self, address: u8) -> bool {
        let Some(index) = self.index_of(address) else { return false };
        self.with_index(index, |slave, context| slave.remove(context));
        let inactive = self.slaves.get(index).is_some_and(|slave| slave.state() == HandlerState::Inactive);
        if inactive || self.mode == Mode::Stop {
            self.take_out(index);
        }
        true
    }

    /// Gives a slave other parameters. A slave that is being parameterised or exchanges data goes through Slave_Diag, Set_Prm
    /// and Chk_Cfg again, without effect on the others. It keeps its outputs if their number is the same.
    ///
    /// # Errors
    /// [`SlaveListError`] when the list has no such slave or the parameters are impossible; nothing has changed then.
    pub fn reparameterise(&mut self, parameters: &SlaveParameters<'_>) -> Result<(), SlaveListError> {
        let index = self.index_of(parameters.address).ok_or(SlaveListError::Unknown(parameters.address))?;
        let fresh = Handler::new(parameters)?;
        self.with_index(index, |slave, context| slave.replace_parameters(fresh, context));
        Ok(())
    }

    /// Assigns a slave to other groups, one per bit. A slave takes its groups from Set_Prm only, so this works like
    /// [`reparameterise`](Self::reparameterise).
    ///
    /// # Errors
    /// [`SlaveListError`] when the list has no such slave.
    pub fn set_group(&mut self, address: u8, group: u8) -> Result<(), SlaveListError> {
        let index = self.index_of(address).ok_or(SlaveListError::Unknown(address))?;
        self.with_index(index, |slave, context| slave.set_group(group, context));
        Ok(())
    }

    /// Reacts to a slave that was released or has left data exchange.
    #[cold]
    pub(super) fn changed(&mut self, index: usize, change: Change) {
        match change {
            Change::Nothing => {}
            Change::Released => self.take_out(index),
            Change::LeftExchange => {
                if self.settings.auto_clear && self.mode == Mode::Operate {
                    self.set_mode(Mode::Clear);
                    self.with_index(index, |slave, context| slave.auto_clear(context));
                }
            }
        }
    }

    /// The index of the slave with this address.
    pub(super) fn index_of(&self, address: u8) -> Option<usize> {
        self.index_by_address
            .get(usize::from(address))
            .filter(|index| **index != NO_SLAVE)
            .map(|index| usize::from(*index))
    }

    /// Removes a slave from the list. The slaves behind it move up, and all indices follow.
    fn take_out(&mut self, index: usize) {
        self.with_index(index, |slave, context| slave.enter(HandlerState::Inactive, context));
        if index >= self.slaves.len() {
            return;
        }
        let gone = self.slaves.remove(index);
        for (address, entry) in (0..).zip(&mut self.index_by_address) {
            if address == gone.address {
                *entry = NO_SLAVE;
            } else if *entry != NO_SLAVE && usize::from(*entry) > index {
                *entry = entry.saturating_sub(1);
            }
        }
        let moved = |other: usize| if other > index { other.saturating_sub(1) } else { other };
        self.next_in_list = self.next_in_list.map(moved);
        self.offline_from = moved(self.offline_from);
        self.pending = match self.pending {
            Pending::Slave(other, _) if other == index => Pending::Nothing,
            Pending::Slave(other, ask) => Pending::Slave(moved(other), ask),
            pending => pending,
        };
    }
}
