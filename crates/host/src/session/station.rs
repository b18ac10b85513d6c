//! The station of a session: a master behind a pointer.

use profivac_dp::link::active::{Active, CheckedBus};
use profivac_dp::link::{Baud, BitTime, Listening, Station, Transmit};
use profivac_dp::master::{Master, Settings, SlaveListError, SlaveParameters};
use profivac_wire::{MAX_DU, Telegram};

/// A master with room for every slave of a bus.
pub type BusMaster = Master<125, MAX_DU>;

/// Adds a slave to a master, or restarts it with new parameters if the master has it already.
///
/// # Errors
/// [`SlaveListError`] when the parameters are impossible.
pub fn add_or_restart(master: &mut BusMaster, parameters: &SlaveParameters<'_>) -> Result<(), SlaveListError> {
    if master.state(parameters.address).is_none() {
        return master.add(parameters);
    }
    master.reparameterise(parameters)?;
    master.restart(parameters.address);
    Ok(())
}

/// The station behind a pointer: it is too large for the stack of a thread.
pub(super) struct BoxedStation(pub(super) Box<Active<BusMaster>>);

impl BoxedStation {
    /// Keeps the station off the stack of the caller.
    #[inline(never)]
    pub(super) fn new(bus: CheckedBus, baud: Baud) -> Self {
        Self(Box::new(BusMaster::on(bus, Settings::new(baud), BitTime(0))))
    }
}

impl Station for BoxedStation {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        self.0.telegram(end, telegram)
    }

    fn activity(&mut self, end: BitTime) {
        self.0.activity(end);
    }

    fn sent(&mut self, end: BitTime) {
        self.0.sent(end);
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        self.0.poll(now)
    }

    fn wake_at(&self) -> Option<BitTime> {
        self.0.wake_at()
    }

    fn listening(&self) -> Listening {
        self.0.listening()
    }
}
