//! Long sweeps along the walls of given maps, for the other programs of this folder.
//!
//! `cargo run --release --example long_sweeps -- MAPS OUT [COUNT] [FIRST_SEED]` writes COUNT sweeps for every `MAP.geojson` of
//! the folder MAPS into the folder OUT: `MAP-sSEED.csv` and `MAP-sSEED.truth.tum`, beside a copy of the map. In each the
//! paper's whisker is pressed against a random stretch of wall and follows it for 0.3 to 1.2 m, at 300 Hz and 0.15 m/s, with
//! the lean and the pressure drawn anew every 40 mm and 5 % noise on readings. Sweeps in which one contact of the tip does
//! not explain most readings, in which a wall stops the base, or in which the whisker touches within a twentieth of its
//! length, are replaced by those of the next seed.

#[path = "../tests/data/long_sweep.rs"]
mod long_sweep;
#[path = "../tests/data/random.rs"]
mod random;

use long_sweep::long_sweep;
use std::path::Path;
use vibrissa::io::format_tum;
use vibrissa::io::log::to_csv;
use vibrissa::{Error, Result};

fn written(path: &Path, text: &str) -> Result<()> {
    std::fs::write(path, text).map_err(|error| Error::data(format!("{}: {error}", path.display())))
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let mut folder = |name: &str| arguments.next().ok_or_else(|| Error::usage(format!("the folder {name} is missing")));
    let (maps, out) = (folder("MAPS")?, folder("OUT")?);
    let mut number = || arguments.next().and_then(|word| word.parse::<u64>().ok());
    let (count, first) = (number().unwrap_or(8), number().unwrap_or(1));
    std::fs::create_dir_all(&out).map_err(|error| Error::data(error.to_string()))?;
    let files = std::fs::read_dir(&maps).map_err(|error| Error::data(error.to_string()))?;
    let mut paths: Vec<_> = files.filter_map(|file| Some(file.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "geojson"));
    paths.sort();
    for path in paths {
        let map = vibrissa::read_map(&path)?;
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        std::fs::copy(&path, Path::new(&out).join(format!("{name}.geojson")))
            .map_err(|error| Error::data(error.to_string()))?;
        let found = (first..first + 100 * count).filter_map(|seed| Some((seed, long_sweep(&map, seed)?)));
        for (seed, sweep) in found.take(count as usize) {
            let beside = |ending: &str| Path::new(&out).join(format!("{name}-s{seed}.{ending}"));
            written(&beside("csv"), &to_csv(&sweep.log))?;
            written(&beside("truth.tum"), &format_tum(&sweep.truth))?;
            println!("{name}-s{seed}: {} rows, {} touches", sweep.truth.len(), sweep.contacts.len());
        }
    }
    Ok(())
}
