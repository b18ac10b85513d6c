//! The requests, their right answers, and the checks after a wrong one.

use crate::support::bus;
use crate::support::rig::{MasterRig, Sent};
use profivac_dp::link::active::{Active, Confirmation, Request};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::services::{self, ServiceError};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};

pub const IDENT: u16 = 0x1234;
/// Two octets in, two octets out.
pub const CFG: [u8; 2] = [0x11, 0x21];

pub const THERE: &str = "10 02 08 00 0A 16";
pub const POWER_UP: &str = "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16";
pub const READY: &str = "68 0B 0B 68 82 88 08 3E 3C 00 0C 00 02 12 34 E0 16";
pub const INPUTS: &str = "68 05 05 68 02 08 08 01 02 15 16";
pub const INPUTS_HIGH: &str = "68 05 05 68 02 08 0A 01 02 17 16";

pub type Station = MasterRig<Master<4, 32>>;

/// An answer that a test changes: addresses, FC, access points and data.
#[derive(Clone, Debug)]
pub struct Answer {
    pub da: u8,
    pub sa: u8,
    pub fc: u8,
    pub saps: Option<[u8; 2]>,
    pub du: Vec<u8>,
}

impl Answer {
    pub fn of(fc: u8, saps: Option<[u8; 2]>, du: &[u8]) -> Self {
        Self { da: 2, sa: 8, fc, saps, du: du.to_vec() }
    }

    /// SD1 where nothing follows FC, else SD2.
    pub fn octets(&self) -> Vec<u8> {
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

/// The data and the state of slave 8 in the master.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    pub inputs: Option<Vec<u8>>,
    pub diagnosis: Option<(u32, u8, u16, Vec<u8>)>,
    pub state: Option<String>,
    pub exchanges: u32,
    pub diagnoses: u32,
}

pub fn known(rig: &Station) -> Known {
    let master = &rig.station.user;
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

/// A raw request, and the function that reads its answer.
#[derive(Clone, Copy)]
pub struct Class2Rig {
    pub request: Request<'static>,
    pub read: fn(&Confirmation<'_>) -> Result<Vec<u8>, ServiceError>,
}

/// A request on the line, and the answer to it.
pub struct Case {
    pub name: &'static str,
    /// Runs the master until it has sent this request.
    pub asked: fn() -> Station,
    pub class2: Option<Class2Rig>,
    /// The right answer, with new values.
    pub right: Answer,
    /// The answer to the previous request.
    pub former: &'static str,
    /// The wrong lengths and their error texts; none if every length is right.
    pub lengths: &'static [(usize, &'static str)],
}

pub fn rig() -> Station {
    let mut master: Active<Master<4, 32>> = {
        let settings = Settings { control_cycles: 0, ..Settings::new(Baud::B1500000) };
        Master::on(bus().check().unwrap(), settings, BitTime(0))
    };
    master.user.add(&SlaveParameters::new(8, IDENT, &CFG)).unwrap();
    master.user.set_mode(Mode::Operate);
    let mut rig = MasterRig::new(master);
    rig.next_request();
    rig
}

/// The next request after these answers.
pub fn after(answers: &[&str]) -> Station {
    let mut rig = rig();
    for answer in answers {
        rig.receive(answer);
        rig.next_request();
    }
    rig
}

pub fn fdl_status() -> Station {
    rig()
}

pub fn first_diag() -> Station {
    after(&[THERE])
}

pub fn set_prm() -> Station {
    after(&[THERE, POWER_UP])
}

pub fn chk_cfg() -> Station {
    after(&[THERE, POWER_UP, "E5"])
}

pub fn second_diag() -> Station {
    after(&[THERE, POWER_UP, "E5", "E5"])
}

/// The master sends Operate first, which has no answer.
pub fn first_exchange() -> Station {
    let mut rig = after(&[THERE, POWER_UP, "E5", "E5", READY]);
    rig.next_request();
    rig
}

pub fn exchange() -> Station {
    let mut rig = first_exchange();
    rig.receive(INPUTS);
    rig.next_request();
    rig
}

pub fn diag_in_exchange() -> Station {
    let mut rig = exchange();
    rig.receive(INPUTS_HIGH);
    rig.next_request();
    rig
}

pub const MS0: [u8; 2] = [0x3E, 0];

/// The access points of an answer of this service.
pub fn saps(service: u8) -> Option<[u8; 2]> {
    Some([MS0[0], service])
}

pub fn cyclic() -> Vec<Case> {
    let diag = |du: &[u8]| Answer::of(8, saps(0x3C), du);
    let too_short: &[_] = &[(5, "its answer has 5 octets instead of 6"), (1, "its answer has 1 octets instead of 6")];
    let data: &[_] = &[(1, "it answers with data where it should only acknowledge")];
    let case = |name, asked, right, former, lengths| Case { name, asked, class2: None, right, former, lengths };
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

pub fn class2_cases() -> Vec<Case> {
    let case = |name, request, read, right, lengths| Case {
        name,
        asked: exchange,
        class2: Some(Class2Rig { request, read }),
        right,
        former: INPUTS,
        lengths,
    };
    vec![
        case(
            "FDL status",
            services::fdl_status(8),
            |c| services::station_type(c).map(|_| vec![]),
            Answer::of(0, None, &[]),
            &[(1, FORM)],
        ),
        case(
            "Slave_Diag",
            services::slave_diag(8),
            |c| services::diagnosis(c).map(|diag| diag.ext_diag.to_vec()),
            Answer::of(8, saps(0x3C), &[8, 0xC, 0, 2, 0x12, 0x34, 2, 9]),
            &[(5, "its answer has 5 octets instead of 6")],
        ),
        case(
            "Get_Cfg",
            services::get_cfg(8),
            |c| services::configuration(c).map(|(octets, _)| octets.to_vec()),
            Answer::of(8, saps(0x3B), &[0xC1, 0x81, 0x84, 0x85]),
            &[
                (3, "its configuration is none: the last identifier announces more octets than follow"),
                (0, "its configuration is none: no identifier"),
            ],
        ),
        case(
            "RD_Inp",
            services::rd_inp(8),
            |c| services::image(c, Some(2)).map(<[u8]>::to_vec),
            Answer::of(8, saps(0x38), &[7, 7]),
            &[(1, "its answer has 1 octets instead of 2"), (3, "its answer has 3 octets instead of 2")],
        ),
        case(
            "RD_Outp",
            services::rd_outp(8),
            |c| services::image(c, Some(2)).map(<[u8]>::to_vec),
            Answer::of(8, saps(0x39), &[7, 7]),
            &[(1, "its answer has 1 octets instead of 2"), (3, "its answer has 3 octets instead of 2")],
        ),
        case(
            "Set_Slave_Add",
            services::set_slave_add(8, &[5, 0x12, 0x34, 0]),
            |c| services::acknowledged(c).map(|()| vec![]),
            Answer::of(9, None, &[]),
            &[(1, "it answers with data where it should only acknowledge")],
        ),
    ]
}

pub const FORM: &str = "the form of the answer does not fit the request";
pub const OTHER_SAPS: &str = "the answer belongs to other service access points";

pub fn is_exchange(sent: &Sent) -> bool {
    matches!(sent.octets[..], [0x68, 5, 5, 0x68, 8, 2, ..])
}

impl Case {
    /// Answers each repetition of the request with these octets until the master has a result: the text of the error, or the
    /// values that a class 2 request returns.
    pub fn answered(&self, rig: &mut Station, octets: &[u8]) -> Result<Vec<u8>, String> {
        match &self.class2 {
            None => Self::cycle_answered(rig, octets),
            Some(class2) => Self::class2_answered(rig, class2, octets),
        }
    }

    fn cycle_answered(rig: &mut Station, octets: &[u8]) -> Result<Vec<u8>, String> {
        let state = rig.station.user.state(8);
        let exchanges = rig.station.user.counters(8).unwrap().exchanges;
        for _ in 0..8 {
            if !octets.is_empty() {
                rig.receive_octets(11, octets);
            }
            rig.next_request();
            if let Some(error) = rig.station.user.exchange_error(8) {
                return Err(error.to_string());
            }
            if rig.station.user.state(8) != state || rig.station.user.counters(8).unwrap().exchanges != exchanges {
                return Ok(Vec::new());
            }
        }
        panic!("it does not come to anything");
    }

    /// Data_Exchange with the same slave continues as it should.
    fn class2_answered(rig: &mut Station, class2: &Class2Rig, octets: &[u8]) -> Result<Vec<u8>, String> {
        rig.station.user.submit_request(&class2.request).unwrap();
        rig.receive(INPUTS);
        for _ in 0..20 {
            match rig.next_request() {
                sent if is_exchange(&sent) => rig.receive(INPUTS),
                _ if octets.is_empty() => {}
                _ => rig.receive_octets(11, octets),
            }
            if let Some(confirmation) = rig.station.user.take_confirmation() {
                return (class2.read)(&confirmation).map_err(|reason| reason.to_string());
            }
        }
        panic!("there is no result");
    }

    pub fn takes_the_right_answer(&self) {
        let mut rig = (self.asked)();
        let before = known(&rig);
        let result = self.answered(&mut rig, &self.right.octets());
        assert!(result.is_ok(), "{}: {result:?}", self.name);
        match &self.class2 {
            None => assert_ne!(known(&rig), before, "{}: the right answer changes the values", self.name),
            // With data, the error of the raw request is about their end.
            Some(_) => assert!(self.right.du.ends_with(&result.unwrap()), "{}", self.name),
        }
    }

    /// The master takes no value from the defective answer and reports this error.
    pub fn refuses(&self, what: &str, octets: &[u8], words: &str) {
        let mut rig = (self.asked)();
        let before = known(&rig);
        let result = self.answered(&mut rig, octets);
        assert_eq!(result, Err(words.to_string()), "{}, {what}", self.name);
        self.nothing_is_new(&rig, &before, what);
    }

    pub fn nothing_is_new(&self, rig: &Station, before: &Known, what: &str) {
        let now = known(rig);
        match &self.class2 {
            // The slave may be lost after it; then there are no inputs.
            None => {
                assert!(now.inputs.is_none() || now.inputs == before.inputs, "{}, {what}: {now:?}", self.name);
                assert_eq!(
                    (now.exchanges, now.diagnoses),
                    (before.exchanges, before.diagnoses),
                    "{}, {what}",
                    self.name
                );
            }
            // A class 2 request does not disturb the data exchange.
            Some(_) => {
                assert_eq!((&now.inputs, &now.state), (&before.inputs, &before.state), "{}, {what}", self.name);
            }
        }
        assert_eq!(now.diagnosis, before.diagnosis, "{}, {what}", self.name);
    }
}

pub fn all() -> impl Iterator<Item = Case> {
    cyclic().into_iter().chain(class2_cases())
}
