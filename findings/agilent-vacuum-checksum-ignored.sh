#!/usr/bin/env bash
# agilent-vacuum 0.1.2: an answer with a wrong checksum is a pressure.
#
# Expected: an answer of an ion pump controller whose checksum does not fit is refused, or the request is repeated. The package exports
# validate_checksum() for it, and computes the checksum of what it sends.
#
# Seen: nothing calls validate_checksum() on answers. With one damaged character an answer of 4.2E-08 mbar is read as 4.2E-05, without an error
# and without a warning. Besides, the driver looks for the four characters "/x03" where the end of an answer is the octet 03, so each read
# lasts until the serial timeout.
#
# Why it matters: ion pump controllers share long RS-485 lines with inverters. A logged pressure three decades too high looks like a leak.
# Until that changes, subclass SerialClient, and check the answer with validate_checksum() before you return it.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check agilent-vacuum==0.1.2 aioserial==1.3.1 pyserial==3.5 aiofiles==24.1.0 tenacity==9.0.0

timeout 60 "$folder/venv/bin/python" - <<'PYTHON'
import asyncio
import os
import sys
import threading
import tty
from functools import reduce

from agilent_vacuum import validate_checksum
from agilent_vacuum.communication import SerialClient
from agilent_vacuum.ipc_mini import IpcMiniDriver

master, slave = os.openpty()
tty.setraw(master)
WINDOW_812 = b"\x808120"


def answer(pressure, checked):
    """The answer to a read of window 812 with this text, and the checksum that fits the text `checked`."""
    body = lambda text: WINDOW_812 + text + b"\x03"
    checksum = reduce(lambda sum, octet: sum ^ octet, body(checked))
    return b"\x02" + body(pressure) + f"{checksum:02X}".encode()


answers = [answer(b"4.2E-08", b"4.2E-08"), answer(b"4.2E-05", b"4.2E-08")]


def controller():
    for text in answers:
        request = b""
        while not request[:-2].endswith(b"\x03"):
            request += os.read(master, 1)
        os.write(master, text)


async def read_twice():
    driver = IpcMiniDriver(SerialClient(os.ttyname(slave), timeout=1.0))
    driver.is_connected = True
    return [await driver.read_pressure() for _ in answers]


threading.Thread(target=controller, daemon=True).start()
pressures = asyncio.run(read_twice())
valid = [validate_checksum(text) for text in answers]
for pressure, fits in zip(pressures, valid):
    print(f"checksum {'fits' if fits else 'does not fit'}: read_pressure() gives {pressure}")
sys.exit(None if (pressures, valid) == ([4.2e-8, 4.2e-5], [True, False]) else f"agilent-vacuum changed: {pressures}, {valid}")
PYTHON
echo 'as described: agilent-vacuum 0.1.2 reads a pressure from an answer whose checksum is wrong'
