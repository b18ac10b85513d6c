//! Brings every device up in every configuration, with every user parameter string of its table.

use crate::twelve_devices::rig::{Line, patient, until};
use profivac_devices::model::{Configuration, Field, Model, UserPrm};
use profivac_dp::master::{Mode, SlaveParameters};

/// All configurations of a device, and every user parameter string at least once.
fn settings(model: &'static Model) -> Vec<(&'static Configuration, &'static UserPrm)> {
    let strings =
        |of: &Configuration| model.user_prm.iter().filter(move |prm| suit(model, of, prm)).collect::<Vec<_>>();
    let rounds = model.configurations.len().max(model.user_prm.len());
    let configurations = model.configurations.iter().cycle().zip(0..rounds);
    configurations
        .map(|(configuration, round)| {
            let strings = strings(configuration);
            (configuration, strings[round % strings.len()])
        })
        .collect()
}

/// TTR compatibility mode has a configuration of its own, and its string has no unit: errata-pxg55x-img400 49.
fn suit(model: &Model, configuration: &Configuration, prm: &UserPrm) -> bool {
    let is_ttr = configuration.inputs.is_some_and(|telegram| telegram.fields.contains(&Field::TtrValue));
    let has_modes =
        model.configurations.iter().any(|it| it.inputs.is_some_and(|it| it.fields.contains(&Field::TtrValue)));
    !has_modes || is_ttr == model.unit(prm.unit_code()).is_none()
}

/// Brings all devices up together, round by round, each in its next configuration, until all are done.
pub fn every_configuration<L: Line>(line: &mut L, devices: &[(u8, &'static Model)]) {
    line.master().set_mode(Mode::Operate);
    let settings: Vec<_> = devices.iter().map(|(_, model)| settings(model)).collect();
    let rounds = settings.iter().map(Vec::len).max().unwrap();
    for round in 0..rounds {
        let present: Vec<_> = devices
            .iter()
            .zip(&settings)
            .filter_map(|((address, model), settings)| Some((*address, *model, settings.get(round)?)))
            .collect();
        for (address, model, (configuration, prm)) in &present {
            let parameters = patient(*address, model, configuration);
            line.master().add(&SlaveParameters { user_prm: prm.octets, ..parameters }).unwrap();
        }
        for (address, model, (configuration, prm)) in &present {
            let what = format!("{} with {:02X?} and {:02X?}", model.name, prm.octets, configuration.octets);
            let octets = until(line, &what, |master| master.inputs(*address).map(<[u8]>::len));
            assert_eq!(octets, configuration.input_octets(), "{what}");
            assert_eq!(line.master().exchange_error(*address), None, "{what}");
        }
        for (address, ..) in &present {
            line.master().remove(*address);
        }
        until(line, "giving back", |master| (master.addresses().count() == 0).then_some(()));
    }
}
