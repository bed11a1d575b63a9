//! The minimum of a function of one value by golden sections.
//!
//! Each section keeps the part of the bracket in which the lower of two inner points lies, and that point with it:
//!
//! ```text
//! low          a       b          high        a = low + g (high − low),  b = high − g (high − low)
//!  |-----------|-------|-----------|          g = (3 − √5)/2
//! ```
//!
//! Source: Kiefer 1953.

/// Ratio g of a section.
const GOLDEN_SECTION: f64 = 0.381_966_011_250_105_1;

/// Returns the bracket around the minimum of `cost` after narrowing it by a number of sections.
pub fn golden_section(bracket: (f64, f64), sections: usize, mut cost: impl FnMut(f64) -> f64) -> (f64, f64) {
    let (mut low, mut high) = bracket;
    let (mut a, mut b) = (low + GOLDEN_SECTION * (high - low), high - GOLDEN_SECTION * (high - low));
    let (mut cost_a, mut cost_b) = (cost(a), cost(b));
    for _ in 0..sections {
        if cost_a < cost_b {
            (high, b, cost_b) = (b, a, cost_a);
            a = low + GOLDEN_SECTION * (high - low);
            cost_a = cost(a);
        } else {
            (low, a, cost_a) = (a, b, cost_b);
            b = high - GOLDEN_SECTION * (high - low);
            cost_b = cost(b);
        }
    }
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bracket_closes_on_the_minimum() {
        let mut calls = 0;
        let (low, high) = golden_section((-1.0, 4.0), 20, |value| {
            calls += 1;
            (value - 1.234).powi(2)
        });
        assert!(low <= 1.234 && 1.234 <= high, "{low} {high}");
        assert!(high - low < 5.0 * 0.6181f64.powi(20), "{low} {high}");
        assert_eq!(calls, 22);
    }
}
