//! The parameters of the devices, copied by hand from the tables of the manuals and the errata: the pages in `docs/devices`
//! come from the tables of the code, and must have the same.
//!
//! A line has places (slot, or slot:instance), index, octets (`n`: by data type), and the access of class 1 and class 2:
//! `rwrw`. For a device without MS1 and MS2 it is the access of the parameter channel.

use crate::slave_model::page::Page;
use std::collections::BTreeSet;

/// tira41d1 3, errata-bpg-bcg-tpg 42, 43, 71, 93, 110, 115.
pub const BCG450: &str = "
0 15 1 rwrw, 0 16 4 r-r-, 0 17 8 r-r-, 0 18 9 r-r-, 0 19 20 r-r-, 0 20 20 r-r-, 0 21 8 r-r-, 0 22 8 r-r-, 0 23 30 r-r-
0 24 50 r-r-, 0 25 1 r-r-, 0 26 1 r-r-, 0 27 12 r-r-, 0 28 13 r-r-, 0 204 1 r-r-, 0 205 4 r-r-, 0 206 2 r-r-
0 207 1 r-r-, 0 208 1 r-r-, 0 209 4 r-r-, 0 210 3 r-r-, 0 211 1 r-r-
1 16 4 --r-, 1 46 1 rwrw, 1 47 1 r-r-, 1 120 1 r-r-
1:1/1:2/1:3 19 n r-r-, 1:1/1:2/1:3 20 1 r-r-, 1:1/1:2/1:3 21 1 --rw, 1:1/1:2/1:3 22 2 --rw, 1:1/1:2/1:3 23 1 r-r-
1:1/1:2/1:3 24 n r-r-, 1:1/1:2/1:3 39 1 rwrw, 1:1/1:2/1:3 40 n rwrw, 1:1/1:2/1:3 44 n r-r-, 1:1/1:2/1:3 45 n r-r-
1:5/1:6 19 n r-r-, 1:5/1:6 20 1 r-r-, 1:5/1:6 21 1 --rw, 1:5/1:6 22 2 --rw, 1:5/1:6 23 1 r-r-
1:5/1:6 201 1 rwrw, 1:5/1:6 202 2 rwrw, 1:5/1:6 203 1 r-r-
1:1/1:2/1:3/1:4 101 4 --r-, 1:1/1:2/1:3 102 1 r-r-, 1:1/1:2/1:3 103 2 r-r-, 1:1/1:2/1:3 104 2 r-r-
1:2 14 2 -w-w, 1:2 105 1 rwrw, 1:2 106 4 rwrw, 1:2 109 1 r-r-, 1:2 201 1 r-r-, 1:4 14 2 -w-w";

/// tira36e1 3, errata-bpg-bcg-tpg 38, 39, 45, 71, 93, 94: what both gauges have.
const XPG400: &str = "
0 15 1 rwrw, 0 16 4 r-r-, 0 17 8 r-r-, 0 18 9 r-r-, 0 19 20 r-r-, 0 20 20 r-r-, 0 21 8 r-r-, 0 22 8 r-r-, 0 23 30 r-r-
0 24 50 r-r-, 0 25 1 r-r-, 0 26 1 r-r-, 0 27 10 r-r-, 0 28 11 r-r-, 0 204 1 r-r-, 0 205 4 r-r-, 0 206 1 r-r-
0 207 1 r-r-, 0 208 4 r-r-, 0 209 1 r-r-
1 15 1 -w-w, 1 16 4 --r-, 1 46 1 rwrw, 1 47 1 r-r-, 1 120 1 r-r-
1:1/1:2 19 n r-r-, 1:1/1:2 20 1 r-r-, 1:1/1:2 21 1 --rw, 1:1/1:2 22 2 --rw, 1:1/1:2 23 1 r-r-, 1:1/1:2 24 n r-r-
1:1/1:2 39 1 rwrw, 1:1/1:2 40 n rwrw, 1:1/1:2 44 n r-r-, 1:1/1:2 45 n r-r-
1:3/1:4 19 n r-r-, 1:3/1:4 20 1 r-r-, 1:3/1:4 21 1 --rw, 1:3/1:4 22 2 --rw, 1:3/1:4 23 1 r-r-
1:1/1:2 101 4 --r-, 1:1/1:2 102 1 r-r-, 1:1/1:2 103 2 r-r-, 1:1/1:2 104 2 r-r-, 1:1 140 1 r-r-, 1:2 105 1 rwrw";

/// What only the BPG400-SP has.
const BPG400: &str = "1:2 14 2 -w-w, 1:2 106 4 rwrw, 1:2 109 1 r-r-";
/// What only the HPG400-SP has.
const HPG400: &str = "0 202 n r-r-, 0 203 1 r-r-";

/// tira56e1 7 to 13, errata-pxg55x-img400 75, 78, 92: what all gauges have.
const PXG55X: &str = "
0 15 1 rwrw, 0 16 4 r-r-, 0 17 8 --r-, 0 18 9 --r-, 0 19 20 --r-, 0 20 20 --r-, 0 21 8 --r-, 0 22 8 --r-, 0 23 30 --r-
0 24 50 --r-, 0 25 1 r-r-, 0 26 1 r-r-, 0 36 2 r-r-, 0 202 8 --r-, 0 204 2 r-r-, 0 206 1 r-r-, 0 207 2 r-r-
0 208 1 r-r-, 0 210 1 r-r-, 0 211 1 r-r-, 0 212 4 r-r-, 1 46 1 rwrw, 1 47 1 r-r-, 1 120 1 r-r-
2/3 16 4 r-r-, 2/3 17 n rwrw, 2/3 18 1 rwrw, 2/3 19 n rwrw, 2/3 20 1 rwrw, 2/3 21 1 r-r-, 2/3 26 1 r-r-
2/3 28 2 --rw, 2/3 29 1 --rw, 2/3 31 n rwrw, 2/3 32 n rwrw, 2/3 201 4 rwrw, 2/3 202 1 rwrw
4/5 16 4 r-r-, 4/5 19 1 --r-, 4/5 20 1 --r-";

/// What the PCG55x has with instances 1 and 2.
const PCG55X: &str = "0 27 10 r-r-, 0 28 11 r-r-, 0 205 4 r-r-, 0 209 4 r-r-, 1:1 41 1 rwrw, 1:2 201 1 rwrw";
/// What the PSG55x has.
const PSG55X: &str = "0 27 8 r-r-, 0 28 9 r-r-, 0 205 2 r-r-, 0 209 2 r-r-, 1:1 201 1 rwrw";
/// What each instance of tira56e1 8 and 12 has.
const PXG55X_INSTANCE: &str = "
15 2 rwrw, 16 4 r-r-, 19 n r-r-, 20 1 r-r-, 21 1 --rw, 22 2 --rw, 23 1 r-r-, 24 n r-r-, 39 1 rwrw, 40 n rwrw
44 n r-r-, 45 n r-r-, 101 4 r-r-, 102 1 r-r-, 103 2 r-r-, 104 2 r-r-";

/// BG 5530 4.4, errata-pxg55x-img400 130, 132, 139.
pub const IMG400: &str = "
0 15 1 rwrw, 0 16 4 r-r-, 0 25 1 r-r-, 0 26 1 r-r-, 0 203 1 rwrw, 0 204 2 r-r-, 0 205 1 -w-w
1/2/3/4 15 2 rwrw, 1/2/3/4 16 4 --r-, 1/2/3/4 19 n r-r-, 1/2/3/4 20 1 r-r-, 1/2/3/4 21 1 --rw, 1/2/3/4 22 2 --r-
1/2/3/4 23 1 r-r-, 1/2/3/4 24 n r-r-, 1/2/3/4 39 1 rwrw, 1/2/3/4 40 n rwrw, 1/2/3/4 44 n r-r-, 1/2/3/4 45 n r-r-
5/6/7/8/9/10/11 16 4 --r-, 5/6/7/8/9/10/11 19 n rwrw, 5/6/7/8/9/10/11 20 1 rwrw, 5/6/7/8/9/10/11 21 1 r-r-
5/6/7/8/9/10/11 24 n rwrw, 5/6/7/8/9/10/11 27 1 rwrw, 5/6/7/8/9/10/11 28 2 --r-, 5/6/7/8/9/10/11 29 1 --r-
5/6/7/8/9/10/11 201 n rwrw, 1/2 14 2 rwrw, 1/2/3/4 101 4 --r-, 1/2/3/4 102 1 r-r-, 1/2/3/4 103 2 r-r-
1/2/3/4 104 2 r-r-, 1/2 105 1 rwrw, 1/2 107 4 rwrw, 1/2 110 1 r-r-";

/// i9973ber/a 3.2.3, 3.2.4, errata-bpg-bcg-tpg 127 to 130, 150.
pub const TPG: &str = "
0 20 1 r-, 0 21 4 r-, 0 24 2 rw, 0 25 1 rw, 0 26 1 rw
1/2/3/4 20 n --, 1/2/3/4 21 1 --, 1/2/3/4 22 1 rw, 1/2/3/4 23 1 rw
5/6/7/8/9/10 20 1 rw, 5/6/7/8/9/10 21 n rw, 5/6/7/8/9/10 22 n rw, 5/6/7/8/9/10 23 1 rw, 5/6/7/8/9/10 24 1 r-";

/// The lists of a device.
pub fn of(name: &str, atmosphere: bool) -> Vec<String> {
    let instance = |number: u8| {
        let at = |row: &str| format!("1:{number} {row}");
        rows(PXG55X_INSTANCE).map(at).collect::<Vec<_>>().join(", ")
    };
    match name {
        "bcg450" => vec![BCG450.into()],
        "bpg400" => vec![XPG400.into(), BPG400.into()],
        "hpg400" => vec![XPG400.into(), HPG400.into()],
        "img400" => vec![IMG400.into()],
        "tpg300" => vec![TPG.into()],
        "psg550" => vec![PXG55X.into(), PSG55X.into(), instance(1)],
        _ if atmosphere => vec![PXG55X.into(), PCG55X.into(), instance(1), instance(2), instance(3)],
        _ => vec![PXG55X.into(), PCG55X.into(), instance(1), instance(2)],
    }
}

fn rows(list: &str) -> impl Iterator<Item = &str> {
    list.split([',', '\n']).map(str::trim).filter(|it| !it.is_empty())
}

/// The page has the parameters of the lists.
pub fn check(page: &Page, lists: &[String]) {
    let listed = lists.iter().flat_map(|list| rows(list)).flat_map(|row| {
        let (places, rest) = row.split_once(' ').expect("places and the rest");
        places.split('/').map(|place| format!("{place} {rest}")).collect::<Vec<_>>()
    });
    let listed: BTreeSet<String> = listed.collect();
    let letters = |rights: &[bool]| -> String {
        let letter = |(at, right): (usize, &bool)| if *right { ['r', 'w'][at % 2] } else { '-' };
        rights.iter().enumerate().map(letter).collect()
    };
    let paged = page.rows.iter().map(|row| {
        let place = row.instance.map_or(row.slot.to_string(), |it| format!("{}:{it}", row.slot));
        let octets = row.octets.map_or("n".to_owned(), |it| it.to_string());
        let rights = if page.table.ms2 { letters(&row.access) } else { letters(&row.channel) };
        format!("{place} {} {octets} {rights}", row.index)
    });
    let paged: BTreeSet<String> = paged.collect();
    let name = &page.table.name;
    assert_eq!(listed.difference(&paged).collect::<Vec<_>>(), Vec::<&String>::new(), "{name}: not on the page");
    assert_eq!(paged.difference(&listed).collect::<Vec<_>>(), Vec::<&String>::new(), "{name}: not in the manual");
}
