#!/usr/bin/env bash
# pylablib 1.4.5: an ITR90 with a broken sensor reports the error "ok".
#
# Expected: the `error` of get_update() is "BA_error" when the gauge reports a Bayard-Alpert error. The driver has the three error codes of
# the manual (5 Pirani adjusted poorly, 8 BA error, 9 Pirani error). Leybold GA09420 4.6.1.1 puts them into bits 7 to 4 of octet 3 of the
# output string, and marks bits 3 to 0 as not used.
#
# Seen: the driver looks into bits 3 to 0. Each of the three errors is "ok", and the pressure comes as from a sound gauge. A gauge that sets one
# of the unused bits gets an error that it does not have, or a KeyError.
#
# Why it matters: the ITR90 is the BPG400 under another name. Whoever compares the values of the bus with those of this driver sees a healthy gauge,
# while PROFIBUS reports the defect. Until that changes, read octet 3 yourself.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pylablib==1.4.5 pyserial==3.5 'setuptools<81'

timeout 60 "$folder/venv/bin/python" - <<'PYTHON'
import os
import sys
import threading
import time
import tty

from pylablib.devices import Leybold


def output_string(error):
    # Length, page 5; status: emission 25 uA, mbar; error; 20000 = 10^(20000/4000 - 12.5) mbar; version; sensor type 10; check sum.
    octets = [5, 0x01, error, 20000 >> 8, 20000 & 0xFF, 20, 10]
    return bytes([7, *octets, sum(octets) % 256])


master, slave = os.openpty()
tty.setraw(master)
error = 0x00


def gauge_sends():
    while True:
        os.write(master, output_string(error))
        time.sleep(0.02)


threading.Thread(target=gauge_sends, daemon=True).start()
gauge = Leybold.ITR90((os.ttyname(slave), 9600))
failure = None
for error, words in ((0x00, "no error"), (0x50, "Pirani adjusted poorly"), (0x80, "BA error"), (0x90, "Pirani error")):
    time.sleep(0.5)
    gauge.instr.flush_read()
    seen = gauge.get_update()
    print(f"error byte {error:02X} ({words}): error {seen.error!r}, {seen.value / 100:.2e} mbar")
    if (seen.error, f"{seen.value:.2e}") != ("ok", "3.16e-06"):
        failure = f"pylablib changed: error byte {error:02X} gave {seen.error!r} and {seen.value:.2e} Pa"
sys.stdout.flush()
if failure:
    print(failure, file=sys.stderr)
os._exit(1 if failure else 0)
PYTHON
echo 'as described: pylablib 1.4.5 calls each error of an ITR90 "ok"'
