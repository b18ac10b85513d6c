//! The alarms of a virtual slave that wait for the acknowledgement of the master. profibus-wire 4.5.

use super::{GsdStation, Refused};
use profivac_dp::slave::Device;
use profivac_gsd::Alarm;
use profivac_wire::acyclic::AlarmAck;
use profivac_wire::ext_diag::{Message, MessageKind, Specifier, SpecifierChange};
use profivac_wire::prm::{Dpv1Status2, Dpv1Status3};
use std::collections::BTreeSet;

/// The words of Alarm_Type. profibus-wire 2.3.2.
pub(super) const TYPES: [(&str, u8); 6] =
    [("diagnostic", 1), ("process", 2), ("pull", 3), ("plug", 4), ("status", 5), ("update", 6)];

/// Alarm_Type of the manufacturer. profibus-wire 2.3.2.
pub(super) const MANUFACTURER: std::ops::RangeInclusive<u32> = 32..=126;

/// The most octets behind type, slot and specifier. profibus-wire 2.3.2.
const MAX_DATA: usize = 59;

/// The header octet, type, slot and specifier.
const HEADER: usize = 4;

/// The number of alarms by Alarm_Mode; 0 is type mode. profibus-wire 2.4.
const SEQUENCE_MODE: [usize; 8] = [0, 2, 4, 8, 12, 16, 24, 32];

/// The sequence numbers. profibus-wire 2.3.2.
const SEQUENCE_NUMBERS: u8 = 32;

/// An alarm, as an order raises it.
#[derive(Clone, Copy)]
pub(super) struct NewAlarm<'a> {
    pub(super) slot: u8,
    pub(super) alarm_type: u8,
    pub(super) change: SpecifierChange,
    pub(super) data: &'a [u8],
}

/// How many alarms may wait at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Limit {
    /// Type mode.
    OneOfEachType,
    /// Sequence mode.
    Total(usize),
}

/// An alarm without its acknowledgement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Waiting {
    pub(super) slot: u8,
    pub(super) alarm_type: u8,
    pub(super) specifier: Specifier,
    pub(super) data: Vec<u8>,
    /// The master has fetched it.
    pub(super) fetched: bool,
}

/// The alarms that wait, in the order in which they were raised.
#[derive(Clone, Debug, Default)]
pub(super) struct Alarms {
    waiting: Vec<Waiting>,
    next_number: u8,
    /// The sequence number of the alarm that the master has fetched last.
    last_fetched: Option<u8>,
    notices: Vec<String>,
}

impl Waiting {
    /// The device-related block of the diagnosis.
    pub(super) fn block(&self) -> Vec<u8> {
        let length = u8::try_from(HEADER.saturating_add(self.data.len())).unwrap_or(u8::MAX);
        [&[length, self.alarm_type, self.slot, self.specifier.0][..], &self.data].concat()
    }

    fn is_acknowledged_by(&self, alarm: AlarmAck) -> bool {
        let number = Specifier(alarm.specifier).seq_nr();
        self.fetched && (self.slot, self.alarm_type, self.specifier.seq_nr()) == (alarm.slot, alarm.alarm_type, number)
    }

    pub(super) fn words(&self) -> String {
        let (kind, slot) = (MessageKind::Alarm(self.alarm_type), self.slot);
        Message { kind, slot, specifier: self.specifier, data: &self.data }.to_string()
    }
}

impl Alarms {
    pub(super) fn iter(&self) -> impl Iterator<Item = &Waiting> {
        self.waiting.iter()
    }

    /// The alarm in the diagnosis: each is in one of its own. chosen: the one that was fetched last stays there until it is acknowledged
    /// or the next one takes its place; it never comes back, because the master may be about to acknowledge it.
    pub(super) fn shown(&self) -> Option<&Waiting> {
        let is_last = |alarm: &&Waiting| self.last_fetched == Some(alarm.specifier.seq_nr());
        self.waiting.iter().find(|alarm| !alarm.fetched).or_else(|| self.waiting.iter().find(is_last))
    }

    /// The longest block that waits.
    pub(super) fn longest(&self) -> usize {
        self.waiting.iter().map(|alarm| HEADER.saturating_add(alarm.data.len())).max().unwrap_or(0)
    }

    pub(super) fn fetched(&mut self) {
        if let Some(alarm) = self.waiting.iter_mut().find(|alarm| !alarm.fetched) {
            alarm.fetched = true;
            self.last_fetched = Some(alarm.specifier.seq_nr());
        }
    }

    pub(super) fn acknowledge(&mut self, alarm: AlarmAck) -> bool {
        let Some(place) = self.waiting.iter().position(|waiting| waiting.is_acknowledged_by(alarm)) else {
            return false;
        };
        let acknowledged = self.waiting.remove(place);
        self.notices.push(format!("the master acknowledged the {}", acknowledged.words()));
        true
    }

    /// Data exchange begins or has ended. Waiting alarms are discarded, profibus-wire 4.5.
    pub(super) fn discard(&mut self) {
        let lost = self.waiting.drain(..);
        self.notices.extend(lost.map(|alarm| format!("discarded with the data exchange: the {}", alarm.words())));
        (self.next_number, self.last_fetched) = (0, None);
    }

    pub(super) const fn has_notices(&self) -> bool {
        !self.notices.is_empty()
    }

    pub(super) fn take_notices(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notices)
    }

    /// Adds an alarm with the next sequence number that no waiting alarm has, and returns it in words.
    ///
    /// # Errors
    /// A sentence: too many wait.
    fn add(&mut self, new: NewAlarm<'_>, limit: Limit) -> Result<String, String> {
        let is_of_type = |waiting: &&Waiting| kind_of(waiting.alarm_type) == kind_of(new.alarm_type);
        match (limit, self.waiting.iter().find(is_of_type)) {
            (Limit::OneOfEachType, Some(waiting)) => {
                return Err(format!(
                    "the {} waits for the acknowledgement of the master, and in type mode (Alarm_Mode 0) one alarm of each type does",
                    waiting.words()
                ));
            }
            (Limit::Total(most), _) if self.waiting.len() >= most => {
                return Err(format!(
                    "{most} alarms wait for the acknowledgement of the master, as many as may wait at a time"
                ));
            }
            _ => {}
        }
        let is_free = |number: &u8| !self.waiting.iter().any(|waiting| waiting.specifier.seq_nr() == *number);
        let numbers = (self.next_number..SEQUENCE_NUMBERS).chain(0..self.next_number);
        let number = numbers.into_iter().find(is_free).unwrap_or_default();
        self.next_number = number.saturating_add(1) % SEQUENCE_NUMBERS;
        let waiting = Waiting {
            slot: new.slot,
            alarm_type: new.alarm_type,
            specifier: Specifier::new(number, new.change),
            data: new.data.to_vec(),
            fetched: false,
        };
        let words = waiting.words();
        self.waiting.push(waiting);
        Ok(words)
    }
}

/// The keyword of a GSD file and the bit of Set_Prm that belong to Alarm_Type.
const fn kind_of(alarm_type: u8) -> Alarm {
    match alarm_type {
        1 => Alarm::Diagnostic,
        2 => Alarm::Process,
        3 | 4 => Alarm::PullPlug,
        5 => Alarm::Status,
        6 => Alarm::Update,
        _ => Alarm::Manufacturer,
    }
}

impl GsdStation {
    /// Raises an alarm, if the file, the parameters of the master and the alarms that wait allow it. profibus-wire 4.5.
    ///
    /// # Errors
    /// [`Refused`] says what is missing.
    pub(super) fn raise_alarm(&mut self, new: NewAlarm<'_>) -> Result<String, Refused> {
        let kind = kind_of(new.alarm_type);
        self.check_file_has(kind, new.slot)?;
        let limit = self.limit_of_the_master(kind)?;
        if new.data.len() > MAX_DATA {
            return Err(Refused(format!("expected at most {MAX_DATA} octets, got {}", new.data.len())));
        }
        let device = self.slave.device();
        device.check_room(device.reported(), HEADER.saturating_add(new.data.len()))?;
        Ok(self.slave.device_mut().change_alarms(|alarms| alarms.add(new, limit))?)
    }

    fn check_file_has(&self, kind: Alarm, slot: u8) -> Result<(), Refused> {
        let device = self.plan().device();
        let module = if slot == 0 { None } else { device.module(self.plan().slot(slot.into())?.number) };
        let of_module = module.map(|module| module.alarms.supported.clone()).unwrap_or_default();
        let supported: BTreeSet<_> = device.general.supported_alarms().into_iter().chain(of_module).collect();
        if supported.contains(&kind) {
            return Ok(());
        }
        let possible: Vec<_> = supported.iter().map(ToString::to_string).collect();
        let possible = if possible.is_empty() { "none".to_owned() } else { possible.join(", ") };
        Err(Refused(format!(
            "the file has no {}_supp for slot {slot}; alarms of this slot: {possible}",
            kind.keyword()
        )))
    }

    /// How many alarms the master lets wait.
    ///
    /// chosen: the lower one of Alarm_Mode and Alarm_Sequence_Mode_Count; type mode if the file has no sequence mode.
    fn limit_of_the_master(&self, kind: Alarm) -> Result<Limit, Refused> {
        let owner = self.slave.state().owner().filter(|_| self.is_exchanging());
        let Some(owner) = owner else {
            return Err(Refused(
                "no master exchanges data with the slave, and an alarm needs its acknowledgement".into(),
            ));
        };
        let device = self.slave.device();
        if !owner.dpv1 || !device.features().ms1 {
            return Err(Refused(
                "alarms are acknowledged over MS1: the master must set DPV1_Enable in Set_Prm, and the file have \
                 C1_Read_Write_supp"
                    .into(),
            ));
        }
        let octet = |at: usize| device.prm.get(at).copied().unwrap_or(0);
        if !Dpv1Status2::from_bits_retain(octet(1)).contains(kind.enable_bit()) {
            let bit = kind.enable_bit().bits().trailing_zeros();
            return Err(Refused(format!(
                "the master has not enabled {kind}: bit {bit} of DPV1_Status_2 in Set_Prm is 0"
            )));
        }
        let mode = Dpv1Status3::from_bits_retain(octet(2)) & Dpv1Status3::ALARM_MODE;
        let of_master = SEQUENCE_MODE.get(usize::from(mode.bits())).copied().unwrap_or(0);
        let of_file = device.plan.device().general.alarm_sequence_mode_count.unwrap_or(0);
        match of_master.min(usize::try_from(of_file).unwrap_or(usize::MAX)) {
            0 => Ok(Limit::OneOfEachType),
            most => Ok(Limit::Total(most)),
        }
    }

    /// What became of alarms since the last call: acknowledged, or discarded because the data exchange ended.
    pub fn take_alarm_notices(&mut self) -> Vec<String> {
        // Whoever takes the device mutably drops the prepared answer.
        if !self.slave.device().alarms().has_notices() {
            return Vec::new();
        }
        self.slave.device_mut().take_alarm_notices()
    }
}
