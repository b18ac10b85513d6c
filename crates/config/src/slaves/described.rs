//! A slave by a device file: the GSD file that its tables give, and the values of its inputs as points.

use profivac_client::gsd::gsd;
use profivac_devices::model::{Codes, CyclicValue, DataType, Model, Quantity};
use profivac_gsd::GsdFile;
use profivac_gsd_slave::{Direction, GsdSlave, ModuleChoice, Modules};
use profivac_station::config::{PointType, SlavePoint};
use std::sync::Arc;

/// The GSD file that the tables give.
pub fn file(model: &Model) -> Arc<GsdFile> {
    Arc::new(GsdFile::read(gsd(model).as_bytes()))
}

/// The module of the default configuration. In that file each configuration is a module, in the order of the tables.
pub fn usual_module(model: &Model) -> Modules {
    let usual = model.configurations.iter().position(|one| one.octets == model.default_configuration.octets);
    let number = usual.and_then(|position| u32::try_from(position).ok()).unwrap_or_default().saturating_add(1);
    Modules::InOrder(vec![ModuleChoice::Number(number)])
}

/// The values of the inputs, and the points of the station's file. One of the file replaces a value with its name.
pub fn with_values(model: &Model, slave: &GsdSlave, given: Vec<SlavePoint>) -> Vec<SlavePoint> {
    let configuration = model.configuration(slave.chk_cfg());
    let values = configuration.into_iter().flat_map(|one| model.values_of(one, false));
    let others = values.filter(|value| given.iter().all(|point| point.name != value.name));
    let mut points: Vec<_> = others.filter_map(|value| point(value, slave)).collect();
    points.extend(given);
    points
}

fn point(value: &CyclicValue, slave: &GsdSlave) -> Option<SlavePoint> {
    let kind = match value.data_type {
        DataType::Boolean => PointType::Bool,
        DataType::Int8 => PointType::I8,
        DataType::Uint8 => PointType::U8,
        DataType::Int16 => PointType::I16,
        DataType::Uint16 => PointType::U16,
        DataType::Int32 => PointType::I32,
        DataType::Uint32 => PointType::U32,
        DataType::Float => PointType::F32,
        // No value of a device file.
        DataType::Visible(_)
        | DataType::OctetString(_)
        | DataType::Array(_)
        | DataType::Record(_)
        | DataType::ByType => return None,
    };
    let octet = usize::from(value.octet);
    let place = slave.layout().name_of(Direction::Input, octet)?;
    let (scale, unit) = match value.codes {
        Codes::Quantity(Quantity { unit, factor, .. }) => (factor, Some(unit)),
        _ => (1.0, None),
    };
    let texts = value.codes.codes().iter().map(|code| (i64::from(code.number), code.name.to_owned()));
    Some(SlavePoint {
        name: value.name.to_owned(),
        place: if kind == PointType::Bool { format!("{place} bit {}", value.bit) } else { place },
        record: None,
        kind,
        octet,
        bit: value.bit,
        is_little_endian: false,
        scale,
        offset: 0.0,
        unit,
        texts: texts.collect(),
        status: None,
        deadband: 0.0,
    })
}
