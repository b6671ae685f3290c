#!/bin/sh
# all.sh [OPTION...]
#
# Every test that needs vcan0 (natively where the kernel has one, else in a small virtual machine). The options are for the
# tests; with any, as for long runs, the systemd unit after them (where this machine has systemd).
set -eu
cd "$(dirname "$0")/../.."
arch=$(uname -m | tr '[:lower:]' '[:upper:]')
export "CARGO_TARGET_${arch}_UNKNOWN_LINUX_GNU_RUNNER=$PWD/tests/vcan/run.sh"
export VCAN_TIMEOUT="${VCAN_TIMEOUT:-1200}"
cargo test --locked --test vcan -- "$@"
[ $# = 0 ] || tests/systemd.sh "${CARGO_TARGET_DIR:-target}/debug/gripd"
