//! Changing the list of slaves while the others go on: taking one out, giving one other parameters.

use super::handler::{Change, Handler};
use super::parameters::{SlaveListError, SlaveParameters};
use super::state::HandlerState;
use super::{Master, Mode, NO_SLAVE, Pending};

impl<const SLAVES: usize, const OCTETS: usize, const EVENTS: usize, const ACYCLIC: usize>
    Master<SLAVES, OCTETS, EVENTS, ACYCLIC>
{
    /// Takes a slave out of the cycle, unlocks it if it may be ours, and forgets it: there is room for another then. The
    /// end is told by an event, [`State::Inactive`]. In [`Mode::Stop`] it is forgotten at once, and not unlocked.
    ///
    /// Whether there is such a slave.
    pub fn remove(&mut self, address: u8) -> bool {
        let Some(place) = self.index_of(address) else { return false };
        self.with_place(place, |slave, context| slave.remove(context));
        let inactive = self.slaves.get(place).is_some_and(|slave| slave.state() == HandlerState::Inactive);
        if inactive || self.mode == Mode::Stop {
            self.take_out(place);
        }
        true
    }

    /// Gives a slave other parameters. If it is being parameterised or exchanges data it is taken through Slave_Diag,
    /// Set_Prm and Chk_Cfg again; the others notice nothing. Its outputs stay if there are as many as before.
    ///
    /// # Errors
    /// [`Rejected`] when there is no such slave or the parameters are impossible; then everything stays as it was.
    pub fn reparameterise(&mut self, parameters: &SlaveParameters<'_>) -> Result<(), SlaveListError> {
        let place = self.index_of(parameters.address).ok_or(SlaveListError::Unknown(parameters.address))?;
        let fresh = Handler::new(parameters)?;
        self.with_place(place, |slave, context| slave.replace_parameters(fresh, context));
        Ok(())
    }

    /// Puts a slave into other groups, one per bit. A slave takes its groups from Set_Prm only, so this is as
    /// [`reparameterise`](Self::reparameterise).
    ///
    /// # Errors
    /// [`Rejected`] when there is no such slave.
    pub fn set_group(&mut self, address: u8, group: u8) -> Result<(), SlaveListError> {
        let place = self.index_of(address).ok_or(SlaveListError::Unknown(address))?;
        self.with_place(place, |slave, context| slave.set_group(group, context));
        Ok(())
    }

    /// What the master does when a slave has been given back, or has fallen out of data exchange.
    #[cold]
    pub(super) fn changed(&mut self, place: usize, change: Change) {
        match change {
            Change::Nothing => {}
            Change::Released => self.take_out(place),
            Change::LeftExchange => {
                if self.settings.auto_clear && self.mode == Mode::Operate {
                    self.set_mode(Mode::Clear);
                    self.with_place(place, |slave, context| slave.auto_clear(context));
                }
            }
        }
    }

    /// Where the slave with this address is.
    pub(super) fn index_of(&self, address: u8) -> Option<usize> {
        self.index_by_address
            .get(usize::from(address))
            .filter(|place| **place != NO_SLAVE)
            .map(|place| usize::from(*place))
    }

    /// The slaves behind move up; whoever counts places counts on.
    fn take_out(&mut self, place: usize) {
        self.with_place(place, |slave, context| slave.enter(HandlerState::Inactive, context));
        if place >= self.slaves.len() {
            return;
        }
        let gone = self.slaves.remove(place);
        for (address, entry) in (0..).zip(&mut self.index_by_address) {
            if address == gone.address {
                *entry = NO_SLAVE;
            } else if *entry != NO_SLAVE && usize::from(*entry) > place {
                *entry = entry.saturating_sub(1);
            }
        }
        let moved = |other: usize| if other > place { other.saturating_sub(1) } else { other };
        self.next_in_list = self.next_in_list.map(moved);
        self.offline_from = moved(self.offline_from);
        self.pending = match self.pending {
            Pending::Slave(other, _) if other == place => Pending::Nothing,
            Pending::Slave(other, ask) => Pending::Slave(moved(other), ask),
            pending => pending,
        };
    }
}
