"""A bus and its gauges."""

from __future__ import annotations

import asyncio
import atexit
import contextlib
import time
import weakref
from collections.abc import AsyncIterator, Iterator, Mapping
from datetime import datetime, timezone
from os import PathLike
from pathlib import Path
from types import TracebackType

from . import _profivac
from ._errors import ProfivacError, Usage
from ._types import Change, Command, Difference, Parameter, Reading, Restored, State, Station, Unit, Value, unit_of

Words = str | bool | int | float
"""What a parameter is written with: a word, a pressure with its unit, a number, a Boolean."""

_open: weakref.WeakSet[Bus] = weakref.WeakSet()


@atexit.register
def _close_all() -> None:
    """Selectors are restored at the end of the interpreter."""
    for bus in list(_open):
        bus.close()


class Bus:
    """A line on which this program is a master. Use :func:`profivac.open`.

    A bus is a context manager; closing it restores the selectors of its gauges and releases the port. Several threads may use it:
    their requests take turns.

    >>> import profivac as pv
    >>> with pv.open("sim:bcg450@5 pcg550@6", names={"chamber": 5}) as bus:
    ...     bus["chamber"].device, bus[6].device
    ('bcg450', 'pcg550')
    """

    def __init__(self, core: _profivac.Bus, names: Mapping[str, int], via: str) -> None:
        self._core = core
        if via not in ("ms2", "ms1", "pkw"):
            core.close()
            raise Usage(f"expected via to be one of ms2, ms1, pkw, got {via!r}")
        self._names = dict(names)
        self._via = via
        self._gauges: dict[int, Gauge] = {}
        self._closed = False
        _open.add(self)

    def gauge(self, which: int | str) -> Gauge:
        """The gauge at an address, or with a name of ``open(..., names={...})``. Sends nothing yet.

        >>> import profivac as pv
        >>> with pv.open("sim:psg550@5", names={"fore-line": 5}) as bus:
        ...     bus.gauge("fore-line") is bus[5]
        True
        """
        address = self._address(which)
        if address not in self._gauges:
            core = self._core.gauge(address, self._via)
            # Two threads may ask for the same gauge at the same time.
            self._gauges.setdefault(address, Gauge(core, self, address, self._name_of(address)))
        return self._gauges[address]

    def __getitem__(self, which: int | str) -> Gauge:
        return self.gauge(which)

    def _name_of(self, address: int) -> str | None:
        return next((name for name, known in self._names.items() if known == address), None)

    def _address(self, which: int | str) -> int:
        if isinstance(which, str):
            if which not in self._names:
                known = ", ".join(self._names) or "none; open(..., names={'chamber': 5}) gives names"
                raise Usage(f"no gauge has the name {which!r}; known: {known}")
            which = self._names[which]
        if not isinstance(which, int) or isinstance(which, bool) or not 0 <= which <= 126:
            raise Usage(f"expected an address from 0 to 126 or a name, got {which!r}")
        return which

    def scan(self, first: int = 0, last: int = 126) -> list[Station]:
        """The stations that answer. Sends requests for status and diagnosis only, never Set_Prm.

        An address without a station costs a slot time: a whole bus at 19.2 kbit/s takes a few seconds.

        >>> import profivac as pv
        >>> with pv.open("sim:bcg450@5") as bus:
        ...     [(station.address, station.devices, station.owner) for station in bus.scan(4, 6)]
        [(5, ('bcg450',), None)]
        """
        rows = self._core.scan(self._address(first), self._address(last))
        return [Station(address, kind, ident, tuple(devices), state, owner) for address, kind, ident, devices, state, owner in rows]

    def stream(self, *gauges: int | str, interval: float = 1.0, unit: Unit | str = Unit.PA) -> Iterator[tuple[Gauge, Reading]]:
        """Readings of these gauges in turn, every ``interval`` seconds, without an end. Takes no ownership.

        >>> import profivac as pv
        >>> with pv.open("sim:psg550@5 psg550@6") as bus:
        ...     for gauge, reading in bus.stream(5, 6, interval=0):
        ...         if gauge.address == 6:
        ...             break
        """
        watched = [self.gauge(which) for which in gauges]
        if not watched:
            raise Usage("expected the gauges to watch, got none; Bus.scan() shows the stations of the bus")
        due = time.monotonic()
        while True:
            for gauge in watched:
                yield gauge, gauge.read(unit)
            due = max(due + interval, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))

    async def stream_async(
        self, *gauges: int | str, interval: float = 1.0, unit: Unit | str = Unit.PA
    ) -> AsyncIterator[tuple[Gauge, Reading]]:
        """:meth:`stream` for asyncio.

        >>> import asyncio
        >>> import profivac as pv
        >>> async def first() -> int:
        ...     with pv.open("sim:psg550@5") as bus:
        ...         async for gauge, reading in bus.stream_async(5):
        ...             return gauge.address
        ...     raise AssertionError
        >>> asyncio.run(first())
        5
        """
        watched = [self.gauge(which) for which in gauges]
        if not watched:
            raise Usage("expected the gauges to watch, got none; Bus.scan() shows the stations of the bus")
        while True:
            due = time.monotonic() + interval
            for gauge in watched:
                yield gauge, await gauge.read_async(unit)
            await asyncio.sleep(max(0.0, due - time.monotonic()))

    @property
    def closed(self) -> bool:
        """Whether the bus is closed."""
        return self._closed

    def close(self) -> None:
        """Ends exchanges, restores the selectors of the gauges and releases the port. May be called twice."""
        self._closed = True
        for gauge in list(self._gauges.values()):
            for exchange in list(gauge._exchanges):
                exchange.close()
            gauge._core.close()
        self._core.close()
        _open.discard(self)

    def __del__(self) -> None:
        if hasattr(self, "_gauges"):
            self.close()

    def __enter__(self) -> Bus:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


class Gauge:
    """A gauge of a bus.

    >>> import profivac as pv
    >>> with pv.open("sim:bcg450@5:unit=mbar") as bus:
    ...     gauge = bus[5]
    ...     gauge["pirani.safe-value"] = "12.5 Pa"
    ...     print(gauge["pirani.safe-value"])
    0.125 mbar
    """

    def __init__(self, core: _profivac.Gauge, bus: Bus, address: int, name: str | None) -> None:
        self._core = core
        # The bus stays open while one of its gauges is in use.
        self._bus = bus
        self._exchanges: weakref.WeakSet[Exchange] = weakref.WeakSet()
        self.address = address
        """The station address."""
        self.name = name
        """The name of ``open(..., names={...})``."""
        self._idle_times: list[float] = []
        self._model: tuple[str, str, str, int] | None = None
        self._tables: tuple[dict[str, Parameter], dict[str, Command]] | None = None

    def __repr__(self) -> str:
        return f"<profivac.Gauge {self.name or ''}@{self.address}>"

    def _identity(self) -> tuple[str, str, str, int]:
        if self._model is None:
            self._model = self._core.model()
        return self._model

    @property
    def device(self) -> str:
        """The device by its name in profivac, such as ``bcg450``. Asks the gauge once.

        A TPG 300 and a TPG 500 cannot be told apart over the parameter channel: ``tpg300 or tpg500``.
        """
        return self._identity()[0]

    @property
    def title(self) -> str:
        """The device by its name in the manual."""
        return self._identity()[1]

    @property
    def ident(self) -> int:
        """The Ident_Number of the slave."""
        return self._identity()[3]

    def read(self, unit: Unit | str = Unit.PA, *, part: str | None = None) -> Reading:
        """Reads the pressure: of the part that measures, or of ``part``, such as ``pirani`` or ``channel.2``.

        A gauge in IDLE gives ``State.OFF``; ``gauge.command("execute")`` starts it.

        >>> import profivac as pv
        >>> with pv.open("sim:bcg450@5") as bus:
        ...     before = bus[5].read().state
        ...     change = bus[5].command("execute")
        ...     before, str(bus[5].read(pv.Unit.MBAR))
        (<State.OFF: 'off'>, '1.000e-03 mbar')
        """
        wanted = unit_of(unit)
        name = None if part is None else f"{part}{'/' if '.' in part else '.'}process-value"
        return _reading(self._core.pressure(name), wanted)

    def pressure(self, unit: Unit | str = Unit.PA) -> float:
        """The pressure as a number in ``unit``; not a number (``nan``) unless the reading is valid.

        >>> import profivac as pv
        >>> with pv.open("sim:psg550@5") as bus:
        ...     off = bus[5].pressure()
        ...     change = bus[5].command("execute")
        ...     print(off, f"{bus[5].pressure(pv.Unit.MBAR):.1e}")
        nan 1.0e-03
        """
        value = self.read(unit).value
        return float("nan") if value is None else value

    async def read_async(self, unit: Unit | str = Unit.PA, *, part: str | None = None) -> Reading:
        """:meth:`read` for asyncio. A cancelled request still runs to its end in the thread of the bus.

        >>> import asyncio
        >>> import profivac as pv
        >>> with pv.open("sim:psg550@5") as bus:
        ...     print(asyncio.run(bus[5].read_async()).state)
        State.OFF
        """
        return await asyncio.to_thread(self.read, unit, part=part)

    def get(self, name: str) -> Value:
        """Reads a parameter: ``pirani.process-value``, ``trip-point.1/low-trip-point``, or ``1:2/19`` for slot 1, instance 2, index 19.

        >>> import profivac as pv
        >>> with pv.open("sim:bcg450@5:unit=mbar") as bus:
        ...     full_scale = bus[5].get("pirani.full-scale")
        >>> full_scale.value, full_scale.unit, full_scale.pascal
        (1000.0, 'mbar', 100000.0)
        """
        return _value(self._core.read(name))

    async def get_async(self, name: str) -> Value:
        """:meth:`get` for asyncio."""
        return await asyncio.to_thread(self.get, name)

    def set(self, name: str, value: Words, *, force: bool = False, confirm: bool = False) -> Change:
        """Writes a parameter and reads it back.

        ``value`` is one of the words ``gauge.parameters[name].choices``, a number, a Boolean, or a pressure with its unit: ``"2e-3 mbar"``.
        ``force`` allows a pressure outside the measuring range. ``confirm`` allows a command that can do damage.

        >>> import profivac as pv
        >>> with pv.open("sim:bcg450@5") as bus:
        ...     change = bus[5].set("pirani.safe-state", "full-scale")
        ...     str(change.before), str(change.after)
        ('zero', 'full-scale')
        """
        return _change(self._core.write(name, _words(value), force, confirm))

    async def set_async(self, name: str, value: Words, *, force: bool = False, confirm: bool = False) -> Change:
        """:meth:`set` for asyncio."""
        return await asyncio.to_thread(self.set, name, value, force=force, confirm=confirm)

    def __getitem__(self, name: str) -> Value:
        return self.get(name)

    def __setitem__(self, name: str, value: Words) -> None:
        self.set(name, value)

    def command(self, words: str, *, confirm: bool = False) -> Change:
        """Sends a command: ``execute``, ``stop``, ``degas on``, ``cdg.zero-adjust``.

        The conditions of the manual are checked first. A command that can do damage raises :class:`profivac.Usage` with its risk
        unless ``confirm`` is true.

        >>> import profivac as pv
        >>> with pv.VirtualSegment("bcg450@5", pressure="1e-7 mbar") as chamber:
        ...     change = chamber.bus[5].command("execute")
        ...     try:
        ...         change = chamber.bus[5].command("degas on")
        ...     except pv.Usage as error:
        ...         print("nothing was sent" in str(error))
        True
        """
        return _change(self._core.command(words, confirm))

    async def command_async(self, words: str, *, confirm: bool = False) -> Change:
        """:meth:`command` for asyncio."""
        return await asyncio.to_thread(self.command, words, confirm=confirm)

    @property
    def parameters(self) -> dict[str, Parameter]:
        """The parameters of the device by name, from the tables of its manual.

        >>> import profivac as pv
        >>> with pv.open("sim:bcg450@5") as bus:
        ...     row = bus[5].parameters["pirani.safe-value"]
        >>> row.printed, row.slot, row.instance, row.index, row.writable
        ('Safe Value', 1, 1, 40, True)
        """
        return self._known()[0]

    @property
    def commands(self) -> dict[str, Command]:
        """The commands of the device by name, with the risk of each.

        >>> import profivac as pv
        >>> with pv.open("sim:psg550@5") as bus:
        ...     [name for name in bus[5].commands if "execute" in name]
        ['device.execute']
        """
        return self._known()[1]

    def _known(self) -> tuple[dict[str, Parameter], dict[str, Command]]:
        if self._tables is None:
            self._tables = tables(self._core.tables())
        return self._tables

    def dump(self, file: str | PathLike[str] | None = None) -> str:
        """All values of the gauge as a settings file (TOML), and written to ``file`` if one is given.

        >>> import profivac as pv
        >>> with pv.open("sim:psg550@5") as bus:
        ...     'device = "psg550"' in bus[5].dump()
        True
        """
        text = self._core.dump()
        if file is not None:
            Path(file).write_text(text, encoding="utf-8")
        return text

    def diff(self, settings: str | PathLike[str]) -> list[Difference]:
        """The settings that differ from a settings file: its path, or the text that :meth:`dump` returned.

        >>> import profivac as pv
        >>> with pv.open("sim:bcg450@5") as bus:
        ...     before = bus[5].dump()
        ...     change = bus[5].set("pirani.safe-state", "full-scale")
        ...     [(row.name, row.gauge, row.file) for row in bus[5].diff(before)]
        [('pirani.safe-state', 'full-scale', 'zero')]
        """
        return [Difference(name, gauge, file or "") for name, gauge, file, _ in self._core.diff(_settings(settings))]

    def restore(self, settings: str | PathLike[str], *, force: bool = False) -> list[Restored]:
        """Writes the settings that differ from a settings file, each read back. A file of another device raises :class:`profivac.Usage`.

        >>> import profivac as pv
        >>> with pv.open("sim:bcg450@5 bcg450@6") as bus:
        ...     change = bus[5].set("pirani.safe-state", "full-scale")
        ...     restored = bus[6].restore(bus[5].dump())
        ...     bus[6].diff(bus[5].dump())
        []
        """
        return [Restored(*row) for row in self._core.restore(_settings(settings), force)]

    def exchange(self, unit: Unit | str = Unit.PA) -> Exchange:
        """Takes ownership of the gauge and returns its cyclic data: for each exchange one reading of each channel.

        This sends Set_Prm: a gauge that measures on ownership enters EXECUTING. The unit stays as it is. Refused while another master
        owns the gauge. The end of the block releases it.

        >>> import profivac as pv
        >>> with pv.open("sim:tpg500@5") as bus, bus[5].exchange(pv.Unit.MBAR) as exchange:
        ...     [reading.instance for reading in next(exchange)]
        [1, 2, 3, 4]
        """
        wanted = unit_of(unit)
        exchange = Exchange(self._bus._core.exchange(self.address), self, wanted)
        self._exchanges.add(exchange)
        return exchange

    @contextlib.contextmanager
    def selector_kept(self) -> Iterator[Gauge]:
        """Restores the Channel Instance Selector at the end of the block, instead of when the bus is closed.

        >>> import profivac as pv
        >>> with pv.open("sim:bcg450@5") as bus:
        ...     with bus[5].selector_kept() as gauge:
        ...         overrange = gauge.get("cdg.overrange")  # The slot shows the diaphragm meanwhile.
        """
        try:
            yield self
        finally:
            self._core.restore_selector()

    @contextlib.contextmanager
    def connection_kept(self, idle: float = 2.0) -> Iterator[Gauge]:
        """Keeps the MS2 connection open within the block: several times as many readings per second.

        Without it each request asks for the identity of the gauge, opens a connection and closes it, so that other class 2 masters, such
        as an engineering tool, find a free one. A gauge has few connections (the virtual ones have two), and a kept one takes one of
        them: the gauge refuses further masters then. So it is closed after ``idle`` s without a request (0.1 to 3600) and opened again by
        the next one, and it is closed at the end of the block. It carries an Idle telegram every 5 s, and takes no ownership. After a power
        failure of the gauge the first request raises :class:`profivac.Connection`, because another gauge may be at the address; the next
        one asks for the identity again.

        >>> import profivac as pv
        >>> with pv.open("sim:psg550@5") as bus, bus[5].connection_kept() as gauge:
        ...     change = gauge.command("execute")
        ...     readings = [gauge.read() for _ in range(3)]
        """
        self._core.keep_connection(idle)
        self._idle_times.append(idle)
        try:
            yield self
        finally:
            self._idle_times.pop()
            # A block within another one leaves the connection to it. A lost line and a forked process have none to close.
            with contextlib.suppress(ProfivacError):
                self._core.keep_connection(self._idle_times[-1] if self._idle_times else None)


class Exchange:
    """The cyclic data of a gauge: an iterator, blocking and for asyncio. Use :meth:`Gauge.exchange`.

    >>> import profivac as pv
    >>> with pv.VirtualSegment("psg550@5", pressure="2 mbar") as chamber, chamber.bus[5].exchange(pv.Unit.MBAR) as exchange:
    ...     print(next(exchange)[0])
    2.000e+00 mbar
    """

    def __init__(self, core: _profivac.Cyclic, gauge: Gauge, unit: Unit) -> None:
        self._core = core
        self.gauge = gauge
        self._unit = unit

    def __iter__(self) -> Exchange:
        return self

    def __next__(self) -> list[Reading]:
        return [_reading(row, self._unit) for row in self._core.next()]

    def __aiter__(self) -> Exchange:
        return self

    async def __anext__(self) -> list[Reading]:
        return await asyncio.to_thread(self.__next__)

    def close(self) -> None:
        """Releases the gauge. May be called twice."""
        self._core.close()

    def __enter__(self) -> Exchange:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def _reading(row: _profivac._PressureRow, unit: Unit) -> Reading:
    pascal, word, cause, limit, instance = row
    state = State(word)
    end = None if limit is None else unit.from_pa(limit)
    bounds = {State.UNDERRANGE: (None, end), State.OVERRANGE: (end, None)}.get(state, (None, None))
    value = None if pascal is None else unit.from_pa(pascal)
    return Reading(value, unit, state, datetime.now(timezone.utc), bounds, cause, instance)


def _value(row: _profivac._ReadingRow) -> Value:
    return Value(*row)


def _change(row: _profivac._WriteRow) -> Change:
    name, written, before, after = row
    return Change(name, written, None if before is None else _value(before), None if after is None else _value(after))


def _words(value: Words) -> str:
    # A number of numpy prints itself with the name of its type.
    plain: Words = value.item() if hasattr(value, "item") else value
    if not isinstance(plain, (bool, int, float, str)):
        raise Usage(f"expected a word, a number or a pressure with its unit like '2e-3 mbar', got {value!r}")
    if isinstance(plain, bool):
        return "true" if plain else "false"
    return plain if isinstance(plain, str) else repr(plain)


def _settings(settings: str | PathLike[str]) -> str:
    """The text of a settings file. A text has lines, a path has none."""
    if isinstance(settings, str) and "\n" in settings:
        return settings
    try:
        return Path(settings).read_text(encoding="utf-8")
    except (OSError, UnicodeError) as error:
        raise Usage(f"{settings} cannot be read: {error}") from error


def tables(rows: _profivac._Tables) -> tuple[dict[str, Parameter], dict[str, Command]]:
    """Parameters and commands by name."""
    parameters = {
        name: Parameter(name, printed, *place, type_, access, source, tuple(choices), bounds, *flags)
        for name, printed, place, type_, access, source, choices, bounds, flags in rows[0]
    }
    return parameters, {name: Command(name, risk) for name, risk in rows[1]}
