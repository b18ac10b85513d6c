//! The connection of a station to the cable: transmit queue, transceiver, power.

use crate::scheduler::NEVER;
use crate::signal::TelegramFault;
use profivac_dp::link::{BitTime, Listening, Station, Transmit};
use profivac_wire::Telegram;
use std::any::Any;
use std::collections::VecDeque;
use std::sync::Arc;

/// A station that can be downcast to its type.
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

/// The action of a driver at its time.
pub(crate) enum DriverAction {
    /// The station begins to send.
    Send(Arc<[u8]>),
    /// Nothing is sent.
    Nothing,
}

/// Connects one station.
pub(crate) struct Driver {
    pub(crate) station: Box<dyn Attached>,
    pub(crate) position: u64,
    /// The address of a passive station; `None` if the station receives everything.
    pub(crate) address: Option<u8>,
    /// Telegrams to send, each with its earliest time.
    queue: VecDeque<(BitTime, Arc<[u8]>)>,
    sending: bool,
    /// The end of the present or last transmission.
    pub(crate) sends_until: BitTime,
    powered: bool,
    /// The station was polled at all times before this.
    polled: BitTime,
    /// The faults of the next telegram.
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

    /// The time of the next action.
    pub(crate) fn next(&self) -> BitTime {
        if !self.powered {
            return NEVER;
        }
        // A station with a wake time in the past is called once per bit time, so time advances.
        let wake = self.station.wake_at().map_or(NEVER, |wake| wake.max(self.polled));
        let transmit = match self.queue.front() {
            _ if self.sending => self.sends_until,
            Some((not_before, _)) => *not_before,
            None => NEVER,
        };
        wake.min(transmit)
    }

    /// Runs the action at `now`: ends a transmission, begins the next one, or polls the station.
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

    /// Marks the station as sending until `end`.
    pub(crate) const fn begin_sending(&mut self, end: BitTime) {
        self.sending = true;
        self.sends_until = end;
    }

    /// Passes a telegram to the station, unless it was sending. Returns whether its address has changed.
    pub(crate) fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> bool {
        if !self.powered || self.sending && end <= self.sends_until {
            return false;
        }
        let Self { station, queue, .. } = self;
        enqueue(queue, station.telegram(end, telegram));
        self.changed_address()
    }

    /// Reads the address of the station. Returns whether it has changed.
    pub(crate) fn changed_address(&mut self) -> bool {
        let before = std::mem::replace(&mut self.address, own_address(&*self.station));
        before.is_some() && before != self.address
    }

    pub(crate) fn activity(&mut self, end: BitTime) {
        if self.powered {
            self.station.activity(end);
        }
    }

    /// Switches the power. Without power nothing is sent, including the rest of a telegram.
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
