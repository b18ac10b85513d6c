//! A fixed number of slots, each of which holds one request or connection.

use super::handle::Key;

/// A request or connection that a pool holds.
pub(in crate::master) trait Pooled {
    /// Whether nothing more happens to it. The pool may replace it then.
    fn is_over(&self) -> bool;

    /// Whether it is over and its outcome was taken.
    fn is_taken(&self) -> bool {
        false
    }
}

/// Up to `SLOTS` of `T`.
#[derive(Clone, Debug)]
pub(in crate::master) struct Pool<T, const SLOTS: usize> {
    slots: [Slot<T>; SLOTS],
    /// No slot from this number on has ever had content.
    used: usize,
}

#[derive(Clone, Debug)]
struct Slot<T> {
    serial: u32,
    content: Option<T>,
}

impl<T: Pooled, const SLOTS: usize> Pool<T, SLOTS> {
    pub(in crate::master) const fn new() -> Self {
        const { assert!(SLOTS <= 256, "a key numbers the slots in one octet") }
        Self { slots: [const { Slot { serial: 0, content: None } }; SLOTS], used: 0 }
    }

    /// Puts `content` into a free slot, or else replaces one that is over and whose outcome was not taken.
    pub(in crate::master) fn insert(&mut self, content: T) -> Option<Key> {
        let free = self.slots.iter().position(|slot| slot.content.as_ref().is_none_or(Pooled::is_taken));
        let over = || self.slots.iter().position(|slot| slot.content.as_ref().is_some_and(Pooled::is_over));
        let number = free.or_else(over)?;
        let slot = self.slots.get_mut(number)?;
        slot.serial = slot.serial.wrapping_add(1);
        slot.content = Some(content);
        self.used = self.used.max(number.saturating_add(1));
        Some(Key { slot: u8::try_from(number).ok()?, serial: slot.serial })
    }

    /// The number of slots, from the first, that may have content.
    pub(in crate::master) const fn used(&self) -> usize {
        self.used
    }

    pub(in crate::master) fn at(&mut self, number: usize) -> Option<&mut T> {
        self.slots.get_mut(number)?.content.as_mut()
    }

    /// The content of a slot with its key.
    pub(in crate::master) fn entry(&mut self, number: usize) -> Option<(Key, &mut T)> {
        let slot = self.slots.get_mut(number)?;
        Some((Key { slot: u8::try_from(number).ok()?, serial: slot.serial }, slot.content.as_mut()?))
    }

    /// The contents with their keys, slot by slot.
    pub(in crate::master) fn entries(&mut self) -> impl Iterator<Item = (Key, &mut T)> {
        let used = self.slots.get_mut(..self.used).unwrap_or_default();
        (0..=u8::MAX).zip(used).filter_map(|(number, slot)| {
            let key = Key { slot: number, serial: slot.serial };
            Some((key, slot.content.as_mut()?))
        })
    }

    pub(in crate::master) fn get(&self, key: Key) -> Option<&T> {
        let slot = self.slots.get(usize::from(key.slot))?;
        slot.content.as_ref().filter(|_| key.serial == slot.serial)
    }

    pub(in crate::master) fn get_mut(&mut self, key: Key) -> Option<&mut T> {
        let slot = self.slots.get_mut(usize::from(key.slot))?;
        slot.content.as_mut().filter(|_| key.serial == slot.serial)
    }

    /// Frees a slot.
    pub(in crate::master) fn remove(&mut self, key: Key) {
        if let Some(slot) = self.slots.get_mut(usize::from(key.slot))
            && slot.serial == key.serial
        {
            slot.content = None;
        }
    }

    pub(in crate::master) fn iter(&self) -> impl Iterator<Item = &T> {
        self.slots.iter().filter_map(|slot| slot.content.as_ref())
    }

    pub(in crate::master) fn iter_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.slots.iter_mut().filter_map(|slot| slot.content.as_mut())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Pooled for u16 {
        fn is_over(&self) -> bool {
            false
        }
    }

    #[test]
    fn a_full_pool_has_an_entry_for_each_slot_and_one_that_was_freed_is_used_again() {
        let mut pool = Pool::<u16, 256>::new();
        assert_eq!((pool.used(), pool.entries().count()), (0, 0));
        let keys: heapless::Vec<_, 256> = (0..256).filter_map(|content| pool.insert(content)).collect();
        assert_eq!((keys.len(), pool.used(), pool.insert(256)), (256, 256, None));
        assert!(
            pool.entries()
                .zip(0..=u8::MAX)
                .all(|((key, content), number)| (key.slot, *content) == (number, number.into()))
        );
        let middle = keys[100];
        pool.remove(middle);
        assert_eq!((pool.entries().count(), pool.entry(100)), (255, None));
        assert_eq!(pool.get(middle), None);
        let again = pool.insert(1000).unwrap();
        assert_eq!((again.slot, pool.used(), pool.get(again), pool.get(middle)), (100, 256, Some(&1000), None));
    }
}
