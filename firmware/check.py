#!/usr/bin/env python3
"""Builds the firmware, measures it, and runs it in QEMU against masters: firmware/check.py PROGRAM [OPTION...]

PROGRAM is the program `profivac`. With --long ten million random octets are sent instead of 200,000, and the power fails at every flash
operation. PYTHON has pyprofibus and EXAMPLE is `profirust_master` of crates/sim: without them these masters are left out. DEFMT_PRINT
reads the log; without it none is read. Prints the sizes, and one line for each check. Exit code 1 if one fails. Without QEMU, or without
the standard library of the target, which rustup fetches, it says why it is skipped.
"""

import argparse
import json
import os
import pathlib
import random
import re
import select
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
TARGET = "thumbv7em-none-eabihf"
RP2040_TARGET = "thumbv6m-none-eabi"
ADDRESS = 5
RAM = 8192
# Code and data of the BCG450 with its flash store. More than that is a mistake of a change.
MOST_CODE = 49_152
# With the feature `prepared-answers`.
MOST_PREPARED_CODE = 50_300
# Only bounds a hang.
TIMEOUT = 120

# A slot time of 200 ms, so that a loaded computer misses no answer of the emulated processor.
PATIENTLY = "--slot-time=4000"

# In the program no function may remain that a panic calls.
PANIC = ("panicking", "panic_fmt", "unwrap_failed", "expect_failed", "len_mismatch_fail")

# The images: devices of one family share a program, which chooses the device when it starts.
DEVICES = {
    "bcg450": "BCG450",
    "xpg400": "BPG400, HPG400",
    "pxg55x": "PCG550, PCG552, PCG554, PSG550, PSG552, PSG554",
    "tpg": "TPG300, TPG500",
    "img400": "IMG400",
}

failures = 0


def check(what, good, found=""):
    global failures
    failures += not good
    print(f"{'ok' if good else 'FAILED':7} {what}{': ' + str(found) if found != '' else ''}", flush=True)
    return good


def run(*command, **more):
    return subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, **more)


def cargo(folder, *arguments):
    environment = {**os.environ, "CARGO_TARGET_DIR": str(ROOT / "target" / "firmware")}
    subprocess.run(["nice", "cargo", *arguments], cwd=folder, env=environment, check=True, timeout=4 * TIMEOUT)


def build(image, *features, board="qemu", folder=HERE, package="profivac-gauge", target=TARGET):
    features = ",".join((board, *features))
    which = ("--package", package, "--bin", image, "--target", target, "--features", features)
    cargo(folder, "build", "--quiet", "--locked", "--release", *which)
    return ROOT / "target" / "firmware" / target / "release" / image


def sections(image):
    lines = run("size", "-A", image).stdout.splitlines()
    rows = [line.split() for line in lines if line.startswith(".")]
    return {row[0]: int(row[1]) for row in rows}


def sizes(image):
    found = sections(image)
    code = found[".vectors"] + found[".text"] + found[".rodata"] + found.get(".data", 0)
    return code, found.get(".data", 0) + found[".bss"]


class Gauge:
    """The firmware in QEMU: the bus on a TCP port or a pty, the console on a socket."""

    def __init__(self, image, bus_on_pty=False, log=None):
        self.folder = tempfile.TemporaryDirectory()
        console = os.path.join(self.folder.name, "console")
        bus = "pty,id=bus" if bus_on_pty else "socket,id=bus,host=127.0.0.1,port=0,server=on,wait=off,nodelay=on"
        command = ["qemu-system-arm", "-M", "mps2-an386", "-display", "none", "-kernel", str(image)]
        command += ["-chardev", bus, "-serial", "chardev:bus"]
        command += ["-chardev", f"socket,id=console,path={console},server=on,wait=off", "-serial", "chardev:console"]
        command += ["-chardev", f"file,id=log,path={log}", "-serial", "chardev:log"] if log else []
        command += ["-qmp", "stdio"]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.process.stdout.readline()
        self.tell("qmp_capabilities")
        name = next(it["filename"] for it in self.tell("query-chardev") if it["label"] == "bus")
        self.port = name.removeprefix("pty:") if bus_on_pty else "tcp://" + name.split(",")[0].split(":", 2)[-1].removeprefix("tcp:")
        self.console = socket.socket(socket.AF_UNIX)
        self.console.connect(console)
        self.console.settimeout(TIMEOUT)

    def tell(self, command):
        """A command of QEMU's machine protocol, and its answer."""
        self.process.stdin.write(json.dumps({"execute": command}) + "\n")
        self.process.stdin.flush()
        while True:
            answer = json.loads(self.process.stdout.readline())
            if "return" in answer:
                return answer["return"]

    def numbers(self, octet):
        """The numbers that the firmware prints for a command on its console."""
        self.console.sendall(bytes([octet]))
        return [int(word, 16) for word in self.line().split()]

    def line(self):
        """The next line from the console."""
        line = b""
        while not line.endswith(b"\n"):
            line += self.console.recv(1)
        return line

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.console.close()
        self.process.kill()
        self.process.communicate()
        self.folder.cleanup()


def lights(gauge):
    """Green flashes without data exchange. Red alone is on while the port does not have the rate of the bus; it works again with one that
    it has."""

    def become(*wanted):
        deadline, found = time.monotonic() + TIMEOUT, None
        while found != wanted and time.monotonic() < deadline:
            found = tuple(gauge.numbers(ord("l")))
        return check(f"lights {wanted} (green, red)", found == wanted, found)

    become(0, 0)
    become(1, 0)
    become(0, 0)
    gauge.numbers(ord("x"))
    become(0, 1)
    gauge.numbers(ord("y"))
    become(1, 0)


class Masters:
    """The program as a master of one gauge."""

    def __init__(self, program, gauge):
        self.program, self.gauge = program, gauge

    def __call__(self, command, *arguments, address=True):
        options = ["--port", self.gauge.port] + (["--address", str(ADDRESS), PATIENTLY] if address else [])
        return run(self.program, command, *options, *arguments)


def our_master(program, gauge):
    master = Masters(program, gauge)
    found = master("scan", "--json", address=False)
    check("scan finds the gauge", f'"address":{ADDRESS}' in found.stdout.replace(" ", ""), found.stderr.strip())
    listed = json.loads(master("list", "--json").stdout)
    readable = [row for row in listed if "2_R" in row["access"]]
    dumped = master("dump")
    check("dump reads every setting", dumped.returncode == 0, dumped.stderr.strip()[:200])
    failed = []
    for row in readable:
        name = row["name"]
        answer = master("read", name, "--json")
        # 1: the gauge is in IDLE, so a pressure is not valid, but it was read.
        if answer.returncode not in (0, 1) or not answer.stdout.strip():
            failed.append(f"{name}: {answer.stderr.strip()[-200:]}")
    check("every parameter is read by MS2", readable and not failed, f"{len(readable)} parameters {failed[:5]}")


def conform(program, gauge):
    result = run(program, "conform", "--own", "--port", gauge.port, "--address", str(ADDRESS))
    last = (result.stderr or result.stdout).strip().splitlines()[-1:]
    check("conform", result.returncode == 0, *last)


def flash_waits(gauge):
    """The writes of the checks before have operated the flash, and never while an answer waited or was being sent."""
    operations, disturbing = gauge.numbers(ord("o"))
    check("the flash waits until no answer is being sent or waits", operations > 20 and disturbing == 0,
          f"{operations} operations, {disturbing} during an answer")


def value(master):
    # A gauge that has just started may miss a request.
    for _ in range(5):
        answer = master("read", "pirani.safe-value", "--json")
        if answer.returncode == 0:
            return json.loads(answer.stdout)[0]["value"]
    raise SystemExit(f"FAILED  the gauge does not answer: {answer.stderr.strip()}")


def power_fails(gauge, operation, master, target, text):
    """Whether the power fails at this flash operation of a write. The master is stopped then, and the gauge starts again."""
    gauge.numbers(128 + operation)
    options = ["--port", gauge.port, "--address", str(ADDRESS), PATIENTLY, target, text]
    with subprocess.Popen([master.program, "write", *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
        # A write may be followed by that of the Channel Instance Selector, so the power may fail when the program has ended.
        waits = 10
        while waits > 0:
            if select.select([gauge.console], [], [], 0.02)[0]:
                process.kill()
                process.communicate()
                gauge.line()
                gauge.console.sendall(b"g")
                return True
            waits -= process.poll() is not None
    gauge.numbers(128)
    return False


def power_cuts(program, gauge, every):
    """A write, and a power cut at each of its flash operations: after power-up the value is the old or the new one.

    A cut at the second operation leaves an incomplete save behind, so the write after it copies all values to the other page.
    """
    master = Masters(program, gauge)
    wrong, cuts, old, new = [], 0, 0.1, 0.2
    master("write", "pirani.safe-value", f"{old} mbar")
    operation, failed = 1, True
    while failed:
        for at in (2, operation):
            failed = power_fails(gauge, at, master, "pirani.safe-value", f"{new} mbar")
            found = value(master)
            cuts += failed
            if found not in ((old, new) if failed else (new,)):
                wrong.append(f"operation {at}: {found}")
            if found == new:
                old, new = new, old
        operation += 1 if every or operation < 4 else 3
    check("a power cut at a flash operation leaves the old or the new value", not wrong and cuts >= 10,
          wrong[:3] or f"{cuts} cuts, in page changes of {operation} operations at most")


def random_octets(gauge, count):
    """Random octets with requests among them. After every 64 KiB the gauge answers an FDL status request as before."""
    host, port = gauge.port.removeprefix("tcp://").rsplit(":", 1)
    seed = random.randrange(1 << 32)
    source = random.Random(seed)
    requests = [bytes.fromhex(it) for it in ("100501494f16", "68050568858 26d3c3ef116".replace(" ", ""), "e5", "dc0501")]
    status, answer = bytes.fromhex("100503495116"), bytes.fromhex("100305000816")
    sent, alive = 0, True
    with socket.create_connection((host, int(port)), timeout=TIMEOUT) as line:
        while sent < count and alive:
            piece = bytearray()
            while len(piece) < 65_536:
                piece += source.randbytes(source.randrange(300)) + source.choice(requests)
            line.sendall(piece)
            sent += len(piece)
            alive = answers(line, status, answer)
    damaged, lost, late = gauge.numbers(ord("c"))
    check(f"{sent} random octets", alive and damaged > 0, f"seed {seed}, {damaged} damaged, {lost} not taken in time, {late} late")


def answers(line, request, answer):
    """Repeats a request, with pauses in which the line is idle, until the answer comes."""
    heard, deadline = b"", time.monotonic() + TIMEOUT
    while answer not in heard and time.monotonic() < deadline:
        line.sendall(request)
        if select.select([line], [], [], 0.1)[0]:
            heard = heard[-16:] + line.recv(65_536)
    return answer in heard


class Foreign:
    """A master of others in a process. It prints events, and takes outputs in hex, a line each."""

    def __init__(self, command):
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.timer = threading.Timer(TIMEOUT, self.process.kill)
        self.timer.start()
        self.found = {}

    def events(self, line):
        """The events of a line: a name with its words each."""
        name, *words = line.split()
        return {name: words}

    def until(self, done):
        """Whether an event makes this true before the master ends."""
        for line in self.process.stdout:
            self.found.update(self.events(line))
            if done():
                return True
        return False

    def inputs(self):
        return bytes.fromhex(self.found["inputs"][0]) if "inputs" in self.found else b""

    def channel(self, octets, done):
        """Writes the outputs until the first eight octets of the inputs are as wanted; these."""
        self.process.stdin.write(octets.hex() + "\n")
        self.process.stdin.flush()
        self.until(lambda: len(self.inputs()) >= 8 and done(self.inputs()))
        return self.inputs()[:8]

    def task(self, kind, slot, index, value=0):
        """A task in the parameter channel and its answer; whether the gauge has done it."""
        location = bytes([slot, index])
        octets = bytes([kind << 4, *location, 0]) + value.to_bytes(4, "big")
        answer = self.channel(octets, lambda inputs: inputs[0] >> 4 != 0 and inputs[1:3] == location)
        self.channel(bytes(8), lambda inputs: inputs[0] >> 4 == 0)
        return bool(answer) and answer[0] >> 4 in (1, 2, 11), answer.hex()

    def complaint(self):
        self.process.kill()
        return self.process.stderr.read()[-300:]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.timer.cancel()
        self.process.kill()
        self.process.communicate()


class Pyprofibus(Foreign):
    def __init__(self, python, gauge, ident, cfg, prm, outputs, inputs):
        script = ROOT / "crates/cli/tests/peers/pyprofibus_master.py"
        super().__init__([python, str(script), gauge.port, str(ADDRESS), ident, cfg, prm, str(outputs), str(inputs)])

    def events(self, line):
        return {name: [value] for name, value in json.loads(line).items()}


# A configuration of a BCG450 with a parameter channel, and user parameters for mbar; the octets of its outputs and inputs.
WITH_CHANNEL = ("C6878E0A0A05050508", "000000051C", 8, 15)
# The index of the Channel Instance Selector of a BCG450.
SELECTOR = 46


def pyprofibus(python, image, program):
    """pyprofibus brings the gauge to exchange, and reads every value of one to four octets in the parameter channel."""
    with Gauge(image, bus_on_pty=True) as gauge, Pyprofibus(python, gauge, "0x08E6", *WITH_CHANNEL) as master:
        exchanging = master.until(lambda: len(master.inputs()) == WITH_CHANNEL[-1])
        check("pyprofibus exchanges data with the gauge", exchanging, master.inputs().hex() or master.complaint())
        reads_short_values("pyprofibus", program, master, exchanging)


def profirust(program, example, image):
    """profirust brings the gauge to exchange, reads its diagnosis, and reads every value of one to four octets in the parameter channel."""
    with Gauge(image) as gauge:
        command = [example, gauge.port.removeprefix("tcp://"), str(ADDRESS), "08E6", *map(str, WITH_CHANNEL)]
        with Foreign(command) as master:
            found = master.found
            exchanging = master.until(lambda: "exchanging" in found and "inputs" in found)
            check("profirust exchanges data with the gauge", exchanging, master.inputs().hex() or master.complaint())
            check("profirust reads the diagnosis of the gauge", found.get("diagnosis", [])[1:] == ["08e6", "2"], found.get("diagnosis"))
            reads_short_values("profirust", program, master, exchanging)


def reads_short_values(name, program, master, exchanging):
    """Reads every value of one to four octets. Where a slot has several instances, the Channel Instance Selector selects one."""
    rows = json.loads(run(program, "list", "--json", "--device", "bcg450").stdout)
    short = ("BOOLEAN", "UINT8", "UINT16", "FLOAT", "BY_TYPE")
    rows = [row for row in rows if row["type"] in short and any(access in row["access"] for access in ("1_R", "1/2_R"))]
    refused, instance = [], 0
    for row in rows if exchanging else ():
        if row["instance"] not in (0, instance):
            instance = row["instance"]
            master.task(10, row["slot"], SELECTOR, instance)
        good, answer = master.task(1, row["slot"], row["index"])
        refused += [] if good else [f"{row['name']}: {answer}"]
    check(f"{name} reads every short value in the parameter channel", exchanging and rows and not refused, refused[:5] or len(rows))


def own_device(python):
    """A device of one's own, in a crate outside the project: its tests, its image, and an exchange."""
    folder = HERE / "example"
    cargo(folder, "test", "--quiet", "--locked")
    image = build("ex1", folder=folder, package="example-gauge")
    code, data = sizes(image)
    check("no panic path is in the image of a device of one's own", has_no_panic(image), f"{code} octets, data {data}")
    if python:
        with Gauge(image, bus_on_pty=True) as gauge, Pyprofibus(python, gauge, "0xFFFE", "418308", "000000051C", 0, 4) as master:
            exchanging = master.until(lambda: len(master.inputs()) == 4)
            check("pyprofibus exchanges data with a device of one's own", exchanging, master.inputs().hex() or master.complaint())


def sd2(da, sa, fc, du, saps=None):
    """A telegram with variable length."""
    octets = bytes([da, sa, fc] if saps is None else [da | 0x80, sa | 0x80, fc, *saps]) + bytes.fromhex(du)
    return bytes([0x68, len(octets), len(octets), 0x68]) + octets + bytes([sum(octets) & 0xFF, 0x16])


# Requests of master 3 that change the slave, and what the log of the gauge says of each, without time and level. None is a pause, until
# the line is there.
LOGGED = (
    (None, "mps2-an386 in QEMU: address 5, ident 08e6"),
    (None, "the port does not have 12000000 bit/s: it hears nothing"),
    (None, "searches the bus at 6000000 bit/s"),
    (bytes.fromhex("100503495116"), "the bus has 6000000 bit/s"),
    (sd2(5, 3, 0x5D, "80 00 00 00 12 34 00 00 00 00 05 1C", (61, 62)), "Set_Prm of master 3 refused: ident 1234 instead of 08e6"),
    (sd2(5, 3, 0x7D, "80 00 00 00 08 E6 00 00 00 00 05 FF", (61, 62)), "Set_Prm of master 3 refused: [80, 00, 00, 00, 08, e6, 00, 00, 00, 00, 05, ff]"),
    (sd2(5, 3, 0x5D, "88 0A 0A 00 08 E6 00 00 00 00 05 1C", (61, 62)), "WAIT-CFG: parameters of master 3"),
    (sd2(5, 3, 0x7D, "C6 87", (62, 62)), "Chk_Cfg of master 3 refused: [c6, 87]"),
    (None, "WAIT-PRM"),
    (sd2(5, 3, 0x5D, "88 0A 0A 00 08 E6 00 00 00 00 05 1C", (61, 62)), "WAIT-CFG: parameters of master 3"),
    (sd2(5, 3, 0x7D, "C6 87 8E 0A 0A 05 05 05 08", (62, 62)), "DATA-EXCH with master 3: 15 octets of inputs, 8 of outputs"),
    (sd2(5, 4, 0x6D, "80 00 00 00 08 E6 00", (61, 62)), "Set_Prm of master 4 ignored: the slave is locked to another master"),
    (None, "watchdog expired: master 3 sent no request in time"),
    (None, "WAIT-PRM"),
)


def logs(program, printer):
    """The log of a gauge that searches the rate: each event is logged, in this order, and defmt-print reads it."""
    image = build("bcg450", "diagnostics", "defmt", "baud-search")
    with tempfile.TemporaryDirectory() as folder:
        log = os.path.join(folder, "log")

        def lines():
            with open(log, "rb") as octets:
                printed = subprocess.run([printer, "-e", image, "--log-format", "{t} {L} {s}", "stdin"], stdin=octets,
                                         capture_output=True, text=True, timeout=TIMEOUT)
            return printed.stdout.splitlines()

        def wait_for(wanted, start, ask=lambda: None):
            """The number of the line behind that with this text, at `start` or later."""
            deadline = time.monotonic() + TIMEOUT
            while time.monotonic() < deadline:
                ask()
                found = lines()
                for number in range(start, len(found)):
                    if wanted in found[number]:
                        return number + 1
            return None

        with Gauge(image, log=log) as gauge:
            host, port = gauge.port.removeprefix("tcp://").rsplit(":", 1)
            at, missing = 0, []
            with socket.create_connection((host, int(port)), timeout=TIMEOUT) as bus:
                for request, wanted in LOGGED:
                    if request is not None:
                        answers(bus, request, b"\xe5" if len(request) > 6 else bytes.fromhex("100305000816"))
                    found = wait_for(wanted, at)
                    at, missing = (at, [*missing, wanted]) if found is None else (found, missing)
                    if missing:
                        break
                if missing:
                    missing.append(lines()[-3:])
            free, stack = gauge.numbers(ord("s"))
            check("a gauge that searches its rate, with its log, fits into 8 KiB", free >= 64, f"stack {stack}, free {free}")
            written = Masters(program, gauge)("write", "pirani.safe-value", "0.1 mbar")
            if written.returncode != 0 or wait_for("flash: saved; page", at) is None:
                missing.append(f"flash: {written.stderr.strip()}")
            check(f"the log of the gauge has {len(LOGGED) + 1} events in their order", not missing, missing or f"{sizes(image)[0]} octets of code")


# The latest start of an answer that a slave declares, in bit times. profibus-wire 1.12
MAX_TSDR = {9600: 60, 19200: 60, 45450: 60, 93750: 60, 187500: 60, 500000: 100, 1500000: 150, 3000000: 250, 6000000: 450, 12000000: 800}
# Clock and assumed cycles for an instruction, with the wait states of the flash; entry and end of an interrupt take 24 cycles.
PROCESSORS = (("Cortex-M4, 168 MHz", 168e6), ("Cortex-M4, 96 MHz", 96e6))
CYCLES_PER_INSTRUCTION = 2.0
INTERRUPT_CYCLES = 24


def measure(image):
    """Prints the instructions of each service, and the rates that follow."""
    command = ["qemu-system-arm", "-M", "mps2-an386", "-display", "none", "-monitor", "none", "-icount", "shift=10"]
    command += ["-serial", "null", "-serial", "stdio", "-kernel", str(image)]
    rows = {}
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            name, _, numbers = line.rstrip().partition(":")
            if name == "end":
                break
            rows[name] = [int(word, 16) for word in numbers.split()]
        process.kill()
    octet, worst_octet = rows.pop("octet, mean and worst")
    rows.pop("stack, free and used")
    _, held = rows.pop("longest hold")
    print(f"\n{'instructions':40} {'to the answer':>14} {'application after it':>21}")
    for name, (answer, after) in rows.items():
        print(f"{name:40} {answer or '':>14} {after:>21}")
    print(f"{'octet in the interrupt':40} {octet:>14}   at most {worst_octet}")
    print(f"{'copies of the application, which a request waits for':55} at most {held}\n")
    answers = {name: answer for name, (answer, _) in rows.items()}
    exchange, worst = answers["Data_Exchange"], max(answers.values())
    print(f"rates, with {CYCLES_PER_INSTRUCTION} cycles for an instruction (assumed), if the serial port has them:")
    for name, clock in PROCESSORS:
        def serves(rate, answer=worst):
            answer_cycles = (held + answer) * CYCLES_PER_INSTRUCTION + 2 * INTERRUPT_CYCLES
            octet_cycles = worst_octet * CYCLES_PER_INSTRUCTION + INTERRUPT_CYCLES
            return answer_cycles <= MAX_TSDR[rate] / rate * clock and octet_cycles <= 11 / rate * clock
        highest = max((rate for rate in MAX_TSDR if serves(rate)), default=0)
        print(f"  {name}: every service up to {highest / 1000:g} kbit/s")
    print()
    check("a data exchange is answered", exchange <= 2_600, f"{exchange} instructions")
    check("the slowest service is bounded", held + worst <= 8_000, f"{worst} instructions behind a copy of {held}")
    return rows


def table_of_sizes():
    """The sizes of an image for each device."""
    print(f"\n{'image':10} {'code':>8} {'data':>6}   devices")
    for image, devices in DEVICES.items():
        code, data = sizes(build(image))
        print(f"{image:10} {code:8} {data:6}   {devices}")
    print()


def has_no_panic(image):
    symbols = run("nm", "-C", image).stdout
    return not any(word in symbols for word in PANIC)


def boards_to_buy():
    """The boards that QEMU does not have: they build, and the start of the RP2040 has the checksum that its ROM demands."""
    for board in ("stm32f407", "stm32f411"):
        check(f"the {board.upper()} builds, without a panic path", has_no_panic(build("bcg450", board=board)))
    image = build("bcg450", board="rp2040", target=RP2040_TARGET)
    check("the RP2040 builds, without a panic path", has_no_panic(image), f"{sum(sizes(image))} octets of code and data")
    with tempfile.NamedTemporaryFile() as boot:
        run("objcopy", "--input-target=elf32-little", "--output-target=binary", "--only-section=.boot", image, boot.name, check=True)
        octets = pathlib.Path(boot.name).read_bytes()
    checksum = 0xFFFF_FFFF
    for octet in octets[:252]:
        checksum ^= octet << 24
        for _ in range(8):
            checksum = (checksum << 1 ^ (0x04C1_1DB7 if checksum >> 31 else 0)) & 0xFFFF_FFFF
    for board, target in (("stm32f407", TARGET), ("stm32f411", TARGET), ("rp2040", RP2040_TARGET)):
        symbols = run("nm", build("bcg450", "defmt", board=board, target=target)).stdout
        check(f"the log of the {board} is where a debugger finds it", " _SEGGER_RTT" in symbols)
    check("the start of the RP2040 has its checksum", octets[252:] == checksum.to_bytes(4, "little"), octets[252:].hex())


def page(program):
    """The commands of docs/firmware.md that need no hardware: those of the first terminal start the gauge, those of the second read it."""
    text = (ROOT / "docs" / "firmware.md").read_text()
    section = text.split("## Try it without hardware")[1].split("\n## ")[0]
    start, ask = re.findall(r"```sh\n(.*?)```", section, re.DOTALL)
    *before, emulator = start.replace("\\\n", " ").strip().splitlines()
    # What the page installs is there already.
    before = [command for command in before if not command.startswith(("rustup ", "apt-get "))]
    script = "\n".join([*before, f"exec {emulator}"])
    gauge = subprocess.Popen(["bash", "-ec", script], cwd=ROOT, stdin=subprocess.DEVNULL)
    port = int(re.search(r"127\.0\.0\.1:(\d+)", emulator)[1])
    try:
        deadline = time.monotonic() + TIMEOUT
        while gauge.poll() is None and not is_open(port) and time.monotonic() < deadline:
            time.sleep(0.1)
        environment = {**os.environ, "PATH": f"{os.path.dirname(program)}:{os.environ['PATH']}"}
        for command in ask.strip().splitlines():
            done = run("bash", "-ec", command, env=environment)
            check(f"docs/firmware.md: {command}", done.returncode == 0, done.stderr.strip())
    finally:
        gauge.kill()
        gauge.wait()


def is_open(port):
    with socket.socket() as line:
        return line.connect_ex(("127.0.0.1", port)) == 0


def target_is_there():
    for target in (TARGET, RP2040_TARGET):
        if run("rustup", "target", "add", target).returncode != 0:
            print(f"skipped: rustup cannot add the target {target}")
            return False
    if shutil.which("qemu-system-arm") is None:
        print("skipped: qemu-system-arm is not installed")
        return False
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--long", action="store_true")
    parser.add_argument("--python")
    parser.add_argument("--profirust", metavar="EXAMPLE")
    parser.add_argument("--defmt-print")
    options = parser.parse_args()
    if not target_is_there():
        return 0
    program = os.path.abspath(options.program)
    image = build("bcg450")
    code, data = sizes(image)
    check("no panic path is in the image", has_no_panic(image))
    check("the code has its size", code <= MOST_CODE, f"{code} octets with the flash store, data {data}")
    image = build("bcg450", "diagnostics")
    with Gauge(image) as gauge:
        lights(gauge)
        our_master(program, gauge)
        conform(program, gauge)
        flash_waits(gauge)
        power_cuts(program, gauge, options.long)
        random_octets(gauge, 10_000_000 if options.long else 200_000)
        free, stack = gauge.numbers(ord("s"))
        check("data and the deepest stack fit into 8 KiB", free >= 64, f"data {sizes(image)[1]}, stack {stack}, free {free} of {RAM}")
    if options.python:
        pyprofibus(options.python, image, program)
    if options.profirust:
        profirust(program, os.path.abspath(options.profirust), image)
    if options.defmt_print:
        logs(program, os.path.abspath(options.defmt_print))
    page(program)
    own_device(options.python)
    measure(build("measure", "diagnostics"))
    print("the same with prepared answers:")
    measure(build("measure", "diagnostics", "prepared-answers"))
    code, data = sizes(build("bcg450", "prepared-answers"))
    check("with prepared answers the code has its size", code <= MOST_PREPARED_CODE, f"{code} octets, data {data}")
    table_of_sizes()
    boards_to_buy()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
