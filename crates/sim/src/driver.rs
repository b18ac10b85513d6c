//! What stands between a station and the cable: its transmit queue, its transceiver, its power.

use crate::scheduler::NEVER;
use crate::signal::TelegramFault;
use profivac_dp::link::{BitTime, Listening, Station, Transmit};
use profivac_wire::Telegram;
use std::any::Any;
use std::collections::VecDeque;
use std::sync::Arc;

/// A station whose type is known again to whoever attached it.
pub(crate) trait Attached: Station + Send {
    fn as_any(&self) -> &dyn Any;
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

impl<S: Station + Send + 'static> Attached for S {
    fn as_any(&self) -> &dyn Any {
        self
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}

/// What a driver does when its time has come.
pub(crate) enum DriverAction {
    /// It begins to send.
    Send(Arc<[u8]>),
    /// Nothing that others notice.
    Nothing,
}

/// Drives one station.
pub(crate) struct Driver {
    pub(crate) station: Box<dyn Attached>,
    pub(crate) position: u64,
    /// The address a passive station listens to.
    pub(crate) address: Option<u8>,
    /// What waits to be sent, and from when on it may be.
    queue: VecDeque<(BitTime, Arc<[u8]>)>,
    sending: bool,
    /// The end of the telegram that is being sent or was sent last.
    pub(crate) sends_until: BitTime,
    powered: bool,
    /// It was polled at all times before this.
    polled: BitTime,
    /// What happens to the next telegram.
    pub(crate) telegram_faults: Vec<TelegramFault>,
}

impl Driver {
    pub(crate) fn new(station: Box<dyn Attached>, position: u64) -> Self {
        Self {
            address: own_address(&*station),
            station,
            position,
            queue: VecDeque::new(),
            sending: false,
            sends_until: BitTime(0),
            powered: true,
            polled: BitTime(0),
            telegram_faults: Vec::new(),
        }
    }

    /// When it has something to do.
    pub(crate) fn next(&self) -> BitTime {
        if !self.powered {
            return NEVER;
        }
        // A station that keeps asking for the present is called once a bit time, so that time goes on.
        let wake = self.station.wake_at().map_or(NEVER, |wake| wake.max(self.polled));
        let transmit = match self.queue.front() {
            _ if self.sending => self.sends_until,
            Some((not_before, _)) => *not_before,
            None => NEVER,
        };
        wake.min(transmit)
    }

    /// Its time has come: a telegram has left, the next may begin, or the station is called.
    pub(crate) fn run(&mut self, now: BitTime) -> DriverAction {
        if self.sending && self.sends_until <= now {
            self.sending = false;
            self.station.sent(self.sends_until);
            return DriverAction::Nothing;
        }
        if !self.sending
            && let Some((_, octets)) = self.queue.pop_front_if(|(not_before, _)| *not_before <= now)
        {
            return DriverAction::Send(octets);
        }
        self.polled = now + 1;
        let Self { station, queue, .. } = self;
        enqueue(queue, station.poll(now));
        DriverAction::Nothing
    }

    /// It is sending until `end`.
    pub(crate) const fn begin_sending(&mut self, end: BitTime) {
        self.sending = true;
        self.sends_until = end;
    }

    /// Hands over a telegram, unless the station was sending itself. Returns the address it listens to no longer.
    pub(crate) fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<u8> {
        if !self.powered || self.sending && end <= self.sends_until {
            return None;
        }
        let Self { station, queue, .. } = self;
        enqueue(queue, station.telegram(end, telegram));
        self.changed_address()
    }

    /// The address the station listens to no longer.
    pub(crate) fn changed_address(&mut self) -> Option<u8> {
        let before = std::mem::replace(&mut self.address, own_address(&*self.station));
        before.filter(|_| before != self.address)
    }

    pub(crate) fn activity(&mut self, end: BitTime) {
        if self.powered {
            self.station.activity(end);
        }
    }

    /// Without power nothing is sent, not even the rest of a telegram.
    pub(crate) fn set_power(&mut self, on: bool) {
        self.powered = on;
        self.queue.clear();
        self.sending = false;
    }
}

fn own_address(station: &dyn Attached) -> Option<u8> {
    match station.listening() {
        Listening::Own(address) => Some(address),
        Listening::Everything => None,
    }
}

fn enqueue(queue: &mut VecDeque<(BitTime, Arc<[u8]>)>, transmit: Option<Transmit<'_>>) {
    queue.extend(transmit.map(|transmit| (transmit.not_before, Arc::from(transmit.octets))));
}
