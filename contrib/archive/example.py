#!/usr/bin/env python3
"""Stations with virtual gauges, three servers of NATS, PostgreSQL and two archives on one computer.

    contrib/archive/example.py target/debug/profivac                  until Ctrl-C; prints how to look at the page and the database
    contrib/archive/example.py target/debug/profivac --kills 200      the proof: kills processes at random, then compares every row
    contrib/archive/example.py target/debug/profivac --servers 0      without NATS: the stations send to the archives over HTTPS

It needs nats-server (unless --servers 0), openssl and PostgreSQL 15 or later. All files are in a temporary folder, all ports are free ones of this computer. As root it
runs PostgreSQL as the user postgres, which the Debian package has made.
"""

import argparse
import contextlib
import glob
import os
import random
import secrets
import select
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

BOUND = 240  # seconds; only a hang takes so long

SEGMENT = """
devices = ["bcg450@5", "psg550@6"]
pressure = "{pressure}"
"""

STATION = """
[station]
name = "{name}"
listen = "127.0.0.1:0"
database = "{name}/record.db"

[archive]
plant = "{plant}"
station = "{name}"
samples = "all"
requests = "acknowledge"

{transport}

[[segment]]
name = "line"
port = "sim:{name}-line.toml"
"""

TO_NATS = """[archive.nats]
servers = ["nats://127.0.0.1:{port}"]"""

TO_ARCHIVE = """[archive.https]
url = "https://localhost:{port}"
request-urls = [{urls}]
token-file = "{name}.token"
ca-file = "server.crt"
"""

GAUGES = """
[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"
poll = "50ms"

[[segment.gauge]]
name = "foreline"
address = 6
device = "psg550"
poll = "50ms"

[[alarm]]
name = "chamber too high"
gauge = "chamber"
above = "5e-3 mbar"
priority = "high"
"""

ARCHIVE = """
[archive]
replicas = {replicas}
samples-days = 30
stream-octets = 1_000_000_000

{source}

[postgres]
connection = "host={host} port={port} user={user} dbname=postgres {mode}"
"""

FROM_NATS = """[nats]
servers = [{servers}]"""

FROM_STATIONS = """[https]
listen = "127.0.0.1:{port}"

[https.tls]
certificate = "server.crt"
key = "server.key"
"""

SENDER = """
[[station]]
plant = "{plant}"
name = "{name}"
token-file = "{name}.token"
"""

# The first archive serves the page of all stations.
VIEW = """
[view]
listen = "127.0.0.1:{port}"
"""

# The first archive reaches PostgreSQL over its socket, the others with TLS.
TLS = "ca-file = \"server.crt\"\n"

NATS = """
server_name: n{number}
listen: 127.0.0.1:{port}
http: 127.0.0.1:{monitor}
jetstream {{ store_dir: "{folder}/nats-{number}" }}
cluster {{ name: example, listen: 127.0.0.1:{route}, routes: [{routes}] }}
"""


def pressure(number):
    """Of the line of a station. The first two have an alarm."""
    return f"{1 + number}e-2 mbar" if number < 2 else f"{1 + number % 7 / 2}e-3 mbar"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_for(what, condition):
    """Waits for a value that is true, and returns it."""
    end = time.monotonic() + BOUND
    while not (value := condition()):
        if time.monotonic() > end:
            raise SystemExit(f"FAILED: {what} did not happen within {BOUND} s")
        time.sleep(0.2)
    return value


class Process:
    """A program that is started again with the same arguments."""

    def __init__(self, name, arguments, folder):
        self.name, self.arguments, self.log = name, arguments, folder / f"{name}.log"
        self.process = self.held = None

    def start(self):
        if self.held is not None:
            os.close(self.held)
        # The program and those that it starts hold the other end of this pipe until the last of them has ended.
        self.held, end = os.pipe()
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(
                self.arguments, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True, pass_fds=[end])
        os.close(end)

    def is_running(self):
        return self.process is not None and self.process.poll() is None

    def kill(self):
        if self.is_running():
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        # A process of PostgreSQL may write a file after the first one of them has ended.
        assert select.select([self.held], [], [], BOUND)[0], f"a process of {self.name} has not ended after SIGKILL"

    def stop(self):
        if self.is_running():
            self.process.terminate()
        self.process.wait(BOUND)


class Line:
    """A network between the stations and a server, which can be cut."""

    def __init__(self, target):
        self.target, self.is_cut, self.sockets = target, False, set()
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        while True:
            near, _ = self.listener.accept()
            try:
                if self.is_cut:
                    raise OSError
                far = socket.create_connection(("127.0.0.1", self.target), 5)
            except OSError:
                near.close()
                continue
            self.sockets |= {near, far}
            for source, sink in ((near, far), (far, near)):
                threading.Thread(target=self.copy, args=(source, sink), daemon=True).start()

    def copy(self, source, sink):
        with contextlib.suppress(OSError):
            while octets := source.recv(65536):
                sink.sendall(octets)
        for end in (source, sink):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            self.sockets.discard(end)

    def cut(self):
        self.is_cut = True
        for end in list(self.sockets):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)


class Example:
    def __init__(self, program, stations, archives, servers, folder):
        self.folder, self.program = folder, program
        self.user = "postgres" if os.geteuid() == 0 else os.environ.get("USER", "postgres")
        self.postgres_port = free_port()
        self.postgres = self.make_postgres()
        self.has_nats = servers > 0
        self.servers, ports = self.make_servers(servers)
        if self.has_nats:
            urls = ", ".join(f'"nats://127.0.0.1:{port}"' for port in ports)
            sources = [FROM_NATS.format(servers=urls)] * archives
        else:
            ports = self.archive_ports = [free_port() for _ in range(archives)]
            sources = [FROM_STATIONS.format(port=port) for port in ports]
        self.lines = [Line(port) for port in ports]
        senders = "" if self.has_nats else "".join(self.make_sender(number) for number in range(stations))
        self.archives = [self.make_archive(number, max(servers, 1), source, senders) for number, source in enumerate(sources)]
        self.stations = [self.make_station(number) for number in range(stations)]

    def make_sender(self, number):
        name = f"station-{number}"
        token = self.folder / f"{name}.token"
        token.touch(0o600)
        token.write_text(secrets.token_hex(32))
        return SENDER.format(name=name, plant=self.plant(number))

    def plant(self, number):
        return "hall" if number % 2 == 0 else "ring"

    def make_archive(self, number, replicas, source, senders):
        host, mode, tls = ("localhost", "sslmode=require", TLS) if number else (self.folder, "", "")
        file = self.folder / f"archive-{number}.toml"
        view = ""
        if number == 0:
            self.view_port = free_port()
            view = VIEW.format(port=self.view_port)
        file.write_text(ARCHIVE.format(
            replicas=replicas, source=source, host=host, mode=mode, port=self.postgres_port, user=self.user) + tls + senders + view)
        return Process(f"archive-{number}", [self.program, "archive", file], self.folder)

    def make_certificate(self, data):
        made = subprocess.run(
            ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj", "/CN=localhost",
             "-addext", "subjectAltName=DNS:localhost", "-addext", "basicConstraints=critical,CA:FALSE",
             "-keyout", data / "server.key", "-out", data / "server.crt"], capture_output=True, text=True)
        if made.returncode != 0:
            raise SystemExit(f"FAILED: openssl: {made.stderr}")
        for name in ("server.key", "server.crt"):
            shutil.copy(data / name, self.folder / name)
        (self.folder / "server.key").chmod(0o600)
        for name in ("server.key", "server.crt"):
            (data / name).chmod(0o600)
            if os.geteuid() == 0:
                shutil.chown(data / name, "postgres")

    def make_postgres(self):
        data = self.folder / "postgres"
        data.mkdir(exist_ok=True)
        if os.geteuid() == 0:
            shutil.chown(data, "postgres")
            self.folder.chmod(0o777)
        found = sorted(glob.glob("/usr/lib/postgresql/*/bin")) + [""]
        self.bin = Path(found[-2]) if len(found) > 1 else Path(shutil.which("initdb")).parent
        self.as_user = ["runuser", "-u", "postgres", "--"] if os.geteuid() == 0 else []
        made = subprocess.run([*self.as_user, self.bin / "initdb", "-D", data, "-A", "trust", "-U", self.user],
                              capture_output=True, text=True)
        if made.returncode != 0:
            raise SystemExit(f"FAILED: initdb: {made.stderr}")
        self.make_certificate(data)
        arguments = [*self.as_user, self.bin / "postgres", "-D", data, "-k", self.folder, "-p", str(self.postgres_port), "-h", "localhost",
                     "-c", "ssl=on"]
        return Process("postgres-server", arguments, self.folder)

    def make_servers(self, count):
        program = shutil.which("nats-server") or "/usr/sbin/nats-server"
        ports, routes, self.monitors = [[free_port() for _ in range(count)] for _ in range(3)]
        servers = []
        for number in range(count):
            urls = ", ".join(f'"nats-route://127.0.0.1:{route}"' for route in routes) if count > 1 else ""
            text = NATS.format(number=number, port=ports[number], monitor=self.monitors[number], folder=self.folder, route=routes[number], routes=urls)
            if count == 1:
                text = "\n".join(line for line in text.splitlines() if not line.startswith("cluster"))
            (self.folder / f"nats-{number}.conf").write_text(text)
            servers.append(Process(f"nats-server-{number}", [program, "-c", self.folder / f"nats-{number}.conf"], self.folder))
        return servers, ports

    def make_station(self, number):
        name = f"station-{number}"
        (self.folder / f"{name}-line.toml").write_text(SEGMENT.format(pressure=pressure(number)))
        (self.folder / name).mkdir(exist_ok=True)
        self.write_station(name, number, GAUGES)
        station = Process(name, [self.program, "run", self.folder / f"{name}.toml"], self.folder)
        station.record = "record.db"
        return station

    def write_station(self, name, number, gauges):
        port = self.lines[number % len(self.lines)].port
        # Users of each archive may ask the station.
        urls = ", ".join(f'"https://localhost:{line.port}"' for line in self.lines)
        transport = (TO_NATS if self.has_nats else TO_ARCHIVE).format(name=name, port=port, urls=urls)
        text = STATION.format(name=name, plant=self.plant(number), transport=transport)
        (self.folder / f"{name}.toml").write_text(text + gauges)
        (self.folder / f"{name}.toml").chmod(0o600)

    def all(self):
        return [self.postgres, *self.servers, *self.archives, *self.stations]

    def start(self):
        for process in self.all():
            process.start()

    def query(self, sql):
        """The rows of a query, as lists of texts; None while the database does not answer."""
        done = subprocess.run(["psql", "-X", "-q", "-h", self.folder, "-p", str(self.postgres_port), "-U", self.user, "-d", "postgres",
                               "-c", f"COPY ({sql}) TO STDOUT"], capture_output=True, text=True)
        if done.returncode != 0:
            return None
        return [line.split("\t") for line in done.stdout.splitlines()]

    def count(self, table):
        rows = self.query(f"SELECT count(*) FROM profivac_data.{table}")
        return int(rows[0][0]) if rows else 0

    def has_samples(self):
        for process in self.all():
            if not process.is_running():
                raise SystemExit(f"FAILED: {process.name} has ended")
        return self.count("sample") > 0

    def has_tls(self):
        rows = self.query("SELECT count(*) FROM pg_stat_ssl JOIN pg_stat_activity USING (pid) WHERE ssl AND application_name = 'profivac archive'")
        return len(self.archives) < 2 or rows != [["0"]]

    def record(self, station, sql):
        with contextlib.closing(sqlite3.connect(f"file:{self.folder}/{station.name}/{station.record}?mode=ro", uri=True, timeout=30)) as record:
            return record.execute(sql).fetchall()

    # The proof.

    def disturb(self, kills, pause):
        """Kills processes and cuts lines at random."""
        for number in range(kills):
            kind = random.choice(["station", "archive", "postgres", "line"] + ["server"] * self.has_nats)
            if kind == "line":
                line = random.choice(self.lines)
                line.cut()
                time.sleep(random.uniform(0, 2) * pause)
                line.is_cut = False
            else:
                chosen = {"station": self.stations, "archive": self.archives, "server": self.servers, "postgres": [self.postgres]}
                process = random.choice(chosen[kind])
                process.kill()
                time.sleep(random.uniform(0, 1) * pause)
                self.start_again(process)
            time.sleep(random.uniform(0.2, 1.5) * pause)
            if (number + 1) % 10 == 0:
                print(f"{number + 1} disturbances, {self.count('sample')} samples", flush=True)

    def start_again(self, process):
        process.start()
        if process is not self.postgres:
            return

        # The server does not start before the last process of its predecessor has ended.
        def is_answering():
            if not process.is_running():
                process.start()
            return self.query("SELECT 1") is not None

        wait_for("an answer of PostgreSQL", is_answering)

    def drain(self):
        """Lets the stations send what is in their records, without recording more samples."""
        for process in self.all():
            if process not in self.stations and not process.is_running():
                self.start_again(process)
        for number, station in enumerate(self.stations):
            if not station.is_running():
                station.start()
            station.stop()
            self.write_station(station.name, number, "")
            station.start()
        for station in self.stations:
            wait_for(f"that {station.name} has sent its record", lambda: self.has_all(station))
            station.stop()

    def has_all(self, station):
        [(waiting, last)] = self.record(station, "SELECT (SELECT count(*) FROM outbox), (SELECT seq FROM sqlite_sequence WHERE name = 'outbox')")
        rows = self.query("SELECT count(*), max(number) FROM profivac_data.batch JOIN profivac_data.station ON station.id = station "
                          f"WHERE name = '{station.name}'")
        return waiting == 0 and bool(rows) and rows[0] == [str(last), str(last)]

    def compare(self):
        """Compares every sample, span and event. Returns the number of samples."""
        total = 0
        for station in self.stations:
            total += self.compare_samples(station)
            self.compare_events(station)
            self.compare_spans(station)
        for table in ("rejected",):
            if rows := self.query(f"SELECT reason FROM profivac_data.{table}"):
                raise SystemExit(f"FAILED: put aside: {rows[0][0]}")
        return total

    def compare_samples(self, station):
        ours = {(name, at, pressure, quality) for name, at, pressure, quality in self.record(
            station, "SELECT name, at_us, pressure_pa, quality FROM sample JOIN series ON series.id = series_id")}
        rows = self.query("SELECT series, (extract(epoch FROM at) * 1000000)::bigint, pressure_pa, quality "
                          f"FROM profivac.sample WHERE station = '{station.name}'")
        theirs = {(name, int(at), None if pressure == "\\N" else float(pressure), int(quality)) for name, at, pressure, quality in rows}
        self.same(station, "samples", ours, theirs)
        if len(rows) != len(theirs):
            raise SystemExit(f"FAILED: {station.name}: {len(rows) - len(theirs)} samples are stored twice")
        return len(ours)

    def compare_events(self, station):
        rows = self.query(f"SELECT id, text FROM profivac.event WHERE station = '{station.name}'")
        theirs = {(int(key), text) for key, text in rows}
        last = max(key for key, _ in theirs)
        # The last event says that the station stops: it is sent at the next start.
        ours = set(self.record(station, f"SELECT id, text FROM event WHERE id <= {last}"))
        self.same(station, "events", ours, theirs)

    def compare_spans(self, station):
        ours, theirs = self.spans(station)
        if ours != theirs:
            # A span that ends while the station stops is in its last batch, which is sent at the next start.
            station.start()
            wait_for(f"that {station.name} has sent its last batch", lambda: self.has_all(station))
            station.stop()
            ours, theirs = self.spans(station)
        self.same(station, "spans", ours, theirs)

    def spans(self, station):
        """The spans of the record and those of the archive, without those that are sent later."""
        sql = "SELECT name, level, start_us, min_pa, max_pa, count, qualities FROM span JOIN series ON series.id = series_id WHERE level > 1"
        all_of_record = set(self.record(station, sql))
        changed = set(self.record(station, "SELECT name, level, start_us FROM outbox_span JOIN series ON series.id = series_id"))
        rows = self.query("SELECT series, level, (extract(epoch FROM start) * 1000000)::bigint, min_pa, max_pa, count, qualities "
                          f"FROM profivac.span WHERE station = '{station.name}'")
        pressure = lambda text: None if text == "\\N" else float(text)
        theirs = {(row[0], int(row[1]), int(row[2]), pressure(row[3]), pressure(row[4]), int(row[5]), int(row[6])) for row in rows}
        # A span that has not ended, or has changed, is sent later.
        is_settled = lambda row: row[:3] not in changed
        return set(filter(is_settled, all_of_record)), set(filter(is_settled, theirs))

    def same(self, station, what, ours, theirs):
        if ours != theirs:
            raise SystemExit(f"FAILED: {station.name}: {len(ours - theirs)} {what} of the record are not in the archive, like "
                             f"{sorted(ours - theirs, key=str)[:2]}; {len(theirs - ours)} of the archive not in the record, like "
                             f"{sorted(theirs - ours, key=str)[:2]}")

    def close(self):
        for process in reversed(self.all()):
            if process.process is not None:
                process.kill()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda path: Path(path).resolve())
    parser.add_argument("--stations", type=int, default=10)
    parser.add_argument("--archives", type=int, default=2)
    parser.add_argument("--servers", type=int, choices=[0, 1, 3], default=3, help="of NATS; 0: over HTTPS")
    parser.add_argument("--kills", type=int, help="disturb that often, then compare and end")
    parser.add_argument("--pause", type=float, default=1.0, help="the length of the pauses between disturbances, as a factor")
    parser.add_argument("--seed", type=int, default=random.randrange(1 << 30))
    arguments = parser.parse_args()
    random.seed(arguments.seed)
    # SIGTERM ends the processes too.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("FAILED: ended by SIGTERM"))
    with tempfile.TemporaryDirectory(prefix="profivac-archive-") as folder:
        example = Example(arguments.program, arguments.stations, arguments.archives, arguments.servers, Path(folder))
        try:
            example.start()
            wait_for("a stored sample", example.has_samples)
            wait_for("an archive with TLS", example.has_tls)
            print(f"http://127.0.0.1:{example.view_port}     # the page of all stations", flush=True)
            print(f"psql -h {folder} -p {example.postgres_port} -U {example.user} postgres     # views are in the schema profivac", flush=True)
            if arguments.kills is None:
                signal.pause()
            print(f"seed {arguments.seed}", flush=True)
            begun = time.monotonic()
            example.disturb(arguments.kills, arguments.pause)
            example.drain()
            samples = example.compare()
            print(f"ok: {samples} samples of {len(example.stations)} stations are the same in the records and in PostgreSQL after "
                  f"{arguments.kills} disturbances in {time.monotonic() - begun:.0f} s")
        except SystemExit:
            for process in example.all():
                if process.log.exists():
                    print(f"--- {process.log.name}\n" + "\n".join(process.log.read_text(errors='replace').splitlines()[-12:]), file=sys.stderr)
            raise
        except KeyboardInterrupt:
            pass
        finally:
            example.close()


if __name__ == "__main__":
    main()
