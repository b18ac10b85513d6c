#!/usr/bin/env bash
# Builds profivac for Windows on Debian: one program without a library beside it, and a zip with it.
#   contrib/windows/build.sh [FOLDER]    into FOLDER, by default target/windows
# Installs the linker for Windows (as root) and the Rust target. The zip holds the program, the documentation, the GSD files of the gauges,
# their function blocks, an example of a station, the scenarios and the dissector for Wireshark.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

# shellcheck source=ci/need.sh
. ci/need.sh
need_to_build
need gcc-mingw-w64-x86-64 x86_64-w64-mingw32-gcc --version
need zip zip -v

target=x86_64-pc-windows-gnu
rustup target add "$target" 2>/dev/null
cargo build --locked --release --package profivac-cli --features opcua,archive --target "$target"

out=${1:-target/windows}
version=$(cargo metadata --locked --no-deps --format-version 1 | sed -n 's/.*"name":"profivac-cli","version":"\([^"]*\)".*/\1/p')
name=profivac-$version-windows-x86_64
folder=$out/$name
rm -rf "$folder"
mkdir -p "$folder"/{docs,gsd,blocks}
cp "target/$target/release/profivac.exe" "$folder"
x86_64-w64-mingw32-strip "$folder/profivac.exe"

# Windows has these libraries; anything else would have to lie beside the program.
system='advapi32|bcrypt|bcryptprimitives|cfgmgr32|crypt32|kernel32|ktmw32|msvcrt|ncrypt|ntdll|ole32|oleaut32|sec[u]r32|user32|userenv|ws2_32|api-ms-win-[a-z0-9-]+'
others=$(x86_64-w64-mingw32-objdump -p "$folder/profivac.exe" | sed -n 's/.*DLL Name: //p' | grep -viE "^($system)\.dll\$" || true)
if [ -n "$others" ]; then
    printf 'profivac.exe needs libraries that Windows does not have:\n%s\n' "$others" >&2
    exit 1
fi

# The files are those of the program for this computer: both print the same.
native=target/release/profivac
cargo build --locked --quiet --release --package profivac-cli --features opcua,archive
"$native" gsd --out "$folder/gsd"
"$native" device list | awk '$1 ~ /^[a-z]+[0-9]+$/ { print $1 }' | while read -r device; do
    "$native" st "$device" >"$folder/blocks/$device.st"
done
cp -r docs/*.md docs/devices "$folder/docs"
cp README.md CHANGELOG.md LICENSE-APACHE LICENSE-MIT contrib/debian/plant.toml contrib/wireshark/profibus.lua "$folder"
cp -r scenarios "$folder"
(cd "$out" && rm -f "$name.zip" && zip -qr "$name.zip" "$name")
printf '%s, %s octets; the program has %s\n' "$out/$name.zip" "$(stat -c %s "$out/$name.zip")" "$(stat -c %s "$folder/profivac.exe")"
