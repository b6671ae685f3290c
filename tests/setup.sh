#!/bin/sh
# Installs what building and testing gripd need on a fresh Debian or Ubuntu machine with Rust:
# a C compiler (for zstd) and Python with venv (the tests compare with cantools).
# Does nothing where all of it is there; uses sudo where it must and can.
# In CI also a chromium (100 MB, with what it needs up to 200; seconds to fetch): `gripd view` is then tried in it.
# Elsewhere that test says that it is skipped where there is none.
set -eu
missing=
command -v cc >/dev/null 2>&1 || missing="$missing gcc libc6-dev"
command -v python3 >/dev/null 2>&1 || missing="$missing python3"
python3 -c 'import ensurepip, venv' >/dev/null 2>&1 || missing="$missing python3-venv"
if [ -n "$missing" ]; then
    echo "setup: installing$missing" >&2
    as_root=
    [ "$(id -u)" = 0 ] || as_root=sudo
    export DEBIAN_FRONTEND=noninteractive
    $as_root apt-get -qq update >&2
    # shellcheck disable=SC2086  # a list of packages
    $as_root apt-get -qq install -y --no-install-recommends $missing >&2
fi
if [ -n "${CI:-}" ] && ! command -v chromium >/dev/null 2>&1; then
    as_root=
    [ "$(id -u)" = 0 ] || as_root=sudo
    export DEBIAN_FRONTEND=noninteractive
    { $as_root apt-get -qq update && $as_root apt-get -qq install -y --no-install-recommends chromium; } >&2 ||
        echo "setup: no chromium can be had here; the page is not tried in a browser" >&2
fi
command -v cargo >/dev/null 2>&1 || { echo "setup: Rust is missing; see https://rustup.rs" >&2; exit 1; }
