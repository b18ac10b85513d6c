//! Virtual slaves by their GSD files: any slave of a bus, without its hardware.
//!
//! The file and the plugged modules say which parameters and which configuration the slave accepts, how long its data and its
//! diagnosis are, and which services it has. It has no behaviour of its own: [orders](Order) set its inputs, its diagnosis and its
//! DP-V1 records, and its [state](GsdStation::state) shows the outputs and parameters of the master.

mod alarms;
mod device;
mod diagnosis;
mod order;
mod plan;
mod records;
mod spec;
mod state;

pub use order::{FORMS, Order, OrderError};
pub use spec::{GsdSpec, GsdSpecError, OpenedSlave, is_gsd_file};
pub use state::{AlarmState, ModuleState, ParameterState, RecordState, SlaveState};

use crate::nonvolatile::NonvolatileMemory;
use alarms::NewAlarm;
use device::GsdDevice;
use diagnosis::{ChannelError, MAX_CHANNEL, unit_texts};
use plan::{MAX_ERROR, MAX_RECORD, Plan, octets_of};
use profivac_client::values::hex;
use profivac_dp::link::{Baud, BitTime, Listening, Station, Transmit};
use profivac_dp::slave::Slave;
use profivac_gsd_slave::{Direction, PlacedModule};
use profivac_wire::Telegram;
use records::Records;
use std::collections::BTreeSet;

/// The address of a slave whose address was never set. profibus-wire 2.11.
const UNSET_ADDRESS: u8 = 126;

/// A slave by its GSD file on a virtual bus.
pub struct GsdStation {
    switch_address: u8,
    slave: Box<Slave<GsdDevice>>,
    powered: bool,
    connected: bool,
}

/// Why a slave does not carry out an order: a sentence that says what is possible.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Refused(pub String);

impl From<String> for Refused {
    fn from(sentence: String) -> Self {
        Self(sentence)
    }
}

impl GsdStation {
    /// A slave that has just been switched on. chosen: a stored address counts more than `switch_address`, because a file with
    /// Set_Slave_Add has no switch.
    fn new(plan: Plan, switch_address: u8, memory: NonvolatileMemory, baud: Baud) -> Self {
        let device = GsdDevice::new(plan, Records::new(memory));
        let address = start_address(&device, switch_address);
        Self { switch_address, slave: Box::new(Slave::new(device, address, baud)), powered: true, connected: true }
    }

    /// Vendor and model of the file.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.slave.device().plan.name
    }

    /// The address by which the user names the slave.
    #[must_use]
    pub const fn switch_address(&self) -> u8 {
        self.switch_address
    }

    /// The station address: Set_Slave_Add may have changed it.
    #[must_use]
    pub fn station_address(&self) -> u8 {
        self.slave.address()
    }

    /// Whether it exchanges data with a master.
    #[must_use]
    pub fn is_exchanging(&self) -> bool {
        self.powered && self.slave.state().is_exchanging()
    }

    /// Switches the power. Inputs, diagnosis and records stay, outputs are safe.
    pub fn set_power(&mut self, on: bool) {
        match (self.powered, on) {
            (false, true) => {
                let address = start_address(self.slave.device(), self.switch_address);
                self.slave.power_up(address);
            }
            // The state shows no exchange and safe outputs while the power is off.
            (true, false) => self.slave.return_to_wait_prm(),
            _ => {}
        }
        self.powered = on;
    }

    /// Connects the slave to the bus or disconnects it.
    pub const fn set_connected(&mut self, connected: bool) {
        self.connected = connected;
    }

    /// Why the slave refused parameters or configuration, for the engineer at the master. `None` if that was taken before.
    pub fn take_refusal(&mut self) -> Option<String> {
        // The device is asked first: whoever takes it mutably drops the prepared answer.
        self.slave.device().has_new_refusal().then_some(())?;
        self.slave.device_mut().take_refusal().map(str::to_owned)
    }

    /// Carries out an order. Returns what the user may want to know: the reported diagnosis, a record; often nothing.
    ///
    /// # Errors
    /// [`Refused`] says what is possible; nothing has changed then.
    pub fn execute(&mut self, order: &Order) -> Result<String, Refused> {
        match order {
            Order::Input { slot, at, octets } => self.set_input(*slot, *at, octets),
            Order::InputBit { slot, bit, on } => self.set_input_bit(*slot, *bit, *on),
            Order::Diagnosis { first, last, value } => self.set_diagnosis(*first, *last, value),
            Order::NoDiagnosis => {
                let cleared = self.slave.device().reported().cleared();
                self.slave.device_mut().report(cleared)?;
                Ok(String::new())
            }
            Order::ChannelError { slot, channel, error, present } => {
                self.set_channel_error(*slot, *channel, error, *present)
            }
            Order::Alarm { slot, alarm_type, change, octets } => {
                self.raise_alarm(NewAlarm { slot: *slot, alarm_type: *alarm_type, change: *change, data: octets })
            }
            Order::Record { slot, index, octets: Some(octets) } => self.set_record(*slot, *index, octets),
            Order::Record { slot, index, octets: None } => {
                let missing = || Refused(format!("no record in slot {slot} index {index}"));
                self.slave.device().records.get(*slot, *index).map(hex).ok_or_else(missing)
            }
        }
    }

    /// The orders that report what the file has words for, each with its words: `diagnosis 9 bit 24 on (Supply of valves missing)`. An error of
    /// a channel is named once, for channel 0 of the first slot that can report it.
    #[must_use]
    pub fn fault_orders(&self) -> Vec<String> {
        let (plan, address) = (self.plan(), self.switch_address);
        let mut orders = Vec::new();
        for texts in unit_texts(plan.device()) {
            let bits = texts.bits.iter().map(|(bit, words)| (format!("bit {bit} on"), words));
            let inverted = texts.inverted.iter().map(|(bit, words)| (format!("bit {bit} off"), words));
            let values = texts.areas.iter().flat_map(|area| {
                let (first, last) = (area.first, area.last);
                area.values.iter().map(move |(number, words)| (format!("area {first}-{last} {number}"), words))
            });
            let all = bits.chain(inverted).chain(values);
            orders.extend(all.map(|(order, words)| format!("diagnosis {address} {order} ({})", words.text.trim())));
        }
        let mut named = BTreeSet::new();
        for module in plan.modules().iter().filter(|module| !module.identifiers.is_empty()) {
            for (error, text) in plan.channel_texts(module) {
                if named.insert((error, text.clone())) {
                    let slot = module.slot;
                    orders.push(format!("channel-error {address} {slot} 0 {error} on ({})", text.trim()));
                }
            }
        }
        orders
    }

    fn set_input(&mut self, slot: u32, at: usize, octets: &[u8]) -> Result<String, Refused> {
        let range = octets_of(self.plan().slot(slot)?, Direction::Input);
        let first = range.start.saturating_add(at);
        let last = first.saturating_add(octets.len());
        if last > range.end {
            return Err(self.too_long(slot, at.saturating_add(octets.len())));
        }
        self.slave.device_mut().input_octets_mut(first..last).copy_from_slice(octets);
        Ok(String::new())
    }

    fn set_input_bit(&mut self, slot: u32, bit: usize, on: bool) -> Result<String, Refused> {
        let range = octets_of(self.plan().slot(slot)?, Direction::Input);
        let (at, mask) = (bit / 8, 1 << (bit % 8));
        let refused = self.too_long(slot, at.saturating_add(1));
        let octet = self.slave.device_mut().input_octets_mut(range).get_mut(at).ok_or(refused)?;
        *octet = if on { *octet | mask } else { *octet & !mask };
        Ok(String::new())
    }

    /// The refusal of inputs up to octet `end` of a slot.
    fn too_long(&self, slot: u32, end: usize) -> Refused {
        let inputs = |one: &PlacedModule| octets_of(one, Direction::Input).len();
        let has = |one: &PlacedModule| format!("slot {slot} ({}) has {} octets of inputs", one.name, inputs(one));
        let has = self.plan().slot(slot).map_or_else(|sentence| sentence, has);
        let with = self.plan().modules().iter().filter(|one| inputs(one) > 0);
        let with: Vec<_> = with.map(|one| one.slot.to_string()).collect();
        Refused(match with.is_empty() {
            true => format!("{has}, got {end}; no module of the slave has inputs"),
            false => format!("{has}, got {end}; slots with inputs: {}", with.join(", ")),
        })
    }

    fn set_diagnosis(&mut self, first: u16, last: u16, value: &str) -> Result<String, Refused> {
        let number = self.diagnosis_value(first, last, value)?;
        let changed = self.slave.device().reported().set_unit(first, last, number)?;
        self.slave.device_mut().report(changed)?;
        Ok(self.reported_texts())
    }

    /// The number of an area: a number, or the file's text for one.
    fn diagnosis_value(&self, first: u16, last: u16, value: &str) -> Result<u64, Refused> {
        let bits = u32::from(last.saturating_sub(first)).saturating_add(1);
        let highest = u64::MAX.checked_shr(64_u32.saturating_sub(bits)).unwrap_or(0);
        let areas = unit_texts(self.plan().device()).flat_map(|texts| &texts.areas);
        let texts: Vec<_> =
            areas.filter(|area| (area.first, area.last) == (first, last)).flat_map(|area| &area.values).collect();
        let named =
            texts.iter().find(|(_, words)| words.text.trim().eq_ignore_ascii_case(value)).map(|(number, _)| **number);
        let number = named.or_else(|| value.parse().ok()).filter(|number| *number <= highest);
        number.ok_or_else(|| {
            let texts: Vec<_> = texts.iter().map(|(number, words)| format!("{number} ({})", words.text)).collect();
            let texts = if texts.is_empty() { String::new() } else { format!(", or a text: {}", texts.join(", ")) };
            Refused(format!(
                "expected for the bits {first} to {last} a number from 0 to {highest}{texts}, got {value:?}"
            ))
        })
    }

    fn set_channel_error(&mut self, slot: u32, channel: u8, error: &str, present: bool) -> Result<String, Refused> {
        let plan = self.plan();
        let one = plan.slot(slot)?;
        let first = u8::try_from(one.identifiers.start).ok().filter(|_| !one.identifiers.is_empty());
        let identifier = first.filter(|identifier| *identifier <= MAX_CHANNEL);
        let identifier = identifier.ok_or_else(|| {
            Refused(format!("slot {slot} ({}) has no identifier from 0 to {MAX_CHANNEL} that could report", one.name))
        })?;
        let texts = plan.channel_texts(one);
        let mut named = texts.iter().filter(|(_, text)| text.trim().eq_ignore_ascii_case(error));
        let named = match (named.next(), named.next()) {
            (Some((number, _)), None) => Some(*number),
            _ => None,
        };
        let number = named.or_else(|| error.parse().ok()).filter(|number| (1..=MAX_ERROR).contains(number));
        let number = number.ok_or_else(|| {
            let texts: Vec<_> = texts.iter().map(|(number, text)| format!("{number} ({text})")).collect();
            let texts =
                if texts.is_empty() { String::new() } else { format!("; texts of the file: {}", texts.join(", ")) };
            Refused(format!("expected an error from 1 to {MAX_ERROR} or its text, got {error:?}{texts}"))
        })?;
        let direction =
            u8::from(one.data(Direction::Input).is_some()) | u8::from(one.data(Direction::Output).is_some()) << 1;
        let error = ChannelError { identifier, channel, direction, error: number };
        let changed = self.slave.device().reported().set_channel(error, present)?;
        self.slave.device_mut().report(changed)?;
        Ok(self.reported_texts())
    }

    fn set_record(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<String, Refused> {
        let general = &self.plan().device().general;
        if general.c1_read_write_supp != Some(true) && general.c2_read_write_supp != Some(true) {
            return Err(Refused(
                "the file has neither C1_Read_Write_supp nor C2_Read_Write_supp: no master reads a record".into(),
            ));
        }
        if octets.len() > MAX_RECORD {
            return Err(Refused(format!("expected at most {MAX_RECORD} octets, got {}", octets.len())));
        }
        let stored = self.slave.device_mut().records.set(slot, index, octets);
        stored.map_err(|error| Refused(error.to_string()))?;
        Ok(String::new())
    }

    fn reported_texts(&self) -> String {
        let device = self.slave.device();
        device.reported().texts(&device.plan).join("; ")
    }

    fn plan(&self) -> &Plan {
        &self.slave.device().plan
    }
}

/// The address after power-up.
fn start_address(device: &GsdDevice, switch_address: u8) -> u8 {
    let stored = device.records.address().filter(|_| profivac_dp::slave::Device::address_is_settable(device));
    stored.map_or(switch_address.min(UNSET_ADDRESS), |(address, _)| address)
}

impl Station for GsdStation {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        if self.powered && self.connected { self.slave.telegram(end, telegram) } else { None }
    }

    fn sent(&mut self, end: BitTime) {
        self.slave.sent(end);
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        if self.powered { self.slave.poll(now).filter(|_| self.connected) } else { None }
    }

    fn wake_at(&self) -> Option<BitTime> {
        self.slave.wake_at().filter(|_| self.powered)
    }

    fn listening(&self) -> Listening {
        self.slave.listening()
    }
}
