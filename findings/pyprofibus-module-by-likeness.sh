#!/usr/bin/env bash
# pyprofibus 1.13: a module that the GSD file does not have is replaced by one with a similar name.
#
# Expected: an error. The docstring of findModule promises None if no module has the name, and setConfiguredModule has a message
# "Module '...' not found in GSD" for this case. The names in a configuration of pyprofibus (module_0=...) go the same way.
#
# Seen: names are also compared by their beginning, and then by similarity (difflib). "Pirani, float", which this file does not have,
# configures "Pirani, integer"; "Pressure, dint" configures "Pressure, uint". The error only comes if nothing is similar.
#
# Why it matters: the gauges of a series have modules with nearly the same names. The slave accepts the identifiers in Chk_Cfg, because they
# are identifiers of its file, and the program decodes the octets of another number format. A wrong pressure is the only sign.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pyprofibus==1.13

"$folder/venv/bin/python" - <<'PYTHON'
import sys

from pyprofibus.gsd.interp import GsdError, GsdInterp

FILE = b"""#Profibus_DP
GSD_Revision = 3
Ident_Number = 0x1234
Modular_Station = 1
Max_Module = 1
Module = "Pirani, integer" 0x41, 0x81, 0x03
EndModule
Module = "Pressure, uint" 0x41, 0x83, 0x07
EndModule
"""
EXPECTED = {"Pirani, float": "41 81 03", "Pressure, dint": "41 83 07", "Temperature": "refused"}

for name, expected in EXPECTED.items():
    device = GsdInterp.fromBytes(FILE)
    try:
        device.setConfiguredModule(name)
        element, = device.getCfgDataElements()
        seen = element.getDU().hex(" ")
    except GsdError:
        seen = "refused"
    print(f"{name!r}: {seen}")
    if seen != expected:
        sys.exit(f"pyprofibus changed: {name!r} gave {expected}")
PYTHON
echo 'as described: pyprofibus 1.13 configures the module with the most similar name'
