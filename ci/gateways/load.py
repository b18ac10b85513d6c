#!/usr/bin/env python3
"""The processor share of the gateways: ci/gateways/load.py PROGRAM [SECONDS]

A station with 480 virtual gauges at 5 Hz, 50 masters that read all slots over Modbus once a second, and 50 servers that scrape
Prometheus every 5 s. Prints the processor time of each group of threads in percent of one core, without clients and with them.
Not part of ./test.
"""

import asyncio
import os
import struct
import subprocess
import sys
import tempfile
import time

from plant import free_port, wait_for

SEGMENTS, GAUGES = 16, 30
MASTERS, SCRAPERS = 50, 50
POLL_S, SCRAPE_S = 1.0, 5.0


def write_plant(folder, ports):
    lines = []
    for segment in range(SEGMENTS):
        path = os.path.join(folder, f"s{segment}.toml")
        devices = ", ".join(f'"bcg450@{address}"' for address in range(3, 3 + GAUGES))
        with open(path, "w") as file:
            file.write(f"baud = 1500000\ndevices = [{devices}]\n")
        lines.append(f'[[segment]]\nname = "s{segment}"\nport = "sim:{path}"\nbaud = 1500000\n')
        for address in range(3, 3 + GAUGES):
            lines.append(f'[[segment.gauge]]\nname = "g{segment}-{address}"\naddress = {address}\ndevice = "bcg450"\npoll = "200ms"\n')
    lines.append(f'[modbus]\nlisten = "127.0.0.1:{ports[0]}"\n\n[prometheus]\nlisten = "127.0.0.1:{ports[1]}"\n')
    path = os.path.join(folder, "plant.toml")
    with open(path, "w", opener=lambda path, flags: os.open(path, flags, 0o600)) as file:
        file.write("\n".join(lines))
    return path


def times(pid):
    """Processor seconds of each group of threads, by name."""
    found, tick = {}, os.sysconf("SC_CLK_TCK")
    for task in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{task}/stat") as file:
            text = file.read()
        name = text[text.index("(") + 1:text.rindex(")")]
        name = name if name in ("modbus", "prometheus", "read model") else "segments, recorder, API"
        user, system = text[text.rindex(")") + 2:].split()[11:13]
        found[name] = found.get(name, 0) + (int(user) + int(system)) / tick
    return found


async def exactly(reader, count):
    return await reader.readexactly(count)


async def master(port, counts):
    """Reads the header and all 480 slots in blocks of 120 registers, once a second."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    while True:
        began = time.monotonic()
        for first in range(100, 100 + 20 * SEGMENTS * GAUGES, 120):
            writer.write(struct.pack(">HHHBBHH", first, 0, 6, 1, 4, first, 120))
            head = await exactly(reader, 9)
            assert head[7] == 4, head
            await exactly(reader, head[8])
            counts["modbus"] += 1
        counts["slowest round"] = max(counts["slowest round"], time.monotonic() - began)
        await asyncio.sleep(max(0.0, POLL_S - (time.monotonic() - began)))


async def scraper(port, counts):
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    while True:
        began = time.monotonic()
        writer.write(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nAccept: application/openmetrics-text\r\n\r\n")
        head = await reader.readuntil(b"\r\n\r\n")
        length = next(int(line.split(b":")[1]) for line in head.lower().split(b"\r\n") if line.startswith(b"content-length"))
        await exactly(reader, length)
        counts["prometheus"] += 1
        counts["octets"] = length
        counts["slowest scrape"] = max(counts["slowest scrape"], time.monotonic() - began)
        await asyncio.sleep(max(0.0, SCRAPE_S - (time.monotonic() - began)))


async def clients(ports, seconds, counts):
    tasks = []
    for number in range(MASTERS):
        tasks.append(asyncio.create_task(master(ports[0], counts)))
        await asyncio.sleep(POLL_S / MASTERS)
    for number in range(SCRAPERS):
        tasks.append(asyncio.create_task(scraper(ports[1], counts)))
        await asyncio.sleep(0)
    done, _ = await asyncio.wait(tasks, timeout=seconds, return_when=asyncio.FIRST_EXCEPTION)
    for task in done:
        task.result()
    for task in tasks:
        task.cancel()


def measured(label, pid, seconds, run):
    before, began = times(pid), time.monotonic()
    run()
    passed = time.monotonic() - began
    after = times(pid)
    shares = {name: 100 * (after[name] - before.get(name, 0)) / passed for name in sorted(after)}
    print(label + ": " + ", ".join(f"{name} {share:.1f} %" for name, share in shares.items()), flush=True)


def main():
    program, seconds = os.path.abspath(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 20
    folder, ports = tempfile.mkdtemp(prefix="profivac-load-"), (free_port(), free_port())
    plant = write_plant(folder, ports)
    station = subprocess.Popen([program, "run", plant, "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True)
    try:
        station.stdout.readline()
        import urllib.request

        def measuring():
            with urllib.request.urlopen(f"http://127.0.0.1:{ports[1]}/metrics") as answer:
                return answer.read().count(b"\nprofivac_reading_pressure_pascals{") == SEGMENTS * GAUGES

        wait_for("480 pressures", measuring)
        counts = {"modbus": 0, "prometheus": 0, "octets": 0, "slowest round": 0.0, "slowest scrape": 0.0}
        measured("without clients", station.pid, seconds, lambda: time.sleep(seconds))
        measured("with clients", station.pid, seconds, lambda: asyncio.run(clients(ports, seconds, counts)))
        print(f"Modbus: {counts['modbus'] / seconds:.0f} requests/s, a round of 480 slots at most {counts['slowest round'] * 1e3:.0f} ms")
        print(f"Prometheus: {counts['prometheus'] / seconds:.1f} scrapes/s of {counts['octets'] / 1e6:.2f} MB, at most {counts['slowest scrape'] * 1e3:.0f} ms")
    finally:
        station.terminate()
        station.wait()
        subprocess.run(["rm", "-rf", folder], check=False)


if __name__ == "__main__":
    main()
