#!/usr/bin/env bash
# Builds the wheel of the Python package without a warning of the compiler or of clippy, installs it into a fresh environment, and checks it
# there: tests, doctests, types, stubs, the types of the examples in the README, the pages, the notebooks and the docstrings.
#   ci/python_package.sh PROGRAM     PROGRAM is the program profivac, which simulates gauges on ptys and TCP ports
# The wheel has the dev profile (optimisation level 1, no debug information): it compiles in a quarter of the time of a release.
set -euo pipefail
program=$(realpath "$1")
cd "$(dirname "${BASH_SOURCE[0]}")/../python"

mkdir -p target/work
if ! cmp -s requirements-test.txt target/tools/installed.txt; then
    python3 -m venv --clear target/tools
    target/tools/bin/python -m pip install --quiet --disable-pip-version-check --requirement requirements-test.txt
    cp requirements-test.txt target/tools/installed.txt
fi
rm -rf target/wheels
# Through clippy, as the workspace: a pass of its own would check every dependency again.
RUSTC_WORKSPACE_WRAPPER=clippy-driver RUSTFLAGS=-Dwarnings nice target/tools/bin/maturin build --quiet --locked --profile dev --out target/wheels

# What a new user does: a fresh environment, the wheel, the example of the README. Nothing else is in this environment, so the wheel needs
# no compiler and no other package.
first_steps() {
    python3 -m venv --clear target/fresh &&
        target/fresh/bin/python -m pip install --quiet --disable-pip-version-check --no-index target/wheels/*.whl &&
        awk '/^```python/ { inside = 1; next } /^```/ && inside { exit } inside' README.md >target/work/readme.py &&
        (cd target/work && ../fresh/bin/python readme.py)
}
TIMEFORMAT='%R %U %S'
{ time first_steps >target/work/first_steps.log 2>&1; } 2>target/work/first_steps.time || { cat target/work/first_steps.log; exit 1; }
read -r real user system <target/work/first_steps.time
echo "a fresh environment, the wheel and the example of the README: $real s, of them $user s and $system s of computing time"
# A minute on an idle computer; a loaded one takes longer for the same computing time.
awk "BEGIN { exit !($user + $system < 60) }" || { echo 'expected less than a minute'; exit 1; }

# The tools come from the other environment, the package from this one.
site=$(target/fresh/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
tools=$(target/tools/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
echo "$tools" >"$site/tools.pth"
python=$PWD/target/fresh/bin/python
cd target/work
# The tests mostly wait for lines, so the parts run at the same time.
parts=()
part() {
    "$python" -m "$@" >"part_${#parts[@]}.log" 2>&1 &
    parts+=($!)
}
export PROFIVAC=$program
for file in ../../tests/test_*.py; do part pytest -q -c ../../pyproject.toml --rootdir=../.. -p no:cacheprovider "$file"; done
part pytest -q --doctest-modules -p no:cacheprovider --pyargs profivac
"$python" ../../../ci/python_examples.py examples
part mypy --strict --config-file ../../pyproject.toml ../../profivac ../../tests ../../bench ../../../ci/python_examples.py examples
part mypy.stubtest profivac._profivac
status=0
for index in "${!parts[@]}"; do
    wait "${parts[index]}" || status=1
    cat "part_$index.log"
done
exit "$status"
