//! `profivac names`: the names that a gateway publishes.

use crate::failure::Failure;
use crate::gateways;
use crate::output::{json, out};
use clap::{Args, ValueEnum};
use profivac_gateway::{Inputs, NameTable, Point};
use profivac_station::config::Config;
use profivac_station::config::gateways::GatewaySettings;
use std::path::PathBuf;

/// List the names that a gateway of a station publishes: PVs, nodes, topics, registers or metrics.
///
/// The command reads the station's file and needs neither a bus nor a running station.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The file that describes the station
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// The gateway
    #[arg(long = "for", value_name = "GATEWAY")]
    gateway: Gateway,
    /// Print JSON
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Print CSV
    #[arg(long)]
    csv: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac names plant.toml --for prometheus
  profivac names plant.toml --for modbus --csv > map.csv";

/// A gateway to control systems; its name is that of its table in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Gateway {
    /// EPICS Channel Access and PV Access: PVs
    Epics,
    /// OPC UA: nodes
    Opcua,
    /// MQTT and Sparkplug B: topics
    Mqtt,
    /// Modbus TCP: registers
    Modbus,
    /// Prometheus: metrics
    Prometheus,
}

impl Gateway {
    const fn name(self) -> &'static str {
        match self {
            Self::Epics => "epics",
            Self::Opcua => "opcua",
            Self::Mqtt => "mqtt",
            Self::Modbus => "modbus",
            Self::Prometheus => "prometheus",
        }
    }
}

/// Prints the table.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let config = Config::read(&arguments.file)?;
    let name = arguments.gateway.name();
    let settings = config.gateways.iter().find(|settings| settings.name() == name).ok_or_else(|| {
        Failure::usage(format!(
            "{file} has no table [{name}], so the station publishes nothing there: add the table, see docs/gateways.md",
            file = arguments.file.display()
        ))
    })?;
    let points = profivac_gateway::points(&Inputs::planned(&config));
    let table = names(settings, &points)?;
    match (arguments.json, arguments.csv) {
        (true, _) => out(&json(&table)),
        (_, true) => out(table.csv().trim_end()),
        _ => out(&table.text()),
    }
    Ok(())
}

/// What the gateway with these settings publishes.
fn names(settings: &GatewaySettings, points: &[Point]) -> Result<NameTable, Failure> {
    match settings {
        #[cfg(feature = "opcua")]
        GatewaySettings::Opcua(_) => Ok(profivac_gateway_opcua::names(points)),
        #[cfg(feature = "prometheus")]
        GatewaySettings::Prometheus(_) => Ok(profivac_gateway_prometheus::names(points)),
        other => Err(gateways::absent(other)),
    }
}
