//! Noise of a recorded column.

/// RMS of the smaller half of the sizes of normal values, in standard deviations.
const SMALLER_HALF_RMS_SIGMAS: f64 = 0.3776;

/// Orders of the differences that estimate noise.
const DIFFERENCE_ORDERS: std::ops::RangeInclusive<usize> = 2..=4;

/// Returns the standard deviation of the noise of a column: the least of the estimates from its differences of
/// second to fourth order.
///
/// For white noise, differences of order n are √(2n over n) times as large as the noise. For motion they shrink as the order
/// rises: on an arc of radius r that turns by φ between samples they are r φⁿ. Second differences therefore take a coarsely
/// sampled arc for noise, and fourth differences do not. The estimates use the smaller half of the differences, so changes of
/// acceleration have no influence if they take less than half of the samples.
/// The result is 0 if half of the differences are 0, as at rest or in steady motion without noise.
pub fn noise(column: &[f64]) -> f64 {
    let mut differences = column.to_vec();
    let mut ratio = 1.0;
    let mut least = f64::INFINITY;
    for order in 1..=*DIFFERENCE_ORDERS.end() {
        differences = differences.windows(2).map(|w| w[1] - w[0]).collect();
        // The ratio of the binomial coefficients 2n over n and 2(n − 1) over n − 1.
        ratio *= (4.0 - 2.0 / order as f64).sqrt();
        if DIFFERENCE_ORDERS.contains(&order) {
            least = least.min(smaller_half_rms(&differences) / (SMALLER_HALF_RMS_SIGMAS * ratio));
        }
    }
    least
}

/// Returns the root mean square of the smaller half of the sizes of the values; 0 if there are fewer than two.
fn smaller_half_rms(values: &[f64]) -> f64 {
    let half = values.len() / 2;
    if half == 0 {
        return 0.0;
    }
    let mut sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    sizes.select_nth_unstable_by(half, f64::total_cmp);
    let square = sizes[..half].iter().map(|size| size * size).sum::<f64>() / half as f64;
    square.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of twelve uniform numbers, which are close to normal.
    fn normal(count: usize, deviation: f64) -> Vec<f64> {
        let mut state = 7_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..count).map(|_| deviation * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0)).collect()
    }

    #[test]
    fn ramps_and_steady_motion_change_nothing() {
        let noisy = normal(20_000, 0.003);
        // A third of the time it accelerates, the rest it moves on.
        let mut speed = 0.0;
        let mut position = 0.0;
        let moving = noisy.iter().enumerate().map(|(row, noise)| {
            speed += if row % 300 < 50 {
                0.002
            } else if row % 300 < 100 {
                -0.002
            } else {
                0.0
            };
            position += speed;
            position + noise
        });
        let moving: Vec<f64> = moving.collect();
        for (name, column, least, most) in [("rest", &noisy, 0.97, 1.03), ("motion", &moving, 0.97, 1.3)] {
            let found = noise(column) / 0.003;
            assert!((least..most).contains(&found), "{name}: {found}");
        }
    }

    /// An arc of 3 mm, cut at 50 mm/s and sampled every 8 ms, turns by 0.13 rad between samples.
    #[test]
    fn an_arc_that_is_sampled_seldom_is_no_noise() {
        let noisy = normal(4000, 1e-3);
        let arc = noisy.iter().enumerate().map(|(row, noise)| 3.0 * f64::cos(0.13 * row as f64) + noise);
        let found = noise(&arc.collect::<Vec<f64>>()) / 1e-3;
        assert!((0.95..1.1).contains(&found), "{found}");
    }

    #[test]
    fn what_has_no_noise_has_none() {
        let steps: Vec<f64> = (0..100).map(|row| f64::from(row.min(50))).collect();
        for column in [&[][..], &[1.0, 2.0], &[1.0; 50], &steps] {
            assert_eq!(noise(column), 0.0, "{column:?}");
        }
    }
}
