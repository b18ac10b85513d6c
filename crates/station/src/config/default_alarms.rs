//! What holds for the default alarms where the file has no settings.

use super::DefaultAlarmSettings;
use crate::alarm::Priority;

/// The defaults of a default alarm, delays in seconds. chosen: longer than what the bus recovers from without help, such as
/// a gauge that is parameterised again or a lost token.
pub struct Defaults {
    /// The priority.
    pub priority: Priority,
    /// The condition must be met for this time.
    pub delay_s: u64,
    /// The condition must not be met for this time.
    pub off_delay_s: u64,
}

/// A gauge reports a fault.
pub const FAULT: Defaults = Defaults { priority: Priority::Medium, delay_s: 2, off_delay_s: 5 };
/// A gauge sends nothing.
pub const STALE: Defaults = Defaults { priority: Priority::Medium, delay_s: 15, off_delay_s: 2 };
/// The gauge of a limit alarm measures nothing.
pub const NOT_MEASURABLE: Defaults = Defaults { priority: Priority::Medium, delay_s: 15, off_delay_s: 5 };
/// A segment is down.
pub const SEGMENT: Defaults = Defaults { priority: Priority::High, delay_s: 10, off_delay_s: 5 };
/// Damaged telegrams on a segment.
pub const DAMAGE: Defaults = Defaults { priority: Priority::Low, delay_s: 0, off_delay_s: 0 };
/// The station does not record.
pub const DATABASE: Defaults = Defaults { priority: Priority::High, delay_s: 10, off_delay_s: 0 };

/// The last check of the database has found damage. chosen: what is recorded now is kept; a copy must be restored soon.
pub const DATABASE_DAMAGE: Defaults = Defaults { priority: Priority::Medium, delay_s: 0, off_delay_s: 0 };

/// The default alarms: their keys in `[alarms]`, and what holds without settings in the file.
const DEFAULTS: [(&str, &Defaults); 7] = [
    ("fault", &FAULT),
    ("stale", &STALE),
    ("not-measurable", &NOT_MEASURABLE),
    ("segment", &SEGMENT),
    ("damage", &DAMAGE),
    ("database", &DATABASE),
    ("database-damage", &DATABASE_DAMAGE),
];

/// What holds for the default alarm `name` where the file has no settings; `None` if there is no such default alarm.
#[must_use]
pub fn settings_by_default(name: &str) -> Option<DefaultAlarmSettings> {
    let (_, defaults) = DEFAULTS.iter().find(|(key, _)| *key == name)?;
    let seconds = |seconds: u64| Some(format!("{seconds} s"));
    Some(DefaultAlarmSettings {
        priority: Some(defaults.priority.word().to_owned()),
        delay: seconds(defaults.delay_s),
        off_delay: seconds(defaults.off_delay_s),
        limit: (name == "damage").then_some(MAX_DAMAGED),
        except: None,
    })
}

/// The default limit of damaged telegrams per minute. chosen: one in some thousand on a bus without idle time.
pub const MAX_DAMAGED: f64 = 30.0;
