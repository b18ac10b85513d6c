#!/usr/bin/env python3
"""Memory and processor time of a station by its parts: ci/gateways/cost.py PROGRAM [SECONDS [PART ...]]

PART: `segments` (1, 8 and 16), `gauges` (0, 1, 10 and 30 on one segment), `streams` (0, 8 and 32 live streams as a browser reads
them), `gateways` (none and each of them alone, without clients); all of them if no part is named. A segment has 30 gauges at 200 ms, unless
the part is `gauges`; `streams` and `gateways` have 8 segments. The gauges are processes behind TCP ports, so that the numbers are those of the
station alone.

Each row is a station of its own that has run for SETTLE_S, measured for SECONDS (120): memory at the end, with and without what the flight
recorders took, and processor time as a share of one core and for each exchange of data. PROGRAM has the feature opcua; mosquitto is
installed. Not part of ./test.
"""

import os
import socket
import subprocess
import sys
import tempfile
import threading
import time

from bounds import Recorders, fetched, processor_seconds
from load import GAUGES, Gauges, exchanging, write_lone_plant
from plant import free_port, wait_for

SETTLE_S = 30
# As contrib/debian/profivac.service starts a station.
ENVIRONMENT = {"MALLOC_MMAP_THRESHOLD_": "131072"}

GATEWAYS = {
    "none": "",
    "EPICS": "[epics]\nca-port = {}\npva-port = {}\npva-search-port = {}\n",
    "OPC UA": '[opcua]\nlisten = "127.0.0.1:{}"\n',
    "MQTT": '[mqtt]\nbroker = "mqtt://127.0.0.1:{broker}"\n',
    "MQTT with Sparkplug": '[mqtt]\nbroker = "mqtt://127.0.0.1:{broker}"\n\n[mqtt.sparkplug]\ngroup = "load"\n',
    "Modbus": '[modbus]\nlisten = "127.0.0.1:{}"\n',
    "Prometheus": '[prometheus]\nlisten = "127.0.0.1:{}"\n',
}


class Stream:
    """A live stream as a browser gets it, compressed; read and thrown away."""

    def __init__(self, url):
        host, port = url.removeprefix("http://").split(":")
        self.socket, self.octets, self.is_open = socket.create_connection((host, int(port)), 60), 0, True
        self.socket.sendall(b"GET /api/live HTTP/1.1\r\nHost: localhost\r\nAccept-Encoding: gzip\r\n\r\n")
        assert self.socket.recv(12) == b"HTTP/1.1 200", "the station refused a live stream"
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        while octets := self.socket.recv(1 << 16):
            self.octets += len(octets)
        self.is_open = False


def status(pid):
    with open(f"/proc/{pid}/status") as file:
        return dict(line.split(":", 1) for line in file)


def exchanges(url, segments):
    """The exchanges of data of all gauges so far. The station reports them about once a second."""
    reports = [fetched(f"{url}/api/segments/s{number}/bus") for number in range(segments)]
    return sum(station["total"]["exchanges"] for report in reports for station in report["stations"])


def row(program, label, segments=8, gauges=GAUGES, tables="", streams=0, seconds=120.0):
    """A station with its gauges: starts it, measures it, and prints a row."""
    folder, lines = tempfile.mkdtemp(prefix="profivac-cost-"), Gauges(program, segments, gauges)
    station = subprocess.Popen(
        [program, "run", write_lone_plant(folder, lines.ports, gauges, tables), "--listen", "127.0.0.1:0"],
        stdout=subprocess.PIPE, text=True, env=os.environ | ENVIRONMENT)
    try:
        url = station.stdout.readline().split()[1]
        wait_for("data exchange with every gauge", lambda: exchanging(url) == segments * gauges)
        opened = [Stream(url) for _ in range(streams)]
        time.sleep(SETTLE_S)

        def counts():
            return processor_seconds(station.pid), exchanges(url, segments), sum(it.octets for it in opened), time.monotonic()

        before = counts()
        time.sleep(seconds)
        spent, exchanged, octets, passed = (new - old for new, old in zip(counts(), before))
        assert all(it.is_open for it in opened), "the station closed a live stream"
        found = status(station.pid)
        resident, heap = (int(found[name].split()[0]) / 1024 for name in ("VmRSS", "RssAnon"))
        recorders = Recorders(url, [f"s{number}" for number in range(segments)]).mib()
        text = (f"{label}: {resident:.1f} MiB resident, {heap:.1f} heap, of it {recorders:.1f} flight recorders, {heap - recorders:.1f} without; "
                f"{found['Threads'].strip()} threads; {100 * spent / passed:.1f} % of a core")
        if exchanged:
            text += f", {exchanged / passed:.0f} exchanges/s, {1e6 * spent / exchanged:.0f} us each"
        if streams:
            text += f"; {octets / passed / streams / 1000:.1f} kB/s for each stream"
        print(f"{text}; load of the computer {os.getloadavg()[0]:.1f}", flush=True)
    finally:
        station.terminate()
        station.wait()
        lines.close()
        subprocess.run(["rm", "-rf", folder], check=False)


def gateways(program, seconds):
    broker_port = free_port()
    broker = subprocess.Popen(["mosquitto", "-p", str(broker_port)], stderr=subprocess.DEVNULL)
    try:
        for name, tables in GATEWAYS.items():
            row(program, f"gateway {name}", tables=tables.format(*(free_port() for _ in range(3)), broker=broker_port), seconds=seconds)
    finally:
        broker.terminate()
        broker.wait()


def main():
    program, seconds = os.path.abspath(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 120
    parts = sys.argv[3:] or ["segments", "gauges", "streams", "gateways"]
    for part in parts:
        if part == "segments":
            for count in (1, 8, 16):
                row(program, f"segments {count}", segments=count, seconds=seconds)
        elif part == "gauges":
            for count in (0, 1, 10, 30):
                row(program, f"gauges {count}", segments=1, gauges=count, seconds=seconds)
        elif part == "streams":
            for count in (0, 8, 32):
                row(program, f"streams {count}", streams=count, seconds=seconds)
        elif part == "gateways":
            gateways(program, seconds)
        else:
            raise SystemExit(f"expected segments, gauges, streams or gateways, found {part}")


if __name__ == "__main__":
    main()
