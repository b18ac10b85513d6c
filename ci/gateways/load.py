#!/usr/bin/env python3
"""The processor share of the gateways: ci/gateways/load.py PROGRAM [SECONDS [--alone]]

A station with 480 virtual gauges at 5 Hz and 50 subscribers for each protocol, one protocol after the other: monitors of the time of each
reading over Channel Access and PV Access, subscribers of a broker, masters that read all slots over Modbus once a second, servers that
scrape Prometheus every 5 s, sessions of OPC UA with a value for each gauge every 200 ms. Prints the processor time of each group
of threads in percent of one core. PROGRAM has the feature opcua; mosquitto is installed. Not part of ./test.

With --alone the gauges are processes behind TCP ports, so that the processor time is that of the station without the simulation; it has no
gateways and no clients. Prints the time of each group of threads too.
"""

import asyncio
import json
import os
import selectors
import socket
import struct
import subprocess
import sys
import tempfile
import time
import urllib.request

from plant import free_port, wait_for

SEGMENTS, GAUGES = 16, 30
MASTERS, SCRAPERS = 50, 50
POLL_S, SCRAPE_S = 1.0, 5.0


class Gauges:
    """The virtual gauges of each segment as a process behind a TCP port."""

    def __init__(self, program, segments=SEGMENTS, gauges=GAUGES):
        # Without gauges one slave, which the station does not know, is behind the port.
        devices = [f"bcg450@{address}" for address in range(3, 3 + max(1, gauges))]
        command = [program, "simulate", "--tcp", "127.0.0.1:0", "--baud", "19200", *devices]
        self.processes = [subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) for _ in range(segments)]
        self.ports = [it.stdout.readline().split()[1] for it in self.processes]

    def close(self):
        for process in self.processes:
            process.kill()
            process.wait()


def plant_file(folder, lines):
    """Writes a file that only its owner reads, and returns its path."""
    path = os.path.join(folder, "plant.toml")
    with open(path, "w", opener=lambda path, flags: os.open(path, flags, 0o600)) as file:
        file.write("\n".join(lines))
    return path


def write_lone_plant(folder, ports, gauges=GAUGES, tables=""):
    """A station whose gauges are elsewhere: a segment for each port."""
    lines = ['[station]\nname = "load"\n', tables]
    for segment, port in enumerate(ports):
        lines.append(f'[[segment]]\nname = "s{segment}"\nport = "tcp://{port}"\nbaud = 19200\n')
        for address in range(3, 3 + gauges):
            lines.append(f'[[segment.gauge]]\nname = "g{segment}-{address}"\naddress = {address}\ndevice = "bcg450"\npoll = "200ms"\n')
    return plant_file(folder, lines)


def answer_of(url):
    with urllib.request.urlopen(url, timeout=60) as answer:
        return json.load(answer)


def exchanges(url):
    """The exchanges of data of all segments in a second: a cycle has one for each gauge."""
    return sum(GAUGES * 1000 / segment["cycle_ms"] for segment in answer_of(f"{url}/api/segments"))


def exchanging(url):
    """How many gauges exchange data."""
    return sum(gauge["state"] == "data-exchange" for gauge in answer_of(f"{url}/api/gauges"))


def alone(program, seconds):
    """Prints the processor share of a station without clients, user and system apart."""
    folder, gauges = tempfile.mkdtemp(prefix="profivac-load-"), Gauges(program)
    command = [program, "run", write_lone_plant(folder, gauges.ports), "--listen", "127.0.0.1:0"]
    station = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        said = station.stdout.readline()
        url = said[said.index("http://"):].strip()
        wait_for("480 gauges in data exchange", lambda: exchanging(url) == SEGMENTS * GAUGES)
        time.sleep(10)
        before, by_thread, began = user_and_system(station.pid), times(station.pid, of_station), time.monotonic()
        time.sleep(seconds)
        after, passed = user_and_system(station.pid), time.monotonic() - began
        user, system = (100 * (new - old) / passed for new, old in zip(after, before))
        print(f"the station alone: {user + system:.1f} % of a core, user {user:.1f} %, system {system:.1f} %; "
              f"{exchanges(url):.0f} exchanges/s; load of the computer {os.getloadavg()[0]:.1f}")
        for name, spent in sorted(times(station.pid, of_station).items(), key=lambda it: -it[1]):
            share = 100 * (spent - by_thread.get(name, 0)) / passed
            if share >= 0.05:
                print(f"  {name}: {share:.1f} %")
    finally:
        station.terminate()
        station.wait()
        gauges.close()
        subprocess.run(["rm", "-rf", folder], check=False)


def user_and_system(pid):
    """The processor time of a process in seconds, in its own code and in the kernel."""
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return [int(it) / os.sysconf("SC_CLK_TCK") for it in fields[11:13]]


def pressures(prometheus):
    """How many gauges have a pressure."""
    with urllib.request.urlopen(f"http://127.0.0.1:{prometheus}/metrics") as answer:
        return answer.read().count(b"\nprofivac_reading_pressure_pascals{")


def write_plant(folder, ports):
    lines = []
    for segment in range(SEGMENTS):
        path = os.path.join(folder, f"s{segment}.toml")
        devices = ", ".join(f'"bcg450@{address}"' for address in range(3, 3 + GAUGES))
        with open(path, "w") as file:
            file.write(f"baud = 1500000\ndevices = [{devices}]\n")
        lines.append(f'[[segment]]\nname = "s{segment}"\nport = "sim:{path}"\nbaud = 1500000\n')
        for address in range(3, 3 + GAUGES):
            lines.append(f'[[segment.gauge]]\nname = "g{segment}-{address}"\naddress = {address}\ndevice = "bcg450"\npoll = "200ms"\n')
    ca, pva, opcua, broker = ports[2:]
    lines.append(f'[epics]\nca-port = {ca}\npva-port = {pva}\npva-search-port = {free_port()}\n\n[opcua]\nlisten = "127.0.0.1:{opcua}"\n')
    lines.append(f'[mqtt]\nbroker = "mqtt://127.0.0.1:{broker}"\n\n[mqtt.sparkplug]\ngroup = "load"\n')
    lines.append(f'[modbus]\nlisten = "127.0.0.1:{ports[0]}"\n\n[prometheus]\nlisten = "127.0.0.1:{ports[1]}"\n')
    return plant_file(folder, lines)


def of_gateway(thread):
    """The group of a thread: its gateway, or everything else."""
    gateways = ("epics", "mqtt", "modbus", "opcua", "prometheus", "read model", "sparkplug")
    return thread if thread in gateways else "segments, recorder, API"


def of_station(thread):
    """The group of a thread: the segments, or its name."""
    return "segments" if thread.startswith("s") and thread[1:].isdigit() else thread


def times(pid, group=of_gateway):
    """Processor seconds of each group of threads, by name."""
    found, tick = {}, os.sysconf("SC_CLK_TCK")
    for task in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{task}/stat") as file:
            text = file.read()
        name = text[text.index("(") + 1:text.rindex(")")]
        name = group(name)
        user, system = text[text.rindex(")") + 2:].split()[11:13]
        found[name] = found.get(name, 0) + (int(user) + int(system)) / tick
    return found


async def exactly(reader, count):
    return await reader.readexactly(count)


async def master(port, counts):
    """Reads the header and all 480 slots in blocks of 120 registers, once a second."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    while True:
        began = time.monotonic()
        for first in range(100, 100 + 20 * SEGMENTS * GAUGES, 120):
            writer.write(struct.pack(">HHHBBHH", first, 0, 6, 1, 4, first, 120))
            head = await exactly(reader, 9)
            assert head[7] == 4, head
            await exactly(reader, head[8])
            counts["modbus"] += 1
        counts["slowest round"] = max(counts["slowest round"], time.monotonic() - began)
        await asyncio.sleep(max(0.0, POLL_S - (time.monotonic() - began)))


async def scraper(port, counts):
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    while True:
        began = time.monotonic()
        writer.write(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nAccept: application/openmetrics-text\r\n\r\n")
        head = await reader.readuntil(b"\r\n\r\n")
        length = next(int(line.split(b":")[1]) for line in head.lower().split(b"\r\n") if line.startswith(b"content-length"))
        await exactly(reader, length)
        counts["prometheus"] += 1
        counts["octets"] = length
        counts["slowest scrape"] = max(counts["slowest scrape"], time.monotonic() - began)
        await asyncio.sleep(max(0.0, SCRAPE_S - (time.monotonic() - began)))


async def clients(ports, seconds, counts):
    tasks = []
    for number in range(MASTERS):
        tasks.append(asyncio.create_task(master(ports[0], counts)))
        await asyncio.sleep(POLL_S / MASTERS)
    for number in range(SCRAPERS):
        tasks.append(asyncio.create_task(scraper(ports[1], counts)))
        await asyncio.sleep(0)
    done, _ = await asyncio.wait(tasks, timeout=seconds, return_when=asyncio.FIRST_EXCEPTION)
    for task in done:
        task.result()
    for task in tasks:
        task.cancel()


def measured(label, pid, seconds, run):
    before, began = times(pid), time.monotonic()
    run()
    report(label, before, times(pid), time.monotonic() - began)


GAUGE_NAMES = [f"G{segment}-{address}" for segment in range(SEGMENTS) for address in range(3, 3 + GAUGES)]


def ca_circuit(port):
    """A circuit of Channel Access with a monitor on the time of each reading, as a text with time (type 14)."""
    def message(command, payload, data_type, count, first, second):
        payload += bytes(-len(payload) % 8)
        return struct.pack(">HHHHII", command, len(payload), data_type, count, first, second) + payload

    it = socket.create_connection(("127.0.0.1", port), 30)
    it.sendall(message(0, b"", 0, 13, 0, 0))
    for number, name in enumerate(GAUGE_NAMES, 1):
        # The channels of a circuit have the numbers from 1.
        it.sendall(message(18, f"{name}:LAST_READING".encode() + b"\0", 0, 0, number, 13))
        it.sendall(message(1, bytes(12) + struct.pack(">HH", 5, 0), 14, 1, number, number))
    return it


def pva_circuit(port):
    """A connection of PV Access with the same monitors."""
    def message(command, payload):
        return bytes([0xCA, 2, 0, command]) + struct.pack("<I", len(payload)) + payload

    it = socket.create_connection(("127.0.0.1", port), 30)
    it.sendall(message(1, struct.pack("<IHH", 65536, 32767, 0) + b"\x09anonymous\xff"))
    for number, name in enumerate(GAUGE_NAMES, 1):
        name = f"{name}:LAST_READING".encode()
        it.sendall(message(7, struct.pack("<HI", 1, number) + bytes([len(name)]) + name))
        it.sendall(message(13, struct.pack("<IIB", number, number, 8)))
        it.sendall(message(13, struct.pack("<IIB", number, number, 0x44)))
    return it


def mqtt_subscriber(port):
    """A subscriber of everything, by hand: CONNECT, SUBSCRIBE."""
    def packet(kind, body):
        return bytes([kind, len(body)]) + body

    it = socket.create_connection(("127.0.0.1", port), 30)
    name = f"load{it.getsockname()[1]}".encode()
    it.sendall(packet(0x10, b"\x00\x04MQTT\x04\x02\x00\x00" + struct.pack(">H", len(name)) + name))
    it.sendall(packet(0x82, b"\x00\x01\x00\x01#\x00"))
    return it


def drained(sockets, seconds):
    """Reads and throws away; returns the octets."""
    selector, octets, end = selectors.DefaultSelector(), 0, time.monotonic() + seconds
    for it in sockets:
        it.setblocking(False)
        selector.register(it, selectors.EVENT_READ)
    while time.monotonic() < end:
        for key, _ in selector.select(0.2):
            chunk = key.fileobj.recv(1 << 20)
            assert chunk, "the server closed a connection"
            octets += len(chunk)
    return octets


class OpcUaSubscriber:
    """A subscriber with a value for each gauge, sampled and published every 200 ms. Requests are made with the structures of asyncua;
    answers are counted, and decoded for `is_decoding` alone, because decoding for 50 takes more than a core in Python."""

    def __init__(self, port, is_decoding):
        from asyncua import ua

        self.ua, self.is_decoding = ua, is_decoding
        self.rest, self.values, self.messages, self.number = bytearray(), 0, 0, 0
        self.channel = self.token = 0
        self.socket = socket.create_connection(("127.0.0.1", port), 60)
        url = f"opc.tcp://127.0.0.1:{port}/".encode()
        body = struct.pack("<IIIIII", 0, 65535, 65535, 0, 0, len(url)) + url
        self.socket.sendall(b"HELF" + struct.pack("<I", 8 + len(body)) + body)
        self.receive()
        self.open()
        self.session = ua.NodeId()
        create = ua.CreateSessionRequest()
        create.Parameters.RequestedSessionTimeout = 3_600_000
        create.Parameters.SessionName = "load"
        create.Parameters.EndpointUrl = url.decode()
        self.session = self.ask(create, ua.CreateSessionResponse).Parameters.AuthenticationToken
        activate = ua.ActivateSessionRequest()
        activate.Parameters.UserIdentityToken = ua.AnonymousIdentityToken(PolicyId="anonymous")
        self.ask(activate, ua.ActivateSessionResponse)
        self.subscribe()
        for _ in range(3):
            self.publish()

    def send(self, kind, head, request):
        from asyncua.ua.ua_binary import struct_to_binary

        self.number += 1
        request.RequestHeader.RequestHandle = self.number
        request.RequestHeader.TimeoutHint = 60_000
        if kind == b"MSG":
            request.RequestHeader.AuthenticationToken = self.session
        body = head + struct.pack("<II", self.number, self.number) + struct_to_binary(request)
        self.socket.sendall(kind + b"F" + struct.pack("<II", 12 + len(body), self.channel) + body)

    def receive(self):
        """The next whole message, blocking: the body behind the security header, or all of it for ACK."""
        parts = b""
        while True:
            head = self.exactly(8)
            body = self.exactly(struct.unpack("<I", head[4:])[0] - 8)
            if head[:3] in (b"ACK", b"OPN"):
                return body
            assert head[:3] == b"MSG", (head, body)
            parts += body[16:]
            if head[3:4] == b"F":
                return parts

    def exactly(self, count):
        octets = b""
        while len(octets) < count:
            more = self.socket.recv(count - len(octets))
            assert more, "the server closed a connection"
            octets += more
        return octets

    def decoded(self, octets, kind):
        from asyncua.common.utils import Buffer
        from asyncua.ua.ua_binary import struct_from_binary

        answer = struct_from_binary(kind, Buffer(octets))
        answer.ResponseHeader.ServiceResult.check()
        return answer

    def open(self):
        ua = self.ua
        request = ua.OpenSecureChannelRequest()
        request.Parameters.RequestedLifetime = 3_600_000
        request.Parameters.SecurityMode = ua.MessageSecurityMode.None_
        policy = b"http://opcfoundation.org/UA/SecurityPolicy#None"
        self.send(b"OPN", struct.pack("<i", len(policy)) + policy + struct.pack("<ii", -1, -1), request)
        body = self.receive()
        length = struct.unpack("<i", body[4:8])[0]
        answer = self.decoded(body[8 + length + 8 + 8:], ua.OpenSecureChannelResponse)
        self.channel, self.token = answer.Parameters.SecurityToken.ChannelId, answer.Parameters.SecurityToken.TokenId

    def ask(self, request, kind):
        self.send(b"MSG", struct.pack("<I", self.token), request)
        return self.decoded(self.receive(), kind)

    def subscribe(self):
        ua = self.ua
        create = ua.CreateSubscriptionRequest()
        create.Parameters.RequestedPublishingInterval = 200
        create.Parameters.RequestedLifetimeCount = 10_000
        create.Parameters.RequestedMaxKeepAliveCount = 100
        create.Parameters.PublishingEnabled = True
        subscription = self.ask(create, ua.CreateSubscriptionResponse).Parameters.SubscriptionId
        items = ua.CreateMonitoredItemsRequest()
        items.Parameters.SubscriptionId = subscription
        items.Parameters.TimestampsToReturn = ua.TimestampsToReturn.Both
        for number, name in enumerate(GAUGE_NAMES):
            item = ua.MonitoredItemCreateRequest()
            item.ItemToMonitor.NodeId = ua.NodeId(f"gauge/{name.lower()}/last-reading", 2)
            item.ItemToMonitor.AttributeId = ua.AttributeIds.Value
            item.MonitoringMode = ua.MonitoringMode.Reporting
            item.RequestedParameters.ClientHandle = number
            item.RequestedParameters.SamplingInterval = 200
            item.RequestedParameters.QueueSize = 1
            items.Parameters.ItemsToCreate.append(item)
        for result in self.ask(items, ua.CreateMonitoredItemsResponse).Results:
            result.StatusCode.check()

    def publish(self):
        self.send(b"MSG", struct.pack("<I", self.token), self.ua.PublishRequest())

    def take(self, octets):
        """Octets that have arrived: counts whole answers, and asks for the next one after each."""
        self.rest += octets
        while len(self.rest) >= 8:
            size = struct.unpack_from("<I", self.rest, 4)[0]
            if len(self.rest) < size:
                return
            message = bytes(self.rest[:size])
            del self.rest[:size]
            assert message[:4] == b"MSGF", message[:16]
            self.messages += 1
            if self.is_decoding:
                answer = self.decoded(message[24:], self.ua.PublishResponse)
                for data in answer.Parameters.NotificationMessage.NotificationData:
                    self.values += len(data.MonitoredItems)
            self.socket.setblocking(True)
            self.publish()
            self.socket.setblocking(False)


def take_all(subscribers, seconds):
    """Serves the subscribers for a time; returns the octets."""
    selector, octets, end = selectors.DefaultSelector(), 0, time.monotonic() + seconds
    for it in subscribers:
        it.socket.setblocking(False)
        selector.register(it.socket, selectors.EVENT_READ, it)
    while time.monotonic() < end:
        for key, _ in selector.select(0.2):
            chunk = key.fileobj.recv(1 << 20)
            assert chunk, "the server closed a connection"
            octets += len(chunk)
            key.data.take(chunk)
    return octets


def with_opcua(pid, port, seconds, count=50):
    subscribers = [OpcUaSubscriber(port, number == 0) for number in range(count)]
    # The first values.
    take_all(subscribers, 5)
    before = [(it.messages, it.values) for it in subscribers]
    octets = []
    measured(f"OPC UA, {count} subscribers", pid, seconds, lambda: octets.append(take_all(subscribers, seconds)))
    messages = sum(it.messages - old for it, (old, _) in zip(subscribers, before))
    values = subscribers[0].values - before[0][1]
    least = min(it.messages - old for it, (old, _) in zip(subscribers, before))
    print(f"  opcua: {messages / seconds:.0f} answers/s, {octets[0] / seconds / 1e6:.1f} MB/s; "
          f"{values / seconds:.0f} values/s for each of {count} subscribers, at least {least / seconds:.1f} answers/s for each")
    for it in subscribers:
        it.socket.close()


def status(url, name):
    with urllib.request.urlopen(url + "/api/gateways", timeout=30) as answer:
        return next(it for it in json.load(answer) if it["name"] == name)


def counted(url, gateway, seconds, run):
    """Runs with what the gateway counts meanwhile."""
    before = status(url, gateway)
    octets = run()
    after = status(url, gateway)
    sent, dropped = (after[key] - before[key] for key in ("sent", "dropped_updates"))
    text = f"  {gateway}: {sent / seconds:.0f} sent/s, {dropped / seconds:.0f} replaced/s, {after['clients']} clients"
    print(text + (f", {octets / seconds / 1e6:.1f} MB/s read" if octets else ""))


def with_sockets(label, url, gateway, pid, seconds, make):
    sockets = [make() for _ in range(50)]
    try:
        # The first values of all monitors.
        drained(sockets, 5)
        measured(label, pid, seconds, lambda: counted(url, gateway, seconds, lambda: drained(sockets, seconds)))
    finally:
        for it in sockets:
            it.close()


def report(label, before, after, passed):
    shares = {name: 100 * (after[name] - before.get(name, 0)) / passed for name in sorted(after)}
    print(label + ": " + ", ".join(f"{name} {share:.1f} %" for name, share in shares.items()), flush=True)


def main():
    program, seconds = os.path.abspath(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 20
    if "--alone" in sys.argv:
        return alone(program, seconds)
    folder, ports = tempfile.mkdtemp(prefix="profivac-load-"), [free_port() for _ in range(6)]
    broker = subprocess.Popen(["mosquitto", "-p", str(ports[5])], stderr=subprocess.DEVNULL)
    plant = write_plant(folder, ports)
    station = subprocess.Popen([program, "run", plant, "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True)
    try:
        url = station.stdout.readline().split()[1]

        wait_for("480 pressures", lambda: pressures(ports[1]) == SEGMENTS * GAUGES)
        counts = {"modbus": 0, "prometheus": 0, "octets": 0, "slowest round": 0.0, "slowest scrape": 0.0}
        measured("without clients", station.pid, seconds, lambda: time.sleep(seconds))
        with_sockets("Channel Access, 50 subscribers", url, "epics", station.pid, seconds, lambda: ca_circuit(ports[2]))
        with_sockets("PV Access, 50 subscribers", url, "epics", station.pid, seconds, lambda: pva_circuit(ports[3]))
        with_sockets("MQTT, 50 subscribers of the broker", url, "mqtt", station.pid, seconds, lambda: mqtt_subscriber(ports[5]))
        with_opcua(station.pid, ports[4], seconds)
        measured("Modbus and Prometheus, 50 each", station.pid, seconds, lambda: asyncio.run(clients(ports, seconds, counts)))
        print(f"  Modbus: {counts['modbus'] / seconds:.0f} requests/s, a round of 480 slots at most {counts['slowest round'] * 1e3:.0f} ms")
        print(f"  Prometheus: {counts['prometheus'] / seconds:.1f} scrapes/s of {counts['octets'] / 1e6:.2f} MB, at most {counts['slowest scrape'] * 1e3:.0f} ms")
    finally:
        station.terminate()
        station.wait()
        broker.terminate()
        broker.wait()
        subprocess.run(["rm", "-rf", folder], check=False)


if __name__ == "__main__":
    main()
