//! A planner of trapezoids that knows a few blocks ahead, block by block as grbl runs them, against the plan of the whole
//! stretch.
//!
//! While a block is run, the buffer holds it and those after it; the plan goes backwards from a stop at the end of the last,
//! v² ← min(v_junction², v² + 2 a L), and the block ends at the speed found for its end, or at what it can reach. Written
//! from the description in grbl's planner.c, without prefix sums.

use truefeed::machine::{Junction, Machine, TimeConstants};
use truefeed::simulation::feed::Tolerances;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::simulate;

use crate::laws::paths::Random;

const DEVIATION_MM: f64 = 0.02;
const TIME_CONSTANT_S: f64 = 1e-4;

struct Block {
    direction: [f64; 3],
    length: f64,
    feedrate: f64,
    acceleration: f64,
}

fn largest_within(limits: [f64; 3], direction: [f64; 3]) -> f64 {
    (0..3).map(|k| limits[k] / direction[k].abs()).fold(f64::INFINITY, f64::min)
}

fn junction_square(before: &Block, after: &Block, limits: [f64; 3]) -> f64 {
    let difference: [f64; 3] = std::array::from_fn(|k| after.direction[k] - before.direction[k]);
    let norm = difference.iter().map(|d| d * d).sum::<f64>().sqrt();
    let cosine = -(0..3).map(|k| before.direction[k] * after.direction[k]).sum::<f64>();
    let half_sine = (0.5 * (1.0 - cosine)).sqrt();
    let acceleration = largest_within(limits, difference.map(|d| d / norm));
    acceleration * DEVIATION_MM * half_sine / (1.0 - half_sine)
}

/// How long the blocks take with so many of them in the buffer, s.
fn time(blocks: &[Block], limits: [f64; 3], buffered: usize) -> f64 {
    let (mut total, mut entry) = (0.0, 0.0_f64);
    for (i, block) in blocks.iter().enumerate() {
        let known = &blocks[i..blocks.len().min(i + buffered)];
        let mut exit: f64 = 0.0;
        for k in (1..known.len()).rev() {
            let slower = known[k].feedrate.min(known[k - 1].feedrate).powi(2);
            let most = junction_square(&known[k - 1], &known[k], limits).min(slower);
            exit = most.min(exit + 2.0 * known[k].acceleration * known[k].length);
        }
        let change = 2.0 * block.acceleration * block.length;
        exit = exit.min(entry + change);
        let peak = (0.5 * (entry + exit + change)).min(block.feedrate.powi(2)).sqrt();
        let ramps = (2.0 * peak * peak - entry - exit) / (2.0 * block.acceleration);
        total += (2.0 * peak - entry.sqrt() - exit.sqrt()) / block.acceleration;
        total += (block.length - ramps) / peak;
        entry = exit;
    }
    total
}

#[test]
fn a_buffer_of_blocks_takes_as_long_as_run_block_by_block() {
    let mut slower = 0;
    for seed in 1..200 {
        let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ seed);
        let limits: [f64; 3] = std::array::from_fn(|_| random.log_between(100.0, 2000.0));
        let buffered = random.between(2.0, 12.0) as usize;
        let (mut position, mut blocks, mut program) = ([0.0; 3], Vec::new(), String::new());
        let mut along = random.direction();
        for _ in 0..120 {
            along = (along + 0.2 * random.direction()).normalize();
            let length = random.log_between(0.02, 1.0);
            let feedrate = random.log_between(300.0, 6000.0).round();
            let end: [f64; 3] =
                std::array::from_fn(|k| ((position[k] + length * along[k]) * 1e4).round() / 1e4);
            let chord: [f64; 3] = std::array::from_fn(|k| end[k] - position[k]);
            let length = chord.iter().map(|d| d * d).sum::<f64>().sqrt();
            let direction = chord.map(|d| d / length);
            let acceleration = largest_within(limits, direction);
            blocks.push(Block { direction, length, feedrate: feedrate / 60.0, acceleration });
            program += &format!("G1 X{:.4} Y{:.4} Z{:.4} F{feedrate}\n", end[0], end[1], end[2]);
            position = end;
        }
        let mut machine = Machine::default();
        machine.interpolator.filters = 1;
        machine.interpolator.time_constants = TimeConstants::Equal(TIME_CONSTANT_S);
        machine.interpolator.contour_tolerance = 10.0;
        machine.interpolator.junction = Junction::Deviation(DEVIATION_MM);
        machine.axes.iter_mut().zip(limits).for_each(|(axis, limit)| axis.acceleration = limit);
        let toolpath = trace(&read(program.as_bytes()), &machine);
        let mut planned = |look_ahead: f64| {
            machine.interpolator.look_ahead = look_ahead;
            simulate::with_policy(&toolpath, &machine, Tolerances::Programmed.into()).cycle_time()
                - TIME_CONSTANT_S
        };
        let [whole, few] = [planned(f64::INFINITY), planned(buffered as f64)];
        // What is on its way through the filter takes some of the way to stop within, too.
        for (found, expected) in
            [(whole, time(&blocks, limits, blocks.len())), (few, time(&blocks, limits, buffered))]
        {
            assert!((found / expected - 1.0).abs() < 2e-3, "seed {seed}: {found} s, {expected} s");
        }
        slower += usize::from(whole * 1.01 < few);
    }
    assert!(20 < slower, "few blocks slow {slower} programs");
}
