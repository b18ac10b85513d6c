//! A device beside its slave answers like the same device behind it, once its application has run.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use profivac_devices::SimulatedDevice;
use profivac_devices::bcg450::Bcg450;
use profivac_devices::img400::Img400;
use profivac_devices::model::Model;
use profivac_devices::profile::beside::{Application, BusSide};
use profivac_devices::profile::{Behaviour, BlockDevice, Setup};
use profivac_devices::pxg55x::{Pxg55x, Pxg55xModel};
use profivac_devices::store::{RamStore, Store};
use profivac_devices::tpg::{Tpg, table};
use profivac_devices::xpg400::{Xpg400, Xpg400Model};
use profivac_dp::link::{Baud, BitTime, Station};
use profivac_dp::slave::{Device, Dpv1Error, Relation, Slave, SlaveState};
use profivac_wire::acyclic::ErrorCode;
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::{DataTelegram, Telegram};

const ADDRESS: u8 = 5;
const MASTER: u8 = 2;
/// Access points of the master: cyclic, MS1, MS2.
const CYCLIC: u8 = 62;
const MS1: u8 = 51;
const MS2: u8 = 50;

/// The same device twice: behind a slave, and beside one.
struct Both<'a, B, S> {
    behind: Slave<BlockDevice<B, S>>,
    beside: Slave<BusSide>,
    application: Application<'a, B, S>,
    now: BitTime,
    fcb: bool,
    is_first: bool,
}

impl<'a, B: Behaviour, S: Store + Clone> Both<'a, B, S> {
    fn new(device: &'a mut BlockDevice<B, S>) -> Self {
        Self {
            behind: Slave::new(device.clone(), ADDRESS, Baud::B1500000),
            beside: Slave::new(BusSide::new(device), ADDRESS, Baud::B1500000),
            application: Application::new(device),
            now: BitTime(1000),
            fcb: true,
            is_first: true,
        }
    }

    /// The application takes the requests of masters, and publishes its results.
    fn work(&mut self) {
        let tasks = self.beside.device_mut().take_tasks();
        self.application.adopt(&tasks);
        self.beside.device_mut().publish(&self.application.snapshot());
        assert!(!self.beside.device_mut().has_tasks(), "one access at a time");
    }

    /// Sends a request to both and returns their answers.
    fn send(&mut self, saps: Option<(u8, u8)>, du: &[u8]) -> [Option<Vec<u8>>; 2] {
        let count = if core::mem::take(&mut self.is_first) {
            FrameCount::First
        } else {
            self.fcb = !self.fcb;
            FrameCount::Counted(self.fcb)
        };
        let fc = Control::Request { function: Function::SrdHigh, count }.to_octet();
        let (dsap, ssap) = saps.unzip();
        let telegram = Telegram::Data(DataTelegram { da: ADDRESS, sa: MASTER, dsap, ssap, fc, du });
        self.now = self.now + 500;
        [answer(&mut self.behind, self.now, &telegram), answer(&mut self.beside, self.now, &telegram)]
    }

    /// Both answer alike, before the application has run.
    fn agree(&mut self, what: &str, saps: Option<(u8, u8)>, du: &[u8]) -> Vec<u8> {
        let [behind, beside] = self.send(saps, du);
        assert_eq!(behind, beside, "{what}: {du:02X?}");
        self.work();
        behind.unwrap_or_default()
    }

    /// An acyclic request: both acknowledge it and every poll, and the responses are the same when the application has run.
    fn acyclic(&mut self, dsap: u8, ssap: u8, request: &[u8]) -> Vec<u8> {
        self.agree("request", Some((dsap, ssap)), request);
        self.agree("response", Some((dsap, ssap)), &[])
    }

    /// The inputs agree one cycle after the outputs: the application has run in between. Before, each slave answers alike with
    /// and without a prepared answer.
    fn exchange(&mut self, outputs: &[u8]) {
        self.send(None, outputs);
        self.send(None, outputs);
        self.work();
        self.agree("exchange", None, outputs);
    }

    fn advance(&mut self, seconds: f64, pressures: [f64; 4]) {
        for (part, pa) in pressures.into_iter().enumerate() {
            self.behind.device_mut().sense(part, pa);
            self.application.device_mut().sense(part, pa);
        }
        self.behind.device_mut().advance(seconds);
        self.application.device_mut().advance(seconds);
        self.work();
    }
}

/// The answer of a slave, prepared or not: the same slave without a prepared answer answers alike, and has the same state and the same
/// inputs afterwards.
fn answer<D: Device + Clone>(slave: &mut Slave<D>, now: BitTime, telegram: &Telegram<'_>) -> Option<Vec<u8>> {
    let mut general = slave.clone();
    // Nothing is changed, but the prepared answer is dropped.
    general.device_mut();
    let expected = general.telegram(now, telegram).map(|answer| answer.octets.to_vec());
    let answered = slave.telegram(now, telegram).map(|answer| answer.octets.to_vec());
    assert_eq!(answered, expected, "{telegram:02X?}");
    assert_eq!(slave.state(), general.state(), "{telegram:02X?}");
    assert_eq!(inputs(slave.clone()), inputs(general), "{telegram:02X?}");
    slave.sent(now);
    answered
}

/// The present inputs.
fn inputs<D: Device>(mut slave: Slave<D>) -> Option<Vec<u8>> {
    let SlaveState::DataExch(_, exchange) = slave.state() else { return None };
    let mut image = vec![0; exchange.lengths.inputs.into()];
    slave.device_mut().inputs(&mut image);
    Some(image)
}

/// Set_Prm with the lock bit, and an ident number.
fn set_prm(model: &Model, user: &[u8], dpv1: bool) -> Vec<u8> {
    let [high, low] = model.ident.to_be_bytes();
    let mut du = vec![0x80, 0, 0, 0, high, low, 0];
    du.extend_from_slice(user);
    if dpv1 && let Some(first) = du.get_mut(7) {
        *first |= 0x80;
    }
    du
}

/// Every configuration with every user parameter string; reads and writes on each path; noise in the outputs.
fn compare<B: Behaviour, S: Store + Clone>(device: &mut BlockDevice<B, S>, model: &'static Model) {
    let mut random = fastrand_like(model.ident.into());
    device.settle();
    let mut both = Both::new(device);
    both.advance(1.0, [1.0, 1e-3, 5.0, 1e5]);
    for configuration in model.configurations {
        for prm in model.user_prm {
            let user = set_prm(model, prm.octets, model.features.ms1 && random().is_multiple_of(2));
            both.agree("Set_Prm", Some((61, CYCLIC)), &user);
            both.agree("Chk_Cfg", Some((62, CYCLIC)), configuration.octets);
            both.agree("Slave_Diag", Some((60, CYCLIC)), &[]);
            both.agree("Get_Cfg", Some((59, CYCLIC)), &[]);
            for _ in 0..6 {
                let mut outputs = vec![0; configuration.output_octets()];
                both.exchange(&outputs);
                if random().is_multiple_of(2) {
                    outputs.iter_mut().for_each(|octet| *octet = random() as u8);
                    if let [first, slot, index, ..] = &mut outputs[..] {
                        (*first, *slot, *index) =
                            ([0x10, 0x20, 0x30][random() as usize % 3], random() as u8 % 12, random() as u8 % 80);
                    }
                    both.exchange(&outputs);
                }
                both.advance(0.01, [10f64.powi(random() as i32 % 6 - 3), 1e-2, 3.0, 1e5]);
                let (slot, index) = (random() as u8 % 12, random() as u8 % 90);
                both.acyclic(MS1, MS1, &[0x5E, slot, index, 240]);
                both.acyclic(MS1, MS1, &[0x5F, slot, index, 1, random() as u8 % 8]);
                both.agree("RD_Inp", Some((56, CYCLIC)), &[]);
            }
        }
    }
    both.agree("unlock", Some((61, CYCLIC)), &[0x40, 0, 0, 0, 0, 0, 0]);
    both.agree("Slave_Diag", Some((60, CYCLIC)), &[]);
    if model.features.dpv1 {
        ms2(&mut both, &mut random);
    }
}

/// Every index of the first slots, read and written with random octets of random lengths over a connection.
fn ms2<B: Behaviour, S: Store + Clone>(both: &mut Both<'_, B, S>, random: &mut impl FnMut() -> u32) {
    // As printed in profibus-wire 4.6.6.
    const INITIATE: &[u8] = &[0x57, 0, 0, 0, 0, 0x64, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];
    both.agree("Initiate", Some((49, MS2)), INITIATE);
    both.agree("Initiate, response", Some((48, MS2)), &[]);
    let mut answered = 0;
    for slot in 0..12 {
        for index in 10..90 {
            let response = both.acyclic(48, MS2, &[0x5E, slot, index, 240]);
            answered += u32::from(response.len() > 12);
            let length = random() % 6 + u32::from(random().is_multiple_of(40)) * 30;
            let mut write = vec![0x5F, slot, index, length as u8];
            write.extend((0..length).map(|_| random() as u8 % 6));
            // A reset command restarts both at the same moment.
            both.acyclic(48, MS2, &write);
            both.acyclic(48, MS2, &[0x5E, slot, index, 240]);
        }
        both.advance(0.7, [1.0, 1e-3, 5.0, 1e5]);
    }
    assert!(answered > 30, "only {answered} reads had a response");
}

/// xorshift, so that the test needs no dependency.
fn fastrand_like(seed: u32) -> impl FnMut() -> u32 {
    let mut state = seed.wrapping_mul(2_654_435_761) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state >> 3
    }
}

/// profibus-wire 4.2: SC is the answer to a poll whose response is not there yet.
#[test]
fn polls_are_acknowledged_until_the_application_has_run() {
    let mut device: Bcg450<Ram> = Bcg450::new(RamStore::default(), setup());
    device.settle();
    let mut both = Both::new(&mut device);
    both.send(Some((49, MS2)), &[0x57, 0, 0, 0, 0, 0x64, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0]);
    both.send(Some((48, MS2)), &[]);
    for request in [&[0x5E, 0, 25, 240][..], &[0x5F, 1, 39, 1, 2]] {
        both.send(Some((48, MS2)), request);
        for _ in 0..3 {
            let [_, poll] = both.send(Some((48, MS2)), &[]);
            assert_eq!(poll.as_deref(), Some(&[0xE5][..]));
        }
        let [_, early] = both.send(Some((48, MS2)), request);
        assert_eq!(early.map(|answer| answer[3] & 0x0F), Some(2), "RR: the connection has a request");
        both.work();
        let [_, response] = both.send(Some((48, MS2)), &[]);
        assert!(response.is_some_and(|answer| answer.len() > 11), "the response, once");
    }
}

/// MS1 and two connections of MS2 have a place for an access. A further one is refused, and nothing waits for it.
#[test]
fn an_access_without_a_place_is_refused() {
    let device: Bcg450<Ram> = Bcg450::new(RamStore::default(), setup());
    let mut bus = BusSide::new(&device);
    let refusal = Dpv1Error::new(ErrorCode::RESOURCE_UNAVAILABLE);
    let third = Relation::Ms2(2);
    assert_eq!(bus.read(third, 0, 25, &mut [0; 240]), Err(refusal));
    assert_eq!(bus.write(third, 0, 15, &[4]), Err(refusal));
    assert!(!bus.is_executing(third) && !bus.has_tasks());
}

/// Chk_Cfg is answered at once, and the inputs of the new configuration come with the application: until then the diagnosis has
/// Stat_Diag, and Data_Exchange has high priority.
#[test]
fn the_diagnosis_is_static_until_the_application_has_inputs() {
    let model = &profivac_devices::bcg450::table::MODEL;
    let mut device: Bcg450<Ram> = Bcg450::new(RamStore::default(), setup());
    device.settle();
    let mut both = Both::new(&mut device);
    let configuration = &model.configurations[0];
    both.send(Some((61, CYCLIC)), &set_prm(model, model.user_prm[0].octets, false));
    both.send(Some((62, CYCLIC)), configuration.octets);
    let mut static_diag = |work: bool| {
        if work {
            both.work();
        }
        let [_, exchange] = both.send(None, &vec![0; configuration.output_octets()]);
        let [_, diagnosis] = both.send(Some((60, CYCLIC)), &[]);
        let status_2 = diagnosis.unwrap()[10];
        (exchange.unwrap()[6] & 0x0F, status_2 & 2 != 0)
    };
    assert_eq!(static_diag(false), (0x0A, true));
    assert_eq!(static_diag(true), (0x08, false));
}

/// A write in the parameter channel that the master withdraws before the application has run is executed, and not answered.
#[test]
fn the_channel_answers_when_the_application_has_run_and_only_to_the_present_task() {
    let model = &profivac_devices::bcg450::table::MODEL;
    let mut device: Bcg450<Ram> = Bcg450::new(RamStore::default(), setup());
    device.settle();
    let mut both = Both::new(&mut device);
    let with_channel = |it: &&profivac_devices::model::Configuration| it.output_octets() == 8;
    let configuration = model.configurations.iter().find(with_channel).unwrap();
    both.agree("Set_Prm", Some((61, CYCLIC)), &set_prm(model, model.user_prm[0].octets, false));
    both.agree("Chk_Cfg", Some((62, CYCLIC)), configuration.octets);
    let mut channel = |task: [u8; 8], work: bool| {
        let [_, answer] = both.send(None, &task);
        if work {
            both.work();
        }
        let answer = answer.unwrap();
        <[u8; 8]>::try_from(&answer[7..15]).unwrap()
    };
    // AK 10: a write of one octet; Safe State of the Pirani.
    let ak_write = model.channel_rules.tasks.iter().find_map(|(ak, kind)| match kind {
        profivac_devices::model::TaskKind::Write(lengths) if lengths.contains(&1) => Some(*ak),
        _ => None,
    });
    let write = [ak_write.unwrap() << 4, 1, 39, 0, 0, 0, 0, 2];
    assert_eq!(channel(write, false), [0, 1, 39, 0, 0, 0, 0, 0]);
    assert_eq!(channel([0; 8], false), [0; 8], "withdrawn");
    assert_eq!(channel(write, true), [0; 8], "the first write is not finished");
    assert_eq!(channel([0; 8], true), [0; 8]);
    let read = [0x10, 1, 39, 0, 0, 0, 0, 0];
    channel(read, true);
    assert_eq!(channel(read, true), [0xB0, 1, 39, 0, 0, 0, 0, 2]);
}

fn setup() -> Setup {
    Setup::new(ADDRESS)
}

type Ram = RamStore<192>;

#[test]
fn a_bcg450_beside_its_slave_answers_like_one_behind_it() {
    let mut device: Bcg450<Ram> = Bcg450::new(RamStore::default(), setup());
    compare(&mut device, &profivac_devices::bcg450::table::MODEL);
}

#[test]
fn every_pcg_and_psg_beside_its_slave_answers_like_one_behind_it() {
    for model in Pxg55xModel::all() {
        let mut device: Pxg55x<Ram> = Pxg55x::new(RamStore::default(), model, setup());
        compare(&mut device, &model.variant().model);
    }
}

#[test]
fn a_bpg400_and_a_hpg400_beside_their_slaves_answer_like_those_behind_them() {
    for (model, table) in [
        (Xpg400Model::Bpg, &profivac_devices::xpg400::table::BPG400),
        (Xpg400Model::Hpg, &profivac_devices::xpg400::table::HPG400),
    ] {
        let mut device: Xpg400<Ram> = Xpg400::new(RamStore::default(), model, setup());
        compare(&mut device, &table.model);
    }
}

#[test]
fn the_controllers_beside_their_slaves_answer_like_those_behind_them() {
    for model in [&table::TPG300, &table::TPG500] {
        let mut device: Tpg<Ram> = Tpg::new(model, RamStore::default(), setup(), [None; 4]);
        compare(&mut device, model);
    }
    let gauges = profivac_devices::img400::Gauges::default();
    let mut device: Img400<Ram> = Img400::new(RamStore::default(), setup(), gauges);
    compare(&mut device, &profivac_devices::img400::table::MODEL);
}
