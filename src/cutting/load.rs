//! Engagement and feed → load: force, torque, power and removal rate along the path.
//!
//! ```text
//! f = v / (n N)        feed per tooth: v level feedrate (mm/s), n speed (1/s), N teeth
//! P = 2π n M           power from the mean torque M over a revolution
//! Q = V v / L          removal rate from the volume V removed over a stretch of length L
//! ```
//!
//! The same engagement is loaded with as many feedrates as wanted: the programmed one and those
//! of the profile. Lengths in mm, times in s, forces in N, torques in N·mm, power in N·mm/s.

use std::f64::consts::TAU;

use crate::cutting::engagement::{Engagement, TOLD};
use crate::cutting::force::{Force, Rotor};
use crate::cutting::headroom::{Headroom, Room, headroom};
use crate::cutting::limits::{CLOSE, FACTORS, Limit, STEEP};
use crate::cutting::setup::{CuttingError, Limits, Setup};
use crate::simulation::profile::FeedCurve;
use crate::simulation::toolpath::{Motion, Operation, Toolpath};
use crate::units::SECONDS_PER_MINUTE;

/// What the tool feels at a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
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
    /// How far the tip is bent aside at most, mm; the axial force counts as if it were lateral.
    pub deflection: f64,
}

/// The largest value of something, and where.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// The value, in the unit of what it is of.
    pub value: f64,
    /// Line of the program.
    pub line: u32,
    /// Distance along the path, mm.
    pub distance: f64,
}

/// What an operation asks of tool and spindle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OperationLoad {
    /// Volume removed, mm³, that of rapids included.
    pub removed: f64,
    /// Largest force, N.
    pub force: Peak,
    /// Largest power, N·mm/s.
    pub power: Peak,
}

/// A stretch of the path on which a limit is exceeded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exceeded {
    /// Which.
    pub limit: Limit,
    /// Its value.
    pub allowed: f64,
    /// Where it is exceeded most, and by what.
    pub peak: Peak,
    /// Least and greatest line.
    pub lines: (u32, u32),
}

/// The load along a path at one feedrate for each place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loads {
    /// At each place of the engagement.
    pub at: Vec<Load>,
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
    /// Where limits are exceeded, by limit and distance.
    pub exceeded: Vec<Exceeded>,
    /// Where the programmed feedrate could be higher; empty but for the loads of that.
    pub headroom: Vec<Headroom>,
    /// Time between the predicted feedrates where they are too few to follow the profile, s.
    pub spacing: Option<f64>,
}

impl Peak {
    fn rise(&mut self, other: Peak) {
        if self.value < other.value {
            *self = other;
        }
    }
}

/// Programmed feedrate at each place, mm/s.
pub fn programmed_feedrates(engagement: &Engagement, toolpath: &Toolpath) -> Vec<f64> {
    let of = |segment: usize| match toolpath.segments.at(segment).motion {
        Motion::Feed { feedrate } => feedrate,
        Motion::Rapid => 0.0,
    };
    engagement.places.iter().map(|place| of(place.segment)).collect()
}

/// The loads by the programmed feedrate, with its headroom, and by that of a profile; `progress` is
/// called with the part done, from 0 to 1.
pub fn programmed_and_predicted(
    engagement: &Engagement,
    toolpath: &Toolpath,
    setup: &Setup,
    curve: &FeedCurve,
    progress: &mut dyn FnMut(f64),
) -> Result<[Loads; 2], CuttingError> {
    let (programmed, predicted) =
        (programmed_feedrates(engagement, toolpath), curve.feedrates_at(engagement.distances()));
    let mut rooms = Vec::with_capacity(engagement.places.len());
    let both =
        loads_with(engagement, toolpath, setup, &[&programmed, &predicted], Some(&mut rooms), progress)?;
    let mut both: [Loads; 2] = both.try_into().expect("two lists of feedrates give two loads");
    both[0].headroom = headroom(engagement, &rooms, &programmed, &predicted);
    both[1].spacing = curve.spacing;
    Ok(both)
}

/// The loads at each list of feedrates (mm/s, one a place).
pub fn loads(
    engagement: &Engagement,
    toolpath: &Toolpath,
    setup: &Setup,
    feedrates: &[&[f64]],
) -> Result<Vec<Loads>, CuttingError> {
    loads_with(engagement, toolpath, setup, feedrates, None, &mut |_| {})
}

/// The same; where `rooms` are asked for they are those above the first list.
fn loads_with(
    engagement: &Engagement,
    toolpath: &Toolpath,
    setup: &Setup,
    feedrates: &[&[f64]],
    mut rooms: Option<&mut Vec<Room>>,
    progress: &mut dyn FnMut(f64),
) -> Result<Vec<Loads>, CuttingError> {
    let coefficients = setup.coefficients.ok_or(CuttingError::NoMaterial)?;
    let whole = [Operation::default()];
    let operations = if toolpath.operations.is_empty() { &whole[..] } else { &toolpath.operations };
    let blank = Loads { operations: vec![OperationLoad::default(); operations.len()], ..Loads::default() };
    let mut all = vec![blank; feedrates.len()];
    let operation_of = |segment: usize| {
        operations.partition_point(|operation| operation.first_segment <= segment).max(1) - 1
    };
    let mut watches = vec![Watch::default(); feedrates.len()];
    let tell = (engagement.places.len() as f64 * TOLD).ceil() as usize;
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
        let higher = if rooms.is_some() && is_limited && !sectors.is_empty() { &FACTORS[..] } else { &[] };
        let given = feedrates.iter().map(|feedrates| feedrates[index]);
        let raised = higher.iter().map(|factor| factor * feedrates[0][index]);
        let speeds: Vec<f64> = given.chain(raised).collect();
        let feeds: Vec<f64> = speeds.iter().map(|speed| speed * per_tooth).collect();
        let forces = rotor.forces(sectors, &feeds);
        let load = |force: &Force, speed: f64| {
            let [x, y, z] = force.mean;
            Load {
                force: force.peak,
                mean_force: x.hypot(y).hypot(z),
                torque: force.peak_torque,
                power: TAU * turns * force.mean_torque,
                removal_rate: place.removed * speed / place.length,
                chip: force.chip,
                deflection: mill.compliance * force.peak,
            }
        };
        let of_all: Vec<Load> = forces.iter().zip(speeds).map(|(force, speed)| load(force, speed)).collect();
        let (of_given, of_raised) = of_all.split_at(feedrates.len());
        if let Some(rooms) = &mut rooms {
            let met = |load: &Load| {
                let watched = watched(load, &mill.limits, &setup.spindle);
                watched.into_iter().find(|(_, value, allowed)| allowed < value).map(|(limit, ..)| limit)
            };
            let ladder = of_given.iter().take(1).chain(of_raised).map(met);
            let (steps, limit) = match ladder.enumerate().find_map(|(step, met)| Some((step, met?))) {
                _ if !is_limited || place.level < STEEP => (0, None),
                Some((step, limit)) => (step.saturating_sub(1), Some(limit)),
                None => (FACTORS.len(), None),
            };
            rooms.push(Room { operation, steps, limit });
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
        for collision in &engagement.collisions {
            loads.operations[operation_of(collision.segment)].removed += collision.removed;
        }
        loads
            .exceeded
            .sort_by(|a, b| a.limit.cmp(&b.limit).then(a.peak.distance.total_cmp(&b.peak.distance)));
    }
    Ok(all)
}

/// Speed of the spindle on a segment, rpm, by the program or else by the set-up.
fn spindle_speed(toolpath: &Toolpath, setup: &Setup, segment: usize) -> Option<f64> {
    let before = toolpath.spins.partition_point(|(first, _)| *first <= segment);
    let programmed = before.checked_sub(1).map(|last| toolpath.spins[last].1.speed);
    programmed.filter(|speed| 0.0 < *speed).or(setup.spindle_speed).filter(|speed| 0.0 < *speed)
}

/// Each limit with what it is of and its value.
fn watched(load: &Load, tool: &Limits, spindle: &Limits) -> [(Limit, f64, f64); 8] {
    [
        (Limit::ToolForce, load.force, tool.force),
        (Limit::ToolTorque, load.torque, tool.torque),
        (Limit::ToolPower, load.power, tool.power),
        (Limit::ToolChip, load.chip, tool.chip),
        (Limit::ToolDeflection, load.deflection, tool.deflection),
        (Limit::SpindleForce, load.force, spindle.force),
        (Limit::SpindleTorque, load.torque, spindle.torque),
        (Limit::SpindlePower, load.power, spindle.power),
    ]
}

/// Which stretch beyond each limit is open: the distance of the last place beyond it (mm) and its entry.
#[derive(Clone, Copy, Debug, Default)]
struct Watch {
    open: [Option<(f64, usize)>; 8],
}

impl Watch {
    /// Opens, extends or closes the stretches beyond the limits at a place.
    fn pass(
        &mut self,
        load: &Load,
        tool: &Limits,
        spindle: &Limits,
        peak: impl Fn(f64) -> Peak,
        exceeded: &mut Vec<Exceeded>,
    ) {
        for (open, (limit, value, allowed)) in self.open.iter_mut().zip(watched(load, tool, spindle)) {
            if value <= allowed {
                continue;
            }
            let peak = peak(value);
            match *open {
                // A dip between two exceedings is not worth a second entry.
                Some((last, entry)) if peak.distance - last <= CLOSE => {
                    let entry = &mut exceeded[entry];
                    entry.peak.rise(peak);
                    entry.lines = (entry.lines.0.min(peak.line), entry.lines.1.max(peak.line));
                    *open = open.map(|(_, entry)| (peak.distance, entry));
                }
                _ => {
                    *open = Some((peak.distance, exceeded.len()));
                    exceeded.push(Exceeded { limit, allowed, peak, lines: (peak.line, peak.line) });
                }
            }
        }
    }
}
