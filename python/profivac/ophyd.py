"""A gauge as a device of ophyd-async, for Bluesky plans. Needs the extra ``profivac[ophyd]``.

>>> import asyncio
>>> import profivac as pv
>>> from profivac.ophyd import VacuumGauge
>>> async def main() -> None:
...     with pv.open("sim:bcg450@5", names={"chamber": 5}) as bus:
...         bus["chamber"].command("execute")
...         chamber = VacuumGauge(lambda: bus["chamber"], name="chamber")
...         await chamber.connect()
...         row = await chamber.read()
...         print(f"{row['chamber-pressure']['value']:.3f} Pa", row["chamber-state"]["value"].value)
>>> asyncio.run(main())
0.100 Pa valid
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import Callable

from bluesky.protocols import Reading as Row
from event_model import DataKey
from ophyd_async.core import (
    Callback,
    SignalBackend,
    SignalDatatypeT,
    SignalMetadata,
    SignalR,
    StandardReadable,
    StandardReadableFormat,
    StrictEnum,
    make_datakey,
)

from ._bus import Gauge
from ._errors import ProfivacError
from ._types import Reading, State, Unit


class GaugeState(StrictEnum):
    """The words of :class:`profivac.State` as choices of a signal."""

    VALID = State.VALID.value
    OVERRANGE = State.OVERRANGE.value
    UNDERRANGE = State.UNDERRANGE.value
    FAULT = State.FAULT.value
    STALE = State.STALE.value
    OFF = State.OFF.value
    MISSING = State.MISSING.value
    ASSUMED = State.ASSUMED.value


_LOWEST_PA = 1e-9
"""The lowest pressure of any gauge."""


def _decimals(unit: Unit) -> int:
    """Decimals with which the lowest pressure has two digits where a client, such as LiveTable, shows no exponent."""
    return max(0, math.ceil(1 - math.log10(unit.from_pa(_LOWEST_PA))))


class _Source:
    """A gauge whose signals share a request: those that ask while it is under way get its reading."""

    def __init__(self, gauge: Callable[[], Gauge], unit: Unit, part: str | None, interval: float) -> None:
        self._open = gauge
        self._gauge: Gauge | None = None
        self._pending: asyncio.Task[Reading] | None = None
        self.unit = unit
        self.part = part
        self.interval = interval

    async def reading(self) -> Reading:
        if self._pending is None or self._pending.done():
            self._pending = asyncio.create_task(self._request())
        # The end of one waiting signal does not end the request of the others.
        return await asyncio.shield(self._pending)

    async def _request(self) -> Reading:
        if self._gauge is None:
            self._gauge = await asyncio.to_thread(self._open)
        return await self._gauge.read_async(self.unit, part=self.part)


class _Backend(SignalBackend[SignalDatatypeT]):
    """One signal of a gauge."""

    def __init__(
        self,
        datatype: type[SignalDatatypeT],
        source: _Source,
        of: Callable[[Reading], SignalDatatypeT],
        units: str | None,
        precision: int | None = None,
    ) -> None:
        super().__init__(datatype)
        self._type = datatype
        self._source = source
        self._of = of
        self._units = units
        self._precision = precision
        self._watch: asyncio.Task[None] | None = None

    def source(self, name: str, read: bool) -> str:
        return f"profivac://{name}"

    async def connect(self, timeout: float) -> None:
        """Reads the gauge once, so that a gauge that does not answer is known now."""
        await asyncio.wait_for(self._source.reading(), timeout)

    async def put(self, value: SignalDatatypeT | None) -> None:
        raise NotImplementedError("a reading of a gauge cannot be set")

    async def get_datakey(self, source: str) -> DataKey:
        value = await self.get_value()
        metadata: SignalMetadata = {"units": self._units} if self._units else {"choices": [state.value for state in State]}
        if self._precision is not None:
            metadata["precision"] = self._precision
        return make_datakey(self._type, value, source, metadata)

    async def get_reading(self) -> Row[SignalDatatypeT]:
        return self._row(await self._source.reading())

    def _row(self, reading: Reading) -> Row[SignalDatatypeT]:
        # Bluesky counts 0 as no alarm and 3 as a value that is not valid.
        return {
            "value": self._of(reading),
            # Bluesky demands a time; a gauge of a station that never gave a reading has none.
            "timestamp": time.time() if reading.time is None else reading.time.timestamp(),
            "alarm_severity": 0 if reading.valid else 3,
        }

    async def get_value(self) -> SignalDatatypeT:
        return self._of(await self._source.reading())

    async def get_setpoint(self) -> SignalDatatypeT:
        raise NotImplementedError("a reading of a gauge has no setpoint")

    def set_callback(self, callback: Callback[Row[SignalDatatypeT]] | None) -> None:
        if self._watch is not None:
            self._watch.cancel()
        self._watch = None if callback is None else asyncio.create_task(self._poll(callback))

    async def _poll(self, callback: Callback[Row[SignalDatatypeT]]) -> None:
        """A gauge does not report changes by itself."""
        while True:
            with contextlib.suppress(ProfivacError):
                callback(await self.get_reading())
            await asyncio.sleep(self._source.interval)


def _pressure(reading: Reading) -> float:
    return float("nan") if reading.value is None else reading.value


def _state(reading: Reading) -> GaugeState:
    return GaugeState(reading.state.value)


class VacuumGauge(StandardReadable):
    """A gauge with the signals ``pressure`` and ``state``.

    ``gauge`` is called at the first connection and returns the gauge, so ``connect(mock=True)`` opens no port.
    ``unit`` is the unit of the pressure, ``part`` as in :meth:`profivac.Gauge.read`, ``interval`` the time between two readings of a
    subscription in s, ``precision`` the decimals with which Bluesky shows the pressure: it shows no exponent, so by default they suffice for
    the lowest pressure of any gauge.
    """

    pressure: SignalR[float]
    """The pressure in ``unit``; not a number (``nan``) unless ``state`` is ``valid``."""
    state: SignalR[GaugeState]
    """Whether the gauge measures, and if not, why."""

    def __init__(
        self,
        gauge: Callable[[], Gauge],
        unit: Unit = Unit.PA,
        *,
        part: str | None = None,
        interval: float = 1.0,
        precision: int | None = None,
        name: str = "",
    ) -> None:
        source = _Source(gauge, unit, part, interval)
        with self.add_children_as_readables(StandardReadableFormat.HINTED_UNCACHED_SIGNAL):
            decimals = _decimals(unit) if precision is None else precision
            self.pressure = SignalR(_Backend(float, source, _pressure, unit.value, decimals))
        with self.add_children_as_readables(StandardReadableFormat.UNCACHED_SIGNAL):
            self.state = SignalR(_Backend(GaugeState, source, _state, None))
        super().__init__(name=name)
