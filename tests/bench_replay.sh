#!/bin/sh
# tests/bench_replay.sh [RUNS [COPIES]]
#
# How fast `gripd replay` is, beside what can-utils' `log2asc` needs to read the same file and to write
# it again: the RAV4's recording (../shared, or $GRIPD_SHARED) over and over, time going on (20 copies,
# 20 min), read, decoded, estimated and published into a file. RUNS (7) runs of each, by turns, so that
# both meet the same machine; prints the medians and their ratio. A measurement, not a test: not in CI.
set -eu
cd "$(dirname "$0")/.."
runs=${1:-7} copies=${2:-20}
. tests/vcan/fetch.sh
fetch
log=${GRIPD_SHARED:-../shared}/recordings/rav4/bus0.log.gz
[ -e "$log" ] || { echo "no $log (set GRIPD_SHARED)" >&2; exit 1; }
cargo build --release --locked --quiet
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The recording's stamps are counted on by its length and one mean pause.
gunzip -c "$log" > "$work/once.log"
awk -v copies="$copies" '
    { stamp[NR] = substr($1, 2, length($1) - 2) + 0; rest[NR] = $2 " " $3 }
    END {
        length_s = (stamp[NR] - stamp[1]) * NR / (NR - 1)
        for (copy = 0; copy < copies; copy++)
            for (line = 1; line <= NR; line++) printf "(%.6f) %s\n", stamp[line] + copy * length_s, rest[line]
    }' "$work/once.log" > "$work/long.log"
frames=$(wc -l < "$work/long.log")
echo "$frames frames, $(wc -c < "$work/long.log") bytes"

seconds() { # COMMAND…: its wall time
    begun=$(date +%s.%N)
    "$@" > /dev/null 2> "$work/stderr" || { cat "$work/stderr" >&2; exit 1; }
    echo "$begun $(date +%s.%N)" | awk '{ printf "%.4f\n", $2 - $1 }'
}
gripd() { seconds target/release/gripd replay -q -c config/rav4.toml "$work/long.log" -o "$work/out.log"; }
log2asc() { seconds "$CACHE/bin/log2asc" -I "$work/long.log" -O "$work/out.asc" can0; }
median() { sort -n "$1" | awk '{ value[NR] = $1 } END { print (value[int((NR + 1) / 2)] + value[int((NR + 2) / 2)]) / 2 }'; }

gripd > /dev/null
log2asc > /dev/null
for _ in $(seq "$runs"); do
    gripd >> "$work/gripd"
    log2asc >> "$work/log2asc"
done
ours=$(median "$work/gripd") theirs=$(median "$work/log2asc")
echo "$ours $theirs $frames" | awk '{
    printf "gripd replay: %.3f s, %.2f million frames/s\nlog2asc:      %.3f s, %.2f million frames/s\n", $1, $3 / $1 / 1e6, $2, $3 / $2 / 1e6
    printf "gripd needs %.2f of the time of log2asc\n", $1 / $2
}'
