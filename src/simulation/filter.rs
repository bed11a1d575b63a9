//! First-order FIR filters in series, as the response to a unit step of velocity.
//!
//! A filter of time constant T averages its input over the last T seconds. Filters T1 … Tn in
//! series answer an impulse with a bell h(t) of area 1, a piecewise polynomial of degree n − 1
//! between its knots (all sums of a subset of the constants):
//!
//! ```text
//! h = box(T1) * box(T2) * … * box(Tn),   box(T)(t) = 1/T on 0 ≤ t < T
//!
//!   h(t)        _.-'''-._
//!             .'         '.
//!         __-'             '-__
//!        0        D/2          D  = T1 + … + Tn, the filter delay
//! ```
//!
//! The interpolator needs the integrals of h, each 0 before t = 0:
//!
//! ```text
//! V = ∫h   answer of the velocity to a step of velocity       after D: 1
//! S = ∫V   displacement under that step, s                     after D: t − D/2
//! Q = ∫S   the same for a ramp of velocity, s²                 after D: (t − D/2)²/2 + σ²/2
//! ```
//!
//! with σ² = Σ Ti²/12, the variance of the bell. For n equal constants T this is Eq. 5 and 31 of
//! Ward et al. 2021 (with the misprints corrected):
//!
//! ```text
//! V(t) = Σ_{k=0..n} (−1)^k C(n,k) (t − kT)₊ⁿ / (n! Tⁿ)
//! ```
//!
//! The polynomials are built by convolving box after box in coordinates local to each knot. This loses no
//! digits even if the constants differ by orders of magnitude, for which the sum above would.

/// Two knots closer than this part of the delay are one: they differ by rounding alone.
const KNOT_MERGE_RATIO: f64 = 1e-12;

/// Filters in series.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterChain {
    time_constants: Vec<f64>,
    delay: f64,
    variance: f64,
    pieces: Vec<BellPiece>,
}

/// The responses from one knot to the next, as polynomials of the time since the knot.
#[derive(Clone, Debug, PartialEq)]
struct BellPiece {
    /// Time of the knot, s.
    start: f64,
    /// Coefficients of h, the constant first.
    h: [f64; 4],
    /// V, S and Q at the knot.
    integrals: [f64; 3],
    /// Coefficients of V and S that derive from h: h1/2 and h2/3; h0/2, h1/6 and h2/12.
    of_step: [f64; 2],
    of_displacement: [f64; 3],
}

impl FilterChain {
    /// Returns the chain of one to four filters with these time constants, s, each positive and finite.
    ///
    /// # Examples
    ///
    /// ```
    /// use truefeed::simulation::filter::FilterChain;
    ///
    /// let filters = FilterChain::new(&[0.02, 0.01]);
    /// assert_eq!(filters.delay(), 0.03, "s");
    /// assert_eq!(filters.step(0.015), 0.5, "halfway through the delay half of a step has arrived");
    /// assert_eq!(filters.step(0.03), 1.0);
    /// ```
    pub fn new(time_constants: &[f64]) -> FilterChain {
        let mut largest_first = time_constants.to_vec();
        largest_first.sort_by(f64::total_cmp);
        largest_first.reverse();
        let delay: f64 = largest_first.iter().sum();
        let mut bell = vec![BellPiece::new(0.0, [1.0 / largest_first[0], 0.0, 0.0, 0.0])];
        let mut support = largest_first[0];
        for &constant in &largest_first[1..] {
            bell = convolved_with_box(&bell, support, constant, KNOT_MERGE_RATIO * delay);
            support += constant;
        }
        let variance = largest_first.iter().map(|constant| constant * constant / 12.0).sum();
        let mut chain =
            FilterChain { time_constants: time_constants.to_vec(), delay, variance, pieces: bell };
        chain.integrate();
        chain
    }

    /// Returns `order` filters of one time constant, s.
    pub fn equal(order: usize, time_constant: f64) -> FilterChain {
        FilterChain::new(&vec![time_constant; order])
    }

    /// Returns the time constants, s.
    pub fn time_constants(&self) -> &[f64] {
        &self.time_constants
    }

    /// Returns the filter delay D = Σ Ti, s: the time that a step takes to arrive in full.
    pub fn delay(&self) -> f64 {
        self.delay
    }

    /// Returns half the filter delay, s: the mean lag of the filtered motion.
    pub fn half_delay(&self) -> f64 {
        0.5 * self.delay
    }

    /// Returns the sum of the squares of the time constants, s².
    pub fn sum_of_squares(&self) -> f64 {
        12.0 * self.variance
    }

    /// Returns the knots of the bell, s, from 0 to D.
    pub fn knots(&self) -> impl Iterator<Item = f64> + '_ {
        self.pieces.iter().map(|piece| piece.start).chain([self.delay])
    }

    /// Returns h at the age `t` (s), 1/s.
    pub fn impulse(&self, t: f64) -> f64 {
        match self.piece(t) {
            PieceAtAge::Before | PieceAtAge::After => 0.0,
            PieceAtAge::In(piece, x) => polynomial(&piece.h, x),
        }
    }

    /// Returns the derivative of h at the age `t` (s), 1/s². The two Dirac pulses of a single filter at 0 and
    /// D are left out.
    pub fn impulse_slope(&self, t: f64) -> f64 {
        match self.piece(t) {
            PieceAtAge::Before | PieceAtAge::After => 0.0,
            PieceAtAge::In(piece, x) => piece.slope(x),
        }
    }

    /// Returns V at the age `t` (s), dimensionless.
    pub fn step(&self, t: f64) -> f64 {
        match self.piece(t) {
            PieceAtAge::Before => 0.0,
            PieceAtAge::After => 1.0,
            PieceAtAge::In(piece, x) => piece.step(x),
        }
    }

    /// Returns S at the age `t` (s), s.
    pub fn displacement(&self, t: f64) -> f64 {
        match self.piece(t) {
            PieceAtAge::Before => 0.0,
            PieceAtAge::After => t - self.half_delay(),
            PieceAtAge::In(piece, x) => piece.displacement(x),
        }
    }

    /// Returns V and S at the age `t` (s).
    pub fn step_and_displacement(&self, t: f64) -> (f64, f64) {
        match self.piece(t) {
            PieceAtAge::Before => (0.0, 0.0),
            PieceAtAge::After => (1.0, t - self.half_delay()),
            PieceAtAge::In(piece, x) => (piece.step(x), piece.displacement(x)),
        }
    }

    /// Returns Q at the age `t` (s), s².
    pub fn ramp_displacement(&self, t: f64) -> f64 {
        match self.piece(t) {
            PieceAtAge::Before => 0.0,
            PieceAtAge::After => 0.5 * ((t - self.half_delay()).powi(2) + self.variance),
            PieceAtAge::In(piece, x) => piece.ramp_displacement(x),
        }
    }

    /// Returns the responses between two ages within the delay as polynomials of the age beyond the first
    /// (s); `None` if a knot lies between the ages.
    pub fn expansion(&self, from: f64, to: f64) -> Option<Expansion> {
        let PieceAtAge::In(piece, x) = self.piece(from) else { return None };
        let is_in_piece =
            to < self.delay && !self.pieces.iter().any(|next| from < next.start && next.start < to);
        is_in_piece.then(|| {
            let impulse = moved(&piece.h, x);
            let [h0, h1, h2, h3] = impulse;
            Expansion { step: [piece.step(x), h0, h1 / 2.0, h2 / 3.0, h3 / 4.0], impulse }
        })
    }

    /// Returns the parts of the ages from `from` to `to` (s), within the delay, that lie between the knots.
    pub fn spans(&self, from: f64, to: f64) -> impl Iterator<Item = Span<'_>> {
        let ends = self.pieces[1..].iter().map(|piece| piece.start).chain([self.delay]);
        self.pieces.iter().zip(ends).filter_map(move |(piece, end)| {
            let (begin, end) = (piece.start.max(from), end.min(to));
            (begin < end).then_some(Span { begin, end, piece })
        })
    }

    /// Returns the largest value of h, 1/s: the bell peaks at half the delay.
    pub fn peak_impulse(&self) -> f64 {
        self.impulse(self.half_delay())
    }

    /// Returns the largest slope of h, 1/s²; infinite for a single filter, whose acceleration steps.
    pub fn peak_impulse_slope(&self) -> f64 {
        if self.time_constants.len() == 1 {
            return f64::INFINITY;
        }
        // On each piece the slope is a polynomial of degree two at most.
        let ends = self.pieces.iter().map(|piece| piece.start).skip(1).chain([self.delay]);
        let slopes = self.pieces.iter().zip(ends).flat_map(|(piece, end)| {
            let width = end - piece.start;
            let slope = |x: f64| piece.slope(x).abs();
            let turning = -piece.h[2] / (3.0 * piece.h[3]);
            let turning = if turning.is_finite() { turning.clamp(0.0, width) } else { 0.0 };
            [slope(0.0), slope(turning), slope(width)]
        });
        slopes.fold(0.0, f64::max)
    }

    fn piece(&self, t: f64) -> PieceAtAge<'_> {
        if t.is_nan() || t <= 0.0 {
            return PieceAtAge::Before;
        }
        if t >= self.delay {
            return PieceAtAge::After;
        }
        let piece = self.pieces.iter().rev().find(|piece| piece.start <= t).expect("the first knot is 0");
        PieceAtAge::In(piece, t - piece.start)
    }

    /// Continues V, S and Q from knot to knot.
    fn integrate(&mut self) {
        for next in 1..self.pieces.len() {
            let (left, right) = self.pieces.split_at_mut(next);
            let (piece, following) = (&left[next - 1], &mut right[0]);
            let x = following.start - piece.start;
            following.integrals = [piece.step(x), piece.displacement(x), piece.ramp_displacement(x)];
        }
    }
}

/// A range of ages between two knots.
pub struct Span<'a> {
    /// Least age, s.
    pub begin: f64,
    /// Greatest age, s.
    pub end: f64,
    piece: &'a BellPiece,
}

impl Span<'_> {
    /// Returns V at an age (s) within the span.
    pub fn step(&self, age: f64) -> f64 {
        self.piece.step(age - self.piece.start)
    }

    /// Returns h at an age (s) within the span, 1/s.
    pub fn impulse(&self, age: f64) -> f64 {
        polynomial(&self.piece.h, age - self.piece.start)
    }
}

/// V and h near an age, as coefficients of the powers of the age beyond it (s), the constant first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expansion {
    /// Coefficients of V.
    pub step: [f64; 5],
    /// Coefficients of h.
    pub impulse: [f64; 4],
}

enum PieceAtAge<'a> {
    Before,
    In(&'a BellPiece, f64),
    After,
}

impl BellPiece {
    /// Returns the piece that begins at `start` (s) with the coefficients `h`; its integrals begin at 0.
    fn new(start: f64, h: [f64; 4]) -> BellPiece {
        let of_step = [h[1] / 2.0, h[2] / 3.0];
        let of_displacement = [h[0] / 2.0, h[1] / 6.0, h[2] / 12.0];
        BellPiece { start, h, integrals: [0.0; 3], of_step, of_displacement }
    }

    fn slope(&self, x: f64) -> f64 {
        self.h[1] + x * (2.0 * self.h[2] + x * 3.0 * self.h[3])
    }

    fn step(&self, x: f64) -> f64 {
        let (h, [first, second]) = (&self.h, self.of_step);
        self.integrals[0] + x * (h[0] + x * (first + x * (second + x * h[3] / 4.0)))
    }

    fn displacement(&self, x: f64) -> f64 {
        let ([v, s, _], [zeroth, first, second]) = (self.integrals, self.of_displacement);
        // Up to three filters have no cubic part, and a division is slow.
        let third = if self.h[3] == 0.0 { 0.0 } else { x * self.h[3] / 20.0 };
        s + x * (v + x * (zeroth + x * (first + x * (second + third))))
    }

    fn ramp_displacement(&self, x: f64) -> f64 {
        let h = &self.h;
        let [v, s, q] = self.integrals;
        q + x
            * (s + x
                * (v / 2.0 + x * (h[0] / 6.0 + x * (h[1] / 24.0 + x * (h[2] / 60.0 + x * h[3] / 120.0)))))
    }
}

fn polynomial(coefficients: &[f64; 4], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// Returns the coefficients of the polynomial about `x` instead of 0.
fn moved(c: &[f64; 4], x: f64) -> [f64; 4] {
    [polynomial(c, x), c[1] + x * (2.0 * c[2] + x * 3.0 * c[3]), c[2] + 3.0 * x * c[3], c[3]]
}

/// Returns the bell `bell` on 0 … `support` averaged over `constant`, all s: the slope of the result is (h(t)
/// − h(t − constant)) / constant, and it begins at 0.
fn convolved_with_box(bell: &[BellPiece], support: f64, constant: f64, same_knot: f64) -> Vec<BellPiece> {
    let around = |t: f64| -> [f64; 4] {
        if t < -same_knot || support - same_knot <= t {
            return [0.0; 4];
        }
        let piece =
            bell.iter().rev().find(|piece| piece.start <= t + same_knot).expect("the first knot is 0");
        moved(&piece.h, t - piece.start)
    };
    let own = bell.iter().map(|piece| piece.start).chain([support]);
    let mut knots: Vec<f64> = own.clone().chain(own.map(|knot| knot + constant)).collect();
    knots.sort_by(f64::total_cmp);
    knots.dedup_by(|later, earlier| *later - *earlier <= same_knot);
    let mut value = 0.0;
    let mut pieces = Vec::with_capacity(knots.len() - 1);
    for pair in knots.windows(2) {
        let (now, before) = (around(pair[0]), around(pair[0] - constant));
        let slope = [0, 1, 2].map(|k| (now[k] - before[k]) / constant);
        let h = [value, slope[0], slope[1] / 2.0, slope[2] / 3.0];
        value = polynomial(&h, pair[1] - pair[0]);
        pieces.push(BellPiece::new(pair[0], h));
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closed form of V, S or h for n equal constants: `derivative` −1 is S, 0 is V, 1 is h.
    fn closed_form(n: usize, constant: f64, t: f64, derivative: i32) -> f64 {
        let power = n as i32 - derivative;
        let factorial = |k: i32| (1..=k).map(f64::from).product::<f64>();
        let binomial = |k: usize| factorial(n as i32) / (factorial(k as i32) * factorial((n - k) as i32));
        let sum: f64 = (0..=n)
            .map(|k| (-1f64).powi(k as i32) * binomial(k) * (t - k as f64 * constant).max(0.0).powi(power))
            .sum();
        sum / (factorial(power) * constant.powi(n as i32))
    }

    #[test]
    fn equal_constants_agree_with_the_closed_form() {
        for n in 1..=4 {
            let constant = 0.0255;
            let chain = FilterChain::equal(n, constant);
            for i in 1..400 {
                let t = i as f64 / 400.0 * 1.2 * chain.delay();
                assert!((chain.step(t) - closed_form(n, constant, t, 0)).abs() < 1e-12);
                assert!((chain.displacement(t) - closed_form(n, constant, t, -1)).abs() < 1e-13);
                if n > 1 {
                    assert!((chain.impulse(t) - closed_form(n, constant, t, 1)).abs() < 1e-9 / constant);
                }
            }
        }
    }

    #[test]
    fn order_of_the_constants_does_not_matter() {
        let (a, b) = (FilterChain::new(&[0.02, 0.001, 0.013]), FilterChain::new(&[0.001, 0.013, 0.02]));
        for i in 0..500 {
            let t = i as f64 * 1e-4;
            assert_eq!(a.step(t), b.step(t));
        }
    }

    /// Each response is the derivative of the next, the bell is symmetric and never negative,
    /// and what arrives in the end is everything.
    #[test]
    fn laws_of_the_responses() {
        let lists: [&[f64]; 7] = [
            &[0.03],
            &[0.03, 0.03],
            &[0.03, 0.01],
            &[0.0255, 0.0255, 0.0255],
            &[0.04, 0.011, 0.0007],
            &[0.02, 0.02, 0.02, 0.02],
            &[0.5, 0.02, 0.0003, 0.0001],
        ];
        for constants in lists {
            let chain = FilterChain::new(constants);
            let delay = chain.delay();
            let end = delay * (1.0 - 1e-12);
            assert!((chain.step(end) - 1.0).abs() < 1e-10, "{constants:?}");
            assert!((chain.displacement(end) - (end - chain.half_delay())).abs() < 1e-10 * delay);
            let variance = chain.sum_of_squares() / 12.0;
            assert!(
                (chain.ramp_displacement(end) - 0.5 * (delay * delay / 4.0 + variance)).abs()
                    < 1e-9 * delay * delay
            );
            for i in 1..200 {
                let t = i as f64 / 200.0 * delay;
                let dt = 1e-6 * delay;
                let slope = |f: &dyn Fn(f64) -> f64| (f(t + dt) - f(t - dt)) / (2.0 * dt);
                assert!((slope(&|t| chain.displacement(t)) - chain.step(t)).abs() < 1e-5);
                assert!(
                    (slope(&|t| chain.ramp_displacement(t)) - chain.displacement(t)).abs() < 1e-5 * delay
                );
                assert!(chain.impulse(t) > -1e-9 / delay);
                assert!((chain.step(t) + chain.step(delay - t) - 1.0).abs() < 1e-10, "{constants:?} at {t}");
                assert!(chain.impulse(t) <= chain.peak_impulse() * (1.0 + 1e-9));
            }
        }
    }

    #[test]
    fn peaks_are_those_of_the_paper() {
        let constant = 0.0255;
        let two = FilterChain::equal(2, constant);
        let three = FilterChain::equal(3, constant);
        assert!((two.peak_impulse() * constant - 1.0).abs() < 1e-12);
        assert!((three.peak_impulse() * constant - 0.75).abs() < 1e-12);
        assert!((two.peak_impulse_slope() * constant * constant - 1.0).abs() < 1e-12);
        assert!((three.peak_impulse_slope() * constant * constant - 1.0).abs() < 1e-12);
    }
}
