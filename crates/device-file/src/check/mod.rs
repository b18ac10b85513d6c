//! The checks of a file: its tables as TOML become the tables of a device, or an error that says what to do.

mod blocks;
mod telegrams;
mod values;

pub use blocks::{UNITS, VERSION};

use crate::conditions;
use crate::device::{
    Device, OwnedBlock, OwnedGsd, OwnedLocation, OwnedPrm, OwnedTask, OwnedUnit, RowCodes, TelegramFields,
};
use crate::error::{Located, problem};
use crate::toml_file::{
    AlarmsToml, ChannelToml, CountsToml, DeviceToml, FaultToml, GsdToml, List, PartToml, UnitToml, UserPrmToml,
};
use crate::words::{ACCESS_ERRORS, CLIPPINGS, PRINCIPLES, octets, pressure_pa, unknown, value_of};
use blocks::{Tables, blocks, find_unit};
use profivac_devices::catalog::{MODELS, model_named};
use profivac_devices::described::{BlockBehaviour, MAX_PARTS, MAX_TRIPS};
use profivac_devices::model::{
    AccessError, Clipping, Counts, DataType, Fault, Field, INTEGER16_MAX, Limits, Model, Part, PartSpec, Scale,
};
use profivac_dp::slave::Features;
use std::collections::BTreeSet;
use std::ops::Range;
use telegrams::{configurations, default_configuration, telegrams};
use toml::Spanned;
use values::values;

/// The longest name of a device.
const MAX_NAME: usize = 32;
/// The most characters of a name, a title or a word.
const MAX_WORDS: usize = 200;
/// The most characters of an explanation: a risk, an effect, a remark.
const MAX_REMARK: usize = 1000;
/// Limit of parameters of a device, counted at each location. chosen: far more than any manual has.
const MAX_PARAMETERS: usize = 4096;
/// Limit of entries in a list. chosen: far more than any manual has.
const MAX_ENTRIES: usize = 1024;
/// The longest octets of Chk_Cfg, and of user parameters in one Set_Prm.
const MAX_DATA_UNIT: usize = 237;

/// Checks a whole file.
pub fn check(file: &DeviceToml) -> Result<Device, Located> {
    let tables = Tables::of(&file.codes)?;
    let outputs = telegrams(&file.outputs)?;
    let inputs = telegrams(&file.inputs)?;
    let configurations = configurations(file, &outputs, &inputs)?;
    let default_configuration = default_configuration(file, &configurations)?;
    let values = values(file, &tables, &outputs, &inputs)?;
    let (tasks, error_codes) = channel(file, &outputs)?;
    let mut blocks = blocks(&file.block, &tables)?;
    find_unit(&mut blocks, &file.block);
    let services = file.services.unwrap_or_default();
    let no_alarms = AlarmsToml { instances: Vec::new(), sensor: Vec::new(), manufacturer: Vec::new() };
    let alarms = file.alarms.as_ref().unwrap_or(&no_alarms);
    let device = Device {
        title: gsd_words(&file.title)?,
        vendor: required(file, file.vendor.as_ref(), "vendor").and_then(gsd_words)?,
        manual: required(file, file.manual.as_ref(), "manual").and_then(words)?,
        errata: file.errata.as_ref().map_or_else(|| Ok(String::new()), remark)?,
        behaviour: behaviour(file, &blocks)?,
        left_out: file.left_out.as_ref().map_or_else(|| Ok(String::new()), remark)?,
        ident: *required(file, file.ident.as_ref(), "ident")?,
        features: Features { sync: services.sync, freeze: services.freeze, dpv1: services.dpv1, ms1: services.ms1 },
        units: pressure_units(file, &blocks, [&outputs, &inputs])?,
        max_integer: file.max_integer.unwrap_or(INTEGER16_MAX),
        user_prm: user_prm(required(file, file.user_parameters.as_ref(), "user-parameters")?)?,
        free_bits: file.free_bits.unwrap_or(0),
        parts: file.parts.as_ref().map_or_else(|| Ok(Vec::new()), parts)?,
        needs_idle_between: file.parameter_channel.as_ref().is_some_and(|channel| channel.idle_between_tasks),
        alarm_instances: alarms.instances.clone(),
        sensor_alarms: sensor_alarms(alarms)?,
        manufacturer_alarms: manufacturer_alarms(alarms)?,
        faults: file.faults.as_ref().map_or_else(|| Ok(Vec::new()), faults)?,
        gsd: gsd(file.gsd.as_ref())?,
        tables: tables.lists,
        name: file.name.get_ref().clone(),
        outputs,
        inputs,
        configurations,
        default_configuration,
        values,
        tasks,
        error_codes,
        blocks,
    };
    conditions::check_parameters(&device)?;
    check_behaviours(file, &device)?;
    Ok(device)
}

/// The built-in device whose behaviour this one has. It finds its rows by the positions of their blocks.
fn behaviour(file: &DeviceToml, blocks: &[OwnedBlock]) -> Result<Option<&'static Model>, Located> {
    let Some(name) = &file.behaviour else { return Ok(None) };
    if let Some(of_block) = file.block.iter().find_map(|block| block.behaviour.as_ref()) {
        return problem(
            of_block.span(),
            "the device has a behaviour, so its blocks cannot have their own; delete the behaviour of the device or the behaviours of the blocks",
        );
    }
    let Some(model) = model_named(name.get_ref()) else {
        let known: Vec<_> = known_names().collect();
        return Err(unknown(name, &format!("a device that profivac has, one of: {}", known.join(", ")), known_names()));
    };
    let mut own = blocks.iter().map(|block| block.name.as_str());
    match model.blocks.iter().map(|placed| placed.block.name).find(|block| own.next() != Some(*block)) {
        Some(block) => problem(
            name.span(),
            format!(
                "the behaviour of {} expects the block {block:?} here: begin with the blocks of `profivac device show {}` in their order, \
                 with at = [] for those that the device does not have",
                model.name, model.name
            ),
        ),
        None => Ok(Some(model)),
    }
}

/// The blocks with a behaviour of the library are where the tables have the parts for it.
fn check_behaviours(file: &DeviceToml, device: &Device) -> Result<(), Located> {
    let mut trips = 0_usize;
    for (block, toml) in device.blocks.iter().zip(&file.block) {
        let (Some(behaviour), Some(name)) = (block.behaviour, &toml.behaviour) else { continue };
        let wrong = |text: String| problem(name.span(), text);
        if device.parts.len() > MAX_PARTS {
            return wrong(format!("a device with behaviours of blocks has at most {MAX_PARTS} parts"));
        }
        if behaviour == BlockBehaviour::TripPoint {
            trips = trips.saturating_add(block.locations.len());
        }
        if trips > MAX_TRIPS {
            return wrong(format!("a device has at most {MAX_TRIPS} trip points"));
        }
        let fits = |part: &PartSpec| behaviour.principle().is_none_or(|principle| part.part.principle == principle);
        let needs_part = behaviour.principle().is_some() || behaviour == BlockBehaviour::AnalogInput;
        let lacking = block.locations.iter().filter(|_| needs_part).find(|location| {
            let mut locations = device.blocks.iter().flat_map(|block| &block.locations);
            let has_instances = locations.any(|it| it.slot == location.slot && it.instance > 0);
            let instance = if location.instance > 0 || has_instances { location.instance } else { location.slot };
            !device.parts.iter().any(|part| part.part.instance == instance && fits(part))
        });
        if let Some(OwnedLocation { slot, instance, .. }) = lacking {
            return wrong(format!(
                "{:?} needs an entry of parts with the instance of the location, or with the slot where it has no instances, and with the \
                 principle: none for slot {slot}, instance {instance}",
                name.get_ref()
            ));
        }
    }
    Ok(())
}

/// A key that the file, or the device that it is like, must have.
fn required<'a, T>(file: &DeviceToml, value: Option<&'a T>, key: &str) -> Result<&'a T, Located> {
    value.map_or_else(
        || problem(file.name.span(), format!("expected the key {key}; add it, or name a device with like that has it")),
        Ok,
    )
}

/// Checks the name of a device that a file describes.
pub fn device_name(name: &Spanned<String>) -> Result<(), Located> {
    let text = name.get_ref();
    let is_word = text.starts_with(|first: char| first.is_ascii_lowercase())
        && text.chars().all(|letter| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '-')
        && !text.ends_with('-');
    if !is_word || text.len() > MAX_NAME {
        return problem(
            name.span(),
            format!("expected a name of at most {MAX_NAME} small letters, digits and hyphens, found {text:?}"),
        );
    }
    if let Some(plain) = text.strip_suffix("-sp") {
        return problem(
            name.span(),
            format!("a name ends without -sp: write {plain:?}; title has the name on the device"),
        );
    }
    if let Some(known) = model_named(text) {
        let title = known.title;
        return problem(
            name.span(),
            format!(
                "{text:?} is the name of a device that profivac has ({title}); choose another, for instance \"my-{text}\""
            ),
        );
    }
    Ok(())
}

/// A text without control characters, not longer than `most`.
fn text(text: &Spanned<String>, most: usize) -> Result<String, Located> {
    let found = text.get_ref();
    if found.is_empty() {
        return problem(text.span(), "expected a text, found none");
    }
    if found.chars().any(char::is_control) {
        return problem(text.span(), format!("expected a text without control characters, found {found:?}"));
    }
    if found.chars().count() > most {
        return problem(text.span(), format!("expected a text of at most {most} characters; shorten it"));
    }
    Ok(found.clone())
}

fn words(words: &Spanned<String>) -> Result<String, Located> {
    text(words, MAX_WORDS)
}

fn remark(remark: &Spanned<String>) -> Result<String, Located> {
    text(remark, MAX_REMARK)
}

/// A text that is also in the GSD file, between quotation marks.
fn gsd_words(text: &Spanned<String>) -> Result<String, Located> {
    let found = words(text)?;
    if found.contains('"') {
        return problem(
            text.span(),
            format!("expected a text without quotation marks, which end it in a GSD file; found {found:?}"),
        );
    }
    Ok(found)
}

/// The entries of a list that has at least one and not too many.
fn entries<'a, T>(list: &'a List<T>, what: &str) -> Result<&'a [Spanned<T>], Located> {
    let entries = list.get_ref();
    if entries.is_empty() {
        return problem(list.span(), format!("expected at least one {what}"));
    }
    limited(list.span(), entries.len(), what)?;
    Ok(entries)
}

fn limited(span: Range<usize>, count: usize, what: &str) -> Result<(), Located> {
    if count > MAX_ENTRIES {
        problem(span, format!("expected at most {MAX_ENTRIES} of {what}, found {count}"))
    } else {
        Ok(())
    }
}

/// Refuses a key that an earlier entry has.
fn only_once<K: Ord>(seen: &mut BTreeSet<K>, key: K, span: Range<usize>, what: &str) -> Result<(), Located> {
    if seen.insert(key) { Ok(()) } else { problem(span, format!("{what} is here twice; delete one of both")) }
}

/// The pressure units. A device without pressures needs none; it has a unit that nothing uses.
fn pressure_units(
    file: &DeviceToml,
    blocks: &[OwnedBlock],
    telegrams: [&TelegramFields; 2],
) -> Result<Vec<OwnedUnit>, Located> {
    if let Some(list) = &file.units {
        return units(list);
    }
    let is_pressure = |field: &Field| {
        matches!(field, Field::ProcessValue(_) | Field::ChannelValue(..) | Field::ChannelMantissa(_) | Field::TtrValue)
    };
    let mut rows = blocks.iter().flat_map(|block| &block.rows);
    let has_pressures = rows.any(|row| row.data_type == DataType::ByType || row.codes == RowCodes::Units)
        || telegrams.iter().flat_map(|fields| fields.values()).flatten().any(is_pressure)
        || file.parts.as_ref().is_some_and(|parts| !parts.get_ref().is_empty());
    if has_pressures {
        return required(file, None::<&List<UnitToml>>, "units").map(|_| Vec::new());
    }
    let (name, alias) = ("mbar".to_owned(), "hPa".to_owned());
    Ok(vec![OwnedUnit { code: 0, name, alias, scale: Scale::PerMbar(1.0) }])
}

fn units(list: &List<UnitToml>) -> Result<Vec<OwnedUnit>, Located> {
    let (mut codes, mut names) = (BTreeSet::new(), BTreeSet::new());
    let unit = |entry: &Spanned<UnitToml>| {
        let UnitToml { code, name, alias, per_mbar } = entry.get_ref();
        only_once(&mut codes, *code, entry.span(), &format!("the unit with code {code}"))?;
        only_once(&mut names, name.get_ref().to_lowercase(), name.span(), &format!("the unit {:?}", name.get_ref()))?;
        let scale = match per_mbar {
            None => Scale::Counts,
            Some(factor) if factor.get_ref().is_finite() && (1e-9..=1e9).contains(factor.get_ref()) => {
                Scale::PerMbar(*factor.get_ref())
            }
            Some(factor) => {
                return problem(factor.span(), "expected the number of units for one mbar, from 1e-9 to 1e9");
            }
        };
        let name = gsd_words(name)?;
        let alias = alias.as_ref().map_or_else(|| Ok(name.clone()), words)?;
        Ok(OwnedUnit { code: *code, alias, name, scale })
    };
    entries(list, "unit")?.iter().map(unit).collect()
}

fn user_prm(list: &List<UserPrmToml>) -> Result<Vec<OwnedPrm>, Located> {
    let mut seen = BTreeSet::new();
    let prm = |entry: &Spanned<UserPrmToml>| {
        let UserPrmToml { name, octets: text } = entry.get_ref();
        let octets = octets(text)?;
        if octets.len() > MAX_DATA_UNIT {
            return problem(text.span(), format!("expected at most {MAX_DATA_UNIT} octets"));
        }
        only_once(&mut seen, octets.clone(), text.span(), &format!("the string {:?}", text.get_ref()))?;
        Ok(OwnedPrm { name: gsd_words(name)?, octets })
    };
    entries(list, "string of user parameters; without any write { name = \"none\", octets = \"\" }")?
        .iter()
        .map(prm)
        .collect()
}

fn parts(list: &List<PartToml>) -> Result<Vec<PartSpec>, Located> {
    limited(list.span(), list.get_ref().len(), "parts")?;
    list.get_ref().iter().map(part).collect()
}

fn part(entry: &Spanned<PartToml>) -> Result<PartSpec, Located> {
    let toml = entry.get_ref();
    let under_pa = pressure_pa(&toml.underrange)?;
    let over_pa = pressure_pa(&toml.overrange)?;
    let full_scale_pa = toml.full_scale.as_ref().map_or(Ok(over_pa), pressure_pa)?;
    if !(0.0 < under_pa && under_pa < over_pa && 0.0 < full_scale_pa) {
        return problem(
            entry.span(),
            "expected an underrange above 0 and below the overrange, and a full scale above 0",
        );
    }
    Ok(PartSpec {
        part: Part { instance: toml.instance, principle: value_of(&PRINCIPLES, &toml.principle, "a principle")? },
        limits: Limits { under_pa, over_pa, full_scale_pa },
        clipping: toml.clips.as_ref().map_or(Ok(Clipping::Never), |clips| value_of(&CLIPPINGS, clips, "clips"))?,
        counts: toml.counts.as_ref().map_or(Ok(Counts::Linear { per_mbar: 1.0 }), counts)?,
    })
}

fn counts(entry: &Spanned<CountsToml>) -> Result<Counts, Located> {
    let usable = |number: f64| number.is_finite() && number.abs() <= 1e9;
    match *entry.get_ref() {
        CountsToml { per_decade: Some(per_decade), at_1_mbar: Some(at_1_mbar), per_mbar: None }
            if usable(per_decade) && per_decade >= 1.0 && usable(at_1_mbar) =>
        {
            Ok(Counts::Log { per_decade, at_1_mbar })
        }
        CountsToml { per_decade: None, at_1_mbar: None, per_mbar: Some(per_mbar) }
            if usable(per_mbar) && per_mbar >= 1e-9 =>
        {
            Ok(Counts::Linear { per_mbar })
        }
        _ => problem(
            entry.span(),
            "expected { per-decade = COUNTS, at-1-mbar = COUNTS } of a logarithmic scale or { per-mbar = COUNTS } of a linear one, \
             with numbers up to 1e9",
        ),
    }
}

/// The tasks and the error codes of the parameter channel.
type Channel = (Vec<(u8, OwnedTask)>, Vec<(AccessError, u8)>);

fn channel(file: &DeviceToml, outputs: &TelegramFields) -> Result<Channel, Located> {
    let Some(ChannelToml { tasks: list, errors, .. }) = &file.parameter_channel else {
        let has_channel = outputs.values().any(|fields| fields.contains(&Field::ParameterChannel));
        return if has_channel {
            required(file, None::<&ChannelToml>, "[parameter-channel]").map(|_| (Vec::new(), Vec::new()))
        } else {
            Ok((Vec::new(), Vec::new()))
        };
    };
    let (mut seen, mut tasks) = (BTreeSet::new(), Vec::new());
    for entry in entries(list, "task")? {
        let task = entry.get_ref();
        if !(1..=15).contains(&task.ak) {
            return problem(entry.span(), format!("expected an AK from 1 to 15, found {}", task.ak));
        }
        only_once(&mut seen, task.ak, entry.span(), &format!("the AK {}", task.ak))?;
        let kind = match &task.write {
            None => OwnedTask::Read,
            Some(lengths) if lengths.iter().all(|length| (1..=4).contains(length)) => {
                OwnedTask::Write(lengths.iter().copied().map(usize::from).collect())
            }
            Some(_) => return problem(entry.span(), "a task of the parameter channel writes 1 to 4 octets"),
        };
        tasks.push((task.ak, kind));
    }
    let codes = errors.iter().map(|entry| {
        let error = entry.get_ref();
        Ok((value_of(&ACCESS_ERRORS, &error.error, "an error")?, error.code))
    });
    Ok((tasks, codes.collect::<Result<_, _>>()?))
}

fn sensor_alarms(alarms: &AlarmsToml) -> Result<Vec<(usize, u8, String)>, Located> {
    let alarm = |entry: &Spanned<super::toml_file::SensorAlarmToml>| {
        let alarm = entry.get_ref();
        if alarm.octet > 1 {
            return problem(entry.span(), format!("Sensor Alarm has the octets 0 and 1, found {}", alarm.octet));
        }
        Ok((usize::from(alarm.octet), alarm.mask, remark(&alarm.name)?))
    };
    alarms.sensor.iter().map(alarm).collect()
}

fn manufacturer_alarms(alarms: &AlarmsToml) -> Result<Vec<(u8, String)>, Located> {
    alarms.manufacturer.iter().map(|alarm| Ok((alarm.mask, remark(&alarm.name)?))).collect()
}

fn faults(list: &List<FaultToml>) -> Result<Vec<(Fault, String)>, Located> {
    let mut seen = BTreeSet::new();
    let fault = |entry: &Spanned<FaultToml>| {
        let FaultToml { name, effect } = entry.get_ref();
        let known = || Fault::ALL.iter().map(|fault| fault.name());
        let fault = Fault::from_name(name.get_ref()).ok_or_else(|| {
            unknown(name, &format!("a fault, one of: {}", known().collect::<Vec<_>>().join(", ")), known())
        })?;
        only_once(&mut seen, name.get_ref().clone(), name.span(), &format!("the fault {:?}", name.get_ref()))?;
        Ok((fault, remark(effect)?))
    };
    list.get_ref().iter().map(fault).collect()
}

/// The release of a device whose file names none.
const USUAL_RELEASE: &str = "1.0";
/// The octets of a diagnosis without extensions.
const USUAL_DIAGNOSIS: u8 = 6;

fn gsd(gsd: Option<&GsdToml>) -> Result<OwnedGsd, Located> {
    let release = |text: Option<&Spanned<String>>| text.map_or_else(|| Ok(USUAL_RELEASE.to_owned()), gsd_words);
    Ok(OwnedGsd {
        revision: gsd.and_then(|gsd| gsd.revision).unwrap_or(1),
        hardware: release(gsd.and_then(|gsd| gsd.hardware.as_ref()))?,
        software: release(gsd.and_then(|gsd| gsd.software.as_ref()))?,
        max_diag_octets: gsd
            .and_then(|gsd| gsd.max_diagnosis_octets.as_ref())
            .map_or(Ok(USUAL_DIAGNOSIS), diagnosis_octets)?,
        set_slave_add: gsd.is_some_and(|gsd| gsd.set_slave_address),
    })
}

/// The length of the longest diagnosis: six octets that every slave has, and at most 244 (profibus-wire 2.3).
fn diagnosis_octets(octets: &Spanned<u8>) -> Result<u8, Located> {
    match *octets.get_ref() {
        known @ 6..=244 => Ok(known),
        other => problem(octets.span(), format!("expected 6 to 244 octets of diagnosis, found {other}")),
    }
}

/// The names of the devices that profivac has.
pub fn known_names() -> impl Iterator<Item = &'static str> {
    MODELS.into_iter().map(|model| model.name)
}
