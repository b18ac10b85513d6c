//! Publishes the batches of simulated stations as fast as the servers acknowledge them, to measure an archive.
//!
//! `cargo run --release -p profivac-archive --example load -- nats://127.0.0.1:4222 STATIONS GAUGES SAMPLES SECONDS`: each station has
//! GAUGES series with SAMPLES samples a second each, one batch a second, for SECONDS seconds that end now. The archive has made the
//! stream before. Prints what was published; `contrib/archive/load.py` runs it with all servers.

use async_nats::HeaderMap;
use async_nats::jetstream::{self, context::PublishAckFuture};
use axum::body::Bytes;
use profivac_recorder::batch::{Batch, FORMAT, Samples, Span};
use profivac_recorder::{Micros, Quality, Sample};
use std::collections::VecDeque;
use std::error::Error;
use std::time::{Duration, Instant};

/// The most batches without an acknowledgement.
const MAX_WAITING: usize = 512;

/// The pause when the servers hold as many batches of a station as they may, and the longest time of that.
const PAUSE: Duration = Duration::from_millis(100);
const LONGEST_WAIT: Duration = Duration::from_secs(120);

/// The batches of one second.
struct Load {
    gauges: u32,
    samples: u32,
    /// The state of the random numbers: noise keeps the batches from being compressed more than those of real gauges.
    random: u64,
}

impl Load {
    /// A number from 0 to 1 (xorshift64).
    fn random(&mut self) -> f64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn batch(&mut self, second: Micros) -> Batch {
        let samples = (0..self.gauges).map(|gauge| self.series(second, gauge)).collect();
        let has_spans = second.0 % (120 * Micros::SECOND) == 0;
        let spans = if has_spans { (0..self.gauges).map(|gauge| span(second, gauge)).collect() } else { Vec::new() };
        Batch { format: FORMAT, made_us: second.0, samples, spans, ..Batch::default() }
    }

    fn series(&mut self, second: Micros, gauge: u32) -> Samples {
        let samples: Vec<_> = (0..self.samples)
            .map(|number| {
                let at =
                    Micros(second.0 + i64::from(number) * Micros::SECOND / i64::from(self.samples) + i64::from(gauge));
                Sample::new(at, Some(1e-4 * (1.0 + 0.01 * self.random())), Quality::Valid)
            })
            .collect();
        Samples::new(name(gauge), &samples)
    }
}

fn name(gauge: u32) -> String {
    format!("gauge-{gauge}")
}

fn span(second: Micros, gauge: u32) -> Span {
    Span {
        series: name(gauge),
        level: 2,
        start_us: second.0 - 120 * Micros::SECOND,
        min_pa: Some(1e-4),
        max_pa: Some(1.01e-4),
        log10_sum: -480.0,
        count: 120,
        qualities: 1,
    }
}

/// A batch that is published until the servers have room for it.
struct Message {
    subject: String,
    headers: HeaderMap,
    payload: Bytes,
}

impl Message {
    async fn publish(&self, jetstream: &jetstream::Context) -> Result<PublishAckFuture, Box<dyn Error>> {
        let (subject, headers) = (self.subject.clone(), self.headers.clone());
        Ok(jetstream.publish_with_headers(subject, headers, self.payload.clone()).await?)
    }

    /// Waits until the batch is stored. While the share of its station is full, it is published again, as a station does: the first time
    /// at once, because the batches behind one that was refused were mostly refused with it.
    async fn stored(
        &self,
        jetstream: &jetstream::Context,
        mut acknowledgement: PublishAckFuture,
    ) -> Result<(), Box<dyn Error>> {
        let begun = Instant::now();
        let mut pause = Duration::ZERO;
        while let Err(error) = acknowledgement.await {
            if !error.to_string().contains("maximum messages per subject exceeded") || begun.elapsed() > LONGEST_WAIT {
                return Err(error.into());
            }
            tokio::time::sleep(pause).await;
            pause = PAUSE;
            acknowledgement = self.publish(jetstream).await?;
        }
        Ok(())
    }
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut next = |what: &str| arguments.next().ok_or_else(|| format!("expected {what}"));
    let server = next("the URL of a server")?;
    let stations: u32 = next("the number of stations")?.parse()?;
    let (gauges, samples) = (next("gauges of a station")?.parse()?, next("samples a second of a gauge")?.parse()?);
    let seconds: i64 = next("seconds")?.parse()?;
    let jetstream = jetstream::new(async_nats::connect(server).await?);
    let mut load = Load { gauges, samples, random: 0x9e37_79b9_7f4a_7c15 };
    let now = Micros::now().0.div_euclid(Micros::SECOND) * Micros::SECOND;
    let begun = Instant::now();
    let mut waiting: VecDeque<(PublishAckFuture, Message)> = VecDeque::new();
    let mut octets = 0_u64;
    for number in 1..=seconds {
        let second = Micros(now - (seconds - number) * Micros::SECOND);
        for station in 0..stations {
            let station = format!("load-{station}");
            let payload = load.batch(second).encode_compressed()?;
            octets += payload.len() as u64;
            let mut headers = HeaderMap::new();
            headers.insert("Profivac-Batch", format!("{station}/{now}/{number}").as_str());
            let message =
                Message { subject: format!("profivac.v1.load.{station}.batch"), headers, payload: payload.into() };
            waiting.push_back((message.publish(&jetstream).await?, message));
            if waiting.len() >= MAX_WAITING
                && let Some((acknowledgement, message)) = waiting.pop_front()
            {
                message.stored(&jetstream, acknowledgement).await?;
            }
        }
    }
    for (acknowledgement, message) in waiting {
        message.stored(&jetstream, acknowledgement).await?;
    }
    let batches = seconds * i64::from(stations);
    println!(
        "{batches} batches, {} samples, {:.1} MB published in {:.1} s",
        batches * i64::from(gauges) * i64::from(samples),
        octets as f64 / 1e6,
        begun.elapsed().as_secs_f64()
    );
    Ok(())
}
