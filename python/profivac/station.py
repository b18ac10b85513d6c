"""A station over HTTP: its gauges, its history, its events."""

from __future__ import annotations

import http.cookiejar
import importlib
import json
import re
import ssl
import urllib.error
import urllib.parse
import urllib.request
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from typing import TYPE_CHECKING, Any

from ._errors import Connection, Refused, Usage
from ._types import Reading, State, Unit

if TYPE_CHECKING:
    import numpy
    import numpy.typing

_SECONDS = {"s": 1, "min": 60, "h": 3600, "d": 86400}
_EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)


@dataclass(frozen=True)
class Event:
    """An event of the record: an alarm, a command, a change of a gauge."""

    time: datetime
    gauge: str | None
    kind: str
    text: str


@dataclass(frozen=True)
class History:
    """The recorded pressures of a series in Pa. Each entry is the span from its time to that of the next one.

    ``None`` in ``low``, ``high`` and ``mean`` is a span without a valid pressure.
    """

    series: str
    time: tuple[datetime, ...]
    low: tuple[float | None, ...]
    high: tuple[float | None, ...]
    mean: tuple[float | None, ...]

    def numpy(self) -> tuple[numpy.typing.NDArray[Any], numpy.typing.NDArray[Any]]:
        """Times (``datetime64[ms]``, UTC) and means in Pa, ``nan`` where there is none. Needs numpy."""
        import numpy

        times = numpy.array([_milliseconds(time) for time in self.time], dtype="datetime64[ms]")
        return times, numpy.array([numpy.nan if mean is None else mean for mean in self.mean], dtype=float)

    def pandas(self) -> Any:
        """A ``DataFrame`` with the columns ``low``, ``mean`` and ``high`` in Pa, indexed by time. Needs pandas."""
        pandas = importlib.import_module("pandas")
        columns = {"low": self.low, "mean": self.mean, "high": self.high}
        index = pandas.DatetimeIndex(list(self.time), name="time")
        return pandas.DataFrame(columns, index=index, dtype=float)


class RemoteStation:
    """A station over its HTTP API. It is only read.

    A station with users needs ``user`` and ``password``. ``cafile`` is the certificate of a station with its own one.
    """

    def __init__(
        self,
        url: str,
        *,
        user: str | None = None,
        password: str | None = None,
        cafile: str | None = None,
        timeout: float = 10.0,
    ) -> None:
        if not url.startswith(("http://", "https://")):
            raise Usage(f"expected a URL such as http://127.0.0.1:8080, got {url!r}")
        self._url = url.rstrip("/")
        self._timeout = timeout
        try:
            context = ssl.create_default_context(cafile=cafile)
        except OSError as error:
            raise Usage(f"{cafile} is no certificate that can be read: {error}") from error
        self._opener = urllib.request.build_opener(
            urllib.request.HTTPCookieProcessor(http.cookiejar.CookieJar()),
            urllib.request.HTTPSHandler(context=context),
        )
        if user is not None:
            self._request("/api/login", body={"name": user, "password": password or ""})

    def _request(self, path: str, body: object = None, **query: str | int) -> Any:
        url = f"{self._url}{path}" + (f"?{urllib.parse.urlencode(query)}" if query else "")
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(url, data, {"content-type": "application/json"} if data else {})
        try:
            with self._opener.open(request, timeout=self._timeout) as answer:
                return json.loads(answer.read())
        except urllib.error.HTTPError as error:
            raise _problem(error) from error
        except (OSError, ValueError) as error:
            raise Connection(f"{self._url} gives no answer of a station: {error}") from error

    def gauges(self) -> list[str]:
        """The names of the gauges."""
        return [gauge["name"] for gauge in self._request("/api/gauges")]

    def series(self) -> list[str]:
        """The names of the recorded series: a gauge, or ``gauge.N`` for channel N of a controller."""
        return [reading["series"] for gauge in self._request("/api/gauges") for reading in gauge["readings"]]

    def read(self, series: str, unit: Unit = Unit.PA) -> Reading:
        """The latest reading of a series, with the time at which the station read it."""
        for gauge in self._request("/api/gauges"):
            for row in gauge["readings"]:
                if row["series"] == series:
                    return _reading(row, gauge["read_ms"], unit)
        raise Usage(f"{self._url} has no series {series!r}; known: {', '.join(self.series())}")

    def history(
        self, series: str, since: str | datetime = "-1h", until: datetime | None = None, *, entries: int = 1000
    ) -> History:
        """The recorded pressures since a time, or since ``-30min``, ``-1h``, ``-7d``, in at most ``entries`` spans (1 to 20000)."""
        end = until or datetime.now(timezone.utc)
        times = {"from": _milliseconds(_since(since, end)), "to": _milliseconds(end)}
        row = self._request("/api/trend", series=series, pixels=entries, **times)
        if not row["start_ms"] and series not in self.series() and series.partition(".")[0] not in self.gauges():
            # A gauge that has not answered since the station started is among the gauges only.
            raise Usage(f"{self._url} has no series {series!r}; known: {', '.join(self.series())}")
        columns = (tuple(row[name]) for name in ("low", "high", "mean"))
        return History(series, tuple(map(_time, row["start_ms"])), *columns)

    def events(self, since: str | datetime = "-1h", until: datetime | None = None, *, limit: int = 200) -> list[Event]:
        """The events since a time, at most ``limit`` (1 to 10000)."""
        end = until or datetime.now(timezone.utc)
        times = {"from": _milliseconds(_since(since, end)), "to": _milliseconds(end)}
        rows = self._request("/api/events", limit=limit, **times)
        return [Event(_time(row["at_ms"]), row.get("gauge"), row["kind"], row["text"]) for row in rows]


def _reading(row: dict[str, Any], read_ms: int | None, unit: Unit) -> Reading:
    state = State(row["quality"])
    end = None if row["limit_pa"] is None else unit.from_pa(row["limit_pa"])
    bounds = {State.UNDERRANGE: (None, end), State.OVERRANGE: (end, None)}.get(state, (None, None))
    value = None if row["pa"] is None else unit.from_pa(row["pa"])
    time = datetime.now(timezone.utc) if read_ms is None else _time(read_ms)
    return Reading(value, unit, state, time, bounds, row["cause"], row["instance"])


def _time(milliseconds: float) -> datetime:
    return _EPOCH + timedelta(milliseconds=milliseconds)


def _milliseconds(time: datetime) -> int:
    if time.tzinfo is None:
        raise Usage(f"expected a time with its zone, such as datetime.now(timezone.utc), got {time!r}")
    return (time - _EPOCH) // timedelta(milliseconds=1)


def _since(since: str | datetime, end: datetime) -> datetime:
    if isinstance(since, datetime):
        return since
    parts = re.fullmatch(r"-(\d+(?:\.\d+)?)(s|min|h|d)", since)
    if parts is None:
        raise Usage(f"expected a time such as '-30min', '-1h' or '-7d', got {since!r}")
    return end - timedelta(seconds=float(parts[1]) * _SECONDS[parts[2]])


def _problem(error: urllib.error.HTTPError) -> Exception:
    """The exception for a problem document (RFC 9457)."""
    try:
        problem = json.loads(error.read())
        sentence = f"{problem['title']}: {problem['detail']}" if problem.get("detail") else str(problem["title"])
    except (ValueError, KeyError, TypeError):
        sentence = f"{error.code} {error.reason}"
    if error.code in (401, 403):
        return Refused(f"{sentence}; pass user and password")
    return Connection(sentence) if error.code >= 500 else Usage(sentence)
