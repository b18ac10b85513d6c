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
from ._ports import DeviceFiles, device_paths, is_devices, is_station, plain_port
from ._profivac import __version__
from ._station_bus import StationBus, StationGauge
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
    "StationBus",
    "StationGauge",
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
    device_files: DeviceFiles = (),
    user: str | None = None,
    password: str | None = None,
    cafile: str | None = None,
) -> Bus:
    """Opens a port and makes this program a master on its line, or opens a station.

    ``port`` is a serial device or pty (``/dev/ttyUSB0``), ``tcp://host:port``, ``sim:FILE.toml`` for a segment file, ``sim:`` and virtual
    devices: ``sim:bcg450@5 pcg550@6``, or the address of a station: ``http://127.0.0.1:8080``, ``https://station:8443``. ``names`` gives
    addresses a name. ``baud`` is in bit/s, ``master`` the address of this program, ``timeout`` in s.

    ``device_files`` names files that describe devices (docs/device-files.md), and folders of them. Those of
    ``/usr/share/profivac/devices`` and ``~/.config/profivac/devices`` are known without that; a wrong one there is left out. Virtual
    devices of files, ``sim:my-gauge.toml@5``, are known too.

    The bus of a station is a :class:`StationBus`: its gauges are read over HTTP, and ``.station`` has history and events. ``user``,
    ``password`` and ``cafile`` are for a station, as with :func:`connect`; ``baud``, ``master``, ``via`` and ``device_files`` are not.

    ``via`` is the way to the parameters. ``ms2`` takes no ownership: a PLC that owns a gauge stays its owner. ``pkw`` (the parameter
    channel, the only way to a TPG 300 or TPG 500) and ``ms1`` take ownership of a gauge for each request, and are refused while another
    master owns it.

    >>> import profivac as pv
    >>> pv.open("/dev/does-not-exist")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    profivac._errors.Connection: ...
    """
    if is_station(port):
        return StationBus(connect(port, user=user, password=password, cafile=cafile, timeout=timeout), names or {})
    if (user, password, cafile) != (None, None, None):
        raise Usage(f"user, password and cafile are for the address of a station, and {port!r} is a port")
    if is_devices(port):
        segment = VirtualSegment(*port.removeprefix("sim:").split(), names=names, via=via, master=master, timeout=timeout)
        return segment.bus
    core = _profivac.Bus.open(plain_port(port), baud, master, timeout, device_paths(device_files))
    return Bus(core, names or {}, via)


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


def parameters_of(device: str) -> dict[str, Parameter]:
    """The parameters of a device by its name, or of a device file (``"my-gauge.toml"``), without a bus.

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
