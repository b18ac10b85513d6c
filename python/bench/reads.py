"""Readings per second over one pty: the package beside pyprofibus. Prints a table; asserts nothing.

    PROFIVAC=target/release/profivac python python/bench/reads.py [SECONDS]

pyprofibus 1.13 and pyserial must be installed. The pressure of a virtual BCG450-SP is read by each master in turn, in cyclic data with
the same configuration; the package also reads it over MS2, which takes no ownership.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import profivac as pv

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "crates/cli/tests/peers"))

ROUNDS = 5

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


def cyclic(port: str, seconds: float) -> float:
    with pv.open(port) as bus, bus[5].exchange() as exchange:
        return rate(seconds, lambda: bool(next(exchange)))


def readings(port: str, seconds: float) -> float:
    with pv.open(port) as bus:
        bus[5].command("execute")
        return rate(seconds, lambda: bus[5].read().valid)


def kept_readings(port: str, seconds: float) -> float:
    with pv.open(port) as bus, bus[5].connection_kept() as gauge:
        gauge.command("execute")
        return rate(seconds, lambda: gauge.read().valid)


def parameter(port: str, seconds: float) -> float:
    with pv.open(port) as bus:
        return rate(seconds, lambda: bus[5]["device.device-state"].value == "IDLE")


def kept_parameter(port: str, seconds: float) -> float:
    with pv.open(port) as bus, bus[5].connection_kept() as gauge:
        return rate(seconds, lambda: gauge["device.device-state"].value == "IDLE")


ROWS: dict[str, Callable[[str, float], float]] = {
    "pyprofibus 1.13, cyclic data": pyprofibus,
    "profivac, cyclic data": cyclic,
    "profivac, pressure over MS2": readings,
    "profivac, pressure over MS2, connection kept": kept_readings,
    "profivac, one parameter over MS2": parameter,
    "profivac, one parameter over MS2, connection kept": kept_parameter,
}


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 2.0
    found: dict[str, list[float]] = {name: [] for name in ROWS}
    # Round by round, so that other work of the computer meets all of them alike.
    for _ in range(ROUNDS):
        for name, measure in ROWS.items():
            with tempfile.TemporaryDirectory() as folder:
                command = [os.environ["PROFIVAC"], "simulate", "--pty", f"{folder}/line", "bcg450@5"]
                with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as line:
                    assert line.stdout is not None
                    line.stdout.readline()
                    try:
                        found[name].append(measure(f"{folder}/line", seconds))
                    finally:
                        line.terminate()
    print(f"load {os.getloadavg()[0]:.1f}; the median and the best of {ROUNDS} rounds")
    for name, rates in found.items():
        print(f"| {name} | {statistics.median(rates):.0f} | {max(rates):.0f} |")


if __name__ == "__main__":
    main()
