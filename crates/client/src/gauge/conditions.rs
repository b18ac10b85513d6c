//! The conditions of a command: the state diagram, and the conditions that the manual prints beside its codes.
//!
//! The client checks them before it sends a command, because the refusal of a device does not name the condition.

use super::Gauge;
use crate::error::{ClientError, STATES, Unmet, mbar, source_states, state_name};
use crate::names::{NamedParameter, ParameterNames};
use crate::records::Records;
use crate::values::Value;
use profivac_devices::model::{Code, Codes, Precondition, Role};
use profivac_devices::profile::{DeviceState, StateEvent};
use profivac_devices::reading::Quality;

/// Slot and index of Device State in every block device.
const DEVICE_STATE: (u8, u8) = (0, 25);

/// Slot and index of Device Block State Command.
const STATE_COMMAND: (u8, u8) = (0, 15);

/// A condition of a command, and whether it is met, as text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Condition {
    /// The required state.
    pub required: String,
    /// The present state.
    pub found: String,
    /// The reason why the condition is not met, and what to do. `None` if it is met.
    pub unmet: Option<String>,
}

/// A condition that is checked before a command is sent.
enum Requirement<'a> {
    /// The state diagram has a transition from the present state.
    Transition(&'a NamedParameter, StateEvent),
    /// The gauge is in EXECUTING.
    Executing(&'a NamedParameter),
    /// Emission Status is not off.
    Emission(&'a NamedParameter),
    /// Degas Status is off.
    NoDegas(&'a NamedParameter),
    /// A Process Value is below a limit in Pa.
    Below(&'a NamedParameter, f64),
}

/// The conditions of a code as text, from the tables alone.
///
/// ```
/// use profivac_client::{conditions, names::ParameterNames};
/// use profivac_devices::catalog::model_named;
///
/// let names = ParameterNames::of(model_named("bcg450").unwrap());
/// let (named, code) = names.command("degas on")?.unwrap();
/// assert!(conditions::required_texts(&names, named, code).contains(&"the emission is on".to_owned()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn required_texts(names: &ParameterNames, named: &NamedParameter, code: &'static Code) -> Vec<String> {
    requirements(names, named, code).iter().map(Requirement::text).collect()
}

/// All conditions of a code with the present state of the gauge.
pub(super) fn all<R: Records>(
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    code: Option<&'static Code>,
) -> Result<Vec<Condition>, ClientError> {
    let Some(code) = code else { return Ok(Vec::new()) };
    let names = gauge.names();
    let condition = |requirement: &Requirement<'_>| {
        let (found, unmet) = requirement.evaluate(gauge)?;
        Ok(Condition { required: requirement.text(), found, unmet: unmet.map(|unmet| unmet.to_string()) })
    };
    requirements(&names, named, code).iter().map(condition).collect()
}

/// Fails with [`ClientError::Condition`] at the first condition of a code that is not met.
pub(super) fn check<R: Records>(
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    code: Option<&'static Code>,
) -> Result<(), ClientError> {
    let Some(code) = code else { return Ok(()) };
    let names = gauge.names();
    for requirement in requirements(&names, named, code) {
        if let (_, Some(unmet)) = requirement.evaluate(gauge)? {
            return Err(ClientError::Condition { place: gauge.context(named), command: code.name, unmet });
        }
    }
    Ok(())
}

/// The conditions of a code that the device can report. A parameter that the device does not have is no condition.
fn requirements<'a>(names: &'a ParameterNames, named: &'a NamedParameter, code: &'static Code) -> Vec<Requirement<'a>> {
    let (slot, index) = DEVICE_STATE;
    let state = names.at(slot, 0, index);
    let transition = state.zip(event(named, code)).map(|(state, event)| Requirement::Transition(state, event));
    let preconditions = code.preconditions.iter().filter_map(|precondition| match *precondition {
        Precondition::Executing => state.map(Requirement::Executing),
        Precondition::EmissionOn => {
            parameter_of_instance(names, named, named.parameter.place.instance, Role::EmissionStatus)
                .map(Requirement::Emission)
        }
        Precondition::NotDegassing => {
            parameter_of_instance(names, named, named.parameter.place.instance, Role::DegasStatus)
                .map(Requirement::NoDegas)
        }
        Precondition::PressureBelow(instance, pa) => {
            let instance = instance.unwrap_or(named.parameter.place.instance);
            parameter_of_instance(names, named, instance, Role::ProcessValue).map(|value| Requirement::Below(value, pa))
        }
    });
    transition.into_iter().chain(preconditions).collect()
}

/// The event of the state diagram that a code of Device Block State Command triggers.
fn event(named: &NamedParameter, code: &'static Code) -> Option<StateEvent> {
    let row = named.parameter.row;
    let is_state_command = (named.parameter.place.slot, row.index) == STATE_COMMAND;
    let number = u8::try_from(code.number).ok().filter(|_| is_state_command && matches!(row.codes, Codes::Commands(_)));
    StateEvent::of_command(number?).ok().flatten()
}

/// The parameter with this role in the same slot, of this instance.
fn parameter_of_instance<'a>(
    names: &'a ParameterNames,
    named: &NamedParameter,
    instance: u8,
    role: Role,
) -> Option<&'a NamedParameter> {
    let slot = named.parameter.place.slot;
    names.all().iter().find(|other| {
        let place = other.parameter.place;
        (place.slot, place.instance) == (slot, instance) && other.parameter.row.role == Some(role)
    })
}

impl Requirement<'_> {
    fn text(&self) -> String {
        match self {
            Self::Transition(_, event) => format!("the gauge is in {}", source_states(*event)),
            Self::Executing(_) => "the gauge is in EXECUTING".to_owned(),
            Self::Emission(_) => "the emission is on".to_owned(),
            Self::NoDegas(_) => "no degas runs".to_owned(),
            Self::Below(value, pa) => format!("{} is below {}", value.name, mbar(*pa)),
        }
    }

    /// The present state as text, and why it does not meet the requirement.
    fn evaluate<R: Records>(&self, gauge: &mut Gauge<R>) -> Result<(String, Option<Unmet>), ClientError> {
        Ok(match self {
            Self::Transition(named, event) => {
                let found = read_state(gauge, named)?;
                // The device decides about a code that is no known state.
                let is_forbidden = found.is_some_and(|state| state.next(*event).is_err());
                (in_state(found), is_forbidden.then_some(Unmet::State { found, event: *event }))
            }
            Self::Executing(named) => {
                let found = read_state(gauge, named)?;
                let is_other = found.is_some_and(|state| state != DeviceState::Executing);
                (in_state(found), is_other.then_some(Unmet::NotExecuting { found }))
            }
            Self::Emission(status) => {
                let reading = gauge.read_parameter(status)?;
                let is_off = reading.value == Value::Integer(0);
                (format!("it is {}", reading.text), is_off.then_some(Unmet::EmissionOff))
            }
            Self::NoDegas(status) => {
                let reading = gauge.read_parameter(status)?;
                let is_running = reading.value != Value::Integer(0);
                (format!("degas is {}", reading.text), is_running.then_some(Unmet::Degassing))
            }
            Self::Below(value, limit_pa) => evaluate_pressure(gauge, value, *limit_pa)?,
        })
    }
}

fn evaluate_pressure<R: Records>(
    gauge: &mut Gauge<R>,
    value: &NamedParameter,
    limit_pa: f64,
) -> Result<(String, Option<Unmet>), ClientError> {
    let parameter = value.name.clone();
    let reading = gauge.pressure_of(value)?;
    Ok(match (reading.quality, reading.pa, reading.limit_pa) {
        (Quality::Valid, Some(pa), _) => {
            let is_too_high = pa >= limit_pa || pa.is_nan();
            let unmet = is_too_high.then_some(Unmet::PressureTooHigh { parameter, pa, limit_pa });
            (format!("it is {}", mbar(pa)), unmet)
        }
        // The pressure is below the range of the part, so it is below a limit within the range.
        (Quality::Underrange, _, Some(end)) if end <= limit_pa => (format!("it is below {}", mbar(end)), None),
        _ => ("it is not valid now".to_owned(), Some(Unmet::NoPressure { parameter, limit_pa })),
    })
}

fn in_state(state: Option<DeviceState>) -> String {
    format!("it is in {}", state_name(state))
}

fn read_state<R: Records>(gauge: &mut Gauge<R>, named: &NamedParameter) -> Result<Option<DeviceState>, ClientError> {
    let reading = gauge.read_parameter(named)?;
    Ok(STATES.into_iter().find(|state| reading.value == Value::Integer(state.code().into())))
}
