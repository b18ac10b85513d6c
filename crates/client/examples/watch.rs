//! Watches the pressures of several gauges without blocking: the bus runs in a thread of its own, and any async runtime can
//! await it. This example has none: pollster waits for the future.
//!
//! On a gauge with several instances the Channel Instance Selector, which the manuals list as nonvolatile, is written when another
//! instance begins to measure, and once at the end; for days of measurement without any write exchange cyclic data instead.
//!
//! ```sh
//! profivac simulate --pty /tmp/line --pressure '5e-6 mbar' bcg450@5 hpg400@6
//! cargo run -p profivac-client --example watch -- /tmp/line 5 6
//! ```

use profivac_client::cyclic::ChannelValue;
use profivac_client::ms2::Ms2;
use profivac_client::{AsyncBus, AsyncGauge, Bus, ClientError, Gauge};
use profivac_devices::profile::DeviceState;
use std::error::Error;
use std::ops::ControlFlow;

/// Reads the gauges at `addresses` in turn, and gives each reading to `report` until it breaks.
///
/// A gauge in IDLE is started first.
pub async fn watch<B>(
    bus: &AsyncBus,
    addresses: &[u8],
    mut report: impl FnMut(u8, ChannelValue) -> ControlFlow<B>,
) -> Result<Option<B>, ClientError> {
    // The gauges are kept, so that their selectors are restored once and not after each reading.
    let gauges: Vec<(u8, AsyncGauge)> = addresses.iter().map(|address| (*address, bus.gauge(*address))).collect();
    for (_, gauge) in &gauges {
        gauge.with(start_if_idle).await?;
    }
    let mut end = None;
    for (address, gauge) in gauges.iter().cycle() {
        let reading = gauge.pressure().await?;
        if let ControlFlow::Break(value) = report(*address, reading) {
            end = Some(value);
            break;
        }
    }
    for (_, gauge) in &gauges {
        gauge.restore_selector().await?;
    }
    Ok(end)
}

/// Runs in the thread of the bus, as one piece.
fn start_if_idle(gauge: &mut Gauge<Ms2<'_>>) -> Result<(), ClientError> {
    if gauge.device_state()? == DeviceState::Idle {
        gauge.command("execute")?;
    }
    Ok(())
}

#[allow(dead_code, reason = "a test calls only the functions above")]
fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let port = arguments.next().ok_or("expected PORT ADDRESS...")?;
    let addresses: Vec<u8> = arguments.map(|address| address.parse()).collect::<Result<_, _>>()?;
    let bus = Bus::builder(port).open_async()?;
    pollster::block_on(watch(&bus, &addresses, |address, reading| {
        match reading.pressure() {
            Some(pressure) => println!("{address}: {:.3e} mbar", pressure.mbar()),
            None => println!("{address}: no valid reading"),
        }
        ControlFlow::<()>::Continue(())
    }))?;
    Ok(())
}
