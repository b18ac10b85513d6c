//! A ring of two masters with all twelve devices, and listeners that join before and after them.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "this is test code"
)]

mod line;

use line::{FIRST, Line, Listener, MASTERS};
use profivac_client::cyclic::{CyclicSlave, ReportedChannels};
use profivac_devices::catalog::{MODELS, model_named};
use profivac_devices::model::{Configuration, Field, TaskKind, Telegram};
use profivac_dp::link::{Baud, BitTime};
use profivac_explain::frame::Chunk;
use profivac_listen::counts::Counts;
use profivac_listen::event::{EventKind, MAX_EVENTS};
use profivac_listen::gauge::{Declared, Origin};
use profivac_listen::parameters::Passed;
use profivac_listen::report::BusReport;
use profivac_listen::station::{MAX_DIAGNOSES, StationState};
use profivac_sim::{Fault, Noise};
use profivac_wire::{DataTelegram, MAX_TELEGRAM};

fn slaves() -> std::ops::Range<u8> {
    FIRST..FIRST + 12
}

/// Compares the inputs and pressures of the masters with those of a listener. Returns how many pressures were equal.
fn compare(line: &Line, listener: &Listener) -> usize {
    let mut equal = 0;
    for slave in &line.slaves {
        let master = line.master(slave.address);
        let (Some(inputs), Some(_)) = (master.inputs(slave.address), master.exchanged_at(slave.address)) else {
            continue;
        };
        let Some(station) = listener.observer.station(slave.address) else { continue };
        if station.knowledge.exchanged_at().is_none() {
            continue;
        }
        assert_eq!(station.knowledge.inputs(), inputs, "{} at {}", slave.model.name, slave.address);
        let Some(reading) = listener.observer.reading(slave.address) else { continue };
        if reading.facts.origin() != Origin::Assumed {
            assert_eq!(reading.values, slave.decode_inputs(inputs), "{}", slave.model.name);
            equal += reading.values.values.len();
        }
    }
    equal
}

/// A line on which every slave exchanges data, and a listener from its beginning.
fn quiet() -> (Line, Listener) {
    let mut line = Line::new(Baud::B93750);
    let mut listener = Listener::new(line.baud);
    for _ in 0..150 {
        line.run(100, &mut [&mut listener]);
        compare(&line, &listener);
    }
    for slave in &line.slaves {
        let (address, master) = (slave.address, line.master(slave.address));
        assert!(
            master.exchanged_at(address).is_some(),
            "{}: {:?} {:?}",
            slave.model.name,
            master.state(address),
            master.exchange_error(address)
        );
    }
    (line, listener)
}

#[test]
fn in_a_quiet_line_everything_is_known_and_every_pressure_is_that_of_the_master() {
    let (line, listener) = quiet();
    let observer = &listener.observer;
    for slave in &line.slaves {
        let address = slave.address;
        assert_eq!(observer.state(address), Some(StationState::Exchanging), "{address}");
        let station = observer.station(address).unwrap();
        let facts = station.knowledge.facts(address).unwrap();
        assert_eq!(facts.configuration, Origin::Heard, "{address}");
        assert_eq!(facts.slave.configuration.octets, slave.configuration.octets, "{address}");
        if slave.model.user_prm.iter().any(|prm| prm.unit_code() == slave.unit.code) {
            assert_eq!((facts.unit, facts.slave.unit.name), (Origin::Heard, slave.unit.name), "{address}");
        }
    }
    for address in MASTERS {
        assert_eq!(observer.state(address), Some(StationState::Master));
    }
    assert_eq!(observer.ring(), MASTERS);
    assert_eq!(observer.totals().damaged, 0);
    assert_eq!(observer.totals().octets, line.octets, "every octet on the line is that of a station");
    statistics_are_equal(&line, &listener);
}

#[test]
fn attached_in_the_middle_it_knows_the_line_after_two_rotations_and_says_what_it_does_not_know() {
    let (mut line, early) = quiet();
    let rotation_tbit = early.observer.rotation().range_tbit().unwrap().1;
    let cycle_tbit = early.observer.cycle().range_tbit().unwrap().1;
    // The file names half of the gauges.
    let mut late = Listener::new(line.baud);
    for slave in line.slaves.iter().filter(|slave| slave.address % 2 == 0) {
        let declared =
            Declared { model: slave.model, configuration: Some(slave.configuration), unit: Some(slave.unit) };
        late.observer.declare(slave.address, declared);
    }
    line.run_tbit(2 * rotation_tbit.max(cycle_tbit), &mut [&mut late]);
    let observer = &late.observer;
    assert_eq!(observer.ring(), MASTERS);
    for address in MASTERS {
        assert_eq!(observer.state(address), Some(StationState::Master));
    }
    for slave in &line.slaves {
        let address = slave.address;
        assert_eq!(observer.state(address), Some(StationState::Exchanging), "{address}");
        let station = observer.station(address).unwrap();
        let inputs = line.master(address).inputs(address).unwrap();
        assert_eq!(station.knowledge.inputs(), inputs);
        match observer.reading(address) {
            Some(reading) => {
                assert_eq!(address % 2, 0, "{address}");
                assert_eq!(reading.facts.origin(), Origin::Configured);
                assert_eq!(reading.values, slave.decode_inputs(inputs));
                let expected: Vec<_> = slave.assumption().into_iter().collect();
                assert_eq!(station.knowledge.unknown().iter().map(ToString::to_string).collect::<Vec<_>>(), expected);
            }
            None => {
                assert_eq!(address % 2, 1, "{address}");
                let unknown = "the device is not known: neither a diagnosis nor a start-up was heard, and the file does not name it";
                assert_eq!(station.knowledge.unknown().iter().map(ToString::to_string).collect::<Vec<_>>(), [unknown]);
            }
        }
    }
}

/// Whether another configuration of the device has the same lengths and other fields.
fn is_ambiguous(slave: &CyclicSlave) -> bool {
    let fields = |it: &Configuration| [it.outputs, it.inputs].map(|telegram| telegram.map(|telegram| telegram.fields));
    let lengths = |it: &Configuration| [it.outputs, it.inputs].map(|telegram| telegram.map_or(0, Telegram::octets));
    let own = slave.configuration;
    slave.model.configurations.iter().any(|it| lengths(it) == lengths(own) && fields(it) != fields(own))
}

#[test]
fn a_gauge_of_which_only_the_model_is_known_is_decoded_and_marked_as_assumed() {
    let (mut line, _) = quiet();
    let mut late = Listener::new(line.baud);
    for slave in &line.slaves {
        late.observer.declare(slave.address, Declared { model: slave.model, configuration: None, unit: None });
    }
    line.run(2000, &mut [&mut late]);
    let (mut right, mut ambiguous) = (0, 0);
    for slave in &line.slaves {
        let facts = late.observer.station(slave.address).unwrap().knowledge.facts(slave.address).unwrap();
        let expected = if is_ambiguous(slave) { Origin::Assumed } else { Origin::Configured };
        assert_eq!((facts.configuration, facts.unit), (expected, Origin::Assumed), "{}", slave.model.name);
        let fields = |it: &Configuration| it.inputs.map(|telegram| telegram.fields);
        let is_right = fields(facts.slave.configuration) == fields(slave.configuration);
        assert!(is_right || is_ambiguous(slave), "the only one that fits: {}", slave.model.name);
        (right, ambiguous) = (right + usize::from(is_right), ambiguous + usize::from(is_ambiguous(slave)));
        let unknown = late
            .observer
            .station(slave.address)
            .unwrap()
            .knowledge
            .unknown()
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>();
        let assumptions = [
            is_ambiguous(slave).then_some("no Chk_Cfg was heard; the configuration"),
            Some("neither Set_Prm nor the file shows the unit; "),
            facts.slave.assumption(),
        ];
        let assumptions: Vec<_> = assumptions.into_iter().flatten().collect();
        assert_eq!(unknown.len(), assumptions.len(), "{unknown:?}");
        assert!(unknown.iter().zip(assumptions).all(|(text, begin)| text.starts_with(begin)), "{unknown:?}");
    }
    println!("{right} of 12 configurations are right, {ambiguous} of them ambiguous");
    assert!(right >= 8 && (1..12).contains(&ambiguous), "{right} {ambiguous}");
}

/// The counters of the listener are those of the masters, and the damage is that of the line.
fn statistics_are_equal(line: &Line, listener: &Listener) {
    for address in slaves() {
        let sent = line.sent(address);
        let station = listener.observer.station(address).unwrap();
        let counts = station.counts.total();
        assert_eq!(
            (counts.requests, counts.repeated, u64::from(station.longest_sequence), counts.lost, counts.refused),
            (sent.requests, sent.repeated, sent.longest, sent.lost, sent.refused),
            "{address}: {counts:?}"
        );
        let damaged = line.damaged_of.get(&address).copied().unwrap_or_default();
        assert_eq!(counts.damaged, damaged, "{address}: {counts:?}");
    }
    assert_eq!(listener.observer.totals().damaged, line.damaged);
}

/// The file of a station names every gauge with its configuration and unit.
fn declare(line: &Line, listener: &mut Listener) {
    for slave in &line.slaves {
        let declared =
            Declared { model: slave.model, configuration: Some(slave.configuration), unit: Some(slave.unit) };
        listener.observer.declare(slave.address, declared);
    }
}

/// Every damaged piece belongs to one station, or to none.
fn damage_is_attributed_once(listener: &Listener) {
    let of_stations: u64 = listener.observer.stations().map(|(_, station)| station.counts.total().damaged).sum();
    let totals = listener.observer.totals();
    assert_eq!(of_stations + totals.unattributed, totals.damaged, "{totals:?}");
}

/// Runs for some seconds of bus time with noise, power cuts and restarts.
fn disturbed(baud: Baud, seconds: u64) {
    let mut line = Line::new(baud);
    let (mut before, mut after) = (Listener::new(line.baud), Listener::new(line.baud));
    for listener in [&mut before, &mut after] {
        declare(&line, listener);
    }
    let mut is_late = false;
    let mut equal = [0, 0];
    for second in 0..seconds {
        let device = line.devices[(second / 60) as usize % 12];
        match second % 60 {
            5 => line.segment.inject(Fault::Noise(Some(Noise::new(second, 2e-5)))),
            25 => line.segment.inject(Fault::Noise(None)),
            28 => line.restart(usize::from(second % 120 < 60)),
            35 => line.segment.station_mut(device).set_power(false),
            42 => line.segment.station_mut(device).set_power(true),
            _ => {}
        }
        is_late |= second == 12;
        for _ in 0..4 {
            if is_late {
                line.run(250, &mut [&mut before, &mut after])
            } else {
                line.run(250, &mut [&mut before])
            }
            equal[0] += compare(&line, &before);
            equal[1] += if is_late { compare(&line, &after) } else { 0 };
        }
    }
    line.settle(&mut [&mut before, &mut after]);
    let totals = before.observer.totals();
    println!("{seconds} s at {baud}: {equal:?} pressures equal, {totals:?}");
    // In a ring at 19.2 kbit/s the second master needs its time to enter.
    assert!(equal.iter().all(|equal| *equal as u64 > seconds * 4 * 12), "{equal:?}");
    assert!(totals.damaged > seconds / 20, "{totals:?}");
    damage_is_attributed_once(&before);
    statistics_are_equal(&line, &before);
    assert_eq!(totals.octets, line.octets, "every octet on the line is that of a station");
    let lost = |kind| before.observer.events().iter().filter(|event| event.kind() == kind).count();
    assert!(lost(EventKind::Lost) > 0 && lost(EventKind::Returned) > 0 && lost(EventKind::Configuration) > 0);
}

#[test]
fn pressures_and_statistics_are_those_of_the_masters_with_noise_power_cuts_and_restarts() {
    disturbed(Baud::B19200, 600);
    disturbed(Baud::B187500, 120);
}

/// An hour at two rates. `./test long listener` runs it.
#[test]
#[ignore = "an hour of bus time at 19.2 and at 187.5 kbit/s takes minutes"]
fn an_hour_of_noise_power_cuts_and_restarts() {
    disturbed(Baud::B19200, 3600);
    disturbed(Baud::B187500, 3600);
}

/// The memory of this process in octets.
fn resident_octets() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    pages.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 4096
}

/// Ten minutes of noise, restarts and power cuts, heard again and again.
#[test]
#[ignore = "a day of bus time takes minutes"]
fn a_day_of_bus_time_needs_bounded_memory() {
    let mut line = Line::new(Baud::B19200);
    line.recorded = Some(Vec::new());
    line.segment.inject(Fault::Noise(Some(Noise::new(1, 1e-4))));
    for second in 0..600 {
        if second % 120 == 60 {
            line.restart(second / 120 % 2);
        }
        line.segment.station_mut(line.devices[second / 60]).set_power(second % 60 < 50);
        line.run(1000, &mut []);
    }
    let (chunks, length_tbit) = (line.recorded.take().unwrap(), line.baud.tbit_of_ms(600_000));
    let mut listener = Listener::new(line.baud);
    let mut after_an_hour = 0;
    for round in 0..24 * 6 {
        for chunk in &chunks {
            let start = chunk.start.map(|start| start + round * length_tbit);
            listener.hear(&Chunk { start, ..chunk.clone() });
        }
        if round == 6 {
            after_an_hour = resident_octets();
        }
    }
    let grown = resident_octets().saturating_sub(after_an_hour);
    println!("{after_an_hour} octets after an hour, {grown} more after a day, {:?}", listener.observer.totals());
    assert!(grown < 1 << 20, "{grown}");
    assert!(listener.observer.observed_tbit() > line.baud.tbit_of_ms(86_000_000));
}

/// Every configuration of all twelve devices whose inputs carry a process value is decoded as the master decodes it: also the mantissas
/// of a TPG and the TTR value of a PCG55x or PSG55x, and none of them has no pressure.
#[test]
fn every_configuration_with_a_process_value_is_decoded_for_all_twelve_devices() {
    let mut decoded = 0;
    for model in MODELS {
        for configuration in model.configurations {
            let Some(inputs) = configuration.inputs else { continue };
            let layout = inputs.layout().map(|(_, field)| field);
            let has_pressure = layout
                .filter(|field| {
                    matches!(
                        field,
                        Field::ProcessValue(_) | Field::ChannelValue(..) | Field::ChannelMantissa(_) | Field::TtrValue
                    )
                })
                .count();
            let mut listener = Listener::new(Baud::B19200);
            let mut now = 0;
            let mut hear = |octets: &[u8]| {
                let chunk = Chunk { start: Some(BitTime(now)), octets: octets.to_vec(), ..Chunk::default() };
                now += 11 * octets.len() as u64 + 40;
                listener.hear(&chunk);
            };
            let unit = &model.units[0];
            let user = model.user_prm.iter().find(|prm| prm.unit_code() == unit.code).map_or(&[][..], |prm| prm.octets);
            let [high, low] = model.ident.to_be_bytes();
            let prm = [&[0x88, 1, 100, 11, high, low, 0][..], user].concat();
            hear(&emit(9, 1, Some((61, 62)), 0x6D, &prm));
            hear(&[0xE5]);
            hear(&emit(9, 1, Some((62, 62)), 0x5D, configuration.octets));
            hear(&[0xE5]);
            let outputs = vec![0; configuration.outputs.map_or(0, |outputs| outputs.octets())];
            let data: Vec<u8> = (1..=inputs.octets() as u8).map(|octet| octet.wrapping_mul(37)).collect();
            hear(&emit(9, 1, None, 0x7D, &outputs));
            hear(&emit(1, 9, None, 0x08, &data));
            let reading = listener.observer.reading(9).expect("a heard start-up is known");
            assert_eq!(reading.facts.configuration, Origin::Heard, "{}", model.name);
            assert_eq!(reading.values.values.len(), has_pressure, "{}: {:02X?}", model.name, configuration.octets);
            let slave = CyclicSlave {
                address: 9,
                model: reading.facts.slave.model,
                configuration,
                unit: reading.facts.slave.unit,
                channels: ReportedChannels::default(),
            };
            assert_eq!(format!("{:?}", reading.values), format!("{:?}", slave.decode_inputs(&data)));
            decoded += has_pressure;
        }
    }
    assert!(decoded > 60, "{decoded}");
}

/// A second master reads and writes parameters over MS2: name, value and requester are shown, and an event reports the write. Another
/// master uses another connection meanwhile.
#[test]
fn parameters_over_ms2_are_shown_with_name_value_and_requester() {
    let model = model_named("bcg450").unwrap();
    let mut listener = Listener::new(Baud::B19200);
    listener.observer.declare(9, Declared { model, configuration: None, unit: None });
    let mut now = 0;
    let mut hear = |octets: &[u8]| {
        let chunk = Chunk { start: Some(BitTime(now)), octets: octets.to_vec(), ..Chunk::default() };
        now += 11 * octets.len() as u64 + 40;
        listener.hear(&chunk);
    };
    // Data Units of slot 1: master 3 reads mbar on connection 1, master 2 writes Torr on connection 0.
    let unit = |name: &str| model.unit_named(name).unwrap().code.to_be_bytes();
    let (mbar, torr) = (unit("mbar"), unit("Torr"));
    hear(&emit(9, 2, Some((0, 50)), 0x6D, &[0x5F, 1, 22, 2, torr[0], torr[1]]));
    hear(&[0xE5]);
    hear(&emit(9, 3, Some((1, 50)), 0x6D, &[0x5E, 1, 22, 2]));
    hear(&[0xE5]);
    hear(&emit(9, 3, Some((1, 50)), 0x5D, &[]));
    hear(&emit(3, 9, Some((50, 1)), 0x08, &[0x5E, 1, 22, 2, mbar[0], mbar[1]]));
    hear(&emit(9, 2, Some((0, 50)), 0x5D, &[]));
    hear(&emit(2, 9, Some((50, 0)), 0x08, &[0x5F, 1, 22, 2]));
    let observer = &listener.observer;
    let text = |passed: &Passed| {
        let (name, value) = observer.parameter_text(9, passed);
        format!("{:?} {:?} by {}: {name} = {value}", passed.path, passed.done, passed.requester)
    };
    let passed: Vec<_> = observer.station(9).unwrap().parameters.passed().iter().map(text).collect();
    let [read, written] = &passed[..] else { panic!("{passed:?}") };
    assert!(read.starts_with("Ms2 Read by 3: ") && read.ends_with("(slot 1 index 22) = mbar (1308)"), "{read}");
    assert!(written.starts_with("Ms2 Written by 2: ") && written.ends_with("= Torr (1301)"), "{written}");
    let event = observer.events().iter().find(|event| event.kind() == EventKind::Parameter).unwrap();
    assert!(event.to_string().starts_with("master 2 writes ") && event.to_string().ends_with("(MS2)"), "{event}");
}

/// Any octets in any order and at any time, also mutated telegrams of a start-up: no panic, and no count that contradicts another.
#[test]
fn hostile_traffic_is_counted_without_a_panic() {
    let model = model_named("bcg450").unwrap();
    let [high, low] = model.ident.to_be_bytes();
    let prm = [&[0x88, 1, 100, 11, high, low, 0][..], model.user_prm[0].octets].concat();
    let usual = [
        emit(9, 1, Some((61, 62)), 0x6D, &prm),
        vec![0xE5],
        emit(9, 1, Some((62, 62)), 0x5D, model.configurations[1].octets),
        emit(9, 1, Some((60, 62)), 0x7D, &[]),
        emit(1, 9, Some((62, 60)), 0x08, &[0, 0x0C, 0, 1, high, low]),
        emit(9, 1, None, 0x5D, &[]),
        emit(1, 9, None, 0x08, &[0x80, 0, 2, 0, 0, 0, 0]),
        emit(9, 2, Some((0, 50)), 0x5D, &[0x5F, 1, 22, 2, 1, 1]),
        emit(2, 9, Some((50, 0)), 0x08, &[0x5F, 1, 22, 2]),
        vec![0xDC, 1, 2],
        vec![0xDC, 255, 255],
    ];
    for seed in 0..20 {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut listener = Listener::new(Baud::B19200);
        listener.observer.declare(9, Declared { model, configuration: None, unit: None });
        for _ in 0..2000 {
            let mut octets = random.choice(&usual).unwrap().clone();
            match random.u8(0..6) {
                0 => octets = (0..random.usize(0..300)).map(|_| random.u8(..)).collect(),
                1 => octets.truncate(random.usize(0..=octets.len())),
                2 => {
                    if let Some(octet) = random.choice((0..octets.len()).collect::<Vec<_>>()) {
                        octets[octet] = random.u8(..);
                    }
                }
                // A valid telegram with any addresses and contents.
                3 => {
                    let du: Vec<u8> = (0..random.usize(0..240)).map(|_| random.u8(..)).collect();
                    let saps = random.bool().then(|| (random.u8(0..64), random.u8(0..64)));
                    octets = emit(random.u8(0..127), random.u8(0..127), saps, random.u8(..), &du);
                }
                _ => {}
            }
            let errors = if random.u8(0..8) == 0 { vec![random.usize(0..300)] } else { Vec::new() };
            // Also backwards, and at the end of time.
            let start = match random.u8(0..50) {
                0 => Some(BitTime(random.u64(..))),
                1 => None,
                _ => Some(listener.observer.now() + random.u64(0..2000)),
            };
            listener.hear(&Chunk { start, octets, errors, is_continued: random.u8(0..8) == 0 });
            let _ = listener.observer.reading(9);
        }
        let report = BusReport::of(&listener.observer);
        let total = |count: fn(&Counts) -> u64| report.stations.iter().map(|it| count(&it.total)).sum::<u64>();
        assert!(total(|it| it.repeated) <= total(|it| it.requests), "{seed}");
        assert!(total(|it| it.damaged) <= listener.observer.totals().damaged, "{seed}");
        assert!(listener.observer.events().iter().count() <= MAX_EVENTS);
    }
}

fn emit(da: u8, sa: u8, saps: Option<(u8, u8)>, fc: u8, du: &[u8]) -> Vec<u8> {
    let mut octets = vec![0; MAX_TELEGRAM];
    let (dsap, ssap) = saps.map_or((None, None), |(dsap, ssap)| (Some(dsap), Some(ssap)));
    let length = profivac_wire::Telegram::Data(DataTelegram { da, sa, dsap, ssap, fc, du }).emit(&mut octets).unwrap();
    octets.truncate(length);
    octets
}

/// Diagnoses with other contents are kept, newest first and the last sixteen; the same one again is no other.
#[test]
fn the_history_of_a_diagnosis_has_the_last_contents_with_their_ages() {
    let baud = Baud::B19200;
    let mut listener = Listener::new(baud);
    let [high, low] = model_named("bcg450").unwrap().ident.to_be_bytes();
    let mut hear_at = |ms: u64, device: u8| {
        let start = BitTime(baud.tbit_of_ms(ms));
        let request = emit(9, 1, Some((60, 62)), 0x7D, &[]);
        let answer_at = start + 11 * request.len() as u64 + 40;
        listener.hear(&Chunk { start: Some(start), octets: request, ..Chunk::default() });
        // 0 is a diagnosis without Ext_Diag and without further octets.
        let extended: &[u8] = if device == 0 { &[] } else { &[0x02, device] };
        let status = if device == 0 { 0 } else { 0x08 };
        let du = [&[status, 0x0C, 0, 1, high, low], extended].concat();
        let octets = emit(1, 9, Some((62, 60)), 0x08, &du);
        listener.hear(&Chunk { start: Some(answer_at), octets, ..Chunk::default() });
        BusReport::of(&listener.observer)
    };
    let report = hear_at(1000, 0);
    assert_eq!((report.stations.len(), report.stations[1].diagnosis.len()), (2, 0));
    assert_eq!(report.events.iter().filter(|event| event.kind == EventKind::Diagnosis).count(), 0);
    hear_at(2000, 0x80);
    let report = hear_at(5000, 0x80);
    let slave = &report.stations[1];
    assert!(!slave.diagnosis.is_empty(), "{slave:?}");
    let ages: Vec<_> = slave.diagnosis_history.iter().map(|it| ((it.age_ms + 500) / 1000, it.reports.len())).collect();
    assert_eq!(ages, [(4, 0)], "the first one of second 1; the present one is not history");
    let report = hear_at(6000, 0);
    let slave = &report.stations[1];
    assert_eq!((slave.diagnosis.len(), slave.total.diagnoses), (0, 4));
    let ages: Vec<_> =
        slave.diagnosis_history.iter().map(|it| ((it.age_ms + 500) / 1000, !it.reports.is_empty())).collect();
    assert_eq!(ages, [(4, true), (5, false)]);
    let texts: Vec<_> = report.events.iter().filter(|it| it.kind == EventKind::Diagnosis).map(|it| &it.text).collect();
    assert_eq!(texts.len(), 2, "{texts:?}");
    assert_eq!(texts[0], "the diagnosis of station 9 reports nothing");
    let report = (1..=40).map(|number| hear_at(10_000 + u64::from(number) * 1000, number)).last().unwrap();
    assert_eq!(report.stations[1].diagnosis_history.len(), MAX_DIAGNOSES - 1);
}

/// Two slaves send the same octets, which are a process alarm or the vendor's. Their Set_Prm comes behind the first diagnosis.
#[test]
fn a_device_related_block_is_an_alarm_only_on_a_slave_with_dp_v1() {
    const DPV0: usize = 0;
    const DPV1: usize = 1;
    let baud = Baud::B19200;
    let mut listener = Listener::new(baud);
    let mut now_ms = 0;
    let mut hear = |slave: usize, (sap, request): (u8, &[u8]), answer: Option<&[u8]>| {
        now_ms += 100;
        let start = BitTime(baud.tbit_of_ms(now_ms));
        let address = 8 + slave as u8;
        let fc = if now_ms % 200 == 0 { 0x5D } else { 0x7D };
        let request = emit(address, 1, Some((sap, 62)), fc, request);
        let answer_at = start + 11 * request.len() as u64 + 40;
        listener.hear(&Chunk { start: Some(start), octets: request, ..Chunk::default() });
        let octets = answer.map_or_else(|| vec![0xE5], |du| emit(1, address, Some((62, sap)), 0x08, du));
        listener.hear(&Chunk { start: Some(answer_at), octets, ..Chunk::default() });
        let report = BusReport::of(&listener.observer);
        let of = |slave: usize| report.stations[1 + slave].diagnosis.get(1).cloned().unwrap_or_default();
        let events = report.events.iter().filter(|event| event.kind == EventKind::Diagnosis);
        let history = report.stations.iter().flat_map(|station| &station.diagnosis_history);
        let history: Vec<String> = history.map(|it| it.reports.get(1).cloned().unwrap_or_default()).collect();
        let slaves: Vec<String> = (0..report.stations.len() - 1).map(of).collect();
        (slaves, events.map(|event| event.text.clone()).collect::<Vec<_>>(), history)
    };
    let block: &[u8] = &[0x08, 0x0C, 0, 1, 0xAA, 0xAB, 0x04, 0x02, 0x03, 0x09];
    let diagnosis = (60, &[][..]);
    let set_prm = |status| [0x88, 20, 11, 11, 0xAA, 0xAB, 1, status, 0, 0];
    let alarm = "process alarm of slot 3, sequence number 1, appears";
    let both = format!("device-related octets 02 03 09 (as DP-V1: {alarm})");
    hear(DPV0, diagnosis, Some(block));
    let (slaves, events, _) = hear(DPV1, diagnosis, Some(block));
    assert_eq!(slaves, [both.as_str(), both.as_str()]);
    assert!(events.iter().all(|text| text.ends_with(&format!("reports Ext_Diag; {both}"))), "{events:?}");
    assert_eq!(events.len(), 2);
    // The live list has other words at once. The contents are the same: no event, and nothing in the history.
    hear(DPV0, (61, &set_prm(0x00)), None);
    let (slaves, ..) = hear(DPV1, (61, &set_prm(0x80)), None);
    assert_eq!(slaves, ["vendor-specific octets 02 03 09", alarm]);
    hear(DPV0, diagnosis, Some(block));
    let (slaves, events, history) = hear(DPV1, diagnosis, Some(block));
    assert_eq!((slaves[DPV1].as_str(), events.len(), history.len()), (alarm, 2, 0));
    // A diagnosis with Prm_Fault and the same block takes the mode back: other words, no other contents.
    let refused = [&[0x48, 0x0D], &block[2..]].concat();
    let (slaves, events, history) = hear(DPV1, diagnosis, Some(&refused));
    assert_eq!((slaves[DPV1].as_str(), events.len(), history.len()), (both.as_str(), 2, 0));
    let (slaves, ..) = hear(DPV1, (51, &[0x5E, 1, 19, 4]), None);
    assert_eq!(slaves, ["vendor-specific octets 02 03 09", alarm]);
    // Set_Prm for another device, then another device at the address: the words of the first one stay in the history.
    let [high, low] = model_named("tpg300").unwrap().ident.to_be_bytes();
    hear(DPV1, (61, &[0x88, 20, 11, 11, high, low, 1]), None);
    let other = [&block[..5], &[0xAC], &block[6..]].concat();
    let (slaves, events, history) = hear(DPV1, diagnosis, Some(&other));
    assert_eq!((slaves[DPV1].as_str(), events.len(), history.as_slice()), (both.as_str(), 3, &[alarm.to_owned()][..]));
    // The first device is back, without a Set_Prm.
    hear(DPV1, (51, &[0x5E, 1, 19, 4]), None);
    let (slaves, events, history) = hear(DPV1, diagnosis, Some(block));
    assert_eq!((slaves[DPV1].as_str(), events.len()), (both.as_str(), 4));
    assert_eq!(history, [alarm, alarm]);
}

/// A master writes the unit by MS1 and reads a parameter in the parameter channel: name, value, way and requester.
#[test]
fn parameters_that_pass_are_shown_with_name_value_and_requester() {
    let model = model_named("bcg450").unwrap();
    let configuration = model
        .configurations
        .iter()
        .find(|it| it.outputs.is_some_and(|it| it.layout().any(|(_, field)| field == Field::ParameterChannel)))
        .unwrap();
    let mut listener = Listener::new(Baud::B19200);
    listener
        .observer
        .declare(9, Declared { model, configuration: Some(configuration), unit: model.unit_named("mbar") });
    let mut now = 0;
    let mut hear = |listener: &mut Listener, octets: &[u8]| {
        let chunk = Chunk { start: Some(BitTime(now)), octets: octets.to_vec(), ..Chunk::default() };
        now += 11 * octets.len() as u64 + 40;
        listener.hear(&chunk);
    };
    // Data Units of slot 1 becomes Torr: request, acknowledgement, poll, response.
    let torr = model.unit_named("Torr").unwrap().code.to_be_bytes();
    hear(&mut listener, &emit(9, 1, Some((51, 51)), 0x6D, &[0x5F, 1, 22, 2, torr[0], torr[1]]));
    hear(&mut listener, &[0xE5]);
    hear(&mut listener, &emit(9, 1, Some((51, 51)), 0x5D, &[]));
    hear(&mut listener, &emit(1, 9, Some((51, 51)), 0x08, &[0x5F, 1, 22, 2]));
    // The parameter channel reads Device State, slot 0 index 25: the task, then an exchange with its answer.
    let (outputs, inputs) = (configuration.outputs.unwrap(), configuration.inputs.unwrap());
    let read = model.channel_rules.tasks.iter().find(|(_, kind)| *kind == TaskKind::Read).unwrap().0;
    let mut task = vec![0; outputs.octets()];
    task[..3].copy_from_slice(&[read << 4, 0, 25]);
    let mut answer = vec![0; inputs.octets()];
    hear(&mut listener, &emit(9, 1, None, 0x7D, &task));
    hear(&mut listener, &emit(1, 9, None, 0x08, &answer));
    answer[..8].copy_from_slice(&[11 << 4, 0, 25, 0, 0, 0, 0, 4]);
    for fc in [0x5D, 0x7D] {
        hear(&mut listener, &emit(9, 1, None, fc, &task));
        hear(&mut listener, &emit(1, 9, None, 0x08, &answer));
    }
    let observer = &listener.observer;
    let text = |passed: &Passed| {
        let (name, value) = observer.parameter_text(9, passed);
        format!("{:?} {:?} by {}: {name} = {value}", passed.path, passed.done, passed.requester)
    };
    let passed: Vec<_> = observer.station(9).unwrap().parameters.passed().iter().map(text).collect();
    let [unit, state] = &passed[..] else { panic!("{passed:?}") };
    assert!(unit.starts_with("Ms1 Written by 1: ") && unit.ends_with("(slot 1 index 22) = Torr (1301)"), "{unit}");
    assert_eq!(state, "ParameterChannel Read by 1: device.device-state (slot 0 index 25) = EXECUTING (4)");
    assert!(
        observer
            .events()
            .iter()
            .any(|event| event.kind() == EventKind::Parameter && event.to_string().contains("= Torr (1301)"))
    );
    let facts = observer.station(9).unwrap().knowledge.facts(9).unwrap();
    assert_eq!(
        (facts.slave.unit.name, facts.unit),
        ("Torr", Origin::Heard),
        "a written unit replaces that of the file"
    );
}

/// The file says mbar and another configuration than the line: an event and a sentence for each, once, and none when they agree again.
#[test]
fn a_file_that_contradicts_the_line_is_an_event_and_a_sentence() {
    let model = model_named("bcg450").unwrap();
    let [file, line] = [&model.configurations[0], &model.configurations[1]];
    let (mbar, torr) = (model.unit_named("mbar").unwrap(), model.unit_named("Torr").unwrap());
    let mut listener = Listener::new(Baud::B19200);
    listener.observer.declare(9, Declared { model, configuration: Some(file), unit: Some(mbar) });
    let mut now = 0;
    let [high, low] = model.ident.to_be_bytes();
    let mut start = |unit: u16, configuration: &Configuration| {
        let user = model.user_prm.iter().find(|prm| prm.unit_code() == unit).unwrap().octets;
        let prm = [&[0x88, 1, 100, 11, high, low, 0][..], user].concat();
        for octets in [
            emit(9, 1, Some((61, 62)), 0x6D, &prm),
            vec![0xE5],
            emit(9, 1, Some((62, 62)), 0x5D, configuration.octets),
            vec![0xE5],
        ] {
            listener.hear(&Chunk { start: Some(BitTime(now)), octets: octets.clone(), ..Chunk::default() });
            now += 11 * octets.len() as u64 + 40;
        }
        let station = listener.observer.station(9).unwrap();
        let events = listener.observer.events().iter().map(|event| event.to_string());
        (
            events.filter(|text| text.contains("the file says")).collect::<Vec<_>>(),
            station.knowledge.unknown().iter().map(ToString::to_string).collect::<Vec<_>>(),
        )
    };
    assert_eq!(start(mbar.code, file), (vec![], vec![]));
    let (events, sentences) = start(torr.code, line);
    assert_eq!(events.len(), 2, "{events:?}");
    assert_eq!(sentences[0], "the file says unit mbar, the line shows Torr: Torr counts, correct the file");
    assert!(sentences[1].starts_with("the file says configuration "), "{sentences:?}");
    assert!(events[0].ends_with(&sentences[0]) && events[1].ends_with(&sentences[1]), "{events:?}");
    assert_eq!(start(torr.code, line).0.len(), 2, "once");
    let (events, sentences) = start(mbar.code, file);
    assert_eq!((events.len(), sentences.len()), (2, 0), "{sentences:?}");
}

/// Any number of masters: one rotation of the token shows all of them, and a master that leaves is missing in the next one.
#[test]
fn a_ring_of_any_number_of_masters_is_known_after_one_rotation() {
    for count in [1_u8, 2, 3, 32, 126] {
        let mut listener = Listener::new(Baud::B500000);
        let mut now = 0;
        let mut rotate = |listener: &mut Listener, masters: &[u8]| {
            for (index, from) in masters.iter().enumerate() {
                let to = masters[(index + 1) % masters.len()];
                listener.hear(&Chunk { start: Some(BitTime(now)), octets: vec![0xDC, to, *from], ..Chunk::default() });
                now += 33 + 37;
            }
        };
        // Each master sends the token to the next higher one.
        let all: Vec<u8> = (1..=count).collect();
        rotate(&mut listener, &all);
        assert_eq!(listener.observer.ring(), all);
        assert!(all.iter().all(|address| listener.observer.state(*address) == Some(StationState::Master)));
        rotate(&mut listener, &all);
        assert_eq!(listener.observer.rotation().range_tbit(), Some((70 * u64::from(count), 70 * u64::from(count))));
        if count > 2 {
            let fewer: Vec<u8> = all.iter().copied().filter(|address| *address != 2).collect();
            (0..2).for_each(|_| rotate(&mut listener, &fewer));
            assert_eq!(listener.observer.ring(), fewer);
        }
        let rings = listener.observer.events().iter().filter(|event| event.kind() == EventKind::Ring).count();
        assert_eq!(rings, if count > 2 { 2 } else { 1 }, "an event for each ring");
    }
}

/// The live list: each state by the traffic that shows it.
#[test]
fn the_live_list_has_the_state_that_the_traffic_shows() {
    const SET_PRM: (Option<(u8, u8)>, u8) = (Some((61, 62)), 0x5D);
    let baud = Baud::B19200;
    let mut listener = Listener::new(baud);
    let mut now = 0;
    let mut hear = |listener: &mut Listener, octets: &[u8]| {
        listener.hear(&Chunk { start: Some(BitTime(now)), octets: octets.to_vec(), ..Chunk::default() });
        now += 11 * octets.len() as u64 + 400;
    };
    let fdl_status = |da: u8| vec![0x10, da, 1, 0x49, da.wrapping_add(0x4A), 0x16];
    let present = |sa: u8| vec![0x10, 1, sa, 0x00, sa.wrapping_add(1), 0x16];
    let asks = |da, fc| emit(da, 1, SET_PRM.0, fc, &[0x88, 1, 100, 11, 0x08, 0xE6, 0]);
    // 2 answers FDL status, 3 acknowledges Set_Prm, 4 exchanges data, 5 answers nothing, 6 has answered before, 7 is never there.
    for telegram in [fdl_status(2), present(2), asks(3, SET_PRM.1), vec![0xE5], fdl_status(7)] {
        hear(&mut listener, &telegram);
    }
    let exchange = |address: u8| [emit(address, 1, None, 0x5D, &[1]), emit(1, address, None, 0x08, &[2])];
    [exchange(4), exchange(6)].concat().iter().for_each(|telegram| hear(&mut listener, telegram));
    for _ in 0..3 {
        hear(&mut listener, &asks(5, SET_PRM.1));
        hear(&mut listener, &emit(6, 1, None, 0x7D, &[1]));
    }
    hear(&mut listener, &[0xDC, 1, 1]);
    let states = |listener: &Listener| {
        let states = (1..=7).map(|address| listener.observer.state(address));
        states.map(|state| state.map_or("", StationState::text)).collect::<Vec<_>>()
    };
    let expected = ["master", "present without a master", "not configured", "exchanging", "missing", "missing", ""];
    assert_eq!(states(&listener), expected);
    // Four seconds later only the exchange with 4 goes on; a silent slave without requests may be present or not.
    now += baud.tbit_of_ms(4000);
    let [request, answer] = exchange(4);
    let request = emit(request[4], request[5], None, 0x7D, &[1]);
    for telegram in [request, answer] {
        listener.hear(&Chunk { start: Some(BitTime(now)), octets: telegram.clone(), ..Chunk::default() });
        now += 11 * telegram.len() as u64 + 400;
    }
    let expected = ["master", "not addressed", "not addressed", "exchanging", "", "not addressed", ""];
    assert_eq!(states(&listener), expected);
}

/// A station searches a gauge of its file with FDL status every few seconds; a master polls the addresses of its GAP with the same request.
#[test]
fn a_gauge_of_the_file_that_answers_no_fdl_status_is_missing_between_two_searches() {
    let baud = Baud::B19200;
    let mut listener = Listener::new(baud);
    let declared = Declared { model: model_named("bcg450").unwrap(), configuration: None, unit: None };
    listener.observer.declare(7, declared);
    let fdl_status = |da: u8| vec![0x10, da, 1, 0x49, da.wrapping_add(0x4A), 0x16];
    let mut now = 0;
    for _ in 0..3 {
        for address in [7, 8] {
            listener.hear(&Chunk { start: Some(BitTime(now)), octets: fdl_status(address), ..Chunk::default() });
            now += 11 * 6 + 400;
        }
        now += baud.tbit_of_ms(4000);
    }
    listener.observer.advance(BitTime(now));
    let states = |listener: &Listener| [7, 8].map(|address| listener.observer.state(address));
    assert_eq!(states(&listener), [Some(StationState::Missing), None]);
    listener.observer.advance(BitTime(now + baud.tbit_of_ms(10_000)));
    assert_eq!(states(&listener), [None, None], "the station has ended its search");
}

/// A receiver that has found an error waits for T_SYN of idle: damaged octets before that are the same damage.
#[test]
fn damaged_octets_without_t_syn_between_them_count_once() {
    for (pause_tbit, damaged) in [(0, 1), (32, 1), (33, 2), (500, 2)] {
        let mut listener = Listener::new(Baud::B19200);
        let octets = vec![0x01, 0x02, 0x03];
        let end = 11 * octets.len() as u64;
        for start in [0, end + pause_tbit] {
            listener.hear(&Chunk { start: Some(BitTime(start)), octets: octets.clone(), ..Chunk::default() });
        }
        listener.hear(&Chunk { start: Some(BitTime(5000)), octets: vec![0xDC, 1, 1], ..Chunk::default() });
        assert_eq!(listener.observer.totals().damaged, damaged, "{pause_tbit}");
    }
}
