#!/usr/bin/env python3
"""What an archive must survive, one case after the other: contrib/archive/cases.py PROGRAM [CASE...] [--days DAYS]

week       a station was without a network for DAYS (7), with a batch a second; it needs `cargo build -p profivac-recorder --example backlog`
stopped    PostgreSQL is stopped with its connections open, and goes on; then NATS is killed: the archives say so
secure     NATS has TLS and the users of docs/archive.md; one of two archives has a wrong password, and a station reads and writes for others in vain
leader     the server of NATS that leads the stream is killed, five times
replaced   the database of a station is deleted; the station begins another one
postgres   the disk of PostgreSQL is full, and then no longer          (root: it mounts a small disk in memory)
nats       the disk of NATS is full, and then no longer                (root)
station    the disk of a station is full, and then no longer           (root)
restored   the database is dumped, lost, and restored
readers    a role reads the stations of its plant only, holds back no batches, and the days beyond the retention are dropped
hostile    a station with a token sends names, numbers, texts and times that no database holds, over HTTPS
versions   a station of this version, one with later fields, and one of a later format send at once
greedy     a station fills its share of the stream while PostgreSQL is down; another one still publishes, and nothing acknowledged is lost
same-name  two stations send under one name: takes more than a minute

Each case ends with the comparison of every sample, span and event of the databases with PostgreSQL.
"""

import argparse
import errno
import json
import os
import runpy
import shutil
import signal
import socket
import ssl
import struct
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
import zlib
from pathlib import Path

example = runpy.run_path(str(Path(__file__).with_name("example.py")))
Example, Process, wait_for = example["Example"], example["Process"], example["wait_for"]
DISK = 192 << 20  # octets: the smallest on which PostgreSQL makes its files


STATION_PERMISSIONS = 'publish: ["{subject}.batch"], subscribe: ["{subject}.inbox.>", "{subject}.request"], allow_responses: true'
ARCHIVE_PERMISSIONS = 'publish: ["$JS.>", "profivac.v1.*.*.request"], subscribe: ["_INBOX.>", "profivac.v1.*.*.batch"]'


class Case(Example):
    """Stations and servers of one case, some of them on a small disk."""

    def __init__(self, program, folder, stations=2, servers=1, disk=None, is_secure=False, days=None, stream="1_000_000_000"):
        self.disk, self.is_secure = folder / disk if disk else None, is_secure
        if self.disk:
            self.disk.mkdir()
            size = DISK if disk == "postgres" else DISK // 8
            subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "none", self.disk], check=True)
        super().__init__(program, stations, 2, servers, folder)
        # The stream must fit on the disk.
        stream = "15_000_000" if disk == "nats-0" else stream
        for file in folder.glob("archive-*.toml"):
            file.write_text(file.read_text().replace("1_000_000_000", stream))
        if is_secure:
            self.secure()
        if days:
            self.make_backlog(days)

    def make_backlog(self, days):
        """The database of a station without a network, made by the recorder with a clock of that time, in memory."""
        backlog = self.program.parent / "examples" / "backlog"
        if not backlog.exists():
            raise SystemExit(f"{backlog} is missing: cargo build {'--release ' * (self.program.parent.name == 'release')}-p profivac-recorder --example backlog")
        self.days = days
        with tempfile.TemporaryDirectory(dir="/dev/shm") as memory:
            made = subprocess.run([backlog, f"{memory}/record.db", str(days), "chamber", "foreline"], capture_output=True, text=True)
            if made.returncode != 0:
                raise SystemExit(f"FAILED: {backlog}: {made.stderr}")
            for file in Path(memory).iterdir():
                shutil.move(file, self.folder / self.stations[0].name)

    def secure(self):
        """Gives NATS a certificate, and each station and the archives a user, with the permissions of docs/archive.md."""
        permissions = {"archive": ARCHIVE_PERMISSIONS}
        for number, station in enumerate(self.stations):
            permissions[station.name] = STATION_PERMISSIONS.format(subject=f"profivac.v1.{self.plant(number)}.{station.name}")
        users = "\n".join(f"{{ user: {name}, password: secret-of-{name}, permissions: {{ {text} }} }}" for name, text in permissions.items())
        for file in self.folder.glob("nats-*.conf"):
            file.write_text(file.read_text() + f'''
tls {{ cert_file: "{self.folder}/server.crt", key_file: "{self.folder}/server.key" }}
authorization {{ users: [ {users} ] }}
''')
        self.log_in(self.folder / "archive-0.toml", "archive")
        self.log_in(self.folder / "archive-1.toml", "archive", "not-the-")

    def log_in(self, file, user, wrong=""):
        """Lets a program use TLS and its user."""
        secret = file.with_suffix(".credentials")
        secret.touch(0o600)
        secret.write_text(f'user = "{user}"\npassword = "{wrong}secret-of-{user}"\n')
        lines = file.read_text().replace("nats://127.0.0.1", "tls://localhost").splitlines()
        at = next(index for index, line in enumerate(lines) if line.startswith("servers"))
        lines[at + 1:at + 1] = [f'credentials = "{secret.name}"', 'ca-file = "server.crt"']
        file.write_text("\n".join(lines) + "\n")

    def write_station(self, name, number, gauges):
        super().write_station(name, number, gauges)
        if self.is_secure:
            self.log_in(self.folder / f"{name}.toml", name)

    def run(self, act):
        self.start()
        wait_for("a stored sample", self.has_samples)
        act(self)
        self.drain()
        return self.compare()

    def close(self):
        super().close()
        if self.disk:
            subprocess.run(["umount", "--lazy", self.disk], check=False)

    def wait_for_more(self):
        """Waits until the rows of a station that starts again have come. A station that measures the same pressure has few others."""
        before = self.count("batch")
        for station in self.stations:
            if station.is_running():
                station.stop()
            station.start()
        wait_for("more batches in the database", lambda: self.count("batch") > before)

    def recorded(self, station):
        return self.record(station, "SELECT count(*) FROM sample")[0][0]

    def fill(self):
        """Fills the disk. Returns the file that does."""
        filler = self.disk / "filler"
        with filler.open("wb", buffering=0) as file:
            for size in (1 << 20, 4096, 512):
                try:
                    while file.write(bytes(size)) == size:
                        pass
                except OSError as error:
                    if error.errno != errno.ENOSPC:
                        raise
        return filler

    def wait_until_same(self, what, value):
        """Waits until a number has been the same for 5 s. It may be None, while the database does not answer."""
        since, last = time.monotonic(), value()

        def is_same():
            nonlocal since, last
            now = value()
            if now != last:
                since, last = time.monotonic(), now
            return time.monotonic() - since > 5

        wait_for(what, is_same)

    def start_all_again(self):
        for process in self.all():
            if not process.is_running():
                self.start_again(process)


def week(case):
    """The network is back at the start of the station."""
    waiting = lambda: case.record(case.stations[0], "SELECT count(*) FROM outbox")[0][0]
    begun, last = time.monotonic(), None
    while (now := waiting()) > 100:
        if last is None or last - now > 100_000:
            last = now
            print(f"{time.monotonic() - begun:.0f} s: {now} batches wait", flush=True)
        for process in case.all():
            if not process.is_running():
                raise SystemExit(f"FAILED: {process.name} has ended")
        time.sleep(1)
    wait_for("all samples", lambda: case.count("batch") > case.days * 86_400)
    took = time.monotonic() - begun
    print(f"{case.days} days in {took:.0f} s, {case.days * 86_400 / took:.0f} times as fast as they were recorded")
    if case.days * 86_400 < 20 * took:
        raise SystemExit("FAILED: that is less than 20 times")


def leader(case):
    def find():
        for number, monitor in enumerate(case.monitors):
            try:
                with urllib.request.urlopen(f"http://127.0.0.1:{monitor}/jsz?streams=1", timeout=2) as answer:
                    accounts = json.load(answer).get("account_details") or []
            except OSError:
                continue
            for stream in (stream for account in accounts for stream in account.get("stream_detail") or []):
                if stream.get("cluster", {}).get("leader") == f"n{number}":
                    return number
        return None

    for _ in range(5):
        wait_for("a leader", lambda: find() is not None)
        server = case.servers[find()]
        server.kill()
        case.wait_for_more()
        server.start()


def stopped(case):
    def is_reported(sentence):
        return any(sentence in archive.log.read_text() for archive in case.archives)

    # Each process of the server has a session of its own.
    main = (case.folder / "postgres" / "postmaster.pid").read_text().split()[0]
    children = subprocess.run(["pgrep", "-P", main], capture_output=True, text=True, check=True).stdout.split()
    processes = [int(number) for number in (main, *children)]
    try:
        for number in processes:
            os.kill(number, signal.SIGSTOP)
        for station in case.stations:
            station.stop()
            station.start()
        wait_for("the report about the database", lambda: is_reported("the database has not answered for 30 s"))
    finally:
        for number in processes:
            os.kill(number, signal.SIGCONT)
    case.wait_for_more()
    for server in case.servers:
        server.kill()
    wait_for("the report about the server of NATS", lambda: is_reported("the connection is lost"))
    case.start_all_again()
    case.wait_for_more()


def replaced(case):
    station = case.stations[0]
    number = 0
    station.stop()
    case.write_station(station.name, number, "")
    station.start()
    wait_for("that the station has sent what it recorded", lambda: case.has_all(station))
    station.stop()
    folder = case.folder / station.name
    first = folder / "first.db"
    shutil.move(folder / "record.db", first)
    for name in ("record.db-wal", "record.db-shm", "record.db-lock"):
        (folder / name).unlink(missing_ok=True)
    case.write_station(station.name, number, example["GAUGES"])
    station.start()
    case.wait_for_more()
    compare_samples, compare_events, compare_spans = case.compare_samples, case.compare_events, case.compare_spans
    # The rows of both databases are in the archive.
    original = case.record

    def both(of, sql):
        if of is not station:
            return original(of, sql)
        rows = original(of, sql)
        of.record = "first.db"
        try:
            return rows + original(of, sql)
        finally:
            of.record = "record.db"

    def compare_both(compare):
        def compared(of):
            case.record = both
            try:
                return compare(of)
            finally:
                case.record = original
        return compared

    case.compare_samples = compare_both(compare_samples)
    # Ids of events and spans begin again in each database; those of the other stations are compared.
    case.compare_events = lambda of: None if of is station else compare_events(of)
    case.compare_spans = lambda of: None if of is station else compare_spans(of)
    case.has_all = lambda of: has_all_of_last_epoch(case, of)


def has_all_of_last_epoch(case, station):
    [(waiting, last)] = case.record(station, "SELECT (SELECT count(*) FROM outbox), (SELECT seq FROM sqlite_sequence WHERE name = 'outbox')")
    rows = case.query("SELECT count(*), max(number) FROM profivac_data.batch JOIN profivac_data.station ON station.id = station "
                      f"AND batch.epoch = station.epoch WHERE name = '{station.name}'")
    return waiting == 0 and bool(rows) and rows[0] == [str(last), str(last)]


def full_database(case):
    filler = case.fill()
    before = [case.recorded(station) for station in case.stations]
    for station in case.stations:
        station.stop()
        station.start()
    wait_for("that the stations record", lambda: all(case.recorded(it) > was for it, was in zip(case.stations, before)))
    case.wait_until_same("that PostgreSQL stores nothing", lambda: case.query("SELECT count(*) FROM profivac_data.sample"))
    filler.unlink()
    case.start_all_again()
    case.wait_for_more()


def full_server(case):
    filler = case.fill()
    for station in case.stations:
        station.stop()
        station.start()
    case.wait_until_same("that NATS takes nothing", lambda: case.count("batch"))
    filler.unlink()
    # A server that has met a full disk takes no messages before it starts again.
    for server in case.servers:
        server.stop()
    case.start_all_again()
    case.wait_for_more()


def full_station(case):
    filler = case.fill()
    case.wait_until_same("that the station records nothing", lambda: case.recorded(case.stations[0]))
    filler.unlink()
    case.start_all_again()
    case.wait_for_more()


def restored(case):
    """The commands of docs/archive.md. No batch comes between dump and loss, so the comparison at the end is that of all rows."""
    connection = ["-h", str(case.folder), "-p", str(case.postgres_port), "-U", case.user]
    psql = ["psql", "-X", "-q", "-At", *connection]
    subprocess.run([*psql, "-c", "CREATE ROLE hall_reader LOGIN", "postgres"], check=True)
    for archive in case.archives:
        archive.stop()
    for file in case.folder.glob("archive-*.toml"):
        file.write_text(file.read_text() + '\n[[plant]]\nname = "hall"\nreaders = ["hall_reader"]\n')
    for archive in case.archives:
        archive.start()
    wait_for("the reader", lambda: case.count("reader") == 1)
    for archive in case.archives:
        archive.stop()
    dump, roles = case.folder / "archive.dump", case.folder / "roles.sql"
    subprocess.run([case.bin / "pg_dump", *connection, "--format=custom", f"--file={dump}", "postgres"], check=True)
    roles.write_text(subprocess.run([case.bin / "pg_dumpall", *connection, "--roles-only"], check=True, capture_output=True, text=True).stdout)
    before = case.count("sample")
    case.postgres.stop()
    shutil.rmtree(case.folder / "postgres")
    case.postgres = case.make_postgres()
    case.postgres.start()
    wait_for("an answer of PostgreSQL", lambda: case.query("SELECT 1") is not None)
    # The administrator exists in the new server.
    subprocess.run([*psql, f"--file={roles}", "postgres"], check=True, capture_output=True)
    subprocess.run([case.bin / "pg_restore", *connection, "--exit-on-error", "--dbname=postgres", dump], check=True)
    if case.count("sample") != before:
        raise SystemExit(f"FAILED: {case.count('sample')} samples are restored of {before}")
    case.start_all_again()
    case.wait_for_more()
    reader = ["psql", "-X", "-q", "-At", *connection[:4], "-U", "hall_reader", "-c", "SELECT DISTINCT plant FROM profivac.sample", "postgres"]
    plants = subprocess.run(reader, check=True, capture_output=True, text=True).stdout.split()
    if plants != ["hall"]:
        raise SystemExit(f"FAILED: after the restoration the reader sees {plants}")


def same_name(case):
    station = case.stations[0]
    other = case.folder / "other"
    other.mkdir()
    text = (case.folder / f"{station.name}.toml").read_text().replace(f"{station.name}/record.db", "other/record.db")
    file = case.folder / "other.toml"
    file.write_text(text)
    file.chmod(0o600)
    second = Process("other", [case.program, "run", file], case.folder)
    second.record = "record.db"
    second.start()
    try:
        wait_for("that a batch is put aside", lambda: case.count("rejected") > 0)
        rows = case.query("SELECT DISTINCT reason FROM profivac_data.rejected")
        if not all("two databases send as station" in reason for reason, in rows):
            raise SystemExit(f"FAILED: put aside: {rows}")
    finally:
        second.stop()
    raise Done(f"{case.count('rejected')} batches of the elder database are put aside with the reason")


def permissions(case):
    """What the server says to the user of the first station, in its own protocol, about subjects of others and its own."""
    station = case.stations[0].name
    port = case.lines[0].port
    trusted = ssl.create_default_context(cafile=case.folder / "server.crt")
    own = f"profivac.v1.hall.{station}"
    forbidden = ["SUB _INBOX.> 1", "SUB > 2", "SUB profivac.v1.*.*.batch 3", "SUB profivac.v1.ring.station-1.inbox.> 4", "SUB profivac.v1.*.*.request 5",
                 "SUB $JS.> 6", "PUB $JS.ACK.PROFIVAC.archive.1.1.1.1.0 0\r\n", "PUB $JS.API.STREAM.DELETE.PROFIVAC 0\r\n",
                 "PUB profivac.v1.ring.station-1.batch 0\r\n", "PUB profivac.v1.ring.station-1.request 0\r\n", "PUB _INBOX.a.b 0\r\n"]
    allowed = [f"SUB {own}.inbox.> 7", f"SUB {own}.request 8"]
    with socket.create_connection(("127.0.0.1", port), 10) as plain:
        while not plain.recv(1, socket.MSG_PEEK):
            pass
        head = plain.recv(65536)
        if not head.startswith(b"INFO "):
            raise SystemExit(f"FAILED: the server begins with {head}")
        with trusted.wrap_socket(plain, server_hostname="localhost") as link, link.makefile("rb") as lines:
            login = json.dumps({"verbose": False, "pedantic": False, "tls_required": True, "user": station, "pass": f"secret-of-{station}"})
            link.sendall(f"CONNECT {login}\r\n".encode())
            for commands, is_allowed in ((forbidden, False), (allowed, True)):
                for command in commands:
                    link.sendall(f"{command}\r\nPING\r\n".encode())
                    refused = False
                    while not (line := lines.readline()).startswith(b"PONG"):
                        if not line:
                            raise SystemExit(f"FAILED: the server ends the connection after {command}")
                        refused |= b"Permissions Violation" in line
                    if refused == is_allowed:
                        raise SystemExit(f"FAILED: {command.strip()} is {'refused' if refused else 'permitted'}")


def secure(case):
    """The comparison at the end is that of batches which came over TLS."""
    log = case.archives[1].log
    wait_for("that the second archive says why it stores nothing", lambda: "credentials" in log.read_text())
    permissions(case)
    case.wait_for_more()


def readers(case):
    def as_role(role, sql):
        command = ["psql", "-X", "-q", "-At", "-h", case.folder, "-p", str(case.postgres_port), "-U", role, "-d", "postgres", "-c", sql]
        return subprocess.run(command, capture_output=True, text=True)

    def expect(condition, what):
        if not condition:
            raise SystemExit(f"FAILED: {what}")

    old = "to_regclass('profivac_data.sample_20010203') IS NULL"
    for sql in ("CREATE ROLE hall_reader LOGIN", "SELECT profivac_data.add_day(date '2001-02-03')"):
        done = as_role(case.user, sql)
        expect(done.returncode == 0, done.stderr)
    expect(case.query(f"SELECT {old}") == [["f"]], "the old day has no partition")
    for archive in case.archives:
        archive.stop()
    for file in case.folder.glob("archive-*.toml"):
        file.write_text(file.read_text() + '\n[[plant]]\nname = "hall"\nreaders = ["hall_reader"]\n')
    for archive in case.archives:
        archive.start()
    wait_for("the reader", lambda: case.count("reader") == 1)
    wait_for("that the old day is dropped", lambda: case.query(f"SELECT {old}") == [["t"]])
    case.wait_for_more()
    hold_back(case, expect)
    for view in ("station", "series", "sample", "span", "event", "alarm", "audit", "active_alarm"):
        for role, plants in (("hall_reader", {"hall"}), (case.user, {"hall", "ring"})):
            done = as_role(role, f"SELECT DISTINCT plant FROM profivac.{view}")
            found = set(done.stdout.split())
            # No user has acted, and no span of two minutes is over.
            is_right = found <= plants if view in ("audit", "span") else found == plants
            expect(done.returncode == 0 and is_right, f"{role}, {view}: {found} {done.stderr}")
    for sql in ("SELECT FROM profivac_data.sample", "DELETE FROM profivac.station", "SELECT FROM profivac_data.reader"):
        done = as_role("hall_reader", sql)
        expect("permission denied" in done.stderr or "cannot delete" in done.stderr, f"{sql}: {done.stderr}")
    raise Done("the role sees its plant in every view and no table, and the old day is dropped")


def hold_back(case, expect):
    """A reader keeps a transaction open, as a dump of the database does, while partitions are missing and one is too old."""
    days = "SELECT relname FROM pg_inherits JOIN pg_class ON pg_class.oid = inhrelid WHERE inhparent = 'profivac_data.sample'::regclass ORDER BY 1"
    for archive in case.archives:
        archive.stop()
    last = case.query(days)[-1][0]
    psql = ["psql", "-X", "-q", "-At", "-v", "ON_ERROR_STOP=1", "-h", case.folder, "-p", str(case.postgres_port), "-d", "postgres"]
    change = f"DROP TABLE profivac_data.{last}; SELECT profivac_data.add_day(date '2001-02-03')"
    done = subprocess.run([*psql, "-U", case.user, "-c", change], capture_output=True, text=True)
    expect(done.returncode == 0, done.stderr)
    reader = subprocess.Popen([*psql, "-U", "hall_reader"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        reader.stdin.write("BEGIN; SELECT count(*) >= 0 FROM profivac.sample;\n")
        reader.stdin.flush()
        expect(reader.stdout.readline() == "t\n", "the reader has no answer")
        before = [archive.log.stat().st_size for archive in case.archives]
        for archive in case.archives:
            archive.start()
        case.wait_for_more()
        rows = [name for name, in case.query(days)]
        expect(last in rows and "sample_20010203" in rows, f"partitions while a reader holds a transaction: {rows}")
        logs = "".join(archive.log.read_text()[size:] for archive, size in zip(case.archives, before))
        expect("tries again" not in logs, f"an archive failed: {logs}")
        reader.stdin.write("COMMIT;\n")
    finally:
        reader.stdin.close()
        reader.wait()
    case.archives[0].stop()
    case.archives[0].start()
    wait_for("that the old day is dropped after the reader", lambda: ["sample_20010203"] not in case.query(days))


def varint(number):
    octets = bytearray()
    while number > 127:
        octets.append(number & 127 | 128)
        number >>= 7
    return bytes(octets) + bytes([number])


def field(tag, value):
    """A field of Protocol Buffers: an integer, a double, or octets."""
    if isinstance(value, int):
        return varint(tag << 3) + varint(value)
    if isinstance(value, float):
        return varint(tag << 3 | 1) + struct.pack("<d", value)
    return varint(tag << 3 | 2) + varint(len(value)) + value


def deflated(octets):
    packer = zlib.compressobj(wbits=-15)
    return packer.compress(octets) + packer.flush()


class Sender:
    """Sends batches of its own over HTTPS in the place of the second station, which stops. The numbers of the fields are those of
    docs/archive-format.md."""

    def __init__(self, case):
        self.case, station = case, case.stations[1]
        station.stop()
        self.now = time.time_ns() // 1000
        self.token = (case.folder / f"{station.name}.token").read_text()
        self.trusted = ssl.create_default_context(cafile=case.folder / "server.crt")
        self.url = f"https://localhost:{case.archive_ports[0]}/v1/ring/{station.name}/{self.now}"

    def send(self, number, *rows, of_format=1, ahead=0):
        """Sends a batch; its database began `ahead` seconds in the future."""
        batch = field(1, of_format) + field(2, self.now) + b"".join(rows)
        url = self.url.replace(str(self.now), str(self.now + ahead * 1_000_000))
        request = urllib.request.Request(f"{url}/{number}", deflated(batch), {"Authorization": f"Bearer {self.token}"})

        def status():
            try:
                with urllib.request.urlopen(request, context=self.trusted, timeout=120) as answer:
                    return answer.status
            except urllib.error.HTTPError as error:
                # As a station does: the archive may still store the batch.
                if error.code != 503:
                    raise
                return None

        return wait_for(f"an answer to batch {number}", status)

    def samples(self, series, pressure=1.0, later=b""):
        """One sample; `later` are fields of a later version."""
        return field(3, field(1, series) + field(2, varint(2 * self.now)) + field(3, bytes([128])) + field(4, struct.pack("<d", pressure)) + later)

    def span(self, series, log10_sum, later=b"", level=2):
        return field(4, field(1, series) + field(2, level) + field(3, self.now) + field(6, log10_sum) + field(7, 1) + later)

    def reasons(self):
        return [row for row, in self.case.query("SELECT reason FROM profivac_data.rejected ORDER BY id")]


def hostile(case):
    sender = Sender(case)
    samples, span = sender.samples, sender.span
    alarm = lambda number: field(6, field(1, number + 1) + field(2, sender.now) + field(3, b"a%d" % number) + field(4, b"raised")
                                 + field(5, b"unacknowledged") + field(6, b"low") + field(8, 1) + field(12, b"invented"))
    refused = [
        ([samples(os.urandom(4_000).hex().encode())], "a name of 8000 octets"),
        ([span(b"chamber", 1e300)], "no sum of pressures"),
        ([span(b"chamber", float("nan"))], "no sum of pressures"),
        ([samples(b"s%d" % number) for number in range(10_001)], "has 10000 series already"),
        ([alarm(number) for number in range(10_001)], "has more than 10000 alarms"),
        # The database has one number for both levels, and refuses a statement with two rows of one key.
        ([span(b"chamber", 1.0, level=40_000), span(b"chamber", 2.0, level=50_000)], "has the level 40000"),
        ([field(5, field(1, 1) + field(2, sender.now) + field(4, b"note") + field(5, b"x" * (4 << 20 >> 1)))], "a text of 2097152 octets"),
        ([samples(b"chamber")], "the database of the station began"),
    ]
    for number, (rows, reason) in enumerate(refused, 1):
        ahead = 365 * 86_400 if "began" in reason else 0
        status, reasons = sender.send(number, *rows, ahead=ahead), sender.reasons()
        if status != 204 or len(reasons) != number or reason not in reasons[-1]:
            raise SystemExit(f"FAILED: batch {number}: {status}, put aside: {reasons}")
    if sender.send(9, samples(b"s1")) != 204 or case.count("rejected") != len(refused):
        raise SystemExit("FAILED: a batch of a known series is refused")
    # The other station and the views for Grafana go on.
    case.wait_for_more()
    if case.query("SELECT count(*) > 0 FROM profivac.span WHERE mean_pa > 0") is None:
        raise SystemExit("FAILED: the view of all spans has no answer")
    raise Done(f"{len(refused)} batches are put aside with the reason, and the other station goes on")


class Publisher:
    """Publishes batches of a station of its own, in the protocol of NATS."""

    def __init__(self, port, station):
        self.station, self.now = station, time.time_ns() // 1000
        self.link = socket.create_connection(("127.0.0.1", port), 30)
        self.lines = self.link.makefile("rb")
        if not self.lines.readline().startswith(b"INFO "):
            raise SystemExit("FAILED: the server of NATS does not begin with INFO")
        login = json.dumps({"verbose": False, "pedantic": False, "headers": True})
        self.link.sendall(f"CONNECT {login}\r\nSUB answer 1\r\n".encode())

    def publish(self, number):
        """The answer of the stream to a batch of about half a megabyte."""
        noise = lambda: os.urandom(16_000).hex().encode()
        event = lambda row: field(5, field(1, 30 * number + row) + field(2, self.now) + field(4, b"note") + field(5, noise()))
        payload = deflated(field(1, 1) + field(2, self.now) + b"".join(event(row) for row in range(1, 31)))
        head = f"NATS/1.0\r\nProfivac-Batch: {self.station}/{self.now}/{number}\r\n\r\n".encode()
        command = f"HPUB profivac.v1.hall.{self.station}.batch answer {len(head)} {len(head) + len(payload)}\r\n"
        self.link.sendall(command.encode() + head + payload + b"\r\n")
        while (line := self.lines.readline()) and not line.startswith(b"MSG "):
            if line.startswith(b"PING"):
                self.link.sendall(b"PONG\r\n")
        return json.loads(self.lines.read(int(line.split()[-1]) + 2))


def greedy(case):
    publisher = Publisher(case.lines[0].target, "greedy")
    case.postgres.kill()
    stored, answer = 0, publisher.publish(1)
    while "error" not in answer:
        stored += 1
        answer = publisher.publish(stored + 1)
    if "maximum messages per subject exceeded" not in answer["error"]["description"]:
        raise SystemExit(f"FAILED: after {stored} batches of half a megabyte: {answer}")
    # The other stations have more to send, and the servers take it.
    last = lambda station: case.record(station, "SELECT seq FROM sqlite_sequence WHERE name = 'outbox'")[0][0]
    for station in case.stations:
        station.stop()
        before = last(station)
        station.start()
        wait_for(f"that {station.name} has more to send", lambda: last(station) > before)
        wait_for(f"that {station.name} publishes while PostgreSQL is down",
                 lambda: case.record(station, "SELECT count(*) FROM outbox")[0][0] == 0)
    if case.query("SELECT 1") is not None:
        raise SystemExit("FAILED: PostgreSQL runs")
    case.start_again(case.postgres)
    sql = "SELECT count(*) FROM profivac_data.batch JOIN profivac_data.station ON station.id = station WHERE name = 'greedy'"
    wait_for("the batches of the greedy station", lambda: case.query(sql) == [[str(stored)]])
    print(f"{stored} batches of the greedy station were acknowledged, and are stored")


def versions(case):
    sender = Sender(case)
    later = field(77, b"of a later version") + field(78, 5) + field(79, 1.5)
    event = lambda number, more=b"": field(5, field(1, number) + field(2, sender.now) + field(4, b"note") + field(5, b"event %d" % number) + more)
    alarm = lambda number, more=b"": field(6, field(1, number) + field(2, sender.now) + field(3, b"pump %d" % number) + field(4, b"raised")
                                           + field(5, b"unacknowledged") + field(6, b"high") + field(8, 1) + field(12, b"hot") + more)
    audit = lambda number, more=b"": field(7, field(1, number) + field(2, sender.now) + field(3, b"login") + field(5, b"ada") + field(6, b"operator") + more)
    batches = [
        (1, [sender.samples(b"this", 2.5), sender.span(b"this", 1.0), event(1), alarm(1), audit(1)]),
        (1, [sender.samples(b"later", 3.5, later), sender.span(b"later", 2.0, later), event(2, later), alarm(2, later), audit(2, later), later]),
        (2, [sender.samples(b"next", 4.5)]),
        (1, [sender.samples(b"this again", 5.5)]),
    ]
    for number, (of_format, rows) in enumerate(batches, 1):
        status = sender.send(number, *rows, of_format=of_format)
        if status != 204:
            raise SystemExit(f"FAILED: batch {number}: {status}")
    name = case.stations[1].name
    expected = {
        f"SELECT series, pressure_pa FROM profivac.sample WHERE station = '{name}' AND series IN ('this', 'later', 'next', 'this again') ORDER BY 2":
            [["this", "2.5"], ["later", "3.5"], ["this again", "5.5"]],
        f"SELECT series, round(mean_pa) FROM profivac.span WHERE station = '{name}' AND series IN ('this', 'later') ORDER BY 2":
            [["this", "10"], ["later", "100"]],
        f"SELECT text FROM profivac.event WHERE station = '{name}' AND kind = 'note' ORDER BY 1": [["event 1"], ["event 2"]],
        f"SELECT alarm FROM profivac.active_alarm WHERE station = '{name}' AND alarm LIKE 'pump%' ORDER BY 1": [["pump 1"], ["pump 2"]],
        f"SELECT user_name FROM profivac.audit WHERE station = '{name}'": [["ada"], ["ada"]],
    }
    for sql, rows in expected.items():
        found = case.query(sql)
        if found != rows:
            raise SystemExit(f"FAILED: {sql}: {found} in place of {rows}")
    reasons = sender.reasons()
    if len(reasons) != 1 or "format 2" not in reasons[0]:
        raise SystemExit(f"FAILED: put aside: {reasons}")
    case.wait_for_more()
    raise Done("both versions are stored, the batch of a later format is put aside with the reason, and the other station goes on")


class Done(Exception):
    """The case has no comparison."""


CASES = {
    "week": (week, {"stations": 1, "days": 7}),
    "stopped": (stopped, {}),
    "leader": (leader, {"servers": 3}),
    "replaced": (replaced, {}),
    "postgres": (full_database, {"disk": "postgres"}),
    "nats": (full_server, {"disk": "nats-0"}),
    "station": (full_station, {"disk": "station-0"}),
    "restored": (restored, {}),
    "secure": (secure, {"is_secure": True}),
    "readers": (readers, {}),
    "hostile": (hostile, {"servers": 0}),
    "versions": (versions, {"servers": 0}),
    "greedy": (greedy, {"stream": "200_000_000"}),
    "same-name": (same_name, {"stations": 1}),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda path: Path(path).resolve())
    parser.add_argument("cases", nargs="*", choices=[[], *CASES], metavar="CASE", default=[])
    parser.add_argument("--days", type=int, default=7)
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("FAILED: ended by SIGTERM"))
    for name in arguments.cases or CASES:
        act, options = CASES[name]
        if "days" in options:
            options = {**options, "days": arguments.days}
        if "disk" in options and os.geteuid() != 0:
            print(f"{name}: skipped: only root can mount a disk")
            continue
        begun = time.monotonic()
        with tempfile.TemporaryDirectory(prefix="profivac-case-", ignore_cleanup_errors=True) as folder:
            case = Case(arguments.program, Path(folder), **options)
            try:
                result = f"{case.run(act)} samples are the same in the databases and in PostgreSQL"
            except Done as done:
                result = str(done)
            except SystemExit:
                for process in case.all():
                    if process.log.exists():
                        print(f"--- {process.log.name}\n" + "\n".join(process.log.read_text(errors="replace").splitlines()[-12:]), file=sys.stderr)
                raise
            finally:
                case.close()
        print(f"{name}: ok: {result} ({time.monotonic() - begun:.0f} s)", flush=True)


if __name__ == "__main__":
    main()
