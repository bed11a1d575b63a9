//! The path on its canvas, with its trail, its shades and its camera.
//!
//! All pixels at the interface are CSS pixels from the canvas' top left corner.

use wasm_bindgen::prelude::*;
use wasm_bindgen::{Clamped, JsCast};
use web_sys::{CanvasRenderingContext2d, HtmlCanvasElement, ImageData};

use crate::plot::Programmed;
use crate::plot::path::{self, Camera, Coloring, Drawing, Light, Raster, Scene, Sheet, SteppedCurve, Trail};
use crate::units::mm_per_min;
use crate::web::theme::length_unit;

/// Width of lines, CSS pixels.
const LINE_WIDTH_PX: f64 = 2.0;
/// Length of dashes, CSS pixels.
const DASH_LENGTH_PX: f64 = 5.0;
/// Largest distance of the pointer from a line that it selects, CSS pixels.
const POINTER_REACH_PX: f64 = 8.0;
/// Yaw of the isometric view from the front and the right, rad.
const OBLIQUE_YAW_RAD: f64 = std::f64::consts::FRAC_PI_4;
/// Pitch of the isometric view, rad.
const OBLIQUE_PITCH_RAD: f64 = 0.615_479_708_670_387_3;

/// The meaning of the colours of the path.
#[wasm_bindgen(getter_with_clone)]
pub struct Legend {
    /// Colours in the notation of CSS, from the best to the worst.
    pub colors: Vec<String>,
    /// Values of the first and the last colour, in the unit.
    pub ends: Vec<f64>,
    /// Unit.
    pub unit: String,
}

/// A picture of the path.
#[wasm_bindgen]
#[derive(Default)]
pub struct PathView {
    trail: Trail,
    pub(super) programmed: Programmed,
    pub(super) pace: SteppedCurve,
    lost: SteppedCurve,
    parts: SteppedCurve,
    coloring: Option<Coloring>,
    scene: Scene,
    camera: Camera,
    dark: bool,
    marked: Option<(f64, f64)>,
    /// Distance up to which the program has run, mm; `None` for the whole program.
    run: Option<f64>,
    raster: Raster,
    /// The drawing of the pixels; `None` if they show another scene.
    drawn: Option<Drawing>,
    ratio: f64,
    colors: Vec<u8>,
}

#[wasm_bindgen]
impl PathView {
    /// Returns an empty picture.
    #[wasm_bindgen(constructor)]
    pub fn new() -> PathView {
        PathView::default()
    }

    /// Replaces everything by the trail of a job and its programmed feedrates; the columns are those of
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
        (self.pace, self.lost, self.marked) = (SteppedCurve::default(), SteppedCurve::default(), None);
        self.run = None;
    }

    /// Sets the feedrate of a run: ends of its steps (mm) and their feedrate (mm/s).
    pub fn pace(&mut self, end: Vec<f64>, feedrate: Vec<f64>) {
        self.pace = SteppedCurve { end, value: feedrate };
    }

    /// Sets the time lost against a recording (s over mm).
    pub fn lost(&mut self, distance: &[f64], seconds: &[f64]) {
        self.lost = SteppedCurve::of_lost(distance, seconds);
    }

    /// Sets the parts of the program: the end of each (mm), and the number of its colour.
    pub fn parts(&mut self, end: Vec<f64>, number: Vec<f64>) {
        self.parts = SteppedCurve { end, value: number };
    }

    /// Colours the path by `feedrate`, by `loss`, by time `lost` or by `part`.
    pub fn color(&mut self, by: &str) {
        let (coloring, pace) = match by {
            "part" => (Coloring::Part, &self.parts),
            "lost" => (Coloring::by_lost(&self.lost), &self.lost),
            "loss" => (Coloring::Loss, &self.pace),
            _ => (Coloring::by_feedrate(&self.programmed), &self.pace),
        };
        self.scene = Scene::new(&self.trail, &self.programmed, pace, coloring);
        self.coloring = Some(coloring);
        self.drawn = None;
    }

    /// Returns the meaning of the colours.
    pub fn legend(&self) -> Legend {
        let coloring = self.coloring.unwrap_or(Coloring::Loss);
        let colors = path::palette(coloring, self.dark);
        let (ends, unit) = match coloring {
            Coloring::Feedrate(top) => ([mm_per_min(top), 0.0], "mm/min"),
            Coloring::Loss => ([0.0, 100.0], "%"),
            // Seconds per metre.
            Coloring::Lost(top) => ([-1e3 * top, 1e3 * top], "s/m"),
            Coloring::Part => ([0.0, 0.0], ""),
        };
        Legend {
            colors: colors.map(|color| format!("rgb({}, {}, {})", color.0, color.1, color.2)).to_vec(),
            ends: ends.to_vec(),
            unit: unit.to_string(),
        }
    }

    /// Selects light on dark, or dark on light.
    #[wasm_bindgen(js_name = setDark)]
    pub fn set_dark(&mut self, dark: bool) {
        self.dark = dark;
    }

    /// Marks a range of the path, mm, or none.
    pub fn mark(&mut self, from: Option<f64>, to: Option<f64>) {
        self.marked = from.zip(to);
    }

    /// Shows the path as run up to a distance (mm), or all of it.
    #[wasm_bindgen(js_name = runTo)]
    pub fn run_to(&mut self, distance: Option<f64>) {
        self.run = distance;
    }

    /// Returns `true` if the cuts are deep enough for an oblique view.
    #[wasm_bindgen(js_name = isDeep)]
    pub fn is_deep(&self) -> bool {
        self.scene.is_deep()
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
        let pen = (LINE_WIDTH_PX * ratio).round().max(1.0) as usize;
        let camera = self.camera.resized(ratio);
        let drawing = Drawing { camera, pen, dash: (DASH_LENGTH_PX * ratio) as f32, marked: self.marked };
        // While a program runs, only colours change.
        if self.drawn != Some(drawing) {
            path::raster(&self.scene, &drawing, &mut self.raster);
            self.drawn = Some(drawing);
        }
        let shades = path::palette(self.coloring.unwrap_or(Coloring::Loss), self.dark);
        let light = Light {
            ground: path::ground(self.dark),
            reach: pen,
            first_pending: self.scene.edges_to(self.run),
        };
        self.raster.colors(&path::ink(&shades, self.dark), &light, &mut self.colors);
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

    /// Returns the view as SVG for a document, dark on white, with labels of the first and the last colour
    /// and of the length of `scale`.
    pub fn svg(&self, first: String, last: String, scale: String) -> String {
        let shades = path::palette(self.coloring.unwrap_or(Coloring::Loss), false);
        path::svg_of_path(
            &self.scene,
            &Sheet {
                camera: self.camera,
                marked: self.marked,
                inks: &path::ink(&shades, false),
                ends: [first, last],
                length: (self.camera.round_length(length_unit()), scale),
            },
        )
    }

    /// Sets the size of the picture; its middle shows the same position as before.
    pub fn resize(&mut self, width: f64, height: f64) {
        self.camera.size = (width, height);
    }

    /// Shows the whole path.
    pub fn fit(&mut self) {
        self.camera.fit(&self.scene);
    }

    /// Looks at the whole path from the `top`, the `front` or the `side`, or obliquely from above.
    pub fn look(&mut self, from: &str) {
        (self.camera.yaw, self.camera.pitch) = match from {
            "top" => (0.0, std::f64::consts::FRAC_PI_2),
            "front" => (0.0, 0.0),
            "side" => (std::f64::consts::FRAC_PI_2, 0.0),
            _ => (OBLIQUE_YAW_RAD, OBLIQUE_PITCH_RAD),
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

    /// Centres a place of the path (mm) if it is not visible.
    pub fn reveal(&mut self, distance: f64) {
        let Some(point) = self.scene.point(distance) else { return };
        let (x, y) = self.camera.project(point);
        let (width, height) = self.camera.size;
        if x < 0.0 || y < 0.0 || width < x || height < y {
            self.camera.target = point;
        }
    }

    /// Returns the distance along the path (mm) at a pixel of the last drawing; undefined if no line is near.
    pub fn pick(&self, x: f64, y: f64) -> Option<f64> {
        let reach = (POINTER_REACH_PX * self.ratio) as usize;
        let camera = self.camera.resized(self.ratio);
        self.raster.pick(&self.scene, &camera, (x * self.ratio, y * self.ratio), reach)
    }

    /// Returns the pixel of a distance along the path (mm): x and y; empty without a path.
    pub fn locate(&self, distance: f64) -> Vec<f64> {
        let place = self.scene.point(distance).map(|point| self.camera.project(point));
        place.map_or(Vec::new(), |(x, y)| vec![x, y])
    }

    /// Returns the directions of X, Y and Z in the picture: x and y of each, as parts of their length.
    pub fn axes(&self) -> Vec<f64> {
        let [right, up] = self.camera.axes();
        (0..3).flat_map(|k| [right[k], -up[k]]).collect()
    }

    /// Returns a length for a scale bar (mm), round in the unit shown, and its number of pixels.
    pub fn scale(&self) -> Vec<f64> {
        let length = self.camera.round_length(length_unit());
        vec![length, length * self.camera.scale]
    }

    /// Returns the length of the path, mm.
    pub fn length(&self) -> f64 {
        self.trail.distance.last().copied().unwrap_or(0.0)
    }
}
