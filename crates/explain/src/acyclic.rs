//! MS1 and MS2: connections and records, by their names.

use super::cycle::{Answer, Request, status_text};
use super::names::DeviceTables;
use super::note::{Kind, Notes};
use profivac_sim::describe::Hex;
use profivac_wire::Sap;
use profivac_wire::acyclic::{Access, Call, Negative, Request as Pdu, Response, Transfer, call};
use std::collections::BTreeMap;

/// What was asked of a connection.
#[derive(Clone, Debug)]
struct PendingRequest {
    master: u8,
    slot: u8,
    index: u8,
    /// The value to be written, nothing to read.
    value: Option<Vec<u8>>,
}

/// Connections and what was asked of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Records {
    asked: BTreeMap<Option<u8>, PendingRequest>,
    /// What was told of each parameter last: a value that does not change is told once.
    reported: BTreeMap<(u8, u8), String>,
    /// Which master opens a connection.
    opening: Option<u8>,
}

/// The access point of the slave, `None` for MS1.
const fn connection(sap: Sap) -> Option<u8> {
    match sap {
        Sap::Ms2(connection) => Some(connection),
        _ => None,
    }
}

fn way(sap: Sap) -> String {
    connection(sap).map_or_else(|| "MS1".to_owned(), |sap| format!("MS2 SAP {sap}"))
}

impl Records {
    /// A request on its way. Returns what it means.
    pub(super) fn request(&mut self, tables: &DeviceTables, request: &Request) -> String {
        let (asked, text) = match Pdu::parse(&request.du) {
            Ok(Pdu::Read(Access { slot, index, .. })) => {
                ((slot, index, None), format!("read {}", name(tables, slot, index, &[])))
            }
            Ok(Pdu::Write(Transfer { slot, index, data })) => {
                let text = format!("write {} = {}", name(tables, slot, index, data), value(tables, slot, index, data));
                ((slot, index, Some(data.to_vec())), text)
            }
            _ => return String::new(),
        };
        let (slot, index, value) = asked;
        self.asked.insert(connection(request.sap), PendingRequest { master: request.master, slot, index, value });
        text
    }

    /// The answer. Returns what it means; tells what is new.
    pub(super) fn answer(
        &mut self,
        address: u8,
        tables: &mut DeviceTables,
        request: &Request,
        answer: Answer<'_>,
        notes: &mut Notes<'_>,
    ) -> String {
        self.connects(address, request, notes);
        if answer.du.is_empty() {
            return self.bare(address, request, answer, notes);
        }
        let sap = request.sap;
        match Response::parse(answer.du) {
            Ok(Response::Read(Transfer { slot, index, data })) => {
                self.read(address, tables, (sap, slot, index), data, notes)
            }
            Ok(Response::Write(Access { slot, index, .. })) => self.written(address, tables, (sap, slot, index), notes),
            Ok(Response::Negative(refusal)) => self.refused(address, tables, sap, refusal, notes),
            Ok(response) => self.connected(address, request, &response, notes),
            Err(_) => String::new(),
        }
    }

    /// What a master opens and closes.
    fn connects(&mut self, address: u8, request: &Request, notes: &mut Notes<'_>) {
        match Pdu::parse(&request.du) {
            Ok(Pdu::Abort(abort)) => {
                let text = format!("master {} closes {}: {}", request.master, way(request.sap), abort.reason);
                notes.about(address, Kind::Connection, text);
                self.asked.remove(&connection(request.sap));
            }
            Ok(Pdu::Initiate(_)) => self.opening = Some(request.master),
            _ => {}
        }
    }

    /// What a slave says about a connection.
    fn connected(&mut self, address: u8, request: &Request, response: &Response<'_>, notes: &mut Notes<'_>) -> String {
        let text = match response {
            Response::Abort(abort) => format!("closes {}: {}", way(request.sap), abort.reason),
            Response::ResourceManager(open) => {
                let master = self.opening.take().unwrap_or(request.master);
                format!("gives master {master} an MS2 connection on SAP {}", open.server_sap)
            }
            Response::Initiate(open) => {
                format!("{} is open, records up to {} octets", way(request.sap), open.max_len_data_unit)
            }
            _ => return String::new(),
        };
        notes.about(address, Kind::Connection, text.clone());
        text
    }

    /// An answer without a PDU: taken, not ready yet, or closed.
    fn bare(&self, address: u8, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) -> String {
        if !answer.is_ack() {
            let what = match request.sap {
                Sap::ResourceManager => "gives no MS2 connection".to_owned(),
                sap => format!("does not take requests on {}", way(sap)),
            };
            notes.about(address, Kind::Refused, format!("{what}: {}", status_text(answer.status)));
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
        let asked = self.asked.get(&connection(sap)).filter(|asked| (asked.slot, asked.index) == (slot, index));
        let data = asked.and_then(|asked| asked.value.clone()).unwrap_or_default();
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
            let asked = self.asked.get(&connection(sap));
            let who = asked.map_or_else(|| "a master".to_owned(), |asked| format!("master {}", asked.master));
            notes.about(address, Kind::Parameter, format!("{who} {verb} {text} ({})", way(sap)));
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
        let asked = self.asked.get(&connection(sap));
        let what = asked.map_or_else(
            || "something".to_owned(),
            |asked| {
                let data = asked.value.as_deref();
                let written = data.map(|data| format!(" = {}", value(tables, asked.slot, asked.index, data)));
                name(tables, asked.slot, asked.index, data.unwrap_or_default()) + &written.unwrap_or_default()
            },
        );
        let code = if refusal.code_2 == 0 { String::new() } else { format!(", code {}", refusal.code_2) };
        let text = format!("{} of {what} refused: {}{code}", refusal.function, refusal.code_1);
        notes.about(address, Kind::Refused, format!("{text} ({})", way(sap)));
        text
    }
}

/// The name of a record; behind index 255 are those of Call.
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
