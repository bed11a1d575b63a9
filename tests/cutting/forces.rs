//! The force model against closed forms and its own laws.

use std::f64::consts::PI;

use truefeed::cutting::{Coefficients, Force, Mill, Rotor, Sector, material};

use crate::cutting::mill;

const RADIUS: f64 = 6.0;
const DEPTH: f64 = 4.0;
const FEED: f64 = 0.12;

fn coefficients() -> Coefficients {
    material("al7075").expect("known").coefficients
}

fn rotor(mill: Mill) -> Rotor {
    Rotor::new(&mill, coefficients()).expect("it has a size")
}

fn sector(entry: f64, exit: f64) -> Sector {
    Sector { entry, exit, depth: DEPTH }
}

fn force(rotor: &Rotor, sectors: &[Sector], feed: f64) -> Force {
    rotor.forces(sectors, &[feed])[0]
}

fn close(ours: f64, exact: f64, relative: f64) {
    assert!((ours - exact).abs() <= relative * exact.abs().max(1e-9), "{ours} is not {exact}");
}

/// Over φ = 0 to π: ∫ sin² = π/2, ∫ sin cos = 0, ∫ sin = 2, ∫ cos = 0, times N a / 2π.
#[test]
fn the_mean_force_of_a_slot_is_the_closed_form() {
    for teeth in [1, 2, 3, 4, 6] {
        let rotor = rotor(Mill { teeth: Some(teeth), ..mill(2.0 * RADIUS) });
        let Coefficients { cutting: [tc, rc, ac], edge: [te, re, ae] } = coefficients();
        let na = f64::from(teeth) * DEPTH;
        let found = force(&rotor, &[sector(0.0, PI)], FEED);
        close(found.mean[0], -na / 4.0 * rc * FEED - na / PI * re, 1e-6);
        close(found.mean[1], na / 4.0 * tc * FEED + na / PI * te, 1e-6);
        close(found.mean[2], na / PI * ac * FEED + na / 2.0 * ae, 1e-6);
        close(found.mean_torque, RADIUS * (na / PI * tc * FEED + na / 2.0 * te), 1e-6);
        close(found.chip, FEED, 1e-12);
    }
}

/// Over φ = 0 to π/2 (conventional) and π/2 to π (climbing): ∫ sin² = π/4, ∫ sin cos = ±1/2,
/// ∫ sin = 1, ∫ cos = ±1.
#[test]
fn the_mean_force_of_half_immersion_is_the_closed_form() {
    let Coefficients { cutting: [tc, rc, ac], edge: [te, re, ae] } = coefficients();
    let rotor = rotor(mill(2.0 * RADIUS));
    let share = 2.0 * DEPTH / (2.0 * PI);
    for (entry, sign) in [(0.0, 1.0), (0.5 * PI, -1.0)] {
        let found = force(&rotor, &[sector(entry, entry + 0.5 * PI)], FEED);
        let half = 0.5 * sign;
        close(found.mean[0], share * (FEED * (-tc * half - rc * PI / 4.0) - te * sign - re), 1e-6);
        close(found.mean[1], share * (FEED * (tc * PI / 4.0 - rc * half) + te - re * sign), 1e-6);
        close(found.mean[2], share * (FEED * ac + ae * PI / 2.0), 1e-6);
    }
}

/// Brute force over fine slices and rotations, written apart from the model.
fn summed(mill: &Mill, sectors: &[Sector], feed: f64) -> (Force, f64) {
    let Coefficients { cutting, edge } = coefficients();
    let teeth = mill.teeth.expect("given");
    let (steps, slices) = (720, 4000);
    let mut force = Force::default();
    let mut lateral: f64 = 0.0;
    for step in 0..steps {
        let rotation = 2.0 * PI * f64::from(step) / f64::from(steps);
        let (mut sum, mut torque) = ([0.0; 3], 0.0);
        for tooth in 0..teeth {
            for sector in sectors {
                for slice in 0..slices {
                    let dz = sector.depth / f64::from(slices);
                    let z = (f64::from(slice) + 0.5) * dz;
                    let phi = rotation + 2.0 * PI * f64::from(tooth) / f64::from(teeth)
                        - z * mill.helix.tan() / RADIUS;
                    let phi = phi.rem_euclid(2.0 * PI);
                    if phi < sector.entry || sector.exit < phi {
                        continue;
                    }
                    let [t, r, a] = [0, 1, 2].map(|k: usize| (cutting[k] * feed * phi.sin() + edge[k]) * dz);
                    sum[0] += -t * phi.cos() - r * phi.sin();
                    sum[1] += t * phi.sin() - r * phi.cos();
                    sum[2] += a;
                    torque += RADIUS * t;
                }
            }
        }
        for (mean, sum) in force.mean.iter_mut().zip(sum) {
            *mean += sum / f64::from(steps);
        }
        force.mean_torque += torque / f64::from(steps);
        force.peak = force.peak.max(sum[0].hypot(sum[1]).hypot(sum[2]));
        force.peak_torque = force.peak_torque.max(torque);
        lateral = lateral.max(sum[0].hypot(sum[1]));
    }
    (force, lateral)
}

#[test]
fn a_helical_mill_is_the_sum_of_its_slices() {
    let two = [Sector { entry: 0.3, exit: 1.2, depth: 2.0 }, Sector { entry: 2.0, exit: PI, depth: 9.0 }];
    let cases: [(f64, u32, &[Sector]); 5] = [
        (30.0, 2, &[sector(0.0, PI)]),
        (45.0, 3, &[sector(0.0, 0.7)]),
        (-30.0, 2, &[sector(1.9, PI)]),
        (40.0, 4, &two),
        // So long a helix that one edge is in the material twice.
        (60.0, 1, &[Sector { entry: 0.5, exit: 2.0, depth: 30.0 }]),
    ];
    for (degrees, teeth, sectors) in cases {
        let mill = Mill { helix: f64::to_radians(degrees), teeth: Some(teeth), ..mill(2.0 * RADIUS) };
        let found = force(&rotor(mill), sectors, FEED);
        let (exact, _) = summed(&mill, sectors, FEED);
        let size = exact.peak;
        for axis in 0..3 {
            assert!((found.mean[axis] - exact.mean[axis]).abs() < 2e-3 * size, "{degrees}° axis {axis}");
        }
        close(found.peak, exact.peak, 3e-3);
        close(found.peak_torque, exact.peak_torque, 3e-3);
        close(found.mean_torque, exact.mean_torque, 3e-3);
    }
}

#[test]
fn forces_scale_as_the_model_says() {
    let slot = [sector(0.0, PI)];
    let base = rotor(mill(2.0 * RADIUS));
    let at = |feed: f64| force(&base, &slot, feed);
    // Linear in feed beside the constant part of the edge.
    for axis in 0..3 {
        let [a, b, c] = [1.0, 2.0, 3.0].map(|k: f64| at(k * FEED).mean[axis]);
        close(c - b, b - a, 1e-9);
    }
    let doubled = Sector { depth: 2.0 * DEPTH, ..slot[0] };
    close(force(&base, &[doubled], FEED).peak, 2.0 * at(FEED).peak, 1e-12);
    close(force(&base, &[doubled], FEED).mean[1], 2.0 * at(FEED).mean[1], 1e-12);
    let four = rotor(Mill { teeth: Some(4), ..mill(2.0 * RADIUS) });
    for axis in 0..3 {
        close(force(&four, &slot, FEED).mean[axis], 2.0 * at(FEED).mean[axis], 1e-12);
    }
    // Without edge forces all is in proportion to the feed.
    let sharp = Coefficients { edge: [0.0; 3], ..coefficients() };
    let sharp = Rotor::new(&mill(2.0 * RADIUS), sharp).expect("it has a size");
    close(force(&sharp, &slot, 3.0 * FEED).peak, 3.0 * force(&sharp, &slot, FEED).peak, 1e-12);
    assert_eq!(force(&base, &slot, 0.0), Force::default());
    assert_eq!(force(&base, &[], FEED).peak, 0.0);
}

/// Energy: without edge forces the mean torque does K_tc for each mm³ of a revolution's chips.
#[test]
fn the_mean_torque_does_the_work_of_the_chips() {
    let sharp = Coefficients { edge: [0.0; 3], ..coefficients() };
    for (entry, exit) in [(0.0, PI), (0.4, 1.9), (2.5, PI)] {
        let rotor = Rotor::new(&mill(2.0 * RADIUS), sharp).expect("it has a size");
        let width = RADIUS * (f64::cos(entry) - f64::cos(exit));
        let volume = width * DEPTH * FEED * 2.0;
        let work = 2.0 * PI * force(&rotor, &[sector(entry, exit)], FEED).mean_torque;
        close(work, sharp.cutting[0] * volume, 1e-9);
    }
}

#[test]
fn a_helix_changes_the_peak_and_not_the_mean() {
    let straight = force(&rotor(mill(2.0 * RADIUS)), &[sector(1.8, PI)], FEED);
    let helical = Mill { helix: 0.6, ..mill(2.0 * RADIUS) };
    let helical = force(&rotor(helical), &[sector(1.8, PI)], FEED);
    for axis in 0..3 {
        close(helical.mean[axis], straight.mean[axis], 1e-12);
    }
    assert!(helical.peak < 0.99 * straight.peak);
}

#[test]
fn run_out_moves_chips_from_tooth_to_tooth_and_loses_none() {
    for teeth in [2, 3, 4] {
        for runout in [0.0, 0.005, 0.02, 0.2] {
            let rotor = rotor(Mill { runout, teeth: Some(teeth), ..mill(2.0 * RADIUS) });
            for even in [0.001, 0.03, 0.1] {
                for back in [0.0, 0.7] {
                    let chips = (0..teeth).map(|tooth| rotor.chip(tooth, back, even)).sum::<f64>();
                    close(chips, f64::from(teeth) * even, 1e-9);
                }
            }
        }
    }
}

#[test]
fn run_out_raises_the_peak_and_a_little_of_it_next_to_nothing() {
    let slot = [sector(0.0, PI)];
    let mill = Mill { helix: 0.5, ..mill(2.0 * RADIUS) };
    let even = force(&rotor(mill), &slot, FEED);
    let tiny = force(&rotor(Mill { runout: 1e-9, ..mill }), &slot, FEED);
    close(tiny.peak, even.peak, 5e-3);
    close(tiny.mean[1], even.mean[1], 5e-3);
    let worn = force(&rotor(Mill { runout: 0.02, ..mill }), &slot, FEED);
    assert!(1.1 * even.peak < worn.peak, "{} {}", even.peak, worn.peak);
    close(worn.mean[1], even.mean[1], 2e-2);
}
