//! Cycle time → price of a batch, every addend in sight.
//!
//! With the rate r_m of the machine and the terms of [`Terms`](crate::quote::Terms):
//!
//! ```text
//! once     O = t_s r_m + t_s r_o + fixed,            its margin k O
//! a part   P = c r_m + c a r_o + t_l r_m + t_l r_o + material + other,   its margin k P
//! price of n parts = (1 + k) O + n (1 + k) P
//! ```
//!
//! where c is the cycle time, its kinds of time each an addend of their own, and k = m / (1 − m) for a
//! margin of the price, k = m for one on cost. Every addend is rounded to a step of the currency and is a whole
//! number of steps from there on, so that sums are exact, and the price of one part, P + O / n, falls
//! strictly with n where O > 0. What belongs together (the kinds of a cycle, its operations) is rounded as running sums,
//! so that its parts add up to the whole to the step.
//!
//! Left out: discounts, scrap, taxes.

use crate::machine::Machine;
use crate::quote::{Breakdown, MarginOf, Rounding, Terms};
use crate::units::SECONDS_PER_HOUR;

/// What an amount is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// The machine stands while it is set up.
    SetUpMachine,
    /// The operator sets it up.
    SetUpOperator,
    /// Fixed cost of the batch.
    Fixed,
    /// Margin on what is paid once.
    MarginOnce,
    /// The machine, on feed moves.
    Cutting,
    /// The machine, on rapid moves.
    Rapid,
    /// The machine, in dwells.
    Dwell,
    /// The machine, changing tools.
    ToolChange,
    /// The machine, in all else that a cycle has.
    OtherTime,
    /// The operator, during the cycle.
    Attendance,
    /// The machine stands while it is loaded.
    LoadingMachine,
    /// The operator loads it.
    LoadingOperator,
    /// Material.
    Material,
    /// Other cost.
    OtherCost,
    /// Margin on a part.
    MarginPart,
}

/// One amount, and what it is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Addend {
    /// What it is for.
    pub item: Item,
    /// Once for the batch, or for each part.
    pub once: bool,
    /// Time that is paid, s; none where it is no time.
    pub time: Option<f64>,
    /// Price of that time, currency per s.
    pub rate: Option<f64>,
    /// The amount in steps of the currency.
    pub steps: i128,
}

/// The price of a batch. Amounts are in steps of the currency.
#[derive(Clone, Debug, PartialEq)]
pub struct Offer {
    /// All amounts that are not nothing; `total` is made of these alone.
    pub addends: Vec<Addend>,
    /// How many parts.
    pub quantity: u32,
    /// Sum of what is paid once.
    pub once: i128,
    /// Sum of what is paid for each part.
    pub part: i128,
    /// What machine and operator cost during one cycle, before the margin.
    pub cycle: i128,
    /// What a step is.
    pub rounding: Rounding,
}

impl Offer {
    /// Price of so many parts.
    pub fn total_of(&self, quantity: u32) -> i128 {
        self.once + i128::from(quantity) * self.part
    }

    /// Price of the batch.
    pub fn total(&self) -> i128 {
        self.total_of(self.quantity)
    }

    /// An amount in the currency.
    pub fn amount(&self, steps: i128) -> f64 {
        steps as f64 / self.rounding.steps()
    }

    /// Price of one of so many parts, in the currency; not rounded.
    pub fn unit_price(&self, quantity: u32) -> f64 {
        self.amount(self.total_of(quantity)) / f64::from(quantity.max(1))
    }

    /// The part of a cycle's cost that falls to each of its parts, by their times; together the whole.
    pub fn by_time(&self, times: &[f64]) -> Vec<i128> {
        apportioned(self.cycle, times)
    }
}

/// Tolerances that differ by a smaller part are the same: a calibration knows its own no better.
const SAME_TOLERANCE: f64 = 0.01;

/// How sure a cycle time is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Uncertainty {
    /// The estimator says so, as a part of it.
    Given(f64),
    /// It was off by that part where the machine was calibrated, at this tolerance.
    Calibrated(f64),
    /// It was off by that part at other tolerances, and nobody has measured at this one.
    Elsewhere(f64),
    /// Nobody knows.
    Unknown,
}

impl Uncertainty {
    /// That of a cycle time on a machine at a contour tolerance, mm.
    pub fn of(terms: &Terms, machine: &Machine, tolerance: f64) -> Uncertainty {
        let is_near = |other: &f64| (other / tolerance - 1.0).abs() < SAME_TOLERANCE;
        let is_measured = machine.tolerances_of_error().iter().any(is_near);
        let known = if is_measured { Uncertainty::Calibrated } else { Uncertainty::Elsewhere };
        let own = machine.cycle_time_error.map_or(Uncertainty::Unknown, known);
        terms.uncertainty.map_or(own, Uncertainty::Given)
    }

    /// As a part of the cycle time.
    pub fn ratio(self) -> Option<f64> {
        match self {
            Uncertainty::Given(ratio) | Uncertainty::Calibrated(ratio) => Some(ratio),
            Uncertainty::Elsewhere(_) | Uncertainty::Unknown => None,
        }
    }
}

/// The price of a batch whose parts take such a cycle, times the factor `of_cycle`, which tells what an uncertain cycle time
/// costs at its ends.
pub fn offer(cycle: &Breakdown, of_cycle: f64, machine: &Machine, terms: &Terms) -> Offer {
    let step = terms.rounding.steps();
    let steps = |amount: f64| (amount * step).round() as i128;
    let machine_rate = machine.rates.hourly / SECONDS_PER_HOUR;
    let timed = |item, once, time: f64, rate: f64| {
        let steps = steps(time * rate);
        Addend { item, once, time: Some(time), rate: Some(rate), steps }
    };
    let sum = |item, once, amount: f64| Addend { item, once, time: None, rate: None, steps: steps(amount) };

    let kinds = [
        (Item::Cutting, cycle.cutting),
        (Item::Rapid, cycle.rapid),
        (Item::Dwell, cycle.dwell),
        (Item::ToolChange, cycle.tool_change),
        (Item::OtherTime, cycle.other),
    ]
    .map(|(item, time)| (item, time * of_cycle));
    let times = kinds.map(|(_, time)| time);
    let whole: f64 = times.iter().sum();
    let by_kind = apportioned(steps(whole * machine_rate), &times);
    let run = kinds
        .into_iter()
        .zip(&by_kind)
        .map(|((item, time), &steps)| Addend { steps, ..timed(item, false, time, machine_rate) });
    let attendance = timed(Item::Attendance, false, whole * terms.attendance, terms.operator);

    let mut addends = vec![
        timed(Item::SetUpMachine, true, terms.set_up, machine_rate),
        timed(Item::SetUpOperator, true, terms.set_up, terms.operator),
        sum(Item::Fixed, true, terms.fixed),
    ];
    addends.extend(run);
    addends.extend([
        attendance,
        timed(Item::LoadingMachine, false, terms.loading, machine_rate),
        timed(Item::LoadingOperator, false, terms.loading, terms.operator),
        sum(Item::Material, false, terms.material),
        sum(Item::OtherCost, false, terms.other),
    ]);
    let cost = |once: bool| -> i128 { total(&addends, once) };
    let on_cost = match terms.margin_of {
        MarginOf::Price => terms.margin / (1.0 - terms.margin),
        MarginOf::Cost => terms.margin,
    };
    let margin = |item, once| Addend {
        item,
        once,
        time: None,
        rate: None,
        steps: (cost(once) as f64 * on_cost).round() as i128,
    };
    let margins = [margin(Item::MarginOnce, true), margin(Item::MarginPart, false)];
    addends.extend(margins);
    addends.retain(|addend| addend.steps != 0);
    addends.sort_by_key(|addend| !addend.once);
    Offer {
        quantity: terms.quantity,
        once: total(&addends, true),
        part: total(&addends, false),
        cycle: by_kind.iter().sum::<i128>() + attendance.steps,
        rounding: terms.rounding,
        addends,
    }
}

/// What is paid once, or for each part.
fn total(addends: &[Addend], once: bool) -> i128 {
    addends.iter().filter(|addend| addend.once == once).map(|addend| addend.steps).sum()
}

/// A whole in parts by weight: differences of rounded running sums, which together are the whole.
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
mod tests {
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

    fn cases(mut check: impl FnMut(Breakdown, Machine, Terms)) {
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
                        matches!(addend.item, Item::MarginOnce | Item::MarginPart) == is_margin
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
            assert_eq!(shares.iter().sum::<i128>(), offer.cycle);
            assert_eq!((shares[1], shares[4]), (0, 0));
            let all: f64 = times.iter().sum();
            for (share, time) in shares.iter().zip(times) {
                assert!((*share as f64 - offer.cycle as f64 * time / all).abs() <= 1.0);
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
        let items: Vec<Item> = offer.addends.iter().map(|addend| addend.item).collect();
        assert_eq!(items, [Item::Cutting, Item::Rapid]);
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
        let at = Uncertainty::of;
        assert_eq!(at(&terms, &machine, 0.01), Uncertainty::Unknown);
        machine.cycle_time_error = Some(0.02);
        assert_eq!(at(&terms, &machine, 0.01), Uncertainty::Calibrated(0.02));
        assert_eq!(at(&terms, &machine, 0.02), Uncertainty::Elsewhere(0.02));
        machine.calibrated_at = vec![0.02, 0.05];
        assert_eq!(at(&terms, &machine, 0.02), Uncertainty::Calibrated(0.02));
        assert_eq!(at(&terms, &machine, 0.01), Uncertainty::Elsewhere(0.02));
        terms.uncertainty = Some(0.1);
        assert_eq!(at(&terms, &machine, 0.01), Uncertainty::Given(0.1));
        assert_eq!((Uncertainty::Unknown.ratio(), Uncertainty::Elsewhere(0.02).ratio()), (None, None));
    }
}
