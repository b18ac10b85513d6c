//! The conditions of a command: the state diagram, and the conditions that the manual prints beside its codes.
//!
//! The client checks them before it sends a command, because the refusal of a device does not name the condition.

use super::Gauge;
use crate::error::{ClientError, FoundPressure, PressureLimit, STATES, Unmet, source_states, state_name};
use crate::names::{NamedParameter, ParameterNames};
use crate::records::Records;
use crate::values::Value;
use profivac_devices::model::{AccessPath, Code, Codes, Direction, Precondition, Role};
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
    DegasOff(&'a NamedParameter),
    /// A Process Value is on one side of a limit.
    Pressure(&'a NamedParameter, PressureLimit),
    /// A Process Value is below a part of a Full Scale.
    BelowPartOf { value: &'a NamedParameter, full_scale: &'a NamedParameter, part: f64 },
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
    let (names, via) = (gauge.names(), gauge.records().via());
    let condition = |requirement: &Requirement<'_>| {
        let (found, unmet) = requirement.evaluate(gauge)?;
        Ok(Condition { required: requirement.text(), found, unmet: unmet.map(|unmet| unmet.to_string()) })
    };
    requirements(&names, named, code).iter().filter(|it| it.is_readable(via)).map(condition).collect()
}

/// Fails with [`ClientError::Condition`] at the first condition of a code that is not met.
pub(super) fn check<R: Records>(
    gauge: &mut Gauge<R>,
    named: &NamedParameter,
    code: Option<&'static Code>,
) -> Result<(), ClientError> {
    let Some(code) = code else { return Ok(()) };
    let (names, via) = (gauge.names(), gauge.records().via());
    for requirement in requirements(&names, named, code).into_iter().filter(|it| it.is_readable(via)) {
        if let (_, Some(unmet)) = requirement.evaluate(gauge)? {
            return Err(ClientError::Condition { location: gauge.context(named), command: code.name, unmet });
        }
    }
    Ok(())
}

/// The conditions of a code that the device can report. A parameter that the device does not have is no condition.
fn requirements<'a>(names: &'a ParameterNames, named: &'a NamedParameter, code: &'static Code) -> Vec<Requirement<'a>> {
    let (slot, index) = DEVICE_STATE;
    let state = names.at(slot, 0, index);
    let transition = state.zip(event(named, code)).map(|(state, event)| Requirement::Transition(state, event));
    let own = named.parameter.location.instance;
    let parameter = |instance: Option<u8>, role| parameter_of_instance(names, named, instance.unwrap_or(own), role);
    let preconditions =
        code.preconditions.iter().filter_map(|precondition| match *precondition {
            Precondition::Executing => state.map(Requirement::Executing),
            Precondition::EmissionOn => parameter(None, Role::EmissionStatus).map(Requirement::Emission),
            Precondition::DegasOff => parameter(None, Role::DegasStatus).map(Requirement::DegasOff),
            Precondition::PressureBelow(instance, pa) => parameter(instance, Role::ProcessValue)
                .map(|value| Requirement::Pressure(value, PressureLimit::Below(pa))),
            Precondition::PressureAbove(instance, pa) => parameter(instance, Role::ProcessValue)
                .map(|value| Requirement::Pressure(value, PressureLimit::Above(pa))),
            Precondition::BelowPartOfFullScale(part) => parameter(None, Role::ProcessValue)
                .zip(parameter(None, Role::FullScale))
                .map(|(value, full_scale)| Requirement::BelowPartOf { value, full_scale, part }),
        });
    transition.into_iter().chain(preconditions).collect()
}

/// The event of the state diagram that a code of Device Block State Command triggers.
fn event(named: &NamedParameter, code: &'static Code) -> Option<StateEvent> {
    let row = named.parameter.row;
    let is_state_command = (named.parameter.location.slot, row.index) == STATE_COMMAND;
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
    let slot = named.parameter.location.slot;
    names.all().iter().find(|other| {
        let location = other.parameter.location;
        (location.slot, location.instance) == (slot, instance) && other.parameter.row.role == Some(role)
    })
}

impl Requirement<'_> {
    fn text(&self) -> String {
        match self {
            Self::Transition(_, event) => format!("the gauge is in {}", source_states(*event)),
            Self::Executing(_) => "the gauge is in EXECUTING".to_owned(),
            Self::Emission(_) => "the emission is on".to_owned(),
            Self::DegasOff(_) => "no degas runs".to_owned(),
            Self::Pressure(value, limit) => format!("{} is {limit}", value.name),
            Self::BelowPartOf { value, part, .. } => {
                format!("{} is below {} % of its full scale", value.name, part * 100.0)
            }
        }
    }

    /// Whether a service reads what the requirement needs. The device decides about the others.
    fn is_readable(&self, via: AccessPath) -> bool {
        let is_readable = |named: &NamedParameter| named.parameter.row.access.allows(via, Direction::Read);
        match self {
            Self::Transition(named, _)
            | Self::Executing(named)
            | Self::Emission(named)
            | Self::DegasOff(named)
            | Self::Pressure(named, _) => is_readable(named),
            Self::BelowPartOf { value, full_scale, .. } => is_readable(value) && is_readable(full_scale),
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
            Self::DegasOff(status) => {
                let reading = gauge.read_parameter(status)?;
                let is_off = reading.value == Value::Integer(0);
                (format!("it is {}", reading.text), (!is_off).then_some(Unmet::DegasRuns))
            }
            Self::Pressure(value, limit) => evaluate_pressure(gauge, value, *limit)?,
            Self::BelowPartOf { value, full_scale, part } => {
                let reading = gauge.read_parameter(full_scale)?;
                match gauge.pressure_pa(&reading) {
                    Some(full_scale_pa) => evaluate_pressure(gauge, value, PressureLimit::Below(full_scale_pa * part))?,
                    // A full scale that is no pressure sets no limit: the device decides.
                    None => ("its full scale is not known".to_owned(), None),
                }
            }
        })
    }
}

fn evaluate_pressure<R: Records>(
    gauge: &mut Gauge<R>,
    value: &NamedParameter,
    limit: PressureLimit,
) -> Result<(String, Option<Unmet>), ClientError> {
    let parameter = value.name.clone();
    let reading = gauge.pressure_of(value)?;
    let found = match (reading.quality, reading.pa, reading.limit_pa) {
        (Quality::Valid, Some(pa), _) => Some(FoundPressure::At(pa)),
        (Quality::Underrange, _, Some(end)) => Some(FoundPressure::Below(end)),
        (Quality::Overrange, _, Some(end)) => Some(FoundPressure::Above(end)),
        _ => None,
    };
    Ok(match found.and_then(|found| Some((found, limit.is_met_by(found)?))) {
        Some((found, true)) => (format!("it is {found}"), None),
        Some((found, false)) => (format!("it is {found}"), Some(Unmet::WrongPressure { parameter, found, limit })),
        None => ("it is not valid now".to_owned(), Some(Unmet::NoPressure { parameter, limit })),
    })
}

fn in_state(state: Option<DeviceState>) -> String {
    format!("it is in {}", state_name(state))
}

fn read_state<R: Records>(gauge: &mut Gauge<R>, named: &NamedParameter) -> Result<Option<DeviceState>, ClientError> {
    let reading = gauge.read_parameter(named)?;
    Ok(STATES.into_iter().find(|state| reading.value == Value::Integer(state.code().into())))
}
