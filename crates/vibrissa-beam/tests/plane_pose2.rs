//! Rigid motions against a matrix exponential that shares no formula with them.

#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use random::Random;
use std::f64::consts::{PI, TAU};
use vibrissa_beam::plane::{Pose2, Twist2, Vec2, wrap_angle};

type Matrix = [[f64; 3]; 3];

fn product(a: Matrix, b: Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Scaling and squaring with a Taylor series.
fn exponential(m: Matrix) -> Matrix {
    let squarings = 12;
    let scaled = m.map(|row| row.map(|v| v / f64::from(1 << squarings)));
    let identity: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let (mut term, mut sum) = (identity, identity);
    for n in 1..20 {
        term = product(term, scaled).map(|row| row.map(|v| v / f64::from(n)));
        sum = std::array::from_fn(|i| std::array::from_fn(|j| sum[i][j] + term[i][j]));
    }
    (0..squarings).fold(sum, |m, _| product(m, m))
}

fn of_twist(t: Twist2) -> Matrix {
    exponential([[0.0, -t.theta, t.x], [t.theta, 0.0, t.y], [0.0, 0.0, 0.0]])
}

fn of_pose(p: Pose2) -> Matrix {
    let (s, c) = p.theta.sin_cos();
    [[c, -s, p.x], [s, c, p.y], [0.0, 0.0, 1.0]]
}

fn assert_near(a: Matrix, b: Matrix, tolerance: f64) {
    for (x, y) in a.iter().flatten().zip(b.iter().flatten()) {
        assert!((x - y).abs() <= tolerance, "{a:?}\n{b:?}");
    }
}

fn twists() -> Vec<Twist2> {
    let mut random = Random(1);
    let mut all = Vec::new();
    for scale in [1.0, 1e-3, 1e-9, 1e-300, 0.0] {
        for _ in 0..200 {
            all.push(Twist2 { x: random.signed(5.0), y: random.signed(5.0), theta: random.signed(PI) * scale });
        }
    }
    for theta in [PI - 1e-12, -PI + 1e-12, 3.0, -3.0] {
        all.push(Twist2 { x: 1.0, y: -2.0, theta });
    }
    all
}

#[test]
fn exponential_and_logarithm() {
    for twist in twists() {
        let pose = Pose2::exp(twist);
        assert_near(of_pose(pose), of_twist(twist), 2e-11);
        // The logarithm's exponential, by matrices, is the pose.
        assert_near(of_twist(pose.log()), of_pose(pose), 2e-11);
        let back = pose.log();
        assert!((back.theta - twist.theta).abs() < 1e-12 && back.theta.signum() * twist.theta >= 0.0);
        assert!((back.x - twist.x).abs() < 1e-9 && (back.y - twist.y).abs() < 1e-9, "{twist:?} {back:?}");
    }
    // More than half a turn: the exponential still agrees, the logarithm takes the short way.
    for theta in [4.0, -5.0, 9.0, -20.0] {
        let pose = Pose2::exp(Twist2 { x: 0.3, y: -0.2, theta });
        assert_near(of_pose(pose), of_twist(Twist2 { x: 0.3, y: -0.2, theta }), 1e-10);
        assert!(pose.log().theta.abs() <= PI);
    }
}

#[test]
fn composition_and_inverse() {
    let all = twists();
    for pair in all.windows(2) {
        let (a, b) = (Pose2::exp(pair[0]), Pose2::exp(pair[1]));
        assert_near(of_pose(a.compose(b)), product(of_pose(a), of_pose(b)), 1e-13);
        assert_near(product(of_pose(a), of_pose(a.inverse())), of_pose(Pose2::IDENTITY), 1e-13);
        assert_near(product(of_pose(a), of_pose(a.between(b))), of_pose(b), 1e-13);
        assert_near(product(of_pose(a.before(b)), of_pose(b)), of_pose(a), 1e-13);
        let p = Vec2::new(pair[1].y, pair[0].x);
        let m = of_pose(a);
        let q = a.transform_point(p);
        assert!((q.x - (m[0][0] * p.x + m[0][1] * p.y + m[0][2])).abs() < 1e-13);
        assert!((q.y - (m[1][0] * p.x + m[1][1] * p.y + m[1][2])).abs() < 1e-13);
        assert!(a.inverse_transform_point(q).distance(p) < 1e-13);
    }
}

#[test]
fn angles_are_wrapped() {
    let mut random = Random(7);
    for size in [1.0, 10.0, 1e3, 1e6, 1e15] {
        for _ in 0..500 {
            let angle = random.signed(size);
            let wrapped = wrap_angle(angle);
            assert!(wrapped > -PI && wrapped <= PI, "{angle} -> {wrapped}");
            let tolerance = 1e-15 * size.max(1.0) * 4.0;
            assert!(
                (wrapped.sin() - angle.sin()).abs() <= tolerance && (wrapped.cos() - angle.cos()).abs() <= tolerance
            );
            assert_eq!(wrap_angle(wrapped).to_bits(), wrapped.to_bits());
        }
    }
    for (angle, expected) in [(PI, PI), (-PI, PI), (3.0 * PI, PI), (TAU, 0.0), (0.0, 0.0)] {
        assert!((wrap_angle(angle) - expected).abs() < 1e-15, "{angle}");
    }
    assert!(wrap_angle(f64::NAN).is_nan() && wrap_angle(f64::INFINITY).is_nan());
    assert!(wrap_angle(f64::MAX).abs() <= PI && wrap_angle(-f64::MAX).abs() <= PI);
}
