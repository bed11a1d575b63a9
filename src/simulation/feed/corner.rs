//! The corner law: the largest command at an isolated corner whose filtered path stays within tolerance.
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
//! The filtered path is nearest to the corner at the time h after the command has passed it. By then a step
//! sent at the corner has caused the displacement S(h), and a step sent Tb later S(h − Tb) = S(αh). The
//! distance of the filtered path from the corner is
//!
//! ```text
//! ε = F ‖u2 − u1‖ G(α),      G(α) = α S(h) + (1 − α) S(αh),  s
//! ```
//!
//! G rises from 0 to S(h), so the largest α within tolerance is G⁻¹(ε / (F ‖u2 − u1‖)), or 1 if the argument
//! exceeds S(h). For n = 2 and 3 equal constants T, G/T is the polynomial g of the paper with its misprints
//! corrected.
//!
//! If the feedrates of the legs differ, each leg holds c for h (1 − c/F) with its own F, and c is the smaller
//! of the two values that the law gives: the pulses on both sides then keep the tolerance. The slower leg
//! nearly always gives the smaller value, because c hardly depends on F. Near the feedrate at which a
//! corner needs no slowing, the faster leg can give it.
//!
//! A faster leg can have a slower corner: beyond the feedrate F₀ = ε / (‖u2 − u1‖ S(h)) at which the corner
//! needs no slowing, c falls below F₀, for n = 1, 2 and 3 equal constants to 0.80, 0.87 and 0.90 F₀ at 1.6, 1.3
//! and 1.2 F₀, and rises to F₀ again. A wider tolerance along an arc alone can therefore cost time at a corner
//! whose tolerance stays; a wider tolerance at corners, or of all in one ratio, never does.
//!
//! The F of a hold is the leg's feedrate without the limit that the tolerance sets on arcs. On such an arc the
//! hold is then a little longer than published. If the hold grew with the arc's own limit, a wider tolerance
//! could make an arc among many short segments slower.
//!
//! G⁻¹ is computed by Newton's method. The first guess is a cubic in u = √(1 − G/S(h)); α is a smooth
//! function of u although G is level at α = 1: G'(1) = 0 and G''(1) = −h, so that dα/du = −2u S(h)/G'(α)
//! begins with −√(2 S(h)/h). About three steps are needed, each of which depends on the one before. For a
//! rest-to-rest motion of many corners, α(u) is tabulated on 128 parts, each a polynomial through six points
//! of α(u). If the error of a part is no larger than rounding, the polynomial is the result; this fails only
//! where the pieces of G join and where α is nearly 0.
//!
//! Source: Ward et al. 2021, Sect. 3.3 and Appendix C, from the definition.

use crate::simulation::filter::FilterChain;

/// Newton's method ends with a step that changes α by less than this part of α: the next step would change α
/// only by rounding.
const MIN_NEWTON_STEP_RATIO: f64 = 1e-8;

/// Parts of a table: fewer are less accurate, more take longer to compute.
const TABLE_PARTS: usize = 128;

/// Points of a part, both ends included.
const POINTS_PER_PART: usize = 6;

/// Largest error of a table between its points, as a part of α.
const MAX_TABLE_ERROR: f64 = 5e-13;

/// The law of an isolated corner for one filter chain.
#[derive(Clone, Debug)]
pub struct CornerLaw<'a> {
    filter: &'a FilterChain,
    half_delay: f64,
    /// S(h) = G(1), s.
    full: f64,
    /// α on equal parts of u from 0 to 1; empty if the law serves few corners.
    table: Vec<TablePart>,
}

/// α on a part of u, through points at equal distances.
#[derive(Clone, Copy, Debug)]
struct TablePart {
    /// Divided differences of the points, over the place in the part from 0 to 1.
    differences: [f64; POINTS_PER_PART],
    /// `true` if the polynomial is α to within [`MAX_TABLE_ERROR`] and not only a first guess.
    is_exact: bool,
}

impl TablePart {
    /// Returns the part through these values of α.
    fn through(values: [f64; POINTS_PER_PART]) -> TablePart {
        let mut differences = values;
        for order in 1..POINTS_PER_PART {
            for i in (order..POINTS_PER_PART).rev() {
                differences[i] =
                    (differences[i] - differences[i - 1]) / (TablePart::point(order) - TablePart::point(0));
            }
        }
        TablePart { differences, is_exact: false }
    }

    /// Returns the place of a point in the part, 0 to 1.
    fn point(index: usize) -> f64 {
        index as f64 / (POINTS_PER_PART - 1) as f64
    }

    /// Returns α at a place in the part, 0 to 1.
    #[inline]
    fn alpha(&self, place: f64) -> f64 {
        let last = self.differences[POINTS_PER_PART - 1];
        (0..POINTS_PER_PART - 1)
            .rev()
            .fold(last, |sum, i| self.differences[i] + (place - TablePart::point(i)) * sum)
    }
}

impl<'a> CornerLaw<'a> {
    /// Returns the law for a filter chain.
    pub fn new(filter: &'a FilterChain) -> CornerLaw<'a> {
        let half_delay = filter.half_delay();
        let full = filter.displacement(half_delay);
        CornerLaw { filter, half_delay, full, table: Vec::new() }
    }

    /// Returns the law with a table of α, which takes time to compute and makes each corner faster.
    pub fn for_many_corners(filter: &'a FilterChain) -> CornerLaw<'a> {
        let law = CornerLaw::new(filter);
        let mut table = Vec::with_capacity(TABLE_PARTS);
        // The last two points predict the next one.
        let (mut before, mut last) = (law.cubic(-TablePart::point(1) / TABLE_PARTS as f64), 1.0);
        for k in 0..TABLE_PARTS {
            let deviation = |place: f64| law.full * (1.0 - ((k as f64 + place) / TABLE_PARTS as f64).powi(2));
            let mut values = [last; POINTS_PER_PART];
            for (i, value) in values.iter_mut().enumerate().skip(1) {
                *value = law.newton(deviation(TablePart::point(i)), 2.0 * last - before);
                (before, last) = (last, *value);
            }
            let part = TablePart::through(values);
            // The polynomial deviates most half-way between its points.
            let is_off = |i: usize| {
                let place = 0.5 * (TablePart::point(i) + TablePart::point(i + 1));
                let alpha = part.alpha(place);
                let (reached, slope) = law.deviation_and_slope(alpha);
                MAX_TABLE_ERROR * alpha * slope < (reached - deviation(place)).abs()
            };
            table.push(TablePart {
                is_exact: k + 1 < TABLE_PARTS && !(0..POINTS_PER_PART - 1).any(is_off),
                ..part
            });
        }
        CornerLaw { table, ..law }
    }

    /// Returns an approximate α of a deviation from 0 to G(1), s, and `true` if it is exact.
    #[inline]
    fn start(&self, deviation: f64) -> (f64, bool) {
        let part_of_full = deviation / self.full;
        // G is straight there, and u would lose its digits.
        if part_of_full < 1e-6 {
            return (part_of_full, false);
        }
        let u = (1.0 - part_of_full).sqrt();
        let place = u * TABLE_PARTS as f64;
        let number = place as u32;
        match self.table.get(number as usize) {
            Some(part) => (part.alpha(place - f64::from(number)), part.is_exact),
            None => (self.cubic(u), false),
        }
    }

    /// Returns the cubic that has the values and slopes of α over u at 0, where G is level, and at 1.
    fn cubic(&self, u: f64) -> f64 {
        let (first, last) = (-(2.0 * self.full / self.half_delay).sqrt(), -2.0);
        let (square, cubic) = (-3.0 - 2.0 * first - last, 2.0 + first + last);
        1.0 + u * (first + u * (square + u * cubic))
    }

    /// Returns G(α), s: the deviation for F ‖u2 − u1‖ = 1 mm/s.
    pub fn deviation(&self, alpha: f64) -> f64 {
        self.deviation_and_slope(alpha).0
    }

    /// Returns G(α), s, and its slope.
    fn deviation_and_slope(&self, alpha: f64) -> (f64, f64) {
        let (step, displacement) = self.filter.step_and_displacement(alpha * self.half_delay);
        let deviation = alpha * self.full + (1.0 - alpha) * displacement;
        (deviation, self.full - displacement + (1.0 - alpha) * self.half_delay * step)
    }

    /// Returns the largest α whose deviation is at most `deviation`, s.
    pub fn alpha(&self, deviation: f64) -> f64 {
        if self.full <= deviation || deviation.is_nan() {
            return 1.0;
        }
        if deviation <= 0.0 {
            return 0.0;
        }
        let (alpha, is_exact) = self.start(deviation);
        if is_exact { alpha } else { self.newton(deviation, alpha) }
    }

    /// Returns the α of a deviation from 0 to G(1), s, by Newton's method from a value near it.
    fn newton(&self, deviation: f64, mut alpha: f64) -> f64 {
        // Each step of Newton's method squares the error. A step that leaves the bracket is replaced by
        // halving it.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let (reached, slope) = self.deviation_and_slope(alpha);
            let excess = reached - deviation;
            if excess <= 0.0 {
                low = alpha;
            } else {
                high = alpha;
            }
            let newton = alpha - excess / slope;
            if (newton - alpha).abs() <= MIN_NEWTON_STEP_RATIO * alpha {
                return newton;
            }
            alpha = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
        }
        alpha
    }

    /// Returns the largest command at a corner between legs run at `before` and `after` (mm/s) that keeps the
    /// deviation over ‖u2 − u1‖ at most `distance`, mm.
    #[inline]
    pub fn feedrate(&self, distance: f64, before: f64, after: f64) -> f64 {
        let of_leg = |feedrate: f64| feedrate * self.alpha(distance / feedrate);
        let (slower, faster) = (before.min(after), before.max(after));
        let corner = of_leg(slower);
        if slower == faster { corner } else { corner.min(of_leg(faster)) }
    }

    /// Returns how long a leg holds the corner's command `corner` (mm/s), s; `feedrate` (mm/s) is the leg's
    /// without the limit of the tolerance (Eq. 14).
    #[inline]
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

    const CHAINS: [&[f64]; 6] =
        [&[0.03], &[0.02, 0.02], &[0.03, 0.007], &[0.0255; 3], &[0.02; 4], &[0.2, 0.001]];

    #[test]
    fn alpha_inverts_the_deviation() {
        for constants in CHAINS {
            let filter = FilterChain::new(constants);
            for law in [CornerLaw::new(&filter), CornerLaw::for_many_corners(&filter)] {
                let mut before = 0.0;
                for i in 1..=2000 {
                    let alpha = i as f64 / 2000.0;
                    let deviation = law.deviation(alpha);
                    assert!(before < deviation, "G rises");
                    before = deviation;
                    assert!((law.alpha(deviation) - alpha).abs() < 1e-12, "{constants:?}, α = {alpha}");
                }
                for tiny in [1e-300, 1e-12, 1e-9, 1e-6] {
                    let alpha = law.alpha(tiny * law.full);
                    assert!((law.deviation(alpha) / (tiny * law.full) - 1.0).abs() < 1e-12);
                }
                assert_eq!(law.alpha(f64::INFINITY), 1.0);
                assert_eq!(law.alpha(0.0), 0.0);
            }
        }
    }

    /// c/F₀ = α S(h)/G(α) over F/F₀ = S(h)/G(α).
    #[test]
    fn a_faster_leg_lowers_the_corner_by_a_tenth_or_two() {
        for (n, least, at) in [(1, 0.80, 1.6), (2, 0.87, 1.3), (3, 0.90, 1.2)] {
            let filter = FilterChain::equal(n, 0.02);
            let law = CornerLaw::new(&filter);
            let of = |i: u32| {
                let alpha = f64::from(i) / 1000.0;
                let ratio = law.full / law.deviation(alpha);
                (alpha * ratio, ratio)
            };
            let (lowest, there) = (1..=1000).map(of).min_by(|a, b| a.0.total_cmp(&b.0)).expect("some");
            assert!((lowest - least).abs() < 0.005 && (there - at).abs() < 0.05, "{n}: {lowest} at {there}");
            let feedrate = law.feedrate(law.full, there, there);
            assert!((feedrate / lowest - 1.0).abs() < 1e-9, "{n}: {feedrate}, not {lowest}");
        }
    }

    /// Of the polynomial of a part only its last digits are missing, but of those where G is pieced together.
    #[test]
    fn nearly_all_parts_of_a_table_are_exact() {
        for constants in CHAINS {
            let filter = FilterChain::new(constants);
            let law = CornerLaw::for_many_corners(&filter);
            let inexact = law.table.iter().filter(|part| !part.is_exact).count();
            assert!(inexact < 16, "{constants:?}: {inexact} of {TABLE_PARTS}");
        }
    }
}
