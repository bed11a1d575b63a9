//! Parameters (`#5`, `#<depth>`) and the values of formulas.
//!
//! One rule for all controls: all values of a block are computed with the parameters before the block, from left
//! to right; then its assignments are made, from left to right; then it is run. So `#3=6 G1 X#3` moves to the
//! former `#3`, as in RS274/NGC, and Fanuc controls, which have one assignment a block and no other words beside
//! it, agree. Siemens controls make each assignment in its position.
//!
//! Rules for differences between controls:
//! - A parameter has the value that the program assigned to it. Before, it is vacant on Fanuc controls and their
//!   relatives: 0 in arithmetic, equal only to another vacant one, and a word of it counts as missing (`#0` is
//!   always vacant). On other controls a numbered parameter is 0 before, and a named one a fault. A remark names the
//!   first such parameter.
//! - Its number is whole (within 0.0001). Of the control's own parameters, position, tool, feed and the like are
//!   known; the others have no value.
//! - A call with arguments has its own parameters 1 to 33 (1 to 30 on LinuxCNC, and all names without `_`).
//! - Comparisons are exact and give 1 or 0; AND, OR and XOR take any value but 0 as true. On Fanuc controls, their
//!   relatives and Okuma's they work bit by bit, which gives the same result for conditions.
//! - MOD is at least 0, FIX rounds down, FUP up, ROUND to the nearest, halves away from 0. On Fanuc
//!   controls FIX rounds toward 0 and FUP away from it, as ROUNDUP of Siemens does.
//! - Angles are in degrees, arctangents in −180 to 180.
//!
//! A value that does not exist or is not finite is a fault, and its block is not run.
//!
//! Source: NIST RS274/NGC (Kramer, Proctor, Messina 2000), Sect. 3.3.2; comparisons as on
//! LinuxCNC.

use crate::simulation::gcode::{
    Argument, Block, Dialect, Formula, Function, LineNumber, Operator, Program, Statement, Step, Target,
    Word, nearest_whole,
};
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use thiserror::Error;

/// The reason why a formula has no value.
#[derive(Clone, Debug, PartialEq, Error)]
pub(super) enum NoValue {
    #[error("{parameter} has no value: nothing was assigned to it")]
    Unassigned { parameter: String },
    #[error("{value} is not the number of a parameter")]
    NoParameter { value: f64 },
    #[error("{left} is divided by zero")]
    DivisionByZero { left: f64 },
    #[error("{function} of {value} does not exist")]
    OutsideFunction { function: &'static str, value: f64 },
    #[error("{left} to the power of {right} does not exist")]
    NoPower { left: f64, right: f64 },
    #[error("a value is too large")]
    TooLarge,
}

/// Values of the control itself, by the number or the name that programs read them with.
pub(super) trait Control {
    /// Returns the value of the parameter with this number.
    fn numbered(&self, number: u32) -> Option<f64>;
    /// Returns the value of the parameter with this name, lower case.
    fn named(&self, name: &str) -> Option<f64>;
}

/// The value of a vacant parameter of Fanuc controls.
const VACANT: f64 = f64::NAN;

/// The values of the parameters, with space for computing.
pub(super) struct Parameters {
    dialect: Dialect,
    globals: HashMap<Name, f64>,
    /// The values of the main program and of each nested call.
    locals: Vec<HashMap<Name, f64>>,
    stack: Vec<f64>,
    assignments: Vec<(Name, f64)>,
    /// The first parameter that was read before an assignment to it.
    pub(super) unassigned: Option<(LineNumber, String)>,
    /// The last parameter of the call in force that was read without a value in a formula.
    missing: Option<Name>,
    state: State,
    line: LineNumber,
    /// Index of the first argument of a statement of the block in the program.
    first_argument: u32,
}

/// A digest of all values, and the number of values of the control that were read: if neither changed, formulas
/// have the same values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct State {
    held: u64,
    control_reads: u64,
}

/// The values of one block.
#[derive(Default)]
pub(super) struct Values {
    /// Its words with all their values, without vacant ones.
    pub(super) words: Vec<Word>,
    pub(super) condition: Option<f64>,
    pub(super) count: Option<f64>,
    pub(super) destination: Option<f64>,
    /// A parameter of the call in force without a value that the condition depends on.
    pub(super) missing: Option<String>,
    /// The arguments of its statements with all their values.
    pub(super) statement_arguments: Vec<Argument>,
    /// The values that it assigns to numbered parameters.
    pub(super) assigned: Vec<(u32, f64)>,
    /// The arguments of a call, by the number of their parameter.
    pub(super) arguments: Vec<(u32, f64)>,
    /// `true` if the program raises an alarm (`#3000=1`).
    pub(super) alarm: bool,
    /// `true` if the program stops for the operator (`#3006=1`), as by M0.
    pub(super) stop: bool,
}

impl Values {
    fn clear(&mut self) {
        self.words.clear();
        self.statement_arguments.clear();
        self.assigned.clear();
        self.arguments.clear();
        (self.condition, self.count, self.destination, self.missing) = (None, None, None, None);
        (self.alarm, self.stop) = (false, false);
    }
}

/// The parameter that raises an alarm at an assignment.
const ALARM_PARAMETER: u32 = 3000;

/// The parameter that stops the program at an assignment.
const STOP_PARAMETER: u32 = 3006;

/// A parameter.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Name {
    Number(u32),
    Index(u32),
}

impl Parameters {
    pub(super) fn new(dialect: Dialect) -> Parameters {
        Parameters {
            dialect,
            globals: HashMap::new(),
            locals: vec![HashMap::new()],
            stack: Vec::new(),
            assignments: Vec::new(),
            unassigned: None,
            missing: None,
            state: State::default(),
            line: LineNumber(0),
            first_argument: 0,
        }
    }

    /// Begins a call, which has its own numbered parameters and, on LinuxCNC, names without `_`.
    pub(super) fn enter(&mut self, arguments: &[(u32, f64)]) {
        let given = arguments.iter().map(|(number, value)| (Name::Number(*number), *value));
        let given: HashMap<Name, f64> = given.filter(|(_, value)| !value.is_nan()).collect();
        let depth = self.locals.len() + 1;
        self.state.held ^= digest_of_all(&given, depth);
        self.locals.push(given);
    }

    /// Returns the digest of all values.
    pub(super) fn state(&self) -> State {
        self.state
    }

    /// Ends a call.
    pub(super) fn leave(&mut self) {
        if 1 < self.locals.len() {
            self.state.held ^= digest_of_all(&self.locals[self.locals.len() - 1], self.locals.len());
            self.locals.pop();
        }
    }

    /// Computes the formulas of a block into `values` and makes its assignments.
    ///
    /// # Errors
    ///
    /// The first formula without a value; no assignment is made then.
    pub(super) fn values_of<'a>(
        &mut self,
        program: &Program,
        block: &Block,
        statements: &[Statement],
        formulas: &'a [Formula],
        control: &dyn Control,
        values: &mut Values,
    ) -> Result<(), (&'a Formula, NoValue)> {
        values.clear();
        if formulas.is_empty() {
            return Ok(());
        }
        values.words.extend_from_slice(program.words(block));
        values.statement_arguments.extend_from_slice(program.arguments(statements));
        self.first_argument = statements.first().map_or(0, |statement| statement.arguments.start);
        self.line = block.line;
        self.assignments.clear();
        for formula in formulas {
            self.take(program, block, formula, control, values).map_err(|no_value| (formula, no_value))?;
            if self.dialect == Dialect::Siemens {
                while let Some((name, value)) = self.assignments.pop() {
                    self.assign(program, name, value);
                }
            }
        }
        values.words.retain(|word| !word.value.is_nan());
        let is_macro = matches!(self.dialect, Dialect::Iso | Dialect::Mach);
        for index in 0..self.assignments.len() {
            let (name, value) = self.assignments[index];
            values.alarm |= is_macro && name == Name::Number(ALARM_PARAMETER);
            values.stop |= is_macro && name == Name::Number(STOP_PARAMETER);
            if let Name::Number(number) = name {
                values.assigned.push((number, value));
            }
            self.assign(program, name, value);
        }
        Ok(())
    }

    /// Returns `true` if a parameter belongs to the call in force.
    fn is_local(&self, program: &Program, name: Name) -> bool {
        match name {
            Name::Number(number) => match self.dialect {
                Dialect::LinuxCnc => number <= 30,
                Dialect::Iso | Dialect::Mach | Dialect::Okuma => number <= 33,
                _ => false,
            },
            Name::Index(_) if self.dialect != Dialect::LinuxCnc => false,
            Name::Index(index) => {
                !program.names.get(index as usize).is_some_and(|name| name.starts_with('_'))
            }
        }
    }

    /// Assigns a value to a parameter; a vacant one removes it.
    fn assign(&mut self, program: &Program, name: Name, value: f64) {
        let depth = if self.is_local(program, name) { self.locals.len() } else { 0 };
        let holder = match depth {
            0 => &mut self.globals,
            _ => self.locals.last_mut().expect("the main program has its own"),
        };
        let former = if value.is_nan() { holder.remove(&name) } else { holder.insert(name, value) };
        for held in former.into_iter().chain(Some(value).filter(|value| !value.is_nan())) {
            self.state.held ^= digest(name, held, depth);
        }
    }

    /// Returns the value of a parameter, of the program or of the control; `None` if it has none.
    fn held(&mut self, program: &Program, name: Name, control: &dyn Control) -> Option<f64> {
        let holder = match self.is_local(program, name) {
            true => self.locals.last().expect("the main program has its own"),
            false => &self.globals,
        };
        if let Some(value) = holder.get(&name) {
            return Some(*value);
        }
        let value = match name {
            Name::Number(number) => control.numbered(number),
            Name::Index(index) => control.named(program.names.get(index as usize)?),
        };
        self.state.control_reads += u64::from(value.is_some());
        value
    }

    /// Returns the value of a parameter, or the value of a missing one in the dialect.
    fn value(&mut self, program: &Program, name: Name, control: &dyn Control) -> Result<f64, NoValue> {
        if let Some(value) = self.held(program, name, control) {
            return Ok(value);
        }
        if name != Name::Number(0) && self.is_local(program, name) {
            self.missing = Some(name);
        }
        let parameter = match name {
            Name::Number(number) => number.to_string(),
            Name::Index(index) => {
                let name = program.names.get(index as usize).map_or("", String::as_str);
                if self.dialect == Dialect::Okuma {
                    self.unassigned.get_or_insert((self.line, name.to_ascii_uppercase()));
                    return Ok(VACANT);
                }
                let parameter = match self.dialect {
                    Dialect::Siemens => name.to_ascii_uppercase(),
                    _ => format!("#<{name}>"),
                };
                return Err(NoValue::Unassigned { parameter });
            }
        };
        let sign = match self.dialect {
            Dialect::Siemens => 'R',
            Dialect::Klartext | Dialect::HeidenhainIso => 'Q',
            _ => '#',
        };
        // Elements of arrays and arguments of calls are 0 before an assignment to them.
        if !matches!(name, Name::Number(0 | 3_000_000_000..)) {
            self.unassigned.get_or_insert((self.line, format!("{sign}{parameter}")));
        }
        let is_vacant = matches!(self.dialect, Dialect::Iso | Dialect::Mach | Dialect::Okuma);
        Ok(if is_vacant { VACANT } else { 0.0 })
    }

    /// Computes one formula and stores its value for its word, or as an assignment after the block's last formula.
    fn take(
        &mut self,
        program: &Program,
        block: &Block,
        formula: &Formula,
        control: &dyn Control,
        values: &mut Values,
    ) -> Result<(), NoValue> {
        self.missing = None;
        let value = self.evaluate(program, formula, control)?;
        match formula.target {
            Target::Word(index) => {
                let word = &mut values.words[(index - block.words.start) as usize];
                word.value = value;
                // Fanuc controls read a formula as written with a point, but P has none there.
                word.has_point = value.fract() != 0.0 || matches!(word.letter, b'X' | b'U');
            }
            Target::StatementArgument(index) => {
                values.statement_arguments[(index - self.first_argument) as usize].value = value;
            }
            Target::Numbered => {
                let number = parameter_number(zero_if_vacant(pop(&mut self.stack)))?;
                self.assignments.push((Name::Number(number), value));
            }
            Target::Named(index) => self.assignments.push((Name::Index(index), value)),
            Target::Condition => {
                values.condition = Some(zero_if_vacant(value));
                values.missing = self.missing.map(|name| match name {
                    Name::Number(number) => format!("#{number}"),
                    Name::Index(index) => program.names.get(index as usize).cloned().unwrap_or_default(),
                });
            }
            Target::Count => values.count = Some(zero_if_vacant(value)),
            Target::Destination => values.destination = Some(zero_if_vacant(value)),
            Target::Argument(number) => values.arguments.push((number, value)),
            Target::Result => {
                let name = program.names.iter().position(|name| name == "_value");
                if let Some(index) = name {
                    self.assignments.push((Name::Index(index as u32), value));
                }
            }
        }
        Ok(())
    }

    /// Returns the value of `formula`; of a numbered target, the number remains on the stack. The value is vacant
    /// only if the formula is one vacant parameter and nothing else.
    fn evaluate(
        &mut self,
        program: &Program,
        formula: &Formula,
        control: &dyn Control,
    ) -> Result<f64, NoValue> {
        self.stack.clear();
        for step in program.steps(formula) {
            let value = match *step {
                Step::Number(value) => value,
                Step::Named(index) => self.value(program, Name::Index(index), control)?,
                Step::Numbered => {
                    let number = zero_if_vacant(pop(&mut self.stack));
                    let number = if number == 0.0 { 0 } else { parameter_number(number)? };
                    self.value(program, Name::Number(number), control)?
                }
                Step::Exists(index) => {
                    let is_there = self.held(program, Name::Index(index), control).is_some();
                    if is_there { 1.0 } else { 0.0 }
                }
                Step::Negate => -zero_if_vacant(pop(&mut self.stack)),
                Step::Function(function) => self.apply(function)?,
                Step::Operator(operator) => {
                    let right = pop(&mut self.stack);
                    let left = pop(&mut self.stack);
                    self.by_bits(operator, left, right)
                        .map_or_else(|| combine_vacant(operator, left, right), Ok)?
                }
            };
            if value.is_infinite() {
                return Err(NoValue::TooLarge);
            }
            self.stack.push(value);
        }
        Ok(pop(&mut self.stack))
    }

    /// Applies a function to the value on the stack.
    fn apply(&mut self, function: Function) -> Result<f64, NoValue> {
        let value = zero_if_vacant(pop(&mut self.stack));
        let is_below_zero = matches!(self.dialect, Dialect::Iso | Dialect::Siemens) && value < 0.0;
        match function {
            Function::Fix if is_below_zero => apply(Function::Fup, value),
            Function::Fup if is_below_zero => apply(Function::Fix, value),
            _ => apply(function, value),
        }
    }

    /// Returns the result of AND, OR and XOR on controls that compute them bit by bit. Fanuc controls do so on
    /// binary numbers, and round other values to the nearest integer.
    fn by_bits(&self, operator: Operator, left: f64, right: f64) -> Option<f64> {
        if !matches!(self.dialect, Dialect::Iso | Dialect::Okuma) {
            return None;
        }
        let [left, right] = [left, right].map(|value| zero_if_vacant(value).round() as i64);
        let bits = match operator {
            Operator::And => left & right,
            Operator::Or => left | right,
            Operator::Xor => left ^ right,
            _ => return None,
        };
        Some(bits as f64)
    }
}

/// Returns the digest of one parameter with its value in the call of this depth; 0 for the parameters of all
/// calls.
fn digest(name: Name, value: f64, depth: usize) -> u64 {
    let mut hasher = DefaultHasher::new();
    (name, value.to_bits(), depth).hash(&mut hasher);
    hasher.finish()
}

fn digest_of_all(held: &HashMap<Name, f64>, depth: usize) -> u64 {
    held.iter().fold(0, |all, (name, value)| all ^ digest(*name, *value, depth))
}

fn zero_if_vacant(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value }
}

/// Returns the result of an operator; a vacant value is 0 in arithmetic, but equal only to a vacant one.
fn combine_vacant(operator: Operator, left: f64, right: f64) -> Result<f64, NoValue> {
    if (left.is_nan() || right.is_nan()) && matches!(operator, Operator::Equal | Operator::NotEqual) {
        let is_same = left.is_nan() && right.is_nan();
        return Ok(if is_same == (operator == Operator::Equal) { 1.0 } else { 0.0 });
    }
    combine(operator, zero_if_vacant(left), zero_if_vacant(right))
}

fn pop(stack: &mut Vec<f64>) -> f64 {
    stack.pop().expect("the reader writes an operand for each step that takes one")
}

fn parameter_number(value: f64) -> Result<u32, NoValue> {
    let number = nearest_whole(value).filter(|number| (1.0..=f64::from(u32::MAX)).contains(number));
    number.map(|number| number as u32).ok_or(NoValue::NoParameter { value })
}

fn apply(function: Function, value: f64) -> Result<f64, NoValue> {
    let exists = match function {
        Function::Asin | Function::Acos => (-1.0..=1.0).contains(&value),
        Function::Sqrt => 0.0 <= value,
        Function::Ln => 0.0 < value,
        _ => true,
    };
    if !exists {
        return Err(NoValue::OutsideFunction { function: function.name(), value });
    }
    Ok(match function {
        Function::Sin => value.to_radians().sin(),
        Function::Cos => value.to_radians().cos(),
        Function::Tan => value.to_radians().tan(),
        Function::Asin => value.asin().to_degrees(),
        Function::Acos => value.acos().to_degrees(),
        Function::Atan => value.atan().to_degrees(),
        Function::Sqrt => value.sqrt(),
        Function::Abs => value.abs(),
        Function::Exp => value.exp(),
        Function::Ln => value.ln(),
        Function::Round => value.round(),
        Function::Fix => value.floor(),
        Function::Fup => value.ceil(),
        Function::Truncate => value.trunc(),
        Function::Fraction => value.fract(),
        Function::Square => value * value,
        Function::Sign if value == 0.0 => 0.0,
        Function::Sign => value.signum(),
        Function::Not if value == 0.0 => 1.0,
        Function::Not => 0.0,
    })
}

fn combine(operator: Operator, left: f64, right: f64) -> Result<f64, NoValue> {
    let truth = |is_true: bool| if is_true { 1.0 } else { 0.0 };
    let (is_left, is_right) = (left != 0.0, right != 0.0);
    Ok(match operator {
        Operator::Over | Operator::Modulo | Operator::Quotient if right == 0.0 => {
            return Err(NoValue::DivisionByZero { left });
        }
        Operator::Power if left == 0.0 && right < 0.0 => return Err(NoValue::DivisionByZero { left: 1.0 }),
        Operator::Power if left < 0.0 && right.fract() != 0.0 => {
            return Err(NoValue::NoPower { left, right });
        }
        Operator::Power => left.powf(right),
        Operator::Times => left * right,
        Operator::Over => left / right,
        Operator::Modulo => left.rem_euclid(right),
        Operator::Plus => left + right,
        Operator::Minus => left - right,
        Operator::Equal => truth(left == right),
        Operator::NotEqual => truth(left != right),
        Operator::Greater => truth(left > right),
        Operator::GreaterOrEqual => truth(left >= right),
        Operator::Less => truth(left < right),
        Operator::LessOrEqual => truth(left <= right),
        Operator::And => truth(is_left && is_right),
        Operator::Or => truth(is_left || is_right),
        Operator::Xor => truth(is_left != is_right),
        Operator::Quotient => (left / right).trunc(),
        Operator::Length => left.hypot(right),
        Operator::Least => left.min(right),
        Operator::Greatest => left.max(right),
        Operator::Angle => left.atan2(right).to_degrees(),
    })
}

#[cfg(test)]
#[path = "parameters_tests.rs"]
mod tests;
