//! The access to the records of a slave that the station exchanges data with, and the defects in them.

use profivac_client::class1::OwnedChannel;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::ms2::{Ms2, Ms2Line};
use profivac_client::records::Records;
use profivac_client::{Defects, Gauge};

/// The records of `slave`: over MS2, or in the parameter channel of a controller without DP-V1.
pub fn records_of<'a, L: Ms2Line>(line: &'a mut L, slave: &CyclicSlave) -> Box<dyn Records + 'a> {
    if slave.model.features.dpv1 {
        Box::new(Ms2::new(line, slave.address))
    } else {
        Box::new(OwnedChannel::new(line, slave))
    }
}

/// The defects behind the alarms of a gauge. `None` if it does not answer now: its alarms keep the names of their groups.
pub fn defects_of<L: Ms2Line>(line: &mut L, slave: &CyclicSlave) -> Option<Defects> {
    Gauge::with_model(records_of(line, slave), slave.address, slave.model).defects().ok()
}
