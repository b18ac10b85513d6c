"""Ports, errors, threads, signals, forks, asyncio."""

from __future__ import annotations

import asyncio
import gc
import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy
import profivac as pv
import pytest
from profivac._bus import _words

from conftest import Simulate


PATIENT = 300.0
"""A timeout in s that only bounds a hang."""


def read_all(bus: pv.Bus) -> list[str]:
    """Sends nothing that a late answer would change: a scan under load may miss a station."""
    for address in (5, 6):
        bus[address].command("execute")
        assert bus[address].read().valid
    return [bus[address].device for address in (5, 6)]


def test_a_pty_is_a_port(simulate: Simulate, tmp_path: Path) -> None:
    place = simulate("--pty", tmp_path / "line", "bcg450@5", "hpg400@6")
    with pv.open(place, timeout=PATIENT) as bus:
        assert read_all(bus) == ["bcg450", "hpg400"]


@pytest.mark.parametrize("scheme", ["tcp:", "tcp://"])
def test_a_tcp_port_is_a_port(simulate: Simulate, scheme: str) -> None:
    place = simulate("--tcp", "127.0.0.1:0", "bcg450@5", "hpg400@6")
    with pv.open(scheme + place, timeout=PATIENT) as bus:
        assert read_all(bus) == ["bcg450", "hpg400"]


def test_a_segment_file_is_a_port(tmp_path: Path) -> None:
    file = tmp_path / "two.toml"
    file.write_text('devices = ["bcg450@5", "hpg400@6"]\n')
    with pv.open(f"sim:{file}", timeout=PATIENT) as bus:
        assert read_all(bus) == ["bcg450", "hpg400"]


def test_errors_follow_the_exit_codes() -> None:
    assert [it.exit_code for it in (pv.Refused, pv.Usage, pv.Connection)] == [1, 2, 3]
    assert all(issubclass(it, pv.ProfivacError) for it in (pv.Refused, pv.Usage, pv.Connection))
    with pv.VirtualSegment("bcg450@5", timeout=1.0) as chamber:
        gauge = chamber.bus[5]
        for wrong in (
            lambda: gauge["pirani.presure"],
            lambda: gauge.set("pirani.safe-value", "much"),
            lambda: gauge.set("pirani.safe-value", "1e9 mbar"),
            lambda: gauge.command("dance"),
            lambda: chamber.bus["nowhere"],
            lambda: chamber.bus[127],
            lambda: gauge.diff("/does/not/exist.toml"),
            lambda: pv.open("sim:bcg451@5"),
            lambda: pv.open("sim:bcg450@5 hpg400@5"),
            lambda: pv.open("sim:bcg450@5", timeout=0),
            lambda: pv.open("sim:bcg450@5", via="smoke"),
            lambda: pv.open("/dev/null", baud=115200),
            lambda: pv.pascal("1 psi"),
            lambda: pv.open("sim:bcg450@5", master=300),
            lambda: pv.open("/dev/null", baud=10**30),
            lambda: pv.VirtualSegment("bcg450@5", seed=-1),
            lambda: pv.decode(b"", baud=-1),
            lambda: chamber.power(300, True),
            lambda: gauge.read("psi"),
            lambda: gauge.exchange("psi"),
        ):
            with pytest.raises(pv.Usage):
                wrong()
        with pytest.raises(pv.Refused):
            gauge.command("degas on", confirm=True)
        with pytest.raises(pv.Connection, match="no answer|does not answer|no station"):
            chamber.bus[9].read()
        with pytest.raises(pv.Connection, match="no station answers at address 9"):
            chamber.bus[9].exchange()
    with pytest.raises(pv.Connection):
        pv.open("/dev/does-not-exist")


def test_a_number_of_numpy_is_written_like_one_of_python() -> None:
    # The annotations promise only Python's own types.
    numbers: list[Any] = [numpy.int64(2), numpy.float64(2.0).astype(int)]
    with pv.VirtualSegment("bcg450@5") as chamber:
        for number in numbers:
            change = chamber.bus[5].set("pirani.safe-state", number)
            assert change.after is not None and change.after.value == "hold-last-value"
    values: list[Any] = [numpy.float64(0.5), numpy.bool_(True), numpy.str_("zero")]
    assert [_words(it) for it in values] == ["0.5", "true", "zero"]


def test_a_forced_pressure_is_written() -> None:
    with pv.VirtualSegment("bcg450@5") as chamber:
        assert chamber.bus[5].set("pirani.safe-value", "1e9 mbar", force=True).after is not None


def test_a_command_with_a_risk_needs_confirmation() -> None:
    with pv.VirtualSegment("bcg450@5", pressure="1e-7 mbar") as chamber:
        gauge = chamber.bus[5]
        gauge.command("execute")
        assert any(command.risk for command in gauge.commands.values())
        with pytest.raises(pv.Usage, match="nothing was sent.*confirm=True"):
            gauge.command("degas on")
        gauge.command("degas on", confirm=True)


def test_a_closed_bus_says_so() -> None:
    chamber = pv.VirtualSegment("bcg450@5")
    gauge = chamber.bus[5]
    chamber.close()
    chamber.close()
    for use in (gauge.read, chamber.bus.scan, lambda: chamber.bus[6], lambda: chamber.advance(1)):
        with pytest.raises(pv.Connection, match="closed"):
            use()


def test_a_wait_holds_no_interpreter_lock() -> None:
    """The counting thread gives the lock back by itself, and without a release in the wait it would never get it."""
    counted, stop = [0], threading.Event()

    def count() -> None:
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0)

    interval = sys.getswitchinterval()
    with pv.VirtualSegment("bcg450@5", timeout=1.0) as chamber:
        chamber.bus[5].read()
        thread = threading.Thread(target=count)
        thread.start()
        sys.setswitchinterval(1000.0)
        try:
            before = counted[0]
            with pytest.raises(pv.Connection):
                chamber.bus[9].read()
            during = counted[0] - before
        finally:
            sys.setswitchinterval(interval)
            stop.set()
            thread.join()
    print(f"{during} steps of another thread during a wait of 1 s")
    assert during > 10


def test_threads_share_a_bus() -> None:
    errors: list[BaseException] = []
    with pv.VirtualSegment("bcg450@5", "psg550@6", pressure="1e-2 mbar") as chamber:

        def work(address: int) -> None:
            try:
                for _ in range(5):
                    assert chamber.bus[address].read(pv.Unit.MBAR).value == pytest.approx(1e-2, rel=0.2)
            except BaseException as error:  # noqa: BLE001
                errors.append(error)

        for address in (5, 6):
            chamber.bus[address].command("execute")
        threads = [threading.Thread(target=work, args=(address,)) for address in (5, 6, 5, 6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert errors == []


def test_asyncio_waits_without_blocking_the_loop() -> None:
    async def main() -> tuple[list[bool], list[int]]:
        with pv.VirtualSegment("bcg450@5", "psg550@6") as chamber:
            for address in (5, 6):
                await chamber.bus[address].command_async("execute")
            readings = await asyncio.gather(*(chamber.bus[address].read_async() for address in (5, 6)))
            await chamber.bus[5].set_async("pirani.safe-state", "full-scale")
            assert (await chamber.bus[5].get_async("pirani.safe-state")).value == "full-scale"
            addresses = []
            async for gauge, _ in chamber.bus.stream_async(5, 6, interval=0):
                addresses.append(gauge.address)
                if len(addresses) == 4:
                    break
            return [reading.valid for reading in readings], addresses

    assert asyncio.run(main()) == ([True, True], [5, 6, 5, 6])


def test_a_stream_goes_on_when_its_time_passes_while_it_decides_to_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    slept: list[float] = []

    class Clock:
        """Each look at the clock takes 0.6 s."""

        now = 0.0

        @classmethod
        def monotonic(cls) -> float:
            cls.now += 0.6
            return cls.now

        @staticmethod
        def sleep(seconds: float) -> None:
            assert seconds >= 0.0, f"time.sleep refuses {seconds}"
            slept.append(seconds)

    with pv.VirtualSegment("psg550@5") as chamber:
        monkeypatch.setattr("profivac._bus.time", Clock)
        readings = chamber.bus.stream(5, interval=1.5)
        for _ in range(5):
            next(readings)
    assert len(slept) == 4


def test_a_stream_needs_a_gauge() -> None:
    with pv.VirtualSegment("bcg450@5") as chamber, pytest.raises(pv.Usage, match="expected the gauges to watch"):
        next(chamber.bus.stream())


def test_a_gauge_keeps_its_bus_open_and_the_bus_ends_what_it_began() -> None:
    gauge = pv.open("sim:bcg450@5")[5]
    gc.collect()
    gauge.command("execute")
    assert gauge.read().valid
    bus = pv.open("sim:bcg450@5")
    exchange = bus[5].exchange()
    next(exchange)
    bus.close()
    with pytest.raises(pv.Connection, match="closed"):
        next(exchange)


def test_cyclic_data_own_the_gauge_until_the_block_ends() -> None:
    with pv.VirtualSegment("bcg450@5", pressure="2e-3 mbar") as chamber:

        def owner() -> int | None:
            return chamber.bus.scan(5, 5)[0].owner

        assert owner() is None
        with chamber.bus[5].exchange(pv.Unit.MBAR) as exchange:
            readings = next(exchange)
            assert [reading.value for reading in next(exchange)] == [pytest.approx(2e-3, rel=0.1)], readings
            assert owner() == 0
            assert chamber.bus[5]["device.device-state"].value == "EXECUTING"
        assert owner() is None
        with pytest.raises(pv.Connection, match="closed"):
            next(exchange)

        async def first() -> list[pv.Reading]:
            with chamber.bus[5].exchange() as exchange:
                async for readings in exchange:
                    return readings
            raise AssertionError

        assert asyncio.run(first())[0].valid


def test_a_connection_is_kept_within_a_block() -> None:
    with pv.VirtualSegment("bcg450@5", "psg550@6", pressure="1e-2 mbar", timeout=PATIENT) as chamber:
        gauge = chamber.bus[5]
        with gauge.connection_kept() as kept:
            assert kept is gauge
            gauge.command("execute")
            assert [gauge.read().state for _ in range(3)] == [pv.State.VALID] * 3
            with gauge.connection_kept(10):
                assert gauge.read().valid
            assert gauge.read().valid
            # The settings of a gauge and its cyclic data go over the same connection, other gauges over theirs.
            assert gauge.diff(gauge.dump()) == []
            with gauge.exchange() as exchange:
                assert next(exchange)[0].valid
            assert chamber.bus[6]["device.device-state"].value == "IDLE"
        # The owner that left has stopped the gauge.
        assert gauge.read().state is pv.State.OFF
        for idle in (0.0, -1.0, 1e9, float("nan")):
            with pytest.raises(pv.Usage, match="expected an idle time"), gauge.connection_kept(idle):
                pass
    with pytest.raises(pv.Connection, match="closed"), gauge.connection_kept():
        pass
    with pv.VirtualSegment("tpg500@5", via="pkw") as owned, pytest.raises(pv.Usage, match="only MS2"):
        with owned.bus[5].connection_kept():
            pass


def test_a_gauge_that_was_switched_off_fails_once_and_is_identified_again() -> None:
    """Another gauge may be at the address, so the connection is not opened again without asking for the identity."""
    with pv.VirtualSegment("bcg450@5", timeout=PATIENT) as chamber, chamber.bus[5].connection_kept(3600) as gauge:
        gauge.get("device.device-state")
        chamber.power(5, False)
        chamber.power(5, True)
        with pytest.raises(pv.Connection, match="the connection that was kept has ended, .* repeat the request"):
            gauge.get("device.device-state")
        assert gauge["device.device-state"].value == "IDLE"


def test_a_bus_is_closed_within_a_block_that_keeps_a_connection() -> None:
    with pv.VirtualSegment("bcg450@5", timeout=PATIENT) as chamber:
        with chamber.bus[5].connection_kept(3600):
            chamber.bus[5].get("device.device-state")
            chamber.bus.close()


INTERRUPTED = """
import os, signal, sys, threading
import profivac as pv
signal.signal(signal.SIGINT, signal.default_int_handler)  # A shell may have started the tests with the signal ignored.
go = threading.Event()

def interrupt():
    go.wait()
    os.kill(os.getpid(), signal.SIGINT)

with pv.VirtualSegment("bcg450@5", timeout=3000) as chamber:
    chamber.bus[5].read()
    threading.Thread(target=interrupt).start()
    # From here on the other thread runs only while the wait has released the interpreter lock.
    sys.setswitchinterval(1000.0)
    try:
        go.set()
        chamber.bus[9].read()
    except KeyboardInterrupt:
        print("interrupted", flush=True)
        # The request runs to its end, and so would the end of the block.
        os._exit(0)
"""


def test_ctrl_c_ends_a_wait(tmp_path: Path) -> None:
    command = [sys.executable, "-c", INTERRUPTED]
    result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=300)
    assert (result.returncode, result.stdout) == (0, "interrupted\n"), result.stderr


FORKED = """
import gc, os, profivac as pv
chamber = pv.VirtualSegment("bcg450@5", names={"chamber": 5})
gauge = chamber.bus["chamber"]
gauge.get("ba.process-value")
with gauge.connection_kept():
    gauge.get("device.device-state")
    child = os.fork()
if child == 0:
    for use in (gauge.read, chamber.bus.scan, lambda: chamber.advance(1)):
        try:
            use()
        except pv.Usage as error:
            assert "a fork does not copy its thread" in str(error), error
        else:
            os._exit(1)
    chamber.close()
    with pv.open("sim:psg550@6") as own:
        own[6].command("execute")
        assert own[6].read().valid
    del gauge, chamber
    gc.collect()
    raise SystemExit(0)
_, status = os.waitpid(child, 0)
assert os.waitstatus_to_exitcode(status) == 0, status
gauge.read()
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
def test_a_fork_is_told_apart(tmp_path: Path) -> None:
    command = [sys.executable, "-c", FORKED]
    result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=300)
    assert result.returncode == 0, result.stderr


def test_the_examples_of_the_readme_run(tmp_path: Path) -> None:
    readme = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")
    examples = [part.split("```")[0] for part in readme.split("```python\n")[1:]]
    shown = [("State.VALID", "0.125 mbar"), ("Pa after roughing, the gauge shows", "Pa after a day, mostly h2o")]
    assert len(examples) == len(shown)
    for example, words in zip(examples, shown):
        command = [sys.executable, "-c", example]
        result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=300)
        assert result.returncode == 0, result.stderr
        assert all(word in result.stdout for word in words), result.stdout
    assert (tmp_path / "gauge.toml").exists()


def test_a_closed_bus_has_released_its_port(simulate: Simulate, tmp_path: Path) -> None:
    place = simulate("--pty", tmp_path / "line", "bcg450@5")
    for _ in range(20):
        with pv.open(place, timeout=PATIENT) as bus:
            bus[5].get("device.device-state")


def test_a_unit_may_be_its_name_and_an_unknown_value_gets_words() -> None:
    with pv.VirtualSegment("psg550@5", pressure=2e-2, unit="mbar") as chamber:
        gauge = chamber.bus[5]
        gauge.command("execute")
        assert gauge.read("mbar").unit is pv.Unit.MBAR
        assert gauge.pressure("MBAR") == gauge.pressure(pv.Unit.MBAR) == pytest.approx(2e-2, rel=0.1)
        chamber.set_pressure(5.0, "mbar")
        assert chamber.pressure == "5.0 mbar"
        for wrong in ("psi", None, 5):
            with pytest.raises(pv.Usage, match="expected a unit, one of Pa, hPa"):
                gauge.read(wrong)  # type: ignore[arg-type]
        for value in (5.0, True, None):
            with pytest.raises(pv.Usage, match="or a number with a unit"):
                chamber.set_pressure(value)  # type: ignore[arg-type]
        with pytest.raises(pv.Usage, match="expected a word, a number or a pressure"):
            gauge.set("pirani.safe-state", None)  # type: ignore[arg-type]
        for address in (5.0, None, True):
            with pytest.raises(pv.Usage, match="expected an address from 0 to 126 or a name"):
                chamber.bus[address]  # type: ignore[index]
