#!/bin/sh
# vcan-systemd.sh [-m MEMORY] [-t SECONDS] [-v] SETUP PROBE
#
# Boots this machine's own root, under an overlay in memory (nothing is written to it), with its systemd
# as first process in a User Mode Linux guest where vcan0 and vcan1 are up: for testing the unit file,
# the watchdog, restarts.
#   SETUP  sh script run as root before systemd starts, in the new root: cp unit etc/systemd/system/
#   PROBE  sh script run as a service after basic.target; its output and exit status are ours
# Needs systemd and dbus on this machine, or in a root named by VCAN_SYSROOT (made by mmdebstrap; with
# udev in it, device units work too). Exit status: PROBE's; 124: the guest did not finish in time.
set -eu
. "$(dirname "$0")/fetch.sh"

memory=768M timeout=120 verbose=0 lower=${VCAN_SYSROOT:-/}
while [ $# -gt 0 ]; do
    case $1 in
        -m) memory=$2; shift 2 ;;
        -t) timeout=$2; shift 2 ;;
        -v) verbose=1; shift ;;
        *) break ;;
    esac
done
[ $# = 2 ] || die "usage: $0 [-m MEMORY] [-t SECONDS] [-v] SETUP PROBE"
fetch
shim=$(preload "$(dirname "$0")")

run=$(mktemp -d "${TMPDIR:-/tmp}/vcan-systemd.XXXXXX")
guest=
cleanup() {
    [ -z "$guest" ] || { kill "$guest"; wait "$guest"; } 2>/dev/null || :
    rm -rf "$run"
}
trap cleanup EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
cp "$1" "$run/setup"
cp "$2" "$run/probe"
: > "$run/out"

modules="fs/overlayfs/overlay net/can/can net/can/can-raw net/can/can-bcm drivers/net/can/dev/can-dev
    drivers/net/can/vcan net/sched/sch_netem net/sched/sch_tbf"
# Units of the host that would wait for hardware, or take minutes on its file system.
masked="systemd-tmpfiles-setup systemd-tmpfiles-setup-dev systemd-tmpfiles-clean systemd-timesyncd
    systemd-update-utmp systemd-networkd systemd-resolved"
cat > "$run/init" <<INIT
#!$ROOT/bin/busybox sh
busybox=$ROOT/bin/busybox
fail() { echo "vcan-systemd guest: \$*" >> $run/out; \$busybox poweroff -f; }
\$busybox mount -t proc proc /proc
for module in $(echo $modules); do \$busybox insmod $MODULES/\$module.ko || fail "cannot load \$module"; done
for interface in vcan0 vcan1; do
    \$busybox ip link add dev \$interface type vcan && \$busybox ip link set \$interface up || fail "cannot make \$interface"
done
\$busybox mount -t tmpfs -o mode=755 upper /mnt && \$busybox mkdir /mnt/upper /mnt/work /mnt/new || fail "no memory"
\$busybox mount -t overlay -o lowerdir=$lower,upperdir=/mnt/upper,workdir=/mnt/work overlay /mnt/new || fail "no overlay"
cd /mnt/new
\$busybox mkdir -p old vcanrun
\$busybox mount -t hostfs -o $run none vcanrun || fail "cannot mount $run"
\$busybox rm -f etc/systemd/system/*.wants/* etc/fstab
\$busybox touch etc/fstab
for unit in $(echo $masked); do \$busybox ln -sf /dev/null etc/systemd/system/\$unit.service; done
\$busybox cat > etc/systemd/system/vcan-test.target <<'UNIT'
[Unit]
Requires=basic.target
Wants=vcan-probe.service dbus.service
UNIT
\$busybox cat > etc/systemd/system/vcan-probe.service <<'UNIT'
[Unit]
After=dbus.service dbus.socket basic.target
[Service]
Type=oneshot
Environment=PATH=$CACHE/bin:/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
ExecStart=/bin/sh -c 'sh /vcanrun/probe </dev/null >>/vcanrun/out 2>&1; echo \$\$? >/vcanrun/status; sync; systemctl poweroff -ff'
UNIT
/bin/sh -e $run/setup >> $run/out 2>&1 || fail "SETUP failed"
\$busybox umount /proc
\$busybox mount --move /dev dev
\$busybox pivot_root . old && exec /old\$busybox chroot . /lib/systemd/systemd --unit=vcan-test.target
fail "no systemd in $lower"
INIT
chmod +x "$run/init"

LD_PRELOAD=$shim timeout -k 5 "$timeout" "$ROOT/usr/bin/linux.uml" mem="$memory" uml_dir="$run" umid=g \
    rootfstype=hostfs hostfs=/ rw init="$run/init" zswap.enabled=0 pty.legacy_count=0 \
    systemd.show_status=0 con=null con0=null,fd:1 ssl=null < /dev/null > "$run/kernel.log" 2>&1 &
guest=$!
tail -q -c +1 -s 0.1 --pid=$guest -f "$run/out" & out=$!
wait $guest 2>/dev/null || :
guest=
wait $out 2>/dev/null || :
[ $verbose = 0 ] || cat "$run/kernel.log" >&2
if [ ! -s "$run/status" ]; then
    tail -n 40 "$run/kernel.log" >&2
    echo "vcan-systemd.sh: the guest ended without a status (more than $timeout s?)" >&2
    exit 124
fi
exit "$(cat "$run/status")"
