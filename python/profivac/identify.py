"""Plants identified from their data: a rate of rise, separated into leak and outgassing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from . import _profivac


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
    total: Interval
    cause: str
    """``leak``, ``outgassing``, ``both``, ``undistinguished`` or ``no-rise``."""
    misfit: float
    """The residuals of the best fit, divided by the noise: near 1 for a good fit."""
    fitted: tuple[tuple[float, float], ...]
    """The best fit: times in s, indicated pressures in Pa."""
    tau_s: float | None
    """The time constant of saturation in s, if that shape is the most probable one."""


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

    >>> times = [10.0 * step for step in range(60)]
    >>> result = rise(times, [1e-3 + 1e-5 * time for time in times], volume_m3=0.1)
    >>> f"{result.total.mean:.2e} Pa m3/s"
    '1.00e-06 Pa m3/s'
    """
    samples = [(float(time), float(pressure)) for time, pressure in zip(seconds, pascal, strict=True)]
    leak, outgassing, total, cause, misfit, fitted, tau_s = _profivac.analyse_rise(
        samples,
        volume_m3=volume_m3,
        pumped_s=pumped_s,
        gauge=gauge,
        outgassed=outgassed,
        gauge_uncertainty=gauge_uncertainty,
        gas_k=gas_k,
    )
    return Rise(Interval(*leak), Interval(*outgassing), Interval(*total), cause, misfit, tuple(fitted), tau_s)
