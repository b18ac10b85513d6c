#!/usr/bin/env bash
# pyserial 3.5 on Debian and its relatives: a pty opens with even parity once, and never again.
#
# Expected: the same answer each time. A pty has no parity: Linux drops PARENB from its settings and reports success. POSIX lets
# tcsetattr() succeed if it could carry out any part of the request. pyserial documents ValueError for a parameter out of range and
# SerialException for a device that cannot be configured.
#
# Seen: the first Serial(pty, parity="E") succeeds, without parity. The second one raises termios.error 22, which is no SerialException.
# All other settings are as wanted by then, so parity is the whole request; Debian has a patch in its C library (local-tcsetaddr)
# that reads the settings back and returns EINVAL if no part was carried out. Another baud rate makes the next opening succeed, once.
# Issue 196 of pyserial has the report and is open.
#
# Why it matters: every PROFIBUS character is 8E1, and masters are tried on ptys before there is hardware. A program that worked is refused at
# its next start. Open a pty with parity "N", or catch termios.error, too.
#
# Needs Linux with the C library of Debian or Ubuntu. With another one the second opening may succeed, and the script says so.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pyserial==3.5

"$folder/venv/bin/python" - <<'PYTHON'
import os
import sys
import termios

import serial


def opened(port, parity, rate):
    try:
        with serial.Serial(port, rate, parity=parity) as line:
            return "parity" if termios.tcgetattr(line.fd)[2] & termios.PARENB else "no parity"
    except termios.error as error:
        return f"termios.error {error.args[0]}, a SerialException: {isinstance(error, serial.SerialException)}"


master, slave = os.openpty()
port = os.ttyname(slave)
REFUSED = "termios.error 22, a SerialException: False"
OPENINGS = (("E", 9600, "no parity"), ("E", 9600, REFUSED), ("E", 19200, "no parity"), ("E", 19200, REFUSED), ("N", 19200, "no parity"))
for number, (parity, rate, expected) in enumerate(OPENINGS, 1):
    seen = opened(port, parity, rate)
    print(f"opening {number}, parity {parity}, {rate} bit/s: {seen}")
    if seen != expected:
        sys.exit(f"this C library or pyserial does otherwise: opening {number} was {expected}")
PYTHON
echo 'as described: pyserial 3.5 opens a pty with even parity once'
