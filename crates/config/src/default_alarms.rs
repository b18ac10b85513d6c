//! `[alarms]`: the alarms that every gauge, every segment and the station have without an `[[alarm]]`.
//!
//! ```toml
//! [alarms]
//! fault = { priority = "high" }
//! stale = { delay = "30 s", except = ["spare"] }
//! damage = { priority = "off" }
//! ```

use super::error::{ConfigProblem, Located};
use super::number_range::NumberRange;
use super::segments::SegmentToml;
use super::values::{delay, number, priority_or_off};
use crate::time_span::TimeSpan;
use profivac_client::suggestion::closest;
use profivac_host::text_file::Parsed;
use profivac_station::alarm::{Condition, Priority, Rule, Series};
use profivac_station::config::default_alarms::{
    DAMAGE, DATABASE, DATABASE_DAMAGE, Defaults, FAULT, MAX_DAMAGED, NOT_MEASURABLE, SEGMENT, STALE,
};
use serde::Deserialize;
use std::collections::{BTreeMap, HashSet};
use std::time::Duration;
use toml::Spanned;

/// The table `[alarms]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct DefaultAlarmsToml {
    /// A gauge reports a fault. Default: medium, after 2 s, ends after 5 s.
    #[serde(default)]
    fault: DefaultAlarmToml,
    /// A gauge sends nothing. Default: medium, after 15 s, ends after 2 s.
    #[serde(default)]
    stale: DefaultAlarmToml,
    /// The gauge of a limit alarm measures nothing. Default: medium, after 15 s, ends after 5 s.
    pub not_measurable: Option<Spanned<DefaultAlarmToml>>,
    /// A segment is down. Default: high, after 10 s, ends after 5 s.
    #[serde(default)]
    segment: DefaultAlarmToml,
    /// Damaged telegrams on a segment. Default: low, without delays.
    #[serde(default)]
    damage: DefaultAlarmToml,
    /// The station does not record. Default: high, after 10 s, ends at once.
    pub database: Option<Spanned<DefaultAlarmToml>>,
    /// The daily check has found damage in the database. Default: medium, without delays.
    #[serde(default)]
    database_damage: DefaultAlarmToml,
    /// The former name of `not-measurable`.
    pub blind: Option<Spanned<DefaultAlarmToml>>,
    /// The former name of `database`.
    pub record: Option<Spanned<DefaultAlarmToml>>,
}

/// The settings of one default alarm.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct DefaultAlarmToml {
    /// `high`, `medium`, `low`, or `off`: then there is no such alarm.
    priority: Option<Spanned<String>>,
    /// The condition must hold for this time, up to 1 h.
    delay: Option<Spanned<Parsed<TimeSpan>>>,
    /// The condition must be over for this time, up to 1 h.
    off_delay: Option<Spanned<Parsed<TimeSpan>>>,
    /// For `damage` only: the damaged telegrams in a minute. Default: 30.
    limit: Option<Spanned<f64>>,
    /// Gauges, or for `segment` and `damage` segments, that have no such alarm.
    #[serde(default)]
    except: Vec<Spanned<String>>,
}

/// The default alarms for all segments and gauges, and for the limits in `rules`.
pub fn default_alarms(
    rules: &[Rule],
    given: &DefaultAlarmsToml,
    segments: &[SegmentToml],
) -> Result<Vec<Rule>, Located> {
    let alarms = Templates::new(given, segments)?;
    let mut all = Vec::new();
    for segment in segments {
        let name = segment.name.get_ref();
        let condition = Condition::SegmentDown { segment: name.clone() };
        let down = alarms.segment.rule(name, format!("segment {name}: down"), condition);
        // While the alarm of the segment is raised, its gauges raise none.
        let behind_segment = down.as_ref().map(|_| name.clone());
        all.extend(down);
        let condition = Condition::DamagedTelegrams { segment: name.clone(), limit: alarms.max_damaged };
        all.extend(alarms.damage.rule(name, format!("segment {name}: damage"), condition));
        for name in names_of(segment) {
            let condition = Condition::Fault { gauge: name.clone() };
            all.extend(alarms.fault.rule(name, format!("{name}: fault"), condition));
            let condition = Condition::Stale { gauge: name.clone(), behind_segment: behind_segment.clone() };
            all.extend(alarms.stale.rule(name, format!("{name}: no data"), condition));
        }
    }
    for (series, limits) in limits_by_series(rules) {
        let (gauge, name) = (series.gauge.clone(), format!("{}: limit not measurable", series.name));
        let has_fault_alarm = alarms.fault.applies_to(&gauge);
        let condition = Condition::NotMeasurable { series, limits, has_fault_alarm };
        all.extend(alarms.not_measurable.rule(&gauge, name, condition));
    }
    all.extend(alarms.database.rule("", "station: not recording".to_owned(), Condition::NotRecording));
    all.extend(alarms.database_damage.rule("", "station: database damaged".to_owned(), Condition::DatabaseDamaged));
    Ok(all)
}

/// The names of gauges and other slaves: both report faults, and may give no data.
fn names_of(segment: &SegmentToml) -> impl Iterator<Item = &String> {
    let slaves = segment.slave.iter().map(|slave| slave.name.get_ref());
    segment.gauge.iter().map(|gauge| gauge.name.get_ref()).chain(slaves)
}

/// The settings of all default alarms.
struct Templates<'a> {
    fault: Template<'a>,
    stale: Template<'a>,
    not_measurable: Template<'a>,
    segment: Template<'a>,
    damage: Template<'a>,
    database: Template<'a>,
    database_damage: Template<'a>,
    max_damaged: f64,
}

impl<'a> Templates<'a> {
    fn new(given: &'a DefaultAlarmsToml, segments: &'a [SegmentToml]) -> Result<Self, Located> {
        let DefaultAlarmsToml {
            fault,
            stale,
            not_measurable,
            segment,
            damage,
            database,
            database_damage,
            blind,
            record,
        } = given;
        let either = |new: &'a Option<Spanned<_>>, old: &'a Option<Spanned<_>>| {
            new.as_ref().or(old.as_ref()).map_or(&EMPTY, Spanned::get_ref)
        };
        let (not_measurable, database) = (either(not_measurable, blind), either(database, record));
        let others = [fault, stale, not_measurable, segment, database, database_damage];
        if let Some(limit) = others.into_iter().find_map(|other| other.limit.as_ref()) {
            return Err(Located::new(limit.span(), ConfigProblem::LimitWithoutDamage));
        }
        let gauges = Exceptions::Gauges(segments.iter().flat_map(names_of).map(String::as_str).collect());
        let segments = Exceptions::Segments(segments.iter().map(|segment| segment.name.get_ref().as_str()).collect());
        Ok(Self {
            fault: Template::new(fault, &FAULT, &gauges)?,
            stale: Template::new(stale, &STALE, &gauges)?,
            not_measurable: Template::new(not_measurable, &NOT_MEASURABLE, &gauges)?,
            segment: Template::new(segment, &SEGMENT, &segments)?,
            damage: Template::new(damage, &DAMAGE, &segments)?,
            database: Template::new(database, &DATABASE, &Exceptions::None)?,
            database_damage: Template::new(database_damage, &DATABASE_DAMAGE, &Exceptions::None)?,
            max_damaged: max_damaged(damage)?,
        })
    }
}

/// Settings that the file does not give.
static EMPTY: DefaultAlarmToml =
    DefaultAlarmToml { priority: None, delay: None, off_delay: None, limit: None, except: Vec::new() };

/// The names that `except` may list.
enum Exceptions<'a> {
    Gauges(Vec<&'a str>),
    Segments(Vec<&'a str>),
    None,
}

impl Exceptions<'_> {
    fn check(&self, name: &Spanned<String>) -> Result<(), Located> {
        let text = name.get_ref();
        let (Self::Gauges(known) | Self::Segments(known)) = self else {
            return Err(Located::new(name.span(), ConfigProblem::NoExceptions(text.clone())));
        };
        if known.contains(&text.as_str()) {
            return Ok(());
        }
        let suggestion = closest(text, known.iter().copied()).map(str::to_owned);
        let name_text = text.clone();
        Err(Located::new(
            name.span(),
            match self {
                Self::Segments(_) => ConfigProblem::UnknownSegment { name: name_text, suggestion },
                Self::Gauges(_) | Self::None => {
                    let known = known.iter().copied().map(str::to_owned).collect();
                    ConfigProblem::UnknownGauge { name: name_text, suggestion, known }
                }
            },
        ))
    }
}

/// The settings of one default alarm, from which a rule for each gauge or segment is made.
struct Template<'a> {
    /// `None` if the alarm is off.
    priority: Option<Priority>,
    delay: Duration,
    off_delay: Duration,
    except: HashSet<&'a str>,
}

impl<'a> Template<'a> {
    fn new(given: &'a DefaultAlarmToml, defaults: &Defaults, exceptions: &Exceptions<'_>) -> Result<Self, Located> {
        given.except.iter().try_for_each(|name| exceptions.check(name))?;
        Ok(Self {
            priority: priority_or_off(given.priority.as_ref(), defaults.priority)?,
            delay: delay(given.delay.as_ref(), Duration::from_secs(defaults.delay_s))?,
            off_delay: delay(given.off_delay.as_ref(), Duration::from_secs(defaults.off_delay_s))?,
            except: given.except.iter().map(|name| name.get_ref().as_str()).collect(),
        })
    }

    /// Whether the gauge or segment `about` has this alarm.
    fn applies_to(&self, about: &str) -> bool {
        self.priority.is_some() && !self.except.contains(about)
    }

    /// The rule for the gauge or segment `about`; `None` if the alarm is off or excepts it.
    fn rule(&self, about: &str, name: String, condition: Condition) -> Option<Rule> {
        let priority = self.priority.filter(|_| self.applies_to(about))?;
        let Self { delay, off_delay, .. } = *self;
        Some(Rule { name, condition, priority, delay, off_delay, message: None })
    }
}

/// The pressure limits in Pa of every series that an alarm watches. A series that only a rise watches has an empty list: its
/// gauge must be able to measure too.
fn limits_by_series(rules: &[Rule]) -> Vec<(Series, Vec<f64>)> {
    let mut all: BTreeMap<&str, (Series, Vec<f64>)> = BTreeMap::new();
    for rule in rules {
        for series in rule.condition.all_series() {
            let (_, limits) = all.entry(&series.name).or_insert_with(|| (series.clone(), Vec::new()));
            limits.extend(rule.condition.pressure_limit());
        }
    }
    all.into_values().collect()
}

fn max_damaged(damage: &DefaultAlarmToml) -> Result<f64, Located> {
    let Some(limit) = &damage.limit else { return Ok(MAX_DAMAGED) };
    number(*limit.get_ref(), limit.span(), "telegrams per minute", NumberRange::Between(1.0, 1e6))
}
