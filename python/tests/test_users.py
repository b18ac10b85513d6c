"""A station with users."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import profivac as pv
import pytest

PASSWORD = "tin whisker plateau"


@pytest.fixture
def url(tmp_path: Path) -> Iterator[str]:
    program = os.environ.get("PROFIVAC")
    if program is None:
        pytest.skip("PROFIVAC is not set to the path of the program")
    (tmp_path / "segment.toml").write_text('devices = ["bcg450@5"]\n')
    file = tmp_path / "plant.toml"
    file.write_text(
        '[station]\nlisten = "127.0.0.1:0"\n[[segment]]\nname = "a"\nport = "sim:segment.toml"\n'
        '[[segment.gauge]]\nname = "chamber"\naddress = 5\ndevice = "bcg450"\n'
    )
    file.chmod(0o600)
    add = [program, "user", "add", "eva", "--role", "viewer", str(file), "--password-stdin"]
    subprocess.run(add, input=PASSWORD, text=True, check=True, capture_output=True)
    command = [program, "run", str(file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        assert process.stdout is not None
        seen = []
        for line in process.stdout:
            seen.append(line)
            if found := re.search(r"http://[\d.:]+\d", line):
                break
        else:
            raise AssertionError("".join(seen))
        # The rest of the output is read, so that the station does not wait for a full pipe.
        drain = subprocess.Popen(["cat"], stdin=process.stdout, stdout=subprocess.DEVNULL)
        try:
            yield found[0]
        finally:
            process.terminate()
            drain.wait()


def test_a_station_with_users_demands_a_password(url: str) -> None:
    with pytest.raises(pv.Refused, match="pass user and password"):
        pv.connect(url, timeout=300).gauges()
    with pytest.raises(pv.Refused):
        pv.connect(url, user="eva", password="guess", timeout=300)
    station = pv.connect(url, user="eva", password=PASSWORD, timeout=300)
    assert station.gauges() == ["chamber"]
    assert isinstance(station.events(), list)


def test_open_logs_in_and_out(url: str) -> None:
    with pytest.raises(pv.Refused, match="pass user and password"):
        pv.open(url, timeout=300)
    with pv.open(url, user="eva", password=PASSWORD, timeout=300) as bus:
        assert isinstance(bus, pv.StationBus)
        assert bus.station.gauges() == ["chamber"]
    with pytest.raises(pv.Refused):
        bus.station.gauges()
    bus.close()
