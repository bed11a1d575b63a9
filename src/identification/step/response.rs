//! The response of filters: a recording of one move as a function of a few parameters.
//!
//! ```text
//!       F  ........._________
//!                  /:       :\
//!                 / :       : \            parameters: F, rise, fall, filters, and p0
//!       0  ______/  :       :  \______                 where positions are recorded
//!               |<->|       |
//!               t0  rise    fall = rise + Tv;   rise = t0 + D/2
//! ```
//!
//! Times refer to the middles of the ramps, which do not move when the filters change, so that the parameters
//! hardly affect each other. Equal filters have the parameter T; the unequal pair has D = T1 + T2 and q =
//! ((T1 − T2)/D)², in which the response is smooth even where T1 = T2.
//!
//! A pulse of duration Tv behind a filter T equals a pulse of duration T behind a filter Tv: if both are
//! free, the longer of the two is assumed to be the pulse.
//!
//! Derivatives by F, rise, fall and p0 are exact; those by the filters are central differences.

use nalgebra::{DMatrix, DVector};

use crate::identification::step::{Estimate, Filters};
use crate::simulation::filter::FilterChain;

/// The recorded quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordedQuantity {
    /// Position along the move, mm.
    Position,
    /// Feedrate along the move, mm/s.
    Feedrate,
}

/// The response of some filters at the times of a recording.
pub struct Response<'a> {
    pub times: &'a [f64],
    pub quantity: RecordedQuantity,
    pub filters: Filters,
}

/// The parameters by name.
pub struct Shape {
    /// Feedrate, mm/s.
    pub feedrate: f64,
    /// Middle of the rising ramp, s.
    pub rise: f64,
    /// Middle of the falling ramp, s.
    pub fall: f64,
    /// The filters.
    pub chain: FilterChain,
}

impl Shape {
    /// Returns `true` if the feedrate rises or falls at a time, s.
    pub fn on_ramp(&self, time: f64) -> bool {
        [self.rise, self.fall].iter().any(|middle| (time - middle).abs() < self.chain.half_delay())
    }
}

/// The meaning of parameters, for people.
pub struct Derived {
    pub time_constants: Vec<Estimate>,
    pub start: Estimate,
    pub feedrate: Estimate,
    pub length: Estimate,
}

/// Step of the central differences, as a part of the parameter.
const DIFFERENCE_STEP: f64 = 1e-5;
/// Largest q: T2 is at least a 4000th of T1.
const MOST_UNEQUAL: f64 = 0.999;

/// Place of the parameters in their vector; F, rise and fall come first.
const FILTER: usize = 3;

impl Response<'_> {
    /// F, rise, fall, two for the filters, and p0.
    pub const MOST_PARAMETERS: usize = 6;

    /// Returns the number of parameters of the filters.
    fn filter_parameters(&self) -> usize {
        match self.filters {
            Filters::Equal(_) => 1,
            Filters::UnequalPair => 2,
        }
    }

    /// Returns the number of parameters.
    pub fn parameters(&self) -> usize {
        FILTER + self.filter_parameters() + usize::from(self.quantity == RecordedQuantity::Position)
    }

    /// Returns the number of parameters that only samples on the ramps determine: rise, fall and the filters.
    pub fn parameters_on_ramps(&self) -> usize {
        2 + self.filter_parameters()
    }

    /// Returns the filters of some parameters; `None` if there are no such filters.
    fn chain(&self, parameters: &DVector<f64>) -> Option<FilterChain> {
        let size = parameters[FILTER];
        let extent = self.times[self.times.len() - 1] - self.times[0];
        if size.is_nan() || size < 1e-6 * extent || 2.0 * extent < size {
            return None;
        }
        let chain = match self.filters {
            Filters::Equal(order) => FilterChain::equal(order, size),
            Filters::UnequalPair => FilterChain::new(&pair(size, parameters[FILTER + 1])?),
        };
        // With several equal filters the pulse cannot be confused with one of them.
        let pulse = parameters[2] - parameters[1];
        let shortest_pulse = match self.filters {
            Filters::Equal(2..) => 0.0,
            _ => chain.time_constants()[0],
        };
        (shortest_pulse < pulse).then_some(chain)
    }

    /// Returns the parameters by name; they must be those of a minimum or of a guess.
    pub fn shape(&self, parameters: &DVector<f64>) -> Shape {
        Shape {
            feedrate: parameters[0],
            rise: parameters[1],
            fall: parameters[2],
            chain: self.chain(parameters).expect("the search stays where there are filters"),
        }
    }

    fn origin(&self, parameters: &DVector<f64>) -> f64 {
        match self.quantity {
            RecordedQuantity::Position => parameters[self.parameters() - 1],
            RecordedQuantity::Feedrate => 0.0,
        }
    }

    /// Returns the response at each time; `None` if there are no such filters.
    pub fn values(&self, parameters: &DVector<f64>) -> Option<DVector<f64>> {
        let chain = self.chain(parameters)?;
        let (feedrate, rise, fall) = (parameters[0], parameters[1], parameters[2]);
        let origin = self.origin(parameters);
        Some(self.at_times(|time| origin + feedrate * self.unit(&chain, time - rise, time - fall)))
    }

    /// Returns the response for F = 1 mm/s and p0 = 0, by the times since the middles of the ramps.
    fn unit(&self, chain: &FilterChain, since_rise: f64, since_fall: f64) -> f64 {
        let half = chain.half_delay();
        match self.quantity {
            RecordedQuantity::Feedrate => chain.step(since_rise + half) - chain.step(since_fall + half),
            RecordedQuantity::Position => {
                chain.displacement(since_rise + half) - chain.displacement(since_fall + half)
            }
        }
    }

    fn at_times(&self, value: impl Fn(f64) -> f64) -> DVector<f64> {
        DVector::from_iterator(self.times.len(), self.times.iter().map(|&time| value(time)))
    }

    /// Returns the derivatives of the response by each parameter, a column each.
    pub fn jacobian(&self, parameters: &DVector<f64>) -> DMatrix<f64> {
        let Shape { feedrate, rise, fall, chain, .. } = self.shape(parameters);
        let slope = |age: f64| match self.quantity {
            RecordedQuantity::Feedrate => chain.impulse(age + chain.half_delay()),
            RecordedQuantity::Position => chain.step(age + chain.half_delay()),
        };
        let mut jacobian = DMatrix::zeros(self.times.len(), self.parameters());
        jacobian.set_column(0, &self.at_times(|time| self.unit(&chain, time - rise, time - fall)));
        jacobian.set_column(1, &self.at_times(|time| -feedrate * slope(time - rise)));
        jacobian.set_column(2, &self.at_times(|time| feedrate * slope(time - fall)));
        for column in FILTER..FILTER + self.filter_parameters() {
            // q is a part already, and may be 0 or at its bound.
            let step = if column == FILTER { DIFFERENCE_STEP * parameters[FILTER] } else { DIFFERENCE_STEP };
            let moved = |by: f64| {
                let mut moved = parameters.clone();
                moved[column] += by;
                self.values(&moved).map(|values| (values, moved[column]))
            };
            let here = || self.values(parameters).map(|values| (values, parameters[column]));
            if let (Some((after, b)), Some((before, a))) =
                (moved(step).or_else(here), moved(-step).or_else(here))
            {
                jacobian.set_column(column, &((after - before) / (b - a)));
            }
        }
        if self.quantity == RecordedQuantity::Position {
            jacobian.column_mut(self.parameters() - 1).fill(1.0);
        }
        jacobian
    }

    /// Moves parameters that left the bounds of q back to them.
    pub fn bounded(&self, mut parameters: DVector<f64>) -> DVector<f64> {
        if self.filters == Filters::UnequalPair {
            parameters[FILTER + 1] = parameters[FILTER + 1].clamp(0.0, MOST_UNEQUAL);
        }
        parameters
    }

    /// Returns `true` if a parameter lies on a bound that `direction` crosses.
    pub fn is_at_bound(&self, parameters: &DVector<f64>, parameter: usize, direction: f64) -> bool {
        let value = parameters[parameter];
        self.filters == Filters::UnequalPair
            && parameter == FILTER + 1
            && ((value <= 0.0 && direction < 0.0) || (MOST_UNEQUAL <= value && 0.0 < direction))
    }

    /// Returns the best of a grid of parameters for a move whose middle (s) and time from 10 % to 90 % of the
    /// length (s) are known roughly; `None` if the squares of the values are no numbers.
    pub fn guess(&self, values: &[f64], middle: f64, width: f64) -> Option<DVector<f64>> {
        let values = DVector::from_column_slice(values);
        let mut best = (f64::INFINITY, None);
        for delay in [0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.2, 1.6, 2.2] {
            for pulse in [0.4, 0.7, 0.9, 1.0, 1.1, 1.2, 1.25] {
                let mut parameters = DVector::zeros(self.parameters());
                (parameters[1], parameters[2]) = (middle - 0.5 * pulse * width, middle + 0.5 * pulse * width);
                match self.filters {
                    Filters::Equal(order) => parameters[FILTER] = delay * width / order as f64,
                    Filters::UnequalPair => {
                        (parameters[FILTER], parameters[FILTER + 1]) = (delay * width, 0.2);
                    }
                }
                parameters[0] = 1.0;
                let Some(unit) = self.values(&parameters) else { continue };
                let (feedrate, origin) = self.straight_line(&unit, &values);
                let misfit = (&unit * feedrate).add_scalar(origin) - &values;
                let squares = misfit.norm_squared();
                if squares < best.0 {
                    parameters[0] = feedrate;
                    if self.quantity == RecordedQuantity::Position {
                        parameters[self.parameters() - 1] = origin;
                    }
                    best = (squares, Some(parameters));
                }
            }
        }
        best.1
    }

    /// Returns the factor and the origin with which `unit` comes closest to `values`.
    fn straight_line(&self, unit: &DVector<f64>, values: &DVector<f64>) -> (f64, f64) {
        let (middle, level) = match self.quantity {
            RecordedQuantity::Feedrate => (0.0, 0.0),
            RecordedQuantity::Position => (unit.mean(), values.mean()),
        };
        let (unit, values) = (unit.add_scalar(-middle), values.add_scalar(-level));
        let factor = unit.dot(&values) / unit.norm_squared();
        (factor, level - factor * middle)
    }

    /// Returns the meaning of the parameters; `uncertainty` returns the uncertainty of a linear combination
    /// of them.
    pub fn derived(&self, parameters: &DVector<f64>, uncertainty: impl Fn(&[f64]) -> f64) -> Derived {
        let along = |weights: &[(usize, f64)]| {
            let mut gradient = vec![0.0; self.parameters()];
            weights.iter().for_each(|&(place, weight)| gradient[place] = weight);
            uncertainty(&gradient)
        };
        let (feedrate, rise, fall) = (parameters[0], parameters[1], parameters[2]);
        let size = parameters[FILTER];
        let (filters, time_constants) = match self.filters {
            Filters::Equal(order) => {
                (order as f64, vec![Estimate { value: size, uncertainty: along(&[(FILTER, 1.0)]) }])
            }
            Filters::UnequalPair => {
                // T = D (1 ± √q)/2; √q is not linear at 0, so that its own spread is used.
                let q = parameters[FILTER + 1];
                let spread = (q + along(&[(FILTER + 1, 1.0)])).sqrt() - q.sqrt();
                let constants = pair(size, q).unwrap_or([size, 0.0]);
                let estimates = constants.map(|value| {
                    let by_size = value / size * along(&[(FILTER, 1.0)]);
                    Estimate { value, uncertainty: by_size.hypot(0.5 * size * spread) }
                });
                (1.0, estimates.to_vec())
            }
        };
        Derived {
            time_constants,
            start: Estimate {
                value: rise - 0.5 * filters * size,
                uncertainty: along(&[(1, 1.0), (FILTER, -0.5 * filters)]),
            },
            feedrate: Estimate { value: feedrate, uncertainty: along(&[(0, 1.0)]) },
            length: Estimate {
                value: feedrate * (fall - rise),
                uncertainty: along(&[(0, fall - rise), (1, -feedrate), (2, feedrate)]),
            },
        }
    }
}

/// Returns T1 ≥ T2 of D = T1 + T2 (s) and q; `None` if q is out of its bounds.
fn pair(delay: f64, q: f64) -> Option<[f64; 2]> {
    let root = q.sqrt();
    ((0.0..=MOST_UNEQUAL).contains(&q)).then_some([0.5 * delay * (1.0 + root), 0.5 * delay * (1.0 - root)])
}
