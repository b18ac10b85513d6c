//! What must be the case before a command is sent: the state diagram, and the conditions of the manual beside its codes.
//! Asked before, because a refusal afterwards says much less.

use super::error::ClientError;
use super::gauge::Gauge;
use super::names::Named;
use super::records::Records;
use super::values::{Value, number};
use profivac_devices::model::{Code, Codes, Need};
use profivac_devices::profile::{Event, State};

/// Slot and index of Device State in every block device.
const DEVICE_STATE: (u8, u8) = (0, 25);

/// Slot and index of Device Block State Command.
const STATE_COMMAND: (u8, u8) = (0, 15);

/// The states by their codes.
const STATES: [State; 6] =
    [State::SelfTesting, State::Idle, State::SelfTestException, State::Executing, State::Abort, State::CriticalFault];

/// Checks the conditions of a code.
///
/// # Errors
/// [`ClientError::Condition`] says what is missing.
pub(super) fn check<R: Records>(
    gauge: &mut Gauge<R>,
    named: &Named,
    code: Option<&'static Code>,
) -> Result<(), ClientError> {
    let Some(code) = code else { return Ok(()) };
    let place = named.parameter.place;
    let is_state_command = (place.slot, named.parameter.row.id) == STATE_COMMAND;
    if is_state_command
        && matches!(named.parameter.row.codes, Codes::Commands(_))
        && let Some(reason) = by_diagram(gauge, code)?
    {
        return Err(ClientError::Condition { place: gauge.place(named), command: code.name, reason });
    }
    for need in code.needs {
        if let Some(reason) = unmet(gauge, named, *need)? {
            return Err(ClientError::Condition { place: gauge.place(named), command: code.name, reason });
        }
    }
    Ok(())
}

fn device_state<R: Records>(gauge: &mut Gauge<R>) -> Result<Option<State>, ClientError> {
    let (slot, index) = DEVICE_STATE;
    let names = gauge.names();
    let Some(named) = names.at(slot, 0, index) else { return Ok(None) };
    let reading = gauge.read(named)?;
    Ok(STATES.into_iter().find(|state| reading.value == Value::Integer(state.code().into())))
}

/// Whether an arrow of the state diagram begins here.
fn by_diagram<R: Records>(gauge: &mut Gauge<R>, code: &'static Code) -> Result<Option<String>, ClientError> {
    let event = u8::try_from(code.number).ok().and_then(|number| Event::of_command(number).ok()).flatten();
    let (Some(state), Some(event)) = (device_state(gauge)?, event) else { return Ok(None) };
    if state.after(event).is_ok() {
        return Ok(None);
    }
    let from: Vec<_> = STATES.into_iter().filter(|state| state.after(event).is_ok()).map(State::name).collect();
    Ok(Some(format!("the gauge is in {}, and it is possible from {} only", state.name(), from.join(", "))))
}

/// What is missing of a condition.
fn unmet<R: Records>(gauge: &mut Gauge<R>, named: &Named, need: Need) -> Result<Option<String>, ClientError> {
    Ok(match need {
        Need::Executing => {
            let state = device_state(gauge)?;
            let executing = state.is_none_or(|state| state == State::Executing);
            let name = state.map_or("no known state", State::name);
            (!executing).then(|| format!("the gauge is in {name} and must be in EXECUTING; write execute first"))
        }
        Need::Emission => {
            let Some(status) = beside(gauge, named, |name| name == "Emission Status") else { return Ok(None) };
            let off = gauge.read(&status)?.value == Value::Integer(0);
            off.then(|| "the emission is off; it must be on".to_owned())
        }
        Need::Below(instance, pa) => too_high(gauge, named, instance, pa)?,
    })
}

fn too_high<R: Records>(
    gauge: &mut Gauge<R>,
    named: &Named,
    instance: Option<u8>,
    limit_pa: f64,
) -> Result<Option<String>, ClientError> {
    let place = named.parameter.place;
    let instance = instance.unwrap_or(place.instance);
    let names = gauge.names();
    let value = names.all().iter().find(|other| {
        let other_place = other.parameter.place;
        (other_place.slot, other_place.instance) == (place.slot, instance)
            && other.parameter.row.name.contains("Value (PV)")
    });
    let Some(value) = value else { return Ok(None) };
    let pressure = gauge.pressure_of(value)?;
    let limit = format!("{} mbar", number(limit_pa / 100.0));
    Ok(match pressure.pa {
        Some(pa) if pa < limit_pa => None,
        Some(pa) => {
            Some(format!("{} is {} mbar and must be below {limit}; pump down first", value.name, number(pa / 100.0)))
        }
        None => Some(format!("{} is not valid now, and must be below {limit}", value.name)),
    })
}

/// The parameter with this name at the same place.
fn beside<R: Records>(gauge: &Gauge<R>, named: &Named, is: impl Fn(&str) -> bool) -> Option<Named> {
    let names = gauge.names();
    let found = names.all().iter().find(|other| other.is_beside(named) && is(other.parameter.row.name));
    found.cloned()
}
