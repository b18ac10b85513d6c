#!/usr/bin/env bash
# Takes every picture of docs/pictures from the running programs, and compares names and widths with those of the pages.
#   ci/pictures.sh            into target/pictures; ends with 1 if a page has a picture that is not taken, or one of another width
#   ci/pictures.sh --write    also replaces those of docs/pictures
#   ci/pictures.sh --gallery  instead: every page of the dashboard, on a desk and on a phone, light and dark, at each act of the demonstration and with
#                          15 and 480 gauges, then its zones, its dialogs and a lost station, into target/gallery with an index.html; takes an hour
# The drawings (*.svg) are written and compared by tests in Rust.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=ci/need.sh
. ci/need.sh
case "$*" in
'' | --write | --gallery) ;;
*) echo 'usage: ci/pictures.sh [--write | --gallery]' >&2 && exit 2 ;;
esac
need_to_build
need chromium-headless-shell chromium-headless-shell --version
if [ "${1:-}" = --gallery ]; then
    rm -rf target/gallery
    cargo build --quiet --workspace --example fake_plant --example acting_plant
    cargo build --quiet --bin profivac
    cd crates/station/web/e2e && npm ci --silent --no-audit --no-fund && exec node gallery.mjs ../../../../target/gallery
fi
need file file --version
need_servers

folder=$PWD/target/pictures
rm -rf "$folder"
mkdir -p "$folder"
cargo build --quiet --workspace --example fake_plant --example acting_plant
docs/pictures/report.sh "$folder"
# The report builds the program without the archive.
cargo build --quiet --workspace --bin profivac --features profivac-cli/opcua,profivac-cli/archive
(cd crates/station/web/e2e && npm ci --silent --no-audit --no-fund && node pictures.mjs "$folder")
PICTURES=$folder contrib/archive/view.py target/debug/profivac --browser
PICTURES=$folder ci/python_package.sh target/debug/profivac

# widths FOLDER: the name of each picture with its width.
widths() { (cd "$1" && file -- *.png | sed -n 's/^\([^:]*\): *PNG image data, \([0-9]*\) x.*/\1 \2/p'); }
diff <(widths docs/pictures) <(widths "$folder") || { echo 'FAILED: < is in docs/pictures, > was taken now' >&2 && exit 1; }
if [ "${1:-}" = --write ]; then cp "$folder"/*.png docs/pictures; fi
echo "ok: $(widths "$folder" | wc -l) pictures, with the names and widths of those in docs/pictures"
