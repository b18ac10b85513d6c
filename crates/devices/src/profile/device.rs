//! A block device on the bus: tables and behaviour behind [`profivac_dp::slave::Device`].

use super::address::StationAddress;
use super::behaviour::Behaviour;
use super::parameter_channel::{self, ParameterChannel, Task};
use crate::model::{AccessError, AccessPath, Configuration, Field, Octets, Unit, Value};
use crate::store::Store;
use profivac_dp::slave::{CfgFault, Device, Dpv1Error as Negative, Features, Outputs, PrmFault, Relation};
use profivac_wire::acyclic::call::IM_RECORD_LENGTH;
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::cfg::Lengths;

/// What a device is given when it is made.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// What the address switch shows; above 125 the stored address holds.
    pub address_switch: u8,
    /// Serial Number.
    pub serial: SerialNumber,
    /// The unit that is stored when power comes; what the memory holds if `None`.
    pub unit: Option<&'static Unit>,
}

impl Setup {
    /// As bought, behind this address switch.
    #[must_use]
    pub fn new(address_switch: u8) -> Self {
        Self { address_switch, serial: SerialNumber::new("100"), unit: None }
    }
}

/// A serial number, at most 30 characters long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialNumber(Octets);

impl SerialNumber {
    /// What it must fit into.
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

    /// As a parameter.
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
    channel: ParameterChannel,
    configuration: &'static Configuration,
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
        device.behaviour.address_switch(setup.address_switch);
        device.start();
        if let Some(unit) = setup.unit {
            device.happen(|behaviour| behaviour.set_unit(unit));
        }
        device
    }

    /// Power comes.
    pub(super) fn start(&mut self) {
        self.behaviour.start();
        self.recall();
        self.behaviour.update();
        self.address.start(&mut self.store);
        let model = self.behaviour.model();
        self.channel = ParameterChannel::new(model.channel_rules);
        self.configuration = model.default_configuration;
    }

    /// What the device stands on its own for, apart from the bus.
    pub const fn behaviour(&self) -> &B {
        &self.behaviour
    }

    /// The nonvolatile memory.
    pub const fn store(&self) -> &S {
        &self.store
    }

    /// Something that no master can be told about: the memory follows if it can.
    pub(super) fn happen(&mut self, event: impl FnOnce(&mut B)) {
        let before = self.behaviour.clone();
        event(&mut self.behaviour);
        self.behaviour.update();
        let _ = self.store_differences(&before, None);
    }

    fn take_output(&mut self, field: Field, octets: &[u8]) {
        match field {
            Field::ParameterChannel => self.serve_channel(octets),
            _ => self.behaviour.output(field, octets),
        }
    }

    /// A write is carried out when it arrives.
    fn serve_channel(&mut self, octets: &[u8]) {
        let Ok(octets) = octets.try_into() else { return };
        let Some(Task::Write { slot, index, lengths, value }) = self.channel.take(octets) else { return };
        let octets = self.right_aligned(slot, index, lengths, &value);
        let result = self.set(AccessPath::ParameterChannel, slot, index, octets);
        self.channel.answer(result.map(|()| octets));
    }

    /// The octets an instruction means: of the lengths it allows, the parameter's own.
    fn right_aligned<'a>(&self, slot: u8, index: u8, lengths: &[usize], value: &'a [u8; 4]) -> &'a [u8] {
        let own = self.length(slot, index).filter(|own| lengths.contains(own));
        let length = own.or(lengths.first().copied()).unwrap_or_default();
        value.split_at_checked(value.len().saturating_sub(length)).map_or(&[], |(_, low)| low)
    }

    /// A read is answered with the value of now: errata-bpg-bcg-tpg 25.
    fn channel_reply(&mut self) -> [u8; parameter_channel::OCTETS] {
        if let Some(Task::Read { slot, index }) = self.channel.task() {
            let octets = self.get(AccessPath::ParameterChannel, slot, index);
            self.channel.answer(octets.as_deref().map_err(|refusal| *refusal));
        }
        *self.channel.reply()
    }

    fn put_input(&mut self, field: Field, place: &mut [u8]) {
        if let (Field::ParameterChannel, Ok(place)) =
            (field, <&mut [u8; parameter_channel::OCTETS]>::try_from(&mut *place))
        {
            *place = self.channel_reply();
            return;
        }
        for (place, octet) in place.iter_mut().zip(self.behaviour.input(field).as_slice()) {
            *place = *octet;
        }
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
        // A memory that fails must not keep a master from the alarm that says so.
        self.happen(|behaviour| behaviour.parameterise(prm));
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
        self.configuration = configuration;
        self.channel = ParameterChannel::new(self.behaviour.model().channel_rules);
        self.happen(|behaviour| behaviour.configure(configuration));
        Ok(lengths)
    }

    fn get_cfg(&self) -> &[u8] {
        self.configuration.octets
    }

    fn set_exchanging(&mut self, running: bool) {
        self.behaviour.exchanging(running);
        self.behaviour.update();
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        let image = match outputs {
            Outputs::Data(image) => image,
            // No instruction and no command: errata-bpg-bcg-tpg 101.
            Outputs::Safe => &[0; MAX_OUTPUTS],
        };
        let mut rest = image;
        for field in self.configuration.outputs.map_or(&[][..], |telegram| telegram.fields) {
            let Some((octets, after)) = rest.split_at_checked(field.octets()) else { return };
            self.take_output(*field, octets);
            rest = after;
        }
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        let mut rest = inputs;
        for field in self.configuration.inputs.map_or(&[][..], |telegram| telegram.fields) {
            let Some((place, after)) = rest.split_at_mut_checked(field.octets()) else { return };
            self.put_input(*field, place);
            rest = after;
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

    fn read(&mut self, via: Relation, slot: u8, index: u8, record: &mut [u8]) -> Result<usize, Negative> {
        let octets = self.get(class(via), slot, index)?;
        let place = record.get_mut(..octets.len()).ok_or(Negative::from(AccessError::WrongLength))?;
        place.copy_from_slice(&octets);
        Ok(octets.len())
    }

    fn write(&mut self, via: Relation, slot: u8, index: u8, record: &[u8]) -> Result<(), Negative> {
        Ok(self.set(class(via), slot, index, record)?)
    }
}

const fn class(relation: Relation) -> AccessPath {
    match relation {
        Relation::Ms1 => AccessPath::Class1,
        Relation::Ms2(_) => AccessPath::Class2,
    }
}
