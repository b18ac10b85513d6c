//! The conversation with one client over TCP.

use crate::connection::{Broken, MAX_OUT, MAX_PER_CLIENT, Posted, Protocol, Slots};
use crate::database::{Target, World};
use crate::put::{Finished, PutError, PutValue, Puts};
use crate::pva::normative::{self, Shape};
use crate::pva::search::{self, Guid};
use crate::pva::source::Source;
use crate::pva::wire::{self, Reader, Writer, command, put};
use profivac_station::gateway_status::GatewayStatus;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::net::IpAddr;
use std::ops::Bound;
use std::sync::Arc;

/// Bits of the second octet of a request.
mod sub {
    pub const PROCESS: u8 = 0x04;
    pub const INIT: u8 = 0x08;
    pub const DESTROY: u8 = 0x10;
    pub const GET: u8 = 0x40;
    pub const PIPELINE: u8 = 0x80;
}

/// What the server tells about its buffers; nothing depends on it.
const BUFFER: u32 = 64 * 1024;
const REGISTRY: u16 = 0x7FFF;

/// What a request does.
enum Request {
    /// Reads when the client asks.
    Get,
    /// Sends what changes.
    Monitor(Monitor),
    /// Writes a value.
    Put,
}

/// The part of a put that its answer needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PutRequest {
    id: u32,
    sub: u8,
}

struct Monitor {
    is_started: bool,
    /// Updates that the client is ready to take, if it counts them.
    window: Option<u32>,
    /// The version that the client has; `None` before the first value.
    version: Option<u64>,
}

struct Operation {
    channel: u32,
    request: Request,
}

struct Channel {
    source: Source,
    /// Its operations. Kept here, so that the end of a channel does not look at all operations of the client.
    operations: BTreeSet<u32>,
}

/// The state of the conversation.
pub struct Circuit {
    host: IpAddr,
    /// The port of this server.
    port: u16,
    guid: Guid,
    status: Arc<GatewayStatus>,
    slots: Slots,
    puts: Puts<PutRequest>,
    channels: HashMap<u32, Channel>,
    next_channel: u32,
    operations: BTreeMap<u32, Operation>,
    /// The last operation that this turn has looked at.
    cursor: Option<u32>,
}

impl Circuit {
    /// A new client.
    #[must_use]
    pub fn new(
        host: IpAddr,
        (port, guid): (u16, Guid),
        status: Arc<GatewayStatus>,
        slots: Slots,
        puts: Puts<PutRequest>,
    ) -> Self {
        Self {
            host,
            port,
            guid,
            status,
            slots,
            puts,
            channels: HashMap::new(),
            next_channel: 1,
            operations: BTreeMap::new(),
            cursor: None,
        }
    }

    fn create_channels(&mut self, mut payload: Reader, world: &World, out: &mut Vec<u8>) -> Result<(), Broken> {
        for _ in 0..payload.half()? {
            let client_id = payload.word()?;
            let name = payload.text()?;
            let mut answer = Writer::default();
            answer.word(client_id);
            match self.create_channel(name, world) {
                Ok(id) => {
                    answer.word(id);
                    answer.ok();
                }
                Err(reason) => {
                    answer.word(u32::MAX);
                    answer.error(reason);
                }
            }
            put(out, command::CREATE_CHANNEL, &answer);
        }
        Ok(())
    }

    fn create_channel(&mut self, name: &str, world: &World) -> Result<u32, &'static str> {
        let source = Source::named(name, world).ok_or("there is no such name; `profivac names` lists all")?;
        let id = self.next_channel;
        let is_free = self.channels.len() < MAX_PER_CLIENT && !self.channels.contains_key(&id);
        if !is_free || !self.slots.take() {
            return Err("there is no room for another channel");
        }
        self.next_channel = id.wrapping_add(1);
        self.channels.insert(id, Channel { source, operations: BTreeSet::new() });
        Ok(id)
    }

    fn destroy_channel(&mut self, mut payload: Reader, out: &mut Vec<u8>) -> Result<(), Broken> {
        let (id, client_id) = (payload.word()?, payload.word()?);
        if let Some(channel) = self.channels.remove(&id) {
            self.slots.give();
            channel.operations.into_iter().for_each(|operation| self.end(operation));
        }
        let mut answer = Writer::default();
        answer.word(id);
        answer.word(client_id);
        put(out, command::DESTROY_CHANNEL, &answer);
        Ok(())
    }

    fn end(&mut self, operation: u32) {
        if let Some(Operation { channel, .. }) = self.operations.remove(&operation) {
            self.slots.give();
            if let Some(channel) = self.channels.get_mut(&channel) {
                channel.operations.remove(&operation);
            }
        }
    }

    /// `GET` and `MONITOR`: begins the operation, or lets it continue.
    fn operate(&mut self, command: u8, mut payload: Reader, world: &World, out: &mut Vec<u8>) -> Result<(), Broken> {
        let (channel, id, sub) = (payload.word()?, payload.word()?, payload.octet()?);
        if sub & sub::INIT != 0 {
            self.begin(command, channel, id, sub, payload, out);
            return Ok(());
        }
        match self.operations.get_mut(&id).map(|operation| (&mut operation.request, operation.channel)) {
            Some((Request::Get, channel)) if command == command::GET => self.get(channel, id, sub, world, out),
            Some((Request::Monitor(monitor), _)) if command == command::MONITOR => {
                if sub & sub::PIPELINE != 0 {
                    let more = payload.word()?;
                    monitor.window = monitor.window.map(|window| window.saturating_add(more));
                }
                // Start is process with get, stop is process alone.
                if sub & sub::PROCESS != 0 {
                    monitor.is_started = sub & sub::GET != 0;
                }
            }
            _ => refuse(out, command, id, sub, "there is no such request"),
        }
        if sub & sub::DESTROY != 0 {
            self.end(id);
        }
        Ok(())
    }

    fn begin(&mut self, command: u8, channel: u32, id: u32, sub: u8, payload: Reader, out: &mut Vec<u8>) {
        let Some(own) = self.channels.get_mut(&channel) else {
            return refuse(out, command, id, sub, "there is no such channel");
        };
        let is_free = self.operations.len() < MAX_PER_CLIENT && !self.operations.contains_key(&id);
        if !is_free || !self.slots.take() {
            return refuse(out, command, id, sub, "there is no room for another request");
        }
        let request = match command {
            command::MONITOR => {
                // The window is the last field, behind the selection of fields, which the server need not follow.
                let window = (sub & sub::PIPELINE != 0).then(|| last_word(&payload));
                Request::Monitor(Monitor { is_started: false, window, version: None })
            }
            command::PUT => Request::Put,
            _ => Request::Get,
        };
        own.operations.insert(id);
        self.operations.insert(id, Operation { channel, request });
        let mut answer = Writer::default();
        answer.word(id);
        answer.octet(sub);
        answer.ok();
        normative::describe(&mut answer, own.source.shape());
        put(out, command, &answer);
    }

    /// `PUT`: begins the operation, reads the present value, or writes.
    fn put(&mut self, mut payload: Reader, world: &World, out: &mut Vec<u8>) -> Result<(), Broken> {
        let (channel, id, sub) = (payload.word()?, payload.word()?, payload.octet()?);
        let target = match self.channels.get(&channel).map(|channel| &channel.source) {
            Some(Source::Record(target, shape)) => Some((*target, *shape)),
            Some(Source::Table) | None => None,
        };
        let found = target.and_then(|(target, shape)| Some((world.database.writable(target)?, shape)));
        let Some((record, shape)) = found.filter(|(record, _)| self.puts.permits(record)) else {
            return self.refuse_write(command::PUT, id, sub, out);
        };
        if sub & sub::INIT != 0 {
            self.begin(command::PUT, channel, id, sub, payload, out);
            return Ok(());
        }
        if !self.operations.get(&id).is_some_and(|operation| matches!(operation.request, Request::Put)) {
            refuse(out, command::PUT, id, sub, "there is no such request");
        } else if sub & sub::GET != 0 {
            self.answer_with_value(command::PUT, channel, id, sub, world, out);
        } else {
            let value = put_value(&mut payload, shape)?;
            let request = PutRequest { id, sub };
            let value = value.map_err(PutError::Value);
            let begun = value.and_then(|value| self.puts.begin(request, record, &value, world, true));
            if begun.is_err() {
                self.finish(Finished { request, result: begun }, out);
            }
        }
        if sub & sub::DESTROY != 0 {
            self.end(id);
        }
        Ok(())
    }

    fn get(&self, channel: u32, id: u32, sub: u8, world: &World, out: &mut Vec<u8>) {
        self.answer_with_value(command::GET, channel, id, sub, world, out);
    }

    fn answer_with_value(&self, command: u8, channel: u32, id: u32, sub: u8, world: &World, out: &mut Vec<u8>) {
        let mut answer = Writer::default();
        answer.word(id);
        answer.octet(sub);
        answer.ok();
        let is_read = self.channels.get(&channel).is_some_and(|it| it.source.put(world, true, &mut answer));
        if is_read {
            put(out, command, &answer);
            self.status.sent(1);
        } else {
            refuse(out, command, id, sub, "the value cannot be read");
        }
    }

    fn get_field(&self, mut payload: Reader, out: &mut Vec<u8>) -> Result<(), Broken> {
        let (channel, id) = (payload.word()?, payload.word()?);
        let mut answer = Writer::default();
        answer.word(id);
        match (self.channels.get(&channel), payload.text()?) {
            (Some(channel), "") => {
                answer.ok();
                normative::describe(&mut answer, channel.source.shape());
            }
            (Some(_), _) => answer.error("only the type of the whole channel can be asked for"),
            (None, _) => answer.error("there is no such channel"),
        }
        put(out, command::GET_FIELD, &answer);
        Ok(())
    }

    /// Everything that calls, processes, or writes what cannot be written.
    fn refuse_write(&self, command: u8, id: u32, sub: u8, out: &mut Vec<u8>) -> Result<(), Broken> {
        if sub & sub::DESTROY == 0 {
            self.status.refused(&format!("the client at {} wants to write; the gateway is read-only", self.host));
            refuse(out, command, id, sub, "the gateway is read-only");
        }
        Ok(())
    }
}

/// The value of a put: the set of the fields, then the values of these fields. Only the value itself can be written.
fn put_value(payload: &mut Reader, shape: Shape) -> Result<Result<PutValue, &'static str>, Broken> {
    let size = payload.size()?;
    let fields = payload.take(size)?;
    // The whole structure, the value, and the index of an enumeration: the value comes first in each case.
    let is_value = fields.first().is_some_and(|first| first & 0b111 != 0);
    if !is_value {
        return Ok(Err("expected the field value"));
    }
    Ok(Ok(match shape {
        Shape::Double => PutValue::Number(payload.double()?),
        Shape::Long => PutValue::Number(payload.long()?),
        Shape::Enum => PutValue::Number(f64::from(payload.word()?)),
        Shape::Text => PutValue::Text(payload.text()?.to_owned()),
        Shape::Table => return Ok(Err("a table cannot be written")),
    }))
}

/// The last 32 bits of a message.
fn last_word(payload: &Reader) -> u32 {
    let last = payload.rest().last_chunk().copied().unwrap_or_default();
    if payload.is_big_endian() { u32::from_be_bytes(last) } else { u32::from_le_bytes(last) }
}

/// Tells that a request fails, and why.
fn refuse(out: &mut Vec<u8>, command: u8, id: u32, sub: u8, reason: &str) {
    let mut answer = Writer::default();
    answer.word(id);
    answer.octet(sub);
    answer.error(reason);
    put(out, command, &answer);
}

impl Protocol for Circuit {
    type Request = PutRequest;

    fn puts(&mut self) -> &mut Puts<PutRequest> {
        &mut self.puts
    }

    fn finish(&mut self, Finished { request, result }: Finished<PutRequest>, out: &mut Vec<u8>) {
        let PutRequest { id, sub } = request;
        match result {
            Ok(()) => {
                let mut answer = Writer::default();
                answer.word(id);
                answer.octet(sub);
                answer.ok();
                put(out, command::PUT, &answer);
            }
            Err(error) => {
                self.status.refused(&format!("a put of the client at {}: {error}", self.host));
                refuse(out, command::PUT, id, sub, &error.to_string());
            }
        }
    }

    fn greet(&mut self, out: &mut Vec<u8>) {
        wire::put_byte_order(out);
        let mut offer = Writer::default();
        offer.word(BUFFER);
        offer.half(REGISTRY);
        // Nothing depends on who the client says it is.
        offer.size(2);
        offer.text("anonymous");
        offer.text("ca");
        put(out, command::CONNECTION_VALIDATION, &offer);
    }

    fn receive(&mut self, input: &[u8], world: &World, out: &mut Vec<u8>) -> Result<usize, Broken> {
        let Some(message) = wire::parse(input)? else { return Ok(0) };
        let mut payload = message.payload;
        let Some(command) = message.command else { return Ok(message.used) };
        match command {
            command::CONNECTION_VALIDATION => {
                let mut answer = Writer::default();
                answer.ok();
                put(out, command::CONNECTION_VALIDATED, &answer);
            }
            command::ECHO => put(out, command::ECHO, &Writer(payload.rest().to_vec())),
            command::SEARCH => search::answer_on_circuit(payload, world, self.guid, self.port, out)?,
            command::CREATE_CHANNEL => self.create_channels(payload, world, out)?,
            command::DESTROY_CHANNEL => self.destroy_channel(payload, out)?,
            command::GET | command::MONITOR => self.operate(command, payload, world, out)?,
            command::GET_FIELD => self.get_field(payload, out)?,
            command::PUT => self.put(payload, world, out)?,
            command::PUT_GET | command::ARRAY | command::PROCESS | command::RPC => {
                let (_, id, sub) = (payload.word()?, payload.word()?, payload.octet()?);
                self.refuse_write(command, id, sub, out)?;
            }
            command::DESTROY_REQUEST => {
                let (_, id) = (payload.word()?, payload.word()?);
                self.end(id);
            }
            command::AUTHENTICATION | command::MESSAGE | command::CANCEL_REQUEST => {}
            _ => return Err(Broken::Malformed("an unknown command")),
        }
        Ok(message.used)
    }

    fn post(&mut self, world: &World, out: &mut Vec<u8>) -> Posted {
        let mut posted = Posted { is_complete: true, ..Posted::default() };
        let begin = self.cursor.take().map_or(Bound::Unbounded, Bound::Excluded);
        for (id, operation) in self.operations.range_mut((begin, Bound::Unbounded)) {
            if out.len() >= MAX_OUT {
                posted.is_complete = false;
                break;
            }
            self.cursor = Some(*id);
            let Request::Monitor(monitor) = &mut operation.request else { continue };
            let Some(source) = self.channels.get(&operation.channel).map(|channel| channel.source) else { continue };
            if !monitor.is_started || monitor.window == Some(0) {
                continue;
            }
            let version = source.version(world);
            if monitor.version == Some(version) {
                continue;
            }
            let missed = monitor.version.map_or(0, |old| version.saturating_sub(old).saturating_sub(1));
            let mut update = Writer::default();
            update.word(*id);
            update.octet(0);
            if !source.put(world, monitor.version.is_none(), &mut update) {
                continue;
            }
            // What newer values have replaced: the value.
            let overrun: &[u8] = if missed > 0 { &source.shape().changing_fields()[..1] } else { &[] };
            update.bits(overrun);
            put(out, command::MONITOR, &update);
            monitor.version = Some(version);
            monitor.window = monitor.window.map(|window| window.saturating_sub(1));
            posted.sent = posted.sent.saturating_add(1);
            posted.dropped = posted.dropped.saturating_add(missed);
        }
        if posted.is_complete {
            self.cursor = None;
        }
        posted
    }

    fn renew(&mut self, old: &World, new: &World) -> Result<(), Broken> {
        for Channel { source, .. } in self.channels.values_mut() {
            let Source::Record(target, shape) = *source else { continue };
            let record = old.database.records.get(target.record).ok_or(Broken::RecordGone)?;
            let found = new.database.find(&record.name).ok_or(Broken::RecordGone)?;
            let is_same_type = new.database.records.get(found.record).is_some_and(|new| new.kind == record.kind);
            if !is_same_type {
                return Err(Broken::RecordGone);
            }
            *source = Source::Record(Target { field: target.field, is_long: target.is_long, ..found }, shape);
        }
        // Limits and ranges may be new.
        for operation in self.operations.values_mut() {
            if let Request::Monitor(monitor) = &mut operation.request {
                monitor.version = None;
            }
        }
        Ok(())
    }
}
