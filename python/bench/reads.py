"""Readings per second over one pty: the package beside pyprofibus. Prints a table; asserts nothing.

    PROFIVAC=target/debug/profivac python python/bench/reads.py [SECONDS]

pyprofibus 1.13 and pyserial must be installed. The pressure of a virtual BCG450-SP is read by each master in turn, in cyclic data with
the same configuration; the package also reads it over MS2, which takes no ownership.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import profivac as pv

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "crates/cli/tests/peers"))

CONFIGURATION = bytes.fromhex("448405050503")
USER_PRM = bytes.fromhex("000000051c")


def rate(seconds: float, read: Callable[[], bool]) -> float:
    """Readings per second, after a first one."""
    while not read():
        pass
    count, begun = 0, time.perf_counter()
    while time.perf_counter() - begun < seconds:
        count += read()
    return count / (time.perf_counter() - begun)


def pyprofibus(port: str, seconds: float) -> float:
    from pyprofibus_master import describe, master_of, open_port, state_of, step  # type: ignore[import-not-found]

    slave = describe(5, 0x08E6, CONFIGURATION, USER_PRM, 0, 5)
    master = master_of(open_port(port), slave)
    state = state_of(master, slave)

    def read() -> bool:
        step(master, slave, state, 0)
        return slave.getMasterInData() is not None

    return rate(seconds, read)


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 5.0
    results = {}
    for name in ("pyprofibus 1.13, cyclic data", "profivac, cyclic data", "profivac, MS2, without ownership"):
        with tempfile.TemporaryDirectory() as folder:
            command = [os.environ["PROFIVAC"], "simulate", "--pty", f"{folder}/line", "bcg450@5"]
            with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as line:
                assert line.stdout is not None
                line.stdout.readline()
                try:
                    results[name] = measure(name, f"{folder}/line", seconds)
                finally:
                    line.terminate()
    for name, per_second in results.items():
        print(f"| {name} | {per_second:.0f} |")


def measure(name: str, port: str, seconds: float) -> float:
    if name.startswith("pyprofibus"):
        return pyprofibus(port, seconds)
    with pv.open(port) as bus:
        if "cyclic" in name:
            with bus[5].exchange() as exchange:
                return rate(seconds, lambda: bool(next(exchange)))
        bus[5].command("execute")
        return rate(seconds, lambda: bus[5].read().valid)


if __name__ == "__main__":
    main()
