#!/bin/sh
# Installs what building and testing gripd need on a fresh Debian or Ubuntu machine with Rust:
# a C compiler (for zstd) and Python with venv (the tests compare with cantools).
# Does nothing where all of it is there; uses sudo where it must and can.
# In CI also valgrind, which counts instructions (benches/instructions.rs), and a chromium (100 MB, with what it needs up
# to 200; seconds to fetch), in which `gripd view` is tried. Elsewhere these say that they are skipped where there is none.
set -eu

install() { # PACKAGE…
    echo "setup: installing $*" >&2
    as_root=
    [ "$(id -u)" = 0 ] || as_root=sudo
    export DEBIAN_FRONTEND=noninteractive
    $as_root apt-get -qq update >&2 && $as_root apt-get -qq install -y --no-install-recommends "$@" >&2
}

missing=
command -v cc >/dev/null 2>&1 || missing="$missing gcc libc6-dev"
command -v python3 >/dev/null 2>&1 || missing="$missing python3"
python3 -c 'import ensurepip, venv' >/dev/null 2>&1 || missing="$missing python3-venv"
# shellcheck disable=SC2086  # a list of packages
[ -z "$missing" ] || install $missing
if [ -n "${CI:-}" ]; then
    for tool in valgrind chromium; do
        command -v $tool >/dev/null 2>&1 || install $tool || echo "setup: no $tool can be had here" >&2
    done
fi
command -v cargo >/dev/null 2>&1 || { echo "setup: Rust is missing; see https://rustup.rs" >&2; exit 1; }
