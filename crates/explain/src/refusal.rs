//! Why a slave refused its parameters or its configuration, as far as the telegrams and its tables show.

use super::slave::Slave;
use profivac_devices::model::{AccessError, Configuration, Model};
use profivac_sim::describe::Hex;
use profivac_wire::cfg::lengths;
use profivac_wire::prm::{PrmStatus, SetPrm};

/// Why Set_Prm was refused. `ident` is that of the slave.
pub(super) fn parameters(slave: &Slave, ident: u16) -> String {
    let Ok(prm) = SetPrm::parse(&slave.prm.octets) else { return "it is too short".to_owned() };
    let mut reasons = Vec::new();
    if prm.ident != ident {
        reasons.push(format!("the master asked for ident {:04X}, this slave has {ident:04X}", prm.ident));
    }
    if prm.status.contains(PrmStatus::WD_ON) && prm.wd_fact.contains(&0) {
        reasons.push("the watchdog is on and one of its factors is 0".to_owned());
    }
    if let Some(model) = slave.tables.model.filter(|_| prm.ident == ident) {
        reasons.extend(by_tables(&prm, model));
    }
    if reasons.is_empty() {
        "the slave does not say why, and no reason is visible".to_owned()
    } else {
        reasons.join("; ")
    }
}

fn by_tables(prm: &SetPrm<'_>, model: &'static Model) -> Vec<String> {
    let mut reasons = Vec::new();
    let missing = |wanted, has: bool| prm.status.contains(wanted) && !has;
    if missing(PrmStatus::SYNC_REQ, model.features.sync) {
        reasons.push(format!("a {} has no Sync", model.name));
    }
    if missing(PrmStatus::FREEZE_REQ, model.features.freeze) {
        reasons.push(format!("a {} has no Freeze", model.name));
    }
    if !model.user_prm.is_empty() && model.user_prm(prm.user).is_none() {
        let known = model.user_prm.iter().map(|prm| format!("{} ({})", Hex(prm.octets), prm.name));
        let known: Vec<String> = known.take(3).collect();
        let came = if prm.user.is_empty() { "none".to_owned() } else { Hex(prm.user).to_string() };
        reasons.push(format!(
            "a {} takes user parameters such as {}, the master sent {came}",
            model.name,
            known.join(", ")
        ));
    }
    reasons
}

/// Why Chk_Cfg was refused: what is offered, what was asked for, and where they differ.
pub(super) fn configuration(slave: &Slave) -> String {
    let (asked, who) = (&slave.asked[..], slave.name());
    let asked_for = format!("the master asked for {}", Hex(asked));
    let usual = slave.tables.model.map(|model| model.default_configuration.octets);
    let Some(offered) = slave.offered.as_deref().or(usual) else {
        return format!("{who} does not say what it offers, {asked_for}");
    };
    let others = slave.tables.model.map_or(0, |model| model.configurations.len().saturating_sub(1));
    let others = if others == 0 { String::new() } else { format!(" and {others} others") };
    let near = slave.tables.model.and_then(|model| nearest(model, asked)).map_or(offered, |near| near.octets);
    let near = if near == offered {
        difference(near, asked)
    } else {
        format!("; the nearest is {}{}", Hex(near), difference(near, asked))
    };
    format!("{who} offers {}{others}, {asked_for}{near}", Hex(offered))
}

/// The configuration with the longest equal beginning and end.
fn nearest(model: &'static Model, asked: &[u8]) -> Option<&'static Configuration> {
    let equal = |configuration: &&Configuration| {
        let octets = configuration.octets;
        let front = octets.iter().zip(asked).take_while(|(left, right)| left == right).count();
        let back = octets.iter().rev().zip(asked.iter().rev()).take_while(|(left, right)| left == right).count();
        front.saturating_add(back)
    };
    model.configurations.iter().max_by_key(equal).filter(|near| equal(near) > 0)
}

/// The first octet that differs, and how many are exchanged if that is another number.
fn difference(near: &[u8], asked: &[u8]) -> String {
    let place = near.iter().zip(asked).position(|(left, right)| left != right);
    let octet = match place {
        Some(place) if near.len() == asked.len() => {
            let [expected, came] = [near, asked].map(|octets| octets.get(place).copied().unwrap_or_default());
            format!("; octet {} is {came:02X} and should be {expected:02X}", place.saturating_add(1))
        }
        _ => String::new(),
    };
    match (lengths(near), lengths(asked)) {
        (Ok(right), Ok(wrong)) if right != wrong => {
            let [right, wrong] = [right, wrong].map(|sum| format!("{} octets out and {} in", sum.outputs, sum.inputs));
            format!("{octet}; {right} instead of {wrong}")
        }
        _ => octet,
    }
}

/// The refusals of the parameter channel, in words.
const CHANNEL: [(AccessError, &str); 12] = [
    (AccessError::UnknownSlot, "there is no such slot"),
    (AccessError::UnknownIndex, "there is no such index"),
    (AccessError::NotWritable, "it cannot be written"),
    (AccessError::OutOfRange, "the value is out of range"),
    (AccessError::WrongLength, "the length is wrong"),
    (AccessError::NotInChannel, "a text cannot travel this way"),
    (AccessError::WrongMode, "not in this operating mode"),
    (AccessError::AlreadyInState, "already in that state"),
    (AccessError::StateConflict, "not in this state"),
    (AccessError::NotReadable, "it cannot be read, or another error"),
    (AccessError::StorageFailed, "the memory has failed"),
    (AccessError::UnknownTask, "there is no such instruction"),
];

/// What an error code of the parameter channel means for a device.
pub(super) fn channel_code(model: &Model, code: u8) -> &'static str {
    let known = CHANNEL.iter().find(|(refusal, _)| model.channel_rules.error_code(*refusal) == code);
    known.map_or("an unknown error", |(_, words)| *words)
}
