#!/usr/bin/env bash
# pylablib 1.4.5: enable(channel=1) of a TPG262 switches gauge 2.
#
# Expected: TPG260.enable(True, channel=1) sends SEN,2,0: gauge 1 on, gauge 2 unchanged. Pfeiffer BG 5195 BEN lists gauge 1 first in each command for
# two gauges, and is_enabled(channel=1) of the same class reads the first of the two fields.
#
# Seen: the driver sends SEN,0,2: it switches gauge 2 on and leaves gauge 1 alone. Then it raises a TypeError about the answer, which looks as if
# nothing had happened. For channel 2 it raises IndexError and sends nothing.
#
# Why it matters: a cold or hot cathode that is switched on at the wrong place may stand at atmosphere, and the gauge that should protect it stays
# off. The TPG500 of the same family has the same two measuring points. Until that changes, send the command with query().
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pylablib==1.4.5 pyserial==3.5 'setuptools<81'

timeout 60 "$folder/venv/bin/python" - <<'PYTHON'
import os
import sys
import threading
import tty

from pylablib.devices import Pfeiffer

master, slave = os.openpty()
tty.setraw(master)
commands = []


def controller():
    """Acknowledges each line and answers the enquiry: zeros for as many fields as SEN has."""
    line = b""
    while True:
        octet = os.read(master, 1)
        if octet == b"\x05":
            os.write(master, b"0,0\r\n" if commands[-1].startswith("SEN") else b"0\r\n")
        elif octet == b"\n":
            commands.append(line.strip().decode())
            os.write(master, b"\x06\r\n")
            line = b""
        else:
            line += octet


threading.Thread(target=controller, daemon=True).start()
gauges = Pfeiffer.TPG260((os.ttyname(slave), 9600))


def enable(channel):
    """The last command that was sent, and how the method ended."""
    commands.append("none")
    try:
        gauges.enable(True, channel=channel)
        ended = "returns"
    except (TypeError, IndexError) as error:
        ended = type(error).__name__
    print(f"enable(True, channel={channel}): sends {commands[-1]}, {ended}")
    return commands[-1], ended


seen = [enable(1), enable(2)]
sys.stdout.flush()
changed = seen != [("SEN,0,2", "TypeError"), ("none", "IndexError")]
if changed:
    print(f"pylablib changed: {seen}", file=sys.stderr)
os._exit(1 if changed else 0)
PYTHON
echo 'as described: pylablib 1.4.5 switches gauge 2 when gauge 1 is meant'
