"""The values that gauges give: readings, parameters, stations, changes."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from datetime import datetime

from ._errors import Usage


class Unit(enum.Enum):
    """A unit of pressure.

    >>> Unit.MBAR.from_pa(101325.0)
    1013.25
    >>> Unit.TORR.to_pa(760.0)
    101325.0
    """

    PA = "Pa"
    HPA = "hPa"
    MBAR = "mbar"
    KPA = "kPa"
    BAR = "bar"
    TORR = "Torr"
    MTORR = "mTorr"
    MICRON = "micron"

    def from_pa(self, pascal: float) -> float:
        """A pressure in Pa, in this unit."""
        numerator, denominator = _PA[self]
        return pascal * denominator / numerator

    def to_pa(self, value: float) -> float:
        """A pressure in this unit, in Pa."""
        numerator, denominator = _PA[self]
        return value * numerator / denominator


def unit_of(unit: Unit | str) -> Unit:
    """A unit, or the unit with this name in any case: ``mbar``, ``torr``.

    >>> unit_of("torr") is unit_of(Unit.TORR) is Unit.TORR
    True
    """
    if isinstance(unit, Unit):
        return unit
    found = [known for known in Unit if isinstance(unit, str) and known.value.lower() == unit.strip().lower()]
    if not found:
        raise Usage(f"expected a unit, one of {', '.join(known.value for known in Unit)}, got {unit!r}")
    return found[0]


# Pa per unit as a fraction: 760 Torr are exactly 101325 Pa.
_PA: dict[Unit, tuple[float, float]] = {
    Unit.PA: (1.0, 1.0),
    Unit.HPA: (100.0, 1.0),
    Unit.MBAR: (100.0, 1.0),
    Unit.KPA: (1000.0, 1.0),
    Unit.BAR: (100000.0, 1.0),
    Unit.TORR: (101325.0, 760.0),
    Unit.MTORR: (101325.0, 760000.0),
    Unit.MICRON: (101325.0, 760000.0),
}


class State(enum.Enum):
    """Whether a reading is a pressure, and if not, why. The words are those of the HTTP API and of exports."""

    VALID = "valid"
    """The gauge measures."""
    OVERRANGE = "overrange"
    """The pressure is above the range of the gauge; only the end of the range is known."""
    UNDERRANGE = "underrange"
    """The pressure is below the range of the gauge; only the end of the range is known."""
    FAULT = "fault"
    """The gauge reports a defect, or a number that is no pressure."""
    STALE = "stale"
    """The gauge gives no data, or gave the last ones too long ago."""
    OFF = "off"
    """The gauge does not measure because it is in IDLE, or its emission or heating is off; this is no defect."""
    MISSING = "missing"
    """No gauge is connected to the channel of the controller."""
    ASSUMED = "assumed"
    """A listener knows the octets and not their unit."""


@dataclass(frozen=True)
class Reading:
    """A pressure with its state.

    ``value`` is in ``unit``, and ``None`` unless ``state`` is ``State.VALID``: the end of a range is never given as a pressure.

    >>> from datetime import datetime, timezone
    >>> now = datetime(2026, 11, 22, tzinfo=timezone.utc)
    >>> reading = Reading(5.2e-4, Unit.PA, State.VALID, now)
    >>> print(reading.to(Unit.MBAR))
    5.200e-06 mbar
    >>> print(reading)
    5.200e-04 Pa
    >>> print(Reading(None, Unit.PA, State.UNDERRANGE, now, bounds=(None, 1e-8)))
    underrange (below 1.000e-08 Pa)
    """

    value: float | None
    unit: Unit
    state: State
    time: datetime | None
    """When the answer arrived, in UTC; over a station, when the gauge gave the reading. ``None`` of a gauge that never gave one."""
    bounds: tuple[float | None, float | None] = (None, None)
    """What is known without a value, in ``unit``: ``(None, x)`` below x, ``(x, None)`` above x."""
    cause: str | None = None
    """More about the state, in the words of the manual."""
    instance: int = 0
    """The part of the gauge or the channel of the controller that measured."""

    @property
    def valid(self) -> bool:
        """Whether there is a pressure."""
        return self.state is State.VALID

    def to(self, unit: Unit | str) -> Reading:
        """The same reading in another unit."""
        target = unit_of(unit)

        def converted(value: float | None) -> float | None:
            return None if value is None else target.from_pa(self.unit.to_pa(value))

        low, high = self.bounds
        return Reading(
            converted(self.value),
            target,
            self.state,
            self.time,
            (converted(low), converted(high)),
            self.cause,
            self.instance,
        )

    def __str__(self) -> str:
        if self.value is not None:
            return f"{self.value:.3e} {self.unit.value}"
        low, high = self.bounds
        if high is not None:
            return f"{self.state.value} (below {high:.3e} {self.unit.value})"
        if low is not None:
            return f"{self.state.value} (above {low:.3e} {self.unit.value})"
        return f"{self.state.value}: {self.cause}" if self.cause else self.state.value


@dataclass(frozen=True)
class Value:
    """A parameter that was read.

    ``value`` is a ``bool``, a number, the manual's word for a code (``str``), text, or octets (``bytes``). A pressure is a number in
    the present unit of the gauge, which is ``unit``.
    """

    name: str
    value: bool | int | float | str | bytes
    text: str
    """The value as text, with its unit."""
    unit: str | None
    pascal: float | None
    """The value in Pa, of a pressure that is one."""
    octets: bytes
    """The record as the gauge sent it."""

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True)
class Parameter:
    """A row in the tables of a device, in the words of the manual."""

    name: str
    printed: str
    """The name as printed in the manual."""
    slot: int
    instance: int
    index: int
    type: str
    access: str
    """As printed: ``1_R`` read by a class 1 master, ``2_W`` written by class 2, ``0_XI`` in the cyclic data."""
    source: str
    """The section of the manual."""
    choices: tuple[str, ...]
    """The words that it accepts; empty for a number or a text."""
    bounds: tuple[float, float] | None
    """The lowest and the highest number."""
    readable: bool
    writable: bool
    setting: bool
    """It survives power loss and is cloned by ``dump`` and ``restore``."""


@dataclass(frozen=True)
class Command:
    """A command of a device. ``risk`` says what damage it can do; empty if it is harmless."""

    name: str
    risk: str


@dataclass(frozen=True)
class Station:
    """A station that answered a scan."""

    address: int
    kind: str
    """``slave``, or the state of a master."""
    ident: int | None
    """The Ident_Number of a slave."""
    devices: tuple[str, ...]
    """The devices with this number; empty for a device that profivac does not know."""
    state: str | None
    owner: int | None
    """The master that owns the slave."""


@dataclass(frozen=True)
class Change:
    """A parameter that was written. ``before`` and ``after`` are ``None`` if it cannot be read."""

    name: str
    written: str
    before: Value | None
    after: Value | None


@dataclass(frozen=True)
class Difference:
    """A setting that differs between a gauge and a file."""

    name: str
    gauge: str
    file: str


@dataclass(frozen=True)
class Restored:
    """A setting that was written: its value ``after``, or the ``error`` why it is unchanged."""

    name: str
    before: str
    after: str | None
    error: str | None
