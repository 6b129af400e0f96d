//! Names the linker script of the board's crate.

fn main() {
    println!("cargo:rustc-link-arg=-Tt4link.x");
    println!("cargo:rerun-if-changed=build.rs");
}
