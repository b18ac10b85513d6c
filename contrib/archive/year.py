#!/usr/bin/env python3
"""How long a year takes to draw: contrib/archive/year.py PROGRAM [--gauges 10] [--at-most SECONDS]

Starts PostgreSQL, NATS and an archive with a page, and adds the spans of a year of noisy pressures for each gauge, of all three levels. Then it asks the page for the
trends of all gauges over the year, at once as the chart does, and opens the chart in Chromium, several times each. Prints the medians; one of the chart beyond
--at-most is a failure. The tests of the dashboard have Chromium and its library: crates/station/web/e2e.
"""

import argparse
import concurrent.futures
import json
import os
import runpy
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.parse
import urllib.request
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
example = runpy.run_path(str(Path(__file__).with_name("example.py")))
TIMES = 7
DAY = 86_400

STATION = """
INSERT INTO profivac_data.station (plant, name, epoch) VALUES ('hall', 'year', 1);
INSERT INTO profivac_data.series (station, name) SELECT (SELECT id FROM profivac_data.station WHERE name = 'year'), 'gauge ' || n FROM generate_series(1, {gauges}) AS n;
INSERT INTO profivac_data.sample SELECT id, now(), 1e-3, 0 FROM profivac_data.series WHERE name LIKE 'gauge %';
INSERT INTO profivac_data.span (series, level, start, epoch, batch, min_pa, max_pa, log10_sum, count, qualities)
    SELECT id, level, start, 1, 1, 1e-5 * noise, 2e-5 * noise, count * (log(1.4e-5) + log(noise)), count, 1
    FROM profivac_data.series, (VALUES (2, 2, 120), (3, 30, 1800), (4, 360, 21600)) AS spans (level, minutes, count),
        generate_series(now() - interval '1 year', now(), minutes * interval '1 minute') AS start, LATERAL (SELECT 0.5 + random() AS noise) AS noise
    WHERE name LIKE 'gauge %';
VACUUM ANALYZE profivac_data.span;
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda path: Path(path).resolve())
    parser.add_argument("--gauges", type=int, default=10)
    parser.add_argument("--at-most", type=float)
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("FAILED: ended by SIGTERM"))
    with tempfile.TemporaryDirectory(prefix="profivac-year-") as folder:
        run = example["Example"](arguments.program, 0, 1, 1, Path(folder))
        try:
            measure(run, arguments)
        finally:
            run.close()


def measure(run, arguments):
    run.start()
    example["wait_for"]("an archive that is ready", lambda: "ready" in run.archives[0].log.read_text())
    day = "SELECT profivac_data.add_day(current_date);"
    made = subprocess.run(["psql", "-X", "-q", "-v", "ON_ERROR_STOP=1", "-h", run.folder, "-p", str(run.postgres_port), "-U", run.user, "-d", "postgres"],
                          input=day + STATION.format(gauges=arguments.gauges), capture_output=True, text=True)
    if made.returncode != 0:
        raise SystemExit(f"FAILED: {made.stderr}")
    print(f"{run.count('span')} spans of {arguments.gauges} gauges")
    url, names = f"http://127.0.0.1:{run.view_port}", [f"year/gauge {number}" for number in range(1, arguments.gauges + 1)]
    to = int(time.time() * 1000)

    def has_station():
        with urllib.request.urlopen(f"{url}/api/archive") as answer:
            return "year" in json.load(answer)["stations"]

    example["wait_for"]("the station on the page", has_station)

    def ask(name):
        query = urllib.parse.urlencode({"series": name, "from": to - 365 * DAY * 1000, "to": to, "pixels": 1000})
        with urllib.request.urlopen(f"{url}/api/trend?{query}") as answer:
            return len(json.load(answer)["start_ms"])

    def ask_all():
        begun = time.monotonic()
        with concurrent.futures.ThreadPoolExecutor(len(names)) as pool:
            entries = sum(pool.map(ask, names))
        return time.monotonic() - begun, entries

    taken, entries = zip(*[ask_all() for _ in range(TIMES)])
    print(f"from the API: {entries[0]} entries in {statistics.median(taken):.2f} s")
    window = {"from": to - 365 * DAY * 1000, "to": to}
    address = f"{url}/trends?" + urllib.parse.urlencode([*window.items(), *(("s", name) for name in names)])
    done = subprocess.run(["node", "year.mjs", address, str(TIMES)], cwd=ROOT / "crates/station/web/e2e", capture_output=True, text=True, env=os.environ)
    if done.returncode != 0:
        raise SystemExit(f"FAILED: {done.stderr}")
    chart = json.loads(done.stdout)
    print(f"the chart in Chromium: {chart['points']} points, {chart['choice']:.2f} s after the choice of the year, {chart['opened']:.2f} s after the page was opened")
    if arguments.at_most is not None and chart["choice"] > arguments.at_most:
        raise SystemExit(f"FAILED: more than {arguments.at_most} s")


if __name__ == "__main__":
    main()
