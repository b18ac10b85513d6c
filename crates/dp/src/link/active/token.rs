//! The token: how it is passed, taken, claimed and given up, and what the telegrams of other masters mean.
//! profibus-wire 1.13.
//!
//! | State \ telegram | token to us | token past us | other token | FDL status to us | other request | our own address |
//! |---|---|---|---|---|---|---|
//! | Offline | - | - | - | - | - | - |
//! | Listening, list not complete | learn | learn | learn | not ready | - | twice: address taken |
//! | Listening, list complete | take it from PS, or the second time | follow | follow | ready | - | twice: address taken |
//! | Idle | take it from PS, or the second time | out of the ring: Listening | follow | in the ring | RS | twice: address taken |
//! | Passing | the successor has it: as Idle | as Idle | as Idle | as Idle | as Idle | as Idle |
//! | Claiming | give up: as Listening | as Listening | as Listening | as Listening | as Listening | as Listening |
//! | any other: we have it | two tokens, give ours up: as Idle | as Idle | as Idle | as Idle | as Idle | as Idle |
//!
//! Who left the address to another station says nothing at all until two rotations went by without it.

use super::las::{self, Las};
use super::request::{FdlUser, Kind, Mismatch};
use super::state::{FdlState, Pass, Unconfirmed, increment};
use super::{Active, Confirmation, Failure};
use crate::link::Transmit;
use crate::link::time::BitTime;
use profivac_wire::control::{Control, Function, StationType, Status};
use profivac_wire::{BROADCAST, DataTelegram, Telegram};

/// A token that nobody takes is sent so often again. profibus-wire 1.13.
const TOKEN_RETRIES: u8 = 2;

/// So many telegrams with our own address are no noise any more.
const DUPLICATE_LIMIT: u8 = 2;

/// What a telegram says that is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ForeignTelegram {
    /// Nothing: no master can have sent it.
    Noise,
    /// That another station has our address.
    OwnAddress,
    /// That we are to have the token.
    TokenToUs { sa: u8 },
    /// That somebody else is to have the token.
    TokenToOther { da: u8, sa: u8 },
    /// That somebody asks for our FDL status.
    FdlStatus { sa: u8 },
    /// That somebody asks for a service that an active station does not have.
    Service { sa: u8 },
    /// That somebody has the token.
    Request { sa: u8 },
}

impl ForeignTelegram {
    /// What the station `own` makes of `telegram`; `None` if it is for [`Active::heard`]: the answer of another station.
    #[inline]
    pub(super) fn of(telegram: &Telegram<'_>, own: u8) -> Option<Self> {
        match telegram {
            Telegram::ShortAck => None,
            Telegram::Data(frame) if frame.sa == own => Some(Self::OwnAddress),
            Telegram::Data(frame) => match frame.control() {
                Control::Response { .. } => None,
                Control::Request { function, .. } => Some(Self::of_request(frame, function, own)),
            },
            &Telegram::Token { da, sa } if !las::is_token(da, sa) => Some(Self::Noise),
            Telegram::Token { sa, .. } if *sa == own => Some(Self::OwnAddress),
            &Telegram::Token { da, sa } if da == own => Some(Self::TokenToUs { sa }),
            &Telegram::Token { da, sa } => Some(Self::TokenToOther { da, sa }),
        }
    }

    fn of_request(frame: &DataTelegram<'_>, function: Function, own: u8) -> Self {
        let sa = frame.sa;
        match function {
            _ if sa >= BROADCAST => Self::Noise,
            _ if frame.da != own => Self::Request { sa },
            Function::FdlStatus => Self::FdlStatus { sa },
            Function::SrdLow | Function::SrdHigh | Function::SdaLow | Function::SdaHigh => Self::Service { sa },
            Function::Ident | Function::LsapStatus => Self::Service { sa },
            Function::SdnLow | Function::SdnHigh | Function::Other(_) => Self::Request { sa },
        }
    }

    /// The master that speaks.
    const fn master(self) -> Option<u8> {
        match self {
            Self::TokenToUs { sa } | Self::TokenToOther { sa, .. } => Some(sa),
            Self::FdlStatus { sa } | Self::Service { sa } | Self::Request { sa } => Some(sa),
            Self::Noise | Self::OwnAddress => None,
        }
    }
}

impl<R: FdlUser> Active<R> {
    /// Another master speaks: the table above.
    #[cold]
    pub(super) fn handle_foreign(
        &mut self,
        end: BitTime,
        telegram: &Telegram<'_>,
        word: ForeignTelegram,
    ) -> Option<Transmit<'_>> {
        if word == ForeignTelegram::Noise {
            self.handle_answer(end, telegram);
            return None;
        }
        if self.is_echo(end, telegram) || self.is_answer_with_request_code(telegram) {
            return None;
        }
        self.give_up_token(end);
        self.other = word.master().or(self.other);
        let complete = self.las.is_complete();
        match (&self.state, word) {
            (FdlState::Offline, _) | (_, ForeignTelegram::Noise) => None,
            (_, ForeignTelegram::OwnAddress) => self.own_address_heard(),
            (FdlState::Listening, ForeignTelegram::TokenToUs { sa }) if !complete => self.learn(self.bus.address, sa),
            (_, ForeignTelegram::TokenToUs { sa }) => self.token_offered(end, sa),
            (FdlState::Idle, ForeignTelegram::TokenToOther { da, sa }) if las::passes(self.bus.address, da, sa) => {
                self.skipped_by_token(da, sa)
            }
            (_, ForeignTelegram::TokenToOther { da, sa }) => self.learn(da, sa),
            (_, ForeignTelegram::FdlStatus { .. } | ForeignTelegram::Service { .. }) if self.duplicate.yielded => None,
            (FdlState::Listening, ForeignTelegram::FdlStatus { sa }) if complete => {
                self.answer(end, sa, StationType::MasterReady, Status::Ok)
            }
            (FdlState::Listening, ForeignTelegram::FdlStatus { sa }) => {
                self.answer(end, sa, StationType::MasterNotReady, Status::Ok)
            }
            (_, ForeignTelegram::FdlStatus { sa }) => self.answer(end, sa, StationType::MasterInRing, Status::Ok),
            (FdlState::Idle, ForeignTelegram::Service { sa }) => {
                self.answer(end, sa, StationType::MasterInRing, Status::ServiceNotActivated)
            }
            (_, ForeignTelegram::Service { .. } | ForeignTelegram::Request { .. }) => None,
        }
    }

    /// Another master speaks, or the line is never quiet: whoever has the token or is about to claim it gives it up.
    pub(super) fn give_up_token(&mut self, now: BitTime) {
        match self.state {
            FdlState::Offline | FdlState::Listening | FdlState::Idle => return,
            FdlState::Claiming | FdlState::Sending(Unconfirmed::Claim) => {
                self.las = Las::new(self.bus.address);
                self.state = FdlState::Listening;
                return;
            }
            FdlState::Passing(_) => return self.enter_idle(),
            FdlState::Waiting(cycle) => {
                self.enter_idle();
                self.failed(now, &cycle, Failure::Interrupted);
            }
            FdlState::Sending(Unconfirmed::Message) => {
                self.enter_idle();
                self.user.confirm(now, Confirmation::Failed(Failure::Interrupted));
            }
            FdlState::Holding { .. } | FdlState::Sending(Unconfirmed::Token | Unconfirmed::Pass(_)) => {
                self.enter_idle()
            }
        }
        increment(&mut self.counters.given_up);
    }

    /// Another station of the ring has the token.
    fn enter_idle(&mut self) {
        self.state = if self.leaving_ring { FdlState::Offline } else { FdlState::Idle };
    }

    /// A token of others, while this station is not the one that gets it.
    fn learn(&mut self, da: u8, sa: u8) -> Option<Transmit<'_>> {
        self.suspect = None;
        self.las.observe_token(da, sa);
        if self.las.is_complete() {
            self.duplicate.yielded = false;
        }
        None
    }

    /// The token goes past this station: it is not in the ring any more. What it knows of the ring is still true, so it is
    /// ready to be let in again.
    fn skipped_by_token(&mut self, da: u8, sa: u8) -> Option<Transmit<'_>> {
        increment(&mut self.counters.left_out);
        self.state = FdlState::Listening;
        self.learn(da, sa)
    }

    /// A token to this station is taken from its predecessor at once. From anybody else it may be a mistake; if it comes
    /// again from there, the ring has changed.
    fn token_offered(&mut self, end: BitTime, sa: u8) -> Option<Transmit<'_>> {
        if !self.las.is_predecessor(sa) && self.suspect != Some(sa) {
            self.suspect = Some(sa);
            return None;
        }
        self.las.observe_token(self.bus.address, sa);
        self.begin_visit(end, self.bus.id1_tbit());
        None
    }

    /// Another station speaks with our address. Once may be noise.
    fn own_address_heard(&mut self) -> Option<Transmit<'_>> {
        increment(&mut self.counters.own_address);
        self.duplicate.heard = self.duplicate.heard.saturating_add(1);
        self.duplicate.heard_since_visit = true;
        if self.duplicate.heard >= DUPLICATE_LIMIT {
            self.duplicate.yielded = true;
            self.las = Las::new(self.bus.address);
            self.state = FdlState::Listening;
        }
        None
    }

    /// Whether an adapter gives back what this station has sent last. It does so at most once.
    fn is_echo(&mut self, end: BitTime, telegram: &Telegram<'_>) -> bool {
        let sent = core::mem::take(&mut self.may_echo).then(|| self.telegram.get(..self.length)).flatten();
        if !sent.is_some_and(|sent| Telegram::parse(sent).as_ref() == Ok(telegram)) {
            return false;
        }
        match &mut self.state {
            FdlState::Waiting(cycle) => cycle.sent_at = cycle.sent_at.map(|left| left.max(end)),
            FdlState::Passing(pass) => pass.heard = false,
            _ => {}
        }
        true
    }

    /// Whether whoever is being asked answers with the function code of a request. A slave that does has no token: it has
    /// erred. A master that is asked for its FDL status may ask for ours because it has a token of its own.
    fn is_answer_with_request_code(&mut self, telegram: &Telegram<'_>) -> bool {
        let (FdlState::Waiting(cycle), Telegram::Data(frame)) = (&mut self.state, telegram) else { return false };
        let status = matches!(frame.control(), Control::Request { function: Function::FdlStatus, .. });
        let asks_too = status && cycle.request.kind == Kind::FdlStatus;
        let is_spoilt = (frame.da, frame.sa) == (self.bus.address, cycle.request.da) && !asks_too;
        if is_spoilt {
            cycle.mismatch = Some(Mismatch::Function(frame.fc));
        }
        is_spoilt
    }

    /// An answer by this station, as soon as it may begin.
    fn answer(&mut self, end: BitTime, da: u8, station: StationType, status: Status) -> Option<Transmit<'_>> {
        let answer = DataTelegram::short(da, self.bus.address, Control::Response { station, status });
        let length = Telegram::Data(answer).emit(&mut self.telegram).ok()?;
        self.transmit(length, end + u64::from(self.bus.min_tsdr_tbit))
    }

    /// The line was silent for T_TO. Inside the ring the token was lost: this station has it now, and the ring goes on with
    /// the list it has. Outside nobody may be there at all: two tokens to oneself tell everybody that a new ring begins.
    pub(super) fn claim(&mut self, now: BitTime, due: BitTime) -> Option<Transmit<'_>> {
        if core::mem::take(&mut self.duplicate.yielded) {
            // free choice: the station with our address gets one T_TO more, so that it is the first to claim.
            self.duplicate.heard = 0;
            self.busy_until = due;
            return None;
        }
        increment(&mut self.counters.claimed);
        if matches!(self.state, FdlState::Idle) {
            self.begin_visit(now, self.bus.id1_tbit());
            return self.use_token(now, due);
        }
        self.las = Las::alone(self.bus.address);
        self.gap.scan(now);
        self.send_token(self.bus.address, Unconfirmed::Claim, due)
    }

    /// The visit is over: the token goes to the successor, or back to a station that is alone.
    pub(super) fn pass_token(&mut self, not_before: BitTime) -> Option<Transmit<'_>> {
        let da = self.las.next();
        if da != self.bus.address {
            return self.send_token(
                da,
                Unconfirmed::Pass(Pass { da, retries_left: TOKEN_RETRIES, heard: false }),
                not_before,
            );
        }
        if self.leaving_ring {
            self.state = FdlState::Offline;
            return None;
        }
        self.send_token(da, Unconfirmed::Token, not_before)
    }

    pub(super) fn send_token(&mut self, da: u8, departure: Unconfirmed, not_before: BitTime) -> Option<Transmit<'_>> {
        let token = Telegram::Token { da, sa: self.bus.address };
        let length = token.emit(&mut self.telegram).ok()?;
        self.state = FdlState::Sending(departure);
        self.transmit(length, not_before)
    }

    /// Nothing was heard for T_SL after a token: again, and then to the successor of the one that does not take it.
    pub(super) fn check_pass(&mut self, now: BitTime, pass: Pass, due: BitTime) -> Option<Transmit<'_>> {
        if pass.heard {
            // Somebody spoke, if not clearly: who has the token can only be the successor.
            self.enter_idle();
            return None;
        }
        if let Some(retries_left) = pass.retries_left.checked_sub(1) {
            increment(&mut self.counters.repeated);
            return self.send_token(pass.da, Unconfirmed::Pass(Pass { retries_left, ..pass }), due);
        }
        increment(&mut self.counters.lost_successors);
        self.las.remove(pass.da);
        self.gap.scan_behind(pass.da, now);
        self.pass_token(due)
    }
}
