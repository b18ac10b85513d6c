//! A line with masters that each ask a slave of their own, and how long their ring may take to be whole again.

use crate::common::Plain;
use profivac_dp::link::active::{Active, BusParameters, Confirmation, FdlUser, Priority, Request, RingState};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::services;
use profivac_dp::slave::Slave;
use profivac_sim::{Fault, Rule, Segment, StationHandle, Violation};

/// What may happen while nobody can know who has the token.
pub const CONFUSION: [Rule; 10] = [
    Rule::Collision,
    Rule::Syn,
    Rule::Id1,
    Rule::Id2,
    Rule::BeforeSlotTime,
    Rule::Unrequested,
    Rule::SecondAnswer,
    Rule::NoToken,
    Rule::SecondToken,
    Rule::Early,
];

pub const BAUD: Baud = Baud::B1500000;
/// The GAP ends here. Slaves are above it, unless a test wants them inside.
pub const HSA: u8 = 15;
/// G x T_TR, the pause between two scans of the GAP.
pub const PAUSE_TBIT: u64 = 5000;

/// Asks its slave for its diagnosis once in a token visit.
pub struct Asker {
    pub slave: u8,
    asked: bool,
    pub answered: u32,
    pub failed: u32,
}

impl Asker {
    pub const fn new(slave: u8) -> Self {
        Self { slave, asked: false, answered: 0, failed: 0 }
    }
}

impl FdlUser for Asker {
    fn next_request(&mut self, priority: Priority, _now: BitTime) -> Option<Request<'_>> {
        if priority == Priority::Low {
            return None;
        }
        self.asked = !self.asked;
        self.asked.then(|| services::slave_diag(self.slave))
    }

    fn confirm(&mut self, _now: BitTime, confirmation: Confirmation<'_>) {
        match confirmation {
            Confirmation::Answer(_) => self.answered += 1,
            Confirmation::Sent | Confirmation::Failed(_) => self.failed += 1,
        }
    }
}

pub type Master = Active<Asker>;

/// The slave of a master.
pub const fn slave_of(master: u8) -> u8 {
    master + 40
}

pub fn parameters(address: u8) -> BusParameters {
    BusParameters { hsa: HSA, gap_factor: 1, rotation_tbit: PAUSE_TBIT as u32, ..BusParameters::new(address, BAUD) }
}

pub fn master(address: u8, now: BitTime) -> Master {
    Active::new(parameters(address), Asker::new(slave_of(address)), now)
}

/// What a ring of the masters at `addresses` may take. All in bit times.
///
/// A visit is at most T_ID1, a request of 11 characters that is asked twice in vain (121 + T_SL each), a question to the GAP
/// (66 + T_SL) and a token (33 + T_ID1); a rotation is a visit of each.
pub struct Bounds {
    slot: u64,
    rotation: u64,
    lowest: u8,
}

impl Bounds {
    pub fn of(addresses: &[u8]) -> Self {
        let bus = parameters(0);
        let slot = u64::from(bus.slot_tbit);
        let visit = bus.id1_tbit() + 2 * (121 + slot) + 66 + slot + 33 + bus.id1_tbit();
        Self {
            slot,
            rotation: visit * addresses.len() as u64,
            lowest: addresses.iter().min().copied().unwrap_or_default(),
        }
    }

    /// How long a rotation takes at most.
    pub const fn rotation(&self) -> u64 {
        self.rotation
    }

    /// After the token was lost: T_TO = (6 + 2n) T_SL of the lowest address n that is left claims it; each of `dead` stations
    /// costs the token and T_SL three times; the second rotation after that is whole.
    pub fn token_lost(&self, dead: u64) -> u64 {
        (6 + 2 * u64::from(self.lowest)) * self.slot + dead * 3 * (33 + self.slot) + 2 * self.rotation
    }

    /// From one question to an address of the GAP to the next: the pause G x T_TR, and one address of at most HSA + 1 per
    /// rotation; the pause ends with a visit.
    fn period(&self) -> u64 {
        PAUSE_TBIT + (u64::from(HSA) + 2) * self.rotation
    }

    /// A station that listens knows the ring: it hears the rest of a rotation and two whole ones.
    fn learn(&self) -> u64 {
        3 * self.rotation
    }

    /// Until a station that begins to listen is in the ring: it learns the ring, and was perhaps asked just before it had.
    pub fn join(&self) -> u64 {
        self.learn() + self.period()
    }

    /// Until stations that know nothing of each other are one ring: the lowest claims the token and asks everybody, perhaps
    /// before they know the ring; each one that joins makes the others learn it anew; within another period everybody who
    /// is not in is asked by his predecessor.
    pub fn begin(&self, stations: usize) -> u64 {
        self.token_lost(0) + stations as u64 * self.learn() + 2 * self.period()
    }
}

pub struct Line {
    pub bus: Segment,
    pub masters: Vec<(u8, StationHandle<Master>)>,
}

impl Line {
    /// Masters that are switched on at bit time 0, and their slaves.
    pub fn new(addresses: &[u8]) -> Self {
        Self::along(&addresses.iter().map(|address| (*address, 0)).collect::<Vec<_>>())
    }

    /// The same with a place on the cable for each master and its slave.
    pub fn along(places: &[(u8, u64)]) -> Self {
        let mut line = Self { bus: Segment::new(BAUD), masters: Vec::new() };
        for (address, position) in places {
            line.bus.attach_at(*position, Slave::<_>::new(Plain::new(), slave_of(*address), BAUD));
            let master = line.bus.attach_at(*position, master(*address, BitTime(0)));
            line.masters.push((*address, master));
        }
        line
    }

    /// A ring that is whole.
    pub fn whole(addresses: &[u8]) -> Self {
        let mut line = Self::new(addresses);
        line.becomes_whole(addresses, Bounds::of(addresses).begin(addresses.len())).unwrap();
        line
    }

    /// A ring that is whole just now, as soon as it is.
    pub fn soon_whole(addresses: &[u8]) -> Self {
        let mut line = Self::new(addresses);
        line.until_known(addresses);
        line
    }

    /// Lets time pass until each of these knows that they are a ring.
    pub fn until_known(&mut self, addresses: &[u8]) {
        let end = self.bus.now() + Bounds::of(addresses).begin(addresses.len());
        while !addresses.iter().all(|address| self.master(*address).masters().count() == addresses.len()) {
            assert!(self.bus.now() < end, "no ring of {addresses:?}");
            self.bus.run_for(100).unwrap();
        }
    }

    /// Nobody can know who has the token for `tbit`; after that everybody keeps to the rules again.
    pub fn in_confusion(&mut self, tbit: u64) {
        CONFUSION.into_iter().for_each(|rule| self.bus.allow(rule));
        self.bus.run_for(tbit).unwrap();
        CONFUSION.into_iter().for_each(|rule| self.bus.disallow(rule));
    }

    /// Who has the token just now, unless it is on its way.
    pub fn holder(&self) -> Option<u8> {
        self.masters.iter().map(|(address, _)| *address).find(|address| self.master(*address).has_token())
    }

    pub fn handle(&self, address: u8) -> StationHandle<Master> {
        let found = self.masters.iter().find(|(other, _)| *other == address);
        found.expect("a master of this line").1
    }

    pub fn master(&self, address: u8) -> &Master {
        self.bus.station(self.handle(address))
    }

    /// Another master is switched on now.
    pub fn add(&mut self, address: u8) {
        self.bus.attach(Slave::<_>::new(Plain::new(), slave_of(address), BAUD));
        let master = self.bus.attach(master(address, self.bus.now()));
        self.masters.push((address, master));
    }

    pub fn switch_off(&mut self, address: u8) {
        self.bus.inject(Fault::Power(self.handle(address).id(), false));
    }

    /// Power returns; the master has forgotten everything.
    pub fn switch_on(&mut self, address: u8) {
        let handle = self.handle(address);
        *self.bus.station_mut(handle) = master(address, self.bus.now());
        self.bus.inject(Fault::Power(handle.id(), true));
    }

    /// The ring consists of `addresses` within `bound_tbit`, and stays so: the referee watches every token of the next
    /// rotations, everybody knows everybody, and everybody gets answers from its slave.
    pub fn becomes_whole(&mut self, addresses: &[u8], bound_tbit: u64) -> Result<(), Box<Violation>> {
        self.bus.run_for(bound_tbit)?;
        self.stays_whole(addresses)
    }

    pub fn stays_whole(&mut self, addresses: &[u8]) -> Result<(), Box<Violation>> {
        self.bus.expect_ring(addresses, self.bus.now());
        let before = self.answers(addresses);
        self.bus.run_for(4 * Bounds::of(addresses).rotation)?;
        let after = self.answers(addresses);
        self.bus.expect_ring(&[], self.bus.now());
        for (place, address) in addresses.iter().enumerate() {
            let master = self.master(*address);
            assert_eq!(master.ring_state(), RingState::InRing, "{address} {}", self.bus.trace());
            let known: Vec<u8> = master.masters().collect();
            let mut all = addresses.to_vec();
            all.sort_unstable();
            assert_eq!(known, all, "what {address} knows");
            assert!(after[place] >= before[place] + 3, "{address} got {} answers", after[place] - before[place]);
        }
        Ok(())
    }

    pub fn answers(&self, addresses: &[u8]) -> Vec<u32> {
        addresses.iter().map(|address| self.master(*address).user.answered).collect()
    }
}
