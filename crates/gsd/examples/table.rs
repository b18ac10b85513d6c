//! Reads every GSD file of a folder and counts their properties: `cargo run --release --example table -- FOLDER`.

use profivac_gsd::{Configuration, Fault, Fit, GsdFile, Severity, text};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let folder = std::env::args().nth(1).ok_or("expected a folder with GSD files")?;
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let extension =
            path.extension().and_then(|extension| extension.to_str()).unwrap_or_default().to_ascii_lowercase();
        if extension.starts_with("gs") {
            files.push((path.display().to_string(), std::fs::read(path)?));
        }
    }
    files.sort();
    let started = Instant::now();
    let read: Vec<_> = files.iter().map(|(name, octets)| (name, octets, GsdFile::read(octets))).collect();
    let took = started.elapsed();
    let mut table = Table::default();
    for (name, octets, file) in &read {
        table.count(name, octets, file);
    }
    table.print(took);
    Ok(())
}

#[derive(Default)]
struct Table {
    rows: BTreeMap<String, usize>,
    verbose: bool,
}

impl Table {
    fn add(&mut self, row: impl Into<String>, counts: bool) {
        *self.rows.entry(row.into()).or_default() += usize::from(counts);
    }

    fn count(&mut self, name: &str, octets: &[u8], file: &GsdFile) {
        self.verbose = std::env::args().nth(2).is_some();
        let device = file.device();
        self.add("files", true);
        self.add("octets kept", file.octets() == octets);
        self.add(format!("encoding {}", file.encoding()), true);
        self.add("revision 3 or later", device.general.gsd_revision >= Some(3));
        self.add("DP-V1", device.general.dpv1_slave == Some(true));
        self.add("modular", device.is_modular());
        self.add("with slot definitions", !device.slots.is_empty());
        self.add("with fixed modules", device.general.fix_preset_modules == Some(true));
        self.add("with preset modules", device.modules.iter().any(|module| module.preset));
        self.add("with numbers of modules", device.modules.iter().any(|module| module.numbered));
        self.add("with parameters", !device.parameters.is_empty());
        self.add("with texts of parameters", !device.texts.is_empty());
        self.add("with parameters of modules", device.modules.iter().any(|module| !module.prm.items.is_empty()));
        self.add("with parameters for PROFIsafe", device.modules.iter().any(|module| !module.safety.items.is_empty()));
        self.add("with Unit_Diag", device.diagnosis.unit != profivac_gsd::UnitDiag::default());
        self.add("with UnitDiagType", !device.diagnosis.types.is_empty());
        self.add("with Channel_Diag", !device.diagnosis.channels.is_empty());
        self.add("without a fault", file.faults().next().is_none());
        let canonical = text(device);
        let again = GsdFile::read(canonical.as_bytes());
        self.add("canonical text is the same when read again", text(again.device()) == canonical);
        self.presets(name, file);
        self.read_back(name, file);
        for fault in Fault::ALL {
            if let Some(problem) = file.problems().iter().find(|problem| problem.fault == *fault) {
                let kind = if problem.severity() == Severity::Fault { "fault" } else { "remark" };
                self.add(format!("{kind}: {}", problem.what()), true);
                if self.verbose {
                    println!("{name}: {problem}");
                }
            }
        }
    }

    fn presets(&mut self, name: &str, file: &GsdFile) {
        match Configuration::preset(file.device()) {
            Ok(configuration) => {
                self.add("presets a configuration", true);
                match configuration.user_prm() {
                    Ok(octets) => self.add("presets user parameters", !octets.is_empty()),
                    Err(error) => println!("{name}: {error}"),
                }
            }
            Err(error) if self.verbose => println!("{name}: {error}"),
            Err(_) => {}
        }
    }

    /// Each module alone, and the preset modules: octets and back to modules and parameters.
    fn read_back(&mut self, name: &str, file: &GsdFile) {
        let device = file.device();
        let alone = device.modules.iter().filter_map(|module| Configuration::of(device, vec![module]).ok());
        for configuration in alone.chain(Configuration::preset(device).ok()) {
            self.add("configurations", true);
            let fit = match Fit::new(device, &configuration.chk_cfg()) {
                Ok(fit) => fit,
                Err(error) => {
                    println!("{name}: {error}");
                    continue;
                }
            };
            self.add("configurations found again", true);
            self.add("with another division", fit.has_other_division);
            self.add("with several modules for a slot", fit.slots.iter().any(|slot| slot.modules.len() > 1));
            let Ok(user) = configuration.user_prm() else { continue };
            let reading = fit.read_prm(&user);
            self.add(
                "default parameters read back without a difference",
                reading.differences.is_empty() && reading.has_right_length(),
            );
            let is_wrong = |one: &profivac_gsd::ReadValue<'_>| one.value != one.usual && one.covered_by.is_none();
            self.add("default parameters with other values than the defaults", reading.values.iter().any(is_wrong));
            if self.verbose && (!reading.differences.is_empty() || reading.values.iter().any(is_wrong)) {
                let wrong: Vec<_> =
                    reading.values.iter().filter(|one| is_wrong(one)).map(ToString::to_string).collect();
                println!("{name}: {} {:?} {wrong:?}", configuration.modules().len(), reading.differences);
            }
            self.add(
                "parameters that a later definition covers",
                reading.values.iter().any(|one| one.covered_by.is_some()),
            );
        }
    }

    fn print(&self, took: Duration) {
        for (row, count) in &self.rows {
            println!("{count:>6}  {row}");
        }
        println!("read in {} ms", took.as_millis());
    }
}
