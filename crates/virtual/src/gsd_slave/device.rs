//! The device behind a virtual slave: what a GSD file says, with inputs, outputs, diagnosis and records.

use super::alarms::Alarms;
use super::diagnosis::Reported;
use super::plan::{MAX_RECORD, Plan};
use super::records::Records;
use profivac_client::values::hex;
use profivac_dp::link::Baud;
use profivac_dp::slave::{CfgFault, Device, Diagnosis, Dpv1Error, Features, Outputs, PrmFault, Relation};
use profivac_wire::acyclic::call::IM_RECORD_LENGTH;
use profivac_wire::acyclic::{AlarmAck, ErrorCode, Im0};
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::cfg::Lengths;
use std::ops::Range;

/// The longest part of an order number in I&M0. profibus-wire 5.3.
const ORDER_ID: usize = 20;

/// The I&M version 1.1. profibus-wire 5.3.
const IM_VERSION: [u8; 2] = [1, 1];

/// The device of a virtual slave.
pub(super) struct GsdDevice {
    pub(super) plan: Plan,
    inputs: Vec<u8>,
    outputs: Vec<u8>,
    pub(super) outputs_safe: bool,
    /// The user parameters that the slave has accepted last.
    pub(super) prm: Vec<u8>,
    reported: Reported,
    alarms: Alarms,
    /// Ext_Diag_Data: the alarm that is shown, and what is reported.
    blocks: Vec<u8>,
    blocks_changed: bool,
    pub(super) records: Records,
    /// Why the slave refused the parameters or the configuration last; `None` since it has accepted both.
    pub(super) refusal: Option<String>,
    /// The refusal has not been taken yet.
    refusal_is_new: bool,
}

impl GsdDevice {
    pub(super) fn new(plan: Plan, records: Records) -> Self {
        Self {
            inputs: vec![0; plan.slave.lengths().inputs.into()],
            outputs: vec![0; plan.slave.lengths().outputs.into()],
            outputs_safe: true,
            prm: Vec::new(),
            reported: Reported::nothing(&plan),
            alarms: Alarms::default(),
            blocks: Vec::new(),
            blocks_changed: false,
            records,
            refusal: None,
            refusal_is_new: false,
            plan,
        }
    }

    pub(super) fn input_octets(&self, range: Range<usize>) -> &[u8] {
        self.inputs.get(range).unwrap_or_default()
    }

    pub(super) fn input_octets_mut(&mut self, range: Range<usize>) -> &mut [u8] {
        self.inputs.get_mut(range).unwrap_or_default()
    }

    pub(super) fn output_octets(&self, range: Range<usize>) -> &[u8] {
        self.outputs.get(range).unwrap_or_default()
    }

    pub(super) const fn reported(&self) -> &Reported {
        &self.reported
    }

    /// # Errors
    /// A sentence: there is no room for it beside an alarm.
    pub(super) fn report(&mut self, reported: Reported) -> Result<(), String> {
        self.check_room(&reported, 0)?;
        self.reported = reported;
        self.compose();
        Ok(())
    }

    pub(super) const fn alarms(&self) -> &Alarms {
        &self.alarms
    }

    pub(super) fn change_alarms<T>(&mut self, change: impl FnOnce(&mut Alarms) -> T) -> T {
        let changed = change(&mut self.alarms);
        self.compose();
        changed
    }

    pub(super) fn take_alarm_notices(&mut self) -> Vec<String> {
        self.alarms.take_notices()
    }

    /// Ext_Diag_Data.
    pub(super) fn blocks(&self) -> &[u8] {
        &self.blocks
    }

    fn compose(&mut self) {
        let alarm = self.alarms.shown().map(|alarm| alarm.block()).unwrap_or_default();
        let blocks = [&alarm[..], self.reported.blocks()].concat();
        self.blocks_changed |= blocks != self.blocks;
        self.blocks = blocks;
    }

    /// Whether a report, and any alarm beside it that waits or has this length, fit the diagnosis.
    ///
    /// # Errors
    /// A sentence with the lengths.
    pub(super) fn check_room(&self, reported: &Reported, alarm: usize) -> Result<(), String> {
        let (alarm, most) = (self.alarms.longest().max(alarm), self.plan.max_ext_diag());
        let octets = reported.blocks().len().saturating_add(alarm);
        if octets <= most || alarm == 0 {
            return Ok(());
        }
        Err(format!(
            "{octets} octets of diagnosis behind the first six, {alarm} of them of an alarm, and the file allows {most}; \
             end another report first"
        ))
    }

    pub(super) const fn has_new_refusal(&self) -> bool {
        self.refusal_is_new
    }

    /// The refusal, if it was not taken before. A master that repeats a wrong request causes one.
    pub(super) fn take_refusal(&mut self) -> Option<&str> {
        let is_new = std::mem::take(&mut self.refusal_is_new);
        self.refusal.as_deref().filter(|_| is_new)
    }

    fn refuse(&mut self, refusal: String) {
        self.refusal_is_new |= self.refusal.as_deref() != Some(&refusal);
        self.refusal = Some(refusal);
    }

    /// The refusal of an access to a record that does not exist. Slot 0 is the station.
    fn no_record(&self, slot: u8) -> Dpv1Error {
        let is_plugged = slot == 0 || self.plan.modules().iter().any(|one| one.slot == slot.into());
        let has_records = self.records.iter().any(|((of, _), _)| of == slot);
        if is_plugged || has_records { Dpv1Error::INVALID_INDEX } else { Dpv1Error::INVALID_SLOT }
    }

    /// The longest record through a relation.
    fn max_record(&self, via: Relation) -> usize {
        let general = &self.plan.device().general;
        let most = match via {
            Relation::Ms1 => general.c1_max_data_len,
            Relation::Ms2(_) => general.c2_max_data_len,
        };
        most.and_then(|most| usize::try_from(most).ok()).unwrap_or(MAX_RECORD).min(MAX_RECORD)
    }
}

impl Device for GsdDevice {
    fn ident_number(&self) -> u16 {
        self.plan.slave.ident()
    }

    fn features(&self) -> Features {
        let general = &self.plan.device().general;
        let has = |feature: Option<bool>| feature == Some(true);
        let dpv1 = self.plan.slave.is_dpv1();
        Features {
            sync: has(general.sync_mode_supp),
            freeze: has(general.freeze_mode_supp),
            dpv1,
            ms1: dpv1 && has(general.c1_read_write_supp),
        }
    }

    fn has_ms2(&self) -> bool {
        self.plan.device().general.c2_read_write_supp == Some(true)
    }

    /// A DP-V1 master says it in Set_Prm.
    fn is_fail_safe(&self) -> bool {
        !self.plan.slave.is_dpv1() && self.plan.device().general.fail_safe == Some(true)
    }

    fn max_tsdr_tbit(&self, baud: Baud) -> u16 {
        self.plan.max_tsdr_tbit(baud)
    }

    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault> {
        match self.plan.check_prm(user) {
            Ok(()) => {
                self.prm = user.to_vec();
                Ok(())
            }
            Err(reason) => {
                self.refuse(format!("Set_Prm: {reason}"));
                Err(PrmFault)
            }
        }
    }

    /// chosen: exactly the identifiers of the plugged modules, as a modular slave compares them with what it finds in its slots.
    fn chk_cfg(&mut self, cfg: &[u8]) -> Result<Lengths, CfgFault> {
        if cfg != self.plan.slave.chk_cfg() {
            self.refuse(format!("Chk_Cfg: expected {}, got {}", hex(self.plan.slave.chk_cfg()), hex(cfg)));
            return Err(CfgFault);
        }
        self.refusal = None;
        Ok(self.plan.slave.lengths())
    }

    fn get_cfg(&self) -> &[u8] {
        self.plan.slave.chk_cfg()
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        match outputs {
            Outputs::Safe => self.outputs.fill(0),
            Outputs::Data(octets) => self.outputs.iter_mut().zip(octets).for_each(|(octet, sent)| *octet = *sent),
        }
        self.outputs_safe = outputs == Outputs::Safe;
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        inputs.iter_mut().zip(&self.inputs).for_each(|(octet, own)| *octet = *own);
    }

    /// Only orders change inputs and diagnosis.
    fn keeps_inputs(&self, _before: &[u8], _outputs: &[u8]) -> bool {
        true
    }

    /// Ext_Diag does not follow the alarms: profibus-wire 10, point 30.
    fn diagnosis(&self) -> Diagnosis<'_> {
        Diagnosis { event: self.reported.is_event(), static_diag: false, blocks: &self.blocks }
    }

    fn take_diagnosis_change(&mut self) -> bool {
        std::mem::take(&mut self.blocks_changed)
    }

    fn set_exchanging(&mut self, _running: bool) {
        self.change_alarms(Alarms::discard);
    }

    fn diagnosis_fetched(&mut self) {
        self.change_alarms(Alarms::fetched);
    }

    fn acknowledge_alarm(&mut self, alarm: AlarmAck) -> bool {
        self.change_alarms(|alarms| alarms.acknowledge(alarm))
    }

    fn has_alarm_access_point(&self) -> bool {
        self.plan.device().general.extra_alarm_sap_supp == Some(true)
    }

    fn address_is_settable(&self) -> bool {
        self.plan.device().general.set_slave_add_supp == Some(true)
    }

    fn set_address(&mut self, request: &SetSlaveAdd<'_>) -> Option<u8> {
        let is_locked = self.records.address().is_some_and(|(_, is_locked)| is_locked);
        if is_locked {
            return None;
        }
        self.records.set_address(request.address, request.no_add_chg != 0).ok()?;
        Some(request.address)
    }

    fn read(&mut self, via: Relation, slot: u8, index: u8, record: &mut [u8]) -> Result<usize, Dpv1Error> {
        let octets = self.records.get(slot, index).ok_or_else(|| self.no_record(slot))?;
        let octets = octets.get(..self.max_record(via)).unwrap_or(octets);
        record.get_mut(..octets.len()).ok_or(Dpv1Error::TYPE_CONFLICT)?.copy_from_slice(octets);
        Ok(octets.len())
    }

    /// chosen: a master writes the records that exist, with any length that the file allows.
    fn write(&mut self, via: Relation, slot: u8, index: u8, record: &[u8]) -> Result<(), Dpv1Error> {
        if self.records.get(slot, index).is_none() {
            return Err(self.no_record(slot));
        }
        if record.len() > self.max_record(via) {
            return Err(Dpv1Error::WRITE_LENGTH);
        }
        self.records.set(slot, index, record).map_err(|_| Dpv1Error::new(ErrorCode::WRITE_ERROR))
    }

    /// chosen: the model as order number if the file has none, version V1.0.0, no serial number.
    fn im0(&self) -> Option<[u8; IM_RECORD_LENGTH]> {
        let general = &self.plan.device().general;
        general.ident_maintenance_supp.filter(|supported| *supported)?;
        let order = general.order_number.as_ref().or(general.model_name.as_ref());
        let order: Vec<u8> =
            order.into_iter().flat_map(|text| text.bytes()).filter(u8::is_ascii).take(ORDER_ID).collect();
        let im0 = Im0 {
            header: [b' '; 10],
            manufacturer_id: 0,
            order_id: &order,
            serial_number: b"",
            hardware_revision: 0,
            software_revision: [b'V', 1, 0, 0],
            rev_counter: 0,
            profile_id: 0,
            profile_specific_type: 0,
            im_version: IM_VERSION,
            im_supported: 0,
        };
        let mut record = [0; IM_RECORD_LENGTH];
        im0.emit(&mut record).ok().map(|_| record)
    }
}
