//! Plain blocks, which nearly all blocks of a long program are: straight moves.
//!
//! ```text
//! block = { G word of the motion in force | X | Y | Z | F }      each axis, and F, at most once
//! ```
//!
//! While nothing in force affects a line (a turned frame, increments, a cycle, compensation, an exact stop), such
//! a block runs as by the rules for all blocks, but without tests for other words. A block that is out of reach or
//! has no length is left to those rules, which remark on it.

mod block;

/// The state for plain blocks.
#[derive(Clone, Copy)]
pub(crate) struct PlainBlockState {
    /// The number of the G word in force: 0 in rapid, 1 in feed.
    code: f64,
    /// Feedrate, mm/s; `None` in rapid.
    feedrate: Option<f64>,
    /// The value of F that changes nothing and gets no remark.
    same_feed: Option<f64>,
}

#[cfg(test)]
mod tests {
    use crate::machine::Machine;
    use crate::simulation::gcode::{Dialect, Options, read_with};
    use crate::simulation::interpreter::trace;
    use crate::simulation::toolpath::Toolpath;
    use crate::simulation::toolpath::random::Random;

    fn traced(text: &str, dialect: Dialect) -> Toolpath {
        let options = Options { dialect: Some(dialect), ..Options::default() };
        trace(&read_with(text.as_bytes(), &options), &Machine::default())
    }

    /// Lines of moves, and of whatever touches the moves that follow.
    fn random_line(random: &mut Random) -> String {
        const OTHERS: [&str; 40] = [
            "G0",
            "G1",
            "G2",
            "G90",
            "G91",
            "G20",
            "G21",
            "G93",
            "G94",
            "G95",
            "G9",
            "G61",
            "G64",
            "G16",
            "G15",
            "G68 X1 Y2 R30",
            "G69",
            "G51 X0 Y0 P2",
            "G50",
            "G81 Z-1 R1",
            "G80",
            "G41 D1",
            "G40",
            "G53",
            "G92 X1",
            "G92.1",
            "A5",
            "I1 J0",
            "R3",
            "G4 P1",
            "S100 M3",
            "G54",
            "G55",
            "G10 L2 P1 X1",
            "G28",
            ",R0.5",
            "X1 X2",
            "F0",
            "G1 X99999999",
            "T1 M6",
        ];
        let mut line = String::new();
        for _ in 0..random.below(5) {
            let number = random.below(20_001) as f64 / 100.0 - 100.0;
            match random.below(8) {
                0 => line += ["G0", "G1"][random.below(2)],
                1..=5 => line += &format!("{}{number}", ["X", "Y", "Z"][random.below(3)]),
                6 => line += &format!("F{}", 500 * random.below(40)),
                _ if random.below(3) == 0 => line += OTHERS[random.below(OTHERS.len())],
                _ => {}
            }
            line += " ";
        }
        line
    }

    /// G97 asks for nothing here, but is no word of a plain block. A line of blanks is none, and stays none: doubts are dated
    /// by blocks.
    #[test]
    fn plain_blocks_are_run_as_all_blocks_are() {
        let mut random = Random(0x9e37);
        let mut moves = 0;
        for dialect in [Dialect::Iso, Dialect::LinuxCnc, Dialect::Okuma, Dialect::Siemens, Dialect::Mach] {
            for _ in 0..1000 {
                let lines: Vec<String> = (0..30).map(|_| random_line(&mut random)).collect();
                let ended = |line: &str, end: &str| match line.trim() {
                    "" => "\n".to_string(),
                    _ => format!("{line}{end}\n"),
                };
                let text = |end: &str| lines.iter().map(|line| ended(line, end)).collect::<String>();
                let (plain, all) = (traced(&text(""), dialect), traced(&text("G97"), dialect));
                assert_eq!(plain, all, "{dialect:?}\n{}", text(""));
                moves += plain.segments.len();
            }
        }
        assert!(20_000 < moves, "{moves} moves");
    }
}
