#!/usr/bin/env bash
# asyncua 2.1.0: a server with an absolute deadband hides a slow leak, a broken sensor and the value after NaN.
#
# Expected: a client that calls deadband_monitor() is told when the value is further than the deadband from the value it was told last, and
# when the status code changes. OPC UA part 4, DataChangeFilter: "Absolute" compares with the last cached value, which is the last one that
# was put into the queue of the client; the deadband decides about values, the trigger STATUS_VALUE about the status.
#
# Seen: the server compares each sample with the sample before it. A pressure that goes from 1 to 9 in steps of 0.4 is never reported with a
# deadband of 0.5. BadSensorFailure and the return from it are never reported: the server sets the value to null, cannot subtract it, logs a
# TypeError and drops the notification. NaN and the first number after it are dropped as well.
#
# Why it matters: a leak is a slow rise, and gateways set a bad status or NaN when a gauge fails. The client keeps the last good pressure
# without any sign. Subscribe without a deadband, or read the value from time to time as well.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check asyncua==2.1.0 anyio==4.16.0 wait_for2==0.4.1 \
    sortedcontainers==2.4.0 cryptography==50.0.2

timeout 120 "$folder/venv/bin/python" - <<'PYTHON'
import asyncio
import logging
import math
import socket
import sys

from asyncua import Client, Server, ua

logging.disable(logging.CRITICAL)
DEADBAND = 0.5
BAD = ua.DataValue(ua.Variant(9.0, ua.VariantType.Double), ua.StatusCode(ua.StatusCodes.BadSensorFailure))
STEPS = (
    ("a step from 1 to 0", [0.0], ["0 Good"]),
    ("back to 1", [1.0], ["1 Good"]),
    ("a rise from 1 to 9 in steps of 0.4", [1 + 0.4 * step for step in range(1, 21)], []),
    ("a broken sensor", [BAD], []),
    ("the sensor is good again, at 5", [5.0], []),
    ("a step to 7", [7.0], ["7 Good"]),
    ("NaN", [math.nan], []),
    ("3 after NaN", [3.0], []),
    ("a step to 5", [5.0], ["5 Good"]),
)


class Heard:
    def __init__(self):
        self.told = {"pressure": [], "mark": []}
        self.marked = asyncio.Event()

    def datachange_notification(self, node, value, data):
        name = "mark" if node == self.mark else "pressure"
        text = "null" if value is None else f"{value:g}"
        self.told[name].append(f"{text} {data.monitored_item.Value.StatusCode.name}")
        if name == "mark":
            self.marked.set()


async def main():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"opc.tcp://127.0.0.1:{free.getsockname()[1]}/"
    server = Server()
    await server.init()
    server.set_endpoint(address)
    pressure = await server.nodes.objects.add_variable(2, "Pressure", 1.0)
    mark = await server.nodes.objects.add_variable(2, "Mark", 0.0)
    async with server, Client(address) as client:
        heard = Heard()
        heard.mark = client.get_node(mark.nodeid)
        subscription = await client.create_subscription(20, heard)
        await subscription.deadband_monitor(client.get_node(pressure.nodeid), DEADBAND, queuesize=100)
        await subscription.subscribe_data_change(heard.mark)
        # The mark is written after the pressures and shares their subscription: when it is heard, so is everything before it.
        await heard.marked.wait()
        print("first value:", heard.told["pressure"])
        if heard.told["pressure"] != ["1 Good"]:
            sys.exit(f"asyncua changed: the first value was {heard.told['pressure'] or 'nothing'}")
        for number, (what, values, expected) in enumerate(STEPS, 1):
            heard.told["pressure"].clear()
            heard.marked.clear()
            for value in values:
                await pressure.write_value(value)
            await mark.write_value(float(number))
            await heard.marked.wait()
            seen = heard.told["pressure"]
            print(f"{what}: {seen or 'nothing'}")
            if seen != expected:
                sys.exit(f"asyncua changed: {what} was {expected or 'nothing'}")


asyncio.run(main())
PYTHON
echo 'as described: a deadband of asyncua 2.1.0 hides slow changes, bad status codes and the value after NaN'
