#!/usr/bin/env python3
"""A client of each protocol that stalls for a minute, then hostile clients at each listener: ci/gateways/stall.py PROGRAM [SECONDS|--together]

A station with 120 virtual gauges at 5 Hz. For each protocol one client subscribes or asks and takes no octets for
SECONDS (60), while another one of the same protocol works; the broker of MQTT is stopped for that time. Then 1,000 connects a second,
half-open connections and random octets at each listener. Prints for each how long the longest wait of the working client was, how many
cycles the segments did and lost meanwhile, and the memory of the station. Ends with 1 when a working client got nothing for ten seconds.
The first line is the station without clients. PROGRAM has the feature opcua; mosquitto is installed.

That takes seven minutes. `./test` has --together: 30 gauges, all six clients stall in the same minute, and no hostile ones.
"""

import os
import selectors
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request

import load
from plant import Hostile, free_port, wait_for

LONGEST_WAIT_S = 10
IS_TOGETHER = sys.argv[2:] == ["--together"]
load.SEGMENTS = 1 if IS_TOGETHER else 4
load.GAUGE_NAMES = load.GAUGE_NAMES[:load.SEGMENTS * load.GAUGES]
READ = struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, 0, 20)
SCRAPE = b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n"
PROTOCOLS = ("Channel Access", "PV Access", "OPC UA", "Modbus", "Prometheus", "MQTT")


class Plain:
    """A client over a socket; `request` is sent each half second."""

    def __init__(self, it, request=None):
        self.socket, self.request = it, request

    def take(self, _octets):
        pass


def client(protocol, ports, is_working):
    """A client; one that stalls has asked for more than all buffers hold."""
    modbus, prometheus, ca, pva, opcua, broker = ports
    if protocol == "Channel Access":
        return Plain(load.ca_circuit(ca))
    if protocol == "PV Access":
        return Plain(load.pva_circuit(pva))
    if protocol == "OPC UA":
        it = load.OpcUaSubscriber(opcua, False)
        for _ in range(0 if is_working else 60):
            it.publish()
        return it
    if protocol == "MQTT":
        return Plain(load.mqtt_subscriber(broker))
    port, request = (modbus, READ) if protocol == "Modbus" else (prometheus, SCRAPE)
    it = socket.create_connection(("127.0.0.1", port), 30)
    if not is_working:
        it.setblocking(False)
        try:
            while True:
                it.send(request * 100)
        except OSError:
            pass
    return Plain(it, request)


def longest_wait(it, seconds):
    """Serves a client; returns the longest time without octets."""
    selector, longest = selectors.DefaultSelector(), 0.0
    it.socket.setblocking(False)
    selector.register(it.socket, selectors.EVENT_READ)
    begin = last = asked = time.monotonic()
    while time.monotonic() < begin + seconds:
        if getattr(it, "request", None) and time.monotonic() > asked + 0.5:
            asked = time.monotonic()
            it.socket.send(it.request)
        for _ in selector.select(0.1):
            chunk = it.socket.recv(1 << 20)
            assert chunk, "the server closed the connection of the working client"
            longest, last = max(longest, time.monotonic() - last), time.monotonic()
            it.take(chunk)
    return max(longest, time.monotonic() - last)


class Figures:
    """What the segments have done, from /metrics, and the memory of the process."""

    def __init__(self, port, pid):
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=60) as answer:
            lines = answer.read().decode().splitlines()
        self.lost = self.sum("profivac_device_lost_cycles_total{", lines)
        self.cycles = self.sum("profivac_segment_cycle_seconds_count{", lines)
        self.seconds = self.sum("profivac_segment_cycle_seconds_sum{", lines)
        with open(f"/proc/{pid}/status") as file:
            self.kb = next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))

    @staticmethod
    def sum(start, lines):
        return sum(float(line.rsplit(" ", 1)[1]) for line in lines if line.startswith(start))

    def text(self, before):
        cycles, lost = self.cycles - before.cycles, self.lost - before.lost
        mean = (self.seconds - before.seconds) / max(1, cycles) * 1e3
        return f"{cycles:.0f} cycles of {mean:.1f} ms, {lost:.0f} lost, memory {before.kb // 1024} to {self.kb // 1024} MiB"


def stalled(protocol, ports, pid, broker, seconds):
    before = Figures(ports[1], pid)
    working, stalls = client("Prometheus" if protocol == "MQTT" else protocol, ports, True), client(protocol, ports, False)
    if protocol == "MQTT":
        broker.send_signal(signal.SIGSTOP)
    wait = longest_wait(working, seconds)
    if protocol == "MQTT":
        broker.send_signal(signal.SIGCONT)
    after = Figures(ports[1], pid)
    print(f"{protocol}: a client stalled for {seconds:.0f} s; the other waited at most {wait:.1f} s; {after.text(before)}", flush=True)
    working.socket.close()
    stalls.socket.close()
    return wait < LONGEST_WAIT_S


def together(ports, pid, broker, seconds):
    """All clients stall in the same time, each beside a working one of its protocol."""
    before, waits = Figures(ports[1], pid), {}
    pairs = {it: (client("Prometheus" if it == "MQTT" else it, ports, True), client(it, ports, False)) for it in PROTOCOLS}
    broker.send_signal(signal.SIGSTOP)

    def measure(protocol):
        waits[protocol] = longest_wait(pairs[protocol][0], seconds)

    threads = [threading.Thread(target=measure, args=(it,)) for it in PROTOCOLS]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    after = Figures(ports[1], pid)
    texts = ", ".join(f"{it} {waits[it]:.1f} s" if it in waits else f"{it} failed" for it in PROTOCOLS)
    print(f"a client of each protocol stalled for {seconds:.0f} s; the others waited at most: {texts}; {after.text(before)}", flush=True)
    for it in (it for pair in pairs.values() for it in pair):
        it.socket.close()
    assert after.cycles > before.cycles, "the segments have stopped"
    return all(waits.get(it, LONGEST_WAIT_S) < LONGEST_WAIT_S for it in PROTOCOLS)


def attacked(protocol, port, ports, pid, seconds):
    before = Figures(ports[1], pid)
    working = client(protocol, ports, True)
    with Hostile(port, [READ * 500, SCRAPE[:20] + b"a" * 100_000, b"\xca\x02\x00\x07\xff\xff\xff\x7f", b"HELF\xff\xff\xff\xff"]) as hostile:
        wait = longest_wait(working, seconds)
    after = Figures(ports[1], pid)
    rate = hostile.made / hostile.seconds
    print(f"{protocol}: {rate:.0f} hostile connections a second for {seconds:.0f} s; the other waited at most {wait:.1f} s; {after.text(before)}", flush=True)
    working.socket.close()
    return wait < LONGEST_WAIT_S


def main():
    program, seconds = os.path.abspath(sys.argv[1]), 60 if IS_TOGETHER or len(sys.argv) < 3 else float(sys.argv[2])
    folder, ports = tempfile.mkdtemp(prefix="profivac-stall-"), [free_port() for _ in range(6)]
    broker = subprocess.Popen([shutil.which("mosquitto") or "/usr/sbin/mosquitto", "-p", str(ports[5])], stderr=subprocess.DEVNULL)
    station = subprocess.Popen([program, "run", load.write_plant(folder, ports), "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True)
    good = True
    try:
        station.stdout.readline()

        def measuring():
            with urllib.request.urlopen(f"http://127.0.0.1:{ports[1]}/metrics") as answer:
                return answer.read().count(b"\nprofivac_reading_pressure_pascals{") == load.SEGMENTS * load.GAUGES

        wait_for("all pressures", measuring)
        if IS_TOGETHER:
            sys.exit(0 if together(ports, station.pid, broker, seconds) else 1)
        before = Figures(ports[1], station.pid)
        time.sleep(seconds / 3)
        print(f"without clients: {Figures(ports[1], station.pid).text(before)}", flush=True)
        for protocol in PROTOCOLS:
            good &= stalled(protocol, ports, station.pid, broker, seconds)
        for protocol, port in zip(("Channel Access", "PV Access", "OPC UA", "Modbus", "Prometheus"), (ports[2], ports[3], ports[4], ports[0], ports[1])):
            good &= attacked(protocol, port, ports, station.pid, seconds / 3)
    finally:
        broker.send_signal(signal.SIGCONT)
        station.terminate()
        station.wait()
        broker.kill()
        broker.wait()
        subprocess.run(["rm", "-rf", folder], check=False)
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
