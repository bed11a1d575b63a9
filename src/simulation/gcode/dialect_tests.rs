//! Short typical programs of each dialect.

use super::*;

#[track_caller]
fn check(dialect: Dialect, programs: &[&str]) {
    for program in programs {
        for end in ["\n", "\r\n"] {
            let text = program.replace('\n', end);
            assert_eq!(detect(text.as_bytes()), dialect, "{program}");
        }
        let found = detect(program.to_lowercase().as_bytes());
        assert_eq!(found, dialect, "in lower case: {program}");
    }
}

#[test]
fn iso() {
    check(
        Dialect::Iso,
        &[
            "",
            "G0 X0 Y0\nG1 X10 F100\nM30",
            "%\nO1234\nG21 G90\nT1 M6\nG43 H1 Z5.\nM30\n%",
            "%\nO0001 (OKUMA, HEIDENHAIN AND SIEMENS ARE NAMES)\nG0 X1.\nM30\n%",
            "(CALL OF THE DAY)\n(DEF REAL MEN)\nG0 X1\n(CYCLE81 IN A COMMENT)\n(L X+1 Y+1)\nG1 X2 F100\nM30",
            "; G64 P0.01 is for others\n; #<name> too\n; o<sub> call\nG0 X1\nM2",
            "#1=5\n#2=[#1+2]\nG0 X#1\nIF[#1GT3]GOTO10\nN10 M30",
            "WHILE[#1LT5]DO1\n#1=#1+1\nEND1\nM30",
            "O100\nG65 P9010 A1. B2.\nM98 P1000 L3\nM30\nO1000\nG0 X1.\nM99",
            "G90 G54 G0 X0 Y0\nG81 G98 Z-5. R1. F100\nX10.\nG80\nM30",
            "G187 P3 E0.01\nG103 P1\nG154 P2\nM97 P100\nM30\nN100 M99",
            "G05.1 Q1 R5\nG61.1\nG43.4 H1\nG54.1 P3\nM30",
            "G91 G28 Z0\nG90\nG53 X0\nG10 L2 P1 X1.\nM01\nM30",
            "(UNITS OF A NUM CONTROL)\nG71 G90\nG0 X1.\nM30",
            "G71 U2. R0.5\nG71 P10 Q20 U0.4 W0.1 F0.2\nM30",
            "G70 P10 Q20\nM30",
            "G81 G98 Z-5. R1. F100\nG71 X50. Y0. I10. J90. K-45. L3\nG80\nM30",
            ":1234\nN10G0X0Y0\nN20G1X10.F100.\nN30M30",
        ],
    );
}

#[test]
fn linuxcnc() {
    check(
        Dialect::LinuxCnc,
        &[
            "%\no100 sub\nG0 X#1\no100 endsub\no100 call [1]\n%",
            "o<hole> call [1] [2]\nM2",
            "#<depth> = 5\nG1 Z[-#<depth>] F100\nM2",
            "G21 G64 P0.01\nG0 X1\nM2",
            "G64P0.01 Q0.02\nG0 X1\nM2",
            "(debug,value is #1)\nG0 X1\nM2",
            "(print,hello)\nG0 X1\nM2",
            "#1=0\no101 while [#1 lt 5]\n#1=[#1+1]\no101 endwhile\nM2",
            "o1 if [#5 gt 2]\nG0 X1\no1 else\nG0 X2\no1 endif\nM2",
            "o1 repeat [5]\nG0 X1\no1 endrepeat\nM2",
            "G17 G21\nG1 @5 ^30 F100\nM2",
            "o<a> sub\no<a> return\no<a> endsub\nM2",
            "G0 X[#<_x> + 5]\nM2",
            "#<_vmajor>=1\nM2",
        ],
    );
}

#[test]
fn siemens() {
    check(
        Dialect::Siemens,
        &[
            "%_N_PART_MPF\n;$PATH=/_N_MPF_DIR\nG0 X1\nM30",
            "N10 G17 G90 G54 G71\nN20 CYCLE832(0.01,1)\nN30 M30",
            "DEF REAL DEPTH=5\nG1 Z=-DEPTH F100\nM30",
            "R1=5\nG1 X=R1\nM30",
            "MCALL CYCLE81(10,0,2,-5)\nX1 Y1\nMCALL\nM30",
            "T=\"MILL_10\"\nM6\nM30",
            "G0 SUPA Z0 D0\nM30",
            "TRANS X10\nROT RPL=30\nG0 X1\nM30",
            "G1 X1 RND=2\nG3 X5 CR=4\nM30",
            "WHILE R1<5\nR1=R1+1\nENDWHILE\nM30",
            "IF R1==5 GOTOF ENDE\nENDE:\nM30",
            "TRAORI\nG54 D1\nG1 X=AC(5) Y=IC(2)\nM30",
            "WORKPIECE(,\"\",,\"BOX\",112,0,-20,-80,0,0,100,100)\nM30",
            "PROC HOLE(REAL X)\nG0 X=X\nRET",
            "; FLANGE\nN10 G17 G90 G54 G71\nN20 T1 D1\nN30 M6\nN40 G0 X0 Y0 S3000 M3\nN50 G1 Z-1 F200\nN60 M30",
            "G710\nG1 X10 F100 ; a move\nM30",
        ],
    );
}

#[test]
fn klartext() {
    check(
        Dialect::Klartext,
        &[
            "0 BEGIN PGM TEST MM\n1 TOOL CALL 1 Z S1000\n2 L X+10 Y+5 R0 FMAX\n3 END PGM TEST MM",
            "BEGIN PGM A INCH\nL Z+100 R0 FMAX M91\nEND PGM A INCH",
            "1 L X+10 Y+5 F500\n2 CC X+0 Y+0\n3 C X+5 Y+5 DR+",
            "1 TOOL CALL 5 Z S5000\n2 L X+0 Y+0 FMAX M3",
            "5 CYCL DEF 200 DRILLING\n6 L X+10 Y+10 R0 FMAX M99",
            "LBL 1\nL IX+10 R0 F100\nLBL 0\nCALL LBL 1 REP 5",
            "FN 0: Q1 = +5\nL X+Q1 R0 F100",
            "BLK FORM 0.1 Z X+0 Y+0 Z-20\nBLK FORM 0.2 X+100 Y+100 Z+0",
            "APPR LT X+10 Y+10 LEN15 RL F100\nDEP LT LEN15",
            "CC X+50 Y+50\nLP PR+30 PA+45 R0 F500\nCP IPA+90 DR+",
            "CR X+10 Y+5 R+5 DR-\nCT X+20 Y+5",
            "TOOL DEF 3 L+0 R+5\nL X+1 R0 F5",
        ],
    );
}

#[test]
fn heidenhain_iso() {
    check(
        Dialect::HeidenhainIso,
        &[
            "%TEST G71 *\nN10 G00 G40 G90 Z+250 *\nN99999999 %TEST G71 *",
            "%PART G70 *\nG01 X+1 Y+1 F100 *",
            "N10 G00 X+10 Y+5 *\nN20 G01 Z-5 F100 *",
            "N10 G30 G17 X+0 Y+0 Z-40 *\nN20 G31 G90 X+100 Y+100 Z+0 *",
            "N10 G99 T1 L+0 R+5 *\nN20 T1 G17 S5000 *\nN30 G00 X+1 *",
            "N10 G98 L1 *\nN20 X+5 *\nN30 L1,5 *",
        ],
    );
}

#[test]
fn grbl() {
    check(
        Dialect::Grbl,
        &[
            "$H\nG21 G90\nG0 X1",
            "$X\nG0 X1",
            "$110=500\n$H\nG0 X1",
            "$J=G91 X10 F500",
            "(made for grbl 1.1)\nG0 X1\nM2",
            "; Grbl post processor\nG0 X1\nM2",
            "$G\n$#\nG0 X1",
            "G0 X1\n!\n~\nG0 X2",
            "G21\nG0 X1\n?\n",
            "$C\nG0 X1",
            "$$\n$I\nG0 X1",
            "$N0=G54\nG0 X1",
        ],
    );
}

#[test]
fn mach() {
    check(
        Dialect::Mach,
        &[
            "(Mach3 mill)\nG0 X1\nM30",
            "(POST: MACH4)\nG21\nM30",
            "; output for Mach3\nG0 X1\nM30",
            "%\n(Mach2/3 and Mach3)\nG0 X1\nM30",
            "G0 X1 (mach3)\nM47",
        ],
    );
}

#[test]
fn okuma() {
    check(
        Dialect::Okuma,
        &[
            "$TEST.MIN%\nG15 H1\nG0 X1.\nM2",
            "VC1=5\nG0 X=VC1\nM2",
            "CALL O1000 Q3\nM2\nO1000\nRTS",
            "G15 H1\nG56 H1 Z50.\nG0 X1.\nM2",
            "G71 Z20.\nG81 X1. Z-5. R2. F100 M53\nG80\nM2",
            "NOEX VC1=1\nM2",
            "MODIN O100\nG0 X1.\nMODOUT\nM2",
            "CALL OO88 PX=1 PY=2\nM2",
            "G16 H0 Z0\nG15 H2\nM2",
            "IF [VC1 EQ 2] N100\nVC2=3\nN100 M2",
            "VZOFX[1]=10\nG15 H1\nM2",
            "DEF WORK\nEND\nM2",
        ],
    );
}

/// Lines that are passed over would not have counted.
#[test]
fn a_bare_move_marks_no_dialect() {
    let words =
        ["X", "Y", "Z", "F", " ", ".", "-", "+", "0", "1", "3", "4", "5", "6", "2", "500", "331", "642"];
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    for _ in 0..50_000 {
        let mut line = String::new();
        for _ in 0..10 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            line += words[(state >> 33) as usize % words.len()];
        }
        let line = ["", "G0", "G1", "G01 "][(state >> 60) as usize % 4].to_string() + &line;
        assert!(is_bare_move(line.as_bytes()), "{line}");
        let marks = CODE_MARKS.iter().chain(&COMMENT_MARKS).filter(|mark| (mark.is_in)(line.as_bytes()));
        assert_eq!(marks.count(), 0, "{line}");
    }
    for line in ["G500", "G331 X1", "X1*", "R1=5", "X1 M47", "(MACH3)", "$H"] {
        assert!(!is_bare_move(line.as_bytes()), "{line}");
    }
}
