//! A store in two pages of flash: after a power cut at any moment it has all old or all new values of a save, never others.
//!
//! A page is a log. Its first two words are its number and the complement of it, written last, so a page counts only when it is
//! complete. Behind them are saves: an entry for each value (a word with kind, length and key, then the octets), a word that ends the
//! save, and a checksum over all its words. Entries without a valid end were cut off and do not count. The newest entry of a key holds.
//!
//! When a save does not fit, or something was cut off behind the last save, the new values and the newest ones of all other keys go to the
//! other page, as one save. Then that page gets the next number, and only then it counts. The old page stays as it is until the next time.

use profivac_devices::model::Octets;
use profivac_devices::store::{Key, MAX_STORED, Store, StoreError};

/// Two pages of flash, in words of 32 bits. Programming turns ones to zeros, erasing turns all bits of a page to ones.
pub trait Pages {
    /// The octets of a page: a multiple of 4, at most 65532.
    const OCTETS: usize;

    /// The word at `offset` (in octets, a multiple of 4) of page 0 or 1.
    fn word(&self, page: usize, offset: usize) -> u32;

    /// Programs a word that is erased.
    fn program(&mut self, page: usize, offset: usize, word: u32);

    /// Erases a page.
    fn erase(&mut self, page: usize);
}

const WORD: usize = 4;
/// The number of a page and its complement.
const HEADER: usize = 2 * WORD;
const ERASED: u32 = u32::MAX;
/// The word that ends a save. No entry begins with these two bits.
const END: u32 = 0xC0DE_0000;
/// The bits of the length in the first word of an entry; keys leave them free.
const LENGTH_SHIFT: u32 = 24;
const LENGTH_MASK: u32 = 0x3F << LENGTH_SHIFT;

/// A store in two pages of flash.
#[derive(Clone, Debug)]
pub struct FlashStore<P> {
    pages: P,
    /// The page that counts; `None` before the first save.
    page: Option<usize>,
    number: u32,
    /// The end of the last complete save.
    end: usize,
    /// The words behind it are erased.
    is_clean: bool,
}

/// An entry of a log.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Kind and key.
    key: u32,
    offset: usize,
    length: usize,
}

impl Entry {
    /// The octets in the log, its first word included.
    const fn size(length: usize) -> usize {
        WORD.saturating_add(length.next_multiple_of(WORD))
    }

    const fn next(&self) -> usize {
        self.offset.saturating_add(Self::size(self.length))
    }
}

/// Writes entries behind each other and computes their checksum.
struct Writer {
    page: usize,
    offset: usize,
    checksum: u32,
    /// The memory has every word that was written.
    is_kept: bool,
}

impl Writer {
    const fn new(page: usize, offset: usize) -> Self {
        Self { page, offset, checksum: !0, is_kept: true }
    }
}

impl<P: Pages> FlashStore<P> {
    /// The store in these pages, after a power cut at any moment.
    pub fn new(pages: P) -> Self {
        let mut store = Self { pages, page: None, number: 0, end: HEADER, is_clean: false };
        for page in [0, 1] {
            let number = store.pages.word(page, 0);
            let is_complete = number == !store.pages.word(page, WORD);
            let is_newer = store.page.is_none() || number.wrapping_sub(store.number) as i32 > 0;
            if is_complete && is_newer {
                (store.page, store.number) = (Some(page), number);
            }
        }
        if let Some(page) = store.page {
            store.end = store.last_save(page);
            store.is_clean =
                (store.end..P::OCTETS).step_by(WORD).all(|offset| store.pages.word(page, offset) == ERASED);
        }
        #[cfg(feature = "defmt")]
        match store.page {
            Some(page) => {
                defmt::info!(
                    "flash: page {=usize} holds {=usize} octets; its end is erased: {=bool}",
                    page,
                    store.end,
                    store.is_clean
                );
            }
            None => defmt::info!("flash: no values are stored"),
        }
        store
    }

    /// The pages.
    pub const fn pages(&self) -> &P {
        &self.pages
    }

    /// The end of the last save that is complete.
    fn last_save(&self, page: usize) -> usize {
        let (mut end, mut offset, mut checksum) = (HEADER, HEADER, !0);
        while let Some(word) = self.word(page, offset) {
            checksum = summed(checksum, word);
            if word == END {
                let sum_at = offset.saturating_add(WORD);
                if self.word(page, sum_at) != Some(checksum) {
                    break;
                }
                offset = sum_at.saturating_add(WORD);
                (end, checksum) = (offset, !0);
                continue;
            }
            let Some(entry) = entry(offset, word) else { break };
            for at in (offset.saturating_add(WORD)..entry.next()).step_by(WORD) {
                checksum = summed(checksum, self.word(page, at).unwrap_or(ERASED));
            }
            offset = entry.next();
        }
        end
    }

    fn word(&self, page: usize, offset: usize) -> Option<u32> {
        (offset < P::OCTETS).then(|| self.pages.word(page, offset))
    }

    /// The entries from `from` to `to`.
    fn entries(&self, page: usize, from: usize, to: usize) -> impl Iterator<Item = Entry> {
        let mut offset = from;
        core::iter::from_fn(move || {
            while offset < to {
                let word = self.word(page, offset)?;
                if word == END {
                    offset = offset.saturating_add(HEADER);
                    continue;
                }
                let found = entry(offset, word)?;
                offset = found.next();
                return Some(found);
            }
            None
        })
    }

    /// The first entry from `from` on.
    fn entry_at(&self, page: usize, from: usize, to: usize) -> Option<Entry> {
        self.entries(page, from, to).next()
    }

    fn octets(&self, page: usize, entry: &Entry) -> Octets {
        let mut octets = [0; MAX_STORED];
        let from = entry.offset.saturating_add(WORD);
        for (number, target) in octets.chunks_mut(WORD).enumerate() {
            let word = self.word(page, from.saturating_add(number.saturating_mul(WORD))).unwrap_or(ERASED);
            target.copy_from_slice(&word.to_le_bytes());
        }
        Octets::new(octets.get(..entry.length).unwrap_or_default())
    }

    /// Appends the values behind the last save; the end of the entries if they do not fit, with the value that did not.
    fn append(&mut self, page: usize, values: &mut dyn Iterator<Item = (Key, Octets)>) -> Result<(), Appended> {
        let mut writer = Writer::new(page, self.end);
        for (key, octets) in values {
            if !self.put(&mut writer, key.to_u32(), &octets) {
                return Err(Appended { end: writer.offset, is_kept: writer.is_kept, next: (key, octets) });
            }
        }
        if self.finish(&mut writer) {
            self.end = writer.offset;
        }
        Ok(())
    }

    /// Copies the newest entries between two places of the present page, except for keys that are on the other page already.
    fn copy(&mut self, writer: &mut Writer, from: usize, end: usize) -> Result<(), StoreError> {
        let Some(page) = self.page else { return Ok(()) };
        let mut at = from;
        while let Some(entry) = self.entry_at(page, at, end) {
            at = entry.next();
            let has_key = |other: Entry| other.key == entry.key;
            let is_newest = !self.entries(page, at, end).any(has_key)
                && !self.entries(writer.page, HEADER, writer.offset).any(has_key);
            let octets = self.octets(page, &entry);
            if is_newest && !self.put(writer, entry.key, &octets) {
                return Err(StoreError);
            }
        }
        Ok(())
    }

    /// Writes an entry. Returns whether it fits, together with the end of the save.
    fn put(&mut self, writer: &mut Writer, key: u32, octets: &[u8]) -> bool {
        let size = Entry::size(octets.len()).saturating_add(HEADER);
        if octets.len() > MAX_STORED || writer.offset.saturating_add(size) > P::OCTETS {
            return false;
        }
        self.put_word(writer, key | (octets.len() as u32) << LENGTH_SHIFT);
        for chunk in octets.chunks(WORD) {
            let mut word = [0xFF; WORD];
            for (target, octet) in word.iter_mut().zip(chunk) {
                *target = *octet;
            }
            self.put_word(writer, u32::from_le_bytes(word));
        }
        true
    }

    fn put_word(&mut self, writer: &mut Writer, word: u32) {
        writer.checksum = summed(writer.checksum, word);
        self.pages.program(writer.page, writer.offset, word);
        writer.is_kept &= self.pages.word(writer.page, writer.offset) == word;
        writer.offset = writer.offset.saturating_add(WORD);
    }

    /// Ends a save. Returns whether the memory has every word of it.
    fn finish(&mut self, writer: &mut Writer) -> bool {
        self.put_word(writer, END);
        let checksum = writer.checksum;
        self.put_word(writer, checksum);
        writer.is_kept
    }

    /// Writes the new values, and the newest of all other keys, to the other page. `appended` are new ones that are on the present
    /// page already.
    fn change_page(
        &mut self,
        appended: Option<Appended>,
        values: &mut dyn Iterator<Item = (Key, Octets)>,
    ) -> Result<(), StoreError> {
        let to = self.page.map_or(0, |page| usize::from(page == 0));
        #[cfg(feature = "defmt")]
        defmt::info!("flash: erases page {=usize} and copies all values to it", to);
        self.pages.erase(to);
        let mut writer = Writer::new(to, HEADER);
        let (new_end, next) = appended.map_or((self.end, None), |appended| (appended.end, Some(appended.next)));
        self.copy(&mut writer, self.end, new_end)?;
        for (key, octets) in next.into_iter().chain(values) {
            if !self.put(&mut writer, key.to_u32(), &octets) {
                return Err(StoreError);
            }
        }
        self.copy(&mut writer, HEADER, self.end)?;
        if !self.finish(&mut writer) {
            return Err(StoreError);
        }
        let number = self.number.wrapping_add(1);
        self.pages.program(to, 0, number);
        self.pages.program(to, WORD, !number);
        if self.word(to, 0) != Some(number) || self.word(to, WORD) != Some(!number) {
            return Err(StoreError);
        }
        (self.page, self.number, self.end, self.is_clean) = (Some(to), number, writer.offset, true);
        Ok(())
    }
}

/// New values that are on a page without an end, and the one that did not fit.
struct Appended {
    end: usize,
    /// The page has every word of them.
    is_kept: bool,
    next: (Key, Octets),
}

/// The entry whose first word this is.
const fn entry(offset: usize, word: u32) -> Option<Entry> {
    let length = ((word & LENGTH_MASK) >> LENGTH_SHIFT) as usize;
    let key = word & !LENGTH_MASK;
    if length > MAX_STORED || Key::from_u32(key).is_none() {
        return None;
    }
    Some(Entry { key, offset, length })
}

/// CRC-32, one word at a time.
fn summed(checksum: u32, word: u32) -> u32 {
    (0..u32::BITS).fold(checksum ^ word, |sum, _| if sum & 1 == 0 { sum >> 1 } else { sum >> 1 ^ 0xEDB8_8320 })
}

impl<P: Pages> Store for FlashStore<P> {
    fn load(&self, key: Key, octets: &mut [u8]) -> Option<usize> {
        let page = self.page?;
        let entry = self.entries(page, HEADER, self.end).filter(|entry| entry.key == key.to_u32()).last()?;
        let target = octets.get_mut(..entry.length)?;
        for (target, octet) in target.iter_mut().zip(self.octets(page, &entry).iter()) {
            *target = *octet;
        }
        Some(entry.length)
    }

    fn save_all(&mut self, values: &mut dyn Iterator<Item = (Key, Octets)>) -> Result<(), StoreError> {
        let result = self.write_all(values);
        #[cfg(feature = "defmt")]
        match result {
            Ok(()) => defmt::info!("flash: saved; page {=usize} has {=usize} octets", self.page.unwrap_or(0), self.end),
            Err(StoreError) => {
                defmt::error!("flash: not saved; the values do not fit, or a word did not keep its value")
            }
        }
        result
    }
}

impl<P: Pages> FlashStore<P> {
    /// Saves the values: all or none.
    fn write_all(&mut self, values: &mut dyn Iterator<Item = (Key, Octets)>) -> Result<(), StoreError> {
        let mut values = values.peekable();
        if values.peek().is_none() {
            return Ok(());
        }
        let Some(page) = self.page.filter(|_| self.is_clean) else { return self.change_page(None, &mut values) };
        // Until the save is complete, and if it fails, the words behind the last one are used up.
        self.is_clean = false;
        let before = self.end;
        match self.append(page, &mut values) {
            Err(appended) if appended.is_kept => self.change_page(Some(appended), &mut values),
            Err(_) => Err(StoreError),
            Ok(()) if self.end == before => Err(StoreError),
            Ok(()) => {
                self.is_clean = true;
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests;
