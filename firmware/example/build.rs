//! Names the linker script of the board, which `profivac-board` has.

fn main() {
    if std::env::var_os("CARGO_FEATURE_QEMU").is_some() {
        println!("cargo:rustc-link-arg-bins=-Tqemu.ld");
        println!("cargo:rustc-link-arg-bins=--nmagic");
    }
    println!("cargo:rerun-if-changed=build.rs");
}
