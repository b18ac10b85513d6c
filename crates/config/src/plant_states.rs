//! `[[plant-state]]`: what an operator declares about the plant, and which alarms mean nothing then.
//!
//! ```toml
//! [[plant-state]]
//! name = "Vented"
//! description = "The target chamber is open."
//! groups = ["target"]              # alarms about these gauges; also gauges, tags, zones of [[volume]], segments
//! kinds = ["above", "rise"]        # of these kinds
//! alarms = ["segment hall: down"]  # and these alarms
//! longest = "12 h"
//! role = "operator"                # or engineer
//! ```

use super::alarms;
use super::error::{ConfigProblem, Located, NamedItem};
use super::labels::MAX_NAME;
use super::names;
use super::segments::SegmentToml;
use crate::time_span::TimeSpan;
use profivac_client::suggestion::closest;
use profivac_host::text_file::Parsed;
use profivac_station::alarm::plant_state::DECLARED;
use profivac_station::alarm::{Condition, ConditionKind, PlantStateRule, Rule, Series};
use profivac_station::directory::Directory;
use profivac_station::plant::PlantPicture;
use profivac_web_server::auth::Role;
use profivac_web_server::visible_text::check_line;
use serde::Deserialize;
use std::collections::{BTreeSet, HashSet};
use std::time::Duration;
use toml::Spanned;

/// The most plant states. chosen: more than an operator tells apart.
const MAX_STATES: usize = 32;

/// The most characters of a description. chosen: two lines of the dialog.
const MAX_DESCRIPTION: usize = 200;

/// The default of `longest`.
const LONGEST: Duration = Duration::from_secs(24 * 3600);

/// The default of `kinds`: the alarms about a pressure. A fault and missing data mean something in every state.
const KINDS: [ConditionKind; 5] = [
    ConditionKind::Above,
    ConditionKind::Below,
    ConditionKind::Rise,
    ConditionKind::Several,
    ConditionKind::NotMeasurable,
];

/// `[[plant-state]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantStateToml {
    /// The name, unique among the plant states, up to 40 characters.
    name: Spanned<String>,
    /// A sentence about it, up to 200 characters.
    description: Option<Spanned<String>>,
    /// Alarms about these gauges, or `NAME.N` for a channel, are suppressed.
    #[serde(default)]
    gauges: Vec<Spanned<String>>,
    /// The same for the gauges of these groups.
    #[serde(default)]
    groups: Vec<Spanned<String>>,
    /// The same for the gauges with one of these tags.
    #[serde(default)]
    tags: Vec<Spanned<String>>,
    /// The same for the gauges on volumes of these zones.
    #[serde(default)]
    zones: Vec<Spanned<String>>,
    /// The same for the gauges of these segments, and for the segments themselves.
    #[serde(default)]
    segments: Vec<Spanned<String>>,
    /// The kinds of alarms that are suppressed: `above`, `below`, `rise`, `several`, `not-measurable` (these without the key), `fault`,
    /// `stale`, `segment-down`, `damaged-telegrams`, `bus-rate`. Without a gauge or segment they are those of the whole plant.
    kinds: Option<Vec<Spanned<String>>>,
    /// Single alarms that are suppressed too, by their names.
    #[serde(default)]
    alarms: Vec<Spanned<String>>,
    /// The longest time for which it is declared, 1 min to 31 days. Default: `24 h`.
    longest: Option<Spanned<Parsed<TimeSpan>>>,
    /// The lowest role that declares it: `operator` or `engineer`. Default: `operator`.
    role: Option<Spanned<String>>,
}

/// The parts of the file that plant states name.
pub struct Known<'a> {
    pub rules: &'a [Rule],
    pub segments: &'a [SegmentToml],
    pub directory: &'a Directory,
    pub plant: &'a PlantPicture,
}

/// The plant states of a file.
pub fn plant_states(given: &[PlantStateToml], known: &Known<'_>) -> Result<Vec<PlantStateRule>, Located> {
    names::unique(NamedItem::PlantState, given.iter().map(|state| &state.name))?;
    if let Some(state) = given.get(MAX_STATES) {
        let problem = ConfigProblem::TooManyPlantStates { most: MAX_STATES, found: given.len() };
        return Err(Located::new(state.name.span(), problem));
    }
    given.iter().map(|state| plant_state(state, known)).collect()
}

fn plant_state(given: &PlantStateToml, known: &Known<'_>) -> Result<PlantStateRule, Located> {
    names::check_length(NamedItem::PlantState, &given.name, MAX_NAME)?;
    given.description.as_ref().map_or(Ok(()), check_description)?;
    Ok(PlantStateRule {
        name: given.name.get_ref().clone(),
        description: given.description.as_ref().map(|text| text.get_ref().clone()),
        longest: given.longest.as_ref().map_or(Ok(LONGEST), longest)?,
        role: given.role.as_ref().map_or(Ok(Role::Operator), role)?,
        alarms: selected(given, known)?,
    })
}

fn check_description(text: &Spanned<String>) -> Result<(), Located> {
    check_line(text.get_ref()).map_err(|problem| Located::new(text.span(), ConfigProblem::Text(problem)))?;
    let found = text.get_ref().chars().count();
    if found <= MAX_DESCRIPTION {
        return Ok(());
    }
    let item = NamedItem::Description;
    Err(Located::new(text.span(), ConfigProblem::LongText { item, most: MAX_DESCRIPTION, found }))
}

fn longest(given: &Spanned<Parsed<TimeSpan>>) -> Result<Duration, Located> {
    let time = given.get_ref().0;
    if DECLARED.contains(&*time) {
        return Ok(time.into());
    }
    Err(Located::new(given.span(), ConfigProblem::LongestDeclared(time)))
}

fn role(given: &Spanned<String>) -> Result<Role, Located> {
    let roles = [Role::Operator, Role::Engineer];
    let found = roles.into_iter().find(|role| role.word() == given.get_ref());
    found.ok_or_else(|| Located::new(given.span(), ConfigProblem::DeclaringRole(given.get_ref().clone())))
}

/// What an entry of a list selects.
enum Selected {
    /// Gauges, and channels of controllers.
    Series(HashSet<String>),
    /// A segment with its gauges.
    Segment { name: String, gauges: HashSet<String> },
}

impl Selected {
    fn gauges(&self) -> &HashSet<String> {
        match self {
            Self::Series(gauges) | Self::Segment { gauges, .. } => gauges,
        }
    }

    /// Whether a measuring part of the condition is among its gauges.
    fn has_part_of(&self, condition: &Condition) -> bool {
        let gauges = self.gauges();
        condition.all_series().iter().any(|series| gauges.contains(&series.gauge) || gauges.contains(&series.name))
    }

    /// Whether the condition is about it: all measuring parts of it.
    fn has(&self, condition: &Condition) -> bool {
        matches!(self, Self::Segment { name, .. } if condition.segment() == Some(name))
            || is_about(condition, self.gauges())
    }
}

/// Whether all measuring parts of the condition are among these gauges and channels.
fn is_about(condition: &Condition, gauges: &HashSet<String>) -> bool {
    let has = |series: &&Series| gauges.contains(&series.gauge) || gauges.contains(&series.name);
    let series = condition.all_series();
    if series.is_empty() {
        condition.gauge().is_some_and(|gauge| gauges.contains(gauge))
    } else {
        series.iter().all(has)
    }
}

/// The names of the alarms that the plant state suppresses.
fn selected(given: &PlantStateToml, known: &Known<'_>) -> Result<BTreeSet<String>, Located> {
    let kinds = kinds(given)?;
    let entries = entries(given, known)?;
    if entries.is_empty() && given.kinds.as_ref().is_none_or(Vec::is_empty) && given.alarms.is_empty() {
        return Err(Located::new(given.name.span(), ConfigProblem::PlantStateContent(given.name.get_ref().clone())));
    }
    // Several entries together have all gauges of a condition about several.
    let all: HashSet<String> = entries.iter().flat_map(|(_, _, entry)| entry.gauges()).cloned().collect();
    let of_whole_plant = entries.is_empty() && given.kinds.is_some();
    let is_selected = |rule: &&Rule| {
        let condition = &rule.condition;
        kinds.contains(&condition.kind())
            && (of_whole_plant || is_about(condition, &all) || entries.iter().any(|(_, _, it)| it.has(condition)))
    };
    let rules: Vec<&Rule> = known.rules.iter().filter(is_selected).collect();
    for (key, name, entry) in &entries {
        if !rules.iter().any(|rule| entry.has(&rule.condition) || entry.has_part_of(&rule.condition)) {
            let kinds = kinds.iter().map(|kind| kind.word()).collect::<Vec<_>>().join(", ");
            let (key, name_text) = (*key, name.get_ref().clone());
            let problem = ConfigProblem::PlantStateSelectsNothing { key, name: name_text, kinds };
            return Err(Located::new(name.span(), problem));
        }
    }
    for kind in given.kinds.iter().flatten() {
        if !rules.iter().any(|rule| rule.condition.kind().word() == kind.get_ref()) {
            let state = given.name.get_ref().clone();
            let problem = ConfigProblem::PlantStateKind { kind: kind.get_ref().clone(), state };
            return Err(Located::new(kind.span(), problem));
        }
    }
    let single = given.alarms.iter().map(|name| single_alarm(name, known.rules)).collect::<Result<Vec<_>, _>>()?;
    Ok(rules.into_iter().map(|rule| rule.name.clone()).chain(single).collect())
}

/// Whether the alarms of this kind say that the record suffers, which no state of the plant explains.
const fn is_about_database(kind: ConditionKind) -> bool {
    matches!(kind, ConditionKind::NotRecording | ConditionKind::DatabaseDamaged)
}

fn kinds(given: &PlantStateToml) -> Result<Vec<ConditionKind>, Located> {
    let Some(given) = &given.kinds else { return Ok(KINDS.to_vec()) };
    let permitted = || ConditionKind::ALL.into_iter().filter(|kind| !is_about_database(*kind));
    let kind = |given: &Spanned<String>| {
        let found = permitted().find(|kind| kind.word() == given.get_ref());
        found.ok_or_else(|| {
            let known = permitted().map(ConditionKind::word).collect::<Vec<_>>().join(", ");
            Located::new(given.span(), ConfigProblem::UnknownAlarmKind { found: given.get_ref().clone(), known })
        })
    };
    given.iter().map(kind).collect()
}

/// An entry of a list: its key, its value, and what it selects.
type Entry<'a> = (&'static str, &'a Spanned<String>, Selected);

fn entries<'a>(given: &'a PlantStateToml, known: &Known<'_>) -> Result<Vec<Entry<'a>>, Located> {
    let mut entries = Vec::new();
    for name in &given.gauges {
        alarms::series(name, known.segments)?;
        entries.push(("gauges", name, Selected::Series(HashSet::from([name.get_ref().clone()]))));
    }
    let labelled = || known.directory.gauges.iter();
    for name in &given.groups {
        let of_group = labelled().filter_map(|(gauge, labels)| Some((labels.group.as_deref()?, gauge.as_str())));
        entries.push(("groups", name, labelled_with(NamedItem::Group, name, of_group)?));
    }
    for name in &given.tags {
        let of_tag =
            labelled().flat_map(|(gauge, labels)| labels.tags.iter().map(move |tag| (tag.as_str(), gauge.as_str())));
        entries.push(("tags", name, labelled_with(NamedItem::Tag, name, of_tag)?));
    }
    for name in &given.zones {
        let of_zone = known.plant.volumes.iter().flat_map(|volume| {
            let zone = volume.zone.as_deref();
            volume.gauges.iter().filter_map(move |gauge| Some((zone?, gauge.as_str())))
        });
        entries.push(("zones", name, labelled_with(NamedItem::Zone, name, of_zone)?));
    }
    for name in &given.segments {
        entries.push(("segments", name, segment(name, known.segments)?));
    }
    Ok(entries)
}

/// The gauges with this label; each item of `labels` is a label and a gauge that has it.
fn labelled_with<'a>(
    item: NamedItem,
    name: &Spanned<String>,
    labels: impl Iterator<Item = (&'a str, &'a str)>,
) -> Result<Selected, Located> {
    let labels: Vec<_> = labels.collect();
    let wanted = name.get_ref().as_str();
    let gauges: HashSet<String> =
        labels.iter().filter(|(label, _)| *label == wanted).map(|(_, gauge)| (*gauge).to_owned()).collect();
    if !gauges.is_empty() {
        return Ok(Selected::Series(gauges));
    }
    let suggestion = closest(wanted, labels.iter().map(|(label, _)| *label)).map(str::to_owned);
    let problem = ConfigProblem::UnknownPlantStateLabel { item, name: wanted.to_owned(), suggestion };
    Err(Located::new(name.span(), problem))
}

fn segment(name: &Spanned<String>, segments: &[SegmentToml]) -> Result<Selected, Located> {
    let wanted = name.get_ref();
    let found = segments.iter().find(|segment| segment.name.get_ref() == wanted);
    let unknown = || {
        let suggestion = closest(wanted, segments.iter().map(|segment| segment.name.get_ref().as_str()));
        let suggestion = suggestion.map(str::to_owned);
        Located::new(name.span(), ConfigProblem::UnknownSegment { name: wanted.clone(), suggestion })
    };
    let gauges = found.ok_or_else(unknown)?.gauge.iter().map(|gauge| gauge.name.get_ref().clone()).collect();
    Ok(Selected::Segment { name: wanted.clone(), gauges })
}

fn single_alarm(name: &Spanned<String>, rules: &[Rule]) -> Result<String, Located> {
    let wanted = name.get_ref();
    let Some(rule) = rules.iter().find(|rule| rule.name == *wanted) else {
        let suggestion = closest(wanted, rules.iter().map(|rule| rule.name.as_str())).map(str::to_owned);
        return Err(Located::new(name.span(), ConfigProblem::UnknownAlarm { name: wanted.clone(), suggestion }));
    };
    if is_about_database(rule.condition.kind()) {
        return Err(Located::new(name.span(), ConfigProblem::NeverSuppressed(wanted.clone())));
    }
    Ok(wanted.clone())
}
