//! A cause that passed the acceptance tests while the search for others continues, and its odds.

use crate::identification::diagnosis::Candidate;
use crate::identification::diagnosis::gates::HeldOut;

/// A cause that passed the acceptance tests, while the search for others continues.
#[derive(Clone)]
pub struct AcceptedCause {
    /// The cause with its values.
    pub candidate: Candidate,
    /// Ids of the effects that fit the runs as well as the cause, such as `axis_velocity_limit (Y)` beside a limit of X.
    pub alike: Vec<String>,
    /// Result in the sections to which the cause was not fitted; `None` if they do not decide.
    pub held_out: Option<HeldOut>,
    /// Upper bound of the confidence, 0 to 1: the gain of likelihood enters when all causes are known.
    pub confidence: f64,
}

impl AcceptedCause {
    /// Returns a cause with the confidence with which the recording shows it directly, without a search.
    pub fn read_off(candidate: Candidate, confidence: f64) -> AcceptedCause {
        AcceptedCause { candidate, alike: Vec::new(), held_out: None, confidence }
    }

    /// Adds the id of an effect that fits the runs as well. All effects that do share the confidence.
    pub fn add_alike(&mut self, id: String) {
        let count = 1.0 + self.alike.len() as f64;
        self.confidence *= count / (count + 1.0);
        self.alike.push(id);
    }
}

/// Returns the candidates of the causes.
pub fn candidates(causes: &[AcceptedCause]) -> Vec<Candidate> {
    causes.iter().map(|cause| cause.candidate.clone()).collect()
}

/// Returns the confidence that a gain of likelihood gives a cause, 0 to 1, given the price of its parameters.
pub fn odds(gain: f64, price: f64) -> f64 {
    gain / (gain + price)
}

/// Least confidence of a named cause.
pub const UNSURE: f64 = 0.1;
