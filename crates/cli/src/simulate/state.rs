//! The answer to the command `state ADDR`.

use crate::output::visible_json;
use profivac_virtual::device::VirtualDevice;
use profivac_virtual::gsd_slave::GsdStation;
use serde::Serialize;

/// The keys of the answer, in their order.
#[derive(Debug, Serialize)]
struct State {
    /// The station address at which the device answers; Set_Slave_Add may have changed it.
    address: u8,
    device_state: &'static str,
    led: &'static str,
    relays: Vec<bool>,
    true_mbar: f64,
    indicated: Vec<Indicated>,
    active_instance: u8,
    exception_status: u8,
    outputs_safe: bool,
    emission: Vec<bool>,
    degas: Vec<bool>,
    run_hours: f64,
}

#[derive(Debug, Serialize)]
struct Indicated {
    instance: u8,
    value_mbar: f64,
    valid: bool,
}

/// The state of a slave by its GSD file as one line of JSON.
pub fn slave_json(slave: &GsdStation) -> String {
    // Numbers, strings and lists always have a JSON form.
    visible_json(&serde_json::to_string(&slave.state()).unwrap_or_default())
}

/// The state of a device as one line of JSON. A value that is not a number is `null`.
pub fn json(device: &VirtualDevice, true_mbar: f64) -> String {
    let report = device.report();
    let indicated = report.indicated.iter().map(|shown| Indicated {
        instance: shown.instance,
        value_mbar: shown.value_mbar,
        valid: shown.valid,
    });
    let state = State {
        address: device.station_address(),
        device_state: report.device_state.name(),
        led: report.led.name(),
        relays: report.relays.iter().copied().collect(),
        true_mbar,
        indicated: indicated.collect(),
        active_instance: report.active_instance,
        exception_status: report.exception_status,
        outputs_safe: report.outputs_safe,
        emission: report.emission.iter().copied().collect(),
        degas: report.degas.iter().copied().collect(),
        run_hours: report.run_hours,
    };
    // Numbers, strings and lists always have a JSON form.
    serde_json::to_string(&state).unwrap_or_default()
}
