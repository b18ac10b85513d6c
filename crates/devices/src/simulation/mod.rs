//! A device without hardware: sensors to drive, faults to inject, a front panel to operate, a state to report.

mod action;
mod report;

pub use action::{Action, FrontPanel, Potentiometer, Switch, SwitchName, UnsupportedAction};
pub use report::{BoundedVec, Led, PartReading, REPORT_CAPACITY, ReportedState, StateReport};

use crate::model::{FaultList, MeasuringRange, Part};
use crate::store::Key;
use profivac_dp::slave::Device;

/// How the device drives a measuring part. The pressure that a real sensor senses depends on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Heater, emission or high voltage is off.
    Off,
    /// The part is supplied.
    On,
    /// A hot cathode emits.
    Emission {
        /// The emission current in mA.
        milliamperes: f64,
        /// Degas runs.
        degas: bool,
    },
}

/// A device that a simulation drives: a [`Device`] on the bus with its sensors, front panel and power supply.
pub trait SimulatedDevice: Device {
    /// The name of the model: `bcg450`.
    fn name(&self) -> &'static str;

    /// The station address that holds from the next power-up on: that of the address switch, or the stored one.
    fn station_address(&self) -> u8;

    /// The measuring parts, in the order of their instances.
    fn parts(&self) -> &[Part];

    /// The measuring range of a part.
    fn measuring_range(&self, part: usize) -> MeasuringRange;

    /// How the device drives a part now.
    fn drive(&self, part: usize) -> Drive;

    /// Sets the pressure that a part senses, in Pa: its indicated pressure before the device's own adjustments. Below
    /// zero where the zero of the sensor is off; NaN counts as 0.
    fn sense(&mut self, part: usize, pa: f64);

    /// Advances the time of the device: timers, degas, ignition, run hours.
    fn advance(&mut self, seconds: f64);

    /// Completes self test, emission switching and filters at once. Timers that a user waits for (degas, run hours) do
    /// not move.
    fn settle(&mut self);

    /// Switches the power off or on. Switched on, the device starts with its nonvolatile values.
    fn set_power(&mut self, on: bool);

    /// Calls `found` with the key of each value of the nonvolatile memory that the device does not take at power-up, because the
    /// parameter cannot have it; its default holds. Keys that the device does not have are not looked at.
    fn refused_values(&self, found: &mut dyn FnMut(Key));

    /// The faults that the device can have.
    fn faults(&self) -> &'static FaultList;

    /// The controls that the device has.
    fn front_panel(&self) -> FrontPanel;

    /// Performs an action.
    ///
    /// # Errors
    /// [`UnsupportedAction`] when the device does not have the fault or control, or the switch not the position; the device has not
    /// changed then.
    fn operate(&mut self, action: Action) -> Result<(), UnsupportedAction>;

    /// The state that the device shows.
    fn report(&self) -> StateReport;
}
