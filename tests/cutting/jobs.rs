//! Cutting jobs that nobody wrote: any bytes are read or refused, and what is read is computed or refused.

use truefeed::cutting::{Engagement, LoadCurve, engagement, programmed_and_predicted};
use truefeed::machine::Machine;
use truefeed::project::{EXAMPLE_CUTTING, Prediction, cutting_from_toml};
use truefeed::simulation::feed::Tolerances;
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::simulate;

use crate::cutting::toolpath;
use crate::fuzz::mutate::{Random, mutated};

const PROGRAM: &str = "G21 G90 T3 M6\nG0 X-10 Y5 Z5\nZ-3\nG1 X30 F1200\nG2 X30 Y5 I-5 J0\nZ-9\nG0 X0\nG0 Z5";

/// Reads a job and, where it can be read, computes with it and writes the result.
fn run(text: &str) -> bool {
    let machine = Machine::default();
    let setup = match cutting_from_toml(text, &machine) {
        Ok(setup) => setup,
        Err(fault) => {
            assert!(!fault.to_string().is_empty());
            return false;
        }
    };
    // The finest maps take seconds; that is what the page's cancelling is for.
    if setup.resolution.is_some_and(|resolution| resolution < 0.5) {
        return true;
    }
    let toolpath = toolpath(PROGRAM);
    let (plan, _) = simulate::within(&toolpath, &machine, Tolerances::Programmed, &mut |_| {});
    let curve = Profile::new(&toolpath, &plan).feed_curve(Resolution::CHART);
    let cut = engagement(&toolpath, &setup);
    let load = |cut: &Engagement| programmed_and_predicted(cut, &toolpath, &setup, &curve, &mut |_| {});
    let loads: Vec<_> = cut.iter().map(load).collect();
    for LoadCurve { at, .. } in loads.iter().flatten().flatten() {
        let is_finite = |load: &truefeed::cutting::CutLoad| {
            [load.force, load.torque, load.power, load.removal_rate, load.chip, load.deflection]
                .iter()
                .all(|value| value.is_finite() && 0.0 <= *value)
        };
        assert!(at.iter().all(is_finite), "{text}");
    }
    let json = Prediction::new("", &toolpath, 1.0, &[]).with_cutting(&setup, &cut, &loads).to_json();
    serde_json::from_str::<serde_json::Value>(&json).is_ok()
}

const KEYS: [&str; 20] = [
    "material",
    "resolution_mm",
    "spindle_rpm",
    "min_mm",
    "max_mm",
    "diameter_mm",
    "teeth",
    "helix_deg",
    "corner_radius_mm",
    "runout_mm",
    "max_force_n",
    "max_torque_nm",
    "max_power_w",
    "max_chip_mm",
    "overhang_mm",
    "modulus_gpa",
    "max_deflection_mm",
    "ktc_n_mm2",
    "kae_n_mm",
    "unknown",
];

const VALUES: [&str; 22] = [
    "0",
    "-0",
    "1",
    "2",
    "3.5",
    "12",
    "-50",
    "100",
    "1e3",
    "1e5",
    "1e308",
    "-1e308",
    "1e-300",
    "nan",
    "inf",
    "-inf",
    "true",
    "\"al7075\"",
    "\"c45\"",
    "[0, 0, -20]",
    "[30, 30, 0]",
    "[1e5, -1e5, nan]",
];

/// Jobs to begin with.
fn seeds() -> Vec<Vec<u8>> {
    let whole = "material = \"c45\"\nresolution_mm = 1\nspindle_rpm = 8000\n[stock]\nmin_mm = [0, 0, -20]\nmax_mm = [30, 30, 0]\n\
        [tools.3]\ndiameter_mm = 6\nteeth = 3\nhelix_deg = 45\ncorner_radius_mm = 1\nrunout_mm = 0.01\nmax_force_n = 90\n\
        max_torque_nm = 1\nmax_power_w = 50\nmax_chip_mm = 0.1\noverhang_mm = 30\nmodulus_gpa = 210\n\
        max_deflection_mm = 0.01\n[spindle]\nmax_torque_nm = 2\nmax_power_w = 100\n[coefficients]\nktc_n_mm2 = 900\n";
    vec![EXAMPLE_CUTTING.as_bytes().to_vec(), whole.as_bytes().to_vec()]
}

#[test]
fn any_bytes_are_read_or_refused() {
    let mut random = Random(0x5eed_0009);
    for _ in 0..2000 {
        let length = random.below(300);
        let bytes: Vec<u8> = (0..length).map(|_| random.below(256) as u8).collect();
        run(&String::from_utf8_lossy(&bytes));
    }
}

#[test]
fn mutated_jobs_are_read_or_refused_and_some_are_read() {
    let words: Vec<Vec<u8>> = KEYS.iter().chain(&VALUES).map(|word| word.as_bytes().to_vec()).collect();
    let (mut random, seeds) = (Random(0x5eed_000a), seeds());
    let read =
        (0..1500).filter(|_| run(&String::from_utf8_lossy(&mutated(&mut random, &seeds, &words)))).count();
    assert!((30..1400).contains(&read), "{read} of 1500");
}

/// Values at the ends of their ranges, so that what follows the reading is reached.
#[test]
fn what_can_be_read_is_computed_or_refused() {
    let mut random = Random(0x5eed_000b);
    for _ in 0..60 {
        let mut of = |values: &[f64]| values[random.below(values.len())];
        let diameter = of(&[0.001, 0.4, 3.0, 12.0, 1000.0]);
        let [teeth, helix] = [of(&[1.0, 2.0, 7.0]), of(&[-75.0, -30.0, 0.0, 1e-9, 45.0, 75.0])];
        let [runout, size] = [of(&[0.0, 1e-12, 0.02, 1.0]), of(&[1e-3, 1.0, 30.0, 1000.0])];
        let [resolution, limit] = [of(&[0.5, 3.0, 100.0]), of(&[0.0, 1e-9, 50.0, 1e7])];
        let corner = 0.499 * diameter * of(&[0.0, 0.3, 1.0]);
        let text = format!(
            "material = \"ti6al4v\"\nresolution_mm = {resolution}\nspindle_rpm = 8000\n[stock]\nmin_mm = [0, 0, -20]\n\
             max_mm = [{size}, {size}, 0]\n[tool]\ndiameter_mm = {diameter}\nteeth = {teeth}\nhelix_deg = {helix}\n\
             runout_mm = {runout}\ncorner_radius_mm = {corner}\nmax_force_n = {limit}\noverhang_mm = 1000\n\
             max_deflection_mm = 10\n[spindle]\nmax_power_w = {limit}\n"
        );
        assert!(run(&text), "{text}");
    }
}
