//! TPG300 and TPG500 after the IF300P/IF301P manual, each behaviour in its own file. Numbers in brackets are those of
//! errata-bpg-bcg-tpg.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

mod exchange;
mod master;
mod parameter_channel;
mod property;
mod rows;
mod settings;
mod thresholds;

use profivac_devices::profile::Setup;
use profivac_devices::store::RamStore;
use profivac_devices::tpg::{Tpg, TpgGauge, table};

type Controller = Tpg<RamStore>;

/// The gauge of a channel.
const PIRANI: Option<TpgGauge> = Some(TpgGauge::Pirani);
const COLD: Option<TpgGauge> = Some(TpgGauge::ColdCathode);

/// The default of the command line.
const BOARDS: [Option<TpgGauge>; 4] = [PIRANI, PIRANI, COLD, COLD];

/// A TPG500 as bought, with the address switch at 5.
fn controller(boards: [Option<TpgGauge>; 4]) -> Controller {
    Tpg::new(&table::TPG500, RamStore::default(), Setup::new(5), boards)
}
