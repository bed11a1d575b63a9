//! The path as a picture in a document: SVG, dark on white, with the legend of its colours and a scale bar.
//!
//! As in [`raster`](crate::plot::path::raster), edges are drawn rank by rank, the worst on top. Edges that
//! end within half a pixel of the last corner are joined, and edges outside the picture left out, so that the
//! size of the file depends on the visible part.

use std::fmt::Write;

use plotters::style::RGBColor;

use crate::plot::escaped;
use crate::plot::path::{Camera, FIRST_SHADE_RANK, MARKED_RANK, RAPID_RANK, Scene};

/// The settings of a drawing in a document.
pub struct Sheet<'a> {
    /// Camera, with the size of the picture.
    pub camera: Camera,
    /// Marked range of the path, mm.
    pub marked: Option<(f64, f64)>,
    /// Colour of each rank; `None` if it is not drawn.
    pub inks: &'a [Option<RGBColor>],
    /// Labels of the first and the last shade.
    pub ends: [String; 2],
    /// Length of the scale bar, mm, and its label.
    pub length: (f64, String),
}

/// Width of lines, pixels.
const LINE_WIDTH_PX: f64 = 1.5;
/// Height of the room below the path, pixels.
const FOOT_HEIGHT_PX: f64 = 34.0;
/// Distance within which an edge is joined with the next, pixels.
const MAX_JOINED_PX: f64 = 0.5;
/// Width of a shade in the ramp, pixels.
const SHADE_WIDTH_PX: f64 = 9.0;
const TEXT_COLOR: &str = "#404852";

/// Returns a scene as SVG.
pub fn svg_of_path(scene: &Scene, sheet: &Sheet) -> String {
    let (width, height) = sheet.camera.size;
    let whole = height + FOOT_HEIGHT_PX;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{whole:.0}\" viewBox=\"0 0 {width:.0} {whole:.0}\">\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\
         <svg width=\"{width:.0}\" height=\"{height:.0}\"><g fill=\"none\" stroke-linejoin=\"round\" stroke-width=\"{LINE_WIDTH_PX}\">"
    );
    let mut ranks: Vec<(u8, String)> = lines(scene, &sheet.camera);
    if let Some(stretch) = sheet.marked {
        ranks.push((MARKED_RANK, marked(scene, &sheet.camera, stretch)));
    }
    for (rank, line) in ranks {
        let Some(Some(ink)) = sheet.inks.get(usize::from(rank)) else { continue };
        let more = match rank {
            RAPID_RANK => " stroke-dasharray=\"5\"",
            MARKED_RANK => " stroke-width=\"4\"",
            _ => "",
        };
        // Writing to a string does not fail.
        let _ = write!(text, "<path stroke=\"{}\"{more} d=\"{line}\"/>", hex(ink));
    }
    text += "</g></svg>";
    text += &foot(sheet, width, height + 0.5 * FOOT_HEIGHT_PX);
    text + "</svg>"
}

/// Returns the visible lines of each rank, the worst last.
fn lines(scene: &Scene, camera: &Camera) -> Vec<(u8, String)> {
    let mut ranks = vec![String::new(); usize::from(MARKED_RANK)];
    let (width, height) = camera.size;
    let is_beyond = |a: f64, b: f64, high: f64| a.max(b) < -LINE_WIDTH_PX || high + LINE_WIDTH_PX < a.min(b);
    let place = |index: usize| camera.project(scene.points[index].map(f64::from));
    let mut pen = None;
    let mut from = (0.0, 0.0);
    let edges = scene.points.len().saturating_sub(1);
    for (edge, &rank) in scene.rank.iter().take(edges).enumerate() {
        let line = &mut ranks[usize::from(rank)];
        if pen != Some(rank) {
            from = place(edge);
        }
        let to = place(edge + 1);
        if is_beyond(from.0, to.0, width) || is_beyond(from.1, to.1, height) {
            pen = None;
            continue;
        }
        if pen != Some(rank) {
            let _ = write!(line, "M{:.1} {:.1}", from.0, from.1);
            pen = Some(rank);
        } else if (to.0 - from.0).hypot(to.1 - from.1) < MAX_JOINED_PX
            && scene.rank.get(edge + 1) == Some(&rank)
        {
            continue;
        }
        let _ = write!(line, "L{:.1} {:.1}", to.0, to.1);
        from = to;
    }
    ranks
        .into_iter()
        .enumerate()
        .filter(|(_, line)| !line.is_empty())
        .map(|(rank, line)| (rank as u8, line))
        .collect()
}

/// Returns the line of a range of the path, mm.
fn marked(scene: &Scene, camera: &Camera, (begin, end): (f64, f64)) -> String {
    let inner = scene.distance.iter().copied().filter(|&distance| begin < distance && distance < end);
    let along = [begin].into_iter().chain(inner).chain([end]);
    let places = along.filter_map(|distance| scene.point(distance)).map(|point| camera.project(point));
    let mut line = String::new();
    for (x, y) in places {
        let _ = write!(line, "{}{x:.1} {y:.1}", if line.is_empty() { 'M' } else { 'L' });
    }
    line
}

/// Returns the legend of the colours, on the left, and the scale bar, on the right, both at the height `y`
/// (pixels).
fn foot(sheet: &Sheet, width: f64, y: f64) -> String {
    let [first, last] = sheet.ends.each_ref().map(|end| escaped(end));
    let mut text = format!(
        "<g font-family=\"system-ui, sans-serif\" font-size=\"12\" fill=\"{TEXT_COLOR}\" dominant-baseline=\"central\">\
         <text x=\"110\" y=\"{y}\" text-anchor=\"end\">{first}</text>"
    );
    let shades =
        sheet.inks.iter().take(usize::from(MARKED_RANK)).skip(usize::from(FIRST_SHADE_RANK)).flatten();
    let mut x = 118.0;
    for ink in shades {
        let _ = write!(
            text,
            "<rect x=\"{x}\" y=\"{}\" width=\"{SHADE_WIDTH_PX}\" height=\"10\" fill=\"{}\"/>",
            y - 5.0,
            hex(ink)
        );
        x += SHADE_WIDTH_PX;
    }
    let _ = write!(text, "<text x=\"{}\" y=\"{y}\">{last}</text>", x + 8.0);
    let (length, label) = &sheet.length;
    let (right, long) = (width - 12.0, length * sheet.camera.scale);
    let _ = write!(
        text,
        "<path d=\"M{:.1} {y}H{right:.1}\" stroke=\"{TEXT_COLOR}\" stroke-width=\"2\"/><text x=\"{:.1}\" y=\"{y}\" text-anchor=\"end\">{}</text></g>",
        right - long,
        right - long - 8.0,
        escaped(label)
    );
    text
}

fn hex(RGBColor(r, g, b): &RGBColor) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
