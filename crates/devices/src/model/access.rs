//! The access rights of a parameter.

bitflags::bitflags! {
    /// The access marks of a parameter, as the manuals print them (Appendix A there).
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct Access: u16 {
        /// `0_XI`, `c_r`: in the cyclic data from the slave to the master.
        const CYCLIC_IN = 1 << 0;
        /// `0_XO`, `c_w`: in the cyclic data from the master to the slave.
        const CYCLIC_OUT = 1 << 1;
        /// `1_R`
        const READ_1 = 1 << 2;
        /// `1_W`
        const WRITE_1 = 1 << 3;
        /// `2_R`
        const READ_2 = 1 << 4;
        /// `2_W`
        const WRITE_2 = 1 << 5;
        /// `ac_r`: by the parameter channel, on devices without DP-V1.
        const READ_CHANNEL = 1 << 6;
        /// `ac_w`
        const WRITE_CHANNEL = 1 << 7;
        /// `prm`, in no manual: only the user parameters set it.
        const USER_PRM = 1 << 8;
    }
}

/// The channel through which an access reaches the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AccessPath {
    /// MS1, the class 1 master that owns the slave.
    Class1,
    /// MS2, a class 2 master.
    Class2,
    /// The parameter channel inside the cyclic data.
    ParameterChannel,
}

/// The direction of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// To the master.
    Read,
    /// To the device.
    Write,
}

impl Access {
    /// Readable by request, on any path.
    pub const READ: Self = Self::READ_1.union(Self::READ_2).union(Self::READ_CHANNEL);
    /// Writable by request, on any path.
    pub const WRITE: Self = Self::WRITE_1.union(Self::WRITE_2).union(Self::WRITE_CHANNEL);

    /// Whether a request on this path is allowed.
    ///
    /// The parameter channel reads and writes the parameters that either class can: errata-bpg-bcg-tpg 22,
    /// errata-pxg55x-img400 3.
    #[must_use]
    pub const fn allows(self, path: AccessPath, direction: Direction) -> bool {
        self.intersects(match (path, direction) {
            (AccessPath::Class1, Direction::Read) => Self::READ_1,
            (AccessPath::Class1, Direction::Write) => Self::WRITE_1,
            (AccessPath::Class2, Direction::Read) => Self::READ_2,
            (AccessPath::Class2, Direction::Write) => Self::WRITE_2,
            (AccessPath::ParameterChannel, Direction::Read) => Self::READ,
            (AccessPath::ParameterChannel, Direction::Write) => Self::WRITE,
        })
    }
}

/// The access column of a block table: the marks of every manual, token by token.
#[doc(hidden)]
#[macro_export]
macro_rules! access {
    ($($marks:tt)*) => { $crate::model::access::marks!(@ $crate::model::Access::empty(); $($marks)*) };
}

/// One arm per mark: longer marks first, because `1_R` begins `1_R/W`.
#[doc(hidden)]
#[macro_export]
macro_rules! marks {
    (@ $access:expr;) => { $access };
    (@ $access:expr; 0_XI $($rest:tt)*) => { $crate::model::access::marks!(@ $access.union($crate::model::Access::CYCLIC_IN); $($rest)*) };
    (@ $access:expr; 0_XO $($rest:tt)*) => { $crate::model::access::marks!(@ $access.union($crate::model::Access::CYCLIC_OUT); $($rest)*) };
    (@ $access:expr; 1/2_R/W $($rest:tt)*) => { $crate::model::access::marks!(@ $access; 1_R 1_W 2_R 2_W $($rest)*) };
    (@ $access:expr; 1/2_R $($rest:tt)*) => { $crate::model::access::marks!(@ $access; 1_R 2_R $($rest)*) };
    (@ $access:expr; 1/2_W $($rest:tt)*) => { $crate::model::access::marks!(@ $access; 1_W 2_W $($rest)*) };
    (@ $access:expr; 1_R/W $($rest:tt)*) => { $crate::model::access::marks!(@ $access; 1_R 1_W $($rest)*) };
    (@ $access:expr; 2_R/W $($rest:tt)*) => { $crate::model::access::marks!(@ $access; 2_R 2_W $($rest)*) };
    (@ $access:expr; 2R/W $($rest:tt)*) => { $crate::model::access::marks!(@ $access; 2_R 2_W $($rest)*) };
    (@ $access:expr; 2R $($rest:tt)*) => { $crate::model::access::marks!(@ $access; 2_R $($rest)*) };
    (@ $access:expr; 1_R $($rest:tt)*) => { $crate::model::access::marks!(@ $access.union($crate::model::Access::READ_1); $($rest)*) };
    (@ $access:expr; 1_W $($rest:tt)*) => { $crate::model::access::marks!(@ $access.union($crate::model::Access::WRITE_1); $($rest)*) };
    (@ $access:expr; 2_R $($rest:tt)*) => { $crate::model::access::marks!(@ $access.union($crate::model::Access::READ_2); $($rest)*) };
    (@ $access:expr; 2_W $($rest:tt)*) => { $crate::model::access::marks!(@ $access.union($crate::model::Access::WRITE_2); $($rest)*) };
    (@ $access:expr; c_r $($rest:tt)*) => { $crate::model::access::marks!(@ $access.union($crate::model::Access::CYCLIC_IN); $($rest)*) };
    (@ $access:expr; c_w $($rest:tt)*) => { $crate::model::access::marks!(@ $access.union($crate::model::Access::CYCLIC_OUT); $($rest)*) };
    (@ $access:expr; ac_r $($rest:tt)*) => { $crate::model::access::marks!(@ $access.union($crate::model::Access::READ_CHANNEL); $($rest)*) };
    (@ $access:expr; ac_w $($rest:tt)*) => { $crate::model::access::marks!(@ $access.union($crate::model::Access::WRITE_CHANNEL); $($rest)*) };
    (@ $access:expr; prm $($rest:tt)*) => { $crate::model::access::marks!(@ $access.union($crate::model::Access::USER_PRM); $($rest)*) };
    (@ $access:expr; , $($rest:tt)*) => { $crate::model::access::marks!(@ $access; $($rest)*) };
}

#[doc(hidden)]
pub use {access, marks};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_marks_of_all_manuals_mean_the_same() {
        let all = Access::READ_1 | Access::WRITE_1 | Access::READ_2 | Access::WRITE_2;
        assert_eq!(access!(1 / 2_R / W), all);
        assert_eq!(access!(1_R/W 2_R/W), all);
        assert_eq!(access!(1_R 1_W 2_R 2_W), all);
        assert_eq!(access!(0_XI 1/2_R), Access::CYCLIC_IN | Access::READ_1 | Access::READ_2);
        assert_eq!(access!(0_XO 2_R), Access::CYCLIC_OUT | Access::READ_2);
        assert_eq!(access!(2R / W), Access::READ_2 | Access::WRITE_2);
        assert_eq!(access!(2R), Access::READ_2);
        assert_eq!(access!(1 / 2_W), Access::WRITE_1 | Access::WRITE_2);
        assert_eq!(access!(c_w, ac_r), Access::CYCLIC_OUT | Access::READ_CHANNEL);
        assert_eq!(access!(ac_r, ac_w), Access::READ_CHANNEL | Access::WRITE_CHANNEL);
        assert_eq!(access!(c_r), Access::CYCLIC_IN);
        assert_eq!(access!(2_R prm), Access::READ_2 | Access::USER_PRM);
    }

    #[test]
    fn each_path_needs_its_own_mark_and_the_parameter_channel_any_mark() {
        let class_2 = access!(2_R / W);
        for (path, allowed) in
            [(AccessPath::Class1, false), (AccessPath::Class2, true), (AccessPath::ParameterChannel, true)]
        {
            assert_eq!(class_2.allows(path, Direction::Read), allowed, "{path:?}");
            assert_eq!(class_2.allows(path, Direction::Write), allowed, "{path:?}");
        }
        assert!(!access!(0_XI).allows(AccessPath::ParameterChannel, Direction::Read));
        assert!(!access!(1 / 2_R).allows(AccessPath::ParameterChannel, Direction::Write));
    }
}
