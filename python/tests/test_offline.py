"""What needs no line: recordings, and plants from their data."""

from __future__ import annotations

import enum
import inspect
import math
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import is_dataclass
from pathlib import Path

import profivac as pv
import pytest
from profivac import identify, ophyd, pymeasure, qcodes, vacuum

GLOBAL_CONTROL = "TX 68 07 07 68 FF 82 46 3A 3E 02 00 41 16\n"

VOLUME, SPEED, LEAK, OUTGASSED = 0.05, 0.02, 2e-7, 2e-6


def record(noise: float = 0.0) -> tuple[list[float], list[float]]:
    """A pump-down of four hours, then an hour with the valve closed."""
    times, pressures = [], []
    for step in range(60):
        seconds = 10 * (14400 / 10) ** (step / 59)
        flow = LEAK + OUTGASSED * 3600 / seconds
        times.append(seconds)
        pressures.append(1e5 * math.exp(-SPEED / VOLUME * seconds) + flow / SPEED)
    base = pressures[-1]
    for step in range(1, 41):
        seconds = 14400 + 90.0 * step
        gas = LEAK * (seconds - 14400) + OUTGASSED * 3600 * math.log(seconds / 14400)
        times.append(seconds)
        pressures.append(base + gas / VOLUME)
    return times, [pascal * (1 + noise * (-1) ** place) for place, pascal in enumerate(pressures)]


def public(owner: object) -> dict[str, object]:
    """The functions, classes, methods and properties that a user sees."""
    names = getattr(owner, "__all__", None) or [name for name in vars(owner) if not name.startswith("_")]
    found = {name: getattr(owner, name) for name in names}
    return {
        name: it
        for name, it in found.items()
        if isinstance(it, property) or getattr(it, "__module__", "").startswith("profivac")
    }


def test_everything_has_a_docstring_and_every_class_with_methods_an_example() -> None:
    shown = 0
    for module in (pv, identify, vacuum, ophyd, pymeasure, qcodes):
        for name, it in public(module).items():
            assert inspect.getdoc(it), name
            if not inspect.isclass(it) or issubclass(it, enum.Enum):
                continue
            members = public(it)
            texts = [inspect.getdoc(member) or "" for member in members.values()]
            assert all(texts), (name, [other for other, text in zip(members, texts) if not text])
            # A class of values is shown where it is returned.
            if any(inspect.isfunction(member) for member in members.values()) and not is_dataclass(it):
                place = sys.modules[it.__module__].__doc__ if module in (ophyd, pymeasure, qcodes) else ""
                assert any(">>>" in text for text in (inspect.getdoc(it), place, *texts) if text), name
                shown += 1
    assert shown > 15


def test_a_recording_is_explained(tmp_path: Path) -> None:
    file = tmp_path / "line.log"
    file.write_text(GLOBAL_CONTROL)
    for recording in (GLOBAL_CONTROL.encode(), file, str(file)):
        (telegram,) = pv.decode(recording)
        assert (telegram.kind, telegram.seconds, telegram.octets[-1]) == ("telegram", None, 0x16)
        (note,) = telegram.notes
        assert (note.kind, note.text) == ("control", "master 2 sends Global_Control Clear_Data to all")


def test_a_recording_without_telegrams_is_wrong_usage(tmp_path: Path) -> None:
    for recording in (b"hello", b"", b"01 02 03\n", tmp_path / "missing.log"):
        with pytest.raises(pv.Usage):
            pv.decode(recording)
    with pytest.raises(pv.Usage, match="expected a PROFIBUS rate"):
        pv.decode(GLOBAL_CONTROL.encode(), baud=115200)


def test_a_plant_is_identified_from_its_record() -> None:
    times, pressures = record(noise=0.002)
    found = identify.plant(times, pressures, volume_m3=VOLUME, closed_s=14400.0)
    assert found.leak.mean == pytest.approx(LEAK, rel=0.3)
    assert found.outgassing_1h.mean == pytest.approx(OUTGASSED, rel=0.3)
    assert found.leak.low < found.leak.mean < found.leak.high
    assert all(speed.mean > 0 for _, speed in found.speeds)
    assert set(found.remedies()) == {"close-leak", "bake", "larger-pump", "better-pump"}
    later = found.predicted(10 * 14400)
    assert later.low <= later.mean <= later.high < pressures[59]
    reached = found.time_to(pressures[40])
    assert reached is not None and reached.mean == pytest.approx(times[40], rel=0.2)
    assert found.time_to(1e-14) is None
    assert len(found.fitted) > 30


def test_a_record_that_cannot_be_fitted_is_wrong_usage() -> None:
    times, pressures = record()
    refused: tuple[Callable[[], object], ...] = (
        lambda: identify.plant(times[:5], pressures[:5], volume_m3=VOLUME),
        lambda: identify.plant(times, pressures),
        lambda: identify.plant(times, pressures, volume_m3=VOLUME, dose=(15000.0, 1.0)),
        lambda: identify.plant(times, pressures, volume_m3=-1.0),
        lambda: identify.plant(times, pressures, volume_m3=VOLUME, opened_s=15000.0),
        lambda: identify.plant(times, [0.0] * len(times), volume_m3=VOLUME),
        lambda: identify.plant(times[::-1], pressures, volume_m3=VOLUME),
    )
    for wrong in refused:
        with pytest.raises(pv.Usage):
            wrong()


PENDING = """
import os, signal, threading
from profivac import identify
import test_offline
signal.signal(signal.SIGINT, signal.default_int_handler)  # A shell may have started the tests with the signal ignored.
times, pressures = test_offline.record(noise=0.002)
try:
    threading.Timer(0, os.kill, (os.getpid(), signal.SIGINT)).start()
    while True:
        identify.plant(times, pressures, volume_m3=0.05, closed_s=14400.0)
except KeyboardInterrupt:
    print("interrupted")
"""


def test_ctrl_c_ends_a_fit(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parent)}
    command = [sys.executable, "-c", PENDING]
    result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment, timeout=300)
    assert (result.returncode, result.stdout) == (0, "interrupted\n"), result.stderr
