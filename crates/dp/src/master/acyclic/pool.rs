//! A fixed number of places, and handles that say who holds which.

use core::fmt;

/// Which service a handle belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Service {
    /// Class 1: one Read or Write of a slave in data exchange.
    Ms1,
    /// Class 2: one connection.
    Ms2,
    /// The parameter channel: one instruction.
    Pkw,
}

impl fmt::Display for Service {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ms1 => "MS1",
            Self::Ms2 => "MS2",
            Self::Pkw => "parameter channel",
        })
    }
}

/// What an acyclic request or connection is called by. A handle that was used up never means another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Handle {
    service: u8,
    place: u8,
    serial: u32,
}

impl Handle {
    /// The service it belongs to.
    #[must_use]
    pub const fn service(self) -> Service {
        match self.service {
            1 => Service::Ms1,
            2 => Service::Ms2,
            _ => Service::Pkw,
        }
    }
}

/// What a place can hold.
pub(in crate::master) trait Pooled {
    /// The service of its handles.
    const SERVICE: u8;

    /// Nothing will happen to it any more: a new one may take its place.
    fn is_over(&self) -> bool;

    /// It is over, and its outcome was taken.
    fn is_taken(&self) -> bool {
        false
    }
}

/// Up to `PLACES` of `T`.
#[derive(Clone, Debug)]
pub(in crate::master) struct Pool<T, const PLACES: usize> {
    slots: [Slot<T>; PLACES],
}

#[derive(Clone, Debug)]
struct Slot<T> {
    serial: u32,
    held: Option<T>,
}

impl<T: Pooled, const PLACES: usize> Pool<T, PLACES> {
    pub(in crate::master) const fn new() -> Self {
        Self { slots: [const { Slot { serial: 0, held: None } }; PLACES] }
    }

    /// Puts `held` where nothing is, or where what is there is over and nobody has asked for its outcome.
    pub(in crate::master) fn insert(&mut self, held: T) -> Option<Handle> {
        let free = self.slots.iter().position(|place| place.held.as_ref().is_none_or(Pooled::is_taken));
        let over = || self.slots.iter().position(|place| place.held.as_ref().is_some_and(Pooled::is_over));
        let number = free.or_else(over)?;
        let place = self.slots.get_mut(number)?;
        place.serial = place.serial.wrapping_add(1);
        place.held = Some(held);
        Some(Handle { service: T::SERVICE, place: u8::try_from(number).ok()?, serial: place.serial })
    }

    /// The handle of what a place holds.
    pub(in crate::master) fn handle(&self, number: usize) -> Option<Handle> {
        let place = self.slots.get(number).filter(|place| place.held.is_some())?;
        Some(Handle { service: T::SERVICE, place: u8::try_from(number).ok()?, serial: place.serial })
    }

    pub(in crate::master) fn at(&mut self, number: usize) -> Option<&mut T> {
        self.slots.get_mut(number)?.held.as_mut()
    }

    pub(in crate::master) fn get(&self, handle: Handle) -> Option<&T> {
        let place = self.slots.get(usize::from(handle.place))?;
        place.held.as_ref().filter(|_| handle.service == T::SERVICE && handle.serial == place.serial)
    }

    pub(in crate::master) fn get_mut(&mut self, handle: Handle) -> Option<&mut T> {
        let place = self.slots.get_mut(usize::from(handle.place))?;
        place.held.as_mut().filter(|_| handle.service == T::SERVICE && handle.serial == place.serial)
    }

    /// Frees a place.
    pub(in crate::master) fn remove(&mut self, handle: Handle) {
        if self.get(handle).is_some()
            && let Some(place) = self.slots.get_mut(usize::from(handle.place))
        {
            place.held = None;
        }
    }

    pub(in crate::master) fn iter(&self) -> impl Iterator<Item = &T> {
        self.slots.iter().filter_map(|place| place.held.as_ref())
    }

    pub(in crate::master) fn iter_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.slots.iter_mut().filter_map(|place| place.held.as_mut())
    }
}
