//! Programmed contour → path of the tool centre: corner treatments, then cutter radius compensation.
//!
//! ```text
//! programmed moves → rounding (RND, CHF, ,R ,C) → queue (G41, G42) → segments
//! ```
//!
//! Every programmed move passes [`Contour`]. Without treatment and compensation it comes out unchanged and at
//! once. All geometry is in the working plane; the third coordinate is interpolated. Where a control would refuse
//! a move, Truefeed continues the path and remarks how.
//!
//! Limits: the tool is a circle, without lathe orientation (L of G41.1) or wear. The queue looks back over 16
//! moves, so it does not see a contour that crosses itself over more moves.
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

/// Largest size of a tool or of a corner treatment that counts as meant, mm.
pub(crate) const MAX_SIZE_MM: f64 = 1e6;

/// A move kept back for the corner at its end.
struct Held {
    segment: Segment,
    plane: Plane,
    /// The stops between it and the next move.
    stops: Vec<Stop>,
}

/// The stage that makes segments of programmed moves.
pub(crate) struct Contour {
    held: Option<Held>,
    /// The treatment of the corner at the end of the held move.
    next_corner: Option<CornerTreatment>,
    /// The treatment of every corner between feed moves, if one is in force.
    every_corner: Option<CornerTreatment>,
    queue: Queue,
}

impl Contour {
    pub(crate) fn new(lead_in: LeadIn) -> Contour {
        Contour { held: None, next_corner: None, every_corner: None, queue: Queue::new(lead_in) }
    }

    /// Returns `true` if moves may be kept back.
    pub(crate) fn keeps_back(&self) -> bool {
        self.held.is_some() || !self.is_plain()
    }

    /// Returns `true` if no compensation and no treatment of every corner is in force.
    fn is_plain(&self) -> bool {
        self.every_corner.is_none() && self.queue.setting().is_none()
    }

    /// Returns `true` if the tool is beside the programmed position, so that even a move of no length moves it.
    pub(crate) fn is_beside(&self) -> bool {
        self.queue.is_beside()
    }

    /// Returns `true` if a move with a length comes out unchanged and at once.
    pub(crate) fn is_idle(&self) -> bool {
        !self.keeps_back() && !self.is_beside() && self.next_corner.is_none()
    }

    /// Adds the next programmed move, in this working plane.
    #[inline]
    pub(crate) fn add(&mut self, segment: Segment, plane: Plane, out: &mut Toolpath) {
        if !self.is_plain() || self.held.is_some() {
            return self.add_behind_held(segment, plane, out);
        }
        self.next_corner = None;
        // Nearly every move of a long program comes out here, unchanged.
        if self.queue.lets_pass(&segment) { out.segments.push(segment) } else { self.queue.add(segment, out) }
    }

    /// Adds the next programmed move while moves are kept back.
    fn add_behind_held(&mut self, segment: Segment, plane: Plane, out: &mut Toolpath) {
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
                        self.queue.add(corner, out);
                    }
                    next = after;
                }
                Ok(None) => {}
                Err(remark) => self.queue.remarks.push((held.segment.line, remark)),
            }
        }
        self.release(out);
        let Some(segment) = next else { return };
        if self.is_plain() {
            self.queue.add(segment, out);
        } else {
            self.held = Some(Held { segment, plane, stops: Vec::new() });
        }
    }

    /// Adds a stop after the last move.
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

    /// Treats every corner between feed moves from here on; `None` ends that.
    pub(crate) fn treat_every_corner(&mut self, treatment: Option<CornerTreatment>) {
        self.every_corner = treatment;
    }

    /// Returns the compensation in force.
    pub(crate) fn setting(&self) -> Option<Setting> {
        self.queue.setting()
    }

    /// Sets the way of the tool around outer corners from here on.
    pub(crate) fn set_outer_corner_rule(&mut self, outer_corner: OuterCorner) {
        self.queue.outer_corner = outer_corner;
    }

    /// Sets the compensation from the next move on; `None` ends it.
    pub(crate) fn set(&mut self, setting: Option<Setting>, out: &mut Toolpath) {
        if setting != self.queue.setting() {
            self.release(out);
            self.queue.set(setting, out);
        }
    }

    /// Sets the compensation from the next move on; the tool is at its distance already, at `at`.
    pub(crate) fn begin_beside(&mut self, setting: Setting, at: Point, out: &mut Toolpath) {
        self.release(out);
        self.queue.begin_beside(setting, at, out);
    }

    /// Takes the position of the tool, if that is not the programmed one. It becomes the programmed position.
    pub(crate) fn take_offset_position(&mut self) -> Option<Point> {
        self.queue.at.take()
    }

    /// Writes out all moves and stops that are kept back.
    pub(crate) fn finish(&mut self, out: &mut Toolpath) {
        self.release(out);
        self.queue.flush(out);
    }

    pub(crate) fn release(&mut self, out: &mut Toolpath) {
        let segment = self.held.as_ref().map(|held| held.segment.clone());
        self.release_as(segment, out);
        self.next_corner = None;
    }

    /// Passes the rest of the held move and the stops after it on to the queue.
    fn release_as(&mut self, segment: Option<Segment>, out: &mut Toolpath) {
        let Some(Held { stops, .. }) = self.held.take() else { return };
        if let Some(segment) = segment {
            self.queue.add(segment, out);
        }
        for stop in stops {
            self.queue.stop(stop, out);
        }
    }

    /// Takes the remarks since the last call.
    pub(crate) fn take_remarks(&mut self) -> Vec<(LineNumber, CompensationRemark)> {
        std::mem::take(&mut self.queue.remarks)
    }
}

/// Returns `true` for two feed moves in their plane; only those get the treatment of every corner.
fn is_contour(held: &Held, next: &Segment) -> bool {
    [&held.segment, next].into_iter().all(|segment| {
        let is_feed = matches!(segment.motion, Motion::Feed { .. });
        is_feed && planar::planar_curve(held.plane, segment).is_some()
    })
}
