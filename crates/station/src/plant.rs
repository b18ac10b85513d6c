//! The picture of the plant: volumes, and the valves and pumps between them, with their states as far as something reports them.
//!
//! The structure changes only with the station's file, and `/api/plant` has it. States and the story change as they happen, and travel
//! in the live stream.

use profivac_recorder::Micros;
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use utoipa::ToSchema;

/// The number of sentences of the story that are kept. chosen: more than a screen shows.
const STORY: usize = 20;

/// The plant: what stands between what.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct PlantPicture {
    /// The volumes; empty if nothing describes the plant.
    pub volumes: Vec<PlantVolume>,
    /// The parts between them.
    pub parts: Vec<PlantPart>,
    /// The user's own drawing as SVG, in which `data-gauge`, `data-volume` and `data-part` name gauges, volumes and parts.
    pub drawing: Option<String>,
}

/// A volume of the plant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct PlantVolume {
    /// Its name.
    pub name: String,
    /// The zone that it belongs to.
    pub zone: Option<String>,
    /// Its gauges. The name of a gauge stands for all its readings that no other volume has; `name.N` is the channel N of a controller.
    pub gauges: Vec<String>,
}

/// A part of the plant: a valve, a tube, a pump or an opening to the outside.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct PlantPart {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: PlantPartKind,
    /// Its volumes. A tube or valve has two, a pump its inlet and perhaps the volume that it pumps into, an opening one.
    pub volumes: Vec<String>,
}

/// The kind of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlantPartKind {
    /// A tube between two volumes, always open.
    Tube,
    /// A valve between two volumes.
    Valve,
    /// A roughing pump.
    RoughingPump,
    /// A turbomolecular pump.
    TurboPump,
    /// A capture pump: an ion pump, a getter, a cryopump.
    CapturePump,
    /// A leak.
    Leak,
    /// A vent.
    Vent,
    /// A gas inlet.
    Inlet,
}

/// The state of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlantPartState {
    /// Gas passes.
    Open,
    /// No gas passes.
    Closed,
    /// The pump runs.
    Running,
    /// The pump stands.
    Stopped,
}

/// The reported state of a part.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct PlantPartStatus {
    /// The state.
    pub state: PlantPartState,
    /// More about it: the speed of a rotor.
    pub detail: Option<String>,
}

/// A sentence about something that happens in the plant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct StorySentence {
    /// When, in milliseconds since 1970.
    pub at_ms: i64,
    /// The sentence.
    pub text: String,
}

/// The plant in the live stream.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct LivePlant {
    /// Changes when `/api/plant` changes.
    pub revision: u64,
    /// The states of the parts, by name. A part without a state reports none.
    pub states: BTreeMap<String, PlantPartStatus>,
    /// What happens, the latest sentence first. Only a demonstration tells a story.
    pub story: Vec<StorySentence>,
}

/// The plant and its present state, shared by the threads of a station.
#[derive(Default)]
pub struct PlantStore(RwLock<Stored>);

#[derive(Default)]
struct Stored {
    plant: PlantPicture,
    revision: u64,
    states: BTreeMap<String, PlantPartStatus>,
    story: VecDeque<StorySentence>,
}

impl PlantStore {
    /// Replaces the plant. States of parts that it does not have are dropped.
    pub fn set(&self, plant: PlantPicture) {
        let mut stored = self.write();
        if stored.plant == plant {
            return;
        }
        stored.states.retain(|name, _| plant.parts.iter().any(|part| part.name == *name));
        stored.plant = plant;
        stored.revision = stored.revision.wrapping_add(1);
    }

    /// Sets the states of the parts of the plant; a part that is not among them reports no state.
    pub fn report(&self, states: impl IntoIterator<Item = (String, PlantPartStatus)>) {
        let mut stored = self.write();
        let known = |name: &str| stored.plant.parts.iter().any(|part| part.name == name);
        let states = states.into_iter().filter(|(name, _)| known(name)).collect();
        stored.states = states;
    }

    /// Adds a sentence to the story, unless it is the latest one.
    pub fn tell(&self, text: &str) {
        let mut stored = self.write();
        if stored.story.front().is_some_and(|latest| latest.text == text) {
            return;
        }
        let at_ms = crate::view::unix_ms(Micros::now());
        stored.story.push_front(StorySentence { at_ms, text: text.to_owned() });
        stored.story.truncate(STORY);
    }

    /// The plant.
    #[must_use]
    pub fn view(&self) -> PlantPicture {
        self.read().plant.clone()
    }

    /// The plant in the live stream.
    #[must_use]
    pub fn live(&self) -> LivePlant {
        let stored = self.read();
        LivePlant {
            revision: stored.revision,
            states: stored.states.clone(),
            story: stored.story.iter().cloned().collect(),
        }
    }

    fn read(&self) -> RwLockReadGuard<'_, Stored> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self) -> RwLockWriteGuard<'_, Stored> {
        self.0.write().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn valve(name: &str) -> PlantPart {
        PlantPart {
            name: name.to_owned(),
            kind: PlantPartKind::Valve,
            volumes: vec!["lock".to_owned(), "chamber".to_owned()],
        }
    }

    fn open(name: &str) -> (String, PlantPartStatus) {
        (name.to_owned(), PlantPartStatus { state: PlantPartState::Open, detail: None })
    }

    #[test]
    fn only_parts_of_the_plant_have_states_and_a_new_plant_has_a_new_revision() {
        let store = PlantStore::default();
        store.set(PlantPicture { volumes: Vec::new(), parts: vec![valve("slide"), valve("bypass")], drawing: None });
        store.report([open("slide"), open("another")]);
        let live = store.live();
        assert_eq!(live.states.keys().collect::<Vec<_>>(), ["slide"]);
        store.set(store.view());
        assert_eq!(store.live(), live, "the same plant again");
        store.set(PlantPicture { volumes: Vec::new(), parts: vec![valve("bypass")], drawing: None });
        assert!(store.live().states.is_empty() && store.live().revision != live.revision);
    }

    #[test]
    fn the_story_has_its_latest_sentence_first_and_keeps_a_screenful() {
        let store = PlantStore::default();
        for number in 0..2 * STORY {
            store.tell(&number.to_string());
            store.tell(&number.to_string());
        }
        let story: Vec<_> = store.live().story.into_iter().map(|sentence| sentence.text).collect();
        let expected: Vec<_> = (STORY..2 * STORY).rev().map(|number| number.to_string()).collect();
        assert_eq!(story, expected);
    }
}
