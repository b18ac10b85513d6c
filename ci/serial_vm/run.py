#!/usr/bin/env python3
"""Runs profivac in a virtual machine whose kernel drives a 16550A, an FTDI adapter and a CDC-ACM device.

ci/serial_vm/run.py PROGRAM            the steps of ./test; compares the table in docs/adapters.md
ci/serial_vm/run.py PROGRAM --write    the same, and writes the table into docs/adapters.md
ci/serial_vm/run.py PROGRAM STEP ...   only these steps, without the table: rates, locks, replug ...
ci/serial_vm/run.py PROGRAM --long     only 100 scans and 100 reads at 9600 and 19200 bit/s on the 16550A, each with one try

Exit code 0: every step had its outcome. Everything else is printed.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import vm  # noqa: E402

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAGE = os.path.join(ROOT, "docs/adapters.md")
FAILURES = os.path.join(ROOT, "target/serial_vm/failures")
BEGIN, END = "<!-- table of ci/serial_vm: begin -->\n", "<!-- table of ci/serial_vm: end -->\n"

COM, USB, ACM = "/dev/ttyS1", "/dev/ttyUSB0", "/dev/ttyACM0"
LATENCY = "$(readlink -f /sys/class/tty/ttyUSB0/device)/latency_timer"
# The longest time of an operation in seconds. The rules of `conform` take minutes beside other programs that load the computer.
OPERATION_TIME = 600
RATES = [9600, 19200, 45450, 93750, 187500, 500000, 1500000, 3000000, 6000000, 12000000]


class Bench:
    """The guest, its cables, and the slave at the other end of each cable."""

    def __init__(self, program, is_long):
        self.program, self.is_long = program, is_long
        self.cables = {COM: vm.Cable(), USB: vm.Cable()}
        self.slaves = {}
        self.guest = vm.Guest(os.path.join(ROOT, "target/serial_vm"), program, self.cables[COM], self.cables[USB])
        self.rows = []
        self.failures = []

    def slave(self, port, baud):
        """Puts a virtual BCG450 with address 5 at the other end of `port`, at the pace of the line."""
        running = self.slaves.get(port)
        if running and running[0] == baud:
            return
        self.remove(port)
        process = subprocess.Popen(
            [self.program, "simulate", "--tcp", "127.0.0.1:0", "--baud", str(baud), "--pace", "bcg450@5"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        address = process.stdout.readline().split()[1]
        self.cables[port].connect(int(address.rsplit(":", 1)[1]))
        self.slaves[port] = (baud, process)

    def remove(self, port):
        _, process = self.slaves.pop(port, (None, None))
        if process:
            self.cables[port].connect(None)
            process.kill()
            process.wait()

    def check(self, name, condition, found):
        """Counts a condition that does not hold."""
        if not condition:
            self.failures.append(name)
            print(f"FAILED {name}: {found}", flush=True)

    def row(self, adapter, rate, operation, outcome):
        """Adds a row to the table."""
        print(f"{adapter} | {rate} | {operation} | {outcome}", flush=True)
        self.rows.append((adapter, rate, operation, outcome))

    def close(self):
        for port in list(self.slaves):
            self.remove(port)
        self.guest.close()


def said(output):
    """The messages of the program without the notice that every run on a UART prints."""
    lines = [line for line in output.splitlines() if "does not switch the transmitter" not in line]
    return re.sub(r"^profivac: ", "", lines[-1]) if lines else "nothing"


def operations(hsa):
    """The commands that are tried, with a text that their output must contain."""
    return {
        "scan": (f"scan --hsa {hsa}", "bcg450"),
        "read": ("read --address 5 pirani.process-value", "pirani.process-value = "),
        "dump": ("dump --address 5", "setpoint-b.atmospheric-pressure-reached"),
        "monitor": ("monitor --own --csv --for 2 5", "DATA"),
        "conform": ("conform --own --address 5", ", 0 broken"),
    }


def try_operation(bench, port, baud, name, repetitions=1):
    """Runs an operation in the guest. Returns `works` or what the program says."""
    command, wanted = operations(10)[name]
    command = f"profivac {command.split(' ', 1)[0]} --port {port} --baud {baud} {command.split(' ', 1)[1]} 2>&1"
    good, failed = 0, None
    for _ in range(repetitions):
        # The time of the virtual machine stands still while the computer is busy, so a short run gives a failure a second try.
        for _ in range(1 if bench.is_long else 3):
            begun = time.monotonic()
            code, output, _ = bench.guest.run(command, OPERATION_TIME)
            is_good = code == 0 and wanted in output
            if is_good or "cannot run at" in output:
                break
            explain(bench, port, f"{command}: exit code {code}: {output}", begun)
        good += is_good
        failed = failed if is_good else f"exit code {code}: {said(output)}"
    if good == repetitions:
        return "works" if repetitions == 1 else f"works, {good} of {repetitions}"
    return failed if repetitions == 1 else f"{good} of {repetitions}; the last failure: {failed}"


def explain(bench, port, failure, begun):
    """Prints an unexpected outcome with the data that show its cause: the telegrams on the cable, and what the driver counts."""
    counters = bench.guest.run("grep '^1:' /proc/tty/driver/serial")[1] if port == COM else ""
    os.makedirs(FAILURES, exist_ok=True)
    name = os.path.join(FAILURES, f"{len(os.listdir(FAILURES))}.txt")
    with open(name, "w") as file:
        file.write("\n".join([failure, counters, *bench.cables[port].lines(begun)]) + "\n")
    print(f"{failure.splitlines()[0]}: see {name}", flush=True)


def real_rate(port, baud):
    """The rate at which a port runs that does not have `baud`: the clock of the 16550A divides to 115200 bit/s / N, and `ftdi_sio` sets 9600."""
    return {COM: 115200 // max(1, round(115200 / baud)), USB: 9600}[port]


def rates(bench):
    """Every rate on both ports: a read works, or the program refuses the rate in words."""
    for port, adapter in [(COM, "16550A of a PC, `8250`"), (USB, "FT232, `ftdi_sio`")]:
        for baud in RATES:
            bench.slave(port, baud)
            outcome = try_operation(bench, port, baud, "read")
            bench.row(adapter, baud, "read", outcome)
            possible = {COM: [9600, 19200], USB: RATES[:8]}[port]
            refused = f"it would run at {real_rate(port, baud)} bit/s: "
            good = outcome == "works" if baud in possible else outcome.startswith("exit code 3") and refused in outcome
            bench.check(f"read at {baud} on {port}", good, outcome)


def chosen(with_conform):
    """The operations that are tried. The rules of `conform` take long, so they are tried at one rate of a port."""
    return [name for name in operations(10) if with_conform or name != "conform"]


def every_operation(bench):
    """All operations on the 16550A with the default trigger, and on the USB adapter with a latency of 1 and 16 ms."""
    for baud in [9600, 19200]:
        bench.slave(COM, baud)
        for name in chosen(baud == 19200):
            outcome = try_operation(bench, COM, baud, name, 3 if name in ("scan", "read") else 1)
            bench.row("16550A of a PC, `8250`, trigger 8", baud, name, "works" if outcome.startswith("works") else outcome)
            bench.check(f"{name} at {baud} on {COM}", outcome.startswith("works"), outcome)
    for latency in [1, 16]:
        bench.cables[USB].latency = latency / 1000
        # A file that even root cannot change stands for an adapter whose latency cannot be lowered.
        bench.guest.run(f"echo {latency} > {LATENCY}; echo {latency} > /tmp/latency; mount -o bind /tmp/latency {LATENCY}; "
                        f"mount -o remount,bind,ro {LATENCY}")
        for baud in [19200, 187500, 1500000]:
            bench.slave(USB, baud)
            for name in chosen(baud == 187500):
                outcome = try_operation(bench, USB, baud, name)
                bench.row(f"FT232, `ftdi_sio`, latency {latency} ms", baud, name, outcome)
                bench.check(f"{name} at {baud} with {latency} ms", outcome == "works", outcome)
        bench.guest.run(f"umount {LATENCY}")
    bench.cables[USB].latency = 0.0


def a_hundred_times(bench):
    """Scan and read on the 16550A with the default trigger, 100 times each."""
    for baud in [9600, 19200]:
        bench.slave(COM, baud)
        for name in ["scan", "read"]:
            outcome = try_operation(bench, COM, baud, name, 100)
            bench.row("16550A of a PC, `8250`, trigger 8", baud, name, outcome)
            bench.check(f"{name} at {baud} on {COM}", outcome == "works, 100 of 100", outcome)


def adapters_without_a_timer(bench):
    """Adapters whose driver tells no latency: the cable has their packets, and holds octets for as long as profivac assumes."""
    # An empty file stands for a driver that has none.
    bench.guest.run(f": > /tmp/latency; mount -o bind /tmp/latency {LATENCY}")
    cable = bench.cables[USB]
    for adapter, chunk, hold in [("packets of 64 as `cp210x` and `pl2303`", 64, 16), ("packets of 32 as `ch341`", 32, 16)]:
        cable.chunk, cable.latency = chunk, hold / 1000
        for baud in [19200, 187500]:
            bench.slave(USB, baud)
            for name in ["scan", "read", "dump", "monitor"]:
                outcome = try_operation(bench, USB, baud, name)
                bench.row(f"no latency timer, {adapter}, held for {hold} ms", baud, name, outcome)
                bench.check(f"{name} at {baud} with {adapter}", outcome == "works", outcome)
    cable.chunk, cable.latency = vm.Cable.FTDI_CHUNK, 0.0
    bench.guest.run(f"umount {LATENCY}")


def latency_without_root(bench):
    """A user who may open the port lowers the latency without root."""
    guest = bench.guest
    bench.slave(USB, 19200)
    guest.run("chgrp dialout /dev/ttyUSB0; chmod 660 /dev/ttyUSB0; echo 16 > /sys/class/tty/ttyUSB0/device/latency_timer")
    code, output, _ = guest.run(f"su user -c 'profivac read --port {USB} --address 5 pirani.process-value' 2>&1")
    latency = guest.run("cat /sys/class/tty/ttyUSB0/device/latency_timer")[1]
    bench.check("low latency without root", (code, latency) == (0, "1"), f"{code}, {latency}: {output}")
    guest.run("setserial /dev/ttyUSB0 ^low_latency; mv /bin/setserial /bin/hidden")
    guest.run("echo 16 > /sys/class/tty/ttyUSB0/device/latency_timer")
    code, output, _ = guest.run(f"su user -c 'profivac read --port {USB} --address 5 pirani.process-value' 2>&1")
    guest.run("mv /bin/hidden /bin/setserial")
    bench.check("a latency that stays is told", code == 0 and "setserial" in output, f"{code}: {output}")


def locks(bench):
    """A second program is refused; a killed one leaves the port usable; one that takes octets away is named."""
    guest = bench.guest
    bench.slave(USB, 19200)
    guest.run(f"profivac monitor --port {USB} --own --csv 5 >/tmp/first 2>&1 & wait_for 'grep DATA /tmp/first'")
    code, output, _ = guest.run(f"profivac read --port {USB} --address 5 pirani.process-value 2>&1")
    bench.check("a second program is refused", code == 3 and "is in use by another program" in output, f"{code}: {output}")
    guest.run("kill -9 %1 || killall -9 profivac; sleep 0.5")
    code, output, _ = guest.run(f"profivac read --port {USB} --address 5 pirani.process-value 2>&1")
    bench.check("a port is usable after SIGKILL", code == 0, f"{code}: {output}")
    # A program of root ignores the lock. It opens the device when the port is in use already, and takes octets away.
    guest.run(f"profivac monitor --port {USB} --own --csv 5 >/tmp/first 2>/tmp/remarks & wait_for 'grep DATA /tmp/first'")
    named = f"wait_for 'grep \"has {USB} open too\" /tmp/remarks'"
    code, output, _ = guest.run(f"cat {USB} >/dev/null & {named} || {named}; found=$?; killall cat profivac; sleep 1; "
                                "cat /tmp/remarks; [ $found = 0 ]", 120)
    bench.check("a program that takes octets away later is named", code == 0, f"{code}: {output}")


def replug(bench):
    """`monitor` continues after the adapter was unplugged and plugged in again."""
    guest = bench.guest
    bench.slave(USB, 19200)
    begin = f"profivac monitor --port {USB} --own --csv 5 >/tmp/rows 2>/tmp/remarks & wait_for 'grep DATA /tmp/rows'"
    guest.run(begin)
    guest.unplug()
    guest.run("wait_for 'grep \"open it again\" /tmp/remarks'")
    guest.plug()
    code, output, _ = guest.run("wait_for 'grep \"is open again\" /tmp/remarks' && n=$(wc -l </tmp/rows) && "
                                "wait_for \"tail -n +$((n + 1)) /tmp/rows | grep ,DATA,\" && tail -n +$((n + 1)) /tmp/rows", 90)
    bench.check("monitor continues after a replug", code == 0, output)
    rows = guest.run("grep -v ',DATA,\"\",' /tmp/rows | tail -n +2")[1]
    bench.check("rows without data name the port", "the port was lost" in rows and "no answer" not in rows, rows)
    ends_within_a_second(bench, "monitor", "cat /tmp/remarks", begin)


def ends_within_a_second(bench, name, explain_command, begin_again):
    """Ends the program in the guest, at most three times: a busy computer delays its end too.

    `explain_command` prints its messages, and `begin_again` starts it for the next try.
    """
    for attempt in range(3):
        if attempt:
            bench.guest.run(begin_again, 60)
        code, output, _ = bench.guest.run(f"ends; {explain_command}", 60)
        ended = re.search(r"ended after (\d+) hundredths", output)
        print(f"{name} {ended.group() if ended else 'does not end'}", flush=True)
        if ended and int(ended.group(1)) <= 100:
            return
    bench.check(f"{name} ends within a second", False, f"{code}: {output}")


# In bit times at 19200 bit/s: 60 for max T_SDR, 11 for a character, and the delays of the port: 4 ms and 44 bit times of the FIFO, or
# 4 ms, a latency of 1 ms and two USB frames.
SLOT_TIMES = {COM: 192, USB: 206}


def slave_in_the_guest(bench):
    """A master on the host reads a virtual gauge in the guest through the drivers."""
    for port in (COM, USB):
        bench.remove(port)
        bench.guest.run(f"profivac simulate --serial {port} --baud 19200 bcg450@7 >/tmp/simulate 2>&1 & "
                        "wait_for 'grep ready /tmp/simulate'")
        where = ["--port", f"tcp://127.0.0.1:{bench.cables[port].master_port}", "--address", "7"]
        done = subprocess.run([bench.program, "read", *where, "pirani.process-value"], capture_output=True, text=True, timeout=60)
        bench.check(f"a slave on {port}", done.returncode == 0, done.stderr)
        remarks = bench.guest.run("ends; cat /tmp/simulate")[1]
        bench.check(f"simulate on {port} names the slot time", f"slot time of at least {SLOT_TIMES[port]} bit times" in remarks, remarks)


def dead_device(bench):
    """A command on a device that takes no octet ends within a second after its timeout, and no change of its rate waits for it."""
    code, output, seconds = bench.guest.run(f"profivac scan --port {ACM} --baud 19200 --timeout 1 --hsa 3 2>&1", 60)
    bench.check("a command on a dead device ends", seconds < 10, f"{seconds:.1f} s, code {code}: {output}")
    begin = f"profivac monitor --port {ACM} --baud 19200 --own --csv 5 >/tmp/rows 2>&1 & sleep 3"
    bench.guest.run(begin)
    ends_within_a_second(bench, "monitor on a dead device", "cat /tmp/rows", begin)
    # A program of root, which the lock does not stop, keeps the queue of the device full. The search for the rate changes the settings of
    # the port ten times; a change that waits for the queue does not end.
    bench.guest.run(f"cat /dev/zero >{ACM} & sleep 1")
    code, output, seconds = bench.guest.run(f"profivac scan --port {ACM} --baud auto 2>&1", 120)
    print(f"ten changes of the rate took {seconds:.1f} s", flush=True)
    bench.check("a change of the rate does not wait for a dead device",
                code == 3 and "no telegram on" in output and seconds < 60, f"{seconds:.1f} s, code {code}: {output}")
    bench.guest.run("killall cat; true")


STATION = """[station]
name = "two ports"
listen = "127.0.0.1:8080"
[[segment]]
name = "com"
port = "/dev/ttyS1"
baud = 19200
[[segment.gauge]]
name = "one"
address = 5
device = "bcg450"
[[segment]]
name = "usb"
port = "/dev/ttyUSB0"
baud = 19200
[[segment.gauge]]
name = "two"
address = 5
device = "bcg450"
"""


def station(bench):
    """A station on two ports goes on when one is unplugged, and ends within a second."""
    guest = bench.guest
    for port in (COM, USB):
        bench.slave(port, 19200)
    for line in STATION.splitlines():
        guest.run(f"echo '{line}' >> /tmp/plant.toml")
    guest.run("profivac run /tmp/plant.toml >/tmp/station 2>&1 & true")
    states = "wget -qO- http://127.0.0.1:8080/api/gauges"
    exchanging = lambda count: f"wait_for '[ $({states} | grep -o data-exchange | wc -l) = {count} ]'"  # noqa: E731
    code, output, _ = guest.run(f"{exchanging(2)} || {states}", 60)
    bench.check("a station reads both ports", code == 0, output)
    guest.unplug()
    code, output, _ = guest.run(f"{exchanging(1)} || {states}", 60)
    bench.check("the other port goes on", code == 0, output)
    guest.plug()
    code, output, _ = guest.run(f"{exchanging(2)} || {states}", 90)
    bench.check("the station finds the port again", code == 0, output)
    guest.unplug()
    guest.run(f"{exchanging(1)} || {states}", 60)
    begin = f"profivac run /tmp/plant.toml >/tmp/station 2>&1 & {exchanging(1)}"
    ends_within_a_second(bench, "the station with an unplugged port", "tail -3 /tmp/station", begin)
    guest.plug()
    guest.run(f"wait_for '[ -e {USB} ]'")


def table(rows):
    """The rows in Markdown; rows that differ only in the rate or the operation are joined."""
    joined = {}
    for adapter, rate, operation, outcome in rows:
        joined.setdefault((adapter, rate, outcome), []).append(operation)
    lines = ["| Adapter, driver | bit/s | Operation | Outcome |", "|---|--:|---|---|"]
    for (adapter, rate, outcome), names in joined.items():
        lines.append(f"| {adapter} | {rate} | {', '.join(names)} | {outcome} |")
    return "\n".join(lines) + "\n"


STEPS = [rates, every_operation, adapters_without_a_timer, latency_without_root, locks, replug, slave_in_the_guest, dead_device, station]


def main():
    is_long = "--long" in sys.argv
    only = [argument for argument in sys.argv[2:] if not argument.startswith("--")]
    steps = [a_hundred_times] if is_long else [step for step in STEPS if not only or step.__name__ in only]
    program = os.path.abspath(sys.argv[1])
    if os.geteuid() == 0:
        # The virtual machine and the slaves run in real time, also beside other programs.
        os.setpriority(os.PRIO_PROCESS, 0, -15)
    shutil.rmtree(FAILURES, ignore_errors=True)
    bench = Bench(program, is_long)
    try:
        for step in steps:
            begun = time.monotonic()
            try:
                step(bench)
            except TimeoutError as error:
                bench.check(step.__name__, False, error)
            print(f"{step.__doc__} ({time.monotonic() - begun:.0f} s)", flush=True)
    finally:
        bench.close()
    if only or is_long:
        sys.exit(1 if bench.failures else 0)
    with open(PAGE) as file:
        page = file.read()
    before, rest = page.split(BEGIN)
    old, after = rest.split(END)
    if "--write" in sys.argv:
        with open(PAGE, "w") as file:
            file.write(before + BEGIN + table(bench.rows) + END + after)
    else:
        bench.check("the table of docs/adapters.md", old == table(bench.rows), "it differs; run with --write and read the difference")
    print(f"{len(bench.rows)} rows, {len(bench.failures)} failures")
    sys.exit(1 if bench.failures else 0)


main()
