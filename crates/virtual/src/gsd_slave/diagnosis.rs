//! The diagnosis that a virtual slave reports: a device-related block, and channel errors with the block of their identifiers.
//! profibus-wire 2.3.1.

use super::plan::Plan;
use profivac_gsd::{Device, UnitDiag};
use std::collections::{BTreeMap, BTreeSet};

/// The most octets behind the header of a device-related block.
const MAX_UNIT: usize = 62;

/// The highest number of an identifier, and of a channel, in a channel-related block.
pub(super) const MAX_CHANNEL: u8 = 63;

/// The header bits of an identifier-related and of a channel-related block.
const IDENTIFIER_BLOCK: u8 = 0x40;
const CHANNEL_BLOCK: u8 = 0x80;

/// A DP-V1 block without further meaning: a status message of slot 0. profibus-wire 2.3.2.
const STATUS_MESSAGE: [u8; 3] = [0x81, 0, 0];

/// The type of a channel of one bit, in the upper bits of its error.
const CHANNEL_IS_BIT: u8 = 1 << 5;

/// An error of a channel, as its block has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ChannelError {
    pub(super) identifier: u8,
    pub(super) channel: u8,
    /// Bit 0: it is an input, bit 1: it is an output.
    pub(super) direction: u8,
    pub(super) error: u8,
}

/// The bits whose text counts when they are not set (Unit_Diag_!Bit).
#[derive(Clone, Debug)]
struct Inverted {
    by_type: BTreeMap<u8, Vec<u16>>,
    /// Those of a block without a type of the file.
    others: Vec<u16>,
}

impl Inverted {
    fn of(diagnosis: &profivac_gsd::Diagnosis) -> Self {
        let numbers = |texts: &UnitDiag| texts.inverted.keys().copied().collect();
        let by_type = diagnosis.types.iter().map(|(kind, texts)| (*kind, numbers(texts))).collect();
        Self { by_type, others: numbers(&diagnosis.unit) }
    }

    /// Those that count for a block: its first octet is its type, see [`profivac_gsd::Diagnosis::device_block`].
    fn in_block(&self, block: &[u8]) -> &[u16] {
        block.first().and_then(|kind| self.by_type.get(kind)).unwrap_or(&self.others)
    }

    /// Sets those of a block, so that they say nothing.
    fn silence(&self, block: &mut [u8]) {
        for number in self.in_block(block).to_vec() {
            set_bit(block, number, true);
        }
    }
}

/// What the slave reports.
#[derive(Clone, Debug)]
pub(super) struct Reported {
    /// The octets behind the header of the device-related block when nothing is reported.
    quiet: Vec<u8>,
    unit: Vec<u8>,
    inverted: Inverted,
    channels: BTreeSet<ChannelError>,
    identifiers: usize,
    /// The longest Ext_Diag_Data.
    most: usize,
    /// Ext_Diag_Data.
    blocks: Vec<u8>,
}

impl Reported {
    /// Nothing to report. chosen: the device-related block has room for each bit and area of the file, and is sent only while it reports
    /// something. Bits whose text counts when they are not set (Unit_Diag_!Bit) are set.
    pub(super) fn nothing(plan: &Plan) -> Self {
        let device = plan.device();
        let most = plan.max_ext_diag();
        let mut quiet = Vec::new();
        for texts in unit_texts(device) {
            let bits = texts.bits.keys().chain(texts.inverted.keys()).copied();
            let last = bits.chain(texts.areas.iter().map(|area| area.last)).max();
            let octets = last.map_or(0, |last| usize::from(last / 8).saturating_add(1)).min(unit_room(most));
            quiet.resize(octets.max(quiet.len()), 0);
        }
        if plan.slave.is_dpv1() && unit_room(most) >= STATUS_MESSAGE.len() {
            quiet.resize(quiet.len().max(STATUS_MESSAGE.len()), 0);
            let [kind, slot, specifier] = STATUS_MESSAGE;
            let kind = device.diagnosis.types.keys().next().copied().unwrap_or(kind);
            quiet.iter_mut().zip([kind, slot, specifier]).for_each(|(octet, status)| *octet = status);
        }
        let inverted = Inverted::of(&device.diagnosis);
        inverted.silence(&mut quiet);
        let unit = quiet.clone();
        Self {
            quiet,
            unit,
            inverted,
            channels: BTreeSet::new(),
            identifiers: plan.modules().iter().map(|module| module.identifiers.len()).sum(),
            most,
            blocks: Vec::new(),
        }
    }

    /// Ext_Diag_Data.
    pub(super) fn blocks(&self) -> &[u8] {
        &self.blocks
    }

    /// Whether there is something to report.
    pub(super) fn is_event(&self) -> bool {
        !self.blocks.is_empty()
    }

    /// Sets the bits from `first` to `last` of the device-related block to a value.
    ///
    /// # Errors
    /// A sentence: the block cannot be that long.
    pub(super) fn set_unit(&self, first: u16, last: u16, value: u64) -> Result<Self, String> {
        let (mut changed, room) = (self.clone(), unit_room(self.most));
        let octets = usize::from(last / 8).saturating_add(1);
        if octets > room {
            return Err(match room.saturating_mul(8).checked_sub(1) {
                Some(highest) => format!("expected a bit from 0 to {highest}: the file allows no longer diagnosis"),
                None => "the file allows no device-related diagnosis: its Max_Diag_Data_Len is too small".to_owned(),
            });
        }
        changed.unit.resize(changed.unit.len().max(octets), 0);
        changed.quiet.resize(changed.unit.len(), 0);
        let set = |block: &mut [u8]| {
            for (place, number) in (first..=last).enumerate() {
                let bit = u32::try_from(place).ok().and_then(|place| value.checked_shr(place)).unwrap_or(0) & 1 == 1;
                set_bit(block, number, bit);
            }
        };
        let before = changed.inverted.in_block(&changed.unit).to_vec();
        set(&mut changed.unit);
        if changed.inverted.in_block(&changed.unit) != before {
            // Another type: its bits have other meanings.
            before.iter().for_each(|number| set_bit(&mut changed.unit, *number, false));
            changed.inverted.silence(&mut changed.unit);
            set(&mut changed.unit);
        }
        changed.checked()
    }

    /// Reports an error of a channel, or not any more.
    ///
    /// # Errors
    /// A sentence: the diagnosis would be longer than the file allows.
    pub(super) fn set_channel(&self, error: ChannelError, present: bool) -> Result<Self, String> {
        let mut changed = self.clone();
        if present {
            changed.channels.insert(error);
        } else {
            changed.channels.remove(&error);
        }
        changed.checked()
    }

    /// Reports nothing any more.
    pub(super) fn cleared(&self) -> Self {
        Self { unit: self.quiet.clone(), channels: BTreeSet::new(), blocks: Vec::new(), ..self.clone() }
    }

    /// The same with its blocks. The block of identifiers is left out if there is no room for it: it says nothing new.
    fn checked(mut self) -> Result<Self, String> {
        let mut blocks = self.unit_block();
        let channels: Vec<u8> = self.channels.iter().flat_map(|error| error.octets()).collect();
        let identifiers = self.identifier_block();
        if blocks.len().saturating_add(identifiers.len()).saturating_add(channels.len()) <= self.most {
            blocks.extend(identifiers);
        }
        blocks.extend(channels);
        if blocks.len() > self.most {
            return Err(format!(
                "{} octets of diagnosis behind the first six, and the file allows {}; end another report first",
                blocks.len(),
                self.most
            ));
        }
        self.blocks = blocks;
        Ok(self)
    }

    fn unit_block(&self) -> Vec<u8> {
        if self.unit == self.quiet {
            return Vec::new();
        }
        let header = u8::try_from(self.unit.len().saturating_add(1)).unwrap_or_default();
        std::iter::once(header).chain(self.unit.iter().copied()).collect()
    }

    fn identifier_block(&self) -> Vec<u8> {
        if self.channels.is_empty() {
            return Vec::new();
        }
        let mut bits = vec![0; self.identifiers.div_ceil(8).clamp(1, 31)];
        for error in &self.channels {
            set_bit(&mut bits, error.identifier.into(), true);
        }
        let header = u8::try_from(bits.len().saturating_add(1)).unwrap_or_default() | IDENTIFIER_BLOCK;
        std::iter::once(header).chain(bits).collect()
    }

    /// What is reported, in the file's words.
    pub(super) fn texts(&self, plan: &Plan) -> Vec<String> {
        let unit = plan.device().diagnosis.device_block(&self.unit_block());
        let unit = unit.into_iter().map(|finding| finding.to_string());
        unit.chain(self.channels.iter().map(|error| error.words(plan))).collect()
    }
}

impl ChannelError {
    /// chosen: the channel is a bit, because no file says how wide it is and 0 is reserved (profibus-wire 2.3.2).
    fn octets(&self) -> [u8; 3] {
        [CHANNEL_BLOCK | self.identifier, self.direction << 6 | self.channel, CHANNEL_IS_BIT | self.error]
    }

    fn words(&self, plan: &Plan) -> String {
        let identifier = usize::from(self.identifier);
        let slot = plan.slave.layout().module_of_identifier(identifier);
        let configuration = plan.slave.configuration();
        let text = configuration.channel_text(identifier, self.error);
        let text = text.map_or_else(|| format!("error {}", self.error), str::to_owned);
        format!("slot {} channel {}: {text}", slot.map_or(0, |slot| slot.slot), self.channel)
    }
}

/// The texts of the device for device-related blocks.
pub(super) fn unit_texts(device: &Device) -> impl Iterator<Item = &UnitDiag> {
    std::iter::once(&device.diagnosis.unit).chain(device.diagnosis.types.values())
}

/// The octets behind the header of a device-related block.
fn unit_room(most: usize) -> usize {
    most.saturating_sub(1).min(MAX_UNIT)
}

fn set_bit(octets: &mut [u8], number: u16, on: bool) {
    let Some(octet) = octets.get_mut(usize::from(number / 8)) else { return };
    let mask = 1 << (number % 8);
    *octet = if on { *octet | mask } else { *octet & !mask };
}
