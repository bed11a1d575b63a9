//! Times that are not motion: neutral ones change nothing, each adds exactly what it says, and the
//! parts of a program add up to the whole.

use crate::laws::paths::{Case, cases};
use truefeed::machine::{FunctionTimes, Machine, PARAMETERS, SpindleDirection, SpindleState};
use truefeed::quote::{Breakdown, Quote, TimeShare, breakdown, programmed_time, quote};
use truefeed::simulation::feed::CornerPolicy;
use truefeed::simulation::gcode::{LineNumber, read};
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::{Operation, Stop, StopCause, Toolpath};

fn case_count() -> usize {
    crate::shared::case_count(2_000)
}

/// Every word that makes the machine wait, the spindle at several speeds.
const PROGRAM: &str = "\
G21 G90 T1 M6
S6000 M3
M8
G0 X10
G1 X60 F2000
S9000
X90 Y20
M9
M0
M1
T2 M6
S3000 M4
G1 X20 Y20
M10
G1 X10
M11
M60
G4 P1.5
T2 M6
M3
M77
G1 X0
M5
M30
";

fn breakdown_on(machine: &Machine) -> Breakdown {
    let toolpath = trace(&read(PROGRAM.as_bytes()), machine);
    let plan = simulate::with_policy(
        &toolpath,
        machine,
        CornerPolicy::Isolated(machine.interpolator.contour_tolerance),
    );
    let breakdown = breakdown(&toolpath, machine, &plan);
    assert!((breakdown.total() - plan.cycle_time()).abs() < 1e-9);
    breakdown
}

fn parts(breakdown: &Breakdown) -> [f64; 12] {
    let b = breakdown;
    let f = &b.functions;
    let functions = [f.spindle, f.coolant, f.stops, f.pallet, f.clamp, f.m_words, f.start];
    assert!((functions.iter().sum::<f64>() - b.other).abs() <= 1e-9 * (1.0 + b.other));
    let [spindle, coolant, stops, pallet, clamp, m_words, start] = functions;
    [
        b.cutting,
        b.rapid,
        b.dwell,
        b.tool_change,
        b.other,
        spindle,
        coolant,
        stops,
        pallet,
        clamp,
        m_words,
        start,
    ]
}

const DWELL: usize = 2;
const TOOL_CHANGE: usize = 3;
const OTHER: usize = 4;
const SPINDLE: usize = 5;
const COOLANT: usize = 6;
const STOPS: usize = 7;
const PALLET: usize = 8;
const CLAMP: usize = 9;
const M_WORDS: usize = 10;
const START: usize = 11;

#[test]
fn each_time_is_added_as_often_as_it_is_asked_for() {
    let before = parts(&breakdown_on(&Machine::default()));
    type Change = fn(&mut FunctionTimes);
    let cases: [(Change, usize, f64); 18] = [
        (|t| t.start = 4.5, START, 4.5),
        (|t| t.dwell_excess = 0.004, DWELL, 0.004),
        // The third M6 finds its tool in the spindle.
        (|t| t.tool_change += 1.0, TOOL_CHANGE, 2.0),
        (|t| t.first_tool_change = Some(t.tool_change - 1.5), TOOL_CHANGE, -1.5),
        (|t| t.tools = [(2, 9.0), (3, 50.0)].into(), TOOL_CHANGE, 5.0),
        // Two starts and a reversal, a stop and half the reversal; a tool change stops as well.
        (|t| t.spindle.start = Some(1.0), SPINDLE, 3.0),
        (|t| t.spindle.stop = Some(0.25), SPINDLE, 0.5),
        // M8 waits for the ramp to 6000; what follows is waited for by no word.
        (|t| (t.spindle.ramp, t.spindle_awaited_by) = (1e-3, vec![8]), COOLANT, 6.0),
        (|t| t.coolant_on = Some(3.0), COOLANT, 3.0),
        (|t| t.coolant_off = Some(0.5), COOLANT, 0.5),
        (|t| t.m_codes = [(8, 3.5), (9, 0.5)].into(), COOLANT, 4.0),
        (|t| t.program_stop = Some(60.0), STOPS, 60.0),
        (|t| (t.program_stop, t.takes_optional_stop) = (Some(60.0), true), STOPS, 120.0),
        (|t| (t.optional_stop, t.takes_optional_stop) = (Some(20.0), true), STOPS, 20.0),
        (|t| t.pallet_change = Some(15.0), PALLET, 15.0),
        (|t| (t.pallet_change, t.pallet_words) = (Some(15.0), vec![60, 77]), PALLET, 30.0),
        (|t| t.clamp = Some(0.8), CLAMP, 1.6),
        (|t| t.m_codes = [(77, 2.0), (30, 1.0)].into(), M_WORDS, 3.0),
    ];
    for (index, (change, part, expected)) in cases.into_iter().enumerate() {
        let mut machine = Machine::default();
        change(&mut machine.times);
        let after = parts(&breakdown_on(&machine));
        for (other, (after, before)) in after.into_iter().zip(before).enumerate() {
            let is_part = other == part || (other == OTHER && part != TOOL_CHANGE && part != DWELL);
            let expected = if is_part { expected } else { 0.0 };
            assert!(
                (after - before - expected).abs() < 1e-9,
                "case {index}, part {other}: {}",
                after - before
            );
        }
    }
}

#[test]
fn a_spindle_ramp_takes_each_change_of_speed_and_a_full_stop_at_an_s_word() {
    let mut machine = Machine::default();
    let before = parts(&breakdown_on(&machine));
    machine.times.spindle.ramp = 1e-3;
    let after = parts(&breakdown_on(&machine));
    // 6000 and 3000 up; after the change 3000 up, over to 3000 the other way, and down.
    assert!((after[SPINDLE] - before[SPINDLE] - (6.0 + 3.0 + 3.0 + 6.0 + 3.0)).abs() < 1e-9);
    // The S word in the cut is a corner less and a stop more.
    let toolpath = trace(&read(PROGRAM.as_bytes()), &machine);
    let from = SpindleState { direction: SpindleDirection::Clockwise, speed: 6000.0 };
    let to = SpindleState { speed: 9000.0, ..from };
    let stop = Stop { after: 2, cause: StopCause::Spindle { from, to, code: None }, line: LineNumber(6) };
    assert!(toolpath.stops.contains(&stop), "{:?}", toolpath.stops);
    let neutral = trace(&read(PROGRAM.as_bytes()), &Machine::default());
    assert_eq!(neutral.stops.len() + 1, toolpath.stops.len());
    assert_eq!(neutral.segments, toolpath.segments);
}

/// The times of the table are neutral where they are left out, and where they are given as neutral.
#[test]
fn neutral_times_leave_the_result_as_it_is() {
    let machine = Machine::default();
    let expected = breakdown_on(&machine);
    let s_word_less = PROGRAM.replace("S9000\n", "");
    let toolpath = trace(&read(s_word_less.as_bytes()), &machine);
    let rule = CornerPolicy::Isolated(machine.interpolator.contour_tolerance);
    assert_eq!(breakdown(&toolpath, &machine, &simulate::with_policy(&toolpath, &machine, rule)), expected);
    for m_code in [0.0, 1.7] {
        let mut plain = Machine::default();
        plain.times.m_code = m_code;
        let mut given = plain.clone();
        given.times.coolant_on = Some(m_code);
        given.times.coolant_off = Some(m_code);
        given.times.program_stop = Some(m_code);
        given.times.pallet_change = Some(m_code);
        given.times.clamp = Some(m_code);
        given.times.takes_optional_stop = true;
        given.times.first_tool_change = Some(given.times.tool_change);
        given.times.spindle.exponent = Some(3.0);
        given.times.spindle_awaited_by = vec![8, 30];
        given.times.dwell_excess = 0.0;
        given.times.spindle_change = 0.0;
        given.times.spindle_at_feed = 0.0;
        given.times.spindle_ramp_at_feed = 0.0;
        assert_eq!(breakdown_on(&given), breakdown_on(&plain));
    }
    let rows = PARAMETERS.iter().filter(|row| row.key.starts_with("times."));
    assert_eq!(rows.count(), 24, "a new time belongs into these laws");
}

/// A random path with random stops and operations.
fn with_parts(case: &mut Case, random: &mut crate::laws::paths::Random) {
    let count = case.toolpath.segments.len();
    let line = |after: usize| LineNumber(after as u32 + 1);
    for after in 0..=count {
        if !random.chance(0.2) {
            continue;
        }
        let spin = |direction, speed| SpindleState { direction, speed };
        let cause = match (random.between(0.0, 5.0) as u32, random.between(0.0, 80.0) as u32) {
            (0, tool) => StopCause::ToolChange { tool: Some(tool % 4) },
            (1, speed) => StopCause::Spindle {
                from: spin(SpindleDirection::Counterclockwise, 100.0 * f64::from(speed)),
                to: spin(SpindleDirection::Clockwise, 70.0 * f64::from(speed)),
                code: Some(3),
            },
            (2, _) => StopCause::Dwell { seconds: random.between(0.0, 3.0) },
            (_, code) => StopCause::MCode { code },
        };
        case.toolpath.stops.push(Stop { after, cause, line: line(after) });
    }
    case.toolpath.stops.sort_by_key(|stop| stop.after);
    let stops = case.toolpath.stops.len();
    let mut cuts = vec![(0, 0)];
    for segment in 0..=count {
        for stop in 0..=stops {
            let before = case.toolpath.stops[..stop].iter().all(|stop| stop.after <= segment);
            let after = case.toolpath.stops[stop..].iter().all(|stop| segment <= stop.after);
            if before && after && random.chance(0.1) {
                cuts.push((segment, stop));
            }
        }
    }
    case.toolpath.operations = (cuts.into_iter())
        .map(|(first_segment, first_stop)| Operation {
            first_segment,
            first_stop,
            tool: random.chance(0.8).then(|| random.between(0.0, 4.0) as u32),
            ..Operation::default()
        })
        .collect();
    let times = &mut case.machine.times;
    times.m_code = random.between(0.0, 1.0);
    times.spindle.start = Some(random.between(0.0, 2.0));
    times.spindle.ramp = random.between(0.0, 1e-3);
    times.coolant_on = Some(random.between(0.0, 4.0));
    times.program_stop = Some(random.between(0.0, 90.0));
    times.pallet_change = Some(random.between(0.0, 30.0));
    times.clamp = Some(random.between(0.0, 2.0));
}

#[track_caller]
fn assert_adds_up(
    shares: impl Iterator<Item = TimeShare>,
    quote: &Quote,
    toolpath: &Toolpath,
    programmed: f64,
) {
    let mut sum = TimeShare::default();
    shares.for_each(|share| sum += share);
    let close = |found: f64, expected: f64| (found - expected).abs() <= 1e-9 * (1.0 + expected.abs());
    for (found, expected) in parts(&sum.breakdown).into_iter().zip(parts(&quote.breakdown)) {
        assert!(close(found, expected), "{found} s, the whole has {expected} s");
    }
    let length: f64 = toolpath.segments.iter().map(|segment| segment.length).sum();
    assert!(close(sum.time(), quote.cycle_time) && close(sum.feed_length + sum.rapid_length, length));
    assert!(close(sum.programmed, programmed) && close(sum.lost(), quote.cycle_time - programmed));
    assert_eq!(sum.moves, toolpath.segments.len());
}

#[test]
fn operations_and_tools_add_up_to_the_whole() {
    let mut several = 0;
    for (mut case, mut random) in cases(5, case_count()) {
        if case.number % 4 != 0 {
            with_parts(&mut case, &mut random);
        }
        let Case { toolpath, machine, .. } = &case;
        let tolerance = case.tolerance();
        let (plan, errors) = simulate::within(toolpath, machine, tolerance, &mut |_| {});
        let quote = quote(toolpath, machine, &plan, tolerance, &errors);
        let programmed = programmed_time(toolpath, machine);
        assert_eq!(quote.operations.len(), toolpath.operations.len().max(1));
        assert_adds_up(quote.operations.iter().map(|found| found.share), &quote, toolpath, programmed);
        assert_adds_up(quote.tools.iter().map(|found| found.share), &quote, toolpath, programmed);
        assert_eq!(quote.tools.iter().map(|tool| tool.operations).sum::<usize>(), quote.operations.len());
        let mut tools: Vec<_> = quote.tools.iter().map(|tool| tool.tool).collect();
        tools.sort();
        tools.dedup();
        assert_eq!(tools.len(), quote.tools.len(), "each tool once");
        several += usize::from(5 < quote.operations.len());
    }
    assert!(case_count() / 10 < several);
}
