#!/usr/bin/env bash
# minimalmodbus 2.1.1: write_register() with decimals writes a value that is one step too low.
#
# Expected: write_register(address, 0.29, number_of_decimals=2) writes 29: the documentation says that the value is multiplied by 100.
#
# Seen: the product is cut, not rounded. 0.29 * 100 is 28.999999999999996 in binary, so 28 is written; 1.15 becomes 114. With two
# decimals 69 of the 1000 values from 0.00 to 9.99 are written too low. Negative values are cut towards zero. read_register() then gives
# 0.28; nothing is raised.
#
# Why it matters: Modbus controllers hold set points, hysteresis and calibration factors of gauges as scaled integers. The set
# point differs from the recipe by one step, and a comparison of the value read back with the value written fails for some values only.
# Round first and write the integer with number_of_decimals=0.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check minimalmodbus==2.1.1 pyserial==3.5

timeout 60 "$folder/venv/bin/python" - <<'PYTHON'
import sys

import minimalmodbus


class Register:
    """A port with one Modbus register behind it: echoes function 6 and answers function 3 with the register."""

    port, baudrate, timeout, is_open = "register", 19200, 1, True
    value, answer = 0, b""

    def open(self):
        pass

    close = open

    def write(self, request):
        if request[1] == 6:
            self.value = int.from_bytes(request[4:6], "big")
            self.answer = request
        else:
            # Address 1, function 3, two octets of data and the check sum of the library itself.
            octets = bytes([1, 3, 2]) + self.value.to_bytes(2, "big")
            self.answer = octets + minimalmodbus._calculate_crc(octets)

    def read(self, count):
        octets, self.answer = self.answer[:count], self.answer[count:]
        return octets


def check(what, seen, expected):
    print(f"{what}: {seen}")
    if seen != expected:
        sys.exit(f"minimalmodbus changed: {what} was {expected}")


register = Register()
device = minimalmodbus.Instrument(register, 1)
device.clear_buffers_before_each_transaction = False


def written(value, decimals, signed=False):
    device.write_register(0, value, decimals, functioncode=6, signed=signed)
    return register.value - 0x10000 if signed and register.value > 0x7FFF else register.value


check("0.29 with two decimals", written(0.29, 2), 28)
check("read back", device.read_register(0, 2), 0.28)
check("1.15 with two decimals", written(1.15, 2), 114)
check("-0.29 with two decimals", written(-0.29, 2, signed=True), -28)
low = sum(written(number / 100, 2) == number - 1 for number in range(1000))
check("too low by one, of the 1000 values up to 9.99", low, 69)
PYTHON
echo 'as described: minimalmodbus 2.1.1 cuts a value with decimals instead of rounding it'
