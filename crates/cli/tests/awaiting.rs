//! Programs that await gauges: many at once, cancelled requests, a lost port.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::Program;
use pollster::block_on;
use profivac_client::{AsyncBus, Bus, ErrorKind, ms2};
use std::task::{Context, Waker};
use std::thread;
use std::time::Duration;

fn bus(simulation: &Program, timeout: Duration) -> AsyncBus {
    Bus::builder(format!("tcp://{}", simulation.ready())).timeout(timeout).open_async().unwrap()
}

#[test]
fn many_threads_await_many_gauges() {
    let addresses = 5..13_u8;
    let devices: Vec<_> = addresses.clone().map(|address| format!("bcg450@{address}")).collect();
    let devices: Vec<_> = devices.iter().map(String::as_str).collect();
    let simulation = Program::start(&[&["simulate", "--tcp", "127.0.0.1:0"], &devices[..]].concat());
    let bus = bus(&simulation, Duration::from_secs(5));
    let work = addresses.map(|address| {
        let gauge = bus.gauge(address);
        thread::spawn(move || {
            block_on(async {
                gauge.write("pirani.safe-value", &format!("{address} mbar")).await?;
                gauge.read("pirani.safe-value").await
            })
        })
    });
    let work: Vec<_> = work.collect();
    for (thread, address) in work.into_iter().zip(5..) {
        assert_eq!(thread.join().unwrap().unwrap().text, format!("{address} mbar"));
    }
}

#[test]
fn a_cancelled_request_does_not_disturb_others() {
    let simulation = Program::start(&["simulate", "--tcp", "127.0.0.1:0", "bcg450@5"]);
    let bus = bus(&simulation, Duration::from_secs(5));
    let gauge = bus.gauge(5);
    for _ in 0..5 {
        let mut given_up = Box::pin(gauge.read("1:2/24"));
        let mut context = Context::from_waker(Waker::noop());
        assert!(given_up.as_mut().poll(&mut context).is_pending());
    }
    assert_eq!(block_on(gauge.read("device.device-state")).unwrap().text, "IDLE");
    // The value of the gauge, not of the requests. Dropping the gauge restores it although they were cancelled.
    assert_eq!(block_on(gauge.read("1/46")).unwrap().text, "1");
    block_on(gauge.read("1:2/24")).unwrap();
    drop(gauge);
    assert_eq!(bus.submit(|session| ms2::read(session, 5, 1, 46).unwrap()).wait().unwrap(), [1]);
}

#[test]
fn a_lost_port_ends_every_wait() {
    let mut simulation = Program::start(&["simulate", "--tcp", "127.0.0.1:0", "bcg450@5"]);
    let bus = bus(&simulation, Duration::from_secs(60));
    let gauge = bus.gauge(9);
    let waiting = thread::spawn(move || block_on(gauge.read("0/25")));
    let gauge = bus.gauge(5);
    simulation.kill();
    let error = waiting.join().unwrap().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Line, "{error}");
    let ended = block_on(gauge.read("0/25")).unwrap_err().to_string();
    assert!(ended.contains("lost") || ended == "the bus is closed", "{ended}");
    let mut last = ended;
    while last != "the bus is closed" {
        last = block_on(gauge.read("0/25")).unwrap_err().to_string();
    }
}
