#!/usr/bin/env bash
# pyserial 3.5 on Linux: inter_byte_timeout does not end a read().
#
# Expected: with inter_byte_timeout=0.02 a read() returns when 20 ms pass after a character, with the characters that have come. The
# documentation calls the option the inter-character timeout; on Windows it is the ReadIntervalTimeout of the driver.
#
# Seen: read(32) waits for its whole timeout and returns two telegrams with half a second between them as one. It makes no difference
# whether the option is missing, 0.02 or 0.2. pyserial writes it into VMIN and VTIME of the port, in whole tenths of a second, so that 0.02
# is 0. But it opens the port with O_NONBLOCK, where Linux uses neither, and its loop with select() only knows the whole timeout.
#
# Why it matters: PROFIBUS and Modbus RTU find the start of a telegram by the idle line before it (33 bit times, 3.5 characters). A monitor
# or a gauge driver that was written on Windows glues request and answer together on Linux, and is slower by the whole time-out. End
# a read by the length in the telegram, or read in_waiting octets at a time and measure the gap.
#
# Needs Linux.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pyserial==3.5

timeout 60 "$folder/venv/bin/python" - <<'PYTHON'
import os
import sys
import threading
import time
import tty

import serial

# FDL status request of master 2 to slave 5, and the answer.
REQUEST, ANSWER = bytes.fromhex("10 05 02 49 50 16"), bytes.fromhex("10 02 05 00 07 16")


def line():
    time.sleep(0.5)
    os.write(master, REQUEST)
    time.sleep(0.5)
    os.write(master, ANSWER)


def check(what, seen, expected):
    print(f"{what}: {seen}")
    if seen != expected:
        sys.exit(f"pyserial changed: {what} was {expected}")


master, slave = os.openpty()
tty.setraw(slave)
for gap in (None, 0.02, 0.2):
    with serial.Serial(os.ttyname(slave), 19200, timeout=5, inter_byte_timeout=gap) as port:
        writer = threading.Thread(target=line)
        began = time.monotonic()
        writer.start()
        octets = port.read(32)
        whole = time.monotonic() - began >= 5
        writer.join()
    check(f"inter_byte_timeout={gap}, octets", octets.hex(" "), (REQUEST + ANSWER).hex(" "))
    check(f"inter_byte_timeout={gap}, waited for the whole timeout", whole, True)
PYTHON
echo 'as described: pyserial 3.5 on Linux joins telegrams in spite of inter_byte_timeout'
