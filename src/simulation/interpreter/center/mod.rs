//! The reference point of I, J and K of arcs: the start of the arc or the origin.
//!
//! G90.1 and G91.1 state it from their block on. Without them, most controls have a fixed rule. On the others the
//! reference point is a setting, and Truefeed infers it from the arcs: an arc that closes from only one of the two
//! points counts for that point, and the majority decides for the whole program, so that one damaged arc changes
//! nothing. Truefeed runs the program with incremental centres, and again with absolute ones if the arcs show those.

mod words;
mod arcs;

use crate::simulation::gcode::{ArcCenters, Dialect};

/// The rule for the centres of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CenterRule {
    /// By the rule of the control, by choice, or as the program states.
    Fixed,
    /// From the start of the arc, unless the arcs show something else.
    Open,
    /// From the origin, as the arcs show.
    Shown,
}

/// The rule, with the arcs that decide it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Centers {
    rule: CenterRule,
    /// Number of arcs that close only from their start, and only from the origin.
    decisive_arcs: [usize; 2],
}

impl Centers {
    /// Returns the state before the first arc of a program.
    pub(super) fn new(dialect: Dialect, chosen: Option<ArcCenters>) -> Centers {
        let is_open = chosen.is_none() && dialect.has_unknown_arc_centers();
        Centers { rule: if is_open { CenterRule::Open } else { CenterRule::Fixed }, decisive_arcs: [0; 2] }
    }

    /// Returns the state for the second run of a program.
    pub(super) fn absolute_by_arcs() -> Centers {
        Centers { rule: CenterRule::Shown, decisive_arcs: [0; 2] }
    }

    /// Returns `true` if centres are absolute before the program states anything.
    pub(super) fn are_absolute(&self) -> bool {
        self.rule == CenterRule::Shown
    }

    /// Returns `true` if the arcs of a whole run show that its centres are absolute.
    pub(super) fn show_absolute(&self) -> bool {
        let [from_start, from_origin] = self.decisive_arcs;
        from_start < from_origin
    }

    /// Keeps the rule from here on, since the program states the reference point itself.
    pub(super) fn fix(&mut self) {
        self.rule = CenterRule::Fixed;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::simulation::gcode::{Options, read_with};
    use crate::simulation::interpreter::trace_text;
    use crate::simulation::toolpath::Toolpath;

    /// Arcs of a contour, their centres from the origin or from the start, some of them with an end that does not fit.
    fn program(is_absolute: bool, damaged: usize) -> String {
        let mut text = "G0 X60. Y20.\nG1 F600.\n".to_string();
        let (mut x, mut y) = (60.0_f64, 20.0_f64);
        for index in 0..10 {
            let (cx, cy) = (50.0, 20.0);
            let angle = 0.5 * f64::from(index + 1);
            let (to_x, to_y) = (cx + 10.0 * angle.cos(), cy + 10.0 * angle.sin());
            let off = if (index as usize) < damaged { 3.0 } else { 0.0 };
            let (i, j) = if is_absolute { (cx, cy) } else { (cx - x, cy - y) };
            text += &format!("G3 X{to_x:.4} Y{to_y:.4} I{:.4} J{j:.4}\n", i + off);
            (x, y) = (to_x, to_y);
        }
        text
    }

    fn traced(text: &str, options: &Options) -> Toolpath {
        let toolpath = trace_text(text.as_bytes().to_vec(), options, &Machine::default());
        let whole =
            crate::simulation::interpreter::trace(&read_with(text.as_bytes(), options), &Machine::default());
        assert_eq!(toolpath, whole);
        toolpath
    }

    fn open_arcs(toolpath: &Toolpath) -> usize {
        toolpath
            .diagnostics
            .iter()
            .filter(|diagnostic| diagnostic.message.starts_with("arc has radius"))
            .count()
    }

    fn says_absolute(toolpath: &Toolpath) -> bool {
        toolpath.diagnostics.iter().any(|diagnostic| diagnostic.message.contains("absolute arc centres"))
    }

    #[test]
    fn arcs_show_what_their_centers_count_from() {
        let options = Options::default();
        let absolute = traced(&program(true, 0), &options);
        let incremental = traced(&program(false, 0), &options);
        assert_eq!((open_arcs(&absolute), open_arcs(&incremental)), (0, 0));
        assert!(says_absolute(&absolute) && !says_absolute(&incremental));
        let length =
            |toolpath: &Toolpath| toolpath.segments.iter().map(|segment| segment.length).sum::<f64>();
        assert!((length(&absolute) - length(&incremental)).abs() < 1e-3);
    }

    #[test]
    fn damaged_arcs_do_not_turn_a_program_over() {
        for is_absolute in [false, true] {
            for damaged in [1, 4] {
                let toolpath = traced(&program(is_absolute, damaged), &Options::default());
                assert_eq!((open_arcs(&toolpath), says_absolute(&toolpath)), (damaged, is_absolute));
            }
        }
        // Nothing closes: the usual reading, in doubt.
        let toolpath = traced(&program(false, 10), &Options::default());
        assert_eq!((open_arcs(&toolpath), says_absolute(&toolpath)), (10, false));
    }

    #[test]
    fn what_is_said_or_chosen_or_a_rule_of_the_control_holds() {
        let absolute = program(true, 0);
        let options = |dialect, arc_centers| Options { dialect, arc_centers, ..Options::default() };
        let chosen = options(None, Some(ArcCenters::Incremental));
        assert!(0 < open_arcs(&traced(&absolute, &chosen)));
        assert_eq!(
            open_arcs(&traced(&absolute, &options(Some(Dialect::Grbl), Some(ArcCenters::Absolute)))),
            0
        );
        assert!(0 < open_arcs(&traced(&absolute, &options(Some(Dialect::Grbl), None))));
        assert_eq!(open_arcs(&traced(&absolute, &options(Some(Dialect::Mach), None))), 0);
        assert!(0 < open_arcs(&traced(&format!("G91.1\n{absolute}"), &Options::default())));
        let said = traced(&format!("G90.1\n{absolute}"), &Options::default());
        assert_eq!((open_arcs(&said), says_absolute(&said)), (0, false));
    }
}
