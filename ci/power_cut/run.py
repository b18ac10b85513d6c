#!/usr/bin/env python3
"""Cuts the power at every system call that writes a store, and looks at what is left.

ci/power_cut/run.py PROGRAM RECORDER [STORE ...] [--every N] [--random N]

PROGRAM is profivac, RECORDER the example `acknowledged` of the crate `recorder`. STORE is one or more of `gauge`, `users`, `record`;
without one, all. The outbox of the archive is a part of the record. The program runs under strace; disk.py says which disks a power cut
after each of its system calls can leave. --every N looks only at every Nth call, --random N tries N random orders of the sectors at each
(3). Exit code 0: every disk kept what was acknowledged.
"""

import argparse
import json
import os
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import tomllib
import zlib

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import disk  # noqa: E402

# A folder in memory: thousands of disks are written, and none of them has to last.
MEMORY = "/dev/shm" if os.path.isdir("/dev/shm") else None


class Acknowledged:
    """What was begun and what was acknowledged, with the times."""

    def __init__(self):
        self.begun, self.done = [], []

    def begin(self, fact, at=None):
        self.begun.append((at or time.time(), fact))

    def end(self, fact, at=None):
        self.done.append((at or time.time(), fact))

    def until(self, begun, ended):
        """What had been acknowledged before a call began, and what had been begun before it ended."""
        return [fact for at, fact in self.done if at < begun], [fact for at, fact in self.begun if at <= ended]


def ends(process, seconds=60):
    """Ends a traced program: strace passes no signal on, so its child gets it."""
    children = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True).stdout.split()
    for child in children:
        os.kill(int(child), signal.SIGTERM)
    process.wait(seconds)


STATION = """[station]
name = "hall"
[[segment]]
name = "north"
port = "/dev/null"
[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"
"""


class Gauge:
    """The nonvolatile parameters of a BCG450: ten values of a set point are written over the bus."""

    name, file = "gauge", "bcg450-5.state"
    TARGET, KEY = "setpoint-a.percentage-of-atmosphere", b"parameter 1:5/202 = "

    # Tenths of a percent.
    FACTORY = 50

    def __init__(self, arguments):
        self.program = arguments.program

    def work(self, folder, trace, facts):
        process = self.simulate(folder, disk.command(trace))
        port = process.stdout.readline().split()[1]
        for number in range(10):
            facts.begin(number)
            command = [self.program, "write", "--port", f"tcp://{port}", "--address", "5", self.TARGET, self.value(number)]
            # A traced gauge is slow, and may answer too late.
            while subprocess.run(command, capture_output=True).returncode:
                print("the gauge gave no answer in time; once more", flush=True)
            facts.end(number)
        ends(process)

    def simulate(self, folder, before=()):
        return subprocess.Popen([*before, self.program, "simulate", "--tcp", "127.0.0.1:0", "--state", folder, "bcg450@5"],
                                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    @staticmethod
    def value(number):
        return f"{10 + number} %"

    def look(self, folder, acknowledged, begun):
        """The file is whole, and has the value that was acknowledged last or one that was begun later."""
        path = os.path.join(folder, self.file)
        if not os.path.exists(path):
            return "the file is missing" if acknowledged else None
        with open(path, "rb") as file:
            text = file.read()
        body, _, check = text.rpartition(b"end, check sum ")
        if check != b"%08X\n" % zlib.crc32(body):
            return f"a file with a wrong check sum: {text[-60:]!r}"
        values = [int(line[len(self.KEY) :].replace(b" ", b""), 16) for line in body.splitlines() if line.startswith(self.KEY)]
        return self.wrong(values[0] if values else None, acknowledged, begun)

    def wrong(self, found, acknowledged, begun):
        """Says why a value is none of the acknowledged last and those begun later."""
        allowed = [10 * (10 + number) for number in begun if not acknowledged or number >= acknowledged[-1]]
        if found in allowed or found in (None, self.FACTORY) and not acknowledged:
            return None
        return f"the value {found}, expected one of {allowed}"

    def look_with_the_program(self, folder, acknowledged, begun):
        """A gauge that starts with the disk has one of the values."""
        process = self.simulate(folder)
        port = process.stdout.readline().split()[1]
        command = [self.program, "read", "--json", "--port", f"tcp://{port}", "--address", "5", self.TARGET]
        answer = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        process.stdin.write("quit\n")
        process.stdin.flush()
        _, complaint = process.communicate(timeout=60)
        if "damaged" in complaint:
            return complaint
        return self.wrong(round(10 * answer[0]["value"]), acknowledged, begun)


class Users:
    """The file of users: added, given another role, and removed."""

    name = "users"

    def __init__(self, arguments):
        self.program = arguments.program

    def work(self, folder, trace, facts):
        station = os.path.join(folder, "plant.toml")
        with open(station, "w") as file:
            file.write(STATION)
        # Each command is a process of its own; their traces are one.
        for number, (action, is_there) in enumerate(self.actions()):
            facts.begin((number, *is_there))
            part = f"{trace}.{number}"
            subprocess.run([*disk.command(part), self.program, "user", *action, station, *(["--password-stdin"] if action[0] == "add" else [])],
                           input="correct horse battery\n", check=True, capture_output=True, text=True)
            facts.end((number, *is_there))
            with open(trace, "a") as whole, open(part) as one:
                shutil.copyfileobj(one, whole)

    @staticmethod
    def actions():
        """Commands, each with a name and the role that it has afterwards."""
        for name in ("ada", "otto", "wall"):
            yield ["add", name, "--role", "viewer"], (name, "viewer")
        yield ["role", "otto", "operator"], ("otto", "operator")
        yield ["role", "ada", "engineer"], ("ada", "engineer")
        yield ["remove", "wall"], ("wall", None)

    def look(self, folder, acknowledged, begun):
        """The file has the users of the actions up to one that was begun, and at least of all that were acknowledged."""
        files = [name for name in os.listdir(folder) if name == "plant.users.toml"]
        users = {}
        for name in files:
            with open(os.path.join(folder, name), "rb") as file:
                users = {user["name"]: user["role"] for user in tomllib.load(file).get("user", [])}
        for count in range(len(acknowledged), len(begun) + 1):
            expected = {}
            for _, name, role in begun[:count]:
                expected[name] = role
            if users == {name: role for name, role in expected.items() if role}:
                return None
        return f"the users {users} after {len(acknowledged)} actions"

    def look_with_the_program(self, folder, acknowledged, begun):
        station = os.path.join(folder, "plant.toml")
        with open(station, "w") as file:
            file.write(STATION)
        for name in os.listdir(folder):
            os.chmod(os.path.join(folder, name), 0o600)
        done = subprocess.run([self.program, "user", "list", station], capture_output=True, text=True)
        return None if done.returncode == 0 else f"`user list` ends with {done.returncode}: {done.stderr}"


class Record:
    """The database of a station: samples, events, alarms, the audit trail, notifications, and the outbox for the archive."""

    name, STEPS = "record", 20

    def __init__(self, arguments):
        self.recorder = arguments.recorder

    def work(self, folder, trace, facts):
        command = [*disk.command(trace), self.recorder, os.path.join(folder, "plant.db"), str(self.STEPS)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        facts.begin(0)
        for line in process.stdout:
            _, number, _, at_us = line.split()
            facts.end(int(number), int(at_us) / 1e6)
            facts.begin(int(number) + 1, int(at_us) / 1e6)
        if process.wait():
            raise RuntimeError(f"the recorder ended with {process.returncode}")

    def look(self, folder, acknowledged, begun):
        """Every table has the rows of the first steps, at least of all that were acknowledged, and the outbox has each of them once."""
        path = os.path.join(folder, "plant.db")
        if not os.path.exists(path):
            return "the database is missing" if acknowledged else None
        connection = sqlite3.connect(path)
        try:
            return self.look_at(connection, len(acknowledged), len(begun))
        except sqlite3.DatabaseError as error:
            # Before the first acknowledgement the tables may be missing.
            return f"{error}" if acknowledged or "no such table" not in str(error) else None
        finally:
            connection.close()

    def look_at(self, connection, acknowledged, begun):
        def numbers(sql):
            return [row[0] for row in connection.execute(sql)]

        (check,) = numbers("PRAGMA integrity_check")
        if check != "ok":
            return f"integrity_check: {check}"
        steps = [int(text) for text in numbers("SELECT text FROM event WHERE kind = 'note' ORDER BY id") if text.isdigit()]
        if steps != list(range(len(steps))) or not acknowledged <= len(steps) <= begun:
            return f"the events of the steps {steps} after {acknowledged} acknowledged ones"
        sent = [int(text) for text in numbers("SELECT after FROM audit WHERE action = 'execute' ORDER BY id")]
        done = [int(text) for text in numbers("SELECT after FROM audit WHERE action = 'acknowledged' ORDER BY id")]
        alarms = numbers("SELECT occurrence FROM alarm_history ORDER BY id")
        notified = [int(text) for text in numbers("SELECT body FROM notification ORDER BY id")]
        for name, found in [("audit trail", done), ("alarm history", alarms), ("notifications", notified)]:
            if found != steps:
                return f"the {name} has the steps {found}, the events {steps}"
        # A command whose step was not recorded any more is repeated when the recorder goes on.
        if sorted(set(sent)) not in (steps, [*steps, len(steps)]) or sent != sorted(sent) or len(sent) > len(steps) + 1:
            return f"the audit trail has the commands {sent}, the events {steps}"
        (samples,) = numbers("SELECT count(*) FROM sample")
        if not len(steps) <= samples <= begun + 1:
            return f"{samples} samples and {len(steps)} events"
        return self.look_at_the_outbox(connection, {"audit": numbers("SELECT count(*) FROM audit")[0], "alarm": len(alarms)}, samples)

    @staticmethod
    def look_at_the_outbox(connection, rows, samples):
        """The batches that wait and those that are kept have every row up to the one that the table `outbox_state` names. The row that precedes a
        command comes with the next batch."""
        kept_and_waiting = "SELECT number, payload FROM outbox_kept UNION ALL SELECT number, payload FROM outbox ORDER BY number"
        batches = list(connection.execute(kept_and_waiting))
        numbers = [number for number, _ in batches]
        if numbers != list(range(1, len(numbers) + 1)):
            return f"the batches {numbers} have gaps"
        found = {field: [] for field in (3, 6, 7)}
        for _, payload in batches:
            for field, message in fields(zlib.decompress(payload, -15)):
                if field in found:
                    found[field].append(message)
        for name, field in [("audit", 7), ("alarm", 6)]:
            last = connection.execute(f"SELECT {name}_id FROM outbox_state").fetchone()
            last = last[0] if last else 0
            ids = [dict(fields(message))[1] for message in found[field]]
            if ids != list(range(1, last + 1)) or not rows[name] - 1 <= last <= rows[name]:
                return f"the batches have the rows {ids} of the table {name}, which has {rows[name]}; the last one sent is {last}"
        if len(found[3]) != samples:
            return f"the batches have {len(found[3])} samples, the table {samples}"
        return None

    def look_with_the_program(self, folder, acknowledged, begun):
        """The recorder goes on with the disk, and afterwards everything fits again."""
        path = os.path.join(folder, "plant.db")
        done = subprocess.run([self.recorder, path, "2"], capture_output=True, text=True)
        if done.returncode:
            return f"the recorder ends with {done.returncode}: {done.stderr}"
        last = int(done.stdout.splitlines()[-1].split()[1])
        return self.look(folder, list(range(last + 1)), list(range(last + 2)))


def fields(message):
    """The fields of a message of Protocol Buffers: numbers, and octets or integers."""
    at = 0

    def integer():
        nonlocal at
        value = shift = 0
        while True:
            octet = message[at]
            at += 1
            value |= (octet & 0x7F) << shift
            shift += 7
            if octet < 0x80:
                return value

    while at < len(message):
        key = integer()
        if key & 7 == 0:
            yield key >> 3, integer()
            continue
        length = {1: 8, 5: 4}.get(key & 7) or integer()
        yield key >> 3, message[at : at + length]
        at += length


STORES = [Gauge, Users, Record]


def explore(store, every, repetitions, seed):
    """Cuts the power at every call of one store. Returns the number of disks, and what was wrong with some of them."""
    source = random.Random(seed)
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory(dir=MEMORY) as memory:
        work, trace, facts = os.path.join(folder, "store"), os.path.join(folder, "trace"), Acknowledged()
        os.mkdir(work)
        model = disk.Disk(work)
        store.work(work, trace, facts)
        calls = writes = disks = 0
        failures = []
        for call in sorted(disk.calls(trace), key=lambda call: call.ended):
            if not model.follow(call):
                continue
            calls += 1
            if calls % every:
                continue
            writes += 1
            known = facts.until(call.begun, call.ended)
            for name, files in disk.cuts(model, source, repetitions):
                disks += 1
                left = os.path.join(memory, "left")
                error = look(store, left, files, known, disks % 50 == 0)
                if error:
                    failures.append(f"{store.name}: call {calls} ({call.name}), {name}: {error}")
                    print(failures[-1], flush=True)
                if len(failures) > 20:
                    return calls, disks, failures
        same = {name: file.after_a_cut(disk.everything) for name, file in model.names.items()}
        for name in os.listdir(work):
            with open(os.path.join(work, name), "rb") as file:
                # The index of the log is mapped, and `plant.toml` was there before.
                if not name.endswith("-shm") and name != "plant.toml" and file.read() != same.get(name):
                    failures.append(f"{store.name}: the model of {name} differs from the file")
                    print(failures[-1], flush=True)
        return calls, disks, failures


def look(store, left, files, known, with_the_program):
    """Writes a disk and looks at it. Returns what is wrong."""
    shutil.rmtree(left, ignore_errors=True)
    os.mkdir(left)
    for name, content in files.items():
        # A power cut leaves the index of the log, which no process shares afterwards, with anything: SQLite makes it anew.
        with open(os.path.join(left, name), "wb") as file:
            file.write(content)
    if with_the_program:
        return store.look_with_the_program(left, *known)
    return store.look(left, *known)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("recorder")
    parser.add_argument("stores", nargs="*", metavar="STORE", help=", ".join(store.name for store in STORES))
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--random", type=int, default=3)
    parser.add_argument("--seed", type=int, default=None)
    arguments = parser.parse_args()
    unknown = set(arguments.stores) - {store.name for store in STORES}
    if unknown:
        parser.error(f"expected stores out of {', '.join(store.name for store in STORES)}, found {', '.join(sorted(unknown))}")
    seed = arguments.seed if arguments.seed is not None else random.randrange(1 << 32)
    print(f"seed {seed}", flush=True)
    has_failed = False
    for kind in STORES:
        if arguments.stores and kind.name not in arguments.stores:
            continue
        begun = time.monotonic()
        calls, disks, failures = explore(kind(arguments), arguments.every, arguments.random, seed)
        has_failed |= bool(failures) or not disks
        print(f"{kind.name}: {calls} calls, {disks} disks, {len(failures)} wrong, {time.monotonic() - begun:.0f} s", flush=True)
    sys.exit(1 if has_failed else 0)


main()
