//! Every misprint of Ward et al. 2021 that matters here: the printed formula misses the definition,
//! the corrected one meets it.
//!
//! The definition is a rectangular pulse convolved with n boxcars of width T1. It is computed here
//! from sums of truncated powers and, to check those, by averaging a table again and again; nothing
//! of the crate is used.

const F: f64 = 50.0;
const T1: f64 = 0.0255;
const TV: f64 = 0.12;

/// The response to a unit step of velocity (`extra` 0), or its displacement (`extra` 1).
fn step_response(n: i32, t: f64, extra: i32) -> f64 {
    let factorial = |k: i32| (1..=k).map(f64::from).product::<f64>();
    let terms = (0..=n).map(|k| {
        let binomial = factorial(n) / (factorial(k) * factorial(n - k));
        (-1f64).powi(k) * binomial * (t - f64::from(k) * T1).max(0.0).powi(n + extra)
    });
    terms.sum::<f64>() / (factorial(n + extra) * T1.powi(n))
}

/// The filtered pulse.
fn velocity(n: i32, t: f64) -> f64 {
    F * (step_response(n, t, 0) - step_response(n, t - TV, 0))
}

/// The largest miss of `formula` between two times, by F.
fn worst(n: i32, from: f64, to: f64, formula: impl Fn(f64) -> f64) -> f64 {
    let times = (1..400).map(|i| from + (to - from) * f64::from(i) / 400.0);
    times.map(|t| (formula(t) - velocity(n, t)).abs() / F).fold(0.0, f64::max)
}

/// G/T of the corner by the definition: the step at the corner and the one Tb later, at half the delay.
fn deviation(n: i32, alpha: f64) -> f64 {
    let half = 0.5 * f64::from(n) * T1;
    (alpha * step_response(n, half, 1) + (1.0 - alpha) * step_response(n, alpha * half, 1)) / T1
}

#[test]
fn the_definition_is_a_pulse_averaged_again_and_again() {
    // Running sums over a table; its error falls as the step does.
    let misses = [510, 1020].map(|steps| {
        let dt = T1 / f64::from(steps);
        let count = ((TV + 3.0 * T1) / dt) as usize + 2;
        let mut table: Vec<f64> =
            (0..count).map(|i| if (i as f64 + 0.5) * dt < TV { F } else { 0.0 }).collect();
        for _ in 0..3 {
            let mut sum = 0.0;
            let before = table.clone();
            for i in 0..count {
                sum += before[i] - if i < steps as usize { 0.0 } else { before[i - steps as usize] };
                table[i] = sum / f64::from(steps);
            }
        }
        let miss = |(i, v): (usize, &f64)| (v - velocity(3, (i as f64 + 2.0) * dt)).abs() / F;
        table.iter().enumerate().map(miss).fold(0.0, f64::max)
    });
    assert!(misses[0] < 2e-3 && misses[1] < 0.6 * misses[0], "{misses:?}");
}

#[test]
fn equation_5_row_2_divides_by_the_square_of_t1() {
    let row = |t: f64| -t * t + 4.0 * T1 * t - 2.0 * T1 * T1;
    assert!(worst(2, T1, 2.0 * T1, |t| F / (2.0 * T1 * T1) * row(t)) < 1e-12);
    assert!(0.1 < worst(2, T1, 2.0 * T1, |t| F / (2.0 * T1) * row(t)));
}

#[test]
fn equation_5_row_4_divides_by_the_square_of_t1() {
    let row = |t: f64| -t * t + 2.0 * TV * t - TV * TV + 2.0 * T1 * T1;
    assert!(worst(2, TV, TV + T1, |t| F / (2.0 * T1 * T1) * row(t)) < 1e-12);
    assert!(0.1 < worst(2, TV, TV + T1, |t| F / (2.0 * T1) * row(t)));
}

#[test]
fn equation_31_row_5_has_the_square_of_tv() {
    let row = |t: f64, factor: f64| {
        F / (2.0 * T1.powi(3))
            * (-t.powi(3) / 3.0 + TV * t * t - factor * t + TV.powi(3) / 3.0 + 2.0 * T1.powi(3))
    };
    assert!(worst(3, TV, TV + T1, |t| row(t, TV * TV)) < 1e-9);
    assert!(0.1 < worst(3, TV, TV + T1, |t| row(t, TV)));
}

/// The left-hand side of Eq. 29, printed and mended, for a corner of `theta` at tolerance `epsilon`.
fn equation_29(theta: f64, alpha: f64, epsilon: f64) -> [f64; 2] {
    let limit = 3.0 * 2f64.sqrt() * epsilon;
    let polynomial = alpha.powi(4) - alpha.powi(3) - alpha;
    [
        F * T1 * (theta + 1.0).cos().sqrt() * polynomial - limit,
        F * T1 * (1.0 + theta.cos()).sqrt() * -polynomial - limit,
    ]
}

#[test]
fn equation_29_as_printed_limits_nothing() {
    for degrees in [5.0f64, 30.0, 90.0, 150.0] {
        let theta = degrees.to_radians();
        for step in 1..=100 {
            let alpha = f64::from(step) / 100.0;
            let error = F * T1 * deviation(2, alpha) * (2.0 + 2.0 * theta.cos()).sqrt();
            // At a tolerance a little above or below the true error, the mended one says so.
            let [printed_below, mended_below] = equation_29(theta, alpha, 0.999 * error);
            let [printed_above, mended_above] = equation_29(theta, alpha, 1.001 * error);
            assert!(0.0 < mended_below && mended_above < 0.0, "{degrees}°, α = {alpha}");
            // The printed one is satisfied either way, or not a number.
            for printed in [printed_below, printed_above] {
                assert!(printed <= 0.0 || printed.is_nan());
            }
        }
    }
}

#[test]
fn equation_30_as_printed_limits_nothing() {
    for degrees in [5.0f64, 30.0, 90.0, 150.0] {
        let theta = degrees.to_radians();
        for step in 1..=100 {
            let a = f64::from(step) / 100.0;
            let error = F * T1 * deviation(3, a) * (2.0 + 2.0 * theta.cos()).sqrt();
            let polynomial =
                16.0 * a.powi(5) + 16.0 * a.powi(4) - 8.0 * a.powi(3) - 16.0 * a * a - 85.0 * a - 1.0;
            let printed =
                F * T1 * (theta + 1.0).cos().sqrt() * polynomial - 192.0 * 2f64.sqrt() * 0.5 * error;
            assert!(printed <= 0.0 || printed.is_nan(), "half of the true error is found to be enough");
            let mended = |epsilon: f64| {
                F * T1 * (1.0 + theta.cos()).sqrt() * 384.0 * branches(a) - 192.0 * 2f64.sqrt() * epsilon
            };
            assert!(0.0 < mended(0.999 * error) && mended(1.001 * error) < 0.0);
        }
    }
}

/// The deviation behind three filters with its two branches.
fn branches(a: f64) -> f64 {
    if a <= 2.0 / 3.0 {
        (78.0 * a + 81.0 * a.powi(4) - 81.0 * a.powi(5)) / 384.0
    } else {
        (162.0 * a.powi(5) - 810.0 * a.powi(4) + 1296.0 * a.powi(3) - 936.0 * a * a + 414.0 * a - 48.0)
            / 384.0
    }
}

/// Eq. 39, as a part of F T1.
fn equation_39(a: f64, tb: f64) -> f64 {
    let sum = 96.0 * T1 * tb.powi(3) + 216.0 * T1.powi(3) * tb + 3.0 * T1.powi(4) * a + 16.0 * tb.powi(4) * a
        - 81.0 * T1.powi(4)
        - 16.0 * tb.powi(4)
        - 216.0 * (T1 * tb).powi(2)
        + 216.0 * (T1 * tb).powi(2) * a
        - 96.0 * T1 * tb.powi(3) * a
        - 216.0 * T1.powi(3) * tb * a;
    -sum / (384.0 * T1.powi(4))
}

#[test]
fn equations_37_to_39_hold_on_one_branch() {
    for step in 0..=100 {
        let a = f64::from(step) / 100.0;
        let [both, one] =
            [branches(a), equation_39(a, 1.5 * T1 * (1.0 - a))].map(|g| (g - deviation(3, a)).abs());
        assert!(both < 1e-12, "α = {a}");
        // Without blending pulses, at α = 1, the branches meet again.
        assert_eq!(one < 1e-12, a <= 2.0 / 3.0 || a == 1.0, "α = {a}");
    }
}

#[test]
fn equations_40_to_42_take_tb_for_another() {
    let printed = |a: f64| {
        (-16.0 * a.powi(5) - 16.0 * a.powi(4) + 8.0 * a.powi(3) + 16.0 * a * a + 85.0 * a + 1.0) / 384.0
    };
    for step in 0..=100 {
        let a = f64::from(step) / 100.0;
        assert!(
            (printed(a) - equation_39(a, T1 * (1.0 - a))).abs() < 1e-12,
            "they are Eq. 39 with T1 (1 − α)"
        );
    }
    // A full stop would miss the corner and still move.
    assert_eq!(printed(0.0), 1.0 / 384.0);
    assert_eq!(deviation(3, 0.0), 0.0);
    let worst = (0..=100).map(|i| f64::from(i) / 100.0).map(|a| (printed(a) - deviation(3, a)).abs());
    assert!(5e-3 < worst.fold(0.0, f64::max));
}

#[test]
fn equation_12_is_an_approximation() {
    for n in [2, 3] {
        let half = 0.5 * f64::from(n) * T1;
        for degrees in [0.0f64, 60.0, 90.0, 120.0] {
            let both = 2.0 * (0.5 * degrees.to_radians()).cos();
            for alpha in [0.05, 0.3, 0.6, 1.0] {
                let v = |t: f64| step_response(n, t, 0);
                let truth = F * both * (alpha * v(half) + (1.0 - alpha) * v(alpha * half));
                // Summed along the legs at the middle of the corner: pulses F, αF and αF, F.
                let tb = half * (1.0 - alpha);
                let leaving = F * ((1.0 - v(half + tb)) + alpha * (v(half + tb) - v(half)));
                let arriving = F * (alpha * (v(half) - v(half - tb)) + v(half - tb));
                let turn = degrees.to_radians();
                let resultant = (leaving + arriving * turn.cos()).hypot(arriving * turn.sin());
                assert!((resultant - truth).abs() < 1e-9 * F);
                let printed = alpha * F;
                let miss = (printed / truth - 1.0).abs();
                assert_eq!(miss < 1e-9, degrees == 0.0 && alpha == 1.0, "{n}, {degrees}°, α = {alpha}");
            }
        }
    }
}

#[test]
fn section_4_1_1_says_5_52_where_table_1_gives_5_59() {
    let (measured, predicted) = (42.38, 44.75);
    let percent: f64 = 100.0 * (predicted / measured - 1.0);
    assert_eq!(format!("{percent:.2}"), "5.59");
}
