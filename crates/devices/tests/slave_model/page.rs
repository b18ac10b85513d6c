//! The tables of a gauge, from its page in `docs/devices`.

use crate::slave_model::tables::{Configuration, Table};
use std::ops::Range;

/// A parameter of one slot.
#[derive(Clone, Debug)]
pub struct Row {
    pub slot: u8,
    /// The instance that Channel Instance Selector must show.
    pub instance: Option<u8>,
    pub index: u8,
    pub name: String,
    pub data_type: String,
    /// `None` for a pressure, whose type the configuration selects.
    pub octets: Option<usize>,
    /// Class 1 reads and writes, class 2 reads and writes.
    pub access: [bool; 4],
    /// The parameter channel reads and writes, where the page says so.
    pub channel: [bool; 2],
}

/// A reason to refuse an access: codes of the parameter channel, and of DP-V1.
#[derive(Clone, Copy, Debug)]
pub struct Reason {
    pub channel: u8,
    pub dpv1: (u8, u8),
}

/// A page.
#[derive(Clone, Debug)]
pub struct Page {
    pub table: Table,
    pub rows: Vec<Row>,
    /// Configurations with the parameter channel.
    pub with_channel: Vec<bool>,
    /// The type of numbers that a configuration selects.
    pub float: Vec<Option<bool>>,
    /// The fields of the inputs of each configuration, besides the parameter channel.
    pub inputs: Vec<Vec<(Range<usize>, String)>>,
    /// In the order of the page.
    pub reasons: Vec<Reason>,
    /// AK 10 writes an octet; otherwise AK 2 does.
    pub octet_instruction: bool,
    /// A new instruction needs AK 0 before it.
    pub zero_between: bool,
}

/// The cells of the rows of all tables behind a heading, up to the next heading of this or a higher level.
fn cells(page: &str, heading: &str) -> Vec<Vec<String>> {
    let level = heading.split(' ').next().expect("a heading").to_owned() + " ";
    let lines = page.lines().skip_while(|line| *line != heading).skip(1);
    let lines = lines.take_while(|line| !line.starts_with(&level) && !line.starts_with("## "));
    lines.filter(|line| line.starts_with("| ")).map(row).collect()
}

fn row(line: &str) -> Vec<String> {
    line.trim_matches('|').split('|').map(|cell| cell.trim().trim_matches('`').to_owned()).collect()
}

fn octets(text: &str) -> Vec<u8> {
    text.split_whitespace().filter_map(|octet| u8::from_str_radix(octet, 16).ok()).collect()
}

/// `8-9 Process Value (integer)` and the like.
fn field(text: &str) -> Option<(Range<usize>, String)> {
    let (octets, name) = text.split_once(' ')?;
    let (from, to) = octets.split_once('-').unwrap_or((octets, octets));
    Some((from.parse().ok()?..to.parse::<usize>().ok()? + 1, name.to_owned()))
}

/// `1/2_R/W` and the like.
fn access(text: &str) -> ([bool; 4], [bool; 2]) {
    let (mut classes, mut channel) = ([false; 4], [false; 2]);
    for mark in text.split([' ', ',']) {
        match mark {
            "ac_r" => channel[0] = true,
            "ac_w" => channel[1] = true,
            _ => {
                let at = mark.find(['R', 'W']).unwrap_or(mark.len());
                let (who, what) = mark.split_at(at);
                for (class, digit) in ["1", "2"].into_iter().enumerate() {
                    if who.contains(digit) {
                        classes[2 * class] |= what.contains('R');
                        classes[2 * class + 1] |= what.contains('W');
                    }
                }
            }
        }
    }
    (classes, channel)
}

impl Page {
    /// Reads the page of a model.
    pub fn of(page: &str, name: &str, address_settable: bool) -> Self {
        let head = page.lines().filter(|line| line.starts_with('|')).map(row);
        let head = head.clone().find(|cells| cells[0] == name).expect("the model is on its page");
        let services = cells(page, "## Services");
        let yes = |service: &str| services.iter().any(|cells| cells[0].starts_with(service) && cells[1] == "yes");
        let (ms1, ms2) = (yes("DP-V1, class 1"), yes("DP-V1, class 2"));
        let from_master = cells(page, "## Telegrams from the master");
        let mut configurations = Vec::new();
        let mut with_channel = Vec::new();
        let (mut float, mut inputs) = (Vec::new(), Vec::new());
        let from_device = cells(page, "## Telegrams from the device");
        let mut default_configuration = 0;
        for cells in cells(page, "## Configurations").iter().skip(1) {
            let telegram = from_master.iter().find(|it| it[0] == cells[1]);
            with_channel.push(telegram.is_some_and(|it| it[2].starts_with("0-7 Parameter Channel")));
            let telegram = from_device.iter().find(|it| it[0] == cells[3]).map_or("", |it| it[2].as_str());
            float
                .push(telegram.contains("(float)").then_some(true).or(telegram.contains("(integer)").then_some(false)));
            inputs
                .push(telegram.split(", ").filter(|it| !it.ends_with("Parameter Channel")).filter_map(field).collect());
            if cells[6] == "yes" {
                default_configuration = configurations.len();
            }
            let number = |position: usize| cells[position].parse().expect("a number");
            configurations.push(Configuration { octets: octets(&cells[5]), outputs: number(2), inputs: number(4) });
        }
        let user_parameters: Vec<Vec<u8>> = cells(page, "## User parameters")
            .iter()
            .skip(1)
            .map(|cells| octets(&cells[1].replace("none", "")))
            .collect();
        let bits = page.lines().find(|line| line.starts_with("The device also accepts the bits"));
        let bits = |position: usize| bits.map_or(0, |line| octets(line.split('`').nth(position).expect("bits"))[0]);
        let instructions = cells(page, "## Parameter channel");
        let reasons = cells(page, "## Refusals").iter().skip(1).map(|cells| Self::reason(cells)).collect();
        Self {
            table: Table {
                name: name.to_owned(),
                ident: u16::from_str_radix(head[1].trim_end_matches('h'), 16).expect("an ident number"),
                sync: yes("Sync"),
                freeze: yes("Freeze"),
                dpv1: ms1 || ms2,
                ms1,
                ms2,
                address_settable,
                configurations,
                default_configuration,
                user_parameters,
                free_bits: [bits(1), bits(3)],
                // open(12): the gauges close Ident.
                ident_strings: None,
                im0: None,
            },
            rows: Self::rows(page),
            with_channel,
            float,
            inputs,
            reasons,
            octet_instruction: instructions.iter().any(|cells| cells[0] == "10"),
            zero_between: page.contains("A new instruction is started only after AK 0."),
        }
    }

    /// Whether a row chooses the instance of others.
    pub fn has_selector(&self) -> bool {
        self.rows.iter().any(|row| row.name == "Channel Instance Selector")
    }

    fn reason(cells: &[String]) -> Reason {
        let code = |position: usize| cells.get(position).map_or("0", |it| it.as_str());
        let hexadecimal = u8::from_str_radix(code(2).trim_end_matches('h'), 16).unwrap_or(0);
        Reason { channel: code(1).parse().unwrap_or(0), dpv1: (hexadecimal, code(3).parse().unwrap_or(0)) }
    }

    fn rows(page: &str) -> Vec<Row> {
        let mut rows = Vec::new();
        let mut locations: Vec<(u8, Option<u8>)> = Vec::new();
        let lines = page.lines().skip_while(|line| *line != "## Blocks").skip(1);
        for line in lines.take_while(|line| !line.starts_with("## ")) {
            if line.starts_with("### ") {
                locations.clear();
            }
            let cells = row(line);
            if let [slot, instance, _] = cells.as_slice()
                && let Ok(slot) = slot.parse()
            {
                locations.push((slot, instance.parse().ok()));
            }
            if let [index, name, data_type, octets, access_text, ..] = cells.as_slice()
                && let Ok(index) = index.parse()
            {
                let (access, channel) = access(access_text);
                rows.extend(locations.iter().map(|(slot, instance)| Row {
                    slot: *slot,
                    instance: *instance,
                    index,
                    name: name.clone(),
                    data_type: data_type.clone(),
                    octets: octets.parse().ok(),
                    access,
                    channel,
                }));
            }
        }
        rows
    }
}
