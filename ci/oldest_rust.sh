#!/usr/bin/env bash
# Builds each library with the oldest Rust that its manifest names, where that differs from the one of the workspace:
# ci/oldest_rust.sh. Installs these toolchains with rustup. Builds below target/oldest, so other builds stay valid.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

status=0
for manifest in crates/*/Cargo.toml; do
    version=$(sed -n 's/^rust-version = "\(.*\)"$/\1/p' "$manifest")
    if [ -z "$version" ]; then continue; fi
    package=$(sed -n 's/^name = "\(.*\)"$/\1/p' "$manifest" | head -n 1)
    if ! rustup run "$version" rustc --version >/dev/null 2>&1; then
        rustup toolchain install "$version" --profile minimal --no-self-update >/dev/null
    fi
    if CARGO_TARGET_DIR="target/oldest/$version" rustup run "$version" cargo check --quiet --locked --package "$package"; then
        echo "$package builds with Rust $version"
    else
        echo "$package does not build with Rust $version"
        status=1
    fi
done
exit "$status"
