//! Calibration of the simulated sensor: flux to moment, moment to the tip's retreat.

use super::report::{dots, line};
use super::{Section, ground};
use vibrissa::beam::Whisker;
use vibrissa::config::CurveOptions;
use vibrissa::figure::chart_plate;
use vibrissa::plane::Vec2;
use vibrissa::sensing::{Chip, Mlx90393, SensingChain, Tle493d};
use vibrissa::tasks::calibrate::{Explained, Labelled, fit_moment_curve, fit_tip_deflection};
use vibrissa::world::calibration::MomentCurve;
use vibrissa::{Error, Result};

/// Contacts: the paper's n = 1000, on a grid of arc lengths by deflections.
const ALONG: usize = 20;
const ACROSS: usize = 50;
/// Nearest and farthest distance of a contact as shares of the whisker, and its largest angle seen from the base (rad).
const NEAREST: f64 = 0.45;
const FARTHEST: f64 = 0.97;
const WIDEST: f64 = 0.35;
/// A field in which every chip saturates (T).
const LARGE_FIELD: f64 = 1.0;

pub(super) fn section() -> Result<Section> {
    let mut section = Section::new("calibration", "Calibration of the sensor");
    let whisker = Whisker::default();
    let chain = SensingChain::default();
    let mut labelled = Labelled {
        source: "simulated contacts".into(),
        contacts: contacts(&whisker),
        inputs: ["bx", "by", "bz"].map(str::to_owned).to_vec(),
        readings: Vec::new(),
        angles: Vec::new(),
        moments: None,
    };
    let explained = labelled.explain(&whisker)?;
    // The chip rounds to counts: that is all the noise there is.
    let read = |moment: f64| chain.chip.flux(chain.chip.counts(chain.flux(moment))).to_vec();
    labelled.contacts = explained.iter().map(|e| labelled.contacts[e.row]).collect();
    let explained: Vec<Explained> = explained.iter().enumerate().map(|(row, e)| Explained { row, ..*e }).collect();
    labelled.readings = explained.iter().map(|e| read(e.moment)).collect();
    let curve = fit_moment_curve(&labelled, &explained, &CurveOptions::default())?;
    let retreat = fit_tip_deflection(&explained).ok_or_else(|| Error::data("no contact bends the whisker"))?;
    section.show(
        "curves",
        [
            "Figure “sensorCalibration”: (a) flux density to bending moment, (b) bending moment to δx, from a real sensor. \
             The figure's values are not told.",
            "A simulated MLX90393 under a magnet on a rubber disc, labelled contacts in point mode as in the paper, and the \
             fitted curves.",
            "The magnet, its place and the rubber's stiffness are ours. The simulated sensor has no hysteresis and no creep; \
             its noise is one count.",
        ],
        vec![moments(&labelled, &explained, &curve), retreats(&explained, &|moment| retreat.at(moment).unwrap_or(f64::NAN))],
    );
    let largest = explained.iter().map(|e| e.moment.abs()).fold(0.0, f64::max);
    section.compare(
        "Labelled contacts",
        "contacts",
        (1000.0, explained.len() as f64),
        (0, ""),
        "A grid of arc lengths and deflections, all within reach.",
    );
    section.find(
        "Residual of the curve from flux to moment, of the largest moment",
        "residual",
        "a curve without an error",
        (1e2 * curve.residual_rms / largest, 4, "%"),
        "Rounding to counts is all that disturbs the simulated sensor.",
    );
    chips(&mut section);
    let spread = largest_spread(&explained);
    section.find(
        "δx that one moment leaves open (contacts anywhere on the whisker)",
        "spread",
        "“not one-to-one”",
        (1e3 * spread, 2, "mm"),
        "Stated by the paper without a number; contacts near the tip alone give a curve.",
    );
    Ok(section)
}

/// The chips that the paper names, as the simulator has them.
fn chips(section: &mut Section) {
    let mlx = |gain, resolution| Chip::Mlx90393(Mlx90393 { gain, resolution, ..Mlx90393::default() });
    let tle = Chip::Tle493d(Tle493d::default());
    let range = |chip: &Chip| 1e3 * chip.range()[0];
    // Bits of all register values between these fields.
    let bits = |chip: &Chip, flux: f64| {
        let at = |flux: f64| f64::from(chip.counts([flux; 3])[0]);
        (at(flux) - at(-flux) + 1.0).log2()
    };
    let reason = "Sensitivity of the data sheet times the registers' range.";
    let (finest, coarsest) = (mlx(7, 0), mlx(0, 3));
    section.compare("MLX90393: smallest range", "mlx.least", (5.0, range(&finest)), (1, "mT"), reason);
    section.compare(
        "MLX90393: largest range",
        "mlx.most",
        (50.0, range(&coarsest)),
        (1, "mT"),
        "Across the chip, where its converter saturates.",
    );
    section.compare("MLX90393: resolution", "mlx.bits", (16.0, bits(&finest, finest.range()[0])), (0, "bit"), reason);
    section.compare("TLE493D: range", "tle.range", (160.0, range(&tle)), (0, "mT"), "The data sheet's.");
    section.compare(
        "TLE493D: resolution",
        "tle.bits",
        (12.0, bits(&tle, LARGE_FIELD)),
        (0, "bit"),
        "All register values.",
    );
}

/// Contacts on both sides of the whisker, up to a little less than its reach.
fn contacts(whisker: &Whisker) -> Vec<Vec2> {
    let share = |i: usize, n: usize| i as f64 / (n - 1) as f64;
    let at = |along: usize, across: usize| {
        let distance = whisker.length * (NEAREST + (FARTHEST - NEAREST) * share(along, ALONG));
        let angle = WIDEST * (2.0 * share(across, ACROSS) - 1.0);
        // Deflected contacts of one arc length lie a little nearer to the base.
        distance * (1.0 - 0.25 * angle * angle) * Vec2::from_angle(angle)
    };
    (0..ALONG).flat_map(|along| (0..ACROSS).map(move |across| at(along, across))).collect()
}

/// The widest range of retreats within a hundredth of the range of moments (m).
fn largest_spread(explained: &[Explained]) -> f64 {
    let mut sorted: Vec<&Explained> = explained.iter().collect();
    sorted.sort_by(|a, b| a.moment.total_cmp(&b.moment));
    let width = 0.01 * sorted.last().map_or(0.0, |e| e.moment);
    let within = |from: usize| {
        let same = sorted[from..].iter().take_while(|e| e.moment <= sorted[from].moment + width).map(|e| e.retreat);
        let (lo, hi) = same.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
        hi - lo
    };
    (0..sorted.len()).map(within).fold(0.0, f64::max)
}

fn moments(labelled: &Labelled, explained: &[Explained], curve: &MomentCurve) -> String {
    let read: Vec<(f64, f64)> =
        explained.iter().map(|e| (1e3 * curve.signal(&labelled.readings[e.row]), 1e3 * e.moment)).collect();
    let [lo, hi] = curve.valid();
    let fitted = (0..=80).map(|i| lo + (hi - lo) * f64::from(i) / 80.0).map(|s| (1e3 * s, 1e3 * curve.at(s))).collect();
    chart_plate(
        "(a) Flux density to bending moment",
        "change of flux density, mT",
        "M(0), mN m",
        &[dots("labelled contacts", "touch", ground::thinned(&read, 400)), line("fitted curve", "series hue0", fitted)],
    )
}

fn retreats(explained: &[Explained], fitted: &dyn Fn(f64) -> f64) -> String {
    let all: Vec<(f64, f64)> = explained.iter().map(|e| (1e3 * e.moment, 1e3 * e.retreat)).collect();
    let (lo, hi) = all.iter().fold((0.0_f64, 0.0_f64), |(lo, hi), p| (lo.min(p.0), hi.max(p.0)));
    let curve = (0..=80).map(|i| lo + (hi - lo) * f64::from(i) / 80.0).map(|m| (m, 1e3 * fitted(1e-3 * m))).collect();
    chart_plate(
        "(b) Bending moment to the tip's retreat δx",
        "M(0), mN m",
        "δx, mm",
        &[
            dots("labelled contacts", "touch", ground::thinned(&all, 400)),
            line("even polynomial through all", "series hue0", curve),
        ],
    )
}
