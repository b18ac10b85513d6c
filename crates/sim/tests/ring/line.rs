//! A line with masters that each poll a slave, and bounds of the time until their ring is complete.

use crate::common::Plain;
use profivac_dp::link::active::{Active, BusParameters, Confirmation, FdlUser, Priority, Request, RingState};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::services;
use profivac_dp::slave::Slave;
use profivac_sim::{Fault, Rule, Segment, StationHandle, Violation};

/// The rules that stations may violate while the holder of the token is unknown.
pub const TOKEN_RULES: [Rule; 10] = [
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
/// HSA, the end of the GAP. Slaves have higher addresses unless a test needs them below.
pub const HSA: u8 = 15;
/// G x T_TR, the pause between two scans of the GAP.
pub const PAUSE_TBIT: u64 = 5000;

/// A master user that requests the diagnosis of its slave once per token visit.
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
    BusParameters {
        hsa: HSA.max(address),
        gap_factor: 1,
        rotation_tbit: PAUSE_TBIT as u32,
        ..BusParameters::new(address, BAUD)
    }
}

pub fn master(address: u8, now: BitTime) -> Master {
    Active::new(parameters(address).check().unwrap(), Asker::new(slave_of(address)), now)
}

/// Bounds of times of a ring of the masters at `addresses`, in bit times.
///
/// A token visit takes at most T_ID1, a request of 11 characters sent twice without answer (121 + T_SL each), a poll of the
/// GAP (66 + T_SL) and a token (33 + T_ID1). A rotation is one visit of each master.
pub struct Bounds {
    slot: u64,
    rotation: u64,
    lowest: u8,
}

impl Bounds {
    pub fn of(addresses: &[u8]) -> Self {
        let segment = parameters(0);
        let slot = u64::from(segment.slot_tbit);
        let visit = segment.id1_tbit() + 2 * (121 + slot) + 66 + slot + 33 + segment.id1_tbit();
        Self {
            slot,
            rotation: visit * addresses.len() as u64,
            lowest: addresses.iter().min().copied().unwrap_or_default(),
        }
    }

    /// The longest rotation.
    pub const fn rotation(&self) -> u64 {
        self.rotation
    }

    /// The time after a lost token: the lowest remaining address n claims it after T_TO = (6 + 2n) T_SL; each of `dead` stations
    /// costs the token and T_SL three times; the second rotation after that is complete.
    pub fn token_lost(&self, dead: u64) -> u64 {
        (6 + 2 * u64::from(self.lowest)) * self.slot + dead * 3 * (33 + self.slot) + 2 * self.rotation
    }

    /// The time between two polls of an address of the GAP: the pause G x T_TR, which ends with a visit, and one address of at
    /// most HSA + 1 per rotation.
    fn period(&self) -> u64 {
        PAUSE_TBIT + (u64::from(HSA) + 2) * self.rotation
    }

    /// The time until a listening station knows the ring: the rest of a rotation and two complete ones.
    fn learn(&self) -> u64 {
        3 * self.rotation
    }

    /// The time until a station that begins to listen is in the ring: it learns the ring, and may just have missed a poll.
    pub fn join(&self) -> u64 {
        self.learn() + self.period()
    }

    /// The time until stations after power-up form one ring: the lowest address claims the token and polls all addresses,
    /// perhaps before the others know the ring; each new member makes the others learn it again; within another period each
    /// remaining station is polled by its predecessor.
    pub fn begin(&self, stations: usize) -> u64 {
        self.token_lost(0) + stations as u64 * self.learn() + 2 * self.period()
    }
}

pub struct Line {
    pub segment: Segment,
    pub masters: Vec<(u8, StationHandle<Master>)>,
}

impl Line {
    /// Masters, switched on at bit time 0, and their slaves.
    pub fn new(addresses: &[u8]) -> Self {
        Self::along(&addresses.iter().map(|address| (*address, 0)).collect::<Vec<_>>())
    }

    /// The same with a position on the cable for each master and its slave.
    pub fn along(places: &[(u8, u64)]) -> Self {
        let mut line = Self { segment: Segment::new(BAUD), masters: Vec::new() };
        for (address, position) in places {
            line.segment.attach_at(*position, Slave::<_>::new(Plain::new(), slave_of(*address), BAUD));
            let master = line.segment.attach_at(*position, master(*address, BitTime(0)));
            line.masters.push((*address, master));
        }
        line
    }

    /// A complete ring.
    pub fn complete(addresses: &[u8]) -> Self {
        let mut line = Self::new(addresses);
        line.becomes_complete(addresses, Bounds::of(addresses).begin(addresses.len())).unwrap();
        line
    }

    /// A ring at the time at which it becomes complete.
    pub fn just_complete(addresses: &[u8]) -> Self {
        let mut line = Self::new(addresses);
        line.until_known(addresses);
        line
    }

    /// Runs until each of these masters knows the ring.
    pub fn until_known(&mut self, addresses: &[u8]) {
        let end = self.segment.now() + Bounds::of(addresses).begin(addresses.len());
        while !addresses.iter().all(|address| self.master(*address).masters().count() == addresses.len()) {
            assert!(self.segment.now() < end, "no ring of {addresses:?}");
            self.segment.run_for(100).unwrap();
        }
    }

    /// Ignores violations of the token rules for `tbit` bit times.
    pub fn without_token_rules(&mut self, tbit: u64) {
        TOKEN_RULES.into_iter().for_each(|rule| self.segment.allow(rule));
        self.segment.run_for(tbit).unwrap();
        TOKEN_RULES.into_iter().for_each(|rule| self.segment.disallow(rule));
    }

    /// The present holder of the token; `None` while the token is on the line.
    pub fn holder(&self) -> Option<u8> {
        self.masters.iter().map(|(address, _)| *address).find(|address| self.master(*address).has_token())
    }

    pub fn handle(&self, address: u8) -> StationHandle<Master> {
        let found = self.masters.iter().find(|(other, _)| *other == address);
        found.expect("a master of this line").1
    }

    pub fn master(&self, address: u8) -> &Master {
        self.segment.station(self.handle(address))
    }

    /// Switches on a further master.
    pub fn add(&mut self, address: u8) {
        self.segment.attach(Slave::<_>::new(Plain::new(), slave_of(address), BAUD));
        let master = self.segment.attach(master(address, self.segment.now()));
        self.masters.push((address, master));
    }

    pub fn switch_off(&mut self, address: u8) {
        self.segment.inject(Fault::Power(self.handle(address).id(), false));
    }

    /// Switches on a master again, with its initial state.
    pub fn switch_on(&mut self, address: u8) {
        let handle = self.handle(address);
        *self.segment.station_mut(handle) = master(address, self.segment.now());
        self.segment.inject(Fault::Power(handle.id(), true));
    }

    /// Asserts that the ring consists of `addresses` within `bound_tbit` and remains so: the referee checks every token of the
    /// next rotations, each master knows all others, and each master gets answers from its slave.
    pub fn becomes_complete(&mut self, addresses: &[u8], bound_tbit: u64) -> Result<(), Box<Violation>> {
        self.segment.run_for(bound_tbit)?;
        self.stays_complete(addresses)
    }

    pub fn stays_complete(&mut self, addresses: &[u8]) -> Result<(), Box<Violation>> {
        self.segment.expect_ring(addresses, self.segment.now());
        let before = self.answers(addresses);
        self.segment.run_for(4 * Bounds::of(addresses).rotation)?;
        let after = self.answers(addresses);
        self.segment.expect_ring(&[], self.segment.now());
        for (index, address) in addresses.iter().enumerate() {
            let master = self.master(*address);
            assert_eq!(master.ring_state(), RingState::InRing, "{address} {}", self.segment.trace());
            let known: Vec<u8> = master.masters().collect();
            let mut all = addresses.to_vec();
            all.sort_unstable();
            assert_eq!(known, all, "the ring as {address} knows it");
            assert!(after[index] >= before[index] + 3, "{address} got {} answers", after[index] - before[index]);
        }
        Ok(())
    }

    pub fn answers(&self, addresses: &[u8]) -> Vec<u32> {
        addresses.iter().map(|address| self.master(*address).user.answered).collect()
    }
}
