//! Laws of jumps, loops and calls.

use crate::machine::Machine;
use crate::simulation::gcode::{Dialect, Options, Severity, read, read_with};
use crate::simulation::interpreter::trace;
use crate::simulation::toolpath::Toolpath;

fn run(text: &str) -> Toolpath {
    trace(&read(text.as_bytes()), &Machine::default())
}

/// The X positions that a program goes to.
fn ends(text: &str) -> Vec<f64> {
    let toolpath = run(text);
    let errors: Vec<_> = toolpath.diagnostics.iter().filter(|d| d.severity == Severity::Error).collect();
    assert!(errors.is_empty(), "{text}: {errors:?}");
    toolpath.segments.iter().map(|segment| segment.end.x).collect()
}

/// The message of the only error of a program.
#[track_caller]
fn error(text: &str) -> (u32, String) {
    let found: Vec<_> = run(text).diagnostics.into_iter().filter(|d| d.severity == Severity::Error).collect();
    assert_eq!(found.len(), 1, "{text}: {found:?}");
    (found[0].line.0, found[0].message.clone())
}

#[test]
fn macro_b_loops_and_jumps() {
    assert_eq!(ends("G0 #1=0\nWHILE[#1LT3]DO1\n#1=#1+1\nX#1\nEND1\nX9"), [1.0, 2.0, 3.0, 9.0]);
    assert_eq!(ends("G0 #1=5\nWHILE[#1LT3]DO1\nX1\nEND1\nX9"), [9.0]);
    assert_eq!(ends("G0 #1=0\nN1 #1=#1+1\nX#1\nIF[#1LT3]GOTO1\nX9"), [1.0, 2.0, 3.0, 9.0]);
    assert_eq!(ends("G0\nGOTO 20\nX1\nN20 X2"), [2.0]);
    assert_eq!(ends("G0 #1=30\nGOTO #1\nN20 X2\nN30 X3"), [3.0]);
    assert_eq!(ends("G0 #1=1\nIF[#1EQ1]THEN#2=5\nIF[#1EQ2]THEN#2=6\nX#2"), [5.0]);
    assert_eq!(ends("G0 #1=0\nIF[#1EQ1]THEN\nX7"), [7.0], "nothing is skipped where nothing follows THEN");
    assert_eq!(ends("G0 #1=0\nDO1\n#1=#1+1\nX#1\nIF[#1GE2]GOTO9\nEND1\nN9 X9"), [1.0, 2.0, 9.0]);
    let nested = "G0 #1=0\nWHILE[#1LT2]DO1\n#1=#1+1\n#2=0\nWHILE[#2LT2]DO2\n#2=#2+1\nX[10*#1+#2]\nEND2\nEND1";
    assert_eq!(ends(nested), [11.0, 12.0, 21.0, 22.0]);
}

#[test]
fn programs_call_programs() {
    let file = "%\nO1\nG0 X1\nM98 P100 L2\nX9\nM30\nO100\nG91 X1\nG90\nM99\n%";
    assert_eq!(ends(file), [1.0, 2.0, 3.0, 9.0]);
    assert_eq!(ends("%\nO1\nG0 X1\nM98 P7 L2\nX9\nM30\n%\nO7\nG91 X1\nG90\nM99\n%"), [1.0, 2.0, 3.0, 9.0]);
    assert_eq!(ends("%\nO1\nM98 P20100\nM30\nO100\nG91 G0 X1\nM99\n%"), [1.0, 2.0]);
    assert_eq!(
        ends("%\nO1\nG65 P7 A2. B3. X4.\nX#1 G0 X9\nM30\nO7\nG0 X#1\nX#2\nX#24\nM99\n%"),
        [2.0, 3.0, 4.0, 9.0]
    );
    assert_eq!(ends("%\nO1\nM97 P50\nG0 X9\nM30\nN50 G0 X5\nM99\n%"), [5.0, 9.0]);
    assert_eq!(ends("%\nO1\nM98 P2\nX8\nN5 X9\nM30\nO2\nG0 X1\nM99 P5\n%"), [1.0, 9.0]);
    assert_eq!(ends("%\nO1\nG0 X1\nO2\nX2\nM99\n%"), [1.0], "the text of the next program is not run");
    assert_eq!(
        ends("%\nO1\n#1=5\nG65 P7 L0 A2.\nG0 X#1\nM30\nO7\nX9\nM99\n%"),
        [5.0],
        "a macro that is run no time leaves nothing behind"
    );
    let same_number = "%\nO1\nN5 G0 X1\nM98 P2\nM30\nO2\n#1=0\nN5 X[2+#1]\n#1=#1+1\nIF[#1LT2]GOTO5\nM99\n%";
    assert_eq!(ends(same_number), [1.0, 2.0, 3.0], "N5 of the own program");
}

#[test]
fn o_words_branch_loop_and_call() {
    let branch = |a: u32| {
        ends(&format!(
            "#<a>={a}\nG0\no1 if [#<a> EQ 1]\nX1\no1 elseif [#<a> EQ 2]\nX2\no1 else\nX3\no1 endif\nX9"
        ))
    };
    assert_eq!([branch(1), branch(2), branch(3)], [[1.0, 9.0], [2.0, 9.0], [3.0, 9.0]]);
    assert_eq!(ends("#1=0\nG0\no1 while [#1 LT 3]\n#1=[#1+1]\nX#1\no1 endwhile"), [1.0, 2.0, 3.0]);
    assert_eq!(ends("#1=0\nG0\no1 do\n#1=[#1+1]\nX#1\no1 while [#1 LT 3]\nX9"), [1.0, 2.0, 3.0, 9.0]);
    assert_eq!(ends("G0 G91\no1 repeat [3]\nX1\no1 endrepeat"), [1.0, 2.0, 3.0]);
    assert_eq!(ends("G0\no1 repeat [0]\nX1\no1 endrepeat\nX2"), [2.0]);
    let leave = "#1=0\nG0\no1 while [1]\n#1=[#1+1]\no2 if [#1 EQ 2]\no1 continue\no2 endif\nX#1\no3 if [#1 GE 4]\no1 break\no3 endif\no1 endwhile\nX9";
    assert_eq!(ends(leave), [1.0, 3.0, 4.0, 9.0]);
    let call = "o<to> sub\n#<x>=[#1+#<_y>]\nG0 X#<x>\no<to> endsub [#<x>+1]\n#<x>=50 #<_y>=1\no<to> call [2]\nX#<x>\nX#<_value>";
    assert_eq!(ends(call), [3.0, 50.0, 4.0]);
    let recursion = "o9 sub\no1 if [#1 GT 0]\no9 call [#1-1]\no1 endif\nG0 X#1\no9 endsub\no9 call [3]";
    assert_eq!(ends(recursion), [1.0, 2.0, 3.0]);
    assert_eq!(ends("o9 sub\nG0 X1\no9 return\nX2\no9 endsub\no9 call\nX9"), [1.0, 9.0]);
}

/// Loops within loops, each run as often as it says.
#[test]
fn counted_loops_nest() {
    let program = "G0 G91\no1 repeat [3]\no2 repeat [4]\nX1\no2 endrepeat\no1 endrepeat";
    assert_eq!(ends(program).len(), 12);
}

#[test]
fn what_leads_nowhere_is_said() {
    let cases = [
        ("GOTO 7", 1, "block N7 is not in this file"),
        ("%\nM98 P1234\n%", 2, "1234 is not in this file"),
        ("%\nG65 A1\n%", 2, "need a P"),
        ("o5 call", 1, "label 5 is not in this file"),
        ("o<missing> call [1]", 1, "`missing` is not in this file"),
        ("M198 P3", 1, "M198"),
        ("G66 P3", 1, "G66"),
        ("%\nG0 X1\n#3000=1(NO)\nX2\n%", 3, "alarm"),
        (
            "G0\no1 repeat [1000000000]\nX1\no1 endrepeat",
            2,
            "1000000000 repetitions cannot be run, 1000000 at most",
        ),
        ("%\nM98 P1 L2000000\nM30\nO1\nG0 X1\nM99\n%", 2, "2000000 repetitions cannot be run"),
        ("WHILE [1] DO 1\nG0 X1", 1, "has no end"),
        ("o1 if [1]\nG0 X1", 1, "has no end"),
        ("END 1", 1, "without its beginning"),
    ];
    for (text, line, part) in cases {
        let found = error(text);
        assert!(found.0 == line && found.1.contains(part), "{text}: {found:?}");
    }
}

/// The times that a line says a move is repeated, and the remark on them.
#[test]
fn repeats_that_are_no_whole_number_are_told() {
    for (dialect, text, count, remark) in [
        (Dialect::LinuxCnc, "G91 G0\no1 repeat [2.4]\nX1\no1 endrepeat\nM2", 2, Some((2, "2.4"))),
        (Dialect::LinuxCnc, "G91 G0\no1 repeat [0.3 * 10]\nX1\no1 endrepeat\nM2", 3, None),
        (Dialect::LinuxCnc, "G91 G0\no1 repeat [-2.5]\nX1\no1 endrepeat\nM2", 0, None),
        (Dialect::Iso, "%\nO1\nM98 P7 L2.6\nM30\nO7\nG91 G0 X1\nM99\n%", 3, Some((3, "2.6"))),
        (Dialect::Iso, "%\nO1\nG65 P7 L1.5 A2.\nM30\nO7\nG91 G0 X#1\nM99\n%", 2, Some((3, "1.5"))),
        (Dialect::Iso, "G91 G0 Z1\nG98 G81 X1 Z-1 R0 F100 L2.5\nG80\nM30", 4, Some((2, "2.5"))),
        (Dialect::Siemens, "G91 G0\nA1: X1\nREPEAT A1 P=0.5+1\nM30", 3, Some((3, "1.5"))),
        (
            Dialect::Klartext,
            "0 BEGIN PGM A MM\n1 LBL 1\n2 L IX+1 FMAX\n3 CALL LBL 1 REP 2.5\n4 END PGM A MM\n",
            4,
            Some((4, "2.5")),
        ),
    ] {
        let options = Options { dialect: Some(dialect), ..Options::default() };
        let toolpath = trace(&read_with(text.as_bytes(), &options), &Machine::default());
        let said: Vec<_> = toolpath.diagnostics.iter().filter(|d| Severity::Info < d.severity).collect();
        assert_eq!(toolpath.segments.len(), count, "{text}: {said:?}");
        assert_eq!(said.len(), usize::from(remark.is_some()), "{text}: {said:?}");
        for (said, (line, value)) in said.iter().zip(remark) {
            assert!(said.line.0 == line && said.message.contains(value), "{text}: {said:?}");
        }
    }
}

/// Endless work ends, and says so.
#[test]
fn nothing_runs_for_ever() {
    for text in [
        "N1 GOTO 1",
        "WHILE [1] DO 1\nEND 1",
        "%\nO1\nM98 P1\n%",
        "o1 sub\no1 call\no1 endsub\no1 call",
        "%\nO1\nN1 M97 P1\n%",
        "o1 while [1]\no1 endwhile",
    ] {
        let found = run(text).diagnostics;
        assert!(
            found.iter().any(|d| d.message.contains("for ever") || d.message.contains("deeper")),
            "{text}: {found:?}"
        );
    }
    let tenfold: String = (1..=10).map(|n| format!("o{n} repeat [10]\n")).collect();
    let ends: String = (1..=10).rev().map(|n| format!("o{n} endrepeat\n")).collect();
    let found = run(&format!("{tenfold}M3\n{ends}")).diagnostics;
    assert!(found.iter().any(|d| d.message.contains("for ever")), "{found:?}");
}

/// The moves of a program, and its errors.
fn moves_and_errors(dialect: Dialect, text: &str) -> (usize, Vec<(u32, String)>) {
    let options = Options { dialect: Some(dialect), ..Options::default() };
    let toolpath = trace(&read_with(text.as_bytes(), &options), &Machine::default());
    let errors = toolpath.diagnostics.into_iter().filter(|found| found.severity == Severity::Error);
    (toolpath.segments.len(), errors.map(|found| (found.line.0, found.message)).collect())
}

#[test]
fn a_loop_that_changes_nothing_it_goes_by_ends_after_a_few_turns() {
    for (dialect, text, line) in [
        (Dialect::Iso, "N10 G91 G1 X1 F1000\nX-1\nGOTO 10\nM30", 3),
        (Dialect::Iso, "G91 G1 F1000\nWHILE[#1 LT 5]DO1\nX1\nX-1\nEND1\nM30", 5),
        (
            Dialect::Iso,
            "G91 G1 F1000\nWHILE[1 EQ 1]DO1\n#2=0\nWHILE[#2 LT 3]DO2\n#2=#2+1\nX1\nEND2\nX-3\nEND1\nM30",
            9,
        ),
        (Dialect::Iso, "%\nO1\nM98 P2\nM30\nO2\nN5 G91 G1 X1 F1000\nX-1\nGOTO 5\nM99\n%", 8),
        (Dialect::LinuxCnc, "G91 G1 F1000\no1 while [1]\nX1\nX-1\no1 endwhile\nM2", 5),
        (
            Dialect::LinuxCnc,
            "G91 G1 F1000\no1 do\no2 repeat [3]\nX1\no2 endrepeat\nX-3\no1 while [#1 EQ 0]\nM2",
            7,
        ),
        (Dialect::Siemens, "G91 G1 F1000\nLOOP\nX1\nX-1\nENDLOOP\nM30", 5),
        (
            Dialect::Klartext,
            "0 BEGIN PGM A MM\n1 LBL 1\n2 L IX+1 R0 F1000\n3 FN 9: IF +Q1 EQU +Q1 GOTO LBL 1\n4 END PGM A MM\n",
            4,
        ),
    ] {
        let (moves, errors) = moves_and_errors(dialect, text);
        assert!((1..=12).contains(&moves), "{dialect:?}: {moves} moves of {text}");
        assert!(
            errors.len() == 1
                && errors[0].0 == line
                && errors[0].1.starts_with("this jump back repeats for ever"),
            "{text}: {errors:?}"
        );
    }
}

/// A macro as it stands in a library, called by nobody.
#[test]
fn a_macro_without_its_arguments_ends_after_a_thousand_turns() {
    let macro_text = "%\nO9100\n#10=0\nWHILE[#10 LE #20]DO1\n#10=#10-1\n#11=0\nWHILE[#11 LE #21]DO2\n#11=#11-1\n#12=0\nWHILE[#12 LE #22]DO3\n#12=#12-1\nG91 G1 X1 F500\nX-1\nEND3\nEND2\nEND1\nM99\n%";
    let (moves, errors) = moves_and_errors(Dialect::Iso, macro_text);
    assert!(moves <= 2 * 1_001, "{moves}");
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert!(errors[0].0 == 14 && errors[0].1.contains("#22"), "{errors:?}");
    // Called with its arguments it ends by itself; a flag that the operator sets is none of the call.
    let called =
        "%\nO1\nG65 P2 I5.\nM30\nO2\n#10=0\nWHILE[#10 LT #4]DO1\n#10=#10+1\nG91 G1 X1 F500\nEND1\nM99\n%";
    assert_eq!(moves_and_errors(Dialect::Iso, called), (5, Vec::new()));
    let flag = "G91 G1 F500\n#1=0\nWHILE[[#1 LT 1500] AND [#500 NE 1]]DO1\n#1=#1+1\nX1\nEND1\nM30";
    assert_eq!(moves_and_errors(Dialect::Iso, flag), (1500, Vec::new()));
}

#[test]
fn loops_that_end_are_run_to_their_end() {
    for (text, count) in [
        ("G91 G1 F500\n#1=0\nN1 X1\nIF[#5001 LT 20]GOTO1\nM30", 20),
        ("G91 G1 F500\n#1=0\nN1 X1\n#1=#1+0.5\nIF[#1 LT 10]GOTO1\nM30", 20),
    ] {
        assert_eq!(moves_and_errors(Dialect::Iso, text), (count, Vec::new()), "{text}");
    }
}

#[test]
fn a_remark_of_a_loop_is_listed_once_with_its_number() {
    let text = "G21 F100\no1 repeat [500]\nG1 X1 Y[1/0]\no1 endrepeat\nM2";
    let (_, errors) = moves_and_errors(Dialect::LinuxCnc, text);
    assert!(errors.len() == 1 && errors[0].0 == 3 && errors[0].1.ends_with(" (500 times)"), "{errors:?}");
}
