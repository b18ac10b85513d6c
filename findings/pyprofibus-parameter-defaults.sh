#!/usr/bin/env bash
# pyprofibus 1.13: user parameters have no defaults, and two generations of keywords are mixed.
#
# Expected: ExtUserPrmData describes a parameter; the line with its data type has its default, Ext_User_Prm_Data_Ref(3) puts it into octet 3
# of the user parameters, and a master that nobody has told another value sends the default (GSD specification for PROFIBUS DP,
# Ext-User-Prm-Data-Def-List). A file of revision 1 and later may also have User_Prm_Data, for older masters: a master that reads
# the Ext keywords uses them instead.
#
# Seen: the line with type and default is ignored. Octet 3 keeps the constant below the reference. If the file has
# User_Prm_Data, octets of the old list stay where the Ext list is shorter.
#
# Why it matters: the pressure unit of a gauge is such a parameter. The default of the file is Pascal, pyprofibus sends mbar (first file), or
# Torr of the old list (second file); the gauge accepts both and reports another number for the same pressure.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pyprofibus==1.13

"$folder/venv/bin/python" - <<'PYTHON'
import sys

from pyprofibus.gsd.interp import GsdInterp

COMMON = """#Profibus_DP
GSD_Revision = 3
Ident_Number = 0x1234
Modular_Station = 1
Max_Module = 1
Max_User_Prm_Data_Len = 5
PrmText = 1
Text(0) = "mbar"
Text(1) = "Torr"
Text(2) = "Pascal"
EndPrmText
ExtUserPrmData = 1 "Pressure unit"
Unsigned8 2 0-2
Prm_Text_Ref = 1
EndExtUserPrmData
"""
EXT = COMMON + """Ext_User_Prm_Data_Const(0) = 0x80, 0x00, 0x00, 0x00, 0x00
Ext_User_Prm_Data_Ref(3) = 1
"""
BOTH = COMMON + """User_Prm_Data_Len = 5
User_Prm_Data = 0x00, 0x00, 0x00, 0x01, 0x09
Ext_User_Prm_Data_Const(0) = 0x80, 0x00, 0x00
Ext_User_Prm_Data_Ref(3) = 1
"""
# With the default of the file octet 3 would be 02 in both; octet 4 of the second would not exist or be 00.
for name, text, expected in (("Ext keywords", EXT, "80 00 00 00 00"), ("both generations", BOTH, "80 00 00 01 09")):
    seen = GsdInterp.fromBytes(text.encode()).getUserPrmData().hex(" ")
    print(f"{name}: {seen}")
    if seen != expected:
        sys.exit(f"pyprofibus changed: the user parameters of the file with {name} were {expected}")
PYTHON
echo 'as described: pyprofibus 1.13 ignores the defaults of user parameters'
