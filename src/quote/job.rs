//! A job → its times and its price. Several programs make a part, each on a machine with a set-up.
//!
//! | symbol | of operation i                                       | inside |
//! |--------|------------------------------------------------------|--------|
//! | c      | cycle time of its program                            | s      |
//! | x      | tool changes in it                                   | s      |
//! | f      | the first of them, where its tool is in the spindle  | s      |
//! | t_s    | set-up, once a batch                                 | s      |
//! | t_l    | load and unload, each part                           | s      |
//! | p      | parts on the machine at a time                    | parts  |
//!
//! A batch of n parts is run in L = ⌈n / p⌉ loads. Without a fixture each part takes c. With a fixture, a
//! tool works on all parts of the load before the next tool change, so that a load pays each change once:
//!
//! ```text
//! a load of q parts      q (c − x) + x − f
//! a part of the batch    c − x + (x − f) L / n
//! ```
//!
//! A last load that is not full pays its changes in full. f is above 0 only if the operation before ran the
//! same parts on the same machine in the same load, so that this operation has neither set-up nor loading,
//! and left the first tool of this operation in the spindle. The order of the operations has no other effect.
//!
//! The price is that of [`offer_of_all`] with these cycles; a batch of another size has other loads, and so
//! another offer. Limits: moves from part to part, and spindle starts that a load could share, are ignored.

use crate::machine::Machine;
use crate::quote::offer::{OperationCharge, offer_of_all};
use crate::quote::{Breakdown, Offer, Quote, TERMS, Terms, Uncertainty};

/// A fixture for several parts on a machine at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fixture {
    /// Number of parts; at least one.
    pub parts: u32,
}

/// The times and tools of a program on its machine that a job needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlannedOperation {
    /// Contour tolerance, mm; the prevailing one if the program sets several.
    pub tolerance: f64,
    /// Cycle time by kind.
    pub cycle: Breakdown,
    /// CAM's estimate, s.
    pub programmed: f64,
    /// The first tool that the program calls, and the duration of its change, s.
    pub first_tool: Option<(u32, f64)>,
    /// The tool in the spindle at the end.
    pub last_tool: Option<u32>,
    /// Half of the range of the time on a calibrated machine, as a part of the time; `None` on other
    /// machines.
    pub range: Option<f64>,
    /// Largest error of the cycle time by the doubts that have a bound, s.
    pub in_doubt: f64,
    /// `true` if every doubt has a bound.
    pub is_bounded: bool,
}

impl PlannedOperation {
    /// Returns the time of a quoted program; `programmed` is CAM's estimate, s.
    pub fn of(quote: &Quote, programmed: f64) -> PlannedOperation {
        let tools = || quote.operations.iter().filter_map(|part| Some((part.operation.tool?, part)));
        PlannedOperation {
            tolerance: quote.tolerance,
            cycle: quote.breakdown,
            programmed,
            first_tool: tools().next().map(|(tool, part)| (tool, part.share.breakdown.tool_change)),
            last_tool: tools().next_back().map(|(tool, _)| tool),
            range: quote.range.as_ref().map(|range| range.ratio),
            in_doubt: quote.trust.seconds_in_doubt(),
            is_bounded: quote.trust.is_bounded(),
        }
    }
}

/// One program of a job, with the machine that runs it.
#[derive(Clone, Debug, PartialEq)]
pub struct JobOperation {
    /// Machine.
    pub machine: Machine,
    /// Set-up time of a batch, s.
    pub set_up: f64,
    /// Time to load and unload a part, s.
    pub loading: f64,
    /// Fixture for several parts at a time; `None` if parts are machined one after the other.
    pub fixture: Option<Fixture>,
    /// Time of its program.
    pub planned: PlannedOperation,
}

/// The operations that make a part, in order, and the terms of its offer; set-up and loading of the terms are
/// ignored.
#[derive(Clone, Debug, PartialEq)]
pub struct QuotedJob {
    /// Operations in order.
    pub operations: Vec<JobOperation>,
    /// Terms of the offer.
    pub terms: Terms,
}

/// Times of a batch, s.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BatchTimes {
    /// Cycle time of a part by kind, for each operation.
    pub cycles: Vec<Breakdown>,
    /// Cycle time of a part, all operations.
    pub part: f64,
    /// Least and greatest cycle time of a part; `None` if the uncertainty of an operation is unknown.
    pub range: Option<[f64; 2]>,
    /// Loading of a part, all operations.
    pub loading: f64,
    /// Set-up of the batch, all operations.
    pub set_up: f64,
    /// Time of the batch: set-up once, cycle and loading for each part; the operations run one after the
    /// other.
    pub batch: f64,
}

/// A term, or the rate of a machine, that is 0 or empty and therefore missing from the price.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MissingTerm {
    /// Key of the term or parameter.
    pub key: &'static str,
    /// Index of the operation; `None` for a term of the whole job.
    pub operation: Option<usize>,
}

/// Key of the machine's hourly rate.
const HOURLY_RATE_KEY: &str = "rates.hourly";

impl QuotedJob {
    /// Returns the cycle time of a part in a batch of `quantity` parts by kind, for each operation.
    pub fn cycles(&self, quantity: u32) -> Vec<Breakdown> {
        let mut before: Option<&JobOperation> = None;
        let cycles = self.operations.iter().map(|operation| {
            let in_spindle = before.filter(|before| continues_load(before, operation));
            before = Some(operation);
            cycle_of_part(operation, in_spindle.and_then(|before| before.planned.last_tool), quantity)
        });
        cycles.collect()
    }

    /// Returns the uncertainty of each operation's cycle time.
    pub fn uncertainties(&self) -> Vec<Uncertainty> {
        let of = |operation: &JobOperation| {
            let PlannedOperation { tolerance, range, .. } = operation.planned;
            Uncertainty::of(&self.terms, &operation.machine, tolerance, range)
        };
        self.operations.iter().map(of).collect()
    }

    /// Returns the uncertainty of each operation's cycle time as a part of that time; `None` if any is
    /// unknown.
    fn ratios(&self) -> Option<Vec<f64>> {
        self.uncertainties().into_iter().map(Uncertainty::ratio).collect()
    }

    /// Returns the times of a batch of `quantity` parts.
    pub fn times(&self, quantity: u32) -> BatchTimes {
        let cycles = self.cycles(quantity);
        let part: f64 = cycles.iter().map(Breakdown::total).sum();
        // All operations are taken at the same end of their range, as the errors of the machines may have the
        // same sign.
        let off = self.ratios().map(|ratios| -> f64 {
            cycles.iter().zip(ratios).map(|(cycle, ratio)| cycle.total() * ratio).sum()
        });
        let loading: f64 = self.operations.iter().map(|operation| operation.loading).sum();
        let set_up: f64 = self.operations.iter().map(|operation| operation.set_up).sum();
        BatchTimes {
            range: off.map(|off| [part - off, part + off]),
            batch: set_up + f64::from(quantity) * (part + loading),
            cycles,
            part,
            loading,
            set_up,
        }
    }

    /// Returns the offer of `quantity` parts.
    pub fn offer(&self, quantity: u32) -> Offer {
        self.offer_at(quantity, |_| 1.0)
    }

    /// Returns the offers of `quantity` parts at the least and at the greatest cycle times; `None` if the
    /// uncertainty of an operation is unknown.
    pub fn ends(&self, quantity: u32) -> Option<[Offer; 2]> {
        let ratios = self.ratios()?;
        Some([-1.0, 1.0].map(|side| self.offer_at(quantity, |index| 1.0 + side * ratios[index])))
    }

    fn offer_at(&self, quantity: u32, of_cycle: impl Fn(usize) -> f64) -> Offer {
        let cycles = self.cycles(quantity);
        let operations = self.operations.iter().zip(cycles).enumerate();
        let charges: Vec<OperationCharge> = operations
            .map(|(index, (operation, cycle))| OperationCharge {
                cycle,
                cycle_factor: of_cycle(index),
                machine: &operation.machine,
                set_up: operation.set_up,
                loading: operation.loading,
            })
            .collect();
        offer_of_all(&charges, &Terms { quantity, ..self.terms.clone() })
    }

    /// Returns the terms and rates that are missing from the price, in the order of the forms.
    pub fn missing(&self) -> Vec<MissingTerm> {
        let Terms { operator, material, other, fixed, margin, .. } = self.terms;
        let of_all = |key, value: f64| (value == 0.0).then_some(MissingTerm { key, operation: None });
        let of_each = |key, value: fn(&JobOperation) -> f64| -> Vec<MissingTerm> {
            let empty = |(_, operation): &(usize, &JobOperation)| value(operation) == 0.0;
            let empty: Vec<usize> =
                self.operations.iter().enumerate().filter(empty).map(|(index, _)| index).collect();
            if empty.len() == self.operations.len() {
                return vec![MissingTerm { key, operation: None }];
            }
            empty.into_iter().map(|index| MissingTerm { key, operation: Some(index) }).collect()
        };
        let mut missing = of_each(HOURLY_RATE_KEY, |operation| operation.machine.rates.hourly);
        missing.extend(of_each("set_up_min", |operation| operation.set_up));
        missing.extend(of_each("loading_s", |operation| operation.loading));
        let sums = [
            ("operator_hourly", operator),
            ("material", material),
            ("other", other),
            ("fixed", fixed),
            ("margin_percent", margin),
        ];
        missing.extend(sums.into_iter().filter_map(|(key, value)| of_all(key, value)));
        missing
    }
}

impl MissingTerm {
    /// Returns the label of the term or parameter.
    pub fn label(&self) -> &'static str {
        TERMS.iter().find(|term| term.key == self.key).map_or("Hourly rate of the machine", |term| term.label)
    }
}

/// Returns `true` if an operation continues with the load of the one before.
fn continues_load(before: &JobOperation, operation: &JobOperation) -> bool {
    operation.fixture.is_some()
        && before.fixture == operation.fixture
        && before.machine == operation.machine
        && operation.set_up == 0.0
        && operation.loading == 0.0
}

/// Returns the cycle time of a part by kind; `in_spindle` is the tool that the load before left in the
/// spindle.
fn cycle_of_part(operation: &JobOperation, in_spindle: Option<u32>, quantity: u32) -> Breakdown {
    let planned = &operation.planned;
    let Some(fixture) = operation.fixture else { return planned.cycle };
    let saved =
        planned.first_tool.filter(|(tool, _)| in_spindle == Some(*tool)).map_or(0.0, |(_, time)| time);
    let loads = f64::from(quantity.max(1).div_ceil(fixture.parts.max(1)));
    let tool_change = (planned.cycle.tool_change - saved).max(0.0) * loads / f64::from(quantity.max(1));
    Breakdown { tool_change, ..planned.cycle }
}

#[cfg(test)]
mod tests {
    // Laws of jobs, over numbers that look like anything.

    use super::*;
    use crate::quote::offer;
    use crate::quote::offer::tests::cases;

    /// An operation with these terms' set-up and loading.
    fn operation(cycle: Breakdown, machine: &Machine, terms: &Terms) -> JobOperation {
        JobOperation {
            machine: machine.clone(),
            set_up: terms.set_up,
            loading: terms.loading,
            fixture: None,
            planned: PlannedOperation {
                tolerance: 0.01,
                cycle,
                is_bounded: true,
                ..PlannedOperation::default()
            },
        }
    }

    /// Jobs of three operations whose numbers are those of three cases in a row.
    fn jobs(mut check: impl FnMut(QuotedJob)) {
        let mut operations = Vec::new();
        cases(|cycle, machine, terms| {
            operations.push(operation(cycle, &machine, &terms));
            if operations.len() == 3 {
                check(QuotedJob { operations: std::mem::take(&mut operations), terms });
            }
        });
    }

    /// All orders of three.
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

    fn in_order(job: &QuotedJob, order: [usize; 3]) -> QuotedJob {
        QuotedJob {
            operations: order.map(|index| job.operations[index].clone()).to_vec(),
            terms: job.terms.clone(),
        }
    }

    #[test]
    fn a_job_of_one_operation_is_todays_quote_bit_for_bit() {
        cases(|cycle, machine, terms| {
            let job =
                QuotedJob { operations: vec![operation(cycle, &machine, &terms)], terms: terms.clone() };
            let plain = offer(&cycle, 1.0, &machine, &terms);
            for quantity in [terms.quantity, 1, 7] {
                let mut own = job.offer(quantity);
                own.quantity = terms.quantity;
                assert_eq!(own, plain);
            }
            assert_eq!(job.times(terms.quantity).part.to_bits(), cycle.total().to_bits());
            let given = QuotedJob { terms: Terms { uncertainty: Some(0.25), ..terms.clone() }, ..job };
            let ends = [0.75, 1.25].map(|of_cycle| offer(&cycle, of_cycle, &machine, &given.terms));
            assert_eq!(given.ends(terms.quantity), Some(ends));
        });
    }

    #[test]
    fn the_total_is_the_sum_of_the_amounts_in_sight() {
        jobs(|job| {
            let quantity = job.terms.quantity;
            let offer = job.offer(quantity);
            let times = |once: bool| if once { 1 } else { i128::from(quantity) };
            let sum: i128 = offer.addends.iter().map(|addend| times(addend.once) * addend.steps).sum();
            assert_eq!(sum, offer.total());
            assert_eq!(offer.cycles.len(), 3);
            // Those of an operation alone are those it has in a job without margin.
            for (index, operation) in job.operations.iter().enumerate() {
                let own = |addend: &crate::quote::Addend| addend.operation == Some(index);
                let steps: i128 =
                    offer.addends.iter().filter(|addend| own(addend)).map(|addend| addend.steps).sum();
                let bare = Terms { fixed: 0.0, material: 0.0, other: 0.0, margin: 0.0, ..job.terms.clone() };
                let alone = QuotedJob { operations: vec![operation.clone()], terms: bare }.offer(quantity);
                assert_eq!(steps, alone.once + alone.part);
            }
        });
    }

    #[test]
    fn the_order_changes_nothing_where_no_tool_change_is_shared() {
        jobs(|job| {
            let quantity = job.terms.quantity;
            for order in ORDERS {
                let other = in_order(&job, order);
                let [one, two] = [job.offer(quantity), other.offer(quantity)];
                assert_eq!((one.once, one.part), (two.once, two.part));
                let [one, two] = [job.times(quantity), other.times(quantity)];
                assert!((one.batch - two.batch).abs() < 1e-9 * one.batch);
            }
        });
    }

    #[test]
    fn on_a_fixture_the_order_changes_the_shared_tool_changes_and_nothing_else() {
        let mut shared = 0;
        jobs(|mut job| {
            let machine = job.operations[0].machine.clone();
            for (index, operation) in job.operations.iter_mut().enumerate() {
                operation.machine = machine.clone();
                (operation.set_up, operation.loading) = (0.0, 0.0);
                operation.fixture = Some(Fixture { parts: 4 });
                let first = operation.planned.cycle.tool_change / 2.0;
                operation.planned.first_tool = Some((index as u32 % 2, first));
                operation.planned.last_tool = Some(1);
            }
            // T0 … T1, T1 … T1, T0 … T1: only the second can follow on its tool.
            let quantity = job.terms.quantity;
            let loads = f64::from(quantity.div_ceil(4)) / f64::from(quantity);
            for order in ORDERS {
                let other = in_order(&job, order);
                let cycle: f64 = other.times(quantity).part;
                let full: f64 = job
                    .operations
                    .iter()
                    .map(|operation| {
                        let cycle = operation.planned.cycle;
                        cycle.total() - cycle.tool_change * (1.0 - loads)
                    })
                    .sum();
                let follows = order[0] != 1;
                let saved = job.operations[1].planned.cycle.tool_change / 2.0 * loads;
                shared += usize::from(follows);
                let expected = if follows { full - saved } else { full };
                assert!((cycle - expected).abs() < 1e-9 * full, "{order:?}: {cycle} instead of {expected}");
            }
        });
        assert!(0 < shared);
    }

    #[test]
    fn a_load_pays_its_changes_once_and_the_last_one_too_where_it_is_not_full() {
        let cycle = Breakdown { cutting: 100.0, tool_change: 12.0, ..Breakdown::default() };
        let mut one = operation(cycle, &Machine::default(), &Terms::default());
        one.fixture = Some(Fixture { parts: 4 });
        let job = QuotedJob { operations: vec![one], terms: Terms::default() };
        for (quantity, loads) in [(1, 1.0), (4, 1.0), (5, 2.0), (8, 2.0), (9, 3.0)] {
            let times = job.times(quantity);
            assert!((times.batch - (100.0 * f64::from(quantity) + 12.0 * loads)).abs() < 1e-9, "{quantity}");
        }
    }

    #[test]
    fn where_one_machine_is_unknown_the_whole_has_no_range() {
        let machine = Machine { cycle_time_error: Some(0.1), ..Machine::default() };
        let cycle = Breakdown { cutting: 100.0, ..Breakdown::default() };
        let tolerance = machine.interpolator.contour_tolerance;
        let mut one = operation(cycle, &machine, &Terms::default());
        one.planned.tolerance = tolerance;
        let mut job = QuotedJob { operations: vec![one.clone(), one], terms: Terms::default() };
        let [low, high] = job.times(1).range.expect("both are known");
        assert!((low - 180.0).abs() < 1e-9 && (high - 220.0).abs() < 1e-9);
        job.operations[1].machine.cycle_time_error = None;
        assert_eq!((job.times(1).range, job.ends(1)), (None, None));
    }

    #[test]
    fn what_is_nothing_is_not_in_the_price_yet() {
        let cycle = Breakdown { cutting: 100.0, ..Breakdown::default() };
        let one = operation(cycle, &Machine::default(), &Terms::default());
        let mut job = QuotedJob {
            operations: vec![one.clone(), one],
            terms: Terms { margin: 0.1, ..Terms::default() },
        };
        let keys =
            |job: &QuotedJob| job.missing().iter().map(|gap| (gap.key, gap.operation)).collect::<Vec<_>>();
        assert_eq!(
            keys(&job),
            [
                ("rates.hourly", None),
                ("set_up_min", None),
                ("loading_s", None),
                ("operator_hourly", None),
                ("material", None),
                ("other", None),
                ("fixed", None),
            ]
        );
        job.operations[0].machine.rates.hourly = 80.0;
        job.operations[1].set_up = 60.0;
        assert_eq!(keys(&job)[..2], [("rates.hourly", Some(1)), ("set_up_min", Some(0))]);
        assert_eq!(job.missing()[0].label(), "Hourly rate of the machine");
    }
}
