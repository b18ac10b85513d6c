#!/usr/bin/env bash
# Prints the line coverage of each crate by the tests of the workspace: ./test coverage; or by those of some crates:
# ./test coverage -p profivac-wire
# Uses the LLVM tools of the Rust toolchain; rustup installs them. Builds into target/coverage, apart from other builds. The last line is
# the whole workspace. target/coverage/report.txt has the coverage of each file.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# shellcheck source=ci/need.sh
. ci/need.sh
need_to_build

tools=$(rustc --print target-libdir)/../bin
if ! [ -x "$tools/llvm-cov" ]; then rustup component add llvm-tools; fi

folder=$PWD/target/coverage
profiles=$folder/profiles
if [ $# -eq 0 ]; then set -- --workspace; fi
rm -rf "$profiles"
mkdir -p "$profiles"

# Programs that the tests start write profiles, too: %p is the process, %m the binary.
export CARGO_TARGET_DIR=$folder RUSTFLAGS='-C instrument-coverage' LLVM_PROFILE_FILE="$profiles/%p-%m.profraw"

# Instrumented code is slow, so a test may exceed its deadline: a failing test does not end the measurement. ./test decides about tests.
cargo test "$@" --lib --bins --tests --no-fail-fast || echo 'some tests failed; the coverage contains them' >&2

"$tools/llvm-profdata" merge --sparse "$profiles"/*.profraw --output "$folder/all.profdata"

# One --object for each executable that cargo test built.
objects=()
while read -r executable; do objects+=(--object "$executable"); done < <(
    cargo test "$@" --lib --bins --tests --no-run --message-format=json 2>/dev/null |
        sed -n 's/.*"executable":"\([^"]*\)".*/\1/p' | sort -u
)

ignored='/(registry|rustc|tests|benches|examples|xtask|bench|fuzz)/'
"$tools/llvm-cov" report "${objects[@]}" --instr-profile "$folder/all.profdata" --ignore-filename-regex "$ignored" \
    --use-color=0 >"$folder/report.txt"

# In the LCOV format SF is the file, LF the number of its lines, LH the number of those that ran.
"$tools/llvm-cov" export "${objects[@]}" --instr-profile "$folder/all.profdata" --ignore-filename-regex "$ignored" \
    --format=lcov --summary-only | awk -F: '
    function row(name, lines, covered) {
        return sprintf("%-12s %8d %8d %7.1f%%", name, lines, lines - covered, lines ? 100 * covered / lines : 0)
    }
    BEGIN { printf "\n%-12s %8s %8s %8s\n", "CRATE", "LINES", "MISSED", "COVERED"; fflush() }
    $1 == "SF" { crate = $2; sub(/^.*\/crates\//, "", crate); sub(/\/.*/, "", crate) }
    $1 == "LF" { lines[crate] += $2; all += $2 }
    $1 == "LH" { covered[crate] += $2; ran += $2 }
    END {
        for (crate in lines) print row(crate, lines[crate], covered[crate]) | "sort"
        close("sort")
        print row("all", all, ran)
    }
'
