"""Every device of profivac: tables, pressure, parameters, clones."""

from __future__ import annotations

import gc
from datetime import datetime, timedelta, timezone
from pathlib import Path

import profivac as pv
import pytest

from conftest import Simulate

MS2 = ["pcg550", "pcg552", "pcg554", "psg550", "psg552", "psg554", "bpg400", "hpg400", "bcg450", "img400"]
CHANNEL_ONLY = ["tpg300", "tpg500"]
DEVICES = [(device, "ms2") for device in MS2] + [(device, "pkw") for device in CHANNEL_ONLY]


@pytest.mark.parametrize(("device", "via"), DEVICES)
def test_a_device_measures_the_pressure_of_its_chamber(device: str, via: str) -> None:
    with pv.VirtualSegment(f"{device}@5", pressure="2e-3 mbar", via=via) as chamber:
        gauge = chamber.bus[5]
        # A TPG 300 and a TPG 500 have one Ident_Number.
        assert gauge.device == (device if via == "ms2" else "tpg300 or tpg500")
        if "execute" in {command.split(".")[-1] for command in gauge.commands}:
            gauge.command("execute")
        before = datetime.now(timezone.utc)
        reading = gauge.read(pv.Unit.MBAR)
        assert reading.state is pv.State.VALID, reading
        assert reading.value == pytest.approx(2e-3, rel=0.1)
        assert reading.unit is pv.Unit.MBAR
        assert reading.time is not None
        assert before - timedelta(seconds=1) <= reading.time <= datetime.now(timezone.utc)
        assert gauge.pressure() == pytest.approx(0.2, rel=0.1)


@pytest.mark.parametrize(("device", "via"), DEVICES)
def test_a_device_gives_cyclic_data_and_parameters(device: str, via: str) -> None:
    """Its parameters are read and written over the service that it has."""
    with pv.VirtualSegment(f"{device}@5", pressure="2e-3 mbar", via=via) as chamber:
        gauge = chamber.bus[5]
        rows = [row for row in gauge.parameters.values() if row.readable and row.slot <= 1]
        values = [gauge[row.name] for row in rows[:5] if via in ("ms2", "pkw")]
        assert values and all(value.text for value in values)
        with gauge.exchange(pv.Unit.MBAR) as exchange:
            for readings in exchange:
                if any(reading.valid for reading in readings):
                    break
        valid = next(reading for reading in readings if reading.valid)
        assert valid.value == pytest.approx(2e-3, rel=0.1)


@pytest.mark.parametrize(("device", "via"), DEVICES)
def test_a_device_has_the_tables_of_its_manual(device: str, via: str) -> None:
    parameters = pv.parameters_of(device)
    with pv.VirtualSegment(f"{device}@5", via=via) as chamber:
        assert chamber.bus[5].parameters == parameters
    assert len(parameters) > 10
    assert all(parameter.source and parameter.type and parameter.access for parameter in parameters.values())
    assert any(parameter.choices for parameter in parameters.values())
    assert any(parameter.setting for parameter in parameters.values())


def test_a_number_of_a_table_has_the_unit_and_the_limits_of_its_manual() -> None:
    assert pv.parameters_of("bcg450")["ba.emission-current"].bounds == (0.0, 20.0)
    with pv.VirtualSegment("pcg550@5") as chamber:
        chamber.advance(1000)
        hours, quarters = (chamber.bus[5][name] for name in ("device.run-hours", "device.run-hours-4"))
    assert (hours.value, hours.unit, hours.text) == (0.0, "h", "0 h")
    assert (quarters.value, quarters.unit, quarters.text, quarters.octets) == (0.25, "h", "0.25 h", bytes([0, 0, 0, 1]))


FILE = Path(__file__).parents[2] / "docs/devices/files/bpg402.toml"


def test_a_device_of_a_file_is_simulated_found_and_read() -> None:
    with pv.VirtualSegment(f"{FILE}@5", "bcg450@6", pressure="2e-3 mbar") as chamber:
        gauge = chamber.bus[5]
        assert (gauge.device, gauge.title) == ("bpg402", "BPG402-SP")
        assert [station.devices for station in chamber.bus.scan(5, 6)] == [("bpg402",), ("bcg450",)]
        assert gauge.parameters == pv.parameters_of(str(FILE))
        assert gauge.parameters != chamber.bus[6].parameters
        gauge.command("execute")
        assert gauge.read(pv.Unit.MBAR).value == pytest.approx(2e-3, rel=0.1)
        with gauge.exchange(pv.Unit.MBAR) as exchange:
            assert any(any(reading.valid for reading in readings) for readings in exchange)


def test_a_port_knows_the_devices_of_the_files_that_are_named(simulate: Simulate) -> None:
    place = simulate("--tcp", "127.0.0.1:0", f"{FILE}@5")
    with pv.open(f"tcp://{place}", device_files=FILE, timeout=300) as bus:
        assert bus[5].device == "bpg402"


def test_a_wrong_device_file_is_an_error_with_its_place(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.toml"
    wrong.write_text('format = 1\nname = "mine"\nlike = "bgc450"\ntitle = "MINE"\n')
    with pytest.raises(pv.Usage, match=r"wrong\.toml:3:8: .*bcg450"):
        pv.parameters_of(str(wrong))
    with pytest.raises(pv.Usage, match=r"wrong\.toml"):
        pv.open("/dev/does-not-exist", device_files=[wrong])


@pytest.mark.parametrize("device", MS2)
def test_the_settings_of_a_device_are_cloned(device: str) -> None:
    with pv.VirtualSegment(f"{device}@5", f"{device}@6") as chamber:
        original, replacement = chamber.bus[5], chamber.bus[6]
        settings = original.dump()
        assert replacement.diff(settings) == []
        written = change_one(replacement)
        assert [difference.name for difference in replacement.diff(settings)] == [written]
        restored = replacement.restore(settings)
        assert [(row.name, row.error) for row in restored] == [(written, None)]
        assert replacement.diff(settings) == []


def change_one(gauge: pv.Gauge) -> str:
    """Writes another value to a setting that has words, and returns its name."""
    settings = [it for it in gauge.parameters.values() if it.setting and it.readable and len(it.choices) > 1]
    for parameter in settings:
        if "unit" in parameter.name or "type" in parameter.name or parameter.name.endswith("lock"):
            continue
        before = gauge[parameter.name]
        other = next(choice for choice in parameter.choices if choice != before.value)
        try:
            change = gauge.set(parameter.name, other)
        except pv.Refused:
            continue
        if change.after is not None and change.after.value == other:
            return parameter.name
    raise AssertionError(f"no setting of {gauge.device} can be changed")


def test_a_gauge_without_a_pressure_gives_none_and_a_state() -> None:
    with pv.VirtualSegment("bcg450@5", pressure="1e-12 mbar") as chamber:
        gauge = chamber.bus[5]
        off = gauge.read()
        assert (off.value, off.state, off.bounds) == (None, pv.State.OFF, (None, None))
        assert gauge.pressure() != gauge.pressure(), "not a number"
        gauge.command("execute")
        below = gauge.read()
        assert (below.value, below.state) == (None, pv.State.UNDERRANGE)
        low, high = below.bounds
        assert low is None and high is not None and 0 < high < 1e-3
        assert str(below).startswith("underrange (below ")
        with pytest.raises(AttributeError):
            below.value = 0.0  # type: ignore[misc]


def test_parameters_have_types() -> None:
    with pv.VirtualSegment("bcg450@5:unit=mbar") as chamber:
        gauge = chamber.bus[5]
        full_scale = gauge["pirani.full-scale"]
        assert (full_scale.value, full_scale.unit, full_scale.pascal, full_scale.text) == (1000, "mbar", 1e5, "1000 mbar")
        assert gauge["device.device-state"].value == "IDLE"
        gauge["pirani.safe-value"] = "12.5 Pa"
        assert gauge["pirani.safe-value"].pascal == pytest.approx(12.5)
        types = {type(gauge[name].value) for name, row in gauge.parameters.items() if row.readable and row.slot == 0}
        assert types >= {int, str}, types


def test_a_part_is_read_by_its_name() -> None:
    with pv.VirtualSegment("bcg450@5", "img400@6", pressure="1 mbar") as chamber:
        gauge = chamber.bus[5]
        gauge.command("execute")
        assert gauge.read(pv.Unit.MBAR, part="pirani").value == pytest.approx(1.0, rel=0.2)
        chamber.bus[6].command("execute")
        assert chamber.bus[6].read(part="channel.3").instance == 3


@pytest.mark.parametrize("end", ["close", "selector_kept", "forget"])
def test_a_selector_is_restored(simulate: Simulate, tmp_path: Path, end: str) -> None:
    """Another bus reads the selector, because a gauge shows the value from before its own move."""
    selector = next(name for name in pv.parameters_of("bcg450") if name.endswith("channel-instance-selector"))
    place = simulate("--pty", tmp_path / "line", "bcg450@5")

    def shown() -> object:
        with pv.open(place, timeout=300) as bus:
            return bus[5][selector].value

    before = shown()
    bus = pv.open(place, timeout=300)
    parts = ("pirani.process-value", "ba.process-value", "cdg.process-value")
    if end == "selector_kept":
        with bus[5].selector_kept() as gauge:
            for part in parts:
                gauge.get(part)
    else:
        for part in parts:
            bus[5].get(part)
    if end == "forget":
        del bus
        gc.collect()
    else:
        bus.close()
    assert shown() == before


def test_a_fault_is_seen() -> None:
    with pv.VirtualSegment("bcg450@5") as chamber:
        gauge = chamber.bus[5]
        gauge.command("execute")
        chamber.fault(5, "eeprom")
        assert gauge["device.exception-status"].value != "none"
        with pytest.raises(pv.Usage, match='bcg450 at address 5 has no fault "fire"; it has eeprom .EEPROM exception, alarm'):
            chamber.fault(5, "fire")
