use super::*;
use crate::simulation::gcode::read;
use crate::simulation::simulate;
use crate::simulation::toolpath::trace;

/// All places of a program on a machine at 10 µm, and what is lost in all.
fn places(program: &str, machine: &Machine) -> (Vec<LostAt>, f64) {
    let toolpath = trace(&read(program.as_bytes()), machine);
    let tolerances = Tolerances::One(0.010);
    let (plan, _) = simulate::within(&toolpath, machine, tolerances, &mut |_| {});
    let mut all = Vec::new();
    each_place(&toolpath, machine, &plan, tolerances, &mut |place| all.push(place));
    (all, total(&toolpath, machine, &plan))
}

/// A program with every kind of place.
fn of_all_kinds() -> String {
    let mut program = String::from(
        "G21 G90 G94\nT1 M6\nG0 X0 Y0\nG1 X30 F3000\nG1 Y30\nG2 X40 Y20 I0 J-10\nG4 P0.5\nM8\nG0 Z5\nG0 X0\n",
    );
    for i in 1..200 {
        program += &format!("G1 X{:.3} Y{:.3}\n", i as f64 * 0.2, if i % 3 == 0 { 0.3 } else { 0.0 });
    }
    program + "G1 X200\nG9 G1 Y80\nG1 X0\nM30\n"
}

fn machines() -> Vec<Machine> {
    let plain = Machine::default();
    let mut limited = plain.clone();
    for axis in &mut limited.axes {
        axis.acceleration = 900.0;
    }
    let mut halting = plain.clone();
    halting.halts.feed_holds.insert(4, 2.5);
    halting.times.start = 3.0;
    halting.rapid.exact_stop = true;
    vec![plain, limited, halting]
}

#[test]
fn places_add_up_to_all_that_is_lost() {
    for machine in machines() {
        let (all, total) = places(&of_all_kinds(), &machine);
        let sum: f64 = all.iter().map(|place| place.seconds).sum();
        assert!(0.0 < total);
        assert!((sum / total - 1.0).abs() < 1e-9, "{sum} s in places, {total} s in all");
    }
}

#[test]
fn places_follow_one_another_along_the_path() {
    for machine in machines() {
        let (all, _) = places(&of_all_kinds(), &machine);
        for place in &all {
            assert!(place.distance.0 <= place.distance.1, "{place:?}");
            assert!(place.lines.0 <= place.lines.1, "{place:?}");
        }
    }
}

#[test]
fn the_costliest_come_first_and_are_the_largest() {
    let machine = Machine::default();
    let toolpath = trace(&read(of_all_kinds().as_bytes()), &machine);
    let tolerances = Tolerances::One(0.010);
    let (plan, _) = simulate::within(&toolpath, &machine, tolerances, &mut |_| {});
    let told = lost(&toolpath, &machine, &plan, tolerances);
    let (mut all, total) = places(&of_all_kinds(), &machine);
    all.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    assert_eq!(told.total, total);
    assert_eq!(told.places.len(), MOST_PLACES);
    let seconds = |places: &[LostAt]| places.iter().map(|place| place.seconds).collect::<Vec<_>>();
    assert_eq!(seconds(&told.places), seconds(&all[..MOST_PLACES]));
}

#[test]
fn a_corner_between_long_lines_is_one_place() {
    let (all, total) = places("G21 G90 G94\nG1 X50 F3000\nG1 Y50\nG1 X51\n", &Machine::default());
    let corner = all.iter().find(|place| matches!(place.reason, Reason::Corner { .. })).expect("a corner");
    let Reason::Corner { turn, tolerance } = corner.reason else { unreachable!() };
    assert!((turn - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!(tolerance, 0.010);
    assert_eq!(corner.lines, (LineNumber(2), LineNumber(3)));
    assert!(corner.distance.0 < 50.0 && 50.0 < corner.distance.1);
    assert!(0.0 < corner.seconds && corner.seconds < total);
}

#[test]
fn a_staircase_is_one_row_of_short_blocks() {
    let stairs: String =
        (1..=40).map(|i| format!("G1 X{} Y{}\n", 20.0 + i as f64 * 0.1, (i % 2) as f64 * 0.1)).collect();
    let (all, total) = places(&format!("G21 G90 G94\nG1 X20 F3000\n{stairs}G1 X2000\n"), &Machine::default());
    let rows: Vec<_> =
        all.iter().filter(|place| matches!(place.reason, Reason::ShortBlocks { .. })).collect();
    assert_eq!(rows.len(), 1, "{all:?}");
    assert_eq!(rows[0].reason, Reason::ShortBlocks { blocks: 40 });
    assert!(0.5 * total < rows[0].seconds);
}

#[test]
fn a_long_surface_is_divided() {
    let surface: String =
        (1..=4000).map(|i| format!("G1 X{:.2} Y{}\n", i as f64 * 0.1, (i % 2) as f64 * 0.1)).collect();
    let (all, _) = places(&format!("G21 G90 G94\nF3000\n{surface}"), &Machine::default());
    let length = all.iter().map(|place| place.distance.1).fold(0.0, f64::max);
    assert!(90 < all.len());
    assert!(all.iter().all(|place| place.distance.1 - place.distance.0 < 0.011 * length));
}

#[test]
fn waits_are_lost_whole() {
    let mut machine = Machine::default();
    machine.times.tool_change = 4.0;
    let (all, _) = places("G21 G90 G94\nT1 M6\nG1 X50 F3000\nG4 P1.5\nG1 X100\n", &machine);
    let waits: Vec<(StopCause, f64)> = all
        .iter()
        .filter_map(|place| match place.reason {
            Reason::Wait(cause) => Some((cause, place.seconds)),
            _ => None,
        })
        .collect();
    assert_eq!(waits.len(), 2, "{all:?}");
    assert!(matches!(waits[0], (StopCause::ToolChange { tool: Some(1) }, 4.0)));
    assert!(matches!(waits[1], (StopCause::Dwell { .. }, 1.5)));
    let ramps: Vec<Reason> =
        all.iter().map(|place| place.reason).filter(|reason| matches!(reason, Reason::Ramp(_))).collect();
    assert_eq!(ramps.len(), 3, "before, at and after the dwell: {ramps:?}");
    assert!(matches!(ramps[1], Reason::Ramp(Standing::For(StopCause::Dwell { .. }))));
    assert_eq!(ramps[2], Reason::Ramp(Standing::End));
}
