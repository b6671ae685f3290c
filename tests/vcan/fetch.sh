# Sourced by the scripts beside it. Fetches Debian packages through apt and unpacks them into a cache:
# nothing is installed, no root is needed. Sets CACHE and, after `fetch`, ROOT and MODULES.
#
#   CACHE/debs/   the packages          CACHE/root/   what was in them
#   CACHE/bin/    their programs, each called with the libraries it came with

CACHE=${VCAN_CACHE:-${XDG_CACHE_HOME:-${HOME:-/var/tmp}/.cache}/gripd-vcan}
ROOT=$CACHE/root

# busybox and a kernel for the guest, can-utils and iproute2 for the tests; the rest are their libraries.
PACKAGES=${VCAN_PACKAGES:-"user-mode-linux can-utils busybox-static iproute2
    libbpf1 libelf1 libmnl0 libbsd0 libmd0 libcap2 zlib1g libxtables12"}

die() {
    echo "${0##*/}: $*" >&2
    exit 125
}

# apt with lists of its own, for a machine whose lists are missing or out of date: works without root.
own_apt() {
    mkdir -p "$CACHE/apt/lists/partial" "$CACHE/apt/archives/partial"
    apt-get -qq -o APT::Sandbox::User="$(id -un)" -o Dir::State::lists="$CACHE/apt/lists" \
        -o Dir::Cache="$CACHE/apt" "$@"
}

# download PACKAGE: into the current folder. Some libraries carry "t64" in newer releases.
download() {
    for name in "$1" "$1t64"; do
        apt-get -qq -o APT::Sandbox::User="$(id -un)" download "$name" 2>/dev/null && return
        [ -e "$CACHE/apt/updated" ] || { own_apt update >&2 && : > "$CACHE/apt/updated"; }
        own_apt download "$name" 2>/dev/null && return
    done
    echo "${0##*/}: apt cannot download $1" >&2
    return 1
}

unpack_packages() {
    mkdir -p "$CACHE/debs" "$ROOT" "$CACHE/bin"
    cd "$CACHE/debs" || return
    for package in $PACKAGES; do
        ls "${package}"_*.deb "${package}t64"_*.deb 2>/dev/null | grep -q . || download "$package" || return
    done
    for deb in ./*.deb; do
        dpkg-deb -x "$deb" "$ROOT" || return
    done
    libraries=$ROOT/lib/x86_64-linux-gnu:$ROOT/usr/lib/x86_64-linux-gnu
    for program in "$ROOT"/usr/bin/* "$ROOT"/bin/ip "$ROOT"/sbin/tc "$ROOT"/usr/sbin/tc; do
        case $program in *linux.uml | *stat) continue ;; esac
        [ -x "$program" ] || continue
        printf '#!/bin/sh\nLD_LIBRARY_PATH=%s exec %s "$@"\n' "$libraries" "$program" \
            > "$CACHE/bin/${program##*/}"
    done
    chmod +x "$CACHE"/bin/*
    echo "$PACKAGES" > "$CACHE/ok"
}

# fetch: once; two test binaries may start at the same time.
fetch() {
    if [ ! -e "$CACHE/ok" ] || [ "$(cat "$CACHE/ok")" != "$PACKAGES" ]; then
        [ "$(uname -m)" = x86_64 ] || die "the guest kernel exists for x86_64 only; load the vcan module instead"
        command -v apt-get >/dev/null && command -v dpkg-deb >/dev/null ||
            die "needs apt-get and dpkg-deb (Debian, Ubuntu); elsewhere load the vcan module: modprobe vcan"
        mkdir -p "$CACHE" || die "cannot make $CACHE (VCAN_CACHE names another place)"
        (
            flock 9
            [ "$(cat "$CACHE/ok" 2>/dev/null)" = "$PACKAGES" ] || unpack_packages
        ) 9> "$CACHE/lock" || die "cannot fetch the packages into $CACHE"
    fi
    MODULES=$(echo "$ROOT"/usr/lib/uml/modules/*/kernel)
    [ -d "$MODULES" ] || die "no kernel modules in $ROOT; remove $CACHE and try again"
}

# preload: what the guest is to be started with on this processor, if anything (xstate.c says why); VCAN_XSTATE=1 asks for it
# anywhere. Without a compiler the guest is tried as it is.
preload() {
    [ -n "${VCAN_XSTATE:-}" ] || grep -qw amx_tile /proc/cpuinfo || return 0
    shim=$CACHE/xstate.so source=$1/xstate.c
    if [ ! -e "$shim" ] || [ "$source" -nt "$shim" ]; then
        command -v cc >/dev/null || return 0
        cc -shared -fPIC -O2 -o "$shim.$$" "$source" && mv "$shim.$$" "$shim" || die "cannot build $source"
    fi
    echo "$shim"
}
