"""The physics of a plant as objects, and the gauges on it. Expected numbers are calculated by hand, not with the simulation."""

from __future__ import annotations

import contextlib
import math
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import profivac as pv
import pytest
from profivac.vacuum import Chamber, Plant

LITRE = 1e-3
"""m³"""


def mbar(pascal: float) -> float:
    return pascal / 100


def test_a_pump_down_follows_its_time_constant() -> None:
    """p = p_ultimate + (p0 - p_ultimate) exp(-S t / V)."""
    plant = Plant()
    chamber = plant.chamber(0.1, gas="n2")
    pump = plant.roughing_pump(chamber, speed_m3_s=0.01, ultimate_pa=1.0)
    plant.advance(100)
    assert chamber.pressure_pa == pytest.approx(101325), "the pump is stopped"
    pump.start()
    plant.advance(50)
    assert chamber.pressure_pa == pytest.approx(1 + 101324 * math.exp(-5), rel=0.01)
    plant.advance(1000)
    assert chamber.pressure_pa == pytest.approx(1.0, rel=0.01)
    pump.stop()
    plant.advance(100)
    assert chamber.pressure_pa == pytest.approx(1.0, rel=0.01)
    assert plant.seconds == pytest.approx(1250)


def test_a_pump_has_its_speed_at_each_pressure() -> None:
    plant = Plant()
    chamber = plant.chamber(1.0, pressure_pa=100, gas="n2")
    speeds = {1.0: 0.001, 1000.0: 0.001}
    plant.roughing_pump(chamber, speed_m3_s=0.01, ultimate_pa=1e-6, speeds_m3_s=speeds).start()
    plant.advance(1000)
    assert chamber.pressure_pa == pytest.approx(100 * math.exp(-1), rel=0.01)


def test_a_valve_lets_gas_pass_until_the_pressures_are_equal() -> None:
    plant = Plant()
    one, other = plant.chamber(0.1, pressure_pa=1e-3, gas="n2"), plant.chamber(0.3, pressure_pa=2e-3, gas="n2")
    valve = plant.valve(one, other, conductance_m3_s=0.01)
    valve.close()
    plant.advance(10)
    assert one.pressure_pa == pytest.approx(1e-3)
    assert valve.opening == 0.0
    valve.open()
    # The difference falls with the time constant V1 V2 / (V1 + V2) / C = 7.5 s.
    plant.advance(7.5)
    assert other.pressure_pa - one.pressure_pa == pytest.approx(1e-3 * math.exp(-1), rel=0.01)
    plant.advance(100)
    assert one.pressure_pa == pytest.approx(1.75e-3) == other.pressure_pa


def test_a_leak_gives_a_rate_of_rise_and_helium_flows_faster() -> None:
    plant = Plant(humidity=0)
    chamber = plant.chamber(0.05, pressure_pa=1e-4, gas="n2")
    leak = plant.leak(chamber, flow_pa_m3_s=1e-10)

    def rise() -> float:
        before = chamber.pressure_pa
        plant.advance(100)
        return (chamber.pressure_pa - before) / 100

    assert rise() == pytest.approx(1e-10 / 0.05, rel=0.02)
    leak.spray("he")
    assert rise() == pytest.approx(1e-10 / 0.05 * math.sqrt(28.97 / 4.0026), rel=0.02)
    assert chamber.gases_pa["he"] > 0
    leak.spray(None)
    leak.close()
    assert rise() == pytest.approx(0.0, abs=1e-13)


def test_an_inlet_gives_a_flow_or_keeps_a_pressure() -> None:
    plant = Plant()
    chamber, fore = plant.chamber(0.1, pressure_pa=1e-3, gas="n2"), plant.chamber(0.01, pressure_pa=1, gas="n2")
    plant.turbo_pump(chamber, fore, speed_m3_s=0.1, running=True)
    plant.roughing_pump(fore, speed_m3_s=0.01, ultimate_pa=0.1).start()
    inlet = plant.inlet(chamber, gas="ar")
    inlet.flow(1e-3)
    plant.advance(60)
    assert chamber.gases_pa["ar"] == pytest.approx(1e-3 / 0.1, rel=0.02), "flow over speed"
    inlet.regulate(0.02, max_flow_pa_m3_s=1e-2)
    plant.advance(60)
    assert chamber.pressure_pa == pytest.approx(0.02, rel=0.03)
    inlet.close()
    plant.advance(60)
    assert chamber.pressure_pa < 1e-6


def test_a_capture_pump_keeps_gas_up_to_its_capacity() -> None:
    plant = Plant(step_s=0.1)
    chamber = plant.chamber(0.1, pressure_pa=1e-3, gas="n2")
    pump = plant.capture_pump(chamber, speeds_m3_s={"n2": 0.1}, capacities_pa_m3={"n2": 1e-3}, highest_pa=1.0)
    pump.start()
    plant.advance(100)
    assert pump.captured_pa_m3 == {"n2": pytest.approx(1e-4, rel=0.01)}
    plant.inlet(chamber, gas="n2").flow(1e-4)
    plant.advance(100)
    assert pump.captured_pa_m3["n2"] == pytest.approx(1e-3, rel=0.01), "full"
    assert chamber.pressure_pa > 1e-3
    pump.regenerate()
    assert pump.captured_pa_m3 == {}
    pump.stop()


def test_a_vent_and_a_seal_let_air_in() -> None:
    plant = Plant()
    chamber, dry = plant.chamber(0.01, pressure_pa=1.0, gas="n2"), plant.chamber(0.01, pressure_pa=1e-6, gas="n2")
    vent = plant.vent(chamber, diameter_m=5e-3, length_m=0.05)
    plant.advance(10)
    assert chamber.pressure_pa == pytest.approx(1.0), "closed"
    vent.open()
    plant.advance(60)
    assert chamber.pressure_pa == pytest.approx(101325, rel=0.01)
    plant.seal(dry, area_m2=1e-3, thickness_m=5e-3, permeabilities_m2_s={"he": 1e-11})
    plant.advance(1000)
    # K A p / d V t, with 0.53 Pa of helium in the air.
    assert dry.gases_pa["he"] == pytest.approx(1e-11 * 1e-3 * 0.53 / 5e-3 / 0.01 * 1000, rel=0.05)


def test_a_bake_out_has_the_pressures_of_the_included_scenario() -> None:
    """docs/plants.md: 3.49e-8 mbar after 8 h, 1.15e-10 mbar after the bake-out, by hand."""
    plant = Plant(step_s=10)
    chamber = plant.chamber(100 * LITRE, pressure_pa=1.0)
    throat, fore = plant.chamber(2 * LITRE, pressure_pa=1.0), plant.chamber(3 * LITRE, pressure_pa=2.0)
    wall = plant.wall(chamber, material="steel", area_m2=1.5)
    plant.roughing_pump(fore, speed_m3_s=20 / 3600, ultimate_pa=1.0).start()
    turbo = plant.turbo_pump(throat, fore, speed_m3_s=0.3, compression=1e11, running=True)
    plant.valve(chamber, throat, diameter_m=0.1, length_m=0.07)
    hour = 3600.0
    plant.advance(8 * hour)
    assert turbo.rotor_speed == pytest.approx(1.0, abs=0.01)
    assert mbar(chamber.pressure_pa) == pytest.approx(3.49e-8, rel=0.05)
    wall.heat(80 + 273.15, hour)
    plant.advance(2 * hour)
    wall.heat(150 + 273.15, 2 * hour)
    plant.advance(2 * hour)
    assert wall.temperature_k == pytest.approx(423.15)
    assert mbar(chamber.pressure_pa) > 1e-7
    plant.advance(22 * hour)
    wall.heat(293.15, 8 * hour)
    plant.advance(14 * hour)
    assert mbar(chamber.pressure_pa) == pytest.approx(1.15e-10, rel=0.1)
    balance = plant.balance()
    for gas, entered in balance.entered.items():
        assert entered == pytest.approx(balance.left.get(gas, 0) + balance.present.get(gas, 0), rel=1e-6), gas


def pumped(**names: int) -> tuple[Plant, Chamber, Chamber]:
    """A chamber with a turbo, and its fore line."""
    plant = Plant()
    chamber, fore = plant.chamber(0.1, pressure_pa=1e-3, gas="n2"), plant.chamber(0.01, pressure_pa=5, gas="n2")
    plant.turbo_pump(chamber, fore, speed_m3_s=0.3, running=True)
    plant.roughing_pump(fore, speed_m3_s=0.005, ultimate_pa=5).start()
    plant.leak(chamber, flow_pa_m3_s=3e-5)
    return plant, chamber, fore


def test_gauges_show_the_pressures_of_their_chambers() -> None:
    plant, chamber, fore = pumped()
    plant.gauge("bcg450@5", chamber)
    plant.gauge("psg550@6", fore)
    with plant.segment(names={"chamber": 5, "fore": 6}) as segment:
        for name in ("chamber", "fore"):
            segment.bus[name].command("execute")
        plant.advance(120)
        for name, place in (("chamber", chamber), ("fore", fore)):
            reading = segment.bus[name].read()
            assert reading.value == pytest.approx(place.pressure_pa, rel=0.1), name
        assert chamber.pressure_pa == pytest.approx(1e-4, rel=0.05), "flow over speed"
        segment.power(6, False)
        segment.fault(5, "eeprom")
        segment.clear(5, "eeprom")
    with pytest.raises(pv.Connection, match="closed"):
        segment.bus[5].read()
    # The plant goes on without its gauges, and can have them again.
    plant.advance(10)
    with plant.segment() as again:
        assert again.bus[5].device == "bcg450"


@pytest.mark.parametrize("device", "pcg550 pcg552 pcg554 psg550 psg552 psg554 bpg400 hpg400 bcg450 img400".split())
def test_every_device_measures_a_plant(device: str) -> None:
    plant = Plant()
    chamber = plant.chamber(0.1, pressure_pa=0.2, gas="n2")
    plant.gauge(f"{device}@5", chamber)
    # The program keeps the bus alone.
    bus = plant.segment().bus
    bus[5].command("execute")
    plant.advance(300)
    reading = bus[5].read()
    assert reading.value == pytest.approx(0.2, rel=0.1), reading
    bus.close()
    plant.advance(1)


@pytest.mark.parametrize("device", ["tpg300", "tpg500"])
def test_a_controller_without_ms2_measures_a_plant(device: str) -> None:
    plant = Plant()
    chamber = plant.chamber(0.1, pressure_pa=0.2, gas="n2")
    plant.gauge(f"{device}@5", chamber)
    with plant.segment(via="pkw") as segment:
        plant.advance(300)
        assert segment.bus[5].read().value == pytest.approx(0.2, rel=0.1)


def test_the_channels_of_a_controller_are_in_several_chambers() -> None:
    plant, chamber, fore = pumped()
    plant.gauge("img400@5", chamber, parts={3: fore})
    with plant.segment() as segment:
        gauge = segment.bus[5]
        gauge.command("execute")
        plant.advance(60)
        shown = gauge.read(part="channel.3")
        assert shown.value == pytest.approx(fore.pressure_pa, rel=0.3), shown


def test_a_real_sensor_releases_gas_during_a_degas() -> None:
    plant, chamber, _ = pumped()
    plant.gauge("bcg450@5", chamber)
    with plant.segment(seed=1) as segment:
        gauge = segment.bus[5]
        gauge.command("execute")
        plant.advance(60)
        before = chamber.gases_pa.get("co", 0.0)
        gauge.command("degas on", confirm=True)
        plant.advance(60)
        assert chamber.gases_pa["co"] > 10 * before


def test_a_run_is_the_same_each_time() -> None:
    def run() -> tuple[float, str]:
        plant, chamber, _ = pumped()
        plant.gauge("bcg450@5", chamber)
        with plant.segment(seed=7) as segment:
            segment.bus[5].command("execute")
            plant.advance(100.5)
            return chamber.pressure_pa, str(segment.bus[5].read())

    assert run() == run()


def test_wrong_numbers_and_parts_are_wrong_usage() -> None:
    plant, other = Plant(), Plant()
    chamber, foreign = plant.chamber(0.1), other.chamber(0.1)
    valve = plant.valve(chamber, plant.chamber(0.1), conductance_m3_s=0.1)
    wrong: tuple[Callable[[], object], ...] = (
        lambda: Plant(air_pa=0),
        lambda: Plant(humidity=2),
        lambda: Plant(step_s=0),
        lambda: plant.chamber(-1),
        lambda: plant.chamber(math.nan),
        lambda: plant.chamber(0.1, pressure_pa=math.inf),
        lambda: plant.chamber(0.1, gas="phlogiston"),
        lambda: plant.valve(chamber, foreign, conductance_m3_s=0.1),
        lambda: plant.valve(chamber, chamber, conductance_m3_s=0.1),
        lambda: plant.valve(chamber, plant.chamber(0.1)),
        lambda: plant.valve(chamber, plant.chamber(0.1), diameter_m=0.1, length_m=0.1, conductance_m3_s=0.1),
        lambda: setattr(valve, "opening", 1.1),
        lambda: plant.roughing_pump(chamber, speed_m3_s=0, ultimate_pa=1),
        lambda: plant.roughing_pump(chamber, speed_m3_s=1, ultimate_pa=1, speeds_m3_s={0.0: 1.0}),
        lambda: plant.turbo_pump(chamber, chamber, speed_m3_s=1),
        lambda: plant.turbo_pump(chamber, plant.chamber(0.1), speed_m3_s=1, compression=0.5),
        lambda: plant.capture_pump(chamber, speeds_m3_s={"phlogiston": 1}),
        lambda: plant.leak(chamber, flow_pa_m3_s=-1),
        lambda: plant.wall(chamber, material="cheese", area_m2=1),
        lambda: plant.wall(chamber, material="steel", area_m2=1).heat(0),
        lambda: plant.seal(chamber, area_m2=1, thickness_m=0, permeabilities_m2_s={"he": 1e-11}),
        lambda: plant.advance(-1),
        lambda: plant.advance(math.nan),
        lambda: plant.segment(),
        lambda: plant.gauge("bcg450@5", foreign),
        lambda: [plant.chamber(0.1) for _ in range(100)],
    )
    for refused in wrong:
        with pytest.raises(pv.Usage):
            refused()
    with pytest.raises(pv.Usage, match="expected a material, one of steel, .*viton, got \"cheese\""):
        plant.wall(chamber, material="cheese", area_m2=1)
    with pytest.raises(pv.Usage, match="expected volume_m3 from 1e-9 to 1e6, got 0"):
        other.chamber(0)


def test_a_wrong_gauge_is_wrong_usage() -> None:
    plant = Plant()
    chamber = plant.chamber(0.1)
    plant.gauge("bcg451@5", chamber)
    with pytest.raises(pv.Usage, match="bcg451"):
        plant.segment()
    other = Plant()
    place = other.chamber(0.1)
    other.gauge("bcg450@5", place, parts={99: place})
    with pytest.raises(pv.Usage, match="bcg450 has no part 99; it has"):
        other.segment()
    third = Plant()
    third.gauge("bcg450@5", third.chamber(0.1))
    with third.segment():
        with pytest.raises(pv.Usage, match="close it first"):
            third.segment()
        with pytest.raises(pv.Usage, match="add the gauges before"):
            third.gauge("psg550@6", third.chamber(0.1))


def test_a_gauge_is_read_while_time_passes_in_another_thread() -> None:
    """The line is served between the slices, and no interpreter lock is held: this thread reads while the other one advances."""
    plant, chamber, _ = pumped()
    plant.gauge("bcg450@5", chamber)
    with plant.segment(timeout=300) as segment:
        segment.bus[5].command("execute")
        plant.advance(60)
        stop = threading.Event()

        def work() -> None:
            while not stop.is_set():
                plant.advance(3600)

        thread = threading.Thread(target=work)
        thread.start()
        try:
            before = plant.seconds
            while plant.seconds == before:
                time.sleep(0)
            # On a loaded computer the answer may come too late.
            while True:
                with contextlib.suppress(pv.Connection):
                    assert segment.bus[5].read().valid
                    break
        finally:
            stop.set()
            thread.join()


INTERRUPTED = """
import os, signal, threading
from profivac.vacuum import Plant
signal.signal(signal.SIGINT, signal.default_int_handler)  # A shell may have started the tests with the signal ignored.
plant = Plant(step_s=0.001)
chamber = plant.chamber(0.1)
plant.gauge("bcg450@5", chamber)
with plant.segment() as segment:
    try:
        threading.Timer(0, os.kill, (os.getpid(), signal.SIGINT)).start()
        while True:
            plant.advance(3e9)
    except KeyboardInterrupt:
        print("interrupted")
    assert 0 <= plant.seconds < 3e9
"""


def test_ctrl_c_ends_the_passing_of_time(tmp_path: Path) -> None:
    command = [sys.executable, "-c", INTERRUPTED]
    result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=dict(os.environ), timeout=300)
    assert (result.returncode, result.stdout) == (0, "interrupted\n"), result.stderr


FORKED = """
import os, threading, time
import profivac as pv
from profivac.vacuum import Plant

idle, busy = Plant(), Plant()
chambers = [plant.chamber(0.1, pressure_pa=1, gas="n2") for plant in (idle, busy)]
idle.gauge("bcg450@5", chambers[0])
segment = idle.segment()
threading.Thread(target=lambda: [busy.advance(1e6) for _ in iter(int, 1)], daemon=True).start()
while busy.seconds == 0:
    time.sleep(0)
child = os.fork()
if child == 0:
    # A plant is memory; its gauges belong to the thread of the parent.
    assert abs(chambers[0].pressure_pa - 1) < 1e-9
    try:
        segment.bus[5].read()
    except pv.Usage as error:
        assert "a fork does not copy its thread" in str(error), error
    try:
        busy.seconds
    except pv.Usage as error:
        assert "when the process was forked" in str(error), error
    own = Plant()
    own.chamber(0.1)
    own.advance(10)
    os._exit(0)
_, status = os.waitpid(child, 0)
assert os.waitstatus_to_exitcode(status) == 0, status
segment.close()
os._exit(0)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
def test_a_plant_is_no_trap_after_a_fork(tmp_path: Path) -> None:
    command = [sys.executable, "-c", FORKED]
    result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=300)
    assert result.returncode == 0, result.stderr
