//! Benchmarks of the library by criterion, apart from its crates, so that their tests need not build it: `cargo bench -p vibrissa-time`.
