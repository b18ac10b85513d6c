"""Plants identified from their data: a rate of rise, or a whole pump-down."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from . import _profivac
from ._errors import Usage


@dataclass(frozen=True)
class Interval:
    """A mean with its 95 % interval."""

    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class Rise:
    """The result of :func:`rise`. Flows are in Pa m³/s."""

    leak: Interval
    outgassing: Interval
    """The outgassing when the valve was closed."""
    total: Interval
    """Both when the valve was closed: the indicated rate times the volume."""
    cause: str
    """``leak``, ``outgassing``, ``both``, ``undistinguished`` or ``no-rise``."""
    misfit: float
    """The residuals of the best fit, divided by the noise: near 1 for a good fit."""
    fitted: tuple[tuple[float, float], ...]
    """The best fit: times in s, indicated pressures in Pa."""
    tau_s: float | None
    """The time constant of saturation in s, if that shape is the most probable one."""
    _sccm: float = field(repr=False, compare=False)

    def sccm(self, flow: Interval) -> Interval:
        """A flow of this result in standard cubic centimetres per minute, at 0 °C and 1013.25 mbar."""
        return Interval(flow.mean * self._sccm, flow.low * self._sccm, flow.high * self._sccm)


def rise(
    seconds: Iterable[float],
    pascal: Iterable[float],
    *,
    volume_m3: float,
    pumped_s: float | None = None,
    gauge: str = "none",
    outgassed: str = "h2o",
    gauge_uncertainty: float = 0.0,
    gas_k: float = 296.0,
) -> Rise:
    """Separates the rise of a closed chamber into leak and outgassing.

    ``seconds`` since the valve was closed and indicated ``pascal`` are lists or numpy arrays of the same length. ``volume_m3`` is the
    volume in m³. ``gauge`` says how the gauge depends on the gas: ``none`` (a diaphragm), ``ionisation`` or ``conduction``.
    ``gas_k`` is the temperature of the gas in K, which :meth:`Rise.sccm` uses.

    >>> times = [10.0 * step for step in range(60)]
    >>> result = rise(times, [1e-3 + 1e-5 * time for time in times], volume_m3=0.1)
    >>> f"{result.total.mean:.2e} Pa m3/s"
    '1.00e-06 Pa m3/s'
    >>> f"{result.sccm(result.total).mean:.2e} sccm"
    '5.46e-04 sccm'
    """
    samples = [(float(time), float(pressure)) for time, pressure in zip(seconds, pascal, strict=True)]
    leak, outgassing, total, cause, misfit, fitted, tau_s, sccm = _profivac.analyse_rise(
        samples,
        volume_m3=volume_m3,
        pumped_s=pumped_s,
        gauge=gauge,
        outgassed=outgassed,
        gauge_uncertainty=gauge_uncertainty,
        gas_k=gas_k,
    )
    return Rise(Interval(*leak), Interval(*outgassing), Interval(*total), cause, misfit, tuple(fitted), tau_s, sccm)


@dataclass(frozen=True)
class Plant:
    """The result of :func:`plant`. Flows are in Pa m³/s, speeds in m³/s, pressures in Pa."""

    volume_m3: Interval
    leak: Interval
    outgassing_1h: Interval
    """The outgassing an hour after the start of the pump-down."""
    exponent: Interval
    """The exponent of the outgassing over time."""
    ultimate_pa: Interval
    """The ultimate pressure of the pump."""
    speeds: tuple[tuple[float, Interval], ...]
    """The effective pumping speed at pressures in Pa, from low to high pressure."""
    misfit: float
    """The scatter divided by the noise: near 1 for a good fit; above 2 the record does not follow the law."""
    fitted: tuple[tuple[float, float, float, float], ...]
    """Means of the record: time in s, measured and fitted pressure in Pa, difference in standard deviations."""
    _core: _profivac.Plant = field(repr=False, compare=False)

    def predicted(self, seconds: float) -> Interval:
        """The pressure in Pa if the pumping goes on until ``seconds`` after the start of the pump-down."""
        return Interval(*self._core.predicted(seconds))

    def time_to(self, pascal: float) -> Interval | None:
        """The time in s at which the pressure reaches ``pascal``; ``None`` if it does not within a year."""
        found = self._core.time_to(pascal)
        return None if found is None else Interval(*found)

    def remedies(self) -> dict[str, Interval]:
        """By which factor each change lowers the pressure after another day of pumping, the best one first."""
        return {name: Interval(*factor) for name, factor in self._core.remedies()}


def plant(
    seconds: Iterable[float],
    pascal: Iterable[float],
    *,
    volume_m3: float | None = None,
    dose: tuple[float, float] | None = None,
    closed_s: float | None = None,
    opened_s: float | None = None,
    gauge_uncertainty: float = 0.0,
) -> Plant:
    """Finds pumping speed, leak, outgassing and ultimate pressure of a plant from one record of one gauge.

    ``seconds`` since the start of the pump-down and ``pascal`` are lists or numpy arrays of the same length, at least 30 samples.
    ``closed_s`` and ``opened_s`` are the times at which the valve to the pump was closed and opened again. The volume is
    ``volume_m3``, or follows from a ``dose``: the time in s and the amount in Pa m³ of gas let in while the valve was closed.
    ``gauge_uncertainty`` is the standard uncertainty of the gauge's sensitivity as a fraction. A fit takes seconds; Ctrl-C ends it.

    >>> import math
    >>> times = [10.0 * 1.2**step for step in range(40)]
    >>> found = plant(times, [1e3 * math.exp(-0.2 * time) + 1 / time for time in times], volume_m3=0.1)
    >>> print(f"{found.speeds[-1][1].mean:.3f} m3/s")
    0.020 m3/s
    """
    samples = [(float(time), float(pressure)) for time, pressure in zip(seconds, pascal, strict=True)]
    if opened_s is not None and closed_s is None:
        raise Usage("expected closed_s with opened_s: a valve is opened after it was closed")
    phases = [(0.0, True)]
    phases += [] if closed_s is None else [(float(closed_s), False)]
    phases += [] if opened_s is None else [(float(opened_s), True)]
    core = _profivac.Plant(
        samples, phases=phases, volume_m3=volume_m3, dose=dose, gauge_uncertainty=gauge_uncertainty
    )
    volume, leak, outgassing, exponent, ultimate, speeds, misfit = core.numbers()
    return Plant(
        Interval(*volume),
        Interval(*leak),
        Interval(*outgassing),
        Interval(*exponent),
        Interval(*ultimate),
        tuple((pressure, Interval(*speed)) for pressure, speed in speeds),
        misfit,
        tuple(core.residuals()),
        core,
    )
