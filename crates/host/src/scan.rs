//! Finds the stations of a bus: one address after the other, with FDL status and Slave_Diag only.

use crate::session::{BusSession, Reply, SessionError};
use profivac_dp::link::active::Failure;
use profivac_dp::master::services;
use profivac_wire::control::StationType;
use profivac_wire::diag::{NO_MASTER, SlaveDiag, StationStatus};

/// A station that answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundStation {
    /// Its address.
    pub address: u8,
    /// Its type.
    pub station_type: StationType,
    /// The fixed part of its diagnosis, if it is a slave that sent one.
    pub slave: Option<SlaveStatus>,
}

/// The fixed part of a diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlaveStatus {
    /// Ident_Number.
    pub ident: u16,
    /// Station_Status.
    pub status: StationStatus,
    /// The owner: the master that parameterised the slave.
    pub owner: Option<u8>,
}

impl SlaveStatus {
    /// Parses a Slave_Diag data unit. `None` when it is too short.
    #[must_use]
    pub fn parse(du: &[u8]) -> Option<Self> {
        let diag = SlaveDiag::parse(du).ok()?;
        let owner = Some(diag.master_add).filter(|master| *master != NO_MASTER);
        Some(Self { ident: diag.ident, status: diag.status, owner })
    }

    /// The state of the slave as text.
    #[must_use]
    pub fn state_text(&self) -> String {
        let words: Vec<_> =
            STATES.into_iter().filter(|(bit, _)| self.status.contains(*bit)).map(|(_, word)| word).collect();
        if words.is_empty() { "exchanges data".to_owned() } else { words.join(", ") }
    }
}

/// The bits of Station_Status that explain why a slave exchanges no data or reports a fault, in the order of importance.
/// profibus-wire 2.3
const STATES: [(StationStatus, &str); 6] = [
    (StationStatus::PRM_FAULT, "refused its parameters"),
    (StationStatus::CFG_FAULT, "refused its configuration"),
    (StationStatus::PRM_REQ, "waits for parameters"),
    (StationStatus::STATION_NOT_READY, "not ready"),
    (StationStatus::STAT_DIAG, "no valid data yet"),
    (StationStatus::EXT_DIAG, "reports a fault"),
];

/// Sends FDL status to `address`, and Slave_Diag if the answer is that of a slave. `None` if no station answers.
///
/// # Errors
/// [`SessionError`].
pub fn probe(session: &mut BusSession, address: u8) -> Result<Option<FoundStation>, SessionError> {
    let station = match session.request(&services::fdl_status(address))? {
        Reply::Answer { station, .. } => station,
        Reply::NoAnswer(Failure::Silence | Failure::Impossible) => return Ok(None),
        // A station is present: repeat the request.
        Reply::NoAnswer(_) => match session.request(&services::fdl_status(address))? {
            Reply::Answer { station, .. } => station,
            Reply::NoAnswer(_) => return Ok(None),
        },
    };
    let slave = if station == StationType::Slave { read_diagnosis(session, address)? } else { None };
    Ok(Some(FoundStation { address, station_type: station, slave }))
}

/// Requests of [`probe_all`] to an address that stays silent. FDL status is not repeated at link level, so one lost octet would
/// hide a station. chosen: `max_retry_limit` of the usual bus parameters has one repetition too.
const PASSES: u32 = 2;

/// Asks all of `addresses` with [`probe`] and adds the stations to `found`, also if the line is lost meanwhile. Silent addresses are asked
/// a second time, and again if an answer came after the slot time, which the session has raised by then.
///
/// # Errors
/// [`SessionError`].
pub fn probe_all(
    session: &mut BusSession,
    addresses: impl IntoIterator<Item = u8>,
    found: &mut Vec<FoundStation>,
) -> Result<(), SessionError> {
    let done = ask_until_silent(session, addresses.into_iter().collect(), found);
    found.sort_by_key(|station| station.address);
    done
}

/// Ends because the slot time has a maximum.
fn ask_until_silent(
    session: &mut BusSession,
    mut addresses: Vec<u8>,
    found: &mut Vec<FoundStation>,
) -> Result<(), SessionError> {
    let mut passes: u32 = 0;
    loop {
        let before = session.timing().slot_time;
        let mut silent = Vec::new();
        for address in addresses {
            match probe(session, address)? {
                Some(station) => found.push(station),
                None => silent.push(address),
            }
        }
        passes = passes.saturating_add(1);
        let has_raised = session.timing().slot_time > before;
        if silent.is_empty() || (passes >= PASSES && !has_raised) {
            return Ok(());
        }
        addresses = silent;
    }
}

/// Slave_Diag, at most twice: the first request to a slave is not repeated at link level. Answers that arrive damaged do not count
/// at first: a loaded computer delivers long answers late, and the station is present.
fn read_diagnosis(session: &mut BusSession, address: u8) -> Result<Option<SlaveStatus>, SessionError> {
    let mut left = 2;
    for _ in 0..=MAX_DAMAGED {
        match session.request(&services::slave_diag(address))? {
            Reply::Answer { du, .. } => return Ok(SlaveStatus::parse(&du)),
            Reply::NoAnswer(Failure::Damaged) => {}
            Reply::NoAnswer(_) => left -= 1,
        }
        if left == 0 {
            break;
        }
    }
    Ok(None)
}

/// The most damaged answers to Slave_Diag. chosen.
const MAX_DAMAGED: usize = 5;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_state_of_a_slave_is_its_diagnosis_as_text() {
        for (du, state, owner) in [
            ([0x02, 0x05, 0x00, 0xFF, 0x08, 0xE6], "waits for parameters, not ready", None),
            ([0x42, 0x05, 0x00, 0xFF, 0x08, 0xE6], "refused its parameters, waits for parameters, not ready", None),
            ([0x02, 0x0C, 0x00, 0x02, 0x08, 0xE6], "not ready", Some(2)),
            ([0x00, 0x0C, 0x00, 0x02, 0x08, 0xE6], "exchanges data", Some(2)),
            ([0x08, 0x0C, 0x00, 0x02, 0x08, 0xE6], "reports a fault", Some(2)),
        ] {
            let status = SlaveStatus::parse(&du).unwrap();
            assert_eq!((status.state_text().as_str(), status.owner, status.ident), (state, owner, 0x08E6), "{du:02X?}");
        }
        assert_eq!(SlaveStatus::parse(&[0x02, 0x05]), None);
    }
}
