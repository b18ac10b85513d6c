//! Requests and answers of Modbus: octets in, octets out. Sources: MODBUS Application Protocol 1.1b3 (app), MODBUS Messaging on
//! TCP/IP 1.0b (tcp).

use crate::image::Image;

/// The most registers of a request (app 6.3, 6.4).
const MOST_REGISTERS: u16 = 125;

/// The reason why a request is refused (app 7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exception {
    /// The function is not known, or writes.
    IllegalFunction = 1,
    /// A register is outside the map.
    IllegalAddress = 2,
    /// The count is 0 or above 125, or the request has another length.
    IllegalValue = 3,
    /// The station has no values yet, or gives none any more.
    DeviceFailure = 4,
}

impl Exception {
    /// A sentence for the state of the gateway.
    #[must_use]
    pub const fn reason(self) -> &'static str {
        match self {
            Self::IllegalFunction => "a request with a function other than 3, 4 and 43/14; the gateway only reads",
            Self::IllegalAddress => "a request for registers outside the map",
            Self::IllegalValue => "a request with a wrong count or length",
            Self::DeviceFailure => "a request while the station has no values",
        }
    }
}

/// What function 43/14 tells about the station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// The version of the program.
    pub version: String,
    /// The name of the station.
    pub station: String,
}

impl Identity {
    /// The objects with their numbers (app 6.21): the basic ones, then the regular ones.
    fn objects(&self) -> [(u8, &str); 6] {
        [
            (0, "profivac"),
            (1, "profivac station"),
            (2, &self.version),
            (4, "profivac: PROFIBUS vacuum gauges"),
            (5, "Modbus TCP gateway"),
            (6, &self.station),
        ]
    }
}

/// The answer to a request; with the exception if it is refused.
#[must_use]
pub fn answer(pdu: &[u8], image: Option<&Image>, identity: &Identity) -> (Vec<u8>, Option<Exception>) {
    let function = pdu.first().copied().unwrap_or_default();
    let answered = match pdu {
        [3 | 4, body @ ..] => read(function, body, image),
        [0x2B, 0x0E, body @ ..] => identify(body, identity),
        _ => Err(Exception::IllegalFunction),
    };
    answered.map_or_else(|refusal| (vec![function | 0x80, refusal as u8], Some(refusal)), |answer| (answer, None))
}

/// Functions 3 and 4: the same registers.
fn read(function: u8, body: &[u8], image: Option<&Image>) -> Result<Vec<u8>, Exception> {
    let &[a, b, c, d] = body else { return Err(Exception::IllegalValue) };
    let (first, count) = (u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d]));
    if !(1..=MOST_REGISTERS).contains(&count) {
        return Err(Exception::IllegalValue);
    }
    let registers = image.ok_or(Exception::DeviceFailure)?.read(first, count).ok_or(Exception::IllegalAddress)?;
    let octets = u8::try_from(count.saturating_mul(2)).map_err(|_| Exception::IllegalValue)?;
    Ok([function, octets].into_iter().chain(registers.iter().flat_map(|register| register.to_be_bytes())).collect())
}

/// Function 43/14, app 6.21: all basic objects (1), the basic and regular ones (2, 3), or a single one (4).
fn identify(body: &[u8], identity: &Identity) -> Result<Vec<u8>, Exception> {
    /// Regular identification, as a stream and one by one.
    const CONFORMITY: u8 = 0x82;
    let &[code, first] = body else { return Err(Exception::IllegalValue) };
    let objects = identity.objects();
    let last = match code {
        1 => 2,
        2..=4 => u8::MAX,
        _ => return Err(Exception::IllegalValue),
    };
    let offered = || objects.into_iter().filter(|(number, _)| *number <= last);
    let is_offered = offered().any(|(number, _)| number == first);
    let chosen: Vec<_> = match (code, is_offered) {
        (4, true) => offered().filter(|(number, _)| *number == first).collect(),
        (4, false) => return Err(Exception::IllegalAddress),
        (_, true) => offered().filter(|(number, _)| *number >= first).collect(),
        // An object that is not there counts as the first one.
        (_, false) => offered().collect(),
    };
    let mut answer = vec![0x2B, 0x0E, code, CONFORMITY, 0, 0, u8::try_from(chosen.len()).unwrap_or_default()];
    for (number, text) in chosen {
        // At most 64 octets each, so that all fit into one answer of 253 octets.
        let text: Vec<u8> = text.chars().take(64).map(ascii).collect();
        answer.extend([number, u8::try_from(text.len()).unwrap_or_default()]);
        answer.extend(text);
    }
    Ok(answer)
}

/// Objects are ASCII (app 6.21); `?` stands for other characters.
fn ascii(letter: char) -> u8 {
    u8::try_from(letter).ok().filter(|octet| matches!(octet, b' '..=b'~')).unwrap_or(b'?')
}

/// The head of a telegram on TCP (tcp 3.1.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head {
    /// The number that the answer repeats.
    pub transaction: u16,
    /// The number of octets of the PDU.
    pub length: usize,
    /// The unit identifier: any is accepted, and repeated.
    pub unit: u8,
}

impl Head {
    /// The octets of a head.
    pub const LENGTH: usize = 7;

    /// Parses a head; `None` if it is none of Modbus, or the PDU has no or more than 253 octets.
    #[must_use]
    pub fn parse(octets: [u8; Self::LENGTH]) -> Option<Self> {
        let [a, b, protocol_high, protocol_low, c, d, unit] = octets;
        let length = usize::from(u16::from_be_bytes([c, d])).checked_sub(1)?;
        let is_modbus = (protocol_high, protocol_low) == (0, 0) && (1..=253).contains(&length);
        is_modbus.then_some(Self { transaction: u16::from_be_bytes([a, b]), length, unit })
    }

    /// The telegram of an answer to the request with this head.
    #[must_use]
    pub fn telegram(self, pdu: &[u8]) -> Vec<u8> {
        let [a, b] = self.transaction.to_be_bytes();
        let [c, d] = u16::try_from(pdu.len().saturating_add(1)).unwrap_or_default().to_be_bytes();
        [a, b, 0, 0, c, d, self.unit].iter().chain(pdu).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity() -> Identity {
        Identity { version: "0.2.0".to_owned(), station: "ä".repeat(100) }
    }

    fn refusal(pdu: &[u8]) -> (Vec<u8>, Option<Exception>) {
        answer(pdu, None, &identity())
    }

    #[test]
    fn every_writing_and_unknown_function_is_illegal() {
        for function in (0..=255_u8).filter(|function| ![3, 4].contains(function)) {
            let (octets, exception) = refusal(&[function, 0, 0, 0, 1]);
            assert_eq!((octets, exception), (vec![function | 0x80, 1], Some(Exception::IllegalFunction)));
        }
        assert_eq!(refusal(&[0x2B, 0x0D, 1, 0]).0, [0xAB, 1]);
    }

    #[test]
    fn a_wrong_count_is_refused_before_the_address() {
        for count in [0_u16, 126, 2000, u16::MAX] {
            let [high, low] = count.to_be_bytes();
            assert_eq!(refusal(&[3, 0xFF, 0xFF, high, low]).1, Some(Exception::IllegalValue), "{count}");
        }
        assert_eq!(refusal(&[4, 0, 0, 1]).1, Some(Exception::IllegalValue), "too short");
        assert_eq!(refusal(&[4, 0, 0, 0, 1, 0]).1, Some(Exception::IllegalValue), "too long");
        assert_eq!(refusal(&[4, 0, 0, 0, 125]).1, Some(Exception::DeviceFailure), "no values yet");
    }

    #[test]
    fn the_identification_has_basic_and_regular_objects_and_fits_into_an_answer() {
        let (basic, _) = refusal(&[0x2B, 0x0E, 1, 0]);
        assert_eq!(basic.get(..7), Some([0x2B, 0x0E, 1, 0x82, 0, 0, 3].as_slice()));
        assert!(basic.windows(8).any(|octets| octets == b"profivac"));
        let (regular, _) = refusal(&[0x2B, 0x0E, 2, 0]);
        assert!(regular.len() <= 253 && regular.get(6) == Some(&6), "{regular:?}");
        assert_eq!(refusal(&[0x2B, 0x0E, 4, 2]).0.get(7..), Some([2, 5, b'0', b'.', b'2', b'.', b'0'].as_slice()));
        assert_eq!(refusal(&[0x2B, 0x0E, 4, 3]).1, Some(Exception::IllegalAddress));
        assert_eq!(refusal(&[0x2B, 0x0E, 2, 4]).0.get(6..8), Some([3, 4].as_slice()), "the rest of a stream");
        assert_eq!(refusal(&[0x2B, 0x0E, 2, 200]).0, regular.to_vec(), "from the beginning");
        assert_eq!(refusal(&[0x2B, 0x0E, 1, 4]).0, basic, "object 4 is not a basic one");
        assert_eq!(refusal(&[0x2B, 0x0E, 5, 0]).1, Some(Exception::IllegalValue));
    }

    #[test]
    fn a_head_of_another_protocol_or_length_is_refused() {
        let head = Head { transaction: 0x0102, length: 5, unit: 255 };
        assert_eq!(Head::parse([1, 2, 0, 0, 0, 6, 255]), Some(head));
        assert_eq!(head.telegram(&[3, 2, 0, 7]), [1, 2, 0, 0, 0, 5, 255, 3, 2, 0, 7]);
        for octets in
            [[0, 0, 0, 1, 0, 6, 1], [0, 0, 0, 0, 0, 1, 1], [0, 0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 0, 255, 1], *b"GET / H"]
        {
            assert_eq!(Head::parse(octets), None, "{octets:?}");
        }
    }
}
