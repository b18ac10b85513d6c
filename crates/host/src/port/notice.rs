//! What somebody should know about a port although it works.

use std::collections::VecDeque;
use std::fmt;
use std::path::PathBuf;

/// A remark of a port. Its text says what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notice {
    /// A USB adapter keeps what it hears for a while, and may not be told otherwise.
    Latency {
        /// The port.
        name: String,
        /// For how long, in milliseconds.
        ms: u32,
        /// Where the system keeps that number.
        setting: PathBuf,
    },
    /// The kernel does not switch the transmitter of this device on and off.
    TransmitterNotSwitched(String),
    /// The other side does not read. What it did not take is lost to it, as on a line.
    OctetsDropped {
        /// Who does not read.
        name: String,
        /// How many octets were cut off so far.
        octets: usize,
    },
    /// What a virtual device had stored is damaged, and it begins with its defaults.
    StoreDamaged {
        /// The device.
        device: String,
        /// The setting of its address switch.
        address: u8,
        /// Where the damaged file is now.
        kept_as: PathBuf,
    },
    /// The port is gone and is looked for.
    Lost(String),
    /// It is there again.
    Reopened(String),
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Latency { name, ms, setting } => write!(
                f,
                "{name} keeps what it hears for {ms} ms: `echo 1 | sudo tee {}` lets answers in at once, until it is \
                 unplugged",
                setting.display()
            ),
            Self::TransmitterNotSwitched(name) => write!(
                f,
                "the kernel does not switch the transmitter of {name}: its RS-485 adapter has to do so by itself"
            ),
            Self::OctetsDropped { name, octets } => {
                write!(f, "{name} does not read what it is sent: {octets} octets were cut off so far")
            }
            Self::StoreDamaged { device, address: place, kept_as: aside } => write!(
                f,
                "the memory of {device} at address {place} is damaged: kept as {}, defaults used",
                aside.display()
            ),
            Self::Lost(name) => {
                write!(f, "lost {name}: it was unplugged, or its other side was closed; looking for it")
            }
            Self::Reopened(name) => write!(f, "{name} is back"),
        }
    }
}

/// So many remarks wait for somebody to ask for them; of more the oldest are forgotten.
const MAX_NOTICES: usize = 16;

/// Remarks that wait for somebody to ask for them.
#[derive(Clone, Debug, Default)]
pub struct Notices(VecDeque<Notice>);

impl Notices {
    /// The oldest.
    pub fn next(&mut self) -> Option<Notice> {
        self.0.pop_front()
    }
}

impl Extend<Notice> for Notices {
    fn extend<T: IntoIterator<Item = Notice>>(&mut self, remarks: T) {
        self.0.extend(remarks);
        self.0.drain(..self.0.len().saturating_sub(MAX_NOTICES));
    }
}

/// Octets that nobody took, counted and told once for each time the other side stops to read.
#[derive(Clone, Debug, Default)]
pub struct DropCounter {
    octets: usize,
    /// The other side has not taken anything since that was told.
    is_blocked: bool,
}

impl DropCounter {
    /// The other side took `taken` of `octets` octets. Returns what there is to tell.
    pub fn sent(&mut self, name: &str, octets: usize, taken: usize) -> Option<Notice> {
        let cut = octets.saturating_sub(taken);
        self.octets = self.octets.saturating_add(cut);
        let is_news = cut > 0 && !self.is_blocked;
        self.is_blocked = cut > 0;
        is_news.then(|| Notice::OctetsDropped { name: name.to_owned(), octets: self.octets })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_cut_is_counted_and_told_once_for_each_time() {
        let mut cuts = DropCounter::default();
        let told = |octets| Some(Notice::OctetsDropped { name: "a".to_owned(), octets });
        assert_eq!(cuts.sent("a", 6, 6), None);
        assert_eq!(cuts.sent("a", 6, 2), told(4));
        assert_eq!(cuts.sent("a", 6, 0), None);
        assert_eq!(cuts.sent("a", 6, 6), None);
        assert_eq!(cuts.sent("a", 9, 8), told(11));
    }

    #[test]
    fn remarks_nobody_asks_for_do_not_pile_up() {
        let mut remarks = Notices::default();
        remarks.extend((0..20).map(|number| Notice::Reopened(number.to_string())));
        let left: Vec<_> = std::iter::from_fn(|| remarks.next()).collect();
        assert_eq!((left.len(), &left[0]), (MAX_NOTICES, &Notice::Reopened("4".to_owned())));
    }

    #[test]
    fn a_remark_says_what_to_do() {
        let setting = PathBuf::from("/sys/class/tty/ttyUSB0/device/latency_timer");
        let text = Notice::Latency { name: "/dev/ttyUSB0".to_owned(), ms: 16, setting }.to_string();
        assert!(text.contains("16 ms: `echo 1 | sudo tee /sys/class/tty/ttyUSB0/device/latency_timer`"), "{text}");
    }
}
