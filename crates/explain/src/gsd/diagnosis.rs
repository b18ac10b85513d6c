//! Diagnosis in the words of the files.

use super::{Described, distinct};
use crate::dpv1::DeviceBlocks;
use profivac_gsd::{Diagnosis, Finding};
use profivac_wire::ext_diag::{
    Block, Blocks, Channel, Message, MessageKind, ModuleState, identifiers_with_diagnosis, module_states,
};

impl Described {
    /// A block of a diagnosis as text; `None` if no file describes the slave.
    #[must_use]
    pub fn block_text(&self, block: &Block<'_>, device_blocks: DeviceBlocks) -> Option<String> {
        if !self.is_known() {
            return None;
        }
        Some(match block {
            Block::Device(content) => self.device_text(content, device_blocks),
            Block::Identifier(content) => self.identifiers_text(identifiers_with_diagnosis(content)),
            Block::Channel(channel) => self.channel_text(channel),
            Block::Revision(_) => return None,
        })
    }

    /// What an extended diagnosis reports, a text for each block. A block without news has none: bits that are all zero and have no text,
    /// a Module_Status with valid modules only, a list of identifiers that are empty or that a channel-related block names.
    #[must_use]
    pub fn conditions(&self, ext_diag: &[u8], device_blocks: DeviceBlocks) -> Vec<String> {
        let blocks: Vec<_> = Blocks::new(ext_diag).collect();
        let has_channel = |number: u16| {
            let is_of = |block: &_| matches!(block, Ok(Block::Channel(one)) if u16::from(one.identifier) == number);
            blocks.iter().any(is_of)
        };
        let texts = blocks.iter().filter_map(|block| match block {
            Ok(Block::Identifier(content)) => {
                let others: Vec<_> = identifiers_with_diagnosis(content).filter(|one| !has_channel(*one)).collect();
                (!others.is_empty()).then(|| self.identifiers_text(others.into_iter()))
            }
            Ok(Block::Device(content)) if self.is_without_news(content, device_blocks) => None,
            Ok(block) => self.block_text(block, device_blocks),
            Err(_) => Some("a damaged block".to_owned()),
        });
        texts.collect()
    }

    fn is_without_news(&self, content: &[u8], device_blocks: DeviceBlocks) -> bool {
        let states = message_in(content, device_blocks).filter(|message| message.kind == MessageKind::MODULE_STATUS);
        match states {
            Some(message) => module_states(message.data).all(|state| state == ModuleState::Valid),
            None => content.iter().all(|octet| *octet == 0) && self.findings(content, None).is_empty(),
        }
    }

    fn identifiers_text(&self, identifiers: impl Iterator<Item = u16>) -> String {
        let all: Vec<_> = identifiers.map(|one| self.identifier_text(one.into())).collect();
        match all.is_empty() {
            true => "no identifier has diagnosis".to_owned(),
            false => format!("with diagnosis: {}", all.join(", ")),
        }
    }

    /// `identifier 3 (slot 2, module 4DO), output channel 5 (bit): error 16 fuse blown (replace it)`.
    fn channel_text(&self, channel: &Channel) -> String {
        let plain = channel.to_string();
        let (place, name) = plain.split_once(": ").unwrap_or((&plain, ""));
        let place = place.strip_prefix(&format!("module {}", channel.identifier)).unwrap_or_default();
        let (identifier, error) = (usize::from(channel.identifier), channel.error.0);
        let texts =
            distinct(self.modules_in(|slot| slot.identifiers.contains(&identifier)).filter_map(|(device, modules)| {
                let own = modules.iter().find_map(|module| module.diagnosis.channel(error));
                let words = own.or_else(|| device.diagnosis.channel(error))?;
                let help = words.help.as_ref().map_or_else(String::new, |help| format!(" ({help})"));
                Some(format!("{}{help}", words.text))
            }));
        // Errors below 16 have a meaning of their own, profibus-wire 2.3.1.
        let name = match (texts.is_empty(), error) {
            (false, _) => texts.join(" or "),
            (true, 16..) => "without a text in the GSD file".to_owned(),
            (true, _) => name.to_owned(),
        };
        format!("{}{place}: error {error} {name}", self.identifier_text(identifier))
    }

    /// An alarm or a status with the module of its slot, or the vendor's octets, and the texts of the files for its bits.
    fn device_text(&self, content: &[u8], device_blocks: DeviceBlocks) -> String {
        let message = message_in(content, device_blocks);
        if let Some(message) = message.filter(|message| message.kind == MessageKind::MODULE_STATUS) {
            return self.module_status_text(&message);
        }
        let slot = message.map(|message| u32::from(message.slot));
        let named = slot.and_then(|number| self.slots.iter().find(|slot| slot.slot == number));
        let named = named.map_or_else(String::new, |slot| format!(" (slot {} is {})", slot.slot, slot.names()));
        let plain = device_blocks.text(content);
        let findings = self.findings(content, slot);
        let is_silent =
            message.is_none_or(|message| message.data.is_empty()) && content.iter().all(|octet| *octet == 0);
        match findings.as_slice() {
            [] if is_silent || message.is_some() => format!("{plain}{named}"),
            [] => format!("{plain}, without a text in the GSD file"),
            findings => format!("{plain}{named}: {}", findings.join("; ")),
        }
    }

    /// The texts of the files for the bits of a block. Texts of the module in the slot of a message count before those of the station.
    fn findings(&self, content: &[u8], slot: Option<u32>) -> Vec<String> {
        let header = u8::try_from(content.len().saturating_add(1)).unwrap_or(0);
        let block = [&[header], content].concat();
        let of =
            |diagnosis: &Diagnosis| diagnosis.device_block(&block).iter().map(Finding::to_string).collect::<Vec<_>>();
        distinct(self.modules_in(|one| Some(one.slot) == slot).flat_map(|(device, modules)| {
            let own = modules.iter().map(|module| of(&module.diagnosis)).find(|texts| !texts.is_empty());
            own.unwrap_or_else(|| of(&device.diagnosis))
        }))
    }

    /// The states of modules, two bits each. chosen: the first module is the first one that is plugged, because profibus-wire 2.3.2
    /// counts modules.
    fn module_status_text(&self, message: &Message<'_>) -> String {
        let states = module_states(message.data).enumerate().filter_map(|(place, state)| {
            let state = match state {
                ModuleState::Valid => return None,
                ModuleState::Invalid => "invalid data",
                ModuleState::Wrong => "wrong module",
                ModuleState::Missing => "no module",
            };
            let number = place.saturating_add(1);
            Some(match self.slots.get(place) {
                Some(slot) => format!("module {number} (slot {}, {}) {state}", slot.slot, slot.names()),
                None if self.slots.is_empty() => format!("module {number} {state}"),
                None => format!("module {number} (beyond the modules) {state}"),
            })
        });
        let states: Vec<_> = states.collect();
        let states = if states.is_empty() { "all valid".to_owned() } else { states.join(", ") };
        format!("module status: {states}")
    }
}

/// The alarm or the status in a device-related block of a slave that sends messages.
fn message_in(content: &[u8], device_blocks: DeviceBlocks) -> Option<Message<'_>> {
    let message = Message::parse(content).ok().filter(|message| !message.kind.is_reserved());
    message.filter(|_| device_blocks == DeviceBlocks::Messages)
}
