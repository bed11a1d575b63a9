//! Limits of the machine hold in the filtered motion, at ramps and corners alike.

use truefeed::machine::{Machine, PathLimits, TimeConstants};
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;

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
                let (plan, _) = simulate::within(&toolpath, &machine, 0.05, &mut |_| {});
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

/// A move from stand to stand takes L/F and the filters' delay D; a limit before the filters adds all of its ramp,
/// one behind them what of its ramp is not in theirs.
#[test]
fn ramps_before_the_filters_take_both() {
    let program = read(b"G1 X100 F3000\n");
    let mut machine = Machine::default();
    machine.interpolator.filters = 3;
    machine.interpolator.time_constants = TimeConstants::Equal(0.02);
    let time = |machine: &Machine| {
        let (plan, _) = simulate::within(&trace(&program, machine), machine, 0.05, &mut |_| {});
        plan.cycle_time()
    };
    assert_eq!(time(&machine), time(&Machine { path: before(f64::INFINITY, &machine), ..machine.clone() }));
    machine.path.acceleration = 400.0;
    let behind = time(&machine);
    machine.path = before(400.0, &machine);
    let before = time(&machine);
    assert!((before - (2.0 + 50.0 / 400.0 + 0.06)).abs() < 1e-9, "{before}");
    assert!((2.0 + 50.0 / 400.0..before - 0.02).contains(&behind), "{behind} behind, {before} before");
}

/// The limits along the path of a machine, with this acceleration (mm/s²) before the filters.
fn before(acceleration: f64, machine: &Machine) -> PathLimits {
    PathLimits { acceleration, limits_command: true, ..machine.path }
}
