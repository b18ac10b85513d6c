//! Power cuts at every operation, whole and torn.

#![allow(clippy::arithmetic_side_effects, clippy::indexing_slicing, clippy::unwrap_used, reason = "tests")]

extern crate std;

use super::*;
use std::vec::Vec;

const PAGE: usize = 128;

/// The effect of the operation in which the power fails.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cut {
    /// Nothing.
    Before,
    /// Some of its bits, or the first half of a page.
    Within(u32),
    /// All of it.
    After,
}

/// Two pages of 128 octets, whose power fails at one operation.
#[derive(Clone, Debug)]
struct Ram {
    words: [[u32; PAGE / WORD]; 2],
    operations: u32,
    cut: Option<(u32, Cut)>,
    /// A bit that stays 1, by the place of its word.
    worn: Option<(usize, usize, u32)>,
}

impl Ram {
    const fn new() -> Self {
        // As a page that was used for something else.
        Self { words: [[0x1234_5678; PAGE / WORD]; 2], operations: 0, cut: None, worn: None }
    }

    /// What this operation does: its mask of bits, `None` for nothing.
    fn operate(&mut self) -> Option<u32> {
        self.operations += 1;
        match self.cut {
            Some((at, _)) if self.operations > at => None,
            Some((at, cut)) if self.operations == at => match cut {
                Cut::Before => None,
                Cut::Within(mask) => Some(mask),
                Cut::After => Some(u32::MAX),
            },
            _ => Some(u32::MAX),
        }
    }
}

impl Pages for Ram {
    const OCTETS: usize = PAGE;

    fn word(&self, page: usize, offset: usize) -> u32 {
        self.words[page][offset / WORD]
    }

    fn program(&mut self, page: usize, offset: usize, word: u32) {
        if let Some(mask) = self.operate() {
            let position = &mut self.words[page][offset / WORD];
            assert!(self.cut.is_some() || *position == ERASED, "a word is programmed once");
            *position &= word | !mask;
            if let Some((worn_page, worn_offset, bit)) = self.worn
                && (worn_page, worn_offset) == (page, offset)
            {
                *position |= bit;
            }
        }
    }

    fn erase(&mut self, page: usize) {
        if let Some(mask) = self.operate() {
            for (number, word) in self.words[page].iter_mut().enumerate() {
                *word |= if mask == u32::MAX || mask.rotate_right(number as u32) & 1 == 1 { ERASED } else { mask };
            }
        }
    }
}

const KEYS: [Key; 4] =
    [Key::Address, Key::Internal(0), Key::Parameter { slot: 1, instance: 2, index: 39 }, Key::Internal(7)];

type Values = Vec<Option<Vec<u8>>>;

fn values(store: &FlashStore<Ram>) -> Values {
    KEYS.iter()
        .map(|key| {
            let mut octets = [0; MAX_STORED];
            store.load(*key, &mut octets).map(|length| octets[..length].to_vec())
        })
        .collect()
}

/// The save of this number: one to three values, of 0 to 16 octets.
fn save(number: u8) -> Vec<(Key, Octets)> {
    let count = usize::from(number % 3) + 1;
    let first = usize::from(number / 2);
    (0..count).map(|at| (KEYS[(first + at) % 4], Octets::new(&[number; 16][..usize::from(number) * 5 % 17]))).collect()
}

#[test]
fn saves_outlive_the_store_and_any_number_of_page_changes() {
    let mut store = FlashStore::new(Ram::new());
    let mut wanted: Values = std::vec![None; 4];
    for number in 0..200 {
        for (key, octets) in save(number) {
            wanted[KEYS.iter().position(|it| *it == key).unwrap()] = Some(octets.to_vec());
        }
        assert_eq!(store.save_all(&mut save(number).into_iter()), Ok(()), "{number}");
        assert_eq!(values(&store), wanted, "{number}");
        store = FlashStore::new(store.pages().clone());
        assert_eq!(values(&store), wanted, "{number} after power-up");
    }
}

/// The power fails at every operation of every save, before, within and after it; then once more at every operation of the next.
#[test]
fn a_power_cut_at_any_operation_leaves_all_old_or_all_new_values() {
    let mut store = FlashStore::new(Ram::new());
    let mut cuts = 0;
    for number in 0..60 {
        let old = values(&store);
        let mut whole = store.clone();
        whole.pages.operations = 0;
        whole.save_all(&mut save(number).into_iter()).unwrap();
        let (operations, new) = (whole.pages.operations, values(&whole));
        for at in 1..=operations {
            for cut in [Cut::Before, Cut::Within(0x0F0F_3355), Cut::Within(0xAAAA_0001), Cut::Within(1), Cut::After] {
                let mut failing = store.clone();
                (failing.pages.operations, failing.pages.cut) = (0, Some((at, cut)));
                let answered = failing.save_all(&mut save(number).into_iter());
                let mut memory = failing.pages.clone();
                memory.cut = None;
                let mut restarted = FlashStore::new(memory);
                let found = values(&restarted);
                assert!(found == old || found == new, "save {number}, operation {at}, {cut:?}: {found:?}");
                assert!(
                    answered.is_err() || found == new,
                    "save {number}, operation {at}, {cut:?}: answered too early"
                );
                // The store works on: the same save again gives the new values.
                assert_eq!(
                    restarted.save_all(&mut save(number).into_iter()),
                    Ok(()),
                    "save {number}, operation {at}, {cut:?}"
                );
                assert_eq!(values(&restarted), new);
                assert_eq!(values(&FlashStore::new(restarted.pages().clone())), new);
                cuts += 1;
            }
        }
        store = whole;
    }
    assert!(cuts > 2000, "{cuts}");
}

/// A save that was answered as stored is there after power-up, and one that was not leaves the values of before.
#[test]
fn a_worn_bit_loses_no_value() {
    let mut refused = 0;
    for (page, offset) in [0, 1].into_iter().flat_map(|page| (0..PAGE).step_by(WORD).map(move |offset| (page, offset)))
    {
        for bit in [1, 1 << 16, 1 << 31] {
            let mut store = FlashStore::new(Ram { worn: Some((page, offset, bit)), ..Ram::new() });
            for number in 0..20 {
                let old = values(&store);
                let saved = store.save_all(&mut save(number).into_iter());
                let new = values(&store);
                store = FlashStore::new(store.pages().clone());
                assert_eq!(values(&store), new, "page {page}, {offset}, save {number}");
                if saved.is_err() {
                    refused += 1;
                    assert_eq!(new, old, "page {page}, {offset}, save {number}");
                } else {
                    for (key, octets) in save(number) {
                        let position = KEYS.iter().position(|it| *it == key).unwrap();
                        assert_eq!(new[position].as_deref(), Some(&*octets), "page {page}, {offset}, save {number}");
                    }
                }
            }
        }
    }
    assert!(refused > 0);
}

#[test]
fn a_full_store_refuses_a_save_and_keeps_its_values() {
    let mut store = FlashStore::new(Ram::new());
    let large = |number: u8| (Key::Internal(number), Octets::new(&[number; 16]));
    for number in 0..5 {
        assert_eq!(store.save_all(&mut core::iter::once(large(number))), Ok(()), "{number}");
    }
    let before = values(&store);
    assert_eq!(store.save_all(&mut core::iter::once(large(5))), Err(StoreError));
    assert_eq!(store.save_all(&mut core::iter::once((Key::Address, Octets::new(&[0; 17])))), Err(StoreError));
    assert_eq!(values(&store), before);
    assert_eq!(values(&FlashStore::new(store.pages().clone())), before);
    assert_eq!(store.save_all(&mut core::iter::once(large(0))), Ok(()));
}

#[test]
fn an_empty_store_has_no_values_and_an_empty_save_writes_nothing() {
    let mut store = FlashStore::new(Ram::new());
    assert_eq!(store.save_all(&mut core::iter::empty()), Ok(()));
    assert_eq!((store.pages().operations, values(&store)), (0, std::vec![None; 4]));
}
