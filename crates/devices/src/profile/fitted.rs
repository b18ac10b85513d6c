//! The measuring parts of a controller, whose channels need not all be fitted.

use crate::model::{Part, Principle};

/// The measuring parts of a controller with `N` channels.
#[derive(Clone, Copy, Debug)]
pub struct FittedChannels<const N: usize> {
    parts: [Part; N],
    count: usize,
}

impl<const N: usize> FittedChannels<N> {
    /// The principle of the gauge on each channel, from channel 1 on; `None` for a channel without a gauge.
    #[must_use]
    pub fn new(channels: [Option<Principle>; N]) -> Self {
        // Only the first `count` are ever read.
        let mut parts = [Part { instance: 0, principle: Principle::Pirani }; N];
        let fitted =
            (1..).zip(channels).filter_map(|(instance, principle)| Some(Part { instance, principle: principle? }));
        let count = parts.iter_mut().zip(fitted).map(|(target, part)| *target = part).count();
        Self { parts, count }
    }

    /// The parts, by channel.
    #[must_use]
    pub fn parts(&self) -> &[Part] {
        self.parts.get(..self.count).unwrap_or_default()
    }

    /// The channel of a part, counted from 0.
    #[must_use]
    pub fn channel(&self, part: usize) -> Option<usize> {
        usize::from(self.parts().get(part)?.instance).checked_sub(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_channels_have_no_part() {
        let fitted = FittedChannels::new([None, Some(Principle::ColdCathode), None, Some(Principle::Pirani)]);
        assert_eq!(
            fitted.parts(),
            [
                Part { instance: 2, principle: Principle::ColdCathode },
                Part { instance: 4, principle: Principle::Pirani }
            ]
        );
        assert_eq!([0, 1, 2].map(|part| fitted.channel(part)), [Some(1), Some(3), None]);
    }
}
