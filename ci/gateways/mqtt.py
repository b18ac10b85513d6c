#!/usr/bin/env python3
"""paho-mqtt and pysparkplug over mosquitto and over amqtt against the MQTT gateway: ci/gateways/mqtt.py PROGRAM

pysparkplug does not decode the properties of a metric (unit, range, Quality): for these the test uses the protocol buffers that it holds.
"""

import base64
import json
import os
import shutil
import signal
import socket
import sqlite3
import struct
import subprocess
import sys
import threading
import time

import paho.mqtt.client as mqtt
import pysparkplug as spb
import sparkplug
from pysparkplug._protobuf import Payload
from plant import HANG_S, Line, Plant, free_port, wait_for

MOSQUITTO = shutil.which("mosquitto") or "/usr/sbin/mosquitto"
GROUP, NODE, HOST = "TargetHall", "station-1", "scada"
TABLES = """
[mqtt]
broker = "mqtt://127.0.0.1:{port}"
prefix = "profivac/hall"
home-assistant = true

[mqtt.sparkplug]
group = "TargetHall"
edge-node = "station-1"
primary-host = "scada"
"""


class Broker:
    def __init__(self, folder, port, more=""):
        self.port = port
        self.file = os.path.join(folder, f"broker-{port}.conf")
        with open(self.file, "w") as file:
            file.write(f"listener {port} 127.0.0.1\npersistence false\nmax_queued_messages 100000\n{more or 'allow_anonymous true'}\n")
        self.process = None

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.stop()

    def start(self):
        self.process = subprocess.Popen([MOSQUITTO, "-c", self.file], stderr=subprocess.DEVNULL)
        wait_for("the broker", lambda: socket.create_connection(("127.0.0.1", self.port), 5).close() or True)

    def stop(self):
        self.process.send_signal(signal.SIGCONT)
        self.process.kill()
        self.process.wait()


class Message:
    """A message of the edge node, decoded twice: by pysparkplug, and as protocol buffers for the properties."""

    def __init__(self, topic, raw, births):
        parts = topic.split("/")
        self.topic, self.verb, self.device = topic, parts[2], parts[4] if len(parts) > 4 else None
        self.raw = raw
        self.pb = Payload.FromString(raw)
        decoder = {"NBIRTH": spb.NBirth, "DBIRTH": spb.DBirth, "NDATA": spb.NData, "DDATA": spb.DData}.get(self.verb)
        self.payload = decoder.decode(raw, birth=births.get(self.device)) if decoder else None
        if self.verb in ("NBIRTH", "DBIRTH"):
            births[self.device] = self.payload
        self.metrics = {it.name: it for it in self.payload.metrics} if self.payload else {}

    def properties(self, name):
        found = next(it for it in self.pb.metrics if it.name == name)
        values = {}
        for key, value in zip(found.properties.keys, found.properties.values):
            values[key] = getattr(value, value.WhichOneof("value"))
        return values

    def bd_seq(self):
        return next(it for it in self.pb.metrics if it.name == "bdSeq").long_value


class Host:
    """A host application: subscribes to everything, checks sequence numbers, keeps what it gets."""

    def __init__(self, port):
        self.lock = threading.Lock()
        self.messages, self.plain, self.births = [], {}, {}
        self.seq, self.faults = None, []
        self.port = port
        self.client = mqtt.Client(f"host-{id(self)}", clean_session=True)
        self.connections, self.is_subscribed = 0, False
        self.client.on_subscribe = self.subscribed
        self.client.on_connect = self.connected
        self.client.on_message = self.receive
        self.client.reconnect_delay_set(1, 1)
        self.client.connect("127.0.0.1", port, keepalive=60)
        self.client.loop_start()

    def connected(self, client, *_):
        client.subscribe([("spBv1.0/#", 1), ("profivac/#", 1), ("homeassistant/#", 1)])
        self.connections += 1

    def subscribed(self, *_):
        self.is_subscribed = True

    def receive(self, _client, _data, message):
        with self.lock:
            if not message.topic.startswith("spBv1.0/"):
                self.plain[message.topic] = message.payload
            elif "/STATE/" not in message.topic and "CMD/" not in message.topic:
                try:
                    self.check(Message(message.topic, message.payload, self.births))
                except Exception as error:  # pylint: disable=broad-except
                    self.faults.append(f"{message.topic}: {error!r}")

    def check(self, message):
        """tck-id-payloads-sequence-num-zero-nbirth, tck-id-payloads-sequence-num-incrementing"""
        if message.verb != "NDEATH":
            expected = 0 if message.verb == "NBIRTH" else (self.seq + 1) % 256
            if message.pb.seq != expected:
                self.faults.append(f"{message.topic}: expected sequence number {expected}, found {message.pb.seq}")
            self.seq = message.pb.seq
        self.messages.append(message)

    def count(self):
        with self.lock:
            return len(self.messages)

    def since(self, begin, verb, device=None):
        with self.lock:
            return [it for it in self.messages[begin:] if it.verb == verb and it.device == device]

    def wait(self, begin, verb, device=None, condition=lambda _: True):
        what = f"{verb} of {device or 'the edge node'}"
        return wait_for(what, lambda: next((it for it in self.since(begin, verb, device) if condition(it)), None))

    def value(self, begin, device, name, condition):
        """The first present value of a metric that meets a condition, in data or in a birth."""
        def found():
            with self.lock:
                messages = [it for it in self.messages[begin:] if it.device == device and name in it.metrics]
            return next((it for it in messages if not it.metrics[name].is_historical and condition(it.metrics[name].value)), None)
        return wait_for(f"{name} of {device or 'the edge node'}", found)

    def state(self, online, timestamp):
        payload = json.dumps({"online": online, "timestamp": timestamp})
        self.client.publish(f"spBv1.0/STATE/{HOST}", payload, qos=1, retain=True).wait_for_publish()

    def command(self, verb, metrics, device=""):
        payload = spb.NCmd(timestamp=int(time.time() * 1000), metrics=metrics).encode(include_dtypes=True)
        self.client.publish(f"spBv1.0/{GROUP}/{verb}/{NODE}{device}", payload, qos=1)

    def json(self, topic):
        with self.lock:
            return json.loads(self.plain[f"profivac/hall/{topic}"])

    def text(self, topic):
        with self.lock:
            return self.plain[f"profivac/hall/{topic}"].decode()


def rebirth():
    return spb.Metric(timestamp=None, name="Node Control/Rebirth", datatype=spb.DataType.BOOLEAN, value=True)


def pressure_of(message):
    found = message.metrics.get("Pressure")
    return found.value if found and not found.is_historical else None


def check_births(plant, host):
    wait_for("the wait for the host", lambda: "waits for the primary host scada" in plant.status("sparkplug")["address"])
    assert host.count() == 0, "births before the primary host is online"
    host.state(True, 1000)
    node = host.wait(0, "NBIRTH")
    chamber = host.wait(0, "DBIRTH", "chamber")
    lock = host.wait(0, "DBIRTH", "load lock")
    assert node.bd_seq() == 0 and node.metrics["Node Control/Rebirth"].value is False
    pressure = chamber.metrics["Pressure"]
    assert pressure.datatype == spb.DataType.FLOAT and 0.05 < pressure.value < 0.2, pressure
    assert abs(time.time() * 1000 - pressure.timestamp) < 60_000
    properties = chamber.properties("Pressure")
    assert properties["engUnit"] == "Pa" and properties["Quality"] == 192, properties
    assert abs(properties["engLow"] / 5e-8 - 1) < 1e-6 and abs(properties["limitHighHigh"] / 10 - 1) < 1e-6, properties
    assert "simulated" not in properties and lock.properties("Pressure")["simulated"] is True
    assert abs(chamber.metrics["PressureLog10"].value + 1) < 0.3
    assert node.metrics["Segments/hall/Up"].value is True and "Alarms/Chamber high/State" in node.metrics
    assert plant.status("sparkplug")["is_running"] and plant.status("sparkplug")["clients"] == 1


def check_data_and_alarm(plant, host):
    begin = host.count()
    plant.tell("pressure 1 mbar")
    host.value(begin, "chamber", "Pressure", lambda pa: pa and pa > 50)
    host.value(begin, "chamber", "Alarm/Priority", lambda priority: priority == 3)
    host.value(begin, None, "Alarms/Chamber high/State", lambda state: state == 1)
    begin = host.count()
    plant.tell("pressure 1e-3 mbar")
    data = host.value(begin, "chamber", "Pressure", lambda pa: pa and pa < 0.2)
    assert data.properties("Pressure")["Quality"] == 192
    last = next(it for it in host.messages[::-1] if it.verb == "DDATA")
    assert all(it.name and it.datatype and not it.HasField("alias") for it in last.pb.metrics), "names with data types"
    check_hosts_without_births([it for it in host.messages if it.verb in ("NDATA", "DDATA")])


def check_hosts_without_births(messages):
    """Libraries of hosts that keep no births read name and value of each metric: pysparkplug and sparkplug-payload (npm)."""
    expected = []
    for message in messages:
        decoder = spb.NData if message.verb == "NDATA" else spb.DData
        expected.append({it.name: it.value for it in decoder.decode(message.raw).metrics})
    folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "sparkplug-payload")
    lines = "".join(base64.b64encode(message.raw).decode() + "\n" for message in messages)
    done = subprocess.run(["node", os.path.join(folder, "values.js")], input=lines, text=True, capture_output=True, timeout=HANG_S)
    assert done.returncode == 0, done.stderr
    for own, line in zip(expected, done.stdout.splitlines(), strict=True):
        other = json.loads(line)
        assert own.keys() == other.keys(), (own, other)
        numbers = [name for name, value in own.items() if isinstance(value, float) and name != "LastReading"]
        assert all(abs(own[name] - other[name]) <= 1e-6 * abs(own[name]) for name in numbers), (own, other)
    assert any(isinstance(own.get("Pressure"), float) for own in expected)


def check_plain(plant, host):
    # Both topics may still have the pressure before: that of the alarm.
    state = wait_for("the plain state", lambda: (it := host.json("chamber/state")) and (it["pressure"] or 100) < 0.2 and it)
    wait_for("the plain pressure", lambda: abs(float(host.text("chamber/pressure")) / state["pressure"] - 1) < 0.5)
    assert state["unit"] == "Pa" and state["quality"] == "valid" and state["simulated"] is False, state
    assert state["limits"]["high_high"] == 10.0 and state["range"][1] > 1e4
    assert host.json("load lock/state")["simulated"] is True
    assert host.text("status") == "online" and host.json("segment/hall")["segment_up"] is True
    assert host.json("chamber/gauge")["device"] == "bcg450"
    retained = mqtt.Client("late", clean_session=True)
    found = {}
    retained.on_message = lambda _c, _d, message: found.update({message.topic: message})
    retained.connect("127.0.0.1", host.client._port)  # pylint: disable=protected-access
    retained.subscribe([("profivac/#", 1), ("homeassistant/#", 1)])
    retained.loop_start()
    wait_for("a retained state", lambda: found["profivac/hall/chamber/state"].retain)
    config = wait_for("a sensor", lambda: next((it for topic, it in found.items() if topic.endswith("chamber/pressure_log10/config")), None))
    config = json.loads(config.payload)
    assert config["state_topic"] == "profivac/hall/chamber/state" and config["expire_after"] == 60
    assert config["default_entity_id"].startswith("sensor.") and "object_id" not in config and config["origin"]["name"] == "profivac", config
    retained.loop_stop()


def check_rebirth(plant, host):
    begin, births = host.count(), host.since(0, "NBIRTH")
    for _ in range(30):
        host.command("NCMD", (rebirth(),))
    again = host.wait(begin, "NBIRTH")
    assert again.bd_seq() == births[-1].bd_seq()
    host.wait(begin, "DBIRTH", "chamber")
    plant.tell("pressure 2e-3 mbar")
    host.value(begin, "chamber", "Pressure", lambda pa: pa and 0.15 < pa < 0.3)
    assert len(host.since(begin, "NBIRTH")) <= 2, "the rebirth is debounced"


def check_refused(plant, host):
    refused = plant.status("sparkplug")["refused"]
    write = spb.Metric(timestamp=None, name="Pressure", datatype=spb.DataType.FLOAT, value=1.0)
    host.command("DCMD", (write,), "/chamber")
    host.command("NCMD", (write,))
    for octets in (b"\xff" * 1000, b"", b"\x12\x7f\x01", os.urandom(1 << 20)):
        host.client.publish(f"spBv1.0/{GROUP}/NCMD/{NODE}", octets, qos=1)
    host.client.publish(f"spBv1.0/STATE/{HOST}", "ONLINE", qos=1)
    wait_for("six refused commands", lambda: plant.status("sparkplug")["refused"] >= refused + 6)
    begin = host.count()
    plant.tell("pressure 1e-3 mbar")
    host.value(begin, "chamber", "Pressure", lambda pa: pa and pa < 0.15)
    assert plant.status("sparkplug")["is_running"]


def check_hostile_publisher(plant, host):
    """Another client of the broker sends what no host application sends, and 5,000 commands at once: data goes on."""
    prefix = f"spBv1.0/{GROUP}"
    write = spb.Metric(timestamp=None, name="x" * 60_000, datatype=spb.DataType.FLOAT, value=float("nan"))
    endless = b"\x12" + b"\xff" * 9 + b"\x01" + bytes(100)
    hostile = [
        (f"{prefix}/NCMD/{NODE}", endless),
        (f"{prefix}/NCMD/{NODE}", spb.NCmd(timestamp=1, metrics=(write,)).encode(include_dtypes=True)),
        (f"{prefix}/NCMD/{NODE}", b"\x12\x00" * 100_000),
        (f"{prefix}/DCMD/{NODE}/" + "y" * 60_000, b"\xff"),
        (f"{prefix}/DCMD/{NODE}/", b"\x00"),
        (f"{prefix}/DCMD/{NODE}/no\u202esuch/device", b""),
        (f"spBv1.0/STATE/{HOST}", b"[" * 100_000),
        (f"spBv1.0/STATE/{HOST}", b'{"online": true, "timestamp": 1e999}'),
        (f"spBv1.0/STATE/{HOST}", b'{"online": "no", "timestamp": -1}'),
        (f"spBv1.0/STATE/{HOST}", b"\xff" * (1 << 20)),
    ]
    client = mqtt.Client("hostile", clean_session=True)
    client.connect("127.0.0.1", host.port)
    client.loop_start()
    refused = plant.status("sparkplug")["refused"]
    with Line(plant.url):
        for topic, octets in hostile:
            client.publish(topic, octets, qos=1).wait_for_publish(HANG_S)
        flood = [client.publish(f"{prefix}/NCMD/{NODE}", os.urandom(200), qos=1) for _ in range(5_000)]
        for pressure, low, high in (("2e-2", 1, 3), ("1e-3", 0, 0.15)):
            begin = host.count()
            plant.tell(f"pressure {pressure} mbar")
            host.value(begin, "chamber", "Pressure", lambda pa, low=low, high=high: pa and low < pa < high)
        flood[-1].wait_for_publish(HANG_S)
        wait_for("refused commands", lambda: plant.status("sparkplug")["refused"] > refused)
    client.disconnect()
    client.loop_stop()
    assert plant.status("sparkplug")["is_running"] and plant.status("mqtt")["is_running"]


ACCEPTED = b"\x20\x02\x00\x00"

# What brokers do that are none: nothing for ever, half an answer, random octets, sizes and topics that are not so.
HOSTILE_BROKERS = [
    None,
    b"",
    b"\x20\x02",
    b"\x20\x02\x00\xff",
    os.urandom(5_000),
    ACCEPTED + b"\x30\xff\xff\xff\x7f" + bytes(100_000),
    ACCEPTED + b"\x30\xff\xff\xff\xff\xff",
    ACCEPTED + b"\x30\x05\x00\xff\xff\xfe\xfd",
    ACCEPTED + b"\x90\x03\xff\xff\x80" * 1000,
]


class HostileBroker:
    """Answers each connection with the same octets, and holds it open if there are none or half of an answer."""

    def __init__(self, octets):
        self.octets, self.held = octets, []
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        while True:
            try:
                connection, _ = self.listener.accept()
                connection.sendall(self.octets or b"")
            except OSError:
                if self.listener.fileno() < 0:
                    return
                continue
            if self.octets is None or self.octets == ACCEPTED[:2]:
                self.held.append(connection)
            else:
                connection.close()

    def close(self):
        self.listener.close()
        for connection in self.held:
            connection.close()


def check_hostile_brokers(plant, host):
    """The station tries brokers that are none, and reaches the one behind them; its segment goes on meanwhile."""
    with open(plant.file) as file:
        before = file.read()
    brokers = [HostileBroker(octets) for octets in HOSTILE_BROKERS]
    first, *others = [f"mqtt://127.0.0.1:{it.port}" for it in brokers]
    real = f"mqtt://127.0.0.1:{host.port}"
    plant.write("plant.toml", before.replace(f'broker = "{real}"', f'broker = "{first}"\nstandby = {json.dumps([*others, real])}'))
    begin = host.count()
    plant.restart()
    with Line(plant.url):
        host.wait(begin, "NBIRTH")
        wait_for("plain topics", lambda: plant.status("mqtt")["is_running"] and str(host.port) in plant.status("mqtt")["address"])
        plant.tell("pressure 2e-2 mbar")
        host.value(begin, "chamber", "Pressure", lambda pa: pa and 1 < pa < 3)
    assert all(it.octets is not None or it.held for it in brokers), "the silent broker was not tried"
    plant.write("plant.toml", before)
    begin = host.count()
    plant.restart()
    host.wait(begin, "NBIRTH")
    plant.tell("pressure 1e-3 mbar")
    host.value(begin, "chamber", "Pressure", lambda pa: pa and pa < 0.15)
    for it in brokers:
        it.close()


def check_unplugged(plant, host):
    begin = host.count()
    plant.tell("power 5 off")
    host.wait(begin, "DDEATH", "chamber")
    state = wait_for("no plain pressure", lambda: (it := host.json("chamber/state"))["pressure"] is None and it)
    assert state["quality"] == "stale" and host.text("chamber/pressure") == "", state
    plant.tell("power 5 on")
    host.wait(begin, "DBIRTH", "chamber")
    wait_for("the plain pressure", lambda: host.json("chamber/state")["quality"] == "valid")


def check_beyond_the_range(plant, host):
    """Below its range a gauge shows no number that a client could take for a pressure."""
    begin = host.count()
    plant.tell("pressure 1e-12 mbar")
    below = host.value(begin, "chamber", "State", lambda state: state == 1)
    assert below.metrics["Pressure"].value is None and below.properties("Pressure")["Quality"] == 0, below.metrics["Pressure"]
    wait_for("no plain pressure", lambda: host.text("chamber/pressure") == "")
    state = host.json("chamber/state")
    is_end = abs(state["pressure"] / state["range"][0] - 1) < 1e-6
    assert state["quality"] == "underrange" and is_end and not state["usable"], state
    plant.tell("pressure 1e-3 mbar")
    host.value(begin, "chamber", "State", lambda state: state == 0)
    wait_for("the plain pressure", lambda: host.text("chamber/pressure") != "")


def assert_historical_first(plant, host, begin, least):
    """The samples of an outage come in order, before present data of the gauge."""
    host.wait(begin, "DBIRTH", "chamber")
    plant.tell("pressure 5e-2 mbar")
    host.wait(begin, "DDATA", "chamber", lambda it: (pressure_of(it) or 0) > 4)
    plant.tell("pressure 1e-3 mbar")
    times, is_past = [], True
    for message in host.since(begin, "DDATA", "chamber"):
        for metric in message.payload.metrics:
            if metric.name == "Pressure":
                assert not metric.is_historical or is_past, "a historical sample behind present data"
                is_past = metric.is_historical
                if is_past:
                    times.append(metric.timestamp)
    assert times == sorted(times) and len(times) >= least, f"{len(times)} historical samples"
    return times


def check_broker_restart(plant, host, broker):
    before, connections = host.since(0, "NBIRTH")[-1].bd_seq(), host.connections
    broker.stop()
    begin, at = host.count(), time.time() * 1000
    wait_for("the end of the connection", lambda: plant.status("sparkplug")["is_running"] is False)
    assert "broker" in plant.status("sparkplug")["problem"]
    # The record keeps what differs from the sample before.
    for pressure in ("2e-3", "4e-3", "8e-3", "1e-3"):
        last = plant.reading("chamber")["pa"]
        plant.tell(f"pressure {pressure} mbar")
        wait_for("another pressure", lambda last=last: abs(plant.reading("chamber")["pa"] / last - 1) > 0.3)
    broker.start()
    wait_for("the host", lambda: host.connections > connections)
    host.state(True, 1000)
    birth = host.wait(begin, "NBIRTH")
    assert birth.bd_seq() > before
    times = assert_historical_first(plant, host, begin, 4)
    assert times[-1] > at, "samples of the outage"


def check_host_offline(plant, host):
    begin = host.count()
    host.state(False, 999)
    plant.tell("pressure 2e-3 mbar")
    host.value(begin, "chamber", "Pressure", lambda pa: pa and 0.15 < pa < 0.3)
    host.state(False, 1000)
    death = host.wait(begin, "NDEATH")
    assert death.bd_seq() == host.since(0, "NBIRTH")[-1].bd_seq()
    wait_for("the wait for the host", lambda: "waits for the primary host" in plant.status("sparkplug")["address"])
    begin = host.count()
    host.state(True, 2000)
    assert host.wait(begin, "NBIRTH").bd_seq() == (death.bd_seq() + 1) % 256
    assert_historical_first(plant, host, begin, 1)


def check_station_restart(plant, host):
    begin, number = host.count(), host.since(0, "NBIRTH")[-1].bd_seq()
    plant.stop()
    assert host.wait(begin, "NDEATH").bd_seq() == number
    wait_for("the plain end", lambda: host.text("status") == "offline")
    plant.start()
    assert host.wait(begin, "NBIRTH").bd_seq() == (number + 1) % 256
    begin = host.count()
    plant.station.kill()
    plant.station.wait()
    assert host.wait(begin, "NDEATH").bd_seq() == (number + 1) % 256
    wait_for("the plain will", lambda: host.text("status") == "offline")


def check_day_of_backlog(plant, host):
    """A day of samples in the record that was not delivered: 86,400 a gauge, in order, before present data."""
    day, now = 86_400, int(time.time())
    first = now - day - 3600
    with sqlite3.connect(os.path.join(plant.folder, "plant.db")) as database:
        for name in ("chamber", "load lock"):
            number = database.execute("SELECT id FROM series WHERE name = ?", (name,)).fetchone()[0]
            rows = ((number, (first + second) * 1_000_000, 1e-3 * (1 + second % 100)) for second in range(day))
            database.executemany("INSERT INTO sample VALUES (?, ?, ?, 0)", rows)
    with open(os.path.join(plant.folder, "plant.sparkplug")) as file:
        memory = json.load(file)
    plant.write("plant.sparkplug", json.dumps(memory | {"delivered_us": (first - 1) * 1_000_000}))
    begin, started = host.count(), time.monotonic()
    plant.start()
    times = assert_historical_first(plant, host, begin, day)
    prepared = [it for it in times if it <= (first + day) * 1000]
    assert prepared == [(first + second) * 1000 for second in range(day)], "each sample once, with its own time"
    seconds = time.monotonic() - started
    print(f"mqtt: a day of backlog, {2 * day} samples, in {seconds:.1f} s")


def check_stalled(plant, host, broker):
    """A subscriber that does not read, then a broker that does nothing: the station and the others are not affected."""
    topic = b"#"
    with socket.create_connection(("127.0.0.1", broker.port)) as stalled:
        stalled.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1024)
        stalled.sendall(b"\x10\x10\x00\x04MQTT\x04\x02\x00\x00\x00\x04slow")
        stalled.sendall(b"\x82\x06\x00\x01" + struct.pack(">H", len(topic)) + topic + b"\x00")
        for pressure, low, high in (("2e-2", 1, 3), ("1e-3", 0, 0.2), ("2e-2", 1, 3)):
            begin = host.count()
            plant.tell(f"pressure {pressure} mbar")
            host.value(begin, "chamber", "Pressure", lambda pa, low=low, high=high: pa and low < pa < high)
    broker.process.send_signal(signal.SIGSTOP)
    try:
        for pressure in ("2e-3", "4e-3", "8e-3", "3e-2"):
            last = plant.reading("chamber")["pa"]
            plant.tell(f"pressure {pressure} mbar")
            wait_for("another pressure", lambda last=last: abs(plant.reading("chamber")["pa"] / last - 1) > 0.3)
    finally:
        begin = host.count()
        broker.process.send_signal(signal.SIGCONT)
    host.value(begin, "chamber", "Pressure", lambda pa: pa and pa > 2)
    wait_for("the newest pressure", lambda: float(host.text("chamber/pressure")) > 2)


def certificates(folder):
    """A CA of the test and a certificate for 127.0.0.1."""
    def run(*arguments):
        subprocess.run(["openssl", *arguments], cwd=folder, check=True, capture_output=True)
    run("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", "ca.key", "-out", "ca.pem", "-days", "2", "-subj", "/CN=Test CA",
        "-addext", "basicConstraints=critical,CA:TRUE", "-addext", "keyUsage=critical,keyCertSign")
    for name, extension in (("server", "subjectAltName=IP:127.0.0.1"), ("client", "extendedKeyUsage=clientAuth")):
        run("req", "-newkey", "rsa:2048", "-nodes", "-keyout", f"{name}.key", "-out", f"{name}.csr", "-subj", f"/CN={name}")
        with open(os.path.join(folder, f"{name}.ext"), "w") as file:
            file.write(extension + "\n")
        run("x509", "-req", "-in", f"{name}.csr", "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial", "-days", "2",
            "-extfile", f"{name}.ext", "-out", f"{name}.pem")
    for name in ("ca", "server", "client"):
        os.chmod(os.path.join(folder, f"{name}.key"), 0o600)


def check_login_and_tls(plant, old):
    """Wrong password, unknown CA, no client certificate: a sentence for each; then all of them right."""
    folder, port = plant.folder, free_port()
    certificates(folder)
    subprocess.run(["mosquitto_passwd", "-b", "-c", "passwords", "hall", "right"], cwd=folder, check=True, capture_output=True)
    for name in ("passwords", "server.key", "server.pem", "ca.pem"):
        # mosquitto gives up root, and reads the files before.
        os.chmod(os.path.join(folder, name), 0o600)
    where = lambda name: os.path.join(folder, name)
    more = (f"user root\nallow_anonymous false\npassword_file {where('passwords')}\ncafile {where('ca.pem')}\n"
            f"certfile {where('server.pem')}\nkeyfile {where('server.key')}\nrequire_certificate true\n")
    with open(plant.file) as file:
        head = file.read().split("\n[mqtt]\n")[0]

    def change(tables, password="right"):
        plant.write("broker.credentials", f'user = "hall"\npassword = "{password}"\n')
        plant.write("plant.toml", head + f'\n[mqtt]\nbroker = "mqtts://127.0.0.1:{port}"\n' + tables)
        plant.station.send_signal(signal.SIGHUP)

    def view():
        """The gateway; after SIGHUP there is none for a moment."""
        found = next((it for it in plant.api("/api/gateways") if it["name"] == "mqtt"), {})
        return {key: value for key, value in found.items() if value is not None}

    login = 'credentials = "broker.credentials"\n'
    client = 'certificate = "client.pem"\nkey = "client.key"\n'
    authority = 'ca-file = "ca.pem"\n'
    with Broker(folder, port, more):
        for tables, password, sentence in (
            (login + client, "right", "no secure connection"),
            (login + client + authority, "wrong", "refuses the login of \"hall\""),
            (client + authority, "right", "wants a login"),
        ):
            change(tables, password)
            wait_for(f"{sentence!r} in the status", lambda sentence=sentence: sentence in view().get("problem", ""))
        change(login + client + authority)
        wait_for("a connection", lambda: view().get("is_running") and view()["sent"] > 0)
        change(login + authority)
        wait_for("a refusal without a certificate", lambda: view().get("problem"))


class OtherBroker(Broker):
    """amqtt: a broker in Python that shares no code with mosquitto."""

    def __init__(self, folder, port):
        self.port = port
        self.file = os.path.join(folder, f"amqtt-{port}.yaml")
        with open(self.file, "w") as file:
            file.write(f"listeners:\n  default:\n    type: tcp\n    bind: 127.0.0.1:{port}\nplugins:\n"
                       "  amqtt.plugins.authentication.AnonymousAuthPlugin:\n    allow_anonymous: true\n")

    def start(self):
        program = os.path.join(os.path.dirname(sys.executable), "amqtt")
        self.process = subprocess.Popen([program, "-c", self.file], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_for("amqtt", lambda: socket.create_connection(("127.0.0.1", self.port), 5).close() or True)


def check_failover(plant, former, broker):
    """The first broker ends: the edge node is born at the second one, and dies there when that one ends; then the first one has it again."""
    former.client.disconnect()
    former.client.loop_stop()
    second = free_port()
    with open(plant.file) as file:
        before = file.read()
    without_host = before.replace('primary-host = "scada"\n', "")
    plant.write("plant.toml", without_host.replace("[mqtt]\n", f'[mqtt]\nstandby = ["mqtt://127.0.0.1:{second}"]\n'))
    view = lambda: plant.status("sparkplug")  # noqa: E731
    broker.stop()
    with OtherBroker(plant.folder, second) as other:
        plant.restart()
        wait_for("the second broker", lambda: view()["is_running"] and str(second) in view()["address"])
        host = Host(second)
        rebirth_at(host)
        begin = host.count()
        plant.tell("pressure 2e-3 mbar")
        host.value(begin, "chamber", "Pressure", lambda pa: pa is not None and abs(pa / 0.2 - 1) < 0.05)
        wait_for("plain topics there", lambda: b'"pressure":' in host.plain.get("profivac/hall/chamber/state", b""))
        assert not host.faults, host.faults[:5]
        host.client.loop_stop()
        broker.start()
        first = Host(broker.port)
        wait_for("the subscription at the first broker", lambda: first.is_subscribed)
        other.stop()
        birth = first.wait(0, "NBIRTH")
        first.wait(0, "DBIRTH", "chamber")
        assert birth.pb.seq == 0 and not first.faults, first.faults[:5]
        wait_for("the first broker", lambda: str(broker.port) in view()["address"] and view()["is_running"])
        # The edge node ends with the death of this birth, not of an older one.
        plant.stop()
        death = first.wait(0, "NDEATH")
        assert death.bd_seq() == birth.bd_seq(), (death.bd_seq(), birth.bd_seq())
        first.client.loop_stop()
    plant.write("plant.toml", before)
    plant.start()


def rebirth_at(host):
    """Asks the edge node for its births, as a host does that has come later."""
    begin = host.count()
    wait_for("the subscription", lambda: host.is_subscribed)
    host.command("NCMD", (rebirth(),))
    host.wait(begin, "NBIRTH")
    for gauge in ("chamber", "load lock"):
        host.wait(begin, "DBIRTH", gauge)
    # Data before the births could not be decoded.
    host.faults.clear()


def main():
    port = free_port()
    with Plant(sys.argv[1], "") as plant:
        plant.stop()
        with open(plant.file, "a") as file:
            file.write(TABLES.format(port=port))
        with Broker(plant.folder, port) as broker:
            host = Host(port)
            plant.start()
            steps = [
                (check_births, (plant, host)), (check_data_and_alarm, (plant, host)), (check_plain, (plant, host)),
                (check_rebirth, (plant, host)), (check_refused, (plant, host)), (check_hostile_publisher, (plant, host)),
                (check_hostile_brokers, (plant, host)), (check_beyond_the_range, (plant, host)),
                (check_unplugged, (plant, host)),
                (check_stalled, (plant, host, broker)), (check_broker_restart, (plant, host, broker)),
                (check_host_offline, (plant, host)), (check_station_restart, (plant, host)),
                (check_day_of_backlog, (plant, host)), (check_failover, (plant, host, broker)), (check_login_and_tls, (plant, broker)),
            ]
            for step, arguments in steps:
                began = time.monotonic()
                try:
                    step(*arguments)
                finally:
                    # The last messages explain a failure.
                    if host.faults or sys.exc_info()[0]:
                        print("mqtt:", host.faults[:5], [it.topic for it in host.messages[-5:]], plant.api("/api/gateways"))
                assert not host.faults, host.faults[:5]
                print(f"mqtt: {step.__name__.removeprefix('check_').replace('_', ' ')}: ok after {time.monotonic() - began:.1f} s", flush=True)
            host.client.loop_stop()
            with Broker(plant.folder, free_port()) as other:
                print(f"mqtt: {sparkplug.run(sys.argv[1], other.port)} statements of Sparkplug 3.0 hold on the wire", flush=True)


if __name__ == "__main__":
    main()
