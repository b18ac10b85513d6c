#!/usr/bin/env python3
"""The example of docs/plc-example.md with awlsim, a soft PLC for S7 STL, and pyprofibus, its PROFIBUS master: ci/plc/example.py PROGRAM

Both are GPL: awlsim runs in a process of its own and is linked to nothing. This program reads its CPU dump, in which the PLC program
shows what it has seen, and compares that with the simulated gauge, and with `sniff` and a listen-only station on the same line. The four families of
gauges run at the same time, each on its own line.
"""

import concurrent.futures
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import threading
import urllib.request

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
EXAMPLE = os.path.join(ROOT, "contrib", "plc")
PAGE = os.path.join(ROOT, "docs", "plc-example.md")
REQUIREMENTS = os.path.join(ROOT, "ci", "requirements.txt")
AWLSIM = os.path.join(os.path.dirname(sys.executable), "awlsim-test")
# A deadline that only ends a test that hangs.
HANG_S = 120
EXECUTING, MBAR = 4, 1
SAFE_VALUE = 0x3FC00000
# Device: the value of the read, the value of the write, the user parameters that awlsim sends. It sets Fail_Safe and Check_Cfg_Mode
# for every DP-V1 slave; the TPG500 has no DP-V1.
FAMILIES = {
    "bcg450": (EXECUTING, SAFE_VALUE, "user C0 01 00 05 1C (unit mbar)"),
    "pcg550": (EXECUTING, SAFE_VALUE, "user C0 01 00 13 08 (unit mbar)"),
    "img400": (EXECUTING, SAFE_VALUE, "user C0 01 00 13 08 (unit hPa)"),
    "tpg500": (MBAR, 1, "ident 05D9, groups 01"),
}
STATION = """
[[segment]]
name = "line"
port = "{folder}/station"
baud = 19200
listen-only = true

[[segment.gauge]]
name = "gauge"
address = 5
device = "{device}"
"""
ANSI = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
FLAGS = re.compile(r" +M: +((?:[0-9A-F]{2} ){16})")


class Process:
    """A program whose output is read while it runs."""

    def __init__(self, folder, *command):
        self.lines, self.ended, self.change = [], False, threading.Condition()
        self.process = subprocess.Popen(
            command, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            with self.change:
                self.keep(ANSI.sub("", line.rstrip()))
                self.change.notify_all()
        with self.change:
            self.ended = True
            self.change.notify_all()

    def keep(self, line):
        self.lines.append(line)

    def wait_for(self, what, condition):
        """Waits until `condition(self)` is true; it is looked at after each line of output."""
        seen = []

        def is_over():
            seen.append(condition(self))
            return seen[-1] or self.ended

        with self.change:
            self.change.wait_for(is_over, HANG_S)
            assert seen[-1], f"{what}: {self.describe()}"

    def describe(self):
        return "\n".join(self.lines[-20:])

    def tell(self, line):
        """Sends a line and waits until it is answered."""
        with self.change:
            answers = len(self.lines)
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        self.wait_for(line, lambda it: len(it.lines) > answers)
        with self.change:
            assert self.lines[answers].startswith("ok"), self.lines[answers]

    def end(self):
        self.process.terminate()
        self.process.wait()
        self.reader.join()


class Plc(Process):
    """awlsim with a project of the example. The flags are described at the head of contrib/plc/gauge.awl."""

    flags = bytes(16)

    def keep(self, line):
        found = FLAGS.match(line)
        if found:
            self.flags = bytes.fromhex(found[1])
        elif line.startswith("DPM1") or "error" in line.lower():
            self.lines.append(line)

    def describe(self):
        return f"flags {self.flags.hex(' ')}\n{super().describe()}"

    def bit(self, number):
        return bool(self.flags[4] >> number & 1)

    @property
    def pressure(self):
        return struct.unpack(">f", self.flags[:4])[0]

    def word(self, at):
        return int.from_bytes(self.flags[at:at + 2], "big")

    def double(self, at):
        return int.from_bytes(self.flags[at:at + 4], "big")

    def shows(self, mbar, within, answers=True):
        return abs(self.pressure / mbar - 1) < 1e-3 and self.bit(0) == within and self.bit(7) != answers


class Listener(Process):
    """`profivac sniff --json`."""

    def keep(self, line):
        self.lines.append(json.loads(line).get("text", "") if line.startswith("{") else line)

    def has_heard(self, *words):
        return any(all(word in line for word in words) for line in self.lines)


class Station(Process):
    """`profivac run` with a listen-only segment."""

    def wait_until_ready(self):
        self.wait_for("the station", lambda it: any(line.startswith("ready ") for line in it.lines))
        self.url = next(line.split()[1] for line in self.lines if line.startswith("ready "))

    def gauge(self):
        with urllib.request.urlopen(f"{self.url}/api/gauges", timeout=HANG_S) as answer:
            return json.load(answer)[0]

    def shows(self, mbar):
        """Whether a reading of the gauge is valid and has this pressure."""
        valid = [reading["pa"] for reading in self.gauge()["readings"] if reading["quality"] == "valid"]
        return any(abs(pa / (100 * mbar) - 1) < 1e-3 for pa in valid)

    def misses(self):
        gauge = self.gauge()
        return gauge["state"] == "missing" and all(reading["pa"] is None for reading in gauge["readings"])


def check_page(flags):
    """The page names the versions of ci/requirements.txt, the project, and the flags as they are; octets 6 and 7 count."""
    with open(PAGE) as page, open(REQUIREMENTS) as requirements:
        page, pinned = page.read(), set(requirements.read().split())
    installed = re.search(r"pip install (.*)", page)[1].split()
    assert len(installed) == 3 and pinned.issuperset(installed), installed
    assert "$ venv/bin/awlsim-test bcg450.awlpro\n" in page
    shown = bytes.fromhex(re.search(r" +M: +((?:[0-9A-F]{2} ?){16})\n", page)[1])
    assert shown[:6] + shown[8:] == flags[:6] + flags[8:], f"{flags.hex(' ')}, and {PAGE} has {shown.hex(' ')}"


def check(program, device, folder):
    """One family, from the GSD file to the power failure."""
    read, written, parameters = FAMILIES[device]
    subprocess.run([program, "gsd", device, "--out", "gsd"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    processes = []

    def start(kind, *command):
        processes.append(kind(folder, *command))
        return processes[-1]

    try:
        hub = start(Process, program, "hub", "--pty", "plc", "--pty", "gauge", "--pty", "listener", "--pty", "station")
        hub.wait_for("the line", lambda it: any(line.startswith("ready") for line in it.lines))
        gauge = start(Process, program, "simulate", "--serial", "gauge", "--pressure", "2e-3 mbar", f"{device}@5")
        gauge.wait_for("the gauge", lambda it: any(line.startswith("ready") for line in it.lines))
        listener = start(Listener, program, "sniff", "--port", "listener", "--json")
        listener.wait_for("the listener", lambda it: any("listening on" in line for line in it.lines))
        file = os.path.join(folder, "station.toml")
        with open(file, "w", opener=lambda path, flags: os.open(path, flags, 0o600)) as text:
            text.write(STATION.format(folder=folder, device=device))
        station = start(Station, program, "run", file, "--listen", "127.0.0.1:0")
        station.wait_until_ready()
        plc = start(Plc, AWLSIM, f"{device}.awlpro")

        plc.wait_for("the pressure", lambda it: it.shows(2e-3, within=True) and station.shows(2e-3))
        plc.wait_for("the parameter channel", lambda it: it.bit(1) and it.bit(2) and not it.bit(3))
        assert (plc.double(8), plc.double(12)) == (read, written), plc.describe()
        if device == "bcg450":
            check_page(plc.flags)
        gauge.tell("pressure 8e-3 mbar")
        plc.wait_for("the other pressure", lambda it: it.shows(8e-3, within=False) and station.shows(8e-3))
        gauge.tell("pressure 2e-3 mbar")
        plc.wait_for("the first pressure again", lambda it: it.shows(2e-3, within=True) and station.shows(2e-3))

        gauge.tell("power 5 off")
        plc.wait_for("the lost gauge", lambda it: it.shows(2e-3, within=False, answers=False) and station.misses())
        gauge.tell("pressure 8e-3 mbar")
        tasks = plc.word(6)
        gauge.tell("power 5 on")
        plc.wait_for("the gauge again", lambda it: it.shows(8e-3, within=False) and it.word(6) > tasks and station.shows(8e-3))
        assert not plc.bit(3), plc.describe()
        assert station.gauge()["listen_only"] and not station.gauge()["assumptions"], station.gauge()

        for words in [
            ["master 2 sets its parameters", parameters],
            ["exchanges data with master 2", "2.000e-3"],
            ["parameter channel: write", "is done"],
            ["does not answer master 2 any more"],
            ["exchanges data with master 2", "8.000e-3"],
        ]:
            listener.wait_for(" ... ".join(words), lambda it, words=words: it.has_heard(*words))
        assert not listener.has_heard("refused"), listener.describe()
        return plc.word(6)
    finally:
        for process in reversed(processes):
            process.end()


def main():
    program = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory(prefix="profivac-plc-") as folder, concurrent.futures.ThreadPoolExecutor() as pool:
        runs = {}
        for device in FAMILIES:
            own = shutil.copytree(EXAMPLE, os.path.join(folder, device))
            runs[device] = pool.submit(check, program, device, own)
        for device, run in runs.items():
            print(f"{device}: exchange, pressure, one write, power off and on; {run.result()} tasks of the parameter channel")


if __name__ == "__main__":
    main()
