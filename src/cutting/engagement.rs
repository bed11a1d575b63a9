//! Toolpath → engagement: the places along the path where the teeth are in the material, and the removed
//! volume.
//!
//! The mill moves along the programmed path over the height map. At each place the half of its circumference
//! that moves forward is compared with the material:
//!
//! ```text
//!             feed t          φ = 0 beside the tool where its teeth move with the feed (M3: left),
//!              ↑  φ = π/2     π/2 in front, π on the other side; a tooth runs from 0 to π, and
//!          .---+---.          the chip is f sin φ thick. Material in 0 … π/2 alone is cut
//!  φ = 0  (    +    )  φ = π  conventionally, in π/2 … π alone climbing.
//! ```
//!
//! A sector is a range of φ with the depth of material above the tip of the tool. The map lags a few cells
//! behind the tool, so that it still contains the material being cut. Within ten degrees of either side a
//! chip is thinner than a fifth of the feed and the cells are too coarse; there the neighbouring sector is
//! extended. Angles are accurate to a few a/R (a side of a cell, R radius), radial depth to a few cells.
//!
//! Limits: ignored are cutting by the bottom when the tool moves straight down (the volume is included), the
//! shape of a rounded corner of the tool in the sectors, and the deviation of the real path from the
//! programmed one, which is within the contour tolerance.

use std::collections::VecDeque;
use std::f64::consts::PI;
use std::ops::Range;

use crate::cutting::setup::{CuttingError, Mill, Setup};
use crate::cutting::stock::HeightMap;
use crate::machine::SpindleDirection;
use crate::simulation::toolpath::{Curve, Motion, Point, Segment, StopCause, Toolpath};

/// A range of angles with material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sector {
    /// Angle at which a tooth enters, rad, 0 to π.
    pub entry: f64,
    /// Angle at which the tooth leaves, rad, above `entry`, at most π.
    pub exit: f64,
    /// Depth of the material above the tip, mm.
    pub depth: f64,
}

/// A place on the path where material is cut.
#[derive(Clone, Debug, PartialEq)]
pub struct CutPlace {
    /// Distance along the programmed path, mm: the middle of the section that it represents.
    pub distance: f64,
    /// Length of that section, mm.
    pub length: f64,
    /// Index of the segment.
    pub segment: usize,
    /// Line of the program.
    pub line: u32,
    /// Volume removed along the section, mm³.
    pub removed: f64,
    /// Share of the motion that is level, 0 straight down to 1.
    pub level: f64,
    /// Indices of the sectors at the place.
    sectors: Range<usize>,
}

/// A rapid move through material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    /// Index of the segment.
    pub segment: usize,
    /// Line of the program.
    pub line: u32,
    /// Distance along the path at which the collision begins, mm.
    pub distance: f64,
    /// Volume removed, mm³.
    pub removed: f64,
}

/// The engagement of the tool along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Engagement {
    /// Places where material is cut, by ascending distance; nothing is cut between them.
    pub places: Vec<CutPlace>,
    /// Rapid moves through material, in order.
    pub collisions: Vec<Collision>,
    /// Side of a cell, mm.
    pub resolution: f64,
    /// The remaining material.
    pub remaining: HeightMap,
    sectors: Vec<Sector>,
}

impl Engagement {
    /// Returns the distance along the path of each place, mm.
    pub fn distances(&self) -> impl Iterator<Item = f64> {
        self.places.iter().map(|place| place.distance)
    }

    /// Returns the sectors of a place, by ascending angle.
    pub fn sectors(&self, place: &CutPlace) -> &[Sector] {
        &self.sectors[place.sectors.clone()]
    }

    /// Returns the largest axial depth at a place, mm.
    pub fn axial(&self, place: &CutPlace) -> f64 {
        self.sectors(place).iter().map(|sector| sector.depth).fold(0.0, f64::max)
    }

    /// Returns the radial width of the material at a place, mm, given the tool's radius (mm).
    pub fn radial(&self, place: &CutPlace, radius: f64) -> f64 {
        self.sectors(place).iter().map(|sector| radius * (sector.entry.cos() - sector.exit.cos())).sum()
    }
}

/// Part of the path after which progress is reported.
pub(crate) const PROGRESS_STEP_RATIO: f64 = 0.01;

/// Lag of the map behind the tool, cells.
const MAP_LAG_CELLS: f64 = 4.0;

/// Least number of places on a path as long as the tool's radius.
const PLACES_PER_RADIUS: f64 = 25.0;

/// Most places of a path; more would fill the memory of a browser.
const MAX_CUT_PLACES: f64 = 3e6;

/// Largest difference of depths that count as equal, cells.
const EQUAL_DEPTH_CELLS: f64 = 0.25;

/// A position of the tool that the map does not include yet.
struct PendingStep {
    position: Point,
    distance: f64,
    owner: VolumeOwner,
}

/// The place or collision to which a removed volume belongs.
#[derive(Clone, Copy)]
enum VolumeOwner {
    Place(usize),
    Rapid { segment: usize, line: u32, distance: f64 },
}

/// The state of a run of one tool after another over the map.
struct ToolRun<'a> {
    engagement: Engagement,
    mill: &'a Mill,
    waiting: VecDeque<PendingStep>,
    /// Position at which the same mill cut last.
    last: Option<Point>,
    /// Number of sections run so far.
    stretches: f64,
}

/// Returns the engagement of the tools with the stock along a toolpath.
///
/// # Errors
///
/// Returns an error if the set-up has no stock or no tool for a place, if rotary axes turn, or if a line is
/// too long for the cells.
///
/// # Examples
///
/// ```
/// use truefeed::cutting::{Mill, Setup, StockBox, engagement, loads, material};
/// use truefeed::machine::Machine;
/// use truefeed::simulation::{gcode::read, interpreter::trace};
///
/// let toolpath = trace(&read(b"G21 G90 G0 X-10 Y0 Z-2\nM3 S8000\nG1 X40 F1000"), &Machine::default());
/// let setup = Setup {
///     stock: Some(StockBox { min: [0.0, -20.0, -10.0], max: [40.0, 20.0, 0.0] }),
///     coefficients: Some(material("al7075").expect("it is in the table").coefficients),
///     tool: Some(Mill { diameter: Some(10.0), teeth: Some(2), ..Mill::default() }),
///     ..Setup::default()
/// };
/// let slot = engagement(&toolpath, &setup).expect("nothing is missing");
/// let feedrates = vec![1000.0 / 60.0; slot.places.len()];
/// let loads = loads(&slot, &toolpath, &setup, &[&feedrates]).expect("nothing is missing");
/// assert!(10.0 < loads[0].force.value, "N");
/// ```
pub fn engagement(toolpath: &Toolpath, setup: &Setup) -> Result<Engagement, CuttingError> {
    engagement_with_progress(toolpath, setup, &mut |_| {})
}

/// Returns the result of [`engagement`]; calls `progress` with the completed fraction, 0 to 1.
///
/// # Errors
///
/// Returns the errors of [`engagement`].
pub fn engagement_with_progress(
    toolpath: &Toolpath,
    setup: &Setup,
    progress: &mut dyn FnMut(f64),
) -> Result<Engagement, CuttingError> {
    let stock = setup.stock.as_ref().ok_or(CuttingError::NoStock)?;
    let map = HeightMap::new(stock, setup.resolution(stock))?;
    let turn = toolpath.segments.iter().find(|segment| !segment.rotation.is_none());
    let turn = turn.map(|segment| segment.line).or_else(|| {
        let is_rotary = |cause: &StopCause| matches!(cause, StopCause::Rotary { .. });
        toolpath.stops.iter().find(|stop| is_rotary(&stop.cause)).map(|stop| stop.line)
    });
    if let Some(line) = turn {
        return Err(CuttingError::Rotary { line: line.0 });
    }
    let none = Mill::default();
    let mut run = ToolRun {
        engagement: Engagement {
            places: Vec::new(),
            collisions: Vec::new(),
            resolution: map.resolution(),
            remaining: map,
            sectors: Vec::new(),
        },
        mill: &none,
        waiting: VecDeque::new(),
        last: None,
        stretches: 0.0,
    };
    let mut operations = toolpath.operations.iter().peekable();
    let mut spins = toolpath.spins.iter().peekable();
    let (mut tool, mut mirrored, mut is_new) = (None, false, true);
    let distances = toolpath.distances();
    let whole = distances[toolpath.segments.len()];
    let mut told = 0.0;
    for ((index, segment), distance) in toolpath.segments.iter().enumerate().zip(distances) {
        if told + PROGRESS_STEP_RATIO * whole < distance {
            progress(distance / whole);
            told = distance;
        }
        while let Some(operation) = operations.next_if(|operation| operation.first_segment <= index) {
            (tool, is_new) = (operation.tool, is_new || operation.tool != tool);
        }
        while let Some((_, spin)) = spins.next_if(|(first, _)| *first <= index) {
            mirrored = spin.direction == SpindleDirection::Counterclockwise;
        }
        // Moves before the first tool are allowed: only cuts and feed moves need one.
        if is_new {
            let mill = setup.mill(tool, segment.line.0);
            match (mill, segment.motion) {
                (Ok(mill), _) => {
                    run.change(mill);
                    is_new = false;
                }
                (Err(_), Motion::Rapid { .. }) => continue,
                (Err(error), Motion::Feed { .. }) => return Err(error),
            }
        }
        run.segment(index, &segment, distance, mirrored)?;
    }
    run.cut_up_to(f64::INFINITY);
    let mut engagement = run.engagement;
    engagement.places.retain(|place| 0.0 < place.removed || !place.sectors.is_empty());
    Ok(engagement)
}

impl<'a> ToolRun<'a> {
    fn change(&mut self, mill: &'a Mill) {
        self.cut_up_to(f64::INFINITY);
        (self.mill, self.last) = (mill, None);
    }

    /// Runs along a segment that begins at `distance` (mm).
    fn segment(
        &mut self,
        index: usize,
        segment: &Segment,
        distance: f64,
        mirrored: bool,
    ) -> Result<(), CuttingError> {
        let (radius, resolution) = (self.mill.radius(), self.engagement.resolution);
        let reach = match segment.curve {
            Curve::Line => self.engagement.remaining.reach(radius, segment.start, segment.end),
            Curve::Arc(_) => Some((0.0, 1.0)),
        };
        let Some((from, to)) = reach else {
            self.cut_up_to(f64::INFINITY);
            self.last = None;
            return Ok(());
        };
        if 0.0 < from {
            self.cut_up_to(f64::INFINITY);
            self.last = None;
        }
        let way = (to - from) * segment.length;
        let spacing = resolution.max(radius / PLACES_PER_RADIUS);
        let stretches = (way / spacing).ceil().max(1.0);
        self.stretches += stretches;
        if MAX_CUT_PLACES < self.stretches {
            return Err(CuttingError::TooLong { resolution, line: segment.line.0 });
        }
        let length = way / stretches;
        let steps = (length / resolution).ceil().max(1.0);
        for stretch in 0..stretches as usize {
            let start = from * segment.length + stretch as f64 * length;
            let middle = start + 0.5 * length;
            let owner = match segment.motion {
                Motion::Rapid { .. } => VolumeOwner::Rapid { segment: index, line: segment.line.0, distance },
                Motion::Feed { .. } => {
                    self.cut_up_to(distance + middle - MAP_LAG_CELLS * resolution);
                    self.place(index, segment, middle, distance + middle, length, mirrored)
                }
            };
            for step in 1..=steps as usize {
                let s = start + length * step as f64 / steps;
                self.waiting.push_back(PendingStep {
                    position: segment.point(s),
                    distance: distance + s,
                    owner,
                });
            }
        }
        if segment.motion.is_rapid() || to < 1.0 {
            self.cut_up_to(f64::INFINITY);
        }
        if to < 1.0 {
            self.last = None;
        }
        Ok(())
    }

    /// Updates the map up to a distance, mm.
    fn cut_up_to(&mut self, distance: f64) {
        while let Some(step) = self.waiting.pop_front_if(|step| step.distance <= distance) {
            let removed = self.engagement.remaining.cut(self.mill, self.last, step.position);
            self.last = Some(step.position);
            match step.owner {
                VolumeOwner::Place(place) => self.engagement.places[place].removed += removed,
                VolumeOwner::Rapid { segment, line, distance } if 0.0 < removed => {
                    match self.engagement.collisions.last_mut().filter(|last| last.segment == segment) {
                        Some(last) => last.removed += removed,
                        None => {
                            self.engagement.collisions.push(Collision { segment, line, distance, removed })
                        }
                    }
                }
                VolumeOwner::Rapid { .. } => {}
            }
        }
    }

    /// Adds a place in the middle of a section, with its sectors.
    fn place(
        &mut self,
        index: usize,
        segment: &Segment,
        s: f64,
        distance: f64,
        length: f64,
        mirrored: bool,
    ) -> VolumeOwner {
        let first = self.engagement.sectors.len();
        let tangent = segment.tangent(s);
        let level = tangent.x.hypot(tangent.y);
        // On a steeper path the tool cuts with its bottom.
        if 1e-3 < level {
            let forward = [tangent.x / level, tangent.y / level];
            self.sectors(segment.point(s), forward, mirrored);
        }
        self.engagement.places.push(CutPlace {
            distance,
            length,
            segment: index,
            line: segment.line.0,
            removed: 0.0,
            level,
            sectors: first..self.engagement.sectors.len(),
        });
        VolumeOwner::Place(self.engagement.places.len() - 1)
    }

    /// Finds the sectors of the tool at a point, moving `forward`.
    fn sectors(&mut self, tip: Point, forward: [f64; 2], mirrored: bool) {
        let (radius, resolution) = (self.mill.radius(), self.engagement.resolution);
        let Engagement { remaining: rest, sectors, .. } = &mut self.engagement;
        let side = if mirrored { [forward[1], -forward[0]] } else { [-forward[1], forward[0]] };
        let bins = (PI * radius / resolution).ceil().clamp(36.0, 720.0) as usize;
        let width = PI / bins as f64;
        let depth_at = |bin: usize| {
            let (sin, cos) = ((bin as f64 + 0.5) * width).sin_cos();
            let at = |axis: usize| tip[axis] + radius * (cos * side[axis] + sin * forward[axis]);
            rest.height(at(0), at(1)).map_or(0.0, |height| (height - tip.z).max(0.0))
        };
        // Nearer to the sides the layer that the map still holds is thinner than a cell.
        let unsure = (std::f64::consts::FRAC_1_SQRT_2 / MAP_LAG_CELLS).asin();
        let unsure = ((unsure / width).ceil() as usize).min(bins / 2 - 1);
        let depths: Vec<f64> = (0..bins).map(|bin| depth_at(bin.clamp(unsure, bins - 1 - unsure))).collect();
        let first = sectors.len();
        let mut count = 0.0;
        for bin in 0..bins {
            // A single bin is at most a cell wide; material in one bin only, and not in its neighbours, is an
            // artefact.
            let (before, after) = (depths[bin.saturating_sub(1)], depths[(bin + 1).min(bins - 1)]);
            let depth = depths[bin].clamp(before.min(after), before.max(after));
            let (entry, exit) = (bin as f64 * width, (bin + 1) as f64 * width);
            match sectors[first..].last_mut() {
                Some(last)
                    if last.exit == entry
                        && 0.0 < depth
                        && (last.depth - depth).abs() <= EQUAL_DEPTH_CELLS * resolution =>
                {
                    last.exit = exit;
                    last.depth += (depth - last.depth) / (count + 1.0);
                    count += 1.0;
                }
                _ if 0.0 < depth => {
                    sectors.push(Sector { entry, exit, depth });
                    count = 1.0;
                }
                _ => {}
            }
        }
    }
}
