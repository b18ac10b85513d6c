//! The listeners of the gateways, without sockets: Channel Access, PV Access, Modbus TCP, commands of Sparkplug B.
//!
//! The target plays a client. A listener accepts messages as far as they are complete, refuses the others, and its answers are messages
//! of its protocol.

use crate::script::Script;
use profivac_gateway::model::Modeller;
use profivac_gateway::{Inputs, points};
use profivac_gateway_epics::connection::{Broken, Protocol, Slots};
use profivac_gateway_epics::database::{Database, World, held};
use profivac_gateway_epics::put::Puts;
use profivac_gateway_epics::{ca, pva};
use profivac_gateway_modbus::image::Encoder;
use profivac_gateway_modbus::map::Map;
use profivac_gateway_modbus::pdu::{Head, Identity, answer};
use profivac_gateway_mqtt::sparkplug::edge_node::{EdgeNode, Names};
use profivac_recorder::Micros;
use profivac_station::config::Config;
use profivac_station::config::gateways::GatewaySettings;
use profivac_station::config::gateways::mqtt::DataStyle;
use profivac_station::gateway_status::GatewayStatuses;
use std::net::{IpAddr, Ipv4Addr};
use std::path::Path;
use std::sync::{Arc, LazyLock};

const HOST: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
const NOW: Micros = Micros(1_000_000_000);

const PLANT: &str = r#"
[[segment]]
name = "hall"
port = "/dev/ttyUSB0"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.gauge]]
name = "fore line"
address = 6
device = "tpg300"

[[alarm]]
name = "Chamber high"
gauge = "chamber"
above = "1e-3 mbar"
priority = "high"

[epics]

[modbus]
"#;

static CONFIG: LazyLock<Config> =
    LazyLock::new(|| profivac_config::parse(PLANT, Path::new("plant.toml")).expect("a right file"));

/// The records and values of EPICS.
static WORLD: LazyLock<World> = LazyLock::new(|| {
    let settings = CONFIG.gateways.iter().find_map(|settings| match settings {
        GatewaySettings::Epics(settings) => Some(settings.clone()),
        _ => None,
    });
    let settings = settings.expect("[epics]");
    let snapshot = Arc::new(Modeller::default().next(Inputs::planned(&CONFIG), NOW));
    let database = Arc::new(Database::new(&CONFIG.name, &snapshot, &settings).expect("no name twice"));
    let held = held(&Arc::default(), &snapshot, false, &settings);
    World { database, snapshot, held }
});

/// The names of records that a client may ask for.
const RECORDS: [&str; 6] =
    ["CHAMBER:P", "CHAMBER:P.DESC$", "FORE_LINE:P.HIGH", "ABSENT", "CHAMBER:P_STR$", "CHAMBER:PLOG"];

/// Passes octets to a circuit, as far as it takes them; returns whether the connection goes on.
fn tell(circuit: &mut impl Protocol, input: &mut Vec<u8>, out: &mut Vec<u8>) -> Result<(), Broken> {
    loop {
        let used = circuit.receive(input, &WORLD, out)?;
        assert!(used <= input.len(), "{used} of {} octets", input.len());
        if used == 0 {
            return Ok(());
        }
        input.drain(..used);
        circuit.post(&WORLD, out);
    }
}

/// A conversation over Channel Access, and a datagram with searches.
pub fn channel_access(octets: &[u8]) {
    let status = GatewayStatuses::default().add("epics");
    let mut circuit = ca::circuit::Circuit::new(HOST, 5064, status, Slots::default(), Puts::new(None, HOST));
    let (mut script, mut input, mut out) = (Script::new(octets), Vec::new(), Vec::new());
    circuit.greet(&mut out);
    while let Some(kind) = script.octet() {
        let before = input.len();
        if kind & 0xC0 == 0xC0 {
            input.extend(script.piece(64));
        } else {
            let payload = if kind & 0x20 != 0 { ca_name(&mut script) } else { script.piece(80).to_vec() };
            let padded = payload.len().next_multiple_of(8);
            let halves = [u16::from(kind & 0x1F), padded as u16, script.number() % 40, u16::from(script.choice())];
            input.extend(halves.iter().flat_map(|half| half.to_be_bytes()));
            let words = [u32::from(script.choice() % 8), u32::from(script.choice() % 16)];
            input.extend(words.iter().flat_map(|word| word.to_be_bytes()));
            input.extend(&payload);
            input.resize(before + 16 + padded, 0);
        }
        if tell(&mut circuit, &mut input, &mut out).is_err() {
            break;
        }
        out.truncate(1 << 16);
    }
    let _ = ca::search::answer(octets, &WORLD, 5064);
    is_channel_access(&ca::search::answer(octets, &WORLD, 5064));
}

fn ca_name(script: &mut Script<'_>) -> Vec<u8> {
    [script.one_of(&RECORDS).as_bytes(), &[0]].concat()
}

/// The octets are messages of Channel Access.
fn is_channel_access(mut octets: &[u8]) {
    while !octets.is_empty() {
        let message = ca::message::parse(octets).expect("a message").expect("a complete message");
        octets = &octets[message.used..];
    }
}

/// A conversation over PV Access, and a datagram with searches.
pub fn pv_access(octets: &[u8]) {
    let status = GatewayStatuses::default().add("epics");
    let mut circuit =
        pva::circuit::Circuit::new(HOST, (5075, [7; 12]), status, Slots::default(), Puts::new(None, HOST));
    let (mut script, mut input, mut out) = (Script::new(octets), Vec::new(), Vec::new());
    circuit.greet(&mut out);
    while let Some(kind) = script.octet() {
        let mut payload = Vec::new();
        match kind >> 6 {
            3 => input.extend(script.piece(64)),
            // A channel by its name, or a request on it.
            2 => {
                let name = script.one_of(&RECORDS);
                payload.extend([1, 0, script.choice() % 8, 0, 0, 0, name.len() as u8]);
                payload.extend(name.as_bytes());
            }
            1 => {
                payload.extend([script.choice() % 8, 0, 0, 0, script.choice() % 8, 0, 0, 0]);
                payload.extend(script.piece(60));
            }
            _ => payload.extend(script.piece(80)),
        }
        if kind >> 6 != 3 {
            let size = payload.len() as u32;
            let flags = if script.choice() & 0x80 == 0 { 0 } else { 0x80 };
            let size = if flags == 0 { size.to_le_bytes() } else { size.to_be_bytes() };
            input.extend([0xCA, 2, flags, kind & 0x1F]);
            input.extend(size);
            input.extend(payload);
        }
        if tell(&mut circuit, &mut input, &mut out).is_err() {
            break;
        }
        out.truncate(1 << 16);
    }
    let _ = pva::search::answer(octets, &WORLD, [7; 12], 5075);
}

/// Requests of Modbus TCP, as the octets of a connection.
pub fn modbus(octets: &[u8]) {
    static PARTS: LazyLock<(profivac_gateway_modbus::image::Image, Identity)> = LazyLock::new(|| {
        let settings = CONFIG.gateways.iter().find_map(|settings| match settings {
            GatewaySettings::Modbus(settings) => Some(settings.clone()),
            _ => None,
        });
        let settings = settings.expect("[modbus]");
        let inputs = Inputs::planned(&CONFIG);
        let map = Map::of(&points(&inputs), &settings).expect("a map");
        let snapshot = Modeller::default().next(inputs, NOW);
        let image = Encoder::new(map, &settings).image(&snapshot, NOW);
        (image, Identity { version: "0.2.0".to_owned(), station: "hall".to_owned() })
    });
    let (image, identity) = &*PARTS;
    let mut rest = octets;
    while let Some((head, behind)) = rest.split_first_chunk() {
        let Some(head) = Head::parse(*head) else { return };
        let Some((pdu, behind)) = behind.split_at_checked(head.length) else { return };
        let (given, refusal) = answer(pdu, Some(image), identity);
        assert!((2..=253).contains(&given.len()), "an answer of {} octets", given.len());
        assert_eq!(given[0] & 0x80 != 0, refusal.is_some() || pdu[0] & 0x80 != 0);
        let telegram = head.telegram(&given);
        let again = telegram.first_chunk().and_then(|head| Head::parse(*head)).expect("the head of an answer");
        assert_eq!((again.transaction, again.length), (head.transaction, given.len()));
        rest = behind;
    }
}

/// Messages to an edge node of Sparkplug B: the state of its host, and commands.
pub fn sparkplug(octets: &[u8]) {
    let data = if octets.len().is_multiple_of(2) { DataStyle::Names } else { DataStyle::Aliases };
    let primary_host = Some("scada".to_owned());
    let names = Names { group: "plant".to_owned(), edge_node: "hall".to_owned(), primary_host, data };
    let topics = ["spBv1.0/STATE/scada", "spBv1.0/plant/NCMD/hall", "spBv1.0/plant/DCMD/hall/chamber", ""];
    let (mut script, mut now) = (Script::new(octets), NOW);
    let mut node = EdgeNode::new(names, 0, None);
    node.subscribed();
    while let Some(kind) = script.octet() {
        now = Micros(now.0 + i64::from(kind) * 10_000);
        let payload = if kind & 0xF0 == 0x80 {
            format!(r#"{{"online":{},"timestamp":{}}}"#, kind & 4 == 0, script.number()).into_bytes()
        } else {
            script.piece(120).to_vec()
        };
        let _ = node.message(topics[usize::from(kind & 3)], &payload, now);
        if node.is_rebirth_due(now) {
            node.births(&WORLD.snapshot, &Default::default(), now);
        }
    }
}
