#!/usr/bin/env bash
# pyprofibus 1.13: the GSD reader loses modules, or the whole device, without an error.
#
# Expected: a GSD file is read or refused. A comment starts with ';' and may stand behind any line, also the first one; a ';' inside quotes
# is text (GSD specification for PROFIBUS DP, general rules). The reader itself has ';' among the characters of a string and decodes
# Latin-1, so a micro sign is a character, too.
#
# Seen: text behind #Profibus_DP makes a device without an ident number, a name and modules. A ';' inside a module's name starts a comment:
# the reader takes one character after the opening quote for the closing one. A module whose name has a micro sign or an apostrophe is
# missing. Nothing is raised and nothing is printed, unless the reader was called with debug=True.
#
# Why it matters: the modules of a vacuum gauge are its telegrams, with units in their names. A module that is missing in the list looks
# like one that the gauge does not have.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pyprofibus==1.13

"$folder/venv/bin/python" - "$folder/gauge.gsd" <<'PYTHON'
import sys

from pyprofibus.gsd.interp import GsdInterp

HEAD = "#Profibus_DP"
BODY = """
GSD_Revision = 3
Vendor_Name = "Example"
Model_Name = "Gauge"
Revision = "1.0"
Ident_Number = 0x1234
Modular_Station = 1
Max_Module = 1
Module = "Pressure, float" 0x94 ; plain
EndModule
Module = "Pressure; float" 0x94
EndModule
Module = "Pressure in \u00b5bar" 0x94
EndModule
Module = "Operator's pressure" 0x94
EndModule
"""


def read(head):
    with open(sys.argv[1], "w", encoding="latin-1") as file:
        file.write(head + BODY)
    return GsdInterp.fromFile(sys.argv[1])


def check(what, seen, expected):
    print(f"{what}: {seen}")
    if seen != expected:
        sys.exit(f"pyprofibus changed: {what} was {expected}")


check("modules of four", [module.name for module in read(HEAD).getField("Module")], ["Pressure, float"])
check("ident, first line alone", read(HEAD).getField("Ident_Number"), 0x1234)
for head in (HEAD + " ; a comment", HEAD + " "):
    device = read(head)
    check(f"ident and modules, first line {head!r}", (device.getField("Ident_Number"), device.getField("Module")), (None, None))
PYTHON
echo 'as described: the GSD reader of pyprofibus 1.13 loses lines silently'
