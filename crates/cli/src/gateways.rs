//! The gateways to control systems that this program was built with: each is a cargo feature.

use crate::failure::Failure;
use profivac_gateway::ReadModel;
use profivac_gateway::thread::GatewayThread;
use profivac_station::config::gateways::GatewaySettings;
use profivac_station::services::Services;
use std::sync::Arc;

/// The running gateways.
#[derive(Default)]
pub struct Gateways {
    model: Option<Arc<ReadModel>>,
    running: Vec<(GatewaySettings, GatewayThread)>,
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

#[allow(clippy::match_like_matches_macro, reason = "which arms are true depends on the features")]
const fn is_built_in(settings: &GatewaySettings) -> bool {
    match settings {
        GatewaySettings::Opcua(_) => cfg!(feature = "opcua"),
        GatewaySettings::Prometheus(_) => cfg!(feature = "prometheus"),
        _ => false,
    }
}

/// The failure when the file has the table of a gateway that this program does not have.
pub fn absent(settings: &GatewaySettings) -> Failure {
    let name = settings.name();
    Failure::usage(format!(
        "the file has [{name}], and this program was built without that gateway: delete the table, or build with --features {name}"
    ))
}

fn start(settings: &GatewaySettings, model: Arc<ReadModel>, services: Arc<Services>) -> Result<GatewayThread, Failure> {
    match settings {
        #[cfg(feature = "opcua")]
        GatewaySettings::Opcua(it) => Ok(profivac_gateway_opcua::start(it.clone(), model, services)?),
        #[cfg(feature = "prometheus")]
        GatewaySettings::Prometheus(it) => Ok(profivac_gateway_prometheus::start(it.clone(), model, services)?),
        other => Err(absent(other)),
    }
}
