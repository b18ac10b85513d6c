#!/usr/bin/env bash
# epicsarchiver-retrieval-client 1.0.1: the last event in an answer of the EPICS Archiver Appliance is changed or lost.
#
# Expected: read_pb_file() and parse_pb_data() give each event as it was archived. In the appliance's format (PB/HTTP) a newline ends an
# event; newline, carriage return and escape inside an event are escaped, all other octets stand as they are.
#
# Seen: the client removes white space at the end of each chunk of events, so a last octet 09, 0B, 0C or 20 is lost with it. It then takes
# the event for one that was cut at a newline and puts 0A in place of the lost octet. A COMM alarm (status 9), HWLIMIT (11) and CALC (12)
# become TIMEOUT (10), the enumeration state 16 becomes 5, and a text that ends with a space is missing. A logged warning says that an
# event was recovered, or could not be parsed; the script turns it off. The same events in the middle of a chunk are right.
#
# Why it matters: the last event of a query up to the present is the present state. A gauge that stops answering has COMM as its newest
# event, so just this alarm is read as another one. Each chunk is concerned, so the last event of each year, too. Read over JSON, or watch
# for the warning.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check epicsarchiver-retrieval-client==1.0.1 protobuf==7.36.2 \
    aiohttp==3.14.5 requests==2.34.2

"$folder/venv/bin/python" - "$folder/gauge.pb" <<'PYTHON'
import logging
import sys

from epicsarchiver.retrieval.EPICSEvent_pb2 import PayloadInfo, ScalarDouble, ScalarEnum, ScalarString
from epicsarchiver.retrieval.pb import read_pb_file

logging.disable(logging.WARNING)
DOUBLE, ENUM, STRING = 6, 3, 0


def line(message):
    octets = message.SerializeToString()
    for octet, escaped in ((b"\x1b", b"\x1b\x01"), (b"\n", b"\x1b\x02"), (b"\r", b"\x1b\x03")):
        octets = octets.replace(octet, escaped)
    return octets + b"\n"


def read(kind, event, value, **alarm):
    """The same event three times in one chunk, as the client gives it back."""
    octets = line(PayloadInfo(type=kind, pvname="Gauge:Pressure", year=2026))
    for second in (1, 2, 3):
        octets += line(event(secondsintoyear=second, nano=0, val=value, **alarm))
    with open(sys.argv[1], "wb") as file:
        file.write(octets)
    _, events = read_pb_file(sys.argv[1])
    return [(event.val, event.severity, event.status) for event in events]


def check(what, seen, expected):
    print(f"{what}: {seen}")
    if seen != expected:
        sys.exit(f"epicsarchiver-retrieval-client changed: {what} was {expected}")


check("5e-9 with a LINK alarm", read(DOUBLE, ScalarDouble, 5e-9, severity=3, status=14), [(5e-9, 3, 14)] * 3)
for name, status in (("COMM", 9), ("HWLIMIT", 11), ("CALC", 12)):
    seen = read(DOUBLE, ScalarDouble, 5e-9, severity=3, status=status)
    check(f"5e-9 with a {name} alarm", seen, [(5e-9, 3, status)] * 2 + [(5e-9, 3, 10)])
check("state 15", read(ENUM, ScalarEnum, 15), [(15, 0, 0)] * 3)
check("state 16", read(ENUM, ScalarEnum, 16), [(16, 0, 0)] * 2 + [(5, 0, 0)])
check("a text", read(STRING, ScalarString, "off"), [("off", 0, 0)] * 3)
check("a text with a space at its end", read(STRING, ScalarString, "off "), [("off ", 0, 0)] * 2)
PYTHON
echo 'as described: epicsarchiver-retrieval-client 1.0.1 changes the last event of a chunk'
