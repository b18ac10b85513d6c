#!/usr/bin/env python3
"""pymodbus against the Modbus gateway: ci/gateways/modbus.py PROGRAM"""

import csv
import io
import logging
import math
import socket
import struct
import subprocess
import sys
import time

from pymodbus import ModbusException
from pymodbus.client import ModbusTcpClient
from plant import HANG_S, Hostile, Line, Plant, free_port, wait_for

logging.getLogger("pymodbus").setLevel(logging.CRITICAL)
TYPES = {"float32": (2, ModbusTcpClient.DATATYPE.FLOAT32), "uint32": (2, ModbusTcpClient.DATATYPE.UINT32),
         "uint16": (1, ModbusTcpClient.DATATYPE.UINT16), "int16": (1, ModbusTcpClient.DATATYPE.INT16)}


class Master:
    """A pymodbus client that finds registers by the CSV of `profivac names`."""

    def __init__(self, port, rows, word_order="big", source=None):
        self.client = ModbusTcpClient("127.0.0.1", port=port, timeout=HANG_S, source_address=source)
        self.rows = {(row["subject"], row["name"]): (int(row["register"]), row["type"]) for row in rows}
        self.word_order = word_order
        wait_for("a connection", self.client.connect)

    def value(self, subject, name):
        register, kind = self.rows[subject, name]
        count, kind = TYPES[kind]
        answer = self.client.read_input_registers(register, count=count)
        assert not answer.isError(), answer
        return self.client.convert_from_registers(answer.registers, kind, word_order=self.word_order)


def map_of(plant):
    """The rows of the map as the program prints them."""
    text = subprocess.run([plant.program, "names", plant.file, "--for", "modbus", "--csv"], check=True, text=True, capture_output=True)
    return list(csv.DictReader(io.StringIO(text.stdout)))


def positive(number):
    """The number if it is above 0, else None; NaN is not."""
    return number if number > 0 else None


def check_values(plant, port, rows):
    master = Master(port, rows)
    assert master.value("", "test-float") == 1.0 and master.value("", "test-integer") == 0x01020304
    assert master.client.read_holding_registers(0, count=4).registers == [0x3F80, 0, 0x0102, 0x0304]
    pa, age, readings, beat = [], [], [], []
    for _ in range(3):
        # On a loaded computer a reading may be stale for a moment, and the pressure is then NaN.
        pa.append(wait_for("a pressure", lambda: positive(master.value("chamber", "pressure"))))
        age.append(master.value("chamber", "age"))
        wait_for("another reading", lambda: master.value("chamber", "readings") not in readings)
        readings.append(master.value("chamber", "readings"))
        wait_for("another heartbeat", lambda: master.value("", "heartbeat") not in beat)
        beat.append(master.value("", "heartbeat"))
    assert all(0.08 < it < 0.12 for it in pa), pa
    assert max(age) < 100, age

    def is_consistent():
        in_unit = master.value("chamber", "pressure-in-unit")
        assert abs(in_unit * 100 / master.value("chamber", "pressure") - 1) < 1e-3 and master.value("chamber", "unit") == 1
        assert abs(master.value("chamber", "log10") / 1000 - math.log10(pa[-1])) < 2e-3
        return master.value("chamber", "state") == 0 and master.value("chamber", "limit-high") == 10.0

    wait_for("pressure, unit, logarithm and state that fit", is_consistent)
    assert math.isnan(master.value("chamber", "limit-low")) and master.value("chamber", "range-high") > 1e4
    assert abs(master.value("", "time") - time.time()) < 30
    wait_for("the state on the bus", lambda: master.value("chamber", "bits") & 1 << 11)
    simulated = {name: bool(master.value(name, "bits") & 1 << 8) for name in ("chamber", "load lock")}
    assert simulated == {"chamber": False, "load lock": True}, simulated
    assert master.value("hall", "segment-state") == 2
    assert master.value("chamber", "address") == 5
    wait_for("the emission", lambda: master.value("chamber", "ba.emission-status") == master.value("chamber", "ba.emission-status"))
    wait_for("its bit, and that it is known", lambda: master.value("chamber", "bits") & 1 << 2 and master.value("chamber", "known") & 1)


def check_alarm_and_fault(plant, port, rows):
    master = Master(port, rows)
    plant.tell("pressure 1 mbar")
    wait_for("the alarm", lambda: master.value("Chamber high", "alarm-state") == 1)
    bits = wait_for("its bits", lambda: master.value("chamber", "bits") & (1 << 4 | 1 << 7))
    assert bits == 1 << 4 | 1 << 7 and master.value("", "unacknowledged-alarms") >= 1
    plant.tell("pressure 1e-3 mbar")
    plant.tell("power 5 off")
    wait_for("no data", lambda: master.value("chamber", "state") == 4)
    assert math.isnan(master.value("chamber", "pressure")) and master.value("chamber", "bits") & 1
    assert master.value("chamber", "log10") == -32768
    assert not math.isnan(master.value("load lock", "pressure"))
    plant.tell("power 5 on")
    wait_for("data again", lambda: master.value("chamber", "state") == 0)


def code_of(answer):
    return answer.exception_code if answer.isError() else 0


def check_requests(port, rows):
    client = Master(port, rows).client
    # The header and two slots.
    assert len(client.read_input_registers(0, count=125).registers) == 125
    assert len(client.read_holding_registers(15, count=125).registers) == 125
    assert code_of(client.read_input_registers(16, count=125)) == 2
    assert code_of(client.read_input_registers(30_000, count=1)) == 2
    assert code_of(client.read_coils(0, count=1)) == 1
    assert code_of(client.read_discrete_inputs(0, count=1)) == 1
    writes = [
        client.write_register(100, 1), client.write_registers(100, [1, 2]), client.write_coil(0, True), client.write_coils(0, [True]),
        client.mask_write_register(address=100), client.readwrite_registers(read_address=0, read_count=1, write_address=0, values=[1]),
    ]
    assert [code_of(answer) for answer in writes] == [1] * len(writes), writes
    for unit in (0, 1, 17, 255):
        assert not client.read_input_registers(0, count=2, device_id=unit).isError() or unit == 0
    facts = client.read_device_information(read_code=2, object_id=0).information
    assert facts[0] == b"profivac" and facts[2] and facts[6] == b"plant", facts
    with socket.create_connection(("127.0.0.1", port), timeout=HANG_S) as raw:
        for count in (0, 126, 65535):
            raw.sendall(struct.pack(">HHHBBHH", 7, 0, 6, 1, 3, 0, count))
            assert raw.recv(100) == struct.pack(">HHHBBB", 7, 0, 3, 1, 0x83, 3)
        # Two requests in one segment have two answers.
        raw.sendall(struct.pack(">HHHBBHH", 8, 0, 6, 1, 4, 0, 1) * 2)
        answers = b""
        while len(answers) < 22:
            answers += raw.recv(100)
        assert answers == struct.pack(">HHHBBBH", 8, 0, 5, 1, 4, 2, 0x3F80) * 2
        # What is no telegram ends the connection.
        raw.sendall(b"GET / HTTP/1.1\r\n\r\n")
        try:
            assert raw.recv(100) == b""
        except ConnectionResetError:
            pass


def check_several(port, rows):
    masters = [Master(port, rows) for _ in range(40)]
    values = [master.value("load lock", "limit-high") for master in masters]
    assert len(values) == 40 and all(math.isnan(value) for value in values), values
    for master in masters:
        master.client.close()


def check_hostile(plant, port, rows):
    requests = [
        struct.pack(">HHHB", 1, 0, 0xFFFF, 1) + b"\xff" * 3000,
        struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, 0, 125) * 500,
        struct.pack(">HHHB", 1, 0, 250, 1) + b"\x10",
        b"\x00" * 7,
    ]
    stalled = socket.create_connection(("127.0.0.1", port), source_address=("127.0.0.8", 0))
    stalled.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1024)
    stalled.setblocking(False)
    try:
        stalled.sendall(struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, 0, 125) * 20_000)
    except BlockingIOError:
        pass
    keeps, slowest, polls = Master(port, rows), 0.0, 0
    with Line(plant.url), Hostile(port, requests) as hostile:
        end = time.monotonic() + 5
        while time.monotonic() < end:
            began = time.monotonic()
            assert keeps.value("", "test-float") == 1.0
            new = Master(port, rows)
            assert new.value("load lock", "unit") == 1
            new.client.close()
            slowest, polls = max(slowest, time.monotonic() - began), polls + 2
            time.sleep(0.05)
    stalled.close()
    assert plant.reading("chamber")["quality"] == "valid"
    assert plant.status("modbus")["refused"] > 0
    print(f"  {hostile.made / hostile.seconds:.0f} hostile connections/s, {polls} polls, the slowest two {slowest * 1e3:.0f} ms")


def check_restart(plant, port, rows):
    master = Master(port, rows)
    plant.restart()

    def again():
        try:
            return master.client.connect() and master.value("chamber", "state") == 0
        except ModbusException:
            master.client.close()
            return False

    wait_for("the same master after a restart", again)


def check_word_order(program):
    port = free_port()
    with Plant(program, f'[modbus]\nlisten = "127.0.0.1:{port}"\nword-order = "low-first"\nunit = "torr"\n') as plant:
        master = Master(port, map_of(plant), word_order="little")
        assert master.value("", "test-float") == 1.0 and master.value("chamber", "unit") == 2
        torr = wait_for("a pressure in Torr", lambda: master.value("chamber", "pressure-in-unit"))
        assert 6e-4 < torr < 9e-4, torr


def main():
    program = sys.argv[1]
    port = free_port()
    with Plant(program, f'[modbus]\nlisten = "127.0.0.1:{port}"\n') as plant:
        rows = map_of(plant)
        steps = [
            ("values", lambda: check_values(plant, port, rows)),
            ("alarm, unplugged gauge", lambda: check_alarm_and_fault(plant, port, rows)),
            ("blocks, exceptions, identification", lambda: check_requests(port, rows)),
            ("40 masters", lambda: check_several(port, rows)),
            ("hostile clients", lambda: check_hostile(plant, port, rows)),
            ("restarted station", lambda: check_restart(plant, port, rows)),
            ("word order and unit", lambda: check_word_order(program)),
        ]
        for name, step in steps:
            began = time.monotonic()
            step()
            print(f"{name}: ok after {time.monotonic() - began:.1f} s", flush=True)


if __name__ == "__main__":
    main()
