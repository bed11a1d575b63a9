//! What each stage costs a block, and that the cost does not grow with the program.
//!
//! ```text
//! cargo bench
//! ```
//!
//! prints nanoseconds a block for each stage on a made finishing pass, and the same as a multiple
//! of a yardstick taken in the same run: summing the lengths of all blocks from their end points,
//! by one square root each. Machines differ in nanoseconds; the multiples compare. Each number is
//! the best of several runs.

use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use truefeed::machine::Machine;
use truefeed::simulation::contour::contour_errors;
use truefeed::simulation::feed::{Rule, plan};
use truefeed::simulation::gcode::read;
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::toolpath::trace;

/// Each stage is run so often.
const RUNS: usize = 5;

/// Contour tolerance, mm.
const TOLERANCE: f64 = 0.01;

/// A finishing pass back and forth over a wavy surface of 60 mm: G1 blocks of 0.1 to 0.5 mm at
/// F3000 to F8000, a new feedrate on each line of the raster.
fn finishing_pass(blocks: usize) -> String {
    let mut program = String::from("G90 G17 G21\n");
    let (mut x, mut y, mut forward) = (0.0f64, 0.0f64, true);
    let mut feedrate = 3000;
    for block in 0..blocks {
        let step = 0.3 + 0.18 * (0.7 * block as f64).sin();
        x += if forward { step } else { -step };
        if !(0.0..=60.0).contains(&x) {
            x = x.clamp(0.0, 60.0);
            y += 0.4;
            forward = !forward;
            feedrate = 3000 + (feedrate - 3000 + 1700) % 5001;
        }
        let z = 1.5 * (0.31 * x).sin() * (0.17 * y).cos() + 0.2 * (1.9 * x).sin();
        writeln!(program, "G1 X{x:.3} Y{y:.3} Z{z:.3} F{feedrate}").expect("text grows");
    }
    program
}

/// The least time of several runs (ns) and the last result.
fn timed<T>(mut run: impl FnMut() -> T) -> (f64, T) {
    let mut least = f64::INFINITY;
    let mut result = None;
    for _ in 0..RUNS {
        let begin = Instant::now();
        result = Some(black_box(run()));
        least = least.min(begin.elapsed().as_secs_f64() * 1e9);
    }
    (least, result.expect("it was run"))
}

fn main() {
    let machine = Machine::default();
    println!("{:>10}  {:<16} {:>12} {:>14}", "blocks", "stage", "ns a block", "× yardstick");
    for blocks in [20_000, 100_000] {
        let text = finishing_pass(blocks);
        let (read_time, program) = timed(|| read(text.as_bytes()));
        let (trace_time, toolpath) = timed(|| trace(&program, &machine));
        let count = toolpath.segments.len() as f64;
        let (yardstick, _) = timed(|| -> f64 {
            black_box(&toolpath.segments).iter().map(|segment| (segment.end - segment.start).norm()).sum()
        });
        let (plan_time, feed_plan) = timed(|| plan(&toolpath, &machine, Rule::Isolated(TOLERANCE)));
        let (profile_time, profile) = timed(|| Profile::new(&toolpath, &feed_plan));
        let (samples_time, samples) = timed(|| profile.samples(Resolution::CHART));
        let (contour_time, _) = timed(|| contour_errors(&toolpath, &feed_plan, &profile));
        let stages = [
            ("yardstick", yardstick),
            ("read", read_time),
            ("trace", trace_time),
            ("plan", plan_time),
            ("profile", profile_time),
            ("samples (chart)", samples_time),
            ("contour errors", contour_time),
        ];
        for (stage, time) in stages {
            let (a_block, multiple) = (time / count, time / yardstick);
            println!("{count:>10}  {stage:<16} {a_block:>12.1} {multiple:>14.1}");
        }
        let rows = samples.time.len() as f64 / count;
        println!("{count:>10}  {rows:.1} rows a block, cycle time {:.1} s", profile.cycle_time());
    }
}
