"""A slave tested against the rules of PROFIBUS DP."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from . import _profivac
from ._errors import Connection, Refused, Usage
from ._ports import DeviceFiles, device_paths, plain_port


class Outcome(enum.Enum):
    """The outcome of a rule."""

    PASSED = "passed"
    """The slave keeps the rule."""
    BROKEN = "broken"
    """The slave breaks the rule; several tests have shown it."""
    NOT_TESTED = "not-tested"
    """The rule was not tested: ``reason`` says why."""


@dataclass(frozen=True)
class Rule:
    """A rule with its outcome, as ``profivac conform --json`` has it."""

    name: str
    """``layer2.fdl-status``: a name for scripts."""
    rule: str
    """The rule in one sentence."""
    section: str
    """The section of the protocol reference; docs/conformance.md has the sources."""
    outcome: Outcome
    expected: str | None
    """What a broken rule expects."""
    reason: str | None
    """Why the rule was not tested."""
    because: str | None
    """The rule that is the reason: the slave breaks it, or it was not tested itself."""
    undecided: bool
    """The line, the computer or a silent slave left the rule open; another run may test it."""
    request: bytes | None
    """The request that shows a broken rule."""
    answer: str | None
    """The answer to it in hex, or ``nothing``."""

    def __str__(self) -> str:
        found = {Outcome.PASSED: "passed", Outcome.BROKEN: f"broken: expected {self.expected}, got {self.answer}"}
        return f"{self.name}: {found.get(self.outcome, f'not tested: {self.reason}')}"


@dataclass(frozen=True)
class Conformance:
    """The outcomes of all rules: an iterator of :class:`Rule`."""

    address: int
    rules: tuple[Rule, ...]

    def __iter__(self) -> Iterator[Rule]:
        return iter(self.rules)

    def __len__(self) -> int:
        return len(self.rules)

    def __getitem__(self, name: str) -> Rule:
        for rule in self.rules:
            if rule.name == name:
                return rule
        raise Usage(f"there is no rule {name!r}; known: {', '.join(rule.name for rule in self.rules)}")

    def _with(self, outcome: Outcome) -> tuple[Rule, ...]:
        return tuple(rule for rule in self.rules if rule.outcome is outcome)

    @property
    def passed(self) -> tuple[Rule, ...]:
        """The rules that the slave keeps."""
        return self._with(Outcome.PASSED)

    @property
    def broken(self) -> tuple[Rule, ...]:
        """The rules that the slave breaks."""
        return self._with(Outcome.BROKEN)

    @property
    def not_tested(self) -> tuple[Rule, ...]:
        """The rules that were not tested."""
        return self._with(Outcome.NOT_TESTED)

    def check(self) -> None:
        """Raises what the exit code of ``profivac conform`` says: ``Refused`` (1) if the slave breaks a rule, ``Connection`` (3) if rules
        are undecided because of the line, the computer or a silent slave."""
        if self.broken:
            names = ", ".join(rule.name for rule in self.broken)
            raise Refused(f"the slave at address {self.address} breaks {len(self.broken)} of {len(self)} rules: {names}")
        undecided = [rule.name for rule in self.rules if rule.undecided]
        if undecided:
            raise Connection(
                f"the test of the slave at address {self.address} left rules open: {', '.join(undecided)}; "
                "check cable and termination, and repeat it while the computer has nothing else to do"
            )


def conform(
    port: str,
    address: int,
    *,
    confirm: bool = False,
    cfg: bytes | None = None,
    user_prm: bytes | None = None,
    baud: int = 19200,
    master: int = 0,
    timeout: float = 5.0,
    device_files: DeviceFiles = (),
    report: Callable[[Rule], object] | None = None,
) -> Conformance:
    """Tests a slave against the rules of PROFIBUS DP (docs/conformance.md): any DP slave, not only a gauge.

    ``port`` is that of :func:`profivac.open`, and no bus may be open on it. The test parameterises the slave, exchanges data with outputs
    of zero and releases it, many times: the relays of a gauge open and close. It also sends damaged telegrams. So it needs ``confirm``, a
    slave that is not in use, and a line without another master; the stored values of the slave stay as they are.

    ``cfg`` and ``user_prm`` are the configuration and the user parameters that the slave accepts; without them the answer to Get_Cfg,
    and the user parameters that keep the unit of a known gauge; a device whose file names outputs needs ``user_prm``. ``device_files``
    are those of :func:`profivac.open`. ``report`` is called with each rule as soon as it has an outcome. A run takes minutes; Ctrl-C ends
    it after the present rule, and the slave is released.

    >>> import profivac as pv
    >>> result = pv.conform("/dev/ttyUSB0", 5, confirm=True, report=print)  # doctest: +SKIP
    >>> [(rule.name, rule.expected, rule.answer) for rule in result.broken]  # doctest: +SKIP
    []
    >>> pv.conform("sim:bcg450@5", 5)
    Traceback (most recent call last):
    profivac._errors.Usage: conform parameterises the slave at address 5 and releases it, many times; nothing was sent; to do it pass confirm=True
    """
    if not confirm:
        raise Usage(
            f"conform parameterises the slave at address {address} and releases it, many times; nothing was sent; "
            "to do it pass confirm=True"
        )
    rules: list[Rule] = []

    def add(row: _profivac._RuleRow) -> None:
        (name, text, section), outcome, expected, reason, because, undecided, request, answer = row
        rules.append(
            Rule(name, text, section, Outcome(outcome), expected, reason, because, undecided, request, answer)
        )
        if report is not None:
            report(rules[-1])

    _profivac.conform(plain_port(port), address, cfg, user_prm, baud, master, timeout, device_paths(device_files), add)
    return Conformance(address, tuple(rules))
