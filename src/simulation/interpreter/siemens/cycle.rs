//! The drilling cycles of SINUMERIK controls.
//!
//! | cycle | operation |
//! |---|---|
//! | CYCLE81, CYCLE82 | drilling, with a dwell |
//! | CYCLE83 | deep holes, see `deep` |
//! | CYCLE84, CYCLE840 | rigid and floating tapping |
//! | CYCLE85, CYCLE89 | feed in, feed out; with a dwell |
//! | CYCLE86 | oriented stop, off the wall |
//! | CYCLE87, CYCLE88 | stop, out after a start by hand; with a dwell |
//!
//! Newer calls end with GMODE, DMODE and AMODE. With a 1 in the tens of GMODE the depth is the diameter of a
//! centring, of a tip of 90°. The digits of AMODE give the meaning of the numbers: units 1 for a depth below RFP,
//! 2 for a height; tens 1 for seconds, 2 for revolutions; in CYCLE83 hundred thousands 2 for DAM in percent. PITA
//! 2 gives the pitch in threads per inch, 3 in inches.
//!
//! RTP is the height to return to, RFP the height of the part, SDIS the clearance above it, DP the depth and DPR
//! the depth below RFP, DTB a dwell (s; revolutions of the spindle if negative). DAM is the amount by which
//! strokes decrease, or the factor if it is negative; VARI 1 retracts, 0 breaks chips (see `deep`). The pitch is
//! PIT (mm), or the one of the metric thread M MPIT; negative for left hand.
//!
//! Source: SINUMERIK 840D sl, Programming Manuals Cycles and Job Planning
//! (external programming of cycles), 2013.

use crate::simulation::gcode::{DrillingCycle, DrillingKind, ThreadPitch};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::bounds::FEEDRATES_MM_S;
use crate::simulation::interpreter::cycle::hole::{HoleKind, SpindleTurn};
use crate::simulation::interpreter::cycle::{Hole, NoHole};
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::units::MM_PER_INCH;

/// Diameters and coarse pitches of metric threads, mm (ISO 261).
const COARSE_PITCHES_MM: [(f64, f64); 19] = [
    (3.0, 0.5),
    (4.0, 0.7),
    (5.0, 0.8),
    (6.0, 1.0),
    (8.0, 1.25),
    (10.0, 1.5),
    (12.0, 1.75),
    (14.0, 2.0),
    (16.0, 2.0),
    (18.0, 2.5),
    (20.0, 2.5),
    (22.0, 2.5),
    (24.0, 3.0),
    (27.0, 3.0),
    (30.0, 3.5),
    (33.0, 3.5),
    (36.0, 4.0),
    (42.0, 4.5),
    (48.0, 5.0),
];

/// Returns a decimal digit of AMODE, the units first; 0 for the meaning by the signs of the arguments.
pub(super) fn mode(cycle: &DrillingCycle, digit: i32) -> u32 {
    (cycle.modes.abs().min(1e9) / 10f64.powi(digit)) as u32 % 10
}

impl Interpreter<'_> {
    /// Makes a hole at the position of the tool.
    pub(super) fn siemens_hole(&mut self, block: Block, drilling: &DrillingCycle) {
        let outcome = self.siemens_hole_of(block, drilling).and_then(|hole| {
            let work = match self.siemens_deep_work(block, drilling, &hole)? {
                Some(work) => work,
                None => self.plan_hole(block, &hole)?,
            };
            let exact_stop = self.canonical.exact_stop;
            self.make_hole(block, &work)?;
            self.canonical.exact_stop = exact_stop;
            Ok(())
        });
        if let Err(no_hole) = outcome {
            let name = drilling.name;
            self.remarks.add(block.place(), TraceRemark::NoSiemensHole { name, no_hole });
        }
    }

    /// Returns the hole of a cycle.
    fn siemens_hole_of(&mut self, block: Block, cycle: &DrillingCycle) -> Result<Hole, NoHole> {
        let unit = self.modal.unit;
        let (part, clearance) = (cycle.part_height * unit, cycle.clearance.abs() * unit);
        let depth = match (cycle.depth, cycle.relative_depth, mode(cycle, 0)) {
            (Some(height), _, 2) => height * unit,
            (Some(below), None, 1) | (_, Some(below), _) => part - below.abs() * unit,
            (height, ..) => height.unwrap_or(0.0) * unit,
        };
        let depth = self.siemens_centring(block, cycle, part).unwrap_or(depth);
        let normal = self.canonical.plane.axes()[2];
        let height = |value: f64| self.frame.coordinate_at(&self.canonical.position, normal, value);
        let [return_to, reference, bottom] =
            [cycle.return_height * unit, part + clearance, depth].map(height);
        let feed_in = self.feedrate(block);
        let unit_of_feeds = self.unit_of_feeds();
        let per_minute = |value: f64| value * unit_of_feeds / 60.0;
        let mut hole = Hole::drilled(reference, bottom, return_to, feed_in);
        hole.dwell = self.siemens_seconds(cycle.dwell, mode(cycle, 1));
        let turn = |is_left_hand: bool| if is_left_hand { SpindleTurn::Left } else { SpindleTurn::Right };
        match cycle.kind {
            DrillingKind::Drill { .. } | DrillingKind::DeepHole { .. } => {}
            DrillingKind::RigidTap { pitch, speed, speed_out, .. } => {
                self.set_siemens_tap(&mut hole, pitch, speed, speed_out, true);
            }
            DrillingKind::FloatingTap { pitch } => {
                self.set_siemens_tap(&mut hole, pitch, 0.0, None, false);
            }
            DrillingKind::Bore { feed_in: written, feed_out } => {
                hole.kind = HoleKind::Bore;
                hole.feed_in = written.map_or(feed_in, per_minute);
                hole.feed_out = feed_out.map_or(hole.feed_in, per_minute);
            }
            DrillingKind::FineBore { is_left_hand, shift } => {
                hole.kind =
                    HoleKind::FineBore { turn: turn(is_left_hand), shift: shift.map(|way| way * unit) };
            }
            DrillingKind::BoreAndStop { is_left_hand } => {
                hole.kind = HoleKind::BoreAndStop { turn: turn(is_left_hand), by_hand: true };
            }
        }
        for feedrate in [&mut hole.feed_in, &mut hole.feed_out] {
            if !FEEDRATES_MM_S.contains(feedrate) {
                let what = "its arguments give no feedrate: run at the feedrate in force";
                self.remarks.add(block.place(), TraceRemark::Statement { name: cycle.name, what });
                *feedrate = feed_in;
            }
        }
        Ok(hole)
    }

    /// Completes a tapped hole: at the pitch times the speed of the cycle (rpm; 0 for the speed in force).
    fn set_siemens_tap(
        &self,
        hole: &mut Hole,
        thread: ThreadPitch,
        speed: f64,
        speed_out: Option<f64>,
        is_rigid: bool,
    ) {
        let ThreadPitch { metric, pitch, unit } = thread;
        let pitch = match unit {
            _ if pitch == 0.0 => pitch_of(metric),
            2.0 => MM_PER_INCH / pitch,
            3.0 => pitch * MM_PER_INCH,
            1.0 => pitch,
            _ => pitch * self.modal.unit,
        };
        let speed = Some(speed).filter(|speed| *speed != 0.0).or(self.functions.speed);
        if let Some(speed) = speed.filter(|_| pitch != 0.0) {
            hole.feed_in = pitch.abs() * speed.abs() / 60.0;
            hole.feed_out = speed_out.map_or(hole.feed_in, |speed_out| pitch.abs() * speed_out.abs() / 60.0);
        }
        let turn = if pitch < 0.0 { SpindleTurn::Left } else { SpindleTurn::Right };
        hole.kind = HoleKind::Tap { turn, is_rigid, pecks: None };
    }

    /// Returns the depth of a centring by its diameter, for a tip of 90°; `None` if the depth is no diameter.
    fn siemens_centring(&mut self, block: Block, cycle: &DrillingCycle, part: f64) -> Option<f64> {
        let is_diameter = matches!(cycle.kind, DrillingKind::Drill { is_centring: true });
        let diameter = cycle.relative_depth.or(cycle.depth).unwrap_or(0.0).abs() * self.modal.unit;
        is_diameter.then(|| {
            let what =
                "the depth is given by a diameter, and the tip of the tool is unknown: a tip of 90° is taken";
            self.remarks.add(block.place(), TraceRemark::Statement { name: cycle.name, what });
            part - 0.5 * diameter
        })
    }
}

/// Returns the pitch of a metric thread by its diameter, mm; 0 if there is none.
fn pitch_of(thread: f64) -> f64 {
    let found = COARSE_PITCHES_MM.iter().find(|(diameter, _)| *diameter == thread.abs());
    found.map_or(0.0, |(_, pitch)| pitch * thread.signum())
}
