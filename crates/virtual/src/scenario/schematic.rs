//! The plant of a scenario as a drawing needs it: which part stands between which volumes. It has no sizes.

use super::Gauge;
use super::plant::Plant;
use profivac_scenario_file::{File, Text};

/// The kind of a part in a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SchematicKind {
    /// A tube between two volumes.
    Tube,
    /// A valve between two volumes.
    Valve,
    /// A roughing pump at one volume.
    RoughingPump,
    /// A turbomolecular pump, from its inlet to its fore side.
    TurboPump,
    /// A capture pump at one volume.
    CapturePump,
    /// A leak from outside into one volume.
    Leak,
    /// A vent from outside into one volume.
    Vent,
    /// A gas inlet at one volume.
    Inlet,
}

/// A part in a drawing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SchematicPart {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: SchematicKind,
    /// Its volumes: one or two.
    pub volumes: Vec<String>,
}

/// A measuring part in a drawing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SchematicGauge {
    /// The address of its device.
    pub address: u8,
    /// Its instance or channel; `None` for all that are not named themselves.
    pub instance: Option<u8>,
    /// Its volume.
    pub volume: String,
}

/// The plant of a scenario as a drawing needs it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schematic {
    /// The volumes, by name.
    pub volumes: Vec<String>,
    /// The parts: tubes and valves, then pumps, then what connects a volume to the outside.
    pub parts: Vec<SchematicPart>,
    /// The gauges.
    pub gauges: Vec<SchematicGauge>,
}

impl Schematic {
    /// The drawing of a file that has been checked.
    pub(super) fn new(file: &File, plant: &Plant, gauges: &[Gauge]) -> Self {
        use SchematicKind as Kind;
        let part = |name: &String, kind, volumes: &[&Text]| SchematicPart {
            name: name.clone(),
            kind,
            volumes: volumes.iter().map(|volume| volume.get_ref().clone()).collect(),
        };
        let two = |kind| move |name: &String, [one, other]: &[Text; 2]| part(name, kind, &[one, other]);
        let (tube, valve) = (two(Kind::Tube), two(Kind::Valve));
        let parts = [
            file.tubes.iter().map(|(name, it)| tube(name, &it.get_ref().between)).collect::<Vec<_>>(),
            file.valves.iter().map(|(name, it)| valve(name, &it.get_ref().between)).collect(),
            file.turbo_pumps
                .iter()
                .map(|(name, it)| part(name, Kind::TurboPump, &[&it.get_ref().inlet, &it.get_ref().fore]))
                .collect(),
            file.roughing_pumps.iter().map(|(name, it)| part(name, Kind::RoughingPump, &[&it.get_ref().at])).collect(),
            file.capture_pumps.iter().map(|(name, it)| part(name, Kind::CapturePump, &[&it.get_ref().at])).collect(),
            file.leaks.iter().map(|(name, it)| part(name, Kind::Leak, &[&it.get_ref().at])).collect(),
            file.vents.iter().map(|(name, it)| part(name, Kind::Vent, &[&it.get_ref().at])).collect(),
            file.inlets.iter().map(|(name, it)| part(name, Kind::Inlet, &[&it.get_ref().at])).collect(),
        ];
        let name_of =
            |wanted| plant.volumes.iter().find(|(_, volume)| **volume == wanted).map(|(name, _)| name.clone());
        let gauge = |gauge: &Gauge| {
            let address = gauge.spec.address;
            let all = std::iter::once((None, gauge.volume));
            let all = all.chain(gauge.channel_volumes.iter().map(|(instance, volume)| (Some(*instance), *volume)));
            let all = all
                .filter_map(|(instance, volume)| Some(SchematicGauge { address, instance, volume: name_of(volume)? }));
            all.collect::<Vec<_>>()
        };
        Self {
            volumes: file.volumes.keys().cloned().collect(),
            parts: parts.into_iter().flatten().collect(),
            gauges: gauges.iter().flat_map(gauge).collect(),
        }
    }
}
