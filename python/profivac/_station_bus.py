"""A station as a bus: its gauges are read over HTTP."""

from __future__ import annotations

import contextlib
import weakref
from collections.abc import Iterator, Mapping
from os import PathLike
from typing import Any, NoReturn

from . import _profivac
from ._bus import Bus, Exchange, Gauge, Words, tables
from ._errors import Connection, ProfivacError, Usage
from ._types import Change, Command, Difference, Parameter, Reading, Restored, Station, Unit, Value, unit_of
from .station import RemoteStation, never_read, reading_of


def _only_read(what: str) -> NoReturn:
    raise Usage(f"a station is only read, it does not {what} for a program; use its page, or a port of this computer")


class StationBus(Bus):
    """A station as a bus. ``profivac.open("http://127.0.0.1:8080")`` returns it.

    The gauges have the names of the station; an address is enough where only one of its segments has it. They are read: ``read``,
    ``pressure``, ``get``, ``stream``, ``parameters`` and their forms for asyncio. The station stays the master of its lines, so whatever
    writes, takes ownership or needs the octets of the line raises :class:`profivac.Usage`.

    >>> import profivac as pv
    >>> with pv.open("http://127.0.0.1:8080") as bus:  # doctest: +SKIP
    ...     for gauge, reading in bus.stream("chamber", "fore-line", interval=10):
    ...         print(gauge.name, reading)
    """

    def __init__(self, station: RemoteStation, names: Mapping[str, int]) -> None:
        self.station = station
        """The station, for history and events."""
        self._names = dict(names)
        self._gauges: dict[int, Gauge] = {}
        self._by_name: dict[str, Gauge] = {}
        self._closed = False
        station.gauges()

    def gauge(self, which: int | str) -> Gauge:
        """The gauge with a name of the station, with a name of ``open(..., names={...})``, or at an address."""
        self._check_open()
        if isinstance(which, str) and which in self._by_name:
            return self._by_name[which]
        row = self._row(which)
        name = row["name"]
        if name not in self._by_name:
            self._by_name.setdefault(name, StationGauge(self, row))
        return self._by_name[name]

    def _row(self, which: int | str) -> dict[str, Any]:
        rows = self.station.rows()
        known = ", ".join(repr(row["name"]) for row in rows) or "none"
        address = self._names.get(which, which) if isinstance(which, str) else which
        found = [row for row in rows if address in (row["name"], row["address"])]
        if not found:
            raise Usage(f"the station has no gauge {which!r}; known: {known}")
        if len(found) > 1:
            raise Usage(f"the station has several gauges at address {address}; use a name out of {known}")
        return found[0]

    def _check_open(self) -> None:
        if self._closed:
            raise Connection("the bus is closed; open it again")

    def scan(self, first: int = 0, last: int = 126) -> list[Station]:
        """The gauges of the station at these addresses. Nothing is sent on its lines; what a station does not tell is ``None``."""
        self._check_open()
        rows = [row for row in self.station.rows() if first <= row["address"] <= last]
        return [Station(row["address"], "slave", None, (row["device"],), row["state"], None) for row in rows]

    def close(self) -> None:
        """Ends the session of a user at the station. May be called twice."""
        if not self._closed:
            self._closed = True
            # A station that is gone has no session to end.
            with contextlib.suppress(ProfivacError):
                self.station.log_out()

    def __del__(self) -> None:
        # A request would not be possible at the end of the interpreter.
        pass


class StationGauge(Gauge):
    """A gauge of a station. Use :class:`StationBus`.

    >>> import profivac as pv
    >>> with pv.open("http://127.0.0.1:8080") as bus:  # doctest: +SKIP
    ...     reading = bus["chamber"].read(pv.Unit.MBAR)
    ...     print(reading, reading.time, bus["chamber"]["device.device-state"])
    """

    def __init__(self, bus: StationBus, row: dict[str, Any]) -> None:
        self._bus: StationBus = bus
        self._exchanges: weakref.WeakSet[Exchange] = weakref.WeakSet()
        self.address = row["address"]
        self.name: str = row["name"]
        self._device: str = row["device"]
        self._tables: tuple[dict[str, Parameter], dict[str, Command]] | None = None

    def _identity(self) -> tuple[str, str, str, int]:
        return _profivac.model_of(self._device)

    def _known(self) -> tuple[dict[str, Parameter], dict[str, Command]]:
        if self._tables is None:
            self._tables = tables(_profivac.parameters_of(self._device))
        return self._tables

    def read(self, unit: Unit | str = Unit.PA, *, part: str | None = None) -> Reading:
        """The latest reading that the station has, with the time at which the gauge gave it."""
        wanted = unit_of(unit)
        self._bus._check_open()
        gauge = self._bus.station.row(self.name)
        rows: list[dict[str, Any]] = gauge["readings"]
        if part is not None:
            name = f"{part}{'/' if '.' in part else '.'}process-value"
            if name not in self.parameters:
                raise Usage(f"{self._device} has no part {part!r}; Gauge.parameters has the names")
            instance = self.parameters[name].instance
            rows = [row for row in rows if row["instance"] == instance]
            if gauge["readings"] and not rows:
                raise Usage(f"the cyclic data of the station do not have {part!r} of {self.name!r}")
        if not gauge["readings"]:
            return never_read(gauge, wanted)
        row = next((row for row in rows if row["quality"] == "valid"), rows[0])
        return reading_of(row, gauge["read_ms"], wanted)

    def get(self, name: str) -> Value:
        """A parameter, which the station reads from the gauge now, together with all others: this takes seconds.

        ``octets`` is empty: a station gives the value and not the record.
        """
        self._bus._check_open()
        if name not in self.parameters:
            raise Usage(f"{self._device} has no parameter {name!r}; Gauge.parameters lists the names")
        for block in self._bus.station.blocks(self.name):
            for row in block["parameters"]:
                if row["target"] == name:
                    if row["value"] is None:
                        raise Connection(f"the station cannot read {name} of {self.name!r}: {row['read_error']}")
                    return _value(self.parameters[name], row["value"])
        raise Usage(f"the station does not read {name} of {self.name!r}")

    def set(self, name: str, value: Words, *, force: bool = False, confirm: bool = False) -> Change:
        """Raises ``Usage``: a station is only read."""
        _only_read("write parameters")

    def command(self, words: str, *, confirm: bool = False) -> Change:
        """Raises ``Usage``: a station is only read."""
        _only_read("send commands")

    def dump(self, file: str | PathLike[str] | None = None) -> str:
        """Raises ``Usage``: a station is only read."""
        _only_read("write settings files")

    def diff(self, settings: str | PathLike[str]) -> list[Difference]:
        """Raises ``Usage``: a station is only read."""
        _only_read("compare settings files")

    def restore(self, settings: str | PathLike[str], *, force: bool = False) -> list[Restored]:
        """Raises ``Usage``: a station is only read."""
        _only_read("write settings")

    def exchange(self, unit: Unit | str = Unit.PA) -> Exchange:
        """Raises ``Usage``: the station owns its gauges. ``Bus.stream`` gives its readings."""
        _only_read("give its gauges away")

    @contextlib.contextmanager
    def selector_kept(self) -> Iterator[Gauge]:
        """Does nothing: the station keeps the selector."""
        yield self

    @contextlib.contextmanager
    def connection_kept(self, idle: float = 2.0) -> Iterator[Gauge]:
        """Does nothing: the station has the connections."""
        yield self


def _value(parameter: Parameter, text: str) -> Value:
    """A value from its text: a word of the manual, a Boolean, a number with its unit, or text."""
    if parameter.choices:
        return Value(parameter.name, text, text, None, None, b"")
    if parameter.type == "BOOLEAN" and text in ("true", "false"):
        return Value(parameter.name, text == "true", text, None, None, b"")
    number, _, unit = text.partition(" ")
    is_number = parameter.type.startswith(("FLOAT", "BY_TYPE", "INT", "UINT", "BOOLEAN"))
    for kind in (int, float) if is_number else ():
        with contextlib.suppress(ValueError):
            return Value(parameter.name, kind(number), text, unit or None, _pascal(text), b"")
    return Value(parameter.name, text, text, None, None, b"")


def _pascal(text: str) -> float | None:
    try:
        return _profivac.convert(text)
    except Usage:
        return None
