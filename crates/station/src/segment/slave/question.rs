//! The requests that the station sends to a slave outside of data exchange: who it is, which modules it has, and its inputs.

use super::mismatch::{other_device, other_modules};
use crate::config;
use profivac_dp::master::services;
use profivac_host::port::PortError;
use profivac_host::scan;
use profivac_host::session::{BusSession, Reply, SessionError};
use profivac_wire::control::Status;

/// What the station asks a slave.
#[derive(Clone, Copy)]
pub enum Question {
    /// Whether it is the device of the GSD file, and no other master owns it.
    Search,
    /// Its modules, with Get_Cfg.
    Modules,
    /// Its inputs, with RD_Inp; unless it `is_verified`, its ident number, its modules and its diagnosis first.
    Inputs {
        /// It was asked for them lately.
        is_verified: bool,
    },
}

/// What a slave answered.
pub enum Answer {
    /// The octets of Get_Cfg; empty if it gave none.
    Modules(Vec<u8>),
    /// It is the device of the GSD file, and no other master owns it.
    Present,
    /// It is the device of the GSD file, with the modules of the station's file, and exchanges data with no master.
    Idle,
    /// It is the device of the GSD file with the modules of the station's file, and gave its inputs.
    Inputs {
        /// The inputs.
        inputs: Vec<u8>,
        /// Its diagnosis; empty without an answer, `None` if the slave was not verified again.
        diagnosis: Option<Vec<u8>>,
    },
}

/// Asks a slave. The inner result has the problem of the slave, in a sentence.
///
/// # Errors
/// When the port is lost.
pub fn ask(
    session: &mut BusSession,
    slave: &config::Slave,
    master: u8,
    question: Question,
) -> Result<Result<Answer, String>, PortError> {
    let answer = match question {
        Question::Search => search(session, slave, master),
        Question::Modules => modules(session, slave),
        Question::Inputs { is_verified } => read_inputs(session, slave, is_verified),
    };
    match answer {
        Err(SessionError::Port(error)) => Err(error),
        Err(error) => Ok(Err(error.to_string())),
        Ok(answer) => Ok(answer),
    }
}

fn search(session: &mut BusSession, slave: &config::Slave, master: u8) -> Result<Result<Answer, String>, SessionError> {
    let owner = present(session, slave)?;
    Ok(owner.and_then(|owner| match owner.filter(|owner| *owner != master) {
        Some(owner) => Err(format!("master {owner} owns it: with own = false the station reads it without ownership")),
        None => Ok(Answer::Present),
    }))
}

/// The owner of the slave, if it answers and is the device of the GSD file.
fn present(session: &mut BusSession, slave: &config::Slave) -> Result<Result<Option<u8>, String>, SessionError> {
    let status = scan::probe(session, slave.address)?.and_then(|station| station.slave);
    Ok(match status {
        None => Err("no slave answers".to_owned()),
        Some(status) if status.ident != slave.gsd.ident() => Err(other_device(status.ident, slave)),
        Some(status) => Ok(status.owner),
    })
}

fn modules(session: &mut BusSession, slave: &config::Slave) -> Result<Result<Answer, String>, SessionError> {
    Ok(Ok(Answer::Modules(match session.request(&services::get_cfg(slave.address))? {
        Reply::Answer { status: Status::DataLow | Status::DataHigh, du, .. } => du,
        Reply::Answer { .. } | Reply::NoAnswer(_) => Vec::new(),
    })))
}

fn read_inputs(
    session: &mut BusSession,
    slave: &config::Slave,
    is_verified: bool,
) -> Result<Result<Answer, String>, SessionError> {
    let diagnosis = if is_verified {
        None
    } else {
        match verify(session, slave)? {
            Ok(diagnosis) => Some(diagnosis),
            Err(problem) => return Ok(Err(problem)),
        }
    };
    let Reply::Answer { status, du, .. } = session.request(&services::rd_inp(slave.address))? else {
        return Ok(Err("no slave answers".to_owned()));
    };
    Ok(match status {
        Status::DataLow | Status::DataHigh => Ok(Answer::Inputs { inputs: du, diagnosis }),
        // A slave without inputs.
        Status::NoReply => Ok(Answer::Inputs { inputs: Vec::new(), diagnosis }),
        Status::ServiceNotActivated => Ok(Answer::Idle),
        status => Err(format!("expected inputs as the answer to RD_Inp, got the status {status:?}")),
    })
}

/// The diagnosis of the slave, if it is the device of the GSD file and Get_Cfg gives the modules of the station's file. A slave that refuses
/// Get_Cfg is believed. chosen: its inputs have the right length.
fn verify(session: &mut BusSession, slave: &config::Slave) -> Result<Result<Vec<u8>, String>, SessionError> {
    if let Err(problem) = present(session, slave)? {
        return Ok(Err(problem));
    }
    let Reply::Answer { status, du: modules, .. } = session.request(&services::get_cfg(slave.address))? else {
        return Ok(Err("no slave answers".to_owned()));
    };
    if matches!(status, Status::DataLow | Status::DataHigh) && modules != slave.gsd.chk_cfg() {
        return Ok(Err(other_modules(&modules, slave)));
    }
    Ok(Ok(match session.request(&services::slave_diag(slave.address))? {
        Reply::Answer { du, .. } => du,
        Reply::NoAnswer(_) => Vec::new(),
    }))
}
