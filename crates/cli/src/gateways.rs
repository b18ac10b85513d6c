//! The gateways to control systems that this program was built with: each is a cargo feature.

use crate::failure::Failure;
use profivac_gateway::model::{Modeller, Snapshot};
use profivac_gateway::thread::GatewayThread;
use profivac_gateway::{Inputs, ReadModel};
use profivac_recorder::Micros;
use profivac_station::config::Config;
use profivac_station::config::gateways::GatewaySettings;
use profivac_station::services::Services;
use std::sync::Arc;

/// The running gateways.
#[derive(Default)]
pub struct Gateways {
    model: Option<Arc<ReadModel>>,
    running: Vec<(GatewaySettings, Vec<GatewayThread>)>,
}

impl Gateways {
    /// Ends the gateways that are not in `wanted`, and starts those that do not run. Gateways with the same settings continue.
    pub fn apply(&mut self, wanted: &[GatewaySettings], services: &Arc<Services>) -> Result<(), Failure> {
        check(wanted)?;
        self.running.retain(|(settings, _)| wanted.contains(settings));
        for settings in wanted {
            if !self.running.iter().any(|(running, _)| running == settings) {
                let model = self.model(services)?;
                self.running.push((settings.clone(), start(settings, model, Arc::clone(services))?));
            }
        }
        if self.running.is_empty() {
            self.model = None;
        }
        Ok(())
    }

    /// The read model, started with the first gateway.
    fn model(&mut self, services: &Arc<Services>) -> Result<Arc<ReadModel>, Failure> {
        let model = match self.model.take() {
            Some(model) => model,
            None => Arc::new(ReadModel::start(Arc::clone(services))?),
        };
        self.model = Some(Arc::clone(&model));
        Ok(model)
    }
}

/// Checks that this program has all of these gateways.
pub fn check(wanted: &[GatewaySettings]) -> Result<(), Failure> {
    wanted.iter().try_for_each(|settings| if is_built_in(settings) { Ok(()) } else { Err(absent(settings)) })
}

/// The points of a station before it starts.
pub fn planned(config: &Config) -> Snapshot {
    Modeller::default().next(Inputs::planned(config), Micros::now())
}

/// The gateways of this program, by the names of their tables.
const BUILT_IN: &[&str] = &[
    #[cfg(feature = "archive")]
    "archive",
    #[cfg(feature = "epics")]
    "epics",
    #[cfg(feature = "modbus")]
    "modbus",
    #[cfg(feature = "mqtt")]
    "mqtt",
    #[cfg(feature = "opcua")]
    "opcua",
    #[cfg(feature = "prometheus")]
    "prometheus",
];

fn is_built_in(settings: &GatewaySettings) -> bool {
    BUILT_IN.contains(&settings.name())
}

/// The failure when the file has the table of a gateway that this program does not have.
pub fn absent(settings: &GatewaySettings) -> Failure {
    let name = settings.name();
    Failure::usage(format!(
        "the file has [{name}], and this program was built without that gateway: delete the table, or build with --features {name}"
    ))
}

/// Starts a gateway: a thread, or one for each protocol that its table has.
#[cfg_attr(
    not(any(
        feature = "archive",
        feature = "epics",
        feature = "modbus",
        feature = "mqtt",
        feature = "opcua",
        feature = "prometheus"
    )),
    expect(unused_variables, reason = "the program has no gateway")
)]
fn start(
    settings: &GatewaySettings,
    model: Arc<ReadModel>,
    services: Arc<Services>,
) -> Result<Vec<GatewayThread>, Failure> {
    match settings {
        #[cfg(feature = "archive")]
        GatewaySettings::Archive(it) => {
            Ok(vec![profivac_archive_link::publisher::start((**it).clone(), model, services)?])
        }
        #[cfg(feature = "epics")]
        GatewaySettings::Epics(it) => Ok(vec![profivac_gateway_epics::start(it.clone(), model, services)?]),
        #[cfg(feature = "mqtt")]
        GatewaySettings::Mqtt(it) => Ok(profivac_gateway_mqtt::start(it, &model, &services)?),
        #[cfg(feature = "modbus")]
        GatewaySettings::Modbus(it) => Ok(vec![profivac_gateway_modbus::start(it.clone(), model, services)?]),
        #[cfg(feature = "opcua")]
        GatewaySettings::Opcua(it) => Ok(vec![profivac_gateway_opcua::start(it.clone(), model, services)?]),
        #[cfg(feature = "prometheus")]
        GatewaySettings::Prometheus(it) => Ok(vec![profivac_gateway_prometheus::start(it.clone(), model, services)?]),
        other => Err(absent(other)),
    }
}
