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
restored   the database is dumped, lost after more batches, and restored; the stations send again what the dump lacks
older      the same without NATS
cleaned    an older dump is restored into the database while the archives run, and the numbers of series go back with it
backup     a `profivac backup` with waiting batches takes the place of a station's database
copied     an older copy of a station's database is put back with cp
retention  twenty days are beyond the retention at a start, then three, then three of which a reader holds one
packed     a day that is over is packed while batches of it come, an archive is killed in the middle of it, a reader holds it back, and it is dumped
tables     the tables of version 8 are migrated, with days that are over
power      the servers of NATS lose all batches that they have acknowledged, as a power cut does
crash      PostgreSQL commits without waiting for the disk unless told, and is killed
foreign    a stream of others takes the batches, then a stream PROFIVAC that keeps them in memory
readers    a role reads the stations of its plant only, roles without rows are told why, a role holds back no batches, and the days beyond the retention are dropped
hostile    a station with a token sends names, numbers, texts and times that no database holds, over HTTPS
versions   a station of this version, with points of slaves, one with later fields, and one of a later format send at once
greedy     a station fills its share of the stream while PostgreSQL is down; another one still publishes, and nothing acknowledged is lost
metrics    what an archive counts is what came, and the stream and the errors show while PostgreSQL is down
absent     [archive] is out of the file of a station for a while
moved      a station gets another name and another plant, as docs/archive-operation.md says
same-name  two stations send under one name: takes more than a minute

Each case ends with the comparison of every sample, span and event of the databases with PostgreSQL.
"""

import argparse
import contextlib
import errno
import json
import os
import re
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

    def api(self, station, path):
        """The answer of the API of a station."""
        url = [line for line in station.log.read_text().splitlines() if line.startswith("ready ")][-1].split()[1]
        with urllib.request.urlopen(url + path, timeout=30) as answer:
            return json.load(answer)

    def told(self, station):
        """What a station knows of the archive."""
        [archive] = [gateway["archive"] for gateway in self.api(station, "/api/gateways") if gateway["name"] == "archive"]
        return archive or {"put_aside": 0}

    def missing(self):
        """The batches that the archive lacks; -1 while the database does not answer."""
        rows = self.query("SELECT coalesce(sum(missing), 0) FROM profivac.station")
        return int(rows[0][0]) if rows else -1

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
    """The commands of docs/archive.md. Batches come between dump and loss: the stations still have them."""
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
    for archive in case.archives:
        archive.start()
    case.wait_for_more()
    wait_for("more samples than in the dump", lambda: case.count("sample") > before)
    for archive in case.archives:
        archive.stop()
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


def cleaned(case):
    """A series of the first station gets the number, after the restoration, that one of the second had before it."""
    connection = ["-h", str(case.folder), "-p", str(case.postgres_port), "-U", case.user]
    dump = case.folder / "archive.dump"
    subprocess.run([case.bin / "pg_dump", *connection, "--format=custom", f"--file={dump}", "postgres"], check=True)
    series = lambda name: case.query(f"SELECT id FROM profivac_data.series WHERE name = '{name}'")
    with_gauge = lambda name: example["GAUGES"].replace('name = "foreline"', f'name = "{name}"')
    for number, name in ((1, "lock"), (0, "load lock")):
        station = case.stations[number]
        station.stop()
        case.write_station(station.name, number, with_gauge(name))
        station.start()
        wait_for(f"the series {name}", lambda: series(name))
    former = {name: series(name) for name in ("lock", "load lock")}
    for station in case.stations:
        station.stop()
    statements = case.folder / "restore.sql"
    subprocess.run([case.bin / "pg_restore", f"--file={statements}", dump], check=True)
    drop = "DROP SCHEMA profivac CASCADE; DROP SCHEMA profivac_data CASCADE"
    restore = ["psql", "-X", "-q", *connection, "--single-transaction", "-v", "ON_ERROR_STOP=1", "-c", drop, "-f", statements, "postgres"]
    # It may meet a query of the page, and then begins again.
    wait_for("the restoration", lambda: subprocess.run(restore, capture_output=True).returncode == 0)
    # The other one comes first this time.
    for number in (0, 1):
        case.stations[number].start()
        name = ("load lock", "lock")[number]
        wait_for(f"the series {name} again", lambda: series(name))
    print(f"series before the restoration: {former}, after it: {({name: series(name) for name in former})}")


def backup(case):
    """A backup with waiting batches and open spans takes the place of the database. Nothing is twice in the archive."""
    station = case.stations[0]
    record, copy = case.folder / station.name / "record.db", case.folder / "backup.db"
    # Batches wait, and the backup has them.
    case.lines[0].cut()
    waiting = lambda: case.record(station, "SELECT count(*) FROM outbox")[0][0]
    station.stop()
    station.start()
    wait_for("that batches wait", lambda: waiting() > 3)
    subprocess.run([case.program, "backup", record, "--to", copy], check=True, capture_output=True)
    case.lines[0].is_cut = False
    wait_for("that they are sent", lambda: waiting() == 0)
    # Until the spans of two minutes that were open at the backup have ended and are stored.
    [(start,)] = case.record(station, "SELECT max(start_us) FROM span WHERE level = 2")
    ended = f"SELECT count(*) FROM profivac_data.span WHERE level = 2 AND start >= to_timestamp({start} / 1000000)"
    wait_for("the span that was open", lambda: int(case.query(ended)[0][0]))
    station.stop()
    for file in record.parent.glob("record.db*"):
        file.unlink()
    shutil.copy(copy, record)
    station.start()
    epochs = f"SELECT count(DISTINCT epoch) FROM profivac_data.batch WHERE station = (SELECT id FROM profivac_data.station WHERE name = '{station.name}')"
    wait_for("the epoch of the copy", lambda: case.query(epochs) == [["2"]])
    copied = "SELECT count(*) FROM profivac_data.span WHERE level = 2 AND epoch = (SELECT max(epoch) FROM profivac_data.batch)"
    wait_for("a span of the copy", lambda: int(case.query(copied)[0][0]))
    wait_for("that the copy has sent everything", lambda: waiting() == 0)
    nothing_is_twice(case)
    if case.count("rejected"):
        raise SystemExit(f"FAILED: put aside: {case.query('SELECT reason FROM profivac_data.rejected')}")
    raise Done("no event and no span is twice in the archive")


def nothing_is_twice(case):
    """No row that a database and its copy both have is twice in the archive."""
    twice = {
        "events": "SELECT text, at, count(*) FROM profivac.event GROUP BY station, text, at, kind HAVING count(*) > 1",
        "alarm changes": "SELECT alarm, at, count(*) FROM profivac_data.alarm GROUP BY station, alarm, id, at HAVING count(*) > 1",
        "audit rows": "SELECT user_name, at, count(*) FROM profivac_data.audit GROUP BY station, id, at HAVING count(*) > 1",
        "spans": "SELECT series, level, start, count(*) FROM profivac_data.span GROUP BY series, level, start HAVING count(*) > 1",
    }
    for what, sql in twice.items():
        if rows := case.query(sql):
            raise SystemExit(f"FAILED: {len(rows)} {what} are twice in the archive, like {rows[0]}")


def copied(case):
    """The station runs on after the copy, and again after the copy was put back. The notes of both times are in the archive."""
    station = case.stations[0]
    record = case.folder / station.name / "record.db"
    station.stop()
    for file in record.parent.glob("record.db*"):
        shutil.copy(file, file.with_name("copy-" + file.name))
    station.start()
    wait_for("that the station has sent what it recorded", lambda: case.has_all(station) and case.count("batch"))
    case.wait_for_more()
    station.kill()
    for file in record.parent.glob("record.db*"):
        file.unlink()
    for file in record.parent.glob("copy-*"):
        shutil.move(file, file.with_name(file.name.removeprefix("copy-")))
    station.start()
    epochs = f"SELECT DISTINCT batch.epoch FROM profivac_data.batch JOIN profivac_data.station ON station.id = station WHERE name = '{station.name}'"
    wait_for("that a batch is put aside", lambda: case.count("rejected"))
    rows = [reason for reason, in case.query("SELECT DISTINCT reason FROM profivac_data.rejected")]
    if not all("came before, made at another time" in reason for reason in rows):
        raise SystemExit(f"FAILED: put aside: {rows}")
    wait_for("another epoch", lambda: len(case.query(epochs)) > 1)
    case.wait_for_more()
    # Each event that the present file has is in the archive, under one of both epochs.
    last = lambda: case.record(station, "SELECT count(*) FROM outbox")[0][0]
    wait_for("that all batches are taken", lambda: last() == 0)

    def missing_events():
        ours = set(case.record(station, "SELECT text, at_us FROM event WHERE id <= (SELECT event_id FROM outbox_state)"))
        rows = case.query(f"SELECT text, (extract(epoch FROM at) * 1000000)::bigint FROM profivac.event WHERE station = '{station.name}'")
        return ours - {(text, int(at)) for text, at in rows}

    wait_for("every event of the copy that was put back", lambda: not missing_events())
    said = case.record(station, "SELECT count(*) FROM event WHERE text LIKE 'the archive has other batches of this database%'")
    if said != [(1,)]:
        raise SystemExit(f"FAILED: the station says {said[0][0]} times that it goes on as another database")
    wait_for("that nothing is missing", lambda: case.missing() == 0)
    nothing_is_twice(case)
    raise Done("the batches of both times are in the archive once, and the station goes on as another database")


def retention(case):
    """Twenty old days and an archive with a number of days that makes them old."""
    days = "SELECT count(*) FROM pg_inherits WHERE inhparent = 'profivac_data.sample'::regclass"
    count = lambda: int(case.query(days)[0][0])
    psql = ["psql", "-X", "-q", "-h", case.folder, "-p", str(case.postgres_port), "-U", case.user, "-d", "postgres", "-c"]
    add = "SELECT profivac_data.add_day(day::date) FROM generate_series(date '2001-02-01', date '2001-02-20', '1 day') AS day"
    before = count()
    subprocess.run([*psql, add], check=True, capture_output=True)
    archive = case.archives[0]
    archive.stop()
    archive.start()
    words = "the samples of 20 days, from 2001-02-01 to 2001-02-20, are beyond samples-days = 30 and are not dropped"
    wait_for("the words of the archive", lambda: words in archive.log.read_text())
    case.wait_for_more()
    if count() != before + 20:
        raise SystemExit(f"FAILED: {count()} days are left of {before + 20}")
    command = [case.program, "archive", case.folder / "archive-0.toml", "--drop-old-samples"]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    if count() != before or not told.startswith("the samples of 20 days, from 2001-02-01 to 2001-02-20, are dropped"):
        raise SystemExit(f"FAILED: {count()} days are left of {before + 20}: {told}")
    subprocess.run([*psql, add.replace("-20'", "-03'")], check=True, capture_output=True)
    archive.stop()
    archive.start()
    words = "the samples of 3 days, from 2001-02-01 to 2001-02-03, are dropped: samples-days is 30"
    wait_for("the words of the archive about three days", lambda: words in archive.log.read_text())
    wait_for("that three days are dropped", lambda: count() == before)
    # A reader of one day holds back no other.
    subprocess.run([*psql, add.replace("-20'", "-03'")], check=True, capture_output=True)
    archive.stop()
    reader = subprocess.Popen([*psql[:-1], "-At"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        reader.stdin.write("BEGIN; SELECT count(*) FROM profivac_data.sample_20010202;\n")
        reader.stdin.flush()
        if reader.stdout.readline() != "0\n":
            raise SystemExit("FAILED: the reader has no answer")
        archive.start()
        words = "the samples of 2001-02-02 stay, because process "
        wait_for("the words of the archive about the reader", lambda: words in archive.log.read_text() and f"(user {case.user}, psql)" in archive.log.read_text())
        if count() != before + 1:
            raise SystemExit(f"FAILED: {count() - before} days are left beside the one with a reader")
        told = subprocess.run(command, capture_output=True, text=True)
        if told.returncode == 0 or words not in told.stderr:
            raise SystemExit(f"FAILED: --drop-old-samples while a reader holds the day: {told.stdout}{told.stderr}")
        reader.stdin.write("COMMIT;\n")
    finally:
        reader.stdin.close()
        reader.wait()
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    if count() != before or "the samples of one day are dropped" not in told:
        raise SystemExit(f"FAILED: {count() - before} days are left after the reader: {told}")


def power(case):
    """All files of the servers are gone, as those that the disk did not have yet. The archives have stored none of the batches."""
    for archive in case.archives:
        archive.stop()
    stored = case.count("batch")
    sql = "SELECT seq - (SELECT count(*) FROM outbox) FROM sqlite_sequence WHERE name = 'outbox'"
    sent = lambda station: case.record(station, sql)[0][0]
    for station in case.stations:
        before = sent(station)
        station.stop()
        station.start()
        wait_for(f"that NATS has acknowledged batches of {station.name}", lambda: sent(station) > before + 2)
    for server in case.servers:
        server.kill()
    for number in range(len(case.servers)):
        shutil.rmtree(case.folder / f"nats-{number}")
    case.start_all_again()
    case.wait_for_more()
    wait_for("that the archive sees what is missing", lambda: case.missing() > 0)
    if case.count("batch") <= stored:
        raise SystemExit("FAILED: no batch came after the loss")
    wait_for("that nothing is missing", lambda: case.missing() == 0)


def crash(case):
    for sql in ("ALTER SYSTEM SET synchronous_commit = off", "ALTER SYSTEM SET wal_writer_delay = '10s'"):
        subprocess.run(["psql", "-X", "-q", "-h", case.folder, "-p", str(case.postgres_port), "-U", case.user, "-d", "postgres", "-c", sql], check=True)
    # The settings are those of the start.
    for process in (*case.archives, case.postgres):
        process.stop()
    for process in (case.postgres, *case.archives):
        case.start_again(process)
    stored = lambda: {tuple(row) for row in case.query("SELECT station, epoch, number, stored FROM profivac_data.batch")}
    for number in range(5):
        case.wait_for_more()
        main = (case.folder / "postgres" / "postmaster.pid").read_text().split()[0]
        children = subprocess.run(["pgrep", "-P", main], capture_output=True, text=True, check=True).stdout.split()
        before = stored()
        # A process that ends by itself would write what the others have not.
        for process in (*children, main):
            with contextlib.suppress(ProcessLookupError):
                os.kill(int(process), signal.SIGKILL)
        case.postgres.kill()
        case.start_again(case.postgres)
        if lost := before - stored():
            raise SystemExit(f"FAILED: crash {number + 1}: {len(lost)} batches of {len(before)} are not as they were, like {min(lost)}")


def foreign(case):
    for archive in case.archives:
        archive.stop()
    with Client(case.lines[0].target) as nats:
        create = lambda name, **settings: nats.request(f"$JS.API.STREAM.CREATE.{name}", {"name": name, "num_replicas": 1, **settings})
        delete = lambda name: nats.request(f"$JS.API.STREAM.DELETE.{name}", {})
        delete("PROFIVAC")
        create("OTHER", subjects=["profivac.>"], retention="limits", storage="file")
        waiting = lambda station: case.record(station, "SELECT count(*) FROM outbox")[0][0]
        for station in case.stations:
            station.stop()
            station.start()
        for station in case.stations:
            words = "SELECT count(*) FROM event WHERE text LIKE '%the stream OTHER has taken the batch%'"
            wait_for(f"the words of {station.name} about the stream", lambda: case.record(station, words)[0][0])
            if not waiting(station):
                raise SystemExit(f"FAILED: {station.name} has forgotten what the stream OTHER has taken")
        delete("OTHER")
        create("PROFIVAC", subjects=["profivac.v1.*.*.batch"], retention="workqueue", storage="memory", discard="new", max_age=20 * 10**9)
        case.archives[0].start()
        words = "storage memory in place of file, max-age 20 s in place of 0 s: batches may be lost"
        wait_for("the words of the archive about the stream", lambda: words in case.archives[0].log.read_text())
        case.archives[0].stop()
        delete("PROFIVAC")
    case.start_all_again()
    case.wait_for_more()


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
        # Both stations are told, and the archive shows and logs it.
        for of in (station, second):
            wait_for(f"the words of {of.name} about batches that are put aside", lambda: case.told(of)["put_aside"] > 0)
            wait_for(f"the head of the pages of {of.name}", lambda: case.api(of, "/api/station")["archive_problem"])
        shown = case.query("SELECT put_aside > 0, put_aside_reason FROM profivac.station")
        if shown[0][0] != "t" or "two databases send as station" not in shown[0][1]:
            raise SystemExit(f"FAILED: the view shows {shown}")
        if not any(f"a batch of {station.name} is put aside" in archive.log.read_text() for archive in case.archives):
            raise SystemExit("FAILED: no archive logs the name and the reason")
    finally:
        second.stop()
    # The first station is the right one: the twin is off, and what was put aside is stored.
    station.stop()
    aside = case.count("rejected")
    command = [case.program, "archive", case.folder / "archive-0.toml", "--accept", station.name, "--again"]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    [(own,)] = case.record(station, "SELECT epoch FROM outbox_state")
    [(chosen,)] = case.query("SELECT epoch FROM profivac_data.station")
    if str(own) != chosen or case.count("rejected") or f"{aside} batches are stored, 0 stay put aside" not in said:
        raise SystemExit(f"FAILED: {own} is not chosen: {chosen}; {case.count('rejected')} of {aside} batches are put aside: {said}")
    station.start()
    has = lambda: case.query(f"SELECT max(number) FROM profivac_data.batch WHERE epoch = {own}")
    last = lambda: case.record(station, "SELECT seq FROM sqlite_sequence WHERE name = 'outbox'")
    wait_for("the batches of the station that was chosen", lambda: int(has()[0][0]) >= last()[0][0])
    second.start()
    wait_for("that batches of the twin are put aside", lambda: case.count("rejected"))
    second.stop()
    rows = case.query("SELECT DISTINCT reason FROM profivac_data.rejected")
    if not all("an operator has chosen an earlier database" in reason for reason, in rows):
        raise SystemExit(f"FAILED: put aside: {rows}")
    raise Done(f"{aside} batches of the elder database were put aside with the reason, and are stored after the choice of the operator")


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
    without_rows(case, as_role, expect)
    for sql in ("SELECT FROM profivac_data.sample", "DELETE FROM profivac.station", "SELECT FROM profivac_data.reader"):
        done = as_role("hall_reader", sql)
        expect("permission denied" in done.stderr or "cannot delete" in done.stderr, f"{sql}: {done.stderr}")
    raise Done("the role sees its plant in every view and no table, and the old day is dropped")


def without_rows(case, as_role, expect):
    """Roles that see no row are told why, once in a query, and the archive logs those that are no readers."""
    for sql in ("CREATE ROLE grafana LOGIN", "CREATE ROLE hal_reader LOGIN", "INSERT INTO profivac_data.reader VALUES ('hal', 'hal_reader')",
                "GRANT USAGE ON SCHEMA profivac TO grafana, hal_reader", "GRANT SELECT ON ALL TABLES IN SCHEMA profivac TO grafana, hal_reader"):
        done = as_role(case.user, sql)
        expect(done.returncode == 0, done.stderr)
    words = {"grafana": "for role grafana: it is a reader of no plant", "hal_reader": "no station sends with the plant that it reads, hal"}
    for role, reason in words.items():
        # Tables without rows are not searched further.
        for view in ("station", "series", "sample", "event", "alarm", "active_alarm"):
            done = as_role(role, f"SELECT count(*) FROM profivac.{view}")
            expect(done.stdout == "0\n" and done.stderr.count(reason) == 1 and done.stderr.count("HINT") == 1, f"{role}, {view}: {done}")
    for role in ("hall_reader", case.user):
        done = as_role(role, "SELECT count(*) > 0 FROM profivac.sample")
        expect(done.stdout == "t\n" and not done.stderr, f"{role}: {done}")
    # The file names no such role, and the archive logs those that the database has.
    archive = case.archives[0]
    archive.stop()
    archive.start()
    wait_for("the words about grafana", lambda: "have no rows for grafana, hal_reader" in archive.log.read_text())


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
            except urllib.error.URLError:
                # The archive starts.
                return None

        return wait_for(f"an answer to batch {number}", status)

    def samples(self, series, pressure=1.0, later=b"", at=None):
        """One sample, at a time in microseconds or now; `later` are fields of a later version."""
        return field(3, field(1, series) + field(2, varint(2 * (at or self.now))) + field(3, bytes([128])) + field(4, struct.pack("<d", pressure)) + later)

    def span(self, series, log10_sum, later=b"", level=2):
        """A span of one valid sample."""
        return field(4, field(1, series) + field(2, level) + field(3, self.now) + field(6, log10_sum) + field(7, 1) + field(8, 1) + later)

    @staticmethod
    def point(name, unit, kind):
        return field(1, field(1, b"turbo") + field(2, name) + field(3, unit) + field(4, kind))

    def value(self, name, value, unit=b"", kind=b"number", later=b"", at=None):
        """One value of a point, at a time in microseconds or now."""
        return field(8, self.point(name, unit, kind) + field(2, varint(2 * (at or self.now))) + field(3, bytes([128])) + field(4, struct.pack("<d", value)) + later)

    def point_span(self, name, low, high, last, unit=b"", kind=b"number"):
        """A span of two values of a point."""
        return field(9, self.point(name, unit, kind) + field(2, 2) + field(3, self.now) + field(4, low) + field(5, high) + field(6, last)
                     + field(7, low + high) + field(8, 2))

    def code_text(self, name, value, text):
        """The text of a code of a point."""
        return field(11, self.point(name, b"", b"code") + field(2, value) + field(3, text))

    def reasons(self):
        return [row for row, in self.case.query("SELECT reason FROM profivac_data.rejected ORDER BY id")]


def packed(case):
    """A day that is over: batches of it come before, during and after it is packed."""
    psql = ["psql", "-X", "-q", "-At", "-v", "ON_ERROR_STOP=1", "-h", case.folder, "-p", str(case.postgres_port), "-U", case.user]
    tell = lambda text: subprocess.run([*psql, "-d", "postgres", "-c", text], check=True, capture_output=True, text=True).stdout
    sender = Sender(case)
    midnight = sender.now // 86_400_000_000 * 86_400_000_000
    noon = midnight - 60 * 3_600_000_000
    name = time.strftime("sample_%Y%m%d", time.gmtime(noon // 1_000_000))
    keys = lambda: case.query(f"SELECT indrelid::regclass FROM pg_index WHERE indisunique AND indrelid::regclass::text LIKE '%{name}'")
    counts = lambda: [int(case.query(f"SELECT count(*) FROM profivac_data.{table}")[0][0]) for table in (name, f"point_{name}")]
    old = lambda second, pressure=1.0: sender.samples(b"late", pressure, at=noon + second * 1_000_000)

    def send(number, *rows):
        if (status := sender.send(number, *rows)) != 204:
            raise SystemExit(f"FAILED: batch {number}: {status}")

    def expect(found, wanted, what):
        if found != wanted:
            raise SystemExit(f"FAILED: {what}: {found} in place of {wanted}")

    send(1, old(0), sender.value(b"speed", 1.0, b"Hz", at=noon))
    # The samples of 50 gauges, in the order in which they come.
    tell(f"INSERT INTO profivac_data.sample (series, at, pressure_pa, quality) SELECT 1000000 + n % 50, to_timestamp({noon // 1_000_000} + n / 50), random(), 0 "
         "FROM generate_series(1, 200000) AS n")
    expect(counts(), [200_001, 1], "rows before")
    reader = subprocess.Popen([*psql, "-d", "postgres"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    waiting = "SELECT pid FROM pg_stat_activity WHERE query LIKE 'CREATE INDEX CONCURRENTLY%' AND wait_event_type = 'Lock'"
    try:
        reader.stdin.write("BEGIN ISOLATION LEVEL REPEATABLE READ; SELECT count(*) FROM profivac_data.version;\n")
        reader.stdin.flush()
        reader.stdout.readline()
        for archive in case.archives:
            archive.stop()
        for archive in case.archives:
            archive.start()
        wait_for("an archive that packs and waits for the reader", lambda: case.query(waiting))
        send(2, old(1))
        case.stations[0].stop()
        case.stations[0].start()
        # Of two archives one packs. It is killed, and so is the process of the database, which would go on.
        for archive in case.archives:
            archive.kill()
        tell(f"SELECT pg_terminate_backend(pid) FROM ({waiting}) AS packing")
        incomplete = "SELECT count(*) FROM pg_index WHERE NOT indisvalid"
        wait_for("an index that is not complete", lambda: case.query(incomplete) not in (None, [["0"]]))
        expect(len(keys()), 2, "keys after the kill")
        for archive in case.archives:
            archive.start()
        send(3, old(2))
        reader.stdin.write(f"SELECT count(*) FROM profivac_data.{name}; COMMIT;\n")
        reader.stdin.flush()
        expect(reader.stdout.readline(), "200001\n", "rows that the reader sees")
    finally:
        reader.stdin.close()
        reader.wait()
    wait_for("that the day has no key", lambda: keys() == [])
    expect(case.query(incomplete), [["0"]], "indexes that are not complete")
    expect(counts(), [200_003, 1], "rows of the packed day")
    [(octets,)] = case.query(f"SELECT pg_total_relation_size('profivac_data.{name}') / 200003.0")
    if float(octets) > 60:
        raise SystemExit(f"FAILED: a sample takes {octets} octets")
    # A batch again; one with a sample and a value that are there, two of one time, and one of today; the same with another number.
    send(3, old(2))
    rows = [old(2, 7.0), old(3), old(4), old(4), sender.samples(b"late"), sender.value(b"speed", 1.0, b"Hz", at=noon), sender.value(b"speed", 2.0, b"Hz", at=noon + 1)]
    send(4, *rows)
    send(5, *rows)
    # A day with a key: a sample that is there, under another number, and one that is not.
    send(6, sender.samples(b"late"), sender.samples(b"late", at=sender.now + 1))
    expect(counts(), [200_005, 2], "rows after late batches")
    late = f"SELECT count(*), count(DISTINCT at), sum(pressure_pa) FROM profivac.sample WHERE station = '{case.stations[1].name}' AND series = 'late'"
    expect(case.query(late), [["7", "7", "7"]], "samples, times and pressures of the late series")
    dump = case.folder / "archive.dump"
    connection = ["-h", str(case.folder), "-p", str(case.postgres_port), "-U", case.user]
    subprocess.run([case.bin / "pg_dump", *connection, "--format=custom", f"--file={dump}", "postgres"], check=True)
    tell("CREATE DATABASE again")
    subprocess.run([case.bin / "pg_restore", *connection, "--exit-on-error", "--dbname=again", dump], check=True)
    restored = subprocess.run([*psql, "-d", "again", "-c", f"SELECT count(*) FROM profivac_data.{name}"], check=True, capture_output=True, text=True).stdout
    expect(restored, "200005\n", "rows of the restored day")
    case.wait_for_more()
    raise Done(f"a sample of the packed day takes {float(octets):.1f} octets, and late and repeated batches are in it once")


def tables(case):
    """A database of version 8, made with the migrations of the program."""
    archive = case.archives[0]
    for process in case.archives:
        process.stop()
    psql = ["psql", "-X", "-q", "-At", "-v", "ON_ERROR_STOP=1", "-h", case.folder, "-p", str(case.postgres_port), "-U", case.user]
    tell = lambda text, database="old": subprocess.run([*psql, "-d", database, "-c", text], check=True, capture_output=True, text=True).stdout
    tell("CREATE DATABASE old", "postgres")
    folder = Path(__file__).resolve().parents[2] / "crates/archive/sql"
    migrations = [f"--file={folder}/{number}.sql" for number in range(1, 9)]
    tell("CREATE SCHEMA profivac_data; CREATE TABLE profivac_data.version (number integer NOT NULL); INSERT INTO profivac_data.version VALUES (8)")
    subprocess.run([*psql, "-d", "old", *migrations], check=True, capture_output=True)
    tell("""INSERT INTO profivac_data.station (plant, name, epoch) VALUES ('hall', 'before', 1);
        INSERT INTO profivac_data.series (station, name) SELECT 1, 'gauge ' || n FROM generate_series(1, 5) AS n;
        INSERT INTO profivac_data.point (station, slave, name, unit, kind) VALUES (1, 'turbo', 'speed', 'Hz', 'number');
        SELECT profivac_data.add_day((current_date + n)::date) FROM generate_series(-4, 4) AS n;
        INSERT INTO profivac_data.sample SELECT n % 5 + 1, now() - n * interval '1 min', n, n % 3 FROM generate_series(0, 5000) AS n;
        INSERT INTO profivac_data.point_sample SELECT 1, now() - n * interval '1 min', n, 0 FROM generate_series(0, 5000) AS n""")
    views = {"sample": "series_id, at", "point_sample": "point_id, at"}
    rows = lambda: {view: tell(f"SELECT * FROM profivac.{view} ORDER BY {order}") for view, order in views.items()}
    columns = lambda: tell("SELECT table_name, column_name, data_type FROM information_schema.columns WHERE table_schema = 'profivac' ORDER BY table_name, ordinal_position")
    before, series = (rows(), columns()), tell("SELECT pg_relation_filenode('profivac_data.series')")
    file = case.folder / "archive-0.toml"
    file.write_text(file.read_text().replace("dbname=postgres", "dbname=old"))
    archive.start()
    keys = "SELECT count(*) FROM pg_index JOIN pg_inherits ON inhrelid = indrelid WHERE indisunique"
    # Today and the day before keep their keys, as have the next three: of pressures and of points.
    wait_for("that three days are packed", lambda: tell(keys) == "10\n")
    if (rows(), columns()) != before:
        raise SystemExit("FAILED: the views show other rows or columns than before")
    if tell("SELECT max(number) FROM profivac_data.version") == "8\n":
        raise SystemExit("FAILED: the tables are not migrated")
    if tell("SELECT pg_relation_filenode('profivac_data.series')") == series:
        raise SystemExit("FAILED: an archive of before that still runs would not notice the migration")
    raise Done("the views show the rows of before, and the days that are over are packed")


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
        ([sender.point_span(b"speed", 1.0, float("nan"), 1.0)], "beyond ±1e290"),
        ([sender.value(os.urandom(4_000).hex().encode(), 1.0)], "a name of 8011 octets"),
        ([sender.value(b"p%d" % number, 1.0) for number in range(10_001)], "has 10000 points already"),
        ([samples(b"chamber")], "the database of the station began"),
    ]
    for number, (rows, reason) in enumerate(refused, 1):
        ahead = 365 * 86_400 if "began" in reason else 0
        status, reasons = sender.send(number, *rows, ahead=ahead), sender.reasons()
        if status != 204 or len(reasons) != number or reason not in reasons[-1]:
            raise SystemExit(f"FAILED: batch {number}: {status}, put aside: {reasons}")
    if sender.send(len(refused) + 1, samples(b"s1"), sender.value(b"p1", 1.0)) != 204 or case.count("rejected") != len(refused):
        raise SystemExit("FAILED: a batch of a known series is refused")
    [(count, last)] = case.query(f"SELECT put_aside, put_aside_reason FROM profivac.station WHERE station = '{case.stations[1].name}'")
    if int(count) != len(refused) or refused[-1][1] not in last:
        raise SystemExit(f"FAILED: the view shows {count} batches that are put aside, the last one because of: {last}")
    if "a batch of station-1 is put aside: a name of 8000 octets" not in case.archives[0].log.read_text():
        raise SystemExit("FAILED: the archive does not log the reason")

    def shown():
        with urllib.request.urlopen(f"http://127.0.0.1:{case.view_port}/api/archive", timeout=30) as answer:
            station = json.load(answer)["stations"]["station-1"]
        return station["put_aside"] == len(refused) and refused[-1][1] in station["put_aside_reason"]

    wait_for("the count and the last reason on the page", shown)
    # The other station and the views for Grafana go on.
    case.wait_for_more()
    if case.query("SELECT count(*) > 0 FROM profivac.span WHERE mean_pa > 0") is None:
        raise SystemExit("FAILED: the view of all spans has no answer")
    raise Done(f"{len(refused)} batches are put aside with the reason, and the other station goes on")


class Client:
    """Speaks the protocol of NATS."""

    def __init__(self, port):
        self.link = socket.create_connection(("127.0.0.1", port), 30)
        self.lines = self.link.makefile("rb")
        if not self.lines.readline().startswith(b"INFO "):
            raise SystemExit("FAILED: the server of NATS does not begin with INFO")
        login = json.dumps({"verbose": False, "pedantic": False, "headers": True})
        self.link.sendall(f"CONNECT {login}\r\nSUB answer 1\r\n".encode())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.lines.close()
        self.link.close()

    def answer(self):
        while (line := self.lines.readline()) and not line.startswith(b"MSG "):
            if line.startswith(b"PING"):
                self.link.sendall(b"PONG\r\n")
        return json.loads(self.lines.read(int(line.split()[-1]) + 2))

    def request(self, subject, body):
        """The answer to a request, which must not be an error."""
        payload = json.dumps(body).encode()
        self.link.sendall(f"PUB {subject} answer {len(payload)}\r\n".encode() + payload + b"\r\n")
        answer = self.answer()
        if "error" in answer:
            raise SystemExit(f"FAILED: {subject}: {answer['error']}")
        return answer


class Publisher(Client):
    """Publishes batches of a station of its own."""

    def __init__(self, port, station):
        super().__init__(port)
        self.station, self.now = station, time.time_ns() // 1000

    def publish(self, number):
        """The answer of the stream to a batch of about half a megabyte. The same number is the same batch."""
        noise = lambda: os.urandom(16_000).hex().encode()
        event = lambda row: field(5, field(1, 30 * number + row) + field(2, self.now) + field(4, b"note") + field(5, noise()))
        return self.put(number, deflated(field(1, 1) + field(2, self.now) + b"".join(event(row) for row in range(1, 31))))

    def put(self, number, payload):
        """The answer of the stream to these octets."""
        head = f"NATS/1.0\r\nProfivac-Batch: {self.station}/{self.now}/{number}\r\n\r\n".encode()
        command = f"HPUB profivac.v1.hall.{self.station}.batch answer {len(head)} {len(head) + len(payload)}\r\n"
        self.link.sendall(command.encode() + head + payload + b"\r\n")
        return self.answer()


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


def check_dashboard(case, station):
    """Every query of the dashboard for Grafana runs in the database, and the points have curves with their units."""
    dashboard = json.loads(Path(__file__).with_name("grafana.json").read_text())
    variables = {one["name"]: one["query"] for one in dashboard["templating"]["list"] if one["type"] == "query"}
    # As Grafana replaces them for a choice of all values; a quotation mark in a value is doubled.
    chosen, first, last = {}, "0", "4102444800"

    def filled(sql):
        sql = sql.replace("$__unixEpochTo()", last).replace("$__unixEpochFrom()", first)
        sql = re.sub(r"\$__timeFilter\((\w+)\)", rf"\1 BETWEEN to_timestamp({first}) AND to_timestamp({last})", sql)
        for name, values in chosen.items():
            sql = sql.replace(f"${name}", values)
        return sql

    def answered(sql):
        rows = case.query(sql)
        if rows is None:
            raise SystemExit(f"FAILED: the database refuses a query of the dashboard: {sql}")
        return rows

    for name, sql in variables.items():
        values = [row[0] for row in answered(filled(sql))]
        chosen[name] = ", ".join("'" + value.replace("'", "''") + "'" for value in values) or "''"
    rows = {}
    for panel in dashboard["panels"]:
        for target in panel["targets"]:
            # Spans of two minutes: the senders have sent no others.
            sql = re.sub(r"CASE WHEN \d+ - \d+ > .*? END", "2", filled(target["rawSql"]))
            rows[panel["title"]] = answered(sql)
    expected = {(f"{station} turbo.speed [Hz]", "3"), (f"{station} turbo.state", "3")}
    found = {tuple(row[1:]) for row in rows["Points of slaves"]}
    if found != expected:
        raise SystemExit(f"FAILED: the dashboard shows the points {found} in place of {expected}")


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
        (1, [sender.value(b"speed", -2.5, b"Hz"), sender.value(b"speed", 60.0, b"rpm"), sender.value(b"state", 3.0, kind=b"code", later=later),
             sender.point_span(b"speed", -2.0, 4.0, 4.0, b"Hz"), sender.point_span(b"state", 0.0, 3.0, 3.0, kind=b"code")]),
        (1, [sender.point_span(b"speed", -2.0, 8.0, 8.0, b"Hz"), sender.code_text(b"state", 3.0, b"closed"), sender.code_text(b"state", 0.0, b"open")]),
        (1, [sender.code_text(b"state", 3.0, b"shut")]),
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
        f"SELECT slave, point, unit, kind, value FROM profivac.point_sample WHERE station = '{name}' ORDER BY value":
            [["turbo", "speed", "Hz", "number", "-2.5"], ["turbo", "state", "", "code", "3"], ["turbo", "speed", "rpm", "number", "60"]],
        # The later batch replaces the text of its value, and the others stay.
        f"SELECT point, value, text FROM profivac.point_text WHERE station = '{name}' ORDER BY value":
            [["state", "0", "open"], ["state", "3", "shut"]],
        f"SELECT value, text FROM profivac.point_sample WHERE station = '{name}' AND kind = 'code'": [["3", "shut"]],
        # The later batch replaces the span, and a code has no mean.
        f"SELECT point, unit, min_value, max_value, mean_value, last_value, count FROM profivac.point_span WHERE station = '{name}' ORDER BY 1":
            [["speed", "Hz", "-2", "8", "3", "8", "2"], ["state", "", "0", "3", "\\N", "3", "2"]],
        f"SELECT text FROM profivac.event WHERE station = '{name}' AND kind = 'note' ORDER BY 1": [["event 1"], ["event 2"]],
        f"SELECT alarm FROM profivac.active_alarm WHERE station = '{name}' AND alarm LIKE 'pump%' ORDER BY 1": [["pump 1"], ["pump 2"]],
        f"SELECT user_name FROM profivac.audit WHERE station = '{name}'": [["ada"], ["ada"]],
    }
    for sql, rows in expected.items():
        found = case.query(sql)
        if found != rows:
            raise SystemExit(f"FAILED: {sql}: {found} in place of {rows}")
    check_dashboard(case, name)
    reasons = sender.reasons()
    if len(reasons) != 1 or "format 2" not in reasons[0]:
        raise SystemExit(f"FAILED: put aside: {reasons}")
    case.wait_for_more()
    raise Done("both versions are stored, the batch of a later format is put aside with the reason, and the other station goes on")


def metrics(case):
    """One archive counts; Prometheus reads its numbers."""
    archive, other = case.archives
    for process in case.archives:
        process.stop()
    file = case.folder / "archive-0.toml"
    file.write_text(file.read_text() + '\n[prometheus]\nlisten = "127.0.0.1:0"\n')
    before = {table: case.count(table) for table in ("batch", "sample", "event")}
    archive.start()

    def url():
        lines = [line for line in archive.log.read_text().splitlines() if line.startswith("metrics at ")]
        return lines and lines[-1].split()[-1]

    wait_for("the address of the metrics", url)

    def text():
        with urllib.request.urlopen(url(), timeout=30) as answer:
            return answer.read().decode()

    def value(sample):
        found = [line.rsplit(" ", 1)[1] for line in text().splitlines() if line.rsplit(" ", 1)[0] == sample]
        return float(found[0]) if found else None

    name = "profivac_archive_"
    wait_for("that the archive takes batches", lambda: value(f'{name}up{{transport="nats"}}') == 1)
    case.wait_for_more()
    counts = {"batch": f"{name}batches_total", "sample": f'{name}rows_total{{table="sample"}}', "event": f'{name}rows_total{{table="event"}}'}
    same = lambda: all(value(sample) == case.count(table) - before[table] for table, sample in counts.items())
    wait_for("the numbers of the database in the metrics", same)
    # Batches of a station of its own: one that comes again, one that is damaged, and three that do not come.
    with Publisher(case.lines[0].target, "counted") as publisher:
        publisher.publish(1)
        publisher.publish(1)
        wait_for("the batch that came again", lambda: value(f"{name}repeated_batches_total") == 1)
        publisher.publish(5)
        publisher.put(6, b"damaged")
    wait_for("the damaged batch", lambda: value(f'{name}rejected_batches_total{{station="counted",reason="damaged"}}') == 1)
    of_counted = '{plant="hall",station="counted"}'
    wait_for("the numbers that have not come", lambda: value(f"{name}station_missing_batches{of_counted}") == 3)
    if value(f"{name}station_rejected_batches{of_counted}") != 1 or abs(time.time() - value(f"{name}station_last_batch_timestamp_seconds{of_counted}")) > 300:
        raise SystemExit(f"FAILED: of the station counted: {text()}")
    for transaction in ("transaction_duration_seconds_count", "retention_next_timestamp_seconds", "retention_last_timestamp_seconds"):
        if not value(name + transaction):
            raise SystemExit(f"FAILED: {transaction} is {value(name + transaction)}")
    case.postgres.kill()
    wait_for("batches in the stream while PostgreSQL is down", lambda: value(f"{name}stream_batches"))
    oldest = value(f"{name}stream_oldest_batch_timestamp_seconds")
    if not oldest or abs(time.time() - oldest) > 300 or value(f'{name}up{{transport="nats"}}') != 0:
        raise SystemExit(f"FAILED: while PostgreSQL is down: {text()}")
    errors = [line for line in text().splitlines() if line.startswith(f"{name}database_errors_total")]
    if not errors:
        raise SystemExit("FAILED: no error of the database is counted")
    case.start_again(case.postgres)
    wait_for("an empty stream", lambda: value(f"{name}stream_batches") == 0)
    if shutil.which("promtool"):
        checked = subprocess.run(["promtool", "check", "metrics"], input=text(), text=True, capture_output=True)
        if checked.returncode != 0:
            raise SystemExit(f"FAILED: promtool: {checked.stdout}{checked.stderr}")
    other.start()
    raise Done(f"batches and rows are counted as in the database, and while PostgreSQL is down: {', '.join(errors)}")


def absent(case):
    """The comparison at the end has every sample, span and event of the time without [archive]."""
    station = case.stations[0]
    file = case.folder / f"{station.name}.toml"
    text = file.read_text()
    before = text.index("[archive]")
    after = text.index("[[segment]]", before)
    station.stop()
    file.write_text(text[:before] + text[after:])
    # A constant pressure is recorded at the start and at the end.
    for _ in range(2):
        recorded = case.recorded(station)
        station.start()
        wait_for("samples without an archive", lambda: case.recorded(station) > recorded)
        station.stop()
    meanwhile = case.recorded(station)
    stored = int(case.query(f"SELECT count(*) FROM profivac.sample WHERE station = '{station.name}'")[0][0])
    file.write_text(text)
    case.wait_for_more()
    wait_for("that everything is sent", lambda: case.record(station, "SELECT count(*) FROM station_state WHERE name = 'archive-absence'") == [(0,)])
    print(f"{stored} samples were stored, {meanwhile} recorded when [archive] was back")


def moved(case):
    """The statements of docs/archive-operation.md."""
    station = case.stations[0]
    station.stop()
    with Client(case.lines[0].target) as nats:
        waiting = lambda: nats.request("$JS.API.STREAM.INFO.PROFIVAC", {})["state"]["messages"]
        wait_for("an empty stream", lambda: waiting() == 0)
    sql = (f"BEGIN; UPDATE profivac_data.station SET name = 'moved', plant = 'ring' WHERE name = '{station.name}';"
           "UPDATE profivac_data.rejected SET station = 'moved', subject = 'profivac.v1.ring.moved.batch', "
           f"message_id = 'moved' || substring(message_id FROM '/.*') WHERE station = '{station.name}';"
           f"UPDATE profivac_data.put_aside SET station = 'moved' WHERE station = '{station.name}'; COMMIT")
    subprocess.run(["psql", "-X", "-q", "-v", "ON_ERROR_STOP=1", "-h", case.folder, "-p", str(case.postgres_port), "-U", case.user, "-d", "postgres", "-c", sql], check=True)
    written = case.write_station

    def write_station(name, number, gauges):
        written(name, number, gauges)
        if name == station.name:
            file = case.folder / f"{name}.toml"
            head, archive = file.read_text().split("[archive]", 1)
            archive = archive.replace('plant = "hall"', 'plant = "ring"', 1).replace(f'station = "{name}"', 'station = "moved"', 1)
            file.write_text(f"{head}[archive]{archive}")

    case.write_station = write_station
    case.write_station(station.name, 0, example["GAUGES"])
    case.wait_for_more()
    # A gap would be noted 40 s after a later batch.
    of_station = "JOIN profivac_data.station ON station.id = station WHERE name = 'moved'"
    last = int(case.query(f"SELECT max(number) FROM profivac_data.batch {of_station}")[0][0])
    wait_for("that the numbers are settled", lambda: int(case.query(f"SELECT min(settled) FROM profivac_data.epoch {of_station}")[0][0]) >= last)
    rows = case.query("SELECT station, plant, missing, put_aside FROM profivac.station ORDER BY 1")
    if rows != [["moved", "ring", "0", "0"], ["station-1", "ring", "0", "0"]]:
        raise SystemExit(f"FAILED: the stations are {rows}")
    # The other comparisons read the folder of the former name.
    original = case.query
    case.query = lambda sql: original(sql.replace(f"'{station.name}'", "'moved'"))


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
    "older": (restored, {"servers": 0}),
    "cleaned": (cleaned, {}),
    "backup": (backup, {"stations": 1}),
    "copied": (copied, {}),
    "retention": (retention, {}),
    "packed": (packed, {"servers": 0}),
    "tables": (tables, {"servers": 0}),
    "power": (power, {}),
    "crash": (crash, {}),
    "foreign": (foreign, {}),
    "secure": (secure, {"is_secure": True}),
    "readers": (readers, {}),
    "hostile": (hostile, {"servers": 0}),
    "versions": (versions, {"servers": 0}),
    "greedy": (greedy, {"stream": "200_000_000"}),
    "metrics": (metrics, {}),
    "absent": (absent, {}),
    "moved": (moved, {}),
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
