#!/usr/bin/env bash
# Takes the pictures of docs/report.md, in three minutes: docs/pictures/report.sh [FOLDER]
# The demonstration is recorded, a station's file says what its gauges are, and Chromium shows the page.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
pictures=${1:-docs/pictures}

cargo build --quiet -p profivac-cli
profivac=${CARGO_TARGET_DIR:-target}/debug/profivac
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$profivac" demo --headless --record "$folder/plant.db" --for 182 >"$folder/rows.txt"
cat >"$folder/plant.toml" <<'STATION'
[station]
name = "Demonstration plant"
database = "plant.db"
[[segment]]
name = "demo"
port = "sim:plant"
[[segment.gauge]]
name = "bcg450 5"
address = 5
device = "bcg450"
levels = { "ready for coating" = "5e-5 mbar" }
[[segment.gauge]]
name = "bpg400 6"
address = 6
device = "bpg400"
[[segment.gauge]]
name = "pcg550 8"
address = 8
device = "pcg550"
[[segment.gauge]]
name = "psg550 11"
address = 11
device = "psg550"
STATION
"$profivac" report "$folder/plant.toml" --gauge 'bcg450 5' --gauge 'bpg400 6' --gauge 'pcg550 8' --gauge 'psg550 11' \
    --volume '20 l' --to-pressure '5e-6 mbar' --title 'Pump-down of the demonstration plant' --out "$folder/report.html"

# picture NAME HEIGHT OPTION...
picture() {
    local name=$1 height=$2
    shift 2
    chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir="$folder/browser" "$@" \
        --window-size=1000,"$height" --screenshot="$pictures/$name.png" "file://$folder/report.html" 2>/dev/null
}
picture report 1480
picture report-dark 1480 --blink-settings=preferredColorScheme=0
