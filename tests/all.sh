#!/bin/sh
# Every test, with all the set-up they need. Those on vcan0 run beside all the others and have the right of way: their
# virtual machine has one processor, and waits as often as it computes. What they print comes last.
set -eu
cd "$(dirname "$0")/.."
tests/setup.sh
cargo test --locked --no-run

said=$(mktemp)
# A session of its own, to be ended as a whole. What a shell starts in the background ignores the signals of a terminal;
# the service's tests send them.
setsid env --default-signal=INT,QUIT tests/vcan/all.sh > "$said" 2>&1 & vcan=$!
trap 'status=$?; [ -z "$vcan" ] || kill -- "-$vcan" 2>/dev/null || :; cat "$said"; rm -f "$said"; exit $status' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
nice -n 10 cargo test --locked
status=0
wait "$vcan" || status=$?
vcan=
exit "$status"
