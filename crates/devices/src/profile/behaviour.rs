//! The interface between a device and what all block devices share.

use super::parameter_access::ParameterAccess;
use super::presentation::Presentation;
use crate::model::{Configuration, Fault, Field, MeasuringRange, Model, Octets, Part, Unit, UserPrm};
use crate::simulation::{Drive, FrontPanel, Potentiometer, StateReport, Switch};
use profivac_wire::acyclic::call::IM_RECORD_LENGTH;

/// The part of a device that no other device has. [`BlockDevice`](super::BlockDevice) adds bus, memory and address.
///
/// Most methods, and [`ParameterAccess::set`], may leave values behind that no longer agree:
/// [`BlockDevice`](super::BlockDevice) calls [`update`](Self::update) after each, which makes them agree. Only
/// [`output`](Self::output) and [`input`](Self::input), which are called in every cycle, are not followed by it.
pub trait Behaviour: ParameterAccess {
    /// The tables of the device.
    fn model(&self) -> &'static Model;

    /// Unit and number type; `None` for a device that keeps them elsewhere.
    fn presentation_mut(&mut self) -> Option<&mut Presentation>;

    /// Sets Data Units.
    fn set_unit(&mut self, unit: &'static Unit) {
        if let Some(presentation) = self.presentation_mut() {
            presentation.unit = unit;
        }
    }

    /// The master has sent this user parameter string.
    fn apply_user_prm(&mut self, prm: &'static UserPrm) {
        if let Some(unit) = self.model().unit(prm.unit_code()) {
            self.set_unit(unit);
        }
    }

    /// Whether the user parameters allow this configuration.
    fn accepts(&self, _configuration: &'static Configuration) -> bool {
        true
    }

    /// The master has sent this configuration.
    fn configure(&mut self, configuration: &'static Configuration) {
        if let Some(presentation) = self.presentation_mut() {
            presentation.configure(configuration);
        }
    }

    /// Data exchange begins (`true`) or has ended.
    fn set_exchanging(&mut self, running: bool);

    /// Processes a field of the outputs other than the parameter channel; zeros after Clear. Many devices have none.
    fn output(&mut self, _field: Field, _octets: &[u8]) {}

    /// The octets of a field of the inputs other than the parameter channel.
    fn input(&self, field: Field) -> Octets;

    /// As [`Device::im0`](profivac_dp::slave::Device::im0).
    fn im0(&self) -> Option<[u8; IM_RECORD_LENGTH]> {
        None
    }

    /// Power-up: everything as from the factory, until the stored values are restored. Sensors, switches and faults
    /// stay.
    fn start(&mut self);

    /// Makes everything agree with the present state and pressures.
    fn update(&mut self);

    /// As [`SimulatedDevice::parts`](crate::SimulatedDevice::parts).
    fn parts(&self) -> &[Part];

    /// As [`SimulatedDevice::measuring_range`](crate::SimulatedDevice::measuring_range).
    fn measuring_range(&self, part: usize) -> MeasuringRange;

    /// As [`SimulatedDevice::drive`](crate::SimulatedDevice::drive), with the power on.
    fn drive(&self, part: usize) -> Drive;

    /// As [`SimulatedDevice::sense`](crate::SimulatedDevice::sense).
    fn sense(&mut self, part: usize, pa: f64);

    /// As [`SimulatedDevice::advance`](crate::SimulatedDevice::advance).
    fn advance(&mut self, seconds: f64);

    /// As [`SimulatedDevice::settle`](crate::SimulatedDevice::settle).
    fn settle(&mut self);

    /// The controls of the device. Actions of controls that are not in it do not reach the methods below.
    fn front_panel(&self) -> FrontPanel;

    /// A fault of the model's list begins or ends.
    fn set_fault(&mut self, fault: Fault, active: bool);

    /// A push button is pressed.
    fn press_button(&mut self, _number: u8) {}

    /// A switch is set. [`BlockDevice`](super::BlockDevice) reads the station address from the address switch.
    fn set_switch(&mut self, _switch: Switch) {}

    /// A potentiometer is turned.
    fn turn_potentiometer(&mut self, _potentiometer: Potentiometer, _volts: f64) {}

    /// Whether a part of the device has failed, as a light or a relay for errors shows it: an alarm of Exception Status, or the status
    /// "sensor error" of a controller's channel.
    fn has_alarm(&self) -> bool;

    /// As [`SimulatedDevice::report`](crate::SimulatedDevice::report).
    fn report(&self) -> StateReport;
}
