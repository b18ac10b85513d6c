//! The report of a device without power.

use profivac_devices::{SimulatedDevice, StateReport};

/// The lists keep their entries; no relay is closed, nothing is on or valid, and nothing changes with time.
pub fn shows_nothing<D: SimulatedDevice>(device: &mut D) {
    let on = device.report();
    device.set_power(false);
    let off = device.report();
    assert_eq!(off.device_state.name(), "OFF");
    assert_eq!(off.led.name(), if on.led.name() == "none" { "none" } else { "off" });
    for lists in [|it: &StateReport| it.relays, |it: &StateReport| it.emission, |it: &StateReport| it.degas] {
        assert_eq!(lists(&off).iter().count(), lists(&on).iter().count(), "{off:?}");
        assert!(lists(&off).iter().all(|on| !on), "{off:?}");
    }
    let instances = |report: &StateReport| report.indicated.iter().map(|shown| shown.instance).collect::<Vec<_>>();
    assert_eq!(instances(&off), instances(&on));
    assert!(off.indicated.iter().all(|shown| shown.value_mbar.is_nan() && !shown.valid), "{off:?}");
    assert!(off.outputs_safe, "{off:?}");
    assert_eq!((off.active_instance, off.exception_status), (0, 0));
    assert_eq!(off.run_hours.to_bits(), on.run_hours.to_bits());
    device.advance(3600.0);
    device.settle();
    assert_eq!(device.report().run_hours.to_bits(), on.run_hours.to_bits());
    device.set_power(true);
    assert_ne!(device.report().device_state.name(), "OFF");
}
