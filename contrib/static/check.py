#!/usr/bin/env python3
"""Proves that a program runs in a root folder with an empty folder tmp and nothing else: contrib/static/check.py PROGRAM [EMULATOR]

EMULATOR is the path of a static emulator in that folder, for instance /qemu-aarch64-static; it is copied there. Needs root.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

# The longest time of a command in seconds; only bounds a hang.
LIMIT_S = 600


def main(program, emulator=None):
    with tempfile.TemporaryDirectory(prefix="profivac-root-") as name:
        root = Path(name)
        os.chmod(root, 0o755)
        # Virtual plants in memory write their segments there.
        (root / "tmp").mkdir()
        shutil.copy(program, root / "profivac")
        prefix = []
        if emulator:
            shutil.copy(shutil.which(Path(emulator).name), root / Path(emulator).name)
            prefix = [emulator]
        before = sorted(path.name for path in root.iterdir())
        print(f"the root folder has {', '.join(before)}")

        def run(*arguments):
            command = [shutil.which("chroot"), name, *prefix, "/profivac", *arguments]
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=LIMIT_S, env={})
            if done.returncode != 0:
                sys.exit(f"FAILED: profivac {' '.join(arguments)} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
            print(f"ok: profivac {' '.join(arguments)}")
            return done.stdout

        def expect(condition, text):
            if not condition:
                sys.exit(f"FAILED: {text}")

        expect(run("--version").startswith("profivac "), "the version is not printed")
        expect("BCG450" in run("gsd", "bcg450"), "the GSD file has no BCG450")
        rows = [json.loads(line) for line in run("demo", "--headless", "--json", "--for", "3", "--record", "/demo.db").splitlines()]
        expect(rows, "the demonstration has no row")
        expect((root / "demo.db").read_bytes()[:15] == b"SQLite format 3", "the record is no database")
        expect("bcg450" in run("export", "/demo.db"), "the record has no sample")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        print("usage: contrib/static/check.py PROGRAM [EMULATOR]", file=sys.stderr)
        sys.exit(2)
    main(*sys.argv[1:])
