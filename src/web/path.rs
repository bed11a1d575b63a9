//! The path on its canvas: it keeps trail, shades and camera, and draws pixels.
//!
//! All pixels that come in and go out are those of the page (CSS pixels, from the canvas' top left corner).

use wasm_bindgen::prelude::*;
use wasm_bindgen::{Clamped, JsCast};
use web_sys::{CanvasRenderingContext2d, HtmlCanvasElement, ImageData};

use crate::plot::Programmed;
use crate::plot::path::{self, Camera, Coloring, Drawing, Pace, Raster, Scene, Sheet, Trail};
use crate::units::mm_per_min;

/// Width of lines and length of dashes, pixels of the page.
const PEN: f64 = 2.0;
const DASH: f64 = 5.0;
/// How far from the pointer a line is still meant, pixels of the page.
const REACH: f64 = 8.0;
/// The view from which the path begins to be turned, rad.
const OBLIQUE: (f64, f64) = (-0.6, 0.55);

/// What the colours of the path mean.
#[wasm_bindgen(getter_with_clone)]
pub struct Legend {
    /// Colours as CSS writes them, from the best to the worst.
    pub colors: Vec<String>,
    /// What the first and the last colour stand for, in the unit.
    pub ends: Vec<f64>,
    /// The unit.
    pub unit: String,
}

/// A picture of the path.
#[wasm_bindgen]
#[derive(Default)]
pub struct PathView {
    trail: Trail,
    programmed: Programmed,
    pace: Pace,
    lost: Pace,
    coloring: Option<Coloring>,
    scene: Scene,
    camera: Camera,
    dark: bool,
    marked: Option<(f64, f64)>,
    raster: Raster,
    ratio: f64,
    colors: Vec<u8>,
}

#[wasm_bindgen]
impl PathView {
    /// A picture of nothing.
    #[wasm_bindgen(constructor)]
    pub fn new() -> PathView {
        PathView::default()
    }

    /// Begins anew with the trail of a job and its programmed feedrates; the columns are those of
    /// `TrailColumns` and `Steps`.
    pub fn program(
        &mut self,
        points: &[f32],
        distance: Vec<f64>,
        end: Vec<f64>,
        feedrate: Vec<f64>,
        rapid: &[u8],
        line: Vec<u32>,
    ) {
        let rapid = rapid.iter().map(|&flag| flag != 0).collect();
        self.programmed = Programmed::new(end, feedrate, rapid, line);
        self.trail = Trail { points: points.as_chunks::<3>().0.to_vec(), distance };
        (self.pace, self.lost, self.marked) = (Pace::default(), Pace::default(), None);
    }

    /// Takes the pace of a run: where its steps end (mm) and their feedrate (mm/s).
    pub fn pace(&mut self, end: Vec<f64>, feedrate: Vec<f64>) {
        self.pace = Pace { end, value: feedrate };
    }

    /// Takes the time lost against a recording (s over mm).
    pub fn lost(&mut self, distance: &[f64], seconds: &[f64]) {
        self.lost = Pace::of_lost(distance, seconds);
    }

    /// Colours the path by `feedrate`, by `loss` or by time `lost`.
    pub fn color(&mut self, by: &str) {
        let (coloring, pace) = match by {
            "lost" => (Coloring::by_lost(&self.lost), &self.lost),
            "loss" => (Coloring::Loss, &self.pace),
            _ => (Coloring::by_feedrate(&self.programmed), &self.pace),
        };
        self.scene = Scene::new(&self.trail, &self.programmed, pace, coloring);
        self.coloring = Some(coloring);
    }

    /// What the colours mean.
    pub fn legend(&self) -> Legend {
        let coloring = self.coloring.unwrap_or(Coloring::Loss);
        let colors = path::palette(coloring, self.dark);
        let (ends, unit) = match coloring {
            Coloring::Feedrate(top) => ([mm_per_min(top), 0.0], "mm/min"),
            Coloring::Loss => ([0.0, 100.0], "%"),
            // Seconds a metre.
            Coloring::Lost(top) => ([-1e3 * top, 1e3 * top], "s/m"),
        };
        Legend {
            colors: colors.map(|color| format!("rgb({}, {}, {})", color.0, color.1, color.2)).to_vec(),
            ends: ends.to_vec(),
            unit: unit.to_string(),
        }
    }

    /// Light on dark or dark on light.
    #[wasm_bindgen(js_name = setDark)]
    pub fn set_dark(&mut self, dark: bool) {
        self.dark = dark;
    }

    /// Marks a stretch of the path, mm; none: marks nothing.
    pub fn mark(&mut self, from: Option<f64>, to: Option<f64>) {
        self.marked = from.zip(to);
    }

    /// Draws on a canvas of this size in CSS pixels.
    pub fn draw(
        &mut self,
        canvas: HtmlCanvasElement,
        width: f64,
        height: f64,
        ratio: f64,
    ) -> Result<(), JsValue> {
        self.resize(width, height);
        self.ratio = ratio;
        let pen = (PEN * ratio).round().max(1.0) as usize;
        let camera = self.camera.resized(ratio);
        let drawing = Drawing { camera, pen, dash: (DASH * ratio) as f32, marked: self.marked };
        path::raster(&self.scene, &drawing, &mut self.raster);
        let shades = path::palette(self.coloring.unwrap_or(Coloring::Loss), self.dark);
        self.raster.colors(&path::ink(&shades, self.dark), &mut self.colors);
        let (width, height) = self.raster.size();
        let (width, height) = (width as u32, height as u32);
        if (canvas.width(), canvas.height()) != (width, height) {
            canvas.set_width(width);
            canvas.set_height(height);
        }
        let context = canvas.get_context("2d")?.ok_or("this canvas cannot be drawn on")?;
        let context: CanvasRenderingContext2d = context.unchecked_into();
        let image = ImageData::new_with_u8_clamped_array_and_sh(Clamped(&self.colors), width, height)?;
        context.put_image_data(&image, 0.0, 0.0)
    }

    /// What is in sight as SVG for a document, dark on white, with what the first and the last colour and the length of
    /// `scale` are called.
    pub fn svg(&self, first: String, last: String, scale: String) -> String {
        let shades = path::palette(self.coloring.unwrap_or(Coloring::Loss), false);
        path::svg_of_path(
            &self.scene,
            &Sheet {
                camera: self.camera,
                marked: self.marked,
                inks: &path::ink(&shades, false),
                ends: [first, last],
                length: (self.camera.round_length(), scale),
            },
        )
    }

    /// Keeps the middle where it is in a picture of another size.
    pub fn resize(&mut self, width: f64, height: f64) {
        self.camera.size = (width, height);
    }

    /// Shows the whole path.
    pub fn fit(&mut self) {
        self.camera.fit(&self.scene.points);
    }

    /// Looks from the `top`, the `front` or the `side`, or from above obliquely, at the whole path.
    pub fn look(&mut self, from: &str) {
        (self.camera.yaw, self.camera.pitch) = match from {
            "top" => (0.0, std::f64::consts::FRAC_PI_2),
            "front" => (0.0, 0.0),
            "side" => (std::f64::consts::FRAC_PI_2, 0.0),
            _ => OBLIQUE,
        };
        self.fit();
    }

    /// Turns by angles, rad.
    pub fn turn(&mut self, yaw: f64, pitch: f64) {
        self.camera.turn(yaw, pitch);
    }

    /// Moves the picture by pixels.
    pub fn pan(&mut self, dx: f64, dy: f64) {
        self.camera.pan(dx, dy);
    }

    /// Magnifies about a pixel.
    pub fn zoom(&mut self, factor: f64, x: f64, y: f64) {
        self.camera.zoom(factor, (x, y));
    }

    /// Puts a place of the path (mm) in the middle, if it is not in sight.
    pub fn reveal(&mut self, distance: f64) {
        let Some(point) = self.scene.point(distance) else { return };
        let (x, y) = self.camera.project(point);
        let (width, height) = self.camera.size;
        if x < 0.0 || y < 0.0 || width < x || height < y {
            self.camera.target = point;
        }
    }

    /// The distance along the path (mm) at a pixel, as it was drawn last; none where there is no line near.
    pub fn pick(&self, x: f64, y: f64) -> Option<f64> {
        let reach = (REACH * self.ratio) as usize;
        let camera = self.camera.resized(self.ratio);
        self.raster.pick(&self.scene, &camera, (x * self.ratio, y * self.ratio), reach)
    }

    /// Where a distance along the path (mm) is in the picture: x and y, pixels; empty without a path.
    pub fn locate(&self, distance: f64) -> Vec<f64> {
        let place = self.scene.point(distance).map(|point| self.camera.project(point));
        place.map_or(Vec::new(), |(x, y)| vec![x, y])
    }

    /// Where X, Y and Z point in the picture: x and y of each, parts of their length.
    pub fn axes(&self) -> Vec<f64> {
        let [right, up] = self.camera.axes();
        (0..3).flat_map(|k| [right[k], -up[k]]).collect()
    }

    /// A round length, mm, and how many pixels it has.
    pub fn scale(&self) -> Vec<f64> {
        let length = self.camera.round_length();
        vec![length, length * self.camera.scale]
    }

    /// Length of the path, mm.
    pub fn length(&self) -> f64 {
        self.trail.distance.last().copied().unwrap_or(0.0)
    }

    /// Line of the program that is run at a distance, mm.
    #[wasm_bindgen(js_name = lineAt)]
    pub fn line_at(&self, distance: f64) -> Option<u32> {
        let ends = &self.programmed.end;
        let segment = ends.partition_point(|&end| end < distance).min(ends.len().saturating_sub(1));
        self.programmed.line.get(segment).copied()
    }

    /// Mean feedrate around a distance (mm), mm/min; none without a run.
    #[wasm_bindgen(js_name = feedrateAt)]
    pub fn feedrate_at(&self, distance: f64) -> Option<f64> {
        let step = self.pace.end.partition_point(|&end| end < distance);
        self.pace.value.get(step).copied().map(mm_per_min)
    }

    /// Where a line of the program is first run: from and to, mm; of a line without a move the next that has one.
    /// Empty where there is none.
    #[wasm_bindgen(js_name = stretchOf)]
    pub fn stretch_of(&self, line: u32) -> Vec<f64> {
        let Programmed { end, line: lines, .. } = &self.programmed;
        let own = lines.iter().position(|&other| other == line);
        let next = || {
            let later = lines.iter().enumerate().filter(|(_, other)| line < **other);
            later.min_by_key(|(index, other)| (**other, *index)).map(|(index, _)| index)
        };
        let Some(first) = own.or_else(next) else { return Vec::new() };
        let last = first + lines[first..].iter().take_while(|other| **other == lines[first]).count() - 1;
        vec![if first == 0 { 0.0 } else { end[first - 1] }, end[last]]
    }
}
