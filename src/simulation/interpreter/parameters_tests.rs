//! Laws of parameters and expressions, from the text of a program to its moves.

use crate::machine::Machine;
use crate::simulation::gcode::{Severity, read};
use crate::simulation::interpreter::trace;
use crate::simulation::toolpath::Toolpath;
use crate::simulation::toolpath::random::Random;

fn run(text: &str) -> Toolpath {
    trace(&read(text.as_bytes()), &Machine::default())
}

/// The value of an expression: where X goes under it.
#[track_caller]
fn value(expression: &str) -> f64 {
    let toolpath = run(&format!("#1=5 #2=-3 #<a b>=7 #5=1\nG0 X1000\nX{expression}"));
    assert_eq!(toolpath.diagnostics, [], "{expression}");
    toolpath.segments.last().expect("X1000 moves").end.x
}

/// Line, columns and message of each diagnostic; all are errors.
#[track_caller]
fn errors(text: &str) -> Vec<(u32, (u32, u32), String)> {
    let diagnostics = run(text).diagnostics;
    assert!(diagnostics.iter().all(|found| found.severity == Severity::Error), "{diagnostics:?}");
    diagnostics.into_iter().map(|found| (found.line.0, found.columns, found.message)).collect()
}

#[test]
fn values_are_as_written_out() {
    let cases = [
        ("#1", 5.0),
        ("-#1", -5.0),
        ("+#2", -3.0),
        ("-[1+2]", -3.0),
        ("#<a b>", 7.0),
        ("#<AB>", 7.0),
        ("# < A b >", 7.0),
        ("##5", 5.0),
        ("#[#5+1]", -3.0),
        ("#[2-1]", 5.0),
        ("[#1*#2]", -15.0),
        ("[ 1 0 . 5 - . 5 ]", 10.0),
        ("[1--2]", 3.0),
        ("[[[2]]]", 2.0),
        ("[7/2]", 3.5),
        ("[7 MOD 4]", 3.0),
        ("[-7 mod 4]", 1.0),
        ("[2**10]", 1024.0),
        ("[2**-1]", 0.5),
        ("[-2**2]", 4.0),
        ("SIN[30]", 0.5),
        ("-COS[60]", -0.5),
        ("TAN[45]", 1.0),
        ("ASIN[1]", 90.0),
        ("ACOS[0]", 90.0),
        ("ATAN[1]/[-1]", 135.0),
        ("ATAN[-1]/[-1]", -135.0),
        ("ATAN[1]", 45.0),
        ("[ATAN[1]/[1]*2]", 90.0),
        ("[ATAN[1]/3]", 15.0),
        ("S Q R T [9]", 3.0),
        ("ABS[-4]", 4.0),
        ("EXP[0]", 1.0),
        ("LN[EXP[2]]", 2.0),
        ("[ROUND[2.5]+10*ROUND[-2.5]]", -27.0),
        ("FIX[2.8]", 2.0),
        ("FIX[-2.8]", -3.0),
        ("FUP[2.1]", 3.0),
        ("FUP[-2.8]", -2.0),
        ("[1 EQ 1]", 1.0),
        ("[1 NE 1]", 0.0),
        ("[2 GT 1]", 1.0),
        ("[1 GE 1]", 1.0),
        ("[1 LT 1]", 0.0),
        ("[1 LE 1]", 1.0),
        ("[2 AND 4]", 1.0),
        ("[2 AND 0]", 0.0),
        ("[0 OR -1]", 1.0),
        ("[2 XOR 4]", 0.0),
        ("[0 xor 4]", 1.0),
    ];
    for (expression, expected) in cases {
        assert!((value(expression) - expected).abs() < 1e-12, "{expression}: {}", value(expression));
    }
}

/// Each row of the table binds more tightly than the next, and each from left to right.
#[test]
fn operators_bind_in_their_order() {
    let rows: [&[&str]; 5] = [
        &["**"],
        &["*", "/", "MOD"],
        &["+", "-"],
        &["EQ", "NE", "GT", "GE", "LT", "LE"],
        &["AND", "OR", "XOR"],
    ];
    for (tight, row) in rows.iter().enumerate() {
        for (loose, other_row) in rows.iter().enumerate() {
            for (a, b) in row.iter().flat_map(|a| other_row.iter().map(move |b| (a, b))) {
                for [x, y, z] in [[7, 2, 3], [2, 3, 2], [1, 1, 2], [5, 4, 1]] {
                    let plain = value(&format!("[{x} {a} {y} {b} {z}]"));
                    let grouped = match tight <= loose {
                        true => value(&format!("[[{x} {a} {y}] {b} {z}]")),
                        false => value(&format!("[{x} {a} [{y} {b} {z}]]")),
                    };
                    assert_eq!(plain, grouped, "{x} {a} {y} {b} {z}");
                }
            }
        }
    }
}

/// A program with every number behind a parameter or in brackets moves as the plain one, bit for
/// bit, arcs and dwells included.
#[test]
fn formulas_move_as_their_values() {
    let plain = "G17 G1 X10.125 Y-3.5 F600\nG2 X20 Y-3.5 I4.9375 J0 Z-1.5\nG3 X1.5 Y2 R-30\nG91 X.25\nT3 M6\nG4 P.5\nM30";
    let mut formulas = String::from("#<zero>=0\n");
    let mut number = String::new();
    for character in plain.chars().chain(['\n']) {
        if matches!(character, '0'..='9' | '.' | '-') {
            number.push(character);
            continue;
        }
        if !number.is_empty() {
            formulas += &format!("[{number}+#<zero>]");
            number.clear();
        }
        formulas.push(character);
    }
    let (expected, found) = (run(plain), run(&formulas));
    assert_eq!(expected.segments.len(), found.segments.len());
    for (a, b) in expected.segments.iter().zip(&found.segments) {
        assert_eq!((a.start, a.end, &a.curve, a.motion), (b.start, b.end, &b.curve, b.motion));
    }
    assert_eq!(expected.stops.len(), 3);
    assert!(expected.stops.iter().zip(&found.stops).all(|(a, b)| (a.after, a.cause) == (b.after, b.cause)));
}

#[test]
fn assignments_act_after_their_block() {
    let ends = |text: &str| -> Vec<f64> {
        let toolpath = run(text);
        assert_eq!(toolpath.diagnostics, [], "{text}");
        toolpath.segments.iter().map(|segment| segment.end.x).collect()
    };
    assert_eq!(ends("#3=5\nG0 #3=6 X#3\nX#3"), [5.0, 6.0]);
    assert_eq!(ends("#3=5\n#3=6 #4=#3\nG0 X#4\nX#3"), [5.0, 6.0]);
    assert_eq!(ends("#3=5 #3=6\nG0 X#3"), [6.0]);
    assert_eq!(ends("#1=7\n##1=3\nG0 X#7"), [3.0]);
    assert_eq!(ends("#[3+4]=3\nG0 X#7"), [3.0]);
    assert_eq!(ends("#<x>=1\n#<X>=[#<x>+1]\nG0 X#< x >"), [2.0]);
    assert_eq!(ends("#4=9/2.(R.);\nG0 X#4"), [4.5]);
    assert_eq!(ends("#8=1\nG#8X-[#8]F100"), [-1.0]);
    let leader = run("#9=2 #8=[1+1]\n%\n#9=1\nG0 X#9\n%");
    assert_eq!(
        (leader.segments.len(), leader.segments.at(0).end.x),
        (1, 1.0),
        "what a leader assigns is not run"
    );
}

/// Blocks that cannot be worked out are named and left out as a whole, assignments included.
#[test]
fn what_has_no_value_is_said() {
    let cases: &[(&str, (u32, u32), &str)] = &[
        ("Y3 X#<scale>", (4, 13), "#<scale> has no value"),
        ("#7=1 X#<b>", (6, 11), "#<b> has no value"),
        ("#[0]=1", (1, 7), "0 is not the number"),
        ("#0=1", (1, 5), "0 is not the number"),
        ("X#-1", (1, 5), "-1 is not the number"),
        ("X#1.5", (1, 6), "1.5 is not the number"),
        ("X[1/0]", (1, 7), "1 is divided by zero"),
        ("X[1 MOD 0]", (1, 11), "1 is divided by zero"),
        ("X[0**-1]", (1, 9), "divided by zero"),
        ("X[-2**.5]", (1, 10), "-2 to the power of 0.5"),
        ("XSQRT[-1]", (1, 10), "SQRT of -1"),
        ("XACOS[2]", (1, 9), "ACOS of 2"),
        ("XLN[0]", (1, 7), "LN of 0"),
        ("XEXP[1000]", (1, 11), "too large"),
        ("X[10**308*10]", (1, 14), "too large"),
        ("X[1+", (5, 6), "expected a value, found the end of the line"),
        ("X[1 2 Y]", (7, 8), "expected an operator or `]`, found `Y`"),
        ("X[]", (3, 4), "expected a value, found `]`"),
        ("XSIN[30", (8, 9), "expected an operator or `]`, found the end"),
        ("#5", (3, 4), "expected `=`"),
        ("#5=", (4, 5), "expected a value"),
        ("X[SINE[3]]", (6, 7), "expected `[`, found `E`"),
        ("X[FOO[3]]", (3, 6), "`FOO` is not a known function"),
        ("X#<a", (3, 4), "`<a` is not the name"),
        ("X#<>", (3, 4), "is not the name"),
        ("#<\u{e4}>=1 ?", (8, 9), "`?` is not understood"),
        ("X[1]]", (5, 6), "`]` is not understood"),
        ("X=5", (1, 4), "`X=5` is not understood"),
    ];
    for (text, columns, part) in cases {
        let found = errors(&format!("G0 #90=1\n{text}\nX#90"));
        assert_eq!(found.len(), 1, "{text}: {found:?}");
        assert_eq!((found[0].0, found[0].1), (2, *columns), "{text}: {found:?}");
        assert!(found[0].2.contains(part) && found[0].2.ends_with("block not run"), "{text}: {found:?}");
        assert_eq!(run(&format!("G0 #90=1\n{text}\nX#90")).segments.len(), 1, "{text}");
    }
    let twice = errors("#<a>=1 X#<b>\nX#<a>");
    assert_eq!(twice.len(), 2, "nothing is assigned by a block that is not run");
    let huge = format!("X[{}]", "9".repeat(400));
    assert!(errors(&huge)[0].2.contains("too large"));
}

/// On Fanuc controls nothing is 0 in arithmetic, equal to nothing but itself, and no word.
#[test]
fn nothing_is_a_value_of_its_own() {
    let x = |text: &str| run(text).segments.last().map_or(0.0, |segment| segment.end.x);
    assert_eq!(x("%\nG0 X7 Y#5\n%"), 7.0);
    assert_eq!(x("%\nG0 X3\nX#5 Y1\n%"), 3.0, "a vacant word is not there");
    assert_eq!(x("%\n#5=4 #6=#5\n#5=#0\nG0 X[#5+1]\n%"), 1.0);
    assert_eq!(x("%\nG0 X[1+[#5 EQ #0]+2*[#5 EQ 0]+4*[#5 NE 0]]\n%"), 6.0);
    let warned = run("%\nG0 X[1+#5]\n%").diagnostics;
    assert!(warned[0].message.contains("the first is #5"), "{warned:?}");
    assert_eq!(x("#<a>=1\nG0 X[1+#<a>]\nX#5"), 0.0, "on LinuxCNC it is 0");
}

/// On Fanuc controls AND, OR and XOR combine bits, which between conditions is the same as truths.
#[test]
fn fanuc_controls_combine_bits() {
    let x = |text: &str| run(text).segments.last().map_or(0.0, |segment| segment.end.x);
    for (expression, expected) in [
        ("6 AND 1", 0.0),
        ("6 OR 1", 7.0),
        ("6 XOR 3", 5.0),
        ("5.6 AND 3.4", 2.0),
        ("-1 AND 5", 5.0),
        ("#9 OR 4", 4.0),
        ("[2 GT 0] AND [3 GT 0]", 1.0),
        ("[2 GT 0] AND [3 LT 0]", 0.0),
        ("[2 EQ 0] OR [3 NE 0]", 1.0),
        ("[2 GT 0] XOR [3 GT 0]", 0.0),
    ] {
        assert_eq!(x(&format!("%\nG0 X[100+[{expression}]]\n%")), 100.0 + expected, "{expression}");
    }
    assert_eq!(x("%\n#1=6\nIF[[#1 AND 1]EQ 0]GOTO10\nG0 X1.\nN10 G0 X2.\n%"), 2.0);
    assert_eq!(x("#<a>=6\nG0 X[#<a> AND 1]"), 1.0, "on LinuxCNC they are truths");
}

/// No depth of nesting exhausts the stack, and no length takes more than linear time.
#[test]
fn depth_is_bounded() {
    let nested = |depth: usize| format!("G0 X{}1{}", "[".repeat(depth), "]".repeat(depth));
    assert_eq!(run(&nested(64)).diagnostics, []);
    for text in [nested(65), nested(1_000_000), format!("X{}1", "#".repeat(1_000_000)), "X-[".repeat(500_000)]
    {
        let found = errors(&text);
        assert!(
            found.len() == 1 && found[0].2.contains("deeper than 64") || text.starts_with("X-"),
            "{found:?}"
        );
    }
    let long = format!("G0 X[{}1]", "1+".repeat(1_000_000));
    assert_eq!(run(&long).segments.at(0).end.x, 1_000_001.0);
    let powers = format!("G0 X[{}1]", "1**1*1+1 EQ 1 AND ".repeat(100_000));
    assert_eq!(run(&powers).diagnostics, []);
    run(&format!("X[1{}", " ".repeat(1_000_000)));
    run(&"#<a".repeat(500_000));
}

/// Expressions by a grammar, then damaged: the true ones run, and no damage does harm.
#[test]
fn any_expressions_run() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let pieces =
        ["#", "[", "]", "<", ">", "=", "*", "/", "-", ".", "1", "X", "\n", "(", ";", "SIN[", "MOD", "\u{e4}"];
    let mut moves = 0;
    for case in 0..40_000 {
        let mut text = String::from("#1=1 #2=2 #<a>=3 F100\nG1");
        for letter in ["X", "\n#3=", "\nG2 X", "Y", "I", "\nG1 Z"] {
            text += letter;
            random.value(&mut text, 3);
        }
        let damages = if case % 2 == 0 { 0 } else { 1 + random.below(6) };
        for _ in 0..damages {
            let at = random.below(text.len() + 1);
            if text.is_char_boundary(at) {
                text.insert_str(at, pieces[random.below(pieces.len())]);
            }
        }
        let toolpath = run(&text);
        if damages == 0 {
            let is_read =
                |message: &str| !message.contains("expected") && !message.contains("not understood");
            assert!(toolpath.diagnostics.iter().all(|found| is_read(&found.message)), "{text}: {toolpath:?}");
        }
        moves += toolpath.segments.len();
        assert!(toolpath.segments.iter().all(|segment| segment.length.is_finite()), "{text}");
    }
    assert!(40_000 < moves, "{moves} moves: many expressions have values");
}

impl Random {
    /// Writes a value of the grammar.
    fn value(&mut self, into: &mut String, depth: usize) {
        let operators = ["**", "*", "/", "MOD", "+", "-", "EQ", "LT", "ge", "AND", "OR", "XOR"];
        let functions = ["SIN", "cos", "ATAN", "SQRT", "ABS", "LN", "ROUND", "FIX", "ASIN"];
        match self.below(if depth == 0 { 3 } else { 8 }) {
            0 => *into += &format!("{}", self.below(20_000) as f64 / 1000.0 - 10.0),
            1 => *into += ["#1", "-#2", "##2", "#<a>", "# < A >", "#<missing>"][self.below(6)],
            2 => *into += &self.below(10).to_string(),
            kind => {
                if kind == 7 {
                    *into += functions[self.below(functions.len())];
                }
                into.push('[');
                self.value(into, depth - 1);
                for _ in 0..self.below(3) {
                    *into += operators[self.below(operators.len())];
                    self.value(into, depth - 1);
                }
                into.push(']');
            }
        }
    }
}
