//! Tells the linker where the scripts of the boards are.

fn main() {
    println!("cargo:rustc-link-search={}", env!("CARGO_MANIFEST_DIR"));
    println!("cargo:rerun-if-changed=sections.ld");
    println!("cargo:rerun-if-changed=qemu.ld");
    println!("cargo:rerun-if-changed=stm32f4.ld");
    println!("cargo:rerun-if-changed=rp2040.ld");
}
