//! Every device beside itself, printed as a device file and read again: both give the same answers to the same telegrams.

use profivac_devices::model::Model;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::slave::Relation;
use profivac_virtual::device::GaugeSlave;
use profivac_virtual::device_spec::{DEVICES, DeviceSpec};
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_wire::control::{Control, FrameCount, Function};
use profivac_wire::{DataTelegram, Telegram};
use std::path::Path;

const BAUD: Baud = Baud::B1500000;
const ADDRESS: u8 = 5;
const MASTER: u8 = 1;

/// A built-in device, and the one of its file.
struct Both {
    slaves: [Box<dyn GaugeSlave>; 2],
    now: BitTime,
    random: fastrand::Rng,
    /// The telegrams that had an answer, and the records that were read.
    answers: usize,
    records: usize,
}

impl Both {
    fn new(model: &'static Model, folder: &Path) -> Self {
        let text = profivac_device_file::show(model);
        let own = format!("\nname = \"{}\"\n", model.name);
        assert_eq!(text.matches(&own).count(), 1);
        std::fs::write(folder.join("again.toml"), text.replace(&own, "\nname = \"again\"\n")).unwrap();
        let build = |name: &str| {
            let spec = DeviceSpec::parse_in(&format!("{name}@{ADDRESS}"), folder).unwrap();
            spec.build(NonvolatileMemory::volatile(), BAUD).unwrap()
        };
        let slaves = [build(model.name), build("again.toml")];
        Self { slaves, now: BitTime(0), random: fastrand::Rng::with_seed(7), answers: 0, records: 0 }
    }

    /// Gives both the same request; their answers are equal.
    fn ask(&mut self, saps: Option<(u8, u8)>, du: &[u8]) -> Option<Vec<u8>> {
        let fc = Control::Request { function: Function::SrdHigh, count: FrameCount::First }.to_octet();
        let (dsap, ssap) = saps.unzip();
        let request = Telegram::Data(DataTelegram { da: ADDRESS, sa: MASTER, dsap, ssap, fc, du });
        self.now = self.now + 10_000;
        let now = self.now;
        let [built_in, of_file] = self.slaves.each_mut().map(|slave| {
            let answer = slave.telegram(now, &request).map(|transmit| transmit.octets.to_vec());
            if answer.is_some() {
                slave.sent(now + 5_000);
            }
            answer
        });
        assert_eq!(of_file, built_in, "{request:?}");
        self.answers += usize::from(built_in.is_some());
        built_in
    }

    /// The same at both devices.
    fn at_both<T: PartialEq + std::fmt::Debug>(&mut self, mut act: impl FnMut(&mut dyn GaugeSlave) -> T) -> T {
        let [built_in, of_file] = self.slaves.each_mut().map(|slave| act(&mut **slave));
        assert_eq!(of_file, built_in);
        built_in
    }

    /// Reads every record of every slot, and writes some of them with octets of the right number.
    fn records(&mut self, model: &Model, writes: usize) {
        let slots: Vec<u8> =
            (0..=model.blocks.iter().flat_map(|it| it.locations).map(|it| it.slot).max().unwrap()).collect();
        for slot in slots {
            for index in 0..=u8::MAX {
                let read = self.at_both(|slave| {
                    let mut record = [0; 240];
                    let length = slave.device_mut().read(Relation::Ms2(0), slot, index, &mut record);
                    length.map(|length| record[..length].to_vec())
                });
                self.records += usize::from(read.is_ok());
            }
        }
        let rows: Vec<_> = model
            .blocks
            .iter()
            .flat_map(|placed| placed.locations.iter().map(move |it| (it.slot, placed.block)))
            .flat_map(|(slot, block)| block.rows.iter().map(move |row| (slot, row.index)))
            .collect();
        for _ in 0..writes {
            let (slot, index) = rows[self.random.usize(..rows.len())];
            let length = [1, 1, 1, 2, 4, 30][self.random.usize(..6)];
            let octets: Vec<u8> =
                (0..length).map(|_| [0, 1, 2, 3, 4, 0x3F, 0x13, 0x08][self.random.usize(..8)]).collect();
            let _ = self.at_both(|slave| slave.device_mut().write(Relation::Ms2(0), slot, index, &octets));
        }
    }

    /// Pressures and time.
    fn pass(&mut self, pa: f64) {
        self.at_both(|slave| {
            let device = slave.device_mut();
            for part in 0..device.parts().len() {
                device.sense(part, pa);
            }
            device.advance(1.0);
            device.report().exception_status
        });
    }

    /// Brings both up in each configuration with each string of user parameters, and exchanges data.
    fn exchange(&mut self, model: &'static Model) {
        for configuration in model.configurations {
            for prm in model.user_prm {
                let [high, low] = model.ident.to_be_bytes();
                let head = [0x80, 0, 0, 11, high, low, 0];
                self.ask(Some((60, 62)), &[]);
                self.ask(Some((61, 62)), &[&head, prm.octets].concat());
                self.ask(Some((62, 62)), configuration.octets);
                self.ask(Some((60, 62)), &[]);
                for round in 0..8 {
                    let mut outputs = vec![0; configuration.output_octets()];
                    outputs.iter_mut().for_each(|octet| *octet = self.random.u8(..0x20));
                    self.ask(None, &outputs);
                    self.pass(10_f64.powi(5 - round));
                }
                self.ask(Some((59, 62)), &[]);
            }
        }
    }
}

#[test]
fn a_device_that_is_printed_and_read_again_gives_the_same_answers_on_the_wire() {
    for entry in &DEVICES {
        let folder = tempfile::tempdir().unwrap();
        let mut both = Both::new(entry.model, folder.path());
        both.at_both(|slave| slave.device_mut().settle());
        both.records(entry.model, 300);
        both.exchange(entry.model);
        both.records(entry.model, 300);
        both.exchange(entry.model);
        println!("{}: {} answers, {} records", entry.model.name, both.answers, both.records);
        assert!(both.answers > 100 && (both.records > 40 || !entry.model.features.dpv1), "{}", entry.model.name);
    }
}
