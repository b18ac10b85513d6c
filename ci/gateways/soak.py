#!/usr/bin/env python3
"""A station with everything enabled, for hours: ci/gateways/soak.py PROGRAM [MINUTES] [SEGMENTS]

SEGMENTS (24) lines of four virtual gauges, so that sixty minutes (MINUTES) are a day of bus time; recorder, alarms, a webhook whose server
refuses every third notification, and every gateway. All the time gauges lose power, break and are mended, lines are cut, pressures cross the
limits of alarms, and clients of each protocol, of the API and of the live stream come and go. Prints a row in each minute: memory, files,
threads, disk, cycles. Ends with 1 when memory, files or threads still grow in the second half, when the disk grows faster than its
samples, or when a gauge does not exchange data at the end. PROGRAM has the feature opcua; mosquitto is installed.
"""

import http.server
import json
import os
import random
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request

import load
from plant import free_port, wait_for

DEVICES = {5: "bcg450", 6: "psg550", 7: "tpg300", 8: "img400"}
FAULTS = {5: "eeprom", 6: "eeprom", 7: "eeprom", 8: "eeprom"}
MIB = 1 << 20
# The flight recorder of a segment, and its captures on the disk: docs/listening.md.
CAPTURES_MIB = 256


class Lines:
    """The processes with the virtual gauges, one for each segment. A line that is cut is a process that ended; it comes back at its port."""

    def __init__(self, program, count):
        self.program, self.ports = program, [free_port() for _ in range(count)]
        self.processes = [None] * count
        for number in range(count):
            self.start(number)

    def start(self, number):
        devices = [f"{device}@{address}" for address, device in DEVICES.items()]
        self.processes[number] = subprocess.Popen(
            [self.program, "simulate", "--tcp", f"127.0.0.1:{self.ports[number]}", "--baud", "187500", *devices],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, text=True)

    def cut(self, number):
        self.processes[number].kill()
        self.processes[number].wait()

    def tell(self, number, line):
        self.processes[number].stdin.write(line + "\n")
        self.processes[number].stdin.flush()

    def close(self):
        for number in range(len(self.processes)):
            self.cut(number)


class Sink(http.server.BaseHTTPRequestHandler):
    """The server of the webhook."""

    count = 0

    def do_POST(self):
        Sink.count += 1
        self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(503 if Sink.count % 3 == 0 else 204)
        self.end_headers()

    def log_message(self, *_):
        pass


def write_plant(folder, ports, lines, sink):
    """The file of the station."""
    text = ["[station]\nname = \"soak\"\ndatabase = \"soak.db\"\n"]
    for number, port in enumerate(lines.ports):
        text.append(f'[[segment]]\nname = "s{number}"\nport = "tcp://127.0.0.1:{port}"\nbaud = 187500\n')
        for address, device in DEVICES.items():
            text.append(f'[[segment.gauge]]\nname = "g{number}-{address}"\naddress = {address}\ndevice = "{device}"\npoll = "200ms"\n')
        text.append(f'[[alarm]]\nname = "high {number}"\ngauge = "g{number}-5"\nabove = "1e-2 mbar"\npriority = "high"\n')
    text.append(f'[[webhook]]\nurl = "http://127.0.0.1:{sink}/"\n')
    modbus, prometheus, ca, pva, opcua, broker = ports
    text.append(f'[epics]\nca-port = {ca}\npva-port = {pva}\npva-search-port = {free_port()}\n\n[opcua]\nlisten = "127.0.0.1:{opcua}"\n')
    text.append(f'[mqtt]\nbroker = "mqtt://127.0.0.1:{broker}"\n\n[mqtt.sparkplug]\ngroup = "soak"\n')
    text.append(f'[modbus]\nlisten = "127.0.0.1:{modbus}"\n\n[prometheus]\nlisten = "127.0.0.1:{prometheus}"\n')
    path = os.path.join(folder, "plant.toml")
    with open(path, "w", opener=lambda path, flags: os.open(path, flags, 0o600)) as file:
        file.write("\n".join(text))
    return path


class Repeated(threading.Thread):
    """Does something again and again until the end. A connection that the other side closes is no fault: lines and clients come and go."""

    def __init__(self, name, work, ended):
        super().__init__(daemon=True)
        self.name, self.work, self.ended, self.count, self.last = name, work, ended, 0, None

    def run(self):
        while not self.ended.is_set():
            try:
                self.work()
                self.count += 1
            except (OSError, AssertionError, ValueError, urllib.error.HTTPError) as error:
                self.last = error
                self.ended.wait(0.5)


def disturb(lines, ended, source):
    """One disturbance of a line or a gauge, and its end."""
    number, address = source.randrange(len(lines.ports)), source.choice(list(DEVICES))
    kind = source.choice(["pressure", "pressure", "pressure", "power", "fault", "cut"])
    if kind == "pressure":
        lines.tell(number, f"pressure {10 ** source.uniform(-7, 2):.3e} mbar")
        ended.wait(1)
    elif kind == "power":
        lines.tell(number, f"power {address} off")
        ended.wait(3)
        lines.tell(number, f"power {address} on")
    elif kind == "fault":
        lines.tell(number, f"fault {address} {FAULTS[address]}")
        ended.wait(3)
        lines.tell(number, f"clear {address} {FAULTS[address]}")
    else:
        lines.cut(number)
        ended.wait(2)
        lines.start(number)


def clients(url, ports, count):
    """What clients do, by name: each comes, reads for some seconds, and goes."""

    def read(path, seconds=0):
        end = time.monotonic() + seconds
        with urllib.request.urlopen(url + path, timeout=60) as answer:
            while answer.read1(1 << 16) and (not seconds or time.monotonic() < end):
                pass

    with urllib.request.urlopen(url + "/api/session", timeout=60) as answer:
        token = json.load(answer)

    def drain(make):
        it = make()
        try:
            load.drained([it], 5)
        finally:
            it.close()

    def opcua():
        it = load.OpcUaSubscriber(ports[4], False)
        try:
            load.take_all([it], 5)
        finally:
            it.socket.close()

    def ask(port, request):
        with socket.create_connection(("127.0.0.1", port), 30) as it:
            for _ in range(10):
                it.sendall(request)
                assert it.recv(1 << 20)
                time.sleep(0.2)

    def history():
        now = int(time.time() * 1000)
        times = f"from={now - 600_000}&to={now}"
        series = f"g{random.randrange(count)}-5"
        for path in ("gauges", "alarms", "station", f"events?{times}", f"trend?series={series}&{times}", f"export.csv?series={series}&{times}",
                     f"export.parquet?series={series}&{times}", f"report.html?series={series}&{times}"):
            read("/api/" + path)
        time.sleep(1)

    def note():
        body = json.dumps({"text": "soak"}).encode()
        headers = {"Content-Type": "application/json", "X-CSRF-Token": token["token"]}
        request = urllib.request.Request(url + "/api/notes", body, headers)
        with urllib.request.urlopen(request, timeout=60) as answer:
            answer.read()
        time.sleep(10)

    return {
        "API": history,
        "live stream": lambda: read("/api/live", 10),
        "note": note,
        "Channel Access": lambda: drain(lambda: load.ca_circuit(ports[2])),
        "PV Access": lambda: drain(lambda: load.pva_circuit(ports[3])),
        "OPC UA": opcua,
        "Modbus": lambda: ask(ports[0], bytes.fromhex("000100000006010400000014")),
        "Prometheus": lambda: ask(ports[1], b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n"),
        "MQTT": lambda: drain(lambda: load.mqtt_subscriber(ports[5])),
    }


class Row:
    """What the station holds at one moment."""

    def __init__(self, pid, folder, prometheus):
        with open(f"/proc/{pid}/status") as file:
            status = dict(line.split(":", 1) for line in file)
        self.memory = int(status["VmRSS"].split()[0]) / 1024
        self.threads = int(status["Threads"])
        self.files = len(os.listdir(f"/proc/{pid}/fd"))
        sizes = {name: size(os.path.join(folder, name)) for name in os.listdir(folder) if name.startswith("soak.db")}
        self.captures = sizes.pop("soak.db.captures", 0) / MIB
        self.database = sum(sizes.values()) / MIB
        with urllib.request.urlopen(f"http://127.0.0.1:{prometheus}/metrics", timeout=60) as answer:
            lines = answer.read().decode().splitlines()
        self.cycles = total("profivac_segment_cycle_seconds_count{", lines)
        self.lost = total("profivac_device_lost_cycles_total{", lines)

    def text(self, minute):
        return (f"{minute:4} min  {self.memory:6.0f} MiB  {self.files:4} files  {self.threads:3} threads  database {self.database:6.1f} MiB  "
                f"captures {self.captures:6.1f} MiB  {self.cycles:.0f} cycles, {self.lost:.0f} lost")


def total(start, lines):
    return sum(float(line.rsplit(" ", 1)[1]) for line in lines if line.startswith(start))


def size(path):
    """The octets of a file, or of all files of a folder."""
    if os.path.isfile(path):
        return os.path.getsize(path)
    return sum(os.path.getsize(os.path.join(folder, name)) for folder, _, names in os.walk(path) for name in names)


def grown(rows, segments):
    """What grows without end: the second half of the rows is compared with the first."""
    first, second = rows[len(rows) // 4 : len(rows) // 2], rows[len(rows) // 2 :]
    found = []
    for name, room in [("files", 10), ("threads", 5)]:
        before, after = max(getattr(row, name) for row in first), max(getattr(row, name) for row in second)
        if after > before + room:
            found.append(f"{name} grew from {before} to {after}")
    if second[-1].captures > CAPTURES_MIB * segments:
        found.append(f"captures have {second[-1].captures:.0f} MiB")
    return found


def main():
    program = os.path.abspath(sys.argv[1])
    minutes, segments = (int(sys.argv[2]) if len(sys.argv) > 2 else 60), (int(sys.argv[3]) if len(sys.argv) > 3 else 24)
    load.GAUGE_NAMES = [f"G{number}-{address}" for number in range(segments) for address in DEVICES]
    folder, ports = tempfile.mkdtemp(prefix="profivac-soak-"), [free_port() for _ in range(6)]
    sink = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Sink)
    threading.Thread(target=sink.serve_forever, daemon=True).start()
    broker = subprocess.Popen([shutil.which("mosquitto") or "/usr/sbin/mosquitto", "-p", str(ports[5])], stderr=subprocess.DEVNULL)
    lines = Lines(program, segments)
    plant = write_plant(folder, ports, lines, sink.server_port)
    station = subprocess.Popen([program, "run", plant, "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True)
    found = ["it did not come to its end"]
    try:
        url = station.stdout.readline().split()[1]

        def exchanging():
            with urllib.request.urlopen(url + "/api/gauges", timeout=60) as answer:
                states = [gauge["state"] for gauge in json.load(answer)]
            return len(states) == segments * len(DEVICES) and all(state == "data-exchange" for state in states)

        wait_for("data exchange of all gauges", exchanging)
        ended, source = threading.Event(), random.Random(25)
        work = {"disturbances": lambda: disturb(lines, ended, source), **clients(url, ports, segments)}
        threads = [Repeated(name, it, ended) for name, it in work.items()]
        for thread in threads:
            thread.start()
        rows = []
        for minute in range(minutes):
            ended.wait(60)
            rows.append(Row(station.pid, folder, ports[1]))
            print(rows[-1].text(minute + 1), flush=True)
        ended.set()
        for thread in threads:
            thread.join(120)
            print(f"{thread.name}: {thread.count} times" + (f", last error: {thread.last!r}" if thread.last else ""), flush=True)
        found = grown(rows, segments)
        found += [f"{thread.name} never worked: {thread.last!r}" for thread in threads if not thread.count]
        wait_for("data exchange of all gauges at the end", exchanging)
        print(f"{segments * minutes / 60:.1f} hours of bus time; {Sink.count} notifications", flush=True)
    finally:
        station.terminate()
        station.wait()
        lines.close()
        broker.kill()
        broker.wait()
        shutil.rmtree(folder, ignore_errors=True)
        for line in found:
            print(line, flush=True)
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
