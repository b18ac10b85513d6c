"""Virtual gauges in memory."""

from __future__ import annotations

from collections.abc import Mapping
from types import TracebackType
from typing import TYPE_CHECKING

from . import _profivac
from ._bus import Bus
from ._errors import Usage
from ._types import Unit, unit_of

if TYPE_CHECKING:
    from typing_extensions import Self


class _Segment:
    """Virtual gauges on a line in memory, with a bus to them."""

    def __init__(self, core: _profivac.Segment, names: Mapping[str, int], via: str, master: int, timeout: float) -> None:
        self._core = core
        self.bus = Bus(core.bus(master, timeout), names, via)
        """The bus to the devices."""

    @property
    def closed(self) -> bool:
        """Whether the bus is closed, and with it the devices are gone."""
        return self.bus.closed

    def power(self, address: int, on: bool) -> None:
        """Switches a device on or off. Without power it does not answer."""
        self._core.power(address, on)

    def fault(self, address: int, name: str) -> None:
        """Sets a fault: ``eeprom``, ``sensor1``, ``unplugged1`` ... An unknown name raises ``Usage`` with those of the device."""
        self._core.fault(address, name, True)

    def clear(self, address: int, name: str) -> None:
        """Clears a fault."""
        self._core.fault(address, name, False)

    def close(self) -> None:
        """Ends the bus and the devices. May be called twice."""
        self.bus.close()
        self._core.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


class PlantSegment(_Segment):
    """The virtual gauges of a plant, and a bus to them. Use :meth:`profivac.vacuum.Plant.segment`.

    Time passes only in :meth:`profivac.vacuum.Plant.advance`.
    """


def _pressure(value: str | float, unit: Unit | str | None) -> str:
    """The text of a pressure, which always has a unit."""
    if isinstance(value, str) and unit is None:
        return value
    if isinstance(value, (int, float)) and not isinstance(value, bool) and unit is not None:
        return f"{float(value)!r} {unit_of(unit).value}"
    raise Usage(f"expected a pressure like '5e-6 mbar', or a number with a unit, got {value!r} with the unit {unit!r}")


class VirtualSegment(_Segment):
    """Virtual gauges around one chamber, and a bus to them.

    A device is written as for ``profivac simulate``: ``bcg450@5``, ``psg550@6:unit=torr``, ``my-gauge.toml@7``; the bus knows its
    file. With ``seed`` the sensors are real ones: they lag, drift and are noisy.

    >>> import profivac as pv
    >>> with pv.VirtualSegment("psg550@5", pressure="2e-2 mbar") as chamber:
    ...     gauge = chamber.bus[5]
    ...     change = gauge.command("execute")
    ...     before = gauge.read(pv.Unit.MBAR).value
    ...     chamber.pressure = "5 mbar"
    ...     f"{before:.1e}", f"{gauge.read(pv.Unit.MBAR).value:.1e}"
    ('2.0e-02', '5.0e+00')
    """

    def __init__(
        self,
        *devices: str,
        pressure: str | float = "1e-3 mbar",
        unit: Unit | str | None = None,
        atmosphere: str = "1013.25 mbar",
        gas: str = "n2",
        seed: int | None = None,
        names: Mapping[str, int] | None = None,
        via: str = "ms2",
        master: int = 0,
        timeout: float = 5.0,
    ) -> None:
        pressure = _pressure(pressure, unit)
        core = _profivac.Segment(list(devices), pressure, atmosphere, gas, seed)
        self._values = {"pressure": pressure, "atmosphere": atmosphere, "gas": gas}
        super().__init__(core, names or {}, via, master, timeout)

    def _set(self, quantity: str, value: str) -> None:
        self._core.set(quantity, value)
        self._values[quantity] = value

    @property
    def pressure(self) -> str:
        """The true pressure in the chamber, with its unit. The devices react to a new one at once, except real sensors."""
        return self._values["pressure"]

    @pressure.setter
    def pressure(self, value: str) -> None:
        self.set_pressure(value)

    def set_pressure(self, value: str | float, unit: Unit | str | None = None) -> None:
        """Sets the true pressure: a text with its unit, or a number in ``unit``.

        >>> import profivac as pv
        >>> with pv.VirtualSegment("psg550@5", pressure=0.02, unit="mbar") as chamber:
        ...     chamber.set_pressure(5.0, pv.Unit.PA)
        ...     chamber.pressure
        '5.0 Pa'
        """
        self._set("pressure", _pressure(value, unit))

    @property
    def atmosphere(self) -> str:
        """The pressure outside, with its unit."""
        return self._values["atmosphere"]

    @atmosphere.setter
    def atmosphere(self, value: str) -> None:
        self._set("atmosphere", value)

    @property
    def gas(self) -> str:
        """The gas in the chamber, such as ``n2``, ``ar`` or ``he``."""
        return self._values["gas"]

    @gas.setter
    def gas(self, value: str) -> None:
        self._set("gas", value)

    def advance(self, seconds: float) -> None:
        """Lets time pass for the devices: timers, run hours, degas, ignition."""
        self._core.advance(seconds)
