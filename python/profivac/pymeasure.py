"""A gauge as an instrument of PyMeasure. Needs the extra ``profivac[pymeasure]``.

>>> import profivac as pv
>>> from profivac.pymeasure import VacuumGauge
>>> with pv.open("sim:bcg450@5") as bus:
...     gauge = VacuumGauge(bus[5], unit=pv.Unit.MBAR)
...     gauge.execute("execute")
...     print(f"{gauge.pressure:.1e} mbar", gauge.state)
1.0e-03 mbar valid
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pymeasure.adapters import Adapter
from pymeasure.instruments import Instrument

from ._bus import Gauge
from ._errors import Connection, Usage
from ._types import Reading, State, Unit


class GaugeAdapter(Adapter):  # type: ignore[misc]
    """Carries the commands of an instrument to a gauge.

    ``get NAME`` replies with a parameter as text, ``set NAME VALUE`` writes one, ``do WORDS`` sends a command. The adapter belongs to
    one instrument; the bus stays open when it ends.
    """

    def __init__(self, gauge: Gauge, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.gauge = gauge
        self._reply: str | None = None

    def _write(self, command: str, **kwargs: Any) -> None:
        verb, _, rest = command.partition(" ")
        if verb == "get":
            self._reply = self.gauge.get(rest).text
        elif verb == "set" and " " in rest:
            name, _, value = rest.partition(" ")
            self.gauge.set(name, value)
        elif verb == "do":
            self.gauge.command(rest)
        else:
            raise Usage(f"expected 'get NAME', 'set NAME VALUE' or 'do WORDS', got {command!r}")

    def _read(self, **kwargs: Any) -> str:
        if self._reply is None:
            raise Connection("no reply is waiting: write 'get NAME' first")
        reply, self._reply = self._reply, None
        return reply

    def __repr__(self) -> str:
        return f"<GaugeAdapter({self.gauge!r})>"


class VacuumGauge(Instrument):  # type: ignore[misc]
    """A gauge of PROFIBUS.

    A parameter of the manual becomes a property in a class of your own, such as
    ``safe_state = Instrument.control("get pirani.safe-state", "set pirani.safe-state %s", "...", cast=str)``.
    """

    def __init__(self, gauge: Gauge | Adapter, name: str = "Vacuum gauge", unit: Unit = Unit.PA, **kwargs: Any) -> None:
        adapter = GaugeAdapter(gauge) if isinstance(gauge, Gauge) else gauge
        super().__init__(adapter, name, includeSCPI=False, **kwargs)
        self._unit = unit

    device_state = Instrument.measurement(
        "get device.device-state", """Get the state of the device, such as ``EXECUTING``.""", cast=str
    )

    @property
    def unit(self) -> Unit:
        """Control the unit of :attr:`pressure`."""
        return self._unit

    @unit.setter
    def unit(self, unit: Unit | str) -> None:
        self._unit = Unit(unit)

    @property
    def reading(self) -> Reading:
        """Get pressure, state and time of one request."""
        reading: Reading = self.adapter.gauge.read(self._unit)
        return reading

    @property
    def pressure(self) -> float:
        """Get the pressure in :attr:`unit`; not a number (``nan``) unless the state is ``valid``."""
        value = self.reading.value
        return float("nan") if value is None else value

    @property
    def state(self) -> str:
        """Get the word of :class:`profivac.State`: whether the gauge measures, and if not, why."""
        state: State = self.reading.state
        return state.value

    def execute(self, words: str) -> None:
        """Send a command of the manual without a risk: ``execute``, ``stop``. An unknown one raises :class:`profivac.Usage`."""
        self.write(f"do {words}")

    @property
    def commands(self) -> Sequence[str]:
        """Get the names of the commands of the device."""
        return list(self.adapter.gauge.commands)
