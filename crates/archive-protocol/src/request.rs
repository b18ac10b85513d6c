//! What a user of the archive asks a station for, over NATS or HTTPS: the station decides, and answers. And what the archive itself tells a
//! station: over NATS as a request, over HTTPS in a header of the answer to a batch.
//!
//! | Request | Answer |
//! |---|---|
//! | `{"status": {"epoch": 1, "stored": 7, "missing": [{"epoch": 1, "first": 3, "last": 5}], "put_aside": 2, "reason": "..."}}` | none |
//! | `{"trend": {"series": "chamber", "from_ms": 0, "to_ms": 1, "pixels": 1000}}` | `{"trend": {...}}`, as `/api/trend` of the station |
//! | `{"acknowledge": {"alarm": "chamber too high", "occurrence": 1, "user": "ada"}}` | `"done"` |
//! | a trend while others wait | `"busy"` |
//! | any other | `{"refused": "the reason in a sentence"}` |

use profivac_recorder::Trend;
use serde::{Deserialize, Serialize};

/// The most entries of a trend: its answer stays below the megabyte that a server of NATS passes on.
pub const MAX_PIXELS: u32 = 4_000;

/// The most octets of a request: names of alarms and series are far shorter.
pub const MAX_OCTETS: usize = 8 << 10;

/// The header with the id of a request.
pub const REQUEST_HEADER: &str = "profivac-request";

/// The header with the [`Status`] of a station in an answer to a batch, as JSON.
pub const STATUS_HEADER: &str = "profivac-status";

/// The subject of the requests to a station.
pub fn subject(plant: &str, station: &str) -> String {
    format!("profivac.v1.{plant}.{station}.request")
}

/// A request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Request {
    /// A trend from the database of the station.
    Trend {
        /// The series.
        series: String,
        /// The beginning, in milliseconds since 1970.
        from_ms: i64,
        /// The end, in milliseconds since 1970.
        to_ms: i64,
        /// The most entries, 1 to [`MAX_PIXELS`].
        pixels: u32,
    },
    /// An acknowledgement of an alarm by an operator of the archive.
    Acknowledge {
        /// The alarm.
        alarm: String,
        /// The occurrence that the operator has seen.
        occurrence: i64,
        /// The name of the operator in the archive.
        user: String,
    },
    /// What the archive has of the station. The station replies to no user.
    Status(Status),
}

/// What the database of an archive has of a station.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Status {
    /// The present epoch of the station.
    pub epoch: i64,
    /// Each batch of this epoch up to this number is stored or put aside.
    pub stored: i64,
    /// Batches that the station is to send again, if it has them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<Missing>,
    /// The database of the station is a copy that was put back, or a second one: it is to begin another epoch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub copied: Option<Copied>,
    /// How many batches of the station were put aside.
    #[serde(default)]
    pub put_aside: u64,
    /// Why the last one of them was put aside, in a sentence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// Batches that came before with the same numbers, from another copy of the database.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Copied {
    /// The epoch of both copies.
    pub epoch: i64,
    /// The first number that both have given to a batch.
    pub first: i64,
}

/// Numbers of batches that have not come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Missing {
    /// The epoch.
    pub epoch: i64,
    /// The first number.
    pub first: i64,
    /// The last number.
    pub last: i64,
}

/// The answer of a station.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reply {
    /// The trend.
    Trend(Trend),
    /// It is done, and on the disk of the station.
    Done,
    /// Other trends wait already: the same request may have an answer later.
    Busy,
    /// The station refuses.
    Refused(String),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_and_replies_have_the_documented_form() {
        let request = Request::Acknowledge { alarm: "a".to_owned(), occurrence: 1, user: "ada".to_owned() };
        let text = r#"{"acknowledge":{"alarm":"a","occurrence":1,"user":"ada"}}"#;
        assert_eq!(serde_json::to_string(&request).unwrap(), text);
        assert_eq!(serde_json::from_str::<Request>(text).unwrap(), request);
        assert_eq!(serde_json::to_string(&Reply::Done).unwrap(), r#""done""#);
        assert_eq!(serde_json::to_string(&Reply::Busy).unwrap(), r#""busy""#);
        let missing = vec![Missing { epoch: 1, first: 3, last: 5 }];
        let reason = Some("no".to_owned());
        let copied = Some(Copied { epoch: 1, first: 6 });
        let status = Request::Status(Status { epoch: 1, stored: 7, missing, copied, put_aside: 2, reason });
        let text = r#"{"status":{"epoch":1,"stored":7,"missing":[{"epoch":1,"first":3,"last":5}],"copied":{"epoch":1,"first":6},"put_aside":2,"reason":"no"}}"#;
        assert_eq!(serde_json::to_string(&status).unwrap(), text);
        assert_eq!(serde_json::from_str::<Request>(text).unwrap(), status);
        let of_later_archive = r#"{"status":{"epoch":1,"stored":7,"later":true}}"#;
        let without = Request::Status(Status { epoch: 1, stored: 7, ..Status::default() });
        assert_eq!(serde_json::from_str::<Request>(of_later_archive).unwrap(), without);
        let refused = Reply::Refused("no".to_owned());
        assert_eq!(serde_json::to_string(&refused).unwrap(), r#"{"refused":"no"}"#);
        for wrong in [r#"{"trend":"none"}"#, r#"{"trend":{"series":[]}}"#, "[]", ""] {
            assert!(serde_json::from_str::<Reply>(wrong).is_err(), "{wrong}");
        }
    }
}
