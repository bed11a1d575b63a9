//! Programmed contour → path of the tool's centre: corner treatments, then cutter radius
//! compensation.
//!
//! ```text
//! programmed moves → rounding (RND, CHF, ,R ,C) → queue (G41, G42) → segments
//! ```
//!
//! Every programmed move goes through [`Contour`]; with neither in force it comes out unchanged
//! and at once. All geometry is in the working plane; the third coordinate is carried along.
//! Where a control would refuse, the path continues, and a remark says how.
//!
//! Limits: the tool is a circle, without lathe orientation (L of G41.1) or wear; the queue looks
//! back over 16 moves; a contour that crosses itself further apart is not seen.
//!
//! Source: LinuxCNC user manual, cutter radius compensation.

mod corner;
mod geometry;
mod offset_queue;
mod planar;
mod remark;
mod rounding;

pub(crate) use corner::OuterCorner;
pub(crate) use offset_queue::{LeadIn, Setting};
pub(crate) use remark::CompensationRemark;
pub(crate) use rounding::{CornerShape, CornerTreatment};

use crate::simulation::gcode::LineNumber;
use crate::simulation::toolpath::compensation::offset_queue::Queue;
use crate::simulation::toolpath::compensation::rounding::Treated;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::{Motion, Point, Segment, Stop, Toolpath};

/// The largest size of a tool or of a corner treatment that is taken at its word, mm.
pub(crate) const MAX_SIZE_MM: f64 = 1e6;

/// A move kept back for the corner at its end.
struct Held {
    segment: Segment,
    plane: Plane,
    /// What follows it before the next move.
    stops: Vec<Stop>,
}

/// The stage between programmed moves and segments.
pub(crate) struct Contour {
    held: Option<Held>,
    /// For the corner at the end of the held move.
    next_corner: Option<CornerTreatment>,
    /// For every corner between feed moves, until it is taken back.
    every_corner: Option<CornerTreatment>,
    queue: Queue,
}

impl Contour {
    pub(crate) fn new(lead_in: LeadIn) -> Contour {
        Contour { held: None, next_corner: None, every_corner: None, queue: Queue::new(lead_in) }
    }

    /// Moves may still be kept back.
    pub(crate) fn keeps_back(&self) -> bool {
        self.held.is_some() || !self.is_plain()
    }

    /// Moves come out as they are given, and at once.
    fn is_plain(&self) -> bool {
        self.every_corner.is_none() && self.queue.setting().is_none()
    }

    /// The tool is beside the programmed position, so that even a move of no length moves it.
    pub(crate) fn is_beside(&self) -> bool {
        self.queue.is_beside()
    }

    /// A move comes out as it is given if it has a length, and nothing waits for it.
    pub(crate) fn is_idle(&self) -> bool {
        !self.keeps_back() && !self.is_beside() && self.next_corner.is_none()
    }

    /// The next programmed move, in this working plane.
    #[inline]
    pub(crate) fn take(&mut self, segment: Segment, plane: Plane, out: &mut Toolpath) {
        if !self.is_plain() || self.held.is_some() {
            return self.take_in(segment, plane, out);
        }
        self.next_corner = None;
        // Nearly every move of a long program comes out here as it is.
        if self.queue.lets_pass(&segment) {
            out.segments.push(segment)
        } else {
            self.queue.take(segment, out)
        }
    }

    /// The next programmed move, where moves are kept back.
    fn take_in(&mut self, segment: Segment, plane: Plane, out: &mut Toolpath) {
        let another_plane =
            |setting: Setting| (setting.plane != plane).then_some(Setting { plane, ..setting });
        if let Some(setting) = self.queue.setting().and_then(another_plane) {
            self.set(Some(setting), out);
        }
        let mut next = Some(segment);
        if let (Some(held), Some(segment)) = (&self.held, &next)
            && let Some(treatment) = self.next_corner.or(self.every_corner)
            && (self.next_corner.is_some() || is_contour(held, segment))
            && held.plane == plane
        {
            match rounding::treat(plane, (&held.segment, segment), &treatment) {
                Ok(Some(Treated { before, corner, after })) => {
                    self.release_as(before, out);
                    if let Some(corner) = corner {
                        self.queue.take(corner, out);
                    }
                    next = after;
                }
                Ok(None) => {}
                Err(trouble) => self.queue.troubles.push((held.segment.line, trouble)),
            }
        }
        self.release(out);
        let Some(segment) = next else { return };
        if self.is_plain() {
            self.queue.take(segment, out);
        } else {
            self.held = Some(Held { segment, plane, stops: Vec::new() });
        }
    }

    /// A stop between the moves.
    pub(crate) fn stop(&mut self, stop: Stop, out: &mut Toolpath) {
        match &mut self.held {
            Some(held) => held.stops.push(stop),
            None => self.queue.stop(stop, out),
        }
    }

    /// Treats the corner between the last move given and the next one.
    pub(crate) fn treat_next_corner(&mut self, treatment: CornerTreatment, plane: Plane, out: &mut Toolpath) {
        if self.held.is_none() && self.is_plain() && !self.is_beside() {
            let Some(segment) = out.segments.pop() else { return };
            let first = out.stops.partition_point(|stop| stop.after <= out.segments.len());
            self.held = Some(Held { segment, plane, stops: out.stops.split_off(first) });
        }
        self.next_corner = Some(treatment);
    }

    /// Treats every corner between feed moves from here on, or no longer.
    pub(crate) fn treat_every_corner(&mut self, treatment: Option<CornerTreatment>) {
        self.every_corner = treatment;
    }

    /// Returns the compensation in force.
    pub(crate) fn setting(&self) -> Option<Setting> {
        self.queue.setting()
    }

    /// Chooses how the tool goes around outer corners from here on.
    pub(crate) fn go_around_corners(&mut self, outer_corner: OuterCorner) {
        self.queue.outer_corner = outer_corner;
    }

    /// Changes the compensation in force from the next move on.
    pub(crate) fn set(&mut self, setting: Option<Setting>, out: &mut Toolpath) {
        if setting != self.queue.setting() {
            self.release(out);
            self.queue.set(setting, out);
        }
    }

    /// Puts compensation in force from the next move on, with the tool at its distance already, at `at`.
    pub(crate) fn begin_beside(&mut self, setting: Setting, at: Point, out: &mut Toolpath) {
        self.release(out);
        self.queue.begin_beside(setting, at, out);
    }

    /// Returns where the tool is, if that is not the programmed position; it becomes the programmed position.
    pub(crate) fn take_place(&mut self) -> Option<Point> {
        self.queue.at.take()
    }

    /// Puts out everything that is kept back.
    pub(crate) fn finish(&mut self, out: &mut Toolpath) {
        self.release(out);
        self.queue.flush(out);
    }

    pub(crate) fn release(&mut self, out: &mut Toolpath) {
        let segment = self.held.as_ref().map(|held| held.segment.clone());
        self.release_as(segment, out);
        self.next_corner = None;
    }

    /// Gives on what is left of the held move, and the stops after it.
    fn release_as(&mut self, segment: Option<Segment>, out: &mut Toolpath) {
        let Some(Held { stops, .. }) = self.held.take() else { return };
        if let Some(segment) = segment {
            self.queue.take(segment, out);
        }
        for stop in stops {
            self.queue.stop(stop, out);
        }
    }

    /// What could not be done as a control would, since this was last asked.
    pub(crate) fn troubles(&mut self) -> Vec<(LineNumber, CompensationRemark)> {
        std::mem::take(&mut self.queue.troubles)
    }
}

/// Two feed moves in their plane: what the treatment of every corner is meant for.
fn is_contour(held: &Held, next: &Segment) -> bool {
    [&held.segment, next].into_iter().all(|segment| {
        let is_feed = matches!(segment.motion, Motion::Feed { .. });
        is_feed && planar::stroke(held.plane, segment).is_some()
    })
}
