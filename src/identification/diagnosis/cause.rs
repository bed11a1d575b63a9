//! A cause that passed the acceptance tests, while others are searched for, and the odds of it.

use crate::identification::diagnosis::Candidate;
use crate::identification::diagnosis::gates::HeldOut;

/// A cause that stands, while others are looked for.
#[derive(Clone)]
pub struct AcceptedCause {
    /// It, with its values.
    pub candidate: Candidate,
    /// Ids of what it cannot be told from.
    pub alike: Vec<String>,
    /// How it did where it was not fitted.
    pub held_out: Option<HeldOut>,
    /// How sure, at most: what the likelihood says of it is known when all causes are.
    pub confidence: f64,
}

impl AcceptedCause {
    /// A cause that is seen by itself, and so sure.
    pub fn read_off(candidate: Candidate, confidence: f64) -> AcceptedCause {
        AcceptedCause { candidate, alike: Vec::new(), held_out: None, confidence }
    }
}

/// The causes alone.
pub fn candidates(causes: &[AcceptedCause]) -> Vec<Candidate> {
    causes.iter().map(|cause| cause.candidate.clone()).collect()
}

/// How sure a gain of likelihood makes, beside its price.
pub fn odds(gain: f64, price: f64) -> f64 {
    gain / (gain + price)
}

/// A cause that is less sure than this is not named.
pub const UNSURE: f64 = 0.1;
