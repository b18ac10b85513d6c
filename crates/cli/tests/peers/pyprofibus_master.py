"""A foreign class 1 master: pyprofibus 1.13 brings one slave to Data_Exchange and keeps it there.

Usage: pyprofibus_master.py PORT ADDRESS IDENT CFG USER_PRM OUTPUTS INPUTS

CFG and USER_PRM are octets in hex, OUTPUTS and INPUTS counts of octets as the master sees them. What it sees it prints as
one JSON line each, until standard input ends:

    {"state": "Data_Exchange", "exchanges": 0}     the master's state for the slave has changed
    {"inputs": "0000...", "exchanges": 17}         other input octets than before

A line of standard input has the outputs in hex; until the first one they are zero.

pyprofibus is GPL: it runs in a process of its own and is linked to nothing.
"""

import json
import sys
import threading

from pyprofibus.dp import DpCfgDataElement, DpError
from pyprofibus.dp_master import DPM1, DpSlaveDesc, DpSlaveState
from pyprofibus.phy_serial import CpPhySerial

MASTER = 2
BAUD = 19200
# Longer than any pause of the tests: the diagnosis shows a running watchdog, and an expired one would hide faults.
WATCHDOG_MS = 2000


class NoOutputs(int):
    """Zero output octets. pyprofibus refuses slaves without any by comparing with 0, though it can serve them."""

    def __eq__(self, other):
        return False

    def __ne__(self, other):
        return other != int(self)

    def __le__(self, other):
        return False

    __hash__ = int.__hash__


def describe(address, ident, cfg, user_prm, outputs, inputs):
    """The slave, as a GSD and configuration file would describe it."""
    slave = DpSlaveDesc()
    slave.name = "gauge"
    slave.slaveAddr = address
    slave.identNumber = ident
    # pyprofibus names both from the slave's point of view.
    slave.inputSize = outputs or NoOutputs()
    slave.outputSize = inputs
    for telegram in (slave.setPrmTelegram, slave.chkCfgTelegram):
        telegram.da = address
    slave.setPrmTelegram.identNumber = ident
    slave.setUserPrmData(user_prm)
    slave.setCfgDataElements([DpCfgDataElement(cfg[0], cfg[1:])])
    slave.setWatchdog(WATCHDOG_MS)
    return slave


def open_port(port):
    phy = CpPhySerial(port=port)
    phy.setConfig(baudrate=BAUD)
    return phy


def master_of(phy, slave):
    """A master with this slave alone: pyprofibus credits SC to every slave it is starting."""
    master = DPM1(phy=phy, masterAddr=MASTER)
    master.addSlave(slave)
    master.initialize()
    return master


def state_of(master, slave):
    """The state of the slave in the master, a private attribute: read for reports and reset to start again."""
    return master._DpMaster__slaveStates[slave.slaveAddr]


def step(master, slave, state, outputs):
    """One step with these outputs. pyprofibus meets RS with an exception; the slave is started over then."""
    # Data_Exchange is sent only with fresh outputs.
    slave.setMasterOutData(bytearray(outputs))
    try:
        master.run()
    except DpError:
        state.setState(DpSlaveState.STATE_INIT)
        state.applyState()


class Outputs:
    """The outputs as standard input has set them last."""

    def __init__(self, count):
        self.octets = bytes(count)
        self.ended = threading.Event()

    def read(self):
        """Takes lines until standard input ends."""
        for line in sys.stdin:
            self.octets = bytes.fromhex(line)
        self.ended.set()


def run(master, slave, outputs):
    """Exchanges data as fast as possible and reports changes."""
    state = state_of(master, slave)
    told_state, told_inputs, exchanges = None, None, 0
    while not outputs.ended.is_set():
        step(master, slave, state, outputs.octets)
        if state.getState() != told_state:
            told_state = state.getState()
            tell(state=state.state2name[told_state], exchanges=exchanges)
        inputs = slave.getMasterInData()
        if inputs is not None:
            exchanges += 1
            if inputs != told_inputs:
                told_inputs = inputs
                tell(inputs=inputs.hex(), exchanges=exchanges)


def tell(**what):
    print(json.dumps(what), flush=True)


def main():
    port, address, ident, cfg, user_prm, outputs, inputs = sys.argv[1:]
    slave = describe(
        int(address), int(ident, 0), bytes.fromhex(cfg), bytes.fromhex(user_prm), int(outputs), int(inputs)
    )
    master = master_of(open_port(port), slave)
    outputs = Outputs(int(outputs))
    threading.Thread(target=outputs.read, daemon=True).start()
    run(master, slave, outputs)
    master.destroy()


if __name__ == "__main__":
    main()
