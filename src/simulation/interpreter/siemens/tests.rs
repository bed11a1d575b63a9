//! Laws of reading SINUMERIK programs.

use crate::machine::Machine;
use crate::simulation::gcode::{Dialect, Keyword, Options, Severity, address, read_with};
use crate::simulation::interpreter::trace;
use crate::simulation::toolpath::{Blending, Curve, Motion, Stop, StopCause, Toolpath};

fn run(text: &str) -> Toolpath {
    let options = Options { dialect: Some(Dialect::Siemens), ..Options::default() };
    trace(&read_with(text.as_bytes(), &options), &Machine::default())
}

/// The X positions that a program goes to.
#[track_caller]
fn ends(text: &str) -> Vec<f64> {
    let toolpath = run(text);
    let errors: Vec<_> = toolpath.diagnostics.iter().filter(|d| d.severity == Severity::Error).collect();
    assert!(errors.is_empty(), "{text}: {errors:?}");
    toolpath.segments.iter().map(|segment| segment.end.x).collect()
}

#[test]
fn values_are_worked_out() {
    assert_eq!(ends("R1=5 R2=R1*2\nG0 X=R1\nX=R2+1\nX=IC(R1)\nX=AC(1)"), [5.0, 11.0, 16.0, 1.0]);
    assert_eq!(ends("DEF REAL _A, B=2\n_A=B+1\nG0 X=_A\nX=SQRT(B*8)\nX=(1+2)*3"), [3.0, 4.0, 9.0]);
    assert_eq!(ends("_=4\n$=_+1\nG0 X=$"), [5.0]);
    assert_eq!(
        ends("G0 X=MINVAL(3,5)\nX=MAXVAL(3,5)\nX=BOUND(0,4,9)\nX=BOUND(1,4,-9)"),
        [3.0, 5.0, 4.0, 1.0]
    );
    assert_eq!(ends("G0 X=ROUND(2.1)\nX=ROUNDUP(2.1)\nX=ROUNDUP(-3.1)"), [2.0, 3.0, -4.0]);
    assert_eq!(ends("R1=2\nR[R1+1]=7\nG0 X=R3\nX=R[3]-1"), [7.0, 6.0]);
    assert_eq!(ends("G0 X1EX1\nX=7 DIV 2\nY=7 MOD 4\nX=-POT(3)+TRUNC(2.7)"), [10.0, 3.0, 3.0, -7.0]);
    assert_eq!(
        ends(
            "G0 X5 ; X6
N10 X7"
        ),
        [5.0, 7.0]
    );
}

/// The length and the feedrate, mm/min, of the last feed move.
fn last_feed(text: &str) -> (f64, f64) {
    let toolpath = run(text);
    let last = toolpath.segments.last().expect("a move");
    match last.motion {
        Motion::Feed { feedrate } => (last.length, (60.0 * feedrate * 1e6).round() / 1e6),
        Motion::Rapid { .. } => panic!("{text}: a rapid move"),
    }
}

/// Only G700 and G710 give the unit of feeds too.
#[test]
fn g70_leaves_feeds_in_millimetres() {
    assert_eq!(last_feed("G70 G90 G0 X0 Y0 Z0\nG1 X10 F500"), (254.0, 500.0));
    assert_eq!(last_feed("G700 G90 G0 X0 Y0 Z0\nG1 X10 F20"), (254.0, 508.0));
    assert_eq!(last_feed("G700\nG71\nG1 X10 F500"), (10.0, 500.0));
    assert_eq!(last_feed("G70\nG710\nG1 X10 F500"), (10.0, 500.0));
    assert_eq!(last_feed("G70 S1000 M3\nG95 G1 X10 F0.5"), (254.0, 500.0));
    assert_eq!(last_feed("G70\nG1 X10 F500 FB=300"), (254.0, 300.0));
    assert_eq!(last_feed("G70 S1000 M3\nG33 Z10 K0.1"), (254.0, 2540.0), "a pitch is a length");
}

#[test]
fn flow_is_followed() {
    assert_eq!(ends("G0\nFOR R1=1 TO 3\nX=R1\nENDFOR\nX9"), [1.0, 2.0, 3.0, 9.0]);
    assert_eq!(ends("G0 R1=0\nWHILE R1<2\nR1=R1+1\nX=R1\nENDWHILE"), [1.0, 2.0]);
    assert_eq!(ends("G0 R1=0\nREPEAT\nR1=R1+1\nX=R1\nUNTIL R1>=2\nX9"), [1.0, 2.0, 9.0]);
    assert_eq!(ends("G0 R1=0\nLOOP\nR1=R1+1\nX=R1\nIF R1==2 GOTOF OUT\nENDLOOP\nOUT: X9"), [1.0, 2.0, 9.0]);
    let branch = |a: u32| ends(&format!("G0 R1={a}\nIF R1==1\nX1\nELSE\nX2\nENDIF\nX9"));
    assert_eq!([branch(1), branch(5)], [[1.0, 9.0], [2.0, 9.0]]);
    assert_eq!(ends("G0 R1=0\nUP: R1=R1+1\nX=R1\nIF (R1<3) AND (R1>0) GOTOB UP\nX9"), [1.0, 2.0, 3.0, 9.0]);
    assert_eq!(ends("G0 G91\nA:\nX1\nREPEAT A P=2"), [1.0, 2.0, 3.0]);
    assert_eq!(ends("G0 G91\nA: X1\nX5\nB: X2\nREPEATB A P=2"), [1.0, 6.0, 8.0, 9.0, 10.0]);
    assert_eq!(ends("G0 G91\nA: X1\nB: X5\nREPEAT A B"), [1.0, 6.0, 7.0, 12.0]);
    // The labels may stand further down, and ENDLABEL ends a section that begins with one label.
    let below = "\nM30\nA: X1\nX2\nB: X4\nX8\nENDLABEL:\nX16";
    assert_eq!(ends(&format!("G0 G91\nREPEAT A B P=2{below}")), [1.0, 3.0, 7.0, 8.0, 10.0, 14.0]);
    assert_eq!(ends(&format!("G0 G91\nREPEATB B P=2{below}")), [4.0, 8.0]);
    assert_eq!(ends(&format!("G0 G91\nREPEAT B{below}")), [4.0, 12.0]);
    assert_eq!(ends(&format!("G0 G91\nCALL BLOCK A TO B{below}")), [1.0, 3.0, 7.0]);
    assert_eq!(ends("G0 G91\nA: X1\nENDLABEL: X2\nX4\nREPEAT A"), [1.0, 3.0, 7.0, 8.0, 10.0]);
    for text in ["REPEAT A\nM30\nA: X1", "REPEAT A B\nA: X1", "REPEATB A", "B: X1\nREPEAT A B"] {
        assert!(!run(&format!("G0 G91\n{text}")).diagnostics.is_empty(), "{text}");
    }
    assert_eq!(ends("G0\nGOTOF N30\nN20 X1\nN30 X3"), [3.0]);
}

/// Known texts are compared; a remark names the first line with an unknown one.
#[test]
fn texts_decide() {
    let program = |first: &str, condition: &str| {
        format!("DEF STRING[9] A{first}, B\nG0\nIF {condition}\nX1\nELSE\nX2\nENDIF\nX3")
    };
    for (first, condition, branch) in [
        ("=\"ROUGH\"", "A==\"ROUGH\"", 1.0),
        ("=\"ROUGH\"", "A==\"FINISH\"", 2.0),
        ("=\"ROUGH\"", "(A<>\"FINISH\") AND (B==\"\")", 1.0),
        ("", "A==B", 1.0),
    ] {
        assert_eq!(ends(&program(first, condition)), [branch, 3.0], "{first} {condition}");
    }
    assert_eq!(ends("DEF STRING[9] KIND\nG0\nKIND=\"UP\"\nIF KIND==\"UP\" GOTOF GO\nX1\nGO: X2"), [2.0]);
    let called = "G0\nBORE(\"DEEP\",5)\nBORE(,7)\nM30\n%_N_BORE_SPF\nPROC BORE(STRING[9] KIND=\"FLAT\", REAL D)\n\
        IF KIND==\"DEEP\"\nX=D\nELSE\nX=-D\nENDIF\nM17";
    assert_eq!(ends(called), [5.0, -7.0]);
    let unknown = run(&program("", "C==\"ROUGH\""));
    let told: Vec<u32> = unknown.diagnostics.iter().map(|told| told.line.0).collect();
    assert_eq!(told, [3], "{:?}", unknown.diagnostics);
    assert!(run(&program("", "A<\"ROUGH\"")).diagnostics[0].message.contains("found `<`"));
}

#[test]
fn subprograms_are_run() {
    let file = "%_N_MAIN_MPF\n;$PATH=/_N_WKS_DIR\nG0 X1\nL100 P2\nHOLE(5, 2)\nX9\nM30\n%_N_L100_SPF\nG91 X1\nG90\nM17\n%_N_HOLE_SPF\nPROC HOLE(REAL A, INT B)\nX=A*B\nRET\n";
    assert_eq!(ends(file), [1.0, 2.0, 3.0, 10.0, 9.0]);
    let missing = run("G0 X1\nBORE(1)\nX2").diagnostics;
    assert!(missing[0].message.contains("`bore` is not in this file"), "{missing:?}");
}

#[test]
fn subprograms_keep_to_themselves() {
    let file = "%_N_MAIN_MPF\nDEF INT I\nDEF REAL A[3]=SET(4,5,6)\nG0\nFOR I=0 TO 1\nX=A[I]\nPART(,7)\nPART(2)\nENDFOR\nM30\n%_N_PART_SPF\nPROC PART(REAL X1=1,REAL Y1=3)\nDEF INT I=9\nX=X1 Y=Y1\nI=50\nRET\n";
    let ends: Vec<_> = clean(file).segments.iter().map(|s| (s.end.x, s.end.y)).collect();
    assert_eq!(ends, [(4.0, 0.0), (1.0, 7.0), (2.0, 3.0), (5.0, 3.0), (1.0, 7.0), (2.0, 3.0)]);
    for call in ["MCALL PART(1)", "MCALL L10"] {
        let found = run(&format!("G0 X1\n{call}\nX2\nMCALL")).diagnostics;
        assert!(found.iter().any(|d| d.message.contains("after every move")), "{call}: {found:?}");
    }
}

#[test]
fn branches_by_value_and_words_without_blanks() {
    let branch = |value: i32| {
        ends(&format!("G0 R1={value}\nCASE R1 OF -1 GOTOF A 2 GOTOF B DEFAULT GOTOF C\nA: X1\nB:\nX2\nC:X3"))
    };
    assert_eq!([branch(-1), branch(2), branch(7)], [vec![1.0, 2.0, 3.0], vec![2.0, 3.0], vec![3.0]]);
    assert_eq!(ends("N10G0X1Y2\nN20G1X=3F100\nN30X4.5Z-1M8"), [1.0, 3.0, 4.5]);
}

#[test]
fn statements_keep_their_arguments() {
    let options = Options { dialect: Some(Dialect::Siemens), ..Options::default() };
    let program = read_with(
        b"MCALL CYCLE81(10, , 2, -5) ; drill\nSUPA G0 Z=5 D0\nT=\"MILL 10\"\nMSG(\"HELLO\")",
        &options,
    );
    let statements: Vec<(u32, &str, Vec<u8>)> = (program.statements.iter())
        .map(|statement| {
            let Keyword::Siemens(keyword) = statement.keyword else { panic!("a SINUMERIK program") };
            let arguments = program.arguments(std::slice::from_ref(statement));
            (statement.block, keyword.name, arguments.iter().map(|argument| argument.position).collect())
        })
        .collect();
    let expected =
        [(0, "MCALL", vec![]), (0, "CYCLE81", vec![0, 2, 3]), (1, "SUPA", vec![]), (3, "MSG", vec![0])];
    assert_eq!(statements, expected);
    let addresses: Vec<u8> = program.words.iter().map(|word| word.letter).collect();
    assert_eq!(addresses, [b'G', b'Z', b'D', address::TOOL_NAME]);
    assert_eq!(program.texts, ["MILL 10", "HELLO"]);
    assert_eq!(program.diagnostics, []);
}

/// The text of a message before a cycle is no argument of the cycle.
#[test]
fn each_statement_has_its_own_arguments() {
    let modes = run("MSG(\"FINISH\") CYCLE832(0.05)\nG1 X1 F500").path_modes;
    assert_eq!(modes.first().map(|mode| mode.blending), Some(Blending::Within(0.05)));
}

/// Any cut of a program is read without a panic, and says what is wrong by line.
#[test]
fn broken_lines_are_said() {
    let whole = "R1=5 IF R1>2 GOTOF A\nFOR R1=1 TO 5\nCYCLE81(1,(2+3),\"T\")\nDEF REAL A[3],B=2\nPROC P(REAL A)\nX=AC(1) CR=5\nREPEAT A P=2\nL100 P3";
    for end in 0..whole.len() {
        run(&whole[..end]);
        run(&whole[end..]);
    }
    for text in ["G0 X=", "IF", "FOR R1", "GOTOF", "X=AC(", "CYCLE81(1", "REPEAT Q P=2", "ENDIF", "G0 ?"] {
        let found = run(text).diagnostics;
        assert!(found.iter().any(|d| d.severity == Severity::Error), "{text}: {found:?}");
    }
}

/// Lengths of the feed and rapid moves, mm.
fn lengths(toolpath: &Toolpath) -> (f64, f64) {
    let sum = |rapid: bool| {
        let segments = toolpath.segments.iter().filter(|segment| (segment.motion.is_rapid()) == rapid);
        segments.map(|segment| segment.length).sum()
    };
    (sum(false), sum(true))
}

/// No error and no warning.
#[track_caller]
fn clean(text: &str) -> Toolpath {
    let toolpath = run(text);
    let found: Vec<_> = toolpath.diagnostics.iter().filter(|d| d.severity != Severity::Info).collect();
    assert!(found.is_empty(), "{text}: {found:?}");
    toolpath
}

#[test]
fn drilling_cycles_make_their_holes() {
    let holes = clean("G0 Z50\nG1 F600\nMCALL CYCLE81(50,0,2,-10)\nX10\nX20\nMCALL\nX30");
    let (feed, rapid) = lengths(&holes);
    assert!((feed - (2.0 * 12.0 + 30.0)).abs() < 1e-9, "{feed}: the moves between are feed moves too");
    assert!((rapid - (50.0 + 2.0 * (48.0 + 60.0))).abs() < 1e-9, "{rapid}");
    let dwells = clean("G0 Z50\nG1 F600\nCYCLE82(50,0,2,,10,1.5)").stops;
    assert!(matches!(dwells[..], [Stop { cause: StopCause::Dwell { seconds: 1.5 }, .. }]), "{dwells:?}");
    // Strokes to −4, −7, −9 and −10; to break chips the tool goes up by 1 mm three times, in feed.
    let pecks = lengths(&clean("G0 Z50\nG1 F600\nCYCLE83(50,0,2,-10,,-4,,1,0,0,1,0)"));
    assert!((pecks.0 - (12.0 + 3.0 * 2.0)).abs() < 1e-9, "{pecks:?}");
    let tap = clean("G0 Z50\nS600 M3\nG1 F100\nCYCLE84(50,0,2,-10,,0,3,,1.25)");
    let feedrates: Vec<f64> = tap
        .segments
        .iter()
        .filter_map(|s| match s.motion {
            Motion::Feed { feedrate } => Some(feedrate),
            Motion::Rapid { .. } => None,
        })
        .collect();
    assert_eq!(feedrates, [12.5, 12.5], "pitch 1.25 mm at 10 turns a second");
    let still = run("G0 Z50\nS0 M3\nG1 F600\nCYCLE84(50,0,2,-10,,0,3,,1.25)");
    let is_in_force = |motion: Motion| motion == Motion::Feed { feedrate: 10.0 };
    assert_eq!(still.segments.iter().filter(|s| is_in_force(s.motion)).count(), 2, "there and back");
    assert!(still.diagnostics.iter().any(|found| found.message.contains("feedrate in force")));
    let row = clean(
        "G0 Z50\nG1 F600\nMCALL CYCLE81(50,0,2,-10)\nHOLES1(0,0,90,10,5,3)\nHOLES2(0,0,20,0,90,4)\nMCALL",
    );
    assert!((lengths(&row).0 - 7.0 * 12.0).abs() < 1e-9);
    let circle: Vec<_> =
        row.segments.iter().filter(|s| !s.motion.is_rapid()).skip(3).map(|s| s.end).collect();
    assert!(circle.iter().all(|end| (end.x.hypot(end.y) - 20.0).abs() < 1e-9), "{circle:?}");
}

#[test]
fn frames_turn_and_shift() {
    let end = |text: &str| clean(text).segments.last().map_or([0.0; 3], |s| [s.end.x, s.end.y, s.end.z]);
    let near = |found: [f64; 3], expected: [f64; 3]| {
        assert!(
            found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9),
            "{found:?}, expected {expected:?}"
        );
    };
    near(end("TRANS X10 Y5\nG0 X1 Y0"), [11.0, 5.0, 0.0]);
    near(end("TRANS X10\nATRANS X5\nG0 X1"), [16.0, 0.0, 0.0]);
    near(end("TRANS X10\nROT RPL=90\nG0 X1 Y0"), [0.0, 1.0, 0.0]);
    near(end("TRANS X10\nAROT RPL=90\nG0 X1 Y0"), [10.0, 1.0, 0.0]);
    near(end("AROT Z90\nG0 X1 Y2"), [-2.0, 1.0, 0.0]);
    near(end("MIRROR X0\nG0 X1 Y2"), [-1.0, 2.0, 0.0]);
    near(end("SCALE X2 Y2\nG0 X1 Y2"), [2.0, 4.0, 0.0]);
    near(end("TRANS X10\nTRANS\nG0 X1"), [1.0, 0.0, 0.0]);
    near(end("$P_PFRAME=CTRANS(X,10,Y,2+3)\nG0 X1 Y0"), [11.0, 5.0, 0.0]);
    near(end("TRANS Y9\n$P_PFRAME=CTRANS(X,10):CROT(Z,90)\nG0 X1 Y0"), [10.0, 1.0, 0.0]);
    near(end("TRANS X10\n$P_PFRAME=$P_PFRAME:CSCALE(X,2):CMIRROR(X)\nG0 X1"), [8.0, 0.0, 0.0]);
    near(end("TRANS X10\n$P_PFRAME=CTRANS()\nG0 X1"), [1.0, 0.0, 0.0]);
    for text in
        ["$P_PFRAME=CTRANS(X", "$P_PFRAME=CFINE(X,1)", "$P_UIFR[1]=CTRANS(X,9)", "$P_IFRAME=$P_UIFR[1]"]
    {
        let found = run(&format!("{text}\nG0 X1"));
        assert_eq!(found.diagnostics.len(), 1, "{text}: {:?}", found.diagnostics);
        assert_eq!(found.segments.last().expect("a move").end.x, 1.0, "{text}");
    }
    near(end("G111 X10 Y0\nG0 RP=5 AP=90"), [10.0, 5.0, 0.0]);
    near(end("G0 X1\nG110 X0 Y0\nG1 F100 RP=5 AP=0"), [6.0, 0.0, 0.0]);
}

#[test]
fn arcs_have_their_forms() {
    let arc = |text: &str| match &clean(text).segments.last().expect("a move").curve {
        Curve::Arc(arc) => (arc.start_radius, arc.sweep.to_degrees()),
        Curve::Line => (0.0, 0.0),
    };
    let near = |(radius, sweep): (f64, f64), expected: (f64, f64)| {
        assert!(
            (radius - expected.0).abs() < 1e-6 && (sweep - expected.1).abs() < 1e-6,
            "{radius} {sweep} {expected:?}"
        );
    };
    near(arc("G1 F100\nG2 X10 Y10 CR=10"), (10.0, 90.0));
    near(arc("G1 F100\nG2 X10 Y10 CR=-10"), (10.0, 270.0));
    near(arc("G1 F100\nG3 X10 Y10 AR=90"), (10.0, 90.0));
    near(arc("G1 F100\nG2 X10 Y10 I=AC(10) J=AC(0)"), (10.0, 90.0));
    near(arc("G1 F100\nG3 X0 Y0 Z5 I10 J0 TURN=2"), (10.0, 1080.0));
    near(arc("G1 F100\nCIP X20 Y0 I1=10 J1=10"), (10.0, 180.0));
    near(arc("G1 F100 X10\nCT X20 Y10"), (10.0, 90.0));
}

#[test]
fn tolerances_are_those_of_the_program() {
    let modes = clean("G1 F100 X1\nCYCLE832(0.02,1,1)\nX2\nG60\nX3\nG642\nX4").path_modes;
    let found: Vec<_> = modes.iter().map(|mode| (mode.from, mode.blending)).collect();
    assert_eq!(found[..2], [(1, Blending::Within(0.02)), (2, Blending::ExactStop)], "{modes:?}");
}

#[test]
fn what_is_not_modelled_is_said() {
    for (text, part) in [
        ("TRAORI", "the motion of the head is not modelled"),
        ("CYCLE800(1,\"A\",0,57,0,0,0,30,0,0)", "swivelled plane"),
        ("POCKET3(10,0,1,-5,20,10,3,5,5,0,2)", "missing from the time"),
        ("BSPLINE X5", "straight lines"),
        ("COMPCAD", "compressor"),
        ("G331 Z-5", "pitch"),
        ("HOLES1(0,0,0,0,5,3)", "no cycle is in force"),
        ("CYCLE81(10,0,2,20)", "hole not made"),
    ] {
        let found = run(&format!("G1 F100\n{text}")).diagnostics;
        assert!(found.iter().any(|d| d.message.contains(part)), "{text}: {found:?}");
    }
    assert_eq!(clean("CYCLE800()\nG500\nSTOPRE FFWON SOFT DIAMOF\nG505 G0 X1\nG25 X1 Y2").segments.len(), 1);
}
