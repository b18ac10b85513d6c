//! The conversation with one client over TCP.

use crate::ca::dbr::{self, NoEncoding};
use crate::ca::message::{
    self, Header, MINOR_VERSION, Message, READ_ONLY, READ_WRITE, command, put, put_empty, status,
};
use crate::ca::search;
use crate::connection::{Broken, MAX_OUT, MAX_PER_CLIENT, Posted, Protocol, Slots};
use crate::database::{Target, World};
use crate::field::{ARCHIVE_DEADBAND, Field};
use crate::put::{Finished, PutValue, Puts};
use crate::record::{Data, MAX_TEXT, RecordType, Sample};
use profivac_gateway::{EpicsSeverity, EpicsStatus};
use profivac_station::gateway_status::GatewayStatus;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::net::IpAddr;
use std::ops::Bound;
use std::sync::Arc;

/// What a monitor wants to know (`DBE_*`).
mod mask {
    pub const VALUE: u16 = 1;
    pub const ARCHIVE: u16 = 2;
    pub const ALARM: u16 = 4;
    pub const PROPERTY: u16 = 8;
}

/// The octets of the request for a monitor: three numbers without a use, the mask, and two of padding.
const MASK_AT: usize = 12;

struct Channel {
    /// The number that the client has given it.
    client_id: u32,
    target: Target,
    /// Its monitors. Kept here, so that the end of a channel does not look at all monitors of the client.
    monitors: BTreeSet<u32>,
}

struct Monitor {
    /// The number that the server has given its channel.
    channel: u32,
    target: Target,
    data_type: u16,
    count: u32,
    mask: u16,
    /// The version of the point that the client has; `None` before the first value.
    version: Option<u64>,
    last: Option<(Data, EpicsSeverity, EpicsStatus)>,
}

impl Monitor {
    /// Whether the client wants this sample after the last one.
    fn wants(&self, sample: &Sample) -> bool {
        let Some((data, severity, status)) = &self.last else { return true };
        let alarm = (*severity, *status) != (sample.severity, sample.status);
        (self.mask & mask::VALUE != 0 && !is_same(data, &sample.data))
            || (self.mask & mask::ALARM != 0 && alarm)
            || (self.mask & mask::ARCHIVE != 0 && (alarm || is_for_archive(data, &sample.data)))
    }
}

fn is_same(old: &Data, new: &Data) -> bool {
    match (old, new) {
        (Data::Double(old), Data::Double(new)) => old.to_bits() == new.to_bits(),
        _ => old == new,
    }
}

fn is_for_archive(old: &Data, new: &Data) -> bool {
    match (old, new) {
        (Data::Double(old), Data::Double(new)) if old.is_finite() && new.is_finite() => {
            (new - old).abs() > old.abs() * ARCHIVE_DEADBAND
        }
        _ => !is_same(old, new),
    }
}

/// The state of the conversation.
pub struct Circuit {
    host: IpAddr,
    /// The port of this server.
    port: u16,
    status: Arc<GatewayStatus>,
    slots: Slots,
    puts: Puts<Header>,
    channels: HashMap<u32, Channel>,
    next_channel: u32,
    monitors: BTreeMap<u32, Monitor>,
    /// The last monitor that this turn has looked at.
    cursor: Option<u32>,
    wants_no_events: bool,
}

impl Circuit {
    /// A new client.
    #[must_use]
    pub fn new(host: IpAddr, port: u16, status: Arc<GatewayStatus>, slots: Slots, puts: Puts<Header>) -> Self {
        Self {
            host,
            port,
            status,
            slots,
            puts,
            channels: HashMap::new(),
            next_channel: 1,
            monitors: BTreeMap::new(),
            cursor: None,
            wants_no_events: false,
        }
    }

    fn create_channel(&mut self, header: Header, payload: &[u8], world: &World, out: &mut Vec<u8>) {
        let client_id = header.first;
        let found = world.database.find(message::text(payload)).and_then(|target| Some((target, world.read(target)?)));
        let is_free = self.channels.len() < MAX_PER_CLIENT;
        let (Some((target, answer)), true) = (found, is_free && self.slots.take()) else {
            return put_empty(out, command::CREATE_CHANNEL_FAILED, 0, 0, client_id, 0);
        };
        let is_large = target.field == Field::Value;
        let (native, count) = match target.is_long {
            true => (dbr::plain::CHAR, dbr::MAX_LONG_TEXT),
            false => (dbr::native(&answer.sample.data, is_large), 1),
        };
        let count = u32::try_from(count).unwrap_or_default();
        let may_write = world.database.writable(target).is_some_and(|record| self.puts.permits(record));
        let rights = if may_write { READ_WRITE } else { READ_ONLY };
        let id = self.free_number();
        self.channels.insert(id, Channel { client_id, target, monitors: BTreeSet::new() });
        put_empty(out, command::ACCESS_RIGHTS, 0, 0, client_id, rights);
        put_empty(out, command::CREATE_CHANNEL, native, count, client_id, id);
    }

    /// The next number without a channel. There are more numbers than channels, so one is free.
    fn free_number(&mut self) -> u32 {
        while self.channels.contains_key(&self.next_channel) {
            self.next_channel = self.next_channel.wrapping_add(1);
        }
        let id = self.next_channel;
        self.next_channel = id.wrapping_add(1);
        id
    }

    fn clear_channel(&mut self, header: Header, out: &mut Vec<u8>) {
        let Some(channel) = self.channels.remove(&header.first) else {
            return fail(out, header, status::BAD_CHANNEL, u32::MAX, "expected the number of a channel, found none");
        };
        self.slots.give();
        for id in channel.monitors {
            self.monitors.remove(&id);
            self.slots.give();
        }
        put_empty(out, command::CLEAR_CHANNEL, 0, 0, header.first, header.second);
    }

    fn read(&self, header: Header, world: &World, out: &mut Vec<u8>) {
        let Some(channel) = self.channels.get(&header.first) else {
            return fail(out, header, status::BAD_CHANNEL, u32::MAX, "expected the number of a channel, found none");
        };
        // The old command has the number of the channel where the new one has the status.
        let is_old = header.command == command::READ;
        match value(world, channel.target, header.data_type, header.count) {
            Ok((octets, count)) => {
                let first = if is_old { channel.client_id } else { status::NORMAL };
                put(out, Header { first, count, payload: 0, ..header }, &octets);
                self.status.sent(1);
            }
            Err(code) if is_old => fail(out, header, code, channel.client_id, "the value cannot be read in this form"),
            Err(code) => put_empty(out, command::READ_NOTIFY, header.data_type, 0, code, header.second),
        }
    }

    fn add_monitor(&mut self, header: Header, payload: &[u8], world: &World, out: &mut Vec<u8>) {
        let Some(channel) = self.channels.get_mut(&header.first) else {
            return fail(out, header, status::BAD_CHANNEL, u32::MAX, "expected the number of a channel, found none");
        };
        let (client_id, target) = (channel.client_id, channel.target);
        let count = header.count;
        if let Err(code) = value(world, target, header.data_type, count) {
            return fail(out, header, code, client_id, "the value cannot be monitored in this form");
        }
        let is_known = self.monitors.contains_key(&header.second);
        if is_known || self.monitors.len() >= MAX_PER_CLIENT || !self.slots.take() {
            return fail(out, header, status::NO_ROOM, client_id, "there is no room for another monitor");
        }
        let mask =
            payload.get(MASK_AT..).and_then(|rest| rest.first_chunk()).map_or(0, |mask| u16::from_be_bytes(*mask));
        let monitor = Monitor {
            channel: header.first,
            target,
            data_type: header.data_type,
            count,
            mask,
            version: None,
            last: None,
        };
        channel.monitors.insert(header.second);
        self.monitors.insert(header.second, monitor);
    }

    fn cancel_monitor(&mut self, header: Header, out: &mut Vec<u8>) {
        match self.monitors.remove(&header.second) {
            Some(monitor) => {
                self.slots.give();
                let client_id = self.channels.get_mut(&monitor.channel).map_or(u32::MAX, |channel| {
                    channel.monitors.remove(&header.second);
                    channel.client_id
                });
                // An update without values confirms the end.
                put_empty(out, command::EVENT_ADD, monitor.data_type, monitor.count, client_id, header.second);
            }
            None => fail(out, header, status::BAD_CHANNEL, u32::MAX, "expected the number of a monitor, found none"),
        }
    }

    fn write(&mut self, header: Header, payload: &[u8], world: &World, out: &mut Vec<u8>) {
        let target = self.channels.get(&header.first).map(|channel| channel.target);
        let Some(record) = target.and_then(|target| world.database.writable(target)) else {
            return self.refuse_write(header, status::NO_WRITE_ACCESS, "the gateway is read-only for this name", out);
        };
        if !self.puts.permits(record) {
            return self.refuse_write(header, status::NO_WRITE_ACCESS, "the gateway is read-only for this client", out);
        }
        let Some(value) = put_value(header, payload) else {
            return self.refuse_write(header, status::BAD_TYPE, "the value has no type that can be written", out);
        };
        let is_awaited = header.command == command::WRITE_NOTIFY;
        if let Err(error) = self.puts.begin(header, record, &value, world, is_awaited) {
            self.refuse_write(header, status::PUT_FAILED, &error.to_string(), out);
        }
    }

    /// Tells the client that a put was not done. An answer to `WRITE_NOTIFY` has no place for a sentence: the page of the gateways has it.
    fn refuse_write(&self, header: Header, code: u32, reason: &str, out: &mut Vec<u8>) {
        self.status.refused(&format!("a put of the client at {}: {reason}", self.host));
        if header.command == command::WRITE_NOTIFY {
            let Header { data_type, count, second, .. } = header;
            return put_empty(out, command::WRITE_NOTIFY, data_type, count, code, second);
        }
        let client_id = self.channels.get(&header.first).map_or(u32::MAX, |channel| channel.client_id);
        fail(out, header, code, client_id, reason);
    }
}

/// The value of a put: a number, a text, or a long text as an array of octets.
fn put_value(header: Header, payload: &[u8]) -> Option<PutValue> {
    let text = |octets: &[u8]| PutValue::Text(message::text(octets).to_owned());
    let number = |number: f64| Some(PutValue::Number(number));
    match (header.data_type, header.count) {
        (dbr::plain::STRING, 1) => Some(text(payload)),
        (dbr::plain::CHAR, 2..) => {
            let count = usize::try_from(header.count).ok()?;
            Some(text(payload.get(..count)?))
        }
        (dbr::plain::CHAR, 1) => number(f64::from(*payload.first()?)),
        (dbr::plain::SHORT, 1) => number(f64::from(i16::from_be_bytes(*payload.first_chunk()?))),
        (dbr::plain::ENUM, 1) => number(f64::from(u16::from_be_bytes(*payload.first_chunk()?))),
        (dbr::plain::LONG, 1) => number(f64::from(i32::from_be_bytes(*payload.first_chunk()?))),
        (dbr::plain::FLOAT, 1) => number(f64::from(f32::from_be_bytes(*payload.first_chunk()?))),
        (dbr::plain::DOUBLE, 1) => number(f64::from_be_bytes(*payload.first_chunk()?)),
        _ => None,
    }
}

/// One value as octets with the number of its elements, or the code of the reason why not. A count of 0 asks for as many as there are.
fn value(world: &World, target: Target, data_type: u16, count: u32) -> Result<(Vec<u8>, u32), u32> {
    let code = |reason| match reason {
        NoEncoding::Type => status::BAD_TYPE,
        NoEncoding::Conversion => status::NO_CONVERSION,
    };
    if target.is_long {
        let answer = world.read(target).ok_or(status::GET_FAILED)?;
        return dbr::encode_long_text(data_type, &answer, count).map_err(code);
    }
    if count > 1 {
        return Err(status::BAD_COUNT);
    }
    if data_type == dbr::CLASS_NAME {
        let kind = world.database.records.get(target.record).map_or(RecordType::Ai, |record| record.kind);
        let mut octets = kind.name().as_bytes().to_vec();
        octets.resize(MAX_TEXT.saturating_add(1), 0);
        return Ok((octets, 1));
    }
    let answer = world.read(target).ok_or(status::GET_FAILED)?;
    dbr::encode(data_type, &answer).map(|octets| (octets, 1)).map_err(code)
}

/// Tells that a request failed: its header and a sentence.
fn fail(out: &mut Vec<u8>, request: Header, code: u32, client_id: u32, text: &str) {
    let mut payload = Vec::new();
    let payload_size = Header { payload: 0, ..request };
    put(&mut payload, payload_size, &[]);
    payload.extend(text.as_bytes());
    payload.push(0);
    let header = Header { command: command::ERROR, payload: 0, data_type: 0, count: 0, first: client_id, second: code };
    put(out, header, &payload);
}

impl Protocol for Circuit {
    type Request = Header;

    fn puts(&mut self) -> &mut Puts<Header> {
        &mut self.puts
    }

    fn finish(&mut self, Finished { request, result }: Finished<Header>, out: &mut Vec<u8>) {
        match result {
            Ok(()) if request.command == command::WRITE_NOTIFY => {
                let Header { data_type, count, second, .. } = request;
                put_empty(out, command::WRITE_NOTIFY, data_type, count, status::NORMAL, second);
            }
            Ok(()) => {}
            Err(error) => self.refuse_write(request, status::PUT_FAILED, &error.to_string(), out),
        }
    }

    fn greet(&mut self, out: &mut Vec<u8>) {
        put_empty(out, command::VERSION, 0, MINOR_VERSION.into(), 0, 0);
    }

    fn receive(&mut self, input: &[u8], world: &World, out: &mut Vec<u8>) -> Result<usize, Broken> {
        let Some(Message { header, payload, used }) = message::parse(input)? else { return Ok(0) };
        match header.command {
            command::EVENT_ADD => self.add_monitor(header, payload, world, out),
            command::EVENT_CANCEL => self.cancel_monitor(header, out),
            command::READ | command::READ_NOTIFY => self.read(header, world, out),
            command::WRITE | command::WRITE_NOTIFY => self.write(header, payload, world, out),
            command::SEARCH => search::answer_on_circuit(header, payload, world, self.port, out),
            command::EVENTS_OFF => self.wants_no_events = true,
            command::EVENTS_ON => self.wants_no_events = false,
            command::READ_SYNC | command::ECHO => put(out, Header { payload: 0, ..header }, &[]),
            command::CLEAR_CHANNEL => self.clear_channel(header, out),
            command::CREATE_CHANNEL => self.create_channel(header, payload, world, out),
            // Names of user and computer are assertions; nothing depends on them.
            command::VERSION | command::CLIENT_NAME | command::HOST_NAME => {}
            _ => return Err(Broken::Malformed("an unknown command")),
        }
        Ok(used)
    }

    fn post(&mut self, world: &World, out: &mut Vec<u8>) -> Posted {
        let mut posted = Posted { is_complete: true, ..Posted::default() };
        if self.wants_no_events {
            return posted;
        }
        let begin = self.cursor.take().map_or(Bound::Unbounded, Bound::Excluded);
        for (id, monitor) in self.monitors.range_mut((begin, Bound::Unbounded)) {
            if out.len() >= MAX_OUT {
                posted.is_complete = false;
                break;
            }
            self.cursor = Some(*id);
            let version = world.version(monitor.target);
            if monitor.version == Some(version) {
                continue;
            }
            let missed = monitor.version.map_or(0, |old| version.saturating_sub(old).saturating_sub(1));
            monitor.version = Some(version);
            let Some(answer) = world.read(monitor.target).filter(|answer| monitor.wants(&answer.sample)) else {
                continue;
            };
            let octets = value(world, monitor.target, monitor.data_type, monitor.count);
            let (first, octets, count) = match &octets {
                Ok((octets, count)) => (status::NORMAL, octets.as_slice(), *count),
                Err(code) => (*code, [].as_slice(), monitor.count),
            };
            let data_type = monitor.data_type;
            put(out, Header { command: command::EVENT_ADD, payload: 0, data_type, count, first, second: *id }, octets);
            monitor.last = Some((answer.sample.data, answer.sample.severity, answer.sample.status));
            posted.sent = posted.sent.saturating_add(1);
            posted.dropped = posted.dropped.saturating_add(missed);
        }
        if posted.is_complete {
            self.cursor = None;
        }
        posted
    }

    fn renew(&mut self, old: &World, new: &World) -> Result<(), Broken> {
        let renewed = |target: Target| {
            let (old_record, field) = (old.database.records.get(target.record)?, target.field);
            let found = new.database.find(&old_record.name)?;
            let new_record = new.database.records.get(found.record)?;
            (old_record.kind == new_record.kind)
                .then_some((Target { field, ..found }, old_record.meta != new_record.meta))
        };
        for channel in self.channels.values_mut() {
            (channel.target, _) = renewed(channel.target).ok_or(Broken::RecordGone)?;
        }
        for monitor in self.monitors.values_mut() {
            let has_new_meta;
            (monitor.target, has_new_meta) = renewed(monitor.target).ok_or(Broken::RecordGone)?;
            if has_new_meta && monitor.mask & mask::PROPERTY != 0 {
                (monitor.version, monitor.last) = (None, None);
            }
        }
        Ok(())
    }
}
