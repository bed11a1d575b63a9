//! Laws of the work at one hole.

use super::*;
use crate::simulation::toolpath::random::Random;

fn hole(kind: HoleKind) -> Hole {
    Hole {
        kind,
        reference: 2.0,
        bottom: -10.0,
        feed_out_to: 2.0,
        return_to: 20.0,
        feed_in: 3.0,
        feed_out: 5.0,
        dwell: 0.0,
        dwell_outside: 0.0,
    }
}

fn full(depth: f64) -> HoleKind {
    HoleKind::Peck { pecks: Pecks::equal(depth), clearance: 0.5, ceiling: 2.0 }
}

fn chips(depth: f64) -> HoleKind {
    HoleKind::ChipBreak { pecks: Pecks::equal(depth), retract: 0.5, ceiling: 2.0 }
}

/// Every kind, with pecks of `depth` and heights below `reach`.
fn kinds(depth: f64, reach: f64) -> [HoleKind; 11] {
    let (turn, shift) = (SpindleTurn::Right, [0.2, -0.1]);
    [
        HoleKind::Drill,
        chips(depth),
        full(depth),
        HoleKind::Tap { turn: SpindleTurn::Left, is_rigid: false, pecks: None },
        HoleKind::Tap { turn, is_rigid: true, pecks: Some(TapPecks { depth, back: 0.5 }) },
        HoleKind::Tap { turn, is_rigid: true, pecks: None },
        HoleKind::Bore,
        HoleKind::BoreAndStop { turn, by_hand: true },
        HoleKind::FineBore { turn, shift },
        HoleKind::BackBore { turn, shift, top: reach, feeds_back: true },
        HoleKind::BackBore { turn, shift, top: reach, feeds_back: false },
    ]
}

fn steps(hole: &Hole) -> Vec<HoleStep> {
    work(hole).expect("a possible hole").steps
}

/// Lengths of feed and of rapid moves along the axis from the first height on, mm.
fn lengths(steps: &[HoleStep]) -> (f64, f64) {
    let (mut feed, mut rapid, mut at) = (0.0, 0.0, None);
    for step in steps {
        match *step {
            HoleStep::Rapid(to) => {
                rapid += (to - at.unwrap_or(to)).abs();
                at = Some(to);
            }
            HoleStep::Feed { to, .. } => {
                feed += (to - at.expect("feed begins at R")).abs();
                at = Some(to);
            }
            _ => {}
        }
    }
    (feed, rapid)
}

#[test]
fn every_hole_begins_at_the_reference_and_ends_at_the_return_height() {
    for kind in kinds(1.0, -5.0) {
        let hole = hole(kind);
        let steps = steps(&hole);
        assert_eq!(steps[0], HoleStep::Rapid(2.0), "{kind:?}");
        let height = |step: &HoleStep| match *step {
            HoleStep::Rapid(to) | HoleStep::Feed { to, .. } => Some(to),
            _ => None,
        };
        assert_eq!(steps.iter().rev().find_map(height), Some(20.0), "{kind:?}");
        let reaches = steps.iter().filter_map(height).fold(f64::INFINITY, f64::min);
        assert_eq!(reaches, -10.0, "{kind:?}");
    }
}

/// A tool taken off the wall comes back to the axis, and a spindle that stopped turns again as
/// it did before.
#[test]
fn every_hole_ends_as_it_began() {
    for kind in kinds(1.0, -5.0) {
        let steps = steps(&hole(kind));
        let shift = steps.iter().rev().find_map(|step| match step {
            HoleStep::Shift(shift) => Some(*shift),
            _ => None,
        });
        assert_eq!(shift.unwrap_or_default(), [0.0; 2], "{kind:?}");
        let spindle =
            steps.iter().rfind(|step| matches!(step, HoleStep::Start(_) | HoleStep::Stop | HoleStep::Orient));
        let turn = match kind {
            HoleKind::Tap { turn, .. }
            | HoleKind::BoreAndStop { turn, .. }
            | HoleKind::FineBore { turn, .. }
            | HoleKind::BackBore { turn, .. } => Some(HoleStep::Start(turn)),
            _ => None,
        };
        assert_eq!(spindle.copied(), turn, "{kind:?}");
    }
}

#[test]
fn pecks_deeper_than_the_hole_are_plain_drilling() {
    let plain = steps(&hole(HoleKind::Drill));
    for depth in [12.0, 12.5, 1e9, f64::INFINITY] {
        assert_eq!(steps(&hole(full(depth))), plain, "{depth}");
        assert_eq!(steps(&hole(chips(depth))), plain, "{depth}");
    }
}

/// 12 mm deep by pecks of 5, 5 and 2, each new one fed for 0.5 mm more.
#[test]
fn feed_and_rapid_of_pecks_are_what_the_head_says() {
    assert_eq!(lengths(&steps(&hole(full(5.0)))), (13.0, 5.0 + 4.5 + 10.0 + 9.5 + 30.0));
    assert_eq!(lengths(&steps(&hole(chips(5.0)))), (13.0, 0.5 + 0.5 + 30.0));
}

/// 5, then 0.8 · 5 − 1 = 3, then 2 in place of 1.4, and 2 again to the bottom.
#[test]
fn pecks_shrink_down_to_the_least() {
    let pecks = Pecks { first: 5.0, ratio: 0.8, decrease: 1.0, least: 2.0 };
    let kind = HoleKind::ChipBreak { pecks, retract: 0.5, ceiling: 2.0 };
    let depths: Vec<f64> = steps(&hole(kind))
        .iter()
        .filter_map(|step| if let HoleStep::Feed { to, .. } = step { Some(*to) } else { None })
        .collect();
    assert_eq!(depths, [-3.0, -6.0, -8.0, -10.0]);
}

/// Ten times a tenth is less than one in binary numbers, which makes no eleventh peck.
#[test]
fn rounding_makes_no_peck_of_its_own() {
    for count in 1..=200 {
        let mut hole = hole(full(0.1));
        hole.bottom = hole.reference - 0.1 * f64::from(count);
        let feeds = steps(&hole).iter().filter(|step| matches!(step, HoleStep::Feed { .. })).count();
        assert_eq!(feeds, count as usize);
    }
}

#[test]
fn pecks_begin_again_no_higher_than_the_ceiling() {
    for step in steps(&hole(full(0.1))).iter().rev().skip(1) {
        assert!(!matches!(step, HoleStep::Rapid(to) if 2.0 < *to), "{step:?}");
    }
}

#[test]
fn floating_taps_stop_before_they_turn_round() {
    let kind = HoleKind::Tap { turn: SpindleTurn::Right, is_rigid: false, pecks: None };
    let floating = steps(&Hole { dwell: 0.3, dwell_outside: 0.2, ..hole(kind) });
    let expected = [
        HoleStep::Rapid(2.0),
        HoleStep::Feed { to: -10.0, feedrate: 3.0 },
        HoleStep::Dwell(0.3),
        HoleStep::Stop,
        HoleStep::Start(SpindleTurn::Left),
        HoleStep::Feed { to: 2.0, feedrate: 5.0 },
        HoleStep::Dwell(0.2),
        HoleStep::Stop,
        HoleStep::Start(SpindleTurn::Right),
        HoleStep::Rapid(20.0),
    ];
    assert_eq!(floating, expected);
    let rigid = steps(&hole(HoleKind::Tap { turn: SpindleTurn::Right, is_rigid: true, pecks: None }));
    assert!(!rigid.contains(&HoleStep::Stop) && rigid.contains(&HoleStep::Start(SpindleTurn::Left)));
}

/// 12 mm deep by pecks of 5, 5 and 2: back by 0.5 mm after each, or out.
#[test]
fn taps_in_pecks_turn_round_for_each_way() {
    let tap = |back: f64| {
        let pecks = Some(TapPecks { depth: 5.0, back });
        steps(&hole(HoleKind::Tap { turn: SpindleTurn::Right, is_rigid: true, pecks }))
    };
    for (back, feed) in [(0.5, 24.0 + 2.0 * 2.0 * 0.5), (f64::INFINITY, 24.0 + 2.0 * (5.0 + 10.0))] {
        let steps = tap(back);
        assert_eq!(lengths(&steps), (feed, 18.0));
        let reversals = steps.iter().filter(|step| matches!(step, HoleStep::Start(_))).count();
        assert_eq!(reversals, 6);
    }
    let deep = Some(TapPecks { depth: 12.0, back: 0.5 });
    let one = |pecks| steps(&hole(HoleKind::Tap { turn: SpindleTurn::Left, is_rigid: false, pecks }));
    assert_eq!(one(deep), one(None));
}

#[test]
fn what_cannot_be_made_says_why() {
    let above = Hole { bottom: 3.0, ..hole(HoleKind::Drill) };
    assert_eq!(work(&above), Err(NoHole::BottomAboveReference { bottom: 3.0, reference: 2.0 }));
    for depth in [0.0, -1.0] {
        assert_eq!(work(&hole(full(depth))), Err(NoHole::BadPeck(depth)));
        assert_eq!(work(&hole(chips(depth))), Err(NoHole::BadPeck(depth)));
    }
    let low = HoleKind::BackBore { turn: SpindleTurn::Right, shift: [0.0; 2], top: -11.0, feeds_back: true };
    assert_eq!(work(&hole(low)), Err(NoHole::TopBelowBottom { top: -11.0, bottom: -10.0 }));
    let far = Hole { reference: f64::MAX, bottom: -f64::MAX, ..hole(HoleKind::Drill) };
    assert_eq!(work(&far), Err(NoHole::OutOfReach));
}

#[test]
fn any_numbers_give_a_bounded_list() {
    let numbers = [0.0, 1e-300, 1e-9, 0.1, 1.0, 1e7, 1e16, 1e300, f64::MAX, f64::INFINITY];
    let mut random = Random(7);
    let mut number = |signed: bool| {
        let value = numbers[random.below(numbers.len())];
        if signed && random.below(2) == 0 { -value } else { value }
    };
    let mut made = 0;
    for _ in 0..20_000 {
        let pecks =
            Pecks { first: number(true), ratio: number(true), decrease: number(true), least: number(true) };
        let (height, ceiling) = (number(true), number(true));
        for kind in [
            HoleKind::Peck { pecks, clearance: height, ceiling },
            HoleKind::ChipBreak { pecks, retract: height, ceiling },
        ] {
            let (reference, bottom, return_to) = (number(true), number(true), number(true));
            let hole = Hole { reference, bottom, return_to, feed_out_to: reference, ..hole(kind) };
            if let Ok(work) = work(&hole) {
                assert!(work.steps.len() <= 3 * MAX_PECKS as usize + 10, "{hole:?}");
                assert_eq!(work.steps.last(), Some(&HoleStep::Rapid(return_to)));
                made += 1;
            }
        }
    }
    assert!(1000 < made, "{made}");
}

#[test]
fn too_many_pecks_are_made_deeper() {
    let most = work(&hole(full(12.0 / 1000.0))).expect("a possible hole");
    assert_eq!(most.pecks_per_made, 1.0);
    let tiny = work(&hole(full(1e-6))).expect("a possible hole");
    assert!((tiny.pecks_per_made - 12_000.0).abs() < 1e-6, "{}", tiny.pecks_per_made);
    assert_eq!(tiny.steps, most.steps);
}
