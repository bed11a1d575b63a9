//! Hints for refusals: changes that would make recorded positions fit. They are reported, never applied.

use std::ops::Range;

use crate::identification::alignment::map_matching::{Track, follow};
use crate::identification::alignment::path::Path;
use crate::machine::AXES;
use crate::simulation::toolpath::{Toolpath, Vector};

/// Returns the offset of recorded positions from the path, mm, if both have the same extent; `None` if the
/// extents differ in size, or if they coincide.
pub fn extents_differ_by(track: &Track, path: &Path) -> Option<Vector> {
    let programmed = path.extent()?;
    let recorded = extent(track);
    let mut shift = Vector::zeros();
    for axis in (0..3).filter(|axis| track.recorded[*axis]) {
        let (own, other) = (&recorded[axis], &programmed[axis]);
        if (0.02 * (other.end - other.start)).max(0.2)
            < ((own.end - own.start) - (other.end - other.start)).abs()
        {
            return None;
        }
        shift[axis] = own.end - other.end;
    }
    (0.05 < shift.norm()).then_some(shift)
}

fn extent(track: &Track) -> [Range<f64>; 3] {
    [0, 1, 2].map(|axis: usize| {
        let values = || track.position.iter().map(|position| position[axis]);
        values().fold(f64::INFINITY, f64::min)..values().fold(f64::NEG_INFINITY, f64::max)
    })
}

/// Returns a change that would make recorded positions fit, as a clause for people; `None` if there is none.
pub fn what_would_fit(
    track: &Track,
    toolpath: &Toolpath,
    recorded: [bool; 3],
    tolerance: f64,
) -> Option<String> {
    let fits = |changed: &Track| {
        let path = Path::new(toolpath, changed.recorded);
        follow(changed, &path, tolerance).is_ok_and(|found| {
            let ends = found.fixes.first().zip(found.fixes.last());
            let covered = ends.map_or(0.0, |(first, last)| last.distance - first.distance);
            found.is_on_path() && 0.3 * path.length() < covered
        })
    };
    let with = |change: &dyn Fn(usize) -> (usize, f64)| Track {
        time: track.time.clone(),
        position: track
            .position
            .iter()
            .map(|position| {
                let mut changed = *position;
                for axis in 0..3 {
                    let (from, factor) = change(axis);
                    changed[axis] = factor * position[from];
                }
                changed
            })
            .collect(),
        recorded,
        ..*track
    };
    let mut backwards = with(&|axis| (axis, 1.0));
    backwards.position.reverse();
    if fits(&backwards) {
        return Some("they fit the reversed path; are the rows in reverse order?".to_string());
    }
    for (a, b) in [(0, 1), (1, 2), (0, 2)] {
        let exchanged = with(&|axis| {
            (
                if axis == a {
                    b
                } else if axis == b {
                    a
                } else {
                    axis
                },
                1.0,
            )
        });
        if fits(&exchanged) {
            return Some(format!("they fit if {} and {} are exchanged", AXES[a], AXES[b]));
        }
    }
    for (factor, what) in
        [(25.4, "inch"), (1.0 / 25.4, "mm although the file says inch"), (1e-3, "µm"), (1e3, "m")]
    {
        if fits(&with(&|axis| (axis, factor))) {
            return Some(format!("they fit if they are {what}"));
        }
    }
    for (mirrored, name) in AXES.iter().enumerate() {
        if fits(&with(&|axis| (axis, if axis == mirrored { -1.0 } else { 1.0 }))) {
            return Some(format!("they fit if {name} has the opposite sign"));
        }
    }
    None
}
