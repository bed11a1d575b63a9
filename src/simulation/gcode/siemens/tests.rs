//! Laws of reading SINUMERIK programs.

use crate::machine::Machine;
use crate::simulation::gcode::{Dialect, Options, Severity, address, read_with};
use crate::simulation::toolpath::{Toolpath, trace};

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
    assert_eq!(ends("R1=2\nR[R1+1]=7\nG0 X=R3\nX=R[3]-1"), [7.0, 6.0]);
    assert_eq!(ends("G0 X1EX1\nX=7 DIV 2\nY=7 MOD 4\nX=-POT(3)+TRUNC(2.7)"), [10.0, 3.0, -7.0]);
    assert_eq!(ends("G0 X5 ; X6\nN10 X7 (X8)").len(), 0);
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
    assert_eq!(ends("G0 G91\nA: X1\nB: X5\nREPEAT A B"), [1.0, 6.0, 7.0]);
    assert_eq!(ends("G0\nGOTOF N30\nN20 X1\nN30 X3"), [3.0]);
}

#[test]
fn subprograms_are_run() {
    let file = "%_N_MAIN_MPF\n;$PATH=/_N_WKS_DIR\nG0 X1\nL100 P2\nHOLE(5, 2)\nX9\nM30\n%_N_L100_SPF\nG91 X1\nG90\nM17\n%_N_HOLE_SPF\nPROC HOLE(REAL A, INT B)\nX=A*B\nRET\n";
    assert_eq!(ends(file), [1.0, 2.0, 3.0, 10.0, 9.0]);
    let missing = run("G0 X1\nBORE(1)\nX2").diagnostics;
    assert!(missing[0].message.contains("`bore` is not in this file"), "{missing:?}");
}

#[test]
fn statements_become_words() {
    let options = Options { dialect: Some(Dialect::Siemens), ..Options::default() };
    let program = read_with(
        b"MCALL CYCLE81(10, , 2, -5) ; drill\nSUPA G0 Z=5 D0\nT=\"MILL 10\"\nMSG(\"HELLO\")",
        &options,
    );
    let addresses: Vec<u8> = program.words.iter().map(|word| word.letter).collect();
    let argument = |index: u8| address::ARGUMENT + index;
    let (statement, tool) = (address::STATEMENT, address::TOOL_NAME);
    let expected = [
        statement,
        statement,
        argument(0),
        argument(2),
        argument(3),
        statement,
        b'G',
        b'Z',
        b'D',
        tool,
        statement,
        argument(0),
    ];
    assert_eq!(addresses, expected);
    assert_eq!(program.texts, ["MILL 10", "HELLO"]);
    assert_eq!(program.diagnostics, []);
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
