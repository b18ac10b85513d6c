//! The state machine of a block device. errata-bpg-bcg-tpg 84 to 92, errata-pxg55x-img400 19 to 28.

use super::exceptions::CommonExceptions;
use crate::model::AccessError;

/// The state of a block device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceState {
    /// Starting.
    Init,
    /// Self test.
    SelfTesting,
    /// Ready, not measuring.
    Idle,
    /// The self test has found a fault.
    SelfTestException,
    /// Measuring.
    Executing,
    /// Stopped by command.
    Abort,
    /// Not able to work; only Reset helps.
    CriticalFault,
}

impl DeviceState {
    /// The code of Device State. INIT has none in the gauges' manuals, and 0 stands for "undefined":
    /// errata-bpg-bcg-tpg 85.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Init => 0,
            Self::SelfTesting => 1,
            Self::Idle => 2,
            Self::SelfTestException => 3,
            Self::Executing => 4,
            Self::Abort => 5,
            Self::CriticalFault => 6,
        }
    }

    /// The name in the state diagram.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Init => "INIT",
            Self::SelfTesting => "SELFTESTING",
            Self::Idle => "IDLE",
            Self::SelfTestException => "SELFTESTEXCEPTION",
            Self::Executing => "EXECUTING",
            Self::Abort => "ABORT",
            Self::CriticalFault => "CRITICALFAULT",
        }
    }
}

/// What moves the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateEvent {
    /// Command 1.
    Reset,
    /// Command 2.
    Abort,
    /// Command 3.
    Recover,
    /// Command 4, and the start of cyclic exchange.
    Execute,
    /// Command 5, and the end of cyclic exchange.
    Stop,
    /// Command 6.
    PerformDiagnostic,
    /// INIT is done.
    Initialised,
    /// The self test has found nothing.
    Passed,
    /// The self test has found a fault.
    Failed,
    /// A fault with which the device cannot work.
    Fault,
}

impl StateEvent {
    /// The event of a Device Block State Command; `None` for 0, Inactive.
    ///
    /// # Errors
    /// [`Refusal::Range`] for a number that is no command.
    pub const fn of_command(number: u8) -> Result<Option<Self>, AccessError> {
        Ok(Some(match number {
            0 => return Ok(None),
            1 => Self::Reset,
            2 => Self::Abort,
            3 => Self::Recover,
            4 => Self::Execute,
            5 => Self::Stop,
            6 => Self::PerformDiagnostic,
            _ => return Err(AccessError::OutOfRange),
        }))
    }
}

/// One arrow of the state diagram, or several with the same number.
#[derive(Debug)]
pub struct Transition {
    /// The number in the diagram.
    pub number: u8,
    /// What moves.
    pub event: StateEvent,
    /// From any of these.
    pub from: &'static [DeviceState],
    /// To this.
    pub to: DeviceState,
}

macro_rules! transitions {
    ($($number:literal $event:ident ($($from:ident)|+ => $to:ident);)+) => {
        /// The state diagram.
        pub const TRANSITIONS: &[Transition] = &[$(Transition {
            number: $number,
            event: StateEvent::$event,
            from: &[$(DeviceState::$from),+],
            to: DeviceState::$to,
        }),+];
    };
}

transitions! {
    14 Initialised       ( Init                                                      => SelfTesting );
    1  Passed            ( SelfTesting                                               => Idle );
    2  Failed            ( SelfTesting                                               => SelfTestException );
    // From IDLE and EXECUTING by the text of the command: errata-bpg-bcg-tpg 88.
    3  PerformDiagnostic ( SelfTestException | Idle | Executing                      => SelfTesting );
    4  Abort             ( Idle | Executing                                          => Abort );
    5  Recover           ( Abort                                                     => Idle );
    8  Execute           ( Idle                                                      => Executing );
    10 Stop              ( Executing                                                 => Idle );
    9  Fault             ( Init | SelfTesting | SelfTestException | Idle | Executing | Abort => CriticalFault );
    13 Reset             ( SelfTesting | SelfTestException | Idle | Executing | Abort | CriticalFault => Init );
}

impl DeviceState {
    /// Where an event leads from here.
    ///
    /// # Errors
    /// [`Refusal::AlreadyThere`] when the device is where the event leads, [`Refusal::Conflict`] when no arrow leaves
    /// this state: errata-bpg-bcg-tpg 89.
    pub fn next(self, event: StateEvent) -> Result<Self, AccessError> {
        let arrows = || TRANSITIONS.iter().filter(|transition| transition.event == event);
        match arrows().find(|transition| transition.from.contains(&self)) {
            Some(transition) => Ok(transition.to),
            None if arrows().any(|transition| transition.to == self) => Err(AccessError::AlreadyInState),
            None => Err(AccessError::StateConflict),
        }
    }
}

/// What a self test finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelfTestResult {
    /// Nothing.
    Good,
    /// An alarm.
    Faulty,
    /// Nothing is left that could be trusted to run.
    Critical,
}

impl SelfTestResult {
    /// What is found with these common alarms, and with any alarm at all. A self test tests the memories (BG 5530 4.4.1),
    /// and an exception that it detects is SELFTEST EXCEPTION (tira56e1 7.2.1).
    // free choice: no manual says which fault is critical (transition 9). Where the program and the memory it works in are
    // both defective, nothing can be trusted to run.
    #[must_use]
    pub fn found(common: CommonExceptions, alarm: bool) -> Self {
        match () {
            () if common.contains(CommonExceptions::EPROM | CommonExceptions::RAM) => Self::Critical,
            () if alarm => Self::Faulty,
            () => Self::Good,
        }
    }
}

// free choice: the manuals give no times; both phases are short.
const INIT_S: f64 = 0.1;
const SELF_TEST_S: f64 = 0.4;

/// The state, and how long it lasts by itself.
#[derive(Clone, Debug)]
pub struct StateMachine {
    state: DeviceState,
    remaining_s: f64,
    exchanging: bool,
    /// The exchange began before IDLE was reached; EXECUTING follows then: errata-bpg-bcg-tpg 90.
    execute_when_idle: bool,
}

impl StateMachine {
    /// Power has just come.
    #[must_use]
    pub const fn power_up() -> Self {
        Self { state: DeviceState::Init, remaining_s: INIT_S, exchanging: false, execute_when_idle: false }
    }

    /// The state.
    #[must_use]
    pub const fn state(&self) -> DeviceState {
        self.state
    }

    /// Whether the device measures.
    #[must_use]
    pub fn is_executing(&self) -> bool {
        self.state == DeviceState::Executing
    }

    /// Whether cyclic exchange runs.
    #[must_use]
    pub const fn is_exchanging(&self) -> bool {
        self.exchanging
    }

    /// Whether unit and data type may be changed: in IDLE, and not during cyclic exchange. errata-bpg-bcg-tpg 91.
    #[must_use]
    pub fn is_configurable(&self) -> bool {
        self.state == DeviceState::Idle && !self.exchanging
    }

    /// A Device Block State Command. Returns whether the device begins anew.
    ///
    /// # Errors
    /// Refused commands change nothing: [`State::after`], [`Event::of_command`].
    pub fn command(&mut self, number: u8) -> Result<bool, AccessError> {
        let Some(event) = StateEvent::of_command(number)? else { return Ok(false) };
        self.enter(self.state.next(event)?);
        // A command during the start has the last word: the exchange forces EXECUTING only once.
        self.execute_when_idle = false;
        Ok(event == StateEvent::Reset)
    }

    /// Cyclic exchange begins or has ended. Its beginning is the command Execute, and so acts from IDLE only; its end
    /// leads back to IDLE. errata-bpg-bcg-tpg 90.
    pub fn exchanging(&mut self, running: bool) {
        self.exchanging = running;
        self.execute_when_idle = running && matches!(self.state, DeviceState::Init | DeviceState::SelfTesting);
        self.happen(if running { StateEvent::Execute } else { StateEvent::Stop });
    }

    /// Time passes.
    pub fn advance(&mut self, seconds: f64, health: SelfTestResult) {
        let mut seconds = seconds;
        while matches!(self.state, DeviceState::Init | DeviceState::SelfTesting) {
            if seconds < self.remaining_s {
                self.remaining_s -= seconds;
                return;
            }
            seconds -= self.remaining_s;
            self.phase_ends(health);
        }
    }

    /// Start and self test come to their end.
    pub fn settle(&mut self, health: SelfTestResult) {
        self.advance(f64::INFINITY, health);
    }

    /// INIT or the self test is over.
    fn phase_ends(&mut self, health: SelfTestResult) {
        self.happen(match (self.state, health) {
            (DeviceState::Init, _) => StateEvent::Initialised,
            (_, SelfTestResult::Good) => StateEvent::Passed,
            (_, SelfTestResult::Faulty) => StateEvent::Failed,
            (_, SelfTestResult::Critical) => StateEvent::Fault,
        });
        if self.state == DeviceState::Idle && core::mem::take(&mut self.execute_when_idle) {
            self.happen(StateEvent::Execute);
        }
    }

    /// Something that is nobody's command: where no arrow leaves, nothing happens.
    fn happen(&mut self, event: StateEvent) {
        if let Ok(state) = self.state.next(event) {
            self.enter(state);
        }
    }

    /// The only place where the state is assigned.
    fn enter(&mut self, state: DeviceState) {
        self.state = state;
        self.remaining_s = match state {
            DeviceState::Init => INIT_S,
            DeviceState::SelfTesting => SELF_TEST_S,
            _ => 0.0,
        };
    }
}
