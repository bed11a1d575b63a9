//! The cycles of ISO programs: G73, G74, G76 and G81 to G89, with R, Z, Q, P, I, J, K, F, L.
//!
//! ```text
//! G73  chip breaking by Q        G84 G74  tapping, right and left hand
//! G83  full retract by Q         G85      feed in, feed out
//! G81  drilling                  G89      G85 with dwell
//! G82  drilling with dwell       G86      feed in, spindle stop, rapid out
//! G76  fine boring               G88      G86, out by hand
//! G87  back boring
//! ```
//!
//! The axis of the holes is the normal of the plane (Z in G17, Y in G18, X in G19). G98 returns to the height at
//! which the first cycle began, G99 to R. Under G91, R counts from that height and the bottom from R; each
//! repetition moves one increment further in the plane.
//!
//! Where controls differ, programs with a `%` line or an O number run as on Fanuc (with the words of Haas that
//! Fanuc does not have), all others as on LinuxCNC:
//!
//! | | Fanuc | LinuxCNC |
//! |---|---|---|
//! | neither G98 nor G99 | G98 | G99 |
//! | R, bottom, Q after a change of cycle | stay in force | to be given again |
//! | R, bottom by G90 after a change to G91 | keep their heights | become increments |
//! | to the hole | in the plane at the height it has, then to R | from below R: up to R first; later holes straight to the return height |
//! | G74, G84, G89: feed out | to R | to the return height |
//! | dwell of G74, G84 | inside and outside | inside |
//! | dwell of G86 | none | at the bottom |
//! | G73, G83: back to z + c | not above R | as written |
//! | c (1 mm typical of set-ups; 0.254 mm built in) | machine parameter | machine parameter |
//! | P | ms without a decimal point, else s | s; ms too from 100 on without a decimal point, unless the dialect is LinuxCNC's or a relative |
//! | Q | its sign does not count | negative: an error |
//! | shift of G76, G87 | I, J, K in the plane, or Q along the first axis | I, J, K in the plane |
//! | G87: bore | up from R to the bottom word | up from the bottom word to K, and back |
//!
//! With I, pecks of G73 and G83 begin with I, decrease by J and are at least K (Haas). With J of 2 to 9 a tap
//! comes out that many times faster (Haas). Tapping is rigid after M29; otherwise the spindle stops before it
//! reverses. F of tapping is the feedrate in force. With Q a tap is made in pecks: after each, the tap is reversed
//! by the retract of chip breaking, or out to R if the machine file says so (Fanuc 5200#5 PCP and 5213).
//!
//! Not modelled: P of G73 and G83, with a remark; G76 of LinuxCNC, which is threading. LinuxCNC adds a last peck
//! if the rounding of its sum of Qs leaves one of no depth; Truefeed adds none.
//!
//! Sources: LinuxCNC, G-code reference, canned cycles; Fanuc Series 15i/150i, Operator's Manual
//! (Programming), canned cycles; Haas, Mill Operator's Manual, G73 to G89.

use crate::simulation::gcode::{Dialect, whole_number};
use crate::simulation::interpreter::block::{AXIS_WORDS, Block, bits};
use crate::simulation::interpreter::bounds::MAX_DWELL_S;
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::cycle::hole::{HoleKind, Pecks, SpindleTurn, TapPecks};
use crate::simulation::interpreter::cycle::{Hole, NoHole};
use crate::simulation::interpreter::dwell::TimeUnit;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::rotary::ROTARY_WORDS;
use crate::simulation::interpreter::state::{Family, Interpreter};
use crate::simulation::toolpath::Point;

/// Most repetitions of the hole of one block.
const MAX_REPEATS: u32 = 10_000;

/// Retract and clearance of pecks on LinuxCNC, mm.
const LINUXCNC_CLEARANCE_MM: f64 = 0.254;

/// Retract and clearance of pecks as typically set on Fanuc controls, mm.
const FANUC_CLEARANCE_MM: f64 = 1.0;

/// A cycle in force, with its modal words. Lengths in mm.
pub(super) struct ActiveCycle {
    code: Code,
    /// Number of its word.
    number: u16,
    /// Position of the tool when the first cycle began.
    begin: Point,
    reference: Option<Level>,
    bottom: Option<Level>,
    /// Depth of the pecks, Q.
    peck: Option<f64>,
    /// Dwell, P, s.
    dwell: Option<f64>,
    /// I, J and K.
    center: [Option<f64>; 3],
}

/// A height as programmed, mm.
#[derive(Clone, Copy)]
struct Level {
    value: f64,
    is_incremental: bool,
}

impl Interpreter<'_> {
    /// Starts the cycle with ten times the number `tenths`.
    pub(crate) fn begin_cycle(&mut self, code: Code, tenths: u16) {
        let number = tenths / 10;
        match &mut self.cycle.active {
            Some(active) if active.number == number => {}
            Some(active) if self.is_tape => {
                active.code = code;
                active.number = number;
                active.center = [None; 3];
                // The pecks of a drill do not hold for a tap.
                if matches!(number, 74 | 84) {
                    active.peck = None;
                }
            }
            other => {
                let begin = other.as_ref().map_or(self.canonical.position, |active| active.begin);
                let (reference, bottom, peck, dwell, center) = (None, None, None, None, [None; 3]);
                *other = Some(ActiveCycle { code, number, begin, reference, bottom, peck, dwell, center });
            }
        }
    }

    /// Runs a block under a cycle: reads its words, and makes its hole as often as L or K says. In a block without
    /// a hole P, Q and others belong to another word, such as M98.
    pub(crate) fn hole(&mut self, block: Block) {
        let axis_words = AXIS_WORDS | ROTARY_WORDS;
        let hole_words = if self.is_tape { axis_words | bits(b"R") } else { axis_words };
        if !self.given.has(hole_words) {
            return;
        }
        if self.is_without_hole(block) {
            return;
        }
        let Some(mut active) = self.cycle.active.take() else { return };
        self.read_cycle_words(block, &mut active);
        if let Err(no_hole) = self.holes(block, &active) {
            self.remarks.add(block.place(), TraceRemark::NoHole { code: active.code, no_hole });
        }
        self.cycle.active = Some(active);
    }

    /// Makes a hole of the cycle in force at each of these places (mm).
    pub(crate) fn holes_at(&mut self, block: Block, places: &[Point]) {
        let Some(mut active) = self.cycle.active.take() else { return };
        self.read_cycle_words(block, &mut active);
        let normal = self.canonical.plane.axes()[2];
        for place in places {
            let mut target = *place;
            target[normal] = self.canonical.position[normal];
            self.rapid_to(block, target);
            if let Err(no_hole) = self.holes(block, &active) {
                self.remarks.add(block.place(), TraceRemark::NoHole { code: active.code, no_hole });
                break;
            }
        }
        self.cycle.active = Some(active);
    }

    /// Reads the words of a block into the cycle in force.
    fn read_cycle_words(&mut self, block: Block, active: &mut ActiveCycle) {
        let (unit, is_incremental) = (self.modal.unit, self.modal.is_incremental);
        let length = |letter: u8| self.given.get(letter).map(|value| value * unit);
        let level = |letter: u8| length(letter).map(|value| Level { value, is_incremental });
        active.reference = level(b'R').or(active.reference);
        active.bottom = level(b"XYZ"[self.canonical.plane.axes()[2]]).or(active.bottom);
        active.peck = length(b'Q').or(active.peck);
        for (center, letter) in active.center.iter_mut().zip(*b"IJK") {
            *center = length(letter).or(*center);
        }
        active.dwell = self.cycle_dwell(block).or(active.dwell);
        let not_modelled = match active.number {
            83 if self.has_full_retracts_by_j(active) => b'J',
            73 | 83 => b'P',
            _ => return,
        };
        if self.given.has(bits(&[not_modelled])) {
            let (code, letter) = (active.code, not_modelled as char);
            self.remarks.add(block.place_of_letter(not_modelled), TraceRemark::CycleWord { code, letter });
        }
    }

    /// Returns `true` for Okuma's G83 with I and J: it breaks chips every I, and leaves the hole every J.
    fn has_full_retracts_by_j(&self, active: &ActiveCycle) -> bool {
        self.dialect == Dialect::Okuma && active.center[0].is_some()
    }

    /// Returns P of the block, s.
    fn cycle_dwell(&mut self, block: Block) -> Option<f64> {
        let word = block.words.iter().rfind(|word| word.letter == b'P')?;
        let value = self.given.get(b'P')?;
        let (unit, place) = (self.unit_of_time(word), block.place_of(word));
        match unit {
            TimeUnit::Guessed => self.remarks.add(place, TraceRemark::GuessedTimeUnit),
            TimeUnit::Milliseconds if value != 0.0 => {
                self.remarks.add(place, TraceRemark::TimeInMilliseconds)
            }
            _ => {}
        }
        let seconds = unit.seconds(value);
        if (0.0..=MAX_DWELL_S).contains(&seconds) {
            return Some(seconds);
        }
        self.remarks.add(block.place_of(word), TraceRemark::BadDwell { seconds });
        Some(0.0)
    }

    /// Makes the holes of a block.
    fn holes(&mut self, block: Block, active: &ActiveCycle) -> Result<(), NoHole> {
        let repeats = self.repeats(block, active);
        let Some(hole) = self.hole_of(block, active)? else { return Ok(()) };
        let work = self.plan_hole(block, &hole)?;
        let normal = self.canonical.plane.axes()[2];
        if 0 < repeats && !self.is_tape && active.begin[normal] < hole.reference {
            let mut target = self.canonical.position;
            target[normal] = hole.reference;
            self.rapid_to(block, target);
        }
        self.canonical.stop_as_in_cycles();
        for repeat in 0..repeats {
            let Some(mut target) = self.target(block) else { break };
            let is_above = hole.reference < self.canonical.position[normal];
            let stays = self.is_tape || (repeat == 0 && is_above);
            target[normal] = if stays { self.canonical.position[normal] } else { hole.return_to };
            self.rapid_to(block, target);
            self.make_hole(block, &work)?;
        }
        if active.number == 88 && 0 < repeats {
            self.remarks.add(block.place(), TraceRemark::ManualRetract { code: active.code });
        }
        Ok(())
    }

    /// Returns the number of holes: L, or K if the cycle has no other use for it.
    fn repeats(&mut self, block: Block, active: &ActiveCycle) -> usize {
        let normal = self.canonical.plane.axes()[2];
        let k_is_used = match active.number {
            73 | 83 => self.is_tape && active.center[0].is_some(),
            76 => normal != 2,
            87 => !self.is_tape || normal != 2,
            _ => false,
        };
        let value = self.given.get(b'L').or(self.given.get(b'K').filter(|_| !k_is_used)).unwrap_or(1.0);
        if let Some(repeats) = whole_number(value).filter(|repeats| *repeats <= MAX_REPEATS) {
            return repeats as usize;
        }
        self.remarks.add(block.place(), TraceRemark::BadRepeats { value });
        1
    }

    /// Returns the hole of a block, or `None` after a remark.
    fn hole_of(&mut self, block: Block, active: &ActiveCycle) -> Result<Option<Hole>, NoHole> {
        let [a, b, normal] = self.canonical.plane.axes();
        let letter = b"XYZ"[normal];
        let written = active.reference.ok_or(NoHole::NoReference)?;
        let initial = active.begin[normal];
        let reference = self.height(normal, written, initial);
        let written = active.bottom.ok_or(NoHole::NoBottom(char::from(letter)))?;
        let bottom = self.height(normal, written, reference);
        let heights = [(letter, reference), (letter, bottom)];
        let words = b"IJKQ".iter().zip(active.center.into_iter().chain([active.peck]));
        let words = words.map(|(letter, value)| (*letter, value.unwrap_or(0.0)));
        for (letter, value) in heights.into_iter().chain(words) {
            if !self.is_within_reach(block, char::from(letter), value) {
                return Ok(None);
            }
        }
        let (is_tape, turn) = (self.is_tape, self.cycle.turn);
        let initial = if is_tape { initial } else { initial.max(reference) };
        let returns_to_reference = self.cycle.returns_to_reference.unwrap_or(!is_tape);
        let return_to = if returns_to_reference { reference } else { initial };
        let return_to = self.return_by_m_word(block, normal, reference).unwrap_or(return_to);
        let dwell = self.dwell_of(block, active);
        let feed_in = self.feedrate(block);
        let mut hole = Hole::drilled(reference, bottom, return_to, feed_in);
        let ceiling = if is_tape { reference } else { f64::INFINITY };
        let usual = if is_tape { FANUC_CLEARANCE_MM } else { LINUXCNC_CLEARANCE_MM };
        let retract = self.machine.cycles.peck_retract.unwrap_or(usual);
        let clearance = self.machine.cycles.peck_clearance.unwrap_or(usual);
        let shift = match (active.center[a], active.center[b], active.peck) {
            (None, None, Some(shift)) if is_tape || active.number == 76 => [shift.abs(), 0.0],
            (along_a, along_b, _) => [along_a.unwrap_or(0.0), along_b.unwrap_or(0.0)],
        };
        match active.number {
            73 => hole.kind = HoleKind::ChipBreak { pecks: self.pecks(active)?, retract, ceiling },
            83 if self.has_full_retracts_by_j(active) => {
                let depth = active.center[0].unwrap_or_default().abs();
                hole.kind = HoleKind::ChipBreak { pecks: Pecks::equal(depth), retract, ceiling };
            }
            83 => hole.kind = HoleKind::Peck { pecks: self.pecks(active)?, clearance, ceiling },
            74 | 84 => {
                hole.dwell = dwell;
                self.set_iso_tap(active, self.tap_pecks(active, usual)?, &mut hole);
            }
            82 => hole.dwell = dwell,
            85 => hole.kind = HoleKind::Bore,
            89 => {
                hole.kind = HoleKind::Bore;
                hole.dwell = dwell;
                hole.feed_out_to = if is_tape { reference } else { return_to };
            }
            86 | 88 => {
                hole.kind = HoleKind::BoreAndStop { turn, by_hand: active.number == 88 };
                // A modal P of another cycle has no effect on G86 of Fanuc controls.
                let waits = active.number == 88 || self.family != Family::Fanuc;
                hole.dwell = if waits { dwell } else { 0.0 };
            }
            76 if !is_tape && active.center.iter().all(Option::is_some) => return Err(NoHole::Threading),
            76 => {
                hole.kind = HoleKind::FineBore { turn, shift };
                hole.dwell = dwell;
            }
            87 if is_tape => {
                hole.kind = HoleKind::BackBore { turn, shift, top: bottom, feeds_back: false };
                hole.bottom = reference;
                hole.reference = initial;
                hole.return_to = initial;
                hole.dwell = dwell;
            }
            87 => {
                let value = active.center[normal].ok_or(NoHole::NoTop(char::from(b"IJK"[normal])))?;
                let is_incremental = self.modal.is_incremental;
                let top = self.height(normal, Level { value, is_incremental }, bottom);
                hole.kind = HoleKind::BackBore { turn, shift, top, feeds_back: true };
            }
            _ => {}
        }
        Ok(Some(hole))
    }

    /// Completes a tapped hole, whose dwell is set.
    fn set_iso_tap(&self, active: &ActiveCycle, pecks: Option<TapPecks>, hole: &mut Hole) {
        let turn = if active.number == 84 { SpindleTurn::Right } else { SpindleTurn::Left };
        hole.kind = HoleKind::Tap { turn, is_rigid: self.cycle.is_rigid, pecks };
        if self.is_tape {
            hole.dwell_outside = hole.dwell;
            // The tap comes out J times as fast.
            let times = active.center[1].map(|times| times / self.modal.unit);
            hole.feed_out *= times.filter(|times| (1.0..=9.0).contains(times)).unwrap_or(1.0);
        } else {
            hole.feed_out_to = hole.return_to;
        }
    }

    /// Returns the pecks of a tap by Q, or `None` without Q.
    fn tap_pecks(&self, active: &ActiveCycle, usual: f64) -> Result<Option<TapPecks>, NoHole> {
        let Some(depth) = active.peck else { return Ok(None) };
        if depth == 0.0 {
            return Err(NoHole::BadPeck(depth));
        }
        let cycles = &self.machine.cycles;
        let back = if cycles.taps_out { f64::INFINITY } else { cycles.peck_retract.unwrap_or(usual) };
        Ok(Some(TapPecks { depth: depth.abs(), back }))
    }

    /// Returns the dwell of a hole, s.
    fn dwell_of(&mut self, block: Block, active: &ActiveCycle) -> f64 {
        match (active.dwell, active.number) {
            (Some(seconds), _) => {
                self.cycle.dwell = seconds;
                seconds
            }
            // LinuxCNC keeps P for all cycles, and these two do not need their own.
            (None, 74 | 84) if !self.is_tape => self.cycle.dwell,
            (None, number) => {
                let needs = if self.is_tape { &[82, 89][..] } else { &[82, 86, 88, 89] };
                if needs.contains(&number) {
                    self.remarks.add(block.place(), TraceRemark::NoCycleDwell { code: active.code });
                }
                0.0
            }
        }
    }

    /// Returns the pecks by Q, or by I, J and K.
    fn pecks(&self, active: &ActiveCycle) -> Result<Pecks, NoHole> {
        let [first, decrease, least] = active.center;
        if let Some(first) = first.filter(|_| self.is_tape) {
            let (decrease, least) = (decrease.unwrap_or(0.0), least.unwrap_or(0.0));
            return Ok(Pecks { first, ratio: 1.0, decrease, least });
        }
        let depth = active.peck.ok_or(NoHole::NoPeck)?;
        Ok(Pecks::equal(if self.is_tape { depth.abs() } else { depth }))
    }

    /// Returns the machine coordinate of a level along the axis of the holes, mm; an incremental one counts from
    /// `from`.
    fn height(&self, normal: usize, level: Level, from: f64) -> f64 {
        let is_incremental = if self.is_tape { level.is_incremental } else { self.modal.is_incremental };
        match is_incremental {
            true => from + level.value,
            false => self.frame.coordinate_at(&self.canonical.position, normal, level.value),
        }
    }
}
