//! A message becomes a batch, or is refused with the reason.

use crate::nats::{of_message_id, of_subject};
use profivac_recorder::batch::{Batch, BatchError, Samples};
use profivac_recorder::{Micros, Sample};

/// Rows with times before this one are of a clock that was not set: 2000-01-01.
const EARLIEST: i64 = 946_684_800 * Micros::SECOND;

/// How far the clock of a station may be ahead of that of the archive. free choice.
const MAX_AHEAD: i64 = 3_600 * Micros::SECOND;

/// A message of a station.
#[derive(Clone, Debug)]
pub struct Incoming {
    /// Its subject.
    pub subject: String,
    /// Its id.
    pub id: String,
    /// Its octets.
    pub payload: Vec<u8>,
}

/// A batch that can be stored.
pub struct Accepted<'a> {
    pub plant: &'a str,
    pub station: &'a str,
    pub epoch: i64,
    pub number: i64,
    pub batch: Batch,
    pub samples: Vec<(String, Vec<Sample>)>,
}

impl Accepted<'_> {
    /// The number of rows and samples.
    pub fn weight(&self) -> usize {
        self.batch.sample_count().saturating_add(self.batch.row_count())
    }
}

/// Decodes and checks a message, or says why it cannot be stored.
pub fn accept(message: &Incoming, now: Micros) -> Result<Accepted<'_>, String> {
    let (plant, station) = of_subject(&message.subject).ok_or("the subject is not profivac.v1.PLANT.STATION.batch")?;
    let (epoch, number) =
        of_message_id(&message.id, station).ok_or_else(|| format!("the id is not {station}/EPOCH/NUMBER"))?;
    let batch = Batch::decode_compressed(&message.payload).map_err(|error| error.to_string())?;
    let unpack = |series: &Samples| Ok((text(&series.series), series.unpack()?));
    let unpacked: Result<Vec<_>, BatchError> = batch.samples.iter().map(unpack).collect();
    let samples = unpacked.map_err(|error| error.to_string())?;
    check_times(&batch, &samples, now)?;
    Ok(Accepted { plant, station, epoch, number, batch, samples })
}

/// A batch with times of a wrong clock is put aside whole: its rows would be found nowhere, and its partitions be dropped or wait for
/// years.
fn check_times(batch: &Batch, samples: &[(String, Vec<Sample>)], now: Micros) -> Result<(), String> {
    let of_samples = samples.iter().flat_map(|(_, samples)| samples.iter().map(|sample| sample.at.0));
    let of_lists = batch.events.iter().map(|row| row.at_us).chain(batch.alarms.iter().map(|row| row.at_us));
    let all = of_samples.chain(of_lists).chain(batch.audit.iter().map(|row| row.at_us));
    let all = all.chain(batch.spans.iter().map(|span| span.start_us)).chain([batch.made_us]);
    let latest = now.0.saturating_add(MAX_AHEAD);
    let wrong = all.into_iter().find(|at| !(EARLIEST..=latest).contains(at));
    wrong.map_or(Ok(()), |at| match at < EARLIEST {
        true => Err(format!("a time before 2000 ({at} µs since 1970): the clock of the station was not set")),
        false => Err(format!(
            "a time {} s ahead of the clock of the archive: set the clock of the station",
            at.saturating_sub(now.0) / Micros::SECOND
        )),
    })
}

/// A text that PostgreSQL accepts: it has no NUL.
pub fn text(text: &str) -> String {
    text.replace('\0', "\u{fffd}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_recorder::Quality;
    use profivac_recorder::batch::FORMAT;

    const NOW: Micros = Micros(1_700_000_000 * Micros::SECOND);

    fn message(at: i64) -> Incoming {
        let samples = [Sample::new(Micros(at), Some(1.0), Quality::Valid)];
        let samples = vec![Samples::new("chamber".to_owned(), &samples)];
        let batch = Batch { format: FORMAT, made_us: NOW.0, samples, ..Batch::default() };
        let payload = batch.encode_compressed().unwrap();
        Incoming { subject: "profivac.v1.hall.hall-1.batch".to_owned(), id: "hall-1/5/7".to_owned(), payload }
    }

    #[test]
    fn a_message_has_plant_station_epoch_number_and_samples() {
        let message = message(NOW.0);
        let accepted = accept(&message, NOW).unwrap();
        assert_eq!((accepted.plant, accepted.station, accepted.epoch, accepted.number), ("hall", "hall-1", 5, 7));
        assert_eq!(accepted.samples[0].1[0].at, NOW);
    }

    #[test]
    fn a_wrong_clock_another_station_and_damage_are_refused_with_a_reason() {
        let reason = |message: Incoming| accept(&message, NOW).err().unwrap();
        assert!(reason(message(0)).contains("was not set"));
        assert!(reason(message(NOW.0 + 3_601 * Micros::SECOND)).contains("3601 s ahead"));
        assert!(accept(&message(NOW.0 + 3_600 * Micros::SECOND), NOW).is_ok());
        assert!(reason(Incoming { id: "hall-2/5/7".to_owned(), ..message(NOW.0) }).contains("hall-1/EPOCH/NUMBER"));
        assert!(reason(Incoming { subject: "x".to_owned(), ..message(NOW.0) }).contains("the subject is not"));
        assert!(reason(Incoming { payload: vec![255; 9], ..message(NOW.0) }).contains("the batch is damaged"));
    }

    #[test]
    fn a_text_has_no_nul() {
        assert_eq!(text("a\0b"), "a\u{fffd}b");
    }
}
