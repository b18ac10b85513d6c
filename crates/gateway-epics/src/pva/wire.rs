//! Numbers, texts, sizes and messages as octets. This server writes little-endian and reads both.

use crate::connection::{Broken, MAX_MESSAGE};

/// The first octet of a message, and the version of the protocol.
const MAGIC: u8 = 0xCA;
const VERSION: u8 = 2;

/// The octets of a header.
pub const HEADER: usize = 8;

/// Flags of a header.
mod flag {
    pub const CONTROL: u8 = 0x01;
    pub const SEGMENTED: u8 = 0x30;
    pub const FROM_SERVER: u8 = 0x40;
    pub const BIG_ENDIAN: u8 = 0x80;
}

/// Commands of application messages.
pub mod command {
    /// A server has started or is still there.
    pub const BEACON: u8 = 0;
    /// The server offers, and the client selects, a way to tell who it is.
    pub const CONNECTION_VALIDATION: u8 = 1;
    /// Is the other side there?
    pub const ECHO: u8 = 2;
    /// Names are searched.
    pub const SEARCH: u8 = 3;
    /// The answer to a search.
    pub const SEARCH_RESPONSE: u8 = 4;
    /// Further messages about who the client is.
    pub const AUTHENTICATION: u8 = 5;
    /// Channels begin.
    pub const CREATE_CHANNEL: u8 = 7;
    /// A channel ends.
    pub const DESTROY_CHANNEL: u8 = 8;
    /// The client may begin.
    pub const CONNECTION_VALIDATED: u8 = 9;
    /// A value is read.
    pub const GET: u8 = 10;
    /// A value is written.
    pub const PUT: u8 = 11;
    /// A value is written and read.
    pub const PUT_GET: u8 = 12;
    /// A value is monitored.
    pub const MONITOR: u8 = 13;
    /// An array is read or written in parts.
    pub const ARRAY: u8 = 14;
    /// A request ends.
    pub const DESTROY_REQUEST: u8 = 15;
    /// A record is processed.
    pub const PROCESS: u8 = 16;
    /// The type of a channel is asked for.
    pub const GET_FIELD: u8 = 17;
    /// A text for the log.
    pub const MESSAGE: u8 = 18;
    /// A function is called.
    pub const RPC: u8 = 20;
    /// A request is interrupted.
    pub const CANCEL_REQUEST: u8 = 21;
    /// Where a multicast search comes from.
    pub const ORIGIN_TAG: u8 = 22;
}

/// The control message that sets the order of octets.
const SET_BYTE_ORDER: u8 = 2;

/// The size that stands for "none".
const NO_SIZE: u8 = 0xFF;

/// The size that stands for "32 bits follow".
const LONG_SIZE: u8 = 0xFE;

/// An application message.
#[derive(Clone, Copy, Debug)]
pub struct Message<'a> {
    /// The command; `None` for a control message, which has no payload.
    pub command: Option<u8>,
    /// The payload.
    pub payload: Reader<'a>,
    /// The octets of the whole message.
    pub used: usize,
}

/// The message at the beginning of `input`, or nothing if it is not complete.
///
/// # Errors
/// The octets are no message, or it is too large.
pub fn parse(input: &[u8]) -> Result<Option<Message<'_>>, Broken> {
    let Some([magic, _, flags, command, size @ ..]) = input.first_chunk::<HEADER>() else {
        return match input.first() {
            Some(first) if *first != MAGIC => Err(Broken::Malformed("the first octet is not CA")),
            _ => Ok(None),
        };
    };
    if *magic != MAGIC {
        return Err(Broken::Malformed("the first octet is not CA"));
    }
    if flags & flag::SEGMENTED != 0 {
        return Err(Broken::Malformed("a message in segments, which no request needs"));
    }
    let is_big_endian = flags & flag::BIG_ENDIAN != 0;
    if flags & flag::CONTROL != 0 {
        // The last four octets of a control message are its data.
        return Ok(Some(Message { command: None, payload: Reader { octets: &[], is_big_endian }, used: HEADER }));
    }
    let size = if is_big_endian { u32::from_be_bytes(*size) } else { u32::from_le_bytes(*size) };
    let end = usize::try_from(size).unwrap_or(usize::MAX).saturating_add(HEADER);
    if end > MAX_MESSAGE {
        return Err(Broken::TooLarge(size.into()));
    }
    let payload = |octets| Reader { octets, is_big_endian };
    Ok(input.get(HEADER..end).map(|octets| Message { command: Some(*command), payload: payload(octets), used: end }))
}

/// Octets that are read from the front.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a> {
    octets: &'a [u8],
    is_big_endian: bool,
}

/// A field reaches beyond the end of its message, or has a form that does not exist.
const TOO_SHORT: Broken = Broken::Malformed("a field beyond the end of its message");

impl<'a> Reader<'a> {
    /// The next `count` octets.
    ///
    /// # Errors
    /// There are fewer.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Broken> {
        let (taken, rest) = self.octets.split_at_checked(count).ok_or(TOO_SHORT)?;
        self.octets = rest;
        Ok(taken)
    }

    /// The octets that are left.
    #[must_use]
    pub const fn rest(&self) -> &'a [u8] {
        self.octets
    }

    /// The order of octets.
    #[must_use]
    pub const fn is_big_endian(&self) -> bool {
        self.is_big_endian
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Broken> {
        let taken = self.take(N)?;
        taken.first_chunk().copied().ok_or(TOO_SHORT)
    }

    /// One octet.
    ///
    /// # Errors
    /// There is none.
    pub fn octet(&mut self) -> Result<u8, Broken> {
        self.array::<1>().map(|[octet]| octet)
    }

    /// 16 bits.
    ///
    /// # Errors
    /// There are fewer.
    pub fn half(&mut self) -> Result<u16, Broken> {
        let octets = self.array()?;
        Ok(if self.is_big_endian { u16::from_be_bytes(octets) } else { u16::from_le_bytes(octets) })
    }

    /// 32 bits.
    ///
    /// # Errors
    /// There are fewer.
    pub fn word(&mut self) -> Result<u32, Broken> {
        let octets = self.array()?;
        Ok(if self.is_big_endian { u32::from_be_bytes(octets) } else { u32::from_le_bytes(octets) })
    }

    /// A floating-point number.
    ///
    /// # Errors
    /// There are fewer than 64 bits.
    pub fn double(&mut self) -> Result<f64, Broken> {
        let octets = self.array()?;
        Ok(if self.is_big_endian { f64::from_be_bytes(octets) } else { f64::from_le_bytes(octets) })
    }

    /// A whole number of 64 bits, as a floating-point number.
    ///
    /// # Errors
    /// There are fewer.
    #[expect(clippy::cast_precision_loss, reason = "numbers of the station have fewer than 53 bits")]
    pub fn long(&mut self) -> Result<f64, Broken> {
        let octets = self.array()?;
        Ok(if self.is_big_endian { i64::from_be_bytes(octets) } else { i64::from_le_bytes(octets) } as f64)
    }

    /// A size; 0 where there is none.
    ///
    /// # Errors
    /// It is not complete.
    pub fn size(&mut self) -> Result<usize, Broken> {
        match self.octet()? {
            NO_SIZE => Ok(0),
            LONG_SIZE => Ok(usize::try_from(self.word()?).unwrap_or(usize::MAX)),
            short => Ok(short.into()),
        }
    }

    /// A text.
    ///
    /// # Errors
    /// It is not complete, or not UTF-8.
    pub fn text(&mut self) -> Result<&'a str, Broken> {
        let size = self.size()?;
        std::str::from_utf8(self.take(size)?).map_err(|_| Broken::Malformed("a text that is not UTF-8"))
    }
}

/// Writes the octets of messages.
#[derive(Debug, Default)]
pub struct Writer(pub Vec<u8>);

impl Writer {
    /// One octet.
    pub fn octet(&mut self, octet: u8) {
        self.0.push(octet);
    }

    /// 16 bits.
    pub fn half(&mut self, half: u16) {
        self.0.extend(half.to_le_bytes());
    }

    /// 32 bits.
    pub fn word(&mut self, word: u32) {
        self.0.extend(word.to_le_bytes());
    }

    /// A whole number of 32 bits.
    pub fn int(&mut self, number: i32) {
        self.0.extend(number.to_le_bytes());
    }

    /// A whole number of 64 bits.
    pub fn long(&mut self, number: i64) {
        self.0.extend(number.to_le_bytes());
    }

    /// A floating-point number.
    pub fn double(&mut self, number: f64) {
        self.0.extend(number.to_le_bytes());
    }

    /// A size.
    pub fn size(&mut self, size: usize) {
        match u8::try_from(size) {
            Ok(short) if short < LONG_SIZE => self.octet(short),
            _ => {
                self.octet(LONG_SIZE);
                self.word(u32::try_from(size).unwrap_or(u32::MAX));
            }
        }
    }

    /// A text.
    pub fn text(&mut self, text: &str) {
        self.size(text.len());
        self.0.extend(text.as_bytes());
    }

    /// The set of these numbered fields, below 64.
    pub fn bits(&mut self, fields: &[u8]) {
        let bits = fields.iter().fold(0_u64, |bits, field| bits | 1_u64.wrapping_shl((*field).into()));
        let octets = bits.to_le_bytes();
        let used = octets.iter().rposition(|octet| *octet != 0).map_or(0, |last| last.saturating_add(1));
        self.size(used);
        self.0.extend(octets.iter().take(used));
    }

    /// Success.
    pub fn ok(&mut self) {
        self.octet(0xFF);
    }

    /// A failure with its reason.
    pub fn error(&mut self, reason: &str) {
        // The type ERROR, the reason, and no call tree.
        self.octet(2);
        self.text(reason);
        self.text("");
    }
}

/// Appends a message of the server with this payload.
pub fn put(out: &mut Vec<u8>, command: u8, payload: &Writer) {
    out.extend([MAGIC, VERSION, flag::FROM_SERVER, command]);
    out.extend(u32::try_from(payload.0.len()).unwrap_or(u32::MAX).to_le_bytes());
    out.extend(&payload.0);
}

/// Appends the message that sets the order of octets to little-endian.
pub fn put_byte_order(out: &mut Vec<u8>) {
    out.extend([MAGIC, VERSION, flag::FROM_SERVER | flag::CONTROL, SET_BYTE_ORDER, 0, 0, 0, 0]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_has_one_octet_or_five() {
        for size in [0, 1, 253, 254, 255, 70_000] {
            let mut writer = Writer::default();
            writer.size(size);
            assert_eq!(writer.0.len(), if size < 254 { 1 } else { 5 });
            let mut reader = Reader { octets: &writer.0, is_big_endian: false };
            assert_eq!((reader.size(), reader.rest().len()), (Ok(size), 0));
        }
    }

    #[test]
    fn a_set_has_the_octets_up_to_its_last_bit() {
        let of = |fields: &[u8]| {
            let mut writer = Writer::default();
            writer.bits(fields);
            writer.0
        };
        assert_eq!((of(&[]), of(&[0]), of(&[1, 2, 9])), (vec![0], vec![1, 1], vec![2, 6, 2]));
    }

    #[test]
    fn a_message_that_is_none_or_too_large_or_in_segments_breaks_the_connection() {
        assert!(parse(b"GET / HTTP/1.1").is_err() && parse(b"G").is_err());
        assert!(matches!(parse(&[0xCA, 2, 0, 3, 0xFF, 0xFF, 0xFF, 0x7F]), Err(Broken::TooLarge(_))));
        assert!(parse(&[0xCA, 2, 0x10, 3, 0, 0, 0, 0]).is_err());
        assert!(parse(&[0xCA, 2, 0, 3, 1, 0, 0, 0]).unwrap().is_none());
        assert_eq!(parse(&[0xCA, 2, 0x80, 3, 0, 0, 0, 1, 7]).unwrap().unwrap().used, 9);
    }

    #[test]
    fn a_field_beyond_the_end_is_an_error() {
        let reader = Reader { octets: &[5, b'a'], is_big_endian: false };
        assert_eq!({ reader }.text(), Err(TOO_SHORT));
        assert_eq!({ reader }.word(), Err(TOO_SHORT));
        assert_eq!(
            Reader { octets: &[1, 0xFF], is_big_endian: false }.text(),
            Err(Broken::Malformed("a text that is not UTF-8"))
        );
    }
}
