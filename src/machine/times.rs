//! Times without motion: durations of the machine's functions once the axes are at rest.
//!
//! An M-word belongs to a group by its function. Its time is the first that is given of: its entry in the
//! table by M-word, the time of its group, the time of all other M-words. The change of a spindle from the
//! speed n1 to n2 (rpm, signed by the direction) takes
//!
//! > t = start + k |n2 − n1| from standstill, t = k |n2 − n1| from one speed to another,
//! > t = stop + k |n1| to standstill, t = stop + start + k (|n1| + |n2|) through standstill,
//!
//! with k in s per rpm. Speeds are in revolutions per minute, as programs and machines give them.
//!
//! If the torque of a drive falls with its speed, the ramp grows faster than in proportion: with the exponent
//! p it is k N |f(n2) − f(n1)|, f(n) = ± (|n| / N)^p and N = 10 000 rpm. Constant torque gives p = 1,
//! constant power p = 2; if the power falls as well, above the nominal speed of most spindles, p approaches
//! 3.
//!
//! Some controls continue while the spindle ramps, and only a later word waits for it: the ramp then belongs
//! to the first word that waits.
//!
//! Limits: functions do not overlap with each other or with motion; a ramp that no word waits for takes no
//! time, and an S word alone starts none if words wait.

use std::collections::BTreeMap;

/// Times without motion.
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionTimes {
    /// Time from the start of the program to its first block, s; neutral 0.
    pub start: f64,
    /// Extra time of each dwell beyond the programmed time, s: a control resumes only in a later cycle of its task; neutral
    /// 0.
    pub dwell_excess: f64,
    /// Tool change at M6, s.
    pub tool_change: f64,
    /// First tool change of a program, at which the spindle may be empty, s; neutral `None`: as other tool
    /// changes.
    pub first_tool_change: Option<f64>,
    /// Times of single tools, s, by number.
    pub tools: BTreeMap<u32, f64>,
    /// Times of the spindle.
    pub spindle: SpindleTimes,
    /// The M-words that wait for the spindle's ramp; neutral `None`: the words that start it.
    pub spindle_awaited_by: Vec<u32>,
    /// Wait at an S word between feed moves until the spindle reaches its speed, s; neutral 0.
    pub spindle_change: f64,
    /// Wait of the first feed move after the spindle started or changed its speed, s; rapid moves do not
    /// wait; neutral 0.
    pub spindle_at_feed: f64,
    /// Ramp time per rpm of a change of speed, s, for controls where only the first feed move at the new speed waits for
    /// the spindle; dwells and rapid moves overlap the ramp; neutral 0.
    pub spindle_ramp_at_feed: f64,
    /// M7 and M8, s; neutral `None`: as other M-words. The same applies to every optional time here.
    pub coolant_on: Option<f64>,
    /// M9, s.
    pub coolant_off: Option<f64>,
    /// M0, s.
    pub program_stop: Option<f64>,
    /// `true` if M1 stops the program; neutral `false`.
    pub takes_optional_stop: bool,
    /// M1 if it stops the program, s; `None`: as M0.
    pub optional_stop: Option<f64>,
    /// Pallet change, s.
    pub pallet_change: Option<f64>,
    /// The M-words that change the pallet.
    pub pallet_words: Vec<u32>,
    /// Clamping or unclamping, s.
    pub clamp: Option<f64>,
    /// The M-words that clamp and unclamp.
    pub clamp_words: Vec<u32>,
    /// Any M-word without an entry, s; neutral 0.
    pub m_code: f64,
    /// Times of single M-words, s, by number.
    pub m_codes: BTreeMap<u32, f64>,
}

/// Times of the spindle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpindleTimes {
    /// From standstill to running, without the ramp, s; neutral `None`: as other M-words.
    pub start: Option<f64>,
    /// From running to standstill, without the ramp, s; neutral `None`: as other M-words.
    pub stop: Option<f64>,
    /// Time per rpm of a change of speed, s; neutral 0.
    pub ramp: f64,
    /// Exponent p of the speed by which the ramp grows; neutral `None`: 1.
    pub exponent: Option<f64>,
}

/// Speed at which ramps of all exponents are equally long, rpm.
const NOMINAL_SPEED_RPM: f64 = 10_000.0;

impl SpindleTimes {
    /// Returns the duration of a change between two speeds (rpm, signed by the direction), s.
    pub fn ramp(&self, from: f64, to: f64) -> f64 {
        let Some(exponent) = self.exponent else { return self.ramp * (to - from).abs() };
        let grown = |speed: f64| speed.signum() * (speed.abs() / NOMINAL_SPEED_RPM).powf(exponent);
        self.ramp * NOMINAL_SPEED_RPM * (grown(to) - grown(from)).abs()
    }
}

/// The direction of the spindle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SpindleDirection {
    /// At rest.
    #[default]
    Standing,
    /// As by M3.
    Clockwise,
    /// As by M4.
    Counterclockwise,
}

/// The state of the spindle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpindleState {
    /// Direction.
    pub direction: SpindleDirection,
    /// Speed, rpm, not negative; 0 at rest or if no program has set it.
    pub speed: f64,
}

/// The groups of M-words that times distinguish.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MCodeGroup {
    /// M7, M8 and M9.
    Coolant,
    /// M0 and M1.
    Stop,
    /// A pallet change.
    Pallet,
    /// Clamping or unclamping.
    Clamp,
    /// Anything else.
    Other,
}

impl SpindleState {
    /// A spindle at rest.
    pub const AT_REST: SpindleState = SpindleState { direction: SpindleDirection::Standing, speed: 0.0 };

    /// Returns `true` if the spindle does not turn.
    pub fn is_at_rest(self) -> bool {
        self.signed_speed() == 0.0
    }

    /// Returns the speed, rpm; positive as by M3.
    pub fn signed_speed(self) -> f64 {
        match self.direction {
            SpindleDirection::Standing => 0.0,
            SpindleDirection::Clockwise => self.speed,
            SpindleDirection::Counterclockwise => -self.speed,
        }
    }
}

/// Neutral times except for the tool change.
impl Default for FunctionTimes {
    fn default() -> FunctionTimes {
        FunctionTimes {
            start: 0.0,
            dwell_excess: 0.0,
            tool_change: 4.0,
            first_tool_change: None,
            tools: BTreeMap::new(),
            spindle: SpindleTimes::default(),
            spindle_awaited_by: Vec::new(),
            spindle_change: 0.0,
            spindle_at_feed: 0.0,
            spindle_ramp_at_feed: 0.0,
            coolant_on: None,
            coolant_off: None,
            program_stop: None,
            takes_optional_stop: false,
            optional_stop: None,
            pallet_change: None,
            pallet_words: vec![60],
            clamp: None,
            clamp_words: vec![10, 11],
            m_code: 0.0,
            m_codes: BTreeMap::new(),
        }
    }
}

impl FunctionTimes {
    /// Returns the duration of a change to a tool, s.
    pub fn of_tool_change(&self, tool: Option<u32>) -> f64 {
        let own = tool.and_then(|tool| self.tools.get(&tool));
        own.copied().unwrap_or(self.tool_change)
    }

    /// Returns the group of M`code`. Assignments of the machine precede the usual meaning.
    pub fn function(&self, code: u32) -> MCodeGroup {
        match code {
            _ if self.pallet_words.contains(&code) => MCodeGroup::Pallet,
            _ if self.clamp_words.contains(&code) => MCodeGroup::Clamp,
            7..=9 => MCodeGroup::Coolant,
            0 | 1 => MCodeGroup::Stop,
            _ => MCodeGroup::Other,
        }
    }

    /// Returns the duration of M`code`, s, other than tool changes and the spindle's words.
    pub fn of_m_code(&self, code: u32) -> f64 {
        let of_group = || match (self.function(code), code) {
            (MCodeGroup::Pallet, _) => self.pallet_change,
            (MCodeGroup::Clamp, _) => self.clamp,
            (MCodeGroup::Coolant, 9) => self.coolant_off,
            (MCodeGroup::Coolant, _) => self.coolant_on,
            (MCodeGroup::Stop, 0) => self.program_stop,
            (MCodeGroup::Stop, _) if self.takes_optional_stop => self.optional_stop.or(self.program_stop),
            (MCodeGroup::Stop | MCodeGroup::Other, _) => None,
        };
        self.m_codes.get(&code).copied().or_else(of_group).unwrap_or(self.m_code)
    }

    /// Returns the time of a spindle change, s, without a ramp that another word waits for; `code` is the
    /// M-word that requests the change, `None` for an S word alone.
    pub fn of_spindle(&self, from: SpindleState, to: SpindleState, code: Option<u32>) -> f64 {
        if let Some(own) = code.and_then(|code| self.m_codes.get(&code)) {
            return *own;
        }
        let SpindleTimes { start, stop, .. } = self.spindle;
        let runs = |spin: SpindleState| spin.direction != SpindleDirection::Standing;
        let of_step = match (runs(from), runs(to)) {
            (false, true) => start,
            (true, false) => stop,
            (true, true) if from.direction != to.direction => {
                stop.or(start).map(|_| stop.unwrap_or(0.0) + start.unwrap_or(0.0))
            }
            _ => None,
        };
        let of_word = if code.is_some() { self.m_code } else { 0.0 };
        let ramp = if self.spindle_awaited_by.is_empty() { self.of_spindle_ramp(from, to) } else { 0.0 };
        of_step.unwrap_or(of_word) + ramp
    }

    /// Returns the duration of the spindle's ramp, s, whichever word waits for it.
    pub fn of_spindle_ramp(&self, from: SpindleState, to: SpindleState) -> f64 {
        self.spindle.ramp(from.signed_speed(), to.signed_speed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn clockwise(speed: f64) -> SpindleState {
        SpindleState { direction: SpindleDirection::Clockwise, speed }
    }

    #[test]
    fn a_start_takes_its_own_time_and_the_ramp() {
        let spindle = SpindleTimes { start: Some(1.0), stop: Some(0.5), ramp: 2e-4, exponent: None };
        let times = FunctionTimes { spindle, m_code: 7.0, ..FunctionTimes::default() };
        let left = SpindleState { direction: SpindleDirection::Counterclockwise, speed: 5000.0 };
        for (from, to, expected) in [
            (SpindleState::AT_REST, clockwise(5000.0), 2.0),
            (clockwise(5000.0), SpindleState::AT_REST, 1.5),
            (clockwise(5000.0), clockwise(8000.0), 0.6 + 7.0),
            (clockwise(5000.0), left, 3.5),
            (SpindleState::AT_REST, SpindleState::AT_REST, 7.0),
        ] {
            let found = times.of_spindle(from, to, Some(3));
            assert!((found - expected).abs() < 1e-12, "{from:?} {to:?}: {found} s");
        }
        assert!((times.of_spindle(clockwise(5000.0), clockwise(8000.0), None) - 0.6).abs() < 1e-12);
    }

    #[test]
    fn ramps_of_all_exponents_are_as_long_to_the_nominal_speed() {
        let ramp = |exponent| SpindleTimes { ramp: 4e-4, exponent, ..SpindleTimes::default() };
        for exponent in [None, Some(1.0), Some(2.0), Some(3.0)] {
            assert!((ramp(exponent).ramp(0.0, 10_000.0) - 4.0).abs() < 1e-12);
            assert!((ramp(exponent).ramp(-10_000.0, 10_000.0) - 8.0).abs() < 1e-12);
        }
        assert!((ramp(Some(2.0)).ramp(5000.0, 0.0) - 1.0).abs() < 1e-12);
        assert!((ramp(Some(2.0)).ramp(5000.0, 10_000.0) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn neutral_times_are_those_of_other_words() {
        let times = FunctionTimes { m_code: 1.7, ..FunctionTimes::default() };
        for code in 0..200 {
            assert_eq!(times.of_m_code(code), 1.7);
        }
        assert_eq!(times.of_spindle(SpindleState::AT_REST, clockwise(9000.0), Some(3)), 1.7);
        assert_eq!(times.of_spindle(clockwise(9000.0), clockwise(100.0), None), 0.0);
    }

    #[test]
    fn the_word_comes_before_its_group_and_the_group_before_the_rest() {
        let mut times = FunctionTimes {
            coolant_on: Some(2.0),
            clamp: Some(0.8),
            m_code: 0.1,
            ..FunctionTimes::default()
        };
        times.m_codes = [(8, 3.0), (3, 4.0)].into();
        times.tools = [(5, 9.0)].into();
        assert_eq!([7, 8, 9, 10, 11, 12].map(|code| times.of_m_code(code)), [2.0, 3.0, 0.1, 0.8, 0.8, 0.1]);
        assert_eq!(times.of_spindle(SpindleState::AT_REST, clockwise(9000.0), Some(3)), 4.0);
        assert_eq!([None, Some(4), Some(5)].map(|tool| times.of_tool_change(tool)), [4.0, 4.0, 9.0]);
    }

    #[test]
    fn an_optional_stop_takes_time_only_where_it_is_taken() {
        let mut times = FunctionTimes { program_stop: Some(60.0), ..FunctionTimes::default() };
        assert_eq!([0, 1].map(|code| times.of_m_code(code)), [60.0, 0.0]);
        times.takes_optional_stop = true;
        assert_eq!(times.of_m_code(1), 60.0);
        times.optional_stop = Some(30.0);
        assert_eq!(times.of_m_code(1), 30.0);
    }
}
