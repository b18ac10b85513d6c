//! Finds circles between the modules of a crate.
//!
//! The modules directly below one parent are compared with each other, at every depth; each module includes all modules
//! below it. A module and its parent may use each other.

use crate::modules::{Arrow, ModulePath, Modules};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// One use for each pair of names.
type Graph = BTreeMap<String, BTreeMap<String, (ModulePath, ModulePath)>>;

/// One shortest circle for each group of modules that are connected in a circle, as text.
pub fn find(modules: &Modules) -> Vec<String> {
    let arrows = modules.arrows();
    modules.paths().flat_map(|parent| below(&arrows, parent)).collect()
}

fn below(arrows: &BTreeSet<Arrow>, parent: &ModulePath) -> Vec<String> {
    let graph = graph(arrows, parent);
    let (mut circles, mut seen) = (Vec::new(), BTreeSet::new());
    for start in graph.keys() {
        if seen.contains(start) {
            continue;
        }
        if let Some(names) = shortest(&graph, start) {
            seen.extend(names.iter().cloned());
            let next = names.iter().skip(1).chain(names.first());
            let uses = names.iter().zip(next).filter_map(|(from, to)| graph.get(from)?.get(to));
            let uses: Vec<String> =
                uses.map(|(from, to)| format!("{} uses {}", from.join("::"), to.join("::"))).collect();
            circles.push(format!("circle {} -> {start}: {}", names.join(" -> "), uses.join(", ")));
        }
    }
    circles
}

/// The uses between the modules directly below `parent`.
fn graph(arrows: &BTreeSet<Arrow>, parent: &ModulePath) -> Graph {
    let mut graph = Graph::new();
    for arrow in arrows {
        if !arrow.from.starts_with(parent) || !arrow.to.starts_with(parent) {
            continue;
        }
        if let (Some(from), Some(to)) = (arrow.from.get(parent.len()), arrow.to.get(parent.len()))
            && from != to
        {
            let uses = graph.entry(from.clone()).or_default();
            uses.entry(to.clone()).or_insert_with(|| (arrow.from.clone(), arrow.to.clone()));
        }
    }
    graph
}

/// The shortest path from `start` back to itself.
fn shortest(graph: &Graph, start: &str) -> Option<Vec<String>> {
    let mut before: BTreeMap<&str, &str> = BTreeMap::new();
    let mut queue = VecDeque::from([start]);
    while let Some(name) = queue.pop_front() {
        for next in graph.get(name).into_iter().flat_map(BTreeMap::keys) {
            if next == start {
                return Some(way(&before, start, name));
            }
            if !before.contains_key(next.as_str()) {
                before.insert(next, name);
                queue.push_back(next);
            }
        }
    }
    None
}

/// The names from `start` to `end`.
fn way(before: &BTreeMap<&str, &str>, start: &str, end: &str) -> Vec<String> {
    let mut names = vec![end.to_owned()];
    let mut at = end;
    while at != start {
        let Some(previous) = before.get(at) else { break };
        names.push((*previous).to_owned());
        at = previous;
    }
    names.reverse();
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modules::tests::made_up;

    fn circles(sources: &[(&str, &str)]) -> Vec<String> {
        find(&made_up(sources))
    }

    #[test]
    fn a_chain_has_no_circle() {
        let sources = [("a", "use crate::b::X;"), ("b", "use crate::c::X;"), ("c", "")];
        assert!(circles(&sources).is_empty());
    }

    #[test]
    fn three_modules_in_a_circle_are_one_circle() {
        let sources =
            [("a", "use crate::b::X;"), ("b", "pub struct X; use super::c::Y;"), ("c", "fn f() { crate::a::x() }")];
        assert_eq!(circles(&sources), ["circle a -> b -> c -> a: a uses b, b uses c, c uses a"]);
    }

    #[test]
    fn a_module_stands_for_all_that_is_below_it() {
        let sources =
            [("a", ""), ("a::one", "use crate::b::X;"), ("a::two", ""), ("b", ""), ("b::one", "use crate::a::two::X;")];
        assert_eq!(circles(&sources), ["circle a -> b -> a: a::one uses b, b::one uses a::two"]);
    }

    #[test]
    fn parent_and_child_may_use_each_other() {
        let sources = [("a", "mod b; use b::X; pub struct Y;"), ("a::b", "use super::Y; pub struct X;")];
        assert!(circles(&sources).is_empty());
    }

    #[test]
    fn a_re_export_by_the_parent_hides_no_circle() {
        let sources = [
            ("a", "pub use one::X; pub use two::Y;"),
            ("a::one", "use super::Y; pub struct X;"),
            ("a::two", "use super::X; pub struct Y;"),
        ];
        assert_eq!(circles(&sources), ["circle one -> two -> one: a::one uses a::two, a::two uses a::one"]);
    }

    #[test]
    fn tests_may_use_anything() {
        let sources = [("a", "#[cfg(test)] mod tests { use crate::b::X; }"), ("b", "use crate::a::X;")];
        assert!(circles(&sources).is_empty());
    }
}
