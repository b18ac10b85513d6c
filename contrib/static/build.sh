#!/usr/bin/env bash
# Builds the program as one static file, for any Linux of this or of another processor.
#   contrib/static/build.sh                        x86_64: target/static/profivac-x86_64
#   contrib/static/build.sh aarch64                64-bit ARM, for instance a Raspberry Pi: target/static/profivac-aarch64
#   contrib/static/build.sh ... --profile NAME     another profile of Cargo than dist
#   contrib/static/build.sh ... --features LIST    parts of the program that are not built otherwise, for instance archive,opcua
#   contrib/static/build.sh ... --tests            only runs the unit tests of the inner crates for it, in an emulator if it is another processor
#   contrib/static/build.sh ... --check            then proves that the program runs in a root folder with an empty folder tmp and nothing else; as root
# Installs what it needs as root: Debian packages, and the standard library of the target with rustup.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
# shellcheck source=ci/need.sh
. ci/need.sh

processor=x86_64
profile=dist
features=
is_checked=no
only_tests=no
while [ $# -gt 0 ]; do
    case "$1" in
    x86_64 | aarch64) processor=$1 ;;
    --profile) profile=${2:?"--profile needs a name"} && shift ;;
    --features) features=${2:?"--features needs a list"} && shift ;;
    --check) is_checked=yes ;;
    --tests) only_tests=yes ;;
    *)
        echo 'usage: contrib/static/build.sh [x86_64 | aarch64] [--profile NAME] [--features LIST] [--check | --tests]' >&2
        exit 2
        ;;
    esac
    shift
done

# The headers of musl for ARM, for the C parts (SQLite, ring): those of glibc have other types, and functions that musl, which Rust brings, has not. Their
# package is unpacked beside the other tools; it is not for this processor, so it cannot be installed.
headers_of_musl() {
    local folder=$PWD/target/tools/musl-arm64
    headers=$folder/usr/include/aarch64-linux-musl
    if [ -f "$headers/stdio.h" ]; then return; fi
    mkdir -p "$folder/lists/partial"
    local apt=(apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o "Dir::State::Lists=$folder/lists" -o "Dir::Cache=$folder/cache" -o APT::Sandbox::User=root)
    (cd "$folder" && "${apt[@]}" update && "${apt[@]}" download musl-dev && dpkg-deb -x musl-dev_*.deb .)
}

need_to_build
need binutils strip --version
target=$processor-unknown-linux-musl
rustup target add "$target"
case $processor in
x86_64)
    need musl-tools musl-gcc --version
    export CC_x86_64_unknown_linux_musl=musl-gcc
    run=()
    ;;
aarch64)
    need gcc-aarch64-linux-gnu aarch64-linux-gnu-gcc --version
    need libc6-dev-arm64-cross test -f /usr/aarch64-linux-gnu/include/stdio.h
    headers_of_musl
    export CC_aarch64_unknown_linux_musl=aarch64-linux-gnu-gcc CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_LINKER=aarch64-linux-gnu-gcc
    # The compiler of Debian asks for functions that check lengths, which only glibc has.
    CFLAGS_aarch64_unknown_linux_musl="-nostdinc -isystem $(aarch64-linux-gnu-gcc -print-file-name=include) -isystem $headers -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=0"
    export CFLAGS_aarch64_unknown_linux_musl
    need qemu-user-static qemu-aarch64-static --version
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_RUNNER=qemu-aarch64-static
    run=(/qemu-aarch64-static)
    ;;
esac

if [ "$only_tests" = yes ]; then
    exec cargo test --quiet --release --lib --target "$target" --package=profivac-{wire,dp,devices}
fi

cargo build --quiet --profile "$profile" --package profivac-cli --features "$features" --target "$target"
folder=$profile
if [ "$profile" = dev ]; then folder=debug; fi
mkdir -p target/static
program=target/static/profivac-$processor
cp "target/$target/$folder/profivac" "$program"
if [ "$processor" = x86_64 ]; then strip "$program"; else aarch64-linux-gnu-strip "$program"; fi
echo "$program"

if [ "$is_checked" = yes ]; then
    if [ "$(id -u)" -ne 0 ]; then
        echo 'only root can change into a root folder' >&2
        exit 1
    fi
    contrib/static/check.py "$program" "${run[@]}"
fi
