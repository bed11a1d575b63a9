//! The score as pictures, for the page that shows its tables.
//!
//! | file | what it shows |
//! |---|---|
//! | `effects.svg` | each single effect at its strength: a full dot where it was named first |
//! | `transfer.svg` | what each rival says of programs it was not fitted to: a dot a case, a bar at the median |
//! | `before-after.svg` | the curves of the case whose held-out error fell by the median ratio |

use std::path::Path;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::score::{Outcome, RIVALS, outcomes};

type Refusal = Box<dyn std::error::Error>;

/// Width of a picture and height of one of its rows, pixels.
const WIDTH: u32 = 760;
const ROW: u32 = 20;
/// Room for the names of rows, and for the axis, pixels.
const NAMES: i32 = 250;
const AXIS: i32 = 46;
/// Letters, pixels.
const FONT: (&str, i32) = ("sans-serif", 13);
const DOT: i32 = 4;
const INK: RGBColor = RGBColor(0x1b, 0x5f, 0xa8);
/// An error too small to be drawn is drawn here, percent.
const LEAST_ERROR: f64 = 1e-3;

/// A dot in a row.
struct Dot {
    at: f64,
    full: bool,
}

/// A row of a picture: its name, its dots, and where its bar is.
struct Row {
    name: String,
    dots: Vec<Dot>,
    bar: Option<f64>,
}

/// Writes the pictures of the cases in `folder` and their `reports` to the folder `out`.
pub fn write(folder: &Path, reports: &Path, out: &Path) -> Result<(), Refusal> {
    let (_, outcomes) = outcomes(folder, reports)?;
    std::fs::create_dir_all(out)?;
    let singles = || outcomes.iter().filter(|outcome| outcome.stratum == "single");
    rows(&out.join("effects.svg"), &by_effect(singles()), "strength, detection limits", (0.2, 12.0))?;
    let found = || outcomes.iter().filter(|outcome| outcome.top && outcome.transfer.is_object());
    let title = "error of the cycle time of another program, %";
    rows(&out.join("transfer.svg"), &by_rival(&found().collect::<Vec<_>>()), title, (LEAST_ERROR, 100.0))?;
    let mut gains: Vec<(f64, &Outcome)> =
        found().filter_map(|outcome| outcome.feed.map(|(before, after)| (after / before, outcome))).collect();
    gains.sort_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((_, outcome)) = gains.get(gains.len() / 2) {
        std::fs::copy(reports.join(&outcome.name).join("chart.svg"), out.join("before-after.svg"))?;
    }
    Ok(())
}

fn by_effect<'a>(singles: impl Iterator<Item = &'a Outcome>) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for outcome in singles {
        let dot = Dot { at: outcome.strength, full: outcome.top };
        match rows.iter_mut().find(|row| row.name == outcome.effect) {
            Some(row) => row.dots.push(dot),
            None => rows.push(Row { name: outcome.effect.clone(), dots: vec![dot], bar: None }),
        }
    }
    rows.sort_by(|a, b| a.name.cmp(&b.name));
    rows
}

fn by_rival(found: &[&Outcome]) -> Vec<Row> {
    let row = |(key, name): (&str, &str)| {
        let mut errors: Vec<f64> = found.iter().filter_map(|outcome| outcome.transfer_error(key)).collect();
        errors.sort_by(f64::total_cmp);
        let drawn = |error: &f64| (100.0 * error).max(LEAST_ERROR);
        let dots = errors.iter().map(|error| Dot { at: drawn(error), full: false }).collect();
        Row { name: name.to_string(), dots, bar: errors.get(errors.len() / 2).map(drawn) }
    };
    RIVALS.into_iter().map(row).collect()
}

/// A picture of rows over a logarithmic axis, the first row at the top.
fn rows(file: &Path, rows: &[Row], title: &str, (low, high): (f64, f64)) -> Result<(), Refusal> {
    let height = ROW * rows.len() as u32;
    let area = SVGBackend::new(file, (WIDTH, height + AXIS as u32 + ROW)).into_drawing_area();
    area.fill(&WHITE)?;
    let font = FONT.into_text_style(&area).pos(Pos::new(HPos::Right, VPos::Center));
    let below = font.pos(Pos::new(HPos::Center, VPos::Top));
    let (left, right) = (NAMES, WIDTH as i32 - 24);
    let x = |value: f64| {
        let part = (value / low).ln() / (high / low).ln();
        left + (part.clamp(0.0, 1.0) * f64::from(right - left)).round() as i32
    };
    let top = (ROW / 2) as i32;
    let bottom = top + height as i32;
    let mut tick = 10f64.powi(low.log10().ceil() as i32);
    while tick <= high * (1.0 + 1e-9) {
        area.draw(&PathElement::new([(x(tick), top), (x(tick), bottom)], BLACK.mix(0.15)))?;
        area.draw(&Text::new(format!("{tick}"), (x(tick), bottom + 4), below.clone()))?;
        tick *= 10.0;
    }
    area.draw(&Text::new(title.to_string(), ((left + right) / 2, bottom + 24), below.clone()))?;
    for (index, row) in rows.iter().enumerate() {
        let y = top + (ROW * index as u32 + ROW / 2) as i32;
        area.draw(&Text::new(row.name.clone(), (left - 10, y), font.clone()))?;
        area.draw(&PathElement::new([(left, y), (right, y)], BLACK.mix(0.15)))?;
        for dot in &row.dots {
            let style = if dot.full { INK.filled() } else { INK.stroke_width(1) };
            area.draw(&Circle::new((x(dot.at), y), DOT, style))?;
        }
        if let Some(bar) = row.bar {
            let half = (ROW / 2) as i32 - 2;
            area.draw(&PathElement::new([(x(bar), y - half), (x(bar), y + half)], INK.stroke_width(3)))?;
        }
    }
    area.present()?;
    Ok(())
}
