//! How the specification writes keywords.

use crate::general::KEYWORDS;
use std::collections::HashMap;
use std::sync::OnceLock;

/// Keywords of blocks and lists.
const STRUCTURE: &[&str] = &[
    "#Profibus_DP",
    "Module",
    "EndModule",
    "Preset",
    "PrmText",
    "EndPrmText",
    "Text",
    "ExtUserPrmData",
    "EndExtUserPrmData",
    "Prm_Text_Ref",
    "Changeable",
    "Visible",
    "Bit",
    "BitArea",
    "Unsigned8",
    "Unsigned16",
    "Unsigned32",
    "Signed8",
    "Signed16",
    "Signed32",
    "SlotDefinition",
    "EndSlotDefinition",
    "Slot",
    "UnitDiagType",
    "EndUnitDiagType",
    "Unit_Diag_Bit",
    "Unit_Diag_!Bit",
    "Unit_Diag_Bit_Help",
    "Unit_Diag_!Bit_Help",
    "Unit_Diag_Area",
    "Unit_Diag_Area_End",
    "X_Unit_Diag_Bit",
    "X_Unit_Diag_Bit_Help",
    "X_Unit_Diag_!Bit",
    "X_Unit_Diag_!Bit_Help",
    "X_Unit_Diag_Area",
    "X_Unit_Diag_Area_End",
    "Value",
    "X_Value",
    "Value_Help",
    "X_Value_Help",
    "Channel_Diag",
    "Channel_Diag_Help",
    "User_Prm_Data",
    "Ext_User_Prm_Data_Const",
    "Ext_User_Prm_Data_Ref",
    "Ext_Module_Prm_Data_Len",
    "F_Ext_User_Prm_Data_Const",
    "F_Ext_User_Prm_Data_Ref",
    "F_Ext_Module_Prm_Data_Len",
];

/// Keywords that are known, but of no use to a master or slave: they are kept as they are.
const KEPT: &[&str] = &[
    "f_paramdesccrc",
    "f_io_structuredesccrc",
    "physical_interface",
    "end_physical_interface",
    "version_firmware_download",
    "end_version_firmware_download",
    "firmware_download_supp",
    "family_name",
    "jokerblock_slot",
    "jokerblock_type",
    "jokerblock_location",
    "end_jokerblock",
    "data_area_beg",
    "data_area_end",
    "module_offset",
    "max_ismodules",
];

fn spellings() -> &'static HashMap<String, &'static str> {
    static SPELLINGS: OnceLock<HashMap<String, &'static str>> = OnceLock::new();
    SPELLINGS
        .get_or_init(|| KEYWORDS.iter().chain(STRUCTURE).map(|right| (right.to_ascii_lowercase(), *right)).collect())
}

/// The right spelling of a keyword in small letters.
pub(super) fn known(keyword: &str) -> Option<&'static str> {
    spellings().get(keyword).copied()
}

pub(super) fn is_kept(keyword: &str) -> bool {
    KEPT.contains(&keyword)
}
