//! `[[volume]]`, `[[pump]]` and `[[valve]]`: the picture of the plant.

use super::alarms;
use super::error::{ConfigProblem, DrawingFileProblem, Located, NamedItem};
use super::names::{self, unique};
use super::segments::{SegmentToml, gauge_names};
use profivac_client::suggestion::closest;
use profivac_host::text_file;
use profivac_station::drawing::{self, Names};
use profivac_station::plant::{PlantPart, PlantPartKind, PlantPicture, PlantVolume};
use serde::Deserialize;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// `[[volume]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VolumeToml {
    /// The name, unique among the volumes.
    name: Spanned<String>,
    /// The zone, whose volumes have a frame together.
    zone: Option<Spanned<String>>,
    /// The gauges on the volume, or `NAME.N` for a channel: the first with a valid reading leads.
    #[serde(default)]
    gauges: Vec<Spanned<String>>,
}

/// `[[pump]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PumpToml {
    /// The name, unique among pumps and valves.
    name: Spanned<String>,
    /// `roughing`, `turbo` or `capture`.
    kind: PumpKindToml,
    /// The volume that is pumped.
    inlet: Spanned<String>,
    /// The volume into which it pumps; without the key the atmosphere.
    outlet: Option<Spanned<String>>,
}

/// `kind` of a pump.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum PumpKindToml {
    Roughing,
    Turbo,
    Capture,
}

/// `[[valve]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValveToml {
    /// The name, unique among pumps and valves.
    name: Spanned<String>,
    /// The two volumes that it connects, the left one first.
    between: [Spanned<String>; 2],
}

/// The plant of the file, with the tables in their order.
pub fn plant(
    volumes: &[VolumeToml],
    pumps: &[PumpToml],
    valves: &[ValveToml],
    segments: &[SegmentToml],
) -> Result<PlantPicture, Located> {
    unique(NamedItem::Volume, volumes.iter().map(|volume| &volume.name))?;
    let names = pumps.iter().map(|pump| &pump.name).chain(valves.iter().map(|valve| &valve.name));
    unique(NamedItem::PlantPart, names)?;
    check_gauges(volumes, segments)?;
    let valves = valves.iter().map(|valve| {
        let [one, other] = &valve.between;
        part(&valve.name, PlantPartKind::Valve, one, Some(other), volumes)
    });
    let pumps = pumps.iter().map(|pump| {
        let kind = match pump.kind {
            PumpKindToml::Roughing => PlantPartKind::RoughingPump,
            PumpKindToml::Turbo => PlantPartKind::TurboPump,
            PumpKindToml::Capture => PlantPartKind::CapturePump,
        };
        part(&pump.name, kind, &pump.inlet, pump.outlet.as_ref(), volumes)
    });
    let parts = valves.chain(pumps).collect::<Result<_, _>>()?;
    Ok(PlantPicture { volumes: volumes.iter().map(volume).collect::<Result<_, _>>()?, parts, drawing: None })
}

/// The drawing of the file, whose path is relative to `folder`.
pub fn drawing(
    given: Option<&Spanned<PathBuf>>,
    plant: &PlantPicture,
    segments: &[SegmentToml],
    folder: &Path,
) -> Result<Option<String>, Located> {
    let Some(given) = given else { return Ok(None) };
    let file = folder.join(given.get_ref());
    let parts = |is_wanted: fn(PlantPartKind) -> bool| {
        plant.parts.iter().filter(move |part| is_wanted(part.kind)).map(|part| part.name.clone()).collect()
    };
    let names = Names {
        gauges: gauge_names(segments).map(str::to_owned).collect(),
        volumes: plant.volumes.iter().map(|volume| volume.name.clone()).collect(),
        valves: parts(|kind| kind == PlantPartKind::Valve),
        pumps: parts(|kind| kind != PlantPartKind::Valve),
    };
    let drawn = text_file::read(&file).map_err(DrawingFileProblem::Read);
    let drawn = drawn.and_then(|text| Ok(drawing::checked(&text, &names)?));
    drawn.map(Some).map_err(|problem| Located::new(given.span(), ConfigProblem::Drawing { file, problem }))
}

fn volume(volume: &VolumeToml) -> Result<PlantVolume, Located> {
    volume.zone.as_ref().map_or(Ok(()), |zone| names::check(NamedItem::Zone, zone))?;
    Ok(PlantVolume {
        name: volume.name.get_ref().clone(),
        zone: volume.zone.as_ref().map(|zone| zone.get_ref().clone()),
        gauges: volume.gauges.iter().map(|gauge| gauge.get_ref().clone()).collect(),
    })
}

fn part(
    name: &Spanned<String>,
    kind: PlantPartKind,
    one: &Spanned<String>,
    other: Option<&Spanned<String>>,
    volumes: &[VolumeToml],
) -> Result<PlantPart, Located> {
    let ends: Vec<_> = std::iter::once(one).chain(other).collect();
    ends.iter().try_for_each(|end| known_volume(end, volumes))?;
    if let Some(other) = other.filter(|other| other.get_ref() == one.get_ref()) {
        return Err(Located::new(other.span(), ConfigProblem::SameVolume(other.get_ref().clone())));
    }
    let volumes = ends.into_iter().map(|end| end.get_ref().clone()).collect();
    Ok(PlantPart { name: name.get_ref().clone(), kind, volumes })
}

fn known_volume(name: &Spanned<String>, volumes: &[VolumeToml]) -> Result<(), Located> {
    let mut known = volumes.iter().map(|volume| volume.name.get_ref().as_str());
    if known.any(|known| known == name.get_ref()) {
        return Ok(());
    }
    let known = volumes.iter().map(|volume| volume.name.get_ref().as_str());
    let suggestion = closest(name.get_ref(), known).map(str::to_owned);
    Err(Located::new(name.span(), ConfigProblem::UnknownVolume { name: name.get_ref().clone(), suggestion }))
}

/// Every gauge is one of the file, and stands at one volume.
fn check_gauges(volumes: &[VolumeToml], segments: &[SegmentToml]) -> Result<(), Located> {
    let mut places: HashMap<&str, &str> = HashMap::new();
    for volume in volumes {
        for gauge in &volume.gauges {
            alarms::series(gauge, segments)?;
            if let Some(other) = places.insert(gauge.get_ref(), volume.name.get_ref()) {
                let problem =
                    ConfigProblem::GaugePlacedTwice { gauge: gauge.get_ref().clone(), volume: other.to_owned() };
                return Err(Located::new(gauge.span(), problem));
            }
        }
    }
    Ok(())
}
