#!/bin/sh
# tests/all.sh [--long]
#
# The tests, with all the set-up they need. Without --long the quick ones: some of everything. With it also those that are
# marked `long`: many seeds, long drives, systemd in the guest. Those in modules `by_hand` take minutes to hours and are
# for people, who say their names; those in modules `child` are started by other tests.
#
# The tests on vcan0 are compiled first, run beside all the others, compiling included, and have the right of way: their
# virtual machine has one processor, and waits as often as it computes. What they print comes last.
set -eu
cd "$(dirname "$0")/.."
case ${1:-} in
    '') ;;
    --long) set -- --include-ignored --skip by_hand:: --skip child:: ;;
    *) echo "all.sh: $1 is not --long" >&2; exit 2 ;;
esac
tests/setup.sh
cargo test --locked --no-run --test vcan

said=$(mktemp)
# A session of its own, to be ended as a whole. What a shell starts in the background ignores the signals of a terminal;
# the service's tests send them.
setsid env --default-signal=INT,QUIT tests/vcan/all.sh "$@" > "$said" 2>&1 & vcan=$!
trap 'status=$?; [ -z "$vcan" ] || kill -- "-$vcan" 2>/dev/null || :; cat "$said"; rm -f "$said"; exit $status' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
# Cargo compiles for one at a time. The first is past that when its tests begin.
while kill -0 "$vcan" 2>/dev/null && ! grep -q ' Running ' "$said"; do sleep 0.2; done
nice -n 10 cargo test --locked -- "$@"
status=0
wait "$vcan" || status=$?
vcan=
exit "$status"
