//! Acyclic services: MS1, MS2 connections, and records with the names of their parameters.

use super::cycle::{Answer, Request, status_text};
use super::names::DeviceTables;
use super::note::{Kind, Notes};
use profivac_sim::describe::Hex;
use profivac_wire::Sap;
use profivac_wire::acyclic::{Access, Call, Negative, Request as Pdu, Response, Transfer, call};
use std::collections::{BTreeMap, BTreeSet};

/// The last read or write request on a connection.
#[derive(Clone, Debug)]
struct PendingRequest {
    master: u8,
    slot: u8,
    index: u8,
    /// The value of a write request; `None` for a read request.
    value: Option<Vec<u8>>,
}

/// The acyclic services of one slave.
#[derive(Clone, Debug, Default)]
pub(super) struct Records {
    /// The last request on each connection, by the access point of the slave; `None` for MS1.
    pending: BTreeMap<Option<u8>, PendingRequest>,
    /// Text of the last note on each parameter: a value that does not change has one note.
    reported: BTreeMap<(u8, u8), String>,
    /// The master that has sent Initiate and has no answer yet.
    opening: Option<u8>,
    /// The connections whose opening was received or that have a note.
    known: BTreeSet<u8>,
}

/// The access point of the slave; `None` for MS1.
const fn connection(sap: Sap) -> Option<u8> {
    match sap {
        Sap::Ms2(connection) => Some(connection),
        _ => None,
    }
}

fn connection_text(sap: Sap) -> String {
    connection(sap).map_or_else(|| "MS1".to_owned(), |sap| format!("MS2 SAP {sap}"))
}

impl Records {
    /// Records a request. Returns its meaning.
    pub(super) fn request(&mut self, tables: &DeviceTables, request: &Request) -> String {
        let (access, text) = match Pdu::parse(&request.du) {
            Ok(Pdu::Read(Access { slot, index, .. })) => {
                ((slot, index, None), format!("read {}", name(tables, slot, index, &[])))
            }
            Ok(Pdu::Write(Transfer { slot, index, data })) => {
                let text = format!("write {} = {}", name(tables, slot, index, data), value(tables, slot, index, data));
                ((slot, index, Some(data.to_vec())), text)
            }
            _ => return String::new(),
        };
        let (slot, index, value) = access;
        self.pending.insert(connection(request.sap), PendingRequest { master: request.master, slot, index, value });
        text
    }

    /// Records an answer. Returns its meaning and adds notes about changes.
    pub(super) fn answer(
        &mut self,
        address: u8,
        tables: &mut DeviceTables,
        request: &Request,
        answer: Answer<'_>,
        notes: &mut Notes<'_>,
    ) -> String {
        self.connection_request(address, request, notes);
        self.report_open_connection(address, request, answer, notes);
        if answer.du.is_empty() {
            return self.answer_without_data(address, request, answer, notes);
        }
        let sap = request.sap;
        match Response::parse(answer.du) {
            Ok(Response::Read(Transfer { slot, index, data })) => {
                self.read(address, tables, (sap, slot, index), data, notes)
            }
            Ok(Response::Write(Access { slot, index, .. })) => self.written(address, tables, (sap, slot, index), notes),
            Ok(Response::Negative(refusal)) => self.refused(address, tables, sap, refusal, notes),
            Ok(response) => self.connection_answer(address, request, &response, notes),
            Err(_) => String::new(),
        }
    }

    /// Adds a note about a connection in use whose opening was not received.
    fn report_open_connection(&mut self, address: u8, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) {
        let begins_or_ends = matches!(Pdu::parse(&request.du), Ok(Pdu::Initiate(_) | Pdu::Abort(_)))
            || matches!(Response::parse(answer.du), Ok(Response::Initiate(_)));
        let Sap::Ms2(sap) = request.sap else { return };
        if !begins_or_ends && !answer.is_refusal() && self.known.insert(sap) {
            let text = format!(
                "has an MS2 connection on SAP {sap} with master {}; its opening was not received",
                request.master
            );
            notes.about(address, Kind::Connection, text);
        }
    }

    /// Adds a note when a master closes a connection, and remembers the master that opens one.
    fn connection_request(&mut self, address: u8, request: &Request, notes: &mut Notes<'_>) {
        match Pdu::parse(&request.du) {
            Ok(Pdu::Abort(abort)) => {
                let text =
                    format!("master {} closes {}: {}", request.master, connection_text(request.sap), abort.reason);
                notes.about(address, Kind::Connection, text);
                self.pending.remove(&connection(request.sap));
                self.close(request.sap);
            }
            Ok(Pdu::Initiate(_)) => self.opening = Some(request.master),
            _ => {}
        }
    }

    fn close(&mut self, sap: Sap) {
        if let Some(sap) = connection(sap) {
            self.known.remove(&sap);
        }
    }

    /// Adds a note when a slave opens or closes a connection.
    fn connection_answer(
        &mut self,
        address: u8,
        request: &Request,
        response: &Response<'_>,
        notes: &mut Notes<'_>,
    ) -> String {
        let text = match response {
            Response::Abort(abort) => {
                self.close(request.sap);
                format!("closes {}: {}", connection_text(request.sap), abort.reason)
            }
            Response::ResourceManager(open) => {
                let master = self.opening.take().unwrap_or(request.master);
                self.known.insert(open.server_sap);
                format!("gives master {master} an MS2 connection on SAP {}", open.server_sap)
            }
            Response::Initiate(open) => {
                self.known.extend(connection(request.sap));
                format!("{} is open, records up to {} octets", connection_text(request.sap), open.max_len_data_unit)
            }
            _ => return String::new(),
        };
        notes.about(address, Kind::Connection, text.clone());
        text
    }

    /// Handles an answer without a PDU: an acknowledgement, or a status that refuses the request.
    fn answer_without_data(&self, address: u8, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) -> String {
        if !answer.is_ack() {
            let refusal = match request.sap {
                Sap::ResourceManager => "gives no MS2 connection".to_owned(),
                sap => format!("does not take requests on {}", connection_text(sap)),
            };
            notes.about(address, Kind::Refused, format!("{refusal}: {}", status_text(answer.status)));
        }
        String::new()
    }

    fn read(
        &mut self,
        address: u8,
        tables: &mut DeviceTables,
        (sap, slot, index): (Sap, u8, u8),
        data: &[u8],
        notes: &mut Notes<'_>,
    ) -> String {
        tables.learn(slot, index, data);
        let text = format!("{} = {}", name(tables, slot, index, data), value(tables, slot, index, data));
        self.report(address, (sap, slot, index), "reads", &text, notes);
        text
    }

    fn written(
        &mut self,
        address: u8,
        tables: &mut DeviceTables,
        (sap, slot, index): (Sap, u8, u8),
        notes: &mut Notes<'_>,
    ) -> String {
        let request =
            self.pending.get(&connection(sap)).filter(|request| (request.slot, request.index) == (slot, index));
        let data = request.and_then(|request| request.value.clone()).unwrap_or_default();
        tables.learn(slot, index, &data);
        let text = format!("{} = {}", name(tables, slot, index, &data), value(tables, slot, index, &data));
        self.reported.remove(&(slot, index));
        self.report(address, (sap, slot, index), "writes", &text, notes);
        text
    }

    fn report(
        &mut self,
        address: u8,
        (sap, slot, index): (Sap, u8, u8),
        verb: &str,
        text: &str,
        notes: &mut Notes<'_>,
    ) {
        if self.reported.insert((slot, index), text.to_owned()).as_deref() != Some(text) {
            let request = self.pending.get(&connection(sap));
            let master = request.map_or_else(|| "a master".to_owned(), |request| format!("master {}", request.master));
            notes.about(address, Kind::Parameter, format!("{master} {verb} {text} ({})", connection_text(sap)));
        }
    }

    fn refused(
        &mut self,
        address: u8,
        tables: &DeviceTables,
        sap: Sap,
        refusal: Negative,
        notes: &mut Notes<'_>,
    ) -> String {
        let request = self.pending.get(&connection(sap));
        let parameter = request.map_or_else(
            || "an unknown parameter".to_owned(),
            |request| {
                let data = request.value.as_deref();
                let written = data.map(|data| format!(" = {}", value(tables, request.slot, request.index, data)));
                name(tables, request.slot, request.index, data.unwrap_or_default()) + &written.unwrap_or_default()
            },
        );
        let code = if refusal.code_2 == 0 { String::new() } else { format!(", code {}", refusal.code_2) };
        let text = format!("{} of {parameter} refused: {}{code}", refusal.function, refusal.code_1);
        notes.about(address, Kind::Refused, format!("{text} ({})", connection_text(sap)));
        text
    }
}

/// The name of a record. Index 255 is Call, which has records of its own.
fn name(tables: &DeviceTables, slot: u8, index: u8, data: &[u8]) -> String {
    match (index, Call::parse(data)) {
        (call::CALL_INDEX, Ok(call)) if call.fi_index == call::IM0 => "I&M0".to_owned(),
        (call::CALL_INDEX, Ok(call)) => format!("Call {:04X}", call.fi_index),
        (call::CALL_INDEX, Err(_)) => "Call".to_owned(),
        _ => tables.name(slot, index),
    }
}

fn value(tables: &DeviceTables, slot: u8, index: u8, data: &[u8]) -> String {
    if index != call::CALL_INDEX {
        return tables.value(slot, index, data);
    }
    let im0 = Call::parse(data).ok().and_then(|call| profivac_wire::acyclic::Im0::parse(call.record).ok());
    im0.map_or_else(
        || Hex(data).to_string(),
        |im0| {
            let text = |octets: &[u8]| String::from_utf8_lossy(octets).into_owned();
            format!("{}, serial number {}", text(im0.order_id), text(im0.serial_number))
        },
    )
}
