//! Lines of Heidenhain DIN/ISO programs, each read into the equivalent statements of Klartext.
//!
//! ```text
//! %NAME G71 *                BEGIN PGM NAME MM          G98 L1         LBL 1
//! G00 X Y, G01 X Y F         L X Y FMAX, L X Y F        L1,3           CALL LBL 1 REP 3
//! G02, G03, G05 X Y          C X Y DR-, DR+             L1, L1,0       CALL LBL 1
//! … with R                   CR X Y R DR±               G200 Q200=2 …  CYCL DEF 200 Q200=2 …
//! I, J                       CC X Y                     G79            CYCL CALL
//! G06 X Y, G16 R H           CT X Y, CTP PR PA          G38            STOP
//! G10, G11 R H               LP PR PA FMAX, LP PR PA    G04 F1         CYCL DEF 9.1 1
//! G12, G13, G15 H            CP PA DR-, DR+             G62 T0.02      CYCL DEF 32.1 T0.02
//! G24 R, G25 R               CHF R, RND R               G54 X, G28 X   CYCL DEF 7.1 X, 8.1 X
//! G40, G41, G42              R0, RL, RR                 G73 H, G72 F   CYCL DEF 10.1 H, 11.1 F
//! T1 G17 S3000               TOOL CALL 1 Z S3000        D00 Q1 P01 5   FN 0: Q1 = 5
//! D09 P01 Q1 P02 0 P03 7     FN 9: IF Q1 EQU 0 GOTO LBL 7
//! ```
//!
//! A remark on a fault is on the whole line. Not read, with a remark: G26 and G27 (tangential approach), G83 to
//! G86 with P01 and on, touch probes.
//!
//! Source: TNC 640, DIN/ISO Programming, 2018.

mod sentence;

use crate::simulation::gcode::expression::{Notation, klartext_number};
use crate::simulation::gcode::klartext::KlartextStatement::{self, *};
use crate::simulation::gcode::klartext::functions::without_model;
use crate::simulation::gcode::klartext::heidenhain_iso::sentence::Sentence;
use crate::simulation::gcode::klartext::words::WITH_SETTINGS;
use crate::simulation::gcode::line::{Line, excerpt, semicolon};
use crate::simulation::gcode::number::number;
use crate::simulation::gcode::reader::{Reader, Refusal};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::{Action, Function, Operator, Reference, Step, Target, When, address};

/// The columns of a whole line.
const WHOLE_LINE_BOUNDS: (u32, u32) = (1, 1);

impl Reader<'_> {
    /// Reads one line of a Heidenhain DIN/ISO program.
    pub(in crate::simulation::gcode) fn heidenhain_iso_line(
        &mut self,
        text: &[u8],
        line: &mut Line,
    ) -> Result<(), Refusal> {
        let end = semicolon(text, 0);
        if end + 1 < text.len() {
            line.comment = Some((end + 1, text.len()));
        }
        let code = text[..end].trim_ascii();
        let code = code.strip_suffix(b"*").unwrap_or(code).trim_ascii_end();
        if code.is_empty() {
            return Ok(());
        }
        let [words, formulas, statements] =
            [self.program.words.len(), self.program.formulas.len(), self.program.statements.len()];
        let outcome = self.din_line(code);
        // Remarks are on the whole line.
        self.program.words.iter_mut().skip(words).for_each(|word| word.columns = WHOLE_LINE_BOUNDS.into());
        self.program
            .formulas
            .iter_mut()
            .skip(formulas)
            .for_each(|formula| formula.columns = WHOLE_LINE_BOUNDS);
        let statements = self.program.statements.iter_mut().skip(statements);
        statements.for_each(|statement| statement.columns = WHOLE_LINE_BOUNDS.into());
        outcome.map_err(|(remark, _)| (remark, WHOLE_LINE_BOUNDS))
    }

    /// Reads the code of a line.
    fn din_line(&mut self, code: &[u8]) -> Result<(), Refusal> {
        let line = &mut Line::default();
        let after_number = match code[0].to_ascii_uppercase() {
            b'N' => number(code, 1).map_or(1, |found| found.end),
            _ => 0,
        };
        let code = code.get(after_number..).unwrap_or_default().trim_ascii();
        let Some(first) = code.first() else { return Ok(()) };
        match first.to_ascii_uppercase() {
            b'%' => self.din_border(&code[1..], after_number == 0),
            b'Q' => self.klartext_parameter(code, 0, line)?,
            b'D' => self.din_function(code, line)?,
            b'L' => self.din_call(&code[1..], line)?,
            _ => match cycle_number(code) {
                Some((number, end)) => {
                    self.din(CycleDefinition { number, step: None });
                    self.klartext_cycle_parameters(code, end, line)?;
                }
                None => self.din_sentence(code, line)?,
            },
        }
        self.end_block();
        Ok(())
    }

    /// Adds a statement.
    fn din(&mut self, statement: KlartextStatement) {
        self.push_klartext(statement, WHOLE_LINE_BOUNDS);
    }

    /// Adds a word whose value is written as in Klartext.
    fn din_value(
        &mut self,
        letter: u8,
        value: &str,
        reference: Reference,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        let end = self.klartext_value(value.as_bytes(), (0, 0), letter, reference, line)?;
        self.klartext_ends(value.as_bytes(), end, line)
    }

    /// Begins a program at `%NAME G71`; with a block number before it, ends one.
    fn din_border(&mut self, header: &[u8], begins: bool) {
        if !begins {
            self.act(Action::Border);
            return;
        }
        let text = String::from_utf8_lossy(header).to_ascii_uppercase();
        let mut parts = text.split_whitespace();
        let name = parts.next().unwrap_or("A");
        self.begin_program(name.as_bytes(), parts.any(|part| part == "G70"), WHOLE_LINE_BOUNDS);
    }

    /// Reads `L1`, `L1,0` or `L1,3` without its L.
    fn din_call(&mut self, label: &[u8], line: &mut Line) -> Result<(), Refusal> {
        let text = String::from_utf8_lossy(label);
        let (label, times) = text.split_once([',', '.']).unwrap_or((&text, "0"));
        let (label, times) = (label.trim().as_bytes(), times.trim().as_bytes());
        let (to, end) = self.klartext_destination(label, 0, line)?;
        self.klartext_ends(label, end, line)?;
        if times == b"0" {
            self.act(Action::Call { to, has_own_parameters: false });
            return Ok(());
        }
        let end = self.klartext_count(times, 0, line)?;
        self.act(Action::Again { to });
        self.klartext_ends(times, end, line)
    }

    /// Reads the words of a line into statements.
    fn din_sentence(&mut self, code: &[u8], line: &mut Line) -> Result<(), Refusal> {
        let unread = |text| (Unread::Text { text }, WHOLE_LINE_BOUNDS);
        let sentence = Sentence::read(code).map_err(unread)?;
        let modal = &mut self.heidenhain.din;
        for code in &sentence.codes {
            match code {
                0..=3 | 5 | 6 | 10..=13 | 15 | 16 => modal.motion = *code,
                90 | 91 => modal.is_incremental = *code == 91,
                _ => {}
            }
        }
        if self.din_definition(&sentence, line)? {
            return Ok(());
        }
        if sentence.has(26) || sentence.has(27) {
            return Err(unread(excerpt(code)));
        }
        if sentence.has(38) {
            self.din(Stop);
            self.end_block();
        }
        self.din_tool_call(&sentence, line)?;
        self.din_pole(&sentence, line)?;
        if sentence.has(24) || sentence.has(25) {
            self.din_corner(&sentence, line)
        } else {
            self.din_path(&sentence, line)
        }
    }

    /// Reads a line that only defines something: a label, a tool, a cycle, the blank. Returns `false` if the line
    /// is none of these.
    fn din_definition(&mut self, sentence: &Sentence, line: &mut Line) -> Result<bool, Refusal> {
        if sentence.has(98) {
            self.klartext_label(sentence.given('L').unwrap_or_default().as_bytes(), 0, line)?;
        } else if sentence.has(99) {
            self.din(ToolDefinition);
            let tool = sentence.given('T').unwrap_or("0");
            if tool.starts_with('"') {
                return Ok(true);
            }
            let (length, radius) = (sentence.given('L').unwrap_or("+0"), sentence.given('R').unwrap_or("+0"));
            if !tool.is_empty() {
                self.din_value(address::DEFINED_TOOL, tool, Reference::Modal, line)?;
            }
            self.din_value(address::TOOL_LENGTH, length, Reference::Modal, line)?;
            self.din_value(address::TOOL_RADIUS, radius, Reference::Modal, line)?;
        } else if let Some((_, number, letter)) =
            SETTINGS.iter().find(|(code, ..)| sentence.has(*code)).copied()
        {
            self.din(CycleDefinition { number, step: Some(0) });
            self.end_block();
            let value = sentence.given(letter).unwrap_or_default();
            self.din(CycleDefinition { number, step: Some(u32::from(!value.is_empty())) });
            self.klartext_setting(value.as_bytes(), 0, line)?;
        } else if sentence.has(54) {
            self.din(CycleDefinition { number: 7, step: Some(1) });
            self.din_axes(sentence, b"XYZABC", line)?;
        } else if sentence.has(28) {
            self.din(CycleDefinition { number: 8, step: Some(1) });
            for word in sentence.words.iter().filter(|word| "XYZ".contains(word.letter)) {
                self.push_word(word.letter as u8, 1.0, WHOLE_LINE_BOUNDS);
            }
        } else if sentence.has(79) {
            self.din(CycleCall);
        } else {
            return Ok(sentence.has(30) || sentence.has(31));
        }
        Ok(true)
    }

    /// Adds the words of these axes.
    fn din_axes(&mut self, sentence: &Sentence, letters: &[u8], line: &mut Line) -> Result<(), Refusal> {
        let reference = self.heidenhain.din.reference();
        for letter in letters {
            if let Some(value) = sentence.given(char::from(*letter)) {
                self.din_value(*letter, value, reference, line)?;
            }
        }
        Ok(())
    }

    /// Adds F of the path; F beside a tool belongs to the tool.
    fn din_feed(&mut self, sentence: &Sentence, line: &mut Line) -> Result<(), Refusal> {
        match sentence.feed() {
            Some(feed) => self.din_value(b'F', feed, Reference::Modal, line),
            None => Ok(()),
        }
    }

    /// Reads T, which calls a tool.
    fn din_tool_call(&mut self, sentence: &Sentence, line: &mut Line) -> Result<(), Refusal> {
        let Some(tool) = sentence.given('T').filter(|_| !sentence.has(51)) else { return Ok(()) };
        self.din(ToolCall);
        let end = self.klartext_tool(tool.as_bytes(), 0, line)?;
        self.klartext_ends(tool.as_bytes(), end, line)?;
        let axis = if sentence.has(18) {
            1.0
        } else if sentence.has(19) {
            0.0
        } else {
            2.0
        };
        self.push_word(address::TOOL_AXIS, axis, WHOLE_LINE_BOUNDS);
        for letter in ['S', 'F'] {
            if let Some(value) = sentence.given(letter) {
                self.din_value(letter as u8, value, Reference::Modal, line)?;
            }
        }
        self.end_block();
        Ok(())
    }

    /// Reads I, J and K, which set the pole.
    fn din_pole(&mut self, sentence: &Sentence, line: &mut Line) -> Result<(), Refusal> {
        let reference = self.heidenhain.din.reference();
        let mut coordinates = [('I', b'X'), ('J', b'Y'), ('K', b'Z')]
            .into_iter()
            .filter_map(|(letter, axis)| Some((axis, sentence.given(letter)?)))
            .peekable();
        if coordinates.peek().is_none() {
            return Ok(());
        }
        self.din(CircleCenter);
        for (axis, value) in coordinates {
            self.din_value(axis, value, reference, line)?;
        }
        self.end_block();
        Ok(())
    }

    /// Reads a chamfer or a rounding; such a line has no path.
    fn din_corner(&mut self, sentence: &Sentence, line: &mut Line) -> Result<(), Refusal> {
        let size = sentence.given('R').unwrap_or_default();
        if sentence.has(24) {
            self.din(Chamfer);
            if !size.is_empty() {
                self.din_value(address::CHAMFER_LEG, size, Reference::Modal, line)?;
            }
        } else {
            self.din(Rounding);
            self.din_value(address::CIRCLE_RADIUS, size, Reference::Modal, line)?;
        }
        self.din_feed(sentence, line)
    }

    /// Reads the move of a line; without a path, its compensation, feedrate and M functions.
    fn din_path(&mut self, sentence: &Sentence, line: &mut Line) -> Result<(), Refusal> {
        let motion = self.heidenhain.din.motion;
        let side = [(41, 1.0), (42, -1.0), (40, 0.0)].into_iter().find(|(code, _)| sentence.has(*code));
        let has_axes = "XYZABC".chars().any(|axis| sentence.given(axis).is_some());
        let (radius, angle) = (sentence.given('R'), sentence.given('H'));
        let is_polar = matches!(motion, 10..=16) && (radius.is_some() || angle.is_some());
        let has_path = has_axes || is_polar;
        let has_functions = sentence.words.iter().any(|word| word.letter == 'M');
        if !(has_path || has_functions || side.is_some() || sentence.feed().is_some()) {
            return Ok(());
        }
        let statement = match motion {
            _ if !has_path => Line,
            2 | 3 | 5 if radius.is_some() => CircleByRadius,
            2 | 3 | 5 => Circle,
            6 => TangentialArc,
            10 | 11 => PolarLine,
            12 | 13 | 15 => PolarCircle,
            16 => PolarTangentialArc,
            _ => Line,
        };
        self.din(statement);
        if matches!(statement, PolarLine | PolarCircle | PolarTangentialArc) {
            if let Some(radius) = radius {
                self.din_value(address::POLAR_RADIUS, radius, Reference::Modal, line)?;
            }
            if let Some(angle) = angle {
                let reference = self.heidenhain.din.reference();
                self.din_value(address::POLAR_ANGLE, angle, reference, line)?;
            }
        }
        self.din_axes(sentence, b"XYZABC", line)?;
        if let (CircleByRadius, Some(radius)) = (statement, radius) {
            self.din_value(address::CIRCLE_RADIUS, radius, Reference::Modal, line)?;
        }
        let sense = match motion {
            2 | 12 => Some(-1.0),
            3 | 13 => Some(1.0),
            _ => None,
        };
        if let Some(sense) = sense.filter(|_| matches!(statement, Circle | CircleByRadius | PolarCircle)) {
            self.push_word(address::SENSE, sense, WHOLE_LINE_BOUNDS);
        }
        if let Some((_, side)) = side {
            self.push_word(address::SIDE, side, WHOLE_LINE_BOUNDS);
        }
        if has_path && matches!(motion, 0 | 10) {
            self.push_word(address::RAPID, 1.0, WHOLE_LINE_BOUNDS);
        } else {
            self.din_feed(sentence, line)?;
        }
        self.din_functions(sentence, line)
    }

    /// Adds the M functions.
    fn din_functions(&mut self, sentence: &Sentence, line: &mut Line) -> Result<(), Refusal> {
        for word in sentence.words.iter().filter(|word| word.letter == 'M') {
            self.din_value(b'M', &word.value, Reference::Modal, line)?;
            if self.program.words.last().is_some_and(|word| WITH_SETTINGS.contains(&word.value)) {
                break;
            }
        }
        Ok(())
    }

    /// Reads `D00 Q1 P01 +5`, `D01 Q1 P01 +Q2 P02 +3`, `D09 P01 +Q1 P02 +0 P03 5` and the like as the FN function
    /// with the same number.
    fn din_function(&mut self, code: &[u8], line: &mut Line) -> Result<(), Refusal> {
        let unread = || (Unread::Text { text: excerpt(code) }, WHOLE_LINE_BOUNDS);
        let text = String::from_utf8_lossy(code).to_ascii_uppercase();
        let mut parts = text[1..].split(" P0");
        let mut head = parts.next().unwrap_or_default().split_whitespace();
        let function = head.next().and_then(|number| number.parse::<u32>().ok()).ok_or_else(unread)?;
        let target = head.next();
        // Each part begins with the second digit of P01, P02 or P03.
        let operands: Option<Vec<&str>> = parts.map(|part| part.get(1..).map(str::trim)).collect();
        let operands = operands.as_deref();
        if let (9..=12, None, Some([left, right, label])) = (function, target, operands) {
            return self.din_jump(function, [left, right], label, line);
        }
        if let (Some(target), Some(operands)) = (target, operands) {
            if function == 18 && !operands.is_empty() {
                let number = parameter(target)?;
                let names = ["=ID", "NR", "IDX"].iter().zip(operands);
                let query: String = names.map(|(name, value)| format!("{name}{value}")).collect();
                return self.klartext_read(number, query.as_bytes(), WHOLE_LINE_BOUNDS, line);
            }
            if let Some(last) = operation(function).filter(|(_, count)| *count == operands.len()) {
                return self.din_assignment(target, operands, last.0, line);
            }
        }
        self.din(without_model(function).ok_or_else(unread)?);
        Ok(())
    }

    /// Assigns the result of an operation on its operands to a parameter.
    fn din_assignment(
        &mut self,
        target: &str,
        operands: &[&str],
        last: Option<Step>,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        if target.starts_with("QS") {
            self.din(Unmodelled("QS"));
            return Ok(());
        }
        let number = parameter(target)?;
        self.din_formula(Target::Numbered, Some(Step::Number(f64::from(number))), operands, last, line)
    }

    /// Jumps to a label if a comparison holds.
    fn din_jump(
        &mut self,
        function: u32,
        operands: [&str; 2],
        label: &str,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        if operands.iter().chain([&label]).any(|operand| operand.contains("QS")) {
            self.din(Unmodelled("IS UNDEFINED"));
            return Ok(());
        }
        let comparison = match function {
            9 => Operator::Equal,
            10 => Operator::NotEqual,
            11 => Operator::Greater,
            _ => Operator::Less,
        };
        self.din_formula(Target::Condition, None, &operands, Some(Step::Operator(comparison)), line)?;
        let (to, end) = self.klartext_destination(label.as_bytes(), 0, line)?;
        self.act(Action::Jump { to, when: When::True });
        self.klartext_ends(label.as_bytes(), end, line)
    }

    /// Adds a formula of operands between its first and its last step.
    fn din_formula(
        &mut self,
        target: Target,
        first: Option<Step>,
        operands: &[&str],
        last: Option<Step>,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        // A colon ends an operand, since no expression continues behind one.
        let text = operands.join(":");
        self.formula(Notation::Klartext, text.as_bytes(), (0, 0), line, |expressions| {
            expressions.steps.extend(first);
            for index in 0..operands.len() {
                if 0 < index {
                    expressions.expect(b':')?;
                }
                expressions.expression(0)?;
            }
            expressions.steps.extend(last);
            Ok(target)
        })
        .and_then(|(end, _)| self.klartext_ends(text.as_bytes(), end, line))
    }
}

/// G words that set one value of a cycle: the word, the cycle, and the letter of the value.
const SETTINGS: [(u32, u32, char); 4] = [(4, 9, 'F'), (62, 32, 'T'), (73, 10, 'H'), (72, 11, 'F')];

/// Returns the number of a Q parameter.
fn parameter(text: &str) -> Result<u32, Refusal> {
    let found = klartext_number(text.as_bytes()).filter(|(_, length)| *length == text.len());
    let expected = || Unread::Expected { expected: "a Q parameter", found: format!("`{text}`") };
    found.map(|(number, _)| number).ok_or_else(|| (expected(), WHOLE_LINE_BOUNDS))
}

/// Returns the last step of an FN function that assigns a value, and the number of its operands.
fn operation(function: u32) -> Option<(Option<Step>, usize)> {
    let of_one = |function| Some((Some(Step::Function(function)), 1));
    let of_two = |operator| Some((Some(Step::Operator(operator)), 2));
    match function {
        0 => Some((None, 1)),
        1 => of_two(Operator::Plus),
        2 => of_two(Operator::Minus),
        3 => of_two(Operator::Times),
        4 => of_two(Operator::Over),
        5 => of_one(Function::Sqrt),
        6 => of_one(Function::Sin),
        7 => of_one(Function::Cos),
        8 => of_two(Operator::Length),
        13 => of_two(Operator::Angle),
        _ => None,
    }
}

/// Returns the number of a cycle with parameters (`G200 Q200=2 …`), and its end; `None` if there is none.
fn cycle_number(code: &[u8]) -> Option<(u32, usize)> {
    let found = code[0].eq_ignore_ascii_case(&b'G').then(|| number(code, 1))??;
    let is_cycle = (200.0..=299.0).contains(&found.value) && found.value.fract() == 0.0;
    is_cycle.then_some((found.value as u32, found.end))
}
