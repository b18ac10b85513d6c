//! The faults that a simulated device can have.

/// The faults of all devices, with their names.
macro_rules! fault_names {
    ($($(#[$doc:meta])* $fault:ident $name:literal;)+) => {
        /// A fault of a device. Every device has some of them: [`Model::faults`](super::Model::faults).
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[non_exhaustive]
        pub enum Fault {
            $($(#[$doc])* $fault,)+
        }

        impl Fault {
            /// All faults.
            pub const ALL: &[Self] = &[$(Self::$fault),+];

            /// The name in words: `pirani-adjust`.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$fault => $name,)+
                }
            }
        }
    };
}

fault_names! {
    /// The nonvolatile memory.
    Eeprom       "eeprom";
    /// The working memory.
    Ram          "ram";
    /// The program memory.
    Eprom        "eprom";
    /// Internal communication.
    Comm         "comm";
    /// The general power supply of a controller.
    Power        "power";
    /// A pressure above the limit of the hot cathodes.
    Overpressure "overpressure";
    /// A Pirani that is badly adjusted.
    PiraniAdjust "pirani-adjust";
    /// The sensor of instance or channel 1.
    Sensor1      "sensor1";
    /// The sensor of instance or channel 2.
    Sensor2      "sensor2";
    /// The sensor of instance or channel 3.
    Sensor3      "sensor3";
    /// The sensor of instance or channel 4.
    Sensor4      "sensor4";
    /// The electronics of instance or channel 1.
    Electronics1 "electronics1";
    /// The electronics of instance or channel 2.
    Electronics2 "electronics2";
    /// The electronics of instance or channel 3.
    Electronics3 "electronics3";
    /// The electronics of instance or channel 4.
    Electronics4 "electronics4";
    /// The plug of channel 1.
    Unplugged1   "unplugged1";
    /// The plug of channel 2.
    Unplugged2   "unplugged2";
    /// The plug of channel 3.
    Unplugged3   "unplugged3";
    /// The plug of channel 4.
    Unplugged4   "unplugged4";
}

impl Fault {
    /// The fault with this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|fault| fault.name() == name)
    }

    /// The fault of the sensor of an instance.
    #[must_use]
    pub const fn of_sensor(instance: u8) -> Option<Self> {
        match instance {
            1 => Some(Self::Sensor1),
            2 => Some(Self::Sensor2),
            3 => Some(Self::Sensor3),
            4 => Some(Self::Sensor4),
            _ => None,
        }
    }

    /// The fault of the electronics of an instance.
    #[must_use]
    pub const fn of_electronics(instance: u8) -> Option<Self> {
        match instance {
            1 => Some(Self::Electronics1),
            2 => Some(Self::Electronics2),
            3 => Some(Self::Electronics3),
            4 => Some(Self::Electronics4),
            _ => None,
        }
    }
}

/// The faults of a device, made by `faults!`.
#[derive(Debug, PartialEq, Eq)]
pub struct FaultList {
    /// The faults.
    pub faults: &'static [Fault],
    /// The effect of each, in the same order.
    pub effects: &'static [&'static str],
}

impl FaultList {
    /// The names, in order.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.faults.iter().map(|fault| fault.name())
    }
}

/// The faults of a device: field, fault, effect.
#[macro_export]
macro_rules! faults {
    ($(#[$doc:meta])* pub $faults:ident; $($field:ident $fault:ident $effect:literal;)+) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $faults {
            $(#[doc = $effect] pub $field: bool,)+
        }

        impl $faults {
            /// No fault is active.
            pub const NONE: Self = Self { $($field: false),+ };

            /// The faults and their effects.
            pub const LIST: $crate::model::FaultList = $crate::model::FaultList {
                faults: &[$($crate::model::Fault::$fault),+],
                effects: &[$($crate::model::text($effect)),+],
            };

            /// Begins or ends a fault. Has no effect for a fault that is not in the list.
            pub fn set(&mut self, fault: $crate::model::Fault, active: bool) {
                match fault {
                    $($crate::model::Fault::$fault => self.$field = active,)+
                    _ => {}
                }
            }
        }
    };
}

#[doc(hidden)]
pub use faults;
