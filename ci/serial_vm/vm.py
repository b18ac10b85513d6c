"""A virtual machine with serial ports that the kernel drives.

| Device | Driver | Other end |
|---|---|---|
| /dev/ttyS1 | 8250, a 16550A with the default trigger of 8 | `Cable` on the host |
| /dev/ttyUSB0 | ftdi_sio | `Cable` on the host, which can hold octets back as the latency timer of the chip does |
| /dev/ttyACM0 | cdc_acm | a gadget in the same guest that never takes an octet |

The guest is a Debian kernel with busybox and the program under test. Its console is a shell: `Guest.run` sends a command
and returns the exit code and the output.
"""

import collections
import glob
import gzip
import json
import os
import re
import select
import shutil
import socket
import subprocess
import threading
import time

# In the order in which they are loaded.
MODULES = [
    "usb/common/usb-common", "usb/core/usbcore", "usb/host/xhci-hcd", "usb/host/xhci-pci",
    "usb/serial/usbserial", "usb/serial/ftdi_sio", "usb/class/cdc-acm",
    "../fs/configfs/configfs", "usb/gadget/udc/udc-core", "usb/gadget/libcomposite", "usb/gadget/udc/dummy_hcd",
    "usb/gadget/function/u_serial", "usb/gadget/function/usb_f_acm", "usb/gadget/legacy/g_serial",
]

INIT = """#!/bin/sh
/bin/busybox --install -s /bin
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs dev /dev
mkdir -p /dev/pts && mount -t devpts devpts /dev/pts
mount -t tmpfs tmp /tmp
for module in /modules/*.ko; do insmod $module; done
ip link set lo up
export HOME=/tmp PATH=/bin TERM=dumb
stty -F /dev/ttyS0 raw -echo
until [ -e /dev/ttyUSB0 -a -e /dev/ttyACM0 ]; do sleep 0.1; done
# wait_for COMMAND: until it succeeds, at most 30 s.
wait_for() {
    n=0
    until eval "$1" >/dev/null 2>&1; do
        n=$((n + 1))
        if [ $n -gt 150 ]; then echo "in vain: $1"; return 1; fi
        sleep 0.2
    done
}
# hundredths: the time since the start in hundredths of a second.
hundredths() { cut -d' ' -f1 /proc/uptime | tr -d .; }
# ends: sends SIGTERM to the program, waits until it has ended, and prints the time that this took.
ends() {
    begun=$(hundredths)
    kill -TERM $(pidof profivac)
    n=0
    while pidof profivac >/dev/null; do
        n=$((n + 1))
        if [ $n -gt 600 ]; then echo "in vain: end"; return 1; fi
        sleep 0.05
    done
    echo "ended after $(($(hundredths) - begun)) hundredths"
}
exec </dev/ttyS0 >/dev/ttyS0 2>&1
echo guest is ready
while read -r line; do eval "$line" </dev/null; done
"""

END = "@end@"


def run(*command, **options):
    return subprocess.run(command, check=True, **options)


def kernel_package():
    """The name of the Debian package with the present kernel; None if the lists of packages do not have it."""
    depends = subprocess.run(["apt-cache", "depends", "linux-image-amd64"], capture_output=True, text=True)
    package = re.search(r"linux-image-\d\S*", depends.stdout)
    return package.group() if depends.returncode == 0 and package else None


def download(package, folder):
    """Downloads a package. Returns whether it is there."""
    return subprocess.run(["apt-get", "download", "-qq", package], cwd=folder).returncode == 0


def kernel(folder):
    """The folder of an unpacked Debian kernel, fetched once."""
    unpacked = os.path.join(folder, "kernel")
    if not glob.glob(unpacked + "/boot/vmlinuz-*"):
        os.makedirs(folder, exist_ok=True)
        package = kernel_package()
        if not package or not download(package, folder):
            # The lists of packages are missing, or older than the package.
            run("apt-get", "update", "-qq")
            package = kernel_package()
            if not package or not download(package, folder):
                raise RuntimeError("apt-get finds no package linux-image-amd64, or cannot download it; look at /etc/apt/sources.list")
        (archive,) = glob.glob(f"{folder}/{package}_*.deb")
        run("dpkg-deb", "-x", archive, unpacked)
        os.remove(archive)
    return unpacked


def initrd(folder, program, kernel_folder):
    """Builds the file system of the guest. Returns its path."""
    root = os.path.join(folder, "root")
    shutil.rmtree(root, ignore_errors=True)
    for name in ["bin", "proc", "sys", "dev", "tmp", "etc", "modules"]:
        os.makedirs(os.path.join(root, name))
    shutil.copy("/bin/busybox", os.path.join(root, "bin/busybox"))
    os.symlink("busybox", os.path.join(root, "bin/sh"))
    run("strip", "-o", os.path.join(root, "bin/profivac"), program)
    libraries = subprocess.run(["ldd", program], check=True, capture_output=True, text=True).stdout
    for library in re.findall(r"(/\S+)", libraries):
        place = root + library
        os.makedirs(os.path.dirname(place), exist_ok=True)
        shutil.copy(library, place)
    (modules,) = glob.glob(f"{kernel_folder}/lib/modules/*/kernel/drivers")
    for number, module in enumerate(MODULES):
        shutil.copy(f"{modules}/{module}.ko", f"{root}/modules/{number:02}.ko")
    shutil.copy(shutil.which("setserial") or "/bin/setserial", f"{root}/bin/setserial")
    users = "root:x:0:0::/:/bin/sh\nuser:x:1000:20::/tmp:/bin/sh\n"
    for name, text in [("etc/passwd", users), ("etc/group", "root:x:0:\ndialout:x:20:user\n")]:
        with open(os.path.join(root, name), "w") as file:
            file.write(text)
    with open(os.path.join(root, "init"), "w") as file:
        file.write(INIT)
    os.chmod(os.path.join(root, "init"), 0o755)
    image = os.path.join(folder, "initrd.gz")
    files = subprocess.run(["find", "."], cwd=root, check=True, capture_output=True).stdout
    archive = run("cpio", "-o", "-H", "newc", "--quiet", cwd=root, input=files, capture_output=True).stdout
    with gzip.open(image, "wb", compresslevel=1) as file:
        file.write(archive)
    return image


class Cable:
    """Connects a serial port of the guest with a TCP port of the host.

    `end` listens; QEMU connects to it. `peer` is the TCP port of a `profivac simulate --tcp`, or None: then the cable
    listens on `master_port` for a master on the host. `latency` seconds and `chunk` octets model a USB adapter: octets for
    the guest wait until so many are there, or until the timer has run out. `journal` keeps the latest pieces in both directions.
    """

    # A packet of 64 octets has two octets of status.
    FTDI_CHUNK = 62

    def __init__(self):
        self.server = socket.create_server(("127.0.0.1", 0))
        self.end = self.server.getsockname()[1]
        self.outside = socket.create_server(("127.0.0.1", 0))
        self.master_port = self.outside.getsockname()[1]
        self.latency, self.chunk = 0.0, self.FTDI_CHUNK
        # Both threads change the ends: the one that puts a slave there, and the one that sees an end close.
        self.ends = threading.Lock()
        self.peer = None
        self.guest = None
        self.held = b""
        self.due = None
        self.closing = False
        self.journal = collections.deque(maxlen=50_000)
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def connect(self, port):
        """Connects the cable with a TCP server of the host, or with nothing."""
        with self.ends:
            old, self.peer = self.peer, None
        if old:
            old.close()
        if port:
            peer = socket.create_connection(("127.0.0.1", port))
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with self.ends:
                self.peer = peer

    def serve(self):
        while not self.closing:
            peer, guest = self.peer, self.guest
            sources = [self.server, self.outside] + [source for source in (peer, guest) if source]
            wait = max(0.0, self.due - time.monotonic()) if self.due else 0.05
            try:
                ready = select.select(sources, [], [], wait)[0]
            except (OSError, ValueError):
                continue
            for source in ready:
                self.receive(source, peer, guest)
            if self.due and time.monotonic() >= self.due:
                self.release()

    def receive(self, source, peer, guest):
        if source in (self.server, self.outside):
            connection = source.accept()[0]
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            if source is self.server:
                self.guest = connection
            else:
                self.peer = connection
            return
        try:
            octets = source.recv(4096)
        except OSError:
            octets = b""
        if not octets:
            self.closed(source)
        elif source is guest:
            self.note(">", octets)
            self.send(peer, octets)
        else:
            self.held += octets
            while len(self.held) >= self.chunk and self.latency:
                self.note("<", self.held[: self.chunk])
                self.send(self.guest, self.held[: self.chunk])
                self.held = self.held[self.chunk :]
            if not self.latency:
                self.release()
            elif self.held and not self.due:
                # The timer of the chip runs freely: it ends at any time up to the latency.
                self.due = time.monotonic() + self.latency
        return

    def closed(self, source):
        """Forgets an end that was closed. The former peer may be seen late, when its successor is connected."""
        with self.ends:
            if source is self.peer:
                self.peer = None
            elif source is self.guest:
                self.guest = None

    def release(self):
        self.due = None
        held, self.held = self.held, b""
        self.note("<", held)
        self.send(self.guest, held)

    def note(self, direction, octets):
        self.journal.append((time.monotonic(), direction, octets))

    def lines(self, begun):
        """What has passed since `begun`: milliseconds, `>` from the guest or `<` to it, octets. Pieces less than 1 ms apart are one."""
        lines, last = [], None
        for at, direction, octets in [piece for piece in list(self.journal) if piece[0] >= begun]:
            if last and last[1] == direction and at - last[0] < 0.001:
                lines[-1] += " " + octets.hex(" ")
            else:
                lines.append(f"{(at - begun) * 1000:9.1f} {direction} {octets.hex(' ')}")
            last = (at, direction)
        return lines

    @staticmethod
    def send(target, octets):
        try:
            if target and octets:
                target.sendall(octets)
        except OSError:
            pass


class Guest:
    """A running virtual machine."""

    def __init__(self, folder, program, com, usb):
        """`com` and `usb` are the cables of /dev/ttyS1 and /dev/ttyUSB0."""
        kernel_folder = kernel(folder)
        image = initrd(folder, program, kernel_folder)
        (vmlinuz,) = glob.glob(kernel_folder + "/boot/vmlinuz-*")
        console, self.console = socket.socketpair()
        monitor, self.monitor = socket.socketpair()
        other_end = "socket,id={},host=127.0.0.1,port={},nodelay=on"
        self.process = subprocess.Popen(
            ["qemu-system-x86_64", "-machine", "pc", "-m", "512", "-display", "none", "-nodefaults", "-no-reboot",
             "-kernel", vmlinuz, "-initrd", image, "-append", "console=ttyS0 quiet panic=-1",
             "-chardev", f"socket,id=console,fd={console.fileno()}",
             "-device", "isa-serial,chardev=console,index=0",
             "-chardev", other_end.format("com", com.end), "-device", "isa-serial,chardev=com,index=1",
             "-chardev", other_end.format("usb", usb.end), "-device", "qemu-xhci,id=xhci",
             "-device", "usb-serial,chardev=usb,id=adapter,bus=xhci.0,always-plugged=on",
             "-chardev", f"socket,id=monitor,fd={monitor.fileno()}", "-mon", "chardev=monitor,mode=control"],
            pass_fds=[console.fileno(), monitor.fileno()], stdin=subprocess.DEVNULL)
        console.close()
        monitor.close()
        self.monitor_lines = self.monitor.makefile()
        self.text = b""
        self.read_until(b"guest is ready", 120)
        self.qmp("qmp_capabilities")

    def read_until(self, wanted, seconds):
        """Returns the console output up to `wanted`."""
        deadline = time.monotonic() + seconds
        while wanted not in self.text:
            left = deadline - time.monotonic()
            if self.process.poll() is not None:
                raise RuntimeError(f"QEMU ended with {self.process.returncode}; the console shows {self.text[-2000:]!r}")
            if left <= 0 or not select.select([self.console], [], [], left)[0]:
                raise TimeoutError(f"no {wanted!r} after {seconds} s; the console shows {self.text[-2000:]!r}")
            self.text += self.console.recv(65536)
        before, self.text = self.text.split(wanted, 1)
        return before.decode(errors="replace")

    def send(self, line):
        """Sends a line to the shell of the guest without waiting."""
        self.console.sendall(line.encode() + b"\n")

    def run(self, command, seconds=60):
        """Runs a command in the guest. Returns its exit code, output and duration in seconds."""
        begun = time.monotonic()
        # The end mark is written in two parts: the echo of the command does not contain it.
        self.send(f"{command}; echo \"@en\"\"d@$?@\"")
        output = self.read_until(END.encode(), seconds)
        code = int(self.read_until(b"@", 10))
        return code, output.replace("\r\n", "\n").strip(), time.monotonic() - begun

    def qmp(self, name, **arguments):
        """Runs a command of the monitor."""
        command = {"execute": name, "arguments": arguments} if arguments else {"execute": name}
        self.monitor.sendall(json.dumps(command).encode() + b"\n")
        answer = self.monitor_message(lambda message: "return" in message or "error" in message)
        if "error" in answer:
            raise RuntimeError(f"{name}: {answer}")

    def monitor_message(self, wanted):
        """The next message of the monitor for which `wanted` holds; the others are dropped."""
        while True:
            message = json.loads(self.monitor_lines.readline())
            if wanted(message):
                return message

    def unplug(self):
        """Unplugs the USB adapter."""
        self.qmp("device_del", id="adapter")
        self.monitor_message(lambda message: message.get("event") == "DEVICE_DELETED")

    def plug(self):
        """Plugs the USB adapter in again."""
        self.qmp("device_add", driver="usb-serial", chardev="usb", id="adapter", bus="xhci.0", **{"always-plugged": True})

    def close(self):
        self.process.kill()
        self.process.wait()
