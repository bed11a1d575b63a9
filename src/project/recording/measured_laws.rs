//! The laws of a machine as measured, as JSON and as text: points, curve, the fitted machine's points, and
//! its error.

use serde::Serialize;
use serde_json::{Map, Number, Value};

use crate::identification::measured::{Absence, CurveLevel, LawKind, LawPoint, Measured, MeasuredLaw};
use crate::plot::{LawChart, Theme, escaped, svg_of_law};
use crate::project::figures::{as_short, to_the_digits_of};
use crate::units::Unit;

/// Width of a chart, pixels.
const CHART_WIDTH_PX: u32 = 460;
/// Height of a chart, pixels.
const CHART_HEIGHT_PX: u32 = 260;
/// Legend of the charts.
const LEGEND: &str = "Read off the recordings without a model: dots with their standard deviation, the monotone curve \
                      through them, and open circles for what the machine file does at the same places.";
/// Digits of a number in the data.
const DATA_DIGITS: usize = 6;
/// Relative spread below which differences are only rounding.
const MIN_SPREAD_RATIO: f64 = 1e-4;

/// The laws of a machine of any family as recordings show them.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredReport {
    laws: Vec<LawRow>,
    absent: Vec<AbsentRow>,
}

/// One law; every number has its unit in its key.
#[derive(Clone, Debug, Serialize)]
struct LawRow {
    id: &'static str,
    /// An axis, long blocks, or a word; may be empty.
    variant: String,
    title: String,
    /// Titles of abscissa and value, with their units.
    axes: [String; 2],
    points: Vec<Map<String, Value>>,
    curve: Vec<Map<String, Value>>,
    /// The points of the simulated machine; empty if none was simulated.
    simulated: Vec<Map<String, Value>>,
    /// Simulated less measured; null if no event is in both.
    model_error: Option<Map<String, Value>>,
    /// The law at its ends, and the machine's error, for people.
    told: String,
}

/// A law that was not measured.
#[derive(Clone, Debug, Serialize)]
struct AbsentRow {
    id: &'static str,
    title: &'static str,
    reason: String,
}

/// The keys and titles of a law.
struct LawForm {
    id: &'static str,
    title: &'static str,
    /// Key, label and unit of abscissa and value.
    over: (&'static str, &'static str, Unit),
    value: (&'static str, &'static str, Unit),
}

fn form(kind: LawKind) -> LawForm {
    use Unit::{Degree, Millimetre, MillimetrePerMinute, Second};
    let of = |id, title, over, value| LawForm { id, title, over, value };
    let feedrate = ("feedrate_mm_min", "feedrate", MillimetrePerMinute);
    let length = ("length_mm", "length", Millimetre);
    match kind {
        LawKind::Corner => {
            of("corner_feedrate", "Lowest feedrate at corners", ("turn_deg", "turn", Degree), feedrate)
        }
        LawKind::Arc => of("arc_feedrate", "Feedrate on arcs", ("radius_mm", "radius", Millimetre), feedrate),
        LawKind::Ramp => of(
            "ramp_time",
            "Ramps, from 10 % to 90 % of the speed step",
            ("speed_step_mm_min", "speed step", MillimetrePerMinute),
            ("rise_time_s", "time", Second),
        ),
        LawKind::Rapid => of("rapid_time", "Rapids from rest to rest", length, ("time_s", "time", Second)),
        LawKind::Block => of("block_time", "Short blocks", length, ("time_s", "time", Second)),
        LawKind::Wait => {
            of("wait", "Waits", ("programmed_s", "programmed", Second), ("wait_s", "time there", Second))
        }
    }
}

/// Returns the key of a quantity in another role, with its unit.
fn role(key: &str, role: &str) -> String {
    let units = ["_mm_min", "_mm", "_deg", "_s"];
    let unit = units.into_iter().find(|unit| key.ends_with(unit)).unwrap_or("");
    format!("{role}{unit}")
}

impl MeasuredReport {
    /// Returns the report of measured laws.
    pub fn new(measured: &Measured) -> MeasuredReport {
        let absent = measured.absent.iter().map(|(kind, absence)| {
            let LawForm { id, title, .. } = form(*kind);
            AbsentRow { id, title, reason: reason(*kind, *absence) }
        });
        MeasuredReport { laws: measured.laws.iter().map(row).collect(), absent: absent.collect() }
    }

    /// Returns the laws as a part of an HTML document: a small chart each, and the laws that were not
    /// measured.
    pub(in crate::project) fn to_html(&self, theme: &Theme) -> String {
        let figure = |row: &LawRow| {
            let chart = serde_json::to_string(row).ok().and_then(|json| law_chart(&json));
            let picture = chart
                .and_then(|chart| svg_of_law(&chart, theme, (CHART_WIDTH_PX, CHART_HEIGHT_PX)))
                .unwrap_or_default();
            let caption = escaped(&format!("{}: {}", row.title, row.told));
            format!("<figure>{picture}<figcaption class=\"small\">{caption}</figcaption></figure>\n")
        };
        let figures: String = self.laws.iter().map(figure).collect();
        let absent = self.absent.iter().map(|row| format!("{} not measured: {}.", row.title, row.reason));
        let absent = escaped(&absent.collect::<Vec<_>>().join(" "));
        format!(
            "<h2>The machine, measured</h2>\n<p class=\"small\">{LEGEND}</p>\n{figures}<p class=\"small\">{absent}</p>\n"
        )
    }

    /// Returns a short table for people: a line per law, with its ends, and the machine's error.
    pub fn to_text(&self) -> String {
        let mut text = "As measured, whatever the family of the control:".to_string();
        for row in &self.laws {
            text += &format!("\n  {:44} {}", row.title, row.told);
        }
        for row in &self.absent {
            text += &format!("\n  {:44} not measured: {}", row.title, row.reason);
        }
        text
    }
}

/// Returns the law at its ends, and the machine's error.
fn in_short(law: &MeasuredLaw) -> String {
    let LawForm { over, value, .. } = form(law.kind);
    let at = |point: &LawPoint| {
        let abscissa = format!("{:.3e}", over.2.from_core(point.over)).parse().unwrap_or(point.over);
        let count = if point.count == 1 { String::new() } else { format!(" (×{})", point.count) };
        let (own, spread) = (value.2.from_core(point.value), value.2.from_core(point.spread));
        let has_spread = MIN_SPREAD_RATIO * own.abs() < spread;
        let own = if has_spread { to_the_digits_of(own, spread) } else { as_short(rounded(own, 4)) };
        let is_alone = law.kind == LawKind::Wait && point.over == 0.0;
        let at =
            if is_alone { String::new() } else { format!(" at {} {}", as_short(abscissa), over.2.symbol()) };
        format!("{own} {}{at}{count}", value.2.symbol())
    };
    let ends = match law.points.as_slice() {
        [] => String::new(),
        [one] => at(one),
        [first, .., last] => format!("{} … {}", at(first), at(last)),
    };
    let Some(error) = law.error else { return ends };
    let [mean, spread] = [error.mean, error.spread].map(|own| value.2.from_core(own));
    let largest = law.points.iter().map(|point| value.2.from_core(point.value).abs()).fold(0.0, f64::max);
    let least = MIN_SPREAD_RATIO * largest;
    if mean.abs() <= least && spread <= least {
        return format!("{ends}; the machine file agrees");
    }
    let (size, beside) = match least < spread {
        true => (to_the_digits_of(mean, spread), format!(" ± {}", to_the_digits_of(spread, spread))),
        false => (as_short(rounded(mean, 2)), String::new()),
    };
    format!("{ends}; the machine file is off by {size}{beside} {}", value.2.symbol())
}

/// Returns the chart of a law in a report, given as JSON; `None` if the text is not a law.
pub fn law_chart(law: &str) -> Option<LawChart> {
    let row: Value = serde_json::from_str(law).ok()?;
    let kind = LawKind::ALL.into_iter().find(|kind| row["id"] == form(*kind).id)?;
    let LawForm { over, value, .. } = form(kind);
    let spread = role(value.0, "spread");
    let list = |key: &str| row[key].as_array().map_or(&[][..], Vec::as_slice);
    let number = |point: &Value, key: &str| point[key].as_f64();
    let both = |point: &Value| Some([number(point, over.0)?, number(point, value.0)?]);
    let point = |point: &Value| {
        let [x, y] = both(point)?;
        Some([x, y, number(point, &spread)?])
    };
    let title = |at: usize| row["axes"][at].as_str().unwrap_or_default().to_string();
    Some(LawChart {
        titles: [title(0), title(1)],
        points: list("points").iter().filter_map(point).collect(),
        curve: list("curve").iter().filter_map(both).collect(),
        simulated: list("simulated").iter().filter_map(both).collect(),
    })
}

fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

fn row(law: &MeasuredLaw) -> LawRow {
    let LawForm { id, title, over, value } = form(law.kind);
    let number = |own: f64| Number::from_f64(rounded(own, DATA_DIGITS)).map_or(Value::Null, Value::Number);
    let of = |pairs: &[(String, Value)]| pairs.iter().cloned().collect::<Map<String, Value>>();
    let abscissa = |own: f64| (over.0.to_string(), number(over.2.from_core(own)));
    let own = |key: String, own: f64| (key, number(value.2.from_core(own)));
    let point = |point: &LawPoint| {
        of(&[
            abscissa(point.over),
            own(value.0.to_string(), point.value),
            own(role(value.0, "spread"), point.spread),
            ("count".to_string(), point.count.into()),
        ])
    };
    let level = |level: &CurveLevel| {
        of(&[
            abscissa(level.over),
            own(value.0.to_string(), level.value),
            own(role(value.0, "deviation"), level.deviation),
        ])
    };
    let error = law.error.map(|error| {
        of(&[
            own(role(value.0, "mean"), error.mean),
            own(role(value.0, "spread"), error.spread),
            ("count".to_string(), error.count.into()),
        ])
    });
    let axis = |(_, label, unit): (&str, &str, Unit)| format!("{label}, {}", unit.symbol());
    LawRow {
        id,
        variant: law.variant.clone(),
        title: if law.variant.is_empty() { title.to_string() } else { format!("{title}: {}", law.variant) },
        axes: [axis(over), axis(value)],
        points: law.points.iter().map(point).collect(),
        curve: law.curve.iter().map(level).collect(),
        simulated: law.simulated.iter().map(point).collect(),
        model_error: error,
        told: in_short(law),
    }
}

/// Returns the reason for a law that was not measured, as a clause.
fn reason(kind: LawKind, absence: Absence) -> String {
    let places = match kind {
        LawKind::Corner => "corners between feed moves of one feedrate",
        LawKind::Arc => "arcs",
        LawKind::Ramp => "straight moves from or to a full stop",
        LawKind::Rapid => "rapids",
        LawKind::Block => "chains of short blocks",
        LawKind::Wait => "words that stop the machine, each alone in its place",
    };
    match absence {
        Absence::NotRecorded => "the recording has no positions".to_string(),
        Absence::NotInProgram => format!("the program has no {places}"),
        Absence::AtFeed => format!("the programmed feedrate held at all {places}"),
        Absence::Unsteady(count) => {
            format!("the motion was not steady long enough at any of {count} places ({places})")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::measured::LawError;

    #[test]
    fn the_rounding_of_equal_events_justifies_no_digits() {
        let law = |spread| MeasuredLaw {
            kind: LawKind::Rapid,
            variant: String::new(),
            points: vec![LawPoint { over: 5.0, value: 0.195, spread, count: 2 }],
            curve: Vec::new(),
            simulated: Vec::new(),
            error: Some(LawError { mean: spread, spread, count: 2 }),
        };
        assert_eq!(in_short(&law(1e-12)), "0.195 s at 5 mm (×2); the machine file agrees");
        let spread_out = "0.1950 s at 5 mm (×2); the machine file is off by 0.0020 ± 0.0020 s";
        assert_eq!(in_short(&law(0.002)), spread_out);
    }
}
