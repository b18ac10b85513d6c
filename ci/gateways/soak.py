#!/usr/bin/env python3
"""A station with everything enabled, for hours: ci/gateways/soak.py PROGRAM [MINUTES [SEGMENTS] | --short]

SEGMENTS (24) lines of four virtual gauges, so that sixty minutes (MINUTES) are a day of bus time; on every eighth line another station is the
master, and this one only listens. Recorder, captures, alarms, users, an archive over HTTP, a webhook and a mail server, which refuse every third
notification and batch, and every gateway. All the time gauges lose power, break and are mended, lines are cut, pressures cross the limits of
alarms, the station reads its file again, and clients of each protocol, of the API and of the live stream come and go.

Prints a row in each minute. Ends with 1 when something passes its limit (bounds.py) while clients come and go, when files or threads are more
than before the first client after the last one has gone, when a client never succeeded, or when a gauge does not exchange data at the end.
PROGRAM has the features opcua and archive; mosquitto is installed. With --short: three lines, 75 seconds, a row every five.
"""

import http.client
import http.cookiejar
import http.server
import json
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request

import load
from bounds import FILES, THREADS, Recorders, Row, grown
from plant import free_port, wait_for

DEVICES = {5: "bcg450", 6: "psg550", 7: "tpg300", 8: "img400"}
FAULT = "eeprom"
USER, PASSWORD = "olga", "tin whisker plateau"
TOKEN = "a-token-of-the-archive"
# As contrib/debian/profivac.service starts a station.
ENVIRONMENT = {"MALLOC_MMAP_THRESHOLD_": "131072"}
# One line of this many belongs to another station.
LISTENED = 8


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
            [self.program, "simulate", "--tcp", f"127.0.0.1:{self.ports[number]}", "--baud", "19200", *devices],
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
    """The server of the webhook, and the archive: both refuse every third request."""

    asked = {"notifications": 0, "batches": 0}

    def do_POST(self):
        kind = "batches" if self.path.startswith("/v1/") else "notifications"
        Sink.asked[kind] += 1
        self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(503 if Sink.asked[kind] % 3 == 0 else 204)
        self.end_headers()

    def log_message(self, *_):
        pass


class Mail:
    """The mail server: it refuses every third message for the time being."""

    def __init__(self):
        peer = os.path.join(os.path.dirname(__file__), "../../crates/station/tests/peers/smtp_server.py")
        replies = ["250", "250", "451"] * 10_000
        self.process = subprocess.Popen(
            [sys.executable, peer, "none", "-", "-", *replies], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.port, self.count = int(self.process.stdout.readline()), 0
        threading.Thread(target=self.take, daemon=True).start()

    def take(self):
        for _ in self.process.stdout:
            self.count += 1


def is_listened(number, count):
    """Whether another station is the master of a line."""
    return number >= count - max(1, count // LISTENED)


def segments(lines, numbers, listens):
    """The tables of the lines with `numbers`, on which the station listens or is the master."""
    text = []
    for number in numbers:
        text.append(f'[[segment]]\nname = "s{number}"\nport = "tcp://127.0.0.1:{lines.ports[number]}"\nbaud = 19200\n')
        if listens:
            text.append("listen-only = true\n")
        for address, device in DEVICES.items():
            text.append(f'[[segment.gauge]]\nname = "g{number}-{address}"\naddress = {address}\ndevice = "{device}"\npoll = "1 s"\n')
    return text


def write(folder, name, text):
    path = os.path.join(folder, name)
    with open(path, "w", opener=lambda path, flags: os.open(path, flags, 0o600)) as file:
        file.write(text)
    return path


def write_plants(folder, plc_folder, ports, lines, sink, mail):
    """The files of the station, and of the one that is the master of the lines on which it listens."""
    count = len(lines.ports)
    listened = [number for number in range(count) if is_listened(number, count)]
    text = ["[station]\nname = \"soak\"\ndatabase = \"soak.db\"\n"]
    text += segments(lines, [number for number in range(count) if number not in listened], False) + segments(lines, listened, True)
    for number in range(count):
        text.append(f'[[alarm]]\nname = "high {number}"\ngauge = "g{number}-5"\nabove = "1e-2 mbar"\npriority = "high"\n')
    text.append(f'[[webhook]]\nurl = "http://127.0.0.1:{sink}/"\n')
    text.append(f'[[email]]\nname = "shift"\nserver = "127.0.0.1:{mail}"\nsecurity = "none"\nfrom = "soak@example.org"\nto = ["shift@example.org"]\n')
    write(folder, "archive.token", TOKEN)
    text.append(f'[archive]\nplant = "hall"\nstation = "soak"\n\n'
                f'[archive.https]\nurl = "http://127.0.0.1:{sink}"\ntoken-file = "archive.token"\n')
    modbus, prometheus, ca, pva, opcua, broker = ports
    text.append(f'[epics]\nca-port = {ca}\npva-port = {pva}\npva-search-port = {free_port()}\n\n[opcua]\nlisten = "127.0.0.1:{opcua}"\n')
    text.append(f'[mqtt]\nbroker = "mqtt://127.0.0.1:{broker}"\n\n[mqtt.sparkplug]\ngroup = "soak"\n')
    text.append(f'[modbus]\nlisten = "127.0.0.1:{modbus}"\n\n[prometheus]\nlisten = "127.0.0.1:{prometheus}"\n')
    plc = "\n".join(['[station]\nname = "plc"\n', *segments(lines, listened, False)])
    return write(folder, "plant.toml", "\n".join(text)), write(plc_folder, "plc.toml", plc)


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
            except urllib.error.HTTPError as error:
                self.last = f"{error.url}: {error.code} {error.read().decode()}"
                self.ended.wait(0.5)
            except (OSError, http.client.HTTPException, AssertionError, ValueError) as error:
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
        lines.tell(number, f"fault {address} {FAULT}")
        ended.wait(3)
        lines.tell(number, f"clear {address} {FAULT}")
    else:
        lines.cut(number)
        ended.wait(2)
        lines.start(number)


class Session:
    """A session of the user, with its cookies."""

    def __init__(self, url):
        self.url, self.opener = url, urllib.request.build_opener(urllib.request.HTTPCookieProcessor(http.cookiejar.CookieJar()))
        self.token = json.loads(self.get("/api/session"))["token"]
        self.token = json.loads(self.post("/api/login", {"name": USER, "password": PASSWORD}))["token"]

    def get(self, path):
        with self.opener.open(self.url + path, timeout=60) as answer:
            return answer.read()

    def post(self, path, body=None):
        headers = {"Content-Type": "application/json", "X-CSRF-Token": self.token or ""}
        with self.opener.open(urllib.request.Request(self.url + path, json.dumps(body or {}).encode(), headers), timeout=60) as answer:
            return answer.read()


def clients(url, ports, count, user, pause):
    """What clients do, by name: each comes, reads for some seconds, and goes; `pause` waits."""

    def read(path, seconds=0):
        end = time.monotonic() + seconds
        with urllib.request.urlopen(url + path, timeout=60) as answer:
            while answer.read1(1 << 16) and (not seconds or time.monotonic() < end):
                pass

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
                pause(0.2)

    def history():
        now = int(time.time() * 1000)
        times = f"from={now - 600_000}&to={now}"
        series = f"g{random.randrange(count)}-5"
        for path in ("gauges", "alarms", "station", f"events?{times}", f"trend?series={series}&{times}", f"export.csv?series={series}&{times}",
                     f"export.parquet?series={series}&{times}", f"report.html?series={series}&{times}"):
            read("/api/" + path)
        pause(1)

    def note():
        """The operator notes something and acknowledges all alarms."""
        user.post("/api/notes", {"text": "soak"})
        alarms = [{"name": alarm["name"], "occurrence": alarm["occurrence"]} for alarm in json.loads(user.get("/api/alarms"))]
        user.post("/api/alarms/acknowledge", {"alarms": alarms})
        pause(5)

    def login():
        """A browser comes and goes."""
        Session(url).post("/api/logout")
        pause(20)

    def capture():
        """The operator makes a capture, and reads the last one."""
        captures = f"/api/segments/s{random.randrange(count)}/captures"
        user.post(captures)
        pause(10)
        if found := json.loads(user.get(captures)):
            user.get(captures + "/" + found[-1]["name"])

    return {
        "API": history,
        "live stream": lambda: read("/api/live", 10),
        "note": note,
        "login": login,
        "capture": capture,
        "Channel Access": lambda: drain(lambda: load.ca_circuit(ports[2])),
        "PV Access": lambda: drain(lambda: load.pva_circuit(ports[3])),
        "OPC UA": opcua,
        "Modbus": lambda: ask(ports[0], bytes.fromhex("000100000006010400000014")),
        "Prometheus": lambda: ask(ports[1], b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n"),
        "MQTT": lambda: drain(lambda: load.mqtt_subscriber(ports[5])),
    }


def at_rest(row, before):
    """The row after the clients have gone, when it has no more files and threads than the one before they came. A pool of threads and
    of connections to the database grows with the first clients."""
    after = row()
    assert after.files <= before.files + FILES, f"{after.files} files, {before.files} before the clients"
    assert after.threads <= before.threads + THREADS, f"{after.threads} threads, {before.threads} before the clients"
    assert after.deleted <= before.deleted, f"{after.deleted} files are open that are deleted"
    return after


def main():
    program, rest = os.path.abspath(sys.argv[1]), sys.argv[2:]
    is_short = rest == ["--short"]
    minutes, count = (1.25, 3) if is_short else [int(given) for given in [*rest, *["60", "24"][len(rest):]]]
    every_s = 5 if is_short else 60
    # The controllers have readings of channels, with other names.
    load.GAUGE_NAMES = [f"G{number}-{address}" for number in range(count) for address in (5, 6)]
    folder, plc_folder = tempfile.mkdtemp(prefix="profivac-soak-"), tempfile.mkdtemp(prefix="profivac-plc-")
    ports = [free_port() for _ in range(6)]
    sink = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Sink)
    threading.Thread(target=sink.serve_forever, daemon=True).start()
    broker = subprocess.Popen([shutil.which("mosquitto") or "/usr/sbin/mosquitto", "-p", str(ports[5])], stderr=subprocess.DEVNULL)
    mail, lines = Mail(), Lines(program, count)
    plant, plc_plant = write_plants(folder, plc_folder, ports, lines, sink.server_port, mail.port)
    subprocess.run([program, "user", "add", USER, "--role", "operator", plant, "--password-stdin"], input=PASSWORD + "\n", text=True, check=True)
    plc = subprocess.Popen([program, "run", plc_plant, "--listen", "127.0.0.1:0"], stdout=subprocess.DEVNULL)
    station = subprocess.Popen(
        [program, "run", plant, "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True, env={**os.environ, **ENVIRONMENT})
    found = ["it did not come to its end"]
    try:
        url = station.stdout.readline().split()[1]
        user, source = Session(url), random.Random(25)
        urllib.request.install_opener(user.opener)
        recorders = Recorders(url, [f"s{number}" for number in range(count)])

        def exchanging():
            states = {gauge["name"]: gauge["state"] for gauge in json.loads(user.get("/api/gauges"))}
            others = [name for name, state in states.items() if state != "data-exchange"]
            assert len(states) == count * len(DEVICES) and not others, f"{len(states)} gauges, without data exchange: {others}"
            return True

        def row():
            return Row(station.pid, folder, ports[1], recorders)

        def reload():
            """The station reads its file again."""
            station.send_signal(signal.SIGHUP)
            ended.wait(15)

        wait_for("data exchange of all gauges", exchanging)
        before = wait_for("the first row", row)
        print(before.text(0), flush=True)
        ended, began = threading.Event(), time.monotonic()
        work = {"disturbances": lambda: disturb(lines, ended, source), "reload": reload, **clients(url, ports, count, user, ended.wait)}
        threads = [Repeated(name, it, ended) for name, it in work.items()]
        for thread in threads:
            thread.start()
        rows = []
        for _ in range(int(minutes * 60 / every_s)):
            ended.wait(every_s)
            rows.append(row())
            print(rows[-1].text(rows[-1].at - began), flush=True)
        ended.set()
        for thread in threads:
            thread.join(120)
            print(f"{thread.name}: {thread.count} times" + (f", last error: {thread.last!r}" if thread.last else ""), flush=True)
        share = 100 * (rows[-1].processor - rows[0].processor) / max(1, rows[-1].at - rows[0].at)
        print(f"{share:.1f} % of a core; notifications, batches and messages: {Sink.asked}, {mail.count}", flush=True)
        found = grown(rows, count, count * len(DEVICES))
        found += [f"{thread.name} never worked: {thread.last!r}" for thread in threads if not thread.count]
        found += [f"the station sent no {what}" for what, number in {**Sink.asked, "mail": mail.count}.items() if not number]
        wait_for("data exchange of all gauges at the end", exchanging)
        after = wait_for("rest after the clients", lambda: at_rest(row, before))
        print(after.text(after.at - began), flush=True)
        print(f"{count * minutes / 60:.2f} hours of bus time", flush=True)
    finally:
        for process in (station, plc):
            process.terminate()
            process.wait()
        lines.close()
        for process in (broker, mail.process):
            process.kill()
            process.wait()
        for it in (folder, plc_folder):
            shutil.rmtree(it, ignore_errors=True)
        for line in found:
            print(line, flush=True)
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
