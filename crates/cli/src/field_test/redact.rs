//! Removes private data from telegrams: the contents of records, and the data of other masters.

use profivac_host::port::Direction;
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Sap, Telegram};

/// Read, Write and Data_Transport of DP-V1, profibus-wire 4.1.
const RECORD_FUNCTIONS: [u8; 3] = [0x5E, 0x5F, 0x51];

/// Function number, slot, index and length.
const RECORD_HEADER: usize = 4;

/// The longest record that is kept. chosen: a number has at most four octets, a text of a gauge has 8 or more.
const MAX_RECORD: usize = 4;

/// The shortest text in damaged octets. chosen: four printable octets in succession are rarely a part of the protocol.
const MIN_TEXT: usize = 4;

/// In place of private octets in damaged pieces.
const REMOVED: u8 = b'x';

/// The rules of removal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Redaction {
    /// Whether records keep their contents.
    keeps_records: bool,
    /// The address of this master, if other masters are on the line: telegrams between other stations lose their data.
    beside_others: Option<u8>,
}

impl Redaction {
    /// Removes nothing.
    #[cfg(test)]
    pub const NONE: Self = Self { keeps_records: true, beside_others: None };

    /// Removes records unless `keeps_records`. `beside_others` is the address of this master if another one is on the line: the data of
    /// the others are removed in every case.
    pub const fn new(keeps_records: bool, beside_others: Option<u8>) -> Self {
        Self { keeps_records, beside_others }
    }

    /// The octets of a telegram or of a damaged piece, with zeros (in damaged octets: `x`) in place of private data.
    pub fn of(self, direction: Direction, octets: &[u8]) -> Vec<u8> {
        match Telegram::parse(octets) {
            Ok(Telegram::Data(data)) => {
                let kept = self.kept(direction, &data);
                if kept >= data.du.len() { octets.to_vec() } else { with_zeros(data, kept) }
            }
            Ok(Telegram::ShortAck | Telegram::Token { .. }) => octets.to_vec(),
            // A damaged piece does not show whose it is.
            Err(_) if direction == Direction::Received && self.beside_others.is_some() => vec![REMOVED; octets.len()],
            Err(_) if self.keeps_records => octets.to_vec(),
            Err(_) => without_text(octets),
        }
    }

    /// The number of octets of the data unit that stay.
    fn kept(self, direction: Direction, data: &DataTelegram<'_>) -> usize {
        let is_foreign = direction == Direction::Received && self.beside_others.is_some_and(|own| data.da != own);
        let is_record = data.du.first().is_some_and(|function| RECORD_FUNCTIONS.contains(function));
        let is_long = data.du.len() > RECORD_HEADER.saturating_add(MAX_RECORD);
        match (is_foreign, is_record && is_long && (is_acyclic(data.dsap) || is_acyclic(data.ssap))) {
            (true, _) => 0,
            (false, true) if !self.keeps_records => RECORD_HEADER,
            (false, _) => data.du.len(),
        }
    }
}

/// Whether records pass through an access point.
const fn is_acyclic(sap: Option<u8>) -> bool {
    matches!(Sap::from_octet(sap), Sap::Ms2(_) | Sap::ResourceManager | Sap::Ms1)
}

/// The telegram with zeros behind the first `kept` octets of its data unit.
fn with_zeros(data: DataTelegram<'_>, kept: usize) -> Vec<u8> {
    let du: Vec<u8> = data.du.iter().enumerate().map(|(index, octet)| if index < kept { *octet } else { 0 }).collect();
    let mut out = [0; MAX_TELEGRAM];
    let length = Telegram::Data(DataTelegram { du: &du, ..data }).emit(&mut out).unwrap_or_default();
    out.get(..length).unwrap_or_default().to_vec()
}

/// Damaged octets with `x` in place of text.
fn without_text(octets: &[u8]) -> Vec<u8> {
    let is_text = |octet: &u8| octet.is_ascii_graphic() || *octet == b' ';
    let runs = octets.chunk_by(|first, second| is_text(first) == is_text(second));
    let redacted = |run: &[u8]| {
        let is_private = run.len() >= MIN_TEXT && run.first().is_some_and(is_text);
        if is_private { vec![REMOVED; run.len()] } else { run.to_vec() }
    };
    runs.flat_map(redacted).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;

    const REMOVING: Redaction = Redaction::new(false, None);

    fn telegram(dsap: Option<u8>, ssap: Option<u8>, du: &[u8]) -> Vec<u8> {
        let mut out = [0; MAX_TELEGRAM];
        let data = DataTelegram { da: 0, sa: 5, dsap, ssap, fc: 8, du };
        let length = Telegram::Data(data).emit(&mut out).unwrap();
        out[..length].to_vec()
    }

    fn has(octets: &[u8], text: &[u8]) -> bool {
        octets.windows(text.len()).any(|window| window == text)
    }

    #[test]
    fn a_serial_number_in_a_record_becomes_zeros_and_the_telegram_stays_valid() {
        let record = telegram(Some(50), Some(3), b"\x5E\x00\x17\x0AS/N 471100");
        let redacted = REMOVING.of(Direction::Received, &record);
        assert!(has(&record, b"471100") && !has(&redacted, b"4711") && !has(&redacted, b"S/N"));
        let Ok(Telegram::Data(data)) = Telegram::parse(&redacted) else { panic!("no telegram") };
        assert_eq!((data.du.len(), &data.du[..4]), (14, &[0x5E, 0, 0x17, 0x0A][..]));
        assert_eq!(Redaction::new(true, None).of(Direction::Received, &record), record);
    }

    #[test]
    fn numbers_and_other_services_stay() {
        for (ssap, du) in [(3, &b"\x5E\x01\x10\x04\x3F\x80\x00\x00"[..]), (60, b"\x5E\x0C\x00\xFF\x08\xE6abcdefgh")] {
            let kept = telegram(Some(62), Some(ssap), du);
            assert_eq!(REMOVING.of(Direction::Received, &kept), kept);
        }
        for kept in [&[0xE5][..], &[0xDC, 5, 2], &[0x68, 1, 2, 0x68, b'a', b'b', 0]] {
            assert_eq!(REMOVING.of(Direction::Received, kept), kept);
        }
    }

    #[test]
    fn text_in_damaged_octets_is_removed() {
        let damaged = b"\x68\x01\x02S/N 4711\x16ab\x16";
        assert_eq!(REMOVING.of(Direction::Received, damaged), b"\x68\x01\x02xxxxxxxx\x16ab\x16");
    }

    #[test]
    fn telegrams_between_other_stations_lose_their_data_beside_another_master() {
        let foreign = telegram(None, None, &[1, 2, 3]);
        let Ok(Telegram::Data(data)) = Telegram::parse(&foreign) else { panic!("no telegram") };
        for keeps_records in [false, true] {
            let redaction = Redaction::new(keeps_records, Some(1));
            assert_eq!(redaction.of(Direction::Received, &foreign), with_zeros(data, 0));
            assert_eq!(redaction.of(Direction::Sent, &foreign), foreign);
            assert_eq!(Redaction::new(keeps_records, Some(0)).of(Direction::Received, &foreign), foreign);
        }
    }

    #[test]
    fn damaged_octets_beside_another_master_are_removed_entirely() {
        let damaged = [0x68, 7, 7, 0x68, 1, 2, 3];
        for keeps_records in [false, true] {
            let redaction = Redaction::new(keeps_records, Some(1));
            assert_eq!(redaction.of(Direction::Received, &damaged), *b"xxxxxxx");
            assert_eq!(redaction.of(Direction::Sent, &damaged), damaged);
        }
    }
}
