//! Laws that the stand-in machine itself has to keep.

use std::path::Path;

#[path = "../../tests/shared/corpus.rs"]
#[allow(dead_code)]
mod corpus;

use crate::cases::{Counts, cases, write};
use crate::effects::{LIBRARY, conceal};
use crate::path::{Shape, add, between, norm};
use crate::physics::{Motion, Physics, TICK};
use crate::random::Random;
use crate::reader::{Step, read};
use crate::{drive, fir, planner, program, score};

fn travelled(motion: &Motion) -> f64 {
    motion.position.windows(2).map(|p| norm(between(p[0], p[1]))).sum()
}

fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

fn speeds(motion: &Motion) -> Vec<f64> {
    motion.position.windows(2).map(|p| norm(between(p[0], p[1])) / TICK).collect()
}

/// Distance of a point from the programmed lines.
fn distance(point: [f64; 3], lines: &[([f64; 3], [f64; 3])]) -> f64 {
    let to = |(from, to): &([f64; 3], [f64; 3])| {
        let along = between(*from, *to);
        let to_point = between(*from, point);
        let dot: f64 = (0..3).map(|k| along[k] * to_point[k]).sum();
        let share = (dot / norm(along).powi(2).max(1e-12)).clamp(0.0, 1.0);
        norm(between(add(*from, share, along), point))
    };
    lines.iter().map(to).fold(f64::INFINITY, f64::min)
}

fn lines_of(steps: &[Step]) -> Vec<([f64; 3], [f64; 3])> {
    let line = |step: &Step| match step {
        Step::Move { shape: Shape::Line { from, to }, .. } => Some((*from, *to)),
        _ => None,
    };
    steps.iter().filter_map(line).collect()
}

#[test]
fn the_fir_kernel_keeps_the_distance_and_reaches_the_feed() {
    let steps = read("F3000\nG1 X40\nG1 X100\nM30\n");
    let motion = fir::command(&steps, &Physics::base(3, 0.0255, 0.02));
    assert!((travelled(&motion) - 100.0).abs() < 1e-6, "{}", travelled(&motion));
    assert!((greatest(speeds(&motion).into_iter()) - 50.0).abs() < 1e-6);
    assert!((motion.cycle_time - (2.0 + 3.0 * 0.0255)).abs() < 1e-9);
    let end = motion.position[motion.position.len() - 1];
    assert!((end[0] - 100.0).abs() < 1e-6, "{end:?}");
}

#[test]
fn fir_corners_stay_within_tolerance() {
    for (tolerance, filters) in [(0.01, 3), (0.05, 3), (0.02, 2), (0.02, 4)] {
        let steps = read("F2000\nG1 X40\nG1 X80 Y40\nG1 X40 Y80\nG1 X40 Y20\nM30\n");
        let motion = fir::command(&steps, &Physics::base(filters, 0.025, tolerance));
        let lines = lines_of(&steps);
        let error = greatest(motion.position.iter().map(|p| distance(*p, &lines)));
        assert!(error <= 1.02 * tolerance, "{filters} filters, {tolerance}: {error}");
        assert!(0.8 * tolerance < error, "the tolerance is used: {filters} filters, {tolerance}: {error}");
    }
}

#[test]
fn the_planner_keeps_every_axis_limit_and_the_tolerance() {
    for seed in 0..6 {
        let mut random = Random::new(seed, 3);
        let steps = read(&program::write(&["rect", "zigzag", "surf", "arcs", "troch"], &mut random));
        let mut physics = Physics::base(3, 0.02, 0.03);
        physics.axis_acceleration = [500.0, 900.0, 700.0];
        physics.axis_velocity = [30.0, 45.0, 60.0];
        let motion = planner::command(&steps, &physics);
        for axis in 0..3 {
            let x: Vec<f64> = motion.position.iter().map(|p| p[axis]).collect();
            let v = greatest(x.windows(2).map(|p| (p[1] - p[0]).abs() / TICK));
            let a = greatest(x.windows(3).map(|p| (p[2] - 2.0 * p[1] + p[0]).abs() / TICK / TICK));
            assert!(v <= physics.axis_velocity[axis] * 1.001, "seed {seed}, axis {axis}: {v} mm/s");
            // Programs are rounded to 0.1 µm, which shows as 1 % where arcs meet.
            assert!(a <= physics.axis_acceleration[axis] * 1.02, "seed {seed}, axis {axis}: {a} mm/s²");
        }
        let end = steps.iter().rev().find_map(|step| match step {
            Step::Move { shape, .. } => Some(shape.point(shape.length())),
            Step::Wait { .. } => None,
        });
        assert!(
            norm(between(end.expect("the program moves"), *motion.position.last().expect("it moved"))) < 1e-3
        );
    }
}

#[test]
fn planner_corners_stay_within_tolerance() {
    let steps = read("F3000\nG1 X40\nG1 X80 Y40\nG1 X40 Y80\nG1 X40 Y20\nG1 X40.5 Y20\nG1 X40.5 Y90\nM30\n");
    let lines = lines_of(&steps);
    let motion = planner::command(&steps, &Physics::base(3, 0.02, 0.03));
    let error = greatest(motion.position.iter().map(|p| distance(*p, &lines)));
    assert!(error <= 0.03 + 1e-9 && 0.02 < error, "{error}");
}

#[test]
fn the_drive_lags_by_its_constant_and_stands_in_its_play() {
    let mut physics = Physics::base(3, 0.02, 0.03);
    physics.drive.lag = 0.02;
    let steps = read("F3000\nG1 X100\nG1 X0\nM30\n");
    let command = fir::command(&steps, &physics);
    let mut actual = command.position.clone();
    drive::drive(&mut actual, &physics.drive);
    let behind = greatest(command.position.iter().zip(&actual).map(|(c, a)| (c[0] - a[0]).abs()));
    assert!((behind - 50.0 * 0.02).abs() < 1e-3, "a lag τ at speed v leaves v τ: {behind}");
    let mut table = command.position.clone();
    drive::drive(&mut table, &drive_with_backlash(0.02));
    let error = greatest(command.position.iter().zip(&table).map(|(c, a)| (c[0] - a[0]).abs()));
    assert!((error - 0.01).abs() < 1e-9, "{error}");
}

fn drive_with_backlash(width: f64) -> crate::physics::Drive {
    crate::physics::Drive { backlash: Some((0, width)), ..Default::default() }
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let counts = Counts { singles: 4, negatives: 1, doubles: 1, outside: 1, ambiguous: 1, planners: 1 };
    let of = |seed| -> Vec<String> {
        let text = |c: &crate::cases::Case| format!("{}{}{}{}", c.program, c.machine, c.recording, c.answer);
        cases(seed, &counts).iter().map(text).collect()
    };
    assert_eq!(of(5), of(5));
    assert_eq!(of(5).len(), 9);
    assert_ne!(of(5), of(6));
}

/// The gate of validity: with nothing concealed the predictor's cycle time is the plant's.
#[test]
fn without_an_effect_the_predictor_agrees() {
    use truefeed::simulation::simulate;
    for seed in 0..12 {
        let mut random = Random::new(seed, 11);
        let (text, families) = program::draw(&mut random);
        let physics = Physics::base(3, random.uniform(0.018, 0.032), random.pick(&[0.01, 0.02, 0.05]));
        let plant = fir::command(&read(&text), &physics).cycle_time;
        let machine = crate::cases::machine_file("gate", &physics);
        let machine = truefeed::project::machine_from_toml(&machine).expect("the file is in the tool's form");
        let program = truefeed::simulation::gcode::read(text.as_bytes());
        let toolpath = truefeed::simulation::interpreter::trace(&program, &machine);
        let (plan, _) = simulate::within(&toolpath, &machine, physics.tolerance, &mut |_| {});
        let predicted = plan.cycle_time();
        let share = (predicted / plant - 1.0).abs();
        assert!(share < 0.0005, "seed {seed} {families:?}: plant {plant}, predicted {predicted}");
    }
}

/// The FIR kernel against a machine that others wrote. That machine counts
/// up to half a second of standing in its cycle times, so what the effect costs is compared.
#[test]
fn another_plant_pays_as_much() {
    let folder = corpus::recordings().join("plant");
    let answers = std::fs::read(folder.join("answers.json")).expect("the corpus has the answers");
    let answers: serde_json::Value = serde_json::from_slice(&answers).expect("the answers are JSON");
    for (name, answer) in answers.as_object().expect("an object") {
        let read_text =
            |file| std::fs::read_to_string(folder.join(name).join(file)).expect("the case is whole");
        let machine = read_text("machine.toml");
        let number = |key: &str| -> f64 {
            let line =
                machine.lines().find(|line| line.starts_with(key)).expect("the machine file has the key");
            line.split('=').nth(1).expect("a value").trim().parse().expect("a number")
        };
        let mut physics = Physics::base(3, number("time_constant_s"), number("contour_tolerance_mm"));
        physics.rapid = number("feed_mm_min") / 60.0;
        physics.tool_change = number("tool_change_s");
        let steps = read(&read_text("program.nc"));
        let clean = fir::command(&steps, &physics).cycle_time;
        let told = |key: &str| answer[key].as_f64().expect("seconds");
        let standing = told("clean_s") - clean;
        assert!((-0.05..0.55).contains(&standing), "{name}: {clean} s, told {} s", told("clean_s"));
        let effects = answer["effects"].as_object().expect("an object");
        if effects.iter().all(|(id, of)| with(id, of, &mut physics)) {
            let cost = fir::command(&steps, &physics).cycle_time - clean;
            let theirs = told("true_s") - told("clean_s");
            assert!(
                (cost - theirs).abs() < 0.02 + 0.03 * theirs.abs(),
                "{name}: costs {cost} s, told {theirs} s"
            );
        }
    }
}

/// Sets one effect from the other plant's parameters; false where its law is another one, or not kept.
fn with(id: &str, of: &serde_json::Value, physics: &mut Physics) -> bool {
    let number = |key: &str| of[key].as_f64().unwrap_or(f64::NAN);
    let axis = of["axis"].as_u64().unwrap_or(0) as usize;
    match id {
        "filter_time_constant" => physics.boxes.iter_mut().for_each(|t| *t *= number("ratio")),
        "unmodelled_wait" => physics.wait = Some((number("line") as u32, number("seconds"))),
        "feed_hold" => physics.hold = Some((number("line") as u32, number("seconds"))),
        "axis_velocity_limit" => physics.axis_velocity[axis] = number("v_mm_min") / 60.0,
        "centripetal_acceleration_limit" => physics.centripetal = number("a_mm_s2"),
        "rapid_override" => physics.rapid_override = number("ratio"),
        "servo_lag" | "backlash" | "structural_vibration" => {}
        _ => return false,
    }
    true
}

/// Every effect of the library, strongly concealed, changes what the recorder sees, and the waits cost
/// what was drawn.
#[test]
fn every_effect_acts() {
    let believed = Physics::base(3, 0.025, 0.02);
    for id in LIBRARY {
        let shown = (0..20).find_map(|seed| {
            let mut random = Random::new(seed, 5);
            let steps = read(&program::draw(&mut random).0);
            let mut physics = believed.clone();
            conceal(id, 10.0, &steps, &mut physics, &mut random)?;
            Some((steps, physics))
        });
        let (steps, physics) = shown.unwrap_or_else(|| panic!("{id} fits no program"));
        let clean = fir::command(&steps, &believed);
        let mut real = fir::command(&steps, &physics);
        drive::drive(&mut real.position, &physics.drive);
        let moved = greatest(clean.position.iter().zip(&real.position).map(|(a, b)| norm(between(*a, *b))));
        assert!(0.005 < moved || physics.clock != 1.0, "{id}: {moved} mm");
        let cost = real.cycle_time - clean.cycle_time;
        match id {
            "feed_hold" | "unmodelled_wait" => assert!((cost - 1.0).abs() < 1e-6, "{id}: {cost} s"),
            "servo_lag" | "backlash" | "structural_vibration" => assert!(cost.abs() < 1e-9, "{id}: {cost} s"),
            "in_position_wait"
            | "look_ahead"
            | "block_processing_time"
            | "rapid_override"
            | "path_acceleration_limit" => {
                assert!(0.0 < cost, "{id}: {cost} s")
            }
            _ => {}
        }
    }
}

/// With an acceleration limit alone, a move takes L/F + F/A and the filters' delay, and never jumps; with a jerk
/// limit alone, a ramp takes 2 √(F/J).
#[test]
fn ramps_take_their_time() {
    let steps = read("F3000\nG1 X100\nM30\n");
    let mut physics = Physics::base(3, 0.02, 0.02);
    physics.path_acceleration = 400.0;
    let motion = fir::command(&steps, &physics);
    let (time, fastest) = (motion.cycle_time, greatest(speeds(&motion).into_iter()));
    assert!((time - (2.0 + 50.0 / 400.0 + 0.06)).abs() < 1e-6, "{time}");
    assert!(fastest < 50.0 * (1.0 + 1e-9), "{fastest}");
    physics.path_acceleration = f64::INFINITY;
    physics.jerk = 5000.0;
    let time = fir::command(&steps, &physics).cycle_time;
    assert!((time - (2.0 + 0.2 + 0.06)).abs() < 1e-6, "{time}");
}

#[test]
fn reports_are_scored() {
    let folder = std::env::temp_dir().join(format!("standin-{}", std::process::id()));
    let counts = Counts { singles: 2, negatives: 1, doubles: 0, outside: 1, ambiguous: 0, planners: 0 };
    let cases = cases(9, &counts);
    write(&cases, &folder).expect("the folder can be written");
    for (number, case) in (1..).zip(&cases) {
        let effects = case.answer["effects"].as_object().expect("an object");
        let named = case.answer["stratum"] == "single";
        let causes: Vec<serde_json::Value> = effects.iter().filter(|_| named).map(|(id, parameters)| {
            serde_json::json!({"id": id, "parameters": parameters, "uncertainty": {}, "lines": null, "seconds": 1.0})
        }).collect();
        let verdict = match case.answer["stratum"].as_str() {
            Some("single") => "explained",
            Some("outside") => "unknown",
            _ => "nothing_missing",
        };
        let place = folder.join(format!("case-{number:02}"));
        std::fs::write(
            place.join("report.json"),
            serde_json::json!({"verdict": verdict, "causes": causes}).to_string(),
        )
        .expect("the report can be written");
    }
    let page = score::page(&folder, &folder).expect("the reports can be read");
    let missing = score::page(&folder, Path::new("nowhere")).expect("absent reports are counted");
    std::fs::remove_dir_all(&folder).expect("the folder is ours");
    assert!(page.contains("| single causes named first | 2 of 2 |"), "{page}");
    assert!(page.contains("| negatives with a cause named | 0 of 1 |"), "{page}");
    assert!(page.contains("| outside the library, called unknown | 1 of 1 |"), "{page}");
    assert!(missing.contains("| reports missing | 4 of 4 |"), "{missing}");
}
