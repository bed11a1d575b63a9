//! The stock, the tools, and the limits of tool and spindle.
//!
//! The stock is a box in the coordinates of the toolpath (the program's, where no work offset is
//! given), the tools are flat end mills with or without a corner radius.

use std::collections::BTreeMap;

use crate::cutting::materials::{Coefficients, Material};

/// The inputs of the cut in addition to the toolpath.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setup {
    /// Stock; `None` if not given.
    pub stock: Option<StockBox>,
    /// Side of a cell of the height map, mm; if `None`, [`Setup::resolution`] chooses it.
    pub resolution: Option<f64>,
    /// Coefficients of the material; `None` if not given.
    pub coefficients: Option<Coefficients>,
    /// Material of the coefficients; `None` if the user gave any of them.
    pub material: Option<&'static Material>,
    /// Tool for numbers without an entry in `tools`.
    pub tool: Option<Mill>,
    /// Tools by number.
    pub tools: BTreeMap<u32, Mill>,
    /// Spindle speed if the program sets none, rpm.
    pub spindle_speed: Option<f64>,
    /// Limits of the spindle; tools have other limits.
    pub spindle: LoadLimits,
}

/// An upright box, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StockBox {
    /// Corner with the least coordinates.
    pub min: [f64; 3],
    /// Corner with the largest coordinates; its z is the height of the top.
    pub max: [f64; 3],
}

/// A flat end mill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mill {
    /// Diameter, mm; `None` if not given.
    pub diameter: Option<f64>,
    /// Radius of the rounded corner between side and bottom, mm; 0 if sharp.
    pub corner_radius: f64,
    /// Number of teeth; `None` if not given.
    pub teeth: Option<u32>,
    /// Helix angle, rad.
    pub helix: f64,
    /// Distance of the axis of the teeth from that of the spindle, mm, towards the first tooth.
    pub runout: f64,
    /// Deflection of the tip by a force, mm/N; 0 for a stiff tool.
    pub compliance: f64,
    /// Limits.
    pub limits: LoadLimits,
}

/// A sharp mill without helix, size and limits.
impl Default for Mill {
    fn default() -> Mill {
        let limits = LoadLimits::default();
        Mill {
            diameter: None,
            corner_radius: 0.0,
            teeth: None,
            helix: 0.0,
            runout: 0.0,
            compliance: 0.0,
            limits,
        }
    }
}

/// Upper limits; infinite by default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadLimits {
    /// Largest force within a revolution, N.
    pub force: f64,
    /// Largest torque within a revolution, N·mm.
    pub torque: f64,
    /// Largest power, averaged over a revolution, N·mm/s.
    pub power: f64,
    /// Thickest chip, mm; only of tools.
    pub chip: f64,
    /// Largest deflection of the tip, mm; only of tools.
    pub deflection: f64,
}

impl Default for LoadLimits {
    fn default() -> LoadLimits {
        let none = f64::INFINITY;
        LoadLimits { force: none, torque: none, power: none, chip: none, deflection: none }
    }
}

impl LoadLimits {
    /// Returns `true` if any quantity is limited.
    pub fn is_any(&self) -> bool {
        *self != LoadLimits::default()
    }
}

/// The reason for missing forces.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CuttingError {
    /// No stock is given.
    #[error("cutting forces are not computed: the cutting job has no stock")]
    NoStock,
    /// The stock has no volume.
    #[error("cutting forces are not computed: the stock has no extent along {axis}")]
    EmptyStock {
        /// Axis.
        axis: char,
    },
    /// The height map would have too many cells.
    #[error(
        "cutting forces are not computed: a resolution of {resolution} mm is too fine for the stock; {coarser:.3} mm works"
    )]
    TooFine {
        /// Side of a cell, mm.
        resolution: f64,
        /// Finest possible side, mm.
        coarser: f64,
    },
    /// The path through the stock is too long for the resolution.
    #[error(
        "cutting forces are not computed: the path is too long for cells of {resolution} mm; choose a coarser resolution"
    )]
    TooLong {
        /// Side of a cell, mm.
        resolution: f64,
        /// Line at which the computation stopped.
        line: u32,
    },
    /// No coefficients are given.
    #[error("cutting forces are not computed: the cutting job has no material")]
    NoMaterial,
    /// A tool that cuts is not described.
    #[error("cutting forces are not computed: {} is not described", tool_name(*.tool))]
    UnknownTool {
        /// Number of the tool; `None` if the program gives none.
        tool: Option<u32>,
        /// Line of the first move of the tool.
        line: u32,
    },
    /// A tool that cuts has no diameter.
    #[error("cutting forces are not computed: {} has no diameter", tool_name(*.tool))]
    NoDiameter {
        /// Number of the tool; `None` if the program gives none.
        tool: Option<u32>,
        /// Line of the first move of the tool.
        line: u32,
    },
    /// A tool that cuts has no number of teeth.
    #[error("cutting forces are not computed: {} has no number of teeth", tool_name(*.tool))]
    NoTeeth {
        /// Number of the tool; `None` if the program gives none.
        tool: Option<u32>,
        /// Line of the first move of the tool.
        line: u32,
    },
    /// Material is cut while no spindle speed is known.
    #[error("cutting forces are not computed: the spindle speed is unknown")]
    NoSpindleSpeed {
        /// Line.
        line: u32,
    },
    /// The tool is turned against the stock.
    #[error(
        "cutting forces are not computed: the program turns rotary axes, which a height map cannot represent"
    )]
    Rotary {
        /// Line.
        line: u32,
    },
}

fn tool_name(tool: Option<u32>) -> String {
    tool.map_or("the tool".to_string(), |tool| format!("tool T{tool}"))
}

impl CuttingError {
    /// Returns the line of the program; 0 if the whole program is concerned.
    pub fn line(&self) -> u32 {
        match *self {
            CuttingError::UnknownTool { line, .. }
            | CuttingError::NoDiameter { line, .. }
            | CuttingError::NoTeeth { line, .. }
            | CuttingError::TooLong { line, .. }
            | CuttingError::NoSpindleSpeed { line }
            | CuttingError::Rotary { line } => line,
            _ => 0,
        }
    }
}

/// Diameter of a plain rod as stiff as a fluted mill, as a part of the diameter of the mill (Kops and Vo
/// 1990).
const EQUIVALENT_ROD_RATIO: f64 = 0.8;

/// Returns the deflection of the tip of a mill by a force, mm/N. The mill is a rod of the diameter 0.8 D that
/// is clamped at the distance L from the tip: L³ / (3 E I) with I = π (0.8 D)⁴ / 64, where D is `diameter`
/// (mm), L `overhang` (mm) and E Young's `modulus` (N/mm²).
pub fn compliance(diameter: f64, overhang: f64, modulus: f64) -> f64 {
    let inertia = std::f64::consts::PI / 64.0 * (EQUIVALENT_ROD_RATIO * diameter).powi(4);
    overhang.powi(3) / (3.0 * modulus * inertia)
}

/// Cells along a radius if no resolution is chosen.
const CELLS_PER_RADIUS: f64 = 50.0;

/// Most cells of a map.
pub(crate) const MAX_MAP_CELLS: f64 = 4e6;

impl Setup {
    /// Returns the tool with a number; `None` if the program gives none.
    ///
    /// # Errors
    ///
    /// Returns an error if the set-up has no such tool, or lacks its diameter or its teeth.
    pub fn mill(&self, tool: Option<u32>, line: u32) -> Result<&Mill, CuttingError> {
        let named = tool.and_then(|tool| self.tools.get(&tool));
        let mill = named.or(self.tool.as_ref()).ok_or(CuttingError::UnknownTool { tool, line })?;
        match mill {
            Mill { diameter: None, .. } => Err(CuttingError::NoDiameter { tool, line }),
            Mill { teeth: None, .. } => Err(CuttingError::NoTeeth { tool, line }),
            _ => Ok(mill),
        }
    }

    /// Returns the side of a cell, mm: the chosen one, or else a fiftieth of the least radius, or the finest
    /// that the stock allows if that is coarser.
    pub fn resolution(&self, stock: &StockBox) -> f64 {
        let mills = self.tools.values().chain(&self.tool);
        let least = mills.filter_map(|mill| mill.diameter).fold(f64::INFINITY, f64::min);
        let by_tool = 0.5 * least / CELLS_PER_RADIUS;
        self.resolution.unwrap_or(by_tool.max(1.1 * stock.finest()))
    }
}

impl StockBox {
    /// Returns the finest resolution of the stock's map, mm.
    pub fn finest(&self) -> f64 {
        let [x, y] = [0, 1].map(|axis: usize| self.max[axis] - self.min[axis]);
        (x * y / MAX_MAP_CELLS).sqrt()
    }
}

impl Mill {
    /// Returns the radius, mm; 0 without a diameter.
    pub fn radius(&self) -> f64 {
        0.5 * self.diameter.unwrap_or(0.0)
    }

    /// Returns the height of the bottom above the tip at a distance from the axis, mm.
    pub fn rise(&self, distance: f64) -> f64 {
        let corner = self.corner_radius.min(self.radius());
        let beyond = (distance - (self.radius() - corner)).clamp(0.0, corner);
        corner - (corner * corner - beyond * beyond).sqrt()
    }
}
