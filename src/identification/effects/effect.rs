//! An effect, and the hypotheses that offer it: parameters of a machine to be freed.

use std::ops::Deref;

use crate::identification::effects::report::{Finding, Quantity, Report, Reported, ReportedValue};
use crate::identification::fit::{FreeParameter, Run, with};
use crate::machine::Machine;
use crate::simulation::feed::limits::rapid_feedrate;
use crate::simulation::toolpath::{Curve, Motion, Vector};

/// What trace an effect leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trace {
    /// Time along the path, or of the recorder.
    Time,
    /// The form of the path, and no time.
    Form,
}

/// What kind of parameter an effect is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nature {
    /// A limit: the machine is the slower the lower it is.
    Limit,
    /// A law or setting of the control.
    Setting,
    /// A switch or a clock, which is known to be exactly 1 where nothing was done.
    Switch,
    /// A time in which the machine stands.
    Halt,
    /// The drives, which trail the command.
    Drive,
    /// No parameter of a machine.
    Other,
}

/// Who brings an effect about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Machine and control: a key of the machine file.
    Machine,
    /// Whoever runs the machine.
    Operator,
    /// What records it.
    Recorder,
}

/// All there is to know of an effect but its physics.
pub struct Row {
    /// Its id in the contract of `diagnose`.
    pub id: &'static str,
    /// What kind of parameter it is.
    pub nature: Nature,
    /// Who brings it about.
    pub origin: Origin,
    /// How much rarer it is than what is met most, as a price in cost: twice the logarithm of the odds.
    pub rarity: f64,
    /// What vendors call the setting; may be empty.
    pub vendors: &'static str,
    /// Why no program brings it out, and what to do instead; `None` where a program does.
    pub unprovoked: Option<&'static str>,
    /// The hypotheses that the programs excite on a machine: parameters, trial values and reports.
    pub offered: fn(Effect, &Context) -> Vec<Hypothesis>,
    /// The sentence for people.
    pub sentence: fn(&Finding) -> String,
}

/// An effect that the identification knows, by its row of the table.
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

    /// What trace it leaves.
    pub fn trace(&self) -> Trace {
        if self.nature == Nature::Drive { Trace::Form } else { Trace::Time }
    }

    /// Returns `true` if whoever runs the machine brings it about.
    pub fn is_by_operator(&self) -> bool {
        self.origin == Origin::Operator
    }
}

/// What the library is made for: a machine, runs on it, and what their programs ask for.
pub struct Context<'a> {
    /// The machine believed in.
    pub machine: &'a Machine,
    /// The runs.
    pub runs: &'a [Run<'a>],
    /// Fastest programmed motion of each axis, mm/s.
    pub axis_feedrate: Vector,
    /// Fastest programmed feedrate, mm/s.
    pub feedrate: f64,
    /// Whether there are rapid moves.
    pub has_rapid: bool,
    /// Whether there are arcs.
    pub has_arc: bool,
    /// Whether a program sets tolerances.
    pub has_tolerance: bool,
}

impl<'a> Context<'a> {
    /// What the programs of the runs ask of a machine.
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
                    Motion::Rapid => {
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

/// An effect that may have been left out.
#[derive(Clone)]
pub struct Hypothesis {
    /// Which effect.
    pub effect: Effect,
    /// Which of several of that effect, for people: the axis, the rule; may be empty.
    pub variant: String,
    /// The parameters it frees.
    pub freed: Vec<FreeParameter>,
    /// The values tried first, one entry a parameter.
    pub trials: Vec<Vec<f64>>,
    /// Whether values between the trials mean anything.
    pub is_continuous: bool,
    /// How the values are reported.
    pub report: Report,
}

impl std::fmt::Debug for Hypothesis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.effect.id, self.variant)
    }
}

impl Hypothesis {
    /// An effect with parameters, the values tried first, and how values are reported.
    pub fn new(
        effect: Effect,
        freed: Vec<FreeParameter>,
        trials: Vec<Vec<f64>>,
        report: impl Fn(&[f64]) -> Vec<(Quantity, Reported)> + Send + Sync + 'static,
    ) -> Hypothesis {
        let report: Report = std::sync::Arc::new(report);
        Hypothesis { effect, variant: String::new(), freed, trials, is_continuous: true, report }
    }

    /// An effect with one parameter.
    pub fn single(
        effect: Effect,
        freed: FreeParameter,
        trials: Vec<f64>,
        report: impl Fn(f64) -> Vec<(Quantity, Reported)> + Send + Sync + 'static,
    ) -> Hypothesis {
        let trials = trials.into_iter().map(|value| vec![value]).collect();
        Hypothesis::new(effect, vec![freed], trials, move |values| report(values[0]))
    }

    /// Names which of several of the effect it is.
    pub fn variant(self, variant: impl Into<String>) -> Hypothesis {
        Hypothesis { variant: variant.into(), ..self }
    }

    /// Marks values between the trials as meaningless.
    pub fn at_trials_only(self) -> Hypothesis {
        Hypothesis { is_continuous: false, ..self }
    }

    /// Returns the name of the effect as people read it: its id with blanks.
    pub fn name(&self) -> String {
        let words = self.effect.name();
        if self.variant.is_empty() { words } else { format!("{words} ({})", self.variant) }
    }

    /// What trace it leaves.
    pub fn trace(&self) -> Trace {
        self.effect.trace()
    }

    /// Whether it is the same variant of the same effect as another.
    pub fn is_same_as(&self, other: &Hypothesis) -> bool {
        self.effect == other.effect && self.variant == other.variant
    }

    /// Whether it is a limit and nothing else, by which the machine is the slower the lower it is.
    pub fn is_limit(&self) -> bool {
        self.effect.nature == Nature::Limit && self.freed.len() == 1
    }

    /// Whether it varies what another one fits beside its own parameter.
    pub fn is_fitted_beside(&self, other: &Hypothesis) -> bool {
        let beside = other.freed.iter().skip(1);
        beside.into_iter().any(|beside| self.freed.iter().any(|own| own.handle == beside.handle))
    }

    /// The machine with these values.
    pub fn machine(&self, machine: &Machine, values: &[f64]) -> Machine {
        with(machine, &self.freed, values)
    }

    /// The values, core units, as they are reported; the uncertainty of each by how far it moves with the `deviations`
    /// of what is freed.
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

/// Numbers from `from` to `to` in even ratios.
pub fn ratios(from: f64, to: f64, count: usize) -> Vec<f64> {
    let part = |at: usize| at as f64 / (count - 1).max(1) as f64;
    (0..count).map(|at| from * (to / from).powf(part(at))).collect()
}
