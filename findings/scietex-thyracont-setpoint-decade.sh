#!/usr/bin/env bash
# scietex.hal.vacuum_gauge 2.5.0: a set point of 1e-6 mbar goes to a Thyracont gauge as another number.
#
# Expected: set_setpoint(1, 1e-6) writes 100014: four digits of mantissa and the exponent plus 20, the format of Thyracont's protocol
# version 1 that the library itself documents. get_setpoint() then gives 1e-6.
#
# Seen: it writes 1000013, a mantissa of five digits, which is no pressure in this format: get_setpoint() gives None. 1e-6 in binary is
# 9.99999999999999954748e-07; the library takes the exponent from these digits and rounds the mantissa afterwards, so 9.9999... becomes
# 10000 with the exponent of the decade below. 1e-7 goes the same way; 1e-3, 1e-4 and 1e-5 are right because their binary numbers lie
# above the decimal ones. set_setpoint() raises nothing. set_pressure(), the command for the adjustment, uses the same code.
#
# Why it matters: set points of vacuum gauges are mostly whole decades, and this one switches a valve or a pump. What a gauge makes of the
# seventh digit is not in its protocol. Read each set point back, and write 1.001e-6 for 1e-6.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check scietex.hal.vacuum_gauge==2.5.0 scietex.hal.serial==2.4.0 \
    scietex.hal.analog_sensor==1.0.1 pymodbus==3.16.1

timeout 60 "$folder/venv/bin/python" - <<'PYTHON'
import asyncio
import struct
import sys

from scietex.hal.vacuum_gauge.thyracont.modbus.v1 import ThyracontModbusV1Gauge

SETPOINT_1, SETPOINT_VALUE = 2, 11
registers = [0] * 16
left = asyncio.Event()


async def gateway(reader, writer):
    """Modbus TCP with functions 3, 6 and 16 on the registers; a written set point can be read as set point 1."""
    while header := await reader.read(7):
        transaction, _, length, unit = struct.unpack(">HHHB", header)
        request = await reader.readexactly(length - 1)
        function, address, number = struct.unpack(">BHH", request[:5])
        if function == 3:
            data = struct.pack(f">{number}H", *registers[address : address + number])
            answer = bytes([function, len(data)]) + data
        elif function == 6:
            registers[address] = number
            answer = request
        else:
            registers[address : address + number] = struct.unpack(f">{number}H", request[6:])
            registers[SETPOINT_1 : SETPOINT_1 + 2] = registers[SETPOINT_VALUE : SETPOINT_VALUE + 2]
            answer = request[:5]
        writer.write(struct.pack(">HHHB", transaction, 0, len(answer) + 1, unit) + answer)
    writer.close()
    left.set()


async def main():
    server = await asyncio.start_server(gateway, "127.0.0.1", 0)
    gauge = ThyracontModbusV1Gauge("127.0.0.1", port=server.sockets[0].getsockname()[1], timeout=10)
    await gauge.connect()
    failure = None
    for pressure, expected in (
        (5e-6, (500014, 5e-6)),
        (1e-3, (100017, 1e-3)),
        (1e-5, (100015, 1e-5)),
        (1e-6, (1000013, None)),
        (1e-7, (1000012, None)),
        (1.001e-6, (100114, 1.001e-6)),
    ):
        await gauge.set_setpoint(1, pressure)
        low, high = registers[SETPOINT_VALUE : SETPOINT_VALUE + 2]
        seen = (high << 16 | low, await gauge.get_setpoint(1))
        print(f"set point {pressure:g} mbar: written {seen[0]}, read back {seen[1]}")
        if seen != expected:
            failure = f"scietex.hal.vacuum_gauge changed: {pressure:g} mbar was {expected}"
    await gauge.close()
    await left.wait()
    server.close()
    return failure


sys.exit(asyncio.run(main()))
PYTHON
echo 'as described: scietex.hal.vacuum_gauge 2.5.0 writes set points of 1e-6 and 1e-7 mbar that are no pressures'
