//! The flash of the board as the memory of a device.

use profivac_board::flash;
use profivac_runtime::flash::{FlashStore, Pages};

/// The two flash pages of the board.
#[derive(Clone, Debug)]
pub struct BoardFlash;

impl Pages for BoardFlash {
    const OCTETS: usize = flash::PAGE;

    fn word(&self, page: usize, offset: usize) -> u32 {
        flash::word(page, offset)
    }

    fn program(&mut self, page: usize, offset: usize, word: u32) {
        flash::program(page, offset, word);
    }

    fn erase(&mut self, page: usize) {
        profivac_board::feed_watchdog();
        flash::erase(page);
    }
}

/// The store of the board.
#[must_use]
pub fn store() -> FlashStore<BoardFlash> {
    FlashStore::new(BoardFlash)
}
