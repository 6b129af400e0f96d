//! The figure of a calibration: well-formed whatever it is given, with every finite point inside its panel.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::figure::{Plot, calibration_figure};

fn plot() -> Plot {
    Plot {
        x_label: "reading <µT>".into(),
        y_label: "moment (mN m) & more".into(),
        points: (0..50).map(|i| (f64::from(i), (f64::from(i) * 0.3).sin())).collect(),
        curve: vec![(0.0, -1.0), (49.0, 1.0)],
        valid: Some([5.0, 45.0]),
        ..Plot::default()
    }
}

/// The positions of the dots, by panel.
fn dots(svg: &str) -> Vec<Vec<(f64, f64)>> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let paths = document.descendants().filter(|n| n.attribute("class") == Some("survivor"));
    let one = |dot: &str| {
        let (x, y) = dot.trim_end_matches("h0").split_once(' ').unwrap();
        (x.parse().unwrap(), y.parse().unwrap())
    };
    paths.map(|n| n.attribute("d").unwrap().split('M').skip(1).map(one).collect()).collect()
}

#[test]
fn points_lie_in_their_panels_and_words_are_escaped() {
    let residuals = Plot { curve: Vec::new(), levels: vec![0.5, -2.0], span: Some([-10.0, 60.0]), ..plot() };
    let svg = calibration_figure("A & B", "notes", &[plot(), residuals]);
    assert!(svg.contains("A &amp; B") && svg.contains("reading &lt;µT&gt;"));
    let document = roxmltree::Document::parse(&svg).unwrap();
    let number = |n: &roxmltree::Node<'_, '_>, name: &str| n.attribute(name).unwrap().parse::<f64>().unwrap();
    let panels: Vec<[f64; 4]> = document
        .descendants()
        .filter(|n| n.attribute("class") == Some("panel"))
        .map(|n| ["x", "y", "width", "height"].map(|name| number(&n, name)))
        .collect();
    let dots = dots(&svg);
    assert_eq!((panels.len(), dots.len()), (2, 2));
    for (panel, dots) in panels.iter().zip(&dots) {
        assert_eq!(dots.len(), 50);
        let [x, y, width, height] = *panel;
        assert!(dots.iter().all(|d| d.0 > x && d.0 < x + width && d.1 > y && d.1 < y + height));
    }
    // To the right is larger x, upwards larger y.
    assert!(dots[0][49].0 > dots[0][0].0 && dots[0][5].1 < dots[0][0].1);
}

#[test]
fn strange_numbers_leave_the_figure_well_formed() {
    let strange = [f64::NAN, f64::INFINITY, -1e308, 1e308, 0.0];
    let wild = Plot {
        points: strange.iter().flat_map(|x| strange.map(|y| (*x, y))).collect(),
        levels: vec![f64::NAN],
        valid: Some([f64::NAN, 1.0]),
        ..Plot::default()
    };
    let same = Plot { points: vec![(3.0, 3.0); 4], ..Plot::default() };
    for plots in [vec![], vec![Plot::default()], vec![wild], vec![same]] {
        let svg = calibration_figure("", "", &plots);
        roxmltree::Document::parse(&svg).unwrap();
        assert!(svg.len() < 100_000);
    }
}
