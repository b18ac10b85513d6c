//! A device file beside the GSD file of its vendor: what an engineering tool would do otherwise.

use profivac_client::values::hex;
use profivac_devices::model::{Configuration, Model};
use profivac_gsd::{Device, Fit, General};

/// What the GSD file says otherwise than the model, with both values.
pub fn differences(model: &Model, gsd: &Device) -> Vec<String> {
    let mut found = Vec::new();
    found.extend(ident(model, &gsd.general));
    found.extend(services(model, &gsd.general));
    found.extend(lengths(model, gsd));
    found.extend(model.configurations.iter().filter_map(|one| configuration(one, gsd)));
    found.into_iter().map(|difference| format!("{}: {difference}", model.name)).collect()
}

fn ident(model: &Model, general: &General) -> Option<String> {
    let other = general.ident_number.filter(|ident| *ident != u32::from(model.ident))?;
    Some(format!(
        "ident is 0x{:04X}, Ident_Number of the GSD file 0x{other:04X}; one of them is of another device",
        model.ident
    ))
}

/// Services of which both say whether the slave has them. A GSD file without a keyword says that it does not.
fn services(model: &Model, general: &General) -> Vec<String> {
    let features = model.features;
    [
        ("sync", features.sync, "Sync_Mode_supp", general.sync_mode_supp),
        ("freeze", features.freeze, "Freeze_Mode_supp", general.freeze_mode_supp),
        ("dpv1", features.dpv1, "DPV1_Slave", general.dpv1_slave),
        ("ms1", features.ms1, "C1_Read_Write_supp", general.c1_read_write_supp),
        ("set-slave-address", model.gsd.set_slave_add, "Set_Slave_Add_supp", general.set_slave_add_supp),
    ]
    .into_iter()
    .filter(|(_, own, _, other)| *own != other.unwrap_or(false))
    .map(|(key, own, keyword, other)| {
        format!(
            "{key} = {own}, {keyword} of the GSD file is {}; compare with the manual",
            u8::from(other.unwrap_or(false))
        )
    })
    .collect()
}

/// Lengths that are above the limits of the GSD file.
fn lengths(model: &Model, gsd: &Device) -> Vec<String> {
    let general = &gsd.general;
    let longest = |octets: fn(&Configuration) -> usize| model.configurations.iter().map(octets).max().unwrap_or(0);
    let user_prm = model.user_prm.iter().map(|prm| prm.octets.len()).max().unwrap_or(0);
    [
        ("inputs", longest(Configuration::input_octets), "Max_Input_Len", general.max_input_len),
        ("outputs", longest(Configuration::output_octets), "Max_Output_Len", general.max_output_len),
        ("user parameters", user_prm, "Max_User_Prm_Data_Len", general.max_user_prm_data_len),
        ("a diagnosis", model.gsd.max_diag_octets.into(), "Max_Diag_Data_Len", general.max_diag_data_len),
    ]
    .into_iter()
    .filter_map(|(what, own, keyword, limit)| {
        let limit = limit.filter(|limit| own as u64 > u64::from(*limit))?;
        Some(format!("{what} of {own} octets, {keyword} of the GSD file is {limit}; compare with the manual"))
    })
    .collect()
}

/// A configuration that no modules of the GSD file give.
fn configuration(configuration: &Configuration, gsd: &Device) -> Option<String> {
    let error = Fit::new(gsd, configuration.octets).err()?;
    Some(format!("configuration {:?}: {error}", hex(configuration.octets)))
}
