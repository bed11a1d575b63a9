//! Events read from a recording, by law, and the reasons for missing ones.

/// A law that a recording may show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LawKind {
    /// Lowest feedrate (mm/s) at a corner over the turn of the path (rad).
    Corner,
    /// Feedrate (mm/s) on an arc over its radius (mm).
    Arc,
    /// Time from 10 % to 90 % of a speed step (s) over the step (mm/s).
    Ramp,
    /// Time of a rapid (s) over its length (mm).
    Rapid,
    /// Time of a short block (s) over its length (mm).
    Block,
    /// Time at a word (s) over the programmed wait (s).
    Wait,
}

impl LawKind {
    /// All laws.
    pub const ALL: [LawKind; 6] =
        [LawKind::Corner, LawKind::Arc, LawKind::Ramp, LawKind::Rapid, LawKind::Block, LawKind::Wait];

    /// Returns `true` if the value of the law can only rise with the abscissa, `false` if it can only fall.
    pub fn is_rising(self) -> bool {
        self != LawKind::Corner
    }

    /// Returns the largest difference between the abscissas of one point: the larger of a value in core units
    /// and a part of the abscissa.
    pub fn apart(self) -> (f64, f64) {
        match self {
            LawKind::Corner => (2f64.to_radians(), 0.0),
            LawKind::Ramp => (0.5, 0.02),
            LawKind::Arc | LawKind::Rapid | LawKind::Block => (0.002, 0.03),
            LawKind::Wait => (1e-6, 0.0),
        }
    }
}

/// One reading of a law at a place of the program.
#[derive(Clone, Debug, PartialEq)]
pub struct LawEvent {
    /// An axis or a word; may be empty.
    pub variant: String,
    /// Abscissa, core units.
    pub over: f64,
    /// Value, core units.
    pub value: f64,
    /// `true` if the programmed feedrate limited the motion; the law then allows at least this feedrate.
    pub is_at_feed: bool,
    /// Index of the run.
    pub run: usize,
    /// Index of the place in the program, unique for one law.
    pub place: usize,
}

impl LawEvent {
    /// Returns an event of the first run.
    pub fn new(variant: impl Into<String>, over: f64, value: f64, place: usize) -> LawEvent {
        LawEvent { variant: variant.into(), over, value, is_at_feed: false, run: 0, place }
    }

    /// Returns the event with another value of `is_at_feed`.
    pub fn at_feed(self, is_at_feed: bool) -> LawEvent {
        LawEvent { is_at_feed, ..self }
    }
}

/// The events of one law.
#[derive(Clone, Debug, Default)]
pub struct LawEvents {
    /// Events.
    pub events: Vec<LawEvent>,
    /// Number of places of the program at which the law might show.
    pub places: usize,
}

/// The reason why a law was not measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Absence {
    /// The recording has no positions.
    NotRecorded,
    /// The program has no place at which the law could show.
    NotInProgram,
    /// The programmed feedrate limited the motion everywhere.
    AtFeed,
    /// At none of this number of places was the motion steady long enough for the sampling.
    Unsteady(usize),
}

impl LawEvents {
    /// Adds the events of another run, with the index `run`.
    pub fn add(&mut self, run: usize, other: LawEvents) {
        self.events.extend(other.events.into_iter().map(|event| LawEvent { run, ..event }));
        self.places += other.places;
    }

    /// Returns the reason why no event shows the law.
    pub fn absence(&self) -> Absence {
        match (self.places, self.events.is_empty()) {
            (0, _) => Absence::NotInProgram,
            (places, true) => Absence::Unsteady(places),
            _ => Absence::AtFeed,
        }
    }
}
