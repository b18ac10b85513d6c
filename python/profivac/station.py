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
from ._types import Reading, State, Unit, unit_of

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

    ``None`` in ``low`` and ``high`` is a span without a pressure; beyond its range a gauge has the end of the range there. ``mean`` is that
    of the measured pressures, ``None`` where there is none.

    >>> from datetime import datetime, timezone
    >>> begin = datetime(2026, 11, 23, tzinfo=timezone.utc)
    >>> history = History("chamber", (begin,), (1e-4,), (3e-4,), (2e-4,))
    >>> history.numpy()[1]
    array([0.0002])
    >>> list(history.pandas().columns)
    ['low', 'mean', 'high']
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

    A station with users needs ``user`` and ``password``. ``cafile`` is the certificate of a station with its own one, ``timeout`` in s.

    >>> import profivac as pv
    >>> station = pv.connect("http://127.0.0.1:8080")  # doctest: +SKIP
    >>> print(station.read("chamber", pv.Unit.MBAR))  # doctest: +SKIP
    5.200e-06 mbar
    >>> times, pascal = station.history("chamber", "-1h").numpy()  # doctest: +SKIP
    >>> [event.text for event in station.events("-1d")]  # doctest: +SKIP
    ['valid again']
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
        self._user = user
        self._token = ""
        if user is not None:
            session = self._request("/api/login", body={"name": user, "password": password or ""})
            self._token = session["token"]

    def _request(self, path: str, body: object = None, **query: str | int) -> Any:
        url = f"{self._url}{path}" + (f"?{urllib.parse.urlencode(query)}" if query else "")
        data = None if body is None else json.dumps(body).encode()
        headers = {} if data is None else {"content-type": "application/json", "x-csrf-token": self._token}
        request = urllib.request.Request(url, data, headers)
        try:
            with self._opener.open(request, timeout=self._timeout) as answer:
                text = answer.read()
                return json.loads(text) if text else None
        except urllib.error.HTTPError as error:
            raise _problem(error) from error
        except (OSError, ValueError) as error:
            raise Connection(f"{self._url} gives no answer of a station: {error}") from error

    @property
    def url(self) -> str:
        """The address of the station."""
        return self._url

    def rows(self) -> list[dict[str, Any]]:
        """The gauges as the HTTP API describes them (``/api/gauges``)."""
        rows: list[dict[str, Any]] = self._request("/api/gauges")
        return rows

    def row(self, gauge: str) -> dict[str, Any]:
        """One gauge as the HTTP API describes it (``/api/gauges/{name}``)."""
        row: dict[str, Any] = self._request(f"/api/gauges/{urllib.parse.quote(gauge, safe='')}")
        return row

    def blocks(self, gauge: str) -> list[dict[str, Any]]:
        """The blocks of a gauge with their parameters, read from it now (``/api/gauges/{name}/blocks``)."""
        rows: list[dict[str, Any]] = self._request(f"/api/gauges/{urllib.parse.quote(gauge, safe='')}/blocks")
        return rows

    def log_out(self) -> None:
        """Ends the session of the user. Does nothing without one."""
        if self._user is not None:
            self._user = None
            self._request("/api/logout", body={})

    def gauges(self) -> list[str]:
        """The names of the gauges."""
        return [gauge["name"] for gauge in self.rows()]

    def series(self) -> list[str]:
        """The names of the recorded series: a gauge, or ``gauge.N`` for channel N of a controller."""
        return [reading["series"] for gauge in self.rows() for reading in gauge["readings"]]

    def read(self, series: str, unit: Unit | str = Unit.PA) -> Reading:
        """The latest reading of a series, with the time at which the gauge gave it.

        Of a gauge that never gave one, the state is ``State.STALE`` and the time ``None``.
        """
        wanted = unit_of(unit)
        for gauge in self.rows():
            if not gauge["readings"] and gauge["name"] in (series, series.rpartition(".")[0]):
                return never_read(gauge, wanted)
            for row in gauge["readings"]:
                if row["series"] == series:
                    return reading_of(row, gauge["read_ms"], wanted)
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


def never_read(gauge: dict[str, Any], unit: Unit) -> Reading:
    """The reading of a gauge that never gave one to the station."""
    return Reading(None, unit, State.STALE, None, cause=gauge["problem"] or "the station has no reading of it yet")


def reading_of(row: dict[str, Any], read_ms: int | None, unit: Unit) -> Reading:
    """A reading of the HTTP API. ``read_ms`` is ``None`` if the gauge never gave one."""
    state = State(row["quality"])
    end = None if row["limit_pa"] is None else unit.from_pa(row["limit_pa"])
    bounds = {State.UNDERRANGE: (None, end), State.OVERRANGE: (end, None)}.get(state, (None, None))
    value = None if row["pa"] is None else unit.from_pa(row["pa"])
    time = None if read_ms is None else _time(read_ms)
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
    # 408 late, 409 the gauge does not answer, 429 too many requests: another time the same request is right.
    return Connection(sentence) if error.code >= 500 or error.code in (408, 409, 429) else Usage(sentence)
