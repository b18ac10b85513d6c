//! Chooses the linker script of the board, which `profivac-board` has.

fn main() {
    for (board, script) in [("QEMU", "qemu"), ("STM32F407", "stm32f4"), ("STM32F411", "stm32f4"), ("RP2040", "rp2040")]
    {
        if std::env::var_os(format!("CARGO_FEATURE_{board}")).is_some() {
            println!("cargo:rustc-link-arg-bins=-T{script}.ld");
            println!("cargo:rustc-link-arg-bins=--nmagic");
        }
    }
    println!("cargo:rerun-if-changed=build.rs");
}
