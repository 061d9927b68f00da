#!/bin/sh
# cargo 1.95.0: `cargo package -p one -p two`, where `two` depends on `one`, compiles `two` against the `one` of the first time that it was
# run, until the version changes.
#
# It unpacks the packages of the workspace into the sources of its home folder, by name and version, and does not look again. So the
# check that packages compile fails on what is right, or passes on what is wrong.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# A home of its own: the one of whoever runs this stays as it is.
export CARGO_HOME="$folder/home"
mkdir -p "$folder/work/one/src" "$folder/work/two/src"
cd "$folder/work"
cat > Cargo.toml <<'END'
[workspace]
members = ["one", "two"]
resolver = "2"
END
crate() {
    printf '[package]\nname = "%s"\nversion = "0.0.1"\nedition = "2021"\ndescription = "x"\nlicense = "MIT"\n' "$1"
}
crate finding-one-2dd7b08 > one/Cargo.toml
{ crate finding-two-2dd7b08; printf '[dependencies]\nfinding-one-2dd7b08 = { path = "../one", version = "0.0.1" }\n'; } > two/Cargo.toml
package() {
    cargo package --quiet --allow-dirty -p finding-one-2dd7b08 -p finding-two-2dd7b08 2> ../seen
}
echo 'pub fn old() {}' > one/src/lib.rs
echo 'pub fn calls() { finding_one_2dd7b08::old() }' > two/src/lib.rs
package || { cat ../seen; echo "changed: it does not package several crates"; exit 1; }
echo "$(cargo --version): two crates package"
echo 'pub fn new() {}' > one/src/lib.rs
echo 'pub fn calls() { finding_one_2dd7b08::new() }' > two/src/lib.rs
cargo check --quiet || { echo "the example is wrong"; exit 1; }
if package; then
    echo "changed: both are compiled as they are now"
    exit 1
fi
grep -q 'cannot find function `new`' ../seen || { cat ../seen; echo "changed: it fails for another reason"; exit 1; }
echo "both changed together, they compile in the workspace, and do not package:"
grep -m 1 '^error' ../seen
