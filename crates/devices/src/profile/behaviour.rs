//! What a device adds to what all block devices share.

use super::parameter_access::ParameterAccess;
use crate::model::{Configuration, Field, Model, Octets, Unit, UserPrm};
use crate::simulation::{Action, Drive, MeasuringRange, Part, StateReport, UnsupportedAction};
use profivac_wire::acyclic::call::IM_RECORD_LENGTH;

/// The part of a device that no other has. [`BlockDevice`](super::BlockDevice) puts a bus and a memory around it.
///
/// Most methods, and [`Blocks::set`], may leave behind what does not fit together any more: [`update`](Self::update) is
/// called after each and puts everything right. Only [`output`](Self::output) and [`input`](Self::input), which are
/// called in every cycle, are not followed by it.
pub trait Behaviour: ParameterAccess {
    /// Its tables.
    fn model(&self) -> &'static Model;

    /// Data Units are this from now on.
    fn set_unit(&mut self, unit: &'static Unit);

    /// The master has chosen this user parameter string.
    fn parameterise(&mut self, prm: &'static UserPrm) {
        if let Some(unit) = self.model().unit(prm.unit_code()) {
            self.set_unit(unit);
        }
    }

    /// Whether the user parameters leave the choice of this configuration.
    fn accepts(&self, _configuration: &'static Configuration) -> bool {
        true
    }

    /// The master has chosen this configuration.
    fn configure(&mut self, configuration: &'static Configuration);

    /// Cyclic exchange begins or has ended.
    fn exchanging(&mut self, running: bool);

    /// A field of the outputs other than the parameter channel; zeros where there are none.
    fn output(&mut self, field: Field, octets: &[u8]);

    /// A field of the inputs other than the parameter channel.
    fn input(&self, field: Field) -> Octets;

    /// As [`Device::im0`](profivac_dp::slave::Device::im0).
    fn im0(&self) -> Option<[u8; IM_RECORD_LENGTH]> {
        None
    }

    /// Power returns: everything as from the factory, until the memory is recalled. Sensors, switches and faults stay.
    fn start(&mut self);

    /// Lets everything follow that follows at once from the present state and pressures.
    fn update(&mut self);

    /// As [`Instrument::parts`](crate::Instrument::parts).
    fn parts(&self) -> &[Part];

    /// As [`Instrument::span`](crate::Instrument::span).
    fn span(&self, part: usize) -> MeasuringRange;

    /// As [`Instrument::drive`](crate::Instrument::drive), with the power on.
    fn drive(&self, part: usize) -> Drive;

    /// As [`Instrument::sense`](crate::Instrument::sense).
    fn sense(&mut self, part: usize, pa: f64);

    /// As [`Instrument::advance`](crate::Instrument::advance).
    fn advance(&mut self, seconds: f64);

    /// As [`Instrument::settle`](crate::Instrument::settle).
    fn settle(&mut self);

    /// The address switch shows this now.
    fn address_switch(&mut self, _setting: u8) {}

    /// As [`Instrument::operate`](crate::Instrument::operate); the address switch is seen to already.
    ///
    /// # Errors
    /// [`Unknown`] when the device has nothing of that name.
    fn operate(&mut self, action: Action<'_>) -> Result<(), UnsupportedAction>;

    /// As [`Instrument::report`](crate::Instrument::report).
    fn report(&self) -> StateReport;
}
