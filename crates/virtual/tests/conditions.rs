//! The conditions of commands, as the client library checks them.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_client::cyclic::{CyclicSlave, ReportedChannels};
use profivac_client::ms2::Ms2;
use profivac_client::pressure::Pressure;
use profivac_client::{ClientError, FoundPressure, Gauge, PressureLimit, Unmet};
use profivac_dp::link::Baud;
use profivac_dp::link::active::BusParameters;
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::{DeviceSpec, entry};
use profivac_virtual::memory_segment::MemorySegment;
use profivac_virtual::nonvolatile::NonvolatileMemory;

const ADDRESS: u8 = 5;
const BAUD: Baud = Baud::B1500000;

/// A device in EXECUTING at a pressure.
fn executing(device: &str, mbar: f64) -> MemorySegment {
    let spec: DeviceSpec = format!("{device}@{ADDRESS}").parse().unwrap();
    let model = entry(device).unwrap().model;
    let pressure = Pressure::from_mbar(mbar);
    let around = GasConditions { pressure, atmosphere: Pressure::from_mbar(1013.25), gas: Gas::N2 };
    let device = VirtualDevice::new(spec.build(NonvolatileMemory::volatile(), BAUD).unwrap(), ADDRESS, BAUD, around);
    let slave = CyclicSlave {
        address: ADDRESS,
        model,
        configuration: model.default_configuration,
        unit: model.unit_named("mbar").unwrap(),
        channels: ReportedChannels::default(),
    };
    let bus = BusParameters::new(1, BAUD).check().unwrap();
    let mut segment = MemorySegment::new(vec![device], vec![slave], bus, BAUD).unwrap();
    segment.run_until(5.0);
    let sent = command(&mut segment, "execute");
    assert!(matches!(sent, None | Some(Unmet::State { .. })), "{sent:?}");
    segment.run_until(30.0);
    segment
}

/// Sends a command. Returns the condition that is not met.
fn command(segment: &mut MemorySegment, name: &str) -> Option<Unmet> {
    let model = segment.slaves()[0].model;
    match Gauge::with_model(Ms2::new(segment, ADDRESS), ADDRESS, model).command(name) {
        Ok(_) => None,
        Err(ClientError::Condition { unmet, .. }) => Some(unmet),
        Err(error) => panic!("{name}: {error}"),
    }
}

/// tira36e1 3.2.1.1, tira56e1 8.2.1 and 8.3.1, tira41d1 3.3.5.2: the chamber is vented.
#[test]
fn a_scale_is_adjusted_in_a_vented_chamber_only() {
    for (device, name, limit_mbar) in [
        ("bpg400", "full-scale-adjust", 100.0),
        ("pcg550", "pirani.gain-adjust", 100.0),
        ("pcg550", "atm.gain-adjust", 300.0),
        ("bcg450", "atmosphere-adjust", 300.0),
    ] {
        let limit = PressureLimit::Above(limit_mbar * 100.0);
        let unmet = command(&mut executing(device, 5e-6), name);
        let is_below_range = matches!(
            unmet, Some(Unmet::WrongPressure { found: FoundPressure::Below(_), limit: found, .. }) if found == limit
        );
        assert!(is_below_range, "{device} {name}: {unmet:?}");
        let unmet = command(&mut executing(device, 10.0), name);
        let is_low = matches!(
            unmet, Some(Unmet::WrongPressure { found: FoundPressure::At(pa), .. }) if pa < limit_mbar * 100.0
        );
        assert!(is_low, "{device} {name}: {unmet:?}");
        assert_eq!(command(&mut executing(device, 1000.0), name), None, "{device} {name}");
    }
}

/// tira56e1 8.1.1 and 8.2.1, BG 5530 4.4.2: the gauge measures nothing.
#[test]
fn a_zero_is_adjusted_in_vacuum_only() {
    for (device, name) in
        [("pcg550", "cdg.zero-adjust"), ("pcg550", "pirani.zero-adjust"), ("img400", "channel.4/zero-adjust")]
    {
        let unmet = command(&mut executing(device, 1000.0), name);
        assert!(
            matches!(unmet, Some(Unmet::WrongPressure { limit: PressureLimit::Below(_), .. })),
            "{name}: {unmet:?}"
        );
        assert_eq!(command(&mut executing(device, 5e-6), name), None, "{device} {name}");
    }
}

#[test]
fn a_degas_is_not_started_while_one_runs() {
    for device in ["bcg450", "bpg400"] {
        let mut segment = executing(device, 1e-6);
        assert_eq!(command(&mut segment, "degas on"), None, "{device}");
        assert_eq!(command(&mut segment, "degas on"), Some(Unmet::DegasRuns), "{device}");
        assert_eq!(command(&mut segment, "degas off"), None, "{device}");
    }
}
