//! The command line.

use crate::cells::{Cell, ERRORS, LAWS};
use std::path::PathBuf;
use vibrissa::Method;
use vibrissa::config::{NoiseAssumption, UndeclaredErrors};
use vibrissa::sim::recorder::NoiseLaw;

pub(crate) const HELP: &str = "\
  --runs N            worlds, 200 unless said otherwise; --short has 12
  --seed S            the first seed, 1
  --method A,B        probabilistic,possibilistic; or deterministic
  --laws A,B          rows of the first table: all, none, or their words
  --errors A,B        rows of the second table, likewise
  --exact             the probabilistic method takes what the robot does not bound for exact
  --independent       the probabilistic method takes errors of the readings for independent
  --noise LAW         how readings err in the second table beside what nobody declared: none
  --declared R        the declared relative bound of the readings, 0.05
  --threads N         all of the machine's
  --short             the form for continuous integration, with fewer worlds and rows; the exit code is 1 where a promise is broken
  --free HOURS        a whisker that is free, and one that is touched now and then: no contact made up, none missed
  --worlds            what the worlds are, and nothing else
  --each              a line for each run that is off, wrong or inconsistent, or whose truth is not held
  --logs DIR          a folder for each of these: log.csv, map.geojson, robot.toml, truth.tum
  --json FILE         the tables in SI units";

/// Worlds of a full run and of a short one.
const RUNS: usize = 200;
const SHORT: usize = 12;
/// The rows of a short run.
const SHORT_LAWS: &str = "none,two_point,ar1_0.5,sine,hysteresis,odometry,drift";
const SHORT_ERRORS: &str = "gain_20,zero_0.3,mount_5,map_10,slip,wrong_map";

pub(crate) struct Call {
    pub(crate) runs: usize,
    pub(crate) seed: u64,
    pub(crate) methods: Vec<Method>,
    pub(crate) laws: Vec<Cell>,
    pub(crate) errors: Vec<Cell>,
    pub(crate) noise: NoiseLaw,
    pub(crate) declared: f64,
    pub(crate) threads: usize,
    pub(crate) judge: bool,
    pub(crate) free: Option<f64>,
    pub(crate) worlds: bool,
    pub(crate) each: bool,
    pub(crate) logs: Option<PathBuf>,
    pub(crate) json: Option<PathBuf>,
}

impl Call {
    pub(crate) fn parse(mut words: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut call = Self {
            runs: RUNS,
            seed: 1,
            methods: methods("probabilistic,possibilistic")?,
            laws: Vec::new(),
            errors: Vec::new(),
            noise: NoiseLaw::Exact,
            declared: 0.05,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            judge: false,
            free: None,
            worlds: false,
            each: false,
            logs: None,
            json: None,
        };
        let (mut runs, mut laws, mut errors, mut independent) = (None, None, None, false);
        let mut undeclared = UndeclaredErrors::default();
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} needs a value"));
            match word.as_str() {
                "--runs" => runs = Some(number(&word, &value()?, 1.0, 1e6)? as usize),
                "--seed" => call.seed = number(&word, &value()?, 0.0, 1e15)? as u64,
                "--method" => call.methods = methods(&value()?)?,
                "--laws" => laws = Some(value()?),
                "--errors" => errors = Some(value()?),
                "--noise" => {
                    let word = value()?;
                    call.noise =
                        NoiseLaw::from_word(&word).ok_or(format!("--noise {word}: one of {:?}", NoiseLaw::WORDS))?;
                }
                "--declared" => call.declared = number(&word, &value()?, 0.0, 0.99)?,
                "--threads" => call.threads = number(&word, &value()?, 1.0, 256.0)? as usize,
                "--exact" => undeclared = UndeclaredErrors::None,
                "--independent" => independent = true,
                "--short" => call.judge = true,
                "--free" => call.free = Some(number(&word, &value()?, 0.0, 1e5)?),
                "--worlds" => call.worlds = true,
                "--each" => call.each = true,
                "--logs" => (call.each, call.logs) = (true, Some(value()?.into())),
                "--json" => call.json = Some(value()?.into()),
                _ => return Err(format!("unknown word {word}")),
            }
        }
        for method in &mut call.methods {
            if let Method::Probabilistic(options) = method {
                options.undeclared = undeclared;
                options.noise_model =
                    if independent { NoiseAssumption::Independent } else { NoiseAssumption::Correlated };
            }
        }
        let [all_laws, all_errors] = if call.judge { [SHORT_LAWS, SHORT_ERRORS] } else { ["all", "all"] };
        call.laws = cells(laws.as_deref().unwrap_or(all_laws), &LAWS)?;
        call.errors = cells(errors.as_deref().unwrap_or(all_errors), &ERRORS)?;
        call.runs = runs.unwrap_or(if call.judge { SHORT } else { RUNS });
        Ok(call)
    }
}

fn number(word: &str, text: &str, least: f64, most: f64) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|error| format!("{word} {text}: {error}"))?;
    if (least..=most).contains(&value) { Ok(value) } else { Err(format!("{word} {text}: allowed {least} to {most}")) }
}

fn methods(words: &str) -> Result<Vec<Method>, String> {
    let of = |word: &str| {
        Ok(match word {
            "probabilistic" => Method::Probabilistic(Default::default()),
            "possibilistic" => Method::Possibilistic(Default::default()),
            "deterministic" => Method::Deterministic(Default::default()),
            _ => return Err(format!("--method {word}: probabilistic, possibilistic or deterministic")),
        })
    };
    words.split(',').map(of).collect()
}

fn cells(words: &str, all: &[Cell]) -> Result<Vec<Cell>, String> {
    if words == "all" {
        return Ok(all.to_vec());
    }
    // `none` alone is no table; the row without an error is asked for among others.
    if words == "none" {
        return Ok(Vec::new());
    }
    let of = |word: &str| {
        let known = || all.iter().map(|cell| cell.word).collect::<Vec<_>>().join(", ");
        all.iter().find(|cell| cell.word == word).copied().ok_or_else(|| format!("{word}: one of {}", known()))
    };
    words.split(',').map(of).collect()
}
