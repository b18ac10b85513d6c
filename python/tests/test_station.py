"""A station over HTTP: the demonstration of the program."""

from __future__ import annotations

import os
import re
import subprocess
import time
from collections.abc import Iterator
from datetime import datetime, timezone

import numpy
import profivac as pv
import pytest


@pytest.fixture(scope="module")
def station() -> Iterator[pv.RemoteStation]:
    program = os.environ.get("PROFIVAC")
    if program is None:
        pytest.skip("PROFIVAC is not set to the path of the program")
    command = [program, "demo", "--headless", "--listen", "127.0.0.1:0", "--for", "600"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        assert process.stdout is not None
        found = next(filter(None, (re.search(r"http://[\d.:]+", line) for line in process.stdout)))
        # The rest of the output is read, so that the program does not wait for a full pipe.
        drain = subprocess.Popen(["cat"], stdin=process.stdout, stdout=subprocess.DEVNULL)
        try:
            yield pv.connect(found[0], timeout=60)
        finally:
            process.terminate()
            drain.wait()


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
    assert reading.time <= datetime.now(timezone.utc)
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


def test_a_wrong_request_is_told(station: pv.RemoteStation) -> None:
    for wrong in (
        lambda: station.history("bcg450 5", "yesterday"),
        lambda: station.history("bcg450 5", datetime(2026, 1, 1)),
        lambda: station.history("bcg450 5", entries=0),
        lambda: station.history("nowhere"),
        lambda: pv.connect("ftp://station"),
        lambda: pv.open("http://station:8080"),
    ):
        with pytest.raises(pv.Usage):
            wrong()
    with pytest.raises(pv.Connection, match="gives no answer of a station"):
        pv.connect("http://127.0.0.1:1").gauges()


def test_a_certificate_that_cannot_be_read_is_wrong_usage() -> None:
    with pytest.raises(pv.Usage, match="/does/not/exist.pem is no certificate"):
        pv.connect("https://127.0.0.1:1", cafile="/does/not/exist.pem")
