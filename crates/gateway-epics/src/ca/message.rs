//! Messages of Channel Access: 16 octets of header, big-endian, then the payload, a multiple of 8 octets.

use crate::connection::{Broken, MAX_MESSAGE};

/// The minor version of the protocol: searches and echoes over TCP, large arrays.
pub const MINOR_VERSION: u16 = 13;

/// The octets of a header.
pub const HEADER: usize = 16;

/// Commands.
pub mod command {
    /// The version of the protocol, as both sides begin.
    pub const VERSION: u16 = 0;
    /// A new monitor, and its values.
    pub const EVENT_ADD: u16 = 1;
    /// The end of a monitor.
    pub const EVENT_CANCEL: u16 = 2;
    /// A value is read, by old clients.
    pub const READ: u16 = 3;
    /// A value is written without an answer.
    pub const WRITE: u16 = 4;
    /// A name is searched.
    pub const SEARCH: u16 = 6;
    /// The client wants no values for now.
    pub const EVENTS_OFF: u16 = 8;
    /// The client wants values again.
    pub const EVENTS_ON: u16 = 9;
    /// Everything up to here has been handled.
    pub const READ_SYNC: u16 = 10;
    /// A request failed.
    pub const ERROR: u16 = 11;
    /// A channel ends.
    pub const CLEAR_CHANNEL: u16 = 12;
    /// A server has started or is still there.
    pub const BEACON: u16 = 13;
    /// A searched name is not here.
    pub const NOT_FOUND: u16 = 14;
    /// A value is read.
    pub const READ_NOTIFY: u16 = 15;
    /// A channel begins.
    pub const CREATE_CHANNEL: u16 = 18;
    /// A value is written with an answer.
    pub const WRITE_NOTIFY: u16 = 19;
    /// The name of the user, as the client gives it.
    pub const CLIENT_NAME: u16 = 20;
    /// The name of the computer, as the client gives it.
    pub const HOST_NAME: u16 = 21;
    /// What the client may do with a channel.
    pub const ACCESS_RIGHTS: u16 = 22;
    /// Is the other side there?
    pub const ECHO: u16 = 23;
    /// A channel cannot begin.
    pub const CREATE_CHANNEL_FAILED: u16 = 26;
}

/// Codes of success and failure (caerr.h of EPICS base): number times eight plus severity.
pub mod status {
    /// `ECA_NORMAL`.
    pub const NORMAL: u32 = 1;
    /// `ECA_ALLOCMEM`: no room.
    pub const NO_ROOM: u32 = 6 << 3;
    /// `ECA_BADTYPE`.
    pub const BAD_TYPE: u32 = (14 << 3) | 2;
    /// `ECA_GETFAIL`.
    pub const GET_FAILED: u32 = 19 << 3;
    /// `ECA_PUTFAIL`: the value was not written.
    pub const PUT_FAILED: u32 = 20 << 3;
    /// `ECA_BADCOUNT`.
    pub const BAD_COUNT: u32 = 22 << 3;
    /// `ECA_NOWTACCESS`: no right to write.
    pub const NO_WRITE_ACCESS: u32 = 47 << 3;
    /// `ECA_NOCONVERT`.
    pub const NO_CONVERSION: u32 = 49 << 3;
    /// `ECA_BADCHID`: no such channel.
    pub const BAD_CHANNEL: u32 = (51 << 3) | 2;
}

/// The right to read, without that to write.
pub const READ_ONLY: u32 = 1;

/// The rights to read and to write.
pub const READ_WRITE: u32 = 3;

/// A header.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// The command.
    pub command: u16,
    /// The octets of the payload.
    pub payload: u32,
    /// The type of the values.
    pub data_type: u16,
    /// Their number.
    pub count: u32,
    /// The first parameter.
    pub first: u32,
    /// The second parameter.
    pub second: u32,
}

/// A message of a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Message<'a> {
    /// Its header.
    pub header: Header,
    /// Its payload with the padding.
    pub payload: &'a [u8],
    /// The octets of the whole message.
    pub used: usize,
}

/// The message at the beginning of `input`, or nothing if it is not complete.
///
/// # Errors
/// The message is too large.
pub fn parse(input: &[u8]) -> Result<Option<Message<'_>>, Broken> {
    let Some([c0, c1, p0, p1, t0, t1, n0, n1, a0, a1, a2, a3, b0, b1, b2, b3]) = input.first_chunk::<HEADER>() else {
        return Ok(None);
    };
    let half = |high: &u8, low: &u8| u16::from_be_bytes([*high, *low]);
    let mut header = Header {
        command: half(c0, c1),
        payload: half(p0, p1).into(),
        data_type: half(t0, t1),
        count: half(n0, n1).into(),
        first: u32::from_be_bytes([*a0, *a1, *a2, *a3]),
        second: u32::from_be_bytes([*b0, *b1, *b2, *b3]),
    };
    let mut begin = HEADER;
    // The long form has size and count as 32 bits behind the header.
    if header.payload == 0xFFFF && header.count == 0 {
        let Some([a, b, c, d, e, f, g, h]) = input.get(HEADER..).and_then(|rest| rest.first_chunk()) else {
            return Ok(None);
        };
        header.payload = u32::from_be_bytes([*a, *b, *c, *d]);
        header.count = u32::from_be_bytes([*e, *f, *g, *h]);
        begin = begin.saturating_add(8);
    }
    let size = usize::try_from(header.payload).unwrap_or(usize::MAX);
    let used = begin.saturating_add(size);
    if used > MAX_MESSAGE {
        return Err(Broken::TooLarge(header.payload.into()));
    }
    Ok(input.get(begin..used).map(|payload| Message { header, payload, used }))
}

/// Writes a message. The payload is padded to a multiple of eight octets; all payloads of this server are below 64 KiB.
pub fn put(out: &mut Vec<u8>, header: Header, payload: &[u8]) {
    let padded = payload.len().next_multiple_of(8);
    out.extend(header.command.to_be_bytes());
    out.extend(u16::try_from(padded).unwrap_or(u16::MAX).to_be_bytes());
    out.extend(header.data_type.to_be_bytes());
    out.extend(u16::try_from(header.count).unwrap_or(u16::MAX).to_be_bytes());
    out.extend(header.first.to_be_bytes());
    out.extend(header.second.to_be_bytes());
    out.extend(payload);
    out.resize(out.len().saturating_add(padded.saturating_sub(payload.len())), 0);
}

/// A message without payload.
pub fn put_empty(out: &mut Vec<u8>, command: u16, data_type: u16, count: u32, first: u32, second: u32) {
    put(out, Header { command, payload: 0, data_type, count, first, second }, &[]);
}

/// The text of a payload up to its end mark.
#[must_use]
pub fn text(payload: &[u8]) -> &str {
    let end = payload.iter().position(|octet| *octet == 0).unwrap_or(payload.len());
    std::str::from_utf8(payload.get(..end).unwrap_or_default()).unwrap_or_default()
}
