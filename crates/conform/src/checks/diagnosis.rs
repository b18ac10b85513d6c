//! The contents of the diagnosis and of the configuration, which any master can read in any state (profibus-wire 2.3 and 2.7).

use super::Check;
use crate::dialogue::{CheckOutcome, Dialogue, Step, StepResult, require};
use crate::expected::Expected;
use profivac_wire::diag::StationStatus;
use profivac_wire::ext_diag::Blocks;
use profivac_wire::{Sap, cfg};

const DIAGNOSIS: &[&str] = &["diagnosis.answer"];

const CONFIGURATION: &[&str] = &["get-cfg.identifiers"];

pub const CHECKS: &[Check] = &[
    Check::new("diagnosis.fixed-bit", "2.3", "bit 2 of the second octet of a diagnosis is 1", fixed_bit)
        .after(DIAGNOSIS),
    Check::new("diagnosis.master-bits", "2.3", "the bits that only masters set are 0", master_bits).after(DIAGNOSIS),
    Check::new("diagnosis.reserved-bits", "2.3", "the reserved bits of a diagnosis are 0", reserved_bits)
        .after(DIAGNOSIS),
    Check::new("diagnosis.ident", "2.3", "the diagnosis has the ident number of the slave", ident).after(DIAGNOSIS),
    Check::new("diagnosis.blocks", "2.3.1", "the blocks of Ext_Diag_Data end with the diagnosis", blocks)
        .after(DIAGNOSIS),
    Check::new("diagnosis.any-master", "3.4", "any master can read the diagnosis", any_master).after(DIAGNOSIS),
    Check::new("get-cfg.identifiers", "2.7", "Get_Cfg is answered with the identifiers of a configuration", get_cfg),
    Check::new("get-cfg.any-master", "2.7", "any master can read the configuration", get_cfg_any_master)
        .after(CONFIGURATION)
        .unless_broken(&["diagnosis.any-master"]),
    Check::new("get-cfg.no-open-format", "2.6.2", "no identifier leaves its manufacturer octets open", no_open_format)
        .after(CONFIGURATION),
];

/// Set by the master that reads the diagnosis.
const MASTER_BITS: StationStatus = StationStatus::STATION_NON_EXISTENT
    .union(StationStatus::INVALID_SLAVE_RESPONSE)
    .union(StationStatus::MASTER_LOCK)
    .union(StationStatus::DEACTIVATED);

/// Bit 6 of the second octet, and bits 6 to 0 of the third one.
const RESERVED_BITS: StationStatus = StationStatus::from_bits_retain(0x007F_4000);

fn fixed_bit(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.diagnosis().prepared()?.require_set(StationStatus::ALWAYS_ONE).tested()
}

fn master_bits(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.diagnosis().prepared()?.require_clear(MASTER_BITS).tested()
}

fn reserved_bits(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.diagnosis().prepared()?.require_clear(RESERVED_BITS).tested()
}

/// Before and after Set_Prm.
fn ident(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let own = dialogue.slave.ident;
    for parameterised in [false, true] {
        if parameterised {
            dialogue.parameterise()?;
        }
        let found = dialogue.diagnosis().prepared()?.ident;
        require(found == own, Expected::Ident(own)).tested()?;
    }
    dialogue.release()?;
    Ok(())
}

fn blocks(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let octets = dialogue.diagnosis_octets(dialogue.own_address()).prepared()?;
    let blocks = octets.get(6..).unwrap_or_default();
    require(Blocks::new(blocks).all(|block| block.is_ok()), Expected::DiagnosisBlocks).tested()
}

fn any_master(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.diagnosis_octets(dialogue.other_master_address()).map(|_| ()).tested()
}

/// The identifiers that the slave returns to `sa`.
fn configuration(dialogue: &mut Dialogue<'_>, sa: u8) -> StepResult<Vec<u8>> {
    let answer = dialogue.request_from(sa, Sap::GetCfg, &[])?;
    let whole = answer.has_data_status() && cfg::lengths(&answer.du).is_ok();
    require(whole, Expected::Configuration)?;
    Ok(answer.du)
}

fn get_cfg(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    configuration(dialogue, dialogue.own_address()).map(|_| ()).tested()
}

fn get_cfg_any_master(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    configuration(dialogue, dialogue.other_master_address()).map(|_| ()).tested()
}

fn no_open_format(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let octets = configuration(dialogue, dialogue.own_address()).prepared()?;
    require(!has_open_format(&octets), Expected::ClosedConfiguration).tested()
}

/// Whether an identifier in special format has the number 15 of manufacturer octets.
fn has_open_format(identifiers: &[u8]) -> bool {
    let mut rest = identifiers;
    while let [identifier, behind @ ..] = rest {
        let is_special = identifier & 0x30 == 0;
        let manufacturer = usize::from(identifier & 0x0F);
        if is_special && manufacturer == 15 {
            return true;
        }
        let lengths = match (is_special, identifier >> 6) {
            (false, _) | (true, 0) => 0,
            (true, 1 | 2) => 1,
            (true, _) => 2,
        };
        let own = if is_special { lengths + manufacturer } else { 0 };
        rest = behind.get(own..).unwrap_or_default();
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_identifier_in_special_format_can_be_open() {
        assert!(has_open_format(&[0x4F, 0x84]));
        assert!(has_open_format(&[0x10, 0xC1, 0x81, 0x84, 0x85, 0x8F, 0x01]));
        // 16 units of the general format, a length octet and a manufacturer octet of 4F.
        for closed in [&[0x1F][..], &[0x41, 0x4F, 0x4F], &[0x42, 0x84, 0x08, 0x05], &[]] {
            assert!(!has_open_format(closed), "{closed:02X?}");
        }
    }
}
