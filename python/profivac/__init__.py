"""PROFIBUS vacuum gauges by the names of their manuals.

>>> import profivac as pv
>>> with pv.open("sim:bcg450@5:unit=mbar", names={"chamber": 5}) as bus:
...     gauge = bus["chamber"]
...     change = gauge.command("execute")
...     print(gauge.read(pv.Unit.MBAR))
1.000e-03 mbar
"""

from __future__ import annotations

from collections.abc import Mapping

from . import _profivac
from ._bus import Bus, Exchange, Gauge, tables
from ._conform import Conformance, Outcome, Rule, conform
from ._decode import Note, Telegram, decode
from ._errors import Connection, ProfivacError, Refused, Usage
from ._profivac import __version__
from ._types import Change, Command, Difference, Parameter, Reading, Restored, State, Station, Unit, Value
from ._virtual import PlantSegment, VirtualSegment
from .station import Event, History, RemoteStation

__all__ = [
    "Bus",
    "Change",
    "Command",
    "Conformance",
    "Connection",
    "Difference",
    "Event",
    "Exchange",
    "Gauge",
    "History",
    "Note",
    "Outcome",
    "Parameter",
    "PlantSegment",
    "ProfivacError",
    "Reading",
    "Refused",
    "RemoteStation",
    "Restored",
    "Rule",
    "State",
    "Station",
    "Telegram",
    "Unit",
    "Usage",
    "Value",
    "VirtualSegment",
    "__version__",
    "conform",
    "connect",
    "decode",
    "open",
    "parameters_of",
    "pascal",
]


def open(
    port: str,
    *,
    names: Mapping[str, int] | None = None,
    baud: int = 19200,
    master: int = 0,
    timeout: float = 5.0,
    via: str = "ms2",
) -> Bus:
    """Opens a port and makes this program a master on its line.

    ``port`` is a serial device or pty (``/dev/ttyUSB0``), ``tcp://host:port``, ``sim:FILE.toml`` for a segment file, or ``sim:`` and
    virtual devices: ``sim:bcg450@5 pcg550@6``. ``names`` gives addresses a name. ``baud`` is in bit/s, ``master`` the address of this
    program, ``timeout`` in s.

    ``via`` is the way to the parameters. ``ms2`` takes no ownership: a PLC that owns a gauge stays its owner. ``pkw`` (the parameter
    channel, the only way to a TPG 300 or TPG 500) and ``ms1`` take ownership of a gauge for each request, and are refused while another
    master owns it.

    >>> import profivac as pv
    >>> pv.open("/dev/does-not-exist")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    profivac._errors.Connection: ...
    """
    address = _tcp(port)
    if address.startswith(("http://", "https://")):
        raise Usage(f"expected a port, got the address of a station; use profivac.connect({port!r})")
    if address.startswith("sim:") and "@" in address and not address.endswith(".toml"):
        segment = VirtualSegment(
            *address.removeprefix("sim:").split(), names=names, via=via, master=master, timeout=timeout
        )
        return segment.bus
    return Bus(_profivac.Bus.open(address, baud, master, timeout), names or {}, via)


def connect(
    url: str,
    *,
    user: str | None = None,
    password: str | None = None,
    cafile: str | None = None,
    timeout: float = 10.0,
) -> RemoteStation:
    """A station over HTTP: ``profivac.connect("https://station:8443", user="eva", password="...")``.

    ``cafile`` is the certificate of a station with its own one, ``timeout`` in s.
    """
    return RemoteStation(url, user=user, password=password, cafile=cafile, timeout=timeout)


def _tcp(port: str) -> str:
    """``tcp:host:port`` as ``tcp://host:port``."""
    if port.startswith("tcp:") and not port.startswith("tcp://"):
        return "tcp://" + port.removeprefix("tcp:")
    return port


def parameters_of(device: str) -> dict[str, Parameter]:
    """The parameters of a device by its name, without a bus.

    >>> parameters_of("bcg450")["pirani.safe-state"].choices[:2]
    ('zero', 'full-scale')
    """
    return tables(_profivac.parameters_of(device))[0]


def pascal(text: str) -> float:
    """A pressure with its unit, in Pa.

    >>> pascal("1e-3 mbar")
    0.1
    """
    return _profivac.convert(text)
