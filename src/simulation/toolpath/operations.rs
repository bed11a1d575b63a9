//! Toolpath → operations: the parts in which a machinist sees a program.
//!
//! A new operation begins
//!
//! - at a tool change, even to the tool that is in the spindle already;
//! - at a heading: comments alone on their lines, at which the tool is free. It is free if the next move is a
//!   rapid, and the move before is a rapid as well or a machine function follows it. A heading directly
//!   before or after a tool change names the operation of the change.
//!
//! Moves after a heading without a cut, such as the way home, belong to the operation before. Moves before the
//! first change and the first cut belong to the first operation.
//!
//! If several comments precede a move, the last uninterrupted run of lines is the heading, and its first line with
//! a letter or a digit is the name. A comment that begins with a tool (`T5 D=10. FLAT END MILL`, `TOOL 5 - END
//! MILL`) names the tool, and so does a comment in the line of a change.
//!
//! Comments are found by line number. Where a program jumps back, it does not run the lines in between, and their
//! comments begin no operation; where it jumps ahead, the last heading before the destination counts.

use std::collections::BTreeMap;

use crate::simulation::gcode::{Comment, LineNumber};
use crate::simulation::toolpath::{Segment, Segments, Stop, StopCause};

/// Most operations of a program; the last one takes all the rest.
pub const MAX_OPERATIONS: usize = 500;

/// Most characters of the name of an operation or a tool.
const MAX_NAME_LENGTH: usize = 80;

/// A part of a program; it ends where the next one begins.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Operation {
    /// Index of its first segment; without segments, of the first segment after it.
    pub first_segment: usize,
    /// Index of its first stop; without stops, of the first stop after it.
    pub first_stop: usize,
    /// Line of the program that begins it.
    pub line: LineNumber,
    /// The tool in the spindle, if a T word names it.
    pub tool: Option<u32>,
    /// Name of the tool, from a comment.
    pub tool_name: Option<String>,
    /// Name of the operation, from its heading.
    pub name: Option<String>,
}

/// Returns the operations of a toolpath, and the number of further ones beyond [`MAX_OPERATIONS`]. `comments` are
/// by ascending line.
pub(crate) fn operations(
    segments: &Segments,
    stops: &[Stop],
    comments: &[Comment],
) -> (Vec<Operation>, usize) {
    let mut cutter = Cutter {
        headings: headings(comments),
        tool_names: tool_names(comments),
        beside: comments
            .iter()
            .filter(|note| !note.is_alone)
            .map(|note| (note.line, bare(&note.text)))
            .collect(),
        operations: vec![Operation::default()],
        beyond: 0,
        heading: None,
        is_free: true,
        has_change: false,
        has_feed: false,
        previous: LineNumber(0),
    };
    let mut stop = 0;
    let mut index = 0;
    while index < segments.len() {
        while let Some(next) = stops.get(stop).filter(|next| next.after <= index) {
            cutter.stop(next, index, stop);
            stop += 1;
        }
        cutter.segment(&segments.at(index), index, stop);
        index += 1;
        if cutter.headings.is_empty() {
            // Lines with one motion begin no operation, up to the next stop.
            let next_stop = stops.get(stop).map_or(segments.len(), |next| next.after);
            index = segments.plain_lines_end(index - 1).min(next_stop).max(index);
            cutter.previous = segments.at(index - 1).line;
        }
    }
    for (index, next) in stops.iter().enumerate().skip(stop) {
        cutter.stop(next, segments.len(), index);
    }
    if cutter.beyond == 0 {
        cutter.settle();
    }
    let first_line = segments.first().map(|s| s.line).into_iter().chain(stops.first().map(|s| s.line)).min();
    if let (LineNumber(0), Some(line)) = (cutter.operations[0].line, first_line) {
        cutter.operations[0].line = line;
    }
    let is_empty = segments.is_empty() && stops.is_empty();
    (if is_empty { Vec::new() } else { cutter.operations }, cutter.beyond)
}

/// A heading that waits for the move after it: its place and its text.
struct Heading<'a> {
    first_segment: usize,
    first_stop: usize,
    line: LineNumber,
    name: &'a str,
}

/// Cuts moves and stops into operations, in their order; the last operation is open.
struct Cutter<'a> {
    /// The headings of the program, by ascending line.
    headings: Vec<HeadingLines<'a>>,
    tool_names: BTreeMap<u32, &'a str>,
    /// Comments beside words, by ascending line.
    beside: Vec<(LineNumber, &'a str)>,
    operations: Vec<Operation>,
    beyond: usize,
    heading: Option<Heading<'a>>,
    /// `true` while the tool does not cut: at the beginning, after a rapid and after a machine function.
    is_free: bool,
    /// `true` if the open operation has a tool change.
    has_change: bool,
    /// `true` if the open operation has a feed move.
    has_feed: bool,
    /// Line of the last move or stop.
    previous: LineNumber,
}

impl<'a> Cutter<'a> {
    /// Keeps the last heading before this line as the one that waits.
    fn pass_to(&mut self, line: LineNumber, first_segment: usize, first_stop: usize) {
        if !self.headings.is_empty() && self.previous < line {
            let before = self.headings.partition_point(|heading| heading.last_line < line);
            let found = before.checked_sub(1).map(|index| self.headings[index]);
            if let Some(found) = found.filter(|found| self.previous < found.last_line) {
                let (line, name) = (found.name_line, found.name);
                self.heading = Some(Heading { first_segment, first_stop, line, name });
            }
        }
        self.previous = line;
    }

    fn stop(&mut self, stop: &Stop, segment: usize, index: usize) {
        let came_from = self.previous;
        self.pass_to(stop.line, segment, index);
        let tool = match stop.cause {
            StopCause::Dwell { .. } | StopCause::Rotary { .. } => return,
            StopCause::ToolChange { tool } => tool,
            StopCause::SameTool { tool } => Some(tool),
            StopCause::Spindle { .. } | StopCause::MCode { .. } => {
                self.is_free = true;
                return;
            }
        };
        self.is_free = true;
        let heading = self.heading.take().unwrap_or(Heading {
            first_segment: segment,
            first_stop: index,
            line: stop.line,
            name: "",
        });
        if self.has_change || self.has_begun(heading.first_segment) {
            self.begin(&heading);
        }
        if 0 < self.beyond {
            return;
        }
        let before = self.beside.partition_point(|(line, _)| *line <= stop.line);
        let beside = before.checked_sub(1).map(|index| self.beside[index]);
        let beside = beside.filter(|(line, _)| *line == stop.line || came_from < *line).map(|(_, name)| name);
        let tool_name = tool.and_then(|tool| self.tool_names.get(&tool).copied()).or(beside);
        self.has_change = true;
        let open = self.open();
        (open.tool, open.tool_name) = (tool, tool_name.filter(|name| !name.is_empty()).map(shortened));
        if open.line == LineNumber(0) || !heading.name.is_empty() {
            open.line = heading.line;
        }
        if !heading.name.is_empty() {
            open.name = Some(shortened(heading.name));
        }
    }

    fn segment(&mut self, segment: &Segment, index: usize, first_stop: usize) {
        self.pass_to(segment.line, index, first_stop);
        let is_rapid = segment.motion.is_rapid();
        if let Some(heading) = self.heading.take().filter(|_| is_rapid && self.is_free) {
            let is_next = self.has_begun(index);
            if is_next {
                self.begin(&heading);
            }
            if self.beyond == 0 && (is_next || !self.has_change || self.open().name.is_none()) {
                let has_change = self.has_change;
                let open = self.open();
                open.name = Some(shortened(heading.name));
                if !has_change {
                    open.line = heading.line;
                }
            }
        }
        self.is_free = is_rapid;
        self.has_feed |= !is_rapid;
    }

    /// Returns `true` if the open operation has moves. Moves before the first cut and change are only the way
    /// there.
    fn has_begun(&mut self, segment: usize) -> bool {
        let is_way_there = self.operations.len() == 1 && !self.has_change && !self.has_feed;
        self.open().first_segment < segment && !is_way_there
    }

    fn open(&mut self) -> &mut Operation {
        self.operations.last_mut().expect("there is always an open operation")
    }

    /// Gives the open operation to the one before if it has no cut, which is a way home.
    fn settle(&mut self) {
        if 1 < self.operations.len() && !self.has_change && !self.has_feed {
            self.operations.pop();
        }
    }

    /// Opens a new operation with the tool of the one before, unless there are [`MAX_OPERATIONS`] already.
    fn begin(&mut self, heading: &Heading) {
        self.settle();
        if self.operations.len() == MAX_OPERATIONS {
            self.beyond += 1;
            let open = self.open();
            (open.tool, open.tool_name, open.name) = (None, None, None);
            return;
        }
        (self.has_change, self.has_feed) = (false, false);
        let Operation { tool, tool_name, .. } = self.open();
        let next = Operation {
            first_segment: heading.first_segment,
            first_stop: heading.first_stop,
            line: heading.line,
            tool: *tool,
            tool_name: tool_name.clone(),
            name: None,
        };
        self.operations.push(next);
    }
}

/// An uninterrupted run of comments that name no tool.
#[derive(Clone, Copy)]
struct HeadingLines<'a> {
    last_line: LineNumber,
    name_line: LineNumber,
    name: &'a str,
}

/// Returns the headings among comments by ascending line.
fn headings(comments: &[Comment]) -> Vec<HeadingLines<'_>> {
    let mut headings: Vec<HeadingLines<'_>> = Vec::new();
    for note in comments.iter().filter(|note| note.is_alone && tool_and_name(&note.text).is_none()) {
        let text = bare(&note.text);
        match headings.last_mut() {
            _ if text.is_empty() => {}
            Some(open) if open.last_line.0 + 1 == note.line.0 => open.last_line = note.line,
            _ => headings.push(HeadingLines { last_line: note.line, name_line: note.line, name: text }),
        }
    }
    headings
}

/// Returns the names of tools from the comments that begin with a tool; the first comment on a tool counts.
fn tool_names(comments: &[Comment]) -> BTreeMap<u32, &str> {
    let mut names = BTreeMap::new();
    for note in comments {
        let mut found = tool_and_name(&note.text);
        while let Some((tool, rest)) = found {
            // One comment may list several tools: `T1 END MILL, T2 DRILL`.
            let next = |(comma, _): (usize, &str)| Some((comma, tool_and_name(&rest[comma..])?));
            let next = rest.match_indices([',', ';']).find_map(next);
            let name = bare(next.map_or(rest, |(comma, _)| &rest[..comma]));
            if !name.is_empty() {
                names.entry(tool).or_insert(name);
            }
            found = next.map(|(_, next)| next);
        }
    }
    names
}

/// Returns the number of the tool that a comment begins with, and the rest of the comment; `None` if it begins
/// with no tool.
pub(crate) fn tool_and_name(text: &str) -> Option<(u32, &str)> {
    let text = bare(text);
    let rest = ["TOOL", "T"].iter().find_map(|word| {
        let head = text.get(..word.len()).filter(|head| head.eq_ignore_ascii_case(word))?;
        Some(text[head.len()..].trim_start_matches([' ', '#', '=', ':', '-']))
    })?;
    let digits = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    let tool = rest[..digits].parse().ok()?;
    let is_word = !rest[digits..].starts_with(|c: char| c.is_alphanumeric());
    is_word.then(|| (tool, bare(&rest[digits..])))
}

/// Returns a text without the ornaments around it.
fn bare(text: &str) -> &str {
    text.trim_matches(|c: char| c.is_whitespace() || "-=*#_~|/:;,.<>+".contains(c))
}

/// Returns the first [`MAX_NAME_LENGTH`] characters of a name.
fn shortened(name: &str) -> String {
    name.chars().take(MAX_NAME_LENGTH).collect()
}
