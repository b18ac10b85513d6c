"""The rules of PROFIBUS DP, run against a slave."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import profivac as pv
import pytest
from profivac import Conformance, Outcome, Rule

from conftest import Simulate

FAST = 500000
"""bit/s: the waits of a test are shorter."""


def test_a_virtual_gauge_breaks_no_rule() -> None:
    seen: list[Rule] = []
    result = pv.conform("sim:bcg450@5", 5, confirm=True, baud=FAST, timeout=300, report=seen.append)
    assert tuple(seen) == result.rules == tuple(result)
    assert [str(rule) for rule in result.broken] == []
    assert len(result) > 100
    assert len(result.passed) + len(result.not_tested) == len(result)
    assert all(rule.reason for rule in result.not_tested)
    status = result["layer2.fdl-status"]
    assert (status.rule, status.section) == ("FDL status is answered with status OK", "1.11")
    # A loaded computer may leave rules open, and then says so.
    if not any(rule.undecided for rule in result):
        result.check()
        assert status.outcome is Outcome.PASSED
    with pytest.raises(pv.Usage, match="there is no rule 'layer3'; known: layer2"):
        result["layer3"]


class Stop(Exception):
    pass


def test_an_error_of_the_report_ends_the_test_and_frees_the_slave(simulate: Simulate, tmp_path: Path) -> None:
    place = simulate("--pty", tmp_path / "line", "tpg500@5")

    def report(rule: Rule) -> None:
        raise Stop(rule.name)

    with pytest.raises(Stop, match="layer2"):
        pv.conform(place, 5, confirm=True, timeout=300, report=report)
    with pv.open(place, timeout=300) as bus:
        # A scan asks once, and a loaded computer can be later than the slot time.
        found = next(found for found in iter(lambda: bus.scan(5, 5), None) if found)
        assert found[0].owner is None


def test_a_configuration_that_the_slave_does_not_have_breaks_rules() -> None:
    seen: list[Rule] = []

    def report(rule: Rule) -> None:
        seen.append(rule)
        if rule.outcome is Outcome.BROKEN:
            raise Stop

    try:
        result = pv.conform("sim:bcg450@5", 5, confirm=True, cfg=bytes([0x11]), baud=FAST, timeout=300, report=report)
    except Stop:
        pass
    else:
        # A loaded computer disturbed each test; then no rule is called broken.
        assert any(rule.undecided for rule in result), result
        return
    broken = seen[-1]
    assert broken.expected and broken.request and broken.answer
    assert str(broken).startswith(f"{broken.name}: broken: expected ")
    with pytest.raises(pv.Refused, match=f"the slave at address 5 breaks 1 of .* rules: {broken.name}"):
        Conformance(5, tuple(seen)).check()


def test_a_rule_that_the_line_left_open_is_no_answer() -> None:
    rule = Rule("a.b", "A rule", "1.1", Outcome.NOT_TESTED, None, "the line is disturbed", None, True, None, None)
    assert str(rule) == "a.b: not tested: the line is disturbed"
    with pytest.raises(pv.Connection, match="left rules open: a.b; check cable"):
        Conformance(5, (rule,)).check()


def test_conform_refuses_what_it_cannot_do() -> None:
    refused: tuple[Callable[[], object], ...] = (
        lambda: pv.conform("sim:bcg450@5", 5),
        lambda: pv.conform("sim:bcg450@5", 0, confirm=True),
        lambda: pv.conform("sim:bcg450@5", 126, confirm=True),
        lambda: pv.conform("http://station", 5, confirm=True),
        lambda: pv.conform("sim:bcg450@5", 5, confirm=True, baud=1),
    )
    for wrong in refused:
        with pytest.raises(pv.Usage):
            wrong()
    with pytest.raises(pv.Connection, match="address 9"):
        pv.conform("sim:bcg450@5", 9, confirm=True, timeout=0.5)
    with pytest.raises(pv.Connection):
        pv.conform("/dev/does-not-exist", 9, confirm=True)


INTERRUPTED = """
import os, signal, threading
import profivac as pv
signal.signal(signal.SIGINT, signal.default_int_handler)  # A shell may have started the tests with the signal ignored.
def report(rule):
    os.kill(os.getpid(), signal.SIGINT)
try:
    pv.conform("sim:bcg450@5", 5, confirm=True, baud=500000, timeout=300, report=report)
except KeyboardInterrupt:
    print("interrupted")
"""


def test_ctrl_c_ends_the_test(tmp_path: Path) -> None:
    command = [sys.executable, "-c", INTERRUPTED]
    result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=300)
    assert (result.returncode, result.stdout) == (0, "interrupted\n"), result.stderr
