#!/bin/sh
# Counts the instructions of each stage and compares them with benches/instructions.toml (see benches/instructions.rs).
# Installs valgrind where it is missing, with sudo where it must and can.
set -eu
cd "$(dirname "$0")/.."
tests/setup.sh
if ! command -v valgrind >/dev/null 2>&1; then
    echo "instructions: installing valgrind" >&2
    as_root=
    [ "$(id -u)" = 0 ] || as_root=sudo
    export DEBIAN_FRONTEND=noninteractive
    $as_root apt-get -qq update >&2
    $as_root apt-get -qq install -y --no-install-recommends valgrind >&2
fi
exec cargo bench --locked --bench instructions -- "$@"
