"""Asks the station at address 5 for its status through a library for serial ports, as a program of a user does.

Usage: ask.py LIBRARY PORT

LIBRARY is pyserial or serialx. The port is opened once, with 19200 bit/s and even parity. Prints the answer in hex.
"""

import sys

# FDL status request of master 2, and the length of its answer (profibus-wire 1.9).
REQUEST = bytes.fromhex("100502495016")
ANSWER_OCTETS = 6

# The longest wait for an answer in s: a loaded computer is slow. Without an answer the library raises an error, or the answer is too short.
TIMEOUT_S = 60


def with_pyserial(port):
    import serial

    with serial.Serial(port, 19200, parity=serial.PARITY_EVEN, timeout=TIMEOUT_S) as line:
        line.write(REQUEST)
        return line.read(ANSWER_OCTETS)


def with_serialx(port):
    import serialx

    with serialx.Serial(port, baudrate=19200, parity=serialx.Parity.EVEN) as line:
        line.write(REQUEST)
        return line.readexactly(ANSWER_OCTETS, timeout=TIMEOUT_S)


LIBRARIES = {"pyserial": with_pyserial, "serialx": with_serialx}

if __name__ == "__main__":
    library, port = sys.argv[1:]
    print(LIBRARIES[library](port).hex(" "))
