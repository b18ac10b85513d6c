//! A store that counts its writes and can fail.

use profivac_devices::model::Octets;
use profivac_devices::store::{Key, RamStore, Store, StoreError};

#[derive(Clone, Default)]
pub struct CountingStore {
    store: RamStore,
    /// Every write fails.
    broken: bool,
    /// The number of writes.
    pub saved: usize,
}

impl CountingStore {
    pub fn broken() -> Self {
        Self { broken: true, ..Self::default() }
    }
}

impl Store for CountingStore {
    fn load(&self, key: Key, octets: &mut [u8]) -> Option<usize> {
        self.store.load(key, octets)
    }

    fn save_all(&mut self, values: &mut dyn Iterator<Item = (Key, Octets)>) -> Result<(), StoreError> {
        self.saved += 1;
        if self.broken { Err(StoreError) } else { self.store.save_all(values) }
    }
}
