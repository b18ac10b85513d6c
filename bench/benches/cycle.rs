//! `cargo bench -p bench --bench cycle`: prints the overhead of a cycle over its minimum.

use bench::cycle::{SLAVES, least_tbit, ours_tbit, theirs_tbit};

fn main() {
    println!("| Slaves | minimum, bit times | profivac | profirust 0.6.0 |");
    println!("|--:|--:|--:|--:|");
    for slaves in SLAVES {
        let least = least_tbit(slaves) as f64;
        let over = |tbit: f64| (tbit / least - 1.0) * 100.0;
        let (ours, theirs) = (over(ours_tbit(slaves)), over(theirs_tbit(slaves)));
        println!("| {slaves} | {least} | +{ours:.2} % | +{theirs:.1} % |");
    }
}
