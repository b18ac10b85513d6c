//! Conversations over Channel Access and PV Access, octet by octet and without sockets.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::Plant;
use profivac_gateway_epics::ca;
use profivac_gateway_epics::connection::{Broken, MAX_OUT, Protocol, Slots};
use profivac_gateway_epics::database::World;
use profivac_gateway_epics::put::Puts;
use profivac_gateway_epics::pva;
use profivac_recorder::Quality;
use profivac_station::gateway_status::{GatewayStatus, GatewayStatuses};
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;

const HOST: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);

fn status() -> Arc<GatewayStatus> {
    GatewayStatuses::default().add("epics")
}

fn ca_circuit(status: &Arc<GatewayStatus>) -> ca::circuit::Circuit {
    ca::circuit::Circuit::new(HOST, 5064, Arc::clone(status), Slots::default(), Puts::new(None, HOST))
}

fn pva_circuit(status: &Arc<GatewayStatus>) -> pva::circuit::Circuit {
    pva::circuit::Circuit::new(HOST, (5075, [7; 12]), Arc::clone(status), Slots::default(), Puts::new(None, HOST))
}

/// A message of Channel Access.
fn ca(command: u16, data_type: u16, count: u16, first: u32, second: u32, payload: &[u8]) -> Vec<u8> {
    let padded = payload.len().next_multiple_of(8);
    let mut octets = Vec::new();
    for half in [command, u16::try_from(padded).unwrap(), data_type, count] {
        octets.extend(half.to_be_bytes());
    }
    octets.extend(first.to_be_bytes());
    octets.extend(second.to_be_bytes());
    octets.extend(payload);
    octets.resize(16 + padded, 0);
    octets
}

/// A message of PV Access.
fn pva(command: u8, payload: &[u8]) -> Vec<u8> {
    let size = u32::try_from(payload.len()).unwrap().to_le_bytes();
    [&[0xCA, 2, 0, command], &size[..], payload].concat()
}

fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// The answer to a message that is complete.
fn tell(circuit: &mut impl Protocol, world: &World, message: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    assert_eq!(circuit.receive(message, world, &mut out), Ok(message.len()));
    out
}

/// The messages of Channel Access in these octets: command, parameters, payload.
fn ca_messages(mut octets: &[u8]) -> Vec<(u16, u32, u32, Vec<u8>)> {
    let mut messages = Vec::new();
    while let Some(ca::message::Message { header, payload, used }) = ca::message::parse(octets).unwrap() {
        messages.push((header.command, header.first, header.second, payload.to_vec()));
        octets = &octets[used..];
    }
    assert!(octets.is_empty());
    messages
}

fn double(octets: &[u8]) -> f64 {
    f64::from_be_bytes(octets[..8].try_into().unwrap())
}

const MASK_VALUE_ALARM: [u8; 16] = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0];
const MASK_ARCHIVE: [u8; 16] = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0];
const MASK_PROPERTY: [u8; 16] = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 8, 0, 0];

/// A circuit with the channel 1 to the pressure of the chamber.
fn ca_channel(status: &Arc<GatewayStatus>, world: &World) -> ca::circuit::Circuit {
    let mut circuit = ca_circuit(status);
    let answer = ca_messages(&tell(&mut circuit, world, &ca(18, 0, 0, 9, 13, b"CHAMBER:P\0")));
    let commands: Vec<_> = answer.iter().map(|(command, first, second, _)| (*command, *first, *second)).collect();
    assert_eq!(commands, [(22, 9, 1), (18, 9, 1)], "the right to read, then the channel");
    circuit
}

fn posted(circuit: &mut impl Protocol, world: &World) -> (Vec<u8>, u64) {
    let mut out = Vec::new();
    let posted = circuit.post(world, &mut out);
    assert!(posted.is_complete);
    (out, posted.dropped)
}

fn reading(plant: &mut Plant, pa: f64) -> World {
    plant.reads("chamber", Quality::Valid, Some(pa), 1);
    plant.world()
}

#[test]
fn a_monitor_gets_the_newest_value_and_the_missed_ones_are_counted() {
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 100.0);
    let mut circuit = ca_channel(&status, &world);
    assert!(tell(&mut circuit, &world, &ca(1, 6, 1, 1, 77, &MASK_VALUE_ALARM)).is_empty());
    let first = ca_messages(&posted(&mut circuit, &world).0);
    assert_eq!((first[0].0, first[0].1, first[0].2, double(&first[0].3)), (1, 1, 77, 1.0));
    assert_eq!(posted(&mut circuit, &world), (vec![], 0), "nothing is sent twice");
    reading(&mut plant, 200.0);
    let world = reading(&mut plant, 300.0);
    let (out, dropped) = posted(&mut circuit, &world);
    let messages = ca_messages(&out);
    assert_eq!((messages.len(), double(&messages[0].3), dropped), (1, 3.0, 1));
}

#[test]
fn a_slow_client_has_a_bounded_buffer_and_continues_where_it_was() {
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 100.0);
    let mut circuit = ca_channel(&status, &world);
    for id in 0..10_000 {
        tell(&mut circuit, &world, &ca(1, 34, 1, 1, id, &MASK_VALUE_ALARM));
    }
    let mut seen = Vec::new();
    loop {
        let mut out = Vec::new();
        let posted = circuit.post(&world, &mut out);
        assert!(out.len() <= MAX_OUT + 200, "{}", out.len());
        seen.extend(ca_messages(&out).iter().map(|(_, _, id, _)| *id));
        if posted.is_complete {
            break;
        }
    }
    assert!(seen.iter().copied().eq(0..10_000));
}

#[test]
fn archivers_get_changes_of_five_percent_and_every_alarm() {
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 1e-3);
    let mut circuit = ca_channel(&status, &world);
    tell(&mut circuit, &world, &ca(1, 6, 1, 1, 1, &MASK_ARCHIVE));
    let count = |circuit: &mut ca::circuit::Circuit, world: &World| ca_messages(&posted(circuit, world).0).len();
    assert_eq!(count(&mut circuit, &world), 1);
    let small = reading(&mut plant, 1.04e-3);
    assert_eq!(count(&mut circuit, &small), 0);
    let large = reading(&mut plant, 1.06e-3);
    assert_eq!(count(&mut circuit, &large), 1);
    plant.loses("chamber");
    assert_eq!(count(&mut circuit, &plant.world()), 1);
}

#[test]
fn a_new_limit_reaches_the_monitors_of_properties_and_a_removed_gauge_ends_the_circuit() {
    let (mut plant, status) = (Plant::new(""), status());
    let old = reading(&mut plant, 1e-3);
    let mut circuit = ca_channel(&status, &old);
    tell(&mut circuit, &old, &ca(1, 34, 1, 1, 1, &MASK_PROPERTY));
    posted(&mut circuit, &old);
    plant.limit(50.0);
    let new = plant.world();
    assert_eq!(circuit.renew(&old, &new), Ok(()));
    let messages = ca_messages(&posted(&mut circuit, &new).0);
    // Unit at 8, then HOPR, LOPR, HIHI.
    assert!((double(&messages[0].3[32..]) - 0.5).abs() < 1e-9);
    plant.removes("chamber");
    assert_eq!(circuit.renew(&new, &plant.world()), Err(Broken::RecordGone));
}

#[test]
fn a_client_that_asks_for_no_events_gets_the_newest_when_it_wants_them_again() {
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 100.0);
    let mut circuit = ca_channel(&status, &world);
    tell(&mut circuit, &world, &ca(1, 6, 1, 1, 1, &MASK_VALUE_ALARM));
    tell(&mut circuit, &world, &ca(8, 0, 0, 0, 0, b""));
    assert_eq!(posted(&mut circuit, &world), (vec![], 0));
    tell(&mut circuit, &world, &ca(9, 0, 0, 0, 0, b""));
    assert_eq!(ca_messages(&posted(&mut circuit, &world).0).len(), 1);
}

#[test]
fn the_end_of_a_channel_ends_its_monitors_and_no_others() {
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 100.0);
    let mut circuit = ca_channel(&status, &world);
    let created = ca_messages(&tell(&mut circuit, &world, &ca(18, 0, 0, 2, 13, b"CHAMBER:PLOG\0")));
    assert_eq!(created.last().map(|(command, client, server, _)| (*command, *client, *server)), Some((18, 2, 2)));
    for (channel, monitor) in [(1, 11), (2, 21), (1, 12), (2, 22)] {
        tell(&mut circuit, &world, &ca(1, 6, 1, channel, monitor, &MASK_VALUE_ALARM));
    }
    // One monitor is cancelled, then its channel is cleared with the other one.
    tell(&mut circuit, &world, &ca(2, 6, 1, 1, 11, b""));
    let cleared = ca_messages(&tell(&mut circuit, &world, &ca(12, 0, 0, 1, 1, b"")));
    assert_eq!(cleared.len(), 1);
    let left: Vec<_> = ca_messages(&posted(&mut circuit, &world).0).iter().map(|(_, _, id, _)| *id).collect();
    assert_eq!(left, [21, 22]);
    // The numbers of ended monitors are free again.
    tell(&mut circuit, &world, &ca(1, 6, 1, 2, 11, &MASK_VALUE_ALARM));
    assert_eq!(ca_messages(&posted(&mut circuit, &world).0).len(), 1);
}

#[test]
fn requests_that_cannot_be_done_have_the_code_of_channel_access() {
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 100.0);
    let mut circuit = ca_channel(&status, &world);
    let mut one = |message: &[u8]| {
        let messages = ca_messages(&tell(&mut circuit, &world, message));
        let [(command, first, second, _)] = &messages[..] else { panic!("{messages:?}") };
        (*command, *first, *second)
    };
    assert_eq!(one(&ca(19, 6, 1, 1, 5, &[0; 8])), (19, 376, 5), "ECA_NOWTACCESS");
    assert_eq!(one(&ca(4, 6, 1, 1, 5, &[0; 8])), (11, 9, 376), "ECA_NOWTACCESS as an exception");
    assert_eq!(one(&ca(15, 6, 2, 1, 5, b"")), (15, 176, 5), "ECA_BADCOUNT");
    assert_eq!(one(&ca(15, 99, 1, 1, 5, b"")), (15, 114, 5), "ECA_BADTYPE");
    assert_eq!(one(&ca(15, 6, 1, 8, 5, b"")), (11, u32::MAX, 410), "ECA_BADCHID");
    assert_eq!(one(&ca(18, 0, 0, 10, 13, b"ABSENT\0")), (26, 10, 0), "no such channel");
    assert_eq!(one(&ca(2, 6, 1, 1, 88, b"")), (11, u32::MAX, 410), "no such monitor");
    assert_eq!(status.view().refused, 2, "the two writes");
}

/// The Archiver Appliance and Phoebus ask for fields with `$` where 39 octets are too few.
#[test]
fn a_long_text_is_a_channel_of_octets_with_as_many_as_there_are() {
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 100.0);
    let mut circuit = ca_circuit(&status);
    let created = tell(&mut circuit, &world, &ca(18, 0, 0, 9, 13, b"CHAMBER:P_STR$\0"));
    // Behind the rights: DBR_CHAR, 1024 elements.
    assert_eq!((&created[16..18], &created[20..24]), (&[0, 18][..], &[0, 4, 4, 0][..]), "{created:?}");
    let answer = ca_messages(&tell(&mut circuit, &world, &ca(15, 4, 0, 1, 5, b"")));
    assert_eq!(answer[0].3, b"1.00e+00 mbar\0\0\0", "with the padding of a payload");
    let full = ca_messages(&tell(&mut circuit, &world, &ca(15, 4, 1024, 1, 5, b"")));
    assert_eq!(full[0].3.len(), 1024);
    assert!(world.database.find("CHAMBER:P.DESC$").is_some() && world.database.find("CHAMBER:P$").is_none());
}

#[test]
fn a_search_is_answered_for_names_that_exist() {
    let world = Plant::new("").world();
    let datagram =
        [ca(0, 0, 13, 0, 0, b""), ca(6, 5, 13, 1, 1, b"CHAMBER:P\0"), ca(6, 5, 13, 2, 2, b"ABSENT\0")].concat();
    let messages = ca_messages(&ca::search::answer(&datagram, &world, 4711));
    assert_eq!(messages.iter().map(|(command, _, id, _)| (*command, *id)).collect::<Vec<_>>(), [(0, 0), (6, 1)]);
    assert!(ca::search::answer(&ca(6, 5, 13, 2, 2, b"ABSENT\0"), &world, 4711).is_empty());
    let head =
        [words(&[3]), vec![0x80, 0, 0, 0], vec![0; 16], 5000_u16.to_le_bytes().to_vec(), vec![1, 3], b"tcp".to_vec()]
            .concat();
    let of = |name: &str| {
        let name = [words(&[42]), vec![u8::try_from(name.len()).unwrap()], name.as_bytes().to_vec()].concat();
        pva(3, &[head.clone(), 1_u16.to_le_bytes().to_vec(), name].concat())
    };
    let (answer, port) = pva::search::answer(&of("CHAMBER:P"), &world, [7; 12], 4711).unwrap();
    assert_eq!((port, &answer[8..20], &answer[answer.len() - 4..]), (5000, &[7; 12][..], &[42, 0, 0, 0][..]));
    assert!(pva::search::answer(&of("ABSENT"), &world, [7; 12], 4711).is_none());
}

/// A circuit of PV Access with the channel 1.
fn pva_channel(status: &Arc<GatewayStatus>, world: &World, name: &str) -> pva::circuit::Circuit {
    let mut circuit = pva_circuit(status);
    let name = [&[u8::try_from(name.len()).unwrap()], name.as_bytes()].concat();
    let answer = tell(&mut circuit, world, &pva(7, &[1_u16.to_le_bytes().to_vec(), words(&[9]), name].concat()));
    assert_eq!(answer[8..], [words(&[9, 1]), vec![0xFF]].concat());
    circuit
}

fn request(id: u32, sub: u8) -> Vec<u8> {
    [words(&[1, id]), vec![sub]].concat()
}

#[test]
fn a_monitor_of_pv_access_gets_all_first_and_then_the_newest_with_the_overrun() {
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 100.0);
    let mut circuit = pva_channel(&status, &world, "CHAMBER:P");
    let init = tell(&mut circuit, &world, &pva(13, &request(5, 8)));
    assert_eq!(init[8..14], [5, 0, 0, 0, 8, 0xFF]);
    assert_eq!(posted(&mut circuit, &world), (vec![], 0), "it has not been started");
    tell(&mut circuit, &world, &pva(13, &request(5, 0x44)));
    let (first, _) = posted(&mut circuit, &world);
    // The set of fields: the whole structure; then the value.
    assert_eq!(first[8..15], [5, 0, 0, 0, 0, 1, 1]);
    assert_eq!(first[15..23], 1.0_f64.to_le_bytes());
    reading(&mut plant, 200.0);
    let world = reading(&mut plant, 300.0);
    let (second, dropped) = posted(&mut circuit, &world);
    // Value, alarm, time; at the end the set of fields with an overrun.
    assert_eq!((second[13..15].to_vec(), dropped), (vec![1, 0b100_0110], 1));
    assert_eq!((&second[15..23], &second[second.len() - 2..]), (&3.0_f64.to_le_bytes()[..], &[1, 2][..]));
    tell(&mut circuit, &world, &pva(13, &request(5, 4)));
    let world = reading(&mut plant, 400.0);
    assert_eq!(posted(&mut circuit, &world), (vec![], 0), "it has been stopped");
}

#[test]
fn the_end_of_a_channel_of_pv_access_ends_its_requests_and_no_others() {
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 100.0);
    let mut circuit = pva_channel(&status, &world, "CHAMBER:P");
    let name = [&[12][..], b"CHAMBER:PLOG"].concat();
    tell(&mut circuit, &world, &pva(7, &[1_u16.to_le_bytes().to_vec(), words(&[8]), name].concat()));
    let of_channel = |channel: u32, id: u32, sub: u8| pva(13, &[words(&[channel, id]), vec![sub]].concat());
    for (channel, id) in [(1, 11), (2, 21), (1, 12), (2, 22)] {
        tell(&mut circuit, &world, &of_channel(channel, id, 8));
        tell(&mut circuit, &world, &of_channel(channel, id, 0x44));
    }
    // One request is destroyed, then its channel with the other one.
    tell(&mut circuit, &world, &pva(15, &words(&[1, 11])));
    tell(&mut circuit, &world, &pva(8, &words(&[1, 9])));
    let updated = |out: &[u8]| {
        let mut ids = Vec::new();
        let mut rest = out;
        while let Some(message) = pva::wire::parse(rest).unwrap() {
            ids.push(message.payload.rest()[0]);
            rest = &rest[message.used..];
        }
        ids
    };
    assert_eq!(updated(&posted(&mut circuit, &world).0), [21, 22]);
    // The numbers of ended requests are free again.
    tell(&mut circuit, &world, &of_channel(2, 11, 8));
    tell(&mut circuit, &world, &of_channel(2, 11, 0x44));
    assert_eq!(updated(&posted(&mut circuit, &world).0), [11]);
}

#[test]
fn a_client_that_counts_gets_no_more_updates_than_it_is_ready_for() {
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 100.0);
    let mut circuit = pva_channel(&status, &world, "CHAMBER:P");
    // An empty selection of fields, then the window of one update.
    tell(&mut circuit, &world, &pva(13, &[request(5, 0x88), vec![0x80, 0, 0], words(&[1])].concat()));
    tell(&mut circuit, &world, &pva(13, &request(5, 0x44)));
    assert!(!posted(&mut circuit, &world).0.is_empty());
    let world = reading(&mut plant, 200.0);
    assert!(posted(&mut circuit, &world).0.is_empty());
    tell(&mut circuit, &world, &pva(13, &[request(5, 0x80), words(&[1])].concat()));
    assert!(!posted(&mut circuit, &world).0.is_empty());
}

#[test]
fn everything_that_writes_over_pv_access_is_refused_and_counted() {
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 100.0);
    let mut circuit = pva_channel(&status, &world, "CHAMBER:P");
    for command in [11, 12, 14, 16, 20] {
        let answer = tell(&mut circuit, &world, &pva(command, &request(5, 8)));
        assert_eq!((answer[3], answer[13]), (command, 2), "an error");
        assert!(answer.ends_with(b"\x18the gateway is read-only\0"), "{answer:?}");
    }
    assert_eq!(status.view().refused, 5);
}

#[test]
fn the_table_has_a_row_for_each_reading() {
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 100.0);
    let mut circuit = pva_channel(&status, &world, "TABLE");
    tell(&mut circuit, &world, &pva(10, &request(5, 8)));
    let answer = tell(&mut circuit, &world, &pva(10, &request(5, 0)));
    let rows = b"\x06\x07chamber\x0bfore line.1\x0bfore line.2\x0bfore line.3\x0bfore line.4\x04copy\x06";
    let at = answer.windows(rows.len()).position(|window| window == rows).unwrap();
    assert_eq!(answer[at + rows.len()..][..8], 1.0_f64.to_le_bytes());
}

/// Random octets, and messages with random contents, neither panic nor let memory grow.
#[test]
fn random_octets_break_at_most_the_connection() {
    let seed = 0x5EED_u64;
    let mut state = seed;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        u8::try_from(state >> 56).unwrap()
    };
    let (mut plant, status) = (Plant::new(""), status());
    let world = reading(&mut plant, 100.0);
    let mut first = ca_channel(&status, &world);
    let mut second = pva_channel(&status, &world, "CHAMBER:P");
    for _ in 0..20_000 {
        let payload: Vec<u8> = (0..random() / 4).map(|_| random()).collect();
        let small = |octet: u8| u32::from(octet % 4);
        let message =
            ca(u16::from(random() % 28), u16::from(random() % 40), 1, small(random()), small(random()), &payload);
        let mut out = Vec::new();
        first.receive(&message, &world, &mut out).ok();
        first.post(&world, &mut out);
        let own = [words(&[small(random()), small(random())]), vec![random()], payload.clone()].concat();
        second.receive(&pva(random() % 24, if random() < 128 { &own } else { &payload }), &world, &mut out).ok();
        second.post(&world, &mut out);
        first.receive(&payload, &world, &mut out).ok();
        second.receive(&payload, &world, &mut out).ok();
        let answered = ca::search::answer(&payload, &world, 1).len();
        let of_pva = pva::search::answer(&payload, &world, [0; 12], 1).map_or(0, |(octets, _)| octets.len());
        assert!(answered <= payload.len() && of_pva < 100, "an answer is not larger than the request");
        assert!(out.len() < 2 * MAX_OUT, "seed {seed}");
    }
}
