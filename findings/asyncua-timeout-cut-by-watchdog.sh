#!/usr/bin/env bash
# asyncua 2.1.0: a client with a long timeout loses its connection when one answer takes longer than a second.
#
# Expected: Client(url, timeout=30) waits up to 30 s for each answer. "Each request sent to the server expects an answer within this time."
#
# Seen: while the server works for 3 s on a method, the client gives the connection up. The call itself returns; every later request fails
# with ConnectionError, "client is disconnected". The watchdog reads the state of the server each second (watchdog_intervall=1.0) and gives
# that read the same second, whatever the timeout is. With watchdog_intervall=30 the client stays connected.
#
# Why it matters: a small server of a gauge or a PLC often answers one request after the other. A long read of history or the creation of a
# thousand monitored items then ends the session with its subscriptions, on a busy computer only.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check asyncua==2.1.0 anyio==4.16.0 wait_for2==0.4.1 \
    sortedcontainers==2.4.0 cryptography==50.0.2

cat > "$folder/server.py" <<'PYTHON'
import asyncio
import logging
import time

from asyncua import Server, ua, uamethod

logging.disable(logging.CRITICAL)


@uamethod
def work(_, seconds):
    time.sleep(seconds)
    return seconds


async def main():
    server = Server()
    await server.init()
    server.set_endpoint("opc.tcp://127.0.0.1:0/")
    kinds = [ua.VariantType.Double]
    await server.nodes.objects.add_method(ua.NodeId("work", 2), ua.QualifiedName("work", 2), work, kinds, kinds)
    async with server:
        print(server.bserver._server.sockets[0].getsockname()[1], flush=True)
        await asyncio.Event().wait()


asyncio.run(main())
PYTHON

timeout 120 "$folder/venv/bin/python" - "$folder/server.py" <<'PYTHON'
import asyncio
import logging
import subprocess
import sys

from asyncua import Client, ua

logging.disable(logging.CRITICAL)


async def outcome(port, **options):
    client = Client(f"opc.tcp://127.0.0.1:{port}/", timeout=30, **options)
    await client.connect()
    try:
        await client.nodes.objects.call_method(ua.NodeId("work", 2), 3.0)
        return ua.ServerState(await client.nodes.server_state.read_value()).name
    except Exception as error:
        return type(error).__name__
    finally:
        try:
            await client.disconnect()
        except Exception:
            pass


async def main():
    server = subprocess.Popen([sys.executable, sys.argv[1]], stdout=subprocess.PIPE, text=True)
    try:
        port = int(server.stdout.readline())
        usual = await outcome(port)
        patient = await outcome(port, watchdog_intervall=30)
    finally:
        server.kill()
    print(f"timeout 30 s, the request after one that took 3 s: {usual}; with watchdog_intervall 30: {patient}")
    sys.exit((usual, patient) != ("ConnectionError", "Running"))


asyncio.run(main())
PYTHON
