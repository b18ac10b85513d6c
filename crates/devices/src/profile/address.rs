//! The station address: from two switches, or stored by Set_Slave_Add. errata-bpg-bcg-tpg 8, profibus-wire 2.11.

use crate::model::Octets;
use crate::store::{self, Key, Store, StoreError};
use profivac_wire::address::SetSlaveAdd;

/// The highest address that a switch or Set_Slave_Add can set.
const HIGHEST: u8 = 125;

/// The address of a station before Set_Slave_Add.
const UNSET: u8 = 126;

/// The address switch and the address in nonvolatile memory.
#[derive(Clone, Debug)]
pub struct StationAddress {
    /// The setting of the switch.
    pub switch: u8,
    /// Its setting at power-up: the device reads it only then.
    switch_at_start: u8,
    stored: u8,
    /// No_Add_Chg.
    locked: bool,
}

impl StationAddress {
    /// The address of a device whose switch is set to `switch`.
    #[must_use]
    pub const fn new(switch: u8) -> Self {
        Self { switch, switch_at_start: switch, stored: UNSET, locked: false }
    }

    /// Power-up: a valid setting of the switch is stored and holds, otherwise the stored address.
    ///
    /// chosen: an address from the switch lifts No_Add_Chg, the only way out of a device without factory reset.
    pub fn start(&mut self, store: &mut impl Store) {
        (self.stored, self.locked) = match store::load(store, Key::Address).as_deref() {
            Some([address, locked]) => (*address, *locked != 0),
            _ => (UNSET, false),
        };
        self.switch_at_start = self.switch;
        if self.is_from_switch() && (self.stored, self.locked) != (self.switch, false) {
            (self.stored, self.locked) = (self.switch, false);
            // A memory that fails changes nothing here: the switch holds as long as it is valid.
            let _ = store.save(Key::Address, &[self.stored, 0]);
        }
    }

    /// Whether the memory holds an address, or none.
    pub fn is_stored_well(store: &impl Store) -> bool {
        store::load(store, Key::Address).as_deref().is_none_or(|octets| matches!(octets, [..=UNSET, 0 | 1]))
    }

    const fn is_from_switch(&self) -> bool {
        self.switch_at_start <= HIGHEST
    }

    /// The address that holds.
    #[must_use]
    pub const fn get(&self) -> u8 {
        if self.is_from_switch() { self.switch_at_start } else { self.stored }
    }

    /// Whether the device serves Set_Slave_Add.
    #[must_use]
    pub const fn is_settable(&self) -> bool {
        !self.is_from_switch()
    }

    /// No_Add_Chg.
    #[must_use]
    pub const fn is_locked(&self) -> bool {
        self.locked
    }

    /// Set_Slave_Add. The new address is stored first; `None` if nothing changed.
    pub fn set(&mut self, store: &mut impl Store, request: &SetSlaveAdd<'_>) -> Option<u8> {
        if !self.is_settable() || self.locked || request.address > HIGHEST {
            return None;
        }
        self.put(store, request.address, request.no_add_chg != 0).ok()?;
        Some(request.address)
    }

    /// Stores the address and then uses it.
    pub fn put(&mut self, store: &mut impl Store, address: u8, locked: bool) -> Result<(), StoreError> {
        store.save(Key::Address, &[address, u8::from(locked)])?;
        (self.stored, self.locked) = (address, locked);
        Ok(())
    }

    /// The address after a factory reset, which lifts No_Add_Chg; `None` if it changes nothing. profibus-wire 2.11.
    ///
    /// chosen: the address stays, so that the master that asked for the reset finds the device again.
    #[must_use]
    pub fn unlocked(&self) -> Option<Self> {
        self.locked.then(|| Self { locked: false, ..self.clone() })
    }

    /// The key and the octets in the memory.
    #[must_use]
    pub fn entry(&self) -> (Key, Octets) {
        (Key::Address, Octets::new(&[self.stored, u8::from(self.locked)]))
    }
}
