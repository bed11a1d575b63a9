//! Expressions → postfix steps.
//!
//! ```text
//! assignment = "#" place "=" expression
//! expression = value { operator value }
//! value      = number  |  [ "+" | "-" ] ( "#" place | bracket | function )
//! place      = "<" name ">"  |  value
//! bracket    = "[" expression "]"
//! function   = "ATAN" bracket "/" bracket  |  name bracket
//! ```
//!
//! Operators bind in this order, the tightest first, and from left to right within a row, as on LinuxCNC: `**`;
//! `*` `/` `MOD`; `+` `-`; `EQ` `NE` `GT` `GE` `LT` `LE`; `AND` `OR` `XOR`. A sign belongs to its value: `-2**2`
//! is 4. `ATAN[y]` without `/[x]` is the arctangent of one value, as on Fanuc controls. White space is ignored,
//! even within the name of a parameter, and so is the difference of upper and lower case.
//!
//! Siemens and Klartext use other signs: round brackets, other operators, and parameters without `#` (`R1`,
//! `R[R2]`, names; `Q1`). In Klartext a function needs no brackets around its value (`SIN Q1`). `EXISTS[#<name>]`
//! is 1 if the parameter has a value. `POW[a,b]` and Siemens' `ATAN2(y,x)`, `MINVAL(a,b)` and `MAXVAL(a,b)` take
//! two values, `BOUND(least,greatest,a)` three. Fanuc controls accept the first two letters of a function.
//!
//! In Siemens programs a text (`"ROUGH"`) is a value too: a number beyond all others, which programs can only
//! assign and compare by `==` and `<>`.
//!
//! A fault ends the reading of its block. Brackets and `#` nest to a bounded depth, so that no text exhausts the
//! stack, and the parser reads every byte a bounded number of times.

use crate::simulation::gcode::formula::{
    FUNCTIONS, Function, KLARTEXT_OPERATORS, MAX_NESTING, OPERATORS, Operator, OperatorRow,
    SIEMENS_OPERATORS, Step,
};
use crate::simulation::gcode::line::{character_length, continuation, excerpt};
use crate::simulation::gcode::number::{is_blank, number, skip_blanks};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::ordered::sort_by_number;
use std::collections::HashMap;

/// First number of a text, beyond those of parameters.
const FIRST_TEXT_NUMBER: f64 = 5e9;

/// Longest name of a parameter, bytes.
const MAX_NAME_LENGTH: usize = 100;

/// The notation of expressions in a family of dialects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Notation {
    /// `[#1+2]`.
    Iso,
    /// `(R1+2)`.
    Siemens,
    /// `( Q1 + 2 )`.
    Klartext,
    /// `[VC1+2]`.
    Okuma,
}

impl Notation {
    fn brackets(self) -> (u8, u8) {
        if matches!(self, Notation::Iso | Notation::Okuma) { (b'[', b']') } else { (b'(', b')') }
    }

    fn operators(self) -> &'static [OperatorRow] {
        match self {
            Notation::Iso | Notation::Okuma => OPERATORS,
            Notation::Siemens => SIEMENS_OPERATORS,
            Notation::Klartext => KLARTEXT_OPERATORS,
        }
    }
}

/// A fault, and the bytes with it.
pub(super) type Fault = (Unread, std::ops::Range<usize>);

/// The named parameters of a program, each once.
#[derive(Debug, Default)]
pub(super) struct Names {
    indices: HashMap<String, u32>,
    /// The names that the program being read defines, by their spelling.
    own: HashMap<String, u32>,
    /// Number of programs in the text before this one.
    programs: u32,
}

impl Names {
    /// Returns the index of a name.
    pub(super) fn index(&mut self, name: String) -> u32 {
        if let Some(index) = self.own.get(&name) {
            return *index;
        }
        let next = self.indices.len() as u32;
        *self.indices.entry(name).or_insert(next)
    }

    /// Returns the step that puts the number of a text on the stack.
    pub(super) fn of_text(&mut self, text: &[u8]) -> Step {
        // No parameter has a name with a quotation mark.
        Step::Number(
            FIRST_TEXT_NUMBER + f64::from(self.index(format!("\"{}", String::from_utf8_lossy(text)))),
        )
    }

    /// Defines a name for the program being read, from here on to its end, and returns its index.
    pub(super) fn define(&mut self, name: String) -> u32 {
        if self.programs == 0 {
            let index = self.index(name.clone());
            self.own.insert(name, index);
            return index;
        }
        let next = self.indices.len() as u32;
        let index = *self.indices.entry(format!("{name}@{}", self.programs)).or_insert(next);
        self.own.insert(name, index);
        index
    }

    /// Returns `true` if the program being read defines this name.
    pub(super) fn is_defined(&self, name: &str) -> bool {
        self.own.contains_key(name)
    }

    /// Begins another program of the text.
    pub(super) fn next_program(&mut self) {
        self.own.clear();
        self.programs += 1;
    }

    /// Returns the names in order of their index.
    pub(super) fn finish(self) -> Vec<String> {
        let mut names: Vec<_> = self.indices.into_iter().collect();
        sort_by_number(&mut names, |(_, index)| *index as f64);
        names.into_iter().map(|(name, _)| name).collect()
    }
}

/// A parameter to which a value is assigned, or that is read.
pub(super) enum Place {
    /// The steps before leave its number.
    Numbered,
    /// The index of its name.
    Named(u32),
}

/// A parser of the expressions in a line, one after the other.
pub(super) struct Expressions<'a> {
    pub(super) text: &'a [u8],
    /// Index of the next byte.
    pub(super) at: usize,
    pub(super) steps: &'a mut Vec<Step>,
    pub(super) names: &'a mut Names,
    notation: Notation,
    depth: usize,
    /// Bytes read so far that continue a character of several bytes.
    pub(super) continuation: usize,
}

impl<'a> Expressions<'a> {
    pub(super) fn new(
        notation: Notation,
        text: &'a [u8],
        at: usize,
        steps: &'a mut Vec<Step>,
        names: &'a mut Names,
    ) -> Expressions<'a> {
        Expressions { text, at, steps, names, notation, depth: 0, continuation: 0 }
    }

    /// Returns `true` if an ISO value that is more than a number begins at `at`.
    pub(super) fn begin_at(text: &[u8], at: usize) -> bool {
        let at = skip_blanks(text, at);
        let is_signed = matches!(text.get(at), Some(b'+' | b'-'));
        let at = skip_blanks(text, at + usize::from(is_signed));
        let is_function = || {
            let found = FUNCTIONS.iter().find_map(|(name, _)| after(text, at, name));
            let of_two = ["POW", "EXISTS"].iter().find_map(|name| after(text, at, name));
            let end = found.or(of_two);
            end.is_some_and(|end| text.get(skip_blanks(text, end)) == Some(&b'['))
        };
        match text.get(at) {
            Some(b'#' | b'[') => true,
            Some(byte) => byte.is_ascii_alphabetic() && is_function(),
            None => false,
        }
    }

    /// Reads `#…=…`; the steps leave the number of the parameter, if it has one, and its value.
    ///
    /// # Errors
    ///
    /// This method and those below fail at a text that is not of their form.
    pub(super) fn assignment(&mut self) -> Result<Place, Fault> {
        self.at += 1;
        let place = self.place()?;
        self.expect(b'=')?;
        self.expression(0)?;
        Ok(place)
    }

    /// Reads one value.
    pub(super) fn value(&mut self) -> Result<(), Fault> {
        self.at = skip_blanks(self.text, self.at);
        if let Some(found) = number(self.text, self.at) {
            if !found.value.is_finite() {
                let text = excerpt(&self.text[self.at..found.end]);
                return Err((Unread::HugeValue { text }, self.at..found.end));
            }
            self.steps.push(Step::Number(found.value));
            self.at = found.end;
            return Ok(());
        }
        let is_negative = self.text.get(self.at) == Some(&b'-');
        if is_negative || self.text.get(self.at) == Some(&b'+') {
            self.at = skip_blanks(self.text, self.at + 1);
        }
        match self.text.get(self.at) {
            Some(b'#') => {
                self.at += 1;
                match self.place()? {
                    Place::Numbered => self.steps.push(Step::Numbered),
                    Place::Named(name) => self.steps.push(Step::Named(name)),
                }
            }
            Some(b'"') if self.notation == Notation::Siemens => self.text_value()?,
            Some(byte) if *byte == self.notation.brackets().0 => self.bracket()?,
            Some(byte) if byte.is_ascii_alphabetic() || matches!(byte, b'_' | b'$') => {
                if !self.variable()? {
                    self.function()?;
                }
            }
            _ => return Err(self.missing("a value")),
        }
        if is_negative {
            self.steps.push(Step::Negate);
        }
        Ok(())
    }

    /// Reads values joined by operators that bind at least as tightly as `tightness`.
    pub(super) fn expression(&mut self, tightness: u8) -> Result<(), Fault> {
        self.value()?;
        while let Some((end, own, operator)) = self.operator()
            && tightness <= own
        {
            let (before, has_text) = (self.at, self.ends_with_text());
            self.at = end;
            self.expression(own + 1)?;
            if (has_text || self.ends_with_text())
                && !matches!(operator, Operator::Equal | Operator::NotEqual)
            {
                self.at = skip_blanks(self.text, before);
                return Err(self.missing("`==` or `<>` beside a text"));
            }
            self.steps.push(Step::Operator(operator));
        }
        Ok(())
    }

    fn ends_with_text(&self) -> bool {
        matches!(self.steps.last(), Some(Step::Number(value)) if FIRST_TEXT_NUMBER <= *value)
    }

    /// Reads a text such as `"ROUGH"`; the steps leave its number.
    fn text_value(&mut self) -> Result<(), Fault> {
        let start = self.at + 1;
        let Some(length) = self.text[start..].iter().position(|byte| *byte == b'"') else {
            self.at = self.text.len();
            return Err(self.missing("`\"`"));
        };
        let text = &self.text[start..start + length];
        self.continuation += continuation(text);
        let number = self.names.of_text(text);
        self.steps.push(number);
        self.at = start + length + 1;
        Ok(())
    }

    /// Returns the next operator: its end, how tightly it binds, and itself; `None` if no operator follows.
    fn operator(&self) -> Option<(usize, u8, Operator)> {
        let at = skip_blanks(self.text, self.at);
        let found = |(name, tightness, operator): &(&str, u8, Operator)| {
            let end = after(self.text, at, name)?;
            // `OR` is not the beginning of `ORIWKS`.
            let is_whole = self.notation == Notation::Iso
                || !name.ends_with(|last: char| last.is_ascii_alphabetic())
                || identifier(&self.text[end..]) == 0;
            is_whole.then_some((end, *tightness, *operator))
        };
        self.notation.operators().iter().find_map(found)
    }

    fn bracket(&mut self) -> Result<(), Fault> {
        let (open, close) = self.notation.brackets();
        self.expect(open)?;
        self.nested(|inner| inner.expression(0))?;
        self.expect(close)
    }

    /// Reads a parameter without `#`; returns `false` if none follows.
    fn variable(&mut self) -> Result<bool, Fault> {
        let letters = identifier(&self.text[self.at..]);
        let name = &self.text[self.at..self.at + letters];
        let prefix = match self.notation {
            Notation::Iso => return Ok(false),
            Notation::Siemens => b'R',
            Notation::Klartext => return self.klartext_variable(letters),
            Notation::Okuma => return Ok(self.okuma_variable(letters)),
        };
        let digits = name[1..].iter().all(u8::is_ascii_digit);
        if name[0].eq_ignore_ascii_case(&prefix) && digits {
            self.at += 1;
            let is_indexed = letters == 1 && self.text.get(self.at) == Some(&b'[');
            if letters == 1 && !is_indexed {
                return Err(self.missing("the number of a parameter"));
            }
            if is_indexed {
                self.at += 1;
                self.nested(|inner| inner.expression(0))?;
                self.expect(b']')?;
            } else {
                let found =
                    number(&self.text[..self.at + letters - 1], self.at).map_or(0.0, |found| found.value);
                self.steps.push(Step::Number(found));
                self.at += letters - 1;
            }
            self.steps.push(Step::Numbered);
            return Ok(true);
        }
        let is_function = FUNCTIONS.iter().any(|(known, _)| name.eq_ignore_ascii_case(known.as_bytes()));
        if is_function || of_several(name).is_some() {
            return Ok(false);
        }
        let is_system = name[0] == b'$';
        if !is_system && self.text.get(self.at + letters) == Some(&b'[') {
            let name = name.to_vec();
            self.at += letters;
            self.nested(|inner| inner.element(&name))?;
            self.steps.push(Step::Numbered);
            return Ok(true);
        }
        let end = self.at + letters + index_of_array(&self.text[self.at + letters..], is_system);
        let name = String::from_utf8_lossy(&self.text[self.at..end]).to_ascii_lowercase();
        self.at = end;
        let index = self.names.index(name);
        self.steps.push(Step::Named(index));
        Ok(true)
    }

    /// Reads `Q1`, `QL1` or `QR1`; returns `false` if none follows. A text (`QS1`) has no value.
    fn klartext_variable(&mut self, letters: usize) -> Result<bool, Fault> {
        let name = &self.text[self.at..self.at + letters];
        let Some((number, length)) = klartext_number(name) else { return Ok(false) };
        self.steps.extend([Step::Number(f64::from(number)), Step::Numbered]);
        self.at += length;
        Ok(true)
    }

    /// Reads `VC1`, `V1`, a name of the program or one of the control (`VZOFZ[1]`); returns `false` for a
    /// function.
    fn okuma_variable(&mut self, letters: usize) -> bool {
        let letters = letters + index_of_array(&self.text[self.at + letters..], true);
        let name = &self.text[self.at..self.at + letters];
        if FUNCTIONS.iter().any(|(known, _)| name.eq_ignore_ascii_case(known.as_bytes())) {
            return false;
        }
        if let Some(number) = okuma_number(name) {
            self.steps.extend([Step::Number(f64::from(number)), Step::Numbered]);
        } else {
            let index = self.names.index(String::from_utf8_lossy(name).to_ascii_lowercase());
            self.steps.push(Step::Named(index));
        }
        self.at += letters;
        true
    }

    /// Reads a function with its values.
    fn function(&mut self) -> Result<(), Fault> {
        let start = self.at;
        let letters = identifier(&self.text[start..]);
        let name = &self.text[start..start + letters];
        if name.eq_ignore_ascii_case(b"EXISTS") {
            return self.exists();
        }
        if let Some(operators) = of_several(name) {
            self.at = start + letters;
            return self.joined_values(operators);
        }
        if self.notation == Notation::Klartext && name.eq_ignore_ascii_case(b"PI") {
            self.at = start + letters;
            self.steps.push(Step::Number(std::f64::consts::PI));
            return Ok(());
        }
        // `ROUNDUP` begins with `ROUND`.
        let found = FUNCTIONS
            .iter()
            .filter_map(|(name, function)| after(self.text, start, name).map(|end| (end, *function)))
            .max_by_key(|(end, _)| *end)
            .or_else(|| Some((start + 2, function_by_two_letters(name)?)));
        let Some((end, function)) = found else {
            let letters = self.text[start..].iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
            let text = excerpt(&self.text[start..start + letters]);
            return Err((Unread::Function { text }, start..start + letters));
        };
        self.at = end;
        let needs_no_bracket = self.notation == Notation::Klartext
            || (self.notation == Notation::Siemens && function == Function::Not);
        if needs_no_bracket {
            self.nested(Self::value)?;
        } else {
            self.bracket()?;
        }
        let slash = skip_blanks(self.text, self.at);
        if function == Function::Atan
            && self.notation == Notation::Iso
            && self.text.get(slash) == Some(&b'/')
            && self.text.get(skip_blanks(self.text, slash + 1)) == Some(&b'[')
        {
            self.at = slash + 1;
            self.bracket()?;
            self.steps.push(Step::Operator(Operator::Angle));
        } else {
            self.steps.push(Step::Function(function));
        }
        Ok(())
    }

    /// Reads values between brackets, one more than there are operators. The operators join the last two values
    /// first.
    fn joined_values(&mut self, operators: &[Operator]) -> Result<(), Fault> {
        let (open, close) = self.notation.brackets();
        self.expect(open)?;
        self.nested(|inner| inner.expression(0))?;
        for _ in operators {
            self.expect(b',')?;
            self.nested(|inner| inner.expression(0))?;
        }
        self.expect(close)?;
        self.steps.extend(operators.iter().map(|operator| Step::Operator(*operator)));
        Ok(())
    }

    /// Reads `EXISTS[#<name>]`.
    fn exists(&mut self) -> Result<(), Fault> {
        self.at += "EXISTS".len();
        self.expect(b'[')?;
        self.expect(b'#')?;
        let start = self.at;
        let Place::Named(name) = self.place()? else {
            let text = excerpt(&self.text[start..self.at]);
            return Err((Unread::Name { text }, start..self.at));
        };
        self.steps.push(Step::Exists(name));
        self.expect(b']')
    }

    /// Reads the parameter behind a `#`.
    pub(super) fn place(&mut self) -> Result<Place, Fault> {
        let start = skip_blanks(self.text, self.at);
        if self.text.get(start) != Some(&b'<') {
            self.nested(Self::value)?;
            return Ok(Place::Numbered);
        }
        let length = self.text[start..].iter().position(|byte| *byte == b'>');
        let end = length.map_or(self.text.len(), |length| start + length);
        let written = self.text.get(start + 1..end).unwrap_or_default();
        let name: Vec<u8> =
            written.iter().copied().filter(|byte| !is_blank(*byte)).take(MAX_NAME_LENGTH + 1).collect();
        match String::from_utf8(name) {
            Ok(name)
                if length.is_some()
                    && (1..=MAX_NAME_LENGTH).contains(&name.len())
                    && !name.contains(char::is_control) =>
            {
                self.continuation += continuation(written);
                self.at = end + 1;
                Ok(Place::Named(self.names.index(name.to_ascii_lowercase())))
            }
            _ => Err((Unread::Name { text: excerpt(&self.text[start..end]) }, start..start + 1)),
        }
    }

    /// Reads a part one level deeper.
    fn nested(&mut self, read: impl FnOnce(&mut Self) -> Result<(), Fault>) -> Result<(), Fault> {
        if self.depth == MAX_NESTING {
            return Err((Unread::Nesting, self.at..self.at + 1));
        }
        self.depth += 1;
        read(self)?;
        self.depth -= 1;
        Ok(())
    }

    /// Reads the byte `sign`.
    pub(super) fn expect(&mut self, sign: u8) -> Result<(), Fault> {
        self.at = skip_blanks(self.text, self.at);
        if self.text.get(self.at) == Some(&sign) {
            self.at += 1;
            return Ok(());
        }
        Err(self.missing(match sign {
            b'[' => "`[`",
            b']' => "an operator or `]`",
            b'(' => "`(`",
            b')' => "an operator or `)`",
            b',' => "`,`",
            b'#' => "`#`",
            _ => "`=`",
        }))
    }

    /// Returns the fault that `expected` is missing at the current byte.
    fn missing(&self, expected: &'static str) -> Fault {
        let rest = &self.text[self.at..];
        let length = if rest.is_empty() { 0 } else { character_length(rest) };
        let found = match length {
            0 => "the end of the line".to_string(),
            _ => format!("`{}`", excerpt(&rest[..length])),
        };
        (Unread::Expected { expected, found }, self.at..self.at + 1)
    }
}

/// Returns the end of `name` if it begins at `at`, else `None`; blanks within it are ignored.
fn after(text: &[u8], at: usize, name: &str) -> Option<usize> {
    let mut end = at;
    for letter in name.bytes() {
        end = skip_blanks(text, end);
        if !text.get(end)?.eq_ignore_ascii_case(&letter) {
            return None;
        }
        end += 1;
    }
    Some(end)
}

/// Returns the number of a common or system variable of Okuma controls.
pub(super) fn okuma_number(name: &[u8]) -> Option<u32> {
    let upper = name.to_ascii_uppercase();
    let digits = upper.strip_prefix(b"VC").or(upper.strip_prefix(b"V"))?;
    std::str::from_utf8(digits).ok()?.parse().ok()
}

/// Returns the number of the Q parameter that `text` begins with, and its length. Local and non-volatile
/// parameters (QL, QR) are numbered behind the others.
pub(super) fn klartext_number(text: &[u8]) -> Option<(u32, usize)> {
    let is = |at: usize, letter: u8| text.get(at).is_some_and(|byte: &u8| byte.eq_ignore_ascii_case(&letter));
    let (first, letters) = match () {
        () if !is(0, b'Q') => return None,
        () if is(1, b'L') => (LOCAL_PARAMETERS, 2),
        () if is(1, b'R') => (STORED_PARAMETERS, 2),
        () => (0, 1),
    };
    let digits = text[letters..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let number: u32 = std::str::from_utf8(&text[letters..letters + digits]).ok()?.parse().ok()?;
    (number < LOCAL_PARAMETERS).then_some((first + number, letters + digits))
}

/// The number of QL0.
pub const LOCAL_PARAMETERS: u32 = 1_000_000;

/// The number of QR0.
pub const STORED_PARAMETERS: u32 = 2_000_000;

/// Returns the length of the name that `text` begins with: letters, digits, `_` and a leading `$`.
pub(super) fn identifier(text: &[u8]) -> usize {
    let belongs = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'$');
    text.iter().take_while(|byte| belongs(byte)).count()
}

/// Returns the length of an index such as `[2]` or `[1,3]` that `text` begins with. An index consists of plain
/// numbers; for the control's own variables it may be a name (`$AA_IM[X]`).
fn index_of_array(text: &[u8], is_system: bool) -> usize {
    if text.first() != Some(&b'[') {
        return 0;
    }
    let belongs =
        |byte: &u8| byte.is_ascii_digit() || *byte == b',' || (is_system && byte.is_ascii_alphanumeric());
    let inner = text[1..].iter().take_while(|byte| belongs(byte)).count();
    if 0 < inner && text.get(1 + inner) == Some(&b']') { inner + 2 } else { 0 }
}

/// Returns the operators that join the values of a function of several values.
fn of_several(name: &[u8]) -> Option<&'static [Operator]> {
    use Operator::{Angle, Greatest, Least, Power};
    const NAMES: [(&str, &[Operator]); 5] = [
        ("POW", &[Power]),
        ("ATAN2", &[Angle]),
        ("MINVAL", &[Least]),
        ("MAXVAL", &[Greatest]),
        ("BOUND", &[Least, Greatest]),
    ];
    let found = NAMES.iter().find(|(known, _)| name.eq_ignore_ascii_case(known.as_bytes()));
    found.map(|(_, operators)| *operators)
}

/// Returns the function that Fanuc controls accept these two letters for.
fn function_by_two_letters(name: &[u8]) -> Option<Function> {
    if name.len() != 2 {
        return None;
    }
    let found = FUNCTIONS.iter().find(|(known, _)| known.as_bytes()[..2].eq_ignore_ascii_case(name));
    found.map(|(_, function)| *function)
}
