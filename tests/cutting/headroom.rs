//! Where the feedrate could be higher: by the first limit met, and proved by running it that high.

use truefeed::cutting::{
    Headroom, LimitKind, LoadCurve, LoadLimits, Mill, Setup, compliance, engagement, programmed_and_predicted,
};
use truefeed::machine::Machine;
use truefeed::simulation::feed::Tolerances;
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::simulate;

use crate::cutting::{mill, setup, toolpath};

/// A slot 2 mm deep, and after it, without stop, one 6 mm deep over the same stock.
const PROGRAM: &str = "G21 G90 T1 M6\nM3 S8000\n(SHALLOW)\nG0 X-10 Y10 Z5\nZ-2\nG1 X50 F600\nG0 Z5\n(DEEP)\nX-10 Y30\nZ-6\nG1 X50 F600\nG0 Z5";

fn with(limits: LoadLimits) -> Setup {
    let mill = Mill { limits, ..mill(8.0) };
    setup([0.0, 0.0, -10.0], [40.0, 40.0, 0.0], mill, 0.2)
}

/// The loads by the programmed feedrate.
fn programmed(program: &str, setup: &Setup) -> LoadCurve {
    let (machine, toolpath) = (Machine::default(), toolpath(program));
    let (plan, _) = simulate::within(&toolpath, &machine, Tolerances::Programmed, &mut |_| {});
    let curve = Profile::new(&toolpath, &plan).feed_curve(Resolution::CHART);
    let cut = engagement(&toolpath, setup).expect("all is given");
    let mut told = Vec::new();
    let both = programmed_and_predicted(&cut, &toolpath, setup, &curve, &mut |part| told.push(part));
    assert!(told.is_sorted() && told.iter().all(|part| (0.0..=1.0).contains(part)) && 10 < told.len());
    let [programmed, predicted] = both.expect("all is given");
    assert!(predicted.headroom.is_empty());
    programmed
}

/// What limits a program is exceeded nowhere with the feedrates it could have, and is with the next step.
fn holds(headroom: &Headroom, setup: &Setup, line: u32) {
    let faster = |factor: f64| {
        let feedrate = format!("F{}", 600.0 * factor);
        let lines: Vec<String> = PROGRAM
            .lines()
            .zip(1..)
            .map(|(text, at)| if at == line { text.replace("F600", &feedrate) } else { text.to_string() })
            .collect();
        let loads = programmed(&lines.join("\n"), setup);
        loads
            .exceeded
            .iter()
            .filter(|beyond| beyond.lines.0 == line)
            .map(|beyond| beyond.limit)
            .collect::<Vec<_>>()
    };
    assert_eq!(faster(headroom.factor), []);
    let next = [1.1, 1.2, 1.3, 1.5, 1.75, 2.0, 2.5, 3.0].into_iter().find(|step| headroom.factor < *step);
    assert_eq!(faster(next.expect("there is one")), headroom.limit.into_iter().collect::<Vec<_>>());
}

#[test]
fn the_shallow_slot_could_be_faster_up_to_the_limit() {
    let free = programmed(PROGRAM, &with(LoadLimits::default()));
    // Nothing limits: nothing is said.
    assert!(free.headroom.is_empty());
    let force = 0.55 * free.force.value;
    for (limits, limit) in [
        (LoadLimits { force, ..LoadLimits::default() }, LimitKind::ToolForce),
        (LoadLimits { torque: 0.55 * free.torque.value, ..LoadLimits::default() }, LimitKind::ToolTorque),
        (LoadLimits { power: 0.55 * free.power.value, ..LoadLimits::default() }, LimitKind::ToolPower),
    ] {
        let setup = with(limits);
        let loads = programmed(PROGRAM, &setup);
        let [headroom] = loads.headroom[..] else { panic!("{:?}", loads.headroom) };
        assert_eq!((headroom.lines, headroom.operation), ((6, 6), 0));
        assert_eq!(headroom.limit, Some(limit));
        holds(&headroom, &setup, 6);
        assert!((headroom.feedrate - 10.0).abs() < 1e-9 && (headroom.length - 44.0).abs() < 5.0);
        assert!(headroom.predicted <= (1.0 + 1e-9) * headroom.feedrate);
    }
}

#[test]
fn chips_limit_both_slots_alike() {
    // 600 mm/min of two teeth at 8000 rpm.
    let chip = 600.0 / 16000.0;
    let setup = with(LoadLimits { chip: 1.6 * chip, ..LoadLimits::default() });
    let loads = programmed(PROGRAM, &setup);
    assert_eq!(loads.headroom.len(), 2);
    for line in [6, 11] {
        let headroom =
            loads.headroom.iter().find(|headroom| headroom.lines == (line, line)).expect("it is told");
        assert_eq!((headroom.factor, headroom.limit), (1.5, Some(LimitKind::ToolChip)));
        holds(headroom, &setup, line);
    }
}

#[test]
fn run_out_leaves_less_room() {
    let even = with(LoadLimits { force: 215.0, ..LoadLimits::default() });
    let uneven = Mill { runout: 0.02, ..even.tool.expect("given") };
    let uneven = Setup { tool: Some(uneven), ..even.clone() };
    let factors = [even, uneven].map(|setup| {
        let loads = programmed(PROGRAM, &setup);
        loads
            .headroom
            .iter()
            .find(|headroom| headroom.lines == (6, 6))
            .map_or(1.0, |headroom| headroom.factor)
    });
    assert!(1.0 < factors[1] && factors[1] < factors[0], "{factors:?}");
}

#[test]
fn a_tool_bends_by_the_cube_of_its_length() {
    // 3 E I of a rod of 8 mm: 3 · 600000 · π 8⁴ / 64.
    let rod = 3.0 * 6e5 * std::f64::consts::PI * 8.0_f64.powi(4) / 64.0;
    assert!((compliance(10.0, 40.0, 6e5) / (64000.0 / rod) - 1.0).abs() < 1e-12);
    let bent = |overhang: f64| {
        let mut setup = with(LoadLimits { deflection: 0.05, ..LoadLimits::default() });
        let tool = setup.tool.as_mut().expect("given");
        tool.compliance = compliance(8.0, overhang, 6e5);
        programmed(PROGRAM, &setup)
    };
    let (short, long) = (bent(20.0), bent(60.0));
    let most = |loads: &LoadCurve| loads.at.iter().map(|load| load.deflection).fold(0.0, f64::max);
    assert!((most(&long) / most(&short) - 27.0).abs() < 1e-9);
    assert!(short.exceeded.is_empty());
    assert_eq!(long.exceeded.last().expect("it is bent").limit, LimitKind::ToolDeflection);
}
