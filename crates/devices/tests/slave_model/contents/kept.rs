//! Process values: what the sensors see, or what Safe State puts in its place.

use super::pressure::Scale;
use super::{Common, Content, Key, MOVING};

/// The rules of a process value with Safe State (ID 39) and Safe Value (ID 40) (73 to 76).
#[derive(Clone, Copy, Debug)]
pub struct Process {
    /// The pressure that the sensor sees and shows, if the specification says so.
    pub mbar: Option<f64>,
    pub full_scale: f64,
    /// The last valid value of EXECUTING; `None` is not known.
    pub last: Option<f64>,
}

impl Process {
    /// The process value of slot and instance of `key`.
    pub fn content(self, common: &Common, key: Key, scale: Scale) -> Content {
        if common.moving {
            return Content::Device(MOVING);
        }
        let (slot, instance, _) = key;
        let value = if common.executing() {
            self.mbar
        } else {
            match common.number((slot, instance, 39)).unwrap_or(0) {
                0 => Some(0.0),
                1 => Some(self.full_scale),
                2 => self.last.filter(|_| !common.unmeasured),
                _ => return common.kept((slot, instance, 40), Some(0.0), scale),
            }
        };
        value.map_or(Content::Device(5), |mbar| common.show(mbar, scale))
    }
}
