//! What the axes make of the command, stepped at a tenth of a tick.
//!
//!     servo lag   τ (1 − f) ẏ = x − y             f the share taken away by feed-forward
//!     one mode    z̈ = ω² (y − z) − 2 ζ ω ż        semi-implicit Euler
//!     friction    after a reversal the axis sticks until it is g behind, which then decays as exp(−t/T)
//!     backlash    the table stands until the drive has crossed the play

use crate::physics::{Drive, TICK};

const SUBSTEPS: usize = 10;

/// Commanded to actual positions.
pub fn drive(position: &mut [[f64; 3]], drive: &Drive) {
    for axis in 0..3 {
        let mut column: Vec<f64> = position.iter().map(|p| p[axis]).collect();
        lag(&mut column, drive.lag * (1.0 - drive.feed_forward));
        if let Some((k, frequency, damping)) = drive.mode
            && k == axis
        {
            mode(&mut column, frequency, damping);
        }
        if let Some((size, seconds)) = drive.friction {
            friction(&mut column, size, seconds);
        }
        if let Some((k, width)) = drive.backlash
            && k == axis
        {
            backlash(&mut column, width);
        }
        for (point, value) in position.iter_mut().zip(column) {
            point[axis] = value;
        }
    }
}

fn lag(column: &mut [f64], constant: f64) {
    if constant <= 0.0 {
        return;
    }
    let kept = (-TICK / constant).exp();
    let mut y = column.first().copied().unwrap_or(0.0);
    let mut before = y;
    for x in column {
        // The command runs straight between two samples; this is the exact answer to such a ramp.
        let slope = (*x - before) / TICK;
        let (offset, now) = (before - constant * slope, *x);
        y = offset + slope * TICK + (y - offset) * kept;
        (before, *x) = (now, y);
    }
}

fn mode(column: &mut [f64], frequency: f64, damping: f64) {
    let omega = std::f64::consts::TAU * frequency;
    let step = TICK / SUBSTEPS as f64;
    let (mut z, mut rate) = (column.first().copied().unwrap_or(0.0), 0.0);
    let mut before = z;
    for y in column {
        for i in 1..=SUBSTEPS {
            let target = before + (*y - before) * i as f64 / SUBSTEPS as f64;
            rate += step * (omega * omega * (target - z) - 2.0 * damping * omega * rate);
            z += step * rate;
        }
        (before, *y) = (*y, z);
    }
}

fn friction(column: &mut [f64], size: f64, seconds: f64) {
    let kept = (-TICK / seconds).exp();
    let (mut behind, mut direction) = (0.0, 0.0);
    let mut before = column.first().copied().unwrap_or(0.0);
    let mut stuck = None;
    for x in column {
        let moved = *x - before;
        if 1e-6 < moved.abs() && moved.signum() != direction {
            direction = moved.signum();
            stuck = Some(before - behind);
        }
        before = *x;
        match stuck {
            Some(at) if (*x - at).abs() < size => behind = *x - at,
            _ => {
                stuck = None;
                behind *= kept;
            }
        }
        *x -= behind;
    }
}

fn backlash(column: &mut [f64], width: f64) {
    let mut table = column.first().copied().unwrap_or(0.0);
    for x in column {
        table = table.clamp(*x - width / 2.0, *x + width / 2.0);
        *x = table;
    }
}
