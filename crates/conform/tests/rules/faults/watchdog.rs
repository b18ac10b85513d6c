//! Slaves with a fault in their watchdog.

use super::*;
use profivac_dp::link::Baud;
use profivac_dp::slave::Watchdog;

/// A Set_Prm and a wait for the watchdog: factors of the last one, in ms, and when it began.
#[derive(Clone, Copy, Default)]
struct Watch {
    period_ms: u64,
    begun_ms: u64,
}

pub static SLAVES: &[FaultySlave] = &[
    slave("watchdog.no-bit", "reports WD_On at any time", Reports(|du| du[TWO] |= 0x08)),
    slave(
        "watchdog.off",
        "runs a watchdog that is switched off",
        Reacts(|| {
            Box::new(|line, octets| {
                let received = line.send(octets);
                let Some(request) = Frame::parse(octets) else { return received };
                if is_valid_prm(&request) && request.du[0] & WD_ON == 0 {
                    let mut watched = request;
                    watched.du[..3].copy_from_slice(&[LOCK | WD_ON, 20, 1]);
                    return line.send(&as_first(&watched));
                }
                let Some(mut answer) = Frame::parse_answer(&received) else { return received };
                let short = line.slave.state().owner().and_then(|owner| owner.watchdog).is_some_and(is_200_ms);
                diagnosis(&request, &mut answer, |du| {
                    if short {
                        du[TWO] &= !0x08;
                    }
                });
                Received::Telegram(answer.octets())
            })
        }),
    ),
    slave(
        "watchdog.expiry",
        "has a watchdog that never expires",
        ChangesRequest(|request| {
            if is_valid_prm(request) && request.du[0] & WD_ON != 0 {
                request.du[1..3].copy_from_slice(&[255, 255]);
            }
        }),
    ),
    slave("watchdog.bit", "does not report WD_On", Reports(|du| du[TWO] &= !0x08)),
    slave(
        "watchdog.no-owner",
        "keeps its owner after the watchdog has expired",
        Reacts(|| {
            let mut ran = false;
            Box::new(move |line, octets| {
                let received = line.send(octets);
                let Some(request) = Frame::parse(octets) else { return received };
                ran = (ran && request.dsap != SET_PRM) || line.slave.watchdog_is_running();
                let expired = ran && is_waiting(&line.slave);
                let Some(mut answer) = Frame::parse_answer(&received) else { return received };
                diagnosis(&request, &mut answer, |du| {
                    if expired {
                        du[OWNER] = MASTER;
                    }
                });
                Received::Telegram(answer.octets())
            })
        }),
    ),
    slave(
        "watchdog.restart",
        "does not restart the watchdog with Data_Exchange",
        Reacts(|| {
            let mut watch = Watch::default();
            Box::new(move |line, octets| {
                let Some(request) = Frame::parse(octets) else { return line.send(octets) };
                if is_prm(&request) {
                    let on = request.du[0] & WD_ON != 0;
                    let period_ms = if on { 10 * u64::from(request.du[1]) * u64::from(request.du[2]) } else { 0 };
                    watch = Watch { period_ms, begun_ms: line.now_ms() };
                }
                if watch.period_ms != 0 && line.now_ms() > watch.begun_ms + watch.period_ms {
                    leave(line);
                }
                line.send(octets)
            })
        }),
    ),
];

fn is_200_ms(watchdog: Watchdog) -> bool {
    watchdog.period_tbit == Baud::B19200.tbit_of_ms(200)
}
