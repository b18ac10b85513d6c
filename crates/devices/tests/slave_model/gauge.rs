//! Gauges and controllers: access, codes and the parameter channel follow the page, values come from the device itself.

use crate::line::Driven;
use crate::model::DeviceDiagnosis;
use crate::page::{Page, Row};
use crate::process::{Process, Refusal, Via};
use crate::tables::Table;
use fastrand::Rng;
use profivac_devices::profile::{Behaviour, BlockDevice};
use profivac_devices::store::RamStore;
use profivac_dp::slave::{Device, Relation};
use std::collections::BTreeMap;

/// Rows of the table of refusals.
const SLOT: usize = 0;
const INDEX: usize = 1;
const NOT_READABLE: usize = 2;
const NOT_WRITABLE: usize = 3;
const TEXT: usize = 4;
const LENGTH: usize = 5;
const MODE: usize = 6;
const RANGE: usize = 9;
const INSTRUCTION: usize = 11;

/// The index of Channel Instance Selector.
const SELECTOR: &str = "Channel Instance Selector";

/// A real device of these tests.
pub type Gauge<B> = BlockDevice<B, RamStore>;

/// The application of a gauge in the model.
#[derive(Clone)]
pub struct Peek<D> {
    page: Page,
    /// The real device after the last telegram.
    device: D,
    /// And before it.
    before: D,
    selector: u8,
    locked: bool,
    /// User parameters select the compatibility mode of the PCG and PSG.
    compatible: bool,
    /// The parameter channel is in the cyclic data.
    channel: bool,
    /// The last instruction that was started, and its answer.
    instruction: Option<[u8; 8]>,
    answer: [u8; 8],
    reached: BTreeMap<&'static str, u64>,
}

impl<D: Device + Clone> Peek<D> {
    /// As delivered.
    pub fn new(page: Page, device: D) -> Self {
        let (selector, channel) = (1, page.with_channel[page.table.default_configuration]);
        let (locked, compatible) = (false, false);
        let before = device.clone();
        Self {
            page,
            device,
            before,
            selector,
            locked,
            compatible,
            channel,
            instruction: None,
            answer: [0; 8],
            reached: BTreeMap::new(),
        }
    }

    fn row(&self, slot: u8, index: u8) -> Result<&Row, usize> {
        let mut of_slot = self.page.rows.iter().filter(|row| row.slot == slot).peekable();
        if of_slot.peek().is_none() {
            return Err(SLOT);
        }
        let shown = |row: &&Row| row.index == index && row.instance.is_none_or(|it| it == self.selector);
        of_slot.find(shown).ok_or(INDEX)
    }

    fn refusal(&self, reason: usize) -> Refusal {
        let (code_1, code_2) = self.page.reasons[reason].dpv1;
        Refusal(code_1, code_2)
    }

    /// The octets of a parameter, from the device.
    fn value(&self, row: &Row) -> Vec<u8> {
        let mut record = [0; 240];
        let relation = if row.access[2] { Relation::Ms2(0) } else { Relation::Ms1 };
        let length = self.device.clone().read(relation, row.slot, row.index, &mut record).expect("the page allows it");
        assert!(
            row.octets.is_none_or(|it| it == length),
            "{} has {length} octets, the page says {:?}",
            row.name,
            row.octets
        );
        record[..length].to_vec()
    }

    /// The answer of the parameter channel to an instruction. profibus-wire 6.1, errata-bpg-bcg-tpg 18 to 25.
    fn execute(&mut self, instruction: [u8; 8]) -> [u8; 8] {
        let [pke, slot, index, _, value @ ..] = instruction;
        let result = self.instructed(pke >> 4, slot, index, value);
        let what = match (&result, pke >> 4) {
            (Ok(_), 1) => "channel: read",
            (Ok(_), _) => "channel: write",
            (Err(SLOT), _) => "channel: no such slot",
            (Err(INDEX), _) => "channel: no such index",
            (Err(NOT_READABLE), _) => "channel: not readable",
            (Err(NOT_WRITABLE), _) => "channel: not writable",
            (Err(TEXT), _) => "channel: text",
            (Err(LENGTH), _) => "channel: length",
            (Err(MODE), _) => "channel: mode",
            (Err(RANGE), _) => "channel: range",
            (Err(_), _) => "channel: no such instruction",
        };
        *self.reached.entry(what).or_default() += 1;
        let mut answer = [0, slot, index, 0, 0, 0, 0, 0];
        match result {
            Ok(octets) => {
                answer[0] = match octets.len() {
                    1 => 0xB0,
                    2 => 0x10,
                    _ => 0x20,
                };
                answer[8 - octets.len()..].copy_from_slice(&octets);
            }
            Err(reason) => {
                answer[0] = 0x70;
                answer[7] = self.page.reasons[reason].channel;
            }
        }
        answer
    }

    fn instructed(&mut self, ak: u8, slot: u8, index: u8, value: [u8; 4]) -> Result<Vec<u8>, usize> {
        let octets: &[usize] = match ak {
            1 => &[],
            2 if self.page.octet_instruction => &[2],
            2 => &[1, 2],
            3 => &[4],
            10 if self.page.octet_instruction => &[1],
            _ => return Err(INSTRUCTION),
        };
        let row = self.row(slot, index)?.clone();
        let [r1, w1, r2, w2] = row.access;
        if ak == 1 {
            if !(r1 || r2 || row.channel[0]) {
                return Err(NOT_READABLE);
            }
            if row.data_type.starts_with("VSTRING") {
                return Err(TEXT);
            }
            if row.octets.is_some_and(|it| it > 4) {
                return Err(LENGTH);
            }
            return Ok(self.value_of_channel(&row));
        }
        if !(w1 || w2 || row.channel[1]) {
            return Err(NOT_WRITABLE);
        }
        let length = row.octets.unwrap_or_else(|| self.value_of_channel(&row).len());
        if !octets.contains(&length) {
            return Err(LENGTH);
        }
        if matches!(row.name.as_str(), "Data Type" | "Data Units" | "Data Unit") {
            return Err(MODE);
        }
        assert_eq!(row.name, SELECTOR, "only the selector is written");
        self.select(value[3])?;
        Ok(vec![value[3]])
    }

    /// The present value; without MS1 and MS2 the input octets of the device have it.
    fn value_of_channel(&self, row: &Row) -> Vec<u8> {
        if self.page.table.ms2 {
            return self.value(row);
        }
        let length = row.octets.unwrap_or(4);
        let mut inputs = [0; 28];
        let (_, count) = self.lengths();
        self.device.clone().inputs(&mut inputs[..count]);
        inputs[8 - length..8].to_vec()
    }

    fn lengths(&self) -> (usize, usize) {
        let octets = self.device.get_cfg();
        let it = self.page.table.configurations.iter().find(|it| it.octets == octets).expect("one of the page");
        (it.outputs, it.inputs)
    }

    fn select(&mut self, instance: u8) -> Result<(), usize> {
        let last = self.page.rows.iter().filter_map(|row| row.instance).max().unwrap_or(1);
        if !(1..=last).contains(&instance) {
            return Err(RANGE);
        }
        self.selector = instance;
        Ok(())
    }

    /// A row; the selector more often than the others.
    fn some_row(&self, random: &mut Rng) -> Row {
        if let Some(selector) = self.page.rows.iter().find(|row| row.name == SELECTOR)
            && random.u8(..6) == 0
        {
            return selector.clone();
        }
        self.page.rows[random.usize(..self.page.rows.len())].clone()
    }
}

impl<D: Device + Clone> Process for Peek<D> {
    fn set_prm(&mut self, table: &Table, user: &[u8]) -> bool {
        let takes = table.takes_user_parameters(user);
        if takes {
            self.compatible = user.len() == 5 && user[3..] == [0, 0];
        }
        takes
    }

    fn chk_cfg(&mut self, table: &Table, octets: &[u8]) -> Option<usize> {
        let position = table.configurations.iter().position(|it| it.octets == octets)?;
        if self.compatible != (octets == [0xA1, 0x91]) {
            return None;
        }
        self.channel = self.page.with_channel[position];
        Some(position)
    }

    fn begin_exchange(&mut self) {
        self.outputs(None);
    }

    fn outputs(&mut self, outputs: Option<&[u8]>) {
        let instruction = outputs.filter(|_| self.channel).and_then(|it| it.first_chunk::<8>().copied());
        match instruction.filter(|it| it[0] >> 4 != 0) {
            None => (self.instruction, self.answer) = (None, [0; 8]),
            Some(new) => {
                let started = self.instruction;
                let again = started.is_some_and(|it| it == new);
                if started.is_none() || (!again && !self.page.zero_between) {
                    self.instruction = Some(new);
                    self.answer = self.execute(new);
                }
            }
        }
    }

    fn inputs(&mut self, length: usize) -> Vec<u8> {
        let mut inputs = vec![0; length];
        if self.device.get_cfg() == self.page.table.configurations[self.position(length)].octets {
            self.device.clone().inputs(&mut inputs);
        }
        if self.channel {
            // A read is repeated with the present value.
            if let Some(instruction) = self.instruction.filter(|it| it[0] >> 4 == 1) {
                self.answer = self.execute(instruction);
            }
            inputs[..8].copy_from_slice(&self.answer);
        }
        inputs
    }

    fn rewind(&mut self) {
        self.device = self.before.clone();
    }

    fn set_address(&mut self, _address: u8, lock: bool) -> bool {
        let free = !self.locked;
        self.locked |= lock;
        free
    }

    fn read(&mut self, _: &Table, via: Via, slot: u8, index: u8) -> Result<(Vec<u8>, u64), Refusal> {
        let row = self.row(slot, index).map_err(|it| self.refusal(it))?;
        if !row.access[if via == Via::Ms1 { 0 } else { 2 }] {
            return Err(self.refusal(NOT_READABLE));
        }
        Ok((self.value(row), 0))
    }

    fn write(&mut self, _: &Table, via: Via, slot: u8, index: u8, data: &[u8]) -> Result<u64, Refusal> {
        let row = self.row(slot, index).map_err(|it| self.refusal(it))?.clone();
        if !row.access[if via == Via::Ms1 { 1 } else { 3 }] {
            return Err(self.refusal(NOT_WRITABLE));
        }
        if row.octets.is_some_and(|it| it != data.len()) || (row.octets.is_none() && !matches!(data.len(), 2 | 4)) {
            return Err(self.refusal(LENGTH));
        }
        assert_eq!(row.name, SELECTOR, "only the selector is written");
        self.select(data[0]).map_err(|it| self.refusal(it))?;
        Ok(0)
    }

    fn no_im0(&self, _: &Table, slot: u8, _read: bool) -> Refusal {
        self.row(slot, 255).map_or_else(|it| self.refusal(it), |_| Refusal(0xB0, 0))
    }

    fn reached(&self) -> BTreeMap<&'static str, u64> {
        self.reached.clone()
    }

    fn suggested_access(&self, random: &mut Rng) -> Option<Vec<u8>> {
        if self.page.rows.is_empty() {
            return None;
        }
        let row = self.some_row(random);
        let slot = if random.u8(..12) == 0 { random.u8(..) } else { row.slot };
        let index = if random.u8(..8) == 0 { random.u8(..255) } else { row.index };
        if random.u8(..100) < 70 {
            return Some(vec![0x5E, slot, index, [240, 240, 4, 2][random.usize(..4)]]);
        }
        // No length that a row of this place has: the write must not change anything, but for the selector.
        let of_place: Vec<&Row> = self.page.rows.iter().filter(|it| (it.slot, it.index) == (slot, index)).collect();
        let of_row = |row: &Row, length: usize| row.octets.map_or(matches!(length, 2 | 4), |own| own == length);
        let taken = |length: usize| of_place.iter().any(|row| of_row(row, length));
        let length = if of_place.first().is_some_and(|it| it.name == SELECTOR) {
            1
        } else {
            (random.usize(1..9)..).find(|length| !taken(*length)).expect("rows are short")
        };
        let value = random.u8(0..8);
        Some([vec![0x5F, slot, index, u8::try_from(length).expect("short")], vec![value; length]].concat())
    }

    fn suggested_outputs(&self, random: &mut Rng, length: usize) -> Option<Vec<u8>> {
        let mut outputs = vec![0; length];
        if !self.channel || random.u8(..3) == 0 {
            return Some(outputs);
        }
        if let Some(same) = self.instruction
            && random.u8(..3) == 0
        {
            outputs[..8].copy_from_slice(&same);
            return Some(outputs);
        }
        let row = self.some_row(random);
        let slot = if random.u8(..12) == 0 { random.u8(..) } else { row.slot };
        let index = if random.u8(..8) == 0 { random.u8(..) } else { row.index };
        let ak = [1, 1, 1, 1, 2, 3, 10, 5, 15][random.usize(..9)];
        // A write that would be executed becomes a read, but for the selector.
        let selects = row.name == SELECTOR && (row.slot, row.index) == (slot, index);
        let of_place = || self.page.rows.iter().filter(|it| (it.slot, it.index) == (slot, index));
        let fits = |it: &Row| match (ak, it.octets) {
            (2, Some(octets)) => octets <= 2,
            (3, Some(octets)) => octets == 4,
            (10, Some(octets)) => octets == 1,
            (2 | 3, None) => true,
            _ => false,
        };
        let writes = of_place().any(|it| (it.access[1] || it.access[3] || it.channel[1]) && fits(it));
        let ak = if selects && random.bool() {
            10
        } else if writes && !selects {
            1
        } else {
            ak
        };
        let value = random.u8(0..8);
        outputs[..8].copy_from_slice(&[ak << 4 | random.u8(..8), slot, index, random.u8(..2), 0, 0, 0, value]);
        Some(outputs)
    }
}

impl<D: Device + Clone> Peek<D> {
    /// The place of the configuration of the device.
    fn position(&self, _length: usize) -> usize {
        let octets = self.device.get_cfg();
        self.page.table.configurations.iter().position(|it| it.octets == octets).expect("one of the page")
    }
}

impl<B: Behaviour + Clone> Driven for Gauge<B> {
    type Process = Peek<Self>;

    fn set_time(&mut self, _now: u64) {}

    fn set_diagnosis(&mut self, _diagnosis: DeviceDiagnosis) {}

    fn show(&self, process: &mut Peek<Self>) {
        process.before = std::mem::replace(&mut process.device, self.clone());
    }
}
