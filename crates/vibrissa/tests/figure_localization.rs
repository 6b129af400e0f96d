//! The localization figure on made-up answers; each picture is left in cargo's folder for test files, to be looked at.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use std::path::Path;
use vibrissa::figure::localization::verdict;
use vibrissa::figure::{FilmFrame, LocalizationScene, Outline, OutlineRole, localization_figure, localization_film};
use vibrissa::flow::pose::{Event, Hypothesis, Localization, ShapeRecord, StampedPose, Status, Stretch};
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::sets::{Interval, StateBox};

/// A linear congruential generator: the test needs scatter, not quality.
struct Scatter(u64);

impl Scatter {
    fn next(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn map() -> Vec<Outline> {
    let bays = (0..=60).map(|i| {
        let x = 0.2 - 0.4 * f64::from(i) / 60.0;
        Vec2::new(
            x,
            0.1 + 0.03 * (-((x - 0.09) / 0.03f64).powi(2)).exp() - 0.02 * (-((x + 0.08) / 0.04f64).powi(2)).exp(),
        )
    });
    let arena = [Vec2::new(-0.2, -0.15), Vec2::new(0.23, -0.15)].into_iter().chain(bays).collect();
    let disc = (0..40).map(|i| Vec2::new(-0.1, -0.07) + Vec2::from_angle(-f64::from(i) * 0.157) * 0.03).collect();
    let wall = vec![Vec2::new(0.1, -0.15), Vec2::new(0.12, -0.09)];
    vec![
        Outline::exact(arena, OutlineRole::Arena, true),
        Outline::exact(disc, OutlineRole::Obstacle, true),
        Outline::exact(wall, OutlineRole::Wall, false),
    ]
}

fn sweep(offset: Vec2) -> Vec<StampedPose> {
    (0..=130)
        .map(|i| StampedPose {
            t: f64::from(i) / 300.0,
            map_from_robot: Pose2::new(0.13 - 0.001 * f64::from(i) + offset.x, 0.035 + offset.y, 1.75),
        })
        .collect()
}

fn shapes() -> Vec<ShapeRecord> {
    let bent = |i: i32| {
        let bend = 0.3 + 0.25 * (f64::from(i) * 0.07).sin();
        (0..=30)
            .map(|k| f64::from(k) / 30.0)
            .map(|s| Vec2::new(0.072 * s, -0.075 * bend * s * s * (1.0 - 0.33 * s)))
            .collect()
    };
    (0..=130).step_by(2).map(|i| ShapeRecord { t: f64::from(i) / 300.0, whisker: 0, points: bent(i) }).collect()
}

fn around(pose: Pose2, spread: f64, count: usize, scatter: &mut Scatter) -> Vec<Pose2> {
    (0..count)
        .map(|_| {
            let [x, y, theta] = [spread, spread, 8.0 * spread].map(|size| scatter.next(-size, size));
            Pose2::new(pose.x + x, pose.y + y, pose.theta + theta)
        })
        .collect()
}

fn hypothesis(poses: &[Pose2], weight: f64) -> Hypothesis {
    let extent = poses.iter().fold(StateBox::EMPTY, |set, &pose| set.including(pose));
    Hypothesis { pose: poses[0], weight, extent, covariance: None, ridge: vec![] }
}

fn empty(status: Status) -> Localization {
    Localization {
        nuisances: Vec::new(),
        consistency: None,
        unsure: Vec::new(),
        method: "deterministic",
        encloses: false,
        status,
        estimate: None,
        hypotheses: vec![],
        trajectory: vec![],
        states: vec![],
        first_states: vec![],
        steps: vec![],
        events: vec![],
        odometry: None,
        shapes: vec![],
    }
}

fn localized(places: &[(Pose2, f64, usize)], status: Status) -> Localization {
    let mut scatter = Scatter(7);
    let first_states = (0..1254)
        .map(|_| Pose2::new(scatter.next(-0.19, 0.22), scatter.next(-0.14, 0.09), scatter.next(-3.1, 3.1)))
        .collect();
    let clusters: Vec<Vec<Pose2>> =
        places.iter().map(|&(pose, spread, count)| around(pose, spread, count, &mut scatter)).collect();
    let weight = 1.0 / places.len() as f64;
    Localization {
        estimate: Some(clusters[0][0]),
        hypotheses: clusters.iter().map(|poses| hypothesis(poses, weight)).collect(),
        trajectory: sweep(Vec2::ZERO),
        states: clusters.iter().flatten().map(|&pose| StateBox::point(pose)).collect(),
        first_states,
        odometry: None,
        shapes: shapes(),
        ..empty(status)
    }
}

fn draw(name: &str, answer: &Localization, truth: Option<&[StampedPose]>) -> String {
    let robot = [Vec2::new(-0.012, -0.008), Vec2::new(0.0, -0.008), Vec2::new(0.0, 0.008), Vec2::new(-0.012, 0.008)];
    let scene =
        LocalizationScene { title: "bays & <made up>.csv on bays.geojson", map: &map(), answer, truth, robot: &robot };
    let figure = localization_figure(&scene);
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.svg"));
    std::fs::write(&file, &figure).unwrap();
    assert_eq!(figure, localization_figure(&scene), "the same scene gives the same bytes");
    well_formed(&figure);
    figure
}

/// Checks that tags nest, that no bare markup is left in text and that no number is broken.
fn well_formed(svg: &str) {
    let mut open = Vec::new();
    for piece in svg.split('<').skip(1) {
        let (tag, text) = piece.split_once('>').expect("every tag ends");
        assert!(!text.contains("NaN") && !tag.contains("NaN") && !tag.contains("inf"), "{piece}");
        for entity in text.split('&').skip(1) {
            assert!(["amp;", "lt;", "gt;", "quot;", "apos;"].iter().any(|known| entity.starts_with(known)), "{text}");
        }
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(tag.split_whitespace().next().unwrap());
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
}

#[test]
fn a_place_that_was_lost_meanwhile_is_told_with_the_verdict() {
    let event = |t: f64, kind: &'static str| Event { t, kind, detail: String::new() };
    let place = [(Pose2::new(0.0003, 0.0352, 1.752), 0.0012, 9)];
    let with = |events: Vec<Event>| Localization { events, ..localized(&place, Status::Localized) };
    let found = with(vec![event(0.1, "inconsistent"), event(0.25, "recovered"), event(0.3, "lift_off")]);
    assert!(draw("recovered", &found, None).contains("lost until t = 0.250 s"));
    for events in [vec![], vec![event(0.1, "recovered"), event(0.25, "inconsistent")]] {
        assert!(!draw("not-recovered", &with(events), None).contains("lost until"));
    }
}

#[test]
fn a_film_thins_the_images_of_a_place_alike_and_shows_the_truth() {
    // Modes and their three images by turns, as a map of four equal walls has them: too many to draw all.
    let corners = [(-0.1, -0.05), (0.1, -0.05), (-0.1, 0.05), (0.1, 0.05)];
    let states: Vec<Pose2> =
        (0..4800).map(|k| Pose2::new(corners[k % 4].0, corners[k % 4].1 + 1e-6 * k as f64, 0.0)).collect();
    let answer = localized(&[(Pose2::new(0.0003, 0.0352, 1.752), 0.0012, 9)], Status::Localized);
    let truth = sweep(Vec2::ZERO);
    let outlines = map();
    let scene = LocalizationScene { title: "film", map: &outlines, answer: &answer, truth: Some(&truth), robot: &[] };
    let frames = [FilmFrame { t: 0.2, states }, FilmFrame { t: 0.3, states: Vec::new() }];
    let film = localization_film(&scene, &frames);
    for words in ["true path", "true pose", "states that explain the log so far", "free space", "class=\"solid\""] {
        assert!(film.contains(words), "{words}");
    }
    let frame: Vec<&str> = film.lines().find(|line| line.contains("[0.200,4800,")).unwrap().split('"').collect();
    let dots: Vec<(bool, bool)> = frame[3]
        .split('M')
        .skip(1)
        .map(|dot| dot.trim_end_matches("h0").split_once(' ').unwrap())
        .map(|(x, y)| (x.parse::<f64>().unwrap(), y.parse::<f64>().unwrap()))
        .map(|(x, y)| (x > 297.0, y > 200.0))
        .collect();
    assert!(dots.len() > 1000 && dots.len() < 1210, "{}", dots.len());
    for group in [(false, false), (false, true), (true, false), (true, true)] {
        let share = dots.iter().filter(|dot| **dot == group).count() as f64 / dots.len() as f64;
        assert!((share - 0.25).abs() < 0.02, "{group:?}: {share}");
    }
    assert!(!frame[9].is_empty(), "the true pose");
}

#[test]
fn numbers_of_places_stand_beside_what_is_left() {
    // Thirty candidates of a place in a row: its number hides none of them, and its marker but the one beneath.
    let place = Pose2::new(0.05, -0.02, 0.4);
    let other = (Pose2::new(-0.1, 0.04, 2.0), 0.001, 3);
    let mut answer = localized(&[(place, 0.0001, 1), other], Status::Ambiguous);
    let row = (0..30).map(|k| StateBox::point(Pose2::new(0.02 + 0.002 * f64::from(k), -0.02, 0.4)));
    answer.states = row.collect();
    let figure = draw("numbers", &answer, None);
    let centres = |class: &str| -> Vec<(f64, f64)> {
        let of =
            figure.lines().filter(|line| line.starts_with("<circle") && line.contains(&format!("class=\"{class}\"")));
        let number =
            |line: &str, key: &str| line.split(key).nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
        of.map(|line| (number(line, "cx=\""), number(line, "cy=\""))).collect()
    };
    let dots = figure.lines().find(|line| line.contains("class=\"survivor\"") && line.starts_with("<path")).unwrap();
    let dots = dots.split('"').nth(1).unwrap().split('M').skip(1).map(|dot| {
        let (x, y) = dot.trim_end_matches("h0").split_once(' ').unwrap();
        (x.parse::<f64>().unwrap(), y.parse::<f64>().unwrap())
    });
    let dots: Vec<(f64, f64)> = dots.collect();
    let badges = centres("badge");
    assert!(dots.len() == 30 && badges.len() >= 2, "{} {}", dots.len(), badges.len());
    for badge in &badges {
        let nearest = dots.iter().map(|dot| (dot.0 - badge.0).hypot(dot.1 - badge.1)).fold(f64::INFINITY, f64::min);
        assert!(nearest > 8.5, "{badge:?}: {nearest}");
    }
}

#[test]
fn a_map_with_a_band_says_so_in_every_legend() {
    let mut outlines = map();
    let quad = [Vec2::new(0.0, 0.1), Vec2::new(0.1, 0.1), Vec2::new(0.1, 0.11), Vec2::new(0.0, 0.11)];
    outlines[0].band.push(quad);
    outlines[0].unknown.push(vec![Vec2::new(0.0, -0.15), Vec2::new(0.1, -0.15)]);
    let answer = localized(&[(Pose2::new(0.0003, 0.0352, 1.752), 0.0012, 9)], Status::Localized);
    let scene = LocalizationScene { title: "band", map: &outlines, answer: &answer, truth: None, robot: &[] };
    let scene_of_map = vibrissa::figure::map_figure("band", &[], "map frame", &outlines, &[]);
    for figure in [localization_figure(&scene), scene_of_map] {
        for words in ["band that holds the wall", "unknown stretch", "obstacle", "free space", ">wall</text>"] {
            assert!(figure.contains(words), "{words}");
        }
        well_formed(&figure);
    }
}

#[test]
fn one_place_is_shown_with_its_extent_and_the_truth() {
    let answer = localized(&[(Pose2::new(0.0003, 0.0352, 1.752), 0.0012, 9)], Status::Localized);
    let truth = sweep(Vec2::new(0.0004, -0.0003));
    let figure = draw("localized", &answer, Some(&truth));
    for words in ["9 of 1254 candidates left after 130 mm of sweep", "true path", "off the truth by 0.50 mm, 0.00°"] {
        assert!(figure.contains(words), "{words}");
    }
    assert!(figure.contains("bays &amp; &lt;made up&gt;.csv"), "the title is escaped");
    assert!(figure.matches("class=\"whisker\"").count() <= 25);
}

#[test]
fn close_ups_appear_where_the_map_dwarfs_what_they_show() {
    let mut answer = localized(&[(Pose2::new(0.0003, 0.0352, 1.752), 0.0012, 9)], Status::Localized);
    let figure = draw("long_sweep", &answer, None);
    assert!(figure.contains("Close up: the estimate") && !figure.contains("Close up: the sweep"));
    answer.trajectory.truncate(20);
    answer.shapes.truncate(10);
    assert!(draw("short_sweep", &answer, None).contains("Close up: the sweep"));
    answer.hypotheses[0].extent = StateBox { x: Interval::new(-0.2, 0.2), ..answer.hypotheses[0].extent };
    assert!(!draw("wide", &answer, None).contains("Close up: the estimate"));
}

#[test]
fn a_ridge_is_a_line_through_its_place() {
    let mut answer = localized(&[(Pose2::new(0.0, 0.035, 1.75), 0.002, 5)], Status::Ambiguous);
    let words = "where along a place the robot may be";
    assert!(!draw("no_ridge", &answer, None).contains(words));
    answer.hypotheses[0].ridge = (0..9).map(|k| Pose2::new(-0.1 + 0.02 * f64::from(k), 0.035, 1.75)).collect();
    let figure = draw("ridge", &answer, None);
    assert!(figure.contains(words) && figure.matches("class=\"ridge\"").count() >= 2, "the line and the legend");
}

#[test]
fn rivals_are_numbered_and_weighed() {
    let places = [
        (Pose2::new(0.0, 0.035, 1.75), 0.002, 5),
        (Pose2::new(-0.15, -0.1, -2.0), 0.003, 4),
        (Pose2::new(0.16, -0.05, 0.3), 0.001, 3),
    ];
    let figure = draw("ambiguous", &localized(&places, Status::Ambiguous), None);
    assert!(figure.contains("ambiguous: 3 separate places"));
    assert!(!figure.contains("true path"));
    for number in 1..=3 {
        assert!(figure.contains(&format!(">{number}</text>")), "badge {number}");
        assert!(figure.contains(&format!("{number}: 33 %,")), "row {number}");
    }
}

#[test]
fn the_picture_of_a_long_way_is_as_small_as_its_piece_of_the_world() {
    let mut answer = localized(&[(Pose2::new(0.0003, 0.0352, 1.752), 0.0012, 9)], Status::Localized);
    answer.trajectory = (0..3000).map(|i| circling(i, 0.0)).collect();
    let once = draw("one_round", &answer, Some(&answer.trajectory.clone()));
    // Two hundred rounds that never meet the same points again, and a drift of a hundredth of a page unit.
    answer.trajectory = (0..600_000).map(|i| circling(i, 1e-9)).collect();
    let often = draw("many_rounds", &answer, Some(&answer.trajectory.clone()));
    assert!(often.len() < 3 * once.len(), "{} against {} bytes", often.len(), once.len());
    // A slow way: every step is far below a page unit, the whole is not.
    answer.trajectory = (0..3000)
        .map(|i| StampedPose { map_from_robot: Pose2::new(5e-5 * f64::from(i), 0.0, 0.0), ..circling(i, 0.0) })
        .collect();
    let slow = draw("slow", &answer, None);
    let way = slow.split(" class=\"path\"").next().and_then(|s| s.rsplit("d=\"M").next()).unwrap();
    let xs: Vec<f64> = way.split('L').map(|p| p.split(' ').next().unwrap().parse().unwrap()).collect();
    assert!(xs.len() > 50 && xs[xs.len() - 1] - xs[0] > 100.0, "{way}");
}

/// A robot on a circle of 80 mm, a tenth of a degree further at each row.
fn circling(row: i32, drift: f64) -> StampedPose {
    let angle = f64::from(row) * 0.001_745_3 * 1.2;
    let centre = Vec2::new(0.0, -0.02 + drift * f64::from(row));
    let p = centre + Vec2::from_angle(angle) * 0.08;
    StampedPose { t: f64::from(row) / 300.0, map_from_robot: Pose2::new(p.x, p.y, angle) }
}

#[test]
fn a_set_of_boxes_is_drawn_as_boxes() {
    let mut answer = localized(&[(Pose2::new(0.0, 0.035, 1.75), 0.003, 5)], Status::Localized);
    let cell = |lo: f64, size: f64| Interval::new(lo, lo + size);
    answer.states = (0..40)
        .map(|i| StateBox { x: cell(-0.002 + 1e-4 * f64::from(i), 2e-4), y: cell(0.034, 2e-3), theta: cell(1.7, 0.1) })
        .collect();
    let figure = draw("boxes", &answer, None);
    assert!(figure.matches("class=\"survivor-box\"").count() >= 40);
}

#[test]
fn no_answer_still_makes_a_figure_that_says_so() {
    let mut answer = empty(Status::Inconsistent);
    answer.events.push(Event { t: 0.25, kind: "inconsistent", detail: "row 76 removed the last candidate".into() });
    assert!(draw("inconsistent", &answer, None).contains("the last was ruled out at t = 0.250 s"));
    assert!(draw("no_contact", &empty(Status::NoContact), None).contains("never touched"));
}

/// Where the first panel, which is the map, ends on the right.
fn right_end(svg: &str) -> f64 {
    let panel = svg.split('<').find(|tag| tag.starts_with("rect") && tag.contains("class=\"panel\"")).unwrap();
    let number = |name: &str| -> f64 {
        panel.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
    };
    number("x") + number("width")
}

#[test]
fn the_map_fills_the_page_where_nothing_stands_beside_it() {
    for (name, status) in [("none_inconsistent", Status::Inconsistent), ("none_no_contact", Status::NoContact)] {
        let figure = draw(name, &empty(status), None);
        assert!((right_end(&figure) - 820.0).abs() < 1e-9, "{}", right_end(&figure));
    }
    // Numbers without a close-up stand beside the legend.
    let mut answer = localized(&[(Pose2::new(0.0, 0.035, 1.75), 0.002, 5)], Status::Ambiguous);
    assert!(right_end(&draw("beside", &answer, None)) < 560.0);
    answer.hypotheses[0].extent.x = Interval::new(-0.2, 0.2);
    let figure = draw("below", &answer, None);
    assert!((right_end(&figure) - 820.0).abs() < 1e-9);
    let legend = figure.split("<text").find(|text| text.contains(">heading = ")).unwrap();
    assert!(legend.contains("x=\"442\""), "{legend}");
}

#[test]
fn hostile_numbers_and_empty_scenes_leave_valid_figures() {
    let wild = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e-300, 0.0];
    let mut answer = localized(&[(Pose2::new(0.0, 0.0, 0.0), 0.0, 1)], Status::Localized);
    for &a in &wild {
        for &b in &wild {
            let pose = Pose2 { x: a, y: b, theta: a };
            answer.trajectory.push(StampedPose { t: a, map_from_robot: pose });
            answer.first_states.push(pose);
            answer.states.push(StateBox { x: Interval::new(a, b), y: Interval::new(b, a), theta: Interval::EMPTY });
            answer.hypotheses.push(Hypothesis {
                pose,
                weight: a,
                extent: StateBox::EMPTY,
                covariance: None,
                ridge: vec![pose, Pose2::IDENTITY],
            });
            answer.shapes.push(ShapeRecord { t: b, whisker: 0, points: vec![Vec2::new(a, b)] });
            answer.estimate = Some(pose);
            let scene = LocalizationScene { title: "", map: &[], answer: &answer, truth: None, robot: &[] };
            let figure = localization_figure(&scene);
            assert!(figure.ends_with("</svg>\n"));
            assert!(!figure.contains("d=\"MNaN") && !figure.contains("=\"NaN\"") && !figure.contains("=\"inf\""));
        }
    }
}

#[test]
fn a_path_that_is_not_sure_is_dashed() {
    let pose = Pose2::new(0.0, 0.035, 1.75);
    let sure = localized(&[(pose, 1e-3, 20)], Status::Localized);
    let draw = |answer: &Localization| {
        localization_figure(&LocalizationScene { title: "doubts", map: &map(), answer, truth: None, robot: &[] })
    };
    let words = "where the path is not sure";
    let plain = draw(&sure);
    assert!(!plain.contains("class=\"path-unsure\"") && !plain.contains(words));
    // The stretches begin and end within the sweep's 0.43 s; the last lies outside of it.
    let unsure = [(0.1, 0.2), (0.3, 0.31), (5.0, 6.0)].map(|(from, to)| Stretch { from, to });
    let doubtful = draw(&Localization { unsure: unsure.to_vec(), ..sure.clone() });
    std::fs::write(Path::new(env!("CARGO_TARGET_TMPDIR")).join("unsure.svg"), &doubtful).unwrap();
    assert!(doubtful.contains(words));
    let count = |text: &str, class: &str| text.matches(&format!("class=\"{class}\"")).count();
    assert_eq!(count(&doubtful, "path-unsure") % 2, 1, "two stretches on each canvas, and the legend");
    assert!(count(&doubtful, "path") > count(&plain, "path"), "three pieces of the sure path");
    let all = draw(&Localization { unsure: vec![Stretch { from: 0.0, to: 9.0 }], ..sure });
    assert!(count(&all, "path-unsure") > 0 && count(&all, "path") == 1, "only the legend's sample is solid");
}

#[test]
fn an_inconsistent_answer_is_drawn_without_a_place() {
    let pose = Pose2::new(0.0, 0.035, 1.75);
    let answer = localized(&[(pose, 1e-3, 20)], Status::Inconsistent);
    let truth = sweep(Vec2::ZERO);
    let scene = LocalizationScene { title: "none", map: &map(), answer: &answer, truth: Some(&truth), robot: &[] };
    let svg = localization_figure(&scene);
    for word in ["class=\"estimate\"", "class=\"extent\"", "off the truth", "estimate and heading"] {
        assert!(!svg.contains(word), "{word}");
    }
}

#[test]
fn shares_of_a_set_are_told_as_no_probabilities() {
    let places = [(Pose2::new(0.0, 0.035, 1.75), 1e-3, 20), (Pose2::new(0.1, -0.05, 0.4), 1e-3, 20)];
    for encloses in [false, true] {
        let answer = Localization { encloses, ..localized(&places, Status::Ambiguous) };
        let scene = LocalizationScene { title: "two", map: &map(), answer: &answer, truth: None, robot: &[] };
        assert_eq!(verdict(&answer).contains("50 %"), !encloses, "{}", verdict(&answer));
        assert_eq!(localization_figure(&scene).contains("1: 50 %"), !encloses);
    }
}
