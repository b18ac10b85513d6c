//! A block device on the bus: tables and behaviour behind [`profivac_dp::slave::Device`].

use super::address::StationAddress;
use super::behaviour::Behaviour;
use super::parameter_channel::ParameterChannel;
use crate::model::{AccessError, AccessPath, Configuration, Field, Octets, Unit, Value};
use crate::simulation::Switch;
use crate::store::Store;
use profivac_dp::slave::{CfgFault, Device, Dpv1Error, Features, Outputs, PrmFault, Relation};
use profivac_wire::acyclic::call::IM_RECORD_LENGTH;
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::cfg::Lengths;

/// The settings of a device when it is made.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The setting of the address switch; above 125 the stored address holds.
    pub address_switch: u8,
    /// Serial Number.
    pub serial: SerialNumber,
    /// The unit that the device stores at its first power-up; `None` keeps the unit in the memory.
    pub unit: Option<&'static Unit>,
}

impl Setup {
    /// As delivered, with this setting of the address switch.
    #[must_use]
    pub fn new(address_switch: u8) -> Self {
        Self { address_switch, serial: SerialNumber::new("100"), unit: None }
    }
}

/// A serial number, at most 30 characters long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialNumber(Octets);

impl SerialNumber {
    /// The length of the parameter Serial Number.
    const LENGTH: usize = 30;

    /// The serial number `text`, cut to 30 octets.
    #[must_use]
    pub fn new(text: &str) -> Self {
        Self(Octets::new(text.as_bytes().get(..Self::LENGTH).unwrap_or(text.as_bytes())))
    }

    /// Its characters.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        self.0.as_slice()
    }

    /// The value of the parameter.
    #[must_use]
    pub const fn value(&self) -> Value {
        Value::Octets(self.0)
    }
}

/// The longest outputs of a device, for the zeros of Clear.
const MAX_OUTPUTS: usize = 16;

/// A device with blocks: a behaviour `B` with its nonvolatile memory `S`, parameter channel and address.
#[derive(Clone, Debug)]
pub struct BlockDevice<B, S> {
    pub(super) behaviour: B,
    pub(super) store: S,
    pub(super) address: StationAddress,
    pub(super) powered: bool,
    pub(super) channel: ParameterChannel,
    pub(super) configuration: &'static Configuration,
}

impl<B: Behaviour, S: Store> BlockDevice<B, S> {
    /// A device that has just been switched on.
    #[must_use]
    pub fn from_behaviour(behaviour: B, store: S, setup: &Setup) -> Self {
        let model = behaviour.model();
        let mut device = Self {
            behaviour,
            store,
            address: StationAddress::new(setup.address_switch),
            powered: true,
            channel: ParameterChannel::new(model.channel_rules),
            configuration: model.default_configuration,
        };
        device.behaviour.set_switch(Switch::Address(setup.address_switch));
        device.start();
        if let Some(unit) = setup.unit {
            device.apply_event(&mut |behaviour| behaviour.set_unit(unit));
        }
        device
    }

    /// Power-up: the behaviour starts as from the factory, then takes the stored values.
    pub(super) fn start(&mut self) {
        self.behaviour.start();
        self.restore();
        self.behaviour.update();
        self.address.start(&mut self.store);
        let model = self.behaviour.model();
        self.channel = ParameterChannel::new(model.channel_rules);
        self.configuration = model.default_configuration;
    }

    /// The behaviour, without bus and memory.
    pub const fn behaviour(&self) -> &B {
        &self.behaviour
    }

    /// As [`Behaviour::has_alarm`].
    pub fn has_alarm(&self) -> bool {
        self.behaviour.has_alarm()
    }

    /// The nonvolatile memory.
    pub const fn store(&self) -> &S {
        &self.store
    }

    /// Changes the device by something other than a write of a master. A memory that fails does not stop the change,
    /// because no master waits for an answer.
    ///
    /// Not inlined, so that the copy of the behaviour is on the stack only while it is needed, and not generic, so that a program
    /// has it once.
    #[inline(never)]
    pub(super) fn apply_event(&mut self, event: &mut dyn FnMut(&mut B)) {
        let before = self.behaviour.clone();
        event(&mut self.behaviour);
        self.behaviour.update();
        let _ = self.store_differences(&before, None, None);
    }

    /// Begins to use a configuration.
    pub(super) fn adopt_configuration(&mut self, configuration: &'static Configuration) {
        self.configuration = configuration;
        self.channel = ParameterChannel::new(self.behaviour.model().channel_rules);
        self.apply_event(&mut |behaviour| behaviour.configure(configuration));
    }
}

impl<B: Behaviour, S: Store> Device for BlockDevice<B, S> {
    fn ident_number(&self) -> u16 {
        self.behaviour.model().ident
    }

    fn features(&self) -> Features {
        self.behaviour.model().features
    }

    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault> {
        let prm = self.behaviour.model().user_prm(user).ok_or(PrmFault)?;
        // With a memory that fails the exchange must still start, so that the master gets the alarm.
        self.apply_event(&mut |behaviour| behaviour.apply_user_prm(prm));
        Ok(())
    }

    fn chk_cfg(&mut self, cfg: &[u8]) -> Result<Lengths, CfgFault> {
        let configuration = self.behaviour.model().configuration(cfg).ok_or(CfgFault)?;
        if !self.behaviour.accepts(configuration) {
            return Err(CfgFault);
        }
        let octets = |octets| u8::try_from(octets).map_err(|_| CfgFault);
        let lengths =
            Lengths { outputs: octets(configuration.output_octets())?, inputs: octets(configuration.input_octets())? };
        self.adopt_configuration(configuration);
        Ok(lengths)
    }

    fn get_cfg(&self) -> &[u8] {
        self.configuration.octets
    }

    fn set_exchanging(&mut self, running: bool) {
        self.behaviour.set_exchanging(running);
        self.behaviour.update();
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        let image = match outputs {
            Outputs::Data(image) => image,
            // No task and no command: errata-bpg-bcg-tpg 101.
            Outputs::Safe => &[0; MAX_OUTPUTS],
        };
        let mut rest = image;
        for field in self.configuration.outputs.map_or(&[][..], |telegram| telegram.fields) {
            rest = match field {
                Field::ParameterChannel => {
                    let Some((octets, after)) = rest.split_first_chunk() else { return };
                    self.accept_channel_request(*octets);
                    after
                }
                _ => {
                    let Some((octets, after)) = rest.split_at_checked(field.octets()) else { return };
                    self.behaviour.output(*field, octets);
                    after
                }
            };
        }
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        let mut rest = inputs;
        for field in self.configuration.inputs.map_or(&[][..], |telegram| telegram.fields) {
            rest = match field {
                Field::ParameterChannel => {
                    let Some((target, after)) = rest.split_first_chunk_mut() else { return };
                    *target = self.channel_answer();
                    after
                }
                _ => {
                    let octets = self.behaviour.input(*field);
                    let Some((target, after)) = rest.split_at_mut_checked(octets.len()) else { return };
                    match (target, octets.as_slice()) {
                        // Most fields: a copy of one octet needs no call.
                        ([target], [octet]) => *target = *octet,
                        (target, octets) => target.copy_from_slice(octets),
                    }
                    after
                }
            };
        }
    }

    /// A new task of the parameter channel changes the inputs, and so may every other output.
    fn keeps_inputs(&self, _before: &[u8], outputs: &[u8]) -> bool {
        match (self.configuration.outputs.map_or(&[][..], |telegram| telegram.fields), outputs.first_chunk()) {
            ([], _) => true,
            ([Field::ParameterChannel], Some(octets)) => self.channel.keeps(*octets),
            _ => false,
        }
    }

    fn address_is_settable(&self) -> bool {
        self.address.is_settable()
    }

    fn set_address(&mut self, request: &SetSlaveAdd<'_>) -> Option<u8> {
        self.address.set(&mut self.store, request)
    }

    fn im0(&self) -> Option<[u8; IM_RECORD_LENGTH]> {
        self.behaviour.im0()
    }

    fn read(&mut self, relation: Relation, slot: u8, index: u8, record: &mut [u8]) -> Result<usize, Dpv1Error> {
        let octets = self.get(path_of(relation), slot, index)?;
        let target = record.get_mut(..octets.len()).ok_or(AccessError::WrongLength)?;
        target.copy_from_slice(&octets);
        Ok(octets.len())
    }

    fn write(&mut self, relation: Relation, slot: u8, index: u8, record: &[u8]) -> Result<(), Dpv1Error> {
        Ok(self.set(path_of(relation), slot, index, record)?)
    }
}

/// The access path of a relation.
pub(super) const fn path_of(relation: Relation) -> AccessPath {
    match relation {
        Relation::Ms1 => AccessPath::Class1,
        Relation::Ms2(_) => AccessPath::Class2,
    }
}
