//! Linker set-up: cortex-m-rt's script, which includes `memory.x`, and a check that it is the one of this folder.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rerun-if-changed=part.x");
    let folder = std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR");
    println!("cargo:rustc-link-search={folder}");
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=-Tpart.x");
    // Sections need not be page-aligned in flash.
    println!("cargo:rustc-link-arg-bins=--nmagic");
}
