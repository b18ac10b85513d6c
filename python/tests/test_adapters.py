"""The adapters, with the libraries themselves."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path

import profivac as pv
import profivac.ophyd
import profivac.pymeasure
import profivac.qcodes
import pytest
from bluesky import RunEngine
from bluesky.plans import count
from ophyd_async.core import set_mock_value
from pymeasure.instruments import Instrument


def never() -> pv.Gauge:
    raise AssertionError("a mock opens no port")


def test_an_ophyd_gauge_connects_as_a_mock_without_a_port() -> None:
    async def main() -> dict[str, object]:
        gauge = profivac.ophyd.VacuumGauge(never, pv.Unit.MBAR, name="chamber")
        await gauge.connect(mock=True)
        set_mock_value(gauge.pressure, 2e-3)
        set_mock_value(gauge.state, profivac.ophyd.GaugeState.VALID)
        return {name: row["value"] for name, row in (await gauge.read()).items()}

    assert asyncio.run(main()) == {"chamber-pressure": 2e-3, "chamber-state": "valid"}


def test_an_ophyd_gauge_reads_pressure_and_state_in_one_request(monkeypatch: pytest.MonkeyPatch) -> None:
    requests = []
    read = pv.Gauge.read

    def counted(gauge: pv.Gauge, unit: pv.Unit = pv.Unit.PA, *, part: str | None = None) -> pv.Reading:
        requests.append(unit)
        return read(gauge, unit, part=part)

    async def main(chamber: pv.VirtualSegment) -> None:
        gauge = profivac.ophyd.VacuumGauge(lambda: chamber.bus[5], pv.Unit.MBAR, name="chamber")
        await gauge.connect(timeout=300)
        requests.clear()
        off = await gauge.read()
        assert requests == [pv.Unit.MBAR]
        assert math.isnan(off["chamber-pressure"]["value"])
        assert (off["chamber-state"]["value"], off["chamber-state"]["alarm_severity"]) == ("off", 3)
        await chamber.bus[5].command_async("execute")
        on = await gauge.read()
        assert on["chamber-pressure"]["value"] == pytest.approx(2e-3, rel=0.1)
        described = (await gauge.describe())["chamber-pressure"]
        assert (described["units"], described["dtype"]) == ("mbar", "number")
        # LiveTable shows no exponent: 5e-10 mbar needs eleven decimals.
        assert described["precision"] == 12
        coarse = profivac.ophyd.VacuumGauge(lambda: chamber.bus[5], pv.Unit.MBAR, precision=4, name="coarse")
        await coarse.connect(timeout=300)
        assert (await coarse.describe())["coarse-pressure"]["precision"] == 4
        assert "valid" in (await gauge.describe())["chamber-state"]["choices"]
        assert gauge.hints == {"fields": ["chamber-pressure"]}

    monkeypatch.setattr(pv.Gauge, "read", counted)
    with pv.VirtualSegment("bcg450@5", pressure="2e-3 mbar", timeout=300) as chamber:
        asyncio.run(main(chamber))


def test_an_ophyd_gauge_reports_to_a_subscriber() -> None:
    async def main(chamber: pv.VirtualSegment) -> list[float]:
        gauge = profivac.ophyd.VacuumGauge(lambda: chamber.bus[5], interval=0, name="chamber")
        await gauge.connect(timeout=300)
        seen: asyncio.Queue[float] = asyncio.Queue()

        def report(rows: dict[str, dict[str, float]]) -> None:
            seen.put_nowait(rows["chamber-pressure"]["value"])

        gauge.pressure.subscribe_reading(report)  # type: ignore[arg-type]
        first = await seen.get()
        chamber.pressure = "1 mbar"
        # A reading from before the change may arrive first.
        while (second := await seen.get()) == first:
            pass
        gauge.pressure.clear_sub(report)
        return [first, second]

    with pv.VirtualSegment("psg550@5", pressure="10 mbar", timeout=300) as chamber:
        chamber.bus[5].command("execute")
        assert asyncio.run(main(chamber)) == [pytest.approx(1000, rel=0.1), pytest.approx(100, rel=0.1)]


def test_a_plan_of_bluesky_records_a_gauge() -> None:
    with pv.VirtualSegment("bcg450@5", pressure="2e-3 mbar", timeout=300) as chamber:
        chamber.bus[5].command("execute")
        engine = RunEngine(call_returns_result=False)
        gauge = profivac.ophyd.VacuumGauge(lambda: chamber.bus[5], name="chamber")
        asyncio.run_coroutine_threadsafe(gauge.connect(timeout=300), engine.loop).result(300)
        rows: list[dict[str, object]] = []
        engine(count([gauge], num=2), lambda name, document: rows.append(document["data"]) if name == "event" else None)
    assert [row["chamber-pressure"] for row in rows] == [pytest.approx(0.2, rel=0.1)] * 2
    assert [row["chamber-state"] for row in rows] == ["valid", "valid"]


def test_an_ophyd_gauge_that_does_not_answer_is_not_connected() -> None:
    async def main(bus: pv.Bus) -> None:
        with pytest.raises(Exception, match="address 9"):
            await profivac.ophyd.VacuumGauge(lambda: bus[9], name="chamber").connect(timeout=300)

    with pv.VirtualSegment("bcg450@5", timeout=1.0) as chamber:
        asyncio.run(main(chamber.bus))


class Own(profivac.pymeasure.VacuumGauge):
    """As a user extends it."""

    safe_state = Instrument.control("get pirani.safe-state", "set pirani.safe-state %s", "Control the state.", cast=str)


def test_a_pymeasure_instrument_reads_and_writes_a_gauge() -> None:
    with pv.VirtualSegment("bcg450@5", pressure="2e-3 mbar") as chamber:
        gauge = Own(chamber.bus[5], unit=pv.Unit.MBAR)
        assert (gauge.state, gauge.device_state) == ("off", "IDLE")
        assert math.isnan(gauge.pressure)
        assert "execute" in {command.split(".")[-1] for command in gauge.commands}
        gauge.execute("execute")
        assert (gauge.state, gauge.device_state) == ("valid", "EXECUTING")
        assert gauge.pressure == pytest.approx(2e-3, rel=0.1)
        gauge.unit = pv.Unit.PA
        assert gauge.pressure == pytest.approx(0.2, rel=0.1)
        assert gauge.safe_state == "zero"
        gauge.safe_state = "full-scale"
        assert chamber.bus[5]["pirani.safe-state"].value == "full-scale"
        gauge.adapter.close()
        assert chamber.bus[5].read().valid, "the bus belongs to the user"
        with pytest.raises(pv.Usage, match="expected 'get NAME'"):
            gauge.write("dance")
        with pytest.raises(pv.Refused, match="pump down first"):
            gauge.execute("degas on")


def test_a_qcodes_instrument_reads_and_writes_a_gauge() -> None:
    with pv.VirtualSegment("bcg450@5", pressure="2e-3 mbar") as chamber:
        gauge = profivac.qcodes.VacuumGauge("chamber", chamber.bus[5], pv.Unit.MBAR, ["pirani.safe-state"])
        try:
            assert gauge.state() == "off"
            chamber.bus[5].command("execute")
            assert gauge.pressure() == pytest.approx(2e-3, rel=0.1)
            gauge.parameters["pirani_safe_state"]("full-scale")
            assert gauge.parameters["pirani_safe_state"]() == "full-scale"
            with pytest.raises(ValueError, match="sideways"):
                gauge.parameters["pirani_safe_state"]("sideways")
            rows = gauge.snapshot(update=True)["parameters"]
            assert (rows["state"]["value"], rows["pressure"]["unit"]) == ("valid", "mbar")
            assert gauge.get_idn()["model"] == "BCG450-SP"
        finally:
            gauge.close()
        with pytest.raises(pv.Usage, match="bcg450 has no parameter 'pirani.dance'"):
            profivac.qcodes.VacuumGauge("other", chamber.bus[5], parameters=["pirani.dance"])


def test_the_package_needs_none_of_the_libraries() -> None:
    package = Path(pv.__file__).parent
    others = [file for file in package.glob("*.py") if file.stem not in ("ophyd", "pymeasure", "qcodes", "pytest_plugin")]
    words = ("import ophyd", "import bluesky", "import pymeasure", "import qcodes", "from ophyd", "from pymeasure", "from qcodes")
    assert [file.name for file in others if any(word in file.read_text(encoding="utf-8") for word in words)] == []
