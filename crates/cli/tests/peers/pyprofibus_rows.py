"""A foreign class 1 master: pyprofibus 1.13 brings one slave after the other to Data_Exchange.

Usage: pyprofibus_rows.py PORT

Each line of standard input describes a slave, and each is answered by one line when the slave has exchanged data or
patience is at its end:

    {"address": 5, "ident": 2278, "cfg": "44840505...", "user_prm": "000000051c", "outputs": 0, "inputs": 5}
    {"state": "Data_Exchange", "inputs": 5}

"state" is the state of the slave in the master, "inputs" the number of octets of the last exchange, null if there was
none. The slave before is left without a word: pyprofibus has no way to release one.
"""

import json
import sys
import time

from pyprofibus_master import describe, master_of, open_port, state_of, step

# The first answer after Chk_Cfg could be a coincidence; three exchanges in a row cannot.
EXCHANGES = 3
# Some hundred times the steps that a slave needs; it only ends an endless start.
PATIENCE_S = 10


def bring_up(phy, address, ident, cfg, user_prm, outputs, inputs):
    """The state of the slave in the master when it has exchanged data, or has failed."""
    slave = describe(address, ident, bytes.fromhex(cfg), bytes.fromhex(user_prm), outputs, inputs)
    master = master_of(phy, slave)
    state = state_of(master, slave)
    came, exchanges = None, 0
    deadline = time.monotonic() + PATIENCE_S
    while exchanges < EXCHANGES and time.monotonic() < deadline:
        step(master, slave, state, bytes(outputs))
        data = slave.getMasterInData()
        if data is not None:
            came, exchanges = len(data), exchanges + 1
    return {"state": state.state2name[state.getState()], "inputs": came}


def main():
    phy = open_port(sys.argv[1])
    for line in sys.stdin:
        print(json.dumps(bring_up(phy, **json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
