//! The program's own tolerances: where it sets none, one, or several.

use crate::laws::paths::{Case, Random, cases, line};
use truefeed::machine::{CornerMode, Machine};
use truefeed::quote::quote;
use truefeed::simulation::contour::contour_errors;
use truefeed::simulation::feed::{CornerPolicy, Tolerances};
use truefeed::simulation::gcode::{LineNumber, read};
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::{Blending, Motion, PathMode, Point, Stop, StopCause, Toolpath, Vector};

fn case_count() -> usize {
    crate::shared::case_count(2000)
}

fn mode(from: usize, blending: Blending) -> PathMode {
    PathMode { from, line: LineNumber(1), source: format!("{blending:?}"), blending, merging: None }
}

/// What a program may ask for.
fn blending(random: &mut Random) -> Blending {
    match random.unit() {
        part if part < 0.2 => Blending::Machine,
        part if part < 0.8 => Blending::Within(random.log_between(0.001, 0.2)),
        _ => Blending::Distance(random.log_between(0.005, 2.0)),
    }
}

/// Some modes along a path of `count` segments.
fn modes(random: &mut Random, count: usize) -> Vec<PathMode> {
    let from: Vec<usize> = (0..count).filter(|_| random.chance(0.3)).collect();
    from.into_iter().map(|from| mode(from, blending(random))).collect()
}

fn time(toolpath: &Toolpath, machine: &Machine, rule: CornerPolicy) -> f64 {
    simulate::with_policy(toolpath, machine, rule).cycle_time()
}

#[test]
fn a_program_without_a_tolerance_has_that_of_the_machine() {
    for (mut case, mut random) in cases(40, case_count()) {
        if random.chance(0.5) {
            case.toolpath.path_modes = vec![mode(1, Blending::Machine)];
        }
        assert_eq!(
            simulate::with_policy(&case.toolpath, &case.machine, CornerPolicy::Programmed),
            case.plan(),
            "case {}",
            case.number
        );
    }
}

#[test]
fn a_tolerance_all_along_is_the_same_one_given() {
    for (mut case, mut random) in cases(41, case_count() / 10) {
        let tolerance = random.log_between(0.001, 0.2);
        let given = |case: &Case, tolerances: Tolerances| {
            let (plan, errors) = simulate::within(&case.toolpath, &case.machine, tolerances, &mut |_| {});
            let quote = quote(&case.toolpath, &case.machine, &plan, tolerances, &errors);
            (plan, errors, quote)
        };
        for corner_mode in [CornerMode::Paper, CornerMode::Guaranteed] {
            case.machine.interpolator.corner_mode = corner_mode;
            case.toolpath.path_modes = Vec::new();
            let one = given(&case, Tolerances::One(tolerance));
            case.toolpath.path_modes = vec![mode(0, Blending::Within(tolerance))];
            let programmed = given(&case, Tolerances::Programmed);
            assert_eq!((&one.0, &one.1), (&programmed.0, &programmed.1), "case {}", case.number);
            assert_eq!(one.2.tolerance, programmed.2.tolerance);
            assert_eq!(one.2.beyond_tolerance, programmed.2.beyond_tolerance);
        }
    }
}

#[test]
fn a_program_is_the_sum_of_its_parts_between_full_stops() {
    for (mut case, mut random) in cases(42, case_count()) {
        let count = case.toolpath.segments.len();
        let middle = 1 + random.between(0.0, (count - 1) as f64) as usize;
        case.toolpath.stops.clear();
        let stop = Stop { after: middle, cause: StopCause::MCode { code: 1 }, line: LineNumber(1) };
        case.toolpath.stops.push(stop);
        let halves = [blending(&mut random), blending(&mut random)];
        case.toolpath.path_modes = vec![mode(0, halves[0]), mode(middle, halves[1])];
        let part = |range: std::ops::Range<usize>, half: Blending| Toolpath {
            segments: case.toolpath.segments.range(range).collect(),
            path_modes: vec![mode(0, half)],
            ..Toolpath::default()
        };
        let parts = [part(0..middle, halves[0]), part(middle..count, halves[1])];
        let sum: f64 = parts.iter().map(|part| time(part, &case.machine, CornerPolicy::Programmed)).sum();
        let whole = time(&case.toolpath, &case.machine, CornerPolicy::Programmed);
        assert!((whole / sum - 1.0).abs() < 1e-12, "case {}: {whole} s, parts {sum} s", case.number);
    }
}

/// Corners too far apart to feel each other.
#[test]
fn isolated_corners_take_the_tolerance_that_holds_there() {
    let mut random = Random(0x5eed_0043);
    let mut taken = 0;
    let paths = crate::shared::case_count(300);
    for case in 0..paths {
        let machine = Machine::default();
        let mut toolpath = Toolpath::default();
        let mut start = Point::origin();
        for _ in 0..8 {
            let end = start + 60.0 * random.direction();
            let motion = Motion::Feed { feedrate: random.log_between(5.0, 200.0) };
            toolpath.segments.push(line(start, end, motion));
            start = end;
        }
        toolpath.path_modes = modes(&mut random, 8);
        let plan = simulate::with_policy(&toolpath, &machine, CornerPolicy::Programmed);
        let errors = contour_errors(&toolpath, &plan, &Profile::new(&toolpath, &plan));
        let bounds = Tolerances::Programmed.bounds(&toolpath, &machine);
        for (corner, bound) in bounds.enumerate().take(7) {
            // What holds by the modes as listed, without going along them.
            let allowed = [corner, corner + 1].map(|segment| {
                let in_force = toolpath.path_modes.iter().rfind(|mode| mode.from <= segment);
                let own = machine.interpolator.contour_tolerance;
                let turn: Vector =
                    toolpath.segments.at(corner + 1).tangent(0.0) - toolpath.segments.at(corner).tangent(0.0);
                match in_force.map_or(Blending::Machine, |mode| mode.blending) {
                    Blending::Within(tolerance) => tolerance,
                    Blending::Distance(d) => (0.25 * d * turn.norm()).max(own.min(0.5 * d)),
                    Blending::Machine | Blending::ExactStop | Blending::ExactPath => own,
                }
            });
            let allowed = allowed[0].min(allowed[1]);
            assert_eq!(bound.corner, allowed, "case {case}, corner {corner}");
            let error = errors.corner[corner];
            assert!(error <= allowed * (1.0 + 1e-6), "case {case}, corner {corner}: {error} of {allowed} mm");
            let slower = plan.segment_feedrates[corner].min(plan.segment_feedrates[corner + 1]);
            if plan.corner_feedrates[corner] < slower {
                taken += 1;
                assert!(0.8 * allowed <= error, "case {case}, corner {corner}: {error} of {allowed} mm");
            }
        }
    }
    assert!(5 * paths / 3 < taken, "corners that take their whole tolerance: {taken}");
}

/// Tolerances rise here and there. Arcs keep to one of their own, since a faster leg may lower the command at
/// a corner whose tolerance does not rise.
#[test]
fn a_wider_tolerance_at_some_corners_never_costs_time() {
    for (mut case, mut random) in cases(44, case_count()) {
        case.machine.interpolator.arc_tolerance = Some(case.tolerance());
        case.toolpath.path_modes = modes(&mut random, case.toolpath.segments.len());
        assert_faster(&mut case, |case| {
            for mode in &mut case.toolpath.path_modes {
                if random.chance(0.5) {
                    widen(mode, random.log_between(1.001, 20.0));
                }
            }
        });
    }
}

/// Every tolerance, also the one of the machine, rises by the same ratio.
#[test]
fn wider_tolerances_all_along_never_cost_time() {
    for (mut case, mut random) in cases(47, case_count()) {
        case.toolpath.path_modes = modes(&mut random, case.toolpath.segments.len());
        let ratio = random.log_between(1.001, 20.0);
        assert_faster(&mut case, |case| {
            case.machine.interpolator.contour_tolerance *= ratio;
            case.toolpath.path_modes.iter_mut().for_each(|mode| widen(mode, ratio));
        });
    }
}

fn widen(mode: &mut PathMode, ratio: f64) {
    if let Blending::Within(length) | Blending::Distance(length) = &mut mode.blending {
        *length *= ratio;
    }
}

/// Asserts that a change of a case costs no time.
fn assert_faster(case: &mut Case, change: impl FnOnce(&mut Case)) {
    let narrow = time(&case.toolpath, &case.machine, CornerPolicy::Programmed);
    change(case);
    let wide = time(&case.toolpath, &case.machine, CornerPolicy::Programmed);
    assert!(wide <= narrow * (1.0 + 1e-12), "case {}: {wide} s, not {narrow} s", case.number);
}

#[test]
fn the_guaranteed_mode_holds_each_tolerance_where_it_holds() {
    for (mut case, mut random) in cases(45, case_count() / 4) {
        case.machine.interpolator.corner_mode = CornerMode::Guaranteed;
        case.toolpath.path_modes = modes(&mut random, case.toolpath.segments.len());
        let (_, errors) =
            simulate::within(&case.toolpath, &case.machine, Tolerances::Programmed, &mut |_| {});
        let bounds = Tolerances::Programmed.bounds(&case.toolpath, &case.machine);
        let beyond: Vec<usize> = errors.beyond(bounds, 1.0 + 1e-6).collect();
        assert!(beyond.is_empty(), "case {}: segments {beyond:?}", case.number);
    }
}

#[test]
fn a_given_tolerance_replaces_all_but_exact_stops() {
    for (case, mut random) in cases(46, case_count() / 10) {
        let toolpath = Toolpath {
            path_modes: modes(&mut random, case.toolpath.segments.len()),
            ..case.toolpath.clone()
        };
        let tolerance = random.log_between(0.001, 0.2);
        let given = CornerPolicy::Isolated(tolerance);
        assert_eq!(
            simulate::with_policy(&toolpath, &case.machine, given),
            simulate::with_policy(&case.toolpath, &case.machine, given)
        );
    }
    let machine = Machine::default();
    let of = |text: &str| {
        let toolpath = trace(&read(text.as_bytes()), &machine);
        time(&toolpath, &machine, CornerPolicy::Isolated(0.02))
    };
    let (stops, none) = (of("G64 P.05\nG61\nG1 F3000 X20\nY20\nX0"), of("G64 P.05\nG1 F3000 X20\nY20\nX0"));
    assert!(none * 1.001 < stops, "{none} s without, {stops} s with exact stops");
}
