//! The steps of one hole, by the drilling cycles of TNC controls.
//!
//! Heights are in program coordinates: the surface Q203, from which the depth Q201 counts downwards; the set-up
//! clearance Q200 above it, where feed begins; Q204 above it, where the tool ends.
//!
//! | cycle | pecks by Q202, from the surface | back between them | out |
//! |---|---|---|---|
//! | 200 | equal | rapid to Q200, wait Q210, rapid to Q200 above the last depth | rapid |
//! | 201, 202 | none | | feed Q208 (0: Q206); 202 with an oriented spindle |
//! | 203 | less by Q212 down to Q205 | after Q213 breaks by Q256 each | feed Q208 (0: rapid) |
//! | 204 | counterbore Q249 from below a part of Q250 | | rapid |
//! | 205 | less by Q212 down to Q205 | rapid, back to Q258 … Q259 above the last depth; breaks after Q257 by Q256 | rapid |
//! | 206 | tap, feed Q206 | | feed, spindle reversed |
//! | 207 | tap, pitch Q239 | | feed, spindle reversed |
//! | 209 | tap, pitch Q239, breaks after Q257 by Q256 | | feed, spindle reversed, Q403 times faster |
//! | 240 | none | | rapid |
//! | 241 | none; from Q379 on, reached at Q253 | | feed Q208 |
//! | 1 | line 3, from line 1 above the surface | rapid to the start, back to 0.6 mm (depth / 50 beyond 30 mm) | rapid |
//! | 2, 17 | tap; 17 by its pitch | | feed |
//!
//! The cycles of the older kind begin at the position of the tool, and count their clearance (line 1) and depth
//! (line 2) from there. Source: TNC 640, Cycle Programming, 2018; TNC 426, 1997. Limits: bore milling (208) and
//! threads (18, 26x) are not modelled; cycle 202 leaves the hole in rapid if Q208 is 0.

use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::bounds::FEEDRATES_MM_S;
use crate::simulation::interpreter::cycle::NoHole;
use crate::simulation::interpreter::cycle::hole::{
    HolePlan, HoleStep, Pecks, SpindleTurn, peck, written_per_made,
};
use crate::simulation::interpreter::klartext::KlartextRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::units::MM_PER_INCH;

/// Least feed of a cycle that means rapid, units of length per minute.
const MIN_RAPID_FEED: f64 = 99_999.0;

/// Displacement of an oriented tool off the wall, mm.
const OFF_THE_WALL_MM: f64 = 0.2;

/// Retract of chip breaking without a value, mm.
const CHIP_BREAK_MM: f64 = 0.2;

/// Most steps of one hole.
const MAX_STEPS: usize = 10_000;

/// Returns `true` for cycles that make a hole.
pub(super) fn is_hole(number: u32) -> bool {
    matches!(number, 1 | 2 | 17 | 200..=207 | 209 | 240 | 241)
}

/// Returns a depth of pecks, mm: the depth of the whole hole if none is given.
fn peck_within(deep: f64, depth: f64) -> f64 {
    if 0.0 < deep { deep } else { depth.max(1e-3) }
}

/// The sizes of a hole; lengths in mm, heights in program coordinates, feedrates in mm/s, dwells in s.
#[derive(Clone, Copy)]
struct Plan {
    reference: f64,
    surface: f64,
    bottom: f64,
    return_to: f64,
    feed: f64,
    /// `None` in rapid.
    feed_out: Option<f64>,
    dwell: f64,
}

/// The pecks of a hole.
#[derive(Clone, Copy)]
struct Pecking {
    pecks: Pecks,
    /// Heights above the last depth at which feed starts again: at the first and at the last peck.
    advance: (f64, f64),
    dwell_outside: f64,
    /// Number of chip breaks before the tool leaves the hole.
    breaks: u32,
    /// Largest depth between chip breaks.
    break_depth: Option<f64>,
    break_by: f64,
    /// `true` if the tool leaves the hole between pecks at the feedrate of the way out.
    feeds_out: bool,
}

impl Interpreter<'_> {
    /// Makes a hole at the position of the tool.
    pub(super) fn make_klartext_hole(&mut self, block: Block, number: u32, lift: f64) {
        let outcome = self.klartext_steps(block, number, lift).and_then(|work| {
            let HolePlan { steps, pecks_per_made } = work;
            self.remark_on_deeper_pecks(block, pecks_per_made);
            let exact_stop = self.canonical.exact_stop;
            let normal = self.canonical.plane.axes()[2];
            let height = |height: f64| self.frame.coordinate_at(&self.canonical.position, normal, height);
            let mut steps: Vec<HoleStep> = steps
                .into_iter()
                .filter(|step| !matches!(step, HoleStep::Dwell(seconds) if *seconds <= 0.0))
                .collect();
            for step in &mut steps {
                match step {
                    HoleStep::Rapid(to) | HoleStep::Feed { to, .. } => *to = height(*to),
                    _ => {}
                }
            }
            let is_far = |step: &HoleStep| matches!(step, HoleStep::Rapid(to) | HoleStep::Feed { to, .. } if to.is_nan() || 1e7 < to.abs());
            if steps.iter().any(is_far) {
                return Err(NoHole::OutOfReach);
            }
            self.make_hole(block, &HolePlan { steps, pecks_per_made })?;
            self.canonical.exact_stop = exact_stop;
            Ok(())
        });
        if let Err(no_hole) = outcome {
            self.remark(block.place(), KlartextRemark::NoHole { number, what: no_hole.to_string() });
        }
    }

    /// Returns a feed of a cycle, mm/s: 0 or a negative one means the feed of the tool call or the block; `None`
    /// for rapid.
    fn cycle_feed(&mut self, block: Block, value: f64) -> Option<f64> {
        let tenths = if self.modal.unit == MM_PER_INCH { 0.1 } else { 1.0 };
        let feedrate = value * self.modal.unit * tenths / 60.0;
        match value {
            MIN_RAPID_FEED.. => None,
            value if 0.0 < value && FEEDRATES_MM_S.contains(&feedrate) => Some(feedrate),
            _ => Some(self.klartext.auto_feed.unwrap_or_else(|| self.feedrate(block))),
        }
    }

    /// Returns the rapid feedrate along the axis of the holes, mm/s.
    fn rapid_along_tool(&self) -> f64 {
        let mut shares = [0.0; 3];
        shares[self.canonical.plane.axes()[2]] = 1.0;
        self.machine.rapid_feedrate(shares)
    }

    /// Returns a parameter of the cycle as a length, mm.
    fn cycle_length(&self, number: u32) -> f64 {
        self.klartext.cycle.q(number) * self.modal.unit
    }

    /// Returns the heights and feedrates of a cycle; in cycles of the older kind they count from the position of
    /// the tool.
    fn klartext_plan(&mut self, block: Block, number: u32, lift: f64) -> Plan {
        let rapid = self.rapid_along_tool();
        if number < 100 {
            let settings = self.klartext.cycle.settings;
            let setting = |line: usize| settings[line].unwrap_or(0.0);
            let at = self.frame.to_program(&self.canonical.position)[self.canonical.plane.axes()[2]];
            let surface = at - setting(1).abs() * self.modal.unit;
            let bottom = surface - setting(2).abs() * self.modal.unit;
            let (feed_line, dwell) = if number == 1 { (5, setting(4)) } else { (4, 0.0) };
            let feed = self.cycle_feed(block, setting(feed_line)).unwrap_or(rapid);
            return Plan { reference: at, surface, bottom, return_to: at, feed, feed_out: None, dwell };
        }
        let surface = self.cycle_length(203) + lift;
        let reference = surface + self.cycle_length(200).abs();
        let return_to = reference.max(surface + self.cycle_length(204));
        let feed = self.cycle_feed(block, self.klartext.cycle.q(206)).unwrap_or(rapid);
        let dwell = self.klartext.cycle.q(211);
        let bottom = surface - self.cycle_length(201).abs();
        Plan { reference, surface, bottom, return_to, feed, feed_out: None, dwell }
    }

    /// Returns pecks by Q202, decreasing by Q212 each down to Q205; `depth` is the depth of the hole, mm.
    fn decreasing_pecks(&self, depth: f64) -> Pecks {
        let deep = peck_within(self.cycle_length(202).abs(), depth);
        let (less, least) = (self.cycle_length(212).abs(), self.cycle_length(205).abs());
        let least = if less == 0.0 { deep } else { least.max(0.01).min(deep) };
        Pecks { first: deep, ratio: 1.0, decrease: less, least }
    }

    /// Returns the steps of a cycle.
    fn klartext_steps(&mut self, block: Block, number: u32, lift: f64) -> Result<HolePlan, NoHole> {
        let mut plan = self.klartext_plan(block, number, lift);
        let out = match self.klartext.cycle.q(208) {
            0.0 => None,
            value => self.cycle_feed(block, value),
        };
        let clearance = plan.reference - plan.surface;
        let depth = plan.surface - plan.bottom;
        let equal = |deep: f64| Pecks::equal(peck_within(deep, depth));
        let plain = Pecking {
            pecks: equal(0.0),
            advance: (clearance, clearance),
            dwell_outside: 0.0,
            breaks: 0,
            break_depth: None,
            break_by: 0.0,
            feeds_out: false,
        };
        let break_by = Some(self.cycle_length(256).abs()).filter(|by| 0.0 < *by).unwrap_or(CHIP_BREAK_MM);
        let turn = self.cycle.turn();
        match number {
            1 => {
                let advance = if depth <= 30.0 { 0.6 } else { (depth / 50.0).min(7.0) };
                let deep = self.klartext.cycle.settings[3].unwrap_or(0.0);
                let pecks = equal(deep.abs() * self.modal.unit);
                plan.steps(&Pecking { pecks, advance: (advance, advance), ..plain })
            }
            200 => {
                let pecks = equal(self.cycle_length(202).abs());
                plan.steps(&Pecking { pecks, dwell_outside: self.klartext.cycle.q(210), ..plain })
            }
            201 => {
                plan.feed_out = Some(out.unwrap_or(plan.feed));
                plan.steps(&plain)
            }
            202 => self.bore_and_orient(&plan, out, turn),
            203 => {
                plan.feed_out = out;
                plan.steps(&Pecking {
                    pecks: self.decreasing_pecks(depth),
                    dwell_outside: self.klartext.cycle.q(210),
                    breaks: self.klartext.cycle.q(213).clamp(0.0, 1000.0) as u32,
                    break_by,
                    feeds_out: out.is_some(),
                    ..plain
                })
            }
            205 => {
                let pecks = self.decreasing_pecks(depth);
                let advance = (self.cycle_length(258).abs(), self.cycle_length(259).abs());
                let break_depth = Some(self.cycle_length(257).abs()).filter(|depth| 0.0 < *depth);
                plan.surface -= self.cycle_length(379).abs();
                plan.steps(&Pecking { pecks, advance, break_depth, break_by, ..plain })
            }
            240 => plan.steps(&plain),
            241 => {
                plan.feed_out = out;
                let start = plan.surface - self.cycle_length(379).abs();
                let mut work = plan.steps(&plain)?;
                if start < plan.surface
                    && let Some(feedrate) = self.cycle_feed(block, self.klartext.cycle.q(253))
                {
                    work.steps.insert(1, HoleStep::Feed { to: start, feedrate });
                }
                Ok(work)
            }
            204 => self.back_bore(block, plan, turn),
            _ => self.tap(block, number, plan, turn),
        }
    }

    /// Returns the steps of cycle 202: boring, and a way out off the wall (Q214) with an oriented spindle, at
    /// `out` (mm/s) or in rapid.
    fn bore_and_orient(&self, plan: &Plan, out: Option<f64>, turn: SpindleTurn) -> Result<HolePlan, NoHole> {
        let shift = match self.klartext.cycle.q(214) as i32 {
            1 => [-OFF_THE_WALL_MM, 0.0],
            2 => [0.0, -OFF_THE_WALL_MM],
            3 => [OFF_THE_WALL_MM, 0.0],
            4 => [0.0, OFF_THE_WALL_MM],
            _ => [0.0, 0.0],
        };
        plan.check_depth()?;
        let up = match out {
            Some(feedrate) => HoleStep::Feed { to: plan.reference, feedrate },
            None => HoleStep::Rapid(plan.reference),
        };
        Ok(HolePlan::from(vec![
            HoleStep::Rapid(plan.reference),
            HoleStep::Feed { to: plan.bottom, feedrate: plan.feed },
            HoleStep::Dwell(plan.dwell),
            HoleStep::Orient,
            HoleStep::Shift(shift),
            up,
            HoleStep::Rapid(plan.return_to),
            HoleStep::Shift([0.0, 0.0]),
            HoleStep::Start(turn),
        ]))
    }

    /// Returns the steps of cycle 204: Q249 depth of the counterbore, Q250 thickness of the part, Q251 off-centre
    /// distance of the tool, Q252 height of its edge, Q253 feed of the way in, Q254 feed of the work, Q255 dwell.
    fn back_bore(&mut self, block: Block, plan: Plan, turn: SpindleTurn) -> Result<HolePlan, NoHole> {
        let unit = self.modal.unit;
        let q = |interpreter: &Self, number: u32| interpreter.klartext.cycle.q(number);
        let rapid = self.rapid_along_tool();
        let into = self.cycle_feed(block, q(self, 253)).unwrap_or(rapid);
        let work = self.cycle_feed(block, q(self, 254)).unwrap_or(rapid);
        let under = plan.surface - (q(self, 250) + q(self, 252)).abs() * unit;
        let below = under - (plan.reference - plan.surface);
        let top = under + q(self, 249).abs() * unit;
        let aside = q(self, 251) * unit;
        let shift = match q(self, 214) as i32 {
            1 => [-aside, 0.0],
            2 => [0.0, -aside],
            3 => [aside, 0.0],
            _ => [0.0, aside],
        };
        Ok(HolePlan::from(vec![
            HoleStep::Rapid(plan.reference),
            HoleStep::Orient,
            HoleStep::Shift(shift),
            HoleStep::Feed { to: below, feedrate: into },
            HoleStep::Shift([0.0, 0.0]),
            HoleStep::Start(turn),
            HoleStep::Feed { to: top, feedrate: work },
            HoleStep::Dwell(q(self, 255)),
            HoleStep::Feed { to: below, feedrate: work },
            HoleStep::Orient,
            HoleStep::Shift(shift),
            HoleStep::Feed { to: plan.reference, feedrate: into },
            HoleStep::Rapid(plan.return_to),
            HoleStep::Shift([0.0, 0.0]),
            HoleStep::Start(turn),
        ]))
    }

    /// Returns the steps of cycles 2, 17, 206, 207 and 209.
    fn tap(
        &mut self,
        block: Block,
        number: u32,
        mut plan: Plan,
        turn: SpindleTurn,
    ) -> Result<HolePlan, NoHole> {
        let unit = self.modal.unit;
        let setting =
            |interpreter: &Self, line: usize| interpreter.klartext.cycle.settings[line].unwrap_or(0.0);
        let q = |interpreter: &Self, number: u32| interpreter.klartext.cycle.q(number);
        let pitch = match number {
            17 => setting(self, 3) * unit,
            207 | 209 => q(self, 239) * unit,
            _ => 0.0,
        };
        let by_pitch = pitch.abs() * self.functions.speed.unwrap_or(0.0) / 60.0;
        let turn = if pitch < 0.0 {
            SpindleTurn::Left
        } else if 0.0 < pitch {
            SpindleTurn::Right
        } else {
            turn
        };
        if pitch != 0.0 {
            if !FEEDRATES_MM_S.contains(&by_pitch) {
                let what = "a pitch without a spindle speed: run at the feedrate in force";
                self.remark(block.place(), KlartextRemark::CycleSetting { number, what });
                plan.feed = self.feedrate(block);
            } else {
                plan.feed = by_pitch;
            }
        }
        if number == 2 {
            plan.dwell = setting(self, 3);
        }
        if number == 207 {
            plan.dwell = 0.0;
        }
        plan.check_depth()?;
        let back = if turn == SpindleTurn::Right { SpindleTurn::Left } else { SpindleTurn::Right };
        let stops = matches!(number, 2 | 206).then_some(HoleStep::Stop);
        let mut steps = vec![HoleStep::Rapid(plan.reference)];
        let faster = Some(q(self, 403)).filter(|factor| number == 209 && 1.0 <= *factor && *factor <= 10.0);
        let feed_out = plan.feed * faster.unwrap_or(1.0);
        let deep = Some(q(self, 257).abs() * unit).filter(|deep| number == 209 && 0.0 < *deep);
        let by = q(self, 256).abs() * unit;
        let mut pecks_per_made = 1.0;
        if let Some(deep) = deep {
            pecks_per_made = peck(plan.surface - plan.bottom, Pecks::equal(deep), |left| {
                steps.push(HoleStep::Feed { to: plan.bottom + left, feedrate: plan.feed });
                if 0.0 < left {
                    let to = if by == 0.0 {
                        plan.reference
                    } else {
                        (plan.bottom + left + by).min(plan.reference)
                    };
                    steps.extend([
                        HoleStep::Start(back),
                        HoleStep::Feed { to, feedrate: feed_out },
                        HoleStep::Start(turn),
                    ]);
                }
            })?;
        } else {
            steps.push(HoleStep::Feed { to: plan.bottom, feedrate: plan.feed });
        }
        steps.push(HoleStep::Dwell(plan.dwell));
        steps.extend(stops.into_iter().chain([HoleStep::Start(back)]));
        steps.push(HoleStep::Feed { to: plan.reference, feedrate: feed_out });
        steps.extend(stops.into_iter().chain([HoleStep::Start(turn)]));
        steps.push(HoleStep::Rapid(plan.return_to));
        Ok(HolePlan { steps, pecks_per_made })
    }
}

impl Plan {
    /// Checks that the hole has a depth.
    ///
    /// # Errors
    ///
    /// If its depth is 0 or less, or not a number.
    fn check_depth(&self) -> Result<(), NoHole> {
        let Plan { reference, bottom, .. } = *self;
        if !(reference - bottom).is_finite() {
            return Err(NoHole::OutOfReach);
        }
        // A cycle with the depth 0 is not run by the control.
        if self.bottom < self.surface { Ok(()) } else { Err(NoHole::NoBottom('Q')) }
    }

    /// Returns the steps down by pecks, and out.
    fn steps(&self, pecking: &Pecking) -> Result<HolePlan, NoHole> {
        self.check_depth()?;
        let Plan { reference, surface, bottom, return_to, feed, feed_out, dwell } = *self;
        let mut steps = vec![HoleStep::Rapid(reference)];
        let depth = surface - bottom;
        let (mut broken, mut from) = (0, surface);
        let (mut breaks, mut breaks_per_made) = (0, 1.0);
        let pecks_per_made = peck(depth, pecking.pecks, |left| {
            let to = bottom + left;
            if let Some(deep) = pecking.break_depth {
                let mut at = from - deep;
                while to + 1e-6 < at {
                    if MAX_STEPS <= steps.len() {
                        breaks_per_made = written_per_made(depth, deep, breaks);
                        break;
                    }
                    breaks += 1;
                    steps.push(HoleStep::Feed { to: at, feedrate: feed });
                    steps.push(HoleStep::Rapid((at + pecking.break_by).min(reference)));
                    at -= deep;
                }
            }
            steps.push(HoleStep::Feed { to, feedrate: feed });
            from = to;
            if left <= 0.0 {
                return;
            }
            if broken < pecking.breaks {
                broken += 1;
                steps.push(HoleStep::Rapid((to + pecking.break_by).min(reference)));
                return;
            }
            broken = 0;
            match feed_out.filter(|_| pecking.feeds_out) {
                Some(feedrate) => steps.push(HoleStep::Feed { to: reference, feedrate }),
                None => steps.push(HoleStep::Rapid(reference)),
            }
            let (first, last) = pecking.advance;
            let share = if 0.0 < depth { 1.0 - left / depth } else { 0.0 };
            let advance = first + (last - first) * share;
            steps.extend([
                HoleStep::Dwell(pecking.dwell_outside),
                HoleStep::Rapid((to + advance).min(reference)),
            ]);
        })?;
        steps.push(HoleStep::Dwell(dwell));
        if let Some(feedrate) = feed_out {
            steps.push(HoleStep::Feed { to: reference, feedrate });
        }
        steps.push(HoleStep::Rapid(return_to));
        Ok(HolePlan { steps, pecks_per_made: pecks_per_made.max(breaks_per_made) })
    }
}
