//! Alarms in the file: what stands there, and what there is by itself.
//!
//! ```toml
//! [[alarm]]
//! name = "chamber too high"
//! gauge = "chamber"                # or a channel of a controller: "tpg.2"
//! above = "1e-3 mbar"              # or below = "…", or rise = 0.5 decades per minute
//! hysteresis = 0.1                 # decades; or reset = "8e-4 mbar"
//! delay = "1 s"
//! off-delay = "5 s"
//! priority = "high"                # high, medium, low
//! message = "close the valve to the lock"
//!
//! [alarms]
//! fault = { priority = "high" }
//! stale = { delay = "30 s", except = ["spare"] }
//! damage = { priority = "off" }
//! ```

use super::names::unique;
use super::{ALIKE, SegmentToml, SpannedMessage};
use crate::alarm::{Condition, Priority, Rule, Subject};
use profivac_client::pressure::Pressure;
use profivac_host::text_file::Parsed;
use serde::Deserialize;
use std::collections::{BTreeMap, HashSet};
use std::time::Duration;
use toml::Spanned;

/// What is usual. free choice: a tenth of a decade is more than gauges flicker, a second more than a single wrong reading lasts.
const HYSTERESIS: f64 = 0.1;
const DELAY: Duration = Duration::from_secs(1);
const OFF_DELAY: Duration = Duration::from_secs(5);
const WINDOW: Duration = Duration::from_secs(30);

/// The longest delay: whoever wants more does not want an alarm.
const LONGEST: Duration = Duration::from_secs(3600);

/// Windows through which a line is drawn.
const WINDOWS: (Duration, Duration) = (Duration::from_secs(5), Duration::from_secs(600));

/// More decades than a hysteresis, and a rise in a minute, can sensibly have.
const MOST_DECADES: f64 = 10.0;

/// An alarm of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct AlarmToml {
    name: Spanned<String>,
    gauge: Spanned<String>,
    above: Option<Spanned<Parsed<Pressure>>>,
    below: Option<Spanned<Parsed<Pressure>>>,
    rise: Option<Spanned<f64>>,
    reset: Option<Spanned<Parsed<Pressure>>>,
    hysteresis: Option<Spanned<f64>>,
    window: Option<Spanned<Parsed<humantime::Duration>>>,
    delay: Option<Spanned<Parsed<humantime::Duration>>>,
    off_delay: Option<Spanned<Parsed<humantime::Duration>>>,
    priority: Option<Spanned<String>>,
    message: Option<String>,
}

/// What is different about the alarms that there are by themselves.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DefaultAlarmsToml {
    #[serde(default)]
    fault: DefaultAlarmToml,
    #[serde(default)]
    stale: DefaultAlarmToml,
    #[serde(default)]
    blind: DefaultAlarmToml,
    #[serde(default)]
    segment: DefaultAlarmToml,
    #[serde(default)]
    damage: DefaultAlarmToml,
    #[serde(default)]
    record: DefaultAlarmToml,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct DefaultAlarmToml {
    priority: Option<Spanned<String>>,
    delay: Option<Spanned<Parsed<humantime::Duration>>>,
    off_delay: Option<Spanned<Parsed<humantime::Duration>>>,
    limit: Option<Spanned<f64>>,
    #[serde(default)]
    except: Vec<Spanned<String>>,
}

/// An alarm that there is by itself: its priority and its delays in seconds. free choice: long enough for what a bus does by itself,
/// a gauge that is started anew or a token that is lost.
struct Usual {
    priority: Priority,
    delay_s: u64,
    off_delay_s: u64,
}

const FAULT: Usual = Usual { priority: Priority::Medium, delay_s: 2, off_delay_s: 5 };
const STALE: Usual = Usual { priority: Priority::Medium, delay_s: 15, off_delay_s: 2 };
const BLIND: Usual = Usual { priority: Priority::Medium, delay_s: 15, off_delay_s: 5 };
const SEGMENT: Usual = Usual { priority: Priority::High, delay_s: 10, off_delay_s: 5 };
const DAMAGE: Usual = Usual { priority: Priority::Low, delay_s: 0, off_delay_s: 0 };
const RECORD: Usual = Usual { priority: Priority::High, delay_s: 10, off_delay_s: 0 };

/// So many damaged telegrams in a minute. free choice: one in some thousand on a bus that is asked all the time.
const MOST_DAMAGED: f64 = 30.0;

/// All alarms: those of the file, then those that there are by themselves.
pub fn rules(
    written: &[AlarmToml],
    defaults: &DefaultAlarmsToml,
    segments: &[SegmentToml],
) -> Result<Vec<Rule>, SpannedMessage> {
    unique("alarm", written.iter().map(|alarm| &alarm.name))?;
    let mut rules = written.iter().map(|alarm| rule(alarm, segments)).collect::<Result<Vec<_>, _>>()?;
    let own = by_themselves(&rules, defaults, segments)?;
    let taken: HashSet<_> = own.iter().map(|rule| rule.name.as_str()).collect();
    if let Some(twice) = written.iter().find(|alarm| taken.contains(alarm.name.get_ref().as_str())) {
        let name = twice.name.get_ref();
        return Err((twice.name.span(), format!("there is an alarm {name:?} by itself; [alarms] says how it is")));
    }
    rules.extend(own);
    Ok(rules)
}

fn rule(alarm: &AlarmToml, segments: &[SegmentToml]) -> Result<Rule, SpannedMessage> {
    let (delay, off_delay) = (delay(alarm.delay.as_ref(), DELAY)?, delay(alarm.off_delay.as_ref(), OFF_DELAY)?);
    Ok(Rule {
        name: alarm.name.get_ref().clone(),
        subject: subject(&alarm.gauge, segments)?,
        condition: condition(alarm)?,
        priority: priority(alarm.priority.as_ref(), Priority::Medium, &[])?.unwrap_or(Priority::Medium),
        delay,
        off_delay,
        message: alarm.message.clone(),
    })
}

/// A gauge, or a channel of one.
fn subject(name: &Spanned<String>, segments: &[SegmentToml]) -> Result<Subject, SpannedMessage> {
    let series = name.get_ref();
    let known: Vec<_> = gauges(segments).collect();
    let channel = series.rsplit_once('.').filter(|(_, channel)| channel.parse::<u8>().is_ok());
    let gauge = known.iter().find(|known| **known == series).or_else(|| {
        let (gauge, _) = channel?;
        known.iter().find(|known| **known == gauge)
    });
    let unknown = || {
        let meant = meant(channel.map_or(series, |(gauge, _)| gauge), known.iter().map(|name| name.as_str()));
        (name.span(), format!("there is no gauge {series:?}{meant}"))
    };
    let gauge = (*gauge.ok_or_else(unknown)?).clone();
    Ok(Subject::Series { gauge, series: series.clone() })
}

fn gauges(segments: &[SegmentToml]) -> impl Iterator<Item = &String> {
    segments.iter().flat_map(|segment| &segment.gauge).map(|gauge| gauge.name.get_ref())
}

/// What a name may have meant.
fn meant<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let likeness = |known: &str| strsim::normalized_damerau_levenshtein(&name.to_lowercase(), &known.to_lowercase());
    let best = known.max_by(|one, two| likeness(one).total_cmp(&likeness(two)));
    best.filter(|best| likeness(best) >= ALIKE).map(|best| format!("; did you mean {best:?}?")).unwrap_or_default()
}

fn condition(alarm: &AlarmToml) -> Result<Condition, SpannedMessage> {
    let AlarmToml { above, below, rise, reset, hysteresis, window, .. } = alarm;
    let name = alarm.name.get_ref();
    if let Some(window) = window.as_ref().filter(|_| rise.is_none()) {
        return Err((window.span(), "a window belongs to rise alone".to_owned()));
    }
    match (above, below, rise) {
        (Some(limit), None, None) => {
            let reset = over(limit, reset.as_ref(), hysteresis.as_ref(), -1.0)?;
            Ok(Condition::Above { limit: limit.get_ref().0.pa(), reset })
        }
        (None, Some(limit), None) => {
            let reset = over(limit, reset.as_ref(), hysteresis.as_ref(), 1.0)?;
            Ok(Condition::Below { limit: limit.get_ref().0.pa(), reset })
        }
        (None, None, Some(limit)) => rising(limit, reset.as_ref(), hysteresis.as_ref(), window.as_ref()),
        _ => {
            let problem = format!("expected one of above, below and rise for the alarm {name:?}");
            Err((alarm.name.span(), problem))
        }
    }
}

/// Where a limit alarm is over, in Pa: `side` is -1 where that is below the limit.
fn over(
    limit: &Spanned<Parsed<Pressure>>,
    reset: Option<&Spanned<Parsed<Pressure>>>,
    hysteresis: Option<&Spanned<f64>>,
    side: f64,
) -> Result<f64, SpannedMessage> {
    let pa = limit.get_ref().0.pa();
    if pa <= 0.0 {
        return Err((limit.span(), format!("expected a pressure above nothing, got {}", limit.get_ref().0)));
    }
    match (reset, hysteresis) {
        (Some(reset), Some(_)) => Err((reset.span(), "expected reset or hysteresis, got both".to_owned())),
        (Some(reset), None) => {
            let over = reset.get_ref().0;
            let (word, fits) = if side < 0.0 { ("above", over.pa() <= pa) } else { ("below", over.pa() >= pa) };
            let problem = || {
                format!(
                    "an alarm cannot be over {word} its limit: expected not {word} {}, got {over}",
                    limit.get_ref().0
                )
            };
            if fits { Ok(over.pa()) } else { Err((reset.span(), problem())) }
        }
        (None, decades) => {
            let decades = decades.map_or(Ok(HYSTERESIS), |given| number(given, "a hysteresis in decades", 0.0))?;
            Ok(pa * 10_f64.powf(side * decades))
        }
    }
}

fn rising(
    limit: &Spanned<f64>,
    reset: Option<&Spanned<Parsed<Pressure>>>,
    hysteresis: Option<&Spanned<f64>>,
    window: Option<&Spanned<Parsed<humantime::Duration>>>,
) -> Result<Condition, SpannedMessage> {
    if let Some(reset) = reset {
        return Err((reset.span(), "a rise has no reset: hysteresis says by how much slower it must be".to_owned()));
    }
    let rate = number(limit, "decades per minute", f64::MIN_POSITIVE)?;
    // free choice: over at half of it.
    let hysteresis =
        hysteresis.map_or(Ok(rate / 2.0), |given| number(given, "a hysteresis in decades per minute", 0.0))?;
    let window = match window {
        Some(given) if !(WINDOWS.0..=WINDOWS.1).contains(&*given.get_ref().0) => {
            return Err((given.span(), format!("expected a window from 5s to 10m, got {}", given.get_ref().0)));
        }
        Some(given) => given.get_ref().0.into(),
        None => WINDOW,
    };
    Ok(Condition::Rise { limit: rate, reset: rate - hysteresis, window })
}

fn number(given: &Spanned<f64>, what: &str, least: f64) -> Result<f64, SpannedMessage> {
    let value = *given.get_ref();
    let fits = (least..=MOST_DECADES).contains(&value);
    let least = if least > 0.0 { "above 0" } else { "from 0" };
    if fits {
        Ok(value)
    } else {
        Err((given.span(), format!("expected {what} {least} to {MOST_DECADES}, got {value}")))
    }
}

fn delay(given: Option<&Spanned<Parsed<humantime::Duration>>>, usual: Duration) -> Result<Duration, SpannedMessage> {
    match given {
        Some(given) if Duration::from(given.get_ref().0) > LONGEST => {
            Err((given.span(), format!("expected a time up to 1h, got {}", given.get_ref().0)))
        }
        Some(given) => Ok(given.get_ref().0.into()),
        None => Ok(usual),
    }
}

/// A priority; nothing for one of the words in `off`.
pub fn priority(
    given: Option<&Spanned<String>>,
    usual: Priority,
    off: &[&str],
) -> Result<Option<Priority>, SpannedMessage> {
    let Some(given) = given else { return Ok(Some(usual)) };
    let word = given.get_ref().as_str();
    if off.contains(&word) {
        return Ok(None);
    }
    let words: Vec<_> = Priority::ALL.iter().map(|known| known.word()).chain(off.iter().copied()).collect();
    let unknown = || (given.span(), format!("expected a priority out of {}, got {word:?}", words.join(", ")));
    Priority::from_word(word).map(Some).ok_or_else(unknown)
}

/// A kind of alarm that there is by itself.
struct Own<'a> {
    priority: Option<Priority>,
    delay: Duration,
    off_delay: Duration,
    except: HashSet<&'a str>,
}

impl<'a> Own<'a> {
    /// `known` are the names of what such an alarm can be about.
    fn of(written: &'a DefaultAlarmToml, usual: &Usual, what: &str, known: &[&str]) -> Result<Self, SpannedMessage> {
        for name in &written.except {
            if !known.contains(&name.get_ref().as_str()) {
                let meant = meant(name.get_ref(), known.iter().copied());
                return Err((name.span(), format!("there is no {what} {:?}{meant}", name.get_ref())));
            }
        }
        Ok(Self {
            priority: priority(written.priority.as_ref(), usual.priority, &["off"])?,
            delay: delay(written.delay.as_ref(), Duration::from_secs(usual.delay_s))?,
            off_delay: delay(written.off_delay.as_ref(), Duration::from_secs(usual.off_delay_s))?,
            except: written.except.iter().map(|name| name.get_ref().as_str()).collect(),
        })
    }

    /// Such an alarm about `about`, unless there is to be none.
    fn rule(&self, about: &str, name: String, subject: Subject, condition: Condition) -> Option<Rule> {
        let priority = self.priority.filter(|_| !self.except.contains(about))?;
        let Self { delay, off_delay, .. } = *self;
        Some(Rule { name, subject, condition, priority, delay, off_delay, message: None })
    }
}

fn by_themselves(
    rules: &[Rule],
    defaults: &DefaultAlarmsToml,
    segments: &[SegmentToml],
) -> Result<Vec<Rule>, SpannedMessage> {
    let names: Vec<_> = gauges(segments).map(String::as_str).collect();
    let lines: Vec<_> = segments.iter().map(|segment| segment.name.get_ref().as_str()).collect();
    let fault = Own::of(&defaults.fault, &FAULT, "gauge", &names)?;
    let stale = Own::of(&defaults.stale, &STALE, "gauge", &names)?;
    let blind = Own::of(&defaults.blind, &BLIND, "gauge", &names)?;
    let down = Own::of(&defaults.segment, &SEGMENT, "segment", &lines)?;
    let damage = Own::of(&defaults.damage, &DAMAGE, "segment", &lines)?;
    let record = Own::of(&defaults.record, &RECORD, "record", &[])?;
    let most_damaged = most_damaged(defaults)?;
    let mut own = Vec::new();
    for segment in segments {
        let line = segment.name.get_ref();
        let about = || Subject::Segment(line.clone());
        let is_down = down.rule(line, format!("segment {line}: down"), about(), Condition::SegmentDown);
        let behind_segment = is_down.as_ref().map(|_| line.clone());
        own.extend(is_down);
        own.extend(damage.rule(
            line,
            format!("segment {line}: damage"),
            about(),
            Condition::DamagedTelegrams { limit: most_damaged },
        ));
        for name in segment.gauge.iter().map(|gauge| gauge.name.get_ref()) {
            let about = || Subject::Gauge(name.clone());
            own.extend(fault.rule(name, format!("{name}: fault"), about(), Condition::Fault));
            let behind_segment = behind_segment.clone();
            own.extend(stale.rule(name, format!("{name}: no data"), about(), Condition::Stale { behind_segment }));
        }
    }
    for (subject, limits) in limited(rules) {
        let Subject::Series { gauge, series } = &subject else { continue };
        own.extend(blind.rule(gauge, format!("{series}: blind"), subject.clone(), Condition::NotMeasurable { limits }));
    }
    own.extend(record.rule("record", "record: not written".to_owned(), Subject::Station, Condition::NotRecording));
    Ok(own)
}

/// The limits of each part that has some; a rise makes a part one that must be seen, too.
fn limited(rules: &[Rule]) -> Vec<(Subject, Vec<f64>)> {
    let mut parts: BTreeMap<&str, (Subject, Vec<f64>)> = BTreeMap::new();
    for rule in rules {
        let Subject::Series { series, .. } = &rule.subject else { continue };
        let (_, limits) = parts.entry(series).or_insert_with(|| (rule.subject.clone(), Vec::new()));
        if rule.condition.unit() == Some("Pa") {
            limits.extend(rule.condition.limit());
        }
    }
    parts.into_values().collect()
}

/// A limit is said of damage alone.
fn most_damaged(defaults: &DefaultAlarmsToml) -> Result<f64, SpannedMessage> {
    let DefaultAlarmsToml { fault, stale, blind, segment, damage, record } = defaults;
    if let Some(limit) = [fault, stale, blind, segment, record].into_iter().find_map(|other| other.limit.as_ref()) {
        return Err((limit.span(), "only damage has a limit, in telegrams per minute".to_owned()));
    }
    match &damage.limit {
        Some(limit) if !(1.0..=1e6).contains(limit.get_ref()) => {
            Err((limit.span(), format!("expected from 1 to 1000000 telegrams per minute, got {}", limit.get_ref())))
        }
        Some(limit) => Ok(*limit.get_ref()),
        None => Ok(MOST_DAMAGED),
    }
}
