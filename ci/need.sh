# Installs the packages that a script needs. Other scripts source this file.

# need PACKAGE COMMAND...: installs the Debian package if the command fails. Only root can install; other users get its name. What apt-get
# prints goes to the standard error, because other scripts read the standard output of those that call this.
need() {
    local package=$1
    shift
    if "$@" >/dev/null 2>&1; then return; fi
    if [ "$(id -u)" -ne 0 ] || ! command -v apt-get >/dev/null; then
        echo "'$*' fails; please install the package $package (its name on Debian)" >&2
        exit 1
    fi
    # Steps that run at the same time install packages one after the other.
    local install=(env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 install -qq -y "$package")
    "${install[@]}" >&2 || {
        apt-get update -qq >&2
        "${install[@]}" >&2
    }
}

# The packages that every build needs: a linker, and Node for the dashboard.
need_to_build() {
    need gcc cc --version
    need nodejs node --version
    need npm npm --version
}

# A virtual environment, and the headers for the packages in it that are compiled.
need_python() {
    need python3-venv python3 -c 'import ensurepip, venv'
    need python3-dev python3 -c 'import os, sysconfig; os.stat(sysconfig.get_path("include") + "/Python.h")'
}

# PostgreSQL installed, and a server of NATS unpacked below target/tools: its package would start a server on a public port.
need_servers() {
    need postgresql ls /usr/lib/postgresql/*/bin/initdb
    export PATH=$PATH:$PWD/target/tools/nats/usr/sbin
    if [ -x target/tools/nats/usr/sbin/nats-server ]; then return; fi
    (
        mkdir -p target/tools/nats && cd target/tools/nats
        apt-get download -qq nats-server || { apt-get update -qq && apt-get download -qq nats-server; }
        dpkg-deb -x nats-server_*.deb .
    )
}
