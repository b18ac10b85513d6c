//! The passive stations of a segment by address, each with the tap that it shares.

use profivac_wire::{BROADCAST, DataTelegram, Telegram};

/// A passive station at a shared tap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Listener {
    pub(crate) driver: usize,
    pub(crate) tap: usize,
}

/// The stations that share taps, by address from 0 to 127.
#[derive(Clone, Debug)]
pub(crate) struct Listeners([Vec<Listener>; 128]);

impl Default for Listeners {
    fn default() -> Self {
        Self([const { Vec::new() }; 128])
    }
}

impl Listeners {
    /// Adds a station with `address`.
    pub(crate) fn join(&mut self, listener: Listener, address: u8) {
        self.0[usize::from(address) % 128].push(listener);
    }

    /// Removes a station. Returns the tap that it shared; `None` if it has one of its own.
    pub(crate) fn leave(&mut self, driver: usize) -> Option<usize> {
        self.0.iter_mut().find_map(|listeners| {
            let index = listeners.iter().position(|listener| listener.driver == driver)?;
            Some(listeners.remove(index).tap)
        })
    }

    /// The stations that receive a telegram.
    pub(crate) fn of(&self, telegram: &Telegram<'_>) -> impl Iterator<Item = Listener> {
        let lists = match telegram {
            Telegram::Data(DataTelegram { da: BROADCAST, .. }) => &self.0[..],
            Telegram::Data(data) => std::slice::from_ref(&self.0[usize::from(data.da) % 128]),
            Telegram::ShortAck | Telegram::Token { .. } => &[],
        };
        lists.iter().flatten().copied()
    }
}
