//! Telegrams, octet by octet, and the receiver. profibus-wire 1.2 to 1.7.

/// Idle time before a telegram after an error, and the longest gap inside one, in bit times.
const T_SYN: u64 = 33;
/// One character.
const CHARACTER: u64 = 11;

/// The sum of the octets. profibus-wire 1.6.
fn fcs(octets: &[u8]) -> u8 {
    octets.iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet))
}

/// Adds delimiters and FCS to the octets from DA to the last one of the data unit.
fn variable(body: &[u8]) -> Vec<u8> {
    let length = u8::try_from(body.len()).expect("a telegram has 249 octets at most");
    let mut octets = vec![0x68, length, length, 0x68];
    octets.extend(body);
    octets.extend([fcs(body), 0x16]);
    octets
}

/// A telegram without data: SD1.
pub fn sd1(da: u8, sa: u8, fc: u8) -> Vec<u8> {
    vec![0x10, da, sa, fc, fcs(&[da, sa, fc]), 0x16]
}

/// A telegram with data: SD2.
pub fn sd2(da: u8, sa: u8, fc: u8, data: &[u8]) -> Vec<u8> {
    variable(&[&[da, sa, fc], data].concat())
}

/// A telegram with eight octets of data: SD3.
pub fn sd3(da: u8, sa: u8, fc: u8, data: &[u8]) -> Vec<u8> {
    let body = [&[da, sa, fc], data].concat();
    [&[0xA2], body.as_slice(), &[fcs(&body), 0x16]].concat()
}

/// A telegram with both service access points.
pub fn with_saps(da: u8, sa: u8, fc: u8, dsap: u8, ssap: u8, du: &[u8]) -> Vec<u8> {
    sd2(da | 0x80, sa | 0x80, fc, &[&[dsap, ssap], du].concat())
}

/// A telegram with FC.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Destination with EXT.
    pub da: u8,
    /// Source with EXT.
    pub sa: u8,
    /// Function code.
    pub fc: u8,
    /// All octets behind FC.
    pub data: Vec<u8>,
}

/// The receiver of section 1.7.
#[derive(Clone, Debug)]
pub struct Receiver {
    octets: Vec<u8>,
    hunting: bool,
    last_end: u64,
}

impl Receiver {
    /// The line is idle from bit time 0.
    pub const fn new() -> Self {
        Self { octets: Vec::new(), hunting: true, last_end: 0 }
    }

    /// A character ended at `end`; returns a telegram with FC that it completes.
    pub fn character(&mut self, end: u64, octet: u8) -> Option<Frame> {
        let gap = (end - CHARACTER).saturating_sub(self.last_end);
        self.last_end = end;
        if !self.octets.is_empty() && gap > T_SYN {
            self.octets.clear();
            self.hunting = true;
        }
        if self.hunting && gap < T_SYN {
            return None;
        }
        self.hunting = false;
        self.octets.push(octet);
        let wanted = match self.octets.as_slice() {
            [0x10, ..] => 6,
            [0xA2, ..] => 14,
            [0xDC, ..] => 3,
            [0xE5, ..] => 1,
            [0x68] | [0x68, _] | [0x68, _, _] => return None,
            [0x68, le, ler, second, ..] if le == ler && *second == 0x68 && (3..=249).contains(le) => {
                usize::from(*le) + 6
            }
            _ => return self.damaged(),
        };
        if self.octets.len() < wanted {
            return None;
        }
        let octets = std::mem::take(&mut self.octets);
        let body = match octets[0] {
            0x10 | 0xA2 => &octets[1..octets.len() - 2],
            0x68 => &octets[4..octets.len() - 2],
            _ => return None,
        };
        let [check, end] = octets[octets.len() - 2..] else { unreachable!() };
        if check != fcs(body) || end != 0x16 {
            return self.damaged();
        }
        Some(Frame { da: body[0], sa: body[1], fc: body[2], data: body[3..].to_vec() })
    }

    /// Waits for an idle line.
    fn damaged(&mut self) -> Option<Frame> {
        self.octets.clear();
        self.hunting = true;
        None
    }
}
