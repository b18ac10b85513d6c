//! What the access column of a row does not allow, in words.

use super::names::NamedParameter;
use profivac_devices::model::{Access, AccessPath, Direction};

/// Why a parameter is not read or written this way, and what to do.
pub(super) fn refusal(access: Access, via: AccessPath, direction: Direction, named: &NamedParameter) -> String {
    let marks = named.parameter.row.access_text;
    let none = match direction {
        Direction::Read => "it cannot be read",
        Direction::Write => "it is read-only",
    };
    let acyclic = Access::READ.union(Access::WRITE);
    let other = [(AccessPath::Class2, "ms2"), (AccessPath::Class1, "ms1"), (AccessPath::ParameterChannel, "pkw")]
        .into_iter()
        .find(|(other, _)| *other != via && access.allows(*other, direction));
    match other {
        Some((_, name)) => format!("the manual allows it another way only (access {marks}); say --via {name}"),
        None if direction == Direction::Write && access.contains(Access::USER_PRM) => {
            format!("only the user parameters of its master set it (access {marks})")
        }
        None if access.intersects(Access::CYCLIC_IN | Access::CYCLIC_OUT) && !access.intersects(acyclic) => {
            format!("it travels in the cyclic data only (access {marks}); `profivac monitor` shows those")
        }
        None => format!("{none} (access {marks})"),
    }
}
