//! How fast an isolated corner may be taken so that the filtered path stays within tolerance.
//!
//! Two straight legs with unit directions u1, u2 are commanded at F; around the corner the
//! command drops to c = αF for Tb = h (1 − α) on each side (Eq. 14; h = D/2, half the delay):
//!
//! ```text
//!  F  -----+                 +-----
//!          |                 |
//!  c = αF  +--------+--------+
//!          |<- Tb ->|<- Tb ->|
//!                 corner
//! ```
//!
//! The filtered path is nearest to the corner h after its command, when a step sent at the corner
//! has displaced S(h) and one sent Tb later S(h − Tb) = S(αh). Its distance from the corner is
//!
//! ```text
//! ε = F ‖u2 − u1‖ G(α),      G(α) = α S(h) + (1 − α) S(αh),  s
//! ```
//!
//! G rises from 0 to S(h), so the largest α within tolerance is G⁻¹(ε / (F ‖u2 − u1‖)), and 1
//! where that is beyond S(h). For n = 2 and 3 equal constants T, G/T is the polynomial g of the
//! paper with its misprints mended.
//!
//! Where the feedrates of the legs differ, each leg keeps c for h (1 − c/F) of its own F, and c is
//! the smaller one of what the law gives for each: both sides then see a pulse that holds the
//! tolerance. That is nearly always the law for the slower leg, as c hardly depends on F; a leg
//! that is little faster than a corner at full feedrate needs the other.
//!
//! The F of a hold is that of the leg without the limit that the tolerance sets on arcs. On such an
//! arc the hold is then a little longer than published; were it to grow with the arc's own limit,
//! a wider tolerance could make a crowded arc slower.
//!
//! Source: Ward et al. 2021, Sect. 3.3 and Appendix C, from the definition.

use crate::simulation::filter::FilterChain;

/// A step of Newton's method that changes α by less than this part of it is the last: the next one would
/// change it by a rounding error.
const LAST_STEP: f64 = 1e-8;

/// The law of an isolated corner for one filter chain.
#[derive(Clone, Debug)]
pub struct CornerLaw<'a> {
    filter: &'a FilterChain,
    half_delay: f64,
    /// S(h) = G(1), s.
    full: f64,
}

impl<'a> CornerLaw<'a> {
    /// The law for this filter chain.
    pub fn new(filter: &'a FilterChain) -> CornerLaw<'a> {
        let half_delay = filter.half_delay();
        CornerLaw { filter, half_delay, full: filter.displacement(half_delay) }
    }

    /// G(α), s: the deviation for F ‖u2 − u1‖ = 1 mm/s.
    pub fn deviation(&self, alpha: f64) -> f64 {
        alpha * self.full + (1.0 - alpha) * self.filter.displacement(alpha * self.half_delay)
    }

    /// The largest α whose deviation is at most `deviation`, s.
    pub fn alpha(&self, deviation: f64) -> f64 {
        if self.full <= deviation || deviation.is_nan() {
            return 1.0;
        }
        // Newton's method; G is nearly straight, so a few steps do, each of which squares what is missing.
        // A step that leaves the bracket is replaced by halving it.
        let (mut low, mut high) = (0.0, 1.0);
        let mut alpha = deviation / self.full;
        for _ in 0..60 {
            let delayed = alpha * self.half_delay;
            let (step, displacement) = self.filter.step_and_displacement(delayed);
            let excess = alpha * self.full + (1.0 - alpha) * displacement - deviation;
            if excess <= 0.0 {
                low = alpha;
            } else {
                high = alpha;
            }
            let slope = self.full - displacement + (1.0 - alpha) * self.half_delay * step;
            let newton = alpha - excess / slope;
            if (newton - alpha).abs() <= LAST_STEP * alpha {
                return newton;
            }
            alpha = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
        }
        alpha
    }

    /// The fastest command at a corner between legs run at `before` and `after` (mm/s) that keeps
    /// the deviation over ‖u2 − u1‖ at most `distance`, mm.
    pub fn feedrate(&self, distance: f64, before: f64, after: f64) -> f64 {
        let of_leg = |feedrate: f64| feedrate * self.alpha(distance / feedrate);
        let (slower, faster) = (before.min(after), before.max(after));
        let corner = of_leg(slower);
        if slower == faster { corner } else { corner.min(of_leg(faster)) }
    }

    /// How long a leg keeps the corner's command `corner` (mm/s), s; `feedrate` (mm/s) is that of
    /// the leg without the limit of the tolerance.
    pub fn hold(&self, corner: f64, feedrate: f64) -> f64 {
        self.half_delay * (1.0 - corner / feedrate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The polynomials of the paper as its errata give them, for constants of 1 s.
    fn g(n: usize, a: f64) -> f64 {
        match n {
            2 => a * (1.0 + a.powi(2) - a.powi(3)) / 6.0,
            3 if a <= 2.0 / 3.0 => (78.0 * a + 81.0 * a.powi(4) - 81.0 * a.powi(5)) / 384.0,
            _ => {
                (162.0 * a.powi(5) - 810.0 * a.powi(4) + 1296.0 * a.powi(3) - 936.0 * a * a + 414.0 * a
                    - 48.0)
                    / 384.0
            }
        }
    }

    #[test]
    fn deviation_is_the_polynomial_of_the_errata() {
        for n in [2, 3] {
            let filter = FilterChain::equal(n, 1.0);
            let law = CornerLaw::new(&filter);
            for i in 0..=1000 {
                let alpha = i as f64 / 1000.0;
                assert!((law.deviation(alpha) - g(n, alpha)).abs() < 1e-14, "n = {n}, α = {alpha}");
            }
        }
    }

    #[test]
    fn alpha_inverts_the_deviation() {
        for constants in [&[0.03][..], &[0.02, 0.02], &[0.03, 0.007], &[0.0255; 3], &[0.02; 4], &[0.2, 0.001]]
        {
            let filter = FilterChain::new(constants);
            let law = CornerLaw::new(&filter);
            let mut before = 0.0;
            for i in 1..=2000 {
                let alpha = i as f64 / 2000.0;
                let deviation = law.deviation(alpha);
                assert!(before < deviation, "G rises");
                before = deviation;
                assert!((law.alpha(deviation) - alpha).abs() < 1e-12, "{constants:?}, α = {alpha}");
            }
            for tiny in [1e-12, 1e-9, 1e-6] {
                let alpha = law.alpha(tiny * law.full);
                assert!((law.deviation(alpha) / (tiny * law.full) - 1.0).abs() < 1e-12);
            }
            assert_eq!(law.alpha(f64::INFINITY), 1.0);
        }
    }
}
