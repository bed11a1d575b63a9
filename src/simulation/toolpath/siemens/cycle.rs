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
//! ```
//!
//! Newer calls go on with GMODE, DMODE and AMODE (CYCLE84 and CYCLE840 with AXN, PITA, TECHNO and more
//! before them). CYCLE81 then has DTB too, and with a 1 in the tens of GMODE its depth is the diameter
//! of a centring: that of a tip of 90° is taken. The digits of AMODE say what the numbers are: units 1
//! a depth below RFP, 2 a height; tens 1 seconds, 2 turns; in CYCLE83 hundred thousands 2 DAM in
//! percent. PITA 2 gives the pitch in threads per inch, 3 in inches.
//!
//! RTP is the height to return to, RFP that of the part, SDIS the clearance above it, DP the depth
//! and DPR the depth below RFP, DTB a dwell (s; turns of the spindle where negative). DAM is the
//! amount by which strokes shrink, or the factor where it is negative; VARI 1 retracts, 0 breaks
//! chips (see `deep`). Pitch is PIT (mm), or that of the metric thread M MPIT; negative for left hand.
//!
//! Source: SINUMERIK 840D sl, Programming Manuals Cycles and Job Planning
//! (external programming of cycles), 2013.

use crate::simulation::gcode::address;
use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::cycle::hole::{Kind, Turn};
use crate::simulation::toolpath::cycle::{Hole, NoHole};
use crate::simulation::toolpath::feed_mode::FEEDRATES;
use crate::simulation::toolpath::remark::Untraced;
use crate::simulation::toolpath::trace::Tracer;
use crate::units::MM_PER_INCH;

/// A cycle with its arguments, heights in program coordinates, in the program's unit.
#[derive(Clone, Copy, Debug)]
pub(in crate::simulation::toolpath) struct Drilling {
    pub(super) name: &'static str,
    pub(super) arguments: [f64; ARGUMENTS],
}

/// The most arguments of a drilling cycle or a pattern.
const ARGUMENTS: usize = 24;

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
    pub(super) fn given(&self, index: usize) -> Option<f64> {
        Some(self.arguments[index]).filter(|value| *value != 0.0)
    }

    /// A decimal digit of AMODE, the units first; 0 leaves it to the signs of the arguments.
    pub(super) fn mode(&self, digit: i32) -> u32 {
        let place = match self.name {
            "CYCLE81" | "CYCLE82" => 8,
            "CYCLE83" | "CYCLE840" => 19,
            "CYCLE84" => 23,
            "CYCLE85" => 10,
            "CYCLE86" => 13,
            _ => return 0,
        };
        (self.arguments[place].abs().min(1e9) / 10f64.powi(digit)) as u32 % 10
    }
}

impl Tracer<'_> {
    /// A cycle with the arguments of the block.
    pub(super) fn siemens_drilling(&mut self, block: Block, name: &'static str) -> Option<Drilling> {
        let mut arguments = [0.0; ARGUMENTS];
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
            let work = match self.siemens_deep_work(block, drilling, &hole)? {
                Some(work) => work,
                None => self.plan_hole(block, &hole)?,
            };
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
        let depth = match (drilling.given(3), drilling.given(4), drilling.mode(0)) {
            (Some(height), _, 2) => height * unit,
            (Some(below), None, 1) | (_, Some(below), _) => part - below.abs() * unit,
            _ => a[3] * unit,
        };
        let depth = self.siemens_centring(block, drilling, part).unwrap_or(depth);
        let normal = self.modal.plane.axes()[2];
        let height = |value: f64| self.frame.coordinate_at(&self.position, normal, value);
        let [return_to, reference, bottom] = [a[0] * unit, part + clearance, depth].map(height);
        let feed_in = self.feedrate(block);
        let unit_of_feeds = self.unit_of_feeds();
        let per_minute = |value: f64| value * unit_of_feeds / 60.0;
        let dwell = self.siemens_seconds(a[5], drilling.mode(1));
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
            "CYCLE81" | "CYCLE82" => hole.dwell = dwell,
            "CYCLE84" | "CYCLE840" => {
                let is_rigid = drilling.name == "CYCLE84";
                let (thread, pitch, speed) = if is_rigid { (a[7], a[8], a[10]) } else { (a[9], a[10], 0.0) };
                let pitch = match a[if is_rigid { 13 } else { 12 }] {
                    _ if pitch == 0.0 => pitch_of(thread),
                    2.0 => MM_PER_INCH / pitch,
                    3.0 => pitch * MM_PER_INCH,
                    1.0 => pitch,
                    _ => pitch * unit,
                };
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
                hole.kind = Kind::Tap { turn, is_rigid, pecks: None };
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
        for feedrate in [&mut hole.feed_in, &mut hole.feed_out] {
            if !FEEDRATES.contains(feedrate) {
                let what = "no feedrate can be told from its arguments: run at the feedrate in force";
                self.remarks.add(block.place(), Untraced::Statement { name: drilling.name, what });
                *feedrate = feed_in;
            }
        }
        Ok(hole)
    }

    /// The depth of a centring by its diameter, for a tip of 90°.
    fn siemens_centring(&mut self, block: Block, drilling: &Drilling, part: f64) -> Option<f64> {
        let is_diameter = drilling.name == "CYCLE81" && (drilling.arguments[6] / 10.0) as i64 % 10 == 1;
        let diameter = drilling.given(4).unwrap_or(drilling.arguments[3]).abs() * self.modal.unit;
        is_diameter.then(|| {
            let what =
                "the depth is given by a diameter, and the tip of the tool is unknown: a tip of 90° is taken";
            self.remarks.add(block.place(), Untraced::Statement { name: drilling.name, what });
            part - 0.5 * diameter
        })
    }

    /// A dwell of a cycle, s: turns of the spindle where it is negative, or by the mode 2.
    pub(super) fn siemens_seconds(&self, value: f64, mode: u32) -> f64 {
        let is_turns = mode == 2 || mode == 0 && value < 0.0;
        let value = value.abs();
        let seconds =
            if is_turns { 60.0 * value / self.functions.speed.unwrap_or(f64::INFINITY) } else { value };
        if (0.0..=1e5).contains(&seconds) { seconds } else { 0.0 }
    }
}

/// The pitch of a metric thread by its diameter, mm; 0 where there is none.
fn pitch_of(thread: f64) -> f64 {
    let found = METRIC.iter().find(|(diameter, _)| *diameter == thread.abs());
    found.map_or(0.0, |(_, pitch)| pitch * thread.signum())
}
