use super::*;
use crate::simulation::filter::FilterChain;

/// Numbers that look random and are the same every time (SplitMix64).
struct Dice(u64);

impl Dice {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// A move as a control with these filters makes it.
struct Planted {
    constants: Vec<f64>,
    feedrate: f64,
    length: f64,
    start: f64,
    sampling: f64,
    /// Noise by the feedrate, or by the length.
    noise: f64,
    quantity: RecordedQuantity,
}

impl Planted {
    /// The case of the paper: 6 mm at 3000 mm/min, delay 0.0765 s, 3 ms.
    fn like_the_paper(constants: &[f64], quantity: RecordedQuantity) -> Planted {
        Planted {
            constants: constants.to_vec(),
            feedrate: 50.0,
            length: 6.0,
            start: 0.0413,
            sampling: 0.003,
            noise: 0.0,
            quantity,
        }
    }

    fn record(&self, dice: &mut Dice) -> (Vec<f64>, Vec<f64>) {
        let chain = FilterChain::new(&self.constants);
        let pulse = self.length / self.feedrate;
        let end = self.start + pulse + chain.delay() + 0.1;
        let times: Vec<f64> =
            (0..=(end / self.sampling) as usize).map(|i| i as f64 * self.sampling).collect();
        let values = times.iter().map(|t| {
            let t = t - self.start;
            match self.quantity {
                RecordedQuantity::Feedrate => {
                    self.feedrate * (chain.step(t) - chain.step(t - pulse))
                        + self.noise * self.feedrate * dice.normal()
                }
                RecordedQuantity::Position => {
                    12.0 + self.feedrate * (chain.displacement(t) - chain.displacement(t - pulse))
                        + self.noise * self.length * dice.normal()
                }
            }
        });
        let values = values.collect();
        (times, values)
    }

    fn identify(&self, dice: &mut Dice) -> Outcome {
        let (times, values) = self.record(dice);
        identify(&Recording { times: &times, values: &values, quantity: self.quantity })
    }
}

fn converged(outcome: Outcome) -> Identification {
    match outcome {
        Outcome::Converged(identification) => identification,
        other => panic!("{other:?}"),
    }
}

#[test]
fn exact_recordings_give_the_filters_exactly() {
    for quantity in [RecordedQuantity::Position, RecordedQuantity::Feedrate] {
        for (index, constants) in
            [vec![0.05], vec![0.03; 2], vec![0.0255; 3], vec![0.019; 4], vec![0.05, 0.02]].iter().enumerate()
        {
            for direction in [1.0, -1.0] {
                let mut planted = Planted::like_the_paper(constants, quantity);
                planted.feedrate *= direction;
                planted.length *= direction;
                let found = converged(planted.identify(&mut Dice(1)));
                let best = found.best();
                assert_eq!(found.chosen, index, "{found:?}");
                assert!(found.is_certain());
                for (estimate, constant) in best.time_constants.iter().zip(constants) {
                    assert!((estimate.value - constant).abs() < 1e-9, "{best:?}");
                }
                assert!((best.start.value - planted.start).abs() < 1e-9);
                assert!((best.feedrate.value / planted.feedrate - 1.0).abs() < 1e-9);
                assert!((best.length.value / planted.length - 1.0).abs() < 1e-9);
            }
        }
    }
}

/// Planted values lie within three standard uncertainties of those found in 99 of 100 recordings,
/// and within one in about two of three, so the uncertainties are neither too small nor too large.
#[test]
fn uncertainties_cover_what_they_should() {
    let mut dice = Dice(7);
    let (mut recordings, mut within_one, mut within_three, mut within_others, mut passed_over) =
        (0, 0, 0, 0, 0);
    for case in 0..1200 {
        let order = 1 + case % 4;
        let constant = dice.between(0.005, 0.060);
        let feedrate = dice.between(20.0, 200.0);
        let planted = Planted {
            constants: vec![constant; order],
            feedrate,
            length: feedrate * (order as f64 * constant + dice.between(0.02, 0.2)),
            start: dice.between(0.02, 0.3),
            sampling: dice.between(0.001, 0.020),
            noise: dice.between(1e-4, 1e-2),
            quantity: if dice.uniform() < 0.5 {
                RecordedQuantity::Position
            } else {
                RecordedQuantity::Feedrate
            },
        };
        let found = match planted.identify(&mut dice) {
            Outcome::Converged(found) => found,
            Outcome::TooFewSamples { .. } => {
                passed_over += 1;
                continue;
            }
            other => panic!("case {case}: {other:?}"),
        };
        let fit = &found.fits[order - 1];
        // Another order may have been chosen, whose ramps are longer.
        if fit.samples_on_ramps <= 3 {
            passed_over += 1;
            continue;
        }
        let Estimate { value, uncertainty } = fit.time_constants[0];
        let miss = (value - constant).abs() / uncertainty;
        recordings += 1;
        within_one += usize::from(miss < 1.0);
        within_three += usize::from(miss < 3.0);
        for (estimate, planted) in [(fit.start, planted.start), (fit.length, planted.length)] {
            within_others += usize::from((estimate.value - planted).abs() < 3.0 * estimate.uncertainty);
        }
    }
    let part = |count: usize| count as f64 / recordings as f64;
    assert!(1000 < recordings, "{passed_over} passed over");
    assert!(0.99 <= 0.5 * part(within_others), "{}", part(within_others));
    assert!(0.99 <= part(within_three), "{}", part(within_three));
    assert!((0.60..0.80).contains(&part(within_one)), "{}", part(within_one));
}

#[test]
fn fine_sampling_tells_the_order() {
    for quantity in [RecordedQuantity::Position, RecordedQuantity::Feedrate] {
        for order in 1..=4 {
            for seed in 0..25 {
                let mut planted = Planted::like_the_paper(&vec![0.0765 / order as f64; order], quantity);
                planted.noise = if quantity == RecordedQuantity::Feedrate { 5e-4 } else { 1e-5 };
                let found = converged(planted.identify(&mut Dice(seed)));
                assert_eq!(found.best().filters.order(), order, "{found:?}");
                let mut rivals = found.rivals.iter().map(|&rival| found.fits[rival].filters);
                assert!(rivals.all(|rival| rival.contains(Filters::Equal(order))), "{found:?}");
            }
        }
    }
}

#[test]
fn unequal_filters_are_told_from_equal_ones() {
    for seed in 0..25 {
        let mut planted = Planted::like_the_paper(&[0.055, 0.0215], RecordedQuantity::Feedrate);
        planted.noise = 1e-3;
        let found = converged(planted.identify(&mut Dice(seed)));
        assert_eq!(found.best().filters, Filters::UnequalPair, "{found:?}");
        for (estimate, constant) in found.best().time_constants.iter().zip([0.055, 0.0215]) {
            assert!((estimate.value - constant).abs() < 4.0 * estimate.uncertainty, "{found:?}");
            assert!(estimate.uncertainty < 1e-3);
        }
    }
}

#[test]
fn coarse_sampling_does_not_tell_the_order() {
    let (mut too_few, mut open) = (0, 0);
    for order in 1..=4 {
        for seed in 0..25 {
            let mut planted =
                Planted::like_the_paper(&vec![0.0765 / order as f64; order], RecordedQuantity::Feedrate);
            (planted.sampling, planted.noise) = if seed % 2 == 0 { (0.05, 0.0) } else { (0.03, 0.01) };
            planted.start = 0.041 + 0.002 * seed as f64;
            match planted.identify(&mut Dice(seed)) {
                // The corners of the trapezoid behind a single filter show even so.
                Outcome::Converged(found) if found.is_certain() => {
                    assert_eq!((order, found.best().filters), (1, Filters::Equal(1)), "{found:?}");
                }
                Outcome::Converged(_) => open += 1,
                Outcome::TooFewSamples { .. } => too_few += 1,
                other => panic!("{other:?}"),
            }
        }
    }
    assert!(20 < open, "{too_few} have too few samples");
}

#[test]
fn what_is_no_single_move_is_said_to_be_none() {
    let times: Vec<f64> = (0..200).map(|i| i as f64 * 0.003).collect();
    let outcome = |value: &dyn Fn(f64) -> f64, quantity| {
        let values: Vec<f64> = times.iter().map(|&time| value(time)).collect();
        identify(&Recording { times: &times, values: &values, quantity })
    };
    let chain = FilterChain::equal(3, 0.0255);
    let pulse = |t: f64, length: f64| chain.step(t) - chain.step(t - length);
    let way = |t: f64, length: f64| chain.displacement(t) - chain.displacement(t - length);
    for quantity in [RecordedQuantity::Position, RecordedQuantity::Feedrate] {
        assert_eq!(
            outcome(&|_| 3.0, RecordedQuantity::Position),
            Outcome::NotASingleMove { unexplained: 1.0 }
        );
        assert_eq!(outcome(&|_| 0.0, quantity), Outcome::NotASingleMove { unexplained: 1.0 });
        let there_and_back = |t: f64| match quantity {
            RecordedQuantity::Position => 50.0 * (way(t - 0.05, 0.12) - 0.6 * way(t - 0.3, 0.12)),
            RecordedQuantity::Feedrate => 50.0 * (pulse(t - 0.05, 0.12) - 0.6 * pulse(t - 0.3, 0.12)),
        };
        let two = |t: f64| match quantity {
            RecordedQuantity::Position => 50.0 * (way(t - 0.05, 0.12) + way(t - 0.3, 0.12)),
            RecordedQuantity::Feedrate => 50.0 * (pulse(t - 0.05, 0.12) + pulse(t - 0.3, 0.12)),
        };
        for (name, other) in [("back", &there_and_back as &dyn Fn(f64) -> f64), ("two", &two)] {
            let found = outcome(other, quantity);
            assert!(matches!(found, Outcome::NotASingleMove { .. }), "{name}, {quantity:?}: {found:?}");
        }
    }
}

/// What moves long after the first move is not cut off.
#[test]
fn a_program_is_no_single_move() {
    let times: Vec<f64> = (0..3000).map(|i| i as f64 * 0.003).collect();
    let chain = FilterChain::equal(3, 0.0255);
    let pulse = |t: f64| chain.step(t) - chain.step(t - 0.12);
    let way = |t: f64| chain.displacement(t) - chain.displacement(t - 0.12);
    for begins in [&[0.5][..], &[0.5, 4.0], &[0.5, 4.0, 8.0]] {
        for quantity in [RecordedQuantity::Position, RecordedQuantity::Feedrate] {
            let value = |time: &f64| match quantity {
                RecordedQuantity::Position => begins.iter().map(|begin| 50.0 * way(time - begin)).sum(),
                RecordedQuantity::Feedrate => begins.iter().map(|begin| 50.0 * pulse(time - begin)).sum(),
            };
            let values: Vec<f64> = times.iter().map(value).collect();
            let found = identify(&Recording { times: &times, values: &values, quantity });
            let is_single = matches!(found, Outcome::Converged(_));
            assert_eq!(is_single, begins.len() == 1, "{begins:?}, {quantity:?}: {found:?}");
        }
    }
}

#[test]
fn garbage_has_an_outcome() {
    let identify = |times: &[f64], values: &[f64], quantity| identify(&Recording { times, values, quantity });
    let mut dice = Dice(3);
    for quantity in [RecordedQuantity::Position, RecordedQuantity::Feedrate] {
        assert_eq!(identify(&[], &[], quantity), Outcome::TooFewSamples { found: 0, needed: 8 });
        assert_eq!(
            identify(&[0.0, 1.0], &[0.0], quantity),
            Outcome::Unreadable(Fault::LengthsDiffer { times: 2, values: 1 })
        );
        assert_eq!(
            identify(&[0.0, 1.0], &[0.0, f64::NAN], quantity),
            Outcome::Unreadable(Fault::NotFinite { row: 1 })
        );
        assert_eq!(
            identify(&[0.0, 0.0], &[0.0, 1.0], quantity),
            Outcome::Unreadable(Fault::TimeNotRising { row: 1 })
        );
        for case in 0..400 {
            let count = (dice.uniform() * 60.0) as usize;
            let mut time = dice.between(-1e6, 1e6);
            let times: Vec<f64> = (0..count)
                .map(|_| {
                    time += 10f64.powf(dice.between(-6.0, 3.0));
                    time
                })
                .collect();
            let scale = 10f64.powf(dice.between(-200.0, 200.0));
            let mut value = 0.0;
            let values: Vec<f64> = (0..count)
                .map(|_| {
                    let fresh = dice.normal() * scale;
                    value = if case % 2 == 0 { fresh } else { value + fresh.abs() };
                    value
                })
                .collect();
            identify(&times, &values, quantity);
        }
        let huge = [-f64::MAX, f64::MAX, f64::MAX, f64::MAX, 0.0, 1.0, f64::MAX, f64::MAX, f64::MAX];
        identify(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0], &huge, quantity);
    }
}
