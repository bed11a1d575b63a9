//! How far a rate may be off for so few cases: the interval of Clopper and Pearson.
//!
//! Source: Clopper, Pearson 1934, "The use of confidence or fiducial limits illustrated in the case of the binomial".

/// The chance that a true rate lies outside.
const OUTSIDE: f64 = 0.10;

/// The 90 % interval of a rate of which `hits` of `of` cases were seen.
pub fn clopper_pearson(hits: usize, of: usize) -> (f64, f64) {
    let low = if hits == 0 { 0.0 } else { rate_where(|p| 1.0 - at_most(hits - 1, of, p), 0.5 * OUTSIDE) };
    let high = if hits == of { 1.0 } else { rate_where(|p| 1.0 - at_most(hits, of, p), 1.0 - 0.5 * OUTSIDE) };
    (low, high)
}

/// The rate at which a probability that grows with it takes the value.
fn rate_where(probability: impl Fn(f64) -> f64, value: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if probability(middle) < value { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The probability of at most `hits` in `of` cases at a rate between 0 and 1.
fn at_most(hits: usize, of: usize, rate: f64) -> f64 {
    let mut log_choices = 0.0;
    let mut sum = 0.0;
    for k in 0..=hits {
        if k > 0 {
            log_choices += ((of - k + 1) as f64 / k as f64).ln();
        }
        sum += (log_choices + k as f64 * rate.ln() + (of - k) as f64 * (1.0 - rate).ln()).exp();
    }
    sum.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::clopper_pearson;

    /// Against the table of the beta distribution: 1 − 0.05^(1/10) for none of ten, symmetric for half of them.
    #[test]
    fn intervals_are_those_of_the_beta_distribution() {
        let near =
            |(low, high): (f64, f64), (l, h): (f64, f64)| (low - l).abs() < 5e-5 && (high - h).abs() < 5e-5;
        assert!(near(clopper_pearson(0, 10), (0.0, 0.2589)));
        assert!(near(clopper_pearson(10, 10), (0.7411, 1.0)));
        assert!(near(clopper_pearson(5, 10), (0.2224, 0.7776)));
    }
}
