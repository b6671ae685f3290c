#!/bin/sh
# tests/fuzz/run.sh READER [SECONDS]
#
# Fuzzes a reader of gripd (recording, dbc, config, state, scenario, tires, fmu) for so long, 60 s unless told, guided by what the inputs
# reach (libFuzzer, on a stable compiler). It begins with the files that the tests have, and goes on where an earlier run ended: what
# reached something new is kept under target/fuzz/corpus. An input that fails is written to target/fuzz/READER-….
# Needs a C++ compiler. Asked by hand.
set -eu
reader=${1:?run.sh READER [SECONDS]}
seconds=${2:-60}
cd "$(dirname "$0")/../.."
fuzz=$PWD/target/fuzz
kept=$fuzz/corpus/$reader
seeds=$fuzz/seeds/$reader
mkdir -p "$kept" "$seeds"
case $reader in
    recording) cp tests/formats/fuzz/corpus/recordings/* tests/formats/fuzz/corpus/candump/* "$seeds" ;;
    dbc) cp tests/formats/fuzz/corpus/dbc/* dbc/gripd.dbc dbc/rav4.dbc "$seeds" ;;
    config) cp tests/formats/fuzz/corpus/toml/* config/rav4.toml config/vw_mqb.toml "$seeds" ;;
    # The checksum in the first line is made anew.
    state) for file in tests/data/state/*; do tail -n +2 "$file" > "$seeds/$(basename "$file")"; done ;;
    scenario) cp config/scenarios/*.toml "$seeds" ;;
    tires | fmu) cp tests/formats/fuzz/corpus/"$reader"/* "$seeds" ;;
esac

# Counters at every edge, and what is compared with what.
flags="-Cpasses=sancov-module"
for option in level=4 inline-8bit-counters pc-table trace-compares; do
    flags="$flags -Cllvm-args=-sanitizer-coverage-$option"
done
# In the versions that gripd is built of.
cp Cargo.lock tests/fuzz/
# A target of its own: build scripts and macros are not counted.
RUSTFLAGS="$flags" cargo build --release --manifest-path tests/fuzz/Cargo.toml --target "$(rustc -vV | sed -n 's/host: //p')" \
    --target-dir "$fuzz/build"
cd "$fuzz"
GRIPD_FUZZ_READER=$reader exec build/*/release/gripd-fuzz "$kept" "$seeds" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=4096 \
    -artifact_prefix="$fuzz/$reader-" -print_final_stats=1
