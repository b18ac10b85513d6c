#!/usr/bin/env python3
"""A Prometheus server and promtool against the Prometheus gateway: ci/gateways/prometheus.py PROGRAM"""

import http.client
import json
import os
import re
import socket
import ssl
import subprocess
import sys
import tempfile
import time
import urllib.parse
import urllib.request

from plant import HANG_S, Hostile, Line, Plant, free_port, wait_for

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
RULES = os.path.join(ROOT, "contrib/prometheus/rules.yml")
DASHBOARD = os.path.join(ROOT, "contrib/prometheus/grafana.json")
ARCHIVE = os.path.join(ROOT, "crates/archive/src/metrics/text.rs")
OPEN_METRICS = "application/openmetrics-text; version=1.0.0; charset=utf-8"
TOKEN = "a-token-of-the-test"


class Server:
    """A Prometheus server that scrapes one address every second."""

    def __init__(self, target, extra=""):
        self.folder = tempfile.mkdtemp(prefix="profivac-prometheus-")
        self.port = free_port()
        config = os.path.join(self.folder, "prometheus.yml")
        with open(config, "w") as file:
            file.write(
                f"global: {{scrape_interval: 1s, evaluation_interval: 1s}}\nrule_files: ['{RULES}']\n"
                f"scrape_configs:\n- job_name: profivac\n  static_configs: [{{targets: ['{target}']}}]\n{extra}")
        with open(os.path.join(self.folder, "log"), "w") as log:
            self.process = subprocess.Popen(
                ["prometheus", f"--config.file={config}", f"--storage.tsdb.path={self.folder}/data",
                 f"--web.listen-address=127.0.0.1:{self.port}"], stderr=log)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(HANG_S)
        subprocess.run(["rm", "-rf", self.folder], check=False)

    def query(self, text):
        """The vector of an expression: labels and value."""
        url = f"http://127.0.0.1:{self.port}/api/v1/query?" + urllib.parse.urlencode({"query": text})
        with urllib.request.urlopen(url, timeout=HANG_S) as answer:
            found = json.load(answer)["data"]["result"]
        return [(it["metric"], float(it["value"][1])) for it in found]

    def value(self, text):
        vector = self.query(text)
        return vector[0][1] if vector else None


def get(port, path="/metrics", accept=None, connection=None):
    connection = connection or http.client.HTTPConnection("127.0.0.1", port, timeout=HANG_S)
    connection.request("GET", path, headers={"Accept": accept} if accept else {})
    answer = connection.getresponse()
    return answer.status, answer.getheader("content-type"), answer.read().decode()


def check_texts(port):
    status, kind, text = get(port, accept="application/openmetrics-text;version=1.0.0,text/plain;q=0.5")
    assert (status, kind) == (200, OPEN_METRICS) and text.endswith("# EOF\n"), (status, kind)
    status, kind, text = get(port)
    assert (status, kind) == (200, "text/plain; version=0.0.4; charset=utf-8"), (status, kind)
    checked = subprocess.run(["promtool", "check", "metrics"], input=text, text=True, capture_output=True, check=False)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    subprocess.run(["promtool", "check", "rules", RULES], check=True, stdout=subprocess.DEVNULL)
    assert get(port, "/")[0] == 404
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=HANG_S)
    connection.request("POST", "/metrics", body="x")
    assert connection.getresponse().status == 405
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=HANG_S)
    connection.request("GET", "/metrics", headers={"Host": "evil.example"})
    assert connection.getresponse().status == 421


def check_values(plant, server):
    pressure = 'profivac_reading_pressure_pascals{gauge="chamber"}'
    value = wait_for("a pressure in Prometheus", lambda: server.value(pressure))
    assert 0.08 < value < 0.12, value
    labels, one = server.query('profivac_device_info{gauge="chamber"}')[0]
    facts = {key: labels[key] for key in ("segment", "device", "address", "simulated")}
    assert facts == {"segment": "hall", "device": "bcg450", "address": "5", "simulated": "false"} and one == 1, labels
    assert server.query('profivac_device_info{gauge="load lock"}')[0][0]["simulated"] == "true"
    age = server.value('time() - profivac_reading_timestamp_seconds{gauge="chamber"}')
    assert -1 < age < 30, age
    limit = server.value('profivac_reading_limit_pascals{gauge="chamber",limit="high_high"}')
    assert abs(limit - 10) < 1e-9, limit
    assert server.value('profivac_reading_range_high_pascals{gauge="chamber"}') > 1e4
    wait_for("cycles in the histogram", lambda: server.value('profivac_segment_cycle_seconds_count{segment="hall"}'))
    wait_for("a quantile", lambda: server.value(
        'histogram_quantile(0.5, rate(profivac_segment_cycle_seconds_bucket{segment="hall"}[30s])) > 0'))
    plant.tell("pressure 1 mbar")
    wait_for("the alarm in Prometheus", lambda: server.value('profivac_alarm_active{alarm="Chamber high",priority="high"}') == 1)
    wait_for("the rule about the limit", lambda: server.query('ALERTS{alertname="ProfivacPressureHigh",gauge="chamber"}'))
    plant.tell("pressure 2000 mbar")
    wait_for("the end of the series above the range", lambda: server.query(pressure) == [])
    wait_for("the rule about the range", lambda: server.query('ALERTS{alertname="ProfivacPressureAboveRange",gauge="chamber"}'))
    plant.tell("pressure 1e-3 mbar")
    wait_for("the series again", lambda: server.query(pressure))


def check_unplugged(plant, server):
    """The pressure of a gauge that is switched off ends at once, although the server looks five minutes back."""
    pressure = 'profivac_reading_pressure_pascals{gauge="chamber"}'
    assert server.value(pressure) is not None
    last = server.value('profivac_reading_timestamp_seconds{gauge="chamber"}')
    plant.tell("power 5 off")
    wait_for("the end of the series", lambda: server.query(pressure) == [])
    wait_for("the state stale", lambda: server.value('profivac_reading_state{gauge="chamber",state="stale"}') == 1)
    assert server.value('profivac_reading_timestamp_seconds{gauge="chamber"}') >= last
    assert server.value('profivac_reading_pressure_pascals{gauge="load lock"}') is not None
    plant.tell("power 5 on")
    wait_for("the series again", lambda: server.query(pressure))


def check_restart(plant, server):
    plant.stop()
    wait_for("up is 0", lambda: server.value('up{job="profivac"}') == 0)
    assert server.query("profivac_reading_pressure_pascals") == []
    plant.start()
    wait_for("up is 1", lambda: server.value('up{job="profivac"}') == 1)
    wait_for("the series again", lambda: server.query('profivac_reading_pressure_pascals{gauge="chamber"}'))


def check_hostile(plant, port):
    stalled = socket.create_connection(("127.0.0.1", port), source_address=("127.0.0.8", 0))
    stalled.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1024)
    stalled.sendall(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n" * 200)
    requests = [
        b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nX: " + b"a" * 100_000,
        b"GET /" + b"m" * 60_000 + b" HTTP/1.1\r\n\r\n",
        b"\x16\x03\x01\x02\x00" + b"\xff" * 500,
        b"POST /metrics HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999\r\n\r\nx",
    ]
    keeps = http.client.HTTPConnection("127.0.0.1", port, timeout=HANG_S)
    slowest, scrapes = 0.0, 0
    with Line(plant.url), Hostile(port, requests) as hostile:
        end = time.monotonic() + 5
        while time.monotonic() < end:
            began = time.monotonic()
            # The connection that was there before survives, and a new one is accepted.
            for connection in (keeps, None):
                status, _, text = get(port, connection=connection)
                assert status == 200 and 'profivac_reading_pressure_pascals{segment="lab"' in text
                scrapes += 1
            slowest = max(slowest, time.monotonic() - began)
            time.sleep(0.1)
    stalled.close()
    assert plant.reading("chamber")["quality"] == "valid"
    print(f"  {hostile.made / hostile.seconds:.0f} hostile connections/s, {scrapes} scrapes, the slowest two {slowest * 1e3:.0f} ms")


def check_tls(program):
    """Other computers need TLS and the token; the certificate is that of the station."""
    folder = tempfile.mkdtemp(prefix="profivac-tls-")
    key, certificate = os.path.join(folder, "key.pem"), os.path.join(folder, "certificate.pem")
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
         "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1", "-keyout", key, "-out", certificate],
        check=True, stderr=subprocess.DEVNULL)
    os.chmod(key, 0o600)
    token = os.path.join(folder, "token")
    with open(token, "w", opener=lambda path, flags: os.open(path, flags, 0o600)) as file:
        file.write(TOKEN + "\n")
    port = free_port()
    tls = f'[tls]\ncertificate = "{certificate}"\nkey = "{key}"\n\n'
    table = f'[prometheus]\nlisten = "0.0.0.0:{port}"\n'
    for head, tables, expected in [("", table, "[tls]"), (tls, table, "token-file")]:
        refused = Plant(program, tables, head)
        refused.write("plant.toml", head + '[[segment]]\nname = "hall"\nport = "sim:lab.toml"\n\n' + tables)
        ran = subprocess.run([program, "run", refused.file, "--check"], capture_output=True, text=True, check=False)
        assert ran.returncode == 2 and "beyond loopback" in ran.stderr and expected in ran.stderr, ran.stderr
    with Plant(program, table + f'token-file = "{token}"\n', tls):
        trusting = ssl.create_default_context(cafile=certificate)

        def scrape(headers):
            connection = http.client.HTTPSConnection("localhost", port, timeout=HANG_S, context=trusting)
            connection.request("GET", "/metrics", headers=headers)
            answer = connection.getresponse()
            return answer.status, answer.getheader("www-authenticate")

        wait_for("TLS", lambda: scrape({})[0])
        assert scrape({}) == (401, "Bearer")
        assert scrape({"Authorization": f"Bearer {TOKEN}x"}) == (401, "Bearer")
        assert scrape({"Authorization": f"Bearer {TOKEN}"})[0] == 200
        secure = f"  scheme: https\n  tls_config: {{ca_file: '{certificate}'}}\n  authorization: {{credentials_file: '{token}'}}\n"
        with Server(f"localhost:{port}", secure) as server:
            wait_for("a scrape over TLS", lambda: server.value('up{job="profivac"}') == 1)
    subprocess.run(["rm", "-rf", folder], check=False)


def check_dashboard(port):
    """Every metric of the Grafana dashboard and of the rules is one of the gateway, or one that an archive has of itself."""
    text = get(port)[2]
    published = {line.split()[2] for line in text.splitlines() if line.startswith("# TYPE ")}
    with open(ARCHIVE) as file:
        own = set(re.findall(r'"(profivac_archive_\w+)"', file.read()))
    published |= own | {f"{name}_total" for name in own}
    with open(DASHBOARD) as file:
        dashboard = json.load(file)
    expressions = [target["expr"] for panel in dashboard["panels"] for target in panel.get("targets", [])]
    assert len(expressions) >= 8, expressions
    with open(RULES) as file:
        expressions += [line for line in file if "expr:" in line]
    for expression in expressions:
        for word in expression.replace("{", " ").replace("(", " ").replace("[", " ").replace(")", " ").split():
            if word.startswith("profivac_"):
                name = word.removesuffix("_bucket")
                assert name in published, f"{word} in {expression} is no metric"


def main():
    program = sys.argv[1]
    port = free_port()
    with Plant(program, f'[prometheus]\nlisten = "127.0.0.1:{port}"\n') as plant, Server(f"127.0.0.1:{port}") as server:
        steps = [
            ("texts, promtool", lambda: check_texts(port)),
            ("values, alarm, rules", lambda: check_values(plant, server)),
            ("dashboard", lambda: check_dashboard(port)),
            ("unplugged gauge", lambda: check_unplugged(plant, server)),
            ("restarted station", lambda: check_restart(plant, server)),
            ("TLS and token", lambda: check_tls(program)),
            ("hostile clients", lambda: check_hostile(plant, port)),
        ]
        for name, step in steps:
            began = time.monotonic()
            step()
            print(f"{name}: ok after {time.monotonic() - began:.1f} s", flush=True)
        status = plant.status("prometheus")
        assert status["is_running"] and status["sent"] > 0, status


if __name__ == "__main__":
    main()
