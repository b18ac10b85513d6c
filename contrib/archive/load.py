#!/usr/bin/env python3
"""How many samples an archive stores: contrib/archive/load.py PROGRAM LOAD [--stations 1000 --gauges 30 --samples 1 --seconds 60 --archives 2 --waiting]

Starts NATS, PostgreSQL and archives on this computer, publishes the batches of simulated stations with LOAD (the example `load` of
crates/archive, built with --release), and prints the rates at which they were published and stored, and the processor time of each
program. The archives run while the batches are published: a station may have a share of the stream only, 256 batches. With --waiting they start
when all batches wait in the stream. Then every row is counted, and psql copies the same rows in binary into a table like that of a day, with its key:
the ratio of both rates. A rate below --at-least samples a second, or below --ratio of that of psql, is a failure.
"""

import argparse
import os
import runpy
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

example = runpy.run_path(str(Path(__file__).with_name("example.py")))


def processor_seconds(process):
    """Of a process and all below it that still run."""
    parents, seconds, tick = {}, {}, os.sysconf("SC_CLK_TCK")
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            fields = (folder / "stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        parents[int(folder.name)] = int(fields[1])
        seconds[int(folder.name)] = (int(fields[11]) + int(fields[12])) / tick

    def is_below(number):
        while number and number != process.process.pid:
            number = parents.get(number)
        return bool(number)

    return sum(value for number, value in seconds.items() if is_below(number))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda path: Path(path).resolve())
    parser.add_argument("load", type=lambda path: Path(path).resolve())
    for name, default in (("stations", 1000), ("gauges", 30), ("samples", 1), ("seconds", 60), ("archives", 2), ("servers", 1)):
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--at-least", type=float, default=0)
    parser.add_argument("--ratio", type=float, default=0)
    parser.add_argument("--waiting", action="store_true")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("FAILED: ended by SIGTERM"))
    with tempfile.TemporaryDirectory(prefix="profivac-load-") as folder:
        run = example["Example"](arguments.program, 0, arguments.archives, arguments.servers, Path(folder))
        try:
            measure(run, arguments)
        finally:
            run.close()


def measure(run, arguments):
    run.start()
    wait_for = example["wait_for"]
    wait_for("an archive that is ready", lambda: any("ready" in archive.log.read_text() for archive in run.archives))
    server = run.servers[0]
    config = (run.folder / "nats-0.conf").read_text()
    url = "nats://" + config.split("listen: ")[1].split()[0]
    numbers = [str(value) for value in (arguments.stations, arguments.gauges, arguments.samples, arguments.seconds)]
    begun = time.monotonic()
    if arguments.waiting:
        for archive in run.archives:
            archive.stop()
    load = subprocess.Popen([arguments.load, url, *numbers])
    expected = arguments.stations * arguments.seconds
    last = 0
    before, first = {}, 0
    if arguments.waiting:
        load.wait()
        for archive in run.archives:
            archive.start()
        # The first batches of stations make their series, once for all years.
        wait_for("all series", lambda: run.count("series") == arguments.stations * arguments.gauges)
        wait_for("their batches", lambda: run.count("batch"))
        before = {process: processor_seconds(process) for process in (run.postgres, server, *run.archives)}
        first, begun = run.count("batch"), time.monotonic()
    while (stored := run.count("batch")) < expected:
        for process in (run.postgres, server, *run.archives):
            if not process.is_running():
                raise SystemExit(f"FAILED: {process.name} has ended")
        if load.poll() not in (None, 0):
            raise SystemExit("FAILED: the batches were not published")
        if stored - last >= expected // 10:
            last = stored
            print(f"{time.monotonic() - begun:.0f} s: {stored} of {expected} batches", flush=True)
        time.sleep(0.1)
    took = time.monotonic() - begun
    samples, wanted = run.count("sample"), expected * arguments.gauges * arguments.samples
    if samples != wanted or run.count("rejected") != 0:
        raise SystemExit(f"FAILED: {samples} samples of {wanted}, {run.count('rejected')} batches put aside")
    counted = samples - first * arguments.gauges * arguments.samples
    rate = counted / took
    print(f"ok: {counted} samples in {took:.1f} s, {rate:.0f} samples/s, {(expected - first) / took:.0f} batches/s")
    if rate < arguments.at_least:
        raise SystemExit(f"FAILED: less than {arguments.at_least:.0f} samples/s")
    size = int(run.query("SELECT pg_database_size('postgres')")[0][0])
    print(f"database {size / 1e6:.0f} MB, {size / samples:.0f} octets for each sample with its share of all else")
    tables = "SELECT sum(pg_total_relation_size(inhrelid)) FROM pg_inherits WHERE inhparent = 'profivac_data.sample'::regclass"
    print(f"{int(run.query(tables)[0][0]) / samples:.1f} octets for the row of a sample and its share of the key")
    used = lambda process: processor_seconds(process) - before.get(process, 0)
    shares = {"PostgreSQL": used(run.postgres), "NATS": used(server), "archives": sum(map(used, run.archives))}
    print(", ".join(f"{name} {seconds:.1f} s of a core" for name, seconds in shares.items()))
    print(f"{sum(shares.values()) / counted * 1e6:.1f} µs of a core for each sample")
    copied = copy_rate(run, samples)
    ratio = rate / copied
    print(f"psql copies {copied:.0f} samples/s: the archives store {ratio:.2f} of that")
    if ratio < arguments.ratio:
        raise SystemExit(f"FAILED: less than {arguments.ratio}")


def copy_rate(run, samples):
    """The samples that psql copies in a second from a file into a table like that of a day."""
    psql = ["psql", "-X", "-q", "-v", "ON_ERROR_STOP=1", "-h", run.folder, "-p", str(run.postgres_port), "-U", run.user, "-d", "postgres", "-c"]
    tell = lambda sql: subprocess.run([*psql, sql], check=True)
    for archive in run.archives:
        archive.stop()
    file = run.folder / "samples"
    columns = "series, at, pressure_pa, quality"
    tell(f"\\copy (SELECT {columns} FROM profivac_data.sample) TO '{file}' BINARY")
    tell("CREATE TABLE copied (LIKE profivac_data.sample INCLUDING ALL, PRIMARY KEY (series, at)); CHECKPOINT")
    begun = time.monotonic()
    tell(f"\\copy copied ({columns}) FROM '{file}' BINARY")
    return samples / (time.monotonic() - begun)


if __name__ == "__main__":
    main()
