#!/bin/sh
# Simulates a fleet's drives, each another one, and replays them into one Parquet table a drive.
# fleet.sh GRIPD COUNT FOLDER
set -eu
gripd=$1 count=$2 folder=$3
cd "$(dirname "$0")/../.."
mkdir -p "$folder"
export gripd folder
one=$(cat <<'SH'
"$gripd" simulate config/scenarios/demo.toml --seed "$1" -o - |
    "$gripd" replay -q -c config/demo.toml - --estimates "$folder/drive_$1.parquet"
SH
)
# On all cores.
seq 1 "$count" | xargs -P "$(nproc)" -I N sh -euc "$one" drive N
