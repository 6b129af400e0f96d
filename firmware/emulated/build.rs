//! Writes the memory map of the machine mps2-an500, with a stack that ends where the machine has no memory.

use std::{env, fs, path::PathBuf};

/// Stack where `STACK` does not say (bytes).
const STACK: u32 = 8192;

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    let stack = env::var("STACK").ok().and_then(|text| text.parse().ok()).unwrap_or(STACK);
    let end = 0x2000_0000 + stack;
    let text = format!(
        "MEMORY\n{{\n  FLASH : ORIGIN = 0x00000000, LENGTH = 4M\n  RAM : ORIGIN = {end:#010x}, LENGTH = 1M\n}}\n\
         _stack_start = {end:#010x};\n_stack_end = 0x20000000;\n"
    );
    fs::write(out.join("memory.x"), text).unwrap_or_else(|error| panic!("memory.x: {error}"));
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg=-Tlink.x");
    println!("cargo:rerun-if-env-changed=STACK");
    println!("cargo:rerun-if-changed=build.rs");
}
