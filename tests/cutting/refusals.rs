//! What cannot be computed is said, rapids through material are found, limits are watched.

use truefeed::cutting::{
    CuttingError, LimitKind, LoadLimits, Mill, Setup, engagement, loads, programmed_feedrates,
};

use crate::cutting::{mill, setup, toolpath};

const PROGRAM: &str = "G21 G90 G0 X-10 Y5 Z-3\nG1 X30 F1200";

fn base() -> Setup {
    setup([0.0, 0.0, -5.0], [20.0, 10.0, 0.0], mill(6.0), 0.2)
}

/// What is said of a program.
fn refusal(program: &str, setup: &Setup) -> Option<CuttingError> {
    let toolpath = toolpath(program);
    let found = match engagement(&toolpath, setup) {
        Ok(found) => found,
        Err(error) => return Some(error),
    };
    let feedrates = programmed_feedrates(&found, &toolpath);
    loads(&found, &toolpath, setup, &[&feedrates]).err()
}

#[test]
fn what_is_missing_is_named() {
    assert_eq!(refusal(PROGRAM, &base()), None);
    assert_eq!(refusal(PROGRAM, &Setup { stock: None, ..base() }), Some(CuttingError::NoStock));
    assert_eq!(refusal(PROGRAM, &Setup { coefficients: None, ..base() }), Some(CuttingError::NoMaterial));
    assert_eq!(
        refusal(PROGRAM, &Setup { spindle_speed: None, ..base() }),
        Some(CuttingError::NoSpindleSpeed { line: 2 })
    );
    let with = |mill: Option<Mill>| refusal(PROGRAM, &Setup { tool: mill, ..base() });
    assert_eq!(with(None), Some(CuttingError::UnknownTool { tool: None, line: 2 }));
    let no_diameter = Mill { diameter: None, ..mill(1.0) };
    assert_eq!(with(Some(no_diameter)), Some(CuttingError::NoDiameter { tool: None, line: 2 }));
    let no_teeth = Mill { teeth: None, ..mill(1.0) };
    assert_eq!(with(Some(no_teeth)), Some(CuttingError::NoTeeth { tool: None, line: 2 }));
    let flat = setup([0.0; 3], [20.0, 0.0, 5.0], mill(6.0), 0.2);
    assert_eq!(refusal(PROGRAM, &flat), Some(CuttingError::EmptyStock { axis: 'Y' }));
    let fine = Setup { resolution: Some(1e-4), ..base() };
    assert!(matches!(refusal(PROGRAM, &fine), Some(CuttingError::TooFine { .. })));
    let turned = format!("{PROGRAM}\nA30");
    assert!(matches!(refusal(&turned, &base()), Some(CuttingError::Rotary { line: 3 })));
}

#[test]
fn a_tool_by_number_is_taken_and_an_unknown_one_is_named() {
    let program = format!("T7 M6\nS9000 M3\n{PROGRAM}");
    let none = Setup { tool: None, ..base() };
    assert_eq!(refusal(&program, &none), Some(CuttingError::UnknownTool { tool: Some(7), line: 4 }));
    let known = Setup { tools: [(7, mill(6.0))].into(), spindle_speed: None, ..none };
    assert_eq!(refusal(&program, &known), None);
}

#[test]
fn the_programs_speed_goes_before_the_set_ups() {
    let chip = |program: &str| {
        let toolpath = toolpath(program);
        let found = engagement(&toolpath, &base()).expect("all is given");
        let feedrates = programmed_feedrates(&found, &toolpath);
        let loads = loads(&found, &toolpath, &base(), &[&feedrates]).expect("all is given");
        loads[0].at[loads[0].at.len() / 2].chip
    };
    assert!((chip(PROGRAM) - 1200.0 / (2.0 * 8000.0)).abs() < 1e-9);
    assert!((chip(&format!("M3 S6000\n{PROGRAM}")) - 0.1).abs() < 1e-9);
    // An S word alone changes the speed of a running spindle.
    assert!((chip(&format!("M3 S6000\nS3000\n{PROGRAM}")) - 0.2).abs() < 1e-9);
}

#[test]
fn the_longest_way_is_run_where_the_stock_is_and_no_further() {
    // A line of ten thousand kilometres crosses the stock; a circle of that size is refused.
    let line = toolpath("G21 G90 G0 X-9999999 Y5 Z-3\nG1 X9999999 F1200");
    let found = engagement(&line, &base()).expect("all is given");
    assert!(!found.places.is_empty() && found.places.len() < 1000);
    let circle = "G21 G90 G0 X-10 Y5 Z-3\nG2 X-10 Y5 I9999999 J0 F1200";
    assert!(matches!(refusal(circle, &base()), Some(CuttingError::TooLong { line: 2, .. })));
}

#[test]
fn rapids_through_material_are_found() {
    let toolpath = toolpath("G21 G90 G0 X-10 Y5 Z5\nZ-3\nX10\nZ5\nX0\nZ1");
    let found = engagement(&toolpath, &base()).expect("all is given");
    assert_eq!(found.collisions.len(), 1);
    assert_eq!(found.collisions[0].line, 3);
    assert!(150.0 < found.collisions[0].removed && found.places.is_empty());
}

#[test]
fn what_is_beyond_a_limit_is_told_with_its_line() {
    let toolpath = toolpath("G21 G90 G0 X-10 Y5 Z-1\nG1 X30 F1200\nZ-4\nX-10");
    let found = engagement(&toolpath, &base()).expect("all is given");
    let feedrates = programmed_feedrates(&found, &toolpath);
    let told = |limits: LoadLimits| {
        let tool = Mill { limits, ..mill(6.0) };
        let setup = Setup { tool: Some(tool), ..base() };
        loads(&found, &toolpath, &setup, &[&feedrates]).expect("all is given").remove(0)
    };
    let free = told(LoadLimits::default());
    assert!(free.exceeded.is_empty() && free.force.line == 4);
    let limited = told(LoadLimits { force: 0.9 * free.force.value, ..LoadLimits::default() });
    assert_eq!(limited.exceeded.len(), 1);
    let exceeded = limited.exceeded[0];
    assert_eq!((exceeded.limit, exceeded.lines), (LimitKind::ToolForce, (4, 4)));
    assert_eq!(exceeded.peak, free.force);
    let power = told(LoadLimits { power: 0.0, ..LoadLimits::default() });
    assert_eq!(power.exceeded.iter().map(|beyond| beyond.lines).collect::<Vec<_>>(), [(2, 2), (4, 4)]);
}
