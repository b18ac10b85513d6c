#!/usr/bin/env python3
"""Runs the tests of the workspace, several test programs at once: many tests wait for a line at its true speed.

ci/run_tests.py [CARGO ARGUMENT ...] [-- TEST ARGUMENT ...]    for example: ci/run_tests.py -p profivac-cli --test all

Prints the whole output of a program that fails. The last lines name the failed tests, `failed: PROGRAM: TEST`, and count: `N passed, M failed`.
"""

import concurrent.futures
import json
import os
import re
import subprocess
import sys
import time

CPUS = os.cpu_count() or 1
# The tests of these packages answer on a line at its true speed: they begin first, and more of them run at once than there are processors. The
# others compute, so they yield the processors.
REAL_TIME = ["cli", "station", "client", "virtual", "host"]
# So many of the slowest programs are printed with their duration.
SLOWEST = 10
# With one of these arguments cargo runs no examples of the documentation.
TARGETS = {"--lib", "--bin", "--bins", "--test", "--tests", "--bench", "--benches", "--example", "--examples"}


def built(arguments, for_tests):
    """Builds the test programs. Returns the command and the folder of each, those of one package together."""
    command = ["nice", "cargo", "test", "--no-run", "--message-format=json-render-diagnostics", *arguments]
    build = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if build.returncode != 0:
        return None
    programs = []
    for line in build.stdout.splitlines():
        message = json.loads(line)
        if message["reason"] == "compiler-artifact" and message["profile"]["test"] and message["executable"]:
            programs.append(([message["executable"], *for_tests], os.path.dirname(message["manifest_path"])))
    order = {package: place for place, package in enumerate(REAL_TIME)}
    return sorted(programs, key=lambda program: (order.get(os.path.basename(program[1]), len(order)), program[1]))


def run(program):
    """Runs one program as cargo does: in the folder of its package."""
    command, folder = program
    begun = time.monotonic()
    waits = os.path.basename(folder) in REAL_TIME
    environment = {"RUST_TEST_THREADS": str(2 * CPUS if waits else CPUS), **os.environ}
    done = subprocess.run([*([] if waits else ["nice"]), *command], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    return program, done.returncode, done.stdout, time.monotonic() - begun


def causes(output):
    """The failed tests in the output of a program, each with the first line of its panic."""
    panics = dict(re.findall(r"^thread '([^']+)' .*panicked at .+\n(.*)", output, re.MULTILINE))
    tests = re.findall(r"^test (\S+)(?: - .+)? \.\.\. FAILED$", output, re.MULTILINE)
    return [f"{test}: {panics.get(test, 'no panic')}" for test in tests]


def name(program):
    """The package and the name of a program: `cli scan` for `deps/scan-0123456789abcdef`."""
    (executable, *_), folder = program
    if executable == "cargo":
        return "pages of the documentation and their examples"
    return f"{os.path.basename(folder)} {re.sub('-[0-9a-f]{16}$', '', os.path.basename(executable))}"


def documentation_tests(arguments):
    """The command that builds the pages of the documentation and runs their examples.

    Only their names contain `(line`, so the test programs run none of their tests. It is the same build as that of the test programs.
    """
    os.environ["RUSTDOC"] = os.path.join(os.path.dirname(os.path.abspath(__file__)), "rustdoc.sh")
    return ["cargo", "test", "--quiet", "--no-fail-fast", *arguments, "--", "(line"], os.getcwd()


def main():
    divider = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    arguments, for_tests = sys.argv[1:divider], sys.argv[divider + 1:]
    programs = built(arguments, for_tests)
    if programs is None:
        sys.exit("\nfailed: the test programs are not built\n0 passed, 1 failed")
    if not for_tests and not TARGETS.intersection(arguments):
        programs.insert(0, documentation_tests(arguments))
    passed, failed, durations, failures = 0, 0, [], []
    with concurrent.futures.ThreadPoolExecutor(CPUS) as pool:
        for done in concurrent.futures.as_completed([pool.submit(run, program) for program in programs]):
            program, code, output, seconds = done.result()
            results = re.findall(r"^test result: \w+\. (\d+) passed; (\d+) failed", output, re.MULTILINE)
            bad = sum(int(result[1]) for result in results)
            passed, failed = passed + sum(int(result[0]) for result in results), failed + bad
            if code != 0:
                # A program that ends without a failing test has failed too.
                failed += bad == 0
                print(f"{name(program)}: exit code {code}\n{output}", flush=True)
                failures += [f"failed: {name(program)}: {failure}" for failure in causes(output) or [f"exit code {code}"]]
            durations.append((seconds, name(program)))
    for seconds, program in sorted(durations, reverse=True)[:SLOWEST]:
        print(f"{program}: {seconds:.0f} s")
    for failure in failures:
        print(failure)
    print(f"{passed} passed, {failed} failed")
    sys.exit(1 if failed else 0)


main()
