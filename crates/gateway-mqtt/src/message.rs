//! A message to be published.

/// How often the broker gets a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delivery {
    /// At most once (`QoS` 0).
    AtMostOnce,
    /// At least once (`QoS` 1).
    AtLeastOnce,
}

/// A message to be published.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// The topic.
    pub topic: String,
    /// The content. An empty one removes a retained message.
    pub payload: Vec<u8>,
    /// How often the broker gets it.
    pub delivery: Delivery,
    /// Whether the broker keeps it for clients that subscribe later.
    pub is_retained: bool,
}
