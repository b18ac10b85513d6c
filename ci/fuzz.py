#!/usr/bin/env python3
"""Runs the targets of fuzz/ under libFuzzer.

    ci/fuzz.py [TARGET] [SECONDS]   fuzzes one target, or with 'all' each, for SECONDS (60 unless given), and counts its executions
    ci/fuzz.py minimise [TARGET]    puts the inputs with coverage of their own into fuzz/corpus, as many as fit
    ci/fuzz.py list                 lists the targets

Needs a C++ compiler. Builds the targets with the installed rustc below target/libfuzzer. Works on the corpora below target/fuzz, which begin with
those of fuzz/corpus. Adds the executions to the table in docs/fuzzing.md. Ends with 1 if a target panics, hangs or takes too much
memory; the input is then in target/fuzz/finds. Each target runs as one process with a low priority.
"""

import os
import re
import struct
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TRIPLE = "x86_64-unknown-linux-gnu"
BUILD = ROOT / "target/libfuzzer"
WORK = ROOT / "target/fuzz"
CORPUS = ROOT / "fuzz/corpus"
FINDS = ROOT / "fuzz/finds"
RECORD = ROOT / "docs/fuzzing.md"

# Name of the target, the most octets of its inputs, and the feature of fuzz/libfuzzer that it needs.
TARGETS = {
    "api": (512, "station"),
    "batch": (2048, "recorder"),
    "capture": (2048, ""),
    "channel_access": (1024, "station"),
    "decode_file": (2048, ""),
    "decode_line": (1024, ""),
    "decode_text": (2048, ""),
    "device_file": (8192, ""),
    "device_spec": (128, ""),
    "gsd": (2048, ""),
    "master": (1024, ""),
    "modbus": (512, "station"),
    "opcua": (1024, "opcua"),
    "plant": (2048, "station"),
    "prometheus": (512, "station"),
    "pv_access": (1024, "station"),
    "receiver": (1024, ""),
    "ring": (512, ""),
    "scenario": (2048, ""),
    "segment": (1024, ""),
    "server": (512, "station"),
    "settings": (1024, ""),
    "slave": (1024, ""),
    "sparkplug": (1024, "station"),
    "trace": (2048, ""),
    "users": (1024, "station"),
}

# The counters of each edge, and the operands of comparisons, which libFuzzer uses to choose inputs.
FLAGS = [
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
    "--cfg fuzzing",
]

# The most octets of a corpus in the repository.
MOST_OCTETS = 100_000


def build(targets):
    """Builds the programs of the targets."""
    environment = dict(os.environ, RUSTC_BOOTSTRAP="1", RUSTFLAGS=" ".join(FLAGS), CARGO_TARGET_DIR=str(BUILD))
    manifest = ROOT / "fuzz/libfuzzer/Cargo.toml"
    command = ["cargo", "build", "--quiet", "--locked", "--release", "--target", TRIPLE, "--manifest-path", manifest]
    command += ["--features", ",".join({TARGETS[target][1] for target in targets} - {""})]
    for target in targets:
        command += ["--bin", target]
    subprocess.run(command, env=environment, check=True)


def program(target):
    """The program of a target."""
    return BUILD / TRIPLE / "release" / target


def unpack(target):
    """The folder with the corpus of a target; at the first use it has the inputs of the repository."""
    folder = WORK / target
    folder.mkdir(parents=True, exist_ok=True)
    packed = CORPUS / f"{target}.bin"
    octets = packed.read_bytes() if packed.exists() else b""
    at = 0
    while at < len(octets):
        (length,) = struct.unpack_from("<I", octets, at)
        (folder / f"packed-{at}").write_bytes(octets[at + 4 : at + 4 + length])
        at += 4 + length
    for find in (FINDS / target).glob("*"):
        (folder / find.name).write_bytes(find.read_bytes())
    return folder


def run(target, *options):
    """Runs the program of a target; returns its exit code and its messages."""
    artifacts = WORK / "finds"
    artifacts.mkdir(parents=True, exist_ok=True)
    limits = [f"-max_len={TARGETS[target][0]}", "-timeout=30", f"-artifact_prefix={artifacts}/{target}-"]
    command = [program(target), *limits, *options]
    done = subprocess.run(command, capture_output=True, preexec_fn=lambda: os.nice(15))
    return done.returncode, done.stderr.decode(errors="replace")


def count(target, executions):
    """Adds executions to the row of a target and to the sum."""
    lines = RECORD.read_text().splitlines(keepends=True)
    row = re.compile(r"^(\| (?:`%s`|Sum) \|.*\| )([0-9 ]+)( \|)$" % target)
    for place, line in enumerate(lines):
        if found := row.match(line.rstrip("\n")):
            total = int(found[2].replace(" ", "")) + executions
            lines[place] = found[1] + f"{total:,}".replace(",", " ") + found[3] + "\n"
        # Another table below has executions of the same targets.
        if line.startswith("| Sum |"):
            break
    RECORD.write_text("".join(lines))


def fuzz(target, seconds):
    """Fuzzes a target; returns whether it did nothing wrong."""
    folder = unpack(target)
    code, messages = run(target, f"-max_total_time={seconds}", "-print_final_stats=1", folder)
    found = re.search(r"stat::number_of_executed_units: +(\d+)", messages)
    executions = int(found[1]) if found else 0
    count(target, executions)
    inputs = sum(1 for _ in folder.iterdir())
    print(f"{target}: {executions} executions, {inputs} inputs" + (", FAILED" if code else ""), flush=True)
    if code:
        print(messages[-4000:], file=sys.stderr)
    return code == 0


def minimise(target):
    """Packs the inputs that have coverage of their own, the shortest first, into the corpus of the repository."""
    folder, least = unpack(target), WORK / f"{target}.least"
    least.mkdir(exist_ok=True)
    for old in least.iterdir():
        old.unlink()
    code, messages = run(target, "-merge=1", least, folder)
    if code:
        print(messages[-4000:], file=sys.stderr)
        return False
    packed, inputs = b"", sorted((path.read_bytes() for path in least.iterdir()), key=lambda it: (len(it), it))
    kept = 0
    for octets in inputs:
        if len(packed) + 4 + len(octets) > MOST_OCTETS:
            break
        packed += struct.pack("<I", len(octets)) + octets
        kept += 1
    CORPUS.mkdir(parents=True, exist_ok=True)
    (CORPUS / f"{target}.bin").write_bytes(packed)
    print(f"{target}: {kept} of {len(inputs)} inputs, {len(packed)} octets", flush=True)
    return True


def main(arguments):
    """Returns the exit code."""
    if arguments == ["list"]:
        print("\n".join(TARGETS))
        return 0
    is_minimising = arguments[:1] == ["minimise"]
    rest = arguments[1:] if is_minimising else arguments
    name = rest[0] if rest else "all"
    seconds = rest[1] if len(rest) > 1 else "60"
    most = 1 if is_minimising else 2
    if (name != "all" and name not in TARGETS) or not seconds.isdecimal() or len(rest) > most:
        print(__doc__, file=sys.stderr)
        return 2
    names = list(TARGETS) if name == "all" else [name]
    build(names)
    results = [minimise(name) if is_minimising else fuzz(name, seconds) for name in names]
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
