//! Limits of the machine hold in the filtered motion, at ramps and corners alike.

use truefeed::machine::{Machine, TimeConstants};
use truefeed::simulation::contour::plan_within;
use truefeed::simulation::gcode::read;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::toolpath::trace;

/// By what part an acceleration may pass its limit where a ramp of the filters turns into one of the
/// limit: passes judge it from sample to sample.
const BETWEEN_SAMPLES: f64 = 0.4;

#[test]
fn no_axis_accelerates_beyond_its_limit() {
    let mut reached = 0;
    let filters = [vec![0.0255; 3], vec![0.03], vec![0.03, 0.03], vec![0.05, 0.004], vec![0.02; 4]];
    let limits = [(300.0, 300.0), (1000.0, 250.0), (3000.0, 3000.0)];
    for ((limit_x, limit_y), constants) in
        limits.iter().flat_map(|limit| filters.iter().map(move |f| (*limit, f)))
    {
        for degrees in [20f64, 45.0, 90.0, 135.0, 180.0] {
            for feed_mm_min in [1000.0, 3000.0, 8000.0] {
                let mut machine = Machine::default();
                machine.interpolator.filters = constants.len();
                machine.interpolator.time_constants = TimeConstants::Unequal(constants.clone());
                machine.axes[0].acceleration = limit_x;
                machine.axes[1].acceleration = limit_y;
                let (sin, cos) = degrees.to_radians().sin_cos();
                let program = format!("G1 X40 F{feed_mm_min}\nX{} Y{}\n", 40.0 + 40.0 * cos, 40.0 * sin);
                let toolpath = trace(&read(program.as_bytes()), &machine);
                let (plan, _) = plan_within(&toolpath, &machine, 0.05, &mut |_| {});
                let profile = Profile::new(&toolpath, &plan);
                // Where it stands a moment the direction of the path, and so its share, is nothing.
                let moments = (0..5000)
                    .map(|i| profile.cycle_time() * i as f64 / 5000.0)
                    .filter(|time| 1e-2 < profile.at_time(*time).velocity.norm());
                let largest =
                    moments.filter_map(|time| profile.dynamics_at_time(time)).fold(0.0f64, |largest, now| {
                        largest
                            .max(now.acceleration.x.abs() / limit_x)
                            .max(now.acceleration.y.abs() / limit_y)
                    });
                assert!(
                    largest <= 1.0 + BETWEEN_SAMPLES,
                    "{limit_x}, {limit_y} mm/s², {constants:?}, {degrees}°, F{feed_mm_min}: {largest}"
                );
                reached += usize::from(0.9 < largest);
            }
        }
    }
    assert!(100 < reached, "the limits are what holds the axes back: {reached}");
}
