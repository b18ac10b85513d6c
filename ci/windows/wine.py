#!/usr/bin/env python3
"""Runs the program for Windows under Wine: its commands, its dashboard, and its station with kills.

    ci/windows/wine.py PROFIVAC_EXE PROFIVAC

PROFIVAC is the program for this computer: its answers are compared with those of the one for Windows. Prints a line for each operation; the
exit code is 1 if one fails. Nothing here ran on Windows itself: Wine has no serial port with parity here, and its access lists are those of
the files of Linux.
"""

import contextlib
import json
import os
import pathlib
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time
import urllib.request

PATIENCE = 120
COMPILER = "x86_64-w64-mingw32-gcc"


class Wine:
    """A folder of Windows with the program in it."""

    def __init__(self, folder: pathlib.Path, program: str):
        self.folder = folder
        self.prefix = folder / "prefix"
        self.program = folder / "profivac.exe"
        shutil.copy(program, self.program)
        source = pathlib.Path(__file__).with_name("prng.c")
        library = folder / "bcryptprimitives.dll"
        subprocess.run([COMPILER, "-shared", "-O2", "-o", library, source, "-ladvapi32"], check=True)
        self.environment = os.environ | {"WINEPREFIX": str(self.prefix), "WINEDEBUG": "-all"}
        self.environment.pop("DISPLAY", None)
        subprocess.run(["wine", "wineboot", "-i"], env=self.environment, check=True, capture_output=True, timeout=PATIENCE)

    def close(self) -> None:
        subprocess.run(["wineserver", "-k"], env=self.environment, check=False, capture_output=True)

    def run(self, *arguments: str, code: int = 0, stdin: str = "") -> str:
        """The output of a command that ends with this exit code."""
        command = ["wine", str(self.program), *arguments]
        ended = subprocess.run(
            command, cwd=self.folder, env=self.environment, input=stdin, capture_output=True, text=True, timeout=PATIENCE
        )
        output = ended.stdout.replace("\r\n", "\n")
        if ended.returncode != code:
            raise AssertionError(f"{arguments}: exit code {ended.returncode}, not {code}\n{output}{ended.stderr}")
        return output + ended.stderr.replace("\r\n", "\n") if code else output

    def start(self, *arguments: str) -> subprocess.Popen:
        """A command that goes on, and has printed a line."""
        command = ["wine", str(self.program), *arguments]
        program = subprocess.Popen(
            command, cwd=self.folder, env=self.environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.first_line(program, "ready")
        return program

    @staticmethod
    def first_line(program: subprocess.Popen, begins: str) -> str:
        for line in program.stdout:
            if line.startswith(begins):
                return line.strip()
        raise AssertionError(f"{program.args}: ended without a line that begins with {begins!r}")


def expect(condition: bool, text: object) -> None:
    if not condition:
        raise AssertionError(text)


def end(program: subprocess.Popen) -> None:
    program.kill()
    program.wait(PATIENCE)


def help_and_lists(wine: Wine, _native: str) -> None:
    expect("Usage: profivac" in wine.run("--help"), "help")
    expect("bcg450" in wine.run("device", "list"), "list of devices")
    expect("expected" in wine.run("read", "--port", "COM77", "--address", "300", "x", code=2), "a wrong address")
    missing = wine.run("scan", "--port", "COM77", code=3)
    expect("there is no port COM77" in missing and "profivac doctor" in missing, missing)
    refused = wine.run("simulate", "--pty", "line", "bcg450@5", code=3)
    expect("Windows has none" in refused and "--tcp" in refused, refused)


def demonstration(wine: Wine, _native: str) -> None:
    rows = wine.run("demo", "--headless", "--for", "20s")
    expect(rows.count("\n") > 10 and "bcg450@5" in rows, rows)


@contextlib.contextmanager
def line(wine: Wine, *devices: str):
    """The port of a simulated line over TCP."""
    command = ["wine", str(wine.program), "simulate", "--tcp", "127.0.0.1:0", *devices]
    program = subprocess.Popen(
        command, cwd=wine.folder, env=wine.environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        yield "tcp://" + wine.first_line(program, "ready ").split()[1]
    finally:
        end(program)


def commands(wine: Wine, _native: str) -> None:
    with line(wine, "bcg450@5", "pcg550@7") as port:
        at = ["--port", port, "--slot-time=4000", "--address", "5"]
        found = wine.run("scan", "--port", port, "--hsa", "10")
        expect("bcg450" in found and "pcg550" in found, found)
        serial = wine.run("read", *at, "device.serial-number")
        expect(serial.startswith("device.serial-number = "), serial)
        wine.run("write", *at, "execute")
        wine.run("dump", *at, "--out", "gauge 5.toml")
        expect((wine.folder / "gauge 5.toml").stat().st_size > 1000, "a name with a blank")
        wine.run("restore", *at, "gauge 5.toml")
        rows = wine.run("monitor", "--port", port, "--own", "--json", "--for", "3s", "5").splitlines()
        expect(any(json.loads(row)["quality"] == "valid" for row in rows), rows)
        conform = wine.run("conform", "--port", port, "--address", "7", "--own", "--slot-time=4000")
        expect(conform.count("\nok ") > 100 and "\nfailed" not in conform, conform)


def files(wine: Wine, native: str) -> None:
    log = "TX 10 08 02 49 53 16\r\nRX 68 05 05 68 88 82 6D 3C 3E F1 16\r\n"
    (wine.folder / "log.txt").write_bytes(log.encode())
    own = subprocess.run([native, "decode", wine.folder / "log.txt"], capture_output=True, text=True).stdout
    expect(wine.run("decode", "log.txt") == own and "telegrams" in own, "decode")
    for arguments in (["gsd", "bcg450"], ["st", "bcg450"]):
        own = subprocess.run([native, *arguments], capture_output=True, text=True, check=True, cwd=wine.folder).stdout
        expect(wine.run(*arguments) == own and own, arguments)


def station(wine: Wine, _native: str) -> None:
    """A station is killed and started again: every sample that it has stored is there, and new ones follow."""
    with line(wine, "bcg450@5") as port:
        (wine.folder / "plant.toml").write_text(
            '[station]\nname = "Plant"\nlisten = "127.0.0.1:0"\ndatabase = "plant.db"\n[[segment]]\nname = "hall"\n'
            f'port = "{port}"\n[[segment.gauge]]\nname = "chamber"\naddress = 5\ndevice = "bcg450"\n'
        )
        wine.run("run", "plant.toml", "--check")
        counts = [0]
        for _ in range(3):
            program = wine.start("run", "plant.toml")
            until = time.monotonic() + PATIENCE
            while time.monotonic() < until and stored(wine) <= counts[-1]:
                time.sleep(0.5)
            counts.append(stored(wine))
            expect(program.poll() is None, "the station has ended")
            end(program)
            expect(counts[-1] > counts[-2], f"no new sample after {counts}")
            expect(stored(wine) >= counts[-1], "a sample that was stored is gone")
        doctor = wine.run("doctor", "plant.db")
        expect("the database is not damaged" in doctor, doctor)


def stored(wine: Wine) -> int:
    """The number of samples in the database."""
    database = wine.folder / "plant.db"
    if not database.exists():
        return 0
    with contextlib.closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True)) as connection:
        try:
            return connection.execute("SELECT count(*) FROM sample").fetchone()[0]
        except sqlite3.OperationalError:
            return 0


def com_port(wine: Wine, native: str) -> None:
    """A COM port that is a pty is refused with words, because a pty has no parity bit."""
    link = wine.folder / "line"
    program = subprocess.Popen([native, "simulate", "--pty", link, "bcg450@5"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        wine.first_line(program, "ready")
        (wine.prefix / "dosdevices" / "com5").symlink_to(os.readlink(link))
        refused = wine.run("scan", "--port", "COM5", "--hsa", "10", code=3)
        expect("COM5 cannot send 8 data bits with even parity" in refused and "set 8N1 instead" in refused, refused)
    finally:
        end(program)


def dashboard(wine: Wine, _native: str) -> None:
    """The demonstration serves its pages."""
    program = subprocess.Popen(
        ["wine", str(wine.program), "demo", "--listen", "127.0.0.1:47812", "--for", "60s"],
        cwd=wine.folder, env=wine.environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )
    try:
        until = time.monotonic() + PATIENCE
        page = b""
        while time.monotonic() < until and b"<title>" not in page:
            with contextlib.suppress(OSError):
                page = urllib.request.urlopen("http://127.0.0.1:47812/", timeout=10).read()
            time.sleep(0.5)
        expect(b"<title>" in page, page[:200])
        with urllib.request.urlopen("http://127.0.0.1:47812/api/live", timeout=PATIENCE) as live:
            first = [live.readline() for _ in range(3)]
        expect(any(line.startswith(b"data:") for line in first), first)
    finally:
        end(program)


STEPS = {
    "help, errors and exit codes": help_and_lists,
    "decode, gsd, st as on this computer": files,
    "demo --headless --for 20s": demonstration,
    "simulate --tcp with scan, read, write, dump, restore, monitor, conform": commands,
    "demo with its dashboard": dashboard,
    "run, killed and started again": station,
    "a COM port without parity is refused": com_port,
}


def main() -> None:
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    program, native, *names = sys.argv[1:]
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        wine = Wine(pathlib.Path(folder), program)
        try:
            for name, step in STEPS.items():
                if names and not any(part in name for part in names):
                    continue
                try:
                    step(wine, os.path.abspath(native))
                    print(f"ok: {name}", flush=True)
                except (AssertionError, subprocess.TimeoutExpired) as error:
                    failed += 1
                    print(f"FAILED: {name}: {error}", flush=True)
        finally:
            wine.close()
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
