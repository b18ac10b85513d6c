//! MS1 and MS2 as `docs/spec` describes them. profibus-wire 4 and 5.

use crate::slave_model::model::{DL, Model, RR, RS, Reply, Request, State, TEN_MS};
use crate::slave_model::process::{Process, Refusal, Via};

/// The shortest Send_Timeout at 1.5 Mbit/s, in units of 10 ms. Section 4.6.2.
const MIN_SEND_TIMEOUT: u16 = 100;
/// The SAP of the first connection; the others follow downwards. Section 4.6.
const FIRST_SAP: u8 = 48;
/// Max_Initiate_PDU_Length of section 4.6.3.
const LONGEST_INITIATE: usize = 52;
/// FI_Index of I&M0. Section 5.2.
const IM0: [u8; 2] = [0xFD, 0xE8];

/// The post box of section 4.2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Job {
    Idle,
    /// The device executes the request until this moment.
    Executing(u64, Vec<u8>),
    /// The response waits for a poll.
    Ready(Vec<u8>),
}

/// A server SAP of MS2. Section 4.10.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Connection {
    Free,
    Bound {
        sa: u8,
        ssap: u8,
        /// Send_Timeout in bit times.
        timeout: u64,
        deadline: u64,
        job: Job,
        /// The SAP is closed when the waiting response was fetched or its time is over.
        closing: bool,
        /// I&M0 was called on this connection.
        called: bool,
    },
}

impl Connection {
    /// The moment at which its timer expires.
    pub const fn deadline(&self) -> Option<u64> {
        match self {
            Self::Free => None,
            Self::Bound { deadline, .. } => Some(*deadline),
        }
    }
}

impl<P: Process> Model<P> {
    /// SAP 51. Sections 4.2 and 4.3.
    pub fn ms1(&mut self, now: u64, request: &Request) -> Reply {
        if !self.table.ms1 || !self.dpv1_enable || self.state != State::DataExch || request.sa != self.master {
            self.reach("MS1 closed");
            return RS;
        }
        self.finish(now, None);
        let pdu = request.du.as_slice();
        match (self.ms1.clone(), pdu) {
            (Job::Ready(response), []) => {
                self.reach("MS1 response fetched");
                self.ms1 = Job::Idle;
                Reply::Data(DL, response)
            }
            (_, []) => {
                self.reach("MS1 poll without response");
                Reply::Sc
            }
            (Job::Executing(..) | Job::Ready(_), _) => {
                self.reach("MS1 busy");
                RR
            }
            (Job::Idle, [0x5E | 0x5F, ..]) => {
                let (mut called, via) = (self.ms1_called, Via::Ms1);
                let (response, delay) = self.access(via, pdu, &mut called);
                self.ms1_called = called;
                self.ms1 = if delay == 0 { Job::Ready(response) } else { Job::Executing(now + delay, response) };
                Reply::Sc
            }
            (Job::Idle, _) => {
                self.reach("MS1 unknown function");
                self.leave();
                Reply::Sc
            }
        }
    }

    /// Read or Write: the response and how long it takes. Sections 4.1.1, 4.3 and 5.1.
    fn access(&mut self, via: Via, pdu: &[u8], called: &mut bool) -> (Vec<u8>, u64) {
        let function = pdu[0];
        let read = function == 0x5E;
        let refused = |refusal: Refusal| (Self::negative(function, refusal), 0);
        let (slot, index, length, data) = match *pdu {
            [_, slot, index, length, ref data @ ..] => (slot, index, length, data),
            _ => {
                self.reach("Read or Write too short");
                return refused(Refusal(0xB3, 0));
            }
        };
        let fits = if read { data.is_empty() } else { data.len() == usize::from(length) };
        if !fits || length == 0 || length > 240 {
            self.reach(if read { "Read with a wrong length" } else { "Write with a wrong length" });
            return refused(Refusal(0xB3, 0));
        }
        let result = if index == 255 {
            self.im0(slot, read, data, called).map(|record| (record, 0))
        } else if read {
            self.process.read(&self.table, via, slot, index)
        } else {
            self.process.write(&self.table, via, slot, index, data).map(|delay| (Vec::new(), delay))
        };
        match result {
            Err(refusal) => {
                self.reach(match refusal.0 {
                    0xB0 => "invalid index",
                    0xB1 => "write length",
                    0xB2 => "invalid slot",
                    0xB5 => "state conflict",
                    0xB6 => "access denied",
                    0xB7 => "invalid range",
                    0xB8 => "invalid parameter",
                    _ => "error of the device",
                });
                refused(refusal)
            }
            Ok((mut record, delay)) if read => {
                if record.len() > usize::from(length) {
                    self.reach("Read truncated");
                }
                self.reach(match via {
                    Via::Ms1 => "MS1 Read",
                    Via::Ms2 => "MS2 Read",
                });
                record.truncate(usize::from(length));
                let length = u8::try_from(record.len()).expect("240 at most");
                ([&[0x5E, slot, index, length], record.as_slice()].concat(), delay)
            }
            Ok((_, delay)) => {
                self.reach(match via {
                    Via::Ms1 => "MS1 Write",
                    Via::Ms2 => "MS2 Write",
                });
                (vec![0x5F, slot, index, length], delay)
            }
        }
    }

    /// Index 255: Call and I&M0. Section 5.1.
    fn im0(&mut self, slot: u8, read: bool, data: &[u8], called: &mut bool) -> Result<Vec<u8>, Refusal> {
        let Some(im0) = self.table.im0 else { return Err(self.process.no_im0(&self.table, slot, read)) };
        // open(10): a Write to index 255 that is refused forgets the Call before it.
        *called &= read;
        if slot != 0 {
            return Err(Refusal(0xB2, 0));
        }
        if read {
            if !*called {
                self.reach("I&M0 without Call");
                return Err(Refusal(0xB5, 0));
            }
            self.reach("I&M0 read");
            return Ok([&[8, 0, IM0[0], IM0[1]], im0.as_slice()].concat());
        }
        match *data {
            [extended, ..] if extended != 8 => Err(Refusal(0xB8, 0)),
            [8, 0, high, low] if [high, low] == IM0 => {
                self.reach("Call");
                *called = true;
                Ok(Vec::new())
            }
            [8, 0, high, low, ..] if [high, low] != IM0 => Err(Refusal(0xB0, 0)),
            _ => Err(Refusal(0xB6, 0)),
        }
    }

    /// A job of a connection, or of MS1, is finished when its time is over.
    fn finish(&mut self, now: u64, connection: Option<usize>) {
        let job = match connection {
            None => &mut self.ms1,
            Some(position) => match &mut self.connections[position] {
                Connection::Bound { job, .. } => job,
                Connection::Free => return,
            },
        };
        if let Job::Executing(until, response) = job
            && *until <= now
        {
            *job = Job::Ready(std::mem::take(response));
        }
    }

    /// SAP 49 and the server SAPs. Sections 4.6 to 4.10.
    pub fn ms2(&mut self, now: u64, request: &Request, dsap: u8, ssap: u8) -> Reply {
        if !self.table.ms2 {
            self.reach("MS2 closed");
            return RS;
        }
        if dsap == FIRST_SAP + 1 {
            return self.resource_manager(now, request, ssap);
        }
        let position = usize::from(FIRST_SAP.abs_diff(dsap));
        let bound = self.connections.get(position).cloned();
        let Some(Connection::Bound { sa, ssap: bound_ssap, timeout, mut job, mut closing, mut called, .. }) = bound
        else {
            self.reach("server SAP closed");
            return RS;
        };
        if (sa, bound_ssap) != (request.sa, ssap) {
            self.reach("server SAP of another master");
            return RS;
        }
        if let Job::Executing(until, response) = &job
            && *until <= now
        {
            job = Job::Ready(response.clone());
        }
        let Connection::Bound { mut deadline, .. } = self.connections[position] else { unreachable!() };
        let pdu = request.du.as_slice();
        let mut free = false;
        let reply = match (&job, pdu) {
            (Job::Ready(response), []) => {
                self.reach("MS2 response fetched");
                let response = response.clone();
                free = closing;
                job = Job::Idle;
                deadline = now + 2 * timeout;
                Reply::Data(DL, response)
            }
            (_, []) => {
                self.reach("MS2 poll without response");
                Reply::Sc
            }
            (job_now, [0x58, ..]) => {
                self.reach(match job_now {
                    Job::Idle => "Abort",
                    Job::Executing(..) => "Abort while the device executes",
                    Job::Ready(_) => "Abort while a response waits",
                });
                free = true;
                Reply::Sc
            }
            (Job::Executing(..) | Job::Ready(_), _) => {
                self.reach("MS2 busy");
                RR
            }
            (Job::Idle, [0x5E | 0x5F, ..]) => {
                let (response, delay) = self.access(Via::Ms2, pdu, &mut called);
                job = if delay == 0 { Job::Ready(response) } else { Job::Executing(now + delay, response) };
                deadline = now + timeout;
                Reply::Sc
            }
            (Job::Idle, [0x51, rest @ ..]) => {
                self.reach("Data_Transport");
                job = Job::Ready(Self::negative(0x51, Self::data_transport(rest)));
                deadline = now + timeout;
                Reply::Sc
            }
            (Job::Idle, [0x48, ..]) => {
                self.reach("Idle");
                job = Job::Ready(pdu.to_vec());
                deadline = now + timeout;
                Reply::Sc
            }
            (Job::Idle, _) => {
                self.reach("MS2 unknown function");
                job = Job::Ready(vec![0x58, 0x00, 0x12]);
                closing = true;
                deadline = now + timeout;
                Reply::Sc
            }
        };
        self.connections[position] = if free {
            Connection::Free
        } else {
            Connection::Bound { sa, ssap, timeout, deadline, job, closing, called }
        };
        reply
    }

    /// A device without Data_Transport refuses it; a wrong length comes first. Section 4.10.
    fn data_transport(rest: &[u8]) -> Refusal {
        match rest {
            [_, _, length, data @ ..] if *length != 0 && usize::from(*length) == data.len() => Refusal(0xA9, 0),
            _ => Refusal(0xB3, 0),
        }
    }

    /// SAP 49. Sections 4.6.1 to 4.6.5.
    fn resource_manager(&mut self, now: u64, request: &Request, ssap: u8) -> Reply {
        let Some(position) = self.connections.iter().position(|it| *it == Connection::Free) else {
            self.reach("no free connection");
            return RS;
        };
        let pdu = request.du.as_slice();
        let [high, low] = MIN_SEND_TIMEOUT.to_be_bytes();
        let sap = FIRST_SAP - u8::try_from(position).expect("49 at most");
        let answer = Reply::Data(DL, vec![0x56, sap, high, low]);
        if pdu.is_empty() {
            self.reach("poll of SAP 49");
            return Reply::Sc;
        }
        if pdu.len() > LONGEST_INITIATE {
            self.reach("Initiate too long");
            return RR;
        }
        if pdu[0] != 0x57 {
            self.reach("SAP 49 without Initiate");
            return answer;
        }
        let word = |position: usize| pdu.get(position..position + 2).map_or(0, |it| u16::from_be_bytes([it[0], it[1]]));
        let (response, closing) = match self.initiate(pdu) {
            Ok(response) => (response, false),
            Err(response) => (response, true),
        };
        // open(5): an Initiate that is answered by Abort does not lengthen the time. open(17): but one to another network does.
        let octets = |position: usize| pdu.get(position).map_or(0, |it| usize::from(*it));
        let whole = pdu.len() >= 20.max(16 + octets(13) + octets(15));
        let another_network = response == [0x58, 0x00, 0x17] && whole && octets(14) == 1;
        let asked = if response[0] == 0x58 && !another_network { 0 } else { word(4) };
        let timeout = u64::from(asked.max(MIN_SEND_TIMEOUT)) * TEN_MS;
        self.connections[position] = Connection::Bound {
            sa: request.sa,
            ssap,
            timeout,
            deadline: now + timeout,
            job: Job::Ready(response),
            closing,
            called: false,
        };
        answer
    }

    /// The response to an Initiate, or an Abort. Sections 4.6.3 to 4.6.5.
    fn initiate(&mut self, pdu: &[u8]) -> Result<Vec<u8>, Vec<u8>> {
        let address_error = vec![0x58, 0x00, 0x17];
        let format_error = vec![0x58, 0x00, 0x12];
        if pdu.len() < 16 {
            self.reach("Initiate too short");
            return Err(address_error);
        }
        let (s_type, s_len, d_type, d_len) = (pdu[12], pdu[13], pdu[14], pdu[15]);
        if (s_type == 0 && s_len != 2) || (d_type == 0 && d_len != 2) {
            self.reach("Initiate with a wrong address length");
            return Err(format_error);
        }
        // open(16): section 4.6.3 has no address of these types.
        if (s_type != 0 && s_len < 8) || (d_type != 0 && d_len < 8) || s_type > 1 || d_type > 1 {
            self.reach("Initiate with an odd address type");
            return Err(format_error);
        }
        if pdu.len() < 20 {
            self.reach("Initiate too short");
            return Err(address_error);
        }
        let (s_len_octets, d_len_octets) = (usize::from(s_len), usize::from(d_len));
        if pdu.len() < 16 + s_len_octets + d_len_octets {
            self.reach("Initiate shorter than its addresses");
            return Err(address_error);
        }
        if d_type != 0 {
            self.reach("Initiate to another network");
            return Err(address_error);
        }
        // open(2): the code of a refused address.
        if pdu[16 + s_len_octets..18 + s_len_octets] != [0, 0] {
            self.reach("Initiate to another application");
            return Err(Self::negative(0x57, Refusal(0xB8, 0)));
        }
        // open(8): the code of missing features.
        if pdu[6] & 1 == 0 {
            self.reach("Initiate without Read and Write");
            return Err(Self::negative(0x57, Refusal(0xA9, 0)));
        }
        self.reach("Initiate");
        let (s_addr, d_addr) = pdu[16..16 + s_len_octets + d_len_octets].split_at(s_len_octets);
        let mut response = vec![0x57, 240, 1, 0, 0, 0, 0, 0, d_type, d_len, s_type, s_len];
        response.extend(d_addr);
        response.extend(s_addr);
        Ok(response)
    }

    /// The timers of section 4.9.
    pub fn expire_connections(&mut self, now: u64) {
        for position in 0..self.connections.len() {
            while let Connection::Bound { deadline, timeout, job, closing, .. } = &mut self.connections[position]
                && *deadline <= now
            {
                // An Abort that waits is not followed by another one: section 4.8.
                if matches!(job, Job::Ready(pdu) if pdu[0] == 0x58) {
                    self.connections[position] = Connection::Free;
                    self.reach("connection closed by its timer");
                } else {
                    *job = Job::Ready(vec![0x58, 0x00, 0x13]);
                    *closing = true;
                    *deadline += *timeout;
                    self.reach("Abort TO");
                }
            }
        }
    }
}
