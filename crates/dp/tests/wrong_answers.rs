//! A wrong answer of any kind never becomes a value, and the trouble is named. profibus-wire 1.3, 1.5, 2.2 and 2.8.
//!
//! For every request of a class 1 master and of a tool beside it, a table of answers with one defect each. All of them carry
//! poison: values that differ from what the master knows. [`Case::takes_the_right_answer`] shows for every kind that
//! the same answer without the defect is taken, so it is the defect alone that keeps the poison out.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

mod support;

use profivac_dp::link::active::{Active, Confirmation, Request};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::services::{self, NoResult};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters, What};
use support::desk::{Desk, Said};
use support::{bus, hex};

const IDENT: u16 = 0x1234;
/// Two octets in, two octets out.
const CFG: [u8; 2] = [0x11, 0x21];

const THERE: &str = "10 02 08 00 0A 16";
const POWER_UP: &str = "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16";
const READY: &str = "68 0B 0B 68 82 88 08 3E 3C 00 0C 00 02 12 34 E0 16";
const INPUTS: &str = "68 05 05 68 02 08 08 01 02 15 16";
const INPUTS_HIGH: &str = "68 05 05 68 02 08 0A 01 02 17 16";

type Station = Desk<Master<4, 32>>;

/// An answer to be spoilt: addresses, FC, access points and data.
#[derive(Clone, Debug)]
struct Answer {
    da: u8,
    sa: u8,
    fc: u8,
    saps: Option<[u8; 2]>,
    du: Vec<u8>,
}

impl Answer {
    fn of(fc: u8, saps: Option<[u8; 2]>, du: &[u8]) -> Self {
        Self { da: 2, sa: 8, fc, saps, du: du.to_vec() }
    }

    /// SD1 where nothing follows FC, else SD2.
    fn octets(&self) -> Vec<u8> {
        let extended = if self.saps.is_some() { 0x80 } else { 0 };
        let mut body = vec![self.da | extended, self.sa | extended, self.fc];
        body.extend(self.saps.into_iter().flatten());
        body.extend(&self.du);
        let fcs = body.iter().fold(0u8, |sum, octet| sum.wrapping_add(*octet));
        let le = body.len() as u8;
        let mut octets = if le == 3 { vec![0x10] } else { vec![0x68, le, le, 0x68] };
        octets.extend(body);
        octets.extend([fcs, 0x16]);
        octets
    }
}

/// What the master knows of slave 8, and where it stands.
#[derive(Clone, Debug, PartialEq)]
struct Known {
    inputs: Option<Vec<u8>>,
    diagnosis: Option<(u32, u8, u16, Vec<u8>)>,
    state: Option<String>,
    exchanges: u32,
    diagnoses: u32,
}

fn known(desk: &Station) -> Known {
    let master = &desk.station.user;
    let counters = master.counters(8).unwrap();
    Known {
        inputs: master.inputs(8).map(<[u8]>::to_vec),
        diagnosis: master
            .diagnosis(8)
            .map(|diag| (diag.status.bits(), diag.master_add, diag.ident, diag.ext_diag.to_vec())),
        state: master.state(8).map(|state| state.to_string()),
        exchanges: counters.exchanges,
        diagnoses: counters.diagnoses,
    }
}

/// A single request, and what its answer comes to.
#[derive(Clone, Copy)]
struct Tool {
    request: Request<'static>,
    read: fn(&Confirmation<'_>) -> Result<Vec<u8>, NoResult>,
}

/// A request on the line, and the answer to it.
struct Case {
    name: &'static str,
    /// Plays until this request is on the line.
    asked: fn() -> Station,
    tool: Option<Tool>,
    /// The right answer, with values that nobody knows yet.
    right: Answer,
    /// What the station answered last: the former request.
    former: &'static str,
    /// The lengths that are wrong, and what is said about them; none where every length is right.
    lengths: &'static [(usize, &'static str)],
}

fn desk() -> Station {
    let mut master: Active<Master<4, 32>> = {
        let settings = Settings { control_cycles: 0, ..Settings::new(Baud::B1500000) };
        Master::on(bus(), settings, BitTime(0))
    };
    master.user.add(&SlaveParameters::new(8, IDENT, &CFG)).unwrap();
    master.user.set_mode(Mode::Operate);
    let mut desk = Desk::new(master);
    desk.asks();
    desk
}

/// The next request after these answers.
fn after(answers: &[&str]) -> Station {
    let mut desk = desk();
    for answer in answers {
        desk.hears(answer);
        desk.asks();
    }
    desk
}

fn fdl_status() -> Station {
    desk()
}

fn first_diag() -> Station {
    after(&[THERE])
}

fn set_prm() -> Station {
    after(&[THERE, POWER_UP])
}

fn chk_cfg() -> Station {
    after(&[THERE, POWER_UP, "E5"])
}

fn second_diag() -> Station {
    after(&[THERE, POWER_UP, "E5", "E5"])
}

/// Operate goes first, without an answer.
fn first_exchange() -> Station {
    let mut desk = after(&[THERE, POWER_UP, "E5", "E5", READY]);
    desk.asks();
    desk
}

fn exchange() -> Station {
    let mut desk = first_exchange();
    desk.hears(INPUTS);
    desk.asks();
    desk
}

fn diag_in_exchange() -> Station {
    let mut desk = exchange();
    desk.hears(INPUTS_HIGH);
    desk.asks();
    desk
}

const MS0: [u8; 2] = [0x3E, 0];

/// The access points of an answer of this service.
fn saps(service: u8) -> Option<[u8; 2]> {
    Some([MS0[0], service])
}

fn cyclic() -> Vec<Case> {
    let diag = |du: &[u8]| Answer::of(8, saps(0x3C), du);
    let too_short: &[_] = &[(5, "its answer has 5 octets instead of 6"), (1, "its answer has 1 octets instead of 6")];
    let data: &[_] = &[(1, "it answers with data where it should only acknowledge")];
    let case = |name, asked, right, former, lengths| Case { name, asked, tool: None, right, former, lengths };
    vec![
        case("FDL status", fdl_status, Answer::of(0, None, &[]), INPUTS, &[(1, FORM)]),
        case("Slave_Diag before Set_Prm", first_diag, diag(&[2, 5, 0, 0xFF, 0x12, 0x34, 2, 9]), THERE, too_short),
        case("Set_Prm", set_prm, Answer::of(9, None, &[]), POWER_UP, data),
        case("Chk_Cfg", chk_cfg, Answer::of(9, None, &[]), POWER_UP, data),
        case("Slave_Diag after Chk_Cfg", second_diag, diag(&[0, 0xC, 0, 2, 0x12, 0x34, 2, 9]), INPUTS, too_short),
        case(
            "Data_Exchange",
            exchange,
            Answer::of(8, None, &[7, 7]),
            READY,
            &[
                (0, "its answer has 0 octets instead of 2"),
                (1, "its answer has 1 octets instead of 2"),
                (3, "its answer has 3 octets instead of 2"),
                (40, "its answer has 40 octets instead of 2"),
            ],
        ),
        case(
            "Slave_Diag in exchange",
            diag_in_exchange,
            diag(&[8, 0xC, 0, 2, 0x12, 0x34, 2, 9]),
            INPUTS_HIGH,
            too_short,
        ),
    ]
}

fn tools() -> Vec<Case> {
    let tool = |name, request, read, right, lengths| Case {
        name,
        asked: exchange,
        tool: Some(Tool { request, read }),
        right,
        former: INPUTS,
        lengths,
    };
    vec![
        tool(
            "FDL status",
            services::fdl_status(8),
            |c| services::station(c).map(|_| vec![]),
            Answer::of(0, None, &[]),
            &[(1, FORM)],
        ),
        tool(
            "Slave_Diag",
            services::slave_diag(8),
            |c| services::diagnosis(c).map(|diag| diag.ext_diag.to_vec()),
            Answer::of(8, saps(0x3C), &[8, 0xC, 0, 2, 0x12, 0x34, 2, 9]),
            &[(5, "its answer has 5 octets instead of 6")],
        ),
        tool(
            "Get_Cfg",
            services::get_cfg(8),
            |c| services::configuration(c).map(|(octets, _)| octets.to_vec()),
            Answer::of(8, saps(0x3B), &[0xC1, 0x81, 0x84, 0x85]),
            &[
                (3, "its configuration is none: the last identifier announces more octets than follow"),
                (0, "its configuration is none: no identifier"),
            ],
        ),
        tool(
            "RD_Inp",
            services::rd_inp(8),
            |c| services::image(c, Some(2)).map(<[u8]>::to_vec),
            Answer::of(8, saps(0x38), &[7, 7]),
            &[(1, "its answer has 1 octets instead of 2"), (3, "its answer has 3 octets instead of 2")],
        ),
        tool(
            "RD_Outp",
            services::rd_outp(8),
            |c| services::image(c, Some(2)).map(<[u8]>::to_vec),
            Answer::of(8, saps(0x39), &[7, 7]),
            &[(1, "its answer has 1 octets instead of 2"), (3, "its answer has 3 octets instead of 2")],
        ),
        tool(
            "Set_Slave_Add",
            services::set_slave_add(8, &[5, 0x12, 0x34, 0]),
            |c| services::acknowledged(c).map(|()| vec![]),
            Answer::of(9, None, &[]),
            &[(1, "it answers with data where it should only acknowledge")],
        ),
    ]
}

const FORM: &str = "the form of the answer does not fit the request";
const OTHER_SAPS: &str = "the answer belongs to other service access points";

fn is_exchange(said: &Said) -> bool {
    matches!(said.octets[..], [0x68, 5, 5, 0x68, 8, 2, ..])
}

impl Case {
    /// Answers every try of the request with these octets until it comes to something: the words for it, and the values
    /// of a tool where there are some.
    fn answered(&self, desk: &mut Station, octets: &[u8]) -> Result<Vec<u8>, String> {
        match &self.tool {
            None => Self::cycle_answered(desk, octets),
            Some(tool) => Self::tool_answered(desk, tool, octets),
        }
    }

    fn cycle_answered(desk: &mut Station, octets: &[u8]) -> Result<Vec<u8>, String> {
        let state = desk.station.user.state(8);
        let exchanges = desk.station.user.counters(8).unwrap().exchanges;
        for _ in 0..8 {
            if !octets.is_empty() {
                desk.hears_octets(11, octets);
            }
            desk.asks();
            if let Some(trouble) = desk.station.user.trouble(8) {
                return Err(trouble.to_string());
            }
            if desk.station.user.state(8) != state || desk.station.user.counters(8).unwrap().exchanges != exchanges {
                return Ok(Vec::new());
            }
        }
        panic!("it does not come to anything");
    }

    /// Data_Exchange with the same slave goes on as it should.
    fn tool_answered(desk: &mut Station, tool: &Tool, octets: &[u8]) -> Result<Vec<u8>, String> {
        desk.station.user.submit(&tool.request).unwrap();
        desk.hears(INPUTS);
        for _ in 0..20 {
            match desk.asks() {
                said if is_exchange(&said) => desk.hears(INPUTS),
                _ if octets.is_empty() => {}
                _ => desk.hears_octets(11, octets),
            }
            if let Some(confirmation) = desk.station.user.take() {
                return (tool.read)(&confirmation).map_err(|reason| reason.to_string());
            }
        }
        panic!("there is no result");
    }

    fn takes_the_right_answer(&self) {
        let mut desk = (self.asked)();
        let before = known(&desk);
        let result = self.answered(&mut desk, &self.right.octets());
        assert!(result.is_ok(), "{}: {result:?}", self.name);
        match &self.tool {
            None => assert_ne!(known(&desk), before, "{}: the poison works", self.name),
            // Where there are data, the end of them is what a tool is told.
            Some(_) => assert!(self.right.du.ends_with(&result.unwrap()), "{}", self.name),
        }
    }

    /// The defect keeps the poison out, and is named.
    fn refuses(&self, what: &str, octets: &[u8], words: &str) {
        let mut desk = (self.asked)();
        let before = known(&desk);
        let result = self.answered(&mut desk, octets);
        assert_eq!(result, Err(words.to_string()), "{}, {what}", self.name);
        self.nothing_is_new(&desk, &before, what);
    }

    fn nothing_is_new(&self, desk: &Station, before: &Known, what: &str) {
        let now = known(desk);
        match &self.tool {
            // The slave may have been lost over it, and then there are no inputs at all.
            None => {
                assert!(now.inputs.is_none() || now.inputs == before.inputs, "{}, {what}: {now:?}", self.name);
                assert_eq!(
                    (now.exchanges, now.diagnoses),
                    (before.exchanges, before.diagnoses),
                    "{}, {what}",
                    self.name
                );
            }
            // A tool beside it disturbs nothing.
            Some(_) => {
                assert_eq!((&now.inputs, &now.state), (&before.inputs, &before.state), "{}, {what}", self.name);
            }
        }
        assert_eq!(now.diagnosis, before.diagnosis, "{}, {what}", self.name);
    }
}

fn all() -> impl Iterator<Item = Case> {
    cyclic().into_iter().chain(tools())
}

#[test]
fn the_right_answer_is_taken_by_every_request() {
    all().for_each(|case| case.takes_the_right_answer());
}

#[test]
fn an_answer_from_another_station_is_refused() {
    for case in all() {
        let wrong = Answer { sa: 9, ..case.right.clone() };
        case.refuses("source", &wrong.octets(), "the answer came from station 9");
    }
}

#[test]
fn an_answer_to_another_master_is_refused() {
    for case in all() {
        let wrong = Answer { da: 3, ..case.right.clone() };
        case.refuses("destination", &wrong.octets(), "the answer was for station 3");
    }
}

#[test]
fn an_answer_of_another_access_point_is_refused() {
    for case in all() {
        let right = &case.right;
        match right.saps {
            Some([master, slave]) => {
                for saps in [Some([master, slave ^ 1]), Some([master ^ 1, slave]), Some([slave, master]), None] {
                    let wrong = Answer { saps, ..right.clone() };
                    case.refuses("access point", &wrong.octets(), OTHER_SAPS);
                }
            }
            // Access points where there are none, or in an answer without data: no form that fits.
            None => {
                let words = if right.fc == 8 { OTHER_SAPS } else { FORM };
                let wrong = Answer { saps: saps(0x3C), ..right.clone() };
                case.refuses("access point", &wrong.octets(), words);
            }
        }
    }
}

#[test]
fn an_answer_with_another_function_code_is_refused() {
    for case in all() {
        let uncounted = case.right.fc == 0;
        // FDL status where data are due and the other way round; reserved ones.
        for fc in [if uncounted { 0x08 } else { 0x00 }, 0x04, 0x07, 0x0B, 0x0E, 0x0F, 0x88] {
            let wrong = Answer { fc, ..case.right.clone() };
            let words = format!("the answer's function code {fc:02X} does not fit the request");
            case.refuses("function", &wrong.octets(), &words);
        }
    }
}

/// A slave that answers with the function code of a request is no master: the token is kept, and the others go on.
#[test]
fn an_answer_with_the_function_code_of_a_request_is_refused() {
    for case in all() {
        for fc in [0x40, 0x43, 0x46, 0x49, 0x4C, 0x4D, 0x5D, 0x6D, 0x7D, 0x4E, 0x4F] {
            // Who is asked for its FDL status and asks for ours is another master.
            if case.right.fc == 0 && fc == 0x49 {
                continue;
            }
            let wrong = Answer { fc, ..case.right.clone() };
            let words = format!("the answer's function code {fc:02X} does not fit the request");
            case.refuses("request", &wrong.octets(), &words);
            let mut desk = (case.asked)();
            desk.hears_octets(11, &wrong.octets());
            assert!(desk.station.has_token(), "{} {fc:02X}", case.name);
        }
    }
}

#[test]
fn an_answer_of_another_length_is_refused() {
    for case in all() {
        for (length, words) in case.lengths {
            let mut du = case.right.du.clone();
            du.resize(*length, 7);
            let acknowledges = case.right.fc == 9;
            let wrong = if acknowledges {
                // Data where SC is due: with the access points that fit, so that the status alone is wrong.
                let service = [(0, 0x3D), (1, 0x3E)][usize::from(case.name == "Chk_Cfg")].1;
                let service = if case.tool.is_some() { 0x37 } else { service };
                Answer { fc: 8, saps: saps(service), du, ..case.right.clone() }
            } else {
                Answer { du, ..case.right.clone() }
            };
            case.refuses(&format!("{length} octets"), &wrong.octets(), words);
        }
    }
}

#[test]
fn a_short_acknowledgement_in_place_of_data_is_refused() {
    for case in all().filter(|case| case.right.fc != 9) {
        let image = case.name == "Data_Exchange" || case.name.starts_with("RD_");
        let words = match (case.right.fc, image) {
            (0, _) => FORM,
            (_, true) => "its answer has 0 octets instead of 2",
            (_, false) => "it acknowledges where it should answer with data",
        };
        case.refuses("SC", &[0xE5], words);
    }
}

#[test]
fn silence_is_named() {
    all().for_each(|case| case.refuses("nothing", &[], "no answer"));
}

#[test]
fn the_answer_to_the_former_request_is_refused_when_it_comes_again() {
    for case in all() {
        let former = hex(case.former);
        let function = format!("the answer's function code {:02X} does not fit the request", 0x08);
        let words = match (case.right.fc, former.len()) {
            (0, _) => function.as_str(),
            (_, 6) => "the answer's function code 00 does not fit the request",
            _ => OTHER_SAPS,
        };
        case.refuses("repeated", &former, words);
    }
}

#[test]
fn a_truncated_answer_is_refused() {
    for case in all() {
        let octets = case.right.octets();
        for length in 1..octets.len() {
            case.refuses(&format!("{length} octets of it"), &octets[..length], "the answer is damaged");
        }
    }
}

#[test]
fn an_answer_with_an_altered_octet_is_refused() {
    for case in all() {
        let octets = case.right.octets();
        for position in 0..octets.len() {
            for bit in 0..8 {
                let mut wrong = octets.clone();
                wrong[position] ^= 1 << bit;
                case.refuses(&format!("octet {position}, bit {bit}"), &wrong, "the answer is damaged");
            }
        }
    }
}

/// It comes when the master has given up and asks another station.
#[test]
fn a_late_answer_does_not_become_the_answer_to_the_next_request() {
    for case in cyclic() {
        let mut desk = (case.asked)();
        let before = known(&desk);
        desk.station.user.submit(&services::slave_diag(9)).unwrap();
        // Station 9 is asked once the cycle is over; whatever is asked of station 8 until then stays unanswered.
        while desk.asks().octets[4] & 0x7F != 9 {}
        desk.hears_octets(100, &case.right.octets());
        desk.says();
        let result =
            desk.station.user.take().map(|confirmation| services::diagnosis(&confirmation).unwrap_err().to_string());
        assert_eq!(result.as_deref(), Some("the answer came from station 8"), "{}", case.name);
        case.nothing_is_new(&desk, &before, "late");
    }
    for case in tools() {
        let mut desk = (case.asked)();
        let before = known(&desk);
        let tool = case.tool.unwrap();
        desk.station.user.submit(&tool.request).unwrap();
        desk.hears(INPUTS);
        // Unanswered, again and again, until the exchange is asked for.
        while !is_exchange(&desk.asks()) {}
        desk.hears_octets(100, &case.right.octets());
        // The exchange is asked for once more, and answered as it should.
        desk.asks();
        desk.hears(INPUTS);
        let result = desk.station.user.take().map(|confirmation| (tool.read)(&confirmation).unwrap_err().to_string());
        assert_eq!(result.as_deref(), Some("no answer"), "{}", case.name);
        // An acknowledgement is one to anything. It has no length of inputs, and so it is no value either.
        if case.right.fc == 9 {
            let trouble = desk.station.user.trouble(8).unwrap().to_string();
            assert_eq!((trouble.as_str(), known(&desk).inputs), ("its answer has 0 octets instead of 2", None));
        } else {
            case.nothing_is_new(&desk, &before, "late");
        }
    }
}

/// Two stations at one address, one slower than the other: the first answer is an answer, the second never is.
#[test]
fn the_second_answer_of_a_twin_is_nobodys() {
    for case in all() {
        let mut twin = case.right.clone();
        twin.du.iter_mut().rev().take(1).for_each(|octet| *octet ^= 0x40);
        let mut desk = (case.asked)();
        if let Some(tool) = &case.tool {
            desk.station.user.submit(&tool.request).unwrap();
            desk.hears(INPUTS);
            desk.asks();
        }
        desk.hears_octets(11, &case.right.octets());
        let before = known(&desk);
        while desk.station.user.next_event().is_some() {}
        // Within T_ID1, and a third one as well.
        desk.hears_octets(15, &twin.octets());
        desk.hears_octets(200, &twin.octets());
        assert_eq!(known(&desk), before, "{}", case.name);
        assert_eq!(strays(&mut desk), (2, 1), "{}: counted each time, told once", case.name);
        if let Some(tool) = &case.tool {
            let result = desk.station.user.take().map(|confirmation| (tool.read)(&confirmation).unwrap());
            assert!(case.right.du.ends_with(&result.unwrap()), "{}", case.name);
        }
    }
}

/// How many answers to nothing slave 8 has given, and how many events tell of them.
fn strays(desk: &mut Station) -> (u32, usize) {
    let events = std::iter::from_fn(|| desk.station.user.next_event());
    let told = events.filter(|event| (event.address, event.what) == (8, What::Stray)).count();
    (desk.station.user.counters(8).unwrap().strays, told)
}

/// SC does not say who sends it: it counts for the slave that has just answered, and for nobody if none has.
#[test]
fn a_second_acknowledgement_counts_for_who_was_asked() {
    let mut desk = set_prm();
    desk.hears("E5");
    desk.hears_after(15, "E5");
    assert_eq!(strays(&mut desk), (1, 1));
    let mut desk = desk_in_pause();
    desk.hears_after(5, "E5");
    assert_eq!(strays(&mut desk), (0, 0));
}

/// The token has just come back, and nobody was asked since.
fn desk_in_pause() -> Station {
    let mut desk = exchange();
    desk.hears(INPUTS);
    while !desk.says().is_token() {}
    desk
}

#[test]
fn what_others_are_answered_is_no_second_answer() {
    let mut desk = exchange();
    desk.hears(INPUTS);
    // The same slave to master 3, and a slave that this master does not have.
    desk.hears_after(15, "68 05 05 68 03 08 08 01 02 16 16");
    desk.hears_after(15, "68 05 05 68 02 09 08 01 02 16 16");
    assert_eq!(strays(&mut desk), (0, 0));
}

/// A slave that was lost and comes back is another matter: the next second answer is told again.
#[test]
fn a_second_answer_is_told_again_after_the_slave_was_lost() {
    let mut desk = exchange();
    desk.hears(INPUTS);
    desk.hears_after(15, INPUTS);
    assert_eq!(strays(&mut desk), (1, 1));
    // It begins from the beginning.
    desk.station.user.restart(8);
    desk.asks();
    desk.hears(THERE);
    desk.hears_after(15, THERE);
    assert_eq!(strays(&mut desk), (2, 1));
}

/// Both at once: nothing that anybody can read.
#[test]
fn the_answers_of_twins_on_top_of_each_other_are_refused() {
    for case in all() {
        let one = case.right.octets();
        // Wired-and of two telegrams that begin a character apart.
        let mut both = one.clone();
        both.push(0xFF);
        for (octet, other) in both.iter_mut().skip(1).zip(&one) {
            *octet &= other;
        }
        case.refuses("on top of each other", &both, "the answer is damaged");
    }
}
