//! The figure of a simulation: whole, safe and the same each time, whatever it is given.

use vibrissa::figure::{Outline, OutlineRole, Series, SimulationScene, simulation_figure};
use vibrissa::flow::pose::StampedPose;
use vibrissa::plane::{Pose2, Vec2};

const EMPTY: SimulationScene<'_> = SimulationScene {
    title: "a < b & \"c\"",
    caption: "",
    map: &[],
    path: &[],
    robot: &[],
    shapes: &[],
    touches: &[],
    series: &[],
    quantity: "moment, mN m",
};

fn sound(svg: &str) {
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    assert!(!svg.contains("a < b &"), "the title is escaped");
}

#[test]
fn nothing_to_show_is_shown() {
    sound(&simulation_figure(&EMPTY));
}

#[test]
fn what_is_not_finite_is_left_out() {
    let series =
        [Series { name: "w".into(), read: vec![(0.0, f64::NAN), (1.0, 2.0)], exact: vec![(f64::INFINITY, 1.0)] }];
    let touches = [Vec2::new(f64::NAN, 0.0), Vec2::new(0.1, 0.1)];
    sound(&simulation_figure(&SimulationScene { series: &series, touches: &touches, ..EMPTY }));
}

#[test]
fn everything_is_named_in_the_legend_and_drawn() {
    let points = vec![Vec2::ZERO, Vec2::new(0.4, 0.0), Vec2::new(0.4, 0.3)];
    let map = [Outline::exact(points, OutlineRole::Arena, true)];
    let path: Vec<StampedPose> = (0..5000)
        .map(|k| StampedPose { t: f64::from(k), map_from_robot: Pose2::new(0.1 + 1e-5 * f64::from(k), 0.05, 0.0) })
        .collect();
    let read: Vec<(f64, f64)> = (0..5000).map(|k| (f64::from(k), (0.01 * f64::from(k)).sin())).collect();
    let series: Vec<Series> =
        ["left", "right"].map(|name| Series { name: name.into(), read: read.clone(), exact: read.clone() }).into();
    let shapes = [vec![Vec2::new(0.1, 0.05), Vec2::new(0.1, 0.1)]];
    let touches = [Vec2::new(0.1, 0.1)];
    let scene =
        SimulationScene { map: &map, path: &path, series: &series, shapes: &shapes, touches: &touches, ..EMPTY };
    let svg = simulation_figure(&scene);
    sound(&svg);
    for word in
        ["left: recorded", "right: recorded", "whiskers along the way", "touched points", "moment, mN m", "time, s"]
    {
        assert!(svg.contains(word), "{word}");
    }
    assert!(svg.len() < 300_000, "{} bytes: long logs are thinned", svg.len());
    assert_eq!(svg, simulation_figure(&scene));
}
