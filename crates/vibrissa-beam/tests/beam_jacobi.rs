//! Jacobi's functions against Legendre's integrals, which share no code with them.

use vibrissa_beam::beam::jacobi::Jacobi;

/// Parameters from one end to the other, with their complements.
fn parameters() -> Vec<(f64, f64)> {
    let mut list = vec![(0.5, 0.5), (0.826, 1.0 - 0.826), (1e-3, 1.0 - 1e-3), (1.0 - 1e-3, 1e-3)];
    for exponent in [6, 9, 12, 15] {
        let small = 10f64.powi(-exponent);
        list.extend([(small, 1.0 - small), (1.0 - small, 1.0 - (1.0 - small))]);
    }
    list
}

#[test]
fn amplitude_and_epsilon_invert_legendre() {
    for (m, m1) in parameters() {
        let j = Jacobi::new(m, m1);
        let k = j.quarter_period();
        assert!((k / ellip::ellipk(m).unwrap() - 1.0).abs() < 1e-14, "K({m})");
        for i in 1..400 {
            let t = 2.0 * k * f64::from(i) / 400.0;
            let e = j.at(t);
            let past = t > k;
            let (s, c, q) = (e.sn, e.cn.abs(), e.dn * e.dn);
            // Carlson's forms keep their digits near m = 1, where incomplete Legendre E does not.
            let rf = ellip::elliprf(c * c, q, 1.0).unwrap();
            let rd = ellip::elliprd(c * c, q, 1.0).unwrap();
            let (f, ee) = (s * rf, s * rf - m / 3.0 * s * s * s * rd);
            let complete = ellip::ellipe(m).unwrap();
            let (f, ee) = if past { (2.0 * k - f, 2.0 * complete - ee) } else { (f, ee) };
            assert!((f / t - 1.0).abs() < 4e-15, "F(am {t} | {m}) = {f}");
            let epsilon = e.m_cn2_integral + m1 * t;
            assert!((epsilon / ee - 1.0).abs() < 1e-13, "E({t} | {m}): {epsilon} {ee}");
        }
    }
}

#[test]
fn identities_derivatives_and_the_inverse() {
    for (m, m1) in parameters() {
        let j = Jacobi::new(m, m1);
        let k = j.quarter_period();
        for i in 1..200 {
            let t = 2.0 * k * f64::from(i) / 200.0;
            let e = j.at(t);
            assert!((e.sn * e.sn + e.cn * e.cn - 1.0).abs() < 1e-15);
            assert!((e.dn * e.dn + m * e.sn * e.sn - 1.0).abs() < 1e-15);
            assert!((e.one_minus_cn / (1.0 - e.cn) - 1.0).abs() < 1e-11);
            let mirrored = j.at(2.0 * k - t);
            assert!((mirrored.cn + e.cn).abs() < 1e-13 && (mirrored.sn - e.sn).abs() < 1e-13);
            if t < k {
                let back = j.inverse_tangent(e.sn / e.cn);
                assert!((back / t - 1.0).abs() < 1e-14, "{m} {t} {back}");
            }
            let h = 1e-4;
            if t > h && t < 2.0 * k - h {
                let slope = (j.at(t + h).sn - j.at(t - h).sn) / (2.0 * h);
                assert!((slope - e.cn * e.dn).abs() < 1e-7);
            }
        }
    }
}

#[test]
fn small_arguments_keep_their_digits() {
    for (m, m1) in parameters() {
        let j = Jacobi::new(m, m1);
        for exponent in 3..150 {
            let t = 10f64.powi(-exponent);
            let e = j.at(t);
            assert!((e.sn / (t - (1.0 + m) * t * t * t / 6.0) - 1.0).abs() < t.powi(4) + 1e-15);
            assert!((e.one_minus_cn / (0.5 * t * t) - 1.0).abs() < t * t + 1e-15);
            assert!((j.inverse_tangent(t) / t - 1.0).abs() < t * t + 1e-15);
        }
    }
}
