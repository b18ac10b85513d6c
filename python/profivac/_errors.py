"""The exceptions of the package, after the exit codes of the program ``profivac``."""


class ProfivacError(Exception):
    """The base of all exceptions of this package.

    ``exit_code`` is the one with which the program ``profivac`` ends for the same reason. ``effect`` says whether the gauge may have the
    value of a write that failed: ``not-sent``, ``refused``, ``possibly-executed`` or ``executed``; it is ``None`` for other requests.

    >>> import profivac as pv
    >>> try:
    ...     pv.open("sim:bcg451@5")
    ... except pv.ProfivacError as error:
    ...     print(type(error).__name__, error.exit_code)
    Usage 2
    """

    exit_code: int = 1
    effect: str | None = None


class Refused(ProfivacError):
    """The device refused the request, or would refuse it. Exit code 1."""

    exit_code = 1


class Usage(ProfivacError, ValueError):
    """The request is wrong: an unknown name, a value that the device cannot have, a wrong file. Exit code 2."""

    exit_code = 2


class Connection(ProfivacError, OSError):
    """The port is missing, busy or lost, or nobody answers. Exit code 3."""

    exit_code = 3
