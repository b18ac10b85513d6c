"""The pytest fixture, as a user has it."""

from __future__ import annotations

import profivac as pv
import pytest
from profivac.pytest_plugin import VirtualGauge


def test_the_fixture_makes_a_gauge(virtual_gauge: VirtualGauge) -> None:
    chamber = virtual_gauge("pcg550", pressure="2 mbar")
    gauge = chamber.bus[5]
    gauge.command("execute")
    assert gauge.read(pv.Unit.MBAR).value == pytest.approx(2.0, rel=0.1)
    chamber.pressure = "20 mbar"
    assert gauge.read(pv.Unit.MBAR).value == pytest.approx(20.0, rel=0.1)
