//! Which plants a user of the view does not see.

use crate::config::Plant;
use profivac_web_server::auth::User;
use std::collections::{BTreeMap, BTreeSet};

/// Plants that a user does not see.
pub type Hidden = BTreeSet<String>;

/// The plants that have a list of users. All users see all others.
#[derive(Clone, Debug, Default)]
pub struct Visibility(BTreeMap<String, BTreeSet<String>>);

impl Visibility {
    /// The lists of the file.
    pub fn of(plants: &[Plant]) -> Self {
        let listed = |plant: &Plant| Some((plant.name.clone(), plant.users.clone()?.into_iter().collect()));
        Self(plants.iter().filter_map(listed).collect())
    }

    /// The plants whose lists do not name this user. Users of the same plants have equal sets: there are at most as many sets as names in
    /// the lists, and one more.
    pub fn hidden_from(&self, user: &User) -> Hidden {
        self.0.iter().filter(|(_, users)| !users.contains(&*user.name)).map(|(plant, _)| plant.clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_web_server::auth::Role;
    use std::sync::Arc;

    #[test]
    fn a_list_hides_its_plant_from_all_others_and_no_list_from_none() {
        let plant = |name: &str, users: Option<&[&str]>| Plant {
            name: name.to_owned(),
            readers: Vec::new(),
            users: users.map(|users| users.iter().map(|user| (*user).to_owned()).collect()),
        };
        let plants = [
            plant("hall", Some(&["ada", "eve"])),
            plant("ring", Some(&["ada"])),
            plant("lab", None),
            plant("old", Some(&[])),
        ];
        let visibility = Visibility::of(&plants);
        let hidden = |name: &str| {
            let user = User { name: Arc::from(name), role: Role::Engineer };
            visibility.hidden_from(&user).into_iter().collect::<Vec<_>>()
        };
        assert_eq!(hidden("ada"), ["old"]);
        assert_eq!(hidden("eve"), ["old", "ring"]);
        assert_eq!(hidden("Ada"), ["hall", "old", "ring"]);
    }
}
