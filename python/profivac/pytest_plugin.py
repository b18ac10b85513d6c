"""A pytest fixture with virtual gauges: ``virtual_gauge``.

.. code-block:: python

    def test_a_pump_stops_above_1_mbar(virtual_gauge):
        chamber = virtual_gauge("pcg550", pressure="2 mbar")
        gauge = chamber.bus[5]
        gauge.command("execute")
        assert gauge.read().valid
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest

from ._virtual import VirtualSegment

VirtualGauge = Callable[..., VirtualSegment]
"""The type of the fixture."""


@pytest.fixture
def virtual_gauge() -> Iterator[VirtualGauge]:
    """Makes a chamber with one virtual gauge at address 5. It ends with the test."""
    with ExitStack() as stack:

        def make(device: str = "bcg450", pressure: str = "1e-3 mbar", **options: object) -> VirtualSegment:
            spec = device if "@" in device else f"{device}@5"
            return stack.enter_context(VirtualSegment(spec, pressure=pressure, **options))  # type: ignore[arg-type]

        yield make
