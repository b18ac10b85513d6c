"""A plant in the computer: chambers, valves, pumps, leaks and walls as objects, with virtual gauges on them.

All numbers are in SI units, and the names say so: Pa, m³, m³/s for speeds and conductances, Pa m³/s for flows of gas, K, s. 1 mbar l/s is
0.1 Pa m³/s, 1 l/s is 1e-3 m³/s. Time passes only in :meth:`Plant.advance`. docs/vacuum.md of the project has the formulas with their
sources and limits; "chosen" there and here marks a number without a source.

>>> from profivac.vacuum import Plant
>>> plant = Plant()
>>> chamber = plant.chamber(volume_m3=0.1)
>>> pump = plant.roughing_pump(chamber, speed_m3_s=0.01, ultimate_pa=0.5)
>>> gauge = plant.gauge("pcg550@5", chamber)
>>> with plant.segment() as segment:
...     change = segment.bus[5].command("execute")
...     pump.start()
...     plant.advance(60)
...     reading = segment.bus[5].read()
>>> print(f"{chamber.pressure_pa:.1e} Pa, the gauge shows {reading.value:.1e} Pa")
2.5e+02 Pa, the gauge shows 2.5e+02 Pa
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from . import _profivac
from ._errors import Usage
from ._virtual import PlantSegment

_ATMOSPHERE_PA = 101325.0
_ROOM_K = 293.15


class _Part:
    """A part of a plant, known to it by a number."""

    def __init__(self, plant: Plant, number: int) -> None:
        self.plant = plant
        """The plant of the part."""
        self._number = number

    @property
    def _core(self) -> _profivac.PlantModel:
        return self.plant._core


class Chamber(_Part):
    """A volume with gas. All gas has room temperature, 20 °C. Made by :meth:`Plant.chamber`.

    >>> from profivac.vacuum import Plant
    >>> Plant().chamber(volume_m3=0.1)
    <profivac.vacuum.Chamber of 0.1 m3 at 1.013e+05 Pa>
    """

    def __init__(self, plant: Plant, number: int, volume_m3: float) -> None:
        super().__init__(plant, number)
        self.volume_m3 = volume_m3
        """The volume in m³."""

    @property
    def pressure_pa(self) -> float:
        """The true pressure in Pa: the sum of the partial pressures."""
        return self._core.pressure(self._number)

    @property
    def gases_pa(self) -> dict[str, float]:
        """The partial pressures in Pa by gas, without those of 0.

        >>> from profivac.vacuum import Plant
        >>> Plant().chamber(volume_m3=0.1, pressure_pa=100, gas="ar").gases_pa
        {'ar': 100.0}
        """
        return dict(self._core.gases(self._number))

    def __repr__(self) -> str:
        return f"<profivac.vacuum.Chamber of {self.volume_m3:g} m3 at {self.pressure_pa:.3e} Pa>"


class Valve(_Part):
    """A tube or a valve between two chambers. It is open at first. Made by :meth:`Plant.valve`.

    >>> from profivac.vacuum import Plant
    >>> plant = Plant()
    >>> one, other = (plant.chamber(0.1, pressure_pa=pascal, gas="n2") for pascal in (1, 3))
    >>> valve = plant.valve(one, other, diameter_m=0.1, length_m=0.3)
    >>> valve.close()
    >>> plant.advance(60)
    >>> closed = one.pressure_pa
    >>> valve.open()
    >>> plant.advance(60)
    >>> print(f"{closed:.1f} Pa, then {one.pressure_pa:.1f} Pa")
    1.0 Pa, then 2.0 Pa
    """

    @property
    def opening(self) -> float:
        """The opening from 0 (closed) to 1 (open)."""
        return self._core.joint_opening(self._number)

    @opening.setter
    def opening(self, opening: float) -> None:
        self._core.set_joint_opening(self._number, opening)

    def open(self) -> None:
        """Opens it fully."""
        self.opening = 1.0

    def close(self) -> None:
        """Closes it."""
        self.opening = 0.0


class RoughingPump(_Part):
    """A roughing pump. It is stopped, and its valve closed, until :meth:`start`. Made by :meth:`Plant.roughing_pump`.

    >>> from profivac.vacuum import Plant
    >>> plant = Plant()
    >>> chamber = plant.chamber(0.1)
    >>> pump = plant.roughing_pump(chamber, speed_m3_s=0.005, ultimate_pa=1, speeds_m3_s={1: 0.001, 100: 0.005, 1e5: 0.004})
    >>> pump.start()
    >>> plant.advance(600)
    >>> print(f"{chamber.pressure_pa:.0f} Pa")
    1 Pa
    """

    def start(self) -> None:
        """Starts the pump."""
        self._core.run_roughing(self._number, True)

    def stop(self) -> None:
        """Stops the pump. Its valve closes."""
        self._core.run_roughing(self._number, False)


class TurboPump(_Part):
    """A turbomolecular pump. Made by :meth:`Plant.turbo_pump`.

    >>> from profivac.vacuum import Plant
    >>> plant = Plant()
    >>> chamber, fore = (plant.chamber(litres * 1e-3, pressure_pa=1, gas="n2") for litres in (100, 3))
    >>> turbo = plant.turbo_pump(chamber, fore, speed_m3_s=0.3, compression=1e10)
    >>> plant.roughing_pump(fore, speed_m3_s=0.005, ultimate_pa=1).start()
    >>> turbo.start()
    >>> plant.advance(60)
    >>> print(f"{turbo.rotor_speed:.1f}")
    0.5
    """

    def start(self) -> None:
        """Switches the motor on. The rotor needs minutes to its speed."""
        self._core.run_turbo(self._number, True)

    def stop(self) -> None:
        """Switches the motor off."""
        self._core.run_turbo(self._number, False)

    @property
    def rotor_speed(self) -> float:
        """The speed of the rotor as a fraction of the nominal one, 0 to 1."""
        return self._core.rotor_speed(self._number)


class CapturePump(_Part):
    """An ion pump, a getter or a cryopump: it keeps the gas. Stopped until :meth:`start`. Made by :meth:`Plant.capture_pump`.

    >>> from profivac.vacuum import Plant
    >>> plant = Plant(step_s=0.1)
    >>> chamber = plant.chamber(0.1, pressure_pa=1e-3, gas="n2")
    >>> pump = plant.capture_pump(chamber, speeds_m3_s={"n2": 0.1, "h2": 0.2}, capacities_pa_m3={"n2": 100})
    >>> pump.start()
    >>> plant.advance(60)
    >>> print(f"{pump.captured_pa_m3['n2']:.1e} Pa m3")
    1.0e-04 Pa m3
    """

    def start(self) -> None:
        """Starts the pump."""
        self._core.run_capture(self._number, True)

    def stop(self) -> None:
        """Stops the pump. It keeps its gas."""
        self._core.run_capture(self._number, False)

    def regenerate(self) -> None:
        """Empties the pump. The gas leaves the plant."""
        self._core.regenerate(self._number)

    @property
    def captured_pa_m3(self) -> dict[str, float]:
        """The gas in the pump by gas, in Pa m³.

        It is counted with the mean of the pressures before and after each step: too large by up to 8 % of what a step takes away where
        the pressure falls by a factor of e in a step. :meth:`Plant.balance` is exact.
        """
        return dict(self._core.captured(self._number))


class Leak(_Part):
    """A leak or a vent to the outside. Made by :meth:`Plant.leak` and :meth:`Plant.vent`.

    >>> from profivac.vacuum import Plant
    >>> plant = Plant()
    >>> chamber = plant.chamber(0.1, pressure_pa=1e-6, gas="n2")
    >>> leak = plant.leak(chamber, flow_pa_m3_s=1e-9)
    >>> leak.spray("he")
    >>> plant.advance(60)
    >>> print(f"{chamber.gases_pa['he'] * chamber.volume_m3 / 60:.1e} Pa m3/s of helium")
    2.7e-09 Pa m3/s of helium
    """

    @property
    def opening(self) -> float:
        """The opening from 0 (closed) to 1 (open)."""
        return self._core.vent_opening(self._number)

    @opening.setter
    def opening(self, opening: float) -> None:
        self._core.set_vent_opening(self._number, opening)

    def open(self) -> None:
        """Opens it fully."""
        self.opening = 1.0

    def close(self) -> None:
        """Closes it."""
        self.opening = 0.0

    def spray(self, gas: str | None) -> None:
        """Sets the gas outside, at the pressure of the air: ``he`` for a leak test. ``None`` is the air again."""
        self._core.set_outside(self._number, gas)


class Inlet(_Part):
    """A gas inlet. It is closed at first. Made by :meth:`Plant.inlet`.

    >>> from profivac.vacuum import Plant
    >>> plant = Plant()
    >>> chamber = plant.chamber(0.1, pressure_pa=1e-3, gas="ar")
    >>> inlet = plant.inlet(chamber, gas="ar")
    >>> inlet.flow(1e-3)
    >>> plant.advance(100)
    >>> inlet.close()
    >>> print(f"{chamber.pressure_pa:.3f} Pa")
    1.001 Pa
    """

    def flow(self, flow_pa_m3_s: float) -> None:
        """Lets a constant flow in, in Pa m³/s at room temperature: 1 sccm is 1.81e-3 Pa m³/s."""
        self._core.set_inlet(self._number, flow_pa_m3_s, None)

    def regulate(self, pressure_pa: float, *, max_flow_pa_m3_s: float) -> None:
        """Keeps a pressure in Pa with a proportional valve; ``max_flow_pa_m3_s`` is the flow of the open valve in Pa m³/s.

        The valve is fully open 2 % below the pressure (chosen).
        """
        self._core.set_inlet(self._number, max_flow_pa_m3_s, pressure_pa)

    def close(self) -> None:
        """Closes it."""
        self._core.set_inlet(self._number, None, None)


class Wall(_Part):
    """A wall that releases gas, and takes up water when it is vented. Made by :meth:`Plant.wall`.

    >>> from profivac.vacuum import Plant
    >>> plant = Plant()
    >>> wall = plant.wall(plant.chamber(0.1, pressure_pa=1e-3, gas="n2"), material="steel", area_m2=1.5)
    >>> wall.heat(423.15, seconds=3600)
    >>> plant.advance(1800)
    >>> print(f"{wall.temperature_k:.0f} K")
    358 K
    """

    @property
    def temperature_k(self) -> float:
        """The temperature in K."""
        return self._core.temperature(self._number)

    def heat(self, temperature_k: float, seconds: float = 0.0) -> None:
        """Heats or cools the wall to a temperature in K (1 to 2000) within ``seconds`` at a constant rate; at once for 0.

        A hot wall releases more gas and ages faster, after Arrhenius' law.
        """
        self._core.heat(self._number, temperature_k, seconds)


@dataclass(frozen=True)
class PlantGauge:
    """A virtual gauge on a chamber. It exists on the line while a :meth:`Plant.segment` is open. Made by :meth:`Plant.gauge`."""

    device: str
    """The device with its address, such as ``pcg550@5``."""
    chamber: Chamber
    """The chamber that it measures."""
    parts: tuple[tuple[int, Chamber], ...] = ()
    """The chambers of its other measuring parts or channels, by instance."""


@dataclass(frozen=True)
class Balance:
    """The gas of a plant, in Pa m³ by gas. ``entered`` is the sum of ``left`` and ``present``."""

    entered: dict[str, float]
    """The gas at the start and all that has entered since."""
    left: dict[str, float]
    """The gas that pumps and openings took away, and the water on walls."""
    present: dict[str, float]
    """The gas in all chambers."""


class Plant:
    """A plant: its parts, and its state over time.

    ``air_pa`` is the pressure of the air around it in Pa, ``humidity`` its relative humidity from 0 to 1. ``step_s`` is the time in s
    after which gauges and plant see each other, 1 ms to 1 h: the gas itself is calculated in shorter steps where it changes faster, with
    an error below 1e-6 of its pressure in each step.

    >>> from profivac.vacuum import Plant
    >>> plant = Plant()
    >>> chamber = plant.chamber(volume_m3=0.05, pressure_pa=1e-4, gas="n2")
    >>> leak = plant.leak(chamber, flow_pa_m3_s=1e-6)
    >>> before = chamber.pressure_pa
    >>> plant.advance(100)
    >>> print(f"{(chamber.pressure_pa - before) * chamber.volume_m3 / 100:.2e} Pa m3/s")
    1.00e-06 Pa m3/s
    """

    def __init__(self, *, air_pa: float = _ATMOSPHERE_PA, humidity: float = 0.5, step_s: float = 1.0) -> None:
        self._core = _profivac.PlantModel(air_pa, humidity, step_s)
        self._gauges: list[PlantGauge] = []
        self._segment: PlantSegment | None = None

    def _number(self, chamber: Chamber) -> int:
        if chamber.plant is not self:
            raise Usage("this chamber belongs to another plant")
        return chamber._number

    def chamber(self, volume_m3: float, *, pressure_pa: float | None = None, gas: str = "air") -> Chamber:
        """Adds a chamber of ``volume_m3`` in m³ (1e-9 to 1e6), filled with a gas at a pressure in Pa (1e-13 to 1e6; default: as outside).

        Gases: ``n2``, ``air``, ``o2``, ``co``, ``co2``, ``h2o``, ``he``, ``ne``, ``ar``, ``kr``, ``xe``, ``h2``, ``freon12``. ``air`` is
        a mixture of its gases with the humidity of the plant. A plant has at most 64 chambers.
        """
        return Chamber(self, self._core.chamber(volume_m3, pressure_pa, gas), volume_m3)

    def valve(
        self,
        one: Chamber,
        other: Chamber,
        *,
        diameter_m: float | None = None,
        length_m: float | None = None,
        conductance_m3_s: float | None = None,
        sharp_edged: bool = False,
    ) -> Valve:
        """Connects two chambers by a tube or valve: a round tube of a diameter and a length in m, or a conductance in m³/s.

        The conductance of a tube depends on pressure and gas, from molecular to viscous flow: Berman's formula (J. Appl. Phys. 36 (1965)
        3356), and docs/vacuum.md for the transition. ``conductance_m3_s`` is molecular, for nitrogen, at every pressure.
        """
        ends = (self._number(one), self._number(other))
        if conductance_m3_s is not None and diameter_m is None and length_m is None and not sharp_edged:
            return Valve(self, self._core.conductance(ends, conductance_m3_s))
        if conductance_m3_s is None and diameter_m is not None and length_m is not None:
            return Valve(self, self._core.tube(ends, (diameter_m, length_m), sharp_edged))
        raise Usage("expected either diameter_m and length_m, or conductance_m3_s")

    def roughing_pump(
        self, at: Chamber, *, speed_m3_s: float, ultimate_pa: float, speeds_m3_s: Mapping[float, float] | None = None
    ) -> RoughingPump:
        """Adds a stopped roughing pump: pumping speed in m³/s, ultimate pressure in Pa.

        Its flow is S(p) (p - p_ultimate). ``speeds_m3_s`` has the speed S at some inlet pressures in Pa; ``speed_m3_s`` is then the
        nominal one. A tenth of the residual gas is water, the rest nitrogen (chosen).
        """
        curve = list((speeds_m3_s or {}).items())
        return RoughingPump(self, self._core.roughing_pump(self._number(at), speed_m3_s, ultimate_pa, curve))

    def turbo_pump(
        self,
        inlet: Chamber,
        fore: Chamber,
        *,
        speed_m3_s: float,
        compression: float = 1e9,
        speeds_m3_s: Mapping[str, float] | None = None,
        compressions: Mapping[str, float] | None = None,
        critical_pa: float = 1e3,
        spin_up_s: float = 120.0,
        running: bool = False,
    ) -> TurboPump:
        """Adds a turbomolecular pump between a chamber and its fore line: speed in m³/s and compression for nitrogen.

        ``speeds_m3_s`` and ``compressions`` are those of other gases; without them the speed is the same and the logarithm of the
        compression follows the root of the molar mass. At the backing pressure ``critical_pa`` in Pa that logarithm is halved. A pump
        that is ``running`` has its speed already; otherwise it needs ``spin_up_s`` in s after its start. The defaults are chosen
        for a typical pump.
        """
        ends = (self._number(inlet), self._number(fore))
        numbers = (compression, critical_pa, spin_up_s)
        others = list((speeds_m3_s or {}).items()), list((compressions or {}).items())
        return TurboPump(self, self._core.turbo_pump(ends, speed_m3_s, numbers, *others, running))

    def capture_pump(
        self,
        at: Chamber,
        *,
        speeds_m3_s: Mapping[str, float],
        capacities_pa_m3: Mapping[str, float] | None = None,
        highest_pa: float = 1e-2,
    ) -> CapturePump:
        """Adds a stopped capture pump: its speed in m³/s and its capacity in Pa m³ by gas.

        Its speed for a gas is S (1 - captured / capacity), without a capacity S; above ``highest_pa`` in Pa it does not pump. The linear
        fall and the default are chosen.
        """
        capacities = list((capacities_pa_m3 or {}).items())
        return CapturePump(
            self, self._core.capture_pump(self._number(at), list(speeds_m3_s.items()), capacities, highest_pa)
        )

    def leak(self, at: Chamber, *, flow_pa_m3_s: float, open: bool = True) -> Leak:
        """Adds a leak: the flow of dry air from 1 atm into vacuum in Pa m³/s.

        Small leaks are molecular, so helium flows 2.7 times faster; large ones are laminar (LACO, Leak rate conversions; the border at
        3e-7 Pa m³/s is chosen).
        """
        leak = Leak(self, self._core.leak(self._number(at), flow_pa_m3_s))
        leak.opening = float(open)
        return leak

    def vent(
        self, at: Chamber, *, diameter_m: float, length_m: float, gas: str | None = None, sharp_edged: bool = False
    ) -> Leak:
        """Adds a closed vent: a round tube of a diameter and a length in m to the air, or to a gas at the pressure of the air."""
        return Leak(self, self._core.vent(self._number(at), (diameter_m, length_m), sharp_edged, gas))

    def inlet(self, at: Chamber, *, gas: str) -> Inlet:
        """Adds a closed inlet for a gas."""
        return Inlet(self, self._core.inlet(self._number(at), gas))

    def wall(
        self, of: Chamber, *, material: str, area_m2: float, aged_s: float = 0.0, aged_at_k: float = _ROOM_K
    ) -> Wall:
        """Adds a wall of an area in m² that releases gas. Without ``aged_s`` it was vented just now.

        Materials: ``steel``, ``polished-steel``, ``fired-steel``, ``aluminium``, ``glass``, ``viton``. Their rates after an hour with
        their sources are in docs/vacuum.md, Outgassing: unbaked steel releases 3e-6 Pa m³/s of water per m², falling with 1/t (Redhead,
        J. Vac. Sci. Technol. A 13 (1995) 467). ``aged_s`` is the time in s that it was in vacuum before, at ``aged_at_k`` in K.
        """
        return Wall(self, self._core.wall(self._number(of), material, area_m2, aged_s, aged_at_k))

    def seal(
        self, of: Chamber, *, area_m2: float, thickness_m: float, permeabilities_m2_s: Mapping[str, float]
    ) -> None:
        """Adds a seal to the air in its steady state: area in m², thickness in m, permeability by gas in m²/s.

        The flow is K A Δp / d (Daynes, Proc. R. Soc. A 97 (1920) 286).
        """
        permeabilities = list(permeabilities_m2_s.items())
        self._core.seal(self._number(of), area_m2, thickness_m, permeabilities)

    def gauge(self, device: str, at: Chamber, *, parts: Mapping[int, Chamber] | None = None) -> PlantGauge:
        """Adds a virtual gauge, as ``profivac simulate`` writes it: ``pcg550@5``, ``bcg450@6:unit=torr``.

        ``parts`` has the chambers of other measuring parts, or of channels of a controller, by instance. Gauges are added before
        :meth:`segment`.
        """
        if self._present() is not None:
            raise Usage("the segment of the plant is open; add the gauges before Plant.segment()")
        for chamber in (at, *(parts or {}).values()):
            self._number(chamber)
        gauge = PlantGauge(device, at, tuple((parts or {}).items()))
        self._gauges.append(gauge)
        return gauge

    def _present(self) -> PlantSegment | None:
        return self._segment if self._segment is not None and not self._segment.closed else None

    def segment(
        self,
        *,
        seed: int | None = None,
        names: Mapping[str, int] | None = None,
        via: str = "ms2",
        master: int = 0,
        timeout: float = 5.0,
    ) -> PlantSegment:
        """Switches the gauges on, on a line in memory: a ``sim:`` segment with the bus ``.bus``. A plant has one at a time.

        With ``seed`` the sensors are real ones: they lag, drift and are noisy, and they pump and release gas, most of all during a degas.
        Without it they are ideal. ``names``, ``via``, ``master`` and ``timeout`` are those of :func:`profivac.open`.
        """
        if self._present() is not None:
            raise Usage("the plant has a segment; close it first")
        if not self._gauges:
            raise Usage("expected a gauge on the plant, got none; Plant.gauge() adds one")
        devices = [gauge.device for gauge in self._gauges]
        places = [
            (gauge.chamber._number, [(instance, chamber._number) for instance, chamber in gauge.parts])
            for gauge in self._gauges
        ]
        core = _profivac.Segment.in_plant(self._core, devices, places, seed)
        # The plant keeps the segment: its gauges must not stand still because a program keeps only the bus.
        self._segment = PlantSegment(core, names or {}, via, master, timeout)
        return self._segment

    def advance(self, seconds: float) -> None:
        """Lets time pass: for the gas, and for the gauges of an open segment. Ctrl-C ends it between two steps.

        A day of a plant with two gauges in steps of 1 s takes about a second. Other threads of Python run meanwhile, and the line is served
        every millisecond; where the computer has other work, a gauge may answer another thread too late, as on a real line.
        """
        segment = self._present()
        self._core.advance(seconds, None if segment is None else segment._core)

    @property
    def seconds(self) -> float:
        """The time that has passed since the plant was made, in s."""
        return self._core.seconds()

    def balance(self) -> Balance:
        """The gas that entered, left and is present.

        >>> from profivac.vacuum import Plant
        >>> plant = Plant()
        >>> one, other = (plant.chamber(0.1, pressure_pa=pascal, gas="ar") for pascal in (100, 300))
        >>> tube = plant.valve(one, other, diameter_m=0.04, length_m=0.3)
        >>> plant.advance(60)
        >>> round(one.pressure_pa, 6), round(plant.balance().present["ar"], 9)
        (200.0, 40.0)
        """
        entered, left, present = self._core.balance()
        return Balance(dict(entered), dict(left), dict(present))
