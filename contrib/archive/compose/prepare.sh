#!/usr/bin/env bash
# Makes the passwords of the composition beside its files, readable by their owner alone, and the folder for the database of the station.
# Passwords that exist stay.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
umask 077

# The letter in front keeps NATS from reading a password such as 12e34 as a number.
password() { printf 'p%s' "$(openssl rand -hex 24)"; }

# credentials FILE USER PASSWORD
credentials() { printf 'user = "%s"\npassword = "%s"\n' "$2" "$3" >"$1"; }

# Its file names the one with the password.
chmod 600 station/station.toml
mkdir -p secrets record
printf 'PROFIVAC_USER=%s:%s\n' "$(id -u)" "$(id -g)" >.env
if [ ! -e secrets/nats.env ]; then
    station=$(password) archive=$(password)
    credentials station/nats.credentials hall-1 "$station"
    credentials archive/nats.credentials archive "$archive"
    printf 'HALL_1=%s\nARCHIVE=%s\n' "$station" "$archive" >secrets/nats.env
fi
if [ ! -e archive/postgres.password ]; then
    password >archive/postgres.password
fi
