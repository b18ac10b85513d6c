//! Gives a slave a new station address with Set_Slave_Add. profibus-wire 2.11.

use profivac_dp::link::active::Failure;
use profivac_dp::master::services;
use profivac_host::scan::{FoundStation, SlaveStatus, probe};
use profivac_host::session::{BusSession, Reply, SessionError};
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::control::Status;

/// No_Add_Chg, true.
const LOCKED: u8 = 0xFF;

/// The number of requests before an address counts as free. chosen: two answers in a row may be lost.
const ATTEMPTS: u8 = 3;

/// The reason why the address of a slave was not changed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AddressError {
    /// The bus session failed.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// No slave answers at the address.
    #[error("no slave answers at address {0}")]
    NoAnswer(u8),
    /// A station answers at the new address.
    #[error("address {0} is taken: a station answers there")]
    AddressInUse(u8),
    /// Another master owns the slave.
    #[error("the slave at address {address} belongs to master {master}; release it there first")]
    OwnedByOther {
        /// The address of the slave.
        address: u8,
        /// The owner.
        master: u8,
    },
    /// The slave refuses the service.
    #[error(
        "the slave at address {0} does not take an address over the bus: its address switch sets the address, or it does not have the service ({1:?})"
    )]
    ServiceClosed(u8, Status),
    /// The slave accepted the telegram and kept its address.
    #[error("the slave at address {0} kept its address: it is locked against changes, or its address switch sets it")]
    NotChanged(u8),
    /// No answer to the telegram arrived.
    #[error("the slave at address {address} did not answer: {failure}")]
    Unconfirmed {
        /// The old address.
        address: u8,
        /// The failure.
        failure: Failure,
    },
    /// The slave answers at neither address.
    #[error("the slave answers neither at address {from} nor at {to} now")]
    NotFound {
        /// The old address.
        from: u8,
        /// The new address.
        to: u8,
    },
}

/// Checks that no master owns the slave at `from`, and that no station answers at `to`. Returns the identity and the owner of the
/// slave. Changes nothing.
///
/// ```
/// # use profivac_client::{Bus, address};
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
/// let slave = address::check(bus.session(), 5, 20)?;
/// assert_eq!(slave.ident, 0x08E6);
/// assert!(matches!(address::check(bus.session(), 5, 5), Err(address::AddressError::AddressInUse(5))));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`AddressError`].
pub fn check(session: &mut BusSession, from: u8, to: u8) -> Result<SlaveStatus, AddressError> {
    if find(session, to)?.is_some() {
        return Err(AddressError::AddressInUse(to));
    }
    let slave = find(session, from)?.and_then(|station| station.slave).ok_or(AddressError::NoAnswer(from))?;
    match slave.owner {
        Some(master) => Err(AddressError::OwnedByOther { address: from, master }),
        None => Ok(slave),
    }
}

/// Probes an address several times: one lost answer must not make a used address look free.
fn find(session: &mut BusSession, address: u8) -> Result<Option<FoundStation>, SessionError> {
    for _ in 1..ATTEMPTS {
        if let Some(station) = probe(session, address)? {
            return Ok(Some(station));
        }
    }
    probe(session, address)
}

/// Gives the slave at `from` with this Ident_Number the address `to`, 0 to 125, and verifies it. With `lock` the slave accepts
/// no other address afterwards.
///
/// ```
/// # use profivac_client::{Bus, address};
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@126"])?).open()?;
/// let slave = address::check(bus.session(), 126, 20)?;
/// address::change(bus.session(), 126, 20, slave.ident, false)?;
/// assert_eq!(bus.gauge(20)?.model().name, "bcg450");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`AddressError`] tells where the slave is.
pub fn change(session: &mut BusSession, from: u8, to: u8, ident: u16, lock: bool) -> Result<(), AddressError> {
    let mut du = [0; 8];
    let request = SetSlaveAdd { address: to, ident, no_add_chg: if lock { LOCKED } else { 0 }, rem_slave_data: &[] };
    let length = request.emit(&mut du).unwrap_or_default();
    match session.request(&services::set_slave_add(from, du.get(..length).unwrap_or_default()))? {
        // SC means both.
        Reply::Answer { status: Status::Ok | Status::NoReply, .. } => {}
        Reply::Answer { status, .. } => return Err(AddressError::ServiceClosed(from, status)),
        Reply::NoAnswer(failure) => return Err(AddressError::Unconfirmed { address: from, failure }),
    }
    let begun = session.now();
    loop {
        let station = probe(session, to)?.and_then(|station| station.slave);
        if station.is_some_and(|slave| slave.ident == ident) {
            return Ok(());
        }
        if probe(session, from)?.is_some() {
            return Err(AddressError::NotChanged(from));
        }
        if session.has_passed(session.timeout(), begun) {
            return Err(AddressError::NotFound { from, to });
        }
    }
}
