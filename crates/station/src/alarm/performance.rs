//! Figures of the alarm system after ISA-18.2 (IEC 62682), clause 16, and EEMUA 191: how many alarms an operator gets, when, and which.

use profivac_model::Priority;
use profivac_recorder::Micros;
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;
use utoipa::ToSchema;

/// Alarms are counted in periods of this length: ten minutes.
const PERIOD: i64 = 600 * Micros::SECOND;
const PERIODS_PER_HOUR: f64 = 6.0;

/// More alarms than this in a period are a flood: ISA-18.2, more than ten in ten minutes.
const MOST_IN_A_PERIOD: u64 = 10;

/// An alarm that is raised this often within [`CHATTERING_TIME`] chatters: EEMUA 191.
const CHATTERING: usize = 3;
const CHATTERING_TIME: i64 = 60 * Micros::SECOND;

/// The alarms that are raised most often, in the list of the most frequent.
const MOST_FREQUENT: usize = 10;

/// An alarm is long active after this time: ISA-18.2 calls it stale, a word that means missing data here.
pub const LONG_ACTIVE_AFTER: Duration = Duration::from_secs(24 * 3600);

/// An alarm was raised.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raised {
    /// When.
    pub at: Micros,
    /// The name of the alarm.
    pub alarm: String,
    /// Its priority at that time; `None` if the database has a word that this program does not know.
    pub priority: Option<Priority>,
}

/// Figures about the alarms of a time range.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct AlarmPerformance {
    /// The beginning, in milliseconds since 1970.
    pub from_ms: i64,
    /// The end, in milliseconds since 1970.
    pub to_ms: i64,
    /// The time in hours in which the station recorded. The rates refer to it.
    pub recorded_hours: f64,
    /// Alarms that were raised.
    pub raised: u64,
    /// Alarms per hour; `null` if the station did not record.
    pub per_hour: Option<f64>,
    /// The ten minutes with the most alarms; `null` without alarms.
    pub worst_ten_minutes: Option<TenMinutes>,
    /// The part of the recorded time, in percent, in periods of ten minutes with more than ten alarms; `null` if the station did not
    /// record.
    pub flood_percent: Option<f64>,
    /// How often a declared plant state suppressed an alarm. These are not among the raised ones.
    pub suppressed: u64,
    /// Alarms raised, by priority.
    pub by_priority: RaisedByPriority,
    /// The alarms that were raised most often, up to ten.
    pub most_frequent: Vec<FrequentAlarm>,
    /// Alarms that were raised three times within a minute at least once, by name.
    pub chattering: Vec<String>,
    /// Alarms that are active now, for longer than a day, by name.
    pub long_active: Vec<String>,
}

/// A period of ten minutes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct TenMinutes {
    /// Its beginning, in milliseconds since 1970.
    pub from_ms: i64,
    /// The alarms that were raised in it.
    pub raised: u64,
}

/// Alarms raised, by priority.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct RaisedByPriority {
    /// High.
    pub high: u64,
    /// Medium.
    pub medium: u64,
    /// Low.
    pub low: u64,
}

/// An alarm and how often it was raised.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct FrequentAlarm {
    /// Its name.
    pub alarm: String,
    /// How often it was raised.
    pub raised: u64,
    /// That part of all raised alarms, in percent.
    pub percent: f64,
}

/// Counts raised alarms, the earliest first. Its size depends on the number of alarms and on the length of the time, not on how often they
/// were raised.
#[derive(Debug)]
pub struct Counter {
    from: Micros,
    to: Micros,
    recorded: Duration,
    raised: u64,
    by_priority: RaisedByPriority,
    alarms: BTreeMap<String, AlarmCounter>,
    /// The alarms of each period with any.
    periods: BTreeMap<i64, u64>,
}

/// Counts one alarm.
#[derive(Debug, Default)]
struct AlarmCounter {
    raised: u64,
    latest: VecDeque<Micros>,
    chatters: bool,
}

impl AlarmCounter {
    fn count(&mut self, at: Micros) {
        self.raised = self.raised.saturating_add(1);
        self.latest.push_back(at);
        if self.latest.len() > CHATTERING {
            self.latest.pop_front();
        }
        let first = self.latest.front().map_or(at.0, |first| first.0);
        self.chatters |= self.latest.len() == CHATTERING && at.0.saturating_sub(first) <= CHATTERING_TIME;
    }
}

impl Counter {
    /// Counts from `from` to `to`, of which `recorded` is the time in which the station recorded.
    #[must_use]
    pub fn new(from: Micros, to: Micros, recorded: Duration) -> Self {
        let (by_priority, alarms, periods) = (RaisedByPriority::default(), BTreeMap::new(), BTreeMap::new());
        Self { from, to, recorded, raised: 0, by_priority, alarms, periods }
    }

    /// Counts an alarm.
    pub fn count(&mut self, raised: Raised) {
        let Raised { at, alarm, priority } = raised;
        self.raised = self.raised.saturating_add(1);
        let of_priority = match priority {
            Some(Priority::High) => Some(&mut self.by_priority.high),
            Some(Priority::Medium) => Some(&mut self.by_priority.medium),
            Some(Priority::Low) => Some(&mut self.by_priority.low),
            None => None,
        };
        if let Some(count) = of_priority {
            *count = count.saturating_add(1);
        }
        let period = at.0.saturating_sub(self.from.0).div_euclid(PERIOD);
        let count = self.periods.entry(period).or_default();
        *count = count.saturating_add(1);
        self.alarms.entry(alarm).or_default().count(at);
    }

    /// The figures; `suppressed` is the number of suppressed alarms in the database, `long_active` are the names of the alarms that have
    /// been active for longer than [`LONG_ACTIVE_AFTER`].
    #[must_use]
    pub fn figures(self, suppressed: u64, long_active: Vec<String>) -> AlarmPerformance {
        let hours = self.recorded.as_secs_f64() / 3600.0;
        let per_recorded = |amount: f64| (hours > 0.0).then(|| amount / hours);
        let floods = self.periods.values().filter(|raised| **raised > MOST_IN_A_PERIOD).count();
        let worst = self.periods.iter().rev().max_by_key(|(_, raised)| **raised);
        let worst_ten_minutes = worst.map(|(period, raised)| {
            let from = self.from.0.saturating_add(period.saturating_mul(PERIOD));
            TenMinutes { from_ms: from.div_euclid(1000), raised: *raised }
        });
        let chattering = self.alarms.iter().filter(|(_, alarm)| alarm.chatters).map(|(name, _)| name.clone());
        AlarmPerformance {
            from_ms: self.from.0.div_euclid(1000),
            to_ms: self.to.0.div_euclid(1000),
            recorded_hours: hours,
            raised: self.raised,
            per_hour: per_recorded(self.raised as f64),
            worst_ten_minutes,
            flood_percent: per_recorded(100.0 * floods as f64 / PERIODS_PER_HOUR).map(|percent| percent.min(100.0)),
            suppressed,
            by_priority: self.by_priority,
            chattering: chattering.collect(),
            most_frequent: most_frequent(self.alarms, self.raised),
            long_active,
        }
    }
}

/// The alarms that were raised most often; among equals in the order of their names.
fn most_frequent(alarms: BTreeMap<String, AlarmCounter>, all: u64) -> Vec<FrequentAlarm> {
    let mut list: Vec<_> = alarms.into_iter().map(|(alarm, counter)| (alarm, counter.raised)).collect();
    list.sort_by_key(|(_, raised)| std::cmp::Reverse(*raised));
    let percent = |raised: u64| 100.0 * raised as f64 / all.max(1) as f64;
    let with_percent = |(alarm, raised)| FrequentAlarm { alarm, raised, percent: percent(raised) };
    list.into_iter().take(MOST_FREQUENT).map(with_percent).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEGIN: i64 = 1_700_000_000 * Micros::SECOND;
    const HOUR: i64 = 3600 * Micros::SECOND;

    fn counter(hours: i64) -> Counter {
        Counter::new(Micros(BEGIN), Micros(BEGIN + hours * HOUR), Duration::from_secs(3600 * hours.unsigned_abs()))
    }

    fn raise(counter: &mut Counter, name: &str, seconds: i64) {
        let at = Micros(BEGIN + seconds * Micros::SECOND);
        counter.count(Raised { at, alarm: name.to_owned(), priority: Some(Priority::Low) });
    }

    #[test]
    fn rates_are_those_of_the_whole_time() {
        let mut counter = counter(10);
        for second in [10, 4_000, 8_000, 30_000, 35_999] {
            raise(&mut counter, "chamber: fault", second);
        }
        let figures = counter.figures(0, Vec::new());
        assert_eq!((figures.raised, figures.per_hour, figures.recorded_hours), (5, Some(0.5), 10.0));
        assert_eq!(figures.by_priority, RaisedByPriority { low: 5, ..RaisedByPriority::default() });
        assert_eq!(
            figures.most_frequent,
            [FrequentAlarm { alarm: "chamber: fault".to_owned(), raised: 5, percent: 100.0 }]
        );
        assert_eq!((figures.flood_percent, figures.chattering), (Some(0.0), Vec::<String>::new()));
    }

    #[test]
    fn eleven_alarms_in_ten_minutes_are_a_flood_and_ten_are_not() {
        let mut counter = counter(1);
        for index in 0..11 {
            raise(&mut counter, &format!("gauge {index}"), 600 + index);
        }
        for index in 0..10 {
            raise(&mut counter, &format!("gauge {index}"), 1_200 + index);
        }
        let figures = counter.figures(0, Vec::new());
        let percent = figures.flood_percent.unwrap();
        assert!((percent - 100.0 / 6.0).abs() < 1e-9, "{percent}");
        let expected = TenMinutes { from_ms: (BEGIN + 600 * Micros::SECOND) / 1000, raised: 11 };
        assert_eq!(figures.worst_ten_minutes, Some(expected));
    }

    #[test]
    fn three_times_in_a_minute_is_chattering() {
        let mut counter = counter(1);
        for second in [0, 31, 60] {
            raise(&mut counter, "chatters", second);
        }
        for second in [0, 31, 61, 93] {
            raise(&mut counter, "is often raised", second);
        }
        assert_eq!(counter.figures(0, Vec::new()).chattering, ["chatters"]);
    }

    #[test]
    fn the_ten_most_frequent_alarms_are_listed_with_their_part() {
        let mut counter = counter(1);
        for index in 0..12 {
            for _ in 0..=index {
                raise(&mut counter, &format!("gauge {index:02}"), 0);
            }
        }
        let figures = counter.figures(0, Vec::new());
        assert_eq!((figures.raised, figures.most_frequent.len()), (78, 10));
        let first = figures.most_frequent.first().unwrap();
        assert_eq!((first.alarm.as_str(), first.raised), ("gauge 11", 12));
        assert!((first.percent - 1200.0 / 78.0).abs() < 1e-9);
    }

    #[test]
    fn a_time_without_alarms_has_zeros() {
        let figures = counter(24).figures(0, vec!["chamber: fault".to_owned()]);
        let expected = AlarmPerformance {
            from_ms: BEGIN / 1000,
            to_ms: (BEGIN + 24 * HOUR) / 1000,
            recorded_hours: 24.0,
            per_hour: Some(0.0),
            flood_percent: Some(0.0),
            long_active: vec!["chamber: fault".to_owned()],
            ..AlarmPerformance::default()
        };
        assert_eq!(figures, expected);
    }

    #[test]
    fn without_a_record_there_is_no_rate() {
        let figures = Counter::new(Micros(BEGIN), Micros(BEGIN + HOUR), Duration::ZERO).figures(0, Vec::new());
        assert_eq!((figures.per_hour, figures.flood_percent, figures.raised), (None, None, 0));
    }
}
