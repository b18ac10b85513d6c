//! Recordings of other protocols with the same frames on the same wires: M-Bus and IEC 60870-5-101 (frames of IEC 60870-5-1, FT 1.2).

use profivac_explain::frame::{Piece, PieceKind};
use profivac_wire::Telegram;

/// C fields of the short frames of M-Bus: SND_NKE, REQ_UD1 and REQ_UD2 with their frame count bits (EN 13757-2).
const M_BUS_SHORT: [u8; 5] = [0x40, 0x5B, 0x7B, 0x5A, 0x7A];

/// Function codes of IEC 60870-5-2, of a primary and of a secondary station, unbalanced and balanced.
const IEC_PRIMARY: [u8; 9] = [0, 1, 2, 3, 4, 8, 9, 10, 11];
const IEC_SECONDARY: [u8; 7] = [0, 1, 8, 9, 11, 14, 15];
/// Bit of the control field: the primary station sends.
const PRIMARY: u8 = 0x40;

/// The most pieces of a recording, and texts left over beside them, that wait for a frame that decides. chosen: a request of PROFIBUS and its
/// answer follow each other, and a meter that is read each minute shows its first values soon.
pub const MOST_WAITING: usize = 8;

/// Examines the telegrams of a recording for another protocol.
#[derive(Debug, Default)]
pub struct OtherProtocol {
    /// Telegrams, SC and damaged pieces.
    pieces: usize,
    frames: u64,
    m_bus: u64,
    iec: u64,
    /// Destination and source of the last telegram.
    last: Option<(u8, u8)>,
    /// A slave answers a master, or an address has the extension of PROFIBUS: no other protocol does either.
    is_profibus: bool,
    /// There was a frame that shows more than an SD1 does.
    is_long: bool,
}

impl OtherProtocol {
    /// Examines the next piece.
    pub fn piece(&mut self, piece: &Piece) {
        self.pieces = self.pieces.saturating_add(1);
        match Telegram::parse(&piece.octets).ok().filter(|_| piece.kind != PieceKind::Damaged) {
            Some(Telegram::ShortAck) => {}
            Some(Telegram::Token { .. }) => self.is_profibus = true,
            Some(Telegram::Data(data)) => {
                self.is_profibus |= data.dsap.is_some() && data.ssap.is_some();
                self.is_profibus |= self.last == Some((data.sa, data.da)) && data.sa != data.da;
                self.last = Some((data.da, data.sa));
                match piece.octets.as_slice() {
                    // 68 L L 68 C A CI: the C field is where PROFIBUS has the destination.
                    [0x68, _, _, _, control, _, rest @ ..] => {
                        self.is_long = true;
                        self.long_frame(*control, rest);
                    }
                    // An address of two octets makes the short frame of IEC 60870-5-101 as long as SD1.
                    [0x10, control, ..] => self.frame(false, is_iec_control(*control)),
                    _ => self.frame(false, false),
                }
            }
            None => self.damaged(&piece.octets),
        }
    }

    /// Counts the short frames of five octets among damaged ones, `10 C A CS 16`: PROFIBUS has none.
    fn damaged(&mut self, octets: &[u8]) {
        let mut rest = octets;
        loop {
            rest = match rest {
                [] => return,
                [0x10, control, address, sum, 0x16, rest @ ..] if control.wrapping_add(*address) == *sum => {
                    self.is_long = true;
                    self.frame(M_BUS_SHORT.contains(control), is_iec_control(*control));
                    rest
                }
                [0xE5, rest @ ..] => rest,
                _ => {
                    self.frame(false, false);
                    return;
                }
            };
        }
    }

    fn long_frame(&mut self, control: u8, rest: &[u8]) {
        let (first, second) = (rest.first().copied().unwrap_or_default(), rest.get(1).copied().unwrap_or_default());
        let is_m_bus = match control {
            0x43 | 0x53 | 0x63 | 0x73 => matches!(first, 0x50..=0x5C | 0xB0..=0xBF),
            0x08 | 0x18 | 0x28 | 0x38 => matches!(first, 0x70..=0x7A),
            _ => false,
        };
        let is_type = |octet: u8| matches!(octet, 1..=45 | 58..=64 | 70 | 100..=107 | 110..=113);
        self.frame(is_m_bus, is_iec_control(control) && (is_type(first) || is_type(second)));
    }

    fn frame(&mut self, is_m_bus: bool, is_iec: bool) {
        self.frames = self.frames.saturating_add(1);
        self.m_bus = self.m_bus.saturating_add(u64::from(is_m_bus));
        self.iec = self.iec.saturating_add(u64::from(is_iec));
    }

    /// Whether the first pieces may still be of another protocol, so that the next ones decide.
    pub const fn is_open(&self) -> bool {
        let fits = self.m_bus == self.frames || self.iec == self.frames;
        !self.is_profibus && fits && self.pieces < MOST_WAITING
    }

    /// The protocols that every frame fits, if no dialogue of PROFIBUS does.
    pub fn names(&self) -> Option<&'static str> {
        if self.is_profibus || self.frames < 2 || !self.is_long {
            return None;
        }
        match (self.m_bus == self.frames, self.iec == self.frames) {
            (true, true) => Some("M-Bus or IEC 60870-5-101"),
            (true, false) => Some("M-Bus"),
            (false, true) => Some("IEC 60870-5-101"),
            (false, false) => None,
        }
    }
}

/// Whether a control field has a function of IEC 60870-5-2.
fn is_iec_control(control: u8) -> bool {
    let codes = if control & PRIMARY == 0 { &IEC_SECONDARY[..] } else { &IEC_PRIMARY };
    codes.contains(&(control & 0x0F))
}
