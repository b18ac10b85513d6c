//! Several gauges at once, awaited: the bus runs in a thread of its own, and any runtime will do. Here there is none.
//!
//! ```sh
//! profivac simulate --pty /tmp/line --pressure '5e-6 mbar' bcg450@5 hpg400@6
//! cargo run -p profivac-host --example asynchronous -- /tmp/line 5 6
//! ```

use profivac_client::bus::{Bus, BusError};
use profivac_dp::link::Baud;
use profivac_host::session::{BusSession, bus_parameters};
use profivac_virtual::open;
use std::error::Error;
use std::pin::pin;
use std::sync::Arc;
use std::task::{Context, Poll, Wake, Waker};
use std::thread::{self, Thread};
use std::time::Duration;

/// What the gauges measure, line by line.
pub fn report(port_name: &str, addresses: &[u8]) -> Result<Vec<String>, Box<dyn Error>> {
    let name = port_name.to_owned();
    let bus = Bus::open(move || {
        let baud = Baud::B19200;
        BusSession::new(open::port(&name, baud)?, baud, bus_parameters(0, baud), Duration::from_secs(5))
    })?;
    Ok(block_on(all(&bus, addresses))?)
}

async fn all(bus: &Bus, addresses: &[u8]) -> Result<Vec<String>, BusError> {
    let mut lines = Vec::new();
    for address in addresses {
        let gauge = bus.gauge(*address);
        if gauge.parameter("device.device-state").await?.text == "IDLE" {
            gauge.command("execute").await?;
        }
        // Several things in one go: the gauge is asked who it is once only.
        let (title, pressure) = gauge.with(|gauge| Ok((gauge.model().title, gauge.pressure()?))).await?;
        let text = pressure.pa.map_or_else(|| "nothing valid".to_owned(), |pa| format!("{:.3e} mbar", pa / 100.0));
        lines.push(format!("{title} at address {address}: {text}"));
    }
    Ok(lines)
}

/// The smallest runtime: this thread, woken.
fn block_on<T>(future: impl Future<Output = T>) -> T {
    struct Unpark(Thread);
    impl Wake for Unpark {
        fn wake(self: Arc<Self>) {
            self.0.unpark();
        }
    }
    let waker = Waker::from(Arc::new(Unpark(thread::current())));
    let mut context = Context::from_waker(&waker);
    let mut future = pin!(future);
    loop {
        match future.as_mut().poll(&mut context) {
            Poll::Ready(value) => return value,
            Poll::Pending => thread::park(),
        }
    }
}

#[allow(dead_code, reason = "a test takes only what is above")]
fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let port = arguments.next().ok_or("expected PORT ADDRESS...")?;
    let addresses: Vec<u8> = arguments.map(|address| address.parse()).collect::<Result<_, _>>()?;
    for line in report(&port, &addresses)? {
        println!("{line}");
    }
    Ok(())
}
