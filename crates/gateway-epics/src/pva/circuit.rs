//! The conversation with one client over TCP.

use crate::connection::{Broken, MAX_OUT, MAX_PER_CLIENT, Posted, Protocol, Slots};
use crate::database::{Target, World};
use crate::pva::normative;
use crate::pva::search::{self, Guid};
use crate::pva::source::Source;
use crate::pva::wire::{self, Reader, Writer, command, put};
use profivac_station::gateway_status::GatewayStatus;
use std::collections::{BTreeMap, HashMap};
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

/// The state of the conversation.
pub struct Circuit {
    host: IpAddr,
    /// The port of this server.
    port: u16,
    guid: Guid,
    status: Arc<GatewayStatus>,
    slots: Slots,
    channels: HashMap<u32, Source>,
    next_channel: u32,
    operations: BTreeMap<u32, Operation>,
    /// The last operation that this turn has looked at.
    cursor: Option<u32>,
}

impl Circuit {
    /// A new client.
    #[must_use]
    pub fn new(host: IpAddr, port: u16, guid: Guid, status: Arc<GatewayStatus>, slots: Slots) -> Self {
        Self {
            host,
            port,
            guid,
            status,
            slots,
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
        self.channels.insert(id, source);
        Ok(id)
    }

    fn destroy_channel(&mut self, mut payload: Reader, out: &mut Vec<u8>) -> Result<(), Broken> {
        let (id, client_id) = (payload.word()?, payload.word()?);
        if self.channels.remove(&id).is_some() {
            self.slots.give();
            let ended: Vec<_> =
                self.operations.iter().filter(|(_, operation)| operation.channel == id).map(|(id, _)| *id).collect();
            ended.into_iter().for_each(|id| self.end(id));
        }
        let mut answer = Writer::default();
        answer.word(id);
        answer.word(client_id);
        put(out, command::DESTROY_CHANNEL, &answer);
        Ok(())
    }

    fn end(&mut self, operation: u32) {
        if self.operations.remove(&operation).is_some() {
            self.slots.give();
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
        let Some(source) = self.channels.get(&channel).copied() else {
            return refuse(out, command, id, sub, "there is no such channel");
        };
        let is_free = self.operations.len() < MAX_PER_CLIENT && !self.operations.contains_key(&id);
        if !is_free || !self.slots.take() {
            return refuse(out, command, id, sub, "there is no room for another request");
        }
        let request = if command == command::MONITOR {
            // The window is the last field, behind the selection of fields, which the server need not follow.
            let window = (sub & sub::PIPELINE != 0).then(|| last_word(&payload));
            Request::Monitor(Monitor { is_started: false, window, version: None })
        } else {
            Request::Get
        };
        self.operations.insert(id, Operation { channel, request });
        let mut answer = Writer::default();
        answer.word(id);
        answer.octet(sub);
        answer.ok();
        normative::describe(&mut answer, source.shape());
        put(out, command, &answer);
    }

    fn get(&self, channel: u32, id: u32, sub: u8, world: &World, out: &mut Vec<u8>) {
        let mut answer = Writer::default();
        answer.word(id);
        answer.octet(sub);
        answer.ok();
        let is_read = self.channels.get(&channel).is_some_and(|channel| channel.put(world, true, &mut answer));
        if is_read {
            put(out, command::GET, &answer);
            self.status.sent(1);
        } else {
            refuse(out, command::GET, id, sub, "the value cannot be read");
        }
    }

    fn get_field(&self, mut payload: Reader, out: &mut Vec<u8>) -> Result<(), Broken> {
        let (channel, id) = (payload.word()?, payload.word()?);
        let mut answer = Writer::default();
        answer.word(id);
        match (self.channels.get(&channel), payload.text()?) {
            (Some(source), "") => {
                answer.ok();
                normative::describe(&mut answer, source.shape());
            }
            (Some(_), _) => answer.error("only the type of the whole channel can be asked for"),
            (None, _) => answer.error("there is no such channel"),
        }
        put(out, command::GET_FIELD, &answer);
        Ok(())
    }

    /// Everything that writes, calls or processes.
    fn refuse_write(&self, command: u8, mut payload: Reader, out: &mut Vec<u8>) -> Result<(), Broken> {
        let (_, id, sub) = (payload.word()?, payload.word()?, payload.octet()?);
        if sub & sub::DESTROY == 0 {
            self.status.refused(&format!("the client at {} wants to write; the gateway is read-only", self.host));
            refuse(out, command, id, sub, "the gateway is read-only");
        }
        Ok(())
    }
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
            command::PUT | command::PUT_GET | command::ARRAY | command::PROCESS | command::RPC => {
                self.refuse_write(command, payload, out)?;
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
            let Some(source) = self.channels.get(&operation.channel) else { continue };
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
        for source in self.channels.values_mut() {
            let Source::Record(target, shape) = *source else { continue };
            let record = old.database.records.get(target.record).ok_or(Broken::RecordGone)?;
            let found = new.database.find(&record.name).ok_or(Broken::RecordGone)?;
            let is_same_type = new.database.records.get(found.record).is_some_and(|new| new.kind == record.kind);
            if !is_same_type {
                return Err(Broken::RecordGone);
            }
            *source = Source::Record(Target { field: target.field, ..found }, shape);
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
