#!/bin/sh
# Every test, with all the set-up they need: first those that need no CAN, then those on a real
# vcan0 (natively where the kernel has one, else in a small virtual machine), then the systemd unit
# (where this machine has systemd).
set -eu
cd "$(dirname "$0")/.."
tests/setup.sh
cargo test --locked
arch=$(uname -m | tr '[:lower:]' '[:upper:]')
export "CARGO_TARGET_${arch}_UNKNOWN_LINUX_GNU_RUNNER=$PWD/tests/vcan/run.sh"
export VCAN_TIMEOUT="${VCAN_TIMEOUT:-600}"
cargo test --locked --test 'vcan*'
exec tests/systemd.sh target/debug/gripd
