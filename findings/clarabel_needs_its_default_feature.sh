#!/bin/sh
# clarabel 0.11.1 does not compile with `default-features = false`: an error type names `serde_json`, which only the default feature
# `serde` brings.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
mkdir src
echo 'fn main() {}' > src/main.rs
with() {
    cat > Cargo.toml <<END
[package]
name = "finding"
version = "0.0.0"
edition = "2021"

[dependencies]
clarabel = { version = "=0.11.1", $1 }

[workspace]
END
    cargo check --quiet 2> seen
}
with 'default-features = true' || { cat seen; echo "changed: it does not compile with default features either"; exit 1; }
echo "clarabel 0.11.1 compiles with default features"
if with 'default-features = false'; then
    echo "changed: it compiles without default features"
    exit 1
fi
grep -q 'serde_json' seen || { cat seen; echo "changed: it fails for another reason"; exit 1; }
echo "and without them it does not:"
grep -m 1 '^error' seen
