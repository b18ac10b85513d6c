//! Conditions of a port that the user should know although the port works.

use profivac_dp::link::Baud;
use std::collections::VecDeque;
use std::fmt;
use std::path::PathBuf;

/// A condition of a port or of the store of a device that is no error. The text says what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Notice {
    /// A USB adapter delays received octets, and the delay cannot be lowered without privileges.
    Latency {
        /// The port.
        name: String,
        /// The delay in milliseconds.
        ms: u32,
        /// The file in which the system keeps the delay.
        setting: PathBuf,
    },
    /// Another program that respects no lock has the device open.
    OpenElsewhere {
        /// The port.
        name: String,
        /// The name of the program.
        program: String,
        /// The number of its process.
        pid: u32,
    },
    /// The kernel does not switch the transmitter of this device.
    TransmitterNotSwitched(String),
    /// The other side does not read. Octets that it does not take are dropped, as on a line.
    OctetsDropped {
        /// The other side.
        name: String,
        /// The octets dropped so far.
        octets: usize,
    },
    /// An answer came after the slot time of this master.
    LateAnswer {
        /// The port.
        name: String,
        /// From the end of the request to the first character of the answer, in milliseconds.
        turnaround_ms: u64,
        /// The slot time, in bit times.
        slot_tbit: u32,
        /// The slot time that this answer needs, in bit times.
        needed_tbit: u32,
        /// What follows.
        remedy: LateAnswerRemedy,
    },
    /// Stored values of a virtual device are not used; the device starts with its defaults in their place.
    StoreDamaged {
        /// The device.
        device: String,
        /// The setting of its address switch.
        address: u8,
        /// Why they are not used.
        damage: StoreDamage,
        /// The name under which the file is kept.
        kept_as: PathBuf,
    },
    /// A server has as many clients as it serves, and closed the connection of one more.
    ClientRefused {
        /// The client.
        name: String,
        /// The most clients.
        most: usize,
    },
    /// A program has closed its side of a pty, and the system refuses what the next program needs. The server tries again.
    PtyNotReady {
        /// The path of the pty.
        name: String,
        /// The error of the system.
        reason: String,
    },
    /// A server at a `tcp://` port begins with commands of telnet.
    TelnetServer(String),
    /// A server at a `tcp://` port sends each FF twice, as telnet does.
    DoubledFf(String),
    /// A server at a `telnet://` or `rfc2217://` port does not answer the commands of telnet.
    NoTelnetServer(String),
    /// A server that speaks telnet refuses binary transmission.
    NotBinary(String),
    /// A server begins with words, which no line does.
    ServerBanner {
        /// The port.
        name: String,
        /// The words.
        words: String,
    },
    /// A serial server does not let this program set its rate and parity.
    NoPortControl(String),
    /// A serial server runs at another rate than the one that it was told.
    ServerRate {
        /// The port.
        name: String,
        /// Its rate in bit/s.
        rate: u32,
        /// The rate of the line.
        baud: Baud,
    },
    /// A serial server does not use even parity.
    ServerParity(String),
    /// A program has set another rate on its side of a pty than the line has.
    PtyRate {
        /// The path of the pty.
        name: String,
        /// The rate of the program in bit/s.
        rate: u32,
        /// The rate of the line.
        baud: Baud,
    },
    /// The port is lost; attempts to open it again have begun.
    Lost(String),
    /// The port is open again.
    Reopened(String),
}

/// What follows from a late answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LateAnswerRemedy {
    /// This master uses the needed slot time from now on.
    Raised,
    /// The user must set the slot time: other masters are on the line, or the user gave the present one.
    ToBeSet,
    /// No slot time of PROFIBUS is as long.
    Impossible,
}

/// Why stored values of a virtual device are not used.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StoreDamage {
    /// The file was altered or is not complete.
    Damaged,
    /// The file belongs to the device of this name.
    OtherDevice(String),
    /// The device does not take this number of values.
    Refused(usize),
}

impl fmt::Display for Notice {
    /// The condition, and behind a colon the remedy.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let found = self.found();
        match self.remedy() {
            Some(remedy) => write!(f, "{found}: {remedy}"),
            None => f.write_str(&found),
        }
    }
}

impl Notice {
    /// What the user can do, if there is something.
    #[must_use]
    pub fn remedy(&self) -> Option<String> {
        match self {
            Self::Latency { setting, .. } => Some(format!(
                "install setserial, with which every user of the port may set 1 ms, or run `echo 1 | sudo tee {}`, which holds until the \
                 adapter is unplugged",
                setting.display()
            )),
            Self::OpenElsewhere { .. } => Some("end it if stations seem not to answer".to_owned()),
            Self::PtyNotReady { .. } => Some(
                "profivac tries again; check that the folder takes new files and that the limit of open files (`ulimit -n`) is not reached"
                    .to_owned(),
            ),
            Self::TransmitterNotSwitched(_) => Some("its RS-485 adapter must switch it by itself".to_owned()),
            Self::LateAnswer { remedy, needed_tbit, .. } => remedy.text(*needed_tbit),
            Self::TelnetServer(name) | Self::DoubledFf(name) => {
                let address = name.trim_start_matches("tcp://");
                Some(format!("use telnet://{address}, or rfc2217://{address}, which also sets its rate and 8E1"))
            }
            Self::NoTelnetServer(name) => {
                let address = name.split_once("://").map_or(name.as_str(), |(_, address)| address);
                Some(format!("if it passes raw octets, use tcp://{address}"))
            }
            Self::NotBinary(_) => Some("switch on binary transmission in the server, or use a port for raw octets".to_owned()),
            Self::ServerBanner { .. } => {
                Some("switch off its banner and its login, or use the port on which it passes raw octets".to_owned())
            }
            Self::NoPortControl(_) | Self::ServerRate { .. } | Self::ServerParity(_) => {
                Some("set the rate of the bus, 8 data bits, even parity and 1 stop bit in the server".to_owned())
            }
            Self::PtyRate { baud, .. } => Some(format!(
                "a pty works at any rate, a serial port only at the rate of the bus: set {} in the program, and look whether its language has \
                 this rate",
                baud.bits_per_second()
            )),
            Self::OctetsDropped { .. }
            | Self::StoreDamaged { .. }
            | Self::ClientRefused { .. }
            | Self::Lost(_)
            | Self::Reopened(_) => None,
        }
    }

    /// The sentence without the remedy.
    #[must_use]
    pub fn found(&self) -> String {
        match self {
            Self::Latency { name, ms, .. } => {
                format!("{name} delays received octets by up to {ms} ms, so everything takes longer")
            }
            Self::OpenElsewhere { name, program, pid } => {
                format!("{program} (process {pid}) has {name} open too and may take received octets away")
            }
            Self::TransmitterNotSwitched(name) => {
                format!("the kernel does not switch the transmitter of {name}")
            }
            Self::OctetsDropped { name, octets } => {
                format!("{name} does not read: {octets} octets have been discarded so far")
            }
            Self::LateAnswer { name, turnaround_ms, slot_tbit, needed_tbit, remedy } => {
                let raised = match remedy {
                    LateAnswerRemedy::Raised => format!(": the slot time is {needed_tbit} bit times from now on"),
                    LateAnswerRemedy::ToBeSet | LateAnswerRemedy::Impossible => String::new(),
                };
                format!(
                    "an answer on {name} came {turnaround_ms} ms after its request, later than the slot time of {slot_tbit} bit \
                     times{raised}"
                )
            }
            Self::StoreDamaged { device, address, damage, kept_as } => {
                let kept_as = kept_as.display();
                format!("the nonvolatile memory of {device} at address {address} {}", damage.text(&kept_as))
            }
            Self::ClientRefused { name, most } => {
                format!(
                    "the connection of {name} was closed: the line has {most} clients already; end one of them first"
                )
            }
            Self::PtyNotReady { name, reason } => format!("{name} is not ready for the next program ({reason})"),
            Self::TelnetServer(name) => format!("the server at {name} speaks telnet, which changes octets of the line"),
            Self::DoubledFf(name) => {
                format!("the server at {name} sends FF twice, as telnet does, so telegrams with this octet are damaged")
            }
            Self::NoTelnetServer(name) => format!("the server at {name} does not answer in telnet"),
            Self::NotBinary(name) => {
                format!("the server at {name} refuses binary transmission and may change octets of the line")
            }
            Self::ServerBanner { name, words } => format!("the server at {name} begins with words: '{words}'"),
            Self::NoPortControl(name) => format!("the server at {name} does not let the rate be set from here"),
            Self::ServerRate { name, rate, baud } => {
                format!("the server at {name} runs at {rate} bit/s and not at {}", baud.bits_per_second())
            }
            Self::ServerParity(name) => format!("the server at {name} does not use even parity"),
            Self::PtyRate { name, rate, baud } => {
                format!("the program at {name} has set {rate} bit/s, and the line has {}", baud.bits_per_second())
            }
            Self::Lost(name) => {
                format!("lost {name}: it was unplugged, or its other side was closed; profivac tries to open it again")
            }
            Self::Reopened(name) => format!("{name} is open again"),
        }
    }
}

impl LateAnswerRemedy {
    fn text(self, needed_tbit: u32) -> Option<String> {
        match self {
            Self::Raised => None,
            Self::Impossible => {
                Some("no slot time of PROFIBUS is as long; use an adapter with less delay, or a lower rate".to_owned())
            }
            Self::ToBeSet => Some(format!(
                "it may count as no answer; set the slot time of each master on the line to at least {needed_tbit} bit times"
            )),
        }
    }
}

impl StoreDamage {
    fn text(&self, kept_as: &dyn fmt::Display) -> String {
        match self {
            Self::Damaged => format!("is damaged; it was renamed to {kept_as}, and the device has default values"),
            Self::OtherDevice(other) => {
                format!("is the memory of a {other}; it was renamed to {kept_as}, and the device has default values")
            }
            Self::Refused(count) => format!(
                "has values that the device does not take ({count}); it was kept as {kept_as}, and these values have their defaults"
            ),
        }
    }
}

/// The longest queue. When it is full, the oldest notice is dropped.
const MAX_NOTICES: usize = 16;

/// Notices that nothing has read yet.
#[derive(Clone, Debug, Default)]
pub struct Notices(VecDeque<Notice>);

impl Notices {
    /// Takes the oldest notice.
    pub fn next(&mut self) -> Option<Notice> {
        self.0.pop_front()
    }
}

impl Extend<Notice> for Notices {
    fn extend<T: IntoIterator<Item = Notice>>(&mut self, notices: T) {
        self.0.extend(notices);
        self.0.drain(..self.0.len().saturating_sub(MAX_NOTICES));
    }
}

/// Counts octets that the other side did not take. Reports them once each time the other side stops reading.
#[derive(Clone, Debug, Default)]
pub struct DropCounter {
    octets: usize,
    /// The other side has taken nothing since the last notice.
    is_blocked: bool,
}

impl DropCounter {
    /// The other side took `taken` of `octets` octets. Returns a notice if it has just stopped reading.
    pub fn sent(&mut self, name: &str, octets: usize, taken: usize) -> Option<Notice> {
        let dropped = octets.saturating_sub(taken);
        self.octets = self.octets.saturating_add(dropped);
        let is_new = dropped > 0 && !self.is_blocked;
        self.is_blocked = dropped > 0;
        is_new.then(|| Notice::OctetsDropped { name: name.to_owned(), octets: self.octets })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dropped_octets_are_counted_and_reported_once_for_each_time_the_reader_stops() {
        let mut drops = DropCounter::default();
        let notice = |octets| Some(Notice::OctetsDropped { name: "a".to_owned(), octets });
        assert_eq!(drops.sent("a", 6, 6), None);
        assert_eq!(drops.sent("a", 6, 2), notice(4));
        assert_eq!(drops.sent("a", 6, 0), None);
        assert_eq!(drops.sent("a", 6, 6), None);
        assert_eq!(drops.sent("a", 9, 8), notice(11));
    }

    #[test]
    fn the_queue_keeps_the_newest_notices() {
        let mut notices = Notices::default();
        notices.extend((0..20).map(|number| Notice::Reopened(number.to_string())));
        let left: Vec<_> = std::iter::from_fn(|| notices.next()).collect();
        assert_eq!((left.len(), &left[0]), (MAX_NOTICES, &Notice::Reopened("4".to_owned())));
    }

    #[test]
    fn a_late_answer_has_a_remedy_unless_the_master_has_raised_its_slot_time() {
        let late = |remedy| Notice::LateAnswer {
            name: "a".to_owned(),
            turnaround_ms: 7,
            slot_tbit: 100,
            needed_tbit: 200,
            remedy,
        };
        let raised = late(LateAnswerRemedy::Raised);
        assert_eq!(raised.remedy(), None);
        assert!(raised.to_string().ends_with("bit times: the slot time is 200 bit times from now on"), "{raised}");
        let to_be_set = late(LateAnswerRemedy::ToBeSet);
        assert!(
            to_be_set.to_string().contains("100 bit times: it may count as no answer; set the slot time"),
            "{to_be_set}"
        );
        assert!(to_be_set.found().ends_with("the slot time of 100 bit times"), "{}", to_be_set.found());
    }

    #[test]
    fn a_notice_says_what_to_do() {
        let setting = PathBuf::from("/sys/class/tty/ttyUSB0/device/latency_timer");
        let text = Notice::Latency { name: "/dev/ttyUSB0".to_owned(), ms: 16, setting }.to_string();
        assert!(
            text.contains("16 ms, so")
                && text.contains("or run `echo 1 | sudo tee /sys/class/tty/ttyUSB0/device/latency_timer`"),
            "{text}"
        );
    }
}
