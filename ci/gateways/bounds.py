"""What a station holds while it runs, and what may not grow: memory, files, threads and the disk.

`soak.py` takes a row from time to time, and one at rest before its clients come and after they have gone.
"""

import json
import os
import time
import urllib.error
import urllib.request

MIB = 1 << 20
# The limits of a flight recorder (profivac-listen): docs/listening.md.
RECORDER_MIB, CAPTURES_MIB, CAPTURES = 32, 256, 20
# What the limits leave for caches, for the allocator, and for clients of which one comes before the other has gone.
FILES, THREADS, MEMORY_MIB, MEMORY_EACH_MIB = 10, 5, 24, 1
# The rows of a gauge in an hour, with events, alarms and a moment of each second around them; the part of the database without gauges.
DATABASE_HOURLY_MIB, DATABASE_MIB = 1, 8
# SQLite begins its log anew after 4 MiB, unless a read transaction is open meanwhile.
LOG_MIB = 32


class Recorders:
    """The memory that the flight recorders of all segments have taken, as the station reports it."""

    def __init__(self, url, segments):
        self.url, self.segments = url, segments

    def mib(self):
        return sum(fetched(f"{self.url}/api/segments/{name}/bus")["recorder_octets"] for name in self.segments) / MIB


def fetched(url):
    """The answer of the API, which bounds the requests of a user in a second (429): then again."""
    while True:
        try:
            with urllib.request.urlopen(url, timeout=60) as answer:
                return json.load(answer)
        except urllib.error.HTTPError as error:
            if error.code != 429:
                raise
            time.sleep(0.2)


class Row:
    """What the station holds at one moment."""

    def __init__(self, pid, folder, prometheus, recorders):
        with open(f"/proc/{pid}/status") as file:
            status = dict(line.split(":", 1) for line in file)
        self.at = time.monotonic()
        self.memory = int(status["VmRSS"].split()[0]) / 1024
        self.heap = int(status["RssAnon"].split()[0]) / 1024
        self.recorders = recorders.mib()
        self.threads = int(status["Threads"])
        links = list(open_files(pid))
        self.files = len(links)
        self.deleted = sum(link.endswith(" (deleted)") for link in links)
        self.capture_folders = [
            (name, len(files), size(path)) for name, path, files in folders(os.path.join(folder, "soak.captures"))]
        self.captures = sum(octets for _, _, octets in self.capture_folders) / MIB
        self.log = size(os.path.join(folder, "soak.db-wal")) / MIB
        self.disk = size(folder) / MIB - self.captures - self.log
        with urllib.request.urlopen(f"http://127.0.0.1:{prometheus}/metrics", timeout=60) as answer:
            lines = answer.read().decode().splitlines()
        self.cycles = total("profivac_segment_cycle_seconds_count{", lines)
        self.lost = total("profivac_device_lost_cycles_total{", lines)
        self.processor = processor_seconds(pid)

    def text(self, seconds):
        return (f"{seconds:5.0f} s  {self.memory:6.1f} MiB, heap {self.heap:6.1f}, recorders {self.recorders:6.1f}  {self.files:3} files  "
                f"{self.threads:2} threads  disk {self.disk:5.1f} MiB, log {self.log:4.1f}, captures {self.captures:6.1f}  "
                f"{self.cycles:.0f} cycles, {self.lost:.0f} lost")


def open_files(pid):
    for name in os.listdir(f"/proc/{pid}/fd"):
        try:
            yield os.readlink(f"/proc/{pid}/fd/{name}")
        except FileNotFoundError:
            pass  # closed meanwhile


def processor_seconds(pid):
    """User and system time of a process, in seconds."""
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def total(start, lines):
    return sum(float(line.rsplit(" ", 1)[1]) for line in lines if line.startswith(start))


def folders(path):
    """The folders in a folder: name, path, names of the files."""
    names = os.listdir(path) if os.path.isdir(path) else []
    return [(name, os.path.join(path, name), os.listdir(os.path.join(path, name))) for name in names]


def size(path):
    """The octets of a file, or of all files of a folder. A file that is deleted meanwhile has none."""
    paths = [os.path.join(folder, name) for folder, _, names in os.walk(path) for name in names] if os.path.isdir(path) else [path]
    octets = 0
    for path in paths:
        try:
            octets += os.path.getsize(path)
        except FileNotFoundError:
            pass
    return octets


def grown(rows, segments, gauges):
    """What passes its limit, as sentences. The first third of the rows is the warm-up; memory and disk count from its end, and for files and
    threads the most of the last third is compared with the most of the second."""
    third = max(1, len(rows) // 3)
    warm, middle, end, found = rows[third - 1], rows[third : 2 * third], rows[2 * third :], []
    last, hours = end[-1], (end[-1].at - warm.at) / 3600

    def limit(what, measured, allowed, unit="MiB"):
        print(f"{what}: {measured:.1f} {unit}, at most {allowed:.1f}", flush=True)
        if measured > allowed:
            found.append(f"{what}: expected at most {allowed:.1f} {unit}, found {measured:.1f}")

    limit("memory of the flight recorders", last.recorders, RECORDER_MIB * segments)
    recorders = last.recorders - warm.recorders
    limit("growth of the heap since the warm-up", last.heap - warm.heap, recorders + MEMORY_MIB + MEMORY_EACH_MIB * segments)
    limit("growth of the disk since the warm-up", last.disk - warm.disk, DATABASE_MIB + DATABASE_HOURLY_MIB * gauges * hours)
    limit("log of the database", max(row.log for row in rows), LOG_MIB)
    for name, room in [("files", FILES), ("threads", THREADS)]:
        limit(f"most {name} of the last third", *(max(getattr(row, name) for row in part) + more for part, more in [(end, 0), (middle, room)]), name)
    for name, count, octets in last.capture_folders:
        # One more while it is written.
        if count > CAPTURES + 1 or octets > CAPTURES_MIB * MIB:
            found.append(f"the segment {name} has {count} captures of {octets / MIB:.0f} MiB")
    return found
