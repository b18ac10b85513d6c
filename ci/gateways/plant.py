"""A station with virtual gauges for the tests of the gateways: the real program, with a gauge that can be unplugged.

Standard library only; each test of a gateway imports it. Waits poll until a deadline that only ends a test that hangs.
"""

import json
import os
import random
import socket
import subprocess
import tempfile
import threading
import time
import urllib.request

HANG_S = 120
POLL_S = 0.05

HALL = '[[segment]]\nname = "hall"\nport = "tcp://{port}"\n\n[[segment.gauge]]\nname = "chamber"\naddress = 5\ndevice = "bcg450"\n\n'
LAB = '[[segment]]\nname = "lab"\nport = "sim:{folder}/lab.toml"\n\n[[segment.gauge]]\nname = "load lock"\naddress = 7\ndevice = "pcg550"\n\n'
PUMP_GSD = '#Profibus_DP\nVendor_Name = "Invented"\nModel_Name = "Pump 1"\nIdent_Number = 0x0FA1\nMax_Input_Len = 3\nMax_Output_Len = 0\nModule = "m" 0x12\n1\nEndModule\n'
VALVE_GSD = '#Profibus_DP\nVendor_Name = "Invented"\nModel_Name = "Valve 7"\nIdent_Number = 0x0FA7\nMax_Input_Len = 2\nMax_Output_Len = 1\nModule = "m" 0x11,0x20\n1\nEndModule\n'
SLAVES = '''[[segment]]
name = "hall"
port = "tcp://{port}"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.slave]]
name = "turbo"
address = 9
gsd = "pump.gsd"
own = true

[[segment.slave.point]]
name = "speed"
type = "u16"
unit = "Hz"

[[segment.slave.point]]
name = "state"
octet = 2
type = "u8"
texts = {{ 0 = "off", 3 = "at speed" }}

[[segment.slave]]
name = "gate"
address = 12
gsd = "valve.gsd"
own = true
outputs = "01"

[[segment.slave.point]]
name = "position"
type = "u8"
unit = "mm"

[[segment.slave.point]]
name = "limit"
octet = 1
bit = 0
type = "bool"
texts = {{ 0 = "open", 1 = "closed" }}

'''
ALARM = '[[alarm]]\nname = "Chamber high"\ngauge = "chamber"\nabove = "1e-1 mbar"\npriority = "high"\n\n'


def wait_for(what, condition):
    """Returns the first true value of `condition()`; errors of a connection count as false."""
    end, last = time.monotonic() + HANG_S, None
    while time.monotonic() < end:
        try:
            value = condition()
            if value:
                return value
        except (OSError, KeyError, IndexError, ValueError, AssertionError, StopIteration) as error:
            last = error
        time.sleep(POLL_S)
    raise SystemExit(f"{what} did not happen within {HANG_S} s; last error: {last!r}")


_given = set()


def free_port():
    """A free port that this process has not been given before: the system may choose one twice while nothing listens on it."""
    while True:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        if port not in _given:
            _given.add(port)
            return port


class Plant:
    """`profivac run` with two segments: `chamber` behind a TCP port, a gauge of another process, and `load lock` in memory."""

    GAUGES = ("chamber", "load lock")

    def __init__(self, program, tables, head=""):
        self.program, self.tables, self.head = os.path.abspath(program), tables, head
        self.folder = tempfile.mkdtemp(prefix="profivac-gateway-")
        self.file = os.path.join(self.folder, "plant.toml")
        self.station = self.url = None

    def simulate(self, *arguments):
        """Starts the devices of another process, and returns their port."""
        self.gauge = subprocess.Popen(
            [self.program, "simulate", "--tcp", "127.0.0.1:0", *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        return self.gauge.stdout.readline().split()[1]

    def make(self):
        """Starts the devices and writes the files of the station."""
        port = self.simulate("--pressure", "1e-3 mbar", "bcg450@5")
        self.write("lab.toml", 'devices = ["pcg550@7"]\npressure = "1e-2 mbar"\n')
        self.write("plant.toml", self.head + HALL.format(port=port) + LAB.format(folder=self.folder) + ALARM + self.tables)

    def __enter__(self):
        self.make()
        try:
            self.start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        self.stop()
        self.gauge.kill()
        self.gauge.wait()
        subprocess.run(["rm", "-rf", self.folder], check=False)

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w", opener=lambda path, flags: os.open(path, flags, 0o600)) as file:
            file.write(text)
        return path

    def start(self):
        """Starts the station and waits until both gauges give readings."""
        self.station = subprocess.Popen(
            [self.program, "run", self.file, "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True)
        line = self.station.stdout.readline()
        if not line.startswith("ready "):
            raise SystemExit(f"expected `ready URL` of profivac run, found {line!r}")
        self.url = line.split()[1]
        if self.url.startswith("http://"):
            for name in self.GAUGES:
                wait_for(f"a reading of {name}", lambda name=name: self.reading(name)["quality"] == "valid")

    def stop(self):
        if self.station:
            self.station.terminate()
            self.station.wait(HANG_S)

    def restart(self):
        self.stop()
        self.start()

    def tell(self, line):
        """A command for `chamber`: `pressure 1e-4 mbar`, `power 5 off`, `fault 5 NAME`."""
        self.gauge.stdin.write(line + "\n")
        self.gauge.stdin.flush()

    def api(self, path):
        with urllib.request.urlopen(self.url + path, timeout=HANG_S) as answer:
            return json.load(answer)

    def reading(self, gauge):
        """The first reading of a gauge as the API has it."""
        found = next(it for it in self.api("/api/gauges") if it["name"] == gauge)
        return found["readings"][0]

    def status(self, gateway):
        return next(it for it in self.api("/api/gateways") if it["name"] == gateway)


class SlavePlant(Plant):
    """`profivac run` with a gauge, a pump controller and a valve on one segment behind a TCP port, two of them by their GSD files."""

    GAUGES = ("chamber",)

    def make(self):
        pump, valve = self.write("pump.gsd", PUMP_GSD), self.write("valve.gsd", VALVE_GSD)
        port = self.simulate("--pressure", "1e-3 mbar", "bcg450@5", f"{pump}@9:modules=1", f"{valve}@12:modules=1")
        self.write("plant.toml", self.head + SLAVES.format(port=port) + self.tables)


class Line:
    """A segment in memory while something else happens: until the `with` ends its messages go on, and at most a few are lost or repeated.

    A computer that is full loses some, because the gauges run on its processor too: 0.4 % at ten times the load that two cores can do.
    """

    FEW, SHARE = 3, 0.05

    def __init__(self, url, segment="lab"):
        self.url = f"{url}/api/segments/{segment}/bus"

    def counts(self):
        with urllib.request.urlopen(self.url, timeout=HANG_S) as answer:
            report = json.load(answer)
        totals = [station["total"] for station in report["stations"]]
        faults = sum(it[name] for it in totals for name in ("lost", "repeated", "damaged"))
        return report["telegrams"], sum(it["requests"] for it in totals), faults

    def __enter__(self):
        self.before = self.counts()
        return self

    def __exit__(self, kind, *_):
        if kind is None:
            # The report is made anew about once a second.
            after = wait_for("a telegram of the segment", lambda: (lambda it: it[0] > self.before[0] and it)(self.counts()))
            _, requests, faults = (new - old for new, old in zip(after, self.before))
            assert faults <= max(self.FEW, self.SHARE * requests), f"{faults} faults of {requests} requests"


class Hostile:
    """Clients that misbehave at a port, from another loopback address, until the `with` ends: half-open connections, random octets,
    the given requests, and up to 1,000 connections a second."""

    def __init__(self, port, requests=(), source="127.0.0.9", per_second=1000):
        self.port, self.requests, self.source, self.per_second = port, list(requests), source, per_second
        self.ended = threading.Event()
        self.made = 0
        self.random = random.Random(20)

    def __enter__(self):
        self.began = time.monotonic()
        self.threads = [threading.Thread(target=work, daemon=True) for work in (self.flood, self.half_open, self.noise)]
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        for thread in self.threads:
            thread.join(HANG_S)
        self.seconds = time.monotonic() - self.began

    def connect(self):
        connection = socket.create_connection(("127.0.0.1", self.port), timeout=5, source_address=(self.source, 0))
        self.made += 1
        return connection

    def flood(self):
        """Connects and disconnects at once."""
        while not self.ended.is_set():
            began = time.monotonic()
            for _ in range(max(1, self.per_second // 50)):
                try:
                    self.connect().close()
                except OSError:
                    pass
            time.sleep(max(0.0, 0.02 - (time.monotonic() - began)))

    def half_open(self):
        """Holds connections that send the beginning of a request and nothing more."""
        held = []
        while not self.ended.is_set():
            try:
                connection = self.connect()
                connection.sendall((self.requests or [b"\0"])[0][:3])
                held.append(connection)
            except OSError:
                pass
            if len(held) > 300:
                held.pop(0).close()
            time.sleep(0.01)
        for connection in held:
            connection.close()

    def noise(self):
        """Sends random octets and the hostile requests, and reads nothing."""
        while not self.ended.is_set():
            for request in [self.random.randbytes(self.random.randrange(1, 2000)), *self.requests]:
                try:
                    with self.connect() as connection:
                        connection.sendall(request)
                except OSError:
                    pass
            time.sleep(0.01)
