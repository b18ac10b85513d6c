//! The Channel Instance Selector: where several instances share a slot, it chooses the one that the slot shows.
//!
//! tira41d1 3.2.1.2, tira56e1 9.1.1: it is nonvolatile. So it is written only when another instance is needed, and once more at the
//! end.

use super::Gauge;
use crate::error::{ClientError, Operation};
use crate::names::NamedParameter;
use crate::records::{RecordError, Records, Unavailable, UnrestoredRecord, WriteEffect};
use crate::values::Value;
use profivac_devices::model::Role;

/// How often the selector is written when telegrams are lost.
const ATTEMPTS: usize = 3;

/// An instance number that no device uses: the selector must be read again.
const UNKNOWN: u8 = 0;

/// The Channel Instance Selector as far as it is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct SelectorState {
    /// The instance before this gauge moved the selector.
    original: u8,
    /// The present instance, or [`UNKNOWN`].
    current: u8,
    /// The instance that this gauge wrote last, if it did.
    written: Option<u8>,
}

/// A selector that a gauge has moved and not restored, for the next gauge of the same watcher.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldSelector {
    record: UnrestoredRecord,
}

impl HeldSelector {
    /// Restores the selector, unless another master has moved it since. If the line is lost, the next gauge at this address does.
    pub(crate) fn restore(self, mut records: impl Records) -> Result<(), RecordError> {
        restore_record(&mut records, self.record)
    }
}

/// Writes the original instance, unless another master has moved the selector since. If the line is lost, the record is kept for
/// the next gauge.
fn restore_record(records: &mut impl Records, record: UnrestoredRecord) -> Result<(), RecordError> {
    let UnrestoredRecord { slot, index, written, original } = record;
    records.set_restoring(true);
    let restored = records.read(slot, index).and_then(|octets| match octets.as_slice() {
        [current] if *current == written => write_instance(records, (slot, index), original),
        _ => Ok(()),
    });
    records.set_restoring(false);
    if let Err(RecordError::Session(_) | RecordError::NotSent(_) | RecordError::Interrupted(_)) = &restored {
        records.keep_unrestored(record);
    }
    restored
}

/// Writes the selector. Writing the same instance twice has no further effect, so a lost answer may be answered by a repetition. A write
/// that was not sent has had its repetitions.
fn write_instance(records: &mut impl Records, (slot, index): (u8, u8), instance: u8) -> Result<(), RecordError> {
    let mut written = records.write(slot, index, &[instance]);
    for _ in 1..ATTEMPTS {
        let is_lost = |error: &RecordError| {
            matches!(error, RecordError::Interrupted(_)) && error.write_effect() == WriteEffect::PossiblyExecuted
        };
        if !written.as_ref().is_err_and(is_lost) {
            break;
        }
        written = records.write(slot, index, &[instance]);
    }
    written
}

impl<R: Records> Drop for Gauge<R> {
    /// Restores the Channel Instance Selector.
    fn drop(&mut self) {
        self.restore_selector().ok();
    }
}

impl<R: Records> Gauge<R> {
    /// Moves the Channel Instance Selector back to the instance it showed at the beginning, unless another master has moved it
    /// since. Dropping the gauge does the same.
    ///
    /// ```
    /// # use profivac_client::Bus;
    /// # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5"])?).open()?;
    /// let mut gauge = bus.gauge(5)?;
    /// gauge.read("ba.degas-status")?;
    /// assert!(gauge.selector_moved());
    /// gauge.restore_selector()?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The selector cannot be written. If the line is the reason, the next gauge at this address restores it.
    pub fn restore_selector(&mut self) -> Result<(), ClientError> {
        let Some((record, current)) = self.take_moved_selector() else { return Ok(()) };
        if record.original == current {
            return Ok(());
        }
        self.restore(record)
    }

    fn restore(&mut self, record: UnrestoredRecord) -> Result<(), ClientError> {
        restore_record(&mut self.records, record).map_err(|error| {
            let location = self.raw_context(record.slot, record.index);
            ClientError::from_record(error, Operation::Select, location, None)
        })
    }

    /// The selector that this gauge has moved, with the present instance.
    fn take_moved_selector(&mut self) -> Option<(UnrestoredRecord, u8)> {
        let SelectorState { original, current, written: Some(written) } = self.selector_state.take()? else {
            return None;
        };
        let selector = self.any_selector()?;
        let (slot, index) = (selector.parameter.location.slot, selector.parameter.row.index);
        Some((UnrestoredRecord { slot, index, written, original }, current))
    }

    /// Leaves the selector where it is, for the next gauge of the same watcher.
    pub(crate) fn hold_selector(&mut self) -> Option<HeldSelector> {
        let (record, current) = self.take_moved_selector()?;
        (record.original != current).then_some(HeldSelector { record })
    }

    /// Takes over the selector that the last gauge of this watcher has left. Which instance the slot shows is read again.
    pub(crate) fn resume_selector(&mut self, held: HeldSelector) {
        let UnrestoredRecord { original, written, .. } = held.record;
        self.selector_state = Some(SelectorState { original, current: UNKNOWN, written: Some(written) });
    }

    /// Restores the selector that an earlier gauge at this address could not restore, unless another master has moved it since.
    pub(super) fn recover_selector(&mut self) -> Result<(), ClientError> {
        let Some(record) = self.records.take_unrestored() else { return Ok(()) };
        self.restore(record)
    }

    /// Whether this gauge moved the Channel Instance Selector, so that the owner of the slave saw another instance meanwhile.
    #[must_use]
    pub const fn selector_moved(&self) -> bool {
        self.selector_moved
    }

    /// The instance that a slot shows, or showed before this gauge moved the selector.
    pub(super) fn shown_instance(&mut self, slot: u8) -> Result<u8, ClientError> {
        let current = self.selected_instance(slot)?;
        Ok(match self.selector_state {
            Some(SelectorState { original, written, .. }) if written == Some(current) => original,
            _ => current,
        })
    }

    /// The instance that a slot shows.
    pub(super) fn selected_instance(&mut self, slot: u8) -> Result<u8, ClientError> {
        if let Some(SelectorState { current, .. }) = self.selector_state.filter(|state| state.current != UNKNOWN) {
            return Ok(current);
        }
        let Some(selector) = self.selector(slot) else { return Ok(0) };
        let current = match self.read_record(&selector)? {
            (_, Value::Integer(instance)) => u8::try_from(instance).unwrap_or(UNKNOWN),
            _ => UNKNOWN,
        };
        let state = self.selector_state.unwrap_or(SelectorState { original: current, current, written: None });
        self.selector_state = Some(SelectorState { current, ..state });
        Ok(current)
    }

    /// Whether the slot still shows the instance of a parameter after the parameter was read: another master may move the
    /// selector.
    pub(crate) fn is_still_selected(&mut self, named: &NamedParameter) -> Result<bool, ClientError> {
        let location = named.parameter.location;
        if location.instance == 0 {
            return Ok(true);
        }
        self.invalidate_selector();
        Ok(self.selected_instance(location.slot)? == location.instance)
    }

    /// Marks the present instance as unknown.
    pub(super) fn invalidate_selector(&mut self) {
        self.selector_state = self.selector_state.map(|state| SelectorState { current: UNKNOWN, ..state });
    }

    /// Another master moves the selector between every two requests.
    pub(crate) const fn selector_contention(&self) -> ClientError {
        self.unavailable(Unavailable::SelectorContention)
    }

    /// Makes the slot show the instance of a parameter.
    pub(super) fn select(&mut self, named: &NamedParameter) -> Result<(), ClientError> {
        let location = named.parameter.location;
        if location.instance == 0 || self.selected_instance(location.slot)? == location.instance {
            return Ok(());
        }
        // Until the answer arrives, the selector may show either instance.
        let moving = |state| SelectorState { current: UNKNOWN, written: Some(location.instance), ..state };
        self.selector_state = self.selector_state.map(moving);
        self.selector_moved = true;
        self.write_selector(location.instance)?;
        self.selector_state = self.selector_state.map(|state| SelectorState { current: location.instance, ..state });
        Ok(())
    }

    fn write_selector(&mut self, instance: u8) -> Result<(), ClientError> {
        let selector = self.any_selector().ok_or_else(|| self.unknown_parameter("channel-instance-selector"))?;
        let (slot, index) = (selector.parameter.location.slot, selector.parameter.row.index);
        let written = write_instance(&mut self.records, (slot, index), instance);
        written.map_err(|error| {
            ClientError::from_record(error, Operation::Select, self.context(&selector), Some(&selector))
        })
    }

    /// The selector of a slot.
    fn selector(&self, slot: u8) -> Option<NamedParameter> {
        self.any_selector().filter(|selector| selector.parameter.location.slot == slot)
    }

    /// The selector of the device. No device has two.
    fn any_selector(&self) -> Option<NamedParameter> {
        self.names.all().iter().find(|named| named.parameter.row.role == Some(Role::InstanceSelector)).cloned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::Interruption;
    use profivac_devices::model::AccessPath;
    use profivac_dp::master::ConnectionEnd;
    use profivac_wire::acyclic::AbortReason;

    /// Counts the writes, which all fail.
    struct Failing(Interruption, usize);

    impl Records for Failing {
        fn via(&self) -> AccessPath {
            AccessPath::Class2
        }

        fn read(&mut self, _slot: u8, _index: u8) -> Result<Vec<u8>, RecordError> {
            Err(self.0.into())
        }

        fn write(&mut self, _slot: u8, _index: u8, _octets: &[u8]) -> Result<(), RecordError> {
            self.1 += 1;
            Err(self.0.into())
        }
    }

    #[test]
    fn the_selector_is_written_again_only_if_the_first_write_may_have_been_executed() {
        let end = ConnectionEnd::Aborted(AbortReason::TIMEOUT);
        for (reason, writes) in [
            (Interruption::Ended(end), ATTEMPTS),
            (Interruption::NoAnswer, ATTEMPTS),
            (Interruption::NotExecuted(end), 1),
        ] {
            let mut records = Failing(reason, 0);
            write_instance(&mut records, (1, 46), 2).unwrap_err();
            assert_eq!(records.1, writes, "{reason}");
        }
    }
}
