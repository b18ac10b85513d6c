#!/usr/bin/env python3
"""Counts the mutants that the tests of each crate notice, and prints those that they do not.

    ./test long mutants                      all crates that ci/mutants.toml names: days
    ./test long mutants wire recorder        these crates
    ./test long mutants wire --every 10      each tenth mutant of them
    ./test long mutants --changed REVISION   the mutants of the lines that changed since this revision

A mutant is the code with one change that cargo-mutants makes: another operator, another result, a match without an arm. The tests of its
crate run on it; where none fails, they would not have noticed this fault. The exit code is 1 if a crate is below its goal in
ci/mutants.toml. With --changed each mutant that nobody notices is a fault.
"""

import argparse
import dataclasses
import json
import os
import pathlib
import re
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUTPUT = ROOT / "target" / "mutants"
TOOLS = ROOT / "target" / "tools"
SETTINGS = tomllib.loads((ROOT / "ci" / "mutants.toml").read_text())

# At most one mutant in this many may be one that no test can notice.
MOST_EQUAL = 50


@dataclasses.dataclass
class Counts:
    """The outcomes of the mutants of a crate."""

    noticed: int = 0
    unnoticed: list[str] = dataclasses.field(default_factory=list)
    equal: int = 0
    unviable: int = 0

    def judged(self) -> int:
        """The mutants that compile and behave differently."""
        return self.noticed + len(self.unnoticed)

    def share(self) -> float:
        return self.noticed / self.judged() if self.judged() else 1.0

    def is_enough(self, goal: float) -> bool:
        return self.share() >= goal and self.equal * MOST_EQUAL <= max(self.judged(), MOST_EQUAL)


def crates() -> dict[str, str]:
    """Name and package of each crate."""
    command = ["cargo", "metadata", "--locked", "--no-deps", "--format-version", "1"]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout)
    folders = {pathlib.Path(package["manifest_path"]).parent.name: package["name"] for package in metadata["packages"]}
    return {name: package for name, package in folders.items() if (ROOT / "crates" / name).is_dir()}


def tool() -> dict[str, str]:
    """Builds cargo-mutants where this version is missing. Returns the environment in which cargo finds it."""
    environment = os.environ | {"PATH": f"{TOOLS / 'bin'}{os.pathsep}{os.environ['PATH']}"}
    version = SETTINGS["version"]
    try:
        found = subprocess.run(["cargo-mutants", "mutants", "--version"], env=environment, stdout=subprocess.PIPE, text=True)
        if found.stdout.split() == ["cargo-mutants", version]:
            return environment
    except FileNotFoundError:
        pass
    print(f"installing cargo-mutants {version} ...", flush=True)
    install = ["cargo", "install", "--quiet", "--locked", "--root", str(TOOLS), f"cargo-mutants@{version}"]
    subprocess.run(install, cwd=ROOT, check=True)
    return environment


def run(arguments: list[str], folder: pathlib.Path, environment: dict[str, str]) -> list[dict]:
    """Runs cargo-mutants and returns its outcomes. Exit code 2 means unnoticed mutants, 3 a time-out: the table tells."""
    folder.mkdir(parents=True, exist_ok=True)
    command = ["cargo", "mutants", "--colors", "never", "--no-times", "--output", str(folder), *arguments]
    for exclude in SETTINGS["exclude"]:
        command += ["--exclude-re", exclude["pattern"]]
    code = subprocess.run(command, cwd=ROOT, env=environment).returncode
    if code not in (0, 2, 3):
        sys.exit(f"cargo mutants ended with exit code {code}; its logs are in {folder}")
    outcomes = folder / "mutants.out" / "outcomes.json"
    return json.loads(outcomes.read_text())["outcomes"] if outcomes.exists() else []


def is_equal(crate: str, name: str) -> bool:
    """Whether the settings list a mutant as one that behaves like the code. Its place may move."""
    described = re.sub(r"^[^ ]*: ", "", name)
    return any(entry["crate"] == crate and entry["mutant"] == described for entry in SETTINGS.get("equal", []))


def count(outcomes: list[dict], names: dict[str, str]) -> dict[str, Counts]:
    """The counts of each crate. A mutant whose tests do not end is noticed: a test that hangs ends a run."""
    counts: dict[str, Counts] = {}
    for outcome in outcomes:
        mutant = outcome["scenario"].get("Mutant") if isinstance(outcome["scenario"], dict) else None
        if mutant is None:
            continue
        crate = names[mutant["package"]]
        of_crate = counts.setdefault(crate, Counts())
        match outcome["summary"]:
            case "CaughtMutant" | "Timeout":
                of_crate.noticed += 1
            case "MissedMutant" if is_equal(crate, mutant["name"]):
                of_crate.equal += 1
            case "MissedMutant":
                of_crate.unnoticed.append(mutant["name"])
            case _:
                of_crate.unviable += 1
    return counts


def report(counts: dict[str, Counts], goals: dict[str, float]) -> bool:
    """Prints the table and the unnoticed mutants. Returns whether every crate reaches its goal."""
    for of_crate in counts.values():
        for name in of_crate.unnoticed:
            print(f"unnoticed: {name}")
    print(f"\n{'CRATE':<20} {'NOTICED':>8} {'UNNOTICED':>10} {'EQUAL':>6} {'UNVIABLE':>9} {'SHARE':>7} {'GOAL':>6}")
    reached = True
    for crate, of_crate in sorted(counts.items()):
        goal = goals.get(crate, 0.0)
        is_enough = of_crate.is_enough(goal)
        reached &= is_enough
        row = f"{crate:<20} {of_crate.noticed:>8} {len(of_crate.unnoticed):>10} {of_crate.equal:>6} {of_crate.unviable:>9}"
        print(f"{row} {of_crate.share():>7.1%} {goal:>6.0%}{'' if is_enough else '  below'}")
    return reached


def main() -> None:
    parser = argparse.ArgumentParser(prog="./test long mutants", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("crates", nargs="*", metavar="CRATE", help="a folder of crates/; without one, all that have a goal")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="judge each Nth mutant only")
    parser.add_argument("--changed", metavar="REVISION", help="judge the mutants of the lines that changed since this revision")
    options = parser.parse_args()
    packages = crates()
    names = {package: name for name, package in packages.items()}
    for crate in options.crates:
        if crate not in packages:
            parser.error(f"expected a crate, one of {', '.join(sorted(packages))}; got {crate!r}")
    if options.every < 1:
        parser.error(f"expected a number from 1 on behind --every, got {options.every}")
    shard = ["--shard", f"0/{options.every}"] if options.every > 1 else []
    environment = tool()
    counts: dict[str, Counts] = {}
    if options.changed:
        OUTPUT.mkdir(parents=True, exist_ok=True)
        lines = OUTPUT / "changed.diff"
        difference = subprocess.run(["git", "diff", options.changed, "--", "crates"], cwd=ROOT, stdout=subprocess.PIPE)
        if difference.returncode != 0:
            sys.exit(2)
        lines.write_bytes(difference.stdout)
        counts = count(run([*shard, "--in-diff", str(lines)], OUTPUT / "changed", environment), names)
        goals = dict.fromkeys(counts, 1.0)
    else:
        goals = SETTINGS["goals"]
        for crate in options.crates or goals:
            print(f"\n== mutants of {crate}", flush=True)
            counts |= count(run([*shard, "--package", packages[crate]], OUTPUT / crate, environment), names)
    sys.exit(0 if report(counts, goals) else 1)


if __name__ == "__main__":
    main()
