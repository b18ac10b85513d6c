#!/usr/bin/env bash
# ophyd 1.11.2: a pressure setpoint counts as reached because the process variable shows few digits.
#
# Expected: set(1e-6).wait() of an EpicsSignal with a separate readback returns when the readback is at the setpoint, or raises after its
# timeout. PREC of EPICS is the number of decimals for display (Record Reference Manual, fields for operator display).
#
# Seen: ophyd makes 10^-PREC its absolute tolerance. With PREC = 3 all pressures below 1e-3 mbar are equal: the
# status is done and successful at once, while the readback is 500 times the setpoint. With PREC = 0, the default of an EPICS record, nothing is
# tolerated: the same wait ends with the timeout. The docstring of `tolerance` has the formula, but for the write PV: it is the PREC of the
# readback that counts. A plan that calls set() or bluesky's mv shows nothing of it.
#
# Why it matters: pressures and set points of vacuum gauges are far below 10^-PREC mbar, where a difference of decades is what counts. Give
# EpicsSignal a tolerance of its own, and gateways a PREC that fits the range, or the value's logarithm.
# libca says that it does not find caRepeater; the client works without it.
set -euo pipefail
folder=$(mktemp -d)
server=
trap '[ -z "$server" ] || kill "$server"; rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check ophyd==1.11.2 pyepics==3.5.10 caproto==1.3.0

port=$(venv/bin/python -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
export EPICS_CA_ADDR_LIST=127.0.0.1 EPICS_CA_AUTO_ADDR_LIST=NO EPICS_CA_SERVER_PORT=$port EPICS_CAS_SERVER_PORT=$port
export EPICS_CAS_BEACON_ADDR_LIST=127.0.0.1 EPICS_CAS_AUTO_BEACON_ADDR_LIST=NO
# A server whose readback never follows: a gauge that refuses the set point.
cat >server.py <<'PYTHON'
from caproto.server import PVGroup, pvproperty, run

class Gauge(PVGroup):
    setpoint = pvproperty(value=5e-4, precision=3)
    readback = pvproperty(value=5e-4, precision=3)
    plain_readback = pvproperty(value=5e-4)

run(Gauge(prefix="finding:").pvdb, interfaces=["127.0.0.1"])
PYTHON
venv/bin/python server.py >server.log 2>&1 &
server=$!

timeout 120 venv/bin/python - <<'PYTHON'
import sys

from ophyd import EpicsSignal


def reached(readback, **options):
    signal = EpicsSignal(f"finding:{readback}", write_pv="finding:setpoint", name="pressure", **options)
    signal.wait_for_connection(timeout=60)
    status = signal.set(1e-6, timeout=2)
    try:
        status.wait(10)
        return f"reached, readback {signal.get():g}"
    except Exception as error:
        return f"not reached: {type(error).__name__}"


def check(what, seen, expected):
    print(f"{what}: {seen}")
    if seen != expected:
        sys.exit(f"ophyd changed: {what} was {expected}")


check("PREC 3", reached("readback"), "reached, readback 0.0005")
check("PREC 0", reached("plain_readback"), "not reached: TimeoutError")
check("PREC 3 and a tolerance of 1e-7", reached("readback", tolerance=1e-7), "not reached: TimeoutError")
PYTHON
echo 'as described: ophyd 1.11.2 takes the decimals of the display for the tolerance of a set point'
