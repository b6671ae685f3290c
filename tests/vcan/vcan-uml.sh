#!/bin/sh
# vcan-uml.sh [-m MEMORY] [-t SECONDS] [-i 'vcan0 vcan1'] [-s] [-v] [--fetch] [--] COMMAND [ARGUMENT...]
#
# Runs COMMAND where vcan0 and vcan1 exist, on any machine: as root in a User Mode Linux guest (a kernel
# that runs as an ordinary process) whose root is this machine's file system. Working folder and
# environment are kept; can-utils, ip and tc are in the guest's PATH.
#   -m  the guest's memory (512M)       -t  stop it after so many seconds (300)
#   -i  interfaces to make              -s  pass the standard input on (it is read to its end first)
#   -v  show the guest's kernel log     --fetch  only fetch what is needed
# Exit status: COMMAND's; 125: the guest could not be prepared; 124: it did not finish in time.
set -eu
. "$(dirname "$0")/fetch.sh"

memory=${VCAN_MEMORY:-512M} timeout=${VCAN_TIMEOUT:-300} interfaces='vcan0 vcan1'
verbose=0 pass_stdin=0 fetch_only=0
while [ $# -gt 0 ]; do
    case $1 in
        -m) memory=$2; shift 2 ;;
        -t) timeout=$2; shift 2 ;;
        -i) interfaces=$2; shift 2 ;;
        -s) pass_stdin=1; shift ;;
        -v) verbose=1; shift ;;
        --fetch) fetch_only=1; shift ;;
        --) shift; break ;;
        -*) die "unknown option $1 (the head of this file tells which there are)" ;;
        *) break ;;
    esac
done
fetch
shim=$(preload "$(dirname "$0")")
[ $fetch_only = 0 ] || exit 0
[ $# -gt 0 ] || die "no command"

run=$(mktemp -d "${TMPDIR:-/tmp}/vcan-uml.XXXXXX")
guest=
cleanup() {
    [ -z "$guest" ] || { kill "$guest"; wait "$guest"; } 2>/dev/null || :
    rm -rf "$run"
}
trap cleanup EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# The command as a script: our environment, our folder, then the command itself.
quote() { printf "'%s' " "$(printf %s "$1" | sed "s/'/'\\\\''/g")"; }
{
    (unset OLDPWD; export -p)
    echo "PATH=\"$CACHE/bin:\$PATH\""
    printf 'cd '; quote "$PWD"; echo
    printf 'exec '; for argument; do quote "$argument"; done; echo
} > "$run/command"

# The guest's first process: mount, load, make the interfaces, run the command, leave its status behind.
modules="net/can/can net/can/can-raw net/can/can-bcm net/can/can-gw drivers/net/can/dev/can-dev
    drivers/net/can/vcan drivers/net/can/vxcan net/sched/sch_netem net/sched/sch_tbf"
cat > "$run/init" <<INIT
#!$ROOT/bin/busybox sh
busybox=$ROOT/bin/busybox
fail() { echo "vcan-uml guest: \$*" >> $run/err; \$busybox sync; \$busybox poweroff -f; }
\$busybox mount -t proc proc /proc
\$busybox mount -t sysfs sys /sys
\$busybox mount -t tmpfs -o mode=755 run /run
\$busybox mkdir -p /dev/shm /dev/pts
\$busybox mount -t tmpfs shm /dev/shm
\$busybox mount -t devpts devpts /dev/pts
\$busybox ln -sf /proc/self/fd /dev/fd
\$busybox ln -sf /proc/self/fd/0 /dev/stdin
\$busybox ln -sf /proc/self/fd/1 /dev/stdout
\$busybox ln -sf /proc/self/fd/2 /dev/stderr
for module in $(echo $modules); do \$busybox insmod $MODULES/\$module.ko || fail "cannot load \$module"; done
\$busybox hostname vcan-uml
\$busybox ip link set lo up
for interface in $interfaces; do
    \$busybox ip link add dev \$interface type vcan && \$busybox ip link set \$interface up || fail "cannot make \$interface"
done
\$busybox setsid /bin/sh $run/command < $run/in >> $run/out 2>> $run/err
echo \$? > $run/status
\$busybox sync
\$busybox poweroff -f
INIT
chmod +x "$run/init"
: > "$run/out"
: > "$run/err"
if [ $pass_stdin = 1 ] && [ ! -t 0 ]; then cat > "$run/in"; else : > "$run/in"; fi

# The output goes through files, not through the guest's console, which loses some of it.
LD_PRELOAD=$shim timeout -k 5 "$timeout" "$ROOT/usr/bin/linux.uml" mem="$memory" uml_dir="$run" umid=g \
    rootfstype=hostfs hostfs=/ rw init="$run/init" zswap.enabled=0 pty.legacy_count=0 \
    con=null con0=null,fd:1 ssl=null < /dev/null > "$run/kernel.log" 2>&1 &
guest=$!
tail -q -c +1 -s 0.1 --pid=$guest -f "$run/out" & out=$!
tail -q -c +1 -s 0.1 --pid=$guest -f "$run/err" >&2 & err=$!
wait $guest 2>/dev/null || :
guest=
wait $out $err 2>/dev/null || :
[ $verbose = 0 ] || cat "$run/kernel.log" >&2
if [ ! -s "$run/status" ]; then
    tail -n 30 "$run/kernel.log" >&2
    echo "vcan-uml.sh: the guest ended without a status (more than $timeout s?)" >&2
    exit 124
fi
exit "$(cat "$run/status")"
