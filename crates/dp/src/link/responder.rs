//! The passive half of a station: which requests are ours, and which are repetitions. profibus-wire 1.8, 1.9 and 1.11.
//!
//! There is one frame count memory per station, whatever the service: it holds the last counted requester, its FCB and the
//! whole answer. A repeated request gets that answer again and is not executed twice.

use super::Transmit;
use super::time::BitTime;
use profivac_wire::control::{Control, FrameCount, Function, Status};
use profivac_wire::{BROADCAST, DataTelegram, MAX_DU, MAX_TELEGRAM, Sap, Telegram};

/// The requester that no station is: nobody has asked yet.
const NO_STATION: u8 = 0xFF;

/// FC of the counted request that data exchange consists of.
const SRD_HIGH: u8 = srd_high(false);
/// The same with FCB.
const SRD_HIGH_FCB: u8 = srd_high(true);

const fn srd_high(fcb: bool) -> u8 {
    Control::Request { function: Function::SrdHigh, count: FrameCount::Counted(fcb) }.to_octet()
}

/// A request for the layer above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Indication<'a> {
    /// Who asks.
    pub sa: u8,
    /// Which service.
    pub sap: Sap,
    /// The access point of the requester, where the request came with one.
    pub ssap: Option<u8>,
    /// The data unit.
    pub du: &'a [u8],
}

/// What the layer above answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reply {
    /// SC: taken, nothing to return.
    ShortAck,
    /// A telegram without data.
    Status(Status),
    /// So many octets of the data unit the responder lent, low priority.
    Low(usize),
    /// As [`Low`](Self::Low), but a diagnosis is pending.
    High(usize),
}

/// What the link layer makes of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accepted<'a> {
    /// Not for us, or not to be answered.
    Ignored,
    /// An SDN: to be executed, never answered.
    Unconfirmed(Indication<'a>),
    /// The counted request of before: the same answer again.
    Repetition,
    /// A request that the link layer answers by itself.
    LinkLayer(Status),
    /// Request identification with reply.
    Ident,
    /// To be executed and answered.
    Confirmed(Indication<'a>),
}

/// Address match, frame count memory and the answer that may have to be repeated.
#[derive(Clone, Debug)]
pub struct Responder {
    address: u8,
    /// The last counted requester and its FCB.
    requester: u8,
    fcb: bool,
    /// The request accepted last counts: its answer is to be stored.
    is_counted: bool,
    /// The answer to it; nothing stored while 0.
    length: usize,
    answer: [u8; MAX_TELEGRAM],
    /// Answers to requests that do not count.
    uncounted: [u8; MAX_TELEGRAM],
}

impl Responder {
    /// A station with `address` that nobody has spoken to.
    #[must_use]
    pub const fn new(address: u8) -> Self {
        Self {
            address,
            requester: NO_STATION,
            fcb: false,
            is_counted: false,
            length: 0,
            answer: [0; MAX_TELEGRAM],
            uncounted: [0; MAX_TELEGRAM],
        }
    }

    /// The station address.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// Takes another address and forgets every requester.
    pub const fn set_address(&mut self, address: u8) {
        self.address = address;
        self.requester = NO_STATION;
        self.length = 0;
    }

    /// Deletes the answer that a repetition would get, as a station may whenever it hears a telegram that is not for it. This
    /// one does not do so by itself; a master must get along with both kinds.
    pub const fn forget_answer(&mut self) {
        self.length = 0;
    }

    /// Decides what a frame is for this station and, if it is a new counted request, remembers it.
    #[inline]
    pub fn accept<'a>(&mut self, frame: &DataTelegram<'a>) -> Accepted<'a> {
        if self.is_next(frame) {
            self.remember(frame.sa, !self.fcb);
            return Accepted::Confirmed(indication(frame));
        }
        self.accept_any(frame)
    }

    /// Whether the station that was accepted last goes on with another request to this one, as in every data exchange.
    /// Then nothing is left of what [`judge`](Self::judge) asks.
    #[inline]
    fn is_next(&self, frame: &DataTelegram<'_>) -> bool {
        let fc = if self.fcb { SRD_HIGH } else { SRD_HIGH_FCB };
        frame.fc == fc && frame.sa == self.requester && frame.da == self.address
    }

    /// Any frame. profibus-wire 1.8.
    fn accept_any<'a>(&mut self, frame: &DataTelegram<'a>) -> Accepted<'a> {
        let Control::Request { function, count } = frame.control() else { return Accepted::Ignored };
        self.is_counted = false;
        if frame.sa == self.address || frame.sa == BROADCAST {
            return Accepted::Ignored;
        }
        if frame.da != self.address {
            return match function {
                Function::SdnLow | Function::SdnHigh if frame.da == BROADCAST => {
                    Accepted::Unconfirmed(indication(frame))
                }
                _ => Accepted::Ignored,
            };
        }
        match function {
            Function::SrdLow | Function::SrdHigh => self.counted(frame, count, Accepted::Confirmed(indication(frame))),
            Function::SdaLow | Function::SdaHigh => {
                self.counted(frame, count, Accepted::LinkLayer(Status::ServiceNotActivated))
            }
            Function::SdnLow | Function::SdnHigh => Accepted::Unconfirmed(indication(frame)),
            Function::FdlStatus => Accepted::LinkLayer(Status::Ok),
            Function::Ident => Accepted::Ident,
            // profibus-wire 10, point 2: the service is withdrawn.
            Function::LsapStatus => Accepted::LinkLayer(Status::ServiceNotActivated),
            // profibus-wire 10, point 4
            Function::Other(_) => Accepted::Ignored,
        }
    }

    /// The table of profibus-wire 1.9.
    fn counted<'a>(&mut self, frame: &DataTelegram<'_>, count: FrameCount, new: Accepted<'a>) -> Accepted<'a> {
        match count {
            FrameCount::Uncounted => return new,
            FrameCount::Counted(fcb) if frame.sa == self.requester && fcb == self.fcb && self.length > 0 => {
                return Accepted::Repetition;
            }
            FrameCount::First => self.remember(frame.sa, true),
            FrameCount::Counted(fcb) => self.remember(frame.sa, fcb),
        }
        new
    }

    /// A new counted request: its answer will be stored.
    #[inline]
    const fn remember(&mut self, requester: u8, fcb: bool) {
        self.requester = requester;
        self.fcb = fcb;
        self.length = 0;
        self.is_counted = true;
    }

    /// The stored answer once more, for a request that ended at `end`.
    #[must_use]
    pub fn repeat(&self, not_before: BitTime) -> Transmit<'_> {
        Transmit { not_before, octets: self.answer.get(..self.length).unwrap_or_default() }
    }

    /// Makes the answer to the frame accepted last, and stores it if the request counts. `du` holds the data the reply
    /// speaks of.
    #[inline]
    pub fn answer(
        &mut self,
        frame: &DataTelegram<'_>,
        reply: Reply,
        du: &[u8],
        not_before: BitTime,
    ) -> Option<Transmit<'_>> {
        let telegram = respond(frame, self.address, reply, du);
        let place = if self.is_counted { &mut self.answer } else { &mut self.uncounted };
        let length = telegram.emit(place).ok()?;
        if self.is_counted {
            self.length = length;
        }
        Some(Transmit { not_before, octets: place.get(..length)? })
    }
}

/// A response swaps everything: addresses and access points. SD1 and SC carry none of the latter.
#[inline]
fn respond<'a>(frame: &DataTelegram<'_>, address: u8, reply: Reply, du: &'a [u8]) -> Telegram<'a> {
    let (status, length) = match reply {
        Reply::ShortAck => return Telegram::ShortAck,
        Reply::Status(status) => return Telegram::Data(DataTelegram::short(frame.sa, address, Control::slave(status))),
        Reply::Low(length) => (Status::DataLow, length),
        Reply::High(length) => (Status::DataHigh, length),
    };
    Telegram::Data(DataTelegram {
        da: frame.sa,
        sa: address,
        dsap: frame.ssap,
        ssap: frame.dsap,
        fc: Control::slave(status).to_octet(),
        du: du.get(..length.min(MAX_DU)).unwrap_or_default(),
    })
}

/// DP uses both extensions or none; one alone, or one that is no access point, addresses nothing. profibus-wire 1.3.
#[inline]
fn indication<'a>(frame: &DataTelegram<'a>) -> Indication<'a> {
    let sap = match (frame.dsap, frame.ssap) {
        (None, None) => Sap::Default,
        (Some(dsap), Some(0..=62)) => Sap::from_octet(Some(dsap)),
        (dsap, _) => Sap::Other(dsap.unwrap_or(NO_STATION)),
    };
    Indication { sa: frame.sa, sap, ssap: frame.ssap, du: frame.du }
}
