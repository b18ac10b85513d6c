//! Brings a slave of every GSD file of a folder to data exchange with our master, on a simulated line:
//! `cargo run --example exchange -- FOLDER`.
//!
//! The slave accepts the octets of its file only, and a DP-V1 slave checks the reserved bits of its status octets.

use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{HandlerState, Master, Mode, Settings};
use profivac_dp::slave::{CfgFault, Device, Features, Outputs, PrmFault, Slave};
use profivac_gsd::GsdFile;
use profivac_gsd_slave::{Catalog, GsdSlave, ModuleChoice, Modules, Selection};
use profivac_sim::Segment;
use profivac_wire::cfg;
use std::path::PathBuf;
use std::sync::Arc;

type Failure = Box<dyn std::error::Error>;

const ADDRESS: u8 = 9;
const BAUD: Baud = Baud::B1500000;

fn main() -> Result<(), Failure> {
    let folder = std::env::args().nth(1).ok_or("expected a folder with GSD files")?;
    let catalog = Catalog::read(&[PathBuf::from(folder)])?;
    for unread in catalog.unread() {
        println!("left out  {}: {}", unread.path.display(), unread.reason);
    }
    let (mut all, mut exchanging) = (0_u32, 0_u32);
    for (_, entry) in catalog.entries() {
        all = all.saturating_add(1);
        match slave(&entry.file).and_then(exchange) {
            Ok(()) => exchanging = exchanging.saturating_add(1),
            Err(reason) => println!("{}: {reason}", entry.path.display()),
        }
    }
    println!("{all} devices, {exchanging} exchange data");
    Ok(())
}

/// The modules that the file presets, else the first one that can be plugged alone, else the first two.
fn slave(file: &Arc<GsdFile>) -> Result<GsdSlave, String> {
    let with = |modules| GsdSlave::new(Arc::clone(file), &Selection { modules, changes: Vec::new() });
    let preset = with(Modules::Preset).map_err(|error| error.to_string());
    let numbers = file.device().modules.iter().map(|module| module.number);
    let one = numbers.clone().map(|number| vec![number]);
    let two = numbers.clone().zip(numbers.skip(1)).map(|(first, second)| vec![first, second]);
    let chosen = one
        .chain(two)
        .find_map(|numbers| with(Modules::InOrder(numbers.into_iter().map(ModuleChoice::Number).collect())).ok());
    preset.or_else(|error| chosen.ok_or(error))
}

/// A slave that accepts the octets of its file.
struct Described(GsdSlave);

impl Device for Described {
    fn ident_number(&self) -> u16 {
        self.0.ident()
    }

    fn features(&self) -> Features {
        let general = &self.0.device().general;
        Features {
            sync: general.sync_mode_supp == Some(true),
            freeze: general.freeze_mode_supp == Some(true),
            dpv1: self.0.is_dpv1(),
            ms1: general.c1_read_write_supp == Some(true),
        }
    }

    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault> {
        if user == self.0.user_prm() { Ok(()) } else { Err(PrmFault) }
    }

    fn chk_cfg(&mut self, octets: &[u8]) -> Result<cfg::Lengths, CfgFault> {
        if octets == self.0.chk_cfg() { Ok(self.0.lengths()) } else { Err(CfgFault) }
    }

    fn get_cfg(&self) -> &[u8] {
        self.0.chk_cfg()
    }

    fn outputs(&mut self, _outputs: Outputs<'_>) {}

    fn inputs(&mut self, inputs: &mut [u8]) {
        inputs.fill(0x5A);
    }
}

fn exchange(slave: GsdSlave) -> Result<(), String> {
    let mut segment = Segment::new(BAUD);
    let bus = BusParameters::new(2, BAUD).check().map_err(|error| format!("{error:?}"))?;
    let mut master = Master::<2, 244>::on(bus, Settings::new(BAUD), BitTime(0));
    master.user.add(&slave.parameters(ADDRESS, BAUD)).map_err(|error| error.to_string())?;
    master.user.set_mode(Mode::Operate);
    let inputs = usize::from(slave.lengths().inputs);
    segment.attach(Slave::<Described>::new(Described(slave), ADDRESS, BAUD));
    let master = segment.attach(master);
    segment.run_for(BAUD.tbit_of_ms(500)).map_err(|violation| violation.to_string())?;
    let user = &segment.station(master).user;
    let is_exchanging = user.state(ADDRESS).is_some_and(HandlerState::is_exchanging);
    match (is_exchanging, user.inputs(ADDRESS)) {
        (true, Some(image)) if image == vec![0x5A; inputs] => Ok(()),
        _ => Err(format!("no data exchange: {:?}, {:?}", user.state(ADDRESS), user.exchange_error(ADDRESS))),
    }
}
