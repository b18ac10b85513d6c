//! Gauges and controllers: access, codes and the parameter channel follow the page, values follow [`crate::slave_model::contents`].

use crate::slave_model::contents::{Content, Contents, Key, Reason, Verdict};
use crate::slave_model::line::Driven;
use crate::slave_model::model::DeviceDiagnosis;
use crate::slave_model::open_points::OF_THE_DEVICE;
use crate::slave_model::page::{Page, Row};
use crate::slave_model::process::{Process, Refusal, Via};
use crate::slave_model::tables::Table;
use fastrand::Rng;
use profivac_devices::SimulatedDevice;
use profivac_devices::profile::{Behaviour, BlockDevice};
use profivac_devices::store::RamStore;
use profivac_dp::slave::{Device, Relation};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Rows of the table of refusals.
const SLOT: usize = 0;
const INDEX: usize = 1;
const NOT_READABLE: usize = 2;
const NOT_WRITABLE: usize = 3;
const TEXT: usize = 4;
const LENGTH: usize = 5;
const MODE: usize = 6;
const ALREADY: usize = 7;
const NOT_NOW: usize = 8;
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
    contents: Contents,
    /// The place of the configuration in the page.
    configuration: usize,
    /// The real device after the last telegram.
    device: D,
    /// And before it.
    before: D,
    /// Both are exchanged until the next telegram.
    rewound: bool,
    selector: u8,
    locked: bool,
    /// User parameters select the compatibility mode of the PCG and PSG.
    compatible: bool,
    /// The parameter channel is in the cyclic data.
    channel: bool,
    /// The last instruction that was started, and its answer.
    instruction: Option<[u8; 8]>,
    answer: [u8; 8],
    reached: RefCell<BTreeMap<&'static str, u64>>,
}

impl<D: Device + Clone> Peek<D> {
    /// As delivered.
    pub fn new(page: Page, contents: Contents, device: D) -> Self {
        let (selector, channel) = (1, page.with_channel[page.table.default_configuration]);
        let (locked, compatible) = (false, false);
        let before = device.clone();
        let configuration = page.table.default_configuration;
        Self {
            page,
            contents,
            configuration,
            device,
            before,
            rewound: false,
            selector,
            locked,
            compatible,
            channel,
            instruction: None,
            answer: [0; 8],
            reached: RefCell::default(),
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

    fn reach(&self, what: &'static str) {
        *self.reached.borrow_mut().entry(what).or_default() += 1;
    }

    /// The octets of a parameter.
    fn value(&self, row: &Row) -> Vec<u8> {
        if row.name == SELECTOR {
            return vec![self.selector];
        }
        self.agreed(key(row), &self.of_device(row))
    }

    /// What the contents say, as far as they do; these octets of the device for the rest.
    fn agreed(&self, key: Key, device: &[u8]) -> Vec<u8> {
        let device = device.to_vec();
        let content = self.contents.read(key);
        self.reach(match content {
            Content::Octets(_) => "value: every octet",
            Content::About(_) => "value: computed",
            Content::Bits(..) => "value: some bits",
            Content::Device(reason) => OF_THE_DEVICE[usize::from(reason) - 1],
        });
        match content {
            Content::Octets(octets) => octets,
            Content::About(octets) if self.contents.common.form.alike(&octets, &device) => device,
            Content::About(octets) => octets,
            Content::Bits(mask, octets) => {
                let alike = |((mask, one), other): ((&u8, &u8), &u8)| mask & one == mask & other;
                let fits = device.len() == octets.len() && mask.iter().zip(&octets).zip(&device).all(alike);
                if fits { device } else { octets }
            }
            Content::Device(_) => device,
        }
    }

    /// The octets that the device has.
    fn of_device(&self, row: &Row) -> Vec<u8> {
        if !self.page.table.ms2 {
            let length = row.octets.unwrap_or(self.contents.length());
            return self.real_inputs()[8 - length..8].to_vec();
        }
        let mut record = [0; 240];
        let relation = if row.access[2] { Relation::Ms2(0) } else { Relation::Ms1 };
        let length = self.device.clone().read(relation, row.slot, row.index, &mut record).expect("the page allows it");
        record[..length].to_vec()
    }

    /// The inputs of the device.
    fn real_inputs(&self) -> Vec<u8> {
        let mut inputs = vec![0; self.page.table.configurations[self.configuration].inputs];
        if self.device.get_cfg() == self.page.table.configurations[self.configuration].octets {
            self.device.clone().inputs(&mut inputs);
        }
        inputs
    }

    /// A write of a parameter. `real` decides open points: the code of the parameter channel, if it refuses.
    fn change(&mut self, row: &Row, data: &[u8], real: impl Fn(&Self) -> Option<u8>) -> Result<(), usize> {
        let before = self.contents.clone();
        let reason = match self.contents.write(key(row), data) {
            Verdict::Done => None,
            Verdict::Refused(reason) => Some(place(reason)),
            Verdict::Open(reason) => {
                self.reach(OF_THE_DEVICE[usize::from(reason) - 1]);
                let code = real(self);
                code.map(|code| {
                    let same = |it: &usize| self.page.reasons[*it].channel == code;
                    [MODE, ALREADY, NOT_NOW, RANGE].into_iter().find(same).expect("a reason of the page")
                })
            }
        };
        self.reach(match reason {
            None => "write",
            Some(MODE) => "write: mode",
            Some(ALREADY) => "write: already",
            Some(NOT_NOW) => "write: not now",
            Some(_) => "write: range",
        });
        match reason {
            None => Ok(()),
            Some(reason) => {
                self.contents = before;
                self.contents.particular.refused(key(row), data);
                Err(reason)
            }
        }
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
        self.reach(what);
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
            return Ok(self.value(&row));
        }
        if !(w1 || w2 || row.channel[1]) {
            return Err(NOT_WRITABLE);
        }
        let length = row.octets.unwrap_or(self.contents.length());
        if !octets.contains(&length) {
            return Err(LENGTH);
        }
        if row.name == SELECTOR {
            self.select(value[3])?;
            return Ok(vec![value[3]]);
        }
        let data = value[4 - length..].to_vec();
        self.change(&row, &data, |it| {
            let inputs = it.real_inputs();
            (inputs[0] >> 4 == 7).then_some(inputs[7])
        })?;
        Ok(data)
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
            self.contents.set_prm(user);
        }
        takes
    }

    fn chk_cfg(&mut self, table: &Table, octets: &[u8]) -> Option<usize> {
        let position = table.configurations.iter().position(|it| it.octets == octets)?;
        if self.compatible != (octets == [0xA1, 0x91]) {
            return None;
        }
        self.channel = self.page.with_channel[position];
        self.configuration = position;
        self.contents.set_type(self.page.float[position]);
        Some(position)
    }

    fn begin_exchange(&mut self) {
        self.outputs(None);
        self.contents.begin();
    }

    fn end_exchange(&mut self) {
        self.contents.end();
    }

    fn settle(&mut self) {
        self.contents.settle();
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
        let process = outputs.and_then(|it| if self.channel { it.get(8..) } else { Some(it) });
        self.contents.particular.process(&mut self.contents.common, process);
    }

    fn inputs(&mut self, _length: usize) -> Vec<u8> {
        let mut inputs = self.real_inputs();
        for (range, name) in self.page.inputs[self.configuration].clone() {
            let octets = self.field(&name, &inputs[range.clone()]);
            inputs.splice(range, octets);
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
        std::mem::swap(&mut self.device, &mut self.before);
        self.rewound = true;
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
        if row.octets.unwrap_or(self.contents.length()) != data.len() {
            return Err(self.refusal(LENGTH));
        }
        let result = if row.name == SELECTOR {
            self.select(data[0])
        } else {
            self.change(&row, data, |it| {
                let relation = if via == Via::Ms1 { Relation::Ms1 } else { Relation::Ms2(0) };
                it.before.clone().write(relation, slot, index, data).err().map(|it| it.code_2)
            })
        };
        result.map(|()| 0).map_err(|it| self.refusal(it))
    }

    fn no_im0(&self, _: &Table, slot: u8, _read: bool) -> Refusal {
        self.row(slot, 255).map_or_else(|it| self.refusal(it), |_| Refusal(0xB0, 0))
    }

    fn reached(&self) -> BTreeMap<&'static str, u64> {
        self.reached.borrow().clone()
    }

    fn suggested_access(&self, random: &mut Rng) -> Option<Vec<u8>> {
        if self.page.rows.is_empty() {
            return None;
        }
        let row = self.some_row(random);
        let slot = if random.u8(..12) == 0 { random.u8(..) } else { row.slot };
        let index = if random.u8(..8) == 0 { random.u8(..255) } else { row.index };
        if random.u8(..100) < 55 {
            let length = if random.u8(..4) == 0 { random.u8(..) } else { [240, 240, 4, 2][random.usize(..4)] };
            let mut read = vec![0x5E, slot, index, length];
            match random.u8(..40) {
                0 => read.truncate(random.usize(1..4)),
                1 => read.push(0),
                _ => {}
            }
            return Some(read);
        }
        let data = self.some_data(slot, index, random);
        let mut write = [vec![0x5F, slot, index, u8::try_from(data.len()).expect("short")], data].concat();
        match random.u8(..40) {
            0 => write.truncate(random.usize(1..write.len())),
            1 => write.push(0),
            2 => write[3] = random.u8(..),
            3 => {
                let length = random.u8(1..=240);
                write.truncate(3);
                write.push(length);
                write.resize(4 + usize::from(length), 1);
            }
            _ => {}
        }
        Some(write)
    }

    fn suggested_outputs(&self, random: &mut Rng, length: usize) -> Option<Vec<u8>> {
        let mut outputs = vec![0; length];
        let rest = if self.channel { 8 } else { 0 };
        let process = self.contents.particular.suggest_process(length - rest, random);
        outputs[rest..].copy_from_slice(&process);
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
        let data = self.some_data(slot, index, random);
        let ak = match data.len() {
            _ if ak == 1 || random.u8(..5) == 0 => ak,
            1 if self.page.octet_instruction => 10,
            1 | 2 => 2,
            4 => 3,
            _ => ak,
        };
        let mut value = [0; 4];
        for (to, from) in value.iter_mut().rev().zip(data.iter().rev()) {
            *to = *from;
        }
        outputs[..8].copy_from_slice(&[&[ak << 4 | random.u8(..8), slot, index, random.u8(..2)], &value[..]].concat());
        Some(outputs)
    }
}

impl<D: Device + Clone> Peek<D> {
    /// Octets for a write to this place: mostly of the right length.
    fn some_data(&self, slot: u8, index: u8, random: &mut Rng) -> Vec<u8> {
        let length = random.usize(1..9);
        match self.row(slot, index) {
            Ok(row) if row.name == SELECTOR => vec![random.u8(0..8)],
            Ok(row) if random.u8(..8) != 0 => {
                self.contents.suggest(key(row), row.octets.unwrap_or(self.contents.length()), random)
            }
            _ => (0..length).map(|_| random.u8(0..4)).collect(),
        }
    }

    /// A field of the inputs, which shows a parameter.
    fn field(&self, name: &str, octets: &[u8]) -> Vec<u8> {
        let each = |slots: std::ops::RangeInclusive<u8>, index: u8| {
            slots.zip(octets).flat_map(|(slot, octet)| self.agreed((slot, 0, index), &[*octet])).collect()
        };
        let number = |name: &str| name.split(' ').nth(2).and_then(|it| it.parse::<u8>().ok()).unwrap_or(0);
        match name.split(" (").next().unwrap_or(name) {
            "Exception Status" => self.agreed((0, 0, 26), octets),
            "One Of N Status Extension" => self.agreed((1, 0, 120), octets),
            "One Of N PV Selector" => self.agreed((1, 0, 47), octets),
            "Process Value" => {
                let active = self.page.rows.iter().find(|it| (it.slot, it.index) == (1, 47));
                self.agreed((1, self.value(active.expect("a row"))[0], 19), octets)
            }
            "Channel Status" => self.agreed((0, 0, 204), octets),
            "Trip Relays" if octets.len() == 2 => each(2..=3, 21),
            "Trip Relays" => each(5..=11, 21),
            name if name.starts_with("Measured Value") && octets.len() != 3 && self.page.table.ms2 => {
                self.agreed((number(name), 0, 19), octets)
            }
            name if name.starts_with("Measurement Status") => self.agreed((number(name), 0, 21), octets),
            _ => octets.to_vec(),
        }
    }
}

/// Slot, instance and index.
fn key(row: &Row) -> Key {
    (row.slot, row.instance.unwrap_or(0), row.index)
}

/// The row of the table of refusals.
const fn place(reason: Reason) -> usize {
    match reason {
        Reason::Mode => MODE,
        Reason::Already => ALREADY,
        Reason::NotNow => NOT_NOW,
        Reason::Range => RANGE,
    }
}

impl<B: Behaviour + Clone> Driven for Gauge<B> {
    type Process = Peek<Self>;

    fn set_time(&mut self, _now: u64) {}

    fn set_diagnosis(&mut self, _diagnosis: DeviceDiagnosis) {}

    fn settle(&mut self) {
        SimulatedDevice::settle(self);
    }

    fn show(&self, process: &mut Peek<Self>) {
        if std::mem::take(&mut process.rewound) {
            std::mem::swap(&mut process.device, &mut process.before);
        }
        process.before = std::mem::replace(&mut process.device, self.clone());
    }
}
