//! An effect and its hypotheses, which free parameters of a machine.

use std::ops::Deref;

use crate::identification::effects::report::{
    AXIS, Finding, Quantity, Report, Reported, ReportedValue, SECONDS,
};
use crate::identification::fit::{FreeParameter, Run, with};
use crate::machine::Machine;
use crate::simulation::feed::limits::rapid_feedrate;
use crate::simulation::toolpath::{Curve, Motion, Vector};

/// The trace that an effect leaves in a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trace {
    /// A change of the time along the path, or of the recorder's time.
    Time,
    /// A change of the form of the path, and not of its time.
    Form,
}

/// The kind of parameter that an effect changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nature {
    /// A limit: the lower it is, the slower the machine.
    Limit,
    /// A law or setting of the control.
    Setting,
    /// A switch or a clock, whose value is exactly 1 unless it was changed.
    Switch,
    /// A time during which the machine does not move.
    Halt,
    /// A property of the drives, which lag behind the command.
    Drive,
    /// No parameter of a machine.
    Other,
}

/// The person or device that brings an effect about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Machine and control, by a key of the machine file.
    Machine,
    /// The person who runs the machine.
    Operator,
    /// The device that records the run.
    Recorder,
}

/// All facts about an effect except its physics.
pub struct Row {
    /// Identifier in the contract of `diagnose`.
    pub id: &'static str,
    /// Kind of parameter.
    pub nature: Nature,
    /// Origin: machine, operator or recorder.
    pub origin: Origin,
    /// Price of the rarity, as a cost: twice the logarithm of the odds of the most frequent effects against this
    /// one.
    pub rarity: f64,
    /// Vendors' names of the setting; may be empty.
    pub vendors: &'static str,
    /// Reason why no program provokes the effect, with the measure to take instead; `None` if a program does.
    pub unprovoked: Option<&'static str>,
    /// Function that returns the hypotheses that the programs excite on a machine: parameters, trial values and
    /// reports.
    pub offered: fn(Effect, &Context) -> Vec<Hypothesis>,
    /// Function that returns the sentence for people.
    pub sentence: fn(&Finding) -> String,
}

/// An effect that the identification knows, as a reference to its row of the table.
#[derive(Clone, Copy)]
pub struct Effect(pub(super) &'static Row);

impl Deref for Effect {
    type Target = Row;

    fn deref(&self) -> &Row {
        self.0
    }
}

impl PartialEq for Effect {
    fn eq(&self, other: &Effect) -> bool {
        self.id == other.id
    }
}

impl std::fmt::Debug for Effect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.id)
    }
}

impl Row {
    /// Returns the name of the effect as people read it: its id with blanks.
    pub fn name(&self) -> String {
        self.id.replace('_', " ")
    }

    /// Returns the id, with the axes in brackets if some are given: `axis_velocity_limit (Y)`.
    pub fn id_on(&self, axes: Option<&str>) -> String {
        axes.map_or(self.id.to_string(), |axes| format!("{} ({axes})", self.id))
    }

    /// Returns the trace that the effect leaves.
    pub fn trace(&self) -> Trace {
        if self.nature == Nature::Drive { Trace::Form } else { Trace::Time }
    }

    /// Returns `true` if the operator brings the effect about.
    pub fn is_by_operator(&self) -> bool {
        self.origin == Origin::Operator
    }
}

/// The input of the library: a machine, runs on it, and the demands of their programs.
pub struct Context<'a> {
    /// Assumed machine.
    pub machine: &'a Machine,
    /// Runs on it.
    pub runs: &'a [Run<'a>],
    /// Highest programmed velocity of each axis, rapid moves included, mm/s.
    pub axis_feedrate: Vector,
    /// Highest programmed feedrate, rapid moves included, mm/s.
    pub feedrate: f64,
    /// `true` if the programs have rapid moves.
    pub has_rapid: bool,
    /// `true` if the programs have arcs.
    pub has_arc: bool,
    /// `true` if a program sets tolerances.
    pub has_tolerance: bool,
}

impl<'a> Context<'a> {
    /// Returns the context of runs on a machine, with the demands of their programs.
    pub fn new(machine: &'a Machine, runs: &'a [Run<'a>]) -> Context<'a> {
        let mut context = Context {
            machine,
            runs,
            axis_feedrate: Vector::zeros(),
            feedrate: 0.0,
            has_rapid: false,
            has_arc: false,
            has_tolerance: false,
        };
        for run in runs {
            context.has_tolerance |= !run.toolpath.path_modes.is_empty();
            for segment in &run.toolpath.segments {
                let feedrate = match segment.motion {
                    Motion::Feed { feedrate } => feedrate,
                    Motion::Rapid { .. } => {
                        context.has_rapid = true;
                        rapid_feedrate(&segment, machine)
                    }
                };
                context.has_arc |= segment.curve != Curve::Line;
                context.feedrate = context.feedrate.max(feedrate);
                let share = match &segment.curve {
                    Curve::Line => segment.tangent(0.0).abs(),
                    Curve::Arc(arc) => arc.e1.abs() + arc.e2.abs(),
                };
                for axis in 0..3 {
                    let own = feedrate * share[axis].min(1.0);
                    context.axis_feedrate[axis] = context.axis_feedrate[axis].max(own);
                }
            }
        }
        context
    }
}

/// Values between the trials of a hypothesis that have a meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// All.
    AnyValue,
    /// Whole numbers, of one parameter.
    WholeNumbers,
    /// None.
    Nothing,
}

/// An effect that the machine may have and its file may lack, as free parameters with values tried first.
#[derive(Clone)]
pub struct Hypothesis {
    /// Effect.
    pub effect: Effect,
    /// Variant among several hypotheses of the effect, as people read it: the axis, the rule; may be empty.
    pub variant: String,
    /// Parameters that the hypothesis frees.
    pub freed: Vec<FreeParameter>,
    /// Values tried first, each trial with one entry per parameter.
    pub trials: Vec<Vec<f64>>,
    /// Values between the trials that have a meaning.
    pub between_trials: Between,
    /// Number of words that the PLC answers in a wait that the hypothesis changes; 0 if it changes none.
    pub plc_words: usize,
    /// Price of its rarity, in the unit of the cost.
    pub rarity: f64,
    /// Function that returns the reported quantities of values.
    pub report: Report,
}

impl std::fmt::Debug for Hypothesis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.effect.id, self.variant)
    }
}

impl Hypothesis {
    /// Returns a hypothesis of an effect with its parameters, the values tried first, and the report of values.
    pub fn new(
        effect: Effect,
        freed: Vec<FreeParameter>,
        trials: Vec<Vec<f64>>,
        report: impl Fn(&[f64]) -> Vec<(Quantity, Reported)> + Send + Sync + 'static,
    ) -> Hypothesis {
        let report: Report = std::sync::Arc::new(report);
        Hypothesis {
            effect,
            variant: String::new(),
            freed,
            trials,
            between_trials: Between::AnyValue,
            plc_words: 0,
            rarity: effect.rarity,
            report,
        }
    }

    /// Returns a hypothesis of an effect with one parameter.
    pub fn single(
        effect: Effect,
        freed: FreeParameter,
        trials: Vec<f64>,
        report: impl Fn(f64) -> Vec<(Quantity, Reported)> + Send + Sync + 'static,
    ) -> Hypothesis {
        let trials = trials.into_iter().map(|value| vec![value]).collect();
        Hypothesis::new(effect, vec![freed], trials, move |values| report(values[0]))
    }

    /// Returns the hypothesis with the name of its variant among several of the effect.
    pub fn variant(self, variant: impl Into<String>) -> Hypothesis {
        Hypothesis { variant: variant.into(), ..self }
    }

    /// Returns the hypothesis with values between the trials marked as meaningless.
    pub fn at_trials_only(self) -> Hypothesis {
        Hypothesis { between_trials: Between::Nothing, ..self }
    }

    /// Returns the hypothesis of a number that is counted: between the trials, whole numbers have a meaning.
    pub fn counted(self) -> Hypothesis {
        Hypothesis { between_trials: Between::WholeNumbers, ..self }
    }

    /// Returns `true` if all values between the trials have a meaning, so that least squares can fit them.
    pub fn is_continuous(&self) -> bool {
        self.between_trials == Between::AnyValue
    }

    /// Returns the hypothesis of a variant that is rarer than others of its effect.
    pub fn with_rarity(self, rarity: f64) -> Hypothesis {
        Hypothesis { rarity, ..self }
    }

    /// Returns the hypothesis of a wait in which the PLC answers this number of words.
    pub fn answering(self, plc_words: usize) -> Hypothesis {
        Hypothesis { plc_words, ..self }
    }

    /// Returns the name as people read it: the id of the effect with blanks, and the variant in parentheses.
    pub fn name(&self) -> String {
        let words = self.effect.name();
        if self.variant.is_empty() { words } else { format!("{words} ({})", self.variant) }
    }

    /// Returns the trace that the effect leaves.
    pub fn trace(&self) -> Trace {
        self.effect.trace()
    }

    /// Returns `true` if `other` is the same variant of the same effect.
    pub fn is_same_as(&self, other: &Hypothesis) -> bool {
        self.effect == other.effect && self.variant == other.variant
    }

    /// Returns the letters of the axes that the hypothesis is about; `None` if it is about none.
    pub fn axes(&self) -> Option<String> {
        let reported = (self.report)(self.trials.first()?);
        match reported.into_iter().find(|(quantity, _)| *quantity == AXIS)? {
            (_, Reported::Word(axes)) => Some(axes),
            _ => None,
        }
    }

    /// Returns by how much longer a wait is with one value than with another, s; `None` for anything but a wait.
    pub fn wait_between(&self, from: f64, to: f64) -> Option<f64> {
        let seconds = |value: f64| {
            let reported = (self.report)(&[value]);
            reported.into_iter().find_map(|(quantity, reported)| match reported {
                Reported::Number(seconds) if quantity == SECONDS => Some(seconds),
                _ => None,
            })
        };
        Some(seconds(to)? - seconds(from)?)
    }

    /// Returns `true` if `other` is another explanation to a person: another effect, or the same effect of other axes.
    pub fn is_rival_of(&self, other: &Hypothesis) -> bool {
        self.effect != other.effect || self.axes() != other.axes()
    }

    /// Returns `true` if the hypothesis frees a limit and nothing else: the lower the limit, the slower the
    /// machine.
    pub fn is_limit(&self) -> bool {
        self.effect.nature == Nature::Limit && self.freed.len() == 1
    }

    /// Returns `true` if the hypothesis frees a parameter that `other` fits beside its first one.
    pub fn is_fitted_beside(&self, other: &Hypothesis) -> bool {
        let beside = other.freed.iter().skip(1);
        beside.into_iter().any(|beside| self.freed.iter().any(|own| own.handle == beside.handle))
    }

    /// Returns the machine with these values of the parameters.
    pub fn machine(&self, machine: &Machine, values: &[f64]) -> Machine {
        with(machine, &self.freed, values)
    }

    /// Returns the reported quantities of the values (core units). The standard deviation of each is the root of
    /// the sum of squares of its changes when each parameter in turn moves by its entry of `deviations`.
    pub fn reported(&self, values: &[f64], deviations: &[f64]) -> Vec<ReportedValue> {
        let mut all: Vec<ReportedValue> = (self.report)(values)
            .into_iter()
            .map(|(quantity, value)| ReportedValue { quantity, value, deviation: None })
            .collect();
        for (at, deviation) in deviations.iter().enumerate().filter(|(_, own)| own.is_finite()) {
            let mut moved = values.to_vec();
            moved[at] += deviation;
            for (reported, (_, other)) in all.iter_mut().zip((self.report)(&moved)) {
                if let (Reported::Number(value), Reported::Number(other)) = (&reported.value, other)
                    && *value != other
                {
                    let before = reported.deviation.unwrap_or(0.0);
                    reported.deviation = Some(before.hypot(other - value));
                }
            }
        }
        all
    }
}

/// Returns `count` numbers from `from` to `to`, with the same ratio between all neighbours.
pub fn ratios(from: f64, to: f64, count: usize) -> Vec<f64> {
    let part = |at: usize| at as f64 / (count - 1).max(1) as f64;
    (0..count).map(|at| from * (to / from).powf(part(at))).collect()
}
