#!/bin/sh
# systemd/deb.sh [--gateway] [PROGRAM]
#
# Makes target/debian/gripd_VERSION_ARCH.deb as [package.metadata.deb] of Cargo.toml has it: program, unit,
# configuration, DBC, manual pages, completions, guide. With --gateway gripd-gateway_VERSION_ARCH.deb, which has the
# service and no tools. With cargo-deb where that is installed (`cargo install cargo-deb`), else with dpkg-deb and the
# Python of tests/setup.sh. PROGRAM is the gripd to pack; without it, target/release/gripd is built.
#
# Two builds of a commit by the same compiler, packed with dpkg-deb, are the same to the byte, in whatever folders: all times
# are the commit's (or SOURCE_DATE_EPOCH), and no path of this machine is in the program. Who answers for the package is told
# by DEBFULLNAME and DEBEMAIL, as Debian's own tools have it; without them it is the maintainer of Cargo.toml, who has no address.
set -eu
cd "$(dirname "$0")/.."
variant=
[ "${1:-}" != --gateway ] || { variant=gateway; shift; }
program=${1:-}
umask 022
export LC_ALL=C SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)}"
[ -n "$program" ] || {
    export RUSTFLAGS="--remap-path-prefix=$PWD=/gripd --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=/cargo ${RUSTFLAGS:-}"
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

name=gripd${variant:+-$variant}
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)-$(sed -n 's/^revision = "\(.*\)"/\1/p' Cargo.toml)
maintainer=$(sed -n 's/^maintainer = "\(.*\)"/\1/p' Cargo.toml)
[ -z "${DEBEMAIL:-}" ] || maintainer="${DEBFULLNAME:-$DEBEMAIL} <$DEBEMAIL>"
gzip -9n < CHANGELOG.md > "$made/changelog.gz"
cat > "$made/changelog.Debian" <<END
$name ($version) unstable; urgency=medium

  * See changelog.gz.

 -- $maintainer  $(date -u -R -d "@$SOURCE_DATE_EPOCH")
END
cp systemd/lintian-overrides "$made/lintian-overrides"
[ -z "$variant" ] || printf '%s\n' '# Only the tools can write manual pages; the guide has one for gateways.' no-manual-page \
    >> "$made/lintian-overrides"

if [ -z "${DEBEMAIL:-}" ] && cargo deb --version >/dev/null 2>&1; then
    exec cargo deb --no-build --no-strip ${variant:+--variant=$variant} --output target/debian/
fi
exec python3 systemd/deb.py "$maintainer" $variant
