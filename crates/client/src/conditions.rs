//! What must be the case before a command is sent: the state diagram, and the conditions of the manual beside its codes.
//! Asked before, because a refusal afterwards says much less.

use super::error::ClientError;
use super::gauge::Gauge;
use super::names::{Named, Names};
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

/// A condition of a command, and whether it holds now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Condition {
    /// What must be the case.
    pub wanted: String,
    /// What is the case.
    pub found: String,
    /// Why it is not met and what to do; nothing if it is.
    pub unmet: Option<String>,
}

/// What is asked of a gauge before a command.
enum Ask<'a> {
    /// An arrow of the state diagram begins at the state the gauge is in.
    Arrow(&'a Named, Event),
    /// It measures.
    Executing(&'a Named),
    /// Emission Status is not off.
    Emission(&'a Named),
    /// A Process Value is below so many Pa.
    Below(&'a Named, f64),
}

/// The conditions of a code in words, by the tables alone: no gauge is asked.
#[must_use]
pub fn wanted(names: &Names, named: &Named, code: &'static Code) -> Vec<String> {
    asks(names, named, code).iter().map(Ask::wanted).collect()
}

/// All conditions of a code with what is the case now.
///
/// # Errors
/// What reading may lead to.
pub(super) fn all<R: Records>(
    gauge: &mut Gauge<R>,
    named: &Named,
    code: Option<&'static Code>,
) -> Result<Vec<Condition>, ClientError> {
    let Some(code) = code else { return Ok(Vec::new()) };
    let names = gauge.names();
    asks(&names, named, code).iter().map(|ask| ask.look(gauge)).collect()
}

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
    let names = gauge.names();
    for ask in asks(&names, named, code) {
        if let Some(reason) = ask.look(gauge)?.unmet {
            return Err(ClientError::Condition { place: gauge.place(named), command: code.name, reason });
        }
    }
    Ok(())
}

/// What is asked before a code is written. What a device does not have is not asked for.
fn asks<'a>(names: &'a Names, named: &'a Named, code: &'static Code) -> Vec<Ask<'a>> {
    let (slot, index) = DEVICE_STATE;
    let state = names.at(slot, 0, index);
    let arrow = state.zip(event(named, code)).map(|(state, event)| Ask::Arrow(state, event));
    let needs = code.needs.iter().filter_map(|need| match *need {
        Need::Executing => state.map(Ask::Executing),
        Need::Emission => {
            beside(names, named, named.parameter.place.instance, |name| name == "Emission Status").map(Ask::Emission)
        }
        Need::Below(instance, pa) => {
            let instance = instance.unwrap_or(named.parameter.place.instance);
            beside(names, named, instance, |name| name.contains("Value (PV)")).map(|value| Ask::Below(value, pa))
        }
    });
    arrow.into_iter().chain(needs).collect()
}

/// The event of the state diagram that a code of Device Block State Command is.
fn event(named: &Named, code: &'static Code) -> Option<Event> {
    let row = named.parameter.row;
    let is_state_command = (named.parameter.place.slot, row.id) == STATE_COMMAND;
    let number = u8::try_from(code.number).ok().filter(|_| is_state_command && matches!(row.codes, Codes::Commands(_)));
    Event::of_command(number?).ok().flatten()
}

/// The parameter with this name in the same slot, of this instance.
fn beside<'a>(names: &'a Names, named: &Named, instance: u8, is: impl Fn(&str) -> bool) -> Option<&'a Named> {
    let slot = named.parameter.place.slot;
    names.all().iter().find(|other| {
        let place = other.parameter.place;
        (place.slot, place.instance) == (slot, instance) && is(other.parameter.row.name)
    })
}

impl Ask<'_> {
    /// In words.
    fn wanted(&self) -> String {
        match self {
            Self::Arrow(_, event) => format!("the gauge is in {}", beginnings(*event)),
            Self::Executing(_) => "the gauge is in EXECUTING".to_owned(),
            Self::Emission(_) => "the emission is on".to_owned(),
            Self::Below(value, pa) => format!("{} is below {}", value.name, mbar(*pa)),
        }
    }

    /// Asks the gauge.
    fn look<R: Records>(&self, gauge: &mut Gauge<R>) -> Result<Condition, ClientError> {
        let (found, unmet) = match self {
            Self::Arrow(named, event) => {
                let state = state(gauge, named)?;
                let stays = state.is_some_and(|state| state.after(*event).is_err());
                let from = beginnings(*event);
                (
                    format!("it is in {}", state_name(state)),
                    stays
                        .then(|| format!("the gauge is in {}, and it is possible from {from} only", state_name(state))),
                )
            }
            Self::Executing(named) => {
                let state = state(gauge, named)?;
                let idles = state.is_some_and(|state| state != State::Executing);
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
        Ok(Condition { wanted: self.wanted(), found, unmet })
    }
}

/// What is found of a pressure that must be below a limit, and why that is not met.
fn pressure<R: Records>(
    gauge: &mut Gauge<R>,
    value: &Named,
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
    format!("{} mbar", number(pa / 100.0))
}

fn state<R: Records>(gauge: &mut Gauge<R>, named: &Named) -> Result<Option<State>, ClientError> {
    let reading = gauge.read(named)?;
    Ok(STATES.into_iter().find(|state| reading.value == Value::Integer(state.code().into())))
}

const fn state_name(state: Option<State>) -> &'static str {
    match state {
        Some(state) => state.name(),
        None => "no known state",
    }
}

/// The states from which an arrow of the state diagram begins.
fn beginnings(event: Event) -> String {
    let from: Vec<_> = STATES.into_iter().filter(|state| state.after(event).is_ok()).map(State::name).collect();
    from.join(", ")
}
