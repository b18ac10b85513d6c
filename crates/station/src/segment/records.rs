//! The access to the records of a slave that the station exchanges data with.

use profivac_client::class1::OwnedChannel;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::ms2::{Ms2, Ms2Line};
use profivac_client::records::Records;

/// The records of `slave`: over MS2, or in the parameter channel of a controller without DP-V1.
pub fn records_of<'a, L: Ms2Line>(line: &'a mut L, slave: &CyclicSlave) -> Box<dyn Records + 'a> {
    if slave.model.features.dpv1 {
        Box::new(Ms2::new(line, slave.address))
    } else {
        Box::new(OwnedChannel::new(line, slave))
    }
}
