//! Cycle time → price of a batch, with every addend.
//!
//! With the rate r_m of the machine and the terms of [`Terms`](crate::quote::Terms):
//!
//! ```text
//! once     O = t_s r_m + t_s r_o + fixed,            its margin k O
//! a part   P = c r_m + c a r_o + t_l r_m + t_l r_o + material + other,   its margin k P
//! price of n parts = (1 + k) O + n (1 + k) P
//! ```
//!
//! where c is the cycle time, with one addend per kind of time; the terms define the other symbols. A
//! margin m of the price gives k = m / (1 − m), a margin on cost k = m. Every addend is rounded to a whole
//! number of steps of the currency. Sums are therefore exact, and the price of one part, (1 + k) (P + O / n),
//! falls strictly with n if O > 0. Amounts of one whole (the kinds of a cycle, its operations) are rounded as
//! running sums, so that they add up exactly to the rounded whole.
//!
//! If several operations make a part, each on its machine, O and P are sums over the operations, with fixed,
//! material and other cost once.
//!
//! Limits: discounts, scrap and taxes are ignored.

use crate::machine::Machine;
use crate::quote::{Breakdown, MarginOf, Rounding, Terms};
use crate::simulation::ordered::sort_by_number;
use crate::units::SECONDS_PER_HOUR;

/// The purpose of an amount.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AddendKind {
    /// Machine time of the set-up.
    SetUpMachine,
    /// Operator time of the set-up.
    SetUpOperator,
    /// Fixed cost of the batch.
    Fixed,
    /// Margin on the amounts paid once.
    MarginOnce,
    /// Machine time of feed moves.
    Cutting,
    /// Machine time of rapid moves.
    Rapid,
    /// Machine time of dwells.
    Dwell,
    /// Machine time of tool changes.
    ToolChange,
    /// Machine time of everything else in a cycle.
    OtherTime,
    /// Operator time during the cycle.
    Attendance,
    /// Machine time of loading.
    LoadingMachine,
    /// Operator time of loading.
    LoadingOperator,
    /// Material.
    Material,
    /// Other cost.
    OtherCost,
    /// Margin on the amounts paid for each part.
    MarginPart,
}

/// One amount of a price.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Addend {
    /// Purpose of the amount.
    pub item: AddendKind,
    /// Index of the operation; `None` for an amount of the part or the batch.
    pub operation: Option<usize>,
    /// `true` if paid once for the batch, `false` if for each part.
    pub once: bool,
    /// Time that is paid, s; `None` for an amount that is no time.
    pub time: Option<f64>,
    /// Price of the time, currency per s.
    pub rate: Option<f64>,
    /// Amount in steps of the currency.
    pub steps: i128,
}

/// The price of a batch. Amounts are in steps of the currency.
#[derive(Clone, Debug, PartialEq)]
pub struct Offer {
    /// All amounts that are not 0; `total` is their sum.
    pub addends: Vec<Addend>,
    /// Number of parts.
    pub quantity: u32,
    /// Sum of the amounts paid once.
    pub once: i128,
    /// Sum of the amounts paid for each part.
    pub part: i128,
    /// Cost of machine and operator during the cycle of each operation, before the margin.
    pub cycles: Vec<i128>,
    /// Size of a step.
    pub rounding: Rounding,
}

impl Offer {
    /// Returns the price of `quantity` parts, in steps.
    pub fn total_of(&self, quantity: u32) -> i128 {
        self.once + i128::from(quantity) * self.part
    }

    /// Returns the price of the batch, in steps.
    pub fn total(&self) -> i128 {
        self.total_of(self.quantity)
    }

    /// Converts steps to the currency.
    pub fn amount(&self, steps: i128) -> f64 {
        steps as f64 / self.rounding.steps()
    }

    /// Returns the price of one of `quantity` parts, in the currency; not rounded.
    pub fn unit_price(&self, quantity: u32) -> f64 {
        self.amount(self.total_of(quantity)) / f64::from(quantity.max(1))
    }

    /// Returns the cost of machine and operator during the cycle of a part, before the margin, in steps.
    pub fn cycle(&self) -> i128 {
        self.cycles.iter().sum()
    }

    /// Divides the cost of the cycle (`cycle`) in proportion to `times`, in steps; the results add up to the
    /// whole.
    pub fn by_time(&self, times: &[f64]) -> Vec<i128> {
        apportioned(self.cycle(), times)
    }
}

/// Relative difference below which two tolerances count as equal: a calibration does not determine its
/// tolerance more exactly.
const EQUAL_TOLERANCE_RATIO: f64 = 0.01;

/// The uncertainty of a cycle time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Uncertainty {
    /// The estimator's value, as a part of the time.
    Given(f64),
    /// The error at the machine's calibration, at this tolerance, as a part of the time.
    Calibrated(f64),
    /// The error at the machine's calibration, as a part of the time; it was measured at other tolerances
    /// than this one.
    Elsewhere(f64),
    /// Unknown.
    Unknown,
}

impl Uncertainty {
    /// Returns the uncertainty of a cycle time on a machine at a contour tolerance, mm; `range` is the
    /// possible error of the program on a machine calibrated on other programs, as a part of the time.
    pub fn of(terms: &Terms, machine: &Machine, tolerance: f64, range: Option<f64>) -> Uncertainty {
        let is_near = |other: &f64| (other / tolerance - 1.0).abs() < EQUAL_TOLERANCE_RATIO;
        let is_measured = machine.tolerances_of_error().iter().any(is_near);
        let known = if is_measured { Uncertainty::Calibrated } else { Uncertainty::Elsewhere };
        let own = [range, machine.cycle_time_error].into_iter().flatten().reduce(f64::max);
        let own = own.map_or(Uncertainty::Unknown, known);
        terms.uncertainty.map_or(own, Uncertainty::Given)
    }

    /// Returns the uncertainty as a part of the cycle time; `None` if unknown.
    pub fn ratio(self) -> Option<f64> {
        match self {
            Uncertainty::Given(ratio) | Uncertainty::Calibrated(ratio) => Some(ratio),
            Uncertainty::Elsewhere(_) | Uncertainty::Unknown => None,
        }
    }
}

/// The times of an operation that the customer pays, and its machine.
#[derive(Clone, Copy, Debug)]
pub struct OperationCharge<'a> {
    /// Cycle time by kind.
    pub cycle: Breakdown,
    /// Factor on the cycle; values other than 1 give the price at the ends of an uncertain cycle time.
    pub cycle_factor: f64,
    /// Machine that runs the operation.
    pub machine: &'a Machine,
    /// Set-up time, s.
    pub set_up: f64,
    /// Time to load and unload a part, s.
    pub loading: f64,
}

/// Returns the offer of a batch whose parts each take `cycle` times the factor `of_cycle`.
pub fn offer(cycle: &Breakdown, of_cycle: f64, machine: &Machine, terms: &Terms) -> Offer {
    let charge = OperationCharge {
        cycle: *cycle,
        cycle_factor: of_cycle,
        machine,
        set_up: terms.set_up,
        loading: terms.loading,
    };
    offer_of_all(&[charge], terms)
}

/// Returns the offer of a batch whose parts each need these operations.
pub fn offer_of_all(charges: &[OperationCharge], terms: &Terms) -> Offer {
    let steps = |amount: f64| (amount * terms.rounding.steps()).round() as i128;
    let sum = |item, once, amount: f64| Addend {
        item,
        operation: None,
        once,
        time: None,
        rate: None,
        steps: steps(amount),
    };
    let operation_cost: Vec<OperationCost> =
        charges.iter().enumerate().map(|(index, charge)| paid(index, charge, terms)).collect();
    let mut addends: Vec<Addend> = operation_cost.iter().flat_map(|paid| paid.once).collect();
    addends.push(sum(AddendKind::Fixed, true, terms.fixed));
    addends.extend(operation_cost.iter().flat_map(|paid| paid.part));
    addends.extend([
        sum(AddendKind::Material, false, terms.material),
        sum(AddendKind::OtherCost, false, terms.other),
    ]);
    let on_cost = match terms.margin_of {
        MarginOf::Price => terms.margin / (1.0 - terms.margin),
        MarginOf::Cost => terms.margin,
    };
    let margin = |item, once| {
        let cost = total(&addends, once);
        Addend { steps: (cost as f64 * on_cost).round() as i128, ..sum(item, once, 0.0) }
    };
    let margins = [margin(AddendKind::MarginOnce, true), margin(AddendKind::MarginPart, false)];
    addends.extend(margins);
    addends.retain(|addend| addend.steps != 0);
    sort_by_number(&mut addends, |addend| f64::from(!addend.once));
    Offer {
        quantity: terms.quantity,
        once: total(&addends, true),
        part: total(&addends, false),
        cycles: operation_cost.into_iter().map(|paid| paid.cycle).collect(),
        rounding: terms.rounding,
        addends,
    }
}

/// The cost of an operation without its margin.
struct OperationCost {
    once: [Addend; 2],
    part: [Addend; 8],
    /// Cost of machine and operator during the cycle, in steps.
    cycle: i128,
}

fn paid(index: usize, charge: &OperationCharge, terms: &Terms) -> OperationCost {
    let steps = |amount: f64| (amount * terms.rounding.steps()).round() as i128;
    let machine_rate = charge.machine.rates.hourly / SECONDS_PER_HOUR;
    let timed = |item, once, time: f64, rate: f64| {
        let steps = steps(time * rate);
        Addend { item, operation: Some(index), once, time: Some(time), rate: Some(rate), steps }
    };
    let kinds = [
        (AddendKind::Cutting, charge.cycle.cutting),
        (AddendKind::Rapid, charge.cycle.rapid),
        (AddendKind::Dwell, charge.cycle.dwell),
        (AddendKind::ToolChange, charge.cycle.tool_change),
        (AddendKind::OtherTime, charge.cycle.other),
    ]
    .map(|(item, time)| (item, time * charge.cycle_factor));
    let times = kinds.map(|(_, time)| time);
    let whole: f64 = times.iter().sum();
    let by_kind = apportioned(steps(whole * machine_rate), &times);
    let run = [0, 1, 2, 3, 4].map(|kind| {
        let (item, time) = kinds[kind];
        Addend { steps: by_kind[kind], ..timed(item, false, time, machine_rate) }
    });
    let attendance = timed(AddendKind::Attendance, false, whole * terms.attendance, terms.operator);
    let [cutting, rapid, dwell, tool_change, other] = run;
    OperationCost {
        once: [
            timed(AddendKind::SetUpMachine, true, charge.set_up, machine_rate),
            timed(AddendKind::SetUpOperator, true, charge.set_up, terms.operator),
        ],
        part: [
            cutting,
            rapid,
            dwell,
            tool_change,
            other,
            attendance,
            timed(AddendKind::LoadingMachine, false, charge.loading, machine_rate),
            timed(AddendKind::LoadingOperator, false, charge.loading, terms.operator),
        ],
        cycle: by_kind.iter().sum::<i128>() + attendance.steps,
    }
}

/// Returns the sum of the amounts paid once, or of those paid for each part, in steps.
fn total(addends: &[Addend], once: bool) -> i128 {
    addends.iter().filter(|addend| addend.once == once).map(|addend| addend.steps).sum()
}

/// Divides a whole by weights into differences of rounded running sums, which add up to it.
fn apportioned(whole: i128, weights: &[f64]) -> Vec<i128> {
    let all: f64 = weights.iter().sum();
    let (mut running, mut given) = (0.0, 0);
    let last = weights.iter().rposition(|weight| 0.0 < *weight);
    let part = |(index, weight): (usize, &f64)| {
        running += weight;
        let up_to =
            if last == Some(index) { whole } else { (whole as f64 * (running / all)).round() as i128 };
        let up_to = if 0.0 < *weight { up_to.min(whole) } else { given };
        let part = up_to - given;
        given = up_to;
        part
    };
    weights.iter().enumerate().map(part).collect()
}

#[cfg(test)]
pub(super) mod tests {
    // Laws of the price, over numbers that look like anything.

    use super::*;
    use crate::machine::Rates;

    const HOUR: f64 = SECONDS_PER_HOUR;

    /// Numbers that look like anything, the same in each run.
    struct Random(u64);

    impl Random {
        fn below(&mut self, most: f64) -> f64 {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            most * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
        }
    }

    pub(in crate::quote) fn cases(mut check: impl FnMut(Breakdown, Machine, Terms)) {
        let mut random = Random(7);
        for case in 0..2000 {
            let cycle = Breakdown {
                cutting: random.below(4000.0),
                rapid: random.below(200.0),
                dwell: if case % 3 == 0 { 0.0 } else { random.below(5.0) },
                tool_change: random.below(60.0),
                other: random.below(3.0),
                ..Breakdown::default()
            };
            let machine = Machine { rates: Rates { hourly: random.below(300.0) }, ..Machine::default() };
            let rounding = [Rounding::Units, Rounding::Hundredths, Rounding::TenThousandths][case % 3];
            let terms = Terms {
                quantity: 1 + random.below(5000.0) as u32,
                set_up: random.below(5.0) * HOUR,
                loading: random.below(600.0),
                operator: random.below(80.0) / HOUR,
                attendance: random.below(1.0),
                material: random.below(40.0),
                other: random.below(4.0),
                fixed: random.below(500.0),
                margin: random.below(0.9),
                margin_of: if case % 2 == 0 { MarginOf::Price } else { MarginOf::Cost },
                rounding,
                ..Terms::default()
            };
            check(cycle, machine, terms);
        }
    }

    #[test]
    fn the_addends_are_the_total_to_the_step() {
        cases(|cycle, machine, terms| {
            let offer = offer(&cycle, 1.0, &machine, &terms);
            let times = |addend: &Addend| if addend.once { 1 } else { i128::from(terms.quantity) };
            let sum: i128 = offer.addends.iter().map(|addend| times(addend) * addend.steps).sum();
            assert_eq!(sum, offer.total());
            assert!(offer.addends.iter().all(|addend| 0 < addend.steps));
        });
    }

    #[test]
    fn each_addend_is_its_time_at_its_rate() {
        cases(|cycle, machine, terms| {
            for addend in offer(&cycle, 1.0, &machine, &terms).addends {
                if let (Some(time), Some(rate)) = (addend.time, addend.rate) {
                    let exact = time * rate * terms.rounding.steps();
                    assert!((exact - addend.steps as f64).abs() <= 1.0 + 1e-9, "{addend:?}: {exact}");
                }
            }
        });
    }

    #[test]
    fn a_part_gets_cheaper_with_the_quantity_where_something_is_paid_once_and_only_there() {
        cases(|cycle, machine, terms| {
            let dear = offer(&cycle, 1.0, &machine, &terms);
            let level = offer(&cycle, 1.0, &machine, &Terms { set_up: 0.0, fixed: 0.0, ..terms.clone() });
            for (n, more) in [(1u32, 2u32), (2, 3), (9, 10), (99, 5000), (999_999, 1_000_000)] {
                // n₁ total(n₂) < n₂ total(n₁) is unit(n₂) < unit(n₁) without rounding.
                let cross = |offer: &Offer| {
                    (i128::from(n) * offer.total_of(more), i128::from(more) * offer.total_of(n))
                };
                let (low, high) = cross(&dear);
                assert_eq!(low < high, 0 < dear.once);
                let (low, high) = cross(&level);
                assert_eq!(low, high);
                assert!(dear.total_of(n) <= dear.total_of(more));
            }
        });
    }

    #[test]
    fn a_margin_is_what_it_is_called() {
        cases(|cycle, machine, terms| {
            let offer = offer(&cycle, 1.0, &machine, &terms);
            for once in [true, false] {
                let price = total(&offer.addends, once) as f64;
                let of = |is_margin: bool| -> f64 {
                    let is = |addend: &&Addend| {
                        matches!(addend.item, AddendKind::MarginOnce | AddendKind::MarginPart) == is_margin
                    };
                    offer.addends.iter().filter(|a| a.once == once).filter(is).map(|a| a.steps as f64).sum()
                };
                let (margin, cost) = (of(true), of(false));
                let expected = match terms.margin_of {
                    MarginOf::Price => terms.margin * price,
                    MarginOf::Cost => terms.margin * cost,
                };
                assert!((margin - expected).abs() <= 1.0, "{margin} instead of {expected}");
            }
        });
    }

    #[test]
    fn operations_share_the_cycle_to_the_step() {
        cases(|cycle, machine, terms| {
            let offer = offer(&cycle, 1.0, &machine, &terms);
            let times = [cycle.cutting, 0.0, cycle.rapid, cycle.other, 0.0];
            let shares = offer.by_time(&times);
            assert_eq!(shares.iter().sum::<i128>(), offer.cycle());
            assert_eq!((shares[1], shares[4]), (0, 0));
            let all: f64 = times.iter().sum();
            for (share, time) in shares.iter().zip(times) {
                assert!((*share as f64 - offer.cycle() as f64 * time / all).abs() <= 1.0);
            }
        });
        assert_eq!(apportioned(0, &[]), []);
        assert_eq!(apportioned(5, &[1.0, 1.0]).iter().sum::<i128>(), 5);
    }

    #[test]
    fn neutral_terms_are_the_machines_time_and_nothing_else() {
        let machine = Machine { rates: Rates { hourly: 90.0 }, ..Machine::default() };
        let cycle = Breakdown { cutting: 100.0, rapid: 20.0, ..Breakdown::default() };
        let offer = offer(&cycle, 1.0, &machine, &Terms::default());
        assert_eq!(offer.amount(offer.total()), 3.0);
        assert_eq!(offer.amount(offer.total()), crate::quote::price(120.0, &machine));
        let items: Vec<AddendKind> = offer.addends.iter().map(|addend| addend.item).collect();
        assert_eq!(items, [AddendKind::Cutting, AddendKind::Rapid]);
    }

    #[test]
    fn a_longer_cycle_costs_more_and_what_is_paid_once_does_not_change() {
        cases(|cycle, machine, terms| {
            let at = |of_cycle| offer(&cycle, of_cycle, &machine, &terms);
            let (low, mid, high) = (at(0.9), at(1.0), at(1.1));
            assert!(low.part <= mid.part && mid.part <= high.part);
            assert_eq!((low.once, mid.once), (mid.once, high.once));
        });
    }

    #[test]
    fn an_uncertainty_is_entered_or_calibrated_or_unknown() {
        let (mut machine, mut terms) = (Machine::default(), Terms::default());
        let at =
            |terms: &Terms, machine: &Machine, tolerance| Uncertainty::of(terms, machine, tolerance, None);
        assert_eq!(at(&terms, &machine, 0.01), Uncertainty::Unknown);
        machine.cycle_time_error = Some(0.02);
        assert_eq!(at(&terms, &machine, 0.01), Uncertainty::Calibrated(0.02));
        assert_eq!(at(&terms, &machine, 0.02), Uncertainty::Elsewhere(0.02));
        machine.calibrated_at = vec![0.02, 0.05];
        assert_eq!(at(&terms, &machine, 0.02), Uncertainty::Calibrated(0.02));
        assert_eq!(at(&terms, &machine, 0.01), Uncertainty::Elsewhere(0.02));
        // On a machine that knows how far off it is on other programs, that counts, but no less than what it was off by.
        let ranged = |range| Uncertainty::of(&terms, &machine, 0.02, Some(range));
        assert_eq!([ranged(0.05), ranged(0.01)], [0.05, 0.02].map(Uncertainty::Calibrated));
        terms.uncertainty = Some(0.1);
        assert_eq!(at(&terms, &machine, 0.01), Uncertainty::Given(0.1));
        assert_eq!((Uncertainty::Unknown.ratio(), Uncertainty::Elsewhere(0.02).ratio()), (None, None));
    }
}
