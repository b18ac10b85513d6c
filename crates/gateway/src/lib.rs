//! What the gateways to control systems share: one read model of the station, and the thread in which a gateway runs.
//!
//! ```text
//! station: snapshots, alarms, lines ── plant ──▶ points ──▶ EPICS, OPC UA, MQTT, Modbus, Prometheus
//! ```
//!
//! A *point* is one value of the station: the pressure of a reading, the state of a segment, the text of an alarm. The model publishes
//! immutable [`Snapshot`]s. A gateway waits for the next one and compares it with the one it has served last, so there is no queue
//! that could grow, and a slow client gets the newest value of each point.

pub mod command;
pub mod model;
pub mod names;
pub mod plant;
pub mod point;
pub mod signal;
pub mod socket;
pub mod state;
pub mod thread;

pub use command::{Commander, WriteError, WriteRequest};
pub use model::{ReadModel, Snapshot, Subscription};
pub use names::NameTable;
pub use plant::{Inputs, points};
pub use point::{Limits, Point, PointValue, Subject, Value};
pub use signal::{Kind, Signal};
pub use state::{EpicsSeverity, EpicsStatus, Health, State};
