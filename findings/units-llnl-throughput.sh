#!/usr/bin/env bash
# units-llnl 0.13.1 (LLNL units), and scipp 26.8.0, which reads the units of NeXus files with it: "Pa m^3/s" is another unit.
#
# Expected: a space between two unit symbols is a product (SI Brochure, 9th edition, 5.2) and an exponent belongs to the symbol in front
# of it, so "Pa m^3/s" is "Pa*m^3/s": a watt. A text that cannot be read raises an error or gives an invalid unit.
#
# Seen: "Pa m^3/s" is (Pa m)^3/s, valid, without a warning; so is "Pa m3/s". "m^3 Pa/s" is right, "mbar l/s" is invalid.
# "mBar" is 0.8 m^2 times an item: neither a pressure nor invalid. scipp has both.
#
# Why it matters: Pa m^3/s is the unit of throughput and of leak rates, and the manuals write it with a space. A conversion to mbar*l/s gives
# NaN instead of 10. Write "Pa*m^3/s", and compare the dimension of each unit that comes from a file.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check units-llnl==0.13.1 scipp==26.8.0

"$folder/venv/bin/python" - <<'PYTHON'
import sys

import scipp
import units_llnl as llnl


def check(what, seen, expected):
    print(f"{what}: {seen}")
    if str(seen) != expected:
        sys.exit(f"changed: {what} was {expected}")


for text, expected in (
    ("Pa*m^3/s", "W"),
    ("m^3 Pa/s", "W"),
    ("Pa m^3/s", "kg^3/s^7"),
    ("Pa m3/s", "kg^3/s^7"),
):
    check(f"units-llnl, {text}", llnl.Unit(text), expected)
    check(f"units-llnl, {text} is valid", llnl.Unit(text).is_valid(), "True")
    check(f"scipp, {text}", scipp.Unit(text), expected)
check("units-llnl, mbar l/s is valid", llnl.Unit("mbar l/s").is_valid(), "False")
check("units-llnl, mBar", llnl.Unit("mBar"), "0.800000000000000044m^2*item")
check("1 Pa*m^3/s in mbar*l/s", llnl.convert(1, "Pa*m^3/s", "mbar*l/s"), "10.0")
check("1 Pa m^3/s in mbar*l/s", llnl.convert(1, "Pa m^3/s", "mbar*l/s"), "nan")
PYTHON
echo 'as described: a space in a unit of throughput changes its dimension'
