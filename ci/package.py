#!/usr/bin/env python3
"""Builds the Debian package and installs, starts, upgrades and removes it in a fresh root folder.

ci/package.py PROGRAM      packs this program; needs root, because dpkg changes into the root folder

The root folder has a dpkg database of its own, with the libraries of this computer that the package depends on, and busybox as its shell.
systemd does not run in it: systemd-analyze checks the unit, and the test starts the command of the unit itself.
"""

import gzip
import os
import re
import shutil
import signal
import socket
import stat
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
COMMANDS = r"^  ([a-z-]+) "
EXPOSURE = "20"  # tenths: systemd calls up to 4.0 "OK"
LONGEST_WAIT_S = 120


def run(*command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


def expect(condition, text):
    if not condition:
        sys.exit(f"FAILED: {text}")
    print(f"ok: {text}")


def build(program, revision):
    # The program of the tests is several times as large as that of a release: at the usual level xz takes a minute for each package.
    command = (PROJECT / "contrib/debian/build.sh", "--program", program, "--revision", revision, "--compression", "0")
    return PROJECT / run(*command).strip()


class Root:
    """A root folder with a dpkg database, a shell and the libraries of the program."""

    def __init__(self, folder, package):
        self.folder = folder
        for part in ("var/lib/dpkg/info", "var/lib/dpkg/updates", "var/lib/dpkg/triggers", "bin", "etc", "tmp"):
            (folder / part).mkdir(parents=True)
        shutil.copy("/usr/bin/busybox", folder / "bin/sh")
        (folder / "etc/passwd").write_text("root:x:0:0::/:/bin/sh\n")
        (folder / "etc/group").write_text("root:x:0:\n")
        depends = run("dpkg-deb", "--field", package, "Depends")
        names = [re.split(r"[ (:]", one.strip())[0] for one in depends.split(",")]
        expect("libc6" in names, f"the package depends on libraries: {depends.strip()}")
        # A Depends of the libraries themselves is not the concern of this test.
        own = ("Package", "Status", "Version", "Architecture", "Maintainer", "Description")
        entries = [
            "\n".join(line for line in run("dpkg", "--status", name).splitlines() if line.startswith(own)) for name in names
        ]
        (folder / "var/lib/dpkg/status").write_text("\n\n".join(entries) + "\n")

    def copy_libraries(self):
        for path in re.findall(r"(/\S+) \(0x", run("ldd", self.folder / "usr/bin/profivac")):
            target = self.folder / path.lstrip("/")
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, target)

    def dpkg(self, *arguments):
        return run("dpkg", f"--root={self.folder}", "--force-bad-path", *arguments)

    def version(self):
        return run("dpkg-query", f"--admindir={self.folder}/var/lib/dpkg", "--show", "--showformat=${Version} ${Status}", "profivac")

    def make_user(self):
        """What postinst does on a computer with systemd."""
        run("systemd-sysusers", f"--root={self.folder}", "profivac.conf")
        run("systemd-tmpfiles", f"--root={self.folder}", "--create", "profivac.conf")
        entries = [line.split(":") for line in (self.folder / "etc/passwd").read_text().splitlines()]
        self.user, self.group = next((int(entry[2]), int(entry[3])) for entry in entries if entry[0] == "profivac")

    def profivac(self, *arguments, **options):
        return run(*self.chroot(), "/usr/bin/profivac", *arguments, **options)

    def chroot(self):
        return "chroot", f"--userspec={self.user}:{self.group}", str(self.folder)


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class Station:
    """The command of the unit, as the user of the unit."""

    def __init__(self, root, port):
        unit = (root.folder / "usr/lib/systemd/system/profivac.service").read_text()
        command = re.search(r"^ExecStart=(.*)$", unit, re.M).group(1).split()
        self.log = tempfile.TemporaryFile()
        self.process = subprocess.Popen(
            [*root.chroot(), *command], stdout=self.log, stderr=subprocess.STDOUT
        )
        self.port = port

    def output(self):
        self.log.seek(0)
        return self.log.read().decode(errors="replace")

    def wait(self):
        end = time.monotonic() + LONGEST_WAIT_S
        while time.monotonic() < end and self.process.poll() is None:
            try:
                with urllib.request.urlopen(f"http://127.0.0.1:{self.port}/") as answer:
                    return answer.read().decode()
            except (urllib.error.URLError, ConnectionError):
                time.sleep(0.2)
        sys.exit(f"FAILED: the station does not answer\n{self.output()}")

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(LONGEST_WAIT_S)
        expect(code == 0, f"the station ends with 0 after SIGTERM, found {code}\n{self.output() if code else ''}".strip())


def check_files(root, program):
    share = root.folder / "usr/share"
    commands = set(re.findall(COMMANDS, run(program, "--help").split("Commands:")[1].split("\n\n")[0], re.M)) - {"help"}
    pages = {path.name.removesuffix(".1.gz") for path in (share / "man/man1").iterdir()}
    expect(pages == {"profivac"} | {f"profivac-{command}" for command in commands}, f"{len(pages)} man pages, one for each command")
    for name, part in (("profivac", "Exit codes"), ("profivac-scan", "--port"), ("profivac-st", "--dialect")):
        with gzip.open(share / f"man/man1/{name}.1.gz", "rt") as page:
            expect(part in page.read().replace("\\-", "-"), f"the page {name} has {part!r}")
    run("bash", "-n", share / "bash-completion/completions/profivac")
    expect(len(list((share / "profivac/gsd").glob("*.GSD"))) == 12, "12 GSD files")
    expect(len(list((share / "profivac/gsd").glob("*.BMP"))) == 36, "36 bitmaps")
    expect(len(list((share / "profivac/st").iterdir())) == 24, "function blocks for 12 devices in two dialects")
    expect(list(root.folder.glob("usr/lib/*/wireshark/plugins/profibus.lua")), "the dissector")
    expect((root.folder / "usr/lib/udev/rules.d/70-profivac.rules").is_file(), "the udev rule")


def check_units(root):
    folder = root.folder / "usr/lib/systemd/system"
    # The targets and the program of a Debian system that the unit names.
    for target in ("sysinit", "basic", "shutdown", "multi-user", "network-online"):
        shutil.copy(f"/usr/lib/systemd/system/{target}.target", folder)
    shutil.copy("/usr/bin/busybox", root.folder / "bin/kill")
    # The unit of an archive is not in the package, whose program has no archive.
    shutil.copy(PROJECT / "contrib/archive/profivac-archive.service", folder)
    for name in ("profivac.service", "profivac-archive.service"):
        unit = folder / name
        done = subprocess.run(["systemd-analyze", "verify", "--man=no", f"--root={root.folder}", unit], capture_output=True, text=True)
        own = [line for line in done.stderr.splitlines() if "profivac" in line]
        expect(not own, f"systemd-analyze verify has no remark about {name} {own or ''}".strip())
        text = run("systemd-analyze", "security", "--no-pager", "--offline=true", f"--threshold={EXPOSURE}", unit)
        expect("Overall exposure" in text, f"{name}: {text.strip().splitlines()[-1].strip()}")
    (folder / "profivac-archive.service").unlink()
    expect(not list(root.folder.glob("etc/systemd/system/*.wants/*")), "the unit is not enabled")


def main(program):
    if os.geteuid() != 0:
        sys.exit("ci/package.py needs root: dpkg changes into the root folder of the test")
    first, second = build(program, "1"), build(program, "2")
    with tempfile.TemporaryDirectory() as folder:
        root = Root(Path(folder) / "root", first)
        root.dpkg("--install", first)
        expect(root.version().endswith("-1 install ok installed"), "installed")
        root.copy_libraries()
        root.make_user()
        expect(root.profivac("--version").startswith("profivac "), "the program runs in the root folder")
        check_files(root, program)
        check_units(root)

        port = free_port()
        example = (root.folder / "usr/share/doc/profivac/examples/plant.toml").read_text()
        configuration = root.folder / "etc/profivac/plant.toml"
        configuration.write_text(example.replace("127.0.0.1:8080", f"127.0.0.1:{port}"))
        data = root.folder / "var/lib/profivac"
        for part in (configuration.parent, data):
            expect(stat.filemode(part.stat().st_mode) == "drwxr-x---" and part.stat().st_uid == root.user, f"{part} is the station's".replace(str(root.folder), ""))
        # As `install -m 600 -o profivac` does.
        os.chown(configuration, root.user, root.group)
        configuration.chmod(0o600)
        root.profivac("user", "add", "ada", "--role", "engineer", "--password-stdin", "/etc/profivac/plant.toml", input="correct horse 17\n")
        root.profivac("run", "/etc/profivac/plant.toml", "--check")
        print("ok: the example configuration is accepted")

        station = Station(root, port)
        expect("<html" in station.wait(), "the station starts with the command of the unit, and serves the dashboard")
        root.dpkg("--install", second)
        expect(root.version().endswith("-2 install ok installed"), "upgraded while the station runs")
        expect("<html" in station.wait(), "the station still runs")
        station.end()
        station = Station(root, port)
        station.wait()
        station.end()
        expect((data / "plant.db").is_file(), "the database is that of the first start")

        root.dpkg("--remove", "profivac")
        left = [path for path in (root.folder / "usr").rglob("*profivac*") if path.is_file()]
        expect(not left, f"removed without a trace in /usr {left or ''}".strip())
        expect((data / "plant.db").is_file() and configuration.is_file(), "the data and the configuration stay")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        print("usage: ci/package.py PROGRAM", file=sys.stderr)
        sys.exit(2)
    main(Path(sys.argv[1]).resolve())
