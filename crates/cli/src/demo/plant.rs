//! The plant of a scenario in the dashboard: its picture, and the states of its valves and pumps.

use profivac_station::plant::{PlantPart, PlantPartKind, PlantPartState, PlantPartStatus, PlantPicture, PlantVolume};
use profivac_virtual::scenario::{PartState, Run, Schematic, SchematicKind};

/// A rotor below this fraction of its rated speed is shown as `0 %`: its pump is stopped.
pub const LEAST_ROTOR_SPEED: f64 = 0.005;

/// The picture of a plant. `name` gives the name of the gauge at an address.
pub fn view(schematic: &Schematic, name: impl Fn(u8) -> String) -> PlantPicture {
    let gauges = |volume: &String| {
        let here = schematic.gauges.iter().filter(|gauge| gauge.volume == *volume);
        here.map(|gauge| match gauge.instance {
            None => name(gauge.address),
            Some(instance) => format!("{}.{instance}", name(gauge.address)),
        })
        .collect()
    };
    let volume = |volume: &String| PlantVolume { name: volume.clone(), zone: None, gauges: gauges(volume) };
    let parts = schematic.parts.iter().map(|part| PlantPart {
        name: part.name.clone(),
        kind: kind(part.kind),
        volumes: part.volumes.clone(),
    });
    PlantPicture { volumes: schematic.volumes.iter().map(volume).collect(), parts: parts.collect(), drawing: None }
}

const fn kind(kind: SchematicKind) -> PlantPartKind {
    match kind {
        SchematicKind::Tube => PlantPartKind::Tube,
        SchematicKind::Valve => PlantPartKind::Valve,
        SchematicKind::RoughingPump => PlantPartKind::RoughingPump,
        SchematicKind::TurboPump => PlantPartKind::TurboPump,
        SchematicKind::CapturePump => PlantPartKind::CapturePump,
        SchematicKind::Leak => PlantPartKind::Leak,
        SchematicKind::Vent => PlantPartKind::Vent,
        SchematicKind::Inlet => PlantPartKind::Inlet,
    }
}

/// The states of the parts of a plant.
pub fn states(run: &Run) -> impl Iterator<Item = (String, PlantPartStatus)> {
    run.states().into_iter().filter_map(|(name, state)| Some((name.to_owned(), status(state)?)))
}

/// The state of a part; `None` for the temperature of a wall.
fn status(state: PartState) -> Option<PlantPartStatus> {
    let shown = match state {
        PartState::Open => PlantPartState::Open,
        PartState::Closed => PlantPartState::Closed,
        PartState::Running => PlantPartState::Running,
        PartState::Stopped => PlantPartState::Stopped,
        PartState::RotorSpeed(fraction) if fraction < LEAST_ROTOR_SPEED => PlantPartState::Stopped,
        PartState::RotorSpeed(_) => PlantPartState::Running,
        PartState::Temperature(_) => return None,
    };
    Some(PlantPartStatus { state: shown, detail: matches!(state, PartState::RotorSpeed(_)).then(|| state.to_string()) })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::super::{SCENARIO, SCENARIO_NAME};
    use super::*;
    use profivac_virtual::scenario::{MasterPresence, Scenario};

    #[test]
    fn the_plant_of_the_demonstration_has_its_gauges_at_its_volumes_and_every_part_a_state() {
        let scenario = Scenario::parse(SCENARIO, SCENARIO_NAME).unwrap();
        let plant = view(scenario.schematic(), |address| format!("gauge {address}"));
        let gauges = |name: &str| plant.volumes.iter().find(|volume| volume.name == name).unwrap().gauges.clone();
        assert_eq!(gauges("fore-line"), ["gauge 11", "gauge 15.2"]);
        assert_eq!(gauges("throat"), ["gauge 13"]);
        assert_eq!(gauges("chamber").len(), 9);
        let turbo = plant.parts.iter().find(|part| part.name == "turbo").unwrap();
        assert_eq!((turbo.kind, turbo.volumes.join(" ")), (PlantPartKind::TurboPump, "throat exhaust".to_owned()));
        let run = scenario.start(MasterPresence::Present);
        let states: Vec<_> = states(&run).collect();
        let state = |name: &str| states.iter().find(|(part, _)| part == name).map(|(_, status)| status.clone());
        assert!(plant.parts.iter().all(|part| state(&part.name).is_some()), "{states:?}");
        assert_eq!(state("gate").unwrap().state, PlantPartState::Closed);
        let expected = PlantPartStatus { state: PlantPartState::Running, detail: Some("100 %".to_owned()) };
        assert_eq!(state("turbo").unwrap(), expected);
        assert_eq!(state("scroll").unwrap().state, PlantPartState::Running);
    }
}
