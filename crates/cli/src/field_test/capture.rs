//! Recorded chunks as packets of a capture file, and back.

use super::redact::Redaction;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT};
use profivac_explain::PLATFORM_SILENCE;
use profivac_host::clock::tbit_of;
use profivac_host::port::{Character, Direction, RecordedChunk};
use profivac_sim::trace::pcapng::CaptureError;
use profivac_sim::trace::{Entry, pcapng};
use profivac_wire::{Telegram, TelegramLength};

/// A telegram, or octets that are none, with its sender.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet {
    /// Whether this computer sent it.
    pub direction: Direction,
    /// Time and octets.
    pub entry: Entry,
}

/// A character with the earliest possible begin of its start bit.
type Timed = (BitTime, Character);

/// The packets of `chunks`, without private data.
pub fn packets(chunks: &[RecordedChunk], baud: Baud, is_timed: bool, redaction: Redaction) -> Vec<Packet> {
    let mut packets = Packets { made: Vec::new(), received: Vec::new(), last: BitTime(0), redaction };
    for chunk in chunks {
        packets.add(chunk, baud, is_timed);
    }
    packets.end_received();
    packets.made
}

/// Collects packets.
struct Packets {
    made: Vec<Packet>,
    /// Received characters that are no packet yet.
    received: Vec<Timed>,
    /// The time of the last character. Times never decrease.
    last: BitTime,
    redaction: Redaction,
}

impl Packets {
    fn add(&mut self, chunk: &RecordedChunk, baud: Baud, is_timed: bool) {
        let at = BitTime(tbit_of(baud, chunk.at));
        match chunk.direction {
            Direction::Sent => {
                self.end_received();
                let timed = self.timed(at, &chunk.characters, is_timed);
                self.split(Direction::Sent, &timed);
            }
            Direction::Received => {
                if at - self.last > tbit_of(baud, PLATFORM_SILENCE) {
                    self.end_received();
                }
                // A UART delivers several characters at once: the first one began earlier by their duration.
                let early_tbit = if is_timed { duration_tbit(chunk.characters.len()) } else { 0 };
                let timed = self.timed(BitTime(at.0.saturating_sub(early_tbit)), &chunk.characters, is_timed);
                self.received.extend(timed);
            }
        }
    }

    fn timed(&mut self, begin: BitTime, characters: &[Character], is_timed: bool) -> Vec<Timed> {
        let mut timed = Vec::new();
        for (index, character) in characters.iter().enumerate() {
            let later_tbit = if is_timed { duration_tbit(index) } else { 0 };
            self.last = self.last.max(begin + later_tbit);
            timed.push((self.last, *character));
        }
        timed
    }

    /// No telegram continues: the received characters become packets.
    fn end_received(&mut self) {
        let received = std::mem::take(&mut self.received);
        self.split(Direction::Received, &received);
    }

    fn split(&mut self, direction: Direction, characters: &[Timed]) {
        let all: Vec<_> = characters.iter().map(|(_, character)| *character).collect();
        for range in pieces(&all) {
            let piece = characters.get(range).unwrap_or_default();
            let Some((start, _)) = piece.first() else { continue };
            let characters: Vec<_> = piece.iter().map(|(_, character)| *character).collect();
            let entry = Entry::new(*start, self.redaction.of(direction, &octets(&characters)), errors(&characters));
            self.made.push(Packet { direction, entry });
        }
    }
}

const fn duration_tbit(characters: usize) -> u64 {
    CHARACTER_TBIT.saturating_mul(characters as u64)
}

/// The octets; a character with an error counts as 0.
pub fn octets(characters: &[Character]) -> Vec<u8> {
    let octet = |character: &Character| match character {
        Character::Octet(octet) => *octet,
        Character::Error => 0,
    };
    characters.iter().map(octet).collect()
}

/// The positions of the characters with an error.
fn errors(characters: &[Character]) -> Vec<usize> {
    let all = characters.iter().enumerate();
    all.filter(|(_, character)| **character == Character::Error).map(|(index, _)| index).collect()
}

/// The telegrams in `characters`, and what is between them.
pub fn pieces(characters: &[Character]) -> Vec<std::ops::Range<usize>> {
    let (mut pieces, mut damaged, mut at) = (Vec::new(), 0, 0);
    while at < characters.len() {
        let length = telegram_length(characters, at, at == damaged);
        let Some(length) = length else {
            at = at.saturating_add(1);
            continue;
        };
        if damaged < at {
            pieces.push(damaged..at);
        }
        pieces.push(at..at.saturating_add(length));
        at = at.saturating_add(length);
        damaged = at;
    }
    if damaged < at {
        pieces.push(damaged..at);
    }
    pieces
}

/// The length of the telegram at `at`. Behind damaged octets only a telegram with a check octet counts.
fn telegram_length(characters: &[Character], at: usize, is_first: bool) -> Option<usize> {
    let rest = characters.get(at..)?;
    let head: Vec<_> = octets(rest.get(..rest.len().min(TelegramLength::HEADER_LENGTH.into()))?);
    let TelegramLength::Known(length) = TelegramLength::of(&head) else { return None };
    let length = usize::from(length);
    let telegram = rest.get(..length).filter(|telegram| !telegram.contains(&Character::Error))?;
    match Telegram::parse(&octets(telegram)) {
        Ok(Telegram::Data(_)) => Some(length),
        Ok(Telegram::ShortAck | Telegram::Token { .. }) if is_first => Some(length),
        Ok(Telegram::ShortAck | Telegram::Token { .. }) | Err(_) => None,
    }
}

/// The packets as a capture file.
pub fn write(packets: &[Packet], baud: Baud) -> Vec<u8> {
    let mut file = pcapng::file_header(Some(baud), pcapng::PROFIBUS_DL);
    for packet in packets {
        let direction = match packet.direction {
            Direction::Sent => pcapng::Direction::Sent,
            Direction::Received => pcapng::Direction::Received,
        };
        file.extend(pcapng::directed_packet(&packet.entry, direction, baud));
    }
    file
}

/// Reads a capture file. A packet without direction counts as received.
///
/// # Errors
/// [`CaptureError`] when the file is damaged.
pub fn read(file: &[u8], default_baud: Baud) -> Result<Vec<Packet>, CaptureError> {
    let mut reader = pcapng::Reader::new(default_baud);
    reader.push(file);
    let mut packets = Vec::new();
    while let Some(entry) = reader.next() {
        let entry = entry?;
        let direction = match reader.direction() {
            Some(pcapng::Direction::Sent) => Direction::Sent,
            Some(pcapng::Direction::Received) | None => Direction::Received,
        };
        packets.push(Packet { direction, entry: entry.entry });
    }
    reader.end()?;
    Ok(packets)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use std::time::Duration;

    const REQUEST: [u8; 6] = [0x10, 5, 0, 0x49, 0x4E, 0x16];
    const ANSWER: [u8; 6] = [0x10, 0, 5, 0, 5, 0x16];

    fn chunk(ms: u64, direction: Direction, octets: &[u8]) -> RecordedChunk {
        let characters = octets.iter().copied().map(Character::Octet).collect();
        RecordedChunk { at: Duration::from_millis(ms), direction, characters }
    }

    fn seen(packets: &[Packet]) -> Vec<(Direction, u64, &[u8])> {
        packets.iter().map(|packet| (packet.direction, packet.entry.start.0, &*packet.entry.octets)).collect()
    }

    #[test]
    fn an_answer_in_pieces_becomes_one_packet_and_tokens_packets_of_their_own() {
        let token = [0xDC, 0, 0];
        let chunks = [
            chunk(10, Direction::Sent, &[&token[..], &REQUEST].concat()),
            chunk(20, Direction::Received, &ANSWER[..4]),
            chunk(24, Direction::Received, &ANSWER[4..]),
        ];
        let packets = packets(&chunks, Baud::B19200, true, Redaction::NONE);
        let expected = [
            (Direction::Sent, 192, &token[..]),
            (Direction::Sent, 192 + 33, &REQUEST),
            (Direction::Received, 384 - 44, &ANSWER),
        ];
        assert_eq!(seen(&packets), expected);
        assert_eq!(read(&write(&packets, Baud::B19200), Baud::B9600).unwrap(), packets);
    }

    #[test]
    fn damaged_octets_end_where_a_telegram_begins_and_keep_their_errors() {
        let mut damaged = chunk(20, Direction::Received, &[0x68, 0xE5, 0xDC]);
        damaged.characters.push(Character::Error);
        damaged.characters.extend(ANSWER.map(Character::Octet));
        let packets = packets(&[damaged], Baud::B19200, false, Redaction::NONE);
        let expected = [(Direction::Received, 384, &[0x68, 0xE5, 0xDC, 0][..]), (Direction::Received, 384, &ANSWER)];
        assert_eq!(seen(&packets), expected);
        assert_eq!(packets.first().unwrap().entry.errors, [3]);
        assert_eq!(read(&write(&packets, Baud::B19200), Baud::B9600).unwrap(), packets);
    }
}
