//! The user parameters of Set_Prm in the words of the files.

use super::{Described, LISTED, brief, distinct, name, shortened};
use crate::note::octets;
use profivac_gsd::{Device, Fit, GsdFile, Place, ReadValue, Reading};
use std::collections::HashMap;

/// How much a text names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Parameters that differ from the file's defaults, and twenty things at most; the others are counted. For a sentence.
    Changes,
    /// Everything. For the meaning of a telegram.
    All,
}

impl Extent {
    /// The number of things that a text lists.
    pub(super) const fn most(self) -> usize {
        match self {
            Self::Changes => LISTED,
            Self::All => usize::MAX,
        }
    }
}

impl Described {
    /// The user parameters of the last Set_Prm in words. Empty without a file or without user parameters.
    ///
    /// Set_Prm comes before Chk_Cfg, so the modules may not be known: then the text has the parameters of the station, and says so.
    #[must_use]
    pub fn parameters_text(&self, user: &[u8], extent: Extent) -> String {
        self.parameters_by_file(user, extent, |file| self.fit_of_set_prm(file))
    }

    /// The user parameters of a new Set_Prm in words. The Chk_Cfg that follows chooses the modules, which may differ from the present ones.
    #[must_use]
    pub fn new_parameters_text(&self, user: &[u8], extent: Extent) -> String {
        self.parameters_by_file(user, extent, |_| None)
    }

    /// Each text once, with the names of the devices that have it.
    fn parameters_by_file<'s>(
        &'s self,
        user: &[u8],
        extent: Extent,
        fit: impl Fn(&'s GsdFile) -> Option<Fit<'s>>,
    ) -> String {
        if user.is_empty() {
            return String::new();
        }
        let mut places: HashMap<String, usize> = HashMap::new();
        let mut devices: Vec<Vec<&Device>> = Vec::new();
        for file in &self.possible {
            let fit = fit(file);
            let reading = fit.as_ref().map_or_else(|| file.device().read_station_prm(user), |fit| fit.read_prm(user));
            let place = *places.entry(words(&reading, fit.is_some(), extent)).or_insert(devices.len());
            match devices.get_mut(place) {
                Some(same) => same.push(file.device()),
                None => devices.push(vec![file.device()]),
            }
        }
        let mut texts: Vec<_> = places.into_iter().collect();
        texts.sort_by_key(|(_, place)| *place);
        if let [(only, _)] = texts.as_slice() {
            return only.clone();
        }
        let named = texts.iter().zip(&devices).map(|((text, _), devices)| {
            let names = distinct(devices.iter().map(|device| name(device)));
            format!("as {}: {text}", shortened(&names, " or ", LISTED))
        });
        shortened(&named.collect::<Vec<_>>(), " | ", LISTED)
    }
}

/// The values with their places, what differs from constants, and a wrong length.
fn words(reading: &Reading<'_>, has_modules: bool, extent: Extent) -> String {
    let place = |place: Place| match place {
        Place::Station => String::new(),
        Place::Slot(slot) => {
            let module = reading.modules.iter().find(|(number, _)| *number == slot);
            module.map_or_else(
                || format!("slot {slot}: "),
                |(_, module)| format!("slot {slot} {}: ", brief(&module.name)),
            )
        }
    };
    let is_shown = |value: &&ReadValue<'_>| extent == Extent::All || !value.is_usual();
    let shown = reading.values.iter().filter(is_shown);
    let mut texts: Vec<_> = shown.map(|value| format!("{}{value}", place(value.place))).collect();
    let usual = reading.values.len().saturating_sub(texts.len());
    // Octets behind the end are one text about the length.
    let inside = reading.differences.iter().filter(|one| one.octet < reading.expected);
    texts.extend(inside.map(|one| format!("{}{one}", place(one.place))));
    let mut parts: Vec<_> =
        Some(shortened(&texts, ", ", extent.most())).into_iter().filter(|text| !text.is_empty()).collect();
    parts.extend(match (usual, parts.is_empty()) {
        (0, _) => None,
        (1, true) => Some("the only parameter has its default".to_owned()),
        (_, true) => Some(format!("all {usual} parameters have their defaults")),
        (_, false) => Some(format!("{usual} other parameters have their defaults")),
    });
    if let Some(length) = length_text(reading, has_modules) {
        parts.push(length);
    }
    parts.join("; ")
}

/// A length that is not as the file says.
pub(super) fn length_text(reading: &Reading<'_>, has_modules: bool) -> Option<String> {
    let Reading { expected, found, .. } = reading;
    match has_modules {
        true if expected != found => {
            Some(format!("{} of user parameters, station and modules have {expected} by the GSD file", octets(*found)))
        }
        false if found > expected => {
            Some(format!("{} more, of the modules, which Chk_Cfg shows", octets(found.saturating_sub(*expected))))
        }
        false if found < expected => {
            Some(format!("{} of user parameters, the station alone has {expected} by the GSD file", octets(*found)))
        }
        _ => None,
    }
}
