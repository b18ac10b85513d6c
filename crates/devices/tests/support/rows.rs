//! Every row of a device's tables, by every access path.

use super::{SLAVE, Tester, hex};
use profivac_devices::SimulatedDevice;
use profivac_devices::model::{self, Access, DataType, Location, Model, Row, Storage, TaskKind};
use profivac_dp::slave::{Dpv1Error, Relation};
use profivac_wire::acyclic::ErrorCode;

/// Values that a parameter accepts, and values that it refuses. Pressures are floats in the unit of [`Rig::make`].
pub struct Sample {
    /// Slot, instance, index.
    pub at: (u8, u8, u8),
    /// Accepted.
    pub good: &'static [&'static str],
    /// Of the right length, and out of range.
    pub bad: &'static [&'static str],
    /// Its kind.
    pub kind: Kind,
}

/// The effect of a write.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A read returns the written value.
    Value,
    /// The same, but not during cyclic exchange.
    Presentation,
    /// The device executes a command; a read does not return the written value.
    Command,
}

/// A device under test.
pub struct Rig<D> {
    pub model: &'static Model,
    /// A device that has settled, in IDLE.
    pub make: fn() -> D,
    /// Selects this instance in a slot.
    pub select: fn(&mut D, &Location),
    /// A user parameter string, and two configurations with parameter channel: for integers and floats, where the
    /// device has both.
    pub user: &'static str,
    pub cfgs: [&'static str; 2],
    pub samples: &'static [Sample],
}

/// The two relations of DP-V1 with their marks.
const DPV1: [(Relation, Access, Access); 2] =
    [(Relation::Ms1, Access::READ_1, Access::WRITE_1), (Relation::Ms2(0), Access::READ_2, Access::WRITE_2)];

/// The length of a parameter; `number` is the length of a pressure.
fn length(row: &Row, number: usize) -> usize {
    match row.data_type {
        DataType::Boolean | DataType::Int8 | DataType::Uint8 => 1,
        DataType::Int16 | DataType::Uint16 => 2,
        DataType::Int32 | DataType::Uint32 | DataType::Float => 4,
        DataType::Visible(length) | DataType::OctetString(length) | DataType::Array(length) => length.into(),
        DataType::Record(length) => length.into(),
        DataType::ByType => number,
    }
}

/// AK of a positive answer; errata-bpg-bcg-tpg 19 and 20.
fn answer_ak(row: &Row, length: usize) -> Option<u8> {
    match (row.data_type, length) {
        (DataType::Visible(_), _) => None,
        (_, 1) => Some(11),
        (_, 2) => Some(1),
        (_, 3 | 4) => Some(2),
        _ => None,
    }
}

/// The eight octets of a write.
fn write_request(ak: u8, slot: u8, index: u8, octets: &[u8]) -> [u8; 8] {
    let mut request = [ak << 4, slot, index, 0, 0, 0, 0, 0];
    request[8 - octets.len()..].copy_from_slice(octets);
    request
}

impl<D: SimulatedDevice> Tester<D> {
    /// One instruction in the parameter channel, after AK 0.
    pub fn channel(&mut self, request: [u8; 8]) -> [u8; 8] {
        let outputs = self.outputs().expect("data exchange");
        let mut du = vec![0; outputs];
        assert_eq!(self.exchange(&du)[0], 0, "AK 0 is answered with AK 0");
        du[..8].copy_from_slice(&request);
        self.exchange(&du)[..8].try_into().unwrap()
    }

    /// A read by DP-V1.
    pub fn read(&mut self, via: Relation, slot: u8, index: u8) -> Result<Vec<u8>, Dpv1Error> {
        let mut record = [0; 240];
        let length = self.device().read(via, slot, index, &mut record)?;
        Ok(record[..length].to_vec())
    }

    /// A write by DP-V1.
    pub fn write(&mut self, via: Relation, slot: u8, index: u8, octets: &[u8]) -> Result<(), Dpv1Error> {
        self.device().write(via, slot, index, octets)
    }
}

/// An error answer of the parameter channel.
fn channel_error(slot: u8, index: u8, code: u8) -> [u8; 8] {
    [0x70, slot, index, 0, 0, 0, 0, code]
}

impl<D: SimulatedDevice> Rig<D> {
    fn tester(&self) -> Tester<D> {
        Tester::new((self.make)())
    }

    /// In cyclic exchange with the parameter channel; pressures are integers or floats.
    fn exchanging(&self, cfg: &str) -> Tester<D> {
        let mut tester = self.tester();
        tester.bring_up(&hex(self.user), &hex(cfg));
        tester
    }

    /// The length of a pressure in a configuration.
    fn number(&self, cfg: &str) -> usize {
        let configuration = self.model.configuration(&hex(cfg)).expect("a configuration of the tables");
        configuration.number().map_or(4, |number| number.octets())
    }

    /// AK of a write of this number of octets.
    fn write_ak(&self, length: usize) -> u8 {
        let writes = |instruction| matches!(instruction, TaskKind::Write(lengths) if lengths.contains(&length));
        let instruction = self.model.channel_rules.tasks.iter().find(|(_, instruction)| writes(*instruction));
        instruction.expect("a way to write").0
    }

    /// Every row at every address.
    fn each(&self, mut visit: impl FnMut(&'static Location, &'static Row)) {
        for placed in self.model.blocks {
            for address in placed.locations {
                placed.block.rows.iter().for_each(|row| visit(address, row));
            }
        }
    }

    /// Reads by all three access paths: where a mark allows it, the answer has type and length of the row; otherwise a refusal.
    pub fn every_row_is_read_as_marked(&self) {
        for cfg in self.cfgs {
            let (mut tester, number) = (self.exchanging(cfg), self.number(cfg));
            self.each(|address, row| {
                (self.select)(tester.device(), address);
                let (slot, id, length) = (address.slot, row.index, length(row, number));
                let what = format!("{slot}:{}/{id} {}", address.instance, row.name);
                for (relation, read, _) in DPV1 {
                    let result = tester.read(relation, slot, id).map(|octets| octets.len());
                    let refused = Dpv1Error { code_1: ErrorCode(0xB6), code_2: 18 };
                    let expected = if row.access.contains(read) { Ok(length) } else { Err(refused) };
                    assert_eq!(result, expected, "{what} by {relation:?}");
                }
                let answer = tester.channel([0x10, slot, id, 0, 0, 0, 0, 0]);
                let readable = row.access.intersects(Access::READ);
                let unreadable = self.model.channel_rules.error_code(model::AccessError::NotReadable);
                match answer_ak(row, length) {
                    _ if !readable => assert_eq!(answer, channel_error(slot, id, unreadable), "{what}"),
                    None => assert_eq!(answer, channel_error(slot, id, self.unfit_code(row)), "{what}"),
                    Some(ak) => {
                        assert_eq!(answer[..4], [ak << 4, slot, id, 0], "{what}");
                        // The same octets as by DP-V1, right-aligned.
                        for (relation, ..) in DPV1.iter().filter(|(_, read, _)| row.access.contains(*read)) {
                            let octets = tester.read(*relation, slot, id).unwrap();
                            assert_eq!(answer[8 - length..], octets[..], "{what}");
                        }
                        assert!(answer[4..8 - length].iter().all(|octet| *octet == 0), "{what}");
                    }
                }
            });
        }
    }

    /// The refusal of a value that the parameter channel cannot transfer.
    fn unfit_code(&self, row: &Row) -> u8 {
        let text = matches!(row.data_type, DataType::Visible(_));
        self.model.channel_rules.error_code(if text {
            model::AccessError::NotInChannel
        } else {
            model::AccessError::WrongLength
        })
    }

    /// Writes where no mark allows it, and with another length.
    pub fn no_row_is_written_without_a_mark_or_with_another_length(&self) {
        for cfg in self.cfgs {
            let (mut tester, number) = (self.exchanging(cfg), self.number(cfg));
            self.each(|address, row| {
                (self.select)(tester.device(), address);
                let (slot, id, length) = (address.slot, row.index, length(row, number));
                let what = format!("{slot}:{}/{id} {}", address.instance, row.name);
                for (relation, _, write) in DPV1 {
                    let forbidden = Dpv1Error { code_1: ErrorCode(0xB6), code_2: 1 };
                    let wrong = Dpv1Error { code_1: ErrorCode(0xB1), code_2: 5 };
                    let expected = if row.access.contains(write) { wrong } else { forbidden };
                    for octets in [0, length - 1, length + 1, 240] {
                        let result = tester.write(relation, slot, id, &vec![0; octets]);
                        assert_eq!(result, Err(expected), "{what} by {relation:?} with {octets} octets");
                    }
                    if !row.access.contains(write) {
                        assert_eq!(tester.write(relation, slot, id, &vec![0; length]), Err(forbidden), "{what}");
                    }
                }
                let writable = row.access.intersects(Access::WRITE);
                for octets in [1, 2, 4] {
                    let ak = self.write_ak(octets);
                    if writable && ak == self.write_ak(length) {
                        continue;
                    }
                    let answer = tester.channel(write_request(ak, slot, id, &vec![0; octets]));
                    assert_eq!(answer, channel_error(slot, id, if writable { 5 } else { 1 }), "{what}");
                }
            });
        }
    }

    /// Slots and indices that no table has.
    pub fn other_slots_and_indices_are_refused(&self) {
        let mut tester = self.exchanging(self.cfgs[0]);
        let addresses: Vec<&Location> = self.model.blocks.iter().flat_map(|placed| placed.locations).collect();
        let has_instances = addresses.iter().any(|address| address.instance != 0);
        let selections = addresses.iter().filter(|address| address.instance != 0 || !has_instances);
        for selected in selections.take(if has_instances { usize::MAX } else { 1 }) {
            (self.select)(tester.device(), selected);
            for slot in 0..=255u8 {
                let known_slot = addresses.iter().any(|address| address.slot == slot);
                for index in 0..=255u8 {
                    if self.shows(selected, slot, index) {
                        continue;
                    }
                    let expected = if known_slot { (0xB0, 3) } else { (0xB2, 0) };
                    let expected = Dpv1Error { code_1: ErrorCode(expected.0), code_2: expected.1 };
                    assert_eq!(tester.read(Relation::Ms2(0), slot, index), Err(expected), "{slot}/{index}");
                    assert_eq!(tester.write(Relation::Ms1, slot, index, &[0]), Err(expected), "{slot}/{index}");
                    if index % 16 == slot % 16 {
                        let answer = tester.channel([0x10, slot, index, 0, 0, 0, 0, 0]);
                        assert_eq!(answer, channel_error(slot, index, expected.code_2), "{slot}/{index}");
                    }
                }
            }
        }
    }

    /// Whether slot and index lead to a row while this address is selected.
    fn shows(&self, selected: &Location, slot: u8, index: u8) -> bool {
        let visible = |address: &Location| address.instance == 0 || address.instance == selected.instance;
        self.model.blocks.iter().any(|placed| {
            placed.block.row(index).is_some()
                && placed.locations.iter().any(|address| address.slot == slot && visible(address))
        })
    }

    /// The samples cover every writable row and no other.
    pub fn samples_are_complete(&self) {
        let mut writable = Vec::new();
        self.each(|address, row| {
            if row.access.intersects(Access::WRITE) {
                writable.push((address.slot, address.instance, row.index));
            }
        });
        let mut sampled: Vec<_> = self.samples.iter().map(|sample| sample.at).collect();
        writable.sort_unstable();
        sampled.sort_unstable();
        assert_eq!(sampled, writable);
    }

    /// The row and address of a sample.
    fn find(&self, (slot, instance, index): (u8, u8, u8)) -> (&'static Location, &'static Row) {
        let mut found = None;
        self.each(|address, row| {
            if (address.slot, address.instance, row.index) == (slot, instance, index) {
                found = Some((address, row));
            }
        });
        found.expect("a sample of the tables")
    }

    /// By DP-V1: a good value is read back, a bad value is refused and changes nothing.
    pub fn every_value_is_checked_by_dpv1(&self) {
        for sample in self.samples {
            let (address, row) = self.find(sample.at);
            let (slot, id) = (address.slot, row.index);
            for (relation, read, write) in DPV1 {
                if !row.access.contains(write) {
                    continue;
                }
                let mut tester = self.tester();
                (self.select)(tester.device(), address);
                let what = format!("{slot}:{}/{id} {} by {relation:?}", address.instance, row.name);
                for good in sample.good {
                    assert_eq!(tester.write(relation, slot, id, &hex(good)), Ok(()), "{what}: {good}");
                    if sample.kind != Kind::Command {
                        assert_eq!(tester.read(relation, slot, id).unwrap(), hex(good), "{what}");
                    }
                }
                let before = row.access.contains(read).then(|| tester.read(relation, slot, id).unwrap());
                for bad in sample.bad {
                    let range = Dpv1Error { code_1: ErrorCode(0xB7), code_2: 2 };
                    assert_eq!(tester.write(relation, slot, id, &hex(bad)), Err(range), "{what}: {bad}");
                    if let Some(before) = &before {
                        assert_eq!(tester.read(relation, slot, id).as_ref(), Ok(before), "{what}: {bad}");
                    }
                }
            }
        }
    }

    /// The same by the parameter channel, where the number type is that of the configuration.
    pub fn every_value_is_checked_by_the_channel(&self) {
        for sample in self.samples {
            let (address, row) = self.find(sample.at);
            let (slot, id, length) = (address.slot, row.index, length(row, 4));
            let mut tester = self.exchanging(self.cfgs[1]);
            (self.select)(tester.device(), address);
            let what = format!("{slot}:{}/{id} {}", address.instance, row.name);
            let [write, positive] = [self.write_ak(length), answer_ak(row, length).unwrap()];
            for good in sample.good {
                let request = write_request(write, slot, id, &hex(good));
                let answer = tester.channel(request);
                if sample.kind == Kind::Presentation {
                    assert_eq!(answer, channel_error(slot, id, 17), "{what}: {good}");
                    continue;
                }
                assert_eq!(answer[0], positive << 4, "{what}: {good}");
                assert_eq!(answer[1..], request[1..], "{what}: {good}");
                if sample.kind == Kind::Value {
                    assert_eq!(tester.channel([0x10, slot, id, 0, 0, 0, 0, 0]), answer, "{what}: {good}");
                }
            }
            for bad in sample.bad {
                let code = if sample.kind == Kind::Presentation { 17 } else { 2 };
                let answer = tester.channel(write_request(write, slot, id, &hex(bad)));
                assert_eq!(answer, channel_error(slot, id, code), "{what}: {bad}");
            }
        }
    }

    /// Reads a row by the first access path that its marks allow.
    fn read_somehow(&self, tester: &mut Tester<D>, slot: u8, row: &Row) -> Vec<u8> {
        match DPV1.iter().find(|(_, read, _)| row.access.contains(*read)) {
            Some((relation, ..)) => tester.read(*relation, slot, row.index).unwrap(),
            None => tester.channel([0x10, slot, row.index, 0, 0, 0, 0, 0])[8 - length(row, 4)..].to_vec(),
        }
    }

    /// Writes a row by the first access path that its marks allow.
    fn write_somehow(&self, tester: &mut Tester<D>, slot: u8, row: &Row, octets: &[u8]) {
        match DPV1.iter().find(|(.., write)| row.access.contains(*write)) {
            Some((relation, ..)) => tester.write(*relation, slot, row.index, octets).unwrap(),
            None => {
                let request = write_request(self.write_ak(octets.len()), slot, row.index, octets);
                assert_ne!(tester.channel(request)[0], 0x70, "{request:02X?}");
            }
        }
    }

    /// With the parameter channel if the row has no other access path.
    fn tester_for(&self, address: &Location, row: &Row) -> Tester<D> {
        let by_channel = row.access.intersects(Access::WRITE_CHANNEL);
        let mut tester = if by_channel { self.exchanging(self.cfgs[1]) } else { self.tester() };
        (self.select)(tester.device(), address);
        tester
    }

    /// Nonvolatile values survive power loss; all others return to their initial values.
    pub fn nonvolatile_values_are_restored_after_power_up(&self) {
        for sample in self.samples.iter().filter(|sample| sample.kind != Kind::Command) {
            let (address, row) = self.find(sample.at);
            let factory = self.read_somehow(&mut self.tester_for(address, row), address.slot, row);
            for good in sample.good {
                let mut tester = self.tester_for(address, row);
                self.write_somehow(&mut tester, address.slot, row, &hex(good));
                tester.device().set_power(false);
                tester.device().set_power(true);
                tester.device().settle();
                if tester.is_exchanging() {
                    tester.slave.power_up(SLAVE);
                    tester.bring_up(&hex(self.user), &hex(self.cfgs[1]));
                }
                (self.select)(tester.device(), address);
                let expected = if row.storage == Storage::Nonvolatile { hex(good) } else { factory.clone() };
                let kept = self.read_somehow(&mut tester, address.slot, row);
                assert_eq!(kept, expected, "{}:{}/{}: {good}", address.slot, address.instance, row.index);
            }
        }
    }
}
