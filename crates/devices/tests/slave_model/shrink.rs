//! The shortest list of steps that still shows a difference.

use crate::slave_model::line::{Driven, Line, Step, shown};

/// The number of the first step with a difference.
fn differs<D: Driven>(steps: &[Step], pair: &impl Fn() -> Line<D>) -> Option<usize> {
    let mut line = pair();
    steps.iter().position(|step| line.step(step).difference.is_some())
}

/// Leaves out ever smaller parts as long as a difference stays.
fn shortest<D: Driven>(mut steps: Vec<Step>, pair: &impl Fn() -> Line<D>) -> Vec<Step> {
    let mut part = steps.len() / 2;
    while part > 0 {
        let mut from = 0;
        let mut shorter = false;
        while from < steps.len() {
            let to = (from + part).min(steps.len());
            let rest = [&steps[..from], &steps[to..]].concat();
            // First without the time of the part, then with it: a timer may have to expire.
            let mut later = rest.clone();
            if let Some(next) = later.get_mut(from) {
                next.gap += steps[from..to].iter().map(Step::duration).sum::<u64>();
            }
            let shown = [rest, later].into_iter().find_map(|fewer| Some((differs(&fewer, pair)?, fewer)));
            if let Some((at, mut fewer)) = shown {
                fewer.truncate(at + 1);
                steps = fewer;
                shorter = true;
            } else {
                from = to;
            }
        }
        if !shorter || part == 1 {
            part /= 2;
        }
        part = part.min(steps.len() / 2);
    }
    steps
}

/// Fails with the shortest list of steps, as a table.
pub fn report<D: Driven>(name: &str, seed: u64, steps: Vec<Step>, pair: &impl Fn() -> Line<D>) -> ! {
    let all = steps.len();
    let steps = shortest(steps, pair);
    let mut line = pair();
    let mut table = format!("{:>9} | {:<44} | octets\n", "idle tbit", "step");
    let mut difference = None;
    for step in &steps {
        let outcome = line.step(step);
        table.push_str(&format!("{step}\n{:>9} | -> {}\n", "", shown(outcome.answer.as_deref())));
        difference = outcome.difference;
    }
    let difference = difference.map_or_else(String::new, |it| it.0);
    panic!("{name}, seed {seed}: {} of {all} steps show a difference\n{table}{difference}", steps.len());
}
