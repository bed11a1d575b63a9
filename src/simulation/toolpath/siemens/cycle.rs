//! The drilling cycles of SINUMERIK controls.
//!
//! ```text
//! CYCLE81 (RTP, RFP, SDIS, DP, DPR)                       drilling
//! CYCLE82 (RTP, RFP, SDIS, DP, DPR, DTB)                  with dwell
//! CYCLE83 (RTP, RFP, SDIS, DP, DPR, FDEP, FDPR, DAM, DTB, DTS, FRF, VARI, AXN, MDEP, VRT, DTD, DIS1)
//! CYCLE84 (RTP, RFP, SDIS, DP, DPR, DTB, SDAC, MPIT, PIT, POSS, SST, SST1)       rigid tapping
//! CYCLE840(RTP, RFP, SDIS, DP, DPR, DTB, SDR, SDAC, ENC, MPIT, PIT)              floating tapping
//! CYCLE85 (RTP, RFP, SDIS, DP, DPR, DTB, FFR, RFF)        feed in, feed out
//! CYCLE86 (RTP, RFP, SDIS, DP, DPR, DTB, SDIR, RPA, RPO)  oriented stop, off the wall
//! CYCLE87 (RTP, RFP, SDIS, DP, DPR, SDIR)                 stop, out after a start by hand
//! CYCLE88 (RTP, RFP, SDIS, DP, DPR, DTB, SDIR)            the same with dwell
//! CYCLE89 (RTP, RFP, SDIS, DP, DPR, DTB)                  feed in, dwell, feed out
//! HOLES1  (SPCA, SPCO, STA1, FDIS, DBH, NUM)              a row of holes, under MCALL
//! HOLES2  (CPA, CPO, RAD, STA1, INDA, NUM)                a circle of holes, under MCALL
//! ```
//!
//! RTP is the height to return to, RFP that of the part, SDIS the clearance above it, DP the depth
//! and DPR the depth below RFP, DTB a dwell (s; turns of the spindle where negative). DAM is the
//! amount by which pecks shrink, or the factor where it is negative; VARI 1 retracts, 0 breaks
//! chips. Pitch is PIT (mm), or that of the metric thread M MPIT; negative for left hand.
//!
//! Source: SINUMERIK 840D sl, Programming Manual Cycles, 2013.

use crate::simulation::gcode::address;
use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::cycle::hole::{Kind, Pecks, Turn};
use crate::simulation::toolpath::cycle::{Hole, NoHole};
use crate::simulation::toolpath::remark::Untraced;
use crate::simulation::toolpath::trace::Tracer;

/// A cycle with its arguments, heights in program coordinates, in the program's unit.
#[derive(Clone, Copy, Debug)]
pub(in crate::simulation::toolpath) struct Drilling {
    name: &'static str,
    arguments: [f64; 20],
}

/// Retract of chip breaking and clearance of full retract where the program gives none, mm.
const RETRACT: f64 = 1.0;

/// Coarse pitches of metric threads by their diameter, mm (ISO 261).
const METRIC: [(f64, f64); 19] = [
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

impl Drilling {
    /// An argument that is not 0.
    fn given(&self, index: usize) -> Option<f64> {
        Some(self.arguments[index]).filter(|value| *value != 0.0)
    }
}

impl Tracer<'_> {
    /// A cycle with the arguments of the block.
    pub(super) fn siemens_drilling(&mut self, block: Block, name: &'static str) -> Option<Drilling> {
        let mut arguments = [0.0; 20];
        for word in block.words {
            if let Some(slot) = word
                .letter
                .checked_sub(address::ARGUMENT)
                .and_then(|index| arguments.get_mut(usize::from(index)))
            {
                *slot = word.value;
            }
        }
        Some(Drilling { name, arguments })
    }

    /// Makes a hole where the tool stands.
    pub(super) fn siemens_hole(&mut self, block: Block, drilling: &Drilling) {
        let outcome = self.siemens_hole_of(block, drilling).and_then(|hole| {
            let work = self.plan_hole(block, &hole)?;
            let exact_stop = self.exact_stop;
            self.make_hole(block, &work)?;
            self.exact_stop = exact_stop;
            Ok(())
        });
        if let Err(no_hole) = outcome {
            let name = drilling.name;
            self.remarks.add(block.place(), Untraced::NoSiemensHole { name, no_hole });
        }
    }

    fn siemens_hole_of(&mut self, block: Block, drilling: &Drilling) -> Result<Hole, NoHole> {
        let unit = self.modal.unit;
        let a = &drilling.arguments;
        let (part, clearance) = (a[1] * unit, a[2].abs() * unit);
        let depth = match drilling.given(4) {
            Some(depth) => part - depth.abs() * unit,
            None => a[3] * unit,
        };
        let normal = self.modal.plane.axes()[2];
        let height = |value: f64| self.frame.coordinate_at(&self.position, normal, value);
        let [return_to, reference, bottom] = [a[0] * unit, part + clearance, depth].map(height);
        let feed_in = self.feedrate(block);
        let per_minute = |value: f64| value * unit / 60.0;
        let dwell = self.siemens_seconds(if drilling.name == "CYCLE83" { a[8] } else { a[5] });
        let mut hole = Hole {
            kind: Kind::Drill,
            reference,
            bottom,
            feed_out_to: reference,
            return_to,
            feed_in,
            feed_out: feed_in,
            dwell: 0.0,
            dwell_outside: 0.0,
        };
        let turn = if a[6] == 4.0 { Turn::Left } else { Turn::Right };
        match drilling.name {
            "CYCLE82" => hole.dwell = dwell,
            "CYCLE83" => {
                let first = match (drilling.given(6), drilling.given(5)) {
                    (Some(relative), _) => relative.abs() * unit,
                    (None, Some(absolute)) => part - absolute * unit,
                    (None, None) => part - depth,
                };
                let (ratio, decrease) = if a[7] < 0.0 { (-a[7], 0.0) } else { (1.0, a[7] * unit) };
                let least = if drilling.given(7).is_none() { first } else { a[13].abs() * unit };
                // The first depth counts from the part, pecks from the reference height.
                let pecks = Pecks { first: first + clearance, ratio, decrease, least: least.max(0.01) };
                hole.dwell = dwell;
                hole.kind = match a[11] {
                    0.0 => Kind::ChipBreak {
                        pecks,
                        retract: drilling.given(14).map_or(RETRACT, |retract| retract.abs() * unit),
                        ceiling: reference,
                    },
                    _ => Kind::Peck {
                        pecks,
                        clearance: drilling.given(16).map_or(RETRACT, |distance| distance.abs() * unit),
                        ceiling: reference,
                    },
                };
            }
            "CYCLE84" | "CYCLE840" => {
                let is_rigid = drilling.name == "CYCLE84";
                let (thread, pitch, speed) = if is_rigid { (a[7], a[8], a[10]) } else { (a[9], a[10], 0.0) };
                let pitch = if pitch != 0.0 { pitch * unit } else { pitch_of(thread) };
                let speed = Some(speed).filter(|speed| *speed != 0.0).or(self.functions.speed);
                let turn = if pitch < 0.0 { Turn::Left } else { Turn::Right };
                if let Some(speed) = speed.filter(|_| pitch != 0.0) {
                    hole.feed_in = pitch.abs() * speed.abs() / 60.0;
                    hole.feed_out = hole.feed_in;
                    if let (true, Some(speed_out)) = (is_rigid, drilling.given(11)) {
                        hole.feed_out = pitch.abs() * speed_out.abs() / 60.0;
                    }
                }
                hole.dwell = dwell;
                hole.kind = Kind::Tap { turn, is_rigid };
            }
            "CYCLE85" => {
                hole.kind = Kind::Bore;
                hole.dwell = dwell;
                hole.feed_in = drilling.given(6).map_or(feed_in, per_minute);
                hole.feed_out = drilling.given(7).map_or(hole.feed_in, per_minute);
            }
            "CYCLE86" => {
                hole.kind = Kind::FineBore { turn, shift: [a[7] * unit, a[8] * unit] };
                hole.dwell = dwell;
            }
            "CYCLE87" => {
                let turn = if a[5] == 4.0 { Turn::Left } else { Turn::Right };
                hole.kind = Kind::BoreAndStop { turn, by_hand: true };
            }
            "CYCLE88" => {
                hole.kind = Kind::BoreAndStop { turn, by_hand: true };
                hole.dwell = dwell;
            }
            "CYCLE89" => {
                hole.kind = Kind::Bore;
                hole.dwell = dwell;
            }
            _ => {}
        }
        Ok(hole)
    }

    /// A dwell of a cycle, s: turns of the spindle where it is negative.
    fn siemens_seconds(&self, value: f64) -> f64 {
        let seconds =
            if value < 0.0 { 60.0 * value / -self.functions.speed.unwrap_or(f64::INFINITY) } else { value };
        if (0.0..=1e5).contains(&seconds) { seconds } else { 0.0 }
    }

    /// HOLES1 and HOLES2: the holes of the modal cycle in a row or on a circle.
    pub(super) fn siemens_holes(&mut self, block: Block, name: &'static str) {
        let Some(Drilling { arguments: a, .. }) = self.siemens_drilling(block, name) else { return };
        let Some(drilling) = self.siemens.modal else {
            self.remarks.add(
                block.place(),
                Untraced::Statement { name, what: "no cycle is in force (MCALL): no hole is made" },
            );
            return;
        };
        let unit = self.modal.unit;
        let count = if (1.0..=10_000.0).contains(&a[5]) { a[5] as usize } else { 0 };
        let angle = |degrees: f64| degrees.to_radians();
        for index in 0..count {
            let place = if name == "HOLES1" {
                let along = (a[3] + a[4] * index as f64) * unit;
                [a[0] * unit + along * angle(a[2]).cos(), a[1] * unit + along * angle(a[2]).sin()]
            } else {
                let step = if a[4] == 0.0 { 360.0 / count as f64 } else { a[4] };
                let at = angle(a[3] + step * index as f64);
                [(a[0] + a[2] * at.cos()) * unit, (a[1] + a[2] * at.sin()) * unit]
            };
            let mut program = self.frame.to_program(&self.position);
            let [first, second, _] = self.modal.plane.axes();
            (program[first], program[second]) = (place[0], place[1]);
            let target = self.frame.to_machine(&program);
            if !self.is_within_reach(block, 'X', target.coords.amax()) {
                return;
            }
            self.rapid_to(block, target);
            self.siemens_hole(block, &drilling);
        }
    }
}

/// The pitch of a metric thread by its diameter, mm; 0 where there is none.
fn pitch_of(thread: f64) -> f64 {
    let found = METRIC.iter().find(|(diameter, _)| *diameter == thread.abs());
    found.map_or(0.0, |(_, pitch)| pitch * thread.signum())
}
