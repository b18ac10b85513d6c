//! A gauge of another master, on a segment on which the station only listens.

use super::first_round::FirstRound;
use super::moment::Moment;
use super::readings::Assumed;
use super::shown_gauge::{Exchange, ShownGauge};
use crate::config;
use crate::recording::RecorderHandle;
use crate::view::{self, BusStationState};
use profivac_client::cyclic::{CyclicSlave, CyclicValues};
use profivac_dp::link::BitTime;
use profivac_recorder::Micros;
use profivac_recorder::validity::MAX_SILENCE;
use std::time::{Duration, Instant};

/// A gauge of another master.
pub struct HeardGauge {
    /// What it shows and records.
    pub shown: ShownGauge,
    /// The last data exchange on the line and on the clocks of the station.
    exchange: Option<(BitTime, Moment)>,
    first_round: FirstRound,
    sample_at: Instant,
    /// The assumptions about the configuration and the unit, in sentences.
    assumptions: Vec<String>,
}

/// The heard facts about a gauge of another master.
pub struct Heard {
    /// Everything that decodes its inputs; `None` while the configuration is not known.
    pub slave: Option<CyclicSlave>,
    /// The values of its last inputs.
    pub values: CyclicValues,
    /// The last data exchange since the port was opened, and the time since then; `None` without one.
    pub exchanged: Option<(BitTime, Duration)>,
    /// The unknown facts, in sentences.
    pub unknown: Vec<String>,
    /// What the values depend on and no telegram and no user has shown.
    pub assumed: Option<Assumed>,
    /// The state on the line, for a gauge that does not exchange data.
    pub problem: String,
}

impl HeardGauge {
    /// A gauge of which nothing was heard yet.
    pub fn new(config: config::Gauge, now: Moment) -> Self {
        let first_round = FirstRound::begin(now);
        let shown = ShownGauge::new(config).lost_since(now.wall);
        Self { shown, exchange: None, first_round, sample_at: now.at, assumptions: Vec::new() }
    }

    /// The same gauge, without readings since this time.
    pub fn lost_since(self, at: Micros) -> Self {
        Self { shown: self.shown.lost_since(at), ..self }
    }

    /// The port was opened: the gauge is not missed until its master has had time to ask it.
    pub fn port_opened(&mut self, now: Moment) {
        self.first_round.port_opened(now);
    }

    /// The same slave with another configuration. Under another name it is sampled at once, otherwise after the new interval at the latest.
    pub fn with_config(mut self, recorder: &RecorderHandle, config: config::Gauge, now: Moment) -> Self {
        let is_renamed = self.shown.reconfigure(recorder, config, now);
        let latest = if is_renamed { now.at } else { now.at + self.shown.config.poll };
        self.sample_at = self.sample_at.min(latest);
        self
    }

    /// Whether the gauge is to be sampled now.
    pub fn is_due(&self, now: Moment) -> bool {
        self.sample_at <= now.at
    }

    /// Takes what was observed on the line, and sets the time of the next sample. Validity and age follow the rules for a polled gauge.
    pub fn take_heard(&mut self, recorder: &RecorderHandle, heard: Heard, now: Moment) {
        let Heard { slave, values, exchanged, unknown, assumed, problem } = heard;
        self.sample_at = now.at + self.shown.config.poll;
        self.assumptions = unknown;
        match (slave, exchanged.filter(|(_, silence)| *silence < MAX_SILENCE)) {
            (Some(slave), Some((at, silence))) => {
                self.first_round.end();
                let read = self.exchange.filter(|(known, _)| *known == at).map(|(_, read)| read);
                let read = read.unwrap_or_else(|| now.before(silence));
                self.exchange = Some((at, read));
                self.shown.take_exchange(recorder, &Exchange { slave: &slave, values: &values, read, assumed }, now);
            }
            _ => {
                self.shown.lose_because(recorder, BusStationState::Missing, Some(problem), now);
                // It may have a reading soon, however seldom it is sampled.
                self.sample_at = self.sample_at.min(now.at + MAX_SILENCE);
            }
        }
    }

    /// Ends the readings because the port is lost, the segment stops or the gauge is removed.
    pub fn disconnect(&mut self, recorder: &RecorderHandle, problem: &str, now: Moment) {
        self.shown.disconnect(recorder, problem, now);
        self.sample_at = now.at;
    }

    /// The gauge as the API shows it.
    pub fn view_at(&self, segment: &str, now: Moment) -> view::Gauge {
        let assumptions = self.assumptions.clone();
        let is_awaited = self.first_round.is_awaited(now);
        view::Gauge { listen_only: true, assumptions, is_awaited, ..self.shown.view_at(segment, now) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_client::cyclic::ReportedChannels;
    use profivac_devices::catalog::model_named;
    use profivac_devices::profile::StatusExtension;
    use profivac_recorder::{Quality, Recorder, Sample, Settings};
    use tempfile::TempDir;

    fn moment() -> Moment {
        Moment { at: Instant::now(), wall: Micros(1_700_000_000_000_000) }
    }

    fn recorder() -> (TempDir, RecorderHandle) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let recorder = RecorderHandle::new(Recorder::start(&path, Settings::default()).unwrap(), path);
        (folder, recorder)
    }

    /// A BCG450 at address 5 whose telegram has integers in this unit.
    fn with_integers(unit: &str) -> CyclicSlave {
        let model = model_named("bcg450").unwrap();
        let (configuration, unit) = (&model.configurations[4], model.unit_named(unit).unwrap());
        CyclicSlave { address: 5, model, configuration, unit, channels: ReportedChannels::default() }
    }

    /// The number may be a pressure in the true unit, so the gauge has no fault that raises an alarm.
    #[test]
    fn a_number_that_is_no_pressure_in_an_assumed_unit_is_no_fault_of_the_gauge() {
        let (_folder, recorder) = recorder();
        let slave = with_integers("COUNTS");
        let now = moment();
        let heard = |exception: u8, status: u8, assumed| {
            let values = slave.decode_inputs(&[&[0; 8][..], &[exception, status, 2, 0, 0]].concat());
            let mut gauge =
                HeardGauge::new(config::Gauge::plain("chamber".to_owned(), 5, model_named("bcg450").unwrap()), now);
            let (slave, exchanged, unknown) = (Some(slave), Some((BitTime(1), Duration::ZERO)), Vec::new());
            let heard = Heard { slave, values, exchanged, unknown, assumed, problem: String::new() };
            gauge.take_heard(&recorder, heard, now);
            let view = gauge.view_at("hall", now);
            (view.readings[0].quality, view.state)
        };
        let invalid = StatusExtension::INVALID.bits();
        for (exception, status, assumed, quality, state) in [
            (0x80, 0, None, Quality::Fault, BusStationState::Fault),
            (0x80, 0, Some(Assumed::Unit), Quality::Assumed, BusStationState::DataExchange),
            // An alarm of the gauge does not depend on the unit.
            (0xA2, invalid, Some(Assumed::Unit), Quality::Fault, BusStationState::Fault),
            (0xA2, 0, Some(Assumed::Unit), Quality::Assumed, BusStationState::Fault),
            (0xA2, invalid, Some(Assumed::Configuration), Quality::Assumed, BusStationState::DataExchange),
        ] {
            assert_eq!(heard(exception, status, assumed), (quality, state), "{exception:02X} {status:02X} {assumed:?}");
        }
    }

    /// A BCG450 with integers in Pascal at 900 mbar: the diaphragm shows 32767.
    #[test]
    fn the_highest_integer_is_recorded_as_a_bound_and_one_event_names_the_limits() {
        let (_folder, recorder) = recorder();
        let slave = with_integers("Pascal");
        let values = slave.decode_inputs(&[&[0; 8][..], &[0x80, 0, 3, 0x7F, 0xFF]].concat());
        let config = config::Gauge::plain("chamber".to_owned(), 5, model_named("bcg450").unwrap());
        let now = moment();
        let mut gauge = HeardGauge::new(config, now);
        for number in 0..3 {
            gauge.take_heard(
                &recorder,
                Heard {
                    slave: Some(slave),
                    values: values.clone(),
                    exchanged: Some((BitTime(number), Duration::ZERO)),
                    unknown: Vec::new(),
                    assumed: None,
                    problem: String::new(),
                },
                now,
            );
        }
        let view = gauge.view_at("hall", now);
        let reading = &view.readings[0];
        assert_eq!((reading.quality, reading.pa, reading.limit_pa), (Quality::Overrange, None, Some(32767.0)));
        assert_eq!(view.integers.map(|it| (it.lowest_pa, it.highest_pa)), Some((1.0, 32767.0)));
        let reader = recorder.open_reader().unwrap();
        drop(recorder);
        let samples = reader.samples("chamber", Micros(0), Micros(i64::MAX)).unwrap();
        let is_bound = |sample: &Sample| (sample.quality, sample.pa) == (Quality::Overrange, Some(32767.0));
        assert!(!samples.is_empty() && samples.iter().all(is_bound), "{samples:?}");
        let events = reader.events(Micros(0), Micros(i64::MAX), 100).unwrap();
        let limits = "chamber: its integers in Pascal show 0.01 to 327.67 mbar only";
        assert_eq!(events.iter().filter(|event| event.text.starts_with(limits)).count(), 1, "{events:?}");
    }

    #[test]
    fn an_exchange_is_one_sample_with_its_time_however_often_the_gauge_is_sampled() {
        let (_folder, recorder) = recorder();
        let slave = with_integers("Pascal");
        let begin = moment();
        let config = config::Gauge::plain("chamber".to_owned(), 5, model_named("bcg450").unwrap());
        let mut gauge = HeardGauge::new(config, begin);
        let after =
            |ms| Moment { at: begin.at + Duration::from_millis(ms), wall: begin.wall.after(Duration::from_millis(ms)) };
        // Two exchanges, 10 ms and 110 ms after the beginning, each sampled three times.
        for (bus_time, exchanged_ms, octet) in [(BitTime(100), 10, 1), (BitTime(1_100), 110, 0x7F)] {
            for sampled_ms in [20, 40, 60].map(|later| exchanged_ms + later) {
                let values = slave.decode_inputs(&[&[0; 8][..], &[0x80, 0, 3, octet, 0]].concat());
                let silence = Duration::from_millis(sampled_ms - exchanged_ms);
                let heard = Heard {
                    slave: Some(slave),
                    values,
                    exchanged: Some((bus_time, silence)),
                    unknown: Vec::new(),
                    assumed: None,
                    problem: String::new(),
                };
                gauge.take_heard(&recorder, heard, after(sampled_ms));
                assert_eq!(gauge.view_at("hall", begin).read_at, Some(after(exchanged_ms).wall));
            }
        }
        let reader = recorder.open_reader().unwrap();
        drop(recorder);
        let spans = reader.trend("chamber", Micros(0), Micros(i64::MAX), 1).unwrap();
        assert_eq!(spans.iter().map(|span| span.summary.count).sum::<u32>(), 2);
        let samples = reader.samples("chamber", Micros(0), Micros(i64::MAX)).unwrap();
        assert!(samples.iter().all(|sample| [10, 110].map(|ms| after(ms).wall).contains(&sample.at)), "{samples:?}");
    }
}
