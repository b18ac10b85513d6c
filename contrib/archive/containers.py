#!/usr/bin/env python3
"""Checks the examples for Compose and Kubernetes: contrib/archive/containers.py PROGRAM [--files]

The files are compared with the schemas of the Compose specification and of Kubernetes, the references between the resources of Kubernetes are
resolved, and nats-server and PROGRAM check the files of both examples. Then the services of compose.yaml run with their own files, commands, users,
volumes and networks, but without images: each in a network namespace and a root folder of its own, with the programs of this computer. It ends when samples
of the station are in PostgreSQL. With --files only the files are checked.

It needs PyYAML, check-jsonschema, kubernetes-validate, openssl and nats-server; without --files also root, iproute2, and PostgreSQL 15 or later. PROGRAM has
the feature archive.
"""

import contextlib
import glob
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import yaml

HERE = Path(__file__).resolve().parent
BOUND = 240  # seconds; only a hang takes so long
BRIDGE = "profivac"
SUBNET = "10.213.0"


def fail(text):
    raise SystemExit(f"FAILED: {text}")


def run(*command, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        fail(f"{' '.join(map(str, command))} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


# The files.

def check_schemas():
    tools = Path(sys.executable).parent
    run(tools / "check-jsonschema", "--builtin-schema", "vendor.compose-spec", HERE / "compose/compose.yaml")
    for version in ("1.27", "1.33"):
        run(tools / "kubernetes-validate", "-k", version, "--strict", HERE / "kubernetes/archive.yaml")
    print("ok: the schemas of Compose and Kubernetes")


# Secrets that the comment at the head of archive.yaml lets the user create, with their keys.
SECRETS = {"nats-tls": {"tls.crt", "tls.key", "ca.crt"}, "nats-users": {"HALL_1", "ARCHIVE"},
           "archive": {"nats.credentials", "postgres.password", "ca.crt"}}


def check_references(resources):
    """Every name that a resource uses is a resource of the file, or a secret that its head describes."""
    maps = {item["metadata"]["name"] for item in resources if item["kind"] == "ConfigMap"}
    services = {item["metadata"]["name"] for item in resources if item["kind"] == "Service"}
    labels = [item["spec"]["template"]["metadata"]["labels"] for item in resources if "template" in item.get("spec", {})]
    for item in resources:
        spec = item.get("spec", {})
        selector = spec.get("selector", {})
        selector = selector.get("matchLabels", selector)
        if selector and selector not in labels:
            fail(f"{item['kind']} {item['metadata']['name']} selects {selector}, which no pod has")
        if spec.get("serviceName", "nats") not in services:
            fail(f"{item['metadata']['name']} names the service {spec['serviceName']}, which is absent")
        pod = spec.get("template", {}).get("spec", {})
        claims = {claim["metadata"]["name"] for claim in spec.get("volumeClaimTemplates", [])}
        for volume in pod.get("volumes", []):
            claims.add(volume["name"])
            for source in [volume, *volume.get("projected", {}).get("sources", [])]:
                name = source.get("configMap", {}).get("name")
                secret = source.get("secret", {}).get("secretName") or source.get("secret", {}).get("name")
                if (name and name not in maps) or (secret and secret not in SECRETS):
                    fail(f"{item['metadata']['name']} mounts {name or secret}, which is absent")
        for container in pod.get("containers", []):
            ports = {port["name"] for port in container.get("ports", [])}
            probes = {probe["httpGet"]["port"] for key, probe in container.items() if key.endswith("Probe")}
            mounts = {mount["name"] for mount in container.get("volumeMounts", [])}
            if not (probes <= ports and mounts == claims):
                fail(f"{container['name']}: probes of {probes} with ports {ports}, mounts {mounts} with volumes {claims}")
    print("ok: the references between the resources of Kubernetes")


def check_kubernetes(resources, program, folder):
    """The programs accept the files that the pods get."""
    files = {item["metadata"]["name"]: item["data"] for item in resources if item["kind"] == "ConfigMap"}
    folder.mkdir()
    run("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj", "/CN=nats",
        "-keyout", folder / "tls.key", "-out", folder / "tls.crt")
    shutil.copy(folder / "tls.crt", folder / "ca.crt")
    private = {"nats.credentials": 'user = "archive"\npassword = "p1"\n', "postgres.password": "p2"}
    for name, text in {**private, "archive.toml": files["archive"]["archive.toml"],
                       "nats.conf": files["nats"]["nats.conf"].replace("/etc/nats-tls", str(folder)).replace("/data", str(folder))}.items():
        (folder / name).write_text(text)
        (folder / name).chmod(0o400)
    run(program, "archive", folder / "archive.toml", "--check")
    run("nats-server", "-t", "-c", folder / "nats.conf", env={**os.environ, "POD_NAME": "nats-0", "HALL_1": "p3", "ARCHIVE": "p1"})
    print("ok: profivac and nats-server accept the files of Kubernetes")


# The composition without images.

def environment(service, folder):
    found = {}
    if "env_file" in service:
        lines = (folder / service["env_file"]).read_text().split()
        found.update(line.split("=", 1) for line in lines)
    return {**found, **service.get("environment", {})}


class Service:
    """One container of the composition: a network namespace, a root folder, and the program that its image would start."""

    def __init__(self, name, service, number, program, folder, secrets):
        self.name, self.service, self.folder, self.program = name, service, folder, program
        self.address = f"{SUBNET}.{number}"
        self.is_near = service.get("network_mode") == "host"
        self.secrets = secrets
        self.base = folder.parent / "services" / name
        self.log = self.base / "log"
        self.process = None

    def source(self, volume):
        """The folder or file of this computer behind a volume."""
        if volume.startswith("."):
            return self.folder / volume
        path = self.folder.parent / "volumes" / volume
        path.mkdir(parents=True, exist_ok=True)
        return path

    def connect(self):
        if self.is_near:
            return
        run("ip", "netns", "add", self.name)
        near = f"v{self.address.rsplit('.', 1)[1]}"
        run("ip", "link", "add", near, "type", "veth", "peer", "name", "eth0", "netns", self.name)
        run("ip", "link", "set", near, "master", BRIDGE, "up")
        for step in (["addr", "add", f"{self.address}/24", "dev", "eth0"], ["link", "set", "eth0", "up"], ["link", "set", "lo", "up"]):
            run("ip", "netns", "exec", self.name, "ip", *step)

    def mount(self, hosts):
        """A root folder with the files of this computer below, the volumes of the service, and the names of the network."""
        root = self.base / "root"
        for part in ("upper", "work", "root"):
            (self.base / part).mkdir(parents=True)
        run("mount", "-t", "overlay", "overlay", "-o", f"lowerdir=/,upperdir={self.base / 'upper'},workdir={self.base / 'work'}", root)
        run("mount", "--rbind", "/dev", root / "dev")
        run("mount", "-t", "proc", "proc", root / "proc")
        (root / "etc/hosts").unlink(missing_ok=True)
        (root / "etc/hosts").write_text("127.0.0.1 localhost\n" + ("" if self.is_near else hosts))
        binds = [(self.source(volume.split(":")[0]), *volume.split(":")[1:]) for volume in self.service.get("volumes", [])]
        binds += [(self.folder / self.secrets[name]["file"], f"/run/secrets/{name}", "ro") for name in self.service.get("secrets", [])]
        for source, target, *mode in binds:
            place = root / target.lstrip("/")
            if source.is_dir():
                place.mkdir(parents=True, exist_ok=True)
            else:
                place.parent.mkdir(parents=True, exist_ok=True)
                place.touch()
            run("mount", "--bind", source, place)
            if mode == ["ro"]:
                run("mount", "-o", "remount,ro,bind", place)
        return root

    def command(self, root):
        image = self.service["image"].split(":")[0]
        arguments = self.service.get("command", [])
        if image == "nats":
            return [shutil.which("nats-server"), *arguments]
        if image == "profivac":
            shutil.copy(self.program, root / "profivac")
            return ["/profivac", *arguments]
        return self.postgres(root)

    def postgres(self, root):
        """What the image does at its first start: a cluster with user, database and password, and the scripts of its folder."""
        settings = self.service["environment"]
        data = root / "var/lib/postgresql/data"
        shutil.chown(data, "postgres")
        bin = Path(sorted(glob.glob("/usr/lib/postgresql/*/bin"))[-1])
        password = root / "tmp/password"
        shutil.copy(root / settings["POSTGRES_PASSWORD_FILE"].lstrip("/"), password)
        shutil.chown(password, "postgres")
        as_user = ["chroot", "--userspec=postgres:postgres", root]
        run(*as_user, bin / "initdb", "-D", "/var/lib/postgresql/data", "-U", settings["POSTGRES_USER"], "-A", "scram-sha-256",
            "--pwfile", "/tmp/password")
        with (data / "pg_hba.conf").open("a") as file:
            file.write("host all all all scram-sha-256\n")
        single = [*as_user, bin / "postgres", "--single", "-D", "/var/lib/postgresql/data"]
        run(*single, "postgres", input=f"CREATE DATABASE {settings['POSTGRES_DB']}\n")
        for script in sorted((root / "docker-entrypoint-initdb.d").iterdir()):
            lines = [line for line in script.read_text().splitlines() if not line.startswith("--")]
            run(*single, settings["POSTGRES_DB"], input="\n".join(lines) + "\n")
        return [str(bin / "postgres"), "-D", "/var/lib/postgresql/data", "-h", "0.0.0.0", "-k", "/tmp"]

    def start(self, hosts, owner):
        self.connect()
        root = self.mount(hosts)
        command = self.command(root)
        user = "postgres:postgres" if self.service["image"].startswith("postgres") else owner if "user" in self.service else "0:0"
        network = [] if self.is_near else ["ip", "netns", "exec", self.name]
        with self.log.open("wb") as log:
            self.process = subprocess.Popen(
                [*network, "chroot", f"--userspec={user}", str(root), *command], stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                env={"PATH": os.environ["PATH"], **environment(self.service, self.folder)}, start_new_session=True)

    def check(self):
        if self.process.poll() is not None:
            fail(f"{self.name} ended with {self.process.returncode}:\n{self.log.read_text()[-3000:]}")

    def stop(self):
        if self.process and self.process.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
        subprocess.run(["umount", "--recursive", "--lazy", self.base / "root"], capture_output=True)


def publish(service):
    """Forwards the published ports of this computer to the service."""
    for text in service.service.get("ports", []):
        host, near, far = text.split(":")
        listener = socket.create_server((host, int(near)))
        threading.Thread(target=forward, args=(listener, (service.address, int(far))), daemon=True).start()


def forward(listener, target):
    def copy(source, sink):
        with contextlib.suppress(OSError):
            while octets := source.recv(65536):
                sink.sendall(octets)
        for end in (source, sink):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)

    while True:
        client, _ = listener.accept()
        try:
            server = socket.create_connection(target, 10)
        except OSError:
            client.close()
            continue
        for ends in ((client, server), (server, client)):
            threading.Thread(target=copy, args=ends, daemon=True).start()


def check_compose(program, folder):
    """The programs accept the files of the composition, and a second call of `prepare` leaves its passwords."""
    shutil.copytree(HERE / "compose", folder, ignore=shutil.ignore_patterns("secrets", "record", ".env", "*.password", "*.credentials"))
    run(folder / "prepare.sh")
    before = (folder / "secrets/nats.env").read_text()
    run(folder / "prepare.sh")
    if (folder / "secrets/nats.env").read_text() != before:
        fail("a second call of prepare changes the passwords")
    run(program, "archive", folder / "archive/archive.toml", "--check")
    run(program, "run", folder / "station/station.toml", "--check")
    checked = folder.parent / "nats.conf"
    checked.write_text((folder / "nats.conf").read_text().replace("/data", str(folder.parent)))
    passwords = dict(line.split("=", 1) for line in before.split())
    run("nats-server", "-t", "-c", checked, env={**os.environ, "NATS_NAME": "nats-1", **passwords})
    print("ok: profivac and nats-server accept the files of the composition")


def compose(program, folder):
    check_compose(program, folder)
    owner = (folder / ".env").read_text().strip().split("=")[1]
    text = yaml.safe_load((folder / "compose.yaml").read_text())
    services = []
    for name, service in text["services"].items():
        for replica in range(service.get("deploy", {}).get("replicas", 1)):
            services.append(Service(f"{name}-{replica}" if replica else name, service, len(services) + 2, program, folder, text["secrets"]))
    # The names of the networks are files. An overlay takes changes on this file system, whatever the computer has.
    for place in (Path("/run/netns"), folder.parent / "services"):
        place.mkdir(exist_ok=True)
        run("mount", "-t", "tmpfs", "tmpfs", place)
    run("ip", "link", "set", "lo", "up")
    run("ip", "link", "add", BRIDGE, "type", "bridge")
    run("ip", "addr", "add", f"{SUBNET}.1/24", "dev", BRIDGE)
    run("ip", "link", "set", BRIDGE, "up")
    hosts = "".join(f"{service.address} {service.name}\n" for service in services if not service.is_near)
    try:
        for service in services:
            service.start(hosts, owner)
            publish(service)
        database = next(service for service in services if service.name == "postgres")
        password = (folder / "archive/postgres.password").read_text()
        wait_for_samples(services, database.address, password)
    finally:
        for service in services:
            service.stop()
        run("umount", "--lazy", folder.parent / "services")
    print("ok: the services of the composition run, and samples of the station are in PostgreSQL")


def wait_for_samples(services, address, password):
    query = "SELECT count(*), count(DISTINCT series) FROM profivac.sample"
    end = time.monotonic() + BOUND
    while True:
        for service in services:
            service.check()
        done = subprocess.run(["psql", "-XAt", "-h", address, "-U", "profivac", "-d", "profivac", "-c", query], capture_output=True, text=True,
                              env={**os.environ, "PGPASSWORD": password})
        if done.returncode == 0 and done.stdout.strip().endswith("|2"):
            print(f"ok: {done.stdout.strip().split('|')[0]} samples of 2 gauges")
            return
        if time.monotonic() > end:
            logs = "".join(f"\n== {service.name}\n{service.log.read_text()[-1500:]}" for service in services)
            fail(f"no samples within {BOUND} s: {done.stdout}{done.stderr}{logs}")
        time.sleep(0.5)


def main(program, only_files=False):
    program = Path(program).resolve()
    resources = list(yaml.safe_load_all((HERE / "kubernetes/archive.yaml").read_text()))
    check_schemas()
    check_references(resources)
    with tempfile.TemporaryDirectory(prefix="profivac-containers-") as name:
        folder = Path(name)
        folder.chmod(0o755)
        check_kubernetes(resources, program, folder / "kubernetes")
        if only_files:
            check_compose(program, folder / "compose")
            return
        compose(program, folder / "compose")


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--files"]
    only_files = len(arguments) < len(sys.argv) - 1
    if len(arguments) != 1 or not (only_files or os.geteuid() == 0):
        print("usage: contrib/archive/containers.py PROGRAM --files; as root: contrib/archive/containers.py PROGRAM", file=sys.stderr)
        sys.exit(2)
    if not only_files and os.environ.get("PROFIVAC_NAMESPACE") != "own":
        # Networks and mounts of the check belong to it alone and vanish with it.
        os.execvpe("unshare", ["unshare", "--net", "--mount", "--pid", "--fork", "--kill-child", sys.executable, *sys.argv],
                   {**os.environ, "PROFIVAC_NAMESPACE": "own"})
    main(arguments[0], only_files)
