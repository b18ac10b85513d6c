"""A station over HTTP: the demonstration of the program."""

from __future__ import annotations

import asyncio
import math
import os
import re
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime, timezone
from pathlib import Path

import numpy
import profivac as pv
import pytest


@contextmanager
def served(command: list[str]) -> Iterator[str]:
    """The address of a station that runs."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        assert process.stdout is not None
        found = next(filter(None, (re.search(r"http://[\d.:]+\d", line) for line in process.stdout)))
        # The rest of the output is read, so that the program does not wait for a full pipe.
        drain = subprocess.Popen(["cat"], stdin=process.stdout, stdout=subprocess.DEVNULL)
        try:
            yield found[0]
        finally:
            process.terminate()
            drain.wait()


@pytest.fixture(scope="module")
def station() -> Iterator[pv.RemoteStation]:
    program = os.environ.get("PROFIVAC")
    if program is None:
        pytest.skip("PROFIVAC is not set to the path of the program")
    with served([program, "demo", "--headless", "--listen", "127.0.0.1:0", "--for", "600"]) as url:
        yield pv.connect(url, timeout=60)


def recorded(station: pv.RemoteStation, series: str) -> object:
    """Waits until the recorder has written; only a hang takes long."""
    for _ in range(600):
        history = station.history(series, "-1h")
        if len(history.time) > 1:
            return history
        time.sleep(0.5)
    raise AssertionError("nothing is recorded")


def test_a_station_gives_readings(station: pv.RemoteStation) -> None:
    assert "bcg450 5" in station.gauges(), "the first request finds the gauges"
    recorded(station, "bcg450 5")
    reading = station.read("bcg450 5", pv.Unit.MBAR)
    assert (reading.value is not None) == reading.valid
    assert reading.time is not None and reading.time <= datetime.now(timezone.utc)
    with pytest.raises(pv.Usage, match="no series 'nowhere'; known: bcg450 5"):
        station.read("nowhere")


def test_a_station_gives_its_history_as_arrays(station: pv.RemoteStation) -> None:
    history = recorded(station, "bcg450 5")
    assert isinstance(history, pv.History)
    times, means = history.numpy()
    assert len(times) == len(means) == len(history.time)
    assert times.dtype == numpy.dtype("datetime64[ms]")
    assert numpy.all(numpy.diff(times) > numpy.timedelta64(0))
    low, high = history.low[0], history.high[0]
    assert low is not None and high is not None and 0 < low <= high
    frame = history.pandas()
    assert list(frame.columns) == ["low", "mean", "high"]
    assert frame["mean"].to_numpy() == pytest.approx(means, nan_ok=True)
    assert str(frame.index.tz) == "UTC"
    assert all(isinstance(event, pv.Event) for event in station.events())


def parameter(gauge: pv.Gauge, name: str) -> pv.Value:
    """On a loaded computer the station may be busy, or the gauge may answer it too late."""
    while True:
        try:
            return gauge[name]
        except pv.Connection:
            time.sleep(0.5)


def test_open_takes_the_address_of_a_station(station: pv.RemoteStation) -> None:
    """Names, addresses, streams and parameters are those of a bus; what writes is refused."""
    recorded(station, "bcg450 5")
    with pv.open(station.url, names={"chamber": 5}, timeout=60) as bus:
        assert isinstance(bus, pv.StationBus)
        gauge = bus["bcg450 5"]
        assert gauge is bus[5] is bus["chamber"]
        assert (gauge.device, gauge.title, gauge.ident) == ("bcg450", "BCG450-SP", 0x08E6)
        assert gauge.parameters == pv.parameters_of("bcg450")
        assert {row.devices for row in bus.scan(5, 6)} == {("bcg450",), ("bpg400",)}
        _, reading = next(bus.stream("chamber", unit=pv.Unit.MBAR))
        assert reading.unit is pv.Unit.MBAR and reading.time is not None
        assert asyncio.run(gauge.read_async()).time is not None
        state = parameter(gauge, "device.device-state")
        assert (state.value, state.octets) == ("EXECUTING", b"")
        full_scale = parameter(gauge, "pirani.full-scale")
        assert (full_scale.value, full_scale.unit, full_scale.pascal) == (1000, "mbar", 1e5)
        assert parameter(gauge, "ba.reading-valid").value in (True, False)
        assert isinstance(parameter(gauge, "device.block-type").value, str)
        assert len(bus.station.history("bcg450 5").time) > 1
        refused: tuple[Callable[[], object], ...] = (
            lambda: gauge.set("pirani.safe-value", "1 Pa"),
            lambda: gauge.command("execute"),
            lambda: gauge.dump(),
            lambda: gauge.diff("a\n"),
            lambda: gauge.restore("a\n"),
            lambda: gauge.exchange(),
            lambda: bus["nowhere"],
            lambda: bus[99],
            lambda: gauge["pirani.presure"],
            lambda: gauge.read(part="pirani.1"),
        )
        for wrong in refused:
            with pytest.raises(pv.Usage):
                wrong()
    with pytest.raises(pv.Connection, match="closed"):
        gauge.read()


def test_a_gauge_that_never_gave_a_reading_has_no_time(tmp_path: Path) -> None:
    """The segment has no gauge at the address."""
    program = os.environ.get("PROFIVAC")
    if program is None:
        pytest.skip("PROFIVAC is not set to the path of the program")
    (tmp_path / "segment.toml").write_text('devices = ["psg550@6"]\n')
    file = tmp_path / "plant.toml"
    file.write_text(
        '[station]\nlisten = "127.0.0.1:0"\n[[segment]]\nname = "a"\nport = "sim:segment.toml"\n'
        '[[segment.gauge]]\nname = "chamber"\naddress = 5\ndevice = "bcg450"\n'
    )
    with served([program, "run", str(file)]) as url:
        with pv.open(url, timeout=60) as bus:
            assert isinstance(bus, pv.StationBus)
            for reading in (bus["chamber"].read(pv.Unit.MBAR), bus.station.read("chamber", pv.Unit.MBAR)):
                assert (reading.value, reading.state, reading.time) == (None, pv.State.STALE, None)
                assert reading.cause and reading.unit is pv.Unit.MBAR
            assert math.isnan(bus["chamber"].pressure())
            with pytest.raises(pv.Connection):
                bus["chamber"].get("device.device-state")


def test_a_wrong_request_is_told(station: pv.RemoteStation) -> None:
    for wrong in (
        lambda: station.history("bcg450 5", "yesterday"),
        lambda: station.history("bcg450 5", datetime(2026, 1, 1)),
        lambda: station.history("bcg450 5", entries=0),
        lambda: station.history("nowhere"),
        lambda: pv.connect("ftp://station"),
        lambda: pv.open("sim:bcg450@5", user="eva"),
    ):
        with pytest.raises(pv.Usage):
            wrong()
    with pytest.raises(pv.Connection, match="gives no answer of a station"):
        pv.open("http://127.0.0.1:1")
    with pytest.raises(pv.Connection, match="gives no answer of a station"):
        pv.connect("http://127.0.0.1:1").gauges()


def test_a_certificate_that_cannot_be_read_is_wrong_usage() -> None:
    with pytest.raises(pv.Usage, match="/does/not/exist.pem is no certificate"):
        pv.connect("https://127.0.0.1:1", cafile="/does/not/exist.pem")
