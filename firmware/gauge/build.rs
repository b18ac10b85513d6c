//! Chooses the linker script of the board.

fn main() {
    for board in ["qemu", "stm32f4", "rp2040"] {
        if std::env::var_os(format!("CARGO_FEATURE_{}", board.to_uppercase())).is_some() {
            println!("cargo:rustc-link-arg-bins=-T{board}.ld");
        }
    }
    if std::env::var_os("CARGO_FEATURE_DEFMT").is_some() {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
    println!("cargo:rustc-link-arg-bins=--nmagic");
    println!("cargo:rerun-if-changed=build.rs");
}
