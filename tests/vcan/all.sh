#!/bin/sh
# Every test that needs vcan0 (natively where the kernel has one, else in a small virtual machine), then the systemd unit
# (where this machine has systemd).
set -eu
cd "$(dirname "$0")/../.."
arch=$(uname -m | tr '[:lower:]' '[:upper:]')
export "CARGO_TARGET_${arch}_UNKNOWN_LINUX_GNU_RUNNER=$PWD/tests/vcan/run.sh"
export VCAN_TIMEOUT="${VCAN_TIMEOUT:-900}"
cargo test --locked --test 'vcan*'
exec tests/systemd.sh "${CARGO_TARGET_DIR:-target}/debug/gripd"
