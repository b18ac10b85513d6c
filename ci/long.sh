#!/usr/bin/env bash
# The longest proofs, which `./test long` runs: each is a longer run of a test of `./test`, or one that it leaves out.
#   ci/long.sh [NAME...]    all of them, or these
#   ci/long.sh mutants ...  the mutants of some crates or of a change: ci/mutants.py --help
#   ci/long.sh --list       their names, and how many seconds each took on this computer when it ran last
# Prints the output of each proof while it runs, a line in each minute, and its duration; the last line counts passed and failed proofs.
# Writes into the table of docs/conformance.md when a proof has passed at its full length.
# PROFIVAC_LONG=0.1 makes every proof whose length can be chosen a tenth as long.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=ci/need.sh
. ci/need.sh

# Name, and what it proves. docs/conformance.md has the same names.
proofs=(
    'octets   | a slave answers only what it must among 10^9 random octets and 10^7 services of three masters'
    'model    | a slave of each kind answers as a model of the specification does, in 100 times as many conversations as in ./test'
    'receiver | the receiver divides 100 times as many changed streams as in ./test'
    'notations | no octet of 10 000 random streams becomes another one in 62 notations of programs'
    'firmware | a gauge in QEMU survives 10^7 random octets and a power cut at every flash operation of a write'
    'ring     | two and three masters form a ring again after every sequence of four faults'
    'power    | every disk that a power cut can leave keeps what a gauge, the file of users and the record have acknowledged'
    'sessions | 100 000 conversations with hostile slaves end'
    'plants   | the fit finds the parameters of 200 simulated plants of each kind'
    'listener | a listener needs bounded memory and stays right: a day and two hours of bus time, 100 million hostile octets'
    'rust     | the libraries build with the oldest Rust that their manifests name'
    'fuzz     | libFuzzer, two minutes for each target'
    'serial   | 100 scans and 100 reads at 9600 and 19200 bit/s on a 16550A, each with one try'
    'stalled  | clients of all gateways that stall for ten minutes'
    'soak     | a station with everything enabled keeps its limits for a day of bus time: 24 segments for an hour'
    'cases    | an archive survives a week without a network, full disks, stopped servers, lost databases, two stations of one name and a hostile station'
    'rates    | an archive stores 50 000 samples a second of 1 000 stations, and draws a year of ten gauges in half a second, beside NATS and PostgreSQL'
    'kills    | 200 kills of stations, archives, servers of NATS and PostgreSQL lose no sample, with NATS and without'
    'containers | the examples for Compose and Kubernetes are valid, and the services of the composition run'
    'windows  | the program for Windows runs under Wine: commands, dashboard, a station that is killed'
    'mutants  | the tests of each crate notice as many changed lines as ci/mutants.toml says: days; also mutants CRATE ... and --changed REVISION'
    'pictures | every picture of the pages is taken from the running programs, with the names and widths of those in docs/pictures'
    'book     | the book of all pages and the documentation of all crates are built, and each link leads to a page and a heading'
)

# The last duration of each proof that passed at its full length.
durations=target/long

usage() {
    printf 'usage: ci/long.sh [--list | NAME...]\nnames: '
    printf '%s\n' "${proofs[@]%%|*}" | tr -s ' \n' ' '
    printf '\n'
} >&2

# times NUMBER: the number, multiplied by PROFIVAC_LONG; at least 1.
times() {
    awk -v number="$1" -v factor="${PROFIVAC_LONG:-1}" 'BEGIN { chosen = int(number * factor); print (chosen < 1 ? 1 : chosen) }'
}

python_environment() {
    local wanted=ci/requirements.txt
    if cmp -s "$wanted" target/venv/installed.txt; then return; fi
    need_python
    python3 -m venv --clear target/venv
    target/venv/bin/pip install --quiet --disable-pip-version-check --requirement "$wanted"
    cp "$wanted" target/venv/installed.txt
}

# The program, optimised, with the archive and every gateway.
program=target/release/profivac
program() {
    cargo build --quiet --release --package profivac-cli --features opcua,archive
}

# Chromium and what drives it.
browser() {
    need chromium-headless-shell chromium-headless-shell --version
    if [ ! -d crates/station/web/e2e/node_modules ]; then (cd crates/station/web/e2e && npm ci --silent --no-audit --no-fund); fi
}

# The program that reads the logs of firmware. Building it takes longer than the check of the log.
log_reader() {
    local version=1.2.0
    if target/tools/bin/defmt-print --version 2>/dev/null | grep -qx "defmt-print $version"; then return; fi
    CARGO_PROFILE_DEV_DEBUG=none cargo install --quiet --locked --debug --root target/tools "defmt-print@$version"
}

# The programs that lose power.
power_cut() {
    cargo build --quiet --package profivac-cli && cargo build --quiet --package profivac-recorder --example acknowledged
}

# release PACKAGE ARGUMENT...: tests of one package, optimised, that print while they run.
release() {
    cargo test --quiet --release --package "$1" "${@:2}" -- --nocapture
}

proof_octets() { PROFIVAC_FUZZ=$(times 100) release profivac-dp --test all fuzz::; }
proof_model() { PROFIVAC_FUZZ=$(times 100) release profivac-devices --test all slave_model::; }
proof_notations() { PROFIVAC_CASES=$(times 10000) release profivac-explain --test all random_streams; }
proof_receiver() { PROFIVAC_FUZZ=$(times 100) release profivac-dp --test all receiver::; }
# Steps of ./test build the programs and fetch the tools; here only what is missing is built.
proof_firmware() {
    need qemu-system-arm qemu-system-arm --version
    need binutils size --version
    python_environment && program && log_reader && cargo build --quiet --package profivac-sim --example profirust_master &&
        firmware/check.py "$program" --long --python target/venv/bin/python --profirust target/debug/examples/profirust_master \
            --defmt-print target/tools/bin/defmt-print
}
proof_ring() { PROFIVAC_RING_DEPTH=4 release profivac-dp --test ring_exploration; }
proof_power() { need strace strace -V && power_cut && ci/power_cut/run.py target/debug/profivac target/debug/examples/acknowledged --random 10; }
proof_sessions() { PROFIVAC_CASES=$(times 100000) release profivac-host --lib hostile; }
proof_plants() { PROFIVAC_PLANTS=$(times 200) release profivac-identify --test all fresh::; }
proof_listener() { cargo test --quiet --release --package profivac-listen -- --ignored --nocapture --test-threads=1; }
# Clippy, a part of ./test, already refuses what the standard library of that Rust lacks; three toolchains and their builds find the rest.
proof_rust() { ci/oldest_rust.sh; }
proof_fuzz() { need g++ c++ --version && ci/fuzz.py all "$(times 120)"; }
proof_soak() {
    need mosquitto test -x /usr/sbin/mosquitto
    python_environment && program && target/venv/bin/python ci/gateways/soak.py "$program" "$(times 60)" 24
}
proof_cases() {
    need_servers && program && cargo build --quiet --release --package profivac-recorder --example backlog &&
        contrib/archive/cases.py "$program" --days "$(times 7)"
}
proof_rates() {
    need_servers && program && cargo build --quiet --release --package profivac-archive --example load || return
    local load=(contrib/archive/load.py "$program" target/release/examples/load --at-least 50000)
    "${load[@]}" --seconds "$(times 300)" --samples 2 && "${load[@]}" --stations 1 --seconds "$(times 604800)" &&
        "${load[@]}" --stations 200 --seconds 250 --samples 2 --archives 1 --waiting --ratio 0.4 &&
        browser && contrib/archive/year.py "$program" --at-most 0.5
}
proof_kills() {
    need_servers && program && contrib/archive/example.py "$program" --kills "$(times 200)" &&
        contrib/archive/example.py "$program" --servers 0 --kills "$(times 200)"
}
proof_containers() {
    need iproute2 ip -V
    python_environment && need_servers && program && target/venv/bin/python contrib/archive/containers.py "$program"
}

# ./test only checks that the program compiles for Windows: building and running it there takes ten minutes.
proof_windows() {
    need gcc-mingw-w64-x86-64 x86_64-w64-mingw32-gcc --version
    need wine64 wine --version
    rustup target add x86_64-pc-windows-gnu && program &&
        CARGO_PROFILE_DEV_DEBUG=none cargo build --quiet --package profivac-cli --features opcua,archive --target x86_64-pc-windows-gnu &&
        ci/windows/wine.py target/x86_64-pc-windows-gnu/debug/profivac.exe "$program"
}
proof_mutants() { ci/mutants.py; }
proof_pictures() { need_servers && ci/pictures.sh; }
proof_book() { need_to_build && ci/book.py && RUSTDOCFLAGS=-Dwarnings cargo doc --quiet --workspace --no-deps; }

proof_stalled() {
    python_environment && program && target/venv/bin/python ci/gateways/stall.py "$program" "$(times 600)"
}

proof_serial() {
    need qemu-system-x86 qemu-system-x86_64 --version
    need busybox-static busybox true
    need cpio cpio --version
    program && ci/serial_vm/run.py "$program" --long
}

# note NAME SECONDS: writes into the table of docs/conformance.md when a proof has passed at its full length, and with which revision.
note() {
    local run
    run="$(date +%F), $(git rev-parse --short=8 HEAD)"
    if ! git diff --quiet HEAD -- . ':!docs'; then run+=' with changes'; fi
    sed -i -E "/^\\| \`$1\` \\|/ s/\\| [^|]* \\|\$/| $run, $2 s |/" docs/conformance.md
}

# Says in each minute that a proof still runs.
watch() {
    local minutes=0
    while sleep 60 >/dev/null 2>&1; do minutes=$((minutes + 1)) && echo "-- $1: has been running for $minutes min"; done
}

if [ "${1:-}" = mutants ] && [ $# -gt 1 ]; then
    need gcc cc --version
    exec ci/mutants.py "${@:2}"
fi
names=()
for line in "${proofs[@]}"; do read -r name _ <<<"$line" && names+=("$name"); done
if [ "$*" = --list ]; then
    for line in "${proofs[@]}"; do
        took=$(cat "$durations/${line%% *}" 2>/dev/null || echo -)
        printf '%s | %s\n' "$line" "$took"
    done
    exit
fi
chosen=("$@")
if [ $# -eq 0 ]; then chosen=("${names[@]}"); fi
for name in "${chosen[@]}"; do
    case " ${names[*]} " in
    *" $name "*) ;;
    *) usage && exit 2 ;;
    esac
done

need gcc cc --version
mkdir -p "$durations"
watch=
trap 'if [ -n "$watch" ]; then kill "$watch" 2>/dev/null || true; fi' EXIT
passed=0
failed=()
for index in "${!chosen[@]}"; do
    name=${chosen[index]} start=$SECONDS outcome=ok
    for line in "${proofs[@]}"; do
        case $line in "$name "*) printf '\n== %d of %d: %s\n' $((index + 1)) ${#chosen[@]} "$line" ;; esac
    done
    watch "$name" &
    watch=$!
    if ("proof_$name"); then passed=$((passed + 1)); else outcome=FAILED failed+=("$name"); fi
    kill "$watch" 2>/dev/null || true
    if [ "$outcome" = ok ] && [ -z "${PROFIVAC_LONG:-}" ]; then
        echo $((SECONDS - start)) >"$durations/$name"
        note "$name" $((SECONDS - start))
    fi
    printf -- '-- %s: %s after %d s\n' "$name" "$outcome" $((SECONDS - start))
done
printf '\n%d passed, %d failed%s\n' "$passed" "${#failed[@]}" "${failed[*]:+: ${failed[*]}}"
[ "${#failed[@]}" -eq 0 ]
