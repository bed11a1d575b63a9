//! Contour errors → regions: parts of the program in which the contour error exceeds its bound.
//!
//! Consecutive segments whose error is above their bound form one region. Good segments between them do not
//! end the region as long as they are shorter in total than the last run of bad segments: a ragged
//! pass is one region instead of a hundred, while separate bad passes are separate regions.

use crate::simulation::contour::ContourErrors;
use crate::simulation::feed::ToleranceBound;
use crate::simulation::gcode::LineNumber;
use crate::simulation::toolpath::Toolpath;

/// A part of the program in which the contour error is above its bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorRegion {
    /// First and last line of the program.
    pub lines: (LineNumber, LineNumber),
    /// Distance along the path at which the region begins and ends, mm.
    pub distance: (f64, f64),
    /// Largest contour error in it, mm.
    pub largest: f64,
}

/// Capacity reserved in advance: one region per this number of segments.
const SEGMENTS_PER_REGION: usize = 16;

/// Returns the regions in which the contour error is above `ratio` times its bound, in program order.
pub fn regions_beyond(
    toolpath: &Toolpath,
    errors: &ContourErrors,
    bounds: impl Iterator<Item = ToleranceBound>,
    ratio: f64,
) -> Vec<ErrorRegion> {
    let mut beyond = errors.beyond(bounds, ratio).peekable();
    // A list that grows from nothing leaves freed memory behind, in total as much as its own.
    let mut regions: Vec<ErrorRegion> = Vec::with_capacity(toolpath.segments.len() / SEGMENTS_PER_REGION);
    let mut begin = 0.0;
    // Length of the bad segments since the last good one, mm.
    let mut run = 0.0;
    for (k, segment) in toolpath.segments.iter().enumerate() {
        let end = begin + segment.length;
        let error = errors.corner[k].max(errors.along(k));
        if beyond.next_if_eq(&k).is_some() {
            match regions.last_mut() {
                Some(region) if begin - region.distance.1 <= run => {
                    run = if region.distance.1 < begin { segment.length } else { run + segment.length };
                    region.lines.1 = segment.line;
                    region.distance.1 = end;
                    region.largest = region.largest.max(error);
                }
                _ => {
                    run = segment.length;
                    let lines = (segment.line, segment.line);
                    regions.push(ErrorRegion { lines, distance: (begin, end), largest: error });
                }
            }
        }
        begin = end;
    }
    regions.shrink_to_fit();
    regions
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    #[test]
    fn bad_segments_close_together_are_one_region() {
        let program = b"G1 X1 F1000\nX2\nX3\nX4\nX50\nX51";
        let toolpath = trace(&read(program), &Machine::default());
        let corner = vec![0.3, 0.0, 0.2, 0.0, 0.0, 0.4];
        let errors = ContourErrors { corner, ..ContourErrors::default() };
        let above = |bound: f64| {
            let bounds = [ToleranceBound { along: bound, corner: bound, near: bound }; 6].into_iter();
            regions_beyond(&toolpath, &errors, bounds, 1.0)
        };
        let regions = above(0.1);
        let lines: Vec<_> = regions.iter().map(|region| (region.lines.0.0, region.lines.1.0)).collect();
        assert_eq!(lines, [(1, 3), (6, 6)]);
        assert_eq!(regions[0].distance, (0.0, 3.0));
        assert_eq!((regions[0].largest, regions[1].largest), (0.3, 0.4));
        assert!(above(0.4).is_empty());
    }
}
