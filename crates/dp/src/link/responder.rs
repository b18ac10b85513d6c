//! The passive half of a station: which requests it accepts, and which are repetitions. profibus-wire 1.8, 1.9 and 1.11.
//!
//! A station has one frame count memory for all services: the last counted requester, its FCB and the whole answer. A
//! repeated request gets that answer again and is not executed twice.

use super::Transmit;
use super::time::BitTime;
use profivac_wire::control::{Control, FrameCount, Function, Status};
use profivac_wire::{BROADCAST, DataTelegram, MAX_TELEGRAM, Sap, Telegram, emit_sd2_with};

/// The requester before the first request; no station has this address.
const NO_STATION: u8 = 0xFF;

/// The highest source access point of a DP service.
const MAX_SSAP: u8 = 62;

/// FC of the counted request of data exchange.
const SRD_HIGH: u8 = srd_high(false);
/// The same with FCB.
const SRD_HIGH_FCB: u8 = srd_high(true);

/// FC of an answer with data, without and with a pending diagnosis.
const DATA_LOW: u8 = Control::slave(Status::DataLow).to_octet();
const DATA_HIGH: u8 = Control::slave(Status::DataHigh).to_octet();

const fn srd_high(fcb: bool) -> u8 {
    Control::Request { function: Function::SrdHigh, count: FrameCount::Counted(fcb) }.to_octet()
}

/// A request for the layer above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Indication<'a> {
    /// The address of the requester.
    pub sa: u8,
    /// The service.
    pub sap: Sap,
    /// The access point of the requester, if the request has one.
    pub ssap: Option<u8>,
    /// The data unit.
    pub du: &'a [u8],
}

/// The answer of the layer above, with its data unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reply<'a> {
    /// SC: accepted, without data.
    ShortAck,
    /// A telegram without data.
    Status(Status),
    /// Data with low priority.
    Low(&'a [u8]),
    /// As [`Low`](Self::Low), but a diagnosis is pending.
    High(&'a [u8]),
}

/// The decision of the link layer about a telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Accepted<'a> {
    /// Not for this station, or not to be answered.
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

/// Address filter, frame count memory and the stored answer.
///
/// ```
/// use profivac_dp::link::{Accepted, BitTime, Reply, Responder};
/// use profivac_wire::Telegram;
///
/// let mut responder = Responder::new(8);
/// // Master 2 exchanges data with station 8 for the first time: outputs 00 00.
/// let request = [0x68, 5, 5, 0x68, 8, 2, 0x5D, 0, 0, 0x67, 0x16];
/// let Ok(Telegram::Data(request)) = Telegram::parse(&request) else { unreachable!() };
/// assert!(matches!(responder.accept(&request), Accepted::Confirmed(indication) if indication.du == [0, 0]));
/// let answer = responder.answer(&request, Reply::Low(&[1, 2]), BitTime(11)).map(|answer| answer.octets.to_vec());
///
/// // The answer was lost, and the master repeats the request.
/// assert_eq!(responder.accept(&request), Accepted::Repetition);
/// assert_eq!(responder.repeat(BitTime(400)).map(|repeated| repeated.octets.to_vec()), answer);
/// ```
#[derive(Clone, Debug)]
pub struct Responder {
    address: u8,
    /// The last counted requester and its FCB.
    requester: u8,
    fcb: bool,
    /// The request accepted last is counted: its answer is stored.
    is_counted: bool,
    /// The length of the stored answer; 0 if none is stored.
    length: usize,
    /// The length of the answer that is prepared for the next request; 0 if none is.
    prepared: u8,
    buffers: Buffers,
}

/// Two buffers for answers: one for the stored answer, the other for one that is not stored, or not yet.
#[derive(Clone, Debug)]
struct Buffers {
    first: [u8; MAX_TELEGRAM],
    second: [u8; MAX_TELEGRAM],
    /// The stored answer is in the second buffer.
    stored_in_second: bool,
}

impl Buffers {
    const EMPTY: Self = Self { first: [0; MAX_TELEGRAM], second: [0; MAX_TELEGRAM], stored_in_second: false };

    #[inline]
    const fn stored(&self) -> &[u8; MAX_TELEGRAM] {
        if self.stored_in_second { &self.second } else { &self.first }
    }

    /// The buffer of the stored answer, or the other one.
    #[inline]
    const fn buffer_mut(&mut self, stored: bool) -> &mut [u8; MAX_TELEGRAM] {
        if stored == self.stored_in_second { &mut self.second } else { &mut self.first }
    }
}

impl Responder {
    /// A station with `address` that has not had a request yet.
    #[must_use]
    pub const fn new(address: u8) -> Self {
        Self {
            address,
            requester: NO_STATION,
            fcb: false,
            is_counted: false,
            length: 0,
            prepared: 0,
            buffers: Buffers::EMPTY,
        }
    }

    /// The station address.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// Sets the address and drops the frame count memory.
    pub const fn set_address(&mut self, address: u8) {
        self.address = address;
        self.requester = NO_STATION;
        self.length = 0;
        self.prepared = 0;
    }

    /// Deletes the stored answer, as a station may whenever it receives a telegram for another station. This one does not do
    /// so by itself; a master must work with both kinds.
    pub const fn forget_answer(&mut self) {
        self.length = 0;
    }

    /// Decides about a telegram and, if it is a new counted request, stores it.
    #[inline]
    pub fn accept<'a>(&mut self, data: &DataTelegram<'a>) -> Accepted<'a> {
        if self.is_next(data) {
            self.remember(data.sa, !self.fcb);
            return Accepted::Confirmed(indication(data));
        }
        self.accept_any(data)
    }

    /// Whether the last requester sends the next request of a data exchange. All checks of
    /// [`accept_any`](Self::accept_any) hold then.
    #[inline]
    fn is_next(&self, data: &DataTelegram<'_>) -> bool {
        data.fc == self.next_fc() && data.sa == self.requester && data.da == self.address
    }

    /// FC of the next request of a data exchange of the last requester.
    #[inline]
    const fn next_fc(&self) -> u8 {
        if self.fcb { SRD_HIGH } else { SRD_HIGH_FCB }
    }

    /// Decides about any telegram. profibus-wire 1.8.
    fn accept_any<'a>(&mut self, data: &DataTelegram<'a>) -> Accepted<'a> {
        let Control::Request { function, count } = data.control() else { return Accepted::Ignored };
        self.is_counted = false;
        if data.sa == self.address || data.sa == BROADCAST {
            return Accepted::Ignored;
        }
        if data.da != self.address {
            return match function {
                Function::SdnLow | Function::SdnHigh if data.da == BROADCAST => Accepted::Unconfirmed(indication(data)),
                _ => Accepted::Ignored,
            };
        }
        match function {
            Function::SrdLow | Function::SrdHigh => self.counted(data, count, Accepted::Confirmed(indication(data))),
            Function::SdaLow | Function::SdaHigh => {
                self.counted(data, count, Accepted::LinkLayer(Status::ServiceNotActivated))
            }
            Function::SdnLow | Function::SdnHigh => Accepted::Unconfirmed(indication(data)),
            Function::FdlStatus => Accepted::LinkLayer(Status::Ok),
            Function::Ident => Accepted::Ident,
            // profibus-wire 10, point 2: the service is withdrawn.
            Function::LsapStatus => Accepted::LinkLayer(Status::ServiceNotActivated),
            // profibus-wire 10, point 4
            Function::Other(_) => Accepted::Ignored,
        }
    }

    /// The table of profibus-wire 1.9.
    fn counted<'a>(&mut self, data: &DataTelegram<'_>, count: FrameCount, new: Accepted<'a>) -> Accepted<'a> {
        match count {
            FrameCount::Uncounted => return new,
            FrameCount::Counted(fcb) if data.sa == self.requester && fcb == self.fcb && self.length > 0 => {
                return Accepted::Repetition;
            }
            FrameCount::First => self.remember(data.sa, true),
            FrameCount::Counted(fcb) => self.remember(data.sa, fcb),
        }
        new
    }

    /// Remembers a new counted request, whose answer will be stored.
    #[inline]
    const fn remember(&mut self, requester: u8, fcb: bool) {
        self.requester = requester;
        self.fcb = fcb;
        self.length = 0;
        self.is_counted = true;
    }

    /// The stored answer once more, to be sent not before `not_before`; `None` if none is stored.
    #[must_use]
    pub fn repeat(&self, not_before: BitTime) -> Option<Transmit<'_>> {
        let octets = self.buffers.stored().get(..self.length).filter(|octets| !octets.is_empty())?;
        Some(Transmit { not_before, octets })
    }

    /// Makes the answer to the telegram accepted last, to be sent not before `not_before`, and stores it if the request is
    /// counted. `None` if the data of the reply do not fit a telegram.
    // Always: the compiler would call it, and the reply would be written to memory and read again, in 20 instructions more.
    #[inline(always)]
    pub fn answer(&mut self, data: &DataTelegram<'_>, reply: Reply<'_>, not_before: BitTime) -> Option<Transmit<'_>> {
        let telegram = respond(data, self.address, reply);
        self.prepared = 0;
        let buffer = self.buffers.buffer_mut(self.is_counted);
        let length = telegram.emit(buffer).ok()?;
        if self.is_counted {
            self.length = length;
        }
        Some(Transmit { not_before, octets: buffer.get(..length)? })
    }

    /// Encodes the answer to the next request of a data exchange before that request comes. `fill` writes the `length` octets of its data
    /// unit and returns whether a diagnosis is pending. Returns the request's FC; `None`, and `fill` is not called, if
    /// `requester` did not send the last counted request, because its next frame count bit is not known then.
    ///
    /// The prepared answer is gone after the next [`answer`](Self::answer).
    #[inline]
    pub fn prepare(&mut self, requester: u8, length: u8, fill: impl FnOnce(&mut [u8]) -> bool) -> Option<u8> {
        self.prepared = 0;
        if requester != self.requester {
            return None;
        }
        let length = emit_sd2_with(self.buffers.buffer_mut(false), requester, self.address, length, |du| {
            if fill(du) { DATA_HIGH } else { DATA_LOW }
        })
        .ok()?;
        self.prepared = u8::try_from(length).ok()?;
        Some(self.next_fc())
    }

    /// The request has come for which an answer is [prepared](Self::prepare): accepts it, and returns and stores that answer. `None` if
    /// none is prepared.
    #[inline]
    pub fn release(&mut self, not_before: BitTime) -> Option<Transmit<'_>> {
        let length = core::mem::take(&mut self.prepared);
        if length == 0 {
            return None;
        }
        self.fcb = !self.fcb;
        self.is_counted = true;
        self.length = usize::from(length);
        self.buffers.stored_in_second = !self.buffers.stored_in_second;
        Some(Transmit { not_before, octets: self.buffers.stored().get(..self.length)? })
    }
}

/// A response swaps addresses and access points. SD1 and SC carry no access points.
#[inline]
fn respond<'a>(data: &DataTelegram<'_>, address: u8, reply: Reply<'a>) -> Telegram<'a> {
    let (status, du) = match reply {
        Reply::ShortAck => return Telegram::ShortAck,
        Reply::Status(status) => {
            return Telegram::Data(DataTelegram::short(data.sa, address, Control::slave(status)));
        }
        Reply::Low(du) => (Status::DataLow, du),
        Reply::High(du) => (Status::DataHigh, du),
    };
    Telegram::Data(DataTelegram {
        da: data.sa,
        sa: address,
        dsap: data.ssap,
        ssap: data.dsap,
        fc: Control::slave(status).to_octet(),
        du,
    })
}

/// DP uses both address extensions or none; a single one, or one that is no access point, addresses no service.
/// profibus-wire 1.3.
#[inline]
fn indication<'a>(data: &DataTelegram<'a>) -> Indication<'a> {
    let sap = match (data.dsap, data.ssap) {
        (None, None) => Sap::Default,
        (Some(dsap), Some(0..=MAX_SSAP)) => Sap::from_octet(Some(dsap)),
        (dsap, _) => Sap::Other(dsap.unwrap_or(NO_STATION)),
    };
    Indication { sa: data.sa, sap, ssap: data.ssap, du: data.du }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ADDRESS: u8 = 8;

    /// Everything that a responder remembers, without the octets of the answers, which accepting does not change.
    fn memory(responder: &Responder) -> (u8, u8, bool, bool, usize) {
        let Responder { address, requester, fcb, is_counted, length, prepared: _, buffers: _ } = responder;
        (*address, *requester, *fcb, *is_counted, *length)
    }

    /// `accept` has a short way for the next request of a data exchange. In every state and for every FC, address and access
    /// point that makes a difference it decides and remembers what the rules alone do.
    #[test]
    fn the_short_way_to_the_next_request_decides_and_remembers_as_the_rules_do() {
        let mut by_rules = Responder::new(ADDRESS);
        let mut by_short_way = Responder::new(ADDRESS);
        let mut taken = 0;
        for state in 0..24_u8 {
            let requester = [2, 3, NO_STATION][usize::from(state % 3)];
            let (fcb, is_counted, length) = (state & 1 == 0, (state / 6) & 1 == 0, usize::from((state / 12) & 1) * 9);
            for (da, sa) in [8, 9, BROADCAST].into_iter().flat_map(|da| [2, 3, 8, BROADCAST].map(|sa| (da, sa))) {
                for (dsap, ssap) in [(None, None), (Some(60), Some(62)), (Some(51), None), (None, Some(63))] {
                    for fc in 0..=u8::MAX {
                        for responder in [&mut by_rules, &mut by_short_way] {
                            (responder.requester, responder.fcb) = (requester, fcb);
                            (responder.is_counted, responder.length) = (is_counted, length);
                        }
                        let data = DataTelegram { da, sa, dsap, ssap, fc, du: &[1, 2] };
                        taken += u32::from(by_short_way.is_next(&data));
                        assert_eq!(by_short_way.accept(&data), by_rules.accept_any(&data), "{data:?} in {state}");
                        assert_eq!(memory(&by_short_way), memory(&by_rules), "{data:?} in {state}");
                    }
                }
            }
        }
        // One FC, one source and one destination in each of the 16 states with a requester, with four pairs of access points.
        assert_eq!(taken, 64);
    }
}
