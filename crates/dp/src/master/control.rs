//! Global_Control: commands to all slaves or to groups. profibus-wire 2.9.
//!
//! The master sends the mode at every change and then repeatedly. It can keep groups in Clear while the others operate. Sync,
//! Freeze and their opposites are commands: the master sends each once, because a second Sync would apply further outputs. No
//! slave acknowledges them; the diagnosis shows their effect (Sync_Mode, Freeze_Mode, Not_Supported).

use super::{Master, Mode, Pending};
use crate::link::BitTime;
use crate::link::active::Request;
use core::fmt;
use heapless::Deque;
use profivac_wire::control::Function;
use profivac_wire::global::{ControlCommand, GlobalControl};
use profivac_wire::sap::MASTER_MS0;
use profivac_wire::{BROADCAST, Sap};

/// The most commands that can wait.
pub const MAX_PENDING_COMMANDS: usize = 8;

/// The reason why the master did not accept a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ControlError {
    /// [`MAX_PENDING_COMMANDS`] commands are waiting already.
    Full,
    /// No slave exchanges data, so none would execute the command.
    NoSlaveExchanging,
    /// The command has other bits than Sync, Unsync, Freeze and Unfreeze, or none.
    InvalidCommand(ControlCommand),
}

impl fmt::Display for ControlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full => write!(f, "{MAX_PENDING_COMMANDS} commands are waiting to be sent already"),
            Self::NoSlaveExchanging => f.write_str("no slave exchanges data, so none would execute it"),
            Self::InvalidCommand(command) => {
                write!(f, "control command {:02X} is not made of Sync, Unsync, Freeze and Unfreeze", command.bits())
            }
        }
    }
}

impl core::error::Error for ControlError {}

/// A Global_Control telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ControlMessage {
    /// The mode, to all slaves.
    Mode,
    /// Clear, to the groups that are kept in it.
    Cleared,
    /// The oldest command.
    Command,
}

/// A command that waits.
#[derive(Clone, Copy, Debug)]
struct PendingCommand {
    control: GlobalControl,
    /// The beginning of the first cycle after the call. The command is sent once every selected slave has exchanged data since.
    since: Option<BitTime>,
}

/// All Global_Control telegrams that wait.
#[derive(Clone, Debug)]
pub(super) struct Controls {
    /// The mode has changed, a slave has entered data exchange, or the repetition is due.
    pub(super) mode_due: bool,
    cleared_due: bool,
    /// The number of commands that may be sent now.
    ready: usize,
    commands: Deque<PendingCommand, MAX_PENDING_COMMANDS>,
    /// The groups that are kept in Clear.
    cleared: u8,
}

impl Controls {
    pub(super) const fn new() -> Self {
        Self { mode_due: false, cleared_due: false, ready: 0, commands: Deque::new(), cleared: 0 }
    }

    /// Whether slaves of this group get safe outputs in every mode.
    #[inline]
    pub(super) const fn is_cleared(&self, group: u8) -> bool {
        self.cleared & group != 0
    }

    /// The next telegram.
    #[inline]
    pub(super) fn next(&mut self) -> Option<ControlMessage> {
        if core::mem::take(&mut self.mode_due) {
            self.cleared_due = self.cleared != 0;
            Some(ControlMessage::Mode)
        } else if core::mem::take(&mut self.cleared_due) {
            Some(ControlMessage::Cleared)
        } else {
            (self.ready > 0).then_some(ControlMessage::Command)
        }
    }

    /// Confirms a telegram. It has no answer, so only whether it was sent matters.
    pub(super) fn confirmed(&mut self, message: ControlMessage, sent: bool) {
        match (message, sent) {
            (ControlMessage::Command, true) => {
                self.ready = self.ready.saturating_sub(1);
                self.commands.pop_front();
            }
            (ControlMessage::Mode, false) => self.mode_due = true,
            (ControlMessage::Cleared, false) => self.cleared_due = true,
            (ControlMessage::Command, false) | (ControlMessage::Mode | ControlMessage::Cleared, true) => {}
        }
    }

    /// The data unit.
    fn message(&self, message: ControlMessage, mode: Mode) -> Option<GlobalControl> {
        Some(match (message, mode) {
            (ControlMessage::Mode, Mode::Operate) => GlobalControl { command: ControlCommand::empty(), group: 0 },
            (ControlMessage::Mode, Mode::Clear | Mode::Stop) => {
                GlobalControl { command: ControlCommand::CLEAR_DATA, group: 0 }
            }
            (ControlMessage::Cleared, _) => GlobalControl { command: ControlCommand::CLEAR_DATA, group: self.cleared },
            (ControlMessage::Command, _) => self.commands.front()?.control,
        })
    }

    /// Drops all commands: no slave exchanges data.
    pub(super) fn forget(&mut self) {
        self.commands.clear();
        self.ready = 0;
    }
}

impl<const SLAVES: usize, const OCTETS: usize, const EVENTS: usize, const ACYCLIC: usize>
    Master<SLAVES, OCTETS, EVENTS, ACYCLIC>
{
    /// Sends Sync, Unsync, Freeze or Unfreeze, or a pair of them, to the slaves of a group; `group` 0 is all slaves.
    ///
    /// The master sends it between two cycles, as soon as every slave of the group has exchanged data in a cycle that began
    /// after this call. So Sync applies the outputs as they are now at all slaves at once, and the inputs that Freeze samples
    /// come with the next cycle.
    ///
    /// # Errors
    /// [`ControlError`]; nothing is sent.
    pub fn control(&mut self, command: ControlCommand, group: u8) -> Result<(), ControlError> {
        let pairs = ControlCommand::SYNC | ControlCommand::UNSYNC | ControlCommand::FREEZE | ControlCommand::UNFREEZE;
        if command.is_empty() || !pairs.contains(command) {
            return Err(ControlError::InvalidCommand(command));
        }
        if self.mode == Mode::Stop || self.exchanging == 0 {
            return Err(ControlError::NoSlaveExchanging);
        }
        let waiting = PendingCommand { control: GlobalControl { command, group }, since: None };
        self.controls.commands.push_back(waiting).map_err(|_| ControlError::Full)
    }

    /// The number of commands that wait. The master drops them when no slave exchanges data any more.
    pub fn pending_commands(&self) -> usize {
        self.controls.commands.len()
    }

    /// Keeps the slaves of these groups, one per bit, in Clear while the mode is [`Mode::Operate`]. The master sends them Clear
    /// at once and then as often as the mode, and safe outputs in every exchange.
    pub const fn set_cleared_groups(&mut self, groups: u8) {
        self.controls.cleared = groups;
        self.controls.mode_due = true;
    }

    /// The groups that the master keeps in Clear.
    pub const fn cleared_groups(&self) -> u8 {
        self.controls.cleared
    }

    /// A cycle begins: determines the commands that may be sent before it.
    pub(super) fn prepare_controls(&mut self, now: BitTime) {
        if self.exchanging == 0 {
            self.controls.forget();
        }
        let waiting = |waiting: &PendingCommand| {
            waiting.since.is_some_and(|since| self.all_exchanged_since(since, Some(waiting.control)))
        };
        self.controls.ready = self.controls.commands.iter().take_while(|command| waiting(command)).count();
        for command in &mut self.controls.commands {
            command.since.get_or_insert(now);
        }
    }

    /// Whether every slave in data exchange that `control` selects has exchanged data since then.
    pub(super) fn all_exchanged_since(&self, since: BitTime, control: Option<GlobalControl>) -> bool {
        let concerned = |group| control.is_none_or(|control| control.selects(group));
        self.slaves.iter().filter(|slave| slave.is_exchanging() && concerned(slave.group)).all(|slave| {
            let at = slave.exchanged_at();
            at.is_some_and(|at| at > since)
        })
    }

    /// The next Global_Control, if one waits and a slave exchanges data.
    #[inline]
    pub(super) fn next_control(&mut self) -> Option<Pending> {
        if self.exchanging == 0 {
            return None;
        }
        self.controls.next().map(Pending::Control)
    }

    /// The request. Global_Control goes to all stations; its group selects the slaves.
    pub(super) fn global_control(&mut self, message: ControlMessage) -> Option<Request<'_>> {
        let length = self.controls.message(message, self.mode)?.emit(&mut self.du).ok()?;
        Some(Request {
            da: BROADCAST,
            function: Function::SdnHigh,
            dsap: Sap::GlobalControl.to_octet(),
            ssap: Some(MASTER_MS0),
            du: self.du.get(..length)?,
        })
    }
}
