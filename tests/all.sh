#!/bin/sh
# tests/all.sh [--long] [COMMAND...]
#
# The tests, with all the set-up they need. Without --long the quick ones: some of everything. With it also those that are
# marked `long`: many seeds, long drives, systemd in the guest. Those in modules `by_hand` take minutes to hours and are
# for people, who say their names; those in modules `child` are started by other tests.
#
# The tests on vcan0 are compiled first, run beside all the others, compiling included, and have the right of way: their
# virtual machine has one processor, and waits more than it computes. What they print comes last. COMMAND, which must
# pass, too, runs beside them before the others.
set -eu
cd "$(dirname "$0")/.."
options=
case ${1:-} in
    --long) shift; options="--include-ignored --skip by_hand:: --skip child::" ;;
    -*) echo "all.sh: $1 is not --long" >&2; exit 2 ;;
esac
tests/setup.sh
cargo test --locked --no-run --test vcan

said=$(mktemp)
# A session of its own, to be ended as a whole. What a shell starts in the background ignores the signals of a terminal;
# the service's tests send them.
# shellcheck disable=SC2086  # a list of options
setsid env --default-signal=INT,QUIT tests/vcan/all.sh $options > "$said" 2>&1 & vcan=$!
trap 'status=$?; [ -z "$vcan" ] || kill -- "-$vcan" 2>/dev/null || :; cat "$said"; rm -f "$said"; exit $status' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
# Cargo compiles for one at a time. The first is past that when its tests begin.
while kill -0 "$vcan" 2>/dev/null && ! grep -q ' Running ' "$said"; do sleep 0.2; done
[ $# = 0 ] || nice -n 10 "$@"
# shellcheck disable=SC2086
nice -n 10 cargo test --locked -- $options
status=0
wait "$vcan" || status=$?
vcan=
exit "$status"
