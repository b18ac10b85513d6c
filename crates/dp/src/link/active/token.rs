//! The token: passing, taking, claiming and giving it up, and the telegrams of other masters.
//! profibus-wire 1.13.
//!
//! | State \ telegram | token to us | token that skips us | other token | FDL status to us | other request | our own address |
//! |---|---|---|---|---|---|---|
//! | Offline | - | - | - | - | - | - |
//! | Listening, list not complete | learn | learn | learn | not ready | - | twice: address taken |
//! | Listening, list complete | take it from PS, or the second time | follow | follow | ready | - | twice: address taken |
//! | Idle | take it from PS, or the second time | out of the ring: Listening | follow | in the ring | RS | twice: address taken |
//! | Passing | the successor has it: as Idle | as Idle | as Idle | as Idle | as Idle | as Idle |
//! | Claiming | give up: as Listening | as Listening | as Listening | as Listening | as Listening | as Listening |
//! | any other: token holder | two tokens, give ours up: as Idle | as Idle | as Idle | as Idle | as Idle | as Idle |
//!
//! A station that has yielded its address sends nothing until two rotations have passed without the other station.

use super::las::{self, Las};
use super::request::{FdlUser, Kind, Mismatch};
use super::state::{FdlState, Pass, Unconfirmed, increment};
use super::{Active, Confirmation, Failure};
use crate::link::Transmit;
use crate::link::time::BitTime;
use profivac_wire::control::{Control, Function, StationType, Status};
use profivac_wire::{BROADCAST, DataTelegram, Telegram};

/// How often a token that is not taken is sent again. profibus-wire 1.13.
const TOKEN_REPETITIONS: u8 = 2;

/// This many telegrams with the own address are not noise.
const DUPLICATE_LIMIT: u8 = 2;

/// A telegram of another master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ForeignTelegram {
    /// No master can have sent it.
    Noise,
    /// Another station has our address.
    OwnAddress,
    /// A token to this station.
    TokenToUs { sa: u8 },
    /// A token to another station.
    TokenToOther { da: u8, sa: u8 },
    /// A request for the FDL status of this station.
    FdlStatus { sa: u8 },
    /// A request for a service that an active station does not have.
    Service { sa: u8 },
    /// Any other request: its sender has the token.
    Request { sa: u8 },
}

impl ForeignTelegram {
    /// Classifies `telegram` at the station `own`; `None` if it is an answer, for [`Active::handle_answer`].
    #[inline]
    pub(super) fn of(telegram: &Telegram<'_>, own: u8) -> Option<Self> {
        match telegram {
            Telegram::ShortAck => None,
            Telegram::Data(data) if data.sa == own => Some(Self::OwnAddress),
            Telegram::Data(data) => match data.control() {
                Control::Response { .. } => None,
                Control::Request { function, .. } => Some(Self::of_request(data, function, own)),
            },
            &Telegram::Token { da, sa } if !las::is_token(da, sa) => Some(Self::Noise),
            Telegram::Token { sa, .. } if *sa == own => Some(Self::OwnAddress),
            &Telegram::Token { da, sa } if da == own => Some(Self::TokenToUs { sa }),
            &Telegram::Token { da, sa } => Some(Self::TokenToOther { da, sa }),
        }
    }

    fn of_request(data: &DataTelegram<'_>, function: Function, own: u8) -> Self {
        let sa = data.sa;
        match function {
            _ if sa >= BROADCAST => Self::Noise,
            _ if data.da != own => Self::Request { sa },
            Function::FdlStatus => Self::FdlStatus { sa },
            Function::SrdLow | Function::SrdHigh | Function::SdaLow | Function::SdaHigh => Self::Service { sa },
            Function::Ident | Function::LsapStatus => Self::Service { sa },
            Function::SdnLow | Function::SdnHigh | Function::Other(_) => Self::Request { sa },
        }
    }

    /// The master that sent the telegram.
    const fn master(self) -> Option<u8> {
        match self {
            Self::TokenToUs { sa } | Self::TokenToOther { sa, .. } => Some(sa),
            Self::FdlStatus { sa } | Self::Service { sa } | Self::Request { sa } => Some(sa),
            Self::Noise | Self::OwnAddress => None,
        }
    }
}

impl<R: FdlUser> Active<R> {
    /// Handles a telegram of another master: the table above.
    #[cold]
    pub(super) fn handle_foreign(
        &mut self,
        end: BitTime,
        telegram: &Telegram<'_>,
        foreign: ForeignTelegram,
    ) -> Option<Transmit<'_>> {
        if foreign == ForeignTelegram::Noise {
            self.handle_answer(end, telegram);
            return None;
        }
        if self.is_echo(end, telegram) || self.is_answer_with_request_code(telegram) {
            return None;
        }
        self.give_up_token(end);
        self.other = foreign.master().or(self.other);
        let complete = self.las.is_complete();
        match (&self.state, foreign) {
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

    /// Gives up the token, or the claim to it: another master sent a telegram, or the line is never idle.
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

    /// Updates the list from a token between other stations.
    fn learn(&mut self, da: u8, sa: u8) -> Option<Transmit<'_>> {
        self.suspect = None;
        self.las.observe_token(da, sa);
        if self.las.is_complete() {
            self.duplicate.yielded = false;
        }
        None
    }

    /// The token skips this station, so it is not in the ring any more. Its list is still valid, so it is ready to be let in
    /// again.
    fn skipped_by_token(&mut self, da: u8, sa: u8) -> Option<Transmit<'_>> {
        increment(&mut self.counters.left_out);
        self.state = FdlState::Listening;
        self.learn(da, sa)
    }

    /// A token to this station. The station accepts it from its predecessor at once. From another master it may be an error;
    /// if it comes again from there, the ring has changed.
    fn token_offered(&mut self, end: BitTime, sa: u8) -> Option<Transmit<'_>> {
        if !self.las.is_predecessor(sa) && self.suspect != Some(sa) {
            self.suspect = Some(sa);
            return None;
        }
        self.las.observe_token(self.bus.address, sa);
        self.begin_visit(end, self.bus.id1_tbit());
        None
    }

    /// Another station sent a telegram with our address. A single one may be noise.
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

    /// Whether the telegram is the adapter's echo of the telegram sent last. An adapter echoes at most once.
    fn is_echo(&mut self, end: BitTime, telegram: &Telegram<'_>) -> bool {
        let sent = core::mem::take(&mut self.may_echo).then(|| self.telegram.get(..self.length)).flatten();
        if !sent.is_some_and(|sent| Telegram::parse(sent).as_ref() == Ok(telegram)) {
            return false;
        }
        match &mut self.state {
            FdlState::Waiting(cycle) => cycle.sent_at = cycle.sent_at.map(|sent| sent.max(end)),
            FdlState::Passing(pass) => pass.heard = false,
            _ => {}
        }
        true
    }

    /// Whether the station that should answer has sent the function code of a request. A slave that does so has no token: its
    /// answer is wrong. A master may answer FDL status with an FDL status request because it has a token of its own.
    fn is_answer_with_request_code(&mut self, telegram: &Telegram<'_>) -> bool {
        let (FdlState::Waiting(cycle), Telegram::Data(data)) = (&mut self.state, telegram) else { return false };
        let status = matches!(data.control(), Control::Request { function: Function::FdlStatus, .. });
        let asks_too = status && cycle.request.kind == Kind::FdlStatus;
        let is_spoilt = (data.da, data.sa) == (self.bus.address, cycle.request.da) && !asks_too;
        if is_spoilt {
            cycle.mismatch = Some(Mismatch::Function(data.fc));
        }
        is_spoilt
    }

    /// Answers as soon as allowed.
    fn answer(&mut self, end: BitTime, da: u8, station: StationType, status: Status) -> Option<Transmit<'_>> {
        let answer = DataTelegram::short(da, self.bus.address, Control::Response { station, status });
        let length = Telegram::Data(answer).emit(&mut self.telegram).ok()?;
        self.transmit(length, end + u64::from(self.bus.min_tsdr_tbit))
    }

    /// The line was idle for T_TO. Inside the ring the token was lost: this station has it now, and the ring continues with its
    /// list. Outside the ring there may be no other master: two tokens to itself announce a new ring.
    pub(super) fn claim(&mut self, now: BitTime, due: BitTime) -> Option<Transmit<'_>> {
        if core::mem::take(&mut self.duplicate.yielded) {
            // chosen: the other station with our address gets one more T_TO, so that it claims first.
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

    /// Ends the visit: the token goes to the successor, or back to a station that is alone.
    pub(super) fn pass_token(&mut self, not_before: BitTime) -> Option<Transmit<'_>> {
        let da = self.las.next();
        if da != self.bus.address {
            return self.send_token(
                da,
                Unconfirmed::Pass(Pass { da, repetitions_left: TOKEN_REPETITIONS, heard: false }),
                not_before,
            );
        }
        if self.leaving_ring {
            self.state = FdlState::Offline;
            return None;
        }
        self.send_token(da, Unconfirmed::Token, not_before)
    }

    pub(super) fn send_token(&mut self, da: u8, unconfirmed: Unconfirmed, not_before: BitTime) -> Option<Transmit<'_>> {
        let token = Telegram::Token { da, sa: self.bus.address };
        let length = token.emit(&mut self.telegram).ok()?;
        self.state = FdlState::Sending(unconfirmed);
        self.transmit(length, not_before)
    }

    /// No telegram came for T_SL after a token: sends it again, and then to the successor of the one that does not take it.
    pub(super) fn check_pass(&mut self, now: BitTime, pass: Pass, due: BitTime) -> Option<Transmit<'_>> {
        if pass.heard {
            // Characters came, but no telegram: only the successor can have the token.
            self.enter_idle();
            return None;
        }
        if let Some(repetitions_left) = pass.repetitions_left.checked_sub(1) {
            increment(&mut self.counters.repeated);
            return self.send_token(pass.da, Unconfirmed::Pass(Pass { repetitions_left, ..pass }), due);
        }
        increment(&mut self.counters.lost_successors);
        self.las.remove(pass.da);
        self.gap.scan_behind(pass.da, now);
        self.pass_token(due)
    }
}
