//! GSD files, and octets of traffic in their words.
//!
//! The input has three octets with the lengths of a configuration, user parameters and a diagnosis, these, and then the file.

use profivac_explain::dpv1::DeviceBlocks;
use profivac_explain::gsd::{Described, Extent, Files, Seen};
use profivac_gsd::{Configuration, Device, Fit, GsdFile, text};
use profivac_wire::cfg;
use profivac_wire::ext_diag::Blocks;
use std::sync::Arc;

/// Takes a part of the front.
fn take<'a>(octets: &mut &'a [u8], length: u8) -> &'a [u8] {
    let (part, rest) = octets.split_at(usize::from(length).min(octets.len()));
    *octets = rest;
    part
}

/// Reads a file and asks everything of the model.
pub fn run(octets: &[u8]) {
    let Some(([config, user, diag], mut rest)) = octets.split_first_chunk::<3>() else { return };
    let [config, user, diag] = [config, user, diag].map(|length| take(&mut rest, *length));
    let file = GsdFile::read(rest);
    assert_eq!(file.octets(), rest, "the octets stay");
    assert_eq!(file.lines().map(|(_, line)| line).collect::<String>(), file.text());
    let lines = file.text().split(['\n', '\r']).count();
    assert!(file.problems().iter().all(|problem| (1..=lines).contains(&problem.line)), "a problem has a line");
    let written = text(file.device());
    let again = GsdFile::read(written.as_bytes());
    // A control character at the end of a name is written as a blank, which a name does not keep.
    assert_eq!(again.device().modules.len(), file.device().modules.len(), "what is written is read again");
    preset(file.device());
    fitted(file.device(), config, user);
    described(&Arc::new(file), config, user, diag);
}

/// The octets of the modules that are plugged at first are read back to modules and parameters with the defaults.
fn preset(device: &Device) {
    let Ok(preset) = Configuration::preset(device) else { return };
    let octets = preset.chk_cfg();
    // The octets show neither a module without identifiers nor one whose identifier is cut, and without them the next one may be in a slot
    // that does not take it.
    let is_shown = |one: &profivac_gsd::Plugged<'_>| cfg::lengths(&one.module.config).is_ok();
    if !preset.modules().iter().all(is_shown) {
        return;
    }
    let fit = Fit::new(device, &octets).expect("the modules that gave the octets");
    let Ok(user) = preset.user_prm() else { return };
    if fit.slots.len() == preset.modules().len() && !fit.has_other_division {
        let reading = fit.read_prm(&user);
        assert!(reading.has_right_length() && reading.differences.is_empty(), "{:?}", reading.differences);
    }
}

/// Any configuration and user parameters.
fn fitted(device: &Device, config: &[u8], user: &[u8]) {
    let reading = device.read_station_prm(user);
    assert_eq!(reading.found, user.len());
    let fit = match Fit::new(device, config) {
        Ok(fit) => fit,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let mut end = 0;
    for slot in &fit.slots {
        assert_eq!(slot.config.start, end, "the slots divide all octets");
        end = slot.config.end;
        let own = config.get(slot.config.clone());
        assert!(slot.modules.iter().all(|module| Some(module.config.as_slice()) == own));
        assert!(!slot.modules.is_empty(), "a slot without a module");
    }
    assert_eq!(end, config.len());
    if let Ok(configuration) = fit.configuration() {
        assert_eq!(configuration.chk_cfg(), config);
    }
    let reading = fit.read_prm(user);
    assert!(reading.values.iter().all(|value| value.octet < user.len()));
    assert!(reading.differences.iter().all(|one| user.get(one.octet) == Some(&one.found)));
}

/// The same in sentences.
fn described(file: &Arc<GsdFile>, config: &[u8], user: &[u8], diag: &[u8]) {
    let ident = file.device().general.ident_number.and_then(|ident| u16::try_from(ident).ok());
    let mut described = Described::new(Files::new([Arc::clone(file)]));
    described.identify(ident.unwrap_or(0));
    described.configure(config);
    for extent in [Extent::Changes, Extent::All] {
        let _ = (described.parameters_text(user, extent), described.modules_text(extent));
    }
    let _ = (described.inputs(diag), described.outputs(user));
    for block in Blocks::new(diag).flatten() {
        for format in [DeviceBlocks::Messages, DeviceBlocks::Vendor, DeviceBlocks::Unknown] {
            let words = described.block_text(&block, format);
            assert!(words.is_none_or(|words| !words.is_empty()), "a block without words");
        }
    }
    let seen = Seen { bits_per_second: Some(500_000), set_prm: user, diagnosis: diag, longest_tsdr: Some(99) };
    assert!(described.mismatches(&seen).iter().all(|mismatch| !mismatch.found.is_empty()));
}
