//! The segments and slaves to monitor, from the command line or from a station's file.

use super::Arguments;
use crate::bus::BusOptions;
use crate::failure::Failure;
use crate::values;
use profivac_explain::gsd::Files;
use profivac_gsd_slave::GsdSlave;
use std::collections::BTreeMap;
use std::path::Path;

/// A segment to monitor.
pub struct Plan {
    /// Its name, if there are several.
    pub name: Option<String>,
    /// Its bus.
    pub bus: BusOptions,
    /// The addresses of its slaves.
    pub addresses: Vec<u8>,
    /// The user parameters of slaves that are no known devices.
    pub user_prm: Vec<u8>,
    /// The outputs of slaves that are no known devices.
    pub outputs: BTreeMap<u8, Vec<u8>>,
    /// The slaves that the command owns by their GSD files.
    pub by_gsd: BTreeMap<u8, OwnedByGsd>,
    /// The addresses of --modules and --set.
    pub chosen: Vec<u8>,
    /// The GSD files, which describe slaves of other masters too.
    pub files: Files,
}

/// A slave that the command owns by its GSD file.
#[derive(Clone, Debug)]
pub struct OwnedByGsd {
    /// Its file, modules and parameters.
    pub slave: GsdSlave,
    /// The outputs that it gets.
    pub outputs: Vec<u8>,
}

impl Arguments {
    /// All segments, at least one, each with at least one slave.
    pub(super) fn plans(&self) -> Result<Vec<Plan>, Failure> {
        let plans = match (&self.port, self.targets.as_slice()) {
            (None, [file]) if file.ends_with(".toml") => self.of_file(Path::new(file))?,
            (Some(_), all) if all.iter().any(|text| text.ends_with(".toml")) => {
                return Err(Failure::usage(
                    "expected --port PORT with addresses, or a station's FILE.toml alone; the file names its ports",
                ));
            }
            (Some(port), all) => {
                let addresses = all.iter().map(|text| values::slave_address(text));
                let addresses = addresses.collect::<Result<_, _>>()?;
                vec![Plan {
                    user_prm: self.user_prm(),
                    ..Plan::new(None, BusOptions::new(port, &self.line), addresses)
                }]
            }
            (None, _) => {
                return Err(Failure::usage("expected --port PORT with addresses, or a station's FILE.toml alone"));
            }
        };
        plans.iter().try_for_each(Plan::check)?;
        Ok(plans)
    }

    fn user_prm(&self) -> Vec<u8> {
        self.prm.as_ref().map_or_else(Vec::new, |octets| octets.0.clone())
    }

    /// The segments of a station's file that have gauges.
    fn of_file(&self, file: &Path) -> Result<Vec<Plan>, Failure> {
        let config = profivac_config::read(file)?;
        let several = config.segments.len() > 1;
        let plan = |segment: &profivac_station::config::Segment| {
            let name = several.then(|| segment.name.clone());
            let addresses = segment.gauges.iter().map(|gauge| gauge.address).collect();
            Plan {
                user_prm: self.user_prm(),
                ..Plan::new(name, BusOptions::of_segment(segment, &self.line), addresses)
            }
        };
        let plans: Vec<_> = config.segments.iter().filter(|segment| !segment.gauges.is_empty()).map(plan).collect();
        match (plans.as_slice(), config.segments.as_slice()) {
            ([], [segment]) => {
                Err(Failure::usage(format!("{}: the segment {:?} has no gauges", file.display(), segment.name)))
            }
            ([], _) => Err(Failure::usage(format!("{}: no segment has gauges", file.display()))),
            _ => Ok(plans),
        }
    }
}

impl Plan {
    /// A segment without options for its slaves.
    pub fn new(name: Option<String>, bus: BusOptions, addresses: Vec<u8>) -> Self {
        Self {
            name,
            bus,
            addresses,
            user_prm: Vec::new(),
            outputs: BTreeMap::new(),
            by_gsd: BTreeMap::new(),
            chosen: Vec::new(),
            files: Files::default(),
        }
    }

    /// Fails if an address occurs twice or is that of the master.
    fn check(&self) -> Result<(), Failure> {
        for (number, address) in self.addresses.iter().enumerate() {
            self.bus.check_not_own_address(*address, "address")?;
            if self.addresses.iter().take(number).any(|other| other == address) {
                return Err(Failure::usage(format!("address {address} is given twice")));
            }
        }
        Ok(())
    }
}
