#!/usr/bin/env bash
# Builds the Debian package of this computer's architecture.
#   contrib/debian/build.sh                     compiles the program and writes target/debian/profivac_VERSION_ARCHITECTURE.deb
#   contrib/debian/build.sh --program FILE      packs this program
#   contrib/debian/build.sh --revision N        a higher revision of the same version; the default is 1
#   contrib/debian/build.sh --compression LEVEL the level of xz from 0 to 9; the default is that of dpkg-deb. A minute of a processor less at 0
# Prints the path of the package. Man pages and completions come from the program itself.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

program=
revision=1
compression=()
while [ $# -gt 0 ]; do
    case "$1" in
    --program) program=${2:?"--program needs a file"} ;;
    --revision) revision=${2:?"--revision needs a number"} ;;
    --compression) compression=(-Zxz "-z${2:?"--compression needs a level"}") ;;
    *)
        echo 'usage: contrib/debian/build.sh [--program FILE] [--revision N] [--compression LEVEL]' >&2
        exit 2
        ;;
    esac
    shift 2
done

# shellcheck source=ci/need.sh
. ci/need.sh
need dpkg-dev dpkg-shlibdeps --version
need binutils strip --version
need help2man help2man --version
if [ -z "$program" ]; then
    need_to_build
    cargo build --profile dist --package profivac-cli
    program=target/dist/profivac
fi

version=$("$program" --version | cut -d ' ' -f 2)-$revision
architecture=$(dpkg --print-architecture)
out=target/debian
root=$out/root
package=$out/profivac_${version}_$architecture.deb
rm -rf "$root"
mkdir -p "$root/DEBIAN" "$root/usr/bin"

file() { install -D -m "$3" "$1" "$root/$2"; }

strip -o "$root/usr/bin/profivac" "$program"
chmod 755 "$root/usr/bin/profivac"
own=$root/usr/bin/profivac
file contrib/debian/profivac.service usr/lib/systemd/system/profivac.service 644
file contrib/debian/sysusers.conf usr/lib/sysusers.d/profivac.conf 644
file contrib/debian/tmpfiles.conf usr/lib/tmpfiles.d/profivac.conf 644
file contrib/debian/70-profivac.rules usr/lib/udev/rules.d/70-profivac.rules 644
file contrib/debian/plant.toml usr/share/doc/profivac/examples/plant.toml 644
file contrib/debian/copyright usr/share/doc/profivac/copyright 644
file LICENSE-MIT usr/share/doc/profivac/LICENSE-MIT 644
file contrib/wireshark/profibus.lua "usr/lib/$(dpkg-architecture -q DEB_HOST_MULTIARCH)/wireshark/plugins/profibus.lua" 644
gzip -9n <CHANGELOG.md >"$root/usr/share/doc/profivac/changelog.gz"

# The files for engineering tools.
"$own" gsd --out "$root/usr/share/profivac/gsd" >/dev/null
for gsd in "$root"/usr/share/profivac/gsd/*.GSD; do
    device=$(basename "$gsd" .GSD | tr '[:upper:]' '[:lower:]')
    mkdir -p "$root/usr/share/profivac/st"
    "$own" st "$device" >"$root/usr/share/profivac/st/$device.st"
    "$own" st "$device" --dialect tia >"$root/usr/share/profivac/st/$device.scl"
done

# Completions and man pages.
completions() { mkdir -p "$root/usr/share/$(dirname "$2")" && "$own" completions "$1" >"$root/usr/share/$2"; }
completions bash bash-completion/completions/profivac
completions zsh zsh/vendor-completions/_profivac
completions fish fish/vendor_completions.d/profivac.fish
man=$root/usr/share/man/man1
mkdir -p "$man"
page() { help2man --no-info --section 1 --source "profivac ${version%-*}" --name "$2" --output "$man/$1.1" "$3"; }
# help2man runs a program without a command, so each command gets a program of two lines.
pages=$(mktemp -d)
trap 'rm -rf "$pages"' EXIT
page profivac 'PROFIBUS DP for vacuum gauges' "$own"
for command in $("$own" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z-]*\) .*/\1/p'); do
    if [ "$command" = help ]; then continue; fi
    printf '#!/bin/sh\nif [ "$1" = --version ]; then exec %q --version; fi\nexec %q %s --help\n' "$PWD/$own" "$PWD/$own" "$command" \
        >"$pages/profivac-$command"
    chmod 755 "$pages/profivac-$command"
    page "profivac-$command" "$("$own" "$command" --help | head -n 1 | sed 's/\.$//')" "$pages/profivac-$command"
done
gzip -9n "$man"/*.1

# dpkg-shlibdeps reads a control file of a source package.
mkdir -p "$out/debian"
printf 'Source: profivac\n\nPackage: profivac\nArchitecture: any\n' >"$out/debian/control"
depends=$(cd "$out" && dpkg-shlibdeps -O root/usr/bin/profivac 2>/dev/null | sed -n 's/^shlibs:Depends=//p')
cat >"$root/DEBIAN/control" <<CONTROL
Package: profivac
Version: $version
Architecture: $architecture
Maintainer: the contributors of profivac <profivac@localhost>
Section: electronics
Priority: optional
Installed-Size: $(du -sk "$root/usr" | cut -f 1)
Depends: $depends
Recommends: setserial
Suggests: wireshark
Description: PROFIBUS DP for vacuum gauges
 Virtual gauges, a bus master that reads and writes every parameter by name,
 and a station that records hundreds of gauges, raises alarms and shows a
 dashboard in the browser.
 .
 The package starts nothing: a second master on a bus must be intended.
CONTROL
install -m 755 contrib/debian/postinst contrib/debian/prerm contrib/debian/postrm "$root/DEBIAN"
(cd "$root" && find usr -type f -exec md5sum {} +) >"$root/DEBIAN/md5sums"
dpkg-deb "${compression[@]}" --root-owner-group --build "$root" "$package" >/dev/null
echo "$package"
