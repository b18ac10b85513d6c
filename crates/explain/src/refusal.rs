//! Reasons why a slave refused Set_Prm or Chk_Cfg, from the telegrams and the tables of the device.

use super::note::octets;
use profivac_devices::model::{Configuration, Model};
use profivac_gsd::dpv1_status_bits;
use profivac_sim::describe::Hex;
use profivac_wire::cfg::lengths;
use profivac_wire::prm::{PrmStatus, SetPrm};

/// DPV1_Status_1 to 3, at the front of the user parameters.
const DPV1_OCTETS: usize = 3;

/// The reason for Prm_Fault. `octets` is the data unit of Set_Prm; `model` and `ident` are those of the slave.
pub(super) fn set_prm_reason(octets: &[u8], model: Option<&'static Model>, ident: u16) -> String {
    let Ok(prm) = SetPrm::parse(octets) else { return "it is too short".to_owned() };
    let mut reasons = Vec::new();
    if prm.ident != ident {
        reasons.push(format!("the master asked for ident {:04X}, this slave has {ident:04X}", prm.ident));
    }
    if prm.status.contains(PrmStatus::WD_ON) && prm.wd_fact.contains(&0) {
        reasons.push("the watchdog is on and one of its factors is 0".to_owned());
    }
    if let Some(model) = model.filter(|_| prm.ident == ident) {
        reasons.extend(by_tables(&prm, model));
    }
    if reasons.is_empty() {
        "the slave reports no reason, and the telegram shows none".to_owned()
    } else {
        reasons.join("; ")
    }
}

/// The reasons that the tables of the device give.
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
        let sent = if prm.user.is_empty() { "none".to_owned() } else { Hex(prm.user).to_string() };
        reasons.push(format!(
            "a {} takes user parameters such as {}, the master sent {sent}{}",
            model.name,
            known.join(", "),
            foreign_bits(prm.user, model)
        ));
    }
    if reasons.is_empty() {
        reasons.extend(unsaid_bits(prm.user, model));
    }
    reasons
}

/// The bits that the device has in the tables although its manual does not say so: a real one can refuse them. errata-bpg-bcg-tpg 4.
fn unsaid_bits(user: &[u8], model: &'static Model) -> Option<String> {
    let known = model.user_prm(user).filter(|known| model.features.dpv1 && known.octets.len() >= DPV1_OCTETS)?;
    let taken = [model.dpv1_status, 0, 0].into_iter().zip(known.octets).map(|(free, octet)| free | octet);
    let bits = named_bits(user, taken);
    (!bits.is_empty()).then(|| format!("the manual of a {} does not say that it takes {}", model.name, bits.join(", ")))
}

/// The bits of DPV1_Status_1 to 3 in `user` that are not `taken`, by name: `WD_BASE_1MS (04) in DPV1_Status_1`.
fn named_bits(user: &[u8], taken: impl Iterator<Item = u8>) -> Vec<String> {
    let foreign = user.iter().zip(taken).map(|(octet, taken)| octet & !taken).enumerate();
    foreign
        .filter(|(_, bits)| *bits != 0)
        .map(|(octet, bits)| {
            let names = dpv1_status_bits(octet, bits).join(" and ");
            let names = if names.is_empty() { format!("bits {bits:02X}") } else { format!("{names} ({bits:02X})") };
            format!("{names} in DPV1_Status_{}", octet.saturating_add(1))
        })
        .collect()
}

/// The bits of DPV1_Status_1 to 3 that the device does not take, by name: `: it takes no WD_BASE_1MS (04) in DPV1_Status_1`. Empty if
/// there are none, if no string of the device is as long, or if it has no room for the three octets.
fn foreign_bits(user: &[u8], model: &'static Model) -> String {
    let length = user.len();
    let same_length = || model.user_prm.iter().filter(move |prm| prm.octets.len() == length);
    let same_unit = same_length().find(|prm| prm.octets.get(DPV1_OCTETS..) == user.get(DPV1_OCTETS..));
    let has_status = model.features.dpv1 && length >= DPV1_OCTETS;
    let Some(known) = same_unit.or_else(|| same_length().next()).filter(|_| has_status) else {
        return String::new();
    };
    let [first, second] = model.free_bits();
    let taken = [first, second, 0].into_iter().zip(known.octets).map(|(free, octet)| free | octet);
    let bits: Vec<String> = named_bits(user, taken).iter().map(|bits| format!("no {bits}")).collect();
    if bits.is_empty() { String::new() } else { format!(": it takes {}", bits.join(", ")) }
}

/// A configuration that a slave refused.
pub(super) struct RefusedConfiguration<'a> {
    /// The slave in a sentence: `the bcg450`.
    pub(super) slave: &'a str,
    pub(super) model: Option<&'static Model>,
    /// The octets of Get_Cfg, if a master has read them.
    pub(super) offered: Option<&'a [u8]>,
    /// The octets of Chk_Cfg.
    pub(super) requested: &'a [u8],
}

/// The reason for Cfg_Fault: the offered and the requested configuration, and their difference.
pub(super) fn chk_cfg_reason(refused: &RefusedConfiguration<'_>) -> String {
    let RefusedConfiguration { slave, model, offered, requested } = *refused;
    let asked_for = format!("the master asked for {}", Hex(requested));
    let Some(offered) = offered.or(model.map(|model| model.default_configuration.octets)) else {
        return format!("the configuration of {slave} is not known, {asked_for}");
    };
    let others = model.map_or(0, |model| model.configurations.len().saturating_sub(1));
    let others = if others == 0 { String::new() } else { format!(" and {others} others") };
    let near = model.and_then(|model| nearest(model, requested)).map_or(offered, |near| near.octets);
    let near = if near == offered {
        difference(near, requested)
    } else {
        format!("; the nearest is {}{}", Hex(near), difference(near, requested))
    };
    format!("{slave} offers {}{others}, {asked_for}{near}", Hex(offered))
}

/// The configuration with the longest equal beginning and end.
fn nearest(model: &'static Model, requested: &[u8]) -> Option<&'static Configuration> {
    let equal = |configuration: &&Configuration| {
        let octets = configuration.octets;
        let front = octets.iter().zip(requested).take_while(|(left, right)| left == right).count();
        let back = octets.iter().rev().zip(requested.iter().rev()).take_while(|(left, right)| left == right).count();
        front.saturating_add(back)
    };
    model.configurations.iter().max_by_key(equal).filter(|near| equal(near) > 0)
}

/// The first octet that differs if both have the same length, and the numbers of inputs and outputs if they differ.
fn difference(near: &[u8], requested: &[u8]) -> String {
    let index = near.iter().zip(requested).position(|(left, right)| left != right);
    let octet = match index {
        Some(index) if near.len() == requested.len() => {
            let [expected, found] = [near, requested].map(|octets| octets.get(index).copied().unwrap_or_default());
            format!("; octet {} is {found:02X} and should be {expected:02X}", index.saturating_add(1))
        }
        _ => String::new(),
    };
    match (lengths(near), lengths(requested)) {
        (Ok(right), Ok(wrong)) if right != wrong => {
            let [right, wrong] =
                [right, wrong].map(|sum| format!("{} out and {} in", octets(sum.outputs.into()), sum.inputs));
            format!("{octet}; {right} instead of {wrong}")
        }
        _ => octet,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::bcg450::table::MODEL;

    /// The manuals do not name Fail_Safe and Check_Cfg_Mode: a real gauge can refuse what a virtual one takes.
    #[test]
    fn a_gauge_that_refuses_bits_that_its_manual_does_not_name_gets_them_as_the_reason() {
        let reason = |user: &[u8]| {
            let [high, low] = MODEL.ident.to_be_bytes();
            let octets = [&[0x80, 0, 0, 11, high, low, 0][..], user].concat();
            set_prm_reason(&octets, Some(&MODEL), MODEL.ident)
        };
        assert_eq!(
            reason(&[0xC0, 0x01, 0, 0x05, 0x1C]),
            "the manual of a bcg450 does not say that it takes FAIL_SAFE (40) in DPV1_Status_1, CHECK_CFG_MODE (01) in DPV1_Status_2"
        );
        assert_eq!(reason(&[0x80, 0, 0, 0x05, 0x1C]), "the slave reports no reason, and the telegram shows none");
    }
}
