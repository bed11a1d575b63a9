//! Parameters (`#5`, `#<depth>`) and the values of formulas.
//!
//! One rule for all controls: every value of a block is worked out with the parameters as they
//! are before the block, from left to right; then its assignments are made, from left to right;
//! then it is run. So `#3=6 G1 X#3` moves to the former `#3`, as RS274/NGC says, and Fanuc
//! controls, which have one assignment a block and nothing beside it, agree.
//!
//! Rules where controls differ:
//! - A parameter holds what the program assigned to it, and nothing before: neither zero nor an
//!   empty value. Its number is whole (within 0.0001) and at least 1. The parameters of the
//!   control itself (positions, offsets) hold nothing either.
//! - Comparisons are exact and give 1 or 0; AND, OR and XOR take any value but 0 as true.
//! - MOD is at least 0, FIX rounds down, FUP up, ROUND to the nearest, halves away from 0.
//! - Angles are in degrees, arctangents in −180 to 180.
//!
//! A value that does not exist or is not finite is a fault, and its block is not run.
//!
//! Source: NIST RS274/NGC (Kramer, Proctor, Messina 2000), Sect. 3.3.2; comparisons as on
//! LinuxCNC.

use crate::simulation::gcode::{Block, Formula, Function, Operator, Program, Step, Target, Word};
use std::collections::HashMap;
use thiserror::Error;

/// How far from a whole number the number of a parameter may be.
const WHOLE: f64 = 1e-4;

/// Why a formula has no value.
#[derive(Clone, Debug, PartialEq, Error)]
pub(super) enum NoValue {
    #[error("#{parameter} has no value, since nothing was assigned to it before")]
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

/// What the parameters hold, and room to work.
#[derive(Default)]
pub(super) struct Parameters {
    numbered: HashMap<u32, f64>,
    /// By index in [`Program::names`].
    named: HashMap<u32, f64>,
    stack: Vec<f64>,
    words: Vec<Word>,
    assignments: Vec<(Name, f64)>,
}

/// A parameter.
#[derive(Clone, Copy)]
enum Name {
    Number(u32),
    Index(u32),
}

impl Parameters {
    /// Works out the formulas of `block` and makes its assignments; returns its words with all
    /// their values, or the first formula that has no value, after which nothing is assigned.
    pub(super) fn words_of<'a>(
        &mut self,
        program: &Program,
        block: &Block,
        formulas: &'a [Formula],
    ) -> Result<&[Word], (&'a Formula, NoValue)> {
        self.words.clear();
        self.words.extend_from_slice(program.words(block));
        self.assignments.clear();
        for formula in formulas {
            self.take(program, block, formula).map_err(|no_value| (formula, no_value))?;
        }
        for (name, value) in self.assignments.drain(..) {
            match name {
                Name::Number(number) => self.numbered.insert(number, value),
                Name::Index(index) => self.named.insert(index, value),
            };
        }
        Ok(&self.words)
    }

    /// Works out one formula and keeps its value for its word or for after the block's last one.
    fn take(&mut self, program: &Program, block: &Block, formula: &Formula) -> Result<(), NoValue> {
        let value = self.evaluate(program, formula)?;
        match formula.target {
            Target::Word(index) => {
                let word = &mut self.words[(index - block.words.start) as usize];
                word.value = value;
                word.has_point = value.fract() != 0.0;
            }
            Target::Numbered => {
                let number = parameter_number(pop(&mut self.stack))?;
                self.assignments.push((Name::Number(number), value));
            }
            Target::Named(index) => self.assignments.push((Name::Index(index), value)),
        }
        Ok(())
    }

    /// The value of `formula`; where it has a numbered target, its number is left on the stack.
    fn evaluate(&mut self, program: &Program, formula: &Formula) -> Result<f64, NoValue> {
        self.stack.clear();
        for step in program.steps(formula) {
            let value = match *step {
                Step::Number(value) => value,
                Step::Named(index) => *self.named.get(&index).ok_or_else(|| {
                    let name = program.names.get(index as usize).map_or("", String::as_str);
                    NoValue::Unassigned { parameter: format!("<{name}>") }
                })?,
                Step::Numbered => {
                    let number = parameter_number(pop(&mut self.stack))?;
                    let held = self.numbered.get(&number).copied();
                    held.ok_or_else(|| NoValue::Unassigned { parameter: number.to_string() })?
                }
                Step::Negate => -pop(&mut self.stack),
                Step::Function(function) => apply(function, pop(&mut self.stack))?,
                Step::Operator(operator) => {
                    let right = pop(&mut self.stack);
                    combine(operator, pop(&mut self.stack), right)?
                }
            };
            if !value.is_finite() {
                return Err(NoValue::TooLarge);
            }
            self.stack.push(value);
        }
        Ok(pop(&mut self.stack))
    }
}

fn pop(stack: &mut Vec<f64>) -> f64 {
    stack.pop().expect("the reader writes an operand for each step that takes one")
}

fn parameter_number(value: f64) -> Result<u32, NoValue> {
    let whole = value.round();
    let is_number = (value - whole).abs() <= WHOLE && (1.0..=f64::from(u32::MAX)).contains(&whole);
    if is_number { Ok(whole as u32) } else { Err(NoValue::NoParameter { value }) }
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
    })
}

fn combine(operator: Operator, left: f64, right: f64) -> Result<f64, NoValue> {
    let truth = |is_true: bool| if is_true { 1.0 } else { 0.0 };
    let (is_left, is_right) = (left != 0.0, right != 0.0);
    Ok(match operator {
        Operator::Over | Operator::Modulo if right == 0.0 => return Err(NoValue::DivisionByZero { left }),
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
        Operator::Angle => left.atan2(right).to_degrees(),
    })
}

#[cfg(test)]
mod tests;
