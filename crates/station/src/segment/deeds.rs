//! What is done to a gauge beside the cycle: a draft of it first, and the deed itself when it was fired.

use crate::act::allowed;
use crate::act::draft::{Choice, Done, Draft, Refusal};
use crate::act::orders::Order;
use profivac_client::records::Records;
use profivac_client::watch::Watched;
use profivac_client::{self, ClientError, Doing, Gauge, Severity};

/// What the gauge says to what somebody wants. Nothing is changed.
pub fn draft<R: Records>(name: &str, watched: &Watched, records: R, choice: &Choice) -> Result<Draft, Refusal> {
    let mut gauge = open(name, watched, records)?;
    let drafted = drafted(&mut gauge, choice).map(|(_, draft)| draft);
    // The instance that was shown before is shown again, if the gauge still answers.
    gauge.finish().ok();
    drafted
}

/// Carries out what was armed, if everything is as it was then.
pub fn carry_out<R: Records>(watched: &Watched, records: R, order: &Order) -> Result<Done, Refusal> {
    let (was, is) = ((order.draft.device, order.draft.address), (watched.model.name, watched.address));
    if was != is {
        let sentence = format!(
            "{} was {} at address {} when it was armed and is {} at {} now",
            order.gauge, was.0, was.1, is.0, is.1
        );
        return Err(Refusal::Changed(sentence));
    }
    let mut gauge = open(&order.gauge, watched, records)?;
    let done = carried_out(&mut gauge, order);
    gauge.finish().ok();
    done
}

/// MS2 alone: the parameter channel is not part of the data that the station exchanges.
fn open<R: Records>(name: &str, watched: &Watched, records: R) -> Result<Gauge<R>, Refusal> {
    if !watched.model.features.dpv1 {
        let sentence = format!(
            "{name} has no DP-V1, and the data the station exchanges with it have no parameter channel: take it out of the \
             station's file and use `profivac write --via pkw`"
        );
        return Err(Refusal::Away(sentence));
    }
    Ok(Gauge::known(records, watched.address, watched.model).in_unit(watched.unit))
}

fn drafted<R: Records>(gauge: &mut Gauge<R>, choice: &Choice) -> Result<(profivac_client::Order, Draft), Refusal> {
    let order = gauge.draft(&choice.named, &choice.text).map_err(|error| before_sending(&error))?;
    let conditions = gauge.conditions(&order).map_err(|error| before_sending(&error))?;
    let draft = Draft {
        device: gauge.model().name,
        address: gauge.address(),
        octets: order.octets.clone(),
        before: order.before.as_ref().map(|before| (before.text.clone(), before.octets.clone())),
        after: order.text.clone(),
        risk: allowed::risk(choice.named.parameter.row, order.code),
        conditions,
    };
    Ok((order, draft))
}

fn carried_out<R: Records>(gauge: &mut Gauge<R>, order: &Order) -> Result<Done, Refusal> {
    let (now, draft) = drafted(gauge, &order.choice)?;
    if draft.conditions.iter().any(|condition| condition.unmet.is_some()) {
        return Err(Refusal::Unmet(draft.conditions));
    }
    if let Some(sentence) = changed(order, &draft) {
        return Err(Refusal::Changed(sentence));
    }
    let before = draft.before.map(|(text, _)| text);
    match gauge.carry_out(now) {
        Ok(written) => Ok(Done { before, after: written.after.map(|after| after.text) }),
        Err(error) => Err(after_sending(&error)),
    }
}

/// What is not as it was when it was armed.
fn changed(order: &Order, now: &Draft) -> Option<String> {
    let (was, is) = (&order.draft, now);
    let words = |before: &Option<(String, Vec<u8>)>| before.as_ref().map_or("unreadable", |(text, _)| text).to_owned();
    if was.before != is.before {
        return Some(format!(
            "{} was {} when it was armed and is {} now",
            order.choice.named.name,
            words(&was.before),
            words(&is.before)
        ));
    }
    (was.octets != is.octets)
        .then(|| format!("{} meant {} when it was armed and means {} now", order.choice.text, was.after, is.after))
}

/// Nothing was sent yet.
fn before_sending(error: &ClientError) -> Refusal {
    match error {
        ClientError::Value { .. } | ClientError::Target(_) | ClientError::Access { .. } => {
            Refusal::Value(error.to_string())
        }
        _ => Refusal::Away(error.to_string()),
    }
}

fn after_sending(error: &ClientError) -> Refusal {
    match error {
        ClientError::Refused { doing: Doing::Writing, .. } => Refusal::Refused(error.to_string()),
        _ if error.severity() == Severity::Line => Refusal::Unsure(error.to_string()),
        // It was taken, and is not read back.
        _ => Refusal::Unsure(format!("it was sent and taken, but {error}")),
    }
}
