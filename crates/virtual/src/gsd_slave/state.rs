//! The state of a virtual slave by its GSD file, for `state ADDR`.

use super::GsdStation;
use super::plan::octets_of;
use profivac_client::values::hex;
use profivac_gsd_slave::Direction;
use serde::Serialize;

/// The state, in the order of its keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SlaveState {
    /// The station address at which the slave answers; Set_Slave_Add may have changed it.
    pub address: u8,
    /// Vendor and model.
    pub model: String,
    /// Ident_Number, as `0x1234`.
    pub ident: String,
    /// Whether it has power.
    pub power: bool,
    /// `WAIT-PRM`, `WAIT-CFG` or `DATA-EXCH`.
    pub state: String,
    /// The master that owns it.
    pub master: Option<u8>,
    /// No master sets the outputs: Clear, watchdog, or no exchange.
    pub outputs_safe: bool,
    /// The modules by slot.
    pub modules: Vec<ModuleState>,
    /// The parameters that the master has set, by name.
    pub parameters: Vec<ParameterState>,
    /// The octets of the user parameters.
    pub user_prm: String,
    /// The octets of the diagnosis behind the first six.
    pub diagnosis: String,
    /// The diagnosis in the file's words.
    pub diagnosis_texts: Vec<String>,
    /// The alarms that wait for the acknowledgement of the master.
    pub alarms: Vec<AlarmState>,
    /// The DP-V1 records.
    pub records: Vec<RecordState>,
    /// Why the slave refused Set_Prm or Chk_Cfg last; `None` since it has accepted both.
    pub refused: Option<String>,
}

/// A module in its slot.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ModuleState {
    /// The slot.
    pub slot: u32,
    /// The number of the module in the file.
    pub module: u32,
    /// Its name.
    pub name: String,
    /// The inputs, as hexadecimal octets.
    pub inputs: String,
    /// The outputs, as hexadecimal octets.
    pub outputs: String,
}

/// A parameter with its value.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ParameterState {
    /// `the station` or `slot 3`.
    pub place: String,
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: i64,
    /// The file's text for the value.
    pub text: Option<String>,
}

/// An alarm that waits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AlarmState {
    /// The slot; 0 is the station.
    pub slot: u8,
    /// Type, slot, sequence number and change in words.
    pub text: String,
    /// The sequence number, 0 to 31.
    pub sequence: u8,
    /// The master has fetched it with the diagnosis.
    pub fetched: bool,
}

/// A DP-V1 record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RecordState {
    /// The slot.
    pub slot: u8,
    /// The index.
    pub index: u8,
    /// The octets, hexadecimal.
    pub octets: String,
}

impl GsdStation {
    /// The state.
    #[must_use]
    pub fn state(&self) -> SlaveState {
        let device = self.slave.device();
        let plan = &device.plan;
        let modules = plan.modules().iter().map(|one| ModuleState {
            slot: one.slot,
            module: one.number,
            name: one.name.clone(),
            inputs: hex(device.input_octets(octets_of(one, Direction::Input))),
            outputs: hex(device.output_octets(octets_of(one, Direction::Output))),
        });
        let parameters = plan.parameters(&device.prm).into_iter().map(|one| ParameterState {
            place: one.place.to_string(),
            name: one.name,
            value: one.value,
            text: one.text,
        });
        let alarms = device.alarms().iter().map(|alarm| AlarmState {
            slot: alarm.slot,
            text: alarm.words(),
            sequence: alarm.specifier.seq_nr(),
            fetched: alarm.fetched,
        });
        let records = device.records.iter();
        SlaveState {
            address: self.station_address(),
            model: plan.name.clone(),
            ident: format!("0x{:04X}", plan.slave.ident()),
            power: self.powered,
            state: self.slave.state().to_string(),
            master: self.slave.state().owner().map(|owner| owner.master),
            outputs_safe: device.outputs_safe,
            modules: modules.collect(),
            parameters: parameters.collect(),
            user_prm: hex(&device.prm),
            diagnosis: hex(device.blocks()),
            diagnosis_texts: device.reported().texts(plan),
            alarms: alarms.collect(),
            records: records.map(|((slot, index), octets)| RecordState { slot, index, octets: hex(octets) }).collect(),
            refused: device.refusal.clone(),
        }
    }

    /// The outputs of a slot; empty if it has none. `None` if there is no module in it.
    #[must_use]
    pub fn outputs_of(&self, slot: u32) -> Option<&[u8]> {
        let device = self.slave.device();
        let one = device.plan.slave.layout().in_slot(slot)?;
        Some(device.output_octets(octets_of(one, Direction::Output)))
    }
}
