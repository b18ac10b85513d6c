"""Recorded traffic in sentences."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from . import _profivac
from ._errors import Usage
from ._ports import DeviceFiles, device_paths


@dataclass(frozen=True)
class Note:
    """A sentence about one change on the line."""

    station: int | None
    """The address of the station; ``None`` for the line."""
    kind: str
    """The subject: ``presence``, ``start-up``, ``parameter``, ``refused`` ..."""
    text: str


@dataclass(frozen=True)
class Telegram:
    """A telegram of a recording, or octets that are none."""

    seconds: float | None
    """The time of its first octet in s; ``None`` if the recording has no times."""
    octets: bytes
    kind: str
    """``telegram``, ``damaged``, or ``doubtful`` for an octet that may be part of damaged ones."""
    meaning: str
    """What it means for its station; may be empty."""
    notes: tuple[Note, ...]


def decode(
    recording: bytes | str | PathLike[str], *, baud: int = 19200, device_files: DeviceFiles = ()
) -> list[Telegram]:
    """Explains a recording: the path of a pcapng file, a trace or a log, or its contents as ``bytes``.

    ``baud`` in bit/s applies when the recording has no rate; ``device_files`` are those of :func:`profivac.open`. A recording without a
    telegram raises :class:`profivac.Usage`.

    >>> import profivac as pv
    >>> for telegram in pv.decode(b"TX 68 07 07 68 FF 82 46 3A 3E 02 00 41 16"):
    ...     print(telegram.notes[0].text)
    master 2 sends Global_Control Clear_Data to all
    """
    try:
        contents = recording if isinstance(recording, bytes) else Path(recording).read_bytes()
    except OSError as error:
        raise Usage(f"{recording!s} cannot be read: {error}") from error
    rows = _profivac.decode(contents, baud, device_paths(device_files))
    return [
        Telegram(seconds, octets, kind, meaning, tuple(Note(*note) for note in notes))
        for seconds, octets, kind, meaning, notes in rows
    ]
