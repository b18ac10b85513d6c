//! What a device adds to what all block devices share.

use crate::instrument::{Action, Part, Report, Unknown};
use crate::model::{Address, Configuration, Field, Format, Model, Octets, Parameters, Refusal, Row, UserPrm, Value};
use crate::store::Key;

/// A parameter that was found: where, and which.
#[derive(Clone, Copy, Debug)]
pub struct At<P> {
    /// Slot and instance.
    pub address: &'static Address,
    /// Its row in the table.
    pub row: &'static Row,
    /// Which one it is.
    pub parameter: P,
}

impl<P> At<P> {
    /// The instance, 0 where the slot has only one.
    #[must_use]
    pub const fn instance(&self) -> u8 {
        self.address.instance
    }

    /// The key of a value that is this instance's own.
    #[must_use]
    pub const fn key(&self) -> Key {
        Key::Parameter { slot: self.address.slot, instance: self.address.instance, index: self.row.id }
    }

    /// The key of a value that all instances share.
    #[must_use]
    pub const fn shared_key(&self) -> Key {
        Key::Parameter { slot: self.address.slot, instance: 0, index: self.row.id }
    }
}

/// The part of a device that no other has. [`BlockDevice`](super::BlockDevice) puts a bus and a memory around it.
///
/// A method may leave behind what does not fit together any more; [`update`](Self::update) is called after each and
/// puts everything right.
pub trait Behaviour: Clone {
    /// The parameters of its tables.
    type Parameter: Parameters;

    /// Its tables.
    const MODEL: &'static Model;

    /// Whether a block stands at this address now: the selected instance, a channel that is fitted.
    fn shows(&self, address: &Address) -> bool;

    /// How the pressures of this parameter look on the wire.
    fn format(&self, at: &At<Self::Parameter>) -> Format;

    /// The value of a parameter.
    fn get(&self, at: &At<Self::Parameter>) -> Value;

    /// Whether the present state lets a parameter be written, whatever the value.
    ///
    /// # Errors
    /// [`Refusal::Mode`] if not.
    fn permits(&self, _at: &At<Self::Parameter>) -> Result<(), Refusal> {
        Ok(())
    }

    /// Takes over a value or carries out a command. Direction, length, type and state fit already.
    ///
    /// # Errors
    /// A [`Refusal`]; no parameter has changed then.
    fn set(&mut self, at: &At<Self::Parameter>, value: &Value) -> Result<(), Refusal>;

    /// The value that the memory shall hold: the present one, unless the device stores on request.
    fn kept(&self, at: &At<Self::Parameter>) -> Value {
        self.get(at)
    }

    /// Takes over a value from the memory.
    ///
    /// # Errors
    /// A [`Refusal`]: it cannot be a value of this parameter, and nothing has changed.
    fn recall(&mut self, at: &At<Self::Parameter>, value: &Value) -> Result<(), Refusal> {
        self.set(at, value)
    }

    /// The key under which a nonvolatile parameter is stored.
    fn key(&self, at: &At<Self::Parameter>) -> Key {
        at.key()
    }

    /// Nonvolatile values without an index: adjustments, run hours.
    fn hidden(&self) -> &[f64] {
        &[]
    }

    /// The same, to be recalled.
    fn hidden_mut(&mut self) -> &mut [f64] {
        &mut []
    }

    /// Whether the nonvolatile memory answers.
    fn memory_works(&self) -> bool {
        true
    }

    /// The master has chosen this user parameter string.
    fn parameterise(&mut self, prm: &'static UserPrm);

    /// The master has chosen this configuration.
    fn configure(&mut self, configuration: &'static Configuration);

    /// Cyclic exchange begins or has ended.
    fn exchanging(&mut self, running: bool);

    /// A field of the outputs other than the parameter channel; zeros where there are none.
    fn output(&mut self, field: Field, octets: &[u8]);

    /// A field of the inputs other than the parameter channel.
    fn input(&self, field: Field) -> Octets;

    /// Power returns: everything as from the factory, until the memory is recalled.
    fn start(&mut self);

    /// Lets everything follow that follows at once from the present state and pressures.
    fn update(&mut self);

    /// As [`Instrument::parts`](crate::Instrument::parts).
    fn parts(&self) -> &[Part];

    /// As [`Instrument::sense`](crate::Instrument::sense).
    fn sense(&mut self, part: usize, pa: f64);

    /// As [`Instrument::advance`](crate::Instrument::advance).
    fn advance(&mut self, seconds: f64);

    /// As [`Instrument::settle`](crate::Instrument::settle).
    fn settle(&mut self);

    /// As [`Instrument::operate`](crate::Instrument::operate); the address switch is seen to already.
    ///
    /// # Errors
    /// [`Unknown`] when the device has nothing of that name.
    fn operate(&mut self, action: Action<'_>) -> Result<(), Unknown>;

    /// As [`Instrument::report`](crate::Instrument::report).
    fn report(&self) -> Report;
}
