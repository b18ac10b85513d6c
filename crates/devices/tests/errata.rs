//! Errata about the tables of several devices: store classes, ranges of types, types and locations of blocks.

#![allow(clippy::unwrap_used, reason = "a test")]

use profivac_devices::catalog::{MODELS, model_named};
use profivac_devices::model::{Access, Counts, DataType, Model, NumberType, PressureFormat, Row, Storage, Value};

/// The slots and instances of a model, with the name and the type of the block and its rows.
fn placed(model: &Model) -> impl Iterator<Item = (u8, &'static str, Option<u16>, &'static [Row])> {
    model.blocks.iter().flat_map(|placed| {
        placed
            .locations
            .iter()
            .map(|location| (location.slot, placed.block.name, placed.block.block_type, placed.block.rows))
    })
}

/// D is dynamic: such a value follows from others, so no master writes it and the device does not store it. errata-bpg-bcg-tpg 119.
#[test]
fn a_parameter_of_store_class_d_is_not_written_by_a_master() {
    for name in ["bpg400", "hpg400", "bcg450"] {
        let rows = || placed(model_named(name).unwrap()).flat_map(|(_, _, _, rows)| rows);
        let dynamic: Vec<_> = rows().filter(|row| row.storage == Storage::Dynamic).collect();
        assert!(!dynamic.is_empty() && dynamic.iter().all(|row| !row.access.intersects(Access::WRITE)), "{name}");
    }
}

/// The manuals print 0 to 2^31-1. errata-bpg-bcg-tpg 120, errata-pxg55x-img400 108.
#[test]
fn the_range_of_uint32_ends_at_2_to_the_32_less_1() {
    let unit = model_named("bcg450").unwrap().units.first().unwrap();
    let counts = Counts::Linear { per_mbar: 1.0 };
    let format = PressureFormat { unit, number: NumberType::Float, counts, max_integer: 32767 };
    let largest = Value::Integer(u32::MAX.into());
    assert_eq!(DataType::Uint32.encode(&largest, &format).as_slice(), [0xFF; 4]);
    assert_eq!(DataType::Uint32.decode(&[0xFF; 4], &format), Ok(largest));
    for model in MODELS {
        let uses = placed(model).any(|(_, _, _, rows)| rows.iter().any(|row| row.data_type == DataType::Uint32));
        let has_run_hours = model.name.starts_with("pcg") || model.name.starts_with("psg");
        assert_eq!(uses, has_run_hours, "{}", model.name);
    }
}

/// Type 18 is the OneOfN transducer of tira56e1 App. B, which no device has. errata-pxg55x-img400 157.
#[test]
fn no_block_has_type_18() {
    for model in MODELS {
        assert!(placed(model).all(|(_, _, block_type, _)| block_type != Some(18)), "{}", model.name);
    }
}

/// errata-pxg55x-img400 162
#[test]
fn the_slots_of_the_img400_are_those_of_its_headings() {
    let img400 = model_named("img400").unwrap();
    let blocks = |slot: u8| {
        let mut names: Vec<_> = placed(img400).filter(|placed| placed.0 == slot).map(|(_, name, ..)| name).collect();
        names.sort_unstable();
        names
    };
    assert_eq!(blocks(0), ["Device Block"]);
    let input = "Sensor Analog Input Function Block";
    for slot in [1, 2] {
        assert_eq!(blocks(slot), ["Hot Cathode Ion Gauge Transducer Block", input]);
    }
    for slot in [3, 4] {
        let transducers = ["Diaphragm Gauge Transducer Block", "Heat Transfer Vacuum Gauge Transducer Block"];
        assert_eq!(blocks(slot), [transducers[0], transducers[1], input]);
    }
    for slot in 5..=11 {
        assert_eq!(blocks(slot), ["Trip Function Block"]);
    }
    assert_eq!(blocks(12), [""; 0]);
}
