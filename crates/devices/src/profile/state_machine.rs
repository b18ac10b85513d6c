//! The device states and their transitions. errata-bpg-bcg-tpg 84 to 92, errata-pxg55x-img400 19 to 28.

use super::exceptions::CommonExceptions;
use crate::model::AccessError;
use crate::model::code_table::codes;
use crate::simulation::ReportedState;

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
    /// The code of INIT on an IMG 400, the only device that has one: errata-pxg55x-img400 20.
    pub const INIT_CODE: u16 = 100;

    /// The code of Device State. INIT has none in the gauges' manuals, and 0 means "undefined":
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

    /// The name in the state diagram: `IDLE`.
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

impl From<DeviceState> for ReportedState {
    fn from(state: DeviceState) -> Self {
        match state {
            DeviceState::Init => Self::Init,
            DeviceState::SelfTesting => Self::SelfTesting,
            DeviceState::Idle => Self::Idle,
            DeviceState::SelfTestException => Self::SelfTestException,
            DeviceState::Executing => Self::Executing,
            DeviceState::Abort => Self::Abort,
            DeviceState::CriticalFault => Self::CriticalFault,
        }
    }
}

codes! {
    /// Device Block State Command. The state diagram says which of them a state allows: [`TRANSITIONS`].
    pub StateCommand: Commands;
    0 Inactive          "inactive";
    1 Reset             "reset", risk "restarts the device: it measures nothing until it is ready";
    2 Abort             "abort", risk "stops the measurement; relays and outputs go to their safe state";
    3 Recover           "recover";
    4 Execute           "execute";
    5 Stop              "stop", risk "stops the measurement; relays and outputs go to their safe state";
    6 PerformDiagnostic "perform-diagnostic", risk "stops the measurement for a self test";
}

/// An event that may change the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateEvent {
    /// Command 1.
    Reset,
    /// Command 2.
    Abort,
    /// Command 3.
    Recover,
    /// Command 4, and the start of data exchange.
    Execute,
    /// Command 5, and the end of data exchange.
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
    /// The event of a Device Block State Command; `None` for Inactive.
    ///
    /// # Errors
    /// [`AccessError::OutOfRange`] for a number that is no command.
    pub const fn of_command(number: u8) -> Result<Option<Self>, AccessError> {
        let Some(command) = StateCommand::from_code(number as u16) else { return Err(AccessError::OutOfRange) };
        Ok(Some(match command {
            StateCommand::Inactive => return Ok(None),
            StateCommand::Reset => Self::Reset,
            StateCommand::Abort => Self::Abort,
            StateCommand::Recover => Self::Recover,
            StateCommand::Execute => Self::Execute,
            StateCommand::Stop => Self::Stop,
            StateCommand::PerformDiagnostic => Self::PerformDiagnostic,
        }))
    }
}

/// One transition of the state diagram, or several with the same number.
#[derive(Debug)]
pub struct Transition {
    /// The number in the diagram.
    pub number: u8,
    /// The event.
    pub event: StateEvent,
    /// The states in which it acts.
    pub from: &'static [DeviceState],
    /// The state that follows.
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
    /// The state that follows an event in this state.
    ///
    /// # Errors
    /// [`AccessError::AlreadyInState`] when the device is in that state already, [`AccessError::StateConflict`] when this state has
    /// no transition for the event: errata-bpg-bcg-tpg 89.
    pub fn next(self, event: StateEvent) -> Result<Self, AccessError> {
        let transitions = || TRANSITIONS.iter().filter(|transition| transition.event == event);
        match transitions().find(|transition| transition.from.contains(&self)) {
            Some(transition) => Ok(transition.to),
            None if transitions().any(|transition| transition.to == self) => Err(AccessError::AlreadyInState),
            None => Err(AccessError::StateConflict),
        }
    }
}

/// The result of a self test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelfTestResult {
    /// No alarm.
    Passed,
    /// An alarm.
    Alarm,
    /// The device cannot run reliably.
    Critical,
}

impl SelfTestResult {
    /// The result with these common alarms, and with any alarm at all. A self test tests the memories (BG 5530 4.4.1);
    /// an exception that it detects leads to SELFTEST EXCEPTION (tira56e1 7.2.1).
    #[must_use]
    pub const fn found(common: CommonExceptions, alarm: bool) -> Self {
        if common.is_critical() {
            Self::Critical
        } else if alarm {
            Self::Alarm
        } else {
            Self::Passed
        }
    }
}

// chosen: the manuals give no times; both phases are short.
const INIT_S: f64 = 0.1;
const SELF_TEST_S: f64 = 0.4;

/// The state, and the time until it ends by itself.
#[derive(Clone, Debug)]
pub struct StateMachine {
    state: DeviceState,
    remaining_s: f64,
    exchanging: bool,
    /// The exchange began before IDLE was reached; EXECUTING follows then: errata-bpg-bcg-tpg 90.
    execute_when_idle: bool,
}

impl StateMachine {
    /// The state after power-up.
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

    /// Whether data exchange runs.
    #[must_use]
    pub const fn is_exchanging(&self) -> bool {
        self.exchanging
    }

    /// Whether unit and data type may be changed: in IDLE, and not during data exchange. errata-bpg-bcg-tpg 91.
    #[must_use]
    pub fn is_configurable(&self) -> bool {
        self.state == DeviceState::Idle && !self.exchanging
    }

    /// Executes a Device Block State Command. Returns whether the device restarts.
    ///
    /// # Errors
    /// Refused commands change nothing: [`DeviceState::next`], [`StateEvent::of_command`].
    pub fn command(&mut self, number: u8) -> Result<bool, AccessError> {
        let Some(event) = StateEvent::of_command(number)? else { return Ok(false) };
        self.enter(self.state.next(event)?);
        // A command during the start overrides the start of the exchange, which leads to EXECUTING only once.
        self.execute_when_idle = false;
        Ok(event == StateEvent::Reset)
    }

    /// Data exchange begins or has ended. Its beginning is the command Execute, so it acts in IDLE only; its end leads
    /// back to IDLE. errata-bpg-bcg-tpg 90.
    pub fn set_exchanging(&mut self, running: bool) {
        self.exchanging = running;
        self.execute_when_idle = running && matches!(self.state, DeviceState::Init | DeviceState::SelfTesting);
        self.apply(if running { StateEvent::Execute } else { StateEvent::Stop });
    }

    /// Detects a critical fault while the device works: transition 9 acts at once, errata-bpg-bcg-tpg 158. INIT has
    /// tested nothing yet, and the self test reports at its end.
    pub fn detect(&mut self, common: CommonExceptions) {
        let starts = matches!(self.state, DeviceState::Init | DeviceState::SelfTesting);
        if common.is_critical() && !starts {
            self.apply(StateEvent::Fault);
        }
    }

    /// Advances the time of the start and the self test.
    pub fn advance(&mut self, seconds: f64, result: SelfTestResult) {
        let mut seconds = seconds;
        while matches!(self.state, DeviceState::Init | DeviceState::SelfTesting) {
            if seconds < self.remaining_s {
                self.remaining_s -= seconds;
                return;
            }
            seconds -= self.remaining_s;
            self.phase_ends(result);
        }
    }

    /// Completes start and self test.
    pub fn settle(&mut self, result: SelfTestResult) {
        self.advance(f64::INFINITY, result);
    }

    /// INIT or the self test is over.
    fn phase_ends(&mut self, result: SelfTestResult) {
        self.apply(match (self.state, result) {
            (DeviceState::Init, _) => StateEvent::Initialised,
            (_, SelfTestResult::Passed) => StateEvent::Passed,
            (_, SelfTestResult::Alarm) => StateEvent::Failed,
            (_, SelfTestResult::Critical) => StateEvent::Fault,
        });
        if self.state == DeviceState::Idle && core::mem::take(&mut self.execute_when_idle) {
            self.apply(StateEvent::Execute);
        }
    }

    /// An event that no command causes: without a transition it has no effect.
    fn apply(&mut self, event: StateEvent) {
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
