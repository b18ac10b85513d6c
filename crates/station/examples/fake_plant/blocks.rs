//! The parameters of a device, read from a virtual one.

use profivac_client::Gauge;
use profivac_client::class1::OwnedChannel;
use profivac_client::cyclic::{CyclicSlave, ReportedChannels};
use profivac_client::ms2::Ms2;
use profivac_client::names::NamedParameter;
use profivac_client::pressure::Pressure;
use profivac_client::records::Records;
use profivac_devices::model::{Direction, Model};
use profivac_dp::link::Baud;
use profivac_dp::link::active::BusParameters;
use profivac_station::view::{Block, Parameter};
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::{DeviceSpec, entry};
use profivac_virtual::memory_segment::MemorySegment;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use std::error::Error;

const ADDRESS: u8 = 5;
const BAUD: Baud = Baud::B1500000;

/// The blocks of a device at 3.2e-7 mbar, over MS2 or in the parameter channel.
pub fn read(device: &str) -> Result<Vec<Block>, Box<dyn Error>> {
    let model = entry(device)?.model;
    let mut segment = segment(device, model)?;
    segment.run_until(2.0);
    let slave = segment.slaves().first().copied().ok_or("no slave")?;
    let records: Box<dyn Records + '_> = match model.features.dpv1 {
        true => Box::new(Ms2::new(&mut segment, ADDRESS)),
        false => Box::new(OwnedChannel::new(&mut segment, &slave)),
    };
    let mut gauge = Gauge::with_model(records, ADDRESS, model);
    let via = gauge.records().via();
    let mut blocks: Vec<Block> = Vec::new();
    for named in gauge.names().all() {
        if named.parameter.row.access.allows(via, Direction::Read) {
            let parameter = parameter(&mut gauge, named);
            let name = format!("{} (slot {})", named.parameter.block.name, named.parameter.location.slot);
            match blocks.last_mut().filter(|block| block.name == name) {
                Some(block) => block.parameters.push(parameter),
                None => blocks.push(Block { name, parameters: vec![parameter] }),
            }
        }
    }
    Ok(blocks)
}

fn segment(device: &str, model: &'static Model) -> Result<MemorySegment, Box<dyn Error>> {
    let spec: DeviceSpec = format!("{device}@{ADDRESS}").parse()?;
    let [pressure, atmosphere] = [3.2e-7, 1013.25].map(Pressure::from_mbar);
    let around = GasConditions { pressure, atmosphere, gas: Gas::N2 };
    let built = spec.build(NonvolatileMemory::volatile(), BAUD)?;
    let slave = CyclicSlave {
        address: ADDRESS,
        model,
        configuration: model.default_configuration,
        unit: model.unit_named("mbar").ok_or("no such unit")?,
        channels: ReportedChannels::default(),
    };
    let bus = BusParameters::new(1, BAUD).check()?;
    Ok(MemorySegment::new(vec![VirtualDevice::new(built, ADDRESS, BAUD, around)], vec![slave], bus, BAUD)?)
}

fn parameter(gauge: &mut Gauge<Box<dyn Records + '_>>, named: &NamedParameter) -> Parameter {
    let (value, read_error) = match gauge.read_parameter(named) {
        Ok(reading) => (Some(reading.text), None),
        Err(error) => (None, Some(error.to_string())),
    };
    Parameter {
        target: named.name.clone(),
        name: named.parameter.row.name.to_owned(),
        numbers: named.parameter.numbers(),
        access: named.parameter.row.access_text.to_owned(),
        value,
        read_error,
        write: None,
    }
}
