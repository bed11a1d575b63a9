//! Removed volume against analytic volumes: within the stated error, and falling with resolution.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use truefeed::cutting::{HeightMap, Mill, Setup, StockBox, engagement};

use crate::cutting::{from, mill, setup, toolpath};

/// Removed volume of a program, mm³; what the places hold must be what the map lost.
fn removed(program: &str, setup: &Setup) -> f64 {
    let found = engagement(&toolpath(program), setup).expect("all is given");
    let stock = setup.stock.expect("given");
    let whole: f64 = (0..3).map(|axis| stock.max[axis] - stock.min[axis]).product();
    let sum: f64 = found.places.iter().map(|place| place.removed).sum();
    let lost = whole - found.remaining.volume();
    assert!((sum - lost).abs() < 1e-6 * whole, "{sum} removed, {lost} lost");
    sum
}

/// The volume is met within the stated error at each resolution, and the finer the closer, over
/// several places of the grid.
fn converges(program: &str, mill: Mill, exact: f64, border: f64, depth: f64) {
    let errors = [0.8, 0.4, 0.2, 0.1].map(|resolution| {
        let squares = (0..6).map(|shift| {
            let [x, y] = [0.37, 0.61].map(|part: f64| resolution * (part * f64::from(shift)).fract());
            let setup = setup([-30.0 - x, -30.0 - y, -10.0], [50.0, 50.0, 0.0], mill, resolution);
            let error = removed(program, &setup) - exact;
            assert!(
                error.abs() <= FRAC_1_SQRT_2 * resolution * border * depth,
                "{error} mm³ at {resolution} mm"
            );
            error * error
        });
        (squares.sum::<f64>() / 6.0).sqrt()
    });
    assert!(errors[2] < 0.5 * errors[0] && errors[3] < 0.5 * errors[1], "{errors:?}");
    assert!(errors[3] < 2e-2 * exact, "{errors:?} of {exact}");
}

#[test]
fn a_slot() {
    let exact = 3.0 * (12.0 * 31.0 + PI * 36.0);
    converges(&from(0.0, 0.0, -3.0, "X31"), mill(12.0), exact, 2.0 * 31.0 + 12.0 * PI, 3.0);
}

#[test]
fn a_slot_across_the_grid() {
    let program = &from(0.0, 0.0, -3.0, "X18.6 Y24.8");
    converges(program, mill(12.0), 3.0 * (12.0 * 31.0 + PI * 36.0), 2.0 * 31.0 + 12.0 * PI, 3.0);
}

#[test]
fn a_rectangular_pocket() {
    let program = &from(0.0, 0.0, -5.0, "X20\nY4\nX0\nY8\nX20\nY12\nX0\nY0");
    let exact = 5.0 * (20.0 * 12.0 + 2.0 * 5.0 * (20.0 + 12.0) + PI * 25.0);
    converges(program, mill(10.0), exact, 64.0 + 10.0 * PI, 5.0);
}

#[test]
fn a_circle_leaves_a_core() {
    let program = &from(20.0, 0.0, -2.0, "G2 X20 Y0 I-10 J0");
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
    let program = &from(0.0, 0.0, -3.0, "X31");
    let mill = Mill { corner_radius: corner, ..mill(12.0) };
    converges(program, mill, sharp - fillet, 2.0 * 31.0 + 12.0 * PI, 3.0);
}

#[test]
fn a_ramp_removes_its_wedge() {
    // Down from 0 to 4 mm over 30 mm and back along the floor.
    let program = &from(0.0, 0.0, 0.0, "X30 Z-4\nX0");
    converges(program, mill(8.0), 4.0 * (8.0 * 30.0 + PI * 16.0), 60.0 + 8.0 * PI, 4.0);
}

#[test]
fn no_more_is_removed_than_there_is_and_nothing_twice() {
    let setup = setup([0.0, 0.0, -5.0], [10.0, 10.0, 0.0], mill(30.0), 0.5);
    let through = &from(-20.0, 5.0, -3.0, "X40\nX-20\nX40");
    assert!((removed(through, &setup) - 300.0).abs() < 1e-9);
    let above = &from(-20.0, 5.0, 5.0, "X40");
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
