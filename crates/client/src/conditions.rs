//! What must be the case before a command is sent: the state diagram, and the conditions of the manual beside its codes.
//! Asked before, because a refusal afterwards says much less.

use super::error::ClientError;
use super::gauge::Gauge;
use super::names::{NamedParameter, ParameterNames};
use super::records::Records;
use super::values::{Value, format_number};
use profivac_devices::model::{Code, Codes, Precondition};
use profivac_devices::profile::{DeviceState, StateEvent};

/// Slot and index of Device State in every block device.
const DEVICE_STATE: (u8, u8) = (0, 25);

/// Slot and index of Device Block State Command.
const STATE_COMMAND: (u8, u8) = (0, 15);

/// The states by their codes.
const STATES: [DeviceState; 6] = [
    DeviceState::SelfTesting,
    DeviceState::Idle,
    DeviceState::SelfTestException,
    DeviceState::Executing,
    DeviceState::Abort,
    DeviceState::CriticalFault,
];

/// A condition of a command, and whether it holds now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Condition {
    /// What must be the case.
    pub required: String,
    /// What is the case.
    pub found: String,
    /// Why it is not met and what to do; nothing if it is.
    pub unmet: Option<String>,
}

/// What is asked of a gauge before a command.
enum Requirement<'a> {
    /// An arrow of the state diagram begins at the state the gauge is in.
    Transition(&'a NamedParameter, StateEvent),
    /// It measures.
    Executing(&'a NamedParameter),
    /// Emission Status is not off.
    Emission(&'a NamedParameter),
    /// A Process Value is below so many Pa.
    Below(&'a NamedParameter, f64),
}

/// The conditions of a code in words, by the tables alone: no gauge is asked.
#[must_use]
pub fn required_texts(names: &ParameterNames, named: &NamedParameter, code: &'static Code) -> Vec<String> {
    requirements(names, named, code).iter().map(Requirement::text).collect()
}

/// All conditions of a code with what is the case now.
///
/// # Errors
/// What reading may lead to.
pub(super) fn all<R: Records>(
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    code: Option<&'static Code>,
) -> Result<Vec<Condition>, ClientError> {
    let Some(code) = code else { return Ok(Vec::new()) };
    let names = gauge.names();
    requirements(&names, named, code).iter().map(|ask| ask.evaluate(gauge)).collect()
}

/// Checks the conditions of a code.
///
/// # Errors
/// [`ClientError::Condition`] says what is missing.
pub(super) fn check<R: Records>(
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    code: Option<&'static Code>,
) -> Result<(), ClientError> {
    let Some(code) = code else { return Ok(()) };
    let names = gauge.names();
    for ask in requirements(&names, named, code) {
        if let Some(reason) = ask.evaluate(gauge)?.unmet {
            return Err(ClientError::Condition { place: gauge.location(named), command: code.name, reason });
        }
    }
    Ok(())
}

/// What is asked before a code is written. What a device does not have is not asked for.
fn requirements<'a>(names: &'a ParameterNames, named: &'a NamedParameter, code: &'static Code) -> Vec<Requirement<'a>> {
    let (slot, index) = DEVICE_STATE;
    let state = names.at(slot, 0, index);
    let arrow = state.zip(event(named, code)).map(|(state, event)| Requirement::Transition(state, event));
    let needs = code.preconditions.iter().filter_map(|need| match *need {
        Precondition::Executing => state.map(Requirement::Executing),
        Precondition::EmissionOn => {
            parameter_of_instance(names, named, named.parameter.place.instance, |name| name == "Emission Status")
                .map(Requirement::Emission)
        }
        Precondition::PressureBelow(instance, pa) => {
            let instance = instance.unwrap_or(named.parameter.place.instance);
            parameter_of_instance(names, named, instance, |name| name.contains("Value (PV)"))
                .map(|value| Requirement::Below(value, pa))
        }
    });
    arrow.into_iter().chain(needs).collect()
}

/// The event of the state diagram that a code of Device Block State Command is.
fn event(named: &NamedParameter, code: &'static Code) -> Option<StateEvent> {
    let row = named.parameter.row;
    let is_state_command = (named.parameter.place.slot, row.index) == STATE_COMMAND;
    let number = u8::try_from(code.number).ok().filter(|_| is_state_command && matches!(row.codes, Codes::Commands(_)));
    StateEvent::of_command(number?).ok().flatten()
}

/// The parameter with this name in the same slot, of this instance.
fn parameter_of_instance<'a>(
    names: &'a ParameterNames,
    named: &NamedParameter,
    instance: u8,
    is: impl Fn(&str) -> bool,
) -> Option<&'a NamedParameter> {
    let slot = named.parameter.place.slot;
    names.all().iter().find(|other| {
        let place = other.parameter.place;
        (place.slot, place.instance) == (slot, instance) && is(other.parameter.row.name)
    })
}

impl Requirement<'_> {
    /// In words.
    fn text(&self) -> String {
        match self {
            Self::Transition(_, event) => format!("the gauge is in {}", source_states(*event)),
            Self::Executing(_) => "the gauge is in EXECUTING".to_owned(),
            Self::Emission(_) => "the emission is on".to_owned(),
            Self::Below(value, pa) => format!("{} is below {}", value.name, mbar(*pa)),
        }
    }

    /// Asks the gauge.
    fn evaluate<R: Records>(&self, gauge: &mut Gauge<R>) -> Result<Condition, ClientError> {
        let (found, unmet) = match self {
            Self::Transition(named, event) => {
                let state = state(gauge, named)?;
                let stays = state.is_some_and(|state| state.next(*event).is_err());
                let from = source_states(*event);
                (
                    format!("it is in {}", state_name(state)),
                    stays
                        .then(|| format!("the gauge is in {}, and it is possible from {from} only", state_name(state))),
                )
            }
            Self::Executing(named) => {
                let state = state(gauge, named)?;
                let idles = state.is_some_and(|state| state != DeviceState::Executing);
                let name = state_name(state);
                (
                    format!("it is in {name}"),
                    idles.then(|| format!("the gauge is in {name} and must be in EXECUTING; write execute first")),
                )
            }
            Self::Emission(status) => {
                let reading = gauge.read(status)?;
                let off = reading.value == Value::Integer(0);
                (format!("it is {}", reading.text), off.then(|| "the emission is off; it must be on".to_owned()))
            }
            Self::Below(value, limit) => pressure(gauge, value, *limit)?,
        };
        Ok(Condition { required: self.text(), found, unmet })
    }
}

/// What is found of a pressure that must be below a limit, and why that is not met.
fn pressure<R: Records>(
    gauge: &mut Gauge<R>,
    value: &NamedParameter,
    limit_pa: f64,
) -> Result<(String, Option<String>), ClientError> {
    let limit = mbar(limit_pa);
    Ok(match gauge.pressure_of(value)?.pa {
        Some(pa) if pa < limit_pa => (format!("it is {}", mbar(pa)), None),
        Some(pa) => (
            format!("it is {}", mbar(pa)),
            Some(format!("{} is {} and must be below {limit}; pump down first", value.name, mbar(pa))),
        ),
        None => (
            "it is not valid now".to_owned(),
            Some(format!("{} is not valid now, and must be below {limit}", value.name)),
        ),
    })
}

fn mbar(pa: f64) -> String {
    format!("{} mbar", format_number(pa / 100.0))
}

fn state<R: Records>(gauge: &mut Gauge<R>, named: &NamedParameter) -> Result<Option<DeviceState>, ClientError> {
    let reading = gauge.read(named)?;
    Ok(STATES.into_iter().find(|state| reading.value == Value::Integer(state.code().into())))
}

const fn state_name(state: Option<DeviceState>) -> &'static str {
    match state {
        Some(state) => state.name(),
        None => "no known state",
    }
}

/// The states from which an arrow of the state diagram begins.
fn source_states(event: StateEvent) -> String {
    let from: Vec<_> = STATES.into_iter().filter(|state| state.next(event).is_ok()).map(DeviceState::name).collect();
    from.join(", ")
}
