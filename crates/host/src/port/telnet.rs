//! A line behind a serial server that speaks telnet (RFC 854, RFC 856), or telnet with control of the serial port (RFC 2217).
//!
//! The octet FF has a meaning of its own in telnet and is sent twice as data. The server may refuse each option or answer none: then the
//! octets pass all the same, at the rate that the server is configured for.

use super::notice::{DropCounter, Notice, Notices};
use super::server::{Connection, words};
use super::stream::{is_temporary, write_now};
use super::{CHUNK, Character, Port, PortError};
use crate::readiness::Readiness;
use profivac_dp::link::Baud;
use std::collections::BTreeSet;
use std::io::Read;
use std::mem::{Discriminant, discriminant};
use std::net::TcpStream;
use std::time::Duration;

const IAC: u8 = 0xFF;
const DONT: u8 = 0xFE;
const DO: u8 = 0xFD;
const WONT: u8 = 0xFC;
const WILL: u8 = 0xFB;
const SUBNEGOTIATION: u8 = 0xFA;
const END: u8 = 0xF0;

const BINARY: u8 = 0;
const ECHO: u8 = 1;
const NO_GO_AHEAD: u8 = 3;
/// Control of the serial port (RFC 2217 section 2).
const COM_PORT: u8 = 44;

/// Commands of [`COM_PORT`] (RFC 2217 section 3); a server answers with 100 more.
const SET_BAUD: u8 = 1;
const SET_DATA_SIZE: u8 = 2;
const SET_PARITY: u8 = 3;
const SET_STOP_SIZE: u8 = 4;
const SET_CONTROL: u8 = 5;
const ANSWER: u8 = 100;
const EVEN: u8 = 3;
const NO_FLOW_CONTROL: u8 = 1;

/// The longest subnegotiation that is kept. chosen: the answers of RFC 2217 have six octets, a signature is text of any length.
const LONGEST: usize = 64;

/// What a server has said about the serial port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answer {
    /// It gives no control of the port.
    NoControl,
    /// It does not pass all octets as they are.
    NotBinary,
    /// The rate of the port, in bit/s.
    Rate(u32),
    /// The parity of the port, as RFC 2217 numbers it.
    Parity(u8),
}

/// Position within the commands of telnet.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
enum State {
    #[default]
    Data,
    Command,
    /// The option of this command follows.
    Option(u8),
    Inside(Vec<u8>),
    /// An IAC within a subnegotiation.
    InsideCommand(Vec<u8>),
}

/// Divides what a server sends into octets of the line and commands, and answers the commands.
#[derive(Debug, Default)]
struct Telnet {
    state: State,
    /// The rate that is asked for; `None` without RFC 2217.
    baud: Option<Baud>,
    /// Options of this side that are offered or on, and options of the server.
    ours: BTreeSet<u8>,
    theirs: BTreeSet<u8>,
    /// The server has sent a command.
    has_heard_command: bool,
}

impl Telnet {
    /// The state before the first octet, and what opens the connection.
    fn begin(baud: Option<Baud>) -> (Self, Vec<u8>) {
        let mut ours = BTreeSet::from([BINARY, NO_GO_AHEAD]);
        ours.extend(baud.map(|_| COM_PORT));
        let theirs = BTreeSet::from([BINARY, NO_GO_AHEAD]);
        let offers = ours.iter().flat_map(|option| [IAC, WILL, *option]);
        let opening = offers.chain(theirs.iter().flat_map(|option| [IAC, DO, *option])).collect();
        (Self { state: State::Data, baud, ours, theirs, has_heard_command: false }, opening)
    }

    /// The octets of the line among `octets`; appends the replies of this side and what the server has said.
    fn decode(&mut self, octets: &[u8], replies: &mut Vec<u8>, answers: &mut Vec<Answer>) -> Vec<u8> {
        let mut line = Vec::new();
        for octet in octets {
            self.state = match (std::mem::take(&mut self.state), *octet) {
                (State::Data, IAC) => State::Command,
                (State::Data, octet) => {
                    line.push(octet);
                    State::Data
                }
                (State::Command, IAC) => {
                    line.push(IAC);
                    State::Data
                }
                (State::Command, SUBNEGOTIATION) => State::Inside(Vec::new()),
                (State::Command, verb @ WILL..=DONT) => State::Option(verb),
                // Commands without an option, such as "are you there", need no reply here.
                (State::Command, _) => State::Data,
                (State::Option(verb), option) => {
                    self.option(verb, option, replies, answers);
                    State::Data
                }
                (State::Inside(text), IAC) => State::InsideCommand(text),
                (State::Inside(mut text), octet) | (State::InsideCommand(mut text), octet @ IAC) => {
                    if text.len() < LONGEST {
                        text.push(octet);
                    }
                    State::Inside(text)
                }
                (State::InsideCommand(text), END) => {
                    answers.extend(answer(&text));
                    State::Data
                }
                // The subnegotiation was cut off, and another command follows.
                (State::InsideCommand(_), verb @ WILL..=DONT) => State::Option(verb),
                (State::InsideCommand(_), SUBNEGOTIATION) => State::Inside(Vec::new()),
                (State::InsideCommand(_), _) => State::Data,
            };
        }
        line
    }

    /// Answers a command with an option. A command that changes nothing has no answer, or both sides would go on for ever (RFC 854).
    fn option(&mut self, verb: u8, option: u8, replies: &mut Vec<u8>, answers: &mut Vec<Answer>) {
        self.has_heard_command = true;
        match verb {
            DO if option == COM_PORT && self.baud.is_some() => replies.extend(self.settings()),
            DO if self.ours.contains(&option) => {}
            DO => replies.extend([IAC, WONT, option]),
            DONT => {
                if self.ours.remove(&option) {
                    answers.extend(refused(option));
                }
            }
            // The server may echo what it likes: the master hears its own telegrams only on an RS-485 line.
            WILL if matches!(option, BINARY | NO_GO_AHEAD | COM_PORT) => {
                if self.theirs.insert(option) {
                    replies.extend([IAC, DO, option]);
                }
            }
            WILL if option == ECHO => replies.extend([IAC, DONT, ECHO]),
            WILL => replies.extend([IAC, DONT, option]),
            _ => {
                if self.theirs.remove(&option) && option == BINARY {
                    answers.push(Answer::NotBinary);
                }
            }
        }
    }

    /// The commands that set rate, 8E1 and no flow control.
    fn settings(&self) -> Vec<u8> {
        let Some(baud) = self.baud else { return Vec::new() };
        let rate = baud.bits_per_second().to_be_bytes();
        let commands: [(u8, &[u8]); 5] = [
            (SET_BAUD, &rate),
            (SET_DATA_SIZE, &[8]),
            (SET_PARITY, &[EVEN]),
            (SET_STOP_SIZE, &[1]),
            (SET_CONTROL, &[NO_FLOW_CONTROL]),
        ];
        let mut octets = Vec::new();
        for (command, value) in commands {
            octets.extend([IAC, SUBNEGOTIATION, COM_PORT, command]);
            octets.extend(doubled(value));
            octets.extend([IAC, END]);
        }
        octets
    }
}

/// What follows if the server does not let this side use the option.
fn refused(option: u8) -> Option<Answer> {
    match option {
        COM_PORT => Some(Answer::NoControl),
        BINARY => Some(Answer::NotBinary),
        _ => None,
    }
}

/// What a subnegotiation says about the port.
fn answer(text: &[u8]) -> Option<Answer> {
    let (option, rest) = text.split_first()?;
    let (command, value) = rest.split_first()?;
    match (*option, command.checked_sub(ANSWER)?, value) {
        (COM_PORT, SET_BAUD, value) => Some(Answer::Rate(u32::from_be_bytes(value.try_into().ok()?))),
        (COM_PORT, SET_PARITY, [parity]) => Some(Answer::Parity(*parity)),
        _ => None,
    }
}

/// Octets of the line as telnet sends them: FF twice.
fn doubled(octets: &[u8]) -> Vec<u8> {
    octets.iter().flat_map(|octet| std::iter::repeat_n(*octet, if *octet == IAC { 2 } else { 1 })).collect()
}

/// A connection to a serial server that speaks telnet.
#[derive(Debug)]
pub struct TelnetClient {
    name: String,
    socket: TcpStream,
    telnet: Telnet,
    baud: Option<Baud>,
    drops: DropCounter,
    notices: Notices,
    /// The kinds of notices about the server that were given: it may send its answers again and again.
    told: Vec<Discriminant<Notice>>,
    /// The rest of what the server did not take at once. Half a command or half a doubled FF would change the meaning of what follows.
    unsent: Vec<u8>,
}

impl TelnetClient {
    /// Speaks telnet over `socket`, which must not block. With `baud` it sets rate and 8E1 by RFC 2217.
    ///
    /// # Errors
    /// [`PortError::Lost`] if the server has closed the connection.
    pub(super) fn begin(name: String, socket: TcpStream, baud: Option<Baud>) -> Result<Self, PortError> {
        let (telnet, opening) = Telnet::begin(baud);
        let mut client = Self {
            name,
            socket,
            telnet,
            baud,
            drops: DropCounter::default(),
            notices: Notices::default(),
            told: Vec::new(),
            unsent: Vec::new(),
        };
        client.write(&opening)?;
        Ok(client)
    }

    /// Sends `octets` whole, now or later, or drops them whole while the rest of others waits.
    fn write(&mut self, octets: &[u8]) -> Result<(), PortError> {
        self.complete()?;
        let taken = if self.unsent.is_empty() { self.write_now(octets)? } else { 0 };
        let rest = octets.get(taken..).filter(|_| taken > 0).unwrap_or_default();
        self.unsent.extend(rest);
        let kept = if taken > 0 { octets.len() } else { 0 };
        self.notices.extend(self.drops.sent(&self.name, octets.len(), kept));
        Ok(())
    }

    /// Sends what the server did not take before.
    fn complete(&mut self) -> Result<(), PortError> {
        if !self.unsent.is_empty() {
            let rest = std::mem::take(&mut self.unsent);
            let taken = self.write_now(&rest)?;
            self.unsent.extend(rest.get(taken..).unwrap_or_default());
        }
        Ok(())
    }

    fn write_now(&mut self, octets: &[u8]) -> Result<usize, PortError> {
        write_now(&mut self.socket, octets).ok_or_else(|| PortError::Lost(self.name.clone()))
    }

    /// The notice about a setting that the server does not take.
    fn notice(&self, answer: Answer) -> Option<Notice> {
        let name = self.name.clone();
        match (answer, self.baud) {
            (Answer::NotBinary, _) => Some(Notice::NotBinary(name)),
            (Answer::NoControl, Some(_)) => Some(Notice::NoPortControl(name)),
            (Answer::Rate(rate), Some(baud)) if rate != baud.bits_per_second() => {
                Some(Notice::ServerRate { name, rate, baud })
            }
            (Answer::Parity(parity), Some(_)) if parity != EVEN => Some(Notice::ServerParity(name)),
            _ => None,
        }
    }

    /// Gives the notices about `answers` whose kind was not given before.
    fn tell(&mut self, answers: Vec<Answer>) {
        for answer in answers {
            if let Some(notice) = self.notice(answer)
                && !self.told.contains(&discriminant(&notice))
            {
                self.told.push(discriminant(&notice));
                self.notices.extend([notice]);
            }
        }
    }
}

impl Connection for TelnetClient {
    // chosen: a server that speaks telnet answers the opening.
    const PATIENCE: Duration = Duration::from_secs(1);

    fn socket(&self) -> &TcpStream {
        &self.socket
    }

    /// The octets of the line among them are lost, as before a plug is in.
    fn hear(&mut self, heard: &mut Vec<u8>) -> Result<(), PortError> {
        let mut characters = Vec::new();
        self.receive(&mut characters)?;
        heard.extend(characters.into_iter().filter_map(|character| match character {
            Character::Octet(octet) => Some(octet),
            Character::Error => None,
        }));
        Ok(())
    }

    fn check_server(&mut self, heard: &[u8]) {
        let name = self.name.clone();
        self.notices.extend(words(heard).map(|words| Notice::ServerBanner { name, words }));
        // A server of raw octets has put the opening on the line.
        if !self.telnet.has_heard_command {
            self.notices.extend([Notice::NoTelnetServer(self.name.clone())]);
        }
    }
}

impl Port for TelnetClient {
    fn name(&self) -> &str {
        &self.name
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        vec![Readiness::of(&self.socket)]
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        let mut buffer = [0; CHUNK];
        let length = match self.socket.read(&mut buffer) {
            Ok(length) if length > 0 => length,
            Err(error) if is_temporary(&error) => return Ok(()),
            _ => return Err(PortError::Lost(self.name.clone())),
        };
        let (mut replies, mut answers) = (Vec::new(), Vec::new());
        let octets = self.telnet.decode(buffer.get(..length).unwrap_or_default(), &mut replies, &mut answers);
        characters.extend(octets.into_iter().map(Character::Octet));
        self.tell(answers);
        self.complete()?;
        if replies.is_empty() { Ok(()) } else { self.write(&replies) }
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        self.write(&doubled(octets))
    }

    fn next_notice(&mut self) -> Option<Notice> {
        self.notices.next()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use std::net::TcpListener;

    fn decode(telnet: &mut Telnet, octets: &[u8]) -> (Vec<u8>, Vec<u8>, Vec<Answer>) {
        let (mut replies, mut answers) = (Vec::new(), Vec::new());
        let line = telnet.decode(octets, &mut replies, &mut answers);
        (line, replies, answers)
    }

    #[test]
    fn octets_of_the_line_pass_and_ff_is_doubled() {
        let (mut telnet, opening) = Telnet::begin(None);
        assert_eq!(opening, [IAC, WILL, 0, IAC, WILL, 3, IAC, DO, 0, IAC, DO, 3]);
        let all: Vec<u8> = (0..=255).chain([0xFF, 0xFF, 0]).collect();
        let sent = doubled(&all);
        assert_eq!(sent.len(), all.len() + 3);
        for portion in [1, 2, 3, 500] {
            let octets: Vec<u8> = sent.chunks(portion).flat_map(|octets| decode(&mut telnet, octets).0).collect();
            assert_eq!(octets, all, "portions of {portion}");
        }
    }

    #[test]
    fn each_command_has_one_answer_and_one_that_changes_nothing_has_none() {
        let (mut telnet, _) = Telnet::begin(None);
        for (command, reply) in [
            (&[IAC, DO, BINARY][..], &[][..]),
            (&[IAC, WILL, BINARY], &[]),
            (&[IAC, WILL, ECHO], &[IAC, DONT, ECHO]),
            (&[IAC, DO, 24], &[IAC, WONT, 24]),
            (&[IAC, WILL, 33], &[IAC, DONT, 33]),
            (&[IAC, DO, COM_PORT], &[IAC, WONT, COM_PORT]),
            (&[IAC, WILL, COM_PORT], &[IAC, DO, COM_PORT]),
            (&[IAC, WILL, COM_PORT], &[]),
            (&[IAC, DONT, NO_GO_AHEAD], &[]),
            (&[IAC, WONT, NO_GO_AHEAD], &[]),
            (&[IAC, 0xF6], &[]),
        ] {
            assert_eq!(decode(&mut telnet, command), (vec![], reply.to_vec(), vec![]), "{command:?}");
        }
        for refusal in [[IAC, DONT, BINARY], [IAC, WONT, BINARY]] {
            assert_eq!(decode(&mut telnet, &refusal), (vec![], vec![], vec![Answer::NotBinary]));
            assert_eq!(decode(&mut telnet, &refusal), (vec![], vec![], vec![]), "said once");
        }
        assert_eq!(decode(&mut telnet, &[0xE5]).0, [0xE5]);
    }

    #[test]
    fn a_server_that_gives_control_gets_rate_and_8e1() {
        let (mut telnet, opening) = Telnet::begin(Some(Baud::B187500));
        assert!(opening.windows(3).any(|command| command == [IAC, WILL, COM_PORT]));
        let (line, replies, _) = decode(&mut telnet, &[0x10, IAC, DO, COM_PORT, 0x16]);
        assert_eq!(line, [0x10, 0x16]);
        let expected = [
            &[IAC, SUBNEGOTIATION, COM_PORT, SET_BAUD, 0, 2, 0xDC, 0x6C, IAC, END][..],
            &[IAC, SUBNEGOTIATION, COM_PORT, SET_DATA_SIZE, 8, IAC, END],
            &[IAC, SUBNEGOTIATION, COM_PORT, SET_PARITY, EVEN, IAC, END],
            &[IAC, SUBNEGOTIATION, COM_PORT, SET_STOP_SIZE, 1, IAC, END],
            &[IAC, SUBNEGOTIATION, COM_PORT, SET_CONTROL, NO_FLOW_CONTROL, IAC, END],
        ];
        assert_eq!(replies, expected.concat());
        let rate = [IAC, SUBNEGOTIATION, COM_PORT, ANSWER + SET_BAUD, 0, 0, 0x25, 0x80, IAC, END];
        let answers: Vec<Answer> = rate.chunks(1).flat_map(|octet| decode(&mut telnet, octet).2).collect();
        assert_eq!(answers, [Answer::Rate(9600)]);
        assert_eq!(decode(&mut telnet, &[IAC, DONT, COM_PORT]).2, [Answer::NoControl]);
    }

    /// Nothing that a server sends fills the memory or ends the reading.
    #[test]
    fn a_subnegotiation_without_end_is_kept_up_to_a_limit() {
        let (mut telnet, _) = Telnet::begin(Some(Baud::B19200));
        decode(&mut telnet, &[IAC, SUBNEGOTIATION]);
        decode(&mut telnet, &[7; 100_000]);
        assert!(matches!(&telnet.state, State::Inside(text) if text.len() == LONGEST));
        assert_eq!(decode(&mut telnet, &[IAC, 9, 0xE5]).0, [0xE5]);
        for octets in [&[IAC, SUBNEGOTIATION, IAC, END][..], &[IAC, SUBNEGOTIATION, COM_PORT, IAC, END]] {
            assert_eq!(decode(&mut telnet, octets), (vec![], vec![], vec![]));
        }
    }

    /// A command inside a subnegotiation ends it, and its option is no octet of the line.
    #[test]
    fn a_subnegotiation_that_is_cut_off_loses_no_command() {
        let (mut telnet, _) = Telnet::begin(Some(Baud::B19200));
        let cut = [IAC, SUBNEGOTIATION, COM_PORT, 101, IAC, WONT, BINARY, 0xE5];
        assert_eq!(decode(&mut telnet, &cut), (vec![0xE5], vec![], vec![Answer::NotBinary]));
        let rate = [COM_PORT, ANSWER + SET_BAUD, 0, 0, 0x4B, 0, IAC, END, 0xE5];
        let cut = [&[IAC, SUBNEGOTIATION, 9, IAC, SUBNEGOTIATION][..], &rate].concat();
        assert_eq!(decode(&mut telnet, &cut), (vec![0xE5], vec![], vec![Answer::Rate(19_200)]));
    }

    fn connected(baud: Option<Baud>) -> (TelnetClient, TcpStream) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let socket = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        socket.set_nonblocking(true).unwrap();
        let client = TelnetClient::begin("rfc2217://x:1".to_owned(), socket, baud).unwrap();
        let (server, _) = listener.accept().unwrap();
        // What does not come within this time does not come.
        server.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        (client, server)
    }

    fn receive(client: &mut TelnetClient, count: usize) -> Vec<Character> {
        let mut characters = Vec::new();
        while characters.len() < count {
            let ready = crate::readiness::wait(&client.readiness(), Duration::from_secs(60)).unwrap();
            assert_eq!(ready, [true], "{characters:?} and no more in a minute");
            client.receive(&mut characters).unwrap();
        }
        characters
    }

    /// The server reads nothing until the system takes no octet more; then it reads everything.
    #[test]
    fn a_telegram_reaches_a_slow_server_whole_or_not_at_all() {
        let (mut client, mut server) = connected(None);
        let telegram: Vec<u8> = std::iter::repeat_n(0xFF, 61).chain([0x16]).collect();
        let mut sent = 0;
        while client.next_notice().is_none() {
            client.send(&telegram).unwrap();
            sent += 1;
        }
        let opening = Telnet::begin(None).1.len();
        let whole = doubled(&telegram);
        let mut heard = vec![0; opening];
        server.read_exact(&mut heard).unwrap();
        for _ in 0..sent - 1 {
            let mut part = vec![0; whole.len()];
            client.complete().unwrap();
            server.read_exact(&mut part).unwrap();
            assert_eq!(part, whole);
        }
        client.send(&[0x10]).unwrap();
        drop(client);
        let mut rest = Vec::new();
        server.read_to_end(&mut rest).unwrap();
        assert_eq!(rest, [0x10]);
    }

    #[test]
    fn a_server_that_repeats_an_answer_is_named_once() {
        let (mut client, mut server) = connected(Some(Baud::B19200));
        let answer = [IAC, SUBNEGOTIATION, COM_PORT, ANSWER + SET_BAUD, 0, 1, 0xC2, 0, IAC, END];
        server.write_all(&answer.repeat(40)).unwrap();
        server
            .write_all(&[IAC, SUBNEGOTIATION, COM_PORT, ANSWER + SET_BAUD, 0, 0, 0x25, 0x80, IAC, END, 0xE5])
            .unwrap();
        receive(&mut client, 1);
        let notices: Vec<Notice> = std::iter::from_fn(|| client.next_notice()).collect();
        assert_eq!(notices.len(), 1, "{notices:?}");
    }

    #[test]
    fn no_rate_is_searched_behind_a_server() {
        let (mut client, _server) = connected(Some(Baud::B19200));
        assert!(matches!(client.set_baud(Baud::B93750), Err(PortError::NoBaudRate(_))));
    }

    /// A server over a real connection: what it refuses becomes a notice, and the octets pass.
    #[test]
    fn a_server_that_runs_at_another_rate_is_named() {
        let (mut client, mut server) = connected(Some(Baud::B93750));
        server.write_all(&[IAC, SUBNEGOTIATION, COM_PORT, ANSWER + SET_BAUD, 0, 1, 0xC2, 0, IAC, END]).unwrap();
        server.write_all(&[IAC, SUBNEGOTIATION, COM_PORT, ANSWER + SET_PARITY, 1, IAC, END, IAC, IAC, 0xE5]).unwrap();
        let characters = receive(&mut client, 2);
        assert_eq!(characters, [Character::Octet(0xFF), Character::Octet(0xE5)]);
        let notices: Vec<String> =
            std::iter::from_fn(|| client.next_notice()).map(|notice| notice.to_string()).collect();
        assert!(notices.iter().any(|text| text.contains("115200") && text.contains("93750")), "{notices:?}");
        assert!(notices.iter().any(|text| text.contains("even parity")), "{notices:?}");
        client.send(&[0xFF, 0x10]).unwrap();
        let mut sent = vec![0; 18];
        server.read_exact(&mut sent).unwrap();
        assert_eq!(sent.get(15..), Some(&[0xFF, 0xFF, 0x10][..]));
    }
}
