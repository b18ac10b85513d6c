"""Names of ports, and of device files."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike, fspath

from ._errors import Usage

DeviceFiles = str | PathLike[str] | Sequence[str | PathLike[str]]
"""Files that describe devices, and folders of them; or one of them."""


def device_paths(files: DeviceFiles) -> list[str]:
    """The paths of device files."""
    return [fspath(file) for file in ([files] if isinstance(files, (str, PathLike)) else files)]


def is_station(port: str) -> bool:
    """Whether this is the address of a station."""
    return port.startswith(("http://", "https://"))


def is_devices(port: str) -> bool:
    """Whether this is ``sim:`` with devices, and not with a segment file."""
    return port.startswith("sim:") and "@" in port and not port.endswith(".toml")


def plain_port(port: str) -> str:
    """The name of a port of this computer, with ``tcp:host:port`` as ``tcp://host:port``."""
    if is_station(port):
        raise Usage(f"expected a port, got the address of a station, {port}; the station is the master of its lines")
    if port.startswith("tcp:") and not port.startswith("tcp://"):
        return "tcp://" + port.removeprefix("tcp:")
    return port
