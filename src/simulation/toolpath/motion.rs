//! What a block does with its axis words: dwells, shifts of coordinates and moves.

use crate::machine::AXES;
use crate::simulation::gcode::{Dialect, Word, address};
use crate::simulation::toolpath::block::{AXIS_WORDS, Block, CENTER_WORDS, POLAR_WORDS, bits};
use crate::simulation::toolpath::plane::{Turn, tolerated_difference};
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::rotary::ROTARY_WORDS;
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::words::{Mode, Special};
use crate::simulation::toolpath::{Arc, Curve, Motion, Point, Rotation, Segment, StopCause};

/// Feedrate of feed moves before the first F, mm/s: 1000 mm/min.
pub const ASSUMED_FEEDRATE: f64 = 1000.0 / 60.0;

/// Coordinates and radii beyond this are slips of the pen, mm.
pub(super) const REACH: f64 = 1e7;

/// Moves shorter than this are rounding, mm.
pub(super) const SHORTEST: f64 = 1e-9;

/// The longest dwell that is taken at its word, s: some 11 days.
pub(super) const LONGEST_DWELL: f64 = 1e6;

/// A time without a point that is at least this is no number of seconds in a program of an unknown control.
const LONG_TIME: f64 = 100.0;

/// What a time counts.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum TimeUnit {
    Seconds,
    Milliseconds,
    /// Milliseconds, which only the size of the number says.
    Guessed,
}

impl TimeUnit {
    pub(super) fn seconds(self, value: f64) -> f64 {
        if self == TimeUnit::Seconds { value } else { value / 1000.0 }
    }
}

/// The most turns of one arc.
const MOST_TURNS: f64 = 10_000.0;

impl Tracer<'_> {
    pub(super) fn special(&mut self, block: Block, special: Special, code: Code) {
        match special {
            Special::Dwell => self.dwell(block, code),
            Special::Reference => self.uncompensated(|tracer| tracer.reference(block, code)),
            Special::MachineCoordinates => self.uncompensated(|tracer| tracer.machine_coordinates(block)),
            Special::Probe => self.probe(block, code),
            Special::Thread { is_tapping } => self.thread(block, code, is_tapping),
            Special::Own(word) => self.own_word(block, word, code),
            Special::NurbsEnd => self.end_nurbs(block, code),
            _ => self.change_frame(block, special, code),
        }
    }

    fn dwell(&mut self, block: Block, code: Code) {
        if has_dwell_by_feed(self.dialect) && !self.given.has(bits(b"P")) {
            return self.dwell_by_feed(block);
        }
        let given_as = |letter: u8| block.words.iter().rfind(|word| word.letter == letter);
        let Some(word) = given_as(b'P').or(given_as(b'X')).or(given_as(b'U')) else {
            self.remarks.add(block.place(), Untraced::NoDwellTime);
            return;
        };
        let (unit, place) = (self.unit_of_time(word), block.place_of(word));
        match unit {
            TimeUnit::Guessed => self.remarks.add(place, Untraced::GuessedTimeUnit),
            TimeUnit::Milliseconds => self.remarks.add(place, Untraced::TimeInMilliseconds),
            TimeUnit::Seconds if word.letter == b'P' => self.remarks.add(place, Untraced::DwellInSeconds),
            TimeUnit::Seconds => {}
        }
        let seconds = unit.seconds(word.value);
        if (0.0..=LONGEST_DWELL).contains(&seconds) {
            self.stop(block, StopCause::Dwell { seconds });
        } else {
            self.remarks.add(block.place_of(word), Untraced::BadDwell { seconds });
        }
        let others = if word.letter == b'X' { bits(b"YZ") } else { AXIS_WORDS };
        if self.given.has(others) {
            self.remarks.add(block.place(), Untraced::UnusedAxisWords { code });
        }
    }

    /// What the time of a dwell or a cycle counts. Fanuc controls count one without a point in milliseconds, their
    /// least increment, and RS274/NGC has seconds. A program that shows neither is for a control of the first
    /// kind more often, and hardly waits for minutes.
    pub(super) fn unit_of_time(&self, word: &Word) -> TimeUnit {
        let is_guess = self.dialect == Dialect::Iso && LONG_TIME <= word.value;
        match () {
            () if word.has_point => TimeUnit::Seconds,
            () if self.is_tape => TimeUnit::Milliseconds,
            () if is_guess => TimeUnit::Guessed,
            () => TimeUnit::Seconds,
        }
    }

    /// G28 and G30: over the programmed point to the reference point, in the axes that are
    /// given, or in all where none is. One reference point serves both but where G28.1 or G30.1 kept
    /// another.
    fn reference(&mut self, block: Block, code: Code) {
        // The axis words of G74 and G75 name axes, not a point.
        if self.dialect != Dialect::Siemens {
            let Some(over) = self.target(block) else { return };
            self.take_rotary(block);
            self.rapid_to(block, over);
            self.turn_alone(block, true);
        }
        let goes = |letter: char| {
            !self.given.has(AXIS_WORDS | ROTARY_WORDS) || self.given.get(letter as u8).is_some()
        };
        let axes = AXES.map(goes);
        let mut home = self.position;
        for (axis, _) in axes.into_iter().enumerate().filter(|(_, goes)| *goes) {
            home[axis] = self.reference_point(block, axis, code).unwrap_or(home[axis]);
        }
        self.turn_home(!self.given.has(AXIS_WORDS | ROTARY_WORDS));
        self.rapid_to(block, home);
        self.turn_alone(block, true);
    }

    /// G53: absolute machine coordinates, at the feedrate under G1 and in rapid otherwise.
    fn machine_coordinates(&mut self, block: Block) {
        let mut target = self.position;
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = self.given.get(letter as u8) else { continue };
            let Some(home) = self.home(block, axis) else { continue };
            target[axis] = home + value * self.modal.unit;
            if !self.is_within_reach(block, letter, target[axis]) {
                return;
            }
        }
        self.take_machine_rotary(block);
        match self.modal.mode {
            Some(Mode::Straight) => self.feed_to(block, target),
            _ => self.rapid_to(block, target),
        }
        self.turn_the_rest(block);
    }

    /// Reference point of an axis, mm, or a remark that it is not known.
    pub(super) fn home(&mut self, block: Block, axis: usize) -> Option<f64> {
        let home = self.machine.axes[axis].home;
        if home.is_none() {
            let (axis, key) = (AXES[axis], AXES[axis].to_ascii_lowercase());
            self.remarks.add(block.place(), Untraced::UnknownHome { axis, key });
        }
        home
    }

    /// The move of a block, where it has one.
    pub(super) fn motion(&mut self, block: Block, has_motion_word: bool) {
        let has_axis_words = self.given.has(AXIS_WORDS | POLAR_WORDS);
        if self.cycle.is_active() {
            self.hole(block);
            return;
        }
        let is_arc = matches!(self.modal.mode, Some(Mode::Arc(_)));
        let is_circle =
            is_arc && (self.given.has(CENTER_WORDS) || (has_motion_word && self.given.has(bits(b"R"))));
        let is_spline = matches!(self.modal.mode, Some(Mode::Spline(_)));
        let is_bare_spline = is_spline && has_motion_word;
        if !(has_axis_words || is_circle || is_bare_spline) {
            return;
        }
        let Some(target) = self.target(block) else { return };
        if !is_arc && !is_spline && self.given.has(CENTER_WORDS) {
            self.remarks.add(block.place(), Untraced::UnusedCenter);
        }
        match self.modal.mode {
            None => {
                self.remarks.add(block.place(), Untraced::NoMotionWord);
                self.modal.mode = Some(Mode::Rapid);
                self.rapid_to(block, target);
            }
            Some(Mode::Rapid) => self.rapid_to(block, target),
            Some(Mode::Straight) => self.feed_to(block, target),
            Some(Mode::Arc(turn)) => self.arc_to(block, target, turn),
            Some(Mode::Spline(spline)) => self.spline_to(block, spline, target),
        }
    }

    /// Where the axis words point, mm; none where that is out of reach.
    pub(super) fn target(&mut self, block: Block) -> Option<Point> {
        let mut target = self.position;
        let values = self.axis_values();
        if let Some(chain) = self.frame.turned().copied() {
            return self.turned_target(block, &chain, values);
        }
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = values[axis] else { continue };
            target[axis] = match self.modal.is_incremental {
                true => self.position[axis] + value,
                false => self.frame.coordinate(axis, value),
            };
            if !self.is_within_reach(block, letter, target[axis]) {
                return None;
            }
        }
        Some(target)
    }

    pub(super) fn is_within_reach(&mut self, block: Block, letter: char, coordinate: f64) -> bool {
        let is_within = coordinate.abs() <= REACH;
        if !is_within {
            self.remarks.add(block.place_of_letter(letter as u8), Untraced::OutOfReach { letter });
        }
        is_within
    }

    pub(super) fn arc_to(&mut self, block: Block, end: Point, turn: Turn) {
        for letter in *b"IJKR" {
            let value = self.given.get(letter).unwrap_or_default() * self.modal.unit;
            if !self.is_within_reach(block, letter as char, value) {
                return;
            }
        }
        let (ends, turns) = ((self.position, end), self.turns(block));
        self.hear_center(block, ends);
        let arc = match self.frame.turned().copied() {
            Some(chain) => self.turned_arc(block, chain, ends, turn, turns),
            None => {
                let center = self.center(block, ends, turn);
                center.and_then(|center| Ok(self.modal.plane.arc(ends, center, turn, turns)?))
            }
        };
        match arc {
            Ok(arc) => {
                let (start, end_radius) = (arc.start_radius, arc.end_radius);
                if tolerated_difference(start) < (start - end_radius).abs() {
                    self.remarks.add(block.place(), Untraced::UnequalRadii { start, end: end_radius });
                }
                self.feed_along(block, end, arc);
            }
            Err(no_circle) => {
                self.remarks.add(block.place(), no_circle);
                self.feed_to(block, end);
            }
        }
    }

    /// Along an arc in feed.
    pub(super) fn feed_along(&mut self, block: Block, end: Point, arc: Arc) {
        let length = arc.length();
        let feedrate = self.feedrate_along(block, length);
        let feedrate = self.linear_share(block, length, feedrate);
        self.push(block, end, Curve::Arc(arc.into()), length, Motion::Feed { feedrate });
    }

    /// The centre by R, or by two of I, J and K; one that is left out is that of the start.
    pub(super) fn center(
        &mut self,
        block: Block,
        ends: (Point, Point),
        turn: Turn,
    ) -> Result<Point, Untraced> {
        let [a, b, _] = self.modal.plane.axes();
        let axes = [(a, self.given.get(b"IJK"[a])), (b, self.given.get(b"IJK"[b]))];
        let has_center = axes.iter().any(|(_, value)| value.is_some());
        if let Some(radius) = self.given.get(b'R').or(self.siemens_radius(ends)) {
            if has_center {
                self.remarks.add(block.place(), Untraced::RadiusAndCenter);
            }
            return Ok(self.modal.plane.center_of_radius(ends, turn, radius * self.modal.unit)?);
        }
        if !has_center {
            return self.pole_as_center(ends.0).ok_or(Untraced::NoCenter);
        }
        let mut center = ends.0;
        for (axis, value) in axes {
            let Some(value) = value.map(|value| value * self.modal.unit) else { continue };
            center[axis] = match self.given.is_incremental(b"IJK"[axis], self.modal.has_incremental_center) {
                true => ends.0[axis] + value,
                false if self.frame.turned().is_some() => value,
                false => self.frame.coordinate(axis, value),
            };
        }
        Ok(center)
    }

    /// The turns of an arc: P, TURN of Siemens, or L of Fanuc's spirals and Yasnac's helices.
    fn turns(&mut self, block: Block) -> u32 {
        let further = self.given.get(address::TURNS).map(|value| value + 1.0);
        let by_p = self.given.get(b'P').or(further);
        let by_l = self.given.get(b'L').filter(|_| by_p.is_none() && self.dialect == Dialect::Iso);
        let [first, second, normal] = self.modal.plane.axes().map(|axis| b"IJK"[axis]);
        // An arc without a centre in its plane is an error, which says enough.
        let has_shape = [first, second, b'R'].into_iter().any(|letter| self.given.get(letter).is_some());
        let is_left_out = |letter: u8| has_shape && self.given.get(letter).is_some_and(|value| value != 0.0);
        for letter in [b'L', normal] {
            if is_left_out(letter) && !(letter == b'L' && by_l.is_some()) && self.is_control_of_letters() {
                let remark = Untraced::ArcWordNotRun { letter: letter as char };
                self.remarks.add(block.place_of_letter(letter), remark);
            }
        }
        let letter = if by_l.is_some() { b'L' } else { b'P' };
        match by_p.or(by_l) {
            Some(value) if (1.0..=MOST_TURNS).contains(&value) && value.fract() == 0.0 => {
                if by_l.is_some() && 1.0 < value {
                    self.remarks.add(block.place_of_letter(letter), Untraced::TurnsByL { turns: value });
                }
                value as u32
            }
            Some(value) => {
                let remark = Untraced::BadTurns { letter: letter as char, value };
                self.remarks.add(block.place_of_letter(letter), remark);
                1
            }
            None => 1,
        }
    }

    /// Whether words are single letters, each with a meaning by its block.
    fn is_control_of_letters(&self) -> bool {
        !matches!(self.dialect, Dialect::Siemens | Dialect::Klartext | Dialect::HeidenhainIso)
    }

    pub(super) fn rapid_to(&mut self, block: Block, end: Point) {
        let length = (end - self.position).norm();
        self.push(block, end, Curve::Line, length, Motion::Rapid);
    }

    pub(super) fn feed_to(&mut self, block: Block, end: Point) {
        let length = (end - self.position).norm();
        if SHORTEST <= length || self.contour.is_beside() {
            let feedrate = self.feedrate_along(block, length);
            let feedrate = self.linear_share(block, length, feedrate);
            self.push(block, end, Curve::Line, length, Motion::Feed { feedrate });
        }
    }

    pub(super) fn push(&mut self, block: Block, end: Point, curve: Curve, length: f64, motion: Motion) {
        if length < SHORTEST && !self.contour.is_beside() {
            self.turn_alone(block, motion == Motion::Rapid);
            return;
        }
        if let Some(before_move) = self.heidenhain.as_ref().map(|own| own.before_move) {
            before_move(self, end, &curve, length);
        }
        let (start, exact_stop, line) = (self.position, self.exact_stop, block.line);
        let rotation = self.turned_along().map_or(Rotation::NONE, Rotation::from);
        let segment = Segment { start, end, curve, length, motion, rotation, exact_stop, line };
        self.contour.take(segment, self.modal.plane, &mut self.toolpath);
        self.tell_troubles();
        self.position = end;
    }
}

/// Controls on which F of G4 is a time.
pub(super) fn has_dwell_by_feed(dialect: Dialect) -> bool {
    matches!(dialect, Dialect::Siemens | Dialect::HeidenhainIso | Dialect::Okuma)
}
