//! `profivac names`: the names that a gateway publishes.

use crate::failure::Failure;
use crate::gateways;
use crate::output::{json, out};
use clap::{Args, ValueEnum};
use profivac_gateway::NameTable;
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
    /// Write the PVs that are worth archiving into a file for the Archiver Appliance, one per line (EPICS)
    #[arg(long, value_name = "OUT")]
    archiver: Option<PathBuf>,
    /// Write a screen for Phoebus with all readings (EPICS)
    #[arg(long, value_name = "OUT.bob")]
    bob: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  profivac names plant.toml --for prometheus
  profivac names plant.toml --for modbus --csv > map.csv
  profivac names plant.toml --for epics --archiver pvs.txt --bob vacuum.bob";

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
    let config = profivac_config::read(&arguments.file)?;
    let name = arguments.gateway.name();
    let settings = config.gateways.iter().find(|settings| settings.name() == name).ok_or_else(|| {
        Failure::usage(format!(
            "{file} has no table [{name}], so the station publishes nothing there: add the table, see docs/gateways.md",
            file = arguments.file.display()
        ))
    })?;
    write_lists(arguments, &config, settings)?;
    let table = names(settings, &config)?;
    match (arguments.json, arguments.csv) {
        (true, _) => out(&json(&table)),
        (_, true) => out(table.csv().trim_end()),
        _ => out(&table.text()),
    }
    Ok(())
}

/// Checks that every gateway of the file has a name for each point. An archive gets the names of the database.
pub fn check(config: &Config) -> Result<(), Failure> {
    let mut gateways = config.gateways.iter().filter(|settings| !matches!(settings, GatewaySettings::Archive(_)));
    gateways.try_for_each(|settings| names(settings, config).map(drop))
}

/// What the gateway with these settings publishes.
#[cfg_attr(
    not(any(feature = "epics", feature = "modbus", feature = "mqtt", feature = "opcua", feature = "prometheus")),
    expect(unused_variables, reason = "the program has no gateway")
)]
fn names(settings: &GatewaySettings, config: &Config) -> Result<NameTable, Failure> {
    let snapshot = gateways::planned(config);
    match settings {
        #[cfg(feature = "epics")]
        GatewaySettings::Epics(it) => {
            let names = profivac_gateway_epics::listing::names(&config.name, &snapshot, it);
            names.map_err(|error| Failure::usage(error.to_string()))
        }
        #[cfg(feature = "modbus")]
        GatewaySettings::Modbus(it) => {
            profivac_gateway_modbus::names(&snapshot.points, it).map_err(|error| Failure::usage(error.to_string()))
        }
        #[cfg(feature = "mqtt")]
        GatewaySettings::Mqtt(it) => Ok(profivac_gateway_mqtt::names::names(it, &config.name, &snapshot.points)),
        #[cfg(feature = "opcua")]
        GatewaySettings::Opcua(_) => Ok(profivac_gateway_opcua::names(&snapshot.points)),
        #[cfg(feature = "prometheus")]
        GatewaySettings::Prometheus(_) => Ok(profivac_gateway_prometheus::names(&snapshot.points)),
        other => Err(gateways::absent(other)),
    }
}

/// Writes the files for the Archiver Appliance and for Phoebus.
#[cfg_attr(not(feature = "epics"), expect(unused_variables, reason = "only EPICS has lists"))]
fn write_lists(arguments: &Arguments, config: &Config, settings: &GatewaySettings) -> Result<(), Failure> {
    let Arguments { archiver, bob, .. } = arguments;
    match settings {
        _ if archiver.is_none() && bob.is_none() => Ok(()),
        #[cfg(feature = "epics")]
        GatewaySettings::Epics(it) => {
            use crate::whole_file::write_text;
            use profivac_gateway_epics::listing;
            let snapshot = gateways::planned(config);
            let usage = |error: profivac_gateway_epics::NameError| Failure::usage(error.to_string());
            if let Some(path) = archiver {
                write_text(path, &listing::archiver(&config.name, &snapshot, it).map_err(usage)?)?;
            }
            if let Some(path) = bob {
                write_text(path, &listing::bob(&config.name, &snapshot, it).map_err(usage)?)?;
            }
            Ok(())
        }
        _ => Err(Failure::usage(
            "--archiver and --bob belong to --for epics: delete them, or list the names of EPICS".to_owned(),
        )),
    }
}
