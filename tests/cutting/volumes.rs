//! Removed volume against analytic volumes: within the stated error, and falling with resolution.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use truefeed::cutting::{HeightMap, Mill, Setup, StockBox, engagement};

use crate::{mill, setup, toolpath};

/// Removed volume of a program, mm³; what the places hold must be what the map lost.
fn removed(program: &str, setup: &Setup) -> f64 {
    let found = engagement(&toolpath(program), setup).expect("all is given");
    let stock = setup.stock.expect("given");
    let whole: f64 = (0..3).map(|axis| stock.max[axis] - stock.min[axis]).product();
    let sum: f64 = found.places.iter().map(|place| place.removed).sum();
    let lost = whole - found.rest.volume();
    assert!((sum - lost).abs() < 1e-6 * whole, "{sum} removed, {lost} lost");
    sum
}

/// Off the grid, so that no border lies on borders of cells.
const MIN: [f64; 3] = [-30.013, -30.027, -10.0];
const MAX: [f64; 3] = [50.0, 50.0, 0.0];

/// The volume is met within the stated error at each resolution, and closer at the finest.
fn converges(program: &str, mill: Mill, exact: f64, border: f64, depth: f64) {
    let errors = [0.8, 0.4, 0.2, 0.1, 0.05].map(|resolution| {
        let setup = setup(MIN, MAX, mill, resolution);
        let error = (removed(program, &setup) - exact).abs();
        assert!(error <= FRAC_1_SQRT_2 * resolution * border * depth, "{error} mm³ at {resolution} mm");
        error
    });
    assert!(errors[3].max(errors[4]) < 0.25 * errors[0].max(errors[1]), "{errors:?}");
    assert!(errors[4] < 2e-3 * exact, "{errors:?} of {exact}");
}

#[test]
fn a_slot() {
    let exact = 3.0 * (12.0 * 31.0 + PI * 36.0);
    converges("G21 G90 G1 X0 Y0 Z-3 F1000\nX31", mill(12.0), exact, 2.0 * 31.0 + 12.0 * PI, 3.0);
}

#[test]
fn a_slot_across_the_grid() {
    let program = "G21 G90 G1 X0 Y0 Z-3 F1000\nX18.6 Y24.8";
    converges(program, mill(12.0), 3.0 * (12.0 * 31.0 + PI * 36.0), 2.0 * 31.0 + 12.0 * PI, 3.0);
}

#[test]
fn a_rectangular_pocket() {
    let program = "G21 G90 G1 X0 Y0 Z-5 F1000\nX20\nY4\nX0\nY8\nX20\nY12\nX0\nY0";
    let exact = 5.0 * (20.0 * 12.0 + 2.0 * 5.0 * (20.0 + 12.0) + PI * 25.0);
    converges(program, mill(10.0), exact, 64.0 + 10.0 * PI, 5.0);
}

#[test]
fn a_circle_leaves_a_core() {
    let program = "G21 G90 G0 X20 Y0 Z5\nG1 Z-2 F1000\nG2 X20 Y0 I-10 J0";
    let exact = 2.0 * PI * (13.0 * 13.0 - 7.0 * 7.0);
    converges(program, mill(6.0), exact, 2.0 * PI * 20.0, 2.0);
}

#[test]
fn a_round_corner_leaves_a_fillet() {
    // Below the slot of a sharp mill, less (1 − π/4) r² along each side and once around its ends.
    let (radius, corner): (f64, f64) = (6.0, 2.0);
    let sharp = 3.0 * (12.0 * 31.0 + PI * 36.0);
    let area = (1.0 - PI / 4.0) * corner * corner;
    // Centroid of the fillet from the wall, by Pappus.
    let inward = corner * (10.0 - 3.0 * PI) / (12.0 - 3.0 * PI);
    let fillet = area * (2.0 * 31.0 + 2.0 * PI * (radius - inward));
    let program = "G21 G90 G1 X0 Y0 Z-3 F1000\nX31";
    let mill = Mill { corner_radius: corner, ..mill(12.0) };
    converges(program, mill, sharp - fillet, 2.0 * 31.0 + 12.0 * PI, 3.0);
}

#[test]
fn a_ramp_removes_its_wedge() {
    // Down from 0 to 4 mm over 30 mm and back along the floor.
    let program = "G21 G90 G1 X0 Y0 Z0 F1000\nX30 Z-4\nX0";
    converges(program, mill(8.0), 4.0 * (8.0 * 30.0 + PI * 16.0), 60.0 + 8.0 * PI, 4.0);
}

#[test]
fn no_more_is_removed_than_there_is_and_nothing_twice() {
    let setup = setup([0.0; 3], [10.0, 10.0, 5.0], mill(30.0), 0.5);
    let through = "G21 G90 G1 X-20 Y5 Z-3 F1000\nX40\nX-20\nX40";
    assert!((removed(through, &setup) - 500.0).abs() < 1e-9);
    let above = "G21 G90 G1 X-20 Y5 Z5 F1000\nX40";
    assert_eq!(removed(above, &setup), 0.0);
}

#[test]
fn a_map_holds_the_stock() {
    let stock = StockBox { min: [0.0; 3], max: [10.0, 7.0, 2.0] };
    let map = HeightMap::new(&stock, 0.3).expect("it has a volume");
    assert!(map.resolution() <= 0.3 && (map.volume() - 140.0).abs() < 1e-9);
    assert_eq!(map.height(5.0, 5.0), Some(2.0));
    assert_eq!((map.height(-0.1, 5.0), map.height(5.0, 7.1)), (None, None));
}
