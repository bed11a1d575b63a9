//! Drilling, tapping and boring cycles of Heidenhain controls, as holes of the cycle engine.
//!
//! ```text
//! Q203 surface, Q200 clearance above it, Q204 second clearance, Q201 depth (negative), Q206 feed
//!
//! 200 drilling    Q202 peck, Q211 dwell            201 reaming     Q208 feed out, Q211 dwell
//! 202 boring      Q208, Q211, off the wall         203, 205        Q202, Q212 less each time, Q205 least
//! 206 tapping     feed Q206                        207, 209        Q239 pitch × spindle speed
//! 240 centring    Q211 dwell                       241 deep hole   Q379 start, Q211 dwell
//! 1 pecking, 2 tapping, 17 rigid tapping           set-up, depth, … from where the tool stands
//! ```
//!
//! Full retracts begin again 0.2 mm above the last depth (205: Q258). Not modelled, and said: breaking
//! chips of 209, the depth of 240 by its diameter, feeds of 241 other than Q206, 204 and 208.
//!
//! Source: TNC 640, Cycle Programming 2018, ch. 4 and 5.

use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::cycle::Hole;
use crate::simulation::toolpath::cycle::hole::{Kind, Pecks, Turn};
use crate::simulation::toolpath::klartext::KlartextRemark;
use crate::simulation::toolpath::trace::Tracer;

/// How far above the last depth feed begins again, mm.
const ABOVE_LAST_DEPTH: f64 = 0.2;

/// The least peck, mm, so that a hole ends.
const LEAST_PECK: f64 = 0.01;

impl Tracer<'_> {
    /// Makes a hole of the cycle in force where the tool stands.
    pub(super) fn klartext_hole(&mut self, block: Block) {
        let Some(number) = self.klartext.cycle.number else { return };
        let hole = match number {
            200..=203 | 205..=207 | 209 | 240 | 241 => self.hole_by_parameters(block, number),
            1 | 2 | 17 => self.hole_by_settings(block, number),
            _ => {
                self.remark(block.place(), KlartextRemark::Cycle { number });
                return;
            }
        };
        let exact_stop = self.exact_stop;
        let outcome = self.plan_hole(block, &hole).and_then(|work| self.make_hole(block, &work));
        self.exact_stop = exact_stop;
        if let Err(no_hole) = outcome {
            self.remark(block.place(), KlartextRemark::NoHole { number, what: no_hole.to_string() });
        }
    }

    fn hole_by_parameters(&mut self, block: Block, number: u32) -> Hole {
        let unit = self.modal.unit;
        let normal = self.modal.plane.axes()[2];
        let q = |parameter: u32| self.klartext.cycle.parameter(parameter);
        let length = |parameter: u32| q(parameter).abs() * unit;
        let feed = |parameter: u32| self.cycle_feed(q(parameter));
        let height = |value: f64| self.frame.coordinate_at(&self.position, normal, value);
        let seconds = |parameter: u32| if (0.0..=1e5).contains(&q(parameter)) { q(parameter) } else { 0.0 };
        let surface = q(203) * unit;
        let (clearance, depth) = (length(200), q(201) * unit);
        let own_feed = feed(206);
        let feed_out = feed(208).or(own_feed);
        // Pecks count from the surface, those of the engine from the clearance.
        let pecks = |decrease: f64, least: f64| Pecks {
            first: if q(202) == 0.0 { clearance - depth } else { length(202) + clearance },
            ratio: 1.0,
            decrease: if q(202) == 0.0 { 0.0 } else { decrease.max(clearance) },
            least: least.max(LEAST_PECK),
        };
        let (ceiling, peck) = (height(surface + clearance), length(202));
        let (kind, approximated) = match number {
            200 => (Kind::Peck { pecks: pecks(0.0, peck), clearance: ABOVE_LAST_DEPTH, ceiling }, None),
            203 if 0.0 < q(213) => {
                let retract = if q(256) == 0.0 { ABOVE_LAST_DEPTH } else { length(256) };
                (Kind::ChipBreak { pecks: pecks(length(212), length(205).max(peck)), retract, ceiling }, None)
            }
            203 => (
                Kind::Peck {
                    pecks: pecks(length(212), length(205).max(peck)),
                    clearance: ABOVE_LAST_DEPTH,
                    ceiling,
                },
                None,
            ),
            205 => {
                let clearance = if q(258) == 0.0 { ABOVE_LAST_DEPTH } else { length(258) };
                (Kind::Peck { pecks: pecks(length(212), length(205).max(peck)), clearance, ceiling }, None)
            }
            201 => (Kind::Bore, None),
            202 => (Kind::FineBore { turn: Turn::Right, shift: [ABOVE_LAST_DEPTH, 0.0] }, None),
            206 => (Kind::Tap { turn: Turn::Right, is_rigid: false }, None),
            207 | 209 => {
                let turn = if q(239) < 0.0 { Turn::Left } else { Turn::Right };
                let what =
                    (number == 209).then_some("breaking of chips is not modelled: tapped in one stroke");
                (Kind::Tap { turn, is_rigid: true }, what)
            }
            240 if q(343) == 1.0 => {
                (Kind::Drill, Some("a depth by the diameter is not modelled: Q201 is drilled"))
            }
            241 => (
                Kind::Drill,
                Some("its own feeds and speeds are not modelled: drilled at Q206 from the clearance on"),
            ),
            _ => (Kind::Drill, None),
        };
        let pitch_feed = self.functions.speed.map(|speed| length(239) * speed / 60.0);
        let pitch_feed = pitch_feed.filter(|feed| matches!(number, 207 | 209) && (1e-6..=1e6).contains(feed));
        let (reference, bottom) = (height(surface + clearance), height(surface + depth));
        let return_to = height(surface + clearance.max(q(204) * unit));
        let dwell = seconds(211);
        let feed_in = pitch_feed.or(own_feed);
        let feed_in = feed_in.unwrap_or_else(|| self.feedrate(block));
        let feed_out = if number == 201 { feed_out.unwrap_or(feed_in) } else { feed_in };
        if let Some(what) = approximated {
            self.remark(block.place(), KlartextRemark::CycleSetting { number, what });
        }
        Hole {
            kind,
            reference,
            bottom,
            feed_out_to: reference,
            return_to,
            feed_in,
            feed_out,
            dwell,
            dwell_outside: 0.0,
        }
    }

    /// Cycles 1, 2 and 17: from where the tool stands.
    fn hole_by_settings(&mut self, block: Block, number: u32) -> Hole {
        let unit = self.modal.unit;
        let normal = self.modal.plane.axes()[2];
        let setting = |line: usize| self.klartext.cycle.settings[line].unwrap_or(0.0);
        let here = self.frame.to_program(&self.position)[normal];
        let surface = here - setting(1).abs() * unit;
        let bottom = self.frame.coordinate_at(&self.position, normal, surface + setting(2) * unit);
        let reference = self.position[normal];
        let clearance = here - surface;
        let (peck, dwell) = (setting(3).abs() * unit, setting(if number == 1 { 4 } else { 3 }));
        let own_feed = match number {
            1 => self.cycle_feed(setting(5)),
            2 => self.cycle_feed(setting(4)),
            _ => self.functions.speed.map(|speed| peck * speed / 60.0),
        };
        let kind = match number {
            1 if 0.0 < peck => {
                let pecks = Pecks {
                    first: peck + clearance,
                    ratio: 1.0,
                    decrease: clearance,
                    least: peck.max(LEAST_PECK),
                };
                Kind::Peck { pecks, clearance: 0.6, ceiling: reference }
            }
            1 => Kind::Drill,
            _ => {
                let turn = if setting(3) < 0.0 && number == 17 { Turn::Left } else { Turn::Right };
                Kind::Tap { turn, is_rigid: number == 17 }
            }
        };
        let dwell = if number != 17 && (0.0..=1e5).contains(&dwell) { dwell } else { 0.0 };
        let feed =
            own_feed.filter(|feed| (1e-6..=1e6).contains(feed)).unwrap_or_else(|| self.feedrate(block));
        Hole {
            kind,
            reference,
            bottom,
            feed_out_to: reference,
            return_to: reference,
            feed_in: feed,
            feed_out: feed,
            dwell,
            dwell_outside: 0.0,
        }
    }

    /// A feedrate of a cycle, mm/s; none where it gives none.
    fn cycle_feed(&self, value: f64) -> Option<f64> {
        let feed = value * self.modal.unit / 60.0;
        (1e-6..=1e6).contains(&feed).then_some(feed)
    }
}
