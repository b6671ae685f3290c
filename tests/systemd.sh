#!/bin/sh
# tests/systemd.sh [PROGRAM]
#
# The unit file, checked by systemd itself, and at work in a guest with this machine's systemd as its
# first process: installed from its .deb (where this machine has dpkg), started, publishing, reloaded, killed and back, without the
# interface, stopped, as a real-time process. PROGRAM is the
# gripd to test (target/debug/gripd; built if it is not given). Needs systemd and dbus on this machine;
# says so and passes where there are none. One to two minutes in a guest.
set -eu
cd "$(dirname "$0")/.."
skip() { echo "skipped: $*"; exit 0; }
command -v systemd-analyze >/dev/null || skip "no systemd-analyze here"

program=${1:-}
[ -n "$program" ] || { cargo build --locked --quiet; program=target/debug/gripd; }
program=$(realpath "$program")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# verify wants the program to be there: here it is elsewhere.
sed "s#/usr/bin/gripd#$program#" systemd/gripd.service > "$work/gripd.service"
complaints=$(systemd-analyze verify "$work/gripd.service" 2>&1 | grep gripd || :)
[ -z "$complaints" ] || { echo "systemd-analyze verify: $complaints" >&2; exit 1; }
systemd-analyze security --offline=true --threshold=15 systemd/gripd.service > "$work/security" ||
    { cat "$work/security" >&2; exit 1; }
tail -n 1 "$work/security"

[ -x /lib/systemd/systemd ] && command -v dbus-daemon >/dev/null || skip "no systemd or no dbus for the guest"
[ "$(uname -m)" = x86_64 ] || skip "the guest is for x86_64"

drive=$work/drive.log
sed 's/^duration_s = .*/duration_s = 20.0/' config/scenarios/demo.toml > "$work/drive.toml"
"$program" simulate "$work/drive.toml" -o "$drive"

# In the new root, as an administrator would install it: the package, or file by file.
if command -v dpkg-deb >/dev/null && python3 -c 'import tomllib' 2>/dev/null; then
    systemd/deb.sh "$program"
    package=$(ls -t target/debian/gripd_*.deb | head -n 1)
    # What is installed, without the lists of all its files: dpkg would read them each time, a minute in this guest.
    cat > "$work/setup" <<SETUP
mkdir -p var/tmp/drive
cp var/lib/dpkg/status var/tmp/drive/
mount -t tmpfs none var/lib/dpkg
mkdir var/lib/dpkg/info var/lib/dpkg/updates
mv var/tmp/drive/status var/lib/dpkg/
cp $PWD/$package var/tmp/drive/gripd.deb
cp $PWD/systemd/realtime.conf $drive var/tmp/drive/
SETUP
else
    echo "no dpkg-deb or no Python 3.11: installed without the package"
    cat > "$work/setup" <<SETUP
mkdir -p usr/bin etc/gripd etc/systemd/system var/tmp/drive
cp $program usr/bin/gripd
sed 's#../dbc/demo.dbc#demo.dbc#' $PWD/config/demo.toml > etc/gripd/gripd.toml
cp $PWD/dbc/demo.dbc etc/gripd/
cp $PWD/systemd/gripd.service etc/systemd/system/
cp $PWD/systemd/realtime.conf $drive var/tmp/drive/
SETUP
fi

cat > "$work/probe" <<'PROBE'
fail() { echo "FAILED: $*"; systemctl status gripd --no-pager -l; journalctl -u gripd --no-pager -n 40; exit 1; }
property() { systemctl show gripd -P "$1"; }
within() { # SECONDS WHAT COMMAND…
    seconds=$1 what=$2; shift 2
    for _ in $(seq $((seconds * 10))); do "$@" && return; sleep 0.1; done
    fail "$what"
}
new_pid() { [ "$(property MainPID)" != "$old" ] && [ "$(property MainPID)" != 0 ] && [ "$(property ActiveState)" = active ]; }
publishes() { [ "$(timeout 5 candump -L -n 30 vcan0,6A0:7F8 2>/dev/null | wc -l)" = 30 ]; }
logged() { journalctl -u gripd --no-pager | grep -q "$1"; }
says() { property StatusText | grep -q "$1"; }
package() { # WHAT OPTION…
    what=$1; shift
    # Dependencies are this machine's own; its mandb and other triggers are not asked.
    dpkg --no-triggers "$@" > /var/tmp/dpkg.log 2>&1 < /dev/null ||
        { grep -v "files list file" /var/tmp/dpkg.log; fail "dpkg does not $what"; }
}

deb=/var/tmp/drive/gripd.deb
if [ -e $deb ]; then
    package "install it" -i $deb
    [ "$(property LoadState) $(property ActiveState)" = "loaded inactive" ] || fail "systemd does not know the unit, or started it"
    [ "$(systemctl is-enabled gripd)" = disabled ] || fail "it is enabled without being asked"
    gripd check -c /etc/gripd/gripd.toml > /dev/null || fail "the configuration of the package is wrong"
    for file in man/man1/gripd.1.gz man/man1/gripd-map.1.gz bash-completion/completions/gripd doc/gripd/guide/map-a-car.md \
        doc/gripd/copyright gripd/gripd.dbc doc/gripd/examples/config/vss/friction.dbc \
        doc/gripd/examples/config/vss/gripd.vspec doc/gripd/examples/config/vss/vss_dbc.json \
        doc/gripd/examples/config/viewers/foxglove.json doc/gripd/examples/notebooks/map_a_car.ipynb; do
        [ -s /usr/share/$file ] || fail "the package has no $file"
    done
    for example in demo rav4 thesis; do
        gripd check -c /usr/share/doc/gripd/examples/config/$example.toml > /dev/null || fail "example $example is wrong"
    done
    gripd -q map /usr/share/doc/gripd/examples/dbc/demo.dbc /var/tmp/drive/drive.log > /dev/null || fail "gripd map finds nothing"
    echo "installed from the package: $(dpkg-query -W -f '${Package} ${Version}, ${Installed-Size} KiB' gripd)"
fi

# Type=notify: `start` comes back once it is ready.
systemctl start gripd || fail "it does not start"
[ "$(property Type) $(property ActiveState) $(property SubState)" = "notify active running" ] || fail "not running"
user=$(awk '$1 == "Uid:" { print $2 }' "/proc/$(property MainPID)/status")
[ "$user" -gt 1000 ] || fail "its user is $user, which is not one of its own"
within 5 "no status text" says "interface is up"
canplayer -l i -I /var/tmp/drive/drive.log vcan0=vcan0 & player=$!
publishes || fail "it does not publish"
echo "started and publishes"

old=$(property MainPID)
restarts=$(property NRestarts)
systemctl reload gripd || fail "it does not reload"
within 5 "it does not say that it has reloaded" logged "the new configuration is in use; the estimators go on"
echo "mass_pound = 1" >> /etc/gripd/gripd.toml
! systemctl reload gripd || fail "reloading a wrong configuration succeeds"
within 5 "it does not say that the configuration is refused" says "is refused"
publishes || fail "it does not publish after a refused configuration"
sed -i '$d' /etc/gripd/gripd.toml
systemctl reload gripd
within 5 "it does not say that all is well again" says "is up"
[ "$(property MainPID) $(property NRestarts) $(property ActiveState)" = "$old $restarts active" ] || fail "it was restarted"
publishes || fail "it does not publish after reloads"
echo "reloaded, a wrong configuration refused, reloaded, without a restart"

old=$(property MainPID)
kill -9 "$old"
within 10 "it does not come back after kill -9" new_pid
publishes || fail "it does not publish after a restart"
echo "killed, back, and publishes; restarts: $(property NRestarts)"

# A service that hangs is killed by the watchdog (10 s) and comes back.
old=$(property MainPID)
kill -STOP "$old"
within 30 "the watchdog does not notice" new_pid
echo "stopped, killed by the watchdog, and back"

ip link set vcan0 down
within 5 "it does not say that the interface is down" says waiting
ip link set vcan0 up
within 5 "it does not say that the interface is up" says "is up"
kill $player 2>/dev/null
[ ! -e /var/lib/gripd/learned.toml ] || rm /var/lib/gripd/learned.toml
systemctl stop gripd || fail "it does not stop"
within 2 "it did not save what it learned" test -s /var/lib/gripd/learned.toml
grep -q '^driving_s' /var/lib/gripd/learned.toml || fail "what it saved is something else"
[ "$(property Result) $(property ExecMainStatus)" = "success 0" ] || fail "it did not end cleanly"
echo "stopped cleanly"

# With real-time manners: the loop alone is real-time, its memory stays where it is.
mkdir -p /etc/systemd/system/gripd.service.d
cp /var/tmp/drive/realtime.conf /etc/systemd/system/gripd.service.d/
printf '[service]\nlock_memory = true\nmetrics = "/run/gripd/metrics"\n' >> /etc/gripd/gripd.toml
systemctl daemon-reload
systemctl start gripd || fail "it does not start with real-time manners"
within 5 "no status text" says "is up"
[ -S /run/gripd/metrics ] || fail "no socket for the metrics"
main=$(property MainPID)
for task in /proc/"$main"/task/*; do
    policy=$(sed 's/.*) //' "$task/stat" | cut -d ' ' -f 39)
    case ${task##*/} in "$main") wanted=1 ;; *) wanted=0 ;; esac
    [ "$policy" = "$wanted" ] || fail "thread $(cat "$task/comm") has policy $policy"
done
[ "$(awk '$1 == "VmLck:" { print $2 }' "/proc/$main/status")" -gt 1000 ] || fail "its memory is not locked"
canplayer -I /var/tmp/drive/drive.log vcan0=vcan0 & player=$!
publishes || fail "it does not publish with real-time manners"
kill $player 2>/dev/null
systemctl stop gripd
[ ! -e /run/gripd ] || fail "/run/gripd is still there"
echo "real-time, with locked memory and metrics"

# Starting again and again does not cure a wrong configuration.
echo "nonsense = 1" >> /etc/gripd/gripd.toml
systemctl start gripd 2>/dev/null && fail "a wrong configuration is accepted"
sleep 2
[ "$(property ActiveState) $(property NRestarts) $(property ExecMainStatus)" = "failed 0 2" ] || fail "a wrong configuration is tried again and again"
echo "a wrong configuration fails once, with status 2"

if [ -e $deb ]; then
    sed -i '$d' /etc/gripd/gripd.toml
    systemctl reset-failed gripd
    systemctl start gripd || fail "it does not start before the upgrade"
    old=$(property MainPID)
    package "install it again" -i $deb
    within 10 "the upgrade does not restart it" new_pid
    grep -q lock_memory /etc/gripd/gripd.toml || fail "the upgrade lost the configuration"
    package "remove it" -r gripd
    [ "$(property ActiveState) $(property LoadState)" != "active loaded" ] || fail "it runs on without its program"
    [ ! -e /usr/bin/gripd ] && [ -s /etc/gripd/gripd.toml ] || fail "removing leaves the program, or takes the configuration"
    package "purge it" -P gripd
    [ ! -e /etc/gripd/gripd.toml ] && [ ! -e /var/lib/private/gripd ] || fail "purging leaves something"
    echo "upgraded, which restarts it; removed, which stops it; purged"
fi
PROBE
tests/vcan/vcan-systemd.sh -t 600 "$work/setup" "$work/probe"
