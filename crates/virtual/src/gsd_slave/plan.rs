//! What a GSD file and the plugged modules say about a slave, in the form that the simulation needs.

use profivac_dp::link::Baud;
use profivac_gsd::{Device, Parameter, Place};
use profivac_gsd_slave::{Direction, GsdSlave, PlacedModule};
use profivac_wire::prm::Dpv1Status1;
use std::collections::BTreeMap;
use std::ops::Range;

/// The fixed octets of a diagnosis. profibus-wire 2.3.
const DIAG_HEADER: usize = 6;

/// The longest record. profibus-wire 4.1.
pub(super) const MAX_RECORD: usize = 240;

/// The highest number of a channel error. profibus-wire 2.3.1.
pub(super) const MAX_ERROR: u8 = 31;

/// A slave as its file describes it, with its modules.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) slave: GsdSlave,
    /// Vendor and model.
    pub(super) name: String,
    parameters: Vec<PlannedParameter>,
}

/// A parameter with its place in the user parameters.
#[derive(Clone, Debug)]
struct PlannedParameter {
    place: Place,
    /// Its first octet in the user parameters.
    at: usize,
    parameter: Parameter,
    /// Its value in the octets of the file: another one than its default where a later definition covers it.
    usual: i64,
}

/// A parameter and its value in the user parameters of a master.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct NamedValue {
    pub(super) place: Place,
    pub(super) name: String,
    pub(super) value: i64,
    /// The file's text for the value.
    pub(super) text: Option<String>,
}

impl Plan {
    pub(super) fn new(slave: GsdSlave, name: String) -> Self {
        Self { name, parameters: parameters(&slave), slave }
    }

    pub(super) fn device(&self) -> &Device {
        self.slave.device()
    }

    /// The modules by slot.
    pub(super) fn modules(&self) -> &[PlacedModule] {
        &self.slave.layout().modules
    }

    /// The module in a slot.
    ///
    /// # Errors
    /// A sentence that lists the slots.
    pub(super) fn slot(&self, number: u32) -> Result<&PlacedModule, String> {
        self.slave.layout().in_slot(number).ok_or_else(|| {
            let known = self.modules().iter().map(|one| format!("{} ({})", one.slot, one.name)).collect::<Vec<_>>();
            format!("no module in slot {number}; there are {}", known.join(", "))
        })
    }

    /// The texts of the file for errors of the channels of a module, by number.
    pub(super) fn channel_texts(&self, module: &PlacedModule) -> BTreeMap<u8, String> {
        let configuration = self.slave.configuration();
        let text = |error| Some((error, configuration.channel_text(module.identifiers.start, error)?.to_owned()));
        (0..=MAX_ERROR).filter_map(text).collect()
    }

    /// The longest part of the diagnosis behind the six fixed octets.
    pub(super) fn max_ext_diag(&self) -> usize {
        usize::from(self.slave.max_diag_len()).saturating_sub(DIAG_HEADER)
    }

    /// The longest time until an answer at a rate, in bit times.
    pub(super) fn max_tsdr_tbit(&self, baud: Baud) -> u16 {
        let rate = self.device().rate(baud.bits_per_second());
        let tbit = rate.and_then(|rate| rate.max_tsdr).and_then(|tbit| u16::try_from(tbit).ok());
        tbit.unwrap_or(baud.max_tsdr_tbit())
    }

    /// Whether the slave runs at a rate. chosen: at every rate if the file lists none.
    ///
    /// # Errors
    /// A sentence with the rates of the file.
    pub(super) fn check_rate(&self, baud: Baud) -> Result<(), String> {
        self.device().check_rate(baud.bits_per_second()).map_err(|error| error.to_string())
    }

    /// Checks user parameters.
    ///
    /// chosen: the slave refuses another length than the modules need, and a value that the file does not allow. Real slaves differ:
    /// some ignore what they do not know. Constants of the file are not checked. The file's own octets are always accepted, because
    /// some files have defaults outside their limits.
    ///
    /// # Errors
    /// A sentence for the engineer who set up the master.
    pub(super) fn check_prm(&self, user: &[u8]) -> Result<(), String> {
        let required = self.device().general.fail_safe_required == Some(true) && self.slave.is_dpv1();
        let status = Dpv1Status1::from_bits_retain(user.first().copied().unwrap_or(0));
        // profibus-wire 2.4
        if required && !status.contains(Dpv1Status1::FAIL_SAFE) {
            return Err("expected Fail_Safe in the first DP-V1 octet: the file has Fail_Safe_required".to_owned());
        }
        if !self.is_complete(user) && !self.takes_short(user.len()) {
            let expected = self.slave.user_prm().len();
            let got = user.len();
            return Err(format!("expected {expected} octets of user parameters for the plugged modules, got {got}"));
        }
        let values = self.parameters.iter().filter(|_| self.is_complete(user));
        let mut wrong =
            values.filter_map(|one| one.value(user).filter(|value| !one.takes(*value)).map(|value| (one, value)));
        wrong.next().map_or(Ok(()), |(one, value)| {
            let possible = self.device().values_of(&one.parameter);
            Err(format!("{}: {} cannot be {value}; possible are {possible}", one.place, one.parameter.name))
        })
    }

    fn is_complete(&self, user: &[u8]) -> bool {
        user.len() == self.slave.user_prm().len()
    }

    /// chosen: User_Prm_Data alone, for masters that do not know Ext_User_Prm_Data; and no octets if the file has only the DP-V1 status.
    fn takes_short(&self, length: usize) -> bool {
        let plain = self.device().user_prm_data.as_ref().map_or(0, Vec::len);
        let is_status_only = self.slave.is_dpv1() && self.slave.user_prm().len() == 3;
        (plain > 0 && length == plain) || (is_status_only && length == 0)
    }

    /// The parameters in these user parameters; none if they are not complete.
    pub(super) fn parameters(&self, user: &[u8]) -> Vec<NamedValue> {
        let named = |one: &PlannedParameter| {
            let value = one.value(user)?;
            let text = self.device().text_of(&one.parameter, value).map(str::to_owned);
            Some(NamedValue { place: one.place, name: one.parameter.name.clone(), value, text })
        };
        self.parameters.iter().filter(|_| self.is_complete(user)).filter_map(named).collect()
    }
}

impl PlannedParameter {
    fn value(&self, user: &[u8]) -> Option<i64> {
        self.parameter.kind.get(user.get(self.at..)?)
    }

    fn takes(&self, value: i64) -> bool {
        self.parameter.allows(value) || value == self.usual
    }
}

/// The octets of a module in the image of a direction; empty if it has none.
pub(super) fn octets_of(module: &PlacedModule, direction: Direction) -> Range<usize> {
    module.data(direction).map_or(0..0, |data| data.start..data.start.saturating_add(data.octets))
}

fn parameters(slave: &GsdSlave) -> Vec<PlannedParameter> {
    let configuration = slave.configuration();
    let mut starts = BTreeMap::new();
    let mut at = 0_usize;
    for (place, octets) in configuration.user_prm_by_place() {
        starts.insert(place, at);
        at = at.saturating_add(octets.len());
    }
    let planned = configuration.parameters().into_iter().filter_map(|placed| {
        let at = starts.get(&placed.place)?.saturating_add(usize::from(placed.offset));
        let usual = placed.parameter.kind.get(slave.user_prm().get(at..)?)?;
        Some(PlannedParameter { place: placed.place, at, parameter: placed.parameter.clone(), usual })
    });
    planned.collect()
}
