//! Which words of which dialect are read: every word is run in a short program of each dialect, and
//! what the reader and the tracer say about it decides its place in the table.
//!
//! `cargo run --example words` writes `docs/words.md`.

use std::path::Path;

use truefeed::machine::Machine;
use truefeed::simulation::gcode::{Dialect, Options, read_with};
use truefeed::simulation::interpreter::trace;

const HEAD: &str = "# Words by dialect

**●** supported · **○** supported with a caveat, which a remark states · **–** unsupported, which a remark reports with line and
column · blank: no example in this dialect. `cargo run --example words` writes this page: it runs each example in a short
program of its dialect that first sets a tool, a spindle speed and a feedrate.

Heidenhain means Klartext; Heidenhain's DIN/ISO form is the column DIN.

";

/// A word: what it is, and how each dialect writes it. A dialect that is not listed runs the first.
struct Row(&'static str, &'static [(&'static [Dialect], &'static str)]);

const ISO: &[Dialect] = &[Dialect::Iso, Dialect::LinuxCnc, Dialect::Grbl, Dialect::Mach, Dialect::Okuma];
const SIEMENS: &[Dialect] = &[Dialect::Siemens];
const KLARTEXT: &[Dialect] = &[Dialect::Klartext];
const DIN: &[Dialect] = &[Dialect::HeidenhainIso];
const ALL_ISO: &[Dialect] = &[
    Dialect::Iso,
    Dialect::LinuxCnc,
    Dialect::Siemens,
    Dialect::HeidenhainIso,
    Dialect::Grbl,
    Dialect::Mach,
    Dialect::Okuma,
];

/// The chapters of the table.
const CHAPTERS: &[(&str, &[Row])] = &[
    (
        "Moves",
        &[
            Row("rapid", &[(ALL_ISO, "G0 X5"), (KLARTEXT, "L X+5 FMAX")]),
            Row("feed", &[(ALL_ISO, "G1 X5"), (KLARTEXT, "L X+5 F500")]),
            Row(
                "arc by centre",
                &[
                    (ISO, "G2 X5 Y5 I5 J0"),
                    (SIEMENS, "G2 X5 Y5 I5 J0"),
                    (KLARTEXT, "CC X+5 Y+0\nC X+5 Y+5 DR-"),
                    (DIN, "I5 J0\nG2 X5 Y5"),
                ],
            ),
            Row(
                "arc by radius",
                &[
                    (ISO, "G2 X5 Y5 R5"),
                    (SIEMENS, "G2 X5 Y5 CR=5"),
                    (KLARTEXT, "CR X+5 Y+5 R+5 DR-"),
                    (DIN, "G2 X5 Y5 R5"),
                ],
            ),
            Row(
                "helix",
                &[
                    (ISO, "G2 X0 Y0 Z-1 I5 J0"),
                    (SIEMENS, "G2 X0 Y0 Z-1 I5 J0 TURN=2"),
                    (KLARTEXT, "CC X+5 Y+0\nCP IPA-360 IZ-1 DR-"),
                ],
            ),
            Row("arc through a point", &[(SIEMENS, "CIP X5 Y5 I1=1 J1=3")]),
            Row(
                "tangential arc",
                &[
                    (SIEMENS, "G1 X5\nCT X10 Y5"),
                    (KLARTEXT, "L X+5 F500\nCT X+10 Y+5"),
                    (DIN, "G1 X5\nG6 X10 Y5"),
                ],
            ),
            Row(
                "polar coordinates",
                &[
                    (&[Dialect::Iso], "G16\nG1 X5 Y30\nG15"),
                    (&[Dialect::LinuxCnc], "G1 @5 ^30"),
                    (SIEMENS, "G111 X0 Y0\nG1 AP=30 RP=5"),
                    (KLARTEXT, "CC X+0 Y+0\nLP PR+5 PA+30 F500"),
                    (DIN, "I0 J0\nG11 R5 H30"),
                ],
            ),
            Row(
                "rounding",
                &[
                    (ISO, "G1 X5 ,R1\nY5"),
                    (SIEMENS, "G1 X5 RND=1\nY5"),
                    (KLARTEXT, "L X+5 F500\nRND R1\nL Y+5"),
                    (DIN, "G1 X5\nG25 R1\nY5"),
                ],
            ),
            Row(
                "chamfer",
                &[
                    (ISO, "G1 X5 ,C1\nY5"),
                    (SIEMENS, "G1 X5 CHF=1\nY5"),
                    (KLARTEXT, "L X+5 F500\nCHF 1\nL Y+5"),
                    (DIN, "G1 X5\nG24 R1\nY5"),
                ],
            ),
            Row(
                "approach, departure",
                &[
                    (KLARTEXT, "APPR LT X+5 Y+0 LEN5 R0 F500\nL X+9\nDEP LT LEN5"),
                    (SIEMENS, "G147 X5 Y5 DISR=5"),
                ],
            ),
            Row("thread", &[(ALL_ISO, "G33 Z-5 K1")]),
            Row("spline", &[(&[Dialect::LinuxCnc], "G5 X5 Y5 I1 J1 P1 Q1"), (SIEMENS, "BSPLINE X5 Y5")]),
            Row(
                "probe",
                &[
                    (&[Dialect::Iso, Dialect::Mach, Dialect::Okuma], "G31 Z-5"),
                    (&[Dialect::LinuxCnc, Dialect::Grbl], "G38.2 Z-5"),
                    (SIEMENS, "MEAS=1 G1 Z-5"),
                    (KLARTEXT, "TCH PROBE 0.0 REF. PLANE"),
                ],
            ),
            Row(
                "reference point",
                &[(ALL_ISO, "G28 Z0"), (SIEMENS, "SUPA G0 Z0"), (KLARTEXT, "L Z+0 FMAX M91")],
            ),
            Row("rotary axes", &[(ALL_ISO, "G1 A30 F500"), (KLARTEXT, "L A+30 F500")]),
            Row(
                "tool centre point",
                &[(&[Dialect::Iso, Dialect::Okuma], "G43.4 H1"), (SIEMENS, "TRAORI"), (KLARTEXT, "L M128")],
            ),
        ],
    ),
    (
        "Feed, spindle, dwell",
        &[
            Row("feed per minute", &[(ALL_ISO, "G94 G1 X5 F500"), (KLARTEXT, "L X+5 F500")]),
            Row(
                "inverse time",
                &[(
                    &[
                        Dialect::Iso,
                        Dialect::LinuxCnc,
                        Dialect::Siemens,
                        Dialect::Grbl,
                        Dialect::Mach,
                        Dialect::Okuma,
                    ],
                    "G93 G1 X5 F10",
                )],
            ),
            Row(
                "feed per revolution",
                &[
                    (
                        &[Dialect::Iso, Dialect::LinuxCnc, Dialect::Siemens, Dialect::Mach, Dialect::Okuma],
                        "G95 G1 X5 F0.1",
                    ),
                    (KLARTEXT, "L X+5 FU0.1"),
                ],
            ),
            Row("surface speed", &[(&[Dialect::Iso, Dialect::LinuxCnc, Dialect::Siemens], "G96 S100")]),
            Row(
                "dwell",
                &[
                    (ISO, "G4 P1."),
                    (SIEMENS, "G4 F1"),
                    (KLARTEXT, "CYCL DEF 9.0 DWELL TIME\nCYCL DEF 9.1 DWELL1"),
                    (DIN, "G4 F1"),
                ],
            ),
            Row(
                "exact stop",
                &[
                    (&[Dialect::Iso, Dialect::LinuxCnc, Dialect::Mach, Dialect::Okuma], "G61"),
                    (SIEMENS, "G60"),
                ],
            ),
            Row(
                "tolerance",
                &[
                    (&[Dialect::LinuxCnc], "G64 P0.01 Q0"),
                    (&[Dialect::Iso], "G187 P3 E0.01"),
                    (SIEMENS, "CYCLE832(0.01,1,1)"),
                    (KLARTEXT, "CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.01"),
                    (DIN, "G62 T0.01"),
                ],
            ),
            Row(
                "smoothing",
                &[
                    (&[Dialect::Iso], "G5.1 Q1 R5"),
                    (SIEMENS, "G642"),
                    (&[Dialect::LinuxCnc, Dialect::Mach, Dialect::Okuma], "G64"),
                ],
            ),
            Row("tool change", &[(ALL_ISO, "T2 M6"), (KLARTEXT, "TOOL CALL 2 Z S3000")]),
            Row("coolant, stops", &[(ALL_ISO, "M8 M1"), (KLARTEXT, "STOP M8")]),
        ],
    ),
    (
        "Coordinates and tool",
        &[
            Row("inch", &[(ALL_ISO, "G20"), (SIEMENS, "G70"), (DIN, "G70")]),
            Row("increments", &[(ALL_ISO, "G91 G1 X5"), (SIEMENS, "G1 X=IC(5)"), (KLARTEXT, "L IX+5 F500")]),
            Row("work offset", &[(ALL_ISO, "G54"), (KLARTEXT, "CYCL DEF 247 DATUM SETTING Q339=+1")]),
            Row(
                "shift of coordinates",
                &[
                    (ISO, "G52 X5"),
                    (SIEMENS, "TRANS X5"),
                    (KLARTEXT, "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+5"),
                    (DIN, "G54 X5"),
                ],
            ),
            Row(
                "rotation",
                &[
                    (&[Dialect::Iso, Dialect::Mach, Dialect::Okuma], "G68 X0 Y0 R30"),
                    (&[Dialect::LinuxCnc], "G10 L2 P1 R30"),
                    (SIEMENS, "ROT RPL=30"),
                    (KLARTEXT, "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+30"),
                    (DIN, "G73 G90 H30"),
                ],
            ),
            Row(
                "scaling",
                &[
                    (&[Dialect::Iso, Dialect::Mach, Dialect::Okuma], "G51 X0 Y0 P2."),
                    (SIEMENS, "SCALE X2 Y2 Z2"),
                    (KLARTEXT, "CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 2"),
                    (DIN, "G72 F2"),
                ],
            ),
            Row(
                "mirror",
                &[
                    (&[Dialect::Iso, Dialect::Okuma], "G51.1 X0"),
                    (SIEMENS, "MIRROR X0"),
                    (KLARTEXT, "CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X"),
                    (DIN, "G28 X"),
                ],
            ),
            Row(
                "tilted plane",
                &[
                    (&[Dialect::Iso], "G68.2 X0 Y0 Z0 I30 J0 K0"),
                    (SIEMENS, "CYCLE800(1,\"T\",0,57,0,0,0,30,0,0)"),
                    (KLARTEXT, "PLANE SPATIAL SPA+30 SPB+0 SPC+0 TURN"),
                ],
            ),
            Row(
                "cutter compensation",
                &[
                    (
                        &[Dialect::Iso, Dialect::LinuxCnc, Dialect::Mach, Dialect::Okuma],
                        "G41 D1 G1 X5\nG40 X0",
                    ),
                    (SIEMENS, "G41 D1 G1 X5\nG40 X0"),
                    (KLARTEXT, "L X+5 RL F500\nL X+0 R0"),
                    (DIN, "G41 G1 X5\nG40 X0"),
                ],
            ),
            Row("tool length", &[(ISO, "G43 H1 Z5"), (SIEMENS, "D1")]),
        ],
    ),
    (
        "Cycles",
        &[
            Row(
                "drilling",
                &[
                    (ISO, "G81 X5 Z-5 R1 F500\nG80"),
                    (SIEMENS, "MCALL CYCLE81(10,0,2,-5)\nX5\nMCALL"),
                    (
                        KLARTEXT,
                        "CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=150 Q202=5 Q210=0 Q203=0 Q204=50 Q211=0\nL X+5 FMAX M99",
                    ),
                    (DIN, "G200 Q200=2 Q201=-5 Q206=150 Q202=5 Q210=0 Q203=0 Q204=50 Q211=0\nG0 X5 M99"),
                ],
            ),
            Row(
                "pecking",
                &[
                    (ISO, "G83 X5 Z-5 R1 Q2. F500\nG80"),
                    (SIEMENS, "CYCLE83(10,0,2,-5,,-2,,1,0,0,1,1)"),
                    (
                        KLARTEXT,
                        "CYCL DEF 1.0 PECKING\nCYCL DEF 1.1 SETUP 2\nCYCL DEF 1.2 DEPTH -10\nCYCL DEF 1.3 PECKG 5\nCYCL DEF 1.4 DWELL 0\nCYCL DEF 1.5 F100\nCYCL CALL",
                    ),
                ],
            ),
            Row(
                "chip breaking",
                &[
                    (
                        &[Dialect::Iso, Dialect::LinuxCnc, Dialect::Mach, Dialect::Okuma],
                        "G73 X5 Z-5 R1 Q2. F500\nG80",
                    ),
                    (SIEMENS, "CYCLE83(10,0,2,-5,,-2,,1,0,0,1,0)"),
                ],
            ),
            Row(
                "tapping",
                &[
                    (
                        &[Dialect::Iso, Dialect::LinuxCnc, Dialect::Mach, Dialect::Okuma],
                        "G84 X5 Z-5 R3 F500\nG80",
                    ),
                    (SIEMENS, "CYCLE84(10,0,2,-5,,0,3,,1)"),
                    (KLARTEXT, "CYCL DEF 207 RIGID TAPPING Q200=2 Q201=-5 Q239=1 Q203=0 Q204=50\nCYCL CALL"),
                ],
            ),
            Row(
                "boring",
                &[
                    (
                        &[Dialect::Iso, Dialect::LinuxCnc, Dialect::Mach, Dialect::Okuma],
                        "G85 X5 Z-5 R1 F500\nG80",
                    ),
                    (SIEMENS, "CYCLE85(10,0,2,-5,,0,100,200)"),
                    (
                        KLARTEXT,
                        "CYCL DEF 202 BORING Q200=2 Q201=-5 Q206=150 Q211=0 Q208=250 Q203=0 Q204=50 Q214=0\nCYCL CALL",
                    ),
                ],
            ),
            Row(
                "pocket, slot",
                &[
                    (SIEMENS, "POCKET3(10,0,1,-5,20,10,3,5,5,0,2)"),
                    (KLARTEXT, "CYCL DEF 251 RECTANGULAR POCKET\nCYCL CALL"),
                    (&[Dialect::Okuma], "FMIL"),
                ],
            ),
        ],
    ),
    (
        "Program flow",
        &[
            Row(
                "parameters",
                &[
                    (&[Dialect::Iso, Dialect::LinuxCnc, Dialect::Mach], "#1=5\nG1 X[#1*2]"),
                    (SIEMENS, "R1=5\nG1 X=R1*2"),
                    (KLARTEXT, "Q1 = 5\nL X+Q1 F500"),
                    (&[Dialect::Okuma], "VC1=5\nG1 X=VC1*2"),
                    (DIN, "D00 Q1 P01 +5\nG1 X+Q1"),
                ],
            ),
            Row(
                "condition",
                &[
                    (&[Dialect::Iso], "#1=1\nIF [#1 EQ 1] GOTO 10\nN10 G1 X5"),
                    (&[Dialect::LinuxCnc], "#1=1\no1 if [#1 EQ 1]\nG1 X5\no1 endif"),
                    (SIEMENS, "R1=1\nIF R1==1 GOTOF A\nA: G1 X5"),
                    (KLARTEXT, "Q1 = 1\nFN 9: IF +Q1 EQU +1 GOTO LBL 1\nLBL 1\nL X+5 F500"),
                    (&[Dialect::Okuma], "VC1=1\nIF [VC1 EQ 1] N10\nN10 G1 X5"),
                ],
            ),
            Row(
                "loop",
                &[
                    (&[Dialect::Iso], "#1=0\nWHILE [#1 LT 2] DO 1\n#1=#1+1\nEND 1"),
                    (&[Dialect::LinuxCnc], "o1 repeat [2]\nG91 G1 X1\no1 endrepeat"),
                    (SIEMENS, "FOR R1=1 TO 2\nG91 G1 X1\nENDFOR"),
                    (KLARTEXT, "LBL 1\nL IX+1 F500\nCALL LBL 1 REP 2"),
                    (DIN, "G98 L1\nG91 G1 X1\nL1,2"),
                ],
            ),
            Row(
                "subprogram",
                &[
                    (&[Dialect::Iso, Dialect::Mach], "M98 P9 L2\nM30\nO9\nG1 X5\nM99"),
                    (&[Dialect::LinuxCnc], "o9 sub\nG1 X5\no9 endsub\no9 call"),
                    (SIEMENS, "L9 P2\nM30\n%_N_L9_SPF\nG1 X5\nM17"),
                    (KLARTEXT, "CALL LBL 9\nM30\nLBL 9\nL X+5 F500\nLBL 0"),
                    (&[Dialect::Okuma], "CALL O9 Q2\nM30\nO9\nG1 X5\nRTS"),
                    (DIN, "L9,0\nM30\nG98 L9\nG1 X5\nG98 L0"),
                ],
            ),
            Row(
                "macro call",
                &[
                    (&[Dialect::Iso], "G65 P9 A1.\nM30\nO9\nG1 X#1\nM99"),
                    (&[Dialect::LinuxCnc], "o9 sub\nG1 X#1\no9 endsub\no9 call [5]"),
                    (SIEMENS, "HOLE(5)\nM30\n%_N_HOLE_SPF\nPROC HOLE(REAL A)\nG1 X=A\nRET"),
                ],
            ),
            Row("modal macro", &[(&[Dialect::Iso], "G66 P9 A1.\nG67")]),
            Row("number with exponent", &[(ALL_ISO, "G1 X1E1")]),
        ],
    ),
];

fn main() -> std::io::Result<()> {
    let text = page();
    std::fs::write(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/words.md"), &text)?;
    print!("{text}");
    Ok(())
}

/// The tables.
pub fn page() -> String {
    let mut text = HEAD.to_string();
    for (chapter, rows) in CHAPTERS {
        text += &format!("## {chapter}\n\n| word |");
        for (_, dialect, name) in Dialect::WORDS {
            let short = if dialect == Dialect::HeidenhainIso {
                "DIN"
            } else {
                name.split([' ', ',', '(']).next().unwrap_or(name)
            };
            text += &format!(" {short} |");
        }
        text += " example |\n|---|";
        text += &":-:|".repeat(Dialect::WORDS.len());
        text += "---|\n";
        for Row(word, examples) in *rows {
            text += &format!("| {word} |");
            for (_, dialect, _) in Dialect::WORDS {
                let example = examples.iter().find(|(dialects, _)| dialects.contains(&dialect));
                let sign = example.map_or(" ", |(_, snippet)| sign(dialect, snippet));
                text += &format!(" {sign} |");
            }
            let shown = examples
                .iter()
                .map(|(_, snippet)| format!("`{}`", snippet.lines().next().unwrap_or_default()));
            text += &format!(" {} |\n", shown.collect::<Vec<_>>().join(" "));
        }
        text += "\n";
    }
    text.trim_end().to_string() + "\n"
}

/// What becomes of `snippet` in a program of `dialect`.
fn sign(dialect: Dialect, snippet: &str) -> &'static str {
    let before = diagnostics(dialect, "");
    let found = diagnostics(dialect, snippet);
    let new: Vec<_> = found.iter().filter(|message| !before.contains(message)).collect();
    let is_unknown =
        |message: &&String| message.contains("not understood") || message.contains("in this file");
    match &new[..] {
        [] => "●",
        new if new.iter().any(is_unknown) => "–",
        _ => "○",
    }
}

fn diagnostics(dialect: Dialect, snippet: &str) -> Vec<String> {
    let program = match dialect {
        Dialect::Klartext => format!(
            "BEGIN PGM A MM\nTOOL DEF 1 L+0 R+1\nTOOL CALL 1 Z S3000 F500\nL X+0 Y+0 Z+10 R0 F500 M3\n{snippet}\nEND PGM A MM\n"
        ),
        Dialect::HeidenhainIso => {
            let lines: String = snippet.lines().map(|line| format!("{line} *\n")).collect();
            format!(
                "%A G71 *\nG99 T1 L+0 R+1 *\nT1 G17 S3000 F500 *\nG00 G40 G90 X+0 Y+0 Z+10 M3 *\nG01 F500 *\n{lines}N999 %A G71 *\n"
            )
        }
        Dialect::Siemens => format!("T1 M6 D1\nS3000 M3\nG0 X0 Y0 Z10\nG1 F500\n{snippet}\n"),
        Dialect::LinuxCnc | Dialect::Grbl => format!("T1 M6\nS3000 M3\nG0 X0 Y0 Z10\nG1 F500\n{snippet}\n"),
        _ => format!("%\nO1\nT1 M6\nS3000 M3\nG0 X0 Y0 Z10\nG1 F500.\n{snippet}\n%\n"),
    };
    let options = Options { dialect: Some(dialect), ..Options::default() };
    let mut machine = Machine::default();
    for axis in &mut machine.axes {
        axis.home = Some(0.0);
    }
    let toolpath = trace(&read_with(program.as_bytes(), &options), &machine);
    toolpath.diagnostics.into_iter().map(|diagnostic| diagnostic.message).collect()
}
