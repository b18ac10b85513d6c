//! The frame count bits of an initiator: one per station for all services. profibus-wire 1.10.

use super::request::OpenRequest;
use profivac_wire::control::FrameCount;

/// The frame count of the next counted request to each of the addresses 0 to 126.
#[derive(Clone, Debug)]
pub(super) struct FrameCounts([FrameCount; 127]);

impl FrameCounts {
    pub(super) const fn new() -> Self {
        Self([FrameCount::First; 127])
    }

    /// The frame count of a request.
    pub(super) fn next(&self, request: &OpenRequest) -> FrameCount {
        match self.0.get(usize::from(request.da)) {
            Some(count) if request.kind.counts() => *count,
            _ => FrameCount::Uncounted,
        }
    }

    /// A valid answer came: the next request carries the other bit.
    pub(super) fn answered(&mut self, request: &OpenRequest) {
        self.set(request, |count| match count {
            FrameCount::Counted(fcb) => FrameCount::Counted(!fcb),
            FrameCount::First | FrameCount::Uncounted => FrameCount::Counted(false),
        });
    }

    /// The station is not operational any more: the next request is the first again.
    pub(super) fn forget(&mut self, request: &OpenRequest) {
        self.set(request, |_| FrameCount::First);
    }

    fn set(&mut self, request: &OpenRequest, change: impl Fn(FrameCount) -> FrameCount) {
        if let Some(count) = self.0.get_mut(usize::from(request.da))
            && request.kind.counts()
        {
            *count = change(*count);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::request::Kind;
    use super::*;

    #[test]
    fn the_frame_count_begins_with_a_first_contact_and_toggles_with_answers_only() {
        let mut counts = FrameCounts::new();
        let diag = OpenRequest { da: 8, kind: Kind::Reply, dsap: Some(60), ssap: Some(62) };
        let exchange = OpenRequest { dsap: None, ssap: None, ..diag };
        let neighbour = OpenRequest { da: 9, ..diag };
        let status = OpenRequest { kind: Kind::FdlStatus, ..exchange };

        assert_eq!(counts.next(&diag), FrameCount::First);
        counts.answered(&diag);
        // Another service of the same station continues the count, and an uncounted request changes nothing.
        assert_eq!(counts.next(&exchange), FrameCount::Counted(false));
        assert_eq!(counts.next(&status), FrameCount::Uncounted);
        counts.answered(&status);
        counts.answered(&exchange);
        assert_eq!(counts.next(&diag), FrameCount::Counted(true));
        assert_eq!(counts.next(&neighbour), FrameCount::First);
        counts.forget(&exchange);
        assert_eq!(counts.next(&diag), FrameCount::First);
    }
}
