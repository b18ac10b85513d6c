//! Telegrams in their five formats: SD1, SD2, SD3, SD4 and SC. profibus-wire 1.2 to 1.6.
//!
//! [`Telegram::parse`] accepts all five. [`Telegram::emit`] writes SD1 for a data telegram without access points and data and
//! SD2 for every other one. It never writes SD3, because one commercial slave fails on it (profibus-wire 10, point 39).

use crate::control::Control;
use crate::octets::{TooLong, Writer};
use core::fmt;

/// Length of the longest telegram: SD2 with LE = 249.
pub const MAX_TELEGRAM: usize = 255;

/// Length of the longest data unit with two service access points: 249 - DA - SA - FC - DAE - SAE.
pub const MAX_DU: usize = 244;

/// The broadcast address: a request to all stations.
pub const BROADCAST: u8 = 127;

const SD1: u8 = 0x10;
const SD2: u8 = 0x68;
const SD3: u8 = 0xA2;
const SD4: u8 = 0xDC;
const SC: u8 = 0xE5;
const ED: u8 = 0x16;

/// The octets of an SD2 that LE does not count: SD2, LE, LEr, SD2, FCS and ED.
const FRAME: usize = 6;

/// DA, SA and FC.
const HEAD: u8 = 3;

/// The greatest LE.
const MAX_LE: u8 = 249;

/// Bit 7 of DA and SA: an extension octet for this address follows FC.
const EXT: u8 = 0x80;

/// A complete telegram.
///
/// ```
/// use profivac_wire::Telegram;
///
/// assert_eq!(Telegram::parse(&[0xDC, 5, 2]), Ok(Telegram::Token { da: 5, sa: 2 }));
/// assert_eq!(Telegram::parse(&[0xE5]), Ok(Telegram::ShortAck));
/// assert!(Telegram::parse(&[0x10, 8, 2, 0x49, 0x54, 0x16]).is_err());
///
/// let mut out = [0; 3];
/// assert_eq!(Telegram::Token { da: 5, sa: 2 }.emit(&mut out), Ok(3));
/// assert_eq!(out, [0xDC, 5, 2]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Telegram<'a> {
    /// SC: the short acknowledgement.
    ShortAck,
    /// SD4: the token, from `sa` to `da`. Both octets as received; SD4 has no check octet.
    Token {
        /// The receiver of the token.
        da: u8,
        /// The sender of the token.
        sa: u8,
    },
    /// SD1, SD2 or SD3: a request or an answer.
    Data(DataTelegram<'a>),
}

/// A telegram with addresses, frame control and a data unit: SD1, SD2 or SD3.
///
/// ```
/// use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram, control::Control};
///
/// // FDL status request from station 2 to station 8.
/// let request = DataTelegram::short(8, 2, Control::from_octet(0x49));
/// let mut out = [0; MAX_TELEGRAM];
/// let length = Telegram::Data(request).emit(&mut out)?;
/// assert_eq!(out[..length], [0x10, 8, 2, 0x49, 0x53, 0x16]);
/// assert!(matches!(request.control(), Control::Request { .. }));
/// # Ok::<(), profivac_wire::TooLong>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DataTelegram<'a> {
    /// Destination address, 0 to 127, without the EXT bit.
    pub da: u8,
    /// Source address, 0 to 127, without the EXT bit.
    pub sa: u8,
    /// The extension octet of DA as received: 0 to 63 is a service access point, other values are regional addressing.
    pub dsap: Option<u8>,
    /// The extension octet of SA as received.
    pub ssap: Option<u8>,
    /// The frame control octet.
    pub fc: u8,
    /// The data unit.
    pub du: &'a [u8],
}

/// Error of octets that are not a telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TelegramError {
    /// The octet is not a start delimiter.
    Start(u8),
    /// The format has another length, LE and LEr differ, or LE is not 3 to 249.
    Length,
    /// The last octet is not the end delimiter 16.
    End(u8),
    /// FCS is not the sum of the octets it covers.
    Checksum {
        /// The sum of the received octets.
        expected: u8,
        /// The received FCS.
        received: u8,
    },
    /// An EXT bit announces an extension octet that is missing.
    Extension,
}

impl fmt::Display for TelegramError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Start(octet) => write!(f, "no telegram begins with {octet:02X}"),
            Self::Length => f.write_str("the length octets do not fit the telegram"),
            Self::End(octet) => write!(f, "the telegram ends with {octet:02X} instead of 16"),
            Self::Checksum { expected, received } => {
                write!(f, "the check octet is {received:02X}, the sum is {expected:02X}")
            }
            Self::Extension => f.write_str("an address extension is announced and missing"),
        }
    }
}

impl core::error::Error for TelegramError {}

/// The length of a telegram, as far as its first octets determine it.
///
/// ```
/// use profivac_wire::TelegramLength;
///
/// assert_eq!(TelegramLength::of(&[0x10]), TelegramLength::Known(6));
/// assert_eq!(TelegramLength::of(&[0x68, 5]), TelegramLength::Incomplete);
/// assert_eq!(TelegramLength::of(&[0x68, 5, 5, 0x68]), TelegramLength::Known(11));
/// assert_eq!(TelegramLength::from_sd2_header([0x68, 5, 5, 0x68]), TelegramLength::Known(11));
/// assert_eq!(TelegramLength::from_start_delimiter(0xDC), TelegramLength::Known(3));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TelegramLength {
    /// The number of octets in total.
    Known(u8),
    /// More octets are needed.
    Incomplete,
    /// The octets do not begin a telegram.
    Invalid(TelegramError),
}

impl TelegramLength {
    /// The number of octets that always determine the length.
    pub const HEADER_LENGTH: u8 = 4;

    /// The length according to the first octets: four of an SD2, one of every other format.
    #[must_use]
    #[inline]
    pub const fn of(octets: &[u8]) -> Self {
        match octets {
            [] => Self::Incomplete,
            [SD2, le, ler, repeated, ..] => Self::from_sd2_header([SD2, *le, *ler, *repeated]),
            [SD2, le, ler] if *le != *ler => Self::Invalid(TelegramError::Length),
            // LE = 3 is an SD2 without data, which a parser accepts: profibus-wire 1.2.
            [SD2, 0..3 | 250.., ..] => Self::Invalid(TelegramError::Length),
            [first, ..] => Self::from_start_delimiter(*first),
        }
    }

    /// The length according to the start delimiter. An SD2 needs more octets.
    #[must_use]
    #[inline]
    pub const fn from_start_delimiter(first: u8) -> Self {
        match first {
            SC => Self::Known(1),
            SD4 => Self::Known(3),
            SD1 => Self::Known(6),
            SD2 => Self::Incomplete,
            SD3 => Self::Known(14),
            other => Self::Invalid(TelegramError::Start(other)),
        }
    }

    /// The length according to the first four octets of an SD2.
    #[must_use]
    #[inline]
    pub const fn from_sd2_header(head: [u8; 4]) -> Self {
        match head {
            [SD2, le @ 3..=249, ler, SD2] if le == ler => Self::Known(le.saturating_add(6)),
            [SD2, _, _, SD2] => Self::Invalid(TelegramError::Length),
            [SD2, _, _, other] | [other, ..] => Self::Invalid(TelegramError::Start(other)),
        }
    }
}

/// The arithmetic sum of `octets`, modulo 256. profibus-wire 1.6.
#[cfg(not(target_arch = "arm"))]
fn sum(octets: &[u8]) -> u8 {
    octets.iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet))
}

#[cfg(target_arch = "arm")]
use sum_of_words as sum;

/// [`sum`] for a processor with words of 32 bits and no vectors, of at most 256 octets: the four octets of a word are added in two lanes
/// of 16 bits. Not inlined: firmware has it once.
#[cfg(any(test, target_arch = "arm"))]
#[inline(never)]
fn sum_of_words(octets: &[u8]) -> u8 {
    let words = octets.chunks_exact(4);
    let rest = words.remainder().iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
    let lanes = words.filter_map(|word| word.first_chunk()).fold(0, |lanes: u32, word| {
        let word = u32::from_le_bytes(*word);
        lanes.wrapping_add(word & 0x00FF_00FF).wrapping_add(word >> 8 & 0x00FF_00FF)
    });
    rest.wrapping_add(lanes as u8).wrapping_add((lanes >> 16) as u8)
}

impl<'a> Telegram<'a> {
    /// Parses exactly one telegram.
    ///
    /// # Errors
    /// [`TelegramError`] names the first error.
    #[inline]
    pub fn parse(octets: &'a [u8]) -> Result<Self, TelegramError> {
        match octets {
            [SC] => Ok(Self::ShortAck),
            [SD4, da, sa] => Ok(Self::Token { da: *da, sa: *sa }),
            [SD2, le, ler, SD2, body @ .., fcs, ED] if *le == *ler && usize::from(*le) == body.len() => {
                DataTelegram::parse(body, *fcs).map(Self::Data)
            }
            [SD1, body @ .., fcs, ED] if body.len() == 3 => DataTelegram::parse(body, *fcs).map(Self::Data),
            [SD3, body @ .., fcs, ED] if body.len() == 11 => DataTelegram::parse(body, *fcs).map(Self::Data),
            _ => Err(Self::error_in(octets)),
        }
    }

    /// The error of octets that match no format.
    #[cold]
    fn error_in(octets: &[u8]) -> TelegramError {
        match (TelegramLength::of(octets), octets.last()) {
            (TelegramLength::Invalid(defect), _) => defect,
            (TelegramLength::Known(total), Some(last)) if usize::from(total) == octets.len() => {
                TelegramError::End(*last)
            }
            _ => TelegramError::Length,
        }
    }

    /// Writes the telegram to the front of `out` and returns its length.
    ///
    /// # Errors
    /// [`TooLong`] if `out` is too small, or the data unit longer than a telegram carries.
    #[inline]
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        match self {
            Self::ShortAck => {
                let mut writer = Writer::new(out);
                writer.octet(SC)?;
                Ok(writer.written())
            }
            Self::Token { da, sa } => {
                let mut writer = Writer::new(out);
                writer.octets(&[SD4, *da, *sa])?;
                Ok(writer.written())
            }
            Self::Data(data) => data.emit(out),
        }
    }
}

impl<'a> DataTelegram<'a> {
    /// Parses the part between the start delimiter and FCS.
    #[inline]
    fn parse(body: &'a [u8], fcs: u8) -> Result<Self, TelegramError> {
        let expected = sum(body);
        if expected != fcs {
            return Err(TelegramError::Checksum { expected, received: fcs });
        }
        let [da, sa, fc, rest @ ..] = body else { return Err(TelegramError::Length) };
        let (dsap, rest) = extension(*da, rest)?;
        let (ssap, du) = extension(*sa, rest)?;
        Ok(Self { da: *da & !EXT, sa: *sa & !EXT, dsap, ssap, fc: *fc, du })
    }

    /// The decoded frame control octet.
    #[must_use]
    #[inline]
    pub const fn control(&self) -> Control {
        Control::from_octet(self.fc)
    }

    /// A telegram without access points and data: SD1 on the wire.
    #[must_use]
    pub const fn short(da: u8, sa: u8, control: Control) -> Self {
        Self { da, sa, dsap: None, ssap: None, fc: control.to_octet(), du: &[] }
    }

    fn emit(&self, out: &mut [u8]) -> Result<usize, TooLong> {
        let (da, sa, fc, du) = (self.da & !EXT, self.sa & !EXT, self.fc, self.du);
        match (self.dsap, self.ssap) {
            (None, None) if du.is_empty() => {
                let mut writer = Writer::new(out);
                writer.octets(&[SD1, da, sa, fc, sum(&[da, sa, fc]), ED])?;
                Ok(writer.written())
            }
            (None, None) => emit_sd2(out, [da, sa, fc], du),
            (Some(dsap), Some(ssap)) => emit_sd2(out, [da | EXT, sa | EXT, fc, dsap, ssap], du),
            (Some(dsap), None) => emit_sd2(out, [da | EXT, sa, fc, dsap], du),
            (None, Some(ssap)) => emit_sd2(out, [da, sa | EXT, fc, ssap], du),
        }
    }
}

/// Writes an SD2 without access points to the front of `out` and returns its length: `fill` writes the data unit of `length` octets where
/// it belongs, and returns FC. Unlike [`Telegram::emit`] it writes an SD2 for an empty data unit, too.
///
/// ```
/// use profivac_wire::emit_sd2_with;
///
/// let mut out = [0; 16];
/// let length = emit_sd2_with(&mut out, 2, 8, 1, |du| {
///     du.fill(0x55);
///     0x08
/// })?;
/// assert_eq!(out[..length], [0x68, 4, 4, 0x68, 2, 8, 0x08, 0x55, 0x67, 0x16]);
/// # Ok::<(), profivac_wire::TooLong>(())
/// ```
///
/// # Errors
/// [`TooLong`] if `out` is too small, or the data unit longer than a telegram carries.
#[inline]
pub fn emit_sd2_with(
    out: &mut [u8],
    da: u8,
    sa: u8,
    length: u8,
    fill: impl FnOnce(&mut [u8]) -> u8,
) -> Result<usize, TooLong> {
    let le = length.checked_add(HEAD).filter(|le| *le <= MAX_LE).ok_or(TooLong)?;
    let total = usize::from(le).saturating_add(FRAME);
    let out = out.get_mut(..total).ok_or(TooLong)?;
    let (start, rest) = out.split_first_chunk_mut().ok_or(TooLong)?;
    let (du, end) = rest.split_last_chunk_mut().ok_or(TooLong)?;
    let fc = fill(du);
    let (da, sa) = (da & !EXT, sa & !EXT);
    *start = [SD2, le, le, SD2, da, sa, fc];
    *end = [sum(&[da, sa, fc]).wrapping_add(sum(du)), ED];
    Ok(total)
}

/// Writes an SD2: `head` is the part from DA up to the data unit.
#[inline]
fn emit_sd2<const HEAD: usize>(out: &mut [u8], head: [u8; HEAD], du: &[u8]) -> Result<usize, TooLong> {
    let le = HEAD.saturating_add(du.len());
    let le = u8::try_from(le).ok().filter(|le| *le <= MAX_LE).ok_or(TooLong)?;
    // One check of the bounds for the whole telegram: the compiler knows the lengths of the parts then.
    let length = usize::from(le).saturating_add(FRAME);
    let out = out.get_mut(..length).ok_or(TooLong)?;
    let (start, rest) = out.split_first_chunk_mut().ok_or(TooLong)?;
    let (head_place, rest) = rest.split_first_chunk_mut().ok_or(TooLong)?;
    let (du_place, end) = rest.split_last_chunk_mut().ok_or(TooLong)?;
    *start = [SD2, le, le, SD2];
    *head_place = head;
    *end = [sum(&head).wrapping_add(sum(du)), ED];
    if du_place.len() != du.len() {
        return Err(TooLong);
    }
    du_place.copy_from_slice(du);
    Ok(length)
}

/// Splits off the extension octet that the EXT bit of `address` announces.
#[inline]
fn extension(address: u8, rest: &[u8]) -> Result<(Option<u8>, &[u8]), TelegramError> {
    match (address & EXT != 0, rest) {
        (false, _) => Ok((None, rest)),
        (true, [extension, rest @ ..]) => Ok((Some(*extension), rest)),
        (true, []) => Err(TelegramError::Extension),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::hex;

    const SLAVE_DIAG: DataTelegram<'_> =
        DataTelegram { da: 8, sa: 2, dsap: Some(60), ssap: Some(62), fc: 0x6D, du: &[] };

    #[test]
    fn the_sum_of_words_is_that_of_their_octets() {
        let (ones, rising) = ([0xFF; 256], core::array::from_fn::<u8, 256, _>(|at| at.wrapping_mul(37) as u8));
        for length in 0..=256 {
            for octets in [&ones, &rising] {
                assert_eq!(sum_of_words(&octets[..length]), sum(&octets[..length]), "{length} octets");
            }
        }
    }

    /// Telegrams of profibus-wire 1.6, 1.13, 1.15, 2.3 and 2.8 with their content, in the formats of profibus-wire 1.2.
    fn printed() -> [(&'static str, Telegram<'static>); 6] {
        [
            ("E5", Telegram::ShortAck),
            ("DC 02 02", Telegram::Token { da: 2, sa: 2 }),
            (
                "10 08 02 49 53 16",
                Telegram::Data(DataTelegram { da: 8, sa: 2, dsap: None, ssap: None, fc: 0x49, du: &[] }),
            ),
            ("68 05 05 68 88 82 6D 3C 3E F1 16", Telegram::Data(SLAVE_DIAG)),
            (
                "68 05 05 68 08 02 7D AA 55 86 16",
                Telegram::Data(DataTelegram { da: 8, sa: 2, dsap: None, ssap: None, fc: 0x7D, du: &[0xAA, 0x55] }),
            ),
            (
                "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16",
                Telegram::Data(DataTelegram {
                    da: 2,
                    sa: 8,
                    dsap: Some(62),
                    ssap: Some(60),
                    fc: 0x08,
                    du: &[0x02, 0x05, 0x00, 0xFF, 0x12, 0x34],
                }),
            ),
        ]
    }

    #[test]
    fn printed_telegrams_parse() {
        for (text, telegram) in printed() {
            assert_eq!(Telegram::parse(&hex(text)), Ok(telegram), "{text}");
        }
    }

    #[test]
    fn printed_telegrams_emit() {
        for (text, telegram) in printed() {
            let mut out = [0; MAX_TELEGRAM];
            let length = telegram.emit(&mut out).unwrap();
            assert_eq!(out[..length], hex(text), "{text}");
        }
    }

    #[test]
    fn every_altered_octet_is_an_error() {
        for (text, telegram) in printed().into_iter().skip(2) {
            let octets = hex(text);
            for position in 0..octets.len() {
                for flipped in 1..=0xFF {
                    let mut altered = octets.clone();
                    altered[position] ^= flipped;
                    assert_ne!(Telegram::parse(&altered), Ok(telegram));
                    assert!(
                        Telegram::parse(&altered).is_err(),
                        "{text}: octet {position} as {:02X}",
                        altered[position]
                    );
                }
            }
        }
    }

    #[test]
    fn every_shorter_and_every_longer_telegram_is_an_error() {
        for (text, _) in printed() {
            let mut octets = hex(text);
            for length in 0..octets.len() {
                assert!(Telegram::parse(&octets[..length]).is_err(), "{text} cut to {length}");
            }
            octets.push(0x16);
            assert!(Telegram::parse(&octets).is_err(), "{text} with an octet too many");
        }
    }

    #[test]
    fn sd3_carries_eight_octets_with_or_without_access_points() {
        let plain = hex("A2 08 02 7D 01 02 03 04 05 06 07 08 AB 16");
        assert_eq!(
            Telegram::parse(&plain),
            Ok(Telegram::Data(DataTelegram {
                da: 8,
                sa: 2,
                dsap: None,
                ssap: None,
                fc: 0x7D,
                du: &[1, 2, 3, 4, 5, 6, 7, 8]
            }))
        );
        // Chk_Cfg with six identifiers, as pyprofibus sends it.
        let chk_cfg = hex("A2 88 82 7D 3E 3E 44 86 05 05 05 08 E4 16");
        let Ok(Telegram::Data(telegram)) = Telegram::parse(&chk_cfg) else { panic!("an SD3") };
        assert_eq!((telegram.dsap, telegram.ssap, telegram.du), (Some(62), Some(62), &hex("44 86 05 05 05 08")[..]));
    }

    #[test]
    fn a_missing_extension_octet_is_an_error() {
        assert_eq!(Telegram::parse(&hex("10 88 02 49 D3 16")), Err(TelegramError::Extension));
        assert_eq!(Telegram::parse(&hex("68 04 04 68 88 82 6D 3C B3 16")), Err(TelegramError::Extension));
    }

    #[test]
    fn an_extension_of_one_address_only_is_kept() {
        let octets = hex("68 05 05 68 88 02 6D 3C 3E 71 16");
        let Ok(Telegram::Data(telegram)) = Telegram::parse(&octets) else { panic!("an SD2") };
        assert_eq!((telegram.dsap, telegram.ssap, telegram.du), (Some(0x3C), None, &[0x3E][..]));
    }

    #[test]
    fn each_error_is_named() {
        for (text, defect) in [
            ("00", TelegramError::Start(0)),
            ("", TelegramError::Length),
            ("10 08 02 49 53", TelegramError::Length),
            ("10 08 02 49 54 16", TelegramError::Checksum { expected: 0x53, received: 0x54 }),
            ("10 08 02 49 53 17", TelegramError::End(0x17)),
            ("68 05 06 68 88 82 6D 3C 3E F1 16", TelegramError::Length),
            ("68 02 02 68 88 82 0A 16", TelegramError::Length),
            ("68 FA FA 68 88 82 0A 16", TelegramError::Length),
            ("68 05 05 69 88 82 6D 3C 3E F1 16", TelegramError::Start(0x69)),
        ] {
            assert_eq!(Telegram::parse(&hex(text)), Err(defect), "{text}");
        }
    }

    #[test]
    fn the_length_is_known_from_the_earliest_possible_octet() {
        for (text, extent) in [
            ("", TelegramLength::Incomplete),
            ("10", TelegramLength::Known(6)),
            ("A2", TelegramLength::Known(14)),
            ("DC", TelegramLength::Known(3)),
            ("E5", TelegramLength::Known(1)),
            ("68", TelegramLength::Incomplete),
            ("68 05", TelegramLength::Incomplete),
            ("68 02", TelegramLength::Invalid(TelegramError::Length)),
            ("68 05 05", TelegramLength::Incomplete),
            ("68 05 04", TelegramLength::Invalid(TelegramError::Length)),
            ("68 F9 F9 68", TelegramLength::Known(255)),
            ("68 05 05 10", TelegramLength::Invalid(TelegramError::Start(0x10))),
            ("16", TelegramLength::Invalid(TelegramError::Start(0x16))),
        ] {
            assert_eq!(TelegramLength::of(&hex(text)), extent, "{text}");
        }
    }

    #[test]
    fn a_data_unit_that_is_too_long_is_not_emitted() {
        let du = [0; 245];
        let telegram = DataTelegram { du: &du, ..SLAVE_DIAG };
        assert_eq!(Telegram::Data(telegram).emit(&mut [0; 300]), Err(TooLong));
        let telegram = DataTelegram { du: &du[..MAX_DU], ..SLAVE_DIAG };
        assert_eq!(Telegram::Data(telegram).emit(&mut [0; MAX_TELEGRAM]), Ok(MAX_TELEGRAM));
    }
}
