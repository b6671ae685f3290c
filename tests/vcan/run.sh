#!/bin/sh
# run.sh COMMAND [ARGUMENT...]
#
# Runs COMMAND where vcan0 and vcan1 exist and are up: in a network namespace of its own if this
# machine's kernel has vcan (its own interfaces are not touched), else in a User Mode Linux guest.
# As cargo's runner, one boot per test binary:
#
#   CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER=tests/vcan/run.sh cargo test --test vcan
#
# VCAN_WHERE=native or =guest forces one of the two. Exit status: COMMAND's; 125: no place to run it.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
. "$here/fetch.sh"
[ $# -gt 0 ] || die "no command"

# With root or without: in a user namespace anybody may make interfaces.
own_namespace() {
    if [ "$(id -u)" = 0 ]; then unshare --net -- "$@"; else unshare --map-root-user --net -- "$@"; fi
}

native_works() {
    command -v ip >/dev/null && command -v unshare >/dev/null &&
        own_namespace ip link add dev vcan0 type vcan 2>/dev/null
}

where=${VCAN_WHERE:-}
[ -n "$where" ] || { if native_works; then where=native; else where=guest; fi; }
# A test that finds no interface in spite of this has failed, not skipped.
export GRIPD_REQUIRE_VCAN=1
case $where in
    native)
        command -v candump >/dev/null || { fetch; PATH=$CACHE/bin:$PATH; export PATH; }
        own_namespace sh -ec '
            ip link set lo up
            for interface in vcan0 vcan1; do ip link add dev $interface type vcan; ip link set $interface up; done
            exec "$@"' run.sh "$@"
        ;;
    guest) exec "$here/vcan-uml.sh" -- "$@" ;;
    *) die "VCAN_WHERE is native or guest, not $where" ;;
esac
