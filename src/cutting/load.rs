//! Engagement and feed → load: force, torque, power and removal rate along the path.
//!
//! ```text
//! f = v / (n N)        feed per tooth: v level feedrate (mm/s), n speed (1/s), N teeth
//! P = 2π n M           power from the mean torque M over a revolution
//! Q = V v / L          removal rate from the volume V removed over a stretch of length L
//! ```
//!
//! The loads of one engagement are computed for any number of feedrates per place: the programmed
//! feedrate and the profile's. Lengths in mm, times in s, forces in N, torques in N·mm, power in N·mm/s.

use std::f64::consts::TAU;

use crate::cutting::engagement::{CutPlace, Engagement, PROGRESS_STEP_RATIO};
use crate::cutting::force::{Force, Rotor};
use crate::cutting::headroom::{Headroom, PlaceHeadroom, headroom};
use crate::cutting::limits::{FEED_FACTORS, LimitKind, MAX_GAP_MM, MIN_LEVEL_SHARE};
use crate::cutting::setup::{CuttingError, LoadLimits, Setup};
use crate::simulation::ordered::sort_by_number;
use crate::simulation::profile::FeedCurve;
use crate::simulation::toolpath::{Motion, Operation, Toolpath};
use crate::units::SECONDS_PER_MINUTE;

/// The load on the tool at a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CutLoad {
    /// Largest force within a revolution, N.
    pub force: f64,
    /// Resultant of the mean force, N.
    pub mean_force: f64,
    /// Largest torque within a revolution, N·mm.
    pub torque: f64,
    /// Power over a revolution, N·mm/s.
    pub power: f64,
    /// Removal rate, mm³/s.
    pub removal_rate: f64,
    /// Thickest chip, mm.
    pub chip: f64,
    /// Feed per tooth, mm; 0 where nothing is cut.
    pub feed_per_tooth: f64,
    /// Largest deflection of the tip, mm; the axial force counts as if it were lateral.
    pub deflection: f64,
}

/// The largest value of a quantity, and its place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// The value, in the unit of the quantity.
    pub value: f64,
    /// Line of the program.
    pub line: u32,
    /// Distance along the path, mm.
    pub distance: f64,
}

/// The demands of an operation on tool and spindle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OperationLoad {
    /// Volume removed, including by rapids, mm³.
    pub removed: f64,
    /// Largest force, N.
    pub force: Peak,
    /// Largest power, N·mm/s.
    pub power: Peak,
}

/// A part of the path on which a limit is exceeded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExceededLimit {
    /// The limit.
    pub limit: LimitKind,
    /// Value of the limit, in the unit of the quantity.
    pub allowed: f64,
    /// Largest value of the quantity, and its place.
    pub peak: Peak,
    /// Least and greatest line.
    pub lines: (u32, u32),
}

/// The load along a path at one feedrate for each place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadCurve {
    /// At each place of the engagement.
    pub at: Vec<CutLoad>,
    /// Largest force, N.
    pub force: Peak,
    /// Largest torque, N·mm.
    pub torque: Peak,
    /// Largest power, N·mm/s.
    pub power: Peak,
    /// Largest removal rate, mm³/s.
    pub removal_rate: Peak,
    /// By operation, in the order they are run.
    pub operations: Vec<OperationLoad>,
    /// Exceeded limits, by limit and distance.
    pub exceeded: Vec<ExceededLimit>,
    /// Parts of the path where the programmed feedrate could be higher; empty for the loads at the predicted
    /// feedrate.
    pub headroom: Vec<Headroom>,
    /// Time between predicted feedrates if they are too few to follow the profile, s.
    pub spacing: Option<f64>,
}

impl Peak {
    fn rise(&mut self, other: Peak) {
        if self.value < other.value {
            *self = other;
        }
    }
}

impl LoadCurve {
    /// Adds the volume that collisions removed, and sorts the exceeded limits. `operation_of` returns the operation of
    /// a segment.
    fn finish(&mut self, engagement: &Engagement, operation_of: impl Fn(usize) -> usize) {
        for collision in &engagement.collisions {
            self.operations[operation_of(collision.segment)].removed += collision.removed;
        }
        sort_by_number(&mut self.exceeded, |exceeded| exceeded.peak.distance);
        sort_by_number(&mut self.exceeded, |exceeded| exceeded.limit as usize as f64);
    }
}

/// Returns the programmed feedrate at each place, mm/s.
pub fn programmed_feedrates(engagement: &Engagement, toolpath: &Toolpath) -> Vec<f64> {
    let of = |segment: usize| match toolpath.segments.at(segment).motion {
        Motion::Feed { feedrate } => feedrate,
        Motion::Rapid { .. } => 0.0,
    };
    engagement.places.iter().map(|place| of(place.segment)).collect()
}

/// Returns the loads at the programmed feedrate, with its headroom, and at the feedrate of a profile; calls
/// `progress` with the completed fraction, 0 to 1.
///
/// # Errors
///
/// Returns an error if the set-up has no coefficients, or a place has no tool or no spindle speed.
pub fn programmed_and_predicted(
    engagement: &Engagement,
    toolpath: &Toolpath,
    setup: &Setup,
    curve: &FeedCurve,
    progress: &mut dyn FnMut(f64),
) -> Result<[LoadCurve; 2], CuttingError> {
    let (programmed, predicted) =
        (programmed_feedrates(engagement, toolpath), curve.feedrates_at(engagement.distances()));
    let mut rooms = Vec::with_capacity(engagement.places.len());
    let both =
        loads_with(engagement, toolpath, setup, &[&programmed, &predicted], Some(&mut rooms), progress)?;
    let mut both: [LoadCurve; 2] = both.try_into().expect("two lists of feedrates give two loads");
    both[0].headroom = headroom(engagement, &rooms, &programmed, &predicted);
    both[1].spacing = curve.spacing;
    Ok(both)
}

/// Returns the loads at each list of feedrates (mm/s, one per place).
///
/// # Errors
///
/// Returns an error if the set-up has no coefficients, or a place has no tool or no spindle speed.
pub fn loads(
    engagement: &Engagement,
    toolpath: &Toolpath,
    setup: &Setup,
    feedrates: &[&[f64]],
) -> Result<Vec<LoadCurve>, CuttingError> {
    loads_with(engagement, toolpath, setup, feedrates, None, &mut |_| {})
}

/// Returns the loads at each list of feedrates, and adds the headroom above the first list to `rooms`.
fn loads_with(
    engagement: &Engagement,
    toolpath: &Toolpath,
    setup: &Setup,
    feedrates: &[&[f64]],
    mut rooms: Option<&mut Vec<PlaceHeadroom>>,
    progress: &mut dyn FnMut(f64),
) -> Result<Vec<LoadCurve>, CuttingError> {
    let coefficients = setup.coefficients.ok_or(CuttingError::NoMaterial)?;
    let whole = [Operation::default()];
    let operations = if toolpath.operations.is_empty() { &whole[..] } else { &toolpath.operations };
    let blank =
        LoadCurve { operations: vec![OperationLoad::default(); operations.len()], ..LoadCurve::default() };
    let mut all = vec![blank; feedrates.len()];
    let operation_of = |segment: usize| {
        operations.partition_point(|operation| operation.first_segment <= segment).max(1) - 1
    };
    let mut watches = vec![LimitWatch::default(); feedrates.len()];
    let tell = (engagement.places.len() as f64 * PROGRESS_STEP_RATIO).ceil() as usize;
    for (index, place) in engagement.places.iter().enumerate() {
        if index % tell == 0 {
            progress(index as f64 / engagement.places.len() as f64);
        }
        let operation = operation_of(place.segment);
        let mill = setup.mill(operations[operation].tool, place.line)?;
        let speed = spindle_speed(toolpath, setup, place.segment)
            .ok_or(CuttingError::NoSpindleSpeed { line: place.line })?;
        let Some(rotor) = Rotor::new(mill, coefficients) else {
            let tool = operations[operation].tool;
            return Err(CuttingError::NoDiameter { tool, line: place.line });
        };
        let turns = speed / SECONDS_PER_MINUTE;
        let per_tooth = place.level / (turns * f64::from(rotor.teeth));
        let sectors = engagement.sectors(place);
        let is_limited = mill.limits.is_any() || setup.spindle.is_any();
        let higher =
            if rooms.is_some() && is_limited && !sectors.is_empty() { &FEED_FACTORS[..] } else { &[] };
        let given = feedrates.iter().map(|feedrates| feedrates[index]);
        let raised = higher.iter().map(|factor| factor * feedrates[0][index]);
        let speeds: Vec<f64> = given.chain(raised).collect();
        let feeds: Vec<f64> = speeds.iter().map(|speed| speed * per_tooth).collect();
        let forces = rotor.forces(sectors, &feeds);
        let loads_of = forces.iter().zip(speeds).zip(&feeds);
        let of_all: Vec<CutLoad> = loads_of
            .map(|((force, speed), feed)| CutLoad {
                feed_per_tooth: if sectors.is_empty() { 0.0 } else { *feed },
                ..load_of(force, place, speed, turns, mill.compliance)
            })
            .collect();
        let (of_given, of_raised) = of_all.split_at(feedrates.len());
        if let Some(rooms) = &mut rooms {
            let ladder = of_given.iter().take(1).chain(of_raised);
            let (steps, limit) = match limit_met(ladder, &mill.limits, &setup.spindle) {
                _ if !is_limited || place.level < MIN_LEVEL_SHARE => (0, None),
                Some((step, limit)) => (step.saturating_sub(1), Some(limit)),
                None => (FEED_FACTORS.len(), None),
            };
            rooms.push(PlaceHeadroom { operation, steps, limit });
        }
        for ((loads, watch), load) in all.iter_mut().zip(&mut watches).zip(of_given) {
            let peak = |value: f64| Peak { value, line: place.line, distance: place.distance };
            loads.force.rise(peak(load.force));
            loads.torque.rise(peak(load.torque));
            loads.power.rise(peak(load.power));
            loads.removal_rate.rise(peak(load.removal_rate));
            let own = &mut loads.operations[operation];
            own.removed += place.removed;
            own.force.rise(peak(load.force));
            own.power.rise(peak(load.power));
            watch.pass(load, &mill.limits, &setup.spindle, peak, &mut loads.exceeded);
            loads.at.push(*load);
        }
    }
    for loads in &mut all {
        loads.finish(engagement, operation_of);
    }
    Ok(all)
}

/// Returns the load at a place at `speed` (mm/s), with a spindle at `turns` per second and a mill of this
/// `compliance` (mm/N).
fn load_of(force: &Force, place: &CutPlace, speed: f64, turns: f64, compliance: f64) -> CutLoad {
    let [x, y, z] = force.mean;
    CutLoad {
        force: force.peak,
        mean_force: x.hypot(y).hypot(z),
        torque: force.peak_torque,
        power: TAU * turns * force.mean_torque,
        removal_rate: place.removed * speed / place.length,
        chip: force.chip,
        feed_per_tooth: 0.0,
        deflection: compliance * force.peak,
    }
}

/// Returns the index of the first load beyond a limit, and that limit.
fn limit_met<'a>(
    loads: impl Iterator<Item = &'a CutLoad>,
    limits: &LoadLimits,
    spindle: &LoadLimits,
) -> Option<(usize, LimitKind)> {
    let met = |load: &CutLoad| {
        let watched = watched(load, limits, spindle);
        watched.into_iter().find(|(_, value, allowed)| allowed < value).map(|(limit, ..)| limit)
    };
    loads.map(met).enumerate().find_map(|(step, met)| Some((step, met?)))
}

/// Returns the spindle speed on a segment, rpm: the program's, or else the set-up's.
fn spindle_speed(toolpath: &Toolpath, setup: &Setup, segment: usize) -> Option<f64> {
    let before = toolpath.spins.partition_point(|(first, _)| *first <= segment);
    let programmed = before.checked_sub(1).map(|last| toolpath.spins[last].1.speed);
    programmed.filter(|speed| 0.0 < *speed).or(setup.spindle_speed).filter(|speed| 0.0 < *speed)
}

/// Returns each limit with the quantity and its largest allowed value.
fn watched(load: &CutLoad, tool: &LoadLimits, spindle: &LoadLimits) -> [(LimitKind, f64, f64); 8] {
    [
        (LimitKind::ToolForce, load.force, tool.force),
        (LimitKind::ToolTorque, load.torque, tool.torque),
        (LimitKind::ToolPower, load.power, tool.power),
        (LimitKind::ToolChip, load.chip, tool.chip),
        (LimitKind::ToolDeflection, load.deflection, tool.deflection),
        (LimitKind::SpindleForce, load.force, spindle.force),
        (LimitKind::SpindleTorque, load.torque, spindle.torque),
        (LimitKind::SpindlePower, load.power, spindle.power),
    ]
}

/// The open part of the path beyond each limit: the last distance beyond it (mm) and the index of its entry.
#[derive(Clone, Copy, Debug, Default)]
struct LimitWatch {
    open: [Option<(f64, usize)>; 8],
}

impl LimitWatch {
    /// Opens, extends or closes the parts beyond the limits at a place.
    fn pass(
        &mut self,
        load: &CutLoad,
        tool: &LoadLimits,
        spindle: &LoadLimits,
        peak: impl Fn(f64) -> Peak,
        exceeded: &mut Vec<ExceededLimit>,
    ) {
        for (open, (limit, value, allowed)) in self.open.iter_mut().zip(watched(load, tool, spindle)) {
            if value <= allowed {
                continue;
            }
            let peak = peak(value);
            match *open {
                // A short dip between two exceedings does not make two entries.
                Some((last, entry)) if peak.distance - last <= MAX_GAP_MM => {
                    let entry = &mut exceeded[entry];
                    entry.peak.rise(peak);
                    entry.lines = (entry.lines.0.min(peak.line), entry.lines.1.max(peak.line));
                    *open = open.map(|(_, entry)| (peak.distance, entry));
                }
                _ => {
                    *open = Some((peak.distance, exceeded.len()));
                    exceeded.push(ExceededLimit { limit, allowed, peak, lines: (peak.line, peak.line) });
                }
            }
        }
    }
}
