//! The doubt of accelerations that the shape of ramps shows.
//!
//! The standard deviation of a fit holds for a control that follows the fitted law exactly. A control that ramps by
//! another law, or in segments, has no acceleration that the law could have: within its ramps, the simulated acceleration
//! is off by the misfit m, a relative error (see [`RampMisfit`]). An acceleration a with the standard deviation σ of the
//! fit is therefore known to
//!
//! ```text
//! √(σ² + (m a)²)
//! ```
//!
//! with the misfit of the ramps of the same axis. If the misfit of all ramps is above [`MAX_RAMP_MISFIT`](crate::machine::MAX_RAMP_MISFIT), the control follows
//! another law. Its accelerations, its jerk and the values of its junction law are then no quantities of that control, and
//! have no deviation.

use crate::identification::calibration::Estimate;
use crate::identification::comparison::RampMisfit;
use crate::identification::effects::parameters::{
    AXIS_ACCELERATION, AXIS_VELOCITY_STEP, Adjustable, JUNCTION_DEVIATION, MINIMUM_CRUISE_RATIO,
    PATH_ACCELERATION, PATH_JERK, SQUARE_CORNER_VELOCITY,
};

/// Returns an estimate whose deviation contains the misfit of ramps if it is an acceleration, and that has none if it belongs
/// to a law that the ramps contradict.
pub fn doubted(estimate: Estimate, misfit: &RampMisfit) -> Estimate {
    let is = |parameter: &Adjustable| parameter.key == estimate.key;
    let of_axis = AXIS_ACCELERATION.iter().position(is);
    let is_along_path = is(&PATH_ACCELERATION);
    let others =
        [JUNCTION_DEVIATION, SQUARE_CORNER_VELOCITY, AXIS_VELOCITY_STEP, MINIMUM_CRUISE_RATIO, PATH_JERK];
    if of_axis.is_none() && !is_along_path && !others.iter().any(is) {
        return estimate;
    }
    let of_ramps = of_axis.map_or(misfit.of_path.filter(|_| is_along_path), |axis| misfit.of_axes[axis]);
    let of_fit = estimate.deviation.filter(|_| misfit.is_of_law());
    let with_ramps = |of_fit: f64| of_ramps.map_or(of_fit, |ratio| of_fit.hypot(ratio * estimate.value));
    Estimate { deviation: of_fit.map(with_ramps), ..estimate }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::calibration::ParameterVerdict;
    use crate::machine::MAX_RAMP_MISFIT;

    fn deviation_of(key: &str, misfit: RampMisfit) -> Option<f64> {
        let estimate = Estimate {
            key: key.to_string(),
            before: f64::INFINITY,
            value: 1000.0,
            deviation: Some(3.0),
            verdict: ParameterVerdict::Fitted,
        };
        doubted(estimate, &misfit).deviation
    }

    #[test]
    fn an_acceleration_is_known_no_better_than_the_ramps_of_its_axis() {
        let misfit = RampMisfit { of_path: Some(0.02), of_axes: [Some(0.004), None, Some(0.06)] };
        assert_eq!(deviation_of(AXIS_ACCELERATION[0].key, misfit), Some(5.0));
        assert_eq!(deviation_of(AXIS_ACCELERATION[1].key, misfit), Some(3.0));
        assert_eq!(deviation_of(PATH_ACCELERATION.key, misfit), Some(3_f64.hypot(20.0)));
        assert_eq!(deviation_of("axis.x.rapid_mm_min", misfit), Some(3.0));
    }

    #[test]
    fn a_control_of_another_law_has_no_known_accelerations_nor_corners() {
        let misfit =
            |ratio: f64| RampMisfit { of_path: Some(ratio * MAX_RAMP_MISFIT), of_axes: [Some(0.0); 3] };
        assert_eq!(deviation_of(AXIS_ACCELERATION[0].key, misfit(1.01)), None);
        assert_eq!(deviation_of("axis.x.rapid_mm_min", misfit(1.01)), Some(3.0));
        for own in [JUNCTION_DEVIATION, SQUARE_CORNER_VELOCITY, MINIMUM_CRUISE_RATIO, PATH_JERK] {
            assert_eq!(deviation_of(own.key, misfit(1.01)), None);
            assert_eq!(deviation_of(own.key, misfit(0.99)), Some(3.0));
        }
    }
}
