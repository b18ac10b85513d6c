#!/usr/bin/env python3
"""Sends the API of the demo plant every request that its description allows, and invalid ones: ci/fuzz_api.py PROGRAM

No answer may be a 5xx or differ from the description, and afterwards the station must still exchange data. Every run sends the
same requests.
"""

import http.client
import json
import subprocess
import sys
import tempfile
from pathlib import Path

# A description cannot say that a time range begins before it ends: such a refusal is no defect.
NOT_CHECKED = "positive_data_acceptance"

# This stream never ends; crates/station/tests/api.rs tests it.
NEVER_ENDS = "/api/live"


def main() -> int:
    program = sys.argv[1]
    command = [program, "demo", "--headless", "--listen", "127.0.0.1:0"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as demo:
        try:
            url = address(demo)
            status = fuzz(url)
            station(url)
            return status
        finally:
            demo.terminate()


def address(demo: subprocess.Popen) -> str:
    """The address of the dashboard, from the first line of the demonstration."""
    line = demo.stderr.readline()
    _, found, url = line.partition("http://")
    if not found:
        raise SystemExit(f"expected the address of the dashboard, got {line!r}")
    return "http://" + url.strip()


def ask(url: str, path: str) -> object:
    connection = http.client.HTTPConnection(url.removeprefix("http://"), timeout=60)
    connection.request("GET", path)
    return json.load(connection.getresponse())


def fuzz(url: str) -> int:
    """Fuzzes as engineer, the role of every user of the demonstration, with the CSRF token of the page."""
    token = ask(url, "/api/session")["token"]
    tool = Path(sys.executable).with_name("schemathesis")
    command = [tool, "run", f"{url}/api/openapi.json", "--header", f"x-csrf-token: {token}", "--exclude-path", NEVER_ENDS]
    checks = ["--generation-deterministic", "--checks", "all", "--exclude-checks", NOT_CHECKED, "--max-examples", "40", "--request-timeout", "60", "--no-color"]
    with tempfile.TemporaryDirectory() as notes:
        return subprocess.run([*command, *checks], cwd=notes, check=False).returncode


def station(url: str) -> None:
    """Checks that gauges still exchange data; single gauges lose their power at times in the demonstration."""
    states = [gauge["state"] for gauge in ask(url, "/api/gauges")]
    if "data-exchange" not in states:
        raise SystemExit(f"expected gauges in data exchange after the requests, got {states}")


if __name__ == "__main__":
    sys.exit(main())
