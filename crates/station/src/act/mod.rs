//! Acting on gauges: commands and parameters in two steps, by one person at a time, each on the disk before it is sent.
//!
//! ```text
//! arm ── the gauge is asked, conditions hold ── armed for 30 s ── fire ── "fired" is on the disk ── conditions and the value
//!                                                                             before again ── sent ── "outcome" on the disk
//! ```
//!
//! | Module | Holds |
//! |---|---|
//! | [`mod@mastership`] | who may act now |
//! | [`orders`] | what is armed |
//! | [`draft`] | what somebody wants, what the gauge says to it, what came of it |
//! | [`allowed`] | risks, roles, and what nobody may |
//! | `trail` | what the audit trail says of it |

pub mod allowed;
pub mod draft;
pub mod mastership;
pub mod orders;
mod trail;

use crate::people::{Person, Role};
use crate::plant::{NoAnswer, Plant};
use crate::view::{self, Gauge};
use draft::{Choice, Done, Refusal, Wish};
use mastership::{Change, Mastership, NotYours};
use orders::{ARMED, NotArmed, Order, Orders};
use profivac_client::Condition;
use profivac_recorder::{Deed, EventKind, Micros, Written};
use profivac_virtual::factory::entry;
use std::net::IpAddr;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A segment that has not begun with what was fired after so long does not begin any more: nobody expects it by then.
const BEGIN: Duration = Duration::from_secs(10);

/// Somebody who acts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Actor {
    /// Who.
    pub person: Person,
    /// From where, if it is known.
    pub peer: Option<IpAddr>,
}

/// Why something was not done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotDone {
    /// There is no such gauge, or no such order.
    #[error("{0}")]
    Unknown(String),
    /// It makes no sense.
    #[error("{0}")]
    Bad(String),
    /// Their role does not allow it.
    #[error("{0}")]
    Forbidden(String),
    /// It cannot be done now, and with which conditions.
    #[error("{0}")]
    Conflict(String, Vec<Condition>),
    /// The audit trail cannot be kept, so nothing was done.
    #[error("nothing was sent, because the audit trail cannot be written: {0}")]
    Disk(String),
}

impl From<NotYours> for NotDone {
    fn from(error: NotYours) -> Self {
        Self::Conflict(error.to_string(), Vec::new())
    }
}

impl From<NotArmed> for NotDone {
    fn from(error: NotArmed) -> Self {
        match error {
            NotArmed::Unknown(_) => Self::Unknown(error.to_string()),
            NotArmed::Others(_) => Self::Forbidden(error.to_string()),
            NotArmed::Ended(_) | NotArmed::Many => Self::Conflict(error.to_string(), Vec::new()),
        }
    }
}

impl From<Refusal> for NotDone {
    fn from(refusal: Refusal) -> Self {
        let sentence = refusal.to_string();
        match refusal {
            Refusal::Value(_) => Self::Bad(sentence),
            Refusal::Unmet(conditions) => Self::Conflict(sentence, conditions),
            Refusal::Changed(_) | Refusal::Away(_) | Refusal::Refused(_) | Refusal::Unsure(_) => {
                Self::Conflict(sentence, Vec::new())
            }
        }
    }
}

impl From<NoAnswer> for Refusal {
    fn from(error: NoAnswer) -> Self {
        Self::Away(error.to_string())
    }
}

/// What somebody may do with the mastership.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Move {
    /// Have it, or let its holder know that one wants it.
    Ask,
    /// Give it back.
    Release,
    /// Give it to who asked.
    Grant,
    /// Take it from its holder.
    TakeOver,
}

/// Who may act, and what is armed.
#[derive(Default)]
pub struct Acts {
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    mastership: Mastership,
    orders: Orders,
    armed: u64,
}

impl Acts {
    fn locked(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The state at `now`.
fn at(plant: &Plant, now: Instant) -> MutexGuard<'_, State> {
    let mut state = plant.acts().locked();
    if let Some(person) = state.mastership.pass(now) {
        state.orders.clear();
        plant.recorder().audit(trail::lapsed(&person));
    }
    state.orders.pass(now);
    state
}

/// Who has the mastership.
#[must_use]
pub fn mastership(plant: &Plant, now: Instant) -> view::Mastership {
    let state = at(plant, now);
    let ago = |since: Instant| {
        let ago = view::whole_milliseconds(now.saturating_duration_since(since));
        view::milliseconds(Micros::now()).saturating_sub_unsigned(ago)
    };
    let holder = state.mastership.holder();
    let wish = holder.and_then(|holder| holder.wish.as_ref());
    view::Mastership {
        holder: holder.map(|holder| holder.person.name.to_string()),
        since_ms: holder.map(|holder| ago(holder.since)),
        asked_by: wish.map(|(person, _)| person.name.to_string()),
        asked_ms: wish.map(|(_, since)| ago(*since)),
    }
}

/// Somebody wants something with the mastership.
///
/// # Errors
/// [`NotDone`]: a viewer, or somebody whose it is not.
pub fn pass(plant: &Plant, actor: &Actor, wanted: Move, now: Instant) -> Result<(), NotDone> {
    let person = &actor.person;
    may(person, Role::Operator, "the mastership")?;
    let mut state = at(plant, now);
    let mastership = &mut state.mastership;
    let change = match wanted {
        Move::Ask => mastership.ask(person, now),
        Move::Release => mastership.release(person, now),
        Move::Grant => mastership.grant(person, now),
        Move::TakeOver => mastership.take_over(person, now),
    }?;
    if change.changes_hands() {
        state.orders.clear();
    }
    // Rows stand in the order in which things happened: they are handed over before anybody else can do anything.
    let written = (change != Change::Kept).then(|| plant.recorder().audit(trail::passed(actor, &change)));
    drop(state);
    wait(written);
    Ok(())
}

/// Who has the mastership, with the role they had when they got it.
#[must_use]
pub fn holder(plant: &Plant) -> Option<Person> {
    at(plant, Instant::now()).mastership.holder().map(|holder| holder.person.clone())
}

/// Why somebody does not act any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leave {
    /// Their last session has ended: they logged out, were away for too long, or are no user any more.
    Gone,
    /// They have another role.
    Role,
}

/// Somebody does not act any more: what they held is free, and what they armed is not armed any more.
pub fn gone(plant: &Plant, name: &str, why: Leave) {
    let mut state = at(plant, Instant::now());
    if let Some(holder) = state.mastership.gone(name) {
        state.orders.clear();
        plant.recorder().audit(trail::gone(&holder, why));
    }
}

/// Whether what was fired may still be sent: it has waited for its segment, and the mastership may have changed hands meanwhile.
#[must_use]
pub fn may_send(plant: &Plant, order: &Order) -> bool {
    at(plant, Instant::now()).mastership.holder().is_some_and(|holder| holder.person.name == order.by)
}

/// Waits until a row is on the disk, as long as one can. If it is not there then, the recorder keeps it and says so.
fn wait(written: Option<Written>) {
    written.map(Written::wait);
}

fn may(person: &Person, needed: Role, what: &str) -> Result<(), NotDone> {
    person.may(needed, what).map_err(|problem| NotDone::Forbidden(problem.to_string()))
}

/// The first step: the gauge is asked, and if all conditions hold it is armed. Waits for the gauge.
///
/// # Errors
/// [`NotDone`] says why nothing is armed.
pub fn arm(plant: &Plant, actor: &Actor, name: &str, wish: &Wish) -> Result<Order, NotDone> {
    let person = &actor.person;
    let gauge = plant.gauge(name).ok_or_else(|| NotDone::Unknown(format!("there is no gauge {name:?}")))?;
    let model = entry(&gauge.device).map_err(|error| NotDone::Bad(error.to_string()))?.model;
    let choice = Choice::of(model, wish).map_err(NotDone::Bad)?;
    may(person, choice.role(), &choice.target())?;
    if let Some(reason) = choice.barred() {
        return Err(NotDone::Conflict(format!("{}: {reason}", choice.target()), Vec::new()));
    }
    at(plant, Instant::now()).mastership.act(person, Instant::now())?;
    let line = plant.line_of(name).map_err(Refusal::from)?;
    let draft = plant.draft(name, choice.clone())?;
    if draft.conditions.iter().any(|condition| condition.unmet.is_some()) {
        let refusal = Refusal::Unmet(draft.conditions.clone());
        let entry = trail::refused(actor, &gauge, &choice, &draft, refusal.to_string());
        wait(Some(plant.recorder().audit(entry)));
        return Err(refusal.into());
    }
    // Reading takes time: somebody may have taken the mastership over meanwhile.
    let now = Instant::now();
    let mut state = at(plant, now);
    state.mastership.act(person, now)?;
    state.armed = state.armed.saturating_add(1);
    let id = format!("{:x}-{}", plant.started().0, state.armed);
    let by = person.name.clone();
    let order = Order { id, by, gauge: gauge.name, line, choice, draft, until: now + ARMED };
    state.orders.arm(order.clone())?;
    Ok(order)
}

/// Somebody thinks better of it.
///
/// # Errors
/// [`NotDone`] when there is no such order, or it is somebody else's.
pub fn disarm(plant: &Plant, actor: &Actor, id: &str) -> Result<(), NotDone> {
    let order = at(plant, Instant::now()).orders.disarm(id, &actor.person)?;
    let entry = trail::of(actor, plant.gauge(&order.gauge).as_ref(), &order, Deed::Disarmed);
    wait(Some(plant.recorder().audit(entry)));
    Ok(())
}

/// The second step. Waits for the gauge and the disk; whoever calls this in a thread of its own may go meanwhile.
///
/// # Errors
/// [`NotDone`] says why it was not done, or that nobody knows whether it was.
pub fn fire(plant: &Plant, actor: &Actor, id: &str) -> Result<Fired, NotDone> {
    let order = released(plant, actor, id, Instant::now())?;
    let gauge = plant.gauge(&order.gauge);
    let entry = trail::of(actor, gauge.as_ref(), &order, Deed::Fired);
    let row = plant.recorder().intend(entry.clone()).map_err(NotDone::Disk)?;
    let came = plant.fire(order.clone(), Instant::now() + BEGIN);
    let outcome = came.as_ref().map_or_else(Refusal::outcome, |_| "done".to_owned());
    say(plant, actor, gauge.as_ref(), &order, &outcome);
    // If the disk does not take it now, it is kept and tried again.
    wait(Some(plant.recorder().audit(trail::outcome(entry, row, &came, &outcome))));
    Ok(Fired { order, done: came? })
}

/// What was fired, and what came of it.
#[derive(Clone, Debug)]
pub struct Fired {
    /// The order.
    pub order: Order,
    /// What it was, and what it is.
    pub done: Done,
}

/// Takes an order out of what is armed, if this person may fire it now.
fn released(plant: &Plant, actor: &Actor, id: &str, now: Instant) -> Result<Order, NotDone> {
    let mut state = at(plant, now);
    // Whose order has ended wants to know that first, and not that the mastership is gone.
    let known = state.orders.look(id, &actor.person)?;
    may(&actor.person, known.choice.role(), &known.choice.target())?;
    state.mastership.act(&actor.person, now)?;
    Ok(state.orders.fire(id, &actor.person)?)
}

/// The same for the list of events: full rate is recorded around it.
fn say(plant: &Plant, actor: &Actor, gauge: Option<&Gauge>, order: &Order, outcome: &str) {
    let Order { choice, draft, .. } = order;
    let what = match choice.command {
        Some(_) => choice.target(),
        None => format!("{} = {}", choice.target(), draft.after),
    };
    let name = gauge.map(|gauge| gauge.name.as_str());
    let text = format!("{}: {what} by {}: {outcome}", order.gauge, actor.person.name);
    plant.remark(name, EventKind::Command, text);
}
