//! The points of a slave as the API shows them.

use crate::config;
use crate::segment::moment::Moment;
use crate::view::WatchedParameter;
use profivac_recorder::Quality;

pub fn planned_point(point: &config::SlavePoint) -> WatchedParameter {
    WatchedParameter {
        target: point.name.clone(),
        name: point.place.clone(),
        unit: point.unit,
        number: None,
        text: String::new(),
        quality: Quality::Stale,
        read_at: None,
        lost_at: None,
    }
}

/// A point with its value in these octets, which the slave gave at `read`.
pub fn valued_point(point: &config::SlavePoint, octets: &[u8], read: Moment) -> WatchedParameter {
    let config::PointValue { number, text, quality } = point.value(octets);
    WatchedParameter { number, text, quality, read_at: Some(read.wall), ..planned_point(point) }
}

pub fn planned_points(slave: &config::Slave) -> Vec<WatchedParameter> {
    slave.points.iter().map(planned_point).collect()
}
