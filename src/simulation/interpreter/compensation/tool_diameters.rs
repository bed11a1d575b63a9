//! Diameters of tools from the program itself, for a machine without a table.
//!
//! ```text
//! G10 L12 P1 R5.                                      5 mm radius in the register D1
//! (T1 D=10. CR=0. - ZMIN=-5. - FLAT END MILL)         a header: D, DIA, DIAM or DIAMETER and a number,
//! (TOOL - 2 DIA. OFF. - 2 LEN. - 2 TOOL DIA. - .5)    in the unit of length in force where it is used
//! ```
//!
//! A diameter that the program sets takes precedence over the machine's table, and the table over comments. A
//! register without any of these (D21) gets the diameter of the tool in the spindle, if comments have it: shops
//! number registers as tools, or as tools plus 20, 30 or 50.
//!
//! Limit: a postprocessor that outputs the path of the tool centre uses G41 for wear alone. If the comment says so
//! (`WEAR COMP`), Truefeed ignores its diameter; otherwise the program does not show it, and a remark names the
//! setting.
//!
//! Sources: Fanuc B-63944EN, G10; headers of the postprocessors of Fusion, Mastercam and SolidCAM.

use crate::simulation::gcode::{Comment, LineNumber};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::compensation::{CompensationRemark, MAX_SIZE_MM};
use crate::simulation::toolpath::operations::tool_and_name;
use std::collections::BTreeMap;

/// Words for a diameter in a header, the longer ones first.
const NAMES: [&str; 9] = ["DIAMETER", "DIAM.", "DIAM", "DIA.", "DIA", "D=", "Ø", "ø", REGISTER];

/// The word for registers, which are whole numbers (`D01`), and for diameters, which have a point (`D12.0`).
const REGISTER: &str = "D";

/// Diameters by the number of their tool.
#[derive(Default)]
pub(crate) struct KnownDiameters {
    /// Diameters by G10 L12, mm.
    by_program: BTreeMap<u32, f64>,
    /// Diameters by comments, in the program's unit, with their lines.
    by_comments: BTreeMap<u32, (f64, LineNumber)>,
    /// `true` once a diameter was searched among those of comments.
    was_queried: bool,
}

impl KnownDiameters {
    /// Adds the diameters of further comments; the first one of a tool counts. Returns `false` if that is too
    /// late, because a diameter was searched before.
    pub(crate) fn add_comments(&mut self, comments: &[Comment]) -> bool {
        let mut is_in_time = true;
        for note in comments {
            let Some((tool, text)) = tool_and_name(&note.text) else { continue };
            if let Some(diameter) = diameter_in(text) {
                self.by_comments.entry(tool).or_insert((diameter, note.line));
                is_in_time = !self.was_queried;
            }
        }
        is_in_time
    }
}

impl Interpreter<'_> {
    /// Runs G10 L12, which sets the radius R of the cutter in the register P. Returns `false` if R is missing or
    /// too large.
    pub(crate) fn set_diameter(&mut self, register: u32) -> bool {
        let radius = self.given.get(b'R').map(|radius| radius * self.modal.unit);
        let Some(radius) = radius.filter(|radius| radius.abs() <= MAX_SIZE_MM) else { return false };
        self.compensation.known.by_program.insert(register, 2.0 * radius);
        true
    }

    /// Returns the diameter of a tool, mm: by G10, by the machine's table, or by a comment, which gets a remark;
    /// `None` if all are missing.
    pub(crate) fn known_diameter(&mut self, block: Block, tool: Option<u32>) -> Option<f64> {
        let by_program = tool.and_then(|tool| self.compensation.known.by_program.get(&tool)).copied();
        let by_machine = || Some(self.machine.tools.get(&tool?)?.diameter);
        if let Some(known) = by_program.or_else(by_machine) {
            return Some(known);
        }
        self.compensation.known.was_queried = true;
        let tools = [tool, self.canonical.tool().or(self.modal.tool)];
        let by_comment = |tool| Some((tool, *self.compensation.known.by_comments.get(&tool)?));
        let (tool, (diameter, line)) = tools.into_iter().flatten().find_map(by_comment)?;
        let diameter = diameter * self.modal.unit;
        if MAX_SIZE_MM < diameter {
            return None;
        }
        if self.compensation.remarked.insert(tool) {
            self.remarks.add(
                block.place(),
                TraceRemark::Contour(CompensationRemark::CommentDiameter { tool, diameter, line }),
            );
        }
        Some(diameter)
    }
}

/// Returns the diameter in the description of a tool.
fn diameter_in(text: &str) -> Option<f64> {
    let text = text.to_ascii_uppercase();
    if text.contains("WEAR COMP") {
        return None;
    }
    // No number follows `DIA. OFF.` directly, which names a register.
    NAMES.iter().find_map(|name| {
        text.match_indices(name).find_map(|(at, _)| {
            let is_word = !text[..at].ends_with(|c: char| c.is_alphanumeric());
            let rest = text[at + name.len()..].trim_start_matches([' ', ':', '=', '-']);
            let may_be_diameter = *name != REGISTER || has_point(rest);
            (is_word && may_be_diameter).then(|| positive_number(rest))?
        })
    })
}

fn has_point(text: &str) -> bool {
    text.trim_start_matches(|c: char| c.is_ascii_digit()).starts_with('.')
}

/// Returns the number above 0 that a text begins with.
fn positive_number(text: &str) -> Option<f64> {
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    text[..end].parse().ok().filter(|value: &f64| 0.0 < *value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_posts_tell_diameters() {
        for (text, diameter) in [
            ("D=10. CR=0. - ZMIN=-5. - FLAT END MILL", Some(10.0)),
            ("D=8.5 CR=0. TAPER=118DEG - ZMIN=-22. - DRILL", Some(8.5)),
            ("D=.25 CR=0. - ZMIN=-0.1 - flat end mill", Some(0.25)),
            ("1/2 FLAT ENDMILL | H1 | D1 | CONTROL COMP | TOOL DIA. - .5", Some(0.5)),
            ("1/4 FLAT ENDMILL | H2 | D2 | WEAR COMP | TOOL DIA. - .25", None),
            ("DIA. OFF. - 2 LEN. - 2 TOOL DIA. - .375", Some(0.375)),
            ("DIA. OFF. - 2 LEN. - 2", None),
            ("END MILL DIA 16.0 R0. MM", Some(16.0)),
            ("Ø12 VHM", Some(12.0)),
            ("12MM 3FL CARBIDE EM - H01 - D01 - D12.000MM", Some(12.0)),
            ("BALL D6 R3", None),
            ("MEDIA 5", None),
            ("NO. 7 DRILL | H3", None),
            ("D=0.", None),
        ] {
            assert_eq!(diameter_in(text), diameter, "{text}");
        }
    }
}
