//! `docs/devices` is generated from the tables: each device has a page, and a page that differs from the tables is an
//! error. `cargo xtask goldens` writes the pages.

#![allow(clippy::unwrap_used, reason = "a test")]

mod index;
mod page;
mod words;

use crate::golden;
use profivac_devices::catalog::MODELS;
use profivac_devices::model::Model;
use profivac_devices::pxg55x::table;
use profivac_devices::{bcg450, img400, tpg, xpg400};

/// One page, for one device or for several with the same tables.
struct Page {
    /// The file, without `.md`.
    file: &'static str,
    /// The folder of the tables in `crates/devices/src`.
    source: &'static str,
    /// The differences between the devices of the page.
    note: &'static str,
    models: &'static [&'static Model],
}

const WITH_ATM: &str = "With the atmosphere sensor (`pcg550@5`, `pcg550@5:atm=on`). Without it: [pcg55x](pcg55x.md).";
const WITHOUT_ATM: &str = "Without the atmosphere sensor (`pcg550@5:atm=off`). With it: [pcg55x-atm](pcg55x-atm.md).";

const TPG_NOTE: &str = "The bus does not tell a TPG300 from a TPG500: both have the ident number of the interface board, so \
profivac names a controller that it finds `tpg300 or tpg500`.

A cold cathode under automatic control goes off when the channel that controls it is switched off, fails or is missing, and comes \
back with the reading of this channel. As delivered the Pirani gauge on A1 controls all of them: switching it off with Sensor On_Off \
switches the cathodes of both boards off. A cathode that a command has switched on stays on.";

const fn page(file: &'static str, source: &'static str, models: &'static [&'static Model]) -> Page {
    Page { file, source, note: "", models }
}

const fn pxg(file: &'static str, note: &'static str, models: &'static [&'static Model]) -> Page {
    Page { file, source: "pxg55x", note, models }
}

/// All pages, in the order of the manuals.
static PAGES: [Page; 8] = [
    pxg(
        "pcg55x-atm",
        WITH_ATM,
        &[&table::PCG550_WITH_ATM.model, &table::PCG552_WITH_ATM.model, &table::PCG554_WITH_ATM.model],
    ),
    pxg("pcg55x", WITHOUT_ATM, &[&table::PCG550.model, &table::PCG552.model, &table::PCG554.model]),
    pxg("psg55x", "", &[&table::PSG550.model, &table::PSG552.model, &table::PSG554.model]),
    page("bpg400", "xpg400", &[&xpg400::table::BPG400.model]),
    page("hpg400", "xpg400", &[&xpg400::table::HPG400.model]),
    page("bcg450", "bcg450", &[&bcg450::table::MODEL]),
    Page { file: "tpg", source: "tpg", note: TPG_NOTE, models: &[&tpg::table::TPG300, &tpg::table::TPG500] },
    page("img400", "img400", &[&img400::table::MODEL]),
];

#[test]
fn every_page_agrees_with_the_tables() {
    for page in &PAGES {
        check(page.file, &page::print(page));
    }
    check("README", &index::print(&PAGES));
}

#[test]
fn every_device_has_a_page() {
    for model in MODELS {
        let has = |page: &&Page| page.models.iter().any(|listed| std::ptr::eq(*listed, model));
        assert_eq!(PAGES.iter().filter(has).count(), 1, "{}", model.name);
    }
}

#[test]
fn devices_that_share_a_page_have_the_same_tables() {
    for page in &PAGES {
        let (first, others) = page.models.split_first().unwrap();
        for other in others {
            assert_eq!(page::tables(first), page::tables(other), "{} and {}", first.name, other.name);
        }
    }
}

/// Compares a page with the file of this name.
fn check(name: &str, text: &str) {
    golden::compare(&format!("docs/devices/{name}.md"), text);
}
