//! Sums of long lists without loss of digits.

/// A sum as accurate as if it were rounded once (Neumaier's summation): a million blocks lose no more digits
/// than one.
#[derive(Clone, Copy, Default)]
pub struct RunningSum {
    sum: f64,
    lost: f64,
}

impl RunningSum {
    /// Adds a value.
    #[inline]
    pub fn add(&mut self, value: f64) {
        let Self { sum, lost } = *self;
        let next = sum + value;
        let change = if value.abs() <= sum.abs() { (sum - next) + value } else { (value - next) + sum };
        *self = Self { sum: next, lost: lost + change };
    }

    /// Returns the sum of the values added.
    #[inline]
    pub fn value(self) -> f64 {
        self.sum + self.lost
    }
}

/// Returns the sums of the first 1, 2, 3 … values, each a [`RunningSum`].
pub fn running_sum(values: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
    values.scan(RunningSum::default(), |sum, value| {
        sum.add(value);
        Some(sum.value())
    })
}
