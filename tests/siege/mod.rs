//! Siege: programs made to hurt. Geometry that no CAM writes must give a plan that holds the laws, on any machine, and
//! small files that ask for endless work must end with a message, in bounded time and memory.
mod clocks;
mod machines;

use crate::fuzz::borders;
use std::fmt::Write;

use truefeed::machine::{CornerMode, Machine, TimeConstants, presets};
use truefeed::simulation::feed::CornerPolicy;
use truefeed::simulation::gcode::{Dialect, Options, Severity, read_with};
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

/// Blocks of each hostile path.
const BLOCKS: usize = 400;

/// The most moves of a block of these paths: a corner beside a contour has two more.
const MOVES_PER_BLOCK: usize = 3;

/// The most remarks of a program, however many of its lines are bad: a few hundred of a kind.
const MOST_REMARKS: usize = 2_000;

/// The most moves of a program whose loops and cycles are cut short.
const MOST_MOVES: usize = 4_000_000;

/// The most pulses of a move on a plan of isolated corners.
const PULSES_PER_MOVE: usize = 4;

/// Machines on which the plan takes different ways.
fn machines() -> Vec<Machine> {
    let mut machines: Vec<Machine> = presets().into_iter().map(|preset| preset.machine).collect();
    for filters in 1..=4 {
        let mut machine = Machine::default();
        machine.interpolator.filters = filters;
        machines.push(machine);
    }
    let mut unequal = Machine::default();
    unequal.interpolator.filters = 2;
    unequal.interpolator.time_constants = TimeConstants::Unequal(vec![0.08, 0.0004]);
    let mut limited = Machine::default();
    limited.axes[0].acceleration = 300.0;
    limited.axes[1].acceleration = 3000.0;
    limited.axes[1].velocity = 50.0;
    limited.path.acceleration = 800.0;
    limited.path.centripetal_acceleration = 500.0;
    limited.interpolator.block_time = 0.002;
    let mut guaranteed = Machine::default();
    guaranteed.interpolator.corner_mode = CornerMode::Guaranteed;
    machines.extend([unequal, limited, guaranteed]);
    machines
}

/// A path of `BLOCKS` blocks, the number of each to its text.
fn path(head: &str, block: impl Fn(usize) -> String) -> String {
    path_of(BLOCKS, head, block)
}

fn path_of(blocks: usize, head: &str, block: impl Fn(usize) -> String) -> String {
    (1..=blocks).fold(format!("G21 G90 G94\nG0 X0 Y0 Z0\nF3000\n{head}\n"), |mut text, number| {
        writeln!(text, "{}", block(number)).expect("text has room");
        text
    })
}

fn hold_the_laws(name: &str, program: &str) {
    for machine in machines() {
        let toolpath = trace(&read_with(program.as_bytes(), &Options::default()), &machine);
        let blocks = program.lines().count();
        assert!(
            toolpath.segments.len() <= MOVES_PER_BLOCK * blocks,
            "{name}: {} moves of {blocks} blocks",
            toolpath.segments.len()
        );
        assert!(toolpath.diagnostics.len() <= MOST_REMARKS, "{name}: {} remarks", toolpath.diagnostics.len());
        let outcome = std::panic::catch_unwind(|| borders::check_plan(&toolpath, &machine));
        let (filters, mode) = (machine.interpolator.filters, machine.interpolator.corner_mode);
        assert!(outcome.is_ok(), "{name} on {} with {filters} filters, {mode:?}", machine.name);
    }
}

#[test]
fn blocks_of_no_length() {
    hold_the_laws("zero", &path("", |number| format!("G1 X{} Y1", number / 40)));
    hold_the_laws("nothing but zero", &path("", |_| "G1 X0 Y0".to_string()));
}

#[test]
fn steps_of_a_picometre() {
    hold_the_laws(
        "1e-9",
        &path("", |number| format!("G1 X{:.9} Y{:.9}", number as f64 * 1e-9, (number % 2) as f64 * 1e-9)),
    );
    hold_the_laws(
        "1e-9 between millimetres",
        &path("", |number| format!("G1 X{:.9}", (number / 2) as f64 + (number % 2) as f64 * 1e-9)),
    );
    hold_the_laws(
        "1e-9 at 1e5",
        &path("G1 X100000", |number| format!("G91 G1 X0.00000000{} Y0.000000001", number % 10)),
    );
}

/// All of them lie under one filter delay, and each is still measured by itself: the plan grows with their number.
#[test]
fn fifty_thousand_steps_of_a_nanometre() {
    let program = path_of(50_000, "", |number| {
        format!("G1 X{:.6} Y{:.6}", number as f64 * 1e-6, (number % 2) as f64 * 1e-6)
    });
    let machine = Machine::default();
    let toolpath = trace(&read_with(program.as_bytes(), &Options::default()), &machine);
    let mut rounds = 0;
    let (plan, errors) = simulate::within(&toolpath, &machine, 0.01, &mut |_| rounds += 1);
    assert!((50_000..=50_001).contains(&toolpath.segments.len()));
    assert!(plan.pulses.len() <= PULSES_PER_MOVE * toolpath.segments.len(), "{} pulses", plan.pulses.len());
    assert!(rounds <= 100, "{rounds} rounds");
    assert!(0.0 < errors.largest() && errors.largest() < 1e-5, "{} mm", errors.largest());
    assert!(plan.cycle_time() < 1.0, "{} s", plan.cycle_time());
}

#[test]
fn coordinates_of_a_thousand_kilometres() {
    hold_the_laws(
        "1e9",
        &path("", |number| format!("G1 X{} Y{}", (number % 3) * 500_000_000, (number % 2) * 1_000_000_000)),
    );
    hold_the_laws(
        "1e9 and 1e-3",
        &path("G1 X1000000000", |number| {
            format!("G91 G1 X{}", if number % 5 == 0 { "-1000000000" } else { "0.001" })
        }),
    );
    hold_the_laws("further than any", &path("", |number| format!("G1 X{}", "9".repeat(number % 330 + 1))));
}

#[test]
fn directions_reversed() {
    hold_the_laws("there and back", &path("", |number| format!("G1 X{}", (number % 2) * 10)));
    hold_the_laws(
        "there and back by a hair",
        &path("", |number| format!("G1 X{}", (number % 2) as f64 * 1e-4)),
    );
    hold_the_laws(
        "almost back",
        &path("", |number| format!("G1 X{} Y{:.7}", (number % 2) * 10, number as f64 * 1e-7)),
    );
    hold_the_laws("rapid and feed", &path("", |number| format!("G{} X{}", number % 2, (number % 2) * 10)));
}

#[test]
fn arcs_of_every_size() {
    hold_the_laws("full circles", &path_of(80, "", |_| "G2 I5 J0".to_string()));
    hold_the_laws("circles of a nanometre", &path_of(80, "", |_| "G3 I0.000001 J0".to_string()));
    hold_the_laws("circles of a kilometre", &path_of(80, "", |number| format!("G2 I1000000 J{number}")));
    hold_the_laws(
        "arcs that are almost lines",
        &path_of(80, "", |number| format!("G2 X{} Y0 R1000000000", number as f64 * 0.001)),
    );
    hold_the_laws("arcs of no chord", &path_of(80, "", |_| "G2 X0 Y0 R1".to_string()));
    hold_the_laws("helices", &path_of(80, "", |number| format!("G2 I1 Z{}", (number % 2) as f64 * 1e6)));
}

#[test]
fn feedrates_of_every_size() {
    hold_the_laws(
        "feeds",
        &path("", |number| {
            let feed = ["0", "0.000000001", "1", "99999999999999999999", "-5", "3000"][number % 6];
            format!("G1 X{} Y{} F{feed}", number, number % 2)
        }),
    );
    hold_the_laws(
        "inverse time",
        &path("G93", |number| format!("G1 X{} F{}", number, [1e-3, 1e3, 1e9][number % 3])),
    );
}

#[test]
fn numbers_that_are_none() {
    let words = [
        "NAN", "INF", "-INF", "1E400", "1e-400", "--1", "+-1", ".", "-", "#0", "[0/0]", "[1/0]", "[0-1/0]",
        "SQRT[-1]", "LN[0]", "1.2.3", "0x10", "١", "1,5",
    ];
    for letter in ["X", "Y", "I", "R", "F", "P", "K", "S"] {
        let program = path("", |number| {
            let word = words[number % words.len()];
            format!("G{} {letter}{word} X{}\n#1={word}\nG1 {letter}#1", number % 4, number % 3)
        });
        for (_, dialect, _) in Dialect::WORDS {
            let machine = Machine::default();
            let toolpath = trace(
                &read_with(program.as_bytes(), &Options { dialect: Some(dialect), ..Options::default() }),
                &machine,
            );
            borders::check_plan(&toolpath, &machine);
        }
    }
}

/// A program that asks for more than any machine could do is cut short and says so.
fn ends_with_a_message(name: &str, dialect: Dialect, program: &str) -> Toolpath {
    let options = Options { dialect: Some(dialect), ..Options::default() };
    let toolpath = trace(&read_with(program.as_bytes(), &options), &Machine::default());
    let said: Vec<&str> = toolpath
        .diagnostics
        .iter()
        .filter(|diagnostic| diagnostic.severity != Severity::Info)
        .map(|diagnostic| diagnostic.message.as_str())
        .collect();
    assert!(
        !said.is_empty(),
        "{name}: {} moves of {} bytes, and nothing is said",
        toolpath.segments.len(),
        program.len()
    );
    assert!(said.len() <= MOST_REMARKS, "{name}: {} remarks", said.len());
    let work = toolpath.segments.len() + toolpath.stops.len();
    assert!(work <= MOST_MOVES, "{name}: {work} moves and stops");
    println!("{name}: {} moves: {}", toolpath.segments.len(), said[0]);
    toolpath
}

#[test]
fn small_files_that_ask_for_endless_work_end_with_a_message() {
    let nested = |open: &dyn Fn(usize) -> String, inside: &str, close: &dyn Fn(usize) -> String| {
        let opened: String = (1..=5).map(open).collect();
        let closed: String = (1..=5).rev().map(close).collect();
        format!("{opened}{inside}{closed}M2\n")
    };
    let inside = "G91 G1 X1 F1000\nX-1\n";
    ends_with_a_message(
        "repeats of LinuxCNC",
        Dialect::LinuxCnc,
        &nested(&|o| format!("o{o} repeat [100000]\n"), inside, &|o| format!("o{o} endrepeat\n")),
    );
    ends_with_a_message(
        "loops of macro B",
        Dialect::Iso,
        &nested(&|o| format!("#{o}=0\nWHILE [#{o} LT 99999] DO{o}\n"), inside, &|o| {
            format!("#{o}=#{o}+1\nEND{o}\n")
        }),
    );
    ends_with_a_message("a jump back", Dialect::Iso, "N10 G91 G1 X1 F1000\nX-1\nGOTO 10\nM30\n");
    ends_with_a_message(
        "loops of SINUMERIK",
        Dialect::Siemens,
        &nested(&|o| format!("FOR R{o}=1 TO 100000\n"), inside, &|_| "ENDFOR\n".to_string()),
    );
    ends_with_a_message(
        "repeats of Klartext",
        Dialect::Klartext,
        &format!(
            "0 BEGIN PGM A MM\n{}1 L IX+1 F1000\n{}9 END PGM A MM\n",
            (1..=4).map(|label| format!("LBL {label}\n")).collect::<String>(),
            (1..=4).rev().map(|label| format!("CALL LBL {label} REP 65534\n")).collect::<String>()
        ),
    );
    ends_with_a_message(
        "subprograms that call one another",
        Dialect::Iso,
        "O1\nM98 P2 L9999\nM30\nO2\nM98 P3 L9999\nM99\nO3\nG91 G1 X1 F1000\nX-1\nM99\n",
    );
    ends_with_a_message("a subprogram that calls itself", Dialect::Iso, "O1\nM98 P1\nM30\n");
    ends_with_a_message(
        "pecks of a nanometre",
        Dialect::Iso,
        "G99 G83 X0 Y0 Z-1000 R1 Q0.000001 F100\nX1\nX2\nM30\n",
    );
    ends_with_a_message(
        "holes without end",
        Dialect::LinuxCnc,
        "G91 G81 X1 Y1 Z-1 R1 L2000000000 F100\nM2\n",
    );
}

/// A file whose line ends were lost is refused block by block, whatever a block would be searched for.
#[test]
fn lines_without_end_are_refused() {
    for (dialect, word) in [
        (Dialect::Iso, "T1"),
        (Dialect::Iso, "X1"),
        (Dialect::Iso, "M6"),
        (Dialect::Iso, "G1X1"),
        (Dialect::Iso, "X#1"),
        (Dialect::Okuma, "G15"),
        (Dialect::LinuxCnc, "G64P1"),
        (Dialect::Siemens, "G641 "),
        (Dialect::Siemens, "CYCLE832(0.1,1)"),
        (Dialect::HeidenhainIso, "G01X+1"),
        (Dialect::Klartext, "L X+1 "),
    ] {
        let text = word.repeat(100_000);
        let options = Options { dialect: Some(dialect), ..Options::default() };
        let program = read_with(text.as_bytes(), &options);
        assert!(program.words.len() <= 250 * program.blocks.len().max(1), "{word}: {}", program.words.len());
        let toolpath = trace(&program, &Machine::default());
        assert!(toolpath.segments.len() <= 1, "{word}: {} moves", toolpath.segments.len());
        assert!(!toolpath.diagnostics.is_empty(), "{word}: nothing is said");
        assert!(toolpath.diagnostics.len() <= MOST_REMARKS, "{word}");
    }
    for (open, close) in [("[", "]"), ("(", ")"), ("#", ""), ("SIN[", "]"), ("-", "")] {
        let text = format!("G1 X{}1{} F100\n", open.repeat(100_000), close.repeat(100_000));
        let toolpath = trace(&read_with(text.as_bytes(), &Options::default()), &Machine::default());
        assert!(toolpath.segments.len() <= 1 && !toolpath.diagnostics.is_empty(), "{open}");
    }
}

/// Constructs within each other, far deeper than any control follows them: read with a message, and run within bounds.
#[test]
fn constructs_nested_without_end_end_with_a_message() {
    const DEEP: usize = 20_000;
    let nested = |open: &str, inside: &str, close: &str| {
        format!("{}{inside}{}", open.repeat(DEEP), close.repeat(DEEP))
    };
    let move_by_one = "G91 G1 X1 F1000\n";
    for (name, text) in [
        ("branches", nested("IF R1==0\n", move_by_one, "ENDIF\n")),
        ("branches in ELSE", nested("IF R1==1\nELSE\n", move_by_one, "ENDIF\n")),
        ("loops", nested("LOOP\n", move_by_one, "ENDLOOP\n")),
        ("loops that count", nested("FOR R1=1 TO 2\n", move_by_one, "ENDFOR\n")),
        ("loops that never close", nested("WHILE R1<3\n", move_by_one, "")),
        ("loops that never open", nested("", move_by_one, "ENDWHILE\n")),
        ("loops that cross", nested("WHILE R1<2\nREPEAT\n", move_by_one, "ENDWHILE\nUNTIL R1>2\n")),
        ("brackets", format!("G1 X={}1{} F100\n", "(".repeat(DEEP), ")".repeat(DEEP))),
        ("functions", format!("R1={}0{}\n{move_by_one}", "SIN(".repeat(DEEP), ")".repeat(DEEP))),
        ("parameters", format!("R1={}0{}\n{move_by_one}", "R[".repeat(DEEP), "]".repeat(DEEP))),
        ("signs", format!("R1={}5\nNOPE\n{move_by_one}", "-".repeat(DEEP))),
        ("arguments", format!("CYCLE81({}1{})\n", "(".repeat(DEEP), ")".repeat(DEEP))),
        ("strings", format!("MSG({}\n{move_by_one}", "\"(".repeat(DEEP))),
        ("cases", format!("CASE R1 OF {}\n{move_by_one}", "1 GOTOF A ".repeat(DEEP))),
        ("frames", format!("{}{move_by_one}NOPE\n", "ATRANS X1\nAROT Z1\nASCALE X2\n".repeat(DEEP))),
        ("modal calls", format!("{}X1\n", "MCALL CYCLE81(10,0,2,-5)\n".repeat(DEEP) + "X1 NOPE\n")),
        (
            "repeats in each other",
            format!(
                "{}{move_by_one}{}",
                (0..5000).map(|n| format!("L{n}:\n")).collect::<String>(),
                (0..5000).rev().map(|n| format!("REPEAT L{n} P=9\n")).collect::<String>()
            ),
        ),
    ] {
        ends_with_a_message(&format!("{name} of SINUMERIK"), Dialect::Siemens, &text);
    }
    let program = |inside: &str| format!("0 BEGIN PGM A MM\n{inside}9 END PGM A MM\n");
    let move_by_one = "L IX+1 F1000\n";
    for (name, text) in [
        ("calls of itself", "LBL 1\nL IX+1 F1000\nCALL LBL 1\nLBL 0\nCALL LBL 1\n".to_string()),
        (
            "calls in each other",
            format!(
                "CALL LBL 1\nM30\n{}",
                (1..5000)
                    .map(|n| format!("LBL {n}\nL IX+1 F100\nCALL LBL {}\nLBL 0\n", n + 1))
                    .collect::<String>()
            ),
        ),
        (
            "repeats in each other",
            format!(
                "{}{move_by_one}{}",
                (1..5000).map(|n| format!("LBL {n}\n")).collect::<String>(),
                (1..5000).rev().map(|n| format!("CALL LBL {n} REP 9\n")).collect::<String>()
            ),
        ),
        ("jumps back", "LBL 1\nL IX+1 F1000\nFN 9: IF +0 EQU +0 GOTO LBL 1\n".to_string()),
        ("brackets", format!("Q1 = {}1{}\n{move_by_one}", "(".repeat(DEEP), ")".repeat(DEEP))),
        ("functions", format!("Q1 = {}0\n{move_by_one}", "SIN ".repeat(DEEP))),
        ("signs", format!("Q1 = {}5\nNOPE\n{move_by_one}", "-".repeat(DEEP))),
        (
            "cycles",
            "CYCL DEF 200 Q200=2 Q201=-5 Q206=150 Q202=1 Q210=0 Q203=0 Q204=50 Q211=0\n".repeat(DEEP)
                + "CYCL CALL\nNOPE\n",
        ),
        ("programs", format!("{}{move_by_one}", "BEGIN PGM A MM\n".repeat(DEEP) + "NOPE\n")),
        ("parts of a cycle", format!("CYCL DEF 200{}\n", " Q201=-5".repeat(DEEP))),
    ] {
        ends_with_a_message(&format!("{name} of Klartext"), Dialect::Klartext, &program(&text));
    }
    let blocks = (1..5000).map(|n| format!("N{n} G98 L{n} *\n")).collect::<String>();
    let calls = (1..5000).rev().map(|n| format!("N{} L{n},9 *\n", 10_000 - n)).collect::<String>();
    ends_with_a_message(
        "repeats in each other of DIN/ISO",
        Dialect::HeidenhainIso,
        &format!("%A G71 *\n{blocks}G91 G01 X+1 F1000 *\n{calls}N99999 %A G71 *\n"),
    );
}

/// A table with all rows that its corners need has 78 million of them, and took three minutes.
#[test]
fn the_chart_of_a_loop_without_end_has_no_more_rows_than_it_can_show() {
    let toolpath = ends_with_a_message(
        "squares without end",
        Dialect::LinuxCnc,
        "o1 repeat [100000]\no2 repeat [100000]\nG91 G1 X1 F1000\nY1\nX-1\nY-1\no2 endrepeat\no1 endrepeat\nM2\n",
    );
    let machine = Machine::default();
    let endless = simulate::with_policy(&toolpath, &machine, CornerPolicy::Programmed);
    let profile = Profile::new(&toolpath, &endless);
    let samples = profile.drawn();
    assert!((1_000_000..=4_000_000).contains(&samples.time.len()), "{} rows", samples.time.len());
    assert!(samples.spacing.is_some(), "and what is missing is said");
    let last = samples.time.last().copied().expect("rows");
    assert!((last - profile.cycle_time()).abs() < 1e-6, "{last} s of {}", profile.cycle_time());
    assert!(samples.distance.is_sorted() && samples.time.is_sorted());

    let short = trace(&read_with(b"G91 G1 X1 F1000\nY1\nX-1\nM2\n", &Options::default()), &machine);
    let whole = simulate::with_policy(&short, &machine, CornerPolicy::Programmed);
    let profile = Profile::new(&short, &whole);
    assert_eq!(
        profile.drawn(),
        profile.feed_curve(Resolution::CHART),
        "nothing is missing of an ordinary program"
    );
}

/// What a bounded program costs as a whole: the command gets no more address space than this.
#[cfg(target_os = "linux")]
#[test]
fn the_largest_of_small_files_needs_no_more_than_four_gigabytes() {
    let folder =
        std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("siege-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a writable folder");
    let program = folder.join("endless.ngc");
    std::fs::write(&program,
        "o1 repeat [100000]\no2 repeat [100000]\nG91 G1 X1 F1000\nY1\nX-1\nY-1\no2 endrepeat\no1 endrepeat\nM2\n",
    )
        .expect("a writable folder");
    let machine = folder.join("m.toml");
    std::fs::write(&machine, truefeed::project::toml_from_machine(&Machine::default()))
        .expect("a writable folder");
    let limited = format!(
        "ulimit -v 4000000; exec '{}' predict '{}' --machine '{}' --tolerance 0.01 --json",
        env!("CARGO_BIN_EXE_truefeed"),
        program.display(),
        machine.display()
    );
    let output = std::process::Command::new("sh").args(["-c", &limited]).output().expect("a shell");
    let _ = std::fs::remove_dir_all(&folder);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(json["diagnostics"].as_array().is_some_and(|said| !said.is_empty()), "nothing is said");
    assert!(json["runs"][0]["cycle_time_s"].as_f64().is_some_and(|time| 1000.0 < time));
}
