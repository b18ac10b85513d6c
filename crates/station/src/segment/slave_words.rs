//! The diagnosis of a slave in the words of its GSD file.

use crate::config;
use profivac_gsd_slave::{GsdSlave, PlacedModule};
use profivac_wire::diag::SlaveDiag;
use profivac_wire::ext_diag::{Block, Blocks, Channel, Message, identifiers_with_diagnosis};

/// The extended diagnosis in sentences; empty without one. A block without a text in the file is shown by the standard's words, or by its
/// octets.
pub fn reports(slave: &config::Slave, diag: &SlaveDiag<'_>) -> Vec<String> {
    let gsd = &slave.gsd;
    let blocks = Blocks::new(diag.ext_diag).filter_map(Result::ok);
    let texts = blocks.flat_map(|block| match block {
        Block::Device(content) => device_texts(gsd, content),
        Block::Identifier(content) => {
            let module = |number| format!("{} reports a diagnosis", place(gsd, number));
            identifiers_with_diagnosis(content).map(|number| module(usize::from(number))).collect()
        }
        Block::Channel(channel) => vec![channel_text(gsd, channel)],
        Block::Revision(_) => Vec::new(),
    });
    // A channel says more than its module.
    let all: Vec<String> = texts.collect();
    let is_told = |text: &str| {
        let channel = text.strip_suffix(" reports a diagnosis").map(|module| format!("{module} channel "));
        channel.is_some_and(|channel| all.iter().any(|other| other.starts_with(&channel)))
    };
    all.iter().filter(|text| !is_told(text)).cloned().collect()
}

fn device_texts(gsd: &GsdSlave, content: &[u8]) -> Vec<String> {
    let length = u8::try_from(content.len().saturating_add(1)).unwrap_or_default();
    let block: Vec<u8> = std::iter::once(length).chain(content.iter().copied()).collect();
    let findings = gsd.device().diagnosis.device_block(&block);
    if !findings.is_empty() {
        return findings.iter().map(ToString::to_string).collect();
    }
    match Message::parse(content) {
        Ok(message) if gsd.is_dpv1() => vec![message.to_string()],
        // Bits without a text that are all zero say nothing.
        _ if content.iter().all(|octet| *octet == 0) => Vec::new(),
        _ => vec![format!("device-related diagnosis {}", profivac_listen::Hex(content))],
    }
}

fn channel_text(gsd: &GsdSlave, channel: Channel) -> String {
    let identifier = usize::from(channel.identifier);
    let configuration = gsd.configuration();
    let own = configuration.channel_text(identifier, channel.error.0);
    let text = own.map_or_else(|| channel.error.to_string(), str::to_owned);
    format!("{} channel {}: {text}", place(gsd, identifier), channel.number)
}

/// The module of an identifier, or the number of the identifier if the configuration has none.
fn place(gsd: &GsdSlave, identifier: usize) -> String {
    let module = gsd.layout().module_of_identifier(identifier);
    module.map_or_else(|| format!("identifier {identifier}"), PlacedModule::label)
}
