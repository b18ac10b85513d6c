#!/usr/bin/env python3
"""The normative statements of Sparkplug 3.0 about edge nodes and devices, checked on the wire: ci/gateways/sparkplug.py PROGRAM

A proxy between the station and mosquitto keeps each MQTT packet of the station's Sparkplug connection: its CONNECT with the will, its
subscriptions, births, data and deaths, over a session with an unplugged gauge and a rebirth, an intended end, and a second session. Then
each row of ASSERTIONS is looked at; the names are those of the specification without `tck-id-`.
"""

import json
import os
import socket
import struct
import sys
import tempfile
import threading
import time

import paho.mqtt.client as mqtt
import pysparkplug as spb
from pysparkplug._protobuf import Payload
from plant import Plant, free_port, wait_for

GROUP, NODE, HOST = "TargetHall", "station-1", "scada"
REBIRTH = "Node Control/Rebirth"
TABLES = """
[mqtt]
broker = "mqtt://127.0.0.1:{port}"
plain = false

[mqtt.sparkplug]
group = "TargetHall"
edge-node = "station-1"
primary-host = "scada"
data = "aliases"
"""
CONNECT, PUBLISH, SUBSCRIBE, DISCONNECT = 1, 3, 8, 14


class Packet:
    """A packet: its kind, whether the station sent it, and what this test needs of it."""

    def __init__(self, from_station, head, body):
        self.from_station, self.kind = from_station, head >> 4
        if self.kind == CONNECT and from_station:
            self.connect(body)
        elif self.kind == PUBLISH:
            length = struct.unpack(">H", body[:2])[0]
            self.qos, self.is_retained, self.topic = head >> 1 & 3, bool(head & 1), body[2:2 + length].decode()
            self.raw = body[2 + length + (2 if self.qos else 0):]
            self.take_topic()
        elif self.kind == SUBSCRIBE:
            self.filters, rest = {}, body[2:]
            while rest:
                length = struct.unpack(">H", rest[:2])[0]
                self.filters[rest[2:2 + length].decode()] = rest[2 + length]
                rest = rest[3 + length:]

    def connect(self, body):
        def field(rest):
            length = struct.unpack(">H", rest[:2])[0]
            return rest[2:2 + length], rest[2 + length:]

        flags, rest = body[7], body[10:]
        self.is_clean, self.has_will = bool(flags & 2), bool(flags & 4)
        self.qos, self.is_retained = flags >> 3 & 3, bool(flags & 0x20)
        _, rest = field(rest)
        topic, rest = field(rest)
        self.topic, self.raw = topic.decode(), field(rest)[0]
        self.take_topic()

    def take_topic(self):
        parts = self.topic.split("/")
        self.verb = parts[2] if len(parts) > 3 else parts[1] if len(parts) > 1 else ""
        self.device = parts[4] if len(parts) > 4 else None
        is_state = self.verb == "STATE"
        self.payload = Payload.FromString(self.raw) if parts[0] == "spBv1.0" and not is_state else None


class Wire:
    """A proxy that keeps the packets of both directions in their order."""

    def __init__(self, broker):
        self.broker, self.port, self.packets, self.lock = broker, free_port(), [], threading.Lock()
        self.listener = socket.create_server(("127.0.0.1", self.port))
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            client, _ = self.listener.accept()
            server = socket.create_connection(("127.0.0.1", self.broker))
            for here, there, from_station in ((client, server, True), (server, client, False)):
                threading.Thread(target=self.pump, args=(here, there, from_station), daemon=True).start()

    def pump(self, here, there, from_station):
        rest = b""
        try:
            while True:
                chunk = here.recv(1 << 16)
                if not chunk:
                    break
                rest = self.parse(rest + chunk, from_station)
                there.sendall(chunk)
        except OSError:
            pass
        for it in (here, there):
            try:
                it.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def parse(self, octets, from_station):
        while len(octets) >= 2:
            length, at = 0, 1
            while at < len(octets):
                length |= (octets[at] & 0x7F) << 7 * (at - 1)
                at += 1
                if not octets[at - 1] & 0x80:
                    break
            else:
                return octets
            if len(octets) < at + length:
                return octets
            packet = Packet(from_station, octets[0], octets[at:at + length])
            with self.lock:
                self.packets.append(packet)
            octets = octets[at + length:]
        return octets

    def seen(self, condition):
        with self.lock:
            return [it for it in self.packets if condition(it)]

    def published(self, verb, device=None):
        return self.seen(lambda it: it.from_station and it.kind == PUBLISH and it.verb == verb and (device is None or it.device == device))


def metric(payload, name):
    return next((it for it in payload.metrics if it.name == name), None)


def is_valued(it):
    return it.is_null or it.WhichOneof("value") is not None


class Session:
    """A session as it was on the wire, from CONNECT to its end."""

    def __init__(self, packets):
        self.packets = packets
        self.connect = packets[0]
        own = [it for it in packets if it.from_station and it.kind == PUBLISH]
        self.own, self.births = own, [it for it in own if it.verb == "NBIRTH"]
        self.dbirths, self.ddeaths = [it for it in own if it.verb == "DBIRTH"], [it for it in own if it.verb == "DDEATH"]
        self.data = [it for it in own if it.verb in ("NDATA", "DDATA")]
        self.ndeaths = [it for it in own if it.verb == "NDEATH"]
        self.born = self.births + self.dbirths
        self.filters = {name: qos for it in packets if it.kind == SUBSCRIBE for name, qos in it.filters.items()}

    def index(self, condition):
        return next(number for number, it in enumerate(self.packets) if condition(it))

    def topic(self, verb, device=None):
        return "/".join(filter(None, ["spBv1.0", GROUP, verb, NODE, device]))

    def numbered(self):
        """Whether each message has the number that follows that of the message before; a node's birth begins with 0."""
        last = None
        for it in self.own:
            if it.verb == "NDEATH":
                continue
            wanted = 0 if it.verb == "NBIRTH" else (last + 1) % 256
            if not it.payload.HasField("seq") or it.payload.seq != wanted:
                return False
            last = it.payload.seq
        return True

    def after_birth(self):
        """Whether data and deaths of devices come after their births, and births of devices after that of the node."""
        alive = set()
        for it in self.own:
            if it.verb == "NBIRTH":
                alive = {None}
            elif it.verb == "DBIRTH" and None in alive:
                alive.add(it.device)
            elif it.verb == "DDEATH" and it.device in alive:
                alive.discard(it.device)
            elif it.verb not in ("NDEATH",) and it.device not in alive:
                return False
        return True

    def aliases(self):
        """The aliases of the births of the first generation: one for each metric, no two the same."""
        first = self.births[:1] + [next(it for it in self.dbirths if it.device == device) for device in {it.device for it in self.dbirths}]
        found = [it.alias for packet in first for it in packet.payload.metrics if it.HasField("alias")]
        return len(found) == len(set(found))

    def in_data(self):
        known = {it.alias for packet in self.born for it in packet.payload.metrics if it.HasField("alias")}
        return all(it.HasField("alias") and not it.name and it.alias in known for packet in self.data for it in packet.payload.metrics)

    def properties(self):
        for packet in self.own:
            for it in packet.payload.metrics:
                yield from zip(it.properties.keys, it.properties.values)

    def is_every(self, packets, qos, retained=False):
        return bool(packets) and all((it.qos, it.is_retained) == (qos, retained) for it in packets)

    def timed(self, packets):
        return bool(packets) and all(abs(it.payload.timestamp / 1000 - time.time()) < 3600 for it in packets)

    def waited(self):
        """The birth comes after the state of the primary host, which was online."""
        online = self.index(lambda it: not it.from_station and it.kind == PUBLISH and it.verb == "STATE" and json.loads(it.raw)["online"])
        return online < self.index(lambda it: it.from_station and it.kind == PUBLISH and it.verb == "NBIRTH")


def bd_seq(payload):
    return metric(payload, "bdSeq").long_value


def is_id(text):
    return text and not set(text) & set("+/#")


def rebirth_of(it):
    return metric(it.payload, REBIRTH)


# Statements, and whether a session fulfils them.
ASSERTIONS = [
    ("principles-persistence-clean-session-311", lambda s: s.connect.is_clean),
    ("message-flow-edge-node-birth-publish-connect message-flow-edge-node-birth-publish-will-message payloads-ndeath-will-message",
     lambda s: s.connect.has_will),
    ("message-flow-edge-node-birth-publish-will-message-topic", lambda s: s.connect.topic == s.topic("NDEATH")),
    ("message-flow-edge-node-birth-publish-will-message-qos payloads-ndeath-will-message-qos", lambda s: s.connect.qos == 1),
    ("message-flow-edge-node-birth-publish-will-message-will-retained payloads-ndeath-will-message-retain", lambda s: not s.connect.is_retained),
    ("payloads-ndeath-seq topics-ndeath-seq", lambda s: not s.connect.payload.HasField("seq")),
    ("topics-ndeath-payload payloads-ndeath-bdseq message-flow-edge-node-birth-publish-will-message-payload",
     lambda s: [it.name for it in s.connect.payload.metrics] == ["bdSeq"]),
    ("message-flow-edge-node-ncmd-subscribe", lambda s: s.filters.get(s.topic("NCMD")) == 1),
    ("message-flow-device-dcmd-subscribe", lambda s: any(name.startswith(s.topic("DCMD")) and qos == 1 for name, qos in s.filters.items())),
    ("message-flow-edge-node-birth-publish-phid-wait message-flow-edge-node-birth-publish-phid-wait-id "
     "message-flow-edge-node-birth-publish-phid-wait-online", lambda s: f"spBv1.0/STATE/{HOST}" in s.filters and s.waited()),
    ("principles-birth-certificates-order payloads-ndata-order payloads-ddata-order payloads-dbirth-order "
     "message-flow-device-birth-publish-nbirth-wait", lambda s: s.own[0].verb == "NBIRTH" and s.after_birth()),
    ("topics-nbirth-topic message-flow-edge-node-birth-publish-nbirth-topic payloads-nbirth-edge-node-descriptor",
     lambda s: all(it.topic == s.topic("NBIRTH") for it in s.births)),
    ("topics-nbirth-mqtt payloads-nbirth-qos payloads-nbirth-retain message-flow-edge-node-birth-publish-nbirth-qos "
     "message-flow-edge-node-birth-publish-nbirth-retained", lambda s: s.is_every(s.births, 0)),
    ("payloads-nbirth-seq topics-nbirth-seq-num payloads-sequence-num-req-nbirth payloads-sequence-num-zero-nbirth "
     "message-flow-edge-node-birth-publish-nbirth-payload-seq payloads-sequence-num-always-included payloads-sequence-num-incrementing "
     "payloads-dbirth-seq payloads-dbirth-seq-inc topics-dbirth-seq payloads-ndata-seq payloads-ndata-seq-inc payloads-ddata-seq "
     "payloads-ddata-seq-inc payloads-ddeath-seq payloads-ddeath-seq-inc", lambda s: s.numbered()),
    ("payloads-nbirth-timestamp topics-nbirth-timestamp", lambda s: s.timed(s.births)),
    ("topics-nbirth-bdseq-included payloads-nbirth-bdseq message-flow-edge-node-birth-publish-nbirth-payload-bdseq",
     lambda s: all(metric(it.payload, "bdSeq") for it in s.births)),
    ("topics-nbirth-bdseq-matching payloads-nbirth-bdseq-repeat operational-behavior-data-commands-rebirth-action-3",
     lambda s: {bd_seq(it.payload) for it in s.births} == {bd_seq(s.connect.payload)}),
    ("topics-nbirth-rebirth-metric payloads-nbirth-rebirth-req operational-behavior-data-commands-rebirth-name", lambda s: all(map(rebirth_of, s.births))),
    ("operational-behavior-data-commands-rebirth-datatype", lambda s: all(rebirth_of(it).datatype == 11 for it in s.births)),
    ("operational-behavior-data-commands-rebirth-value", lambda s: all(rebirth_of(it).boolean_value is False for it in s.births)),
    ("operational-behavior-data-commands-rebirth-name-aliases", lambda s: not any(rebirth_of(it).HasField("alias") for it in s.births)),
    ("topics-nbirth-metrics topics-dbirth-metrics payloads-metric-datatype-req payloads-metric-datatype-value "
     "operational-behavior-data-publish-nbirth-values operational-behavior-data-publish-dbirth-values",
     lambda s: all(it.name and 1 <= it.datatype <= 34 and is_valued(it) for packet in s.born for it in packet.payload.metrics)),
    ("payloads-name-birth-data-requirement", lambda s: all(it.HasField("timestamp") for packet in s.born + s.data for it in packet.payload.metrics)),
    ("payloads-alias-uniqueness payloads-alias-birth-requirement", lambda s: s.aliases()),
    ("payloads-alias-data-cmd-requirement payloads-name-requirement", lambda s: bool(s.data) and s.in_data()),
    ("case-sensitivity-metric-names", lambda s: all(
        len({it.name.lower() for it in packet.payload.metrics}) == len(packet.payload.metrics) for packet in s.born)),
    ("case-sensitivity-sparkplug-ids", lambda s: len({it.device.lower() for it in s.dbirths}) == len({it.device for it in s.dbirths})),
    ("topics-dbirth-topic message-flow-device-birth-publish-dbirth-topic message-flow-device-birth-publish-dbirth-match-edge-node-topic",
     lambda s: all(it.topic == s.topic("DBIRTH", it.device) for it in s.dbirths)),
    ("topics-dbirth-mqtt payloads-dbirth-qos payloads-dbirth-retain message-flow-device-birth-publish-dbirth-qos "
     "message-flow-device-birth-publish-dbirth-retained", lambda s: s.is_every(s.dbirths, 0)),
    ("payloads-dbirth-timestamp topics-dbirth-timestamp message-flow-device-birth-publish-dbirth-payload", lambda s: s.timed(s.dbirths)),
    ("topics-ndata-mqtt topics-ddata-mqtt payloads-ndata-qos payloads-ndata-retain payloads-ddata-qos payloads-ddata-retain",
     lambda s: s.is_every(s.data, 0)),
    ("topics-ndata-timestamp topics-ddata-timestamp payloads-ndata-timestamp payloads-ddata-timestamp", lambda s: s.timed(s.data)),
    ("topics-ddeath-mqtt", lambda s: s.is_every(s.ddeaths, 0)),
    ("payloads-ddeath-timestamp", lambda s: s.timed(s.ddeaths)),
    ("payloads-propertyset-keys-array-size payloads-propertyset-values-array-size", lambda s: all(
        len(it.properties.keys) == len(it.properties.values) for packet in s.own for it in packet.payload.metrics)),
    ("payloads-metric-propertyvalue-type-req payloads-metric-propertyvalue-type-value", lambda s: all(1 <= value.type <= 21 for _, value in s.properties())),
    ("payloads-propertyset-quality-value-type", lambda s: all(value.type == 3 for key, value in s.properties() if key == "Quality")),
    ("payloads-propertyset-quality-value-value", lambda s: {value.int_value for key, value in s.properties() if key == "Quality"} <= {0, 192, 500}),
    ("topic-structure-namespace-valid-group-id topic-structure-namespace-valid-edge-node-id topic-structure-namespace-valid-device-id",
     lambda s: is_id(GROUP) and is_id(NODE) and all(is_id(it.device) for it in s.dbirths)),
    ("operational-behavior-edge-node-intentional-disconnect-ndeath operational-behavior-edge-node-intentional-disconnect-packet",
     lambda s: [it.kind for it in s.packets if it.from_station and it.kind in (PUBLISH, DISCONNECT)][-2:] == [PUBLISH, DISCONNECT]
     and s.own[-1].verb == "NDEATH" and bd_seq(s.own[-1].payload) == bd_seq(s.connect.payload)),
    ("operational-behavior-data-commands-rebirth-action-1 operational-behavior-data-commands-rebirth-action-2", lambda s: len(s.births) >= 2),
    ("operational-behavior-device-ddeath", lambda s: any(it.topic == s.topic("DDEATH", "chamber") for it in s.ddeaths)),
]


def sessions_of(packets):
    """Each session of the station: a CONNECT and what follows until the next one."""
    starts = [number for number, it in enumerate(packets) if it.from_station and it.kind == CONNECT]
    return [Session(packets[begin:end]) for begin, end in zip(starts, [*starts[1:], None])]


def host_of(broker):
    host = mqtt.Client("sparkplug-host", clean_session=True)
    host.connect("127.0.0.1", broker, keepalive=60)
    host.loop_start()
    state = json.dumps({"online": True, "timestamp": int(time.time() * 1000)})
    host.publish(f"spBv1.0/STATE/{HOST}", state, qos=1, retain=True).wait_for_publish()
    return host


def first_session(plant, wire, host):
    """Births, data, an unplugged gauge, a rebirth, an intended end."""
    wait_for("data of the gauge", lambda: wire.published("DDATA", "chamber"))
    plant.tell("power 5 off")
    wait_for("the death of the device", lambda: wire.published("DDEATH", "chamber"))
    begin = len(wire.published("DBIRTH", "chamber"))
    plant.tell("power 5 on")
    wait_for("its next birth", lambda: len(wire.published("DBIRTH", "chamber")) > begin)
    rebirth = Payload(timestamp=int(time.time() * 1000))
    rebirth.metrics.add(name=REBIRTH, datatype=spb.DataType.BOOLEAN, boolean_value=True)
    host.publish(f"spBv1.0/{GROUP}/NCMD/{NODE}", rebirth.SerializeToString())
    wait_for("the rebirth", lambda: len(wire.published("NBIRTH")) >= 2)
    wait_for("the births of the devices", lambda: len(wire.published("DBIRTH", "load lock")) >= 2)
    begin = len(wire.published("DDATA", "chamber"))
    plant.tell("pressure 5e-3 mbar")
    wait_for("data after the rebirth", lambda: len(wire.published("DDATA", "chamber")) > begin)


def run(program, broker):
    """Returns how many statements hold; ends the program with those that do not."""
    wire = Wire(broker)
    host = host_of(broker)
    with Plant(program, TABLES.format(port=wire.port)) as plant:
        first_session(plant, wire, host)
        plant.restart()
        def both():
            sessions = sessions_of(wire.seen(lambda _: True))
            return sessions if len(sessions) > 1 and sessions[-1].births else None

        sessions = wait_for("the second session", both)
    host.loop_stop()
    first, second = sessions[0], sessions[-1]
    failed = [names for names, holds in ASSERTIONS if not holds(first)]
    increment = "topics-nbirth-bdseq-increment message-flow-edge-node-birth-publish-will-message-payload-bdSeq"
    if bd_seq(second.connect.payload) != (bd_seq(first.connect.payload) + len(sessions) - 1) % 256:
        failed.append(increment)
    if failed:
        raise SystemExit("these statements of Sparkplug 3.0 do not hold:\n" + "\n".join(failed))
    return sum(len(names.split()) for names, _ in [*ASSERTIONS, (increment, None)])


def main():
    from mqtt import Broker

    with tempfile.TemporaryDirectory() as folder, Broker(folder, free_port()) as broker:
        print(f"{run(os.path.abspath(sys.argv[1]), broker.port)} statements of Sparkplug 3.0 hold on the wire", flush=True)


if __name__ == "__main__":
    main()
