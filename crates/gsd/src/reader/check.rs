//! What a whole file must fulfil.

use super::{Device, Fault, Module, Problem};
use crate::parameter::{PrmArea, PrmContent};
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// The lines that problems of the whole file name; none if the file lacks them.
#[derive(Clone, Copy, Default)]
pub(super) struct Lines {
    pub(super) ident: Option<usize>,
    pub(super) user_prm: Option<usize>,
}

/// Numbers the modules, and compares the parts of the file with each other.
pub(super) fn check(device: &mut Device, lines: Lines, problems: &mut Vec<Problem>) {
    number_modules(device, problems);
    check_names(device, problems);
    let mut list = |line: usize, fault: Fault, found: String| problems.push(Problem::new(line, fault, found));
    // A wrong Ident_Number has a problem of its own.
    if lines.ident.is_none() {
        list(1, Fault::NoIdent, String::new());
    }
    if device.modules.is_empty() {
        list(1, Fault::NoModules, String::new());
    }
    for parameter in device.parameters.values() {
        if let Some(number) = parameter.texts.filter(|number| !device.texts.contains_key(number)) {
            list(parameter.line, Fault::UnknownText, format!("Prm_Text_Ref {number}"));
        }
    }
    check_area(device, &device.prm, device.general.max_user_prm_data_len, &mut list);
    for module in &device.modules {
        check_area(device, &module.prm, module.prm.length.map(u32::from), &mut list);
        check_area(device, &module.safety, module.safety.length.map(u32::from), &mut list);
    }
    check_user_prm(device, lines.user_prm.unwrap_or(1), &mut list);
    check_slots(device, &mut list);
}

/// The signs beside letters and digits in the names that pyprofibus 1.13 reads.
const SIGNS: &str = " ._-+*/<>()[]{}!$%&?^|=#,:`";

/// One problem for all names that a tool does not read: files in German or French have hundreds.
fn check_names(device: &Device, problems: &mut Vec<Problem>) {
    let is_odd =
        |module: &&Module| module.name.contains(|sign: char| !sign.is_ascii_alphanumeric() && !SIGNS.contains(sign));
    let odd: Vec<_> = device.modules.iter().filter(is_odd).collect();
    if let Some(first) = odd.first() {
        let found = if odd.len() == 1 {
            first.name.clone()
        } else {
            format!("{}, and {} more", first.name, odd.len().saturating_sub(1))
        };
        problems.push(Problem::new(first.line, Fault::ModuleName, found));
    }
}

/// A module without a number gets its place among the modules, or if another module has this number the next one above all.
/// If 65535 leaves no room above all, it gets the lowest free one.
fn number_modules(device: &mut Device, problems: &mut Vec<Problem>) {
    let mut names = HashSet::new();
    let mut numbers = HashSet::new();
    for module in &device.modules {
        if !names.insert(module.name.as_str()) {
            problems.push(Problem::new(module.line, Fault::ModuleNameTwice, module.name.clone()));
        }
        if module.numbered && !numbers.insert(module.number) {
            problems.push(Problem::new(module.line, Fault::ModuleNumberTwice, module.number.to_string()));
        }
    }
    let open = device.modules.iter().filter(|module| !module.numbered).count();
    let most = numbers.iter().max().copied().unwrap_or(0);
    let above = u32::try_from(open).is_ok_and(|open| most.saturating_add(open) <= u32::from(u16::MAX));
    let mut next = if above { most.saturating_add(1) } else { 1 };
    for (module, place) in device.modules.iter_mut().zip(1_u32..).filter(|(module, _)| !module.numbered) {
        next = (next..u32::MAX).find(|number| !numbers.contains(number)).unwrap_or(u32::MAX);
        module.number = if numbers.contains(&place) { next } else { place };
        numbers.insert(module.number);
    }
}

/// References of user parameters, and the length of the area. `limit` is the length that the file gives.
fn check_area(device: &Device, area: &PrmArea, limit: Option<u32>, list: &mut impl FnMut(usize, Fault, String)) {
    for item in &area.items {
        let length = match &item.content {
            PrmContent::Const(octets) => octets.len(),
            PrmContent::Ref(number) => match device.parameters.get(number) {
                Some(parameter) => parameter.kind.octets(),
                None => {
                    list(item.line, Fault::UnknownParameter, number.to_string());
                    continue;
                }
            },
        };
        let end = u32::try_from(length).unwrap_or(u32::MAX).saturating_add(u32::from(item.offset));
        if limit.is_some_and(|limit| end > limit) {
            list(
                item.line,
                Fault::BeyondLength,
                format!("it needs {end} octets, the file gives {}", limit.unwrap_or(0)),
            );
        }
    }
}

fn check_user_prm(device: &Device, line: usize, list: &mut impl FnMut(usize, Fault, String)) {
    let Some(octets) = &device.user_prm_data else { return };
    let length = device.general.user_prm_data_len.and_then(|length| usize::try_from(length).ok());
    if let Some(length) = length.filter(|length| *length != octets.len()) {
        list(line, Fault::PrmLength, format!("{} octets instead of {length}", octets.len()));
    }
    let ext = device.prm.octets(&device.parameters, |_, parameter| parameter.default);
    if !ext.is_empty() && ext != *octets {
        list(line, Fault::BothPrm, String::new());
    }
}

fn check_slots(device: &Device, list: &mut impl FnMut(usize, Fault, String)) {
    let runs = runs(device);
    for slot in device.slots.values() {
        let missing = missing(&runs, slot.default, slot.default);
        let missing = missing.or_else(|| slot.allowed.iter().find_map(|(low, high)| self::missing(&runs, *low, *high)));
        if let Some(number) = missing {
            list(slot.line, Fault::UnknownModule, format!("slot {} allows {number}", slot.number));
        }
        if !slot.allowed.iter().any(|(low, high)| (*low..=*high).contains(&slot.default)) {
            list(slot.line, Fault::SlotDefault, format!("slot {} has {}", slot.number, slot.default));
        }
    }
}

/// The numbers of the modules as runs without a gap: the first number of each with its last.
fn runs(device: &Device) -> BTreeMap<u32, u32> {
    let numbers: BTreeSet<u32> = device.modules.iter().map(|module| module.number).collect();
    let mut runs = BTreeMap::new();
    let mut first = None;
    let mut last: Option<u32> = None;
    for number in numbers {
        if last.and_then(|last| last.checked_add(1)) != Some(number) {
            first = Some(number);
        }
        last = Some(number);
        runs.insert(first.unwrap_or(number), number);
    }
    runs
}

/// The lowest number of a range that no module has.
fn missing(runs: &BTreeMap<u32, u32>, low: u32, high: u32) -> Option<u32> {
    let run = runs.range(..=low).next_back().map(|(_, last)| *last).filter(|last| *last >= low);
    match run {
        None => Some(low),
        Some(last) => last.checked_add(1).filter(|next| *next <= high),
    }
}
