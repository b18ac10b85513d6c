#!/usr/bin/env bash
# pcap-file 2.0.0 (Rust): the times of a pcapng file are a thousand times too small.
#
# Expected: EnhancedPacketBlock::timestamp, a Duration, is the time since 1970, as its documentation says. In pcapng the unit of a time
# stamp is in the option if_tsresol of its interface; without the option it is a microsecond (pcapng specification, Interface Description
# Block). Scapy, for example, writes microseconds without the option.
#
# Seen: the reader takes each time stamp for nanoseconds. It decodes the option, but never uses it. The year 2023 becomes 20 January
# 1970, and one second between two telegrams becomes one millisecond. Only a file with if_tsresol = 9 is right. The writer has the same
# fault: with an interface without options it writes nanoseconds, which all other programs read as microseconds. No error is raised.
#
# Why it matters: in a PROFIBUS capture (link type 257) the bus cycle and the reaction time of a slave come out a thousand times too short.
# Look up if_tsresol of the interface and scale the times, and give interfaces the option with 9 before you write packets.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
mkdir src
cat >Cargo.toml <<'TOML'
[package]
name = "times"
version = "0.0.0"
edition = "2021"

[dependencies]
pcap-file = "=2.0.0"
TOML
cat >src/main.rs <<'RUST'
use pcap_file::pcapng::blocks::{enhanced_packet::EnhancedPacketBlock, interface_description::InterfaceDescriptionBlock};
use pcap_file::pcapng::{PcapNgReader, PcapNgWriter};
use pcap_file::{DataLink, Endianness};
use std::time::Duration;

const PROFIBUS: u16 = 257;
/// A pass of the token from station 2 to station 3.
const TOKEN: [u8; 3] = [0xDC, 0x03, 0x02];

fn block(kind: u32, body: &[u8]) -> Vec<u8> {
    let length = (body.len() as u32 + 12).to_le_bytes();
    [&kind.to_le_bytes(), &length, body, &length].concat()
}

/// A file with one interface, with the option if_tsresol or without, and one packet for each time stamp.
fn file(resolution: Option<u8>, stamps: &[u64]) -> Vec<u8> {
    let section = [0x1A2B_3C4D_u32.to_le_bytes(), 1_u32.to_le_bytes(), [0xFF; 4], [0xFF; 4]].concat();
    let mut interface = [&PROFIBUS.to_le_bytes()[..], &[0; 6]].concat();
    if let Some(resolution) = resolution {
        interface.extend([9, 0, 1, 0, resolution, 0, 0, 0, 0, 0, 0, 0]);
    }
    let mut octets = [block(0x0A0D_0D0A, &section), block(1, &interface)].concat();
    for stamp in stamps {
        let words = [0, (stamp >> 32) as u32, *stamp as u32, TOKEN.len() as u32, TOKEN.len() as u32];
        let mut packet: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        packet.extend([&TOKEN[..], &[0]].concat());
        octets.extend(block(6, &packet));
    }
    octets
}

fn read(octets: &[u8]) -> Vec<Duration> {
    let mut reader = PcapNgReader::new(octets).expect("a valid file");
    let mut times = Vec::new();
    while let Some(next) = reader.next_block() {
        times.extend(next.expect("a valid block").into_enhanced_packet().map(|packet| packet.timestamp));
    }
    times
}

/// The time stamp in the octets of a file that the crate has written.
fn written(time: Duration) -> u64 {
    let mut writer = PcapNgWriter::with_endianness(Vec::new(), Endianness::Big).expect("a section");
    let interface = InterfaceDescriptionBlock { linktype: DataLink::from(u32::from(PROFIBUS)), snaplen: 0, options: vec![] };
    writer.write_pcapng_block(interface).expect("an interface");
    let data = TOKEN.as_slice().into();
    let packet = EnhancedPacketBlock { interface_id: 0, timestamp: time, original_len: 3, data, options: vec![] };
    writer.write_pcapng_block(packet).expect("a packet");
    let octets = writer.into_inner();
    // The packet is the last block: 12 octets of frame, 20 of header, 4 of data.
    let stamp = &octets[octets.len() - 24..octets.len() - 16];
    let word = |at: usize| u64::from(u32::from_be_bytes(stamp[at..at + 4].try_into().expect("4 octets")));
    (word(0) << 32) | word(4)
}

fn check<T: PartialEq + std::fmt::Debug>(what: &str, found: T, seen: T) {
    println!("{what}: {found:?}");
    if found != seen {
        eprintln!("pcap-file changed: {what} was {seen:?}");
        std::process::exit(1);
    }
}

fn main() {
    let micros = [1_700_000_000_000_000, 1_700_000_001_000_000];
    let seen = vec![Duration::from_secs(1_700_000), Duration::from_millis(1_700_000_001)];
    check("1700000000 s and 1 s later, microseconds by default", read(&file(None, &micros)), seen.clone());
    check("1700000000 s and 1 s later, if_tsresol = 6", read(&file(Some(6), &micros)), seen);
    let nanos = [1_700_000_000_000_000_000];
    check("1700000000 s, if_tsresol = 9", read(&file(Some(9), &nanos)), vec![Duration::from_secs(1_700_000_000)]);
    check("microseconds written for 1.25 s, by default", written(Duration::from_millis(1250)), 1_250_000_000);
}
RUST
cargo run --quiet
echo 'as described: pcap-file 2.0.0 takes each time of a pcapng file for nanoseconds'
