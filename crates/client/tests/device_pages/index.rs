//! The list of the pages, and how to read them.

use crate::device_pages::Page;
use crate::device_pages::page::{HEADER, table};

/// The text that all pages share.
const READING: &str = "
## How to read a page

Octets count from 0, numbers with `h` are hexadecimal. Slot and ID (the index of DP-V1) address a parameter; where a block has instances,
Channel Instance Selector chooses the one that the slot shows.

Types: `VSTRING(n)` is text filled up with blanks, `OSTRING(n)`, `ARRAY(n)` and `RECORD(n)` are n octets, `BY_TYPE` is a
pressure in the unit and the number type that are set: two octets or four, on the TPG always four. The most significant octet
is sent first. `1/2_R` is `1_R 2_R`, `1_R/W` is `1_R 1_W`, and `2R` is `2_R`.

| Access | Meaning |
|---|---|
| `0_XI`, `c_r` | travels to the master in the cyclic data |
| `0_XO`, `c_w` | travels to the device in the cyclic data |
| `1_R`, `1_W` | a class 1 master reads, writes (MS1) |
| `2_R`, `2_W` | a class 2 master reads, writes (MS2) |
| `ac_r`, `ac_w` | the parameter channel reads, writes, on devices without MS1 and MS2 |
| `prm` | the user parameters set it; no manual has this mark |

On the other devices the parameter channel reads and writes every parameter that class 1 or class 2 may read and write.

| Store | At power loss |
|---|---|
| `N` | kept |
| `V` | lost |
| `R` | lost, unless the master has asked to store it |
| `D` | follows from other values, never stored |
| `-` | nothing is stored |

Where a row differs from the manual, or the manual is silent and the value is chosen, a comment in the source of the
page's tables says so. The results of a second reading of the manuals are beside the pages, in the files `review-*.md`.
";

pub fn print(pages: &[Page]) -> String {
    let mut lines = Vec::new();
    for page in pages {
        let link = format!("[{0}]({0}.md)", page.file);
        lines.extend(page.models.iter().map(|model| {
            let name = format!("`{}`", model.name);
            vec![name, model.title.to_owned(), model.vendor.to_owned(), model.manual.to_owned(), link.clone()]
        }));
    }
    let devices = table(&["Name", "Device", "Vendor", "Manual", "Page"], lines);
    format!(
        "{HEADER}\n# Devices\n\nDevices with the same tables share a page. [Other devices](gallery.md) are described in files.\n\n{devices}{READING}"
    )
}
