//! Keywords with one value.

use crate::alarm::Alarm;
use crate::problem::Fault;
use crate::statement::Statement;
use crate::words::quoted;
use std::collections::BTreeSet;
use std::fmt;

/// A value of a keyword.
trait Value: Sized {
    fn read(statement: &Statement<'_>) -> Result<Self, Fault>;
    fn write(&self, keyword: &str) -> String;
}

impl Value for u32 {
    fn read(statement: &Statement<'_>) -> Result<Self, Fault> {
        statement.values.number()
    }

    fn write(&self, keyword: &str) -> String {
        if keyword == "Ident_Number" { format!("0x{self:04X}") } else { self.to_string() }
    }
}

impl Value for bool {
    fn read(statement: &Statement<'_>) -> Result<Self, Fault> {
        statement.values.number::<u64>().map(|value| value != 0)
    }

    fn write(&self, _: &str) -> String {
        u8::from(*self).to_string()
    }
}

impl Value for String {
    fn read(statement: &Statement<'_>) -> Result<Self, Fault> {
        Ok(statement.values.text())
    }

    fn write(&self, keyword: &str) -> String {
        // A family like `3@ET200B` is no text. A character that a reader takes for something else needs quotation marks.
        let is_plain = |one: u8| one.is_ascii_alphanumeric() || b" @._+/-".contains(&one);
        let stands_alone = keyword == "Slave_Family" && self.bytes().all(is_plain) && self.trim() == self;
        if stands_alone && !self.is_empty() { self.clone() } else { quoted(self) }
    }
}

macro_rules! general {
    ($($section:ident { $($field:ident: $type:ty = $keyword:literal, $doc:literal;)* })*) => {
        /// Keywords with one value. A field is none if the file does not have the keyword.
        #[derive(Clone, Debug, Default, PartialEq, Eq)]
        pub struct General {
            $($(#[doc = concat!($keyword, ": ", $doc, ".")] pub $field: Option<$type>,)*)*
        }

        /// A part of these keywords: a written file has other lines between two parts.
        #[derive(Clone, Copy)]
        pub(crate) enum Section {
            $($section,)*
        }

        impl General {
            /// Takes the value of a keyword in small letters. None if the keyword is none of these; true if it had a value before.
            pub(crate) fn read(&mut self, statement: &Statement<'_>) -> Option<Result<bool, Fault>> {
                $($(if statement.keyword.eq_ignore_ascii_case($keyword) {
                    return Some(Value::read(statement).map(|value| self.$field.replace(value).is_some()));
                })*)*
                None
            }

            /// The keywords that have a value, and their values as a file writes them.
            #[must_use]
            pub fn lines(&self) -> Vec<(&'static str, String)> {
                [$(Section::$section),*].into_iter().flat_map(|section| self.section(section)).collect()
            }

            /// Those of a section.
            pub(crate) fn section(&self, section: Section) -> Vec<(&'static str, String)> {
                let mut lines = Vec::new();
                match section {
                    $(Section::$section => {
                        $(if let Some(value) = &self.$field {
                            lines.push(($keyword, value.write($keyword)));
                        })*
                    })*
                }
                lines
            }
        }

        /// The keywords of [`General`] as the specification writes them.
        pub(crate) const KEYWORDS: &[&str] = &[$($($keyword),*),*];
    };
}

general! {
    Identity {
        gsd_revision: u32 = "GSD_Revision", "1 to 5";
        vendor_name: String = "Vendor_Name", "the vendor";
        model_name: String = "Model_Name", "the device";
        revision: String = "Revision", "the version of the device";
        revision_number: u32 = "Revision_Number", "the version as a number";
        ident_number: u32 = "Ident_Number", "the number that Set_Prm and the diagnosis carry, 0 to 65535";
        protocol_ident: u32 = "Protocol_Ident", "0 for DP";
        station_type: u32 = "Station_Type", "0 for a slave";
        fms_supp: bool = "FMS_supp", "the device also speaks FMS";
        hardware_release: String = "Hardware_Release", "version of the hardware";
        software_release: String = "Software_Release", "version of the firmware";
        bitmap_device: String = "Bitmap_Device", "picture in normal operation";
        bitmap_diag: String = "Bitmap_Diag", "picture with diagnosis";
        bitmap_sf: String = "Bitmap_SF", "picture in a special operating mode";
    }
    Services {
        redundancy: u32 = "Redundancy", "redundant transmission";
        slave_redundancy_supp: u32 = "Slave_Redundancy_supp", "kind of redundancy of the slave";
        repeater_ctrl_sig: u32 = "Repeater_Ctrl_Sig", "level of the control signal for repeaters at the connector";
        pins_24v: u32 = "24V_Pins", "supply at the connector";
        implementation_type: String = "Implementation_Type", "the protocol chip";
        order_number: String = "OrderNumber", "order number of the device";
        info_text: String = "Info_Text", "a sentence about the device";
        freeze_mode_supp: bool = "Freeze_Mode_supp", "Freeze is understood";
        sync_mode_supp: bool = "Sync_Mode_supp", "Sync is understood";
        auto_baud_supp: bool = "Auto_Baud_supp", "the slave finds the baud rate";
        set_slave_add_supp: bool = "Set_Slave_Add_supp", "the address can be set over the bus";
        min_slave_interval: u32 = "Min_Slave_Intervall", "shortest time between two polls, in 100 us";
        diag_update_delay: u32 = "Diag_Update_Delay", "diagnoses that may still ask for parameters after Set_Prm";
        time_sync_supp: bool = "Time_Sync_supp", "time telegrams are understood";
        slave_family: String = "Slave_Family", "place in a catalogue";
        modular_station: bool = "Modular_Station", "modules can be chosen";
        max_module: u32 = "Max_Module", "greatest number of modules";
        max_input_len: u32 = "Max_Input_Len", "greatest number of input octets";
        max_output_len: u32 = "Max_Output_Len", "greatest number of output octets";
        max_data_len: u32 = "Max_Data_Len", "greatest number of input and output octets together";
        max_diag_data_len: u32 = "Max_Diag_Data_Len", "greatest length of a diagnosis, 6 to 244";
        module_offset: u32 = "Modul_Offset", "number of the first slot in tools";
        fix_preset_modules: bool = "FixPresetModules", "modules with Preset are always plugged";
        fail_safe: bool = "Fail_Safe", "outputs of length 0 are understood in Clear";
        fail_safe_required: bool = "Fail_Safe_required", "outputs of length 0 are required in Clear";
        dpv1_slave: bool = "DPV1_Slave", "the first three user parameters are the DP-V1 status";
        c1_read_write_supp: bool = "C1_Read_Write_supp", "records over MS1";
        c1_max_data_len: u32 = "C1_Max_Data_Len", "longest record over MS1";
        c1_response_timeout: u32 = "C1_Response_Timeout", "longest time for an answer over MS1, in 10 ms";
        c1_read_write_required: bool = "C1_Read_Write_required", "the master must have MS1";
        c2_read_write_supp: bool = "C2_Read_Write_supp", "records over MS2";
        c2_max_data_len: u32 = "C2_Max_Data_Len", "longest record over MS2";
        c2_response_timeout: u32 = "C2_Response_Timeout", "longest time for an answer over MS2, in 10 ms";
        c2_read_write_required: bool = "C2_Read_Write_required", "the master must have MS2";
        c2_max_count_channels: u32 = "C2_Max_Count_Channels", "connections over MS2 at one time";
        max_initiate_pdu_length: u32 = "Max_Initiate_PDU_Length", "longest Initiate";
        diagnostic_alarm_supp: bool = "Diagnostic_Alarm_supp", "sends diagnostic alarms";
        process_alarm_supp: bool = "Process_Alarm_supp", "sends process alarms";
        pull_plug_alarm_supp: bool = "Pull_Plug_Alarm_supp", "sends alarms when a module is pulled or plugged";
        status_alarm_supp: bool = "Status_Alarm_supp", "sends status alarms";
        update_alarm_supp: bool = "Update_Alarm_supp", "sends update alarms";
        manufacturer_specific_alarm_supp: bool = "Manufacturer_Specific_Alarm_supp", "sends alarms of the vendor";
        diagnostic_alarm_required: bool = "Diagnostic_Alarm_required", "the master must enable diagnostic alarms";
        process_alarm_required: bool = "Process_Alarm_required", "the master must enable process alarms";
        pull_plug_alarm_required: bool = "Pull_Plug_Alarm_required", "the master must enable pull and plug alarms";
        status_alarm_required: bool = "Status_Alarm_required", "the master must enable status alarms";
        update_alarm_required: bool = "Update_Alarm_required", "the master must enable update alarms";
        manufacturer_specific_alarm_required: bool = "Manufacturer_Specific_Alarm_required", "the master must enable alarms of the vendor";
        extra_alarm_sap_supp: bool = "Extra_Alarm_SAP_supp", "acknowledges alarms over SAP 50";
        alarm_sequence_mode_count: u32 = "Alarm_Sequence_Mode_Count", "alarms at one time in sequence mode";
        alarm_type_mode_supp: bool = "Alarm_Type_Mode_supp", "one alarm of each type";
        dpv1_data_types: bool = "DPV1_Data_Types", "octets behind an identifier are data types";
        wd_base_1ms_supp: bool = "WD_Base_1ms_supp", "watchdog in 1 ms";
        check_cfg_mode: bool = "Check_Cfg_Mode", "another configuration can be accepted";
        publisher_supp: bool = "Publisher_supp", "publishes its inputs to other slaves";
        subscriber_supp: bool = "Subscriber_supp", "reads inputs of other slaves";
        isochron_mode_supp: u32 = "Isochron_Mode_supp", "works in step with the bus cycle";
        isochron_mode_required: bool = "Isochron_Mode_required", "works only in step with the bus cycle";
        tbase_dp: u32 = "TBASE_DP", "unit of the bus cycle, in 1/12 us";
        tdp_min: u32 = "TDP_MIN", "shortest bus cycle, in TBASE_DP";
        tdp_max: u32 = "TDP_MAX", "longest bus cycle, in TBASE_DP";
        t_pll_w_max: u32 = "T_PLL_W_MAX", "greatest jitter of the clock, in 1/12 us";
        tbase_io: u32 = "TBASE_IO", "unit of TI and TO, in 1/12 us";
        ti_min: u32 = "TI_MIN", "shortest time from sampling to the cycle, in TBASE_IO";
        to_min: u32 = "TO_MIN", "shortest time from the cycle to outputs, in TBASE_IO";
        prm_block_structure_supp: bool = "Prm_Block_Structure_supp", "user parameters can be blocks";
        prm_block_structure_req: bool = "Prm_Block_Structure_req", "user parameters must be blocks";
        prmcmd_supp: bool = "PrmCmd_supp", "understands PrmCmd";
        slave_max_switch_over_time: u32 = "Slave_Max_Switch_Over_Time", "longest time to switch over, in 10 ms";
        ident_maintenance_supp: bool = "Ident_Maintenance_supp", "has the records of I&M";
    }
    UserPrm {
        user_prm_data_len: u32 = "User_Prm_Data_Len", "length of User_Prm_Data";
        max_user_prm_data_len: u32 = "Max_User_Prm_Data_Len", "greatest length of all user parameters, 0 to 237";
    }
}

impl General {
    /// The alarms that the slave can send.
    #[must_use]
    pub fn supported_alarms(&self) -> BTreeSet<Alarm> {
        let supported = |alarm: &Alarm| match alarm {
            Alarm::Diagnostic => self.diagnostic_alarm_supp,
            Alarm::Process => self.process_alarm_supp,
            Alarm::PullPlug => self.pull_plug_alarm_supp,
            Alarm::Status => self.status_alarm_supp,
            Alarm::Update => self.update_alarm_supp,
            Alarm::Manufacturer => self.manufacturer_specific_alarm_supp,
        };
        Alarm::ALL.into_iter().filter(|alarm| supported(alarm) == Some(true)).collect()
    }

    /// The alarms that the master must enable.
    #[must_use]
    pub fn required_alarms(&self) -> BTreeSet<Alarm> {
        let required = |alarm: &Alarm| match alarm {
            Alarm::Diagnostic => self.diagnostic_alarm_required,
            Alarm::Process => self.process_alarm_required,
            Alarm::PullPlug => self.pull_plug_alarm_required,
            Alarm::Status => self.status_alarm_required,
            Alarm::Update => self.update_alarm_required,
            Alarm::Manufacturer => self.manufacturer_specific_alarm_required,
        };
        Alarm::ALL.into_iter().filter(|alarm| required(alarm) == Some(true)).collect()
    }
}

/// The baud rates as keywords write them, in the order of a [`Device`](crate::Device).
pub const RATES: [&str; 11] = ["9.6", "19.2", "31.25", "45.45", "93.75", "187.5", "500", "1.5M", "3M", "6M", "12M"];

/// What a file says about a baud rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rate {
    /// As keywords write it, one of [`RATES`].
    pub name: &'static str,
    /// Whether the slave has the rate.
    pub supported: Option<bool>,
    /// The longest time to an answer, in bit times.
    pub max_tsdr: Option<u32>,
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name.strip_suffix('M') {
            Some(number) => write!(f, "{number} Mbit/s"),
            None => write!(f, "{} kbit/s", self.name),
        }
    }
}

/// The slave does not have a baud rate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RateError {
    /// The rate in bit/s.
    pub bits_per_second: u32,
    /// The rates that the file lists.
    pub possible: String,
}

impl fmt::Display for RateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kilobits = f64::from(self.bits_per_second) / 1e3;
        let (number, unit) = if kilobits < 1e3 { (kilobits, "kbit/s") } else { (kilobits / 1e3, "Mbit/s") };
        write!(f, "the GSD file does not have {number} {unit}; it has {}", self.possible)
    }
}

impl std::error::Error for RateError {}

impl Rate {
    /// The rate in bit/s.
    #[must_use]
    pub fn bits_per_second(&self) -> Option<u32> {
        let (number, factor) = self.name.strip_suffix('M').map_or((self.name, 1_000), |number| (number, 1_000_000_u64));
        let (whole, part) = number.split_once('.').unwrap_or((number, "0"));
        let part = format!("{part:0<6}").parse::<u64>().ok()?.checked_mul(factor)?.checked_div(1_000_000)?;
        whole.parse::<u64>().ok()?.checked_mul(factor)?.checked_add(part)?.try_into().ok()
    }
}

/// Takes a keyword of a baud rate. None if it is no such keyword; true if it had a value before.
pub(crate) fn read_rate(rates: &mut Vec<Rate>, statement: &Statement<'_>) -> Option<Result<bool, Fault>> {
    let keyword = statement.keyword.as_str();
    let supported = keyword.strip_suffix("_supp");
    let rate = supported.or_else(|| keyword.strip_prefix("maxtsdr_"))?;
    let place = RATES.iter().position(|name| name.eq_ignore_ascii_case(rate))?;
    let value = match statement.values.number::<u32>() {
        Ok(value) => value,
        Err(fault) => return Some(Err(fault)),
    };
    let name = RATES.get(place).copied()?;
    let before = |one: &Rate| RATES.iter().position(|name| *name == one.name) < Some(place);
    let at = rates.iter().position(|one| !before(one)).unwrap_or(rates.len());
    if rates.get(at).is_none_or(|one| one.name != name) {
        rates.insert(at, Rate { name, ..Rate::default() });
    }
    let entry = rates.get_mut(at)?;
    Some(Ok(match supported {
        Some(_) => entry.supported.replace(value != 0).is_some(),
        None => entry.max_tsdr.replace(value).is_some(),
    }))
}
