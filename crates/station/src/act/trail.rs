//! What the audit trail says of an act.

use super::draft::{Choice, Done, Draft, Refusal};
use super::mastership::Change;
use super::orders::Order;
use super::{Actor, Leave};
use crate::people::Person;
use crate::view::Gauge;
use profivac_recorder::{Deed, Entry, Micros};

/// A row about nothing yet.
fn row(what: Deed, person: &Person) -> Entry {
    Entry {
        at: Micros::now(),
        what,
        of: None,
        who: person.name.to_string(),
        role: person.role.to_string(),
        peer: None,
        gauge: None,
        segment: None,
        address: None,
        target: None,
        before: None,
        after: None,
        outcome: None,
        order: None,
    }
}

impl Actor {
    /// A row about something they did.
    #[must_use]
    pub fn row(&self, what: Deed) -> Entry {
        Entry { peer: self.peer.map(|peer| peer.to_string()), ..row(what, &self.person) }
    }
}

fn about(entry: Entry, gauge: &Gauge) -> Entry {
    let Gauge { name, segment, address, .. } = gauge;
    Entry { gauge: Some(name.clone()), segment: Some(segment.clone()), address: Some(*address), ..entry }
}

fn with(entry: Entry, choice: &Choice, draft: &Draft) -> Entry {
    let before = draft.before.as_ref().map(|(text, _)| text.clone());
    Entry { target: Some(choice.manual()), before, after: Some(draft.after.clone()), ..entry }
}

/// An order: fired, or disarmed.
pub fn of(actor: &Actor, gauge: Option<&Gauge>, order: &Order, what: Deed) -> Entry {
    let entry = actor.row(what);
    let entry = match gauge {
        Some(gauge) => about(entry, gauge),
        None => Entry { gauge: Some(order.gauge.clone()), ..entry },
    };
    Entry { order: Some(order.id.clone()), ..with(entry, &order.choice, &order.draft) }
}

/// What came of what the row `of` says.
pub fn outcome(fired: Entry, of: i64, came: &Result<Done, Refusal>, words: &str) -> Entry {
    let (before, after) = match came {
        Ok(Done { before, after }) => (before.clone(), after.clone()),
        Err(_) => (fired.before, None),
    };
    let outcome = Some(words.to_owned());
    Entry { at: Micros::now(), what: Deed::Outcome, of: Some(of), before, after, outcome, ..fired }
}

/// Nothing was armed.
pub fn refused(actor: &Actor, gauge: &Gauge, choice: &Choice, draft: &Draft, why: String) -> Entry {
    Entry { outcome: Some(why), ..with(about(actor.row(Deed::Refused), gauge), choice, draft) }
}

/// The mastership.
pub fn passed(actor: &Actor, change: &Change) -> Entry {
    let sentence = match change {
        Change::Taken | Change::Kept => "has taken the mastership, which was free".to_owned(),
        Change::Asked => "has asked for the mastership".to_owned(),
        Change::Released => "has released the mastership".to_owned(),
        Change::Granted(name) => format!("has granted the mastership to {name}"),
        Change::TakenOver(name) => format!("has taken the mastership over from {name}"),
    };
    Entry { outcome: Some(sentence), ..actor.row(Deed::Mastership) }
}

/// Its holder did nothing for long.
pub fn lapsed(person: &Person) -> Entry {
    let sentence = "has lost the mastership by doing nothing for 15 minutes";
    Entry { outcome: Some(sentence.to_owned()), ..row(Deed::Mastership, person) }
}

/// Its holder has gone.
pub fn gone(person: &Person, why: Leave) -> Entry {
    let sentence = match why {
        Leave::Gone => "has left, and the mastership is free",
        Leave::Role => "has another role, and the mastership is free",
    };
    Entry { outcome: Some(sentence.to_owned()), ..row(Deed::Mastership, person) }
}
