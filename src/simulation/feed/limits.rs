//! The feedrate at which each segment is commanded, before any corner.
//!
//! It is the smallest of
//!
//! - the programmed feedrate times the feed override, or for a rapid the rapid feedrate r times the rapid
//!   override, with r = min(r_path, min_k r_k / |u_k|): the axis that limits the move runs at its rapid
//!   feedrate r_k, and diagonals are faster than single axes. LinuxCNC clamps the programmed feedrate to the
//!   velocity of the axes, and on an arc to their acceleration, before the override multiplies it (emccanon.cc), so
//!   that an override of 80 % also slows a move that an axis limits; grbl and Klipper clamp the product. Controls that run
//!   rapids at the programmed feedrate F limit r by F times the feed override (M220 in Klipper, gcode_move.py);
//! - V_k / |u_k|: no axis k above its velocity limit; on an arc with the largest |u_k| on it. LinuxCNC limits an
//!   arc to the V_k of the slower axis of its plane, however short the arc (emccanon.cc);
//! - the velocity limit along the path, which acts behind the overrides, on feeds and rapids (in LinuxCNC the slider of
//!   the maximum velocity);
//! - L Ω_k / |Δ_k|: no rotary axis k, which turns by Δ_k (rad) along the segment of length L, above its limit
//!   Ω_k (rad/s);
//! - √(24 ε / (ΣTi² κ)): on an arc of curvature κ and radius r the filtered path runs inside the arc by v²
//!   ΣTi² κ / 24, to first order, which is kept within the tolerance ε. The first order is an upper bound of
//!   the exact r (1 − Π sinc(ωTi/2)), ω = v κ;
//! - √(a / κ): no more than the centripetal acceleration limit, and on an axis no more than its
//!   acceleration limit;
//!
//! and, for short blocks, of two limits that act before or after the corners are planned, depending on
//! [`CornerPlanning`](crate::machine::CornerPlanning):
//!
//! - L / t_block: no block in less than the block processing time;
//! - look-ahead: from v the motion stops within v h + v²/(2A), which must lie within the N blocks that the
//!   control sees, so v = 2 s / (h + √(h² + 2 s / A)) for blocks of total length s (mm).
//!
//! Symbols: u unit tangent, κ curvature (1/mm), Ti filter constants (s), h half the filter delay
//! (s), A acceleration limit along the path (mm/s²). Source: Ward et al. 2021 with its errata;
//! the limits are those that controls document.

use crate::machine::{Axis, Machine};
use crate::simulation::filter::FilterChain;
use crate::simulation::toolpath::{Arc, Curve, Motion, Segment, Vector};

/// Returns the requested feedrate, mm/s: programmed or rapid, with overrides and velocity limits.
pub fn requested_feedrate(segment: &Segment, machine: &Machine) -> f64 {
    let by_axes = axis_feedrate(segment, machine);
    let feedrate = match segment.motion {
        Motion::Rapid { .. } => {
            let overrides = &machine.overrides;
            overridden_rapid(segment, machine, overrides.of_feed(segment.line.0)).min(by_axes)
                * overrides.of_rapid(segment.line.0)
        }
        Motion::Feed { feedrate } => {
            clamped_before_override(feedrate, by_axes, segment, machine)
                * machine.overrides.of_feed(segment.line.0)
        }
    };
    feedrate.min(rotary_feedrate(segment, machine)).min(by_axes).min(machine.path.velocity)
}

/// Returns the feedrate that a feed override multiplies on a segment programmed at `feedrate` (mm/s), mm/s.
pub fn overridable(feedrate: f64, segment: &Segment, machine: &Machine) -> f64 {
    clamped_before_override(feedrate, axis_feedrate(segment, machine), segment, machine)
}

/// Returns the feedrate that an override multiplies, mm/s, from the programmed feedrate and the limit of the
/// axes `by_axes`, both mm/s.
fn clamped_before_override(feedrate: f64, by_axes: f64, segment: &Segment, machine: &Machine) -> f64 {
    if !machine.interpolator.junction.blends_in_time() {
        return feedrate;
    }
    let on_arc = match &segment.curve {
        Curve::Line => f64::INFINITY,
        Curve::Arc(_) => blended_arc_feedrate(segment, blended_acceleration(segment, machine), machine),
    };
    feedrate.min(by_axes).min(on_arc)
}

/// Returns `true` if equal programmed feedrates always give equal requested feedrates: no axis has a velocity
/// limit and no override depends on the line.
pub fn are_lines_alike(machine: &Machine) -> bool {
    machine.overrides.is_even() && has_no_axis_limit(machine) && has_no_axis_rapid(machine)
}

/// Returns the feedrate of a rapid segment, mm/s: the rapid feedrate of the path, with no axis above its own
/// rapid feedrate.
pub fn rapid_feedrate(segment: &Segment, machine: &Machine) -> f64 {
    overridden_rapid(segment, machine, 1.0)
}

/// Returns the feedrate of a rapid segment at a feed override, mm/s. On controls whose feed override slows rapids, it slows the
/// programmed feedrate or, without one, the rate along the path, and not the limits of the axes.
pub fn overridden_rapid(segment: &Segment, machine: &Machine, feed_override: f64) -> f64 {
    let rate = machine.rapid.feedrate;
    let along_path = match segment.motion {
        Motion::Rapid { modal_feedrate } if machine.rapid.at_feedrate && modal_feedrate.is_finite() => {
            rate.min(modal_feedrate * feed_override)
        }
        _ => rate * machine.rapid_ratio_at(feed_override).min(1.0),
    };
    if has_no_axis_rapid(machine) {
        return along_path;
    }
    machine.rapid_feedrate(largest_share(segment).into()).min(along_path)
}

/// Returns `true` if no axis has a rapid feedrate.
fn has_no_axis_rapid(machine: &Machine) -> bool {
    machine.axes.iter().all(|axis| axis.rapid == f64::INFINITY)
}

/// Returns `true` if no axis has a velocity limit.
fn has_no_axis_limit(machine: &Machine) -> bool {
    machine.axes.iter().all(|axis| axis.velocity == f64::INFINITY)
}

/// Returns the feedrate at which no axis exceeds its velocity limit, mm/s.
pub fn axis_feedrate(segment: &Segment, machine: &Machine) -> f64 {
    if has_no_axis_limit(machine) {
        return f64::INFINITY;
    }
    let in_plane = match &segment.curve {
        Curve::Arc(arc) if machine.interpolator.junction.blends_in_time() => {
            weaker_of_plane(arc, machine, |axis| axis.velocity) / turning_share(arc, segment.length)
        }
        _ => f64::INFINITY,
    };
    lowest_of_axes(segment, machine, |axis| axis.velocity).min(in_plane)
}

/// Returns the largest value along a segment at which no axis exceeds its limit.
fn lowest_of_axes(segment: &Segment, machine: &Machine, limit: fn(&Axis) -> f64) -> f64 {
    let share = largest_share(segment);
    let limits = machine.axes.iter().enumerate().map(|(k, axis)| limit(axis) / share[k]);
    limits.fold(f64::INFINITY, f64::min)
}

/// Returns the feedrate at which no rotary axis exceeds its limit, mm/s.
fn rotary_feedrate(segment: &Segment, machine: &Machine) -> f64 {
    if segment.rotation.is_none() {
        return f64::INFINITY;
    }
    segment.length / shortest_turn(&segment.rotation, segment.motion.is_rapid(), machine)
}

/// Returns the time that rotary axes need for a turn (rad) within their limits, s.
fn shortest_turn(rotation: &Vector, is_rapid: bool, machine: &Machine) -> f64 {
    let rapid = if is_rapid { machine.rapid.rotary_rate * machine.overrides.rapid } else { f64::INFINITY };
    let axes = machine.rotary_axes.iter().enumerate();
    axes.map(|(k, axis)| rotation[k].abs() / axis.velocity.min(rapid)).fold(0.0, f64::max)
}

/// Returns the duration of a command that turns only rotary axes (rad), s; `rate` is the rate along all of
/// them (rad/s), `None` in rapid.
pub fn rotary_time(rotation: &Vector, rate: Option<f64>, machine: &Machine) -> f64 {
    let programmed = rate.map_or(0.0, |rate| rotation.norm() / (rate * machine.overrides.feed));
    programmed.max(shortest_turn(rotation, rate.is_none(), machine))
}

/// Returns the largest feedrate at which the filtered path stays within `tolerance` (mm) of an arc, mm/s;
/// infinite along a line. The arc is treated as unbounded; `length` (mm) is the length of its programmed
/// part.
pub fn arc_feedrate(curve: &Curve, length: f64, filter: &FilterChain, tolerance: f64) -> f64 {
    let Curve::Arc(arc) = curve else { return f64::INFINITY };
    (24.0 * tolerance / (filter.sum_of_squares() * curvature(arc, length))).sqrt()
}

/// Returns the largest feedrate that centripetal acceleration allows, mm/s.
pub fn curve_feedrate(segment: &Segment, machine: &Machine) -> f64 {
    let Curve::Arc(arc) = &segment.curve else { return f64::INFINITY };
    let acceleration = machine.path.centripetal_acceleration.min(axis_centripetal(arc, machine));
    (acceleration / curvature(arc, segment.length)).sqrt()
}

/// Returns the distance along a segment of `length` (mm) over which a corner's command can be held, mm: on an
/// arc, the length of its first chord; infinite on a line.
pub fn first_chord(curve: &Curve, length: f64, machine: &Machine) -> f64 {
    match curve {
        Curve::Line => f64::INFINITY,
        Curve::Arc(arc) => length * (machine.interpolator.arc_step / arc.sweep),
    }
}

/// Returns the acceleration limit along a segment, mm/s².
pub fn acceleration(segment: &Segment, machine: &Machine) -> f64 {
    if machine.axes.iter().all(|axis| axis.acceleration == f64::INFINITY) {
        return machine.path.acceleration;
    }
    lowest_of_axes(segment, machine, |axis| axis.acceleration).min(machine.path.acceleration)
}

/// Returns the jerk limit of ramps along a segment, mm/s³.
pub fn jerk(segment: &Segment, machine: &Machine) -> f64 {
    if !machine.limits_jerk_of_axes() {
        return machine.path.jerk;
    }
    lowest_of_axes(segment, machine, |axis| axis.jerk).min(machine.path.jerk)
}

/// Returns the acceleration limit along a segment if corners are blends, mm/s²: on an arc, that at which the motion in
/// its plane has the acceleration of the weaker axis, however short the arc.
pub fn blended_acceleration(segment: &Segment, machine: &Machine) -> f64 {
    let along = acceleration(segment, machine);
    let Curve::Arc(arc) = &segment.curve else { return along };
    along.min(weaker_of_plane(arc, machine, |axis| axis.acceleration) / turning_share(arc, segment.length))
}

/// Share of the acceleration that remains along the path where the motion turns (LinuxCNC).
pub const TANGENTIAL_ACCELERATION_SHARE: f64 = 0.5;
/// Share of the acceleration that may turn the motion beside [`TANGENTIAL_ACCELERATION_SHARE`], √3/2 (LinuxCNC).
pub const NORMAL_ACCELERATION_SHARE: f64 = 0.866_025_403_784_438_6;

/// Returns the feedrate along an arc that leaves half the `acceleration` (mm/s²) for ramps, mm/s; infinite along a line,
/// and where corners are not blends. A helix is planned by [`planned_curvature`], and in its plane no axis exceeds its
/// share of acceleration.
pub fn blended_arc_feedrate(segment: &Segment, acceleration: f64, machine: &Machine) -> f64 {
    match &segment.curve {
        Curve::Arc(arc) if machine.interpolator.junction.blends_in_time() => {
            let weaker = weaker_of_plane(arc, machine, |axis| axis.acceleration);
            let planned = acceleration / planned_curvature(arc, segment.length);
            (NORMAL_ACCELERATION_SHARE * planned.min(weaker / curvature(arc, segment.length))).sqrt()
        }
        _ => f64::INFINITY,
    }
}

/// Returns the limit of the weaker axis of an arc's plane.
fn weaker_of_plane(arc: &Arc, machine: &Machine, limit: fn(&Axis) -> f64) -> f64 {
    let in_plane = |k: usize| MIN_PLANE_COMPONENT < arc.e1[k].hypot(arc.e2[k]);
    let axes = machine.axes.iter().enumerate().filter(|(k, _)| in_plane(*k));
    axes.map(|(_, axis)| limit(axis)).fold(f64::INFINITY, f64::min)
}

/// Returns the part of the speed along a helix of `length` (mm) that turns, at most 1.
fn turning_share(arc: &Arc, length: f64) -> f64 {
    arc.mean_radius() * arc.sweep / length
}

/// Returns the feedrate from which the motion stops within `visible` mm, mm/s.
pub fn stopping_feedrate(visible: f64, half_delay: f64, acceleration: f64) -> f64 {
    2.0 * visible / (half_delay + (half_delay * half_delay + 2.0 * visible / acceleration).sqrt())
}

/// Least component of an arc's plane along an axis of the plane.
const MIN_PLANE_COMPONENT: f64 = 1e-6;

/// Returns the curvature of a helix, 1/mm.
pub fn curvature(arc: &Arc, length: f64) -> f64 {
    arc.mean_radius() * (arc.sweep / length).powi(2)
}

/// Returns the curvature that LinuxCNC 2.9 assumes for a helix, 1/mm: 1/(r + h²/r), with the radius r and the rise h of
/// the whole arc (mm). The true curvature has the rise per radian instead of h, so LinuxCNC runs some helices faster than
/// the acceleration allows.
pub fn planned_curvature(arc: &Arc, length: f64) -> f64 {
    match arc.rise.norm() {
        0.0 => curvature(arc, length),
        rise => 1.0 / (arc.mean_radius() + rise * rise / arc.mean_radius()),
    }
}

/// Returns the largest centripetal acceleration that keeps every axis within its limit, mm/s².
fn axis_centripetal(arc: &Arc, machine: &Machine) -> f64 {
    let limits = machine.axes.iter().enumerate().map(|(k, axis)| {
        // The normal is −(cos θ e1 + sin θ e2).
        axis.acceleration / largest_on_arc(arc.e1[k], arc.e2[k], arc.sweep)
    });
    limits.fold(f64::INFINITY, f64::min)
}

/// Returns the largest |u_k| along the segment for each axis k.
pub fn largest_share(segment: &Segment) -> Vector {
    match &segment.curve {
        Curve::Line => segment.tangent(0.0).abs(),
        Curve::Arc(arc) => {
            let turning = turning_share(arc, segment.length);
            Vector::from_fn(|k, _| {
                let rise = arc.rise[k] / segment.length;
                turning * largest_on_arc(arc.e2[k], -arc.e1[k], arc.sweep) + rise.abs()
            })
        }
    }
}

/// Returns the largest |a cos θ + b sin θ| for θ from 0 to `sweep`.
fn largest_on_arc(a: f64, b: f64, sweep: f64) -> f64 {
    let value = |angle: f64| (a * angle.cos() + b * angle.sin()).abs();
    let turning = b.atan2(a).rem_euclid(std::f64::consts::PI);
    let inside = if turning <= sweep { a.hypot(b) } else { 0.0 };
    inside.max(value(0.0)).max(value(sweep))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Junction;
    use crate::simulation::gcode::{LineNumber, read};
    use crate::simulation::interpreter::trace;
    use crate::simulation::toolpath::plane::{Plane, Turn};
    use crate::simulation::toolpath::{Point, Rotation};

    /// An arc of 60° about Z that moves along Y where it begins.
    fn arc(rise: f64) -> Segment {
        let (start, angle) = (Point::new(10.0, 0.0, 0.0), std::f64::consts::FRAC_PI_3);
        let end = Point::new(10.0 * angle.cos(), 10.0 * angle.sin(), rise);
        let arc = Plane::Xy.arc((start, end), Point::origin(), Turn::Counterclockwise, 1).expect("a circle");
        Segment {
            start,
            end,
            length: arc.length(),
            curve: Curve::Arc(std::sync::Arc::new(arc)),
            motion: Motion::Feed { feedrate: 100.0 },
            rotation: Rotation::NONE,
            exact_stop: false,
            exact_path: false,
            line: LineNumber(1),
        }
    }

    #[test]
    fn linuxcnc_runs_an_arc_as_fast_as_the_slower_axis_of_its_plane() {
        let mut machine = Machine::default();
        (machine.axes[0].velocity, machine.axes[1].velocity) = (20.0, 50.0);
        let at_its_end = 20.0 / std::f64::consts::FRAC_PI_3.sin();
        assert!((axis_feedrate(&arc(0.0), &machine) - at_its_end).abs() < 1e-9);
        machine.interpolator.junction = Junction::AccelerationBlend;
        assert!((axis_feedrate(&arc(0.0), &machine) - 20.0).abs() < 1e-9);
        // A helix advances at the same speed in its plane.
        let helix = arc(5.0);
        let in_plane = 10.0 * std::f64::consts::FRAC_PI_3;
        assert!((axis_feedrate(&helix, &machine) - 20.0 * helix.length / in_plane).abs() < 1e-9);
        // The axis across it sets no limit to an arc without a rise.
        machine.axes[2].velocity = 1.0;
        assert!((axis_feedrate(&arc(0.0), &machine) - 20.0).abs() < 1e-9);
    }

    #[test]
    fn rapids_of_klipper_run_at_the_programmed_feedrate() {
        let mut machine = Machine::default();
        machine.rapid.feedrate = 100.0;
        let program = "G0 X10\nG1 X0 F600\nG0 X10\nG1 X0 F1200\nG0 X10\nX0 F9000\n";
        let toolpath = trace(&read(program.as_bytes()), &machine);
        let rapids = |machine: &Machine| -> Vec<f64> {
            let rapids = toolpath.segments.iter().filter(|segment| segment.motion.is_rapid());
            rapids.map(|segment| requested_feedrate(&segment, machine)).collect()
        };
        assert_eq!(rapids(&machine), [100.0; 4]);
        machine.rapid.at_feedrate = true;
        assert_eq!(rapids(&machine), [100.0, 10.0, 20.0, 100.0]);
        // F at half is still below the limit in the last.
        machine.overrides.feed = 0.5;
        assert_eq!(rapids(&machine), [50.0, 5.0, 10.0, 75.0]);
        machine.overrides.feed = 1.2;
        assert_eq!(rapids(&machine), [100.0, 12.0, 24.0, 100.0]);
    }

    /// Two half turns that LinuxCNC 2.9 was recorded at, between blended corners: 23.19 and 22.35 mm/s.
    #[test]
    fn a_helix_in_half_turns_is_planned_by_the_rise_of_each() {
        let mut machine = Machine::default();
        machine.interpolator.junction = Junction::AccelerationBlend;
        for (axis, acceleration) in machine.axes.iter_mut().zip([840.0, 730.0, 400.0]) {
            axis.acceleration = acceleration;
        }
        for (rise, recorded) in [(-0.5334, 23.19), (-0.3353, 22.35)] {
            let (start, end) = (Point::new(1.50114, 0.0, 0.0), Point::new(-1.50114, 0.0, rise));
            let half_turn = Plane::Xy.arc((start, end), Point::origin(), Turn::Counterclockwise, 1);
            let half_turn = half_turn.expect("a helix");
            let length = half_turn.length();
            let segment =
                Segment { start, end, length, curve: Curve::Arc(std::sync::Arc::new(half_turn)), ..arc(0.0) };
            let own = 0.5 * blended_acceleration(&segment, &machine);
            let planned = blended_arc_feedrate(&segment, own, &machine);
            assert!((planned - recorded).abs() < 0.01, "{planned} mm/s for {recorded}");
        }
        // A steep helix has no more than its weaker axis allows in the plane.
        machine.axes[2].acceleration = 1e4;
        let steep = arc(50.0);
        let Curve::Arc(curve) = &steep.curve else { unreachable!("an arc") };
        let planned = blended_arc_feedrate(&steep, blended_acceleration(&steep, &machine), &machine);
        let in_plane = planned * turning_share(curve, steep.length);
        assert!((in_plane * in_plane / 10.0 - NORMAL_ACCELERATION_SHARE * 730.0).abs() < 1e-6);
    }

    #[test]
    fn an_override_slows_what_linuxcnc_limits_by_acceleration() {
        let mut machine = Machine::default();
        machine.axes.iter_mut().for_each(|axis| axis.acceleration = 300.0);
        machine.overrides.feed = 0.5;
        assert_eq!(requested_feedrate(&arc(0.0), &machine), 50.0);
        machine.interpolator.junction = Junction::AccelerationBlend;
        // √(√3/2 · 300 mm/s² · 10 mm), below the programmed 100 mm/s.
        let limit = (0.5 * 3f64.sqrt() * 300.0 * 10.0).sqrt();
        assert!((requested_feedrate(&arc(0.0), &machine) - 0.5 * limit).abs() < 1e-9);
    }
}
