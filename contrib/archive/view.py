#!/usr/bin/env python3
"""Checks the view of all stations: contrib/archive/view.py PROGRAM [--browser]

Two stations with virtual gauges, one server of NATS, PostgreSQL and two archives, the second one with users. What the API of the view answers is
compared with the database; an operator acknowledges an alarm of a station; wrong and hostile requests get their answer; PostgreSQL and a station are killed
and come back. Then the stations poll the archives over HTTPS, without NATS, and a station tries what it may not. With --browser the page
is tested in Chromium too.
"""

import concurrent.futures
import contextlib
import json
import os
import runpy
import ssl
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
example = runpy.run_path(str(Path(__file__).with_name("example.py")))
Example, Process, free_port, wait_for = example["Example"], example["Process"], example["free_port"], example["wait_for"]


PASSWORD = "a chamber of their own"


def expect(condition, text):
    if not condition:
        raise SystemExit(f"FAILED: {text}")


class View:
    def __init__(self, case, port):
        self.case, self.url, self.token = case, f"http://127.0.0.1:{port}", ""
        self.browser = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())

    def ask(self, path, method="GET", headers=None, body=None, **query):
        """The status of the answer, and its JSON."""
        address = f"{self.url}{urllib.parse.quote(path)}?{urllib.parse.urlencode(query)}"
        headers = {"content-type": "application/json", "x-csrf-token": self.token, **(headers or {})}
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(address, data=data, method=method, headers=headers)
        try:
            with self.browser.open(request, timeout=60) as answer:
                text = answer.read()
                return answer.status, json.loads(text) if text else None
        except urllib.error.HTTPError as error:
            return error.code, json.load(error)

    def login(self, name):
        status, session = self.ask("/api/login", "POST", body={"name": name, "password": PASSWORD})
        expect(status == 200, f"the login of {name}: {session}")
        self.token = session["token"]

    def acknowledge(self, station, alarm, occurrence):
        return self.ask(f"/api/stations/{station}/alarms/{alarm}/acknowledge", "POST", body={"occurrence": occurrence})

    def state(self):
        status, state = self.ask("/api/archive")
        expect(status == 200, f"/api/archive answers with {status}: {state}")
        return state

    def is_complete(self):
        try:
            state = self.state()
        except OSError:
            return False
        return len(state["readings"]) == 4 and len(state["alarms"]) == 2


def shows_the_database(view):
    state = view.state()
    expect(sorted(state["stations"]) == ["station-0", "station-1"], f"stations: {state['stations']}")
    expect([state["stations"][name]["plant"] for name in sorted(state["stations"])] == ["hall", "ring"], "the plants are wrong")
    for key, reading in state["readings"].items():
        # A reading is on the page before the database has it.
        rows = wait_for(f"the sample of {key}", lambda: view.case.query(
            f"SELECT pressure_pa, quality FROM profivac.sample WHERE station || '/' || series = '{key}' "
            f"AND (extract(epoch FROM at) * 1000)::bigint = {reading['at_ms']}"))
        expect(rows == [[repr(reading["pa"]), "0"]] or float(rows[0][0]) == reading["pa"], f"{key}: {reading} and {rows}")
    for name in ("station-0", "station-1"):
        alarm = state["alarms"][f"{name}/chamber too high"]
        expect((alarm["state"], alarm["priority"]) == ("unacknowledged", "high"), f"the alarm is {alarm}")
    print("ok: stations, readings and alarms are those of the database")


def follows_the_stations(view):
    with urllib.request.urlopen(f"{view.url}/api/live", timeout=60) as stream:
        names, changed = [], False
        while not changed:
            line = stream.readline().decode()
            if line.startswith("event: "):
                names.append(line.removeprefix("event: ").strip())
            if line.startswith("data: ") and names[-1] == "change":
                change = json.loads(line.removeprefix("data: "))
                changed = any("at_ms" in reading for reading in change.get("readings", {}).values())
    expect(names[0] == "snapshot" and set(names[1:]) == {"change"}, f"the stream has {names}")
    print("ok: new readings come in the live stream")


def draws_trends(view):
    now = view.state()["now_ms"]
    status, trend = view.ask("/api/trend", series="station-0/chamber", **{"from": now - 60_000, "to": now, "pixels": 50})
    expect(status == 200 and 1 <= len(trend["start_ms"]) <= 50, f"a trend of a minute: {trend}")
    expect(all(low <= mean * 1.000001 and mean <= high * 1.000001
               for low, mean, high in zip(trend["low"], trend["mean"], trend["high"])), f"the mean is outside: {trend}")
    expect(trend["start_ms"] == sorted(trend["start_ms"]) and trend["qualities"] == [1] * len(trend["low"]), f"{trend}")
    # A year is drawn from the spans of six hours, which a short record does not have yet; the longest time is no error.
    for begin, end in ((now - 366 * 86_400_000, now), (-(2**63), 2**63 - 1)):
        status, year = view.ask("/api/trend", series="station-0/chamber", **{"from": begin, "to": end})
        expect(status == 200, f"a trend from {begin} to {end}: {year}")
    events = view.ask("/api/events", **{"from": 0, "to": now + 3_600_000, "station": "station-1"})[1]
    expect(events and {event["station"] for event in events} == {"station-1"}, f"events of one station: {events[:2]}")
    expect([event["at_ms"] for event in events] == sorted((event["at_ms"] for event in events), reverse=True), "the order of events")
    print("ok: trends and events")


def refuses(view):
    time_range = {"from": 0, "to": 1}
    injected = "station-0/x'; DROP TABLE profivac_data.sample; --"
    for status, path, query, sentence in [
        (400, "/api/trend", {"series": "station-0/chamber", "from": 1, "to": 1}, "expected from to lie before to"),
        (400, "/api/trend", {"series": "chamber", **time_range}, "expected series=STATION/SERIES"),
        (400, "/api/trend", {"series": "station-0/chamber", "pixels": 20001, **time_range}, "expected pixels from 1 to 20000"),
        (400, "/api/trend", {"series": "station-0/chamber", "pixels": 0, **time_range}, "expected pixels from 1 to 20000"),
        (400, "/api/trend", {"series": "station-0/chamber", "from": "x", "to": 1}, "invalid digit"),
        (400, "/api/trend", {"series": "station-0/\0", **time_range}, ""),
        (400, "/api/trend", {"series": "a/b", "level": 2, **time_range}, "unknown field"),
        (400, "/api/events", {"limit": 10001, **time_range}, "expected limit from 1 to 10000"),
        (200, "/api/trend", {"series": injected, **time_range}, None),
        (404, "/api/gauges", {}, "/api/openapi.json lists all paths"),
    ]:
        found, answer = view.ask(path, **query)
        expect(found == status and (sentence is None or sentence in answer["detail"]), f"{path} {query}: {found} {answer}")
    expect(view.case.count("sample") > 0, "the samples are lost")
    status, answer = view.ask("/api/archive", headers={"Host": "evil.example"})
    expect(status in (400, 403, 421), f"a foreign host is answered with {status}: {answer}")
    status, answer = view.ask("/api/archive", method="POST")
    expect(status in (403, 405), f"POST is answered with {status}: {answer}")
    print("ok: wrong and hostile requests get their answer")


def survives_the_database(view):
    view.case.postgres.kill()
    wait_for("the problem of the database", lambda: view.state()["problem"])
    readings = view.state()["readings"]
    wait_for("later readings without the database", lambda: any(
        reading["at_ms"] > readings[key]["at_ms"] for key, reading in view.state()["readings"].items()))
    status, answer = view.ask("/api/trend", series="station-0/chamber", **{"from": 0, "to": 1})
    expect(status == 503 and "does not answer" in answer["detail"], f"a trend without a database: {status} {answer}")
    view.case.start_again(view.case.postgres)
    before = {key: reading["at_ms"] for key, reading in view.state()["readings"].items()}
    wait_for("readings after the return of the database", lambda: view.state()["problem"] is None and all(
        reading["at_ms"] > before[key] for key, reading in view.state()["readings"].items()))
    # A connection that the failure left in the pool is not used again.
    for _ in range(8):
        status, answer = view.ask("/api/trend", series="station-0/chamber", **{"from": 0, "to": 1})
        expect(status == 200, f"a trend after the return: {answer}")
    print("ok: the view says that the database is gone, shows what passes through JetStream meanwhile, and goes on when it returns")


def asks_the_stations(view):
    """With users: a viewer may not acknowledge, an operator may, and the station names them."""
    status, answer = view.ask("/api/archive")
    expect(status == 401, f"without a login: {status} {answer}")
    view.login("eve")
    alarm, key = "chamber too high", "station-0/chamber too high"
    # The view with users has just begun: the alarms of the stations follow.
    wait_for("the alarms", lambda: {key, "station-1/chamber too high"} <= set(view.state()["alarms"]))
    occurrence = view.state()["alarms"][key]["occurrence"]
    status, answer = view.acknowledge("station-0", alarm, occurrence)
    expect(status == 403 and "needs the role operator" in answer["detail"], f"a viewer: {status} {answer}")
    view.login("ada")
    token, view.token = view.token, "0" * 64
    expect(view.acknowledge("station-0", alarm, occurrence)[0] == 403, "a wrong token is accepted")
    view.token = token
    for station, name, number, status, sentence in [
        ("station-9", alarm, 1, 404, "no station"),
        ("station-0", "no alarm", 1, 409, "station-0 refuses: "),
        ("station-0", alarm, occurrence + 1, 409, "station-0 refuses: "),
    ]:
        found, answer = view.acknowledge(station, name, number)
        expect(found == status and sentence in answer["detail"], f"{station}, {name}, {number}: {found} {answer}")
    status, answer = view.acknowledge("station-0", alarm, occurrence)
    expect(status == 204, f"an operator: {status} {answer}")
    wait_for("the acknowledged alarm", lambda: view.state()["alarms"][key]["state"] == "acknowledged")
    shown = view.state()["alarms"][key]
    expect(shown["user"] == "archive:ada", f"the station has {shown}")
    rows = view.case.query("SELECT user_name, role FROM profivac.audit WHERE station = 'station-0' AND action = 'acknowledged'")
    expect(rows == [["archive:ada", "operator"]], f"the audit trail of the station: {rows}")
    expect(view.state()["alarms"]["station-1/chamber too high"]["state"] == "unacknowledged", "the other station is changed")
    print("ok: an operator acknowledges an alarm, and the station names them")


def hides_plants(view):
    """A user who is not in the list of a plant sees nothing of it, in any answer."""
    view.login("bob")
    state = view.state()
    expect(list(state["stations"]) == ["station-0"], f"stations of bob: {list(state['stations'])}")
    expect("station-1" not in json.dumps(state) and state["readings"] and state["alarms"], f"the state of bob: {state}")
    with view.browser.open(f"{view.url}/api/live", timeout=60) as stream:
        stream.readline()
        snapshot = stream.readline().decode()
    expect("station-0" in snapshot and "station-1" not in snapshot, f"the stream of bob begins with {snapshot}")
    now = state["now_ms"]
    all_time = {"from": 0, "to": now + 3_600_000}
    for full in ("false", "true"):
        answers = {name: view.ask("/api/trend", series=f"{name}/chamber", full=full, **all_time) for name in ("station-1", "station-9")}
        expect({status for status, _ in answers.values()} == {404}, f"trends of bob: {answers}")
        hidden, absent = (answers[name][1]["detail"].replace(name, "") for name in ("station-1", "station-9"))
        expect(hidden == absent, f"{hidden} differs from {absent}")
    expect(view.acknowledge("station-1", "chamber too high", 1)[0] == 404, "bob acknowledges at a station of another plant")
    events = view.ask("/api/events", **all_time)[1]
    expect({event["station"] for event in events} == {"station-0"}, f"events of bob: {events[:3]}")
    expect(view.ask("/api/events", station="station-1", **all_time) == (200, []), "bob reads events of another plant")
    view.login("ada")
    expect(sorted(view.state()["stations"]) == ["station-0", "station-1"], "ada does not see both plants")
    print("ok: a user sees the plants that the file permits, and no other")


def bounds_requests(view):
    """Many requests at once get an answer each: the trend, or that too many wait."""
    now = view.state()["now_ms"]
    query = {"series": "station-1/chamber", "from": now - 60_000, "to": now, "pixels": 100, "full": "true"}
    # A station that found no archive when it started polls again after a pause.
    wait_for("the first answer of the station", lambda: view.ask("/api/trend", **query)[0] == 200)
    with concurrent.futures.ThreadPoolExecutor(64) as pool:
        answers = [job.result() for job in [pool.submit(view.ask, "/api/trend", **query) for _ in range(200)]]
    expect({status for status, _ in answers} <= {200, 429, 503}, f"answers: {sorted({status for status, _ in answers})}")
    expect(any(status == 200 for status, _ in answers), "no request is answered with a trend")
    wait_for("an answer after many requests", lambda: view.ask("/api/trend", **query)[0] == 200)
    print("ok: 200 requests to a station at once")


def shows_full_resolution(view):
    station = view.case.stations[0]
    now = view.state()["now_ms"]
    query = {"series": "station-0/chamber", "from": now - 3_600_000, "to": now, "pixels": 4000, "full": "true"}
    status, trend = view.ask("/api/trend", **query)
    expect(status == 200 and trend["series"] == "station-0/chamber" and trend["start_ms"], f"from the station: {status} {trend}")
    [(first,)] = view.case.record(station, "SELECT min(at_us) FROM sample JOIN series ON series.id = series_id WHERE name = 'chamber'")
    expect(abs(trend["start_ms"][0] - first // 1000) < 1000, f"the trend begins at {trend['start_ms'][0]}, the record at {first}")
    expect(view.ask("/api/trend", **{**query, "pixels": 4001})[0] == 400, "4001 pixels are accepted")
    status, answer = view.ask("/api/trend", **{**query, "series": "station-9/chamber"})
    expect(status == 404, f"an unknown station: {status} {answer}")
    station.stop()
    status, answer = view.ask("/api/trend", **query)
    sentence = "does not listen" if view.case.has_nats else "is not connected to this archive"
    expect(status == 503 and f"station-0 {sentence}" in answer["detail"], f"a station that is stopped: {status} {answer}")
    station.start()
    wait_for("an answer of the station after its start", lambda: view.ask("/api/trend", **query)[0] == 200)
    print("ok: full resolution comes from the station, and a stopped one is named")


class Peer:
    """Speaks to an archive with the token of a station."""

    def __init__(self, case, name):
        self.token = (case.folder / f"{name}.token").read_text()
        self.url = f"https://localhost:{case.archive_ports[1]}/v1"
        self.trusted = ssl.create_default_context(cafile=case.folder / "server.crt")

    def ask(self, path, body=None):
        """The status of the answer, its header with the id of a request, and its body."""
        request = urllib.request.Request(f"{self.url}/{path}", body, {"Authorization": f"Bearer {self.token}"})
        try:
            with urllib.request.urlopen(request, context=self.trusted, timeout=60) as answer:
                return answer.status, answer.headers["profivac-request"], answer.read()
        except urllib.error.HTTPError as error:
            return error.code, None, error.read()


def guards_requests(view):
    """A station of another plant neither sees nor answers the requests of a station. Both stations are stopped, and played here."""
    for station in view.case.stations:
        station.stop()
    own, other = Peer(view.case, "station-0"), Peer(view.case, "station-1")
    now = view.state()["now_ms"]
    query = {"series": "station-0/chamber", "from": now - 60_000, "to": now, "pixels": 10, "full": "true"}
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        foreign = pool.submit(other.ask, "ring/station-1/request")
        polled = pool.submit(own.ask, "hall/station-0/request")
        asked = pool.submit(lambda: wait_for("a user who is not told that the station is absent", lambda: next(
            (answer for answer in [view.ask("/api/trend", **query)] if "is not connected" not in json.dumps(answer)), None)))
        status, identity, body = polled.result()
        expect(status == 200 and json.loads(body)["trend"]["series"] == "chamber", f"the station gets {status} {body}")
        for path, expected in [("hall/station-0/request", 403), (f"hall/station-0/request/{identity}", 403),
                               (f"ring/station-1/request/{identity}", 410), (f"hall/station-1/request/{identity}", 403)]:
            found = other.ask(path, None if path.endswith("request") else b'{"refused":"by another station"}')
            expect(found[0] == expected and b"chamber" not in found[2], f"{path} with the token of station-1: {found}")
        wrong = Peer(view.case, "station-0")
        wrong.token = "0" * 64
        expect(wrong.ask("hall/station-0/request")[0] == 401, "a wrong token polls")
        expect(own.ask(f"hall/station-0/request/{identity}", b'{"refused":"by its own station"}')[0] == 204, "the reply is not taken")
        status, answer = asked.result()
        expect(status == 409 and answer["detail"] == "station-0 refuses: by its own station", f"the user gets {status} {answer}")
        expect(own.ask(f"hall/station-0/request/{identity}", b'"done"')[0] == 410, "a second reply is taken")
        expect(foreign.result()[0] == 204, f"the other station gets {foreign.result()}")
        # A station that never replies delays its own users, and no others.
        silent = pool.submit(own.ask, "hall/station-0/request")
        begun = time.monotonic()
        status, answer = wait_for("a silent station", lambda: next(
            (answer for answer in [view.ask("/api/trend", **query)] if "is not connected" not in json.dumps(answer)), None))
        expect(status == 503 and "station-0 does not answer: no reply within 10 s" in answer["detail"], f"a silent station: {status} {answer}")
        late = own.ask(f"hall/station-0/request/{silent.result()[1]}", b'"done"')
        expect(late[0] == 410, f"a reply after {time.monotonic() - begun:.0f} s: {late}")
    for station in view.case.stations:
        station.start()
    wait_for("an answer of the station itself", lambda: view.ask("/api/trend", **query)[0] == 200)
    print("ok: a station of another plant, and one with a wrong token, neither see nor answer a request")


OLD_ARCHIVE = """
[https]
listen = "127.0.0.1:0"

[[station]]
plant = "hall"
name = "old"
token-file = "old.token"

[postgres]
connection = "host={host} port={port} user={user} dbname=old"
"""

OLD = """
CREATE SCHEMA profivac_data;
CREATE TABLE profivac_data.version (number integer NOT NULL);
INSERT INTO profivac_data.version VALUES (1);
INSERT INTO profivac_data.station (plant, name, epoch) VALUES ('hall', 'old', 2);
INSERT INTO profivac_data.alarm (station, epoch, id, at, alarm, change, state, priority, occurrence, text) VALUES
    (1, 1, 9, now(), 'a', 'raised', 'unacknowledged', 'high', 1, 'of the former database'),
    (1, 2, 1, now(), 'b', 'raised', 'unacknowledged', 'high', 1, 'raised'),
    (1, 2, 2, now(), 'b', 'acknowledged', 'acknowledged', 'high', 1, 'acknowledged'),
    (1, 2, 3, now(), 'c', 'raised', 'unacknowledged', 'low', 1, 'raised'),
    (1, 2, 4, now(), 'c', 'removed', 'unacknowledged', 'low', 1, 'removed');
"""

LATER = """
INSERT INTO profivac_data.alarm (station, epoch, id, at, alarm, change, state, priority, occurrence, text) VALUES
    (1, 2, 7, now(), 'd', 'raised', 'unacknowledged', 'low', 1, 'raised'),
    (1, 2, 6, now(), 'd', 'returned', 'normal', 'low', 1, 'an earlier one that comes late'),
    (1, 2, 5, now(), 'b', 'returned', 'normal', 'high', 1, 'returned');
INSERT INTO profivac_data.alarm (station, epoch, id, at, alarm, change, state, priority, occurrence, text) VALUES
    (1, 2, 2, now(), 'b', 'acknowledged', 'acknowledged', 'high', 1, 'acknowledged') ON CONFLICT DO NOTHING;
"""


def migrates(case):
    """The program brings tables of version 1 with alarms up to date; their list follows rows that come late or again."""
    run = lambda *arguments, text=None: subprocess.run(
        ["psql", "-X", "-q", "-At", "-v", "ON_ERROR_STOP=1", "-h", case.folder, "-p", str(case.postgres_port), "-U", case.user, *arguments],
        input=text, capture_output=True, text=True)
    run("-d", "postgres", "-c", "CREATE DATABASE old")
    scripts = ROOT / "crates/archive/sql"
    schema, *rows = OLD.strip().split("\n", 1)
    for text in (schema, (scripts / "1.sql").read_text(), *rows):
        done = run("-d", "old", text=text)
        expect(done.returncode == 0, f"the tables of version 1: {done.stderr}")
    token = case.folder / "old.token"
    token.touch(0o600)
    token.write_text("a-token-of-its-station")
    file = case.folder / "old.toml"
    file.write_text(OLD_ARCHIVE.format(host=case.folder, port=case.postgres_port, user=case.user))
    archive = Process("old", [case.program, "archive", file], case.folder)
    archive.start()
    try:
        def is_ready():
            expect(archive.is_running(), f"the archive with the tables of version 1 has ended: {archive.log.read_text()}")
            return "ready" in archive.log.read_text()

        wait_for("the archive with the tables of version 1", is_ready)
    finally:
        archive.stop()
    version = run("-d", "old", "-c", "SELECT max(number), count(*) FROM profivac_data.version").stdout.strip()
    last = len(list(scripts.glob("*.sql")))
    expect(version == f"{last}|{last}", f"the version is {version}, and the program has {last}")
    active = lambda: run("-d", "old", "-c", "SELECT alarm, state FROM profivac.active_alarm ORDER BY alarm").stdout.split()
    expect(active() == ["b|acknowledged"], f"after the migration: {active()}")
    done = run("-d", "old", text=LATER)
    expect(active() == ["d|unacknowledged"], f"after later rows: {active()} {done.stderr}")
    print("ok: tables of the former version, and alarms that come late or again")


def without_nats(program):
    """The same users, and stations that poll the archives over HTTPS."""
    with tempfile.TemporaryDirectory(prefix="profivac-view-") as folder:
        case, guarded = guarded_example(Path(program).resolve(), Path(folder), 0)
        view = View(case, case.view_port)
        with running(case):
            wait_for("the readings of all gauges", view.is_complete)
            asks_the_stations(guarded)
            hides_plants(guarded)
            shows_full_resolution(guarded)
            bounds_requests(guarded)
            guards_requests(guarded)
    print("ok: all of it without NATS")


def guarded_example(program, folder, servers):
    """Two stations and two archives, and the view of the second archive, which has users."""
    case, port = Example(program, 2, 2, servers, folder), free_port()
    second = folder / "archive-1.toml"
    second.write_text(second.read_text() + f'[view]\nlisten = "127.0.0.1:{port}"\nusers = "archive.users"\n'
                      + '[[plant]]\nname = "ring"\nreaders = []\nusers = ["ada", "eve"]\n')
    for name, role in (("ada", "operator"), ("eve", "viewer"), ("bob", "operator")):
        subprocess.run([program, "user", "add", name, "--role", role, "--password-stdin", second],
                       input=PASSWORD + "\n", text=True, check=True)
    return case, View(case, port)


@contextlib.contextmanager
def running(case):
    """Starts everything, shows the ends of the logs after a failure, and ends everything."""
    try:
        case.start()
        yield
    except SystemExit:
        for process in case.all():
            if process.log.exists():
                print(f"-- {process.name}\n{process.log.read_text()[-2000:]}", file=sys.stderr)
        raise
    finally:
        case.close()


def store_points(case):
    """The speed and the state of a turbo pump of station-0, for 20 minutes: the page draws them."""
    sql = """
        WITH point AS (
            INSERT INTO profivac_data.point (station, slave, name, unit, kind)
            SELECT id, 'turbo', new.name, unit, kind
            FROM profivac_data.station, (VALUES ('speed', 'Hz', 'number'), ('state', '', 'code')) AS new (name, unit, kind)
            WHERE station.name = 'station-0' RETURNING id)
        INSERT INTO profivac_data.point_span
        SELECT id, 2, to_timestamp(floor(extract(epoch FROM now()) / 120) * 120 - 120 * number), 0, 0, 3, 3, 3, 3, 1, 1
        FROM point, generate_series(1, 10) AS number"""
    psql = ["psql", "-X", "-q", "-h", case.folder, "-p", str(case.postgres_port), "-U", case.user, "-d", "postgres", "-c", sql]
    subprocess.run(psql, check=True, capture_output=True)


def main(program, browser):
    with tempfile.TemporaryDirectory(prefix="profivac-view-") as folder:
        case, guarded = guarded_example(Path(program).resolve(), Path(folder), 1)
        view = View(case, case.view_port)
        with running(case):
            wait_for("the readings of all gauges", view.is_complete)
            shows_the_database(view)
            follows_the_stations(view)
            draws_trends(view)
            refuses(view)
            migrates(case)
            asks_the_stations(guarded)
            hides_plants(guarded)
            if browser:
                store_points(case)
                addresses = {"ARCHIVE": view.url, "ARCHIVE_USERS": guarded.url, "PASSWORD": PASSWORD}
                subprocess.run(["node", "--test", "archive.mjs"], cwd=ROOT / "crates/station/web/e2e", check=True, env={**os.environ, **addresses})
            shows_full_resolution(guarded)
            bounds_requests(guarded)
            survives_the_database(view)
    without_nats(program)


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--browser"]
    if len(arguments) != 1:
        print("usage: contrib/archive/view.py PROGRAM [--browser]", file=sys.stderr)
        sys.exit(2)
    main(arguments[0], "--browser" in sys.argv[1:])
