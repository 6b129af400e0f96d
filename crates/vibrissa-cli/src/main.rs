//! The command `vibrissa`.
fn main() {}
