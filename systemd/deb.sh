#!/bin/sh
# systemd/deb.sh [--gateway] [PROGRAM]
#
# Makes target/debian/gripd_VERSION_ARCH.deb as [package.metadata.deb] of Cargo.toml has it: program, unit,
# configuration, DBC, manual pages, completions, guide. With --gateway gripd-gateway_VERSION_ARCH.deb, which has the
# service and no tools. With cargo-deb where that is installed (`cargo install cargo-deb`), else with dpkg-deb and the
# Python of tests/setup.sh. PROGRAM is the gripd to pack; without it, target/release/gripd is built.
set -eu
cd "$(dirname "$0")/.."
variant=
[ "${1:-}" != --gateway ] || { variant=gateway; shift; }
program=${1:-}
[ -n "$program" ] || {
    cargo build --release --locked -p gripd ${variant:+--no-default-features}
    program=${CARGO_TARGET_DIR:-target}/release/gripd
}

# What is made, not written: cargo-deb takes it from here.
made=target/package
rm -rf "$made"
mkdir -p "$made/man" "$made/completions"
cp "$program" "$made/gripd"
strip "$made/gripd" 2>/dev/null || :
[ -n "$variant" ] || {
    # Cargo puts the library that goes into FMUs beside the other libraries of the program.
    folder=$(dirname "$program")
    library=$folder/deps/libgripd_fmu.so
    [ -f "$library" ] || library=$folder/libgripd_fmu.so
    cp "$library" "$made/libgripd_fmu.so"
    strip "$made/libgripd_fmu.so" 2>/dev/null || :
    "$program" man "$made/man"
    "$program" completions bash > "$made/completions/gripd"
    "$program" completions zsh > "$made/completions/_gripd"
    "$program" completions fish > "$made/completions/gripd.fish"
}
# Beside its DBC, under /etc/gripd.
sed 's#\.\./dbc/demo\.dbc#demo.dbc#' config/demo.toml > "$made/gripd.toml"

if cargo deb --version >/dev/null 2>&1; then
    exec cargo deb --no-build --no-strip ${variant:+--variant=$variant} --output target/debian/
fi
exec python3 systemd/deb.py $variant
