//! The order in which blocks are run: jumps, loops and calls, within bounds.
//!
//! Blocks run one after the other unless their flow says otherwise. A call keeps the block to return to; a
//! subprogram ends at its return, at the border of the next program in the text, or with the last block. This
//! module also reads M98, M99, M97 and G65, since they contain destinations:
//!
//! - `M98 P1000 L3` runs O1000 three times; without L, `P31000` has this meaning if there is no O31000. `M97 P10`
//!   runs from N10 on, and so does `M98 Q10`; `M98 P1000 Q10` runs O1000 from N10 on. `G65 P1000 A1. B2.` runs O1000
//!   with #1 = 1, #2 = 2. `M99` returns, `M99 P20` returns to N20.
//! - In the main program M99 ends it: the control would restart it.
//!
//! A program may loop for ever, and a short text may cause endless work. A program ends at a jump back if
//! everything that decides its further way equals that of the iteration before. It also ends if a loop runs
//! [`MAX_ITERATIONS_BY_MISSING`] iterations by an argument that was not given: a macro that runs on its own. In any
//! case at most [`MAX_REPEATED`] blocks run beyond those of the text, and calls nest to [`MAX_CALL_DEPTH`].
//!
//! Sources: Fanuc B-63944EN, ch. 13 and 16; LinuxCNC 2.9, O codes.

use crate::simulation::gcode::{
    Action, Destination, Dialect, Direction, Label, LabelKind, LineNumber, Program, SectionEnd, When, Word,
    whole_number,
};
use crate::simulation::interpreter::bounds::{MAX_CALL_DEPTH, MAX_COUNT, MAX_ITERATIONS_BY_MISSING};
use crate::simulation::interpreter::parameters::{Parameters, State, Values};
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::ordered::sort_by_number;
use std::collections::HashMap;
use std::ops::Range;

/// A subprogram being run; the first one is the main program.
struct Call {
    /// The block to return to.
    back: u32,
    /// Its first block, for the next repetition.
    first: u32,
    /// One past its last block, if the text does not end it.
    until: u32,
    /// Number of repetitions left.
    again: u32,
    has_own_parameters: bool,
    /// Number of jumps back left of each [`Action::Again`], by its block.
    counters: HashMap<u32, u32>,
    /// Number of the call, counted from the main program, which is 0.
    serial: u64,
}

/// Everything that decides the further way at a jump back.
#[derive(PartialEq, Eq)]
struct Situation {
    /// The call in force, by its serial number and the repetitions left.
    call: (u64, u32),
    counters: Vec<(u32, u32)>,
    parameters: State,
}

/// The last iteration of a loop, by its jump back.
struct Iteration {
    situation: Situation,
    /// Number of iterations in a row by a condition with a missing argument.
    by_missing: u32,
}

/// The position in a program.
pub(super) struct ProgramCounter<'a> {
    program: &'a Program,
    /// Index of the block that runs next; past the last one at the end.
    at: u32,
    /// Index of the first action that is not before `at`.
    flow: usize,
    calls: Vec<Call>,
    /// The borders between programs in the text.
    borders: Vec<u32>,
    /// Number of blocks that may run beyond once each.
    most_repeated: usize,
    /// Number of blocks that may still run.
    left: usize,
    /// For each block, `true` if it was run.
    was_run: Vec<bool>,
    iterations: HashMap<u32, Iteration>,
    /// The missing arguments of conditions, at their last computation, by their blocks.
    missing: HashMap<u32, String>,
    calls_made: u64,
    /// A count of the block being run that is not a whole number.
    uneven_count: Option<f64>,
}

/// The result of the flow of a block: a remark if it cannot be followed.
pub(super) type Outcome = Result<(), TraceRemark>;

impl<'a> ProgramCounter<'a> {
    pub(super) fn new(program: &'a Program, most_repeated: usize) -> ProgramCounter<'a> {
        let borders = program.flow.iter().filter(|flow| flow.action == Action::Border).map(|flow| flow.block);
        let main = Call {
            back: u32::MAX,
            first: 0,
            until: u32::MAX,
            again: 0,
            has_own_parameters: false,
            counters: HashMap::new(),
            serial: 0,
        };
        ProgramCounter {
            program,
            at: 0,
            flow: 0,
            calls: vec![main],
            borders: borders.collect(),
            most_repeated,
            left: program.blocks.len() + most_repeated,
            was_run: vec![false; program.blocks.len()],
            iterations: HashMap::new(),
            missing: HashMap::new(),
            calls_made: 0,
            uneven_count: None,
        }
    }

    /// Returns the block that runs now; `None` at the end of the program.
    pub(super) fn block(&mut self) -> Option<u32> {
        while 1 < self.calls.len() && self.calls.last().is_some_and(|call| self.at == call.until) {
            // A section has no parameters to remove.
            self.leave(None);
        }
        *self.was_run.get_mut(self.at as usize)? = true;
        Some(self.at)
    }

    /// Returns `true` if the current block has flow, so that its values are needed.
    pub(super) fn has_flow(&self) -> bool {
        self.program.flow.get(self.flow).is_some_and(|flow| flow.block == self.at)
    }

    /// Continues with the next block in the text.
    pub(super) fn step(&mut self) -> Outcome {
        self.left -= 1;
        self.at += 1;
        let most = self.most_repeated;
        if self.left == 0 { Err(self.stop(TraceRemark::EndlessRun { most })) } else { Ok(()) }
    }

    /// Continues with the next block and ignores the flow of this one.
    pub(super) fn pass(&mut self) {
        self.flow += self.program.flow[self.flow..].partition_point(|flow| flow.block <= self.at);
        self.at += 1;
    }

    /// Returns the words of a block with flow, without those of calls.
    pub(super) fn without_call(&self, words: &[Word]) -> Vec<Word> {
        let calls = words.iter().any(is_call);
        let is_macro = words.iter().any(|word| word.letter == b'G' && is_macro_call(word.value));
        let is_of_call = |word: &&Word| {
            is_macro || (calls && (is_call(word) || matches!(word.letter, b'P' | b'L' | b'Q')))
        };
        words.iter().filter(|word| !is_of_call(word)).copied().collect()
    }

    /// Returns the first line and the number of blocks behind block `index` in the text of its program that were
    /// not run; `None` if all were. Local subprograms (M97) are behind the end, and may have been run.
    pub(super) fn rest(&self, index: u32) -> Option<(LineNumber, usize)> {
        let next = self.borders.partition_point(|border| *border < index);
        let end = self.borders.get(next).map_or(self.program.blocks.len(), |border| *border as usize);
        let is_left = |index: &usize| !self.was_run[*index];
        let mut left = (index as usize..end).filter(is_left);
        let first = left.next()?;
        Some((self.program.blocks[first].line, 1 + left.count()))
    }

    /// Ends the program; returns the remark.
    fn stop(&mut self, why: TraceRemark) -> TraceRemark {
        self.at = u32::MAX;
        // There is no subprogram to return from.
        self.calls.truncate(1);
        why
    }

    /// Follows the flow of the block, after its words were run.
    pub(super) fn follow(&mut self, values: &Values, words: &[Word], parameters: &mut Parameters) -> Outcome {
        self.uneven_count = None;
        self.actions(values, words, parameters)?;
        self.uneven_count.map_or(Ok(()), |value| Err(TraceRemark::UnevenRepeats { value }))
    }

    /// Runs the actions of the block until one of them jumps.
    fn actions(&mut self, values: &Values, words: &[Word], parameters: &mut Parameters) -> Outcome {
        let program = self.program;
        let own = self.at;
        let flow = &program.flow[self.flow..];
        let count = flow.partition_point(|flow| flow.block == own);
        self.flow += count;
        self.step()?;
        for flow in &flow[..count] {
            self.action(own, &flow.action, values, words, parameters)?;
            if self.at != own + 1 {
                break;
            }
        }
        if self.at != own + 1 {
            self.flow = program.flow.partition_point(|flow| flow.block < self.at);
        }
        Ok(())
    }

    /// Runs one action of the block `own`.
    fn action(
        &mut self,
        own: u32,
        action: &Action,
        values: &Values,
        words: &[Word],
        parameters: &mut Parameters,
    ) -> Outcome {
        match action {
            Action::Jump { to, when } => {
                let condition = values.condition.unwrap_or(0.0) != 0.0;
                match &values.missing {
                    Some(parameter) => drop(self.missing.insert(own, parameter.clone())),
                    None => drop(self.missing.remove(&own)),
                }
                let is_made = match when {
                    When::Always => true,
                    When::True => condition,
                    When::False => !condition,
                };
                if is_made {
                    self.at = self.find(own, *to, values)?;
                    if self.at <= own {
                        self.check_iteration(own, parameters.state())?;
                    }
                }
            }
            Action::Repeat { end } => match self.count(values.count)? {
                0 => self.at = end.saturating_add(1),
                count => drop(self.counters().insert(*end, count - 1)),
            },
            Action::Again { to } => {
                let left = match self.counters().get(&own) {
                    Some(left) => *left,
                    None => self.count(values.count)?,
                };
                if left == 0 {
                    self.counters().remove(&own);
                } else {
                    self.counters().insert(own, left - 1);
                    self.at = self.find(own, *to, values)?;
                }
            }
            Action::Call { to, has_own_parameters } => {
                let first = self.find(own, *to, values)?;
                let times = if values.count.is_some() { self.count(values.count)? } else { 1 };
                if *has_own_parameters && 0 < times {
                    parameters.enter(&values.arguments);
                }
                self.enter(first, u32::MAX, times, *has_own_parameters)?;
            }
            Action::Section { from, until } => {
                let blocks = self.section(own, *from, *until)?;
                let times = if values.count.is_some() { self.count(values.count)? } else { 1 };
                self.enter(blocks.start, blocks.end, times, false)?;
            }
            Action::Return => self.leave(Some(parameters)),
            Action::SubprogramEnd if self.calls.len() == 1 => {}
            Action::SubprogramEnd => self.leave(Some(parameters)),
            Action::Border => {
                if self.calls.len() == 1 {
                    self.at = u32::MAX;
                } else {
                    self.leave(Some(parameters));
                }
            }
            Action::Words => self.words(own, words, parameters)?,
            Action::Alarm { text } => {
                let text = self.program.texts.get(*text as usize).cloned().unwrap_or_default();
                return Err(TraceRemark::NotRun { text });
            }
        }
        Ok(())
    }

    /// Checks at a jump back from the block `own` that the loop can end.
    fn check_iteration(&mut self, own: u32, parameters: State) -> Outcome {
        let call = self.calls.last().expect("the main program is a call");
        let mut counters: Vec<(u32, u32)> =
            call.counters.iter().map(|(block, left)| (*block, *left)).collect();
        sort_by_number(&mut counters, |(block, _)| f64::from(*block));
        let situation = Situation { call: (call.serial, call.again), counters, parameters };
        let parameter = self.missing.get(&own).or_else(|| self.missing.get(&self.at));
        let before = self.iterations.remove(&own);
        if before.as_ref().is_some_and(|iteration| iteration.situation == situation) {
            return Err(self.stop(TraceRemark::EndlessLoop));
        }
        let by_missing = match parameter {
            Some(_) => before.map_or(1, |iteration| iteration.by_missing + 1),
            None => 0,
        };
        if let (Some(parameter), MAX_ITERATIONS_BY_MISSING..) = (parameter, by_missing) {
            let parameter = parameter.clone();
            return Err(self.stop(TraceRemark::MissingArgument { parameter }));
        }
        self.iterations.insert(own, Iteration { situation, by_missing });
        Ok(())
    }

    /// Returns a count of repetitions; one that is not whole is rounded, and kept for a remark.
    fn count(&mut self, value: Option<f64>) -> Result<u32, TraceRemark> {
        let value = value.unwrap_or(0.0).max(0.0);
        if MAX_COUNT < value {
            return Err(TraceRemark::TooManyRepeats { value });
        }
        if whole_number(value).is_none() {
            self.uneven_count = Some(value);
        }
        Ok(value.round() as u32)
    }

    /// Returns the counters of the call in force.
    fn counters(&mut self) -> &mut HashMap<u32, u32> {
        &mut self.calls.last_mut().expect("the main program is a call").counters
    }

    /// Enters a subprogram or a section.
    fn enter(&mut self, first: u32, until: u32, times: u32, has_own_parameters: bool) -> Outcome {
        if times == 0 {
            return Ok(());
        }
        if self.calls.len() == MAX_CALL_DEPTH {
            return Err(self.stop(TraceRemark::DeepCall));
        }
        let (back, counters) = (self.at, HashMap::new());
        self.calls_made += 1;
        let serial = self.calls_made;
        self.calls.push(Call { back, first, until, again: times - 1, has_own_parameters, counters, serial });
        self.at = first;
        Ok(())
    }

    /// Leaves the subprogram, or repeats it; in the main program, ends the program.
    fn leave(&mut self, parameters: Option<&mut Parameters>) {
        let call = self.calls.last_mut().expect("the main program is a call");
        if 0 < call.again {
            call.again -= 1;
            call.counters.clear();
            self.at = call.first;
        } else if self.calls.len() == 1 {
            self.at = u32::MAX;
            return;
        } else if let Some(call) = self.calls.pop() {
            self.at = call.back;
            if let (true, Some(parameters)) = (call.has_own_parameters, parameters) {
                parameters.leave();
            }
        }
        self.flow = self.program.flow.partition_point(|flow| flow.block < self.at);
    }

    /// Runs M98, M99, M97, M198 and G65 to G67.
    fn words(&mut self, own: u32, words: &[Word], parameters: &mut Parameters) -> Outcome {
        let value = |letter: u8| words.iter().rfind(|word| word.letter == letter).map(|word| word.value);
        let code =
            |letter: u8, number: f64| words.iter().any(|word| word.letter == letter && word.value == number);
        let label = |kind, id| Destination::Label(Label { kind, id }, Direction::Either);
        let (target, repeats) = (value(b'P').and_then(whole_number), value(b'L'));
        if code(b'M', 99.0) {
            if self.calls.len() == 1 {
                return Err(self.stop(TraceRemark::BeginsAgain));
            }
            let back = target.filter(|_| 1 < self.calls.len());
            self.leave(Some(parameters));
            if let Some(id) = back {
                self.at = self.find(self.at, label(LabelKind::Sequence, id), &Values::default())?;
            }
            return Ok(());
        }
        if code(b'G', 66.0) || code(b'G', 66.1) {
            return Err(TraceRemark::ModalMacro);
        }
        let is_macro = code(b'G', 65.0);
        if !is_macro && !code(b'M', 98.0) && !code(b'M', 97.0) {
            return if code(b'M', 198.0) { Err(TraceRemark::ExternalProgram) } else { Ok(()) };
        }
        let sequence = value(b'Q').and_then(whole_number).filter(|_| code(b'M', 98.0));
        let sequence = sequence.map(|id| label(LabelKind::Sequence, id));
        if let (None, Some(local)) = (target, sequence) {
            let first = self.find(own, local, &Values::default())?;
            let times = if repeats.is_some() { self.count(repeats)? } else { 1 };
            return self.enter(first, u32::MAX, times, false);
        }
        let Some(target) = target else { return Err(TraceRemark::NoSubprogram) };
        let packed = code(b'M', 98.0)
            && repeats.is_none()
            && 9999 < target
            && !matches!(self.program.dialect, Dialect::LinuxCnc | Dialect::Mach)
            && !self.has_label(LabelKind::Program, target);
        let (target, packed_times) = if packed { (target % 10_000, target / 10_000) } else { (target, 1) };
        let times = if repeats.is_some() { self.count(repeats)? } else { packed_times };
        let to = if code(b'M', 97.0) {
            label(LabelKind::Sequence, target)
        } else if self.has_label(LabelKind::Program, target) {
            label(LabelKind::Program, target)
        } else {
            label(LabelKind::Numbered, target)
        };
        let mut first = self.find(own, to, &Values::default())?;
        if let Some(inside) = sequence {
            first = self.find(first, inside, &Values::default())?;
        }
        if is_macro && 0 < times {
            parameters.enter(&arguments(words));
        }
        self.enter(first, u32::MAX, times, is_macro)
    }

    /// Returns `true` if the program has this label.
    fn has_label(&self, kind: LabelKind, id: u32) -> bool {
        let label = Label { kind, id };
        self.program.labels.binary_search_by(|(known, _)| known.cmp(&label)).is_ok()
    }

    /// Returns the blocks of a section that the block `own` repeats. Labels are searched before it, the nearest
    /// first, and then after it, all in one program.
    fn section(&self, own: u32, from: Label, until: SectionEnd) -> Result<Range<u32>, TraceRemark> {
        let unit = |block: u32| self.borders.partition_point(|border| *border < block);
        let places = |label: Label| {
            let labels = &self.program.labels;
            let begin = labels.partition_point(|(known, _)| *known < label);
            let same = labels[begin..].iter().take_while(move |(known, _)| *known == label);
            same.map(|(_, block)| *block).filter(|block| unit(*block) == unit(own))
        };
        let before = places(from).filter(|block| *block <= own).last();
        let start = before.or_else(|| places(from).next()).ok_or_else(|| self.no_label(from))?;
        let past = |label: Label| places(label).find(|block| start <= *block).map(|block| block + 1);
        let end = match until {
            SectionEnd::Block => start + 1,
            SectionEnd::Label(label) => past(label).ok_or_else(|| self.no_label(label))?,
            SectionEnd::LabelOrHere(label) => {
                let is_needed = own < start;
                let found = past(label).filter(|end| is_needed || *end <= own);
                found.or((!is_needed).then_some(own)).ok_or_else(|| self.no_label(label))?
            }
        };
        Ok(start..end)
    }

    /// Returns the remark on a missing label.
    fn no_label(&self, label: Label) -> TraceRemark {
        let name = match label.kind {
            LabelKind::Named => self.program.names.get(label.id as usize).cloned().unwrap_or_default(),
            _ => label.id.to_string(),
        };
        TraceRemark::NoLabel { kind: label.kind, name }
    }

    /// Returns the block that a jump or call from the block `own` leads to.
    fn find(&mut self, own: u32, to: Destination, values: &Values) -> Result<u32, TraceRemark> {
        let (label, direction) = match to {
            Destination::Block(block) => return Ok(block),
            Destination::Label(label, direction) => (label, direction),
            Destination::Computed(kind) => {
                let id = values.destination.and_then(whole_number).ok_or(TraceRemark::NoLabel {
                    kind,
                    name: format!("{}", values.destination.unwrap_or_default()),
                })?;
                (Label { kind, id }, Direction::Either)
            }
        };
        let labels = &self.program.labels;
        let begin = labels.partition_point(|(known, _)| *known < label);
        let count = labels[begin..].partition_point(|(known, _)| *known == label);
        let same = &labels[begin..begin + count];
        let after = same.partition_point(|(_, block)| *block <= own);
        let (forward, backward) = (same.get(after), after.checked_sub(1).map(|index| same[index]));
        let unit = |block: u32| self.borders.partition_point(|border| *border < block);
        let is_within = |(_, block): &&(Label, u32)| unit(*block) == unit(own);
        let found = match direction {
            Direction::Forward => forward.copied(),
            Direction::Backward => backward,
            Direction::Either if label.kind == LabelKind::Sequence => forward
                .filter(is_within)
                .copied()
                .or_else(|| same[..after].iter().find(is_within).copied())
                .or(same.first().copied()),
            Direction::Either => forward.copied().or(same.first().copied()),
        };
        found.map(|(_, block)| block).ok_or_else(|| self.no_label(label))
    }
}

/// Returns the arguments of G65 by the numbers of their parameters: A in #1 and so on; of repeated I, J or K, the
/// further ones in #7, #8 and on.
fn arguments(words: &[Word]) -> Vec<(u32, f64)> {
    const BY_LETTER: [(u8, u32); 21] = [
        (b'A', 1),
        (b'B', 2),
        (b'C', 3),
        (b'I', 4),
        (b'J', 5),
        (b'K', 6),
        (b'D', 7),
        (b'E', 8),
        (b'F', 9),
        (b'H', 11),
        (b'M', 13),
        (b'Q', 17),
        (b'R', 18),
        (b'S', 19),
        (b'T', 20),
        (b'U', 21),
        (b'V', 22),
        (b'W', 23),
        (b'X', 24),
        (b'Y', 25),
        (b'Z', 26),
    ];
    let mut sets = [0; 3];
    let mut arguments = Vec::new();
    for word in words {
        let by_letter = BY_LETTER.iter().find(|(letter, _)| *letter == word.letter);
        let Some((letter, number)) = by_letter else { continue };
        let mut number = *number;
        if let b'I'..=b'K' = letter {
            let slot = usize::from(letter - b'I');
            number += 3 * sets[slot];
            sets[slot] += 1;
        }
        if number <= 33 {
            arguments.push((number, word.value));
        }
    }
    arguments
}

/// Returns `true` for M97, M98, M99 and M198.
fn is_call(word: &Word) -> bool {
    word.letter == b'M' && [97.0, 98.0, 99.0, 198.0].contains(&word.value)
}

/// Returns `true` for G65, G66 and G66.1, in whose blocks the other words are arguments.
fn is_macro_call(code: f64) -> bool {
    [65.0, 66.0, 66.1].contains(&code)
}

#[cfg(test)]
#[path = "program_counter_tests.rs"]
mod tests;
