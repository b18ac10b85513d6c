//! A bus of another master behind a TCP port: a BCG450 with pressures in Torr, started and asked as a PLC does it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]
#![allow(dead_code, reason = "each test uses its part")]

use profivac_devices::catalog::model_named;
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};
use std::io::{ErrorKind, Read, Write};
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// The address of the other master.
pub const MASTER: u8 = 2;

/// The address of its gauge.
pub const SLAVE: u8 = 12;

/// The bus. It counts the octets that a listener sends.
pub struct ForeignBus {
    pub port: u16,
    pub sent_by_listener: Arc<AtomicU64>,
    /// The master starts its slave again.
    pub restart: Arc<AtomicBool>,
}

fn telegram(da: u8, sa: u8, saps: Option<(u8, u8)>, fc: u8, du: &[u8]) -> Vec<u8> {
    let mut octets = vec![0; MAX_TELEGRAM];
    let (dsap, ssap) = saps.map_or((None, None), |(dsap, ssap)| (Some(dsap), Some(ssap)));
    let length = Telegram::Data(DataTelegram { da, sa, dsap, ssap, fc, du }).emit(&mut octets).unwrap();
    octets.truncate(length);
    octets
}

/// One start-up of a BCG450 with pressures in Torr, as a PLC does it.
fn start_up() -> Vec<Vec<u8>> {
    let model = model_named("bcg450").unwrap();
    let torr = model.unit_named("Torr").unwrap();
    let user = model.user_prm.iter().find(|prm| prm.unit_code() == torr.code).unwrap();
    let [high, low] = model.ident.to_be_bytes();
    let prm = [&[0x88, 1, 100, 11, high, low, 0][..], user.octets].concat();
    let diagnosis = [0x00, 0x0C, 0x00, MASTER, high, low];
    vec![
        telegram(SLAVE, MASTER, Some((61, 62)), 0x6D, &prm),
        vec![0xE5],
        telegram(SLAVE, MASTER, Some((62, 62)), 0x5D, model.configurations[1].octets),
        vec![0xE5],
        telegram(SLAVE, MASTER, Some((60, 62)), 0x7D, &[]),
        telegram(MASTER, SLAVE, Some((62, 60)), 0x08, &diagnosis),
    ]
}

/// One cycle: a token, an exchange, and every tenth time a repetition.
fn cycle(number: u64) -> Vec<Vec<u8>> {
    let inputs = [&[0x80, 0x00, 0x02][..], &1.0e-4_f32.to_be_bytes()].concat();
    let request = telegram(SLAVE, MASTER, None, if number.is_multiple_of(2) { 0x7D } else { 0x5D }, &[]);
    let answer = telegram(MASTER, SLAVE, None, 0x08, &inputs);
    let repetition = if number.is_multiple_of(10) { vec![request.clone()] } else { Vec::new() };
    [vec![vec![0xDC, MASTER, MASTER]], repetition, vec![request, answer]].concat()
}

/// A fault on the bus from its twentieth cycle on.
#[derive(Clone, Copy)]
pub enum Incident {
    None,
    Lost,
    Burst,
    Diagnosis,
    /// The master starts its slave when a test says so.
    LateStartUp,
    /// The same, and the slave sends five octets: a float behind Exception Status, or an integer behind status and selector.
    FiveOctets,
}

/// The first cycle of an incident.
const INCIDENT: u64 = 20;

impl Incident {
    fn cycle(self, number: u64) -> Vec<Vec<u8>> {
        let usual = cycle(number);
        let is_now = number >= INCIDENT;
        match self {
            Self::Lost if is_now => usual.into_iter().filter(|telegram| telegram.get(4) != Some(&MASTER)).collect(),
            Self::Burst if is_now => [usual, vec![vec![0x68, 0x05, 0x05, 0x68, 0x01]]].concat(),
            Self::Diagnosis if number == INCIDENT => {
                let [high, low] = model_named("bcg450").unwrap().ident.to_be_bytes();
                // Ext_Diag, and a device-related diagnosis with one octet.
                let diagnosis = [0x08, 0x0C, 0x00, MASTER, high, low, 0x02, 0x80];
                let asked = telegram(SLAVE, MASTER, Some((60, 62)), 0x7D, &[]);
                [usual, vec![asked, telegram(MASTER, SLAVE, Some((62, 60)), 0x08, &diagnosis)]].concat()
            }
            Self::FiveOctets => {
                let inputs = [&[0x80][..], &1.0e-4_f32.to_be_bytes()].concat();
                let others = usual.into_iter().filter(|telegram| telegram.get(4) != Some(&MASTER));
                others.chain([telegram(MASTER, SLAVE, None, 0x08, &inputs)]).collect()
            }
            Self::None | Self::Lost | Self::Burst | Self::Diagnosis | Self::LateStartUp => usual,
        }
    }
}

impl ForeignBus {
    /// A bus without a fault.
    pub fn begin() -> Self {
        Self::with(Incident::None)
    }

    pub fn with(incident: Incident) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let sent_by_listener = Arc::new(AtomicU64::new(0));
        let counter = Arc::clone(&sent_by_listener);
        let restart = Arc::new(AtomicBool::new(!matches!(incident, Incident::LateStartUp | Incident::FiveOctets)));
        let starts = Arc::clone(&restart);
        std::thread::spawn(move || {
            let Ok((mut stream, _)) = listener.accept() else { return };
            // The time in which the listener could send paces the bus.
            stream.set_read_timeout(Some(Duration::from_millis(10))).unwrap();
            stream.set_nodelay(true).unwrap();
            for number in 0_u64.. {
                let is_start = number >= 3 && starts.swap(false, Ordering::Relaxed);
                let telegrams = if is_start { start_up() } else { incident.cycle(number) };
                for telegram in telegrams {
                    if stream.write_all(&telegram).is_err() {
                        return;
                    }
                    match stream.read(&mut [0; 64]) {
                        Ok(0) => return,
                        Ok(count) => drop(counter.fetch_add(count as u64, Ordering::Relaxed)),
                        Err(error) => assert!(matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)),
                    }
                }
            }
        });
        Self { port, sent_by_listener, restart }
    }
}
