//! Noise of a recorded column.

/// RMS of the smaller half of the sizes of normal values, in standard deviations.
const SMALLER_HALF_RMS_SIGMAS: f64 = 0.3776;

/// Returns the standard deviation of the noise of a column, from its second differences: without acceleration
/// these are noise, √6 times as large. Only the smaller half of the differences counts, so that ramps have no
/// influence if they take less than half of the samples. The result is 0 if half of the differences are 0, as
/// at rest or in steady motion without noise.
pub fn noise(column: &[f64]) -> f64 {
    let mut differences: Vec<f64> = column.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    let half = differences.len() / 2;
    if half == 0 {
        return 0.0;
    }
    differences.select_nth_unstable_by(half, f64::total_cmp);
    let square = differences[..half].iter().map(|d| d * d).sum::<f64>() / half as f64;
    square.sqrt() / (SMALLER_HALF_RMS_SIGMAS * 6.0f64.sqrt())
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

    #[test]
    fn what_has_no_noise_has_none() {
        let steps: Vec<f64> = (0..100).map(|row| f64::from(row.min(50))).collect();
        for column in [&[][..], &[1.0, 2.0], &[1.0; 50], &steps] {
            assert_eq!(noise(column), 0.0, "{column:?}");
        }
    }
}
