"""A gauge as an instrument of QCoDeS. Needs the extra ``profivac[qcodes]``.

>>> import profivac as pv
>>> from profivac.qcodes import VacuumGauge
>>> with pv.open("sim:bcg450@5") as bus:
...     gauge = VacuumGauge("chamber", bus[5], unit=pv.Unit.MBAR)
...     change = bus[5].command("execute")
...     print(f"{gauge.pressure():.1e} {gauge.pressure.unit}", gauge.state())
...     gauge.close()
1.0e-03 mbar valid
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import partial
from typing import Any

from qcodes.instrument import Instrument
from qcodes.validators import Enum

from ._bus import Gauge
from ._errors import Usage
from ._types import State, Unit


class VacuumGauge(Instrument):
    """A gauge with the parameters ``pressure`` and ``state``, and those of the manual that ``parameters`` names.

    A parameter of the manual gets a name of Python: ``pirani.safe-state`` becomes ``pirani_safe_state``. Its words are checked before
    they are sent. Closing the instrument leaves the bus open.
    """

    def __init__(
        self, name: str, gauge: Gauge, unit: Unit = Unit.PA, parameters: Iterable[str] = (), **kwargs: Any
    ) -> None:
        super().__init__(name, **kwargs)
        self.gauge = gauge
        self.pressure = self.add_parameter(
            "pressure", unit=unit.value, label="Pressure", get_cmd=partial(gauge.pressure, unit), docstring="nan unless valid"
        )
        self.state = self.add_parameter(
            "state",
            label="State",
            get_cmd=self._state,
            vals=Enum(*(state.value for state in State)),
            docstring="Whether the gauge measures, and if not, why",
        )
        for each in parameters:
            self._add(each)

    def _state(self) -> str:
        return self.gauge.read().state.value

    def _add(self, name: str) -> None:
        row = self.gauge.parameters.get(name)
        if row is None:
            raise Usage(f"{self.gauge.device} has no parameter {name!r}; Gauge.parameters lists those it has")
        self.add_parameter(
            re.sub(r"\W", "_", name),
            label=row.printed,
            get_cmd=partial(self._get, name) if row.readable else False,
            set_cmd=partial(self.gauge.set, name) if row.writable else False,
            vals=Enum(*row.choices) if row.choices else None,
            docstring=f"{row.printed}, {row.source}",
        )

    def _get(self, name: str) -> object:
        return self.gauge.get(name).value

    def get_idn(self) -> dict[str, str | None]:
        """The device of the gauge. The vendor is not asked for."""
        return {"vendor": None, "model": self.gauge.title, "serial": None, "firmware": None}
