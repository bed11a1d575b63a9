//! What is cut, with what, and what tool and spindle can bear.
//!
//! The stock is a box in the coordinates of the toolpath (the program's, where no work offset is
//! given), the tools are flat end mills with or without a corner radius.

use std::collections::BTreeMap;

use crate::cutting::materials::{Coefficients, Material};

/// All that the cut needs beside the toolpath.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setup {
    /// The stock; none: not given.
    pub stock: Option<StockBox>,
    /// Side of a cell of the height map, mm; none: [`Setup::resolution`] chooses.
    pub resolution: Option<f64>,
    /// Coefficients of the material; none: not given.
    pub coefficients: Option<Coefficients>,
    /// The material whose coefficients these are; none where they are the user's own, in whole or in part.
    pub material: Option<&'static Material>,
    /// The tool where no other is given by number.
    pub tool: Option<Mill>,
    /// Tools by number.
    pub tools: BTreeMap<u32, Mill>,
    /// Speed of the spindle where the program sets none, rpm.
    pub spindle_speed: Option<f64>,
    /// What the spindle can bear; the tools have limits of their own.
    pub spindle: Limits,
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
    /// Diameter, mm; none: not given.
    pub diameter: Option<f64>,
    /// Radius of the rounded corner between side and bottom, mm; 0: sharp.
    pub corner_radius: f64,
    /// Number of teeth; none: not given.
    pub teeth: Option<u32>,
    /// Helix angle, rad.
    pub helix: f64,
    /// Distance of the axis of the teeth from that of the spindle, mm, towards the first tooth.
    pub runout: f64,
    /// How far its tip is bent aside by a force, mm/N; 0: stiff.
    pub compliance: f64,
    /// What it can bear.
    pub limits: Limits,
}

/// A sharp straight mill without a size and without limits.
impl Default for Mill {
    fn default() -> Mill {
        let limits = Limits::default();
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

/// What may not be exceeded; neutral infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest force within a revolution, N.
    pub force: f64,
    /// Largest torque within a revolution, N·mm.
    pub torque: f64,
    /// Largest power, averaged over a revolution, N·mm/s.
    pub power: f64,
    /// Thickest chip, mm; of tools alone.
    pub chip: f64,
    /// Largest bend at the tip, mm; of tools alone.
    pub deflection: f64,
}

impl Default for Limits {
    fn default() -> Limits {
        let none = f64::INFINITY;
        Limits { force: none, torque: none, power: none, chip: none, deflection: none }
    }
}

impl Limits {
    /// Anything is limited.
    pub fn is_any(&self) -> bool {
        *self != Limits::default()
    }
}

/// Why there are no forces.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CuttingError {
    /// No stock is given.
    #[error("cutting forces are not computed: the stock is not given")]
    NoStock,
    /// The stock has no volume.
    #[error("cutting forces are not computed: the stock has no extent along {axis}")]
    EmptyStock {
        /// The axis.
        axis: char,
    },
    /// The height map would have too many cells.
    #[error(
        "cutting forces are not computed: {resolution} mm is too fine for the stock, {coarser:.3} mm would do"
    )]
    TooFine {
        /// Side of a cell, mm.
        resolution: f64,
        /// The finest there can be, mm.
        coarser: f64,
    },
    /// The path through the stock is too long for the resolution.
    #[error(
        "cutting forces are not computed: the path is too long for cells of {resolution} mm, coarser ones would do"
    )]
    TooLong {
        /// Side of a cell, mm.
        resolution: f64,
        /// How far it came.
        line: u32,
    },
    /// No coefficients are given.
    #[error("cutting forces are not computed: the material is not given")]
    NoMaterial,
    /// A tool that cuts is not described.
    #[error("cutting forces are not computed: {} is not described", tool_name(*.tool))]
    UnknownTool {
        /// Its number; none where the program gives none.
        tool: Option<u32>,
        /// Where it is first moved.
        line: u32,
    },
    /// A tool that cuts has no diameter.
    #[error("cutting forces are not computed: {} has no diameter", tool_name(*.tool))]
    NoDiameter {
        /// Its number; none where the program gives none.
        tool: Option<u32>,
        /// Where it is first moved.
        line: u32,
    },
    /// A tool that cuts has no number of teeth.
    #[error("cutting forces are not computed: {} has no number of teeth", tool_name(*.tool))]
    NoTeeth {
        /// Its number; none where the program gives none.
        tool: Option<u32>,
        /// Where it is first moved.
        line: u32,
    },
    /// Material is cut while no spindle speed is known.
    #[error("cutting forces are not computed: the speed of the spindle is not known")]
    NoSpindleSpeed {
        /// Where.
        line: u32,
    },
    /// The tool is turned against the stock.
    #[error("cutting forces are not computed: rotary axes are turned, which a height map cannot follow")]
    Rotary {
        /// Where.
        line: u32,
    },
}

fn tool_name(tool: Option<u32>) -> String {
    tool.map_or("the tool".to_string(), |tool| format!("tool T{tool}"))
}

impl CuttingError {
    /// Line of the program it concerns; 0 for all of it.
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

/// Diameter of a plain rod that bends like a fluted mill, as a part of the mill's (Kops and Vo 1990).
const ROD: f64 = 0.8;

/// How far a mill of this diameter (mm) is bent by a force at its tip, mm/N: a rod held `overhang` (mm)
/// above it, with Young's `modulus` (N/mm²), L³ / (3 E I) with I = π (0.8 D)⁴ / 64.
pub fn compliance(diameter: f64, overhang: f64, modulus: f64) -> f64 {
    let inertia = std::f64::consts::PI / 64.0 * (ROD * diameter).powi(4);
    overhang.powi(3) / (3.0 * modulus * inertia)
}

/// Cells along a radius where nobody chose a resolution.
const CELLS_A_RADIUS: f64 = 50.0;

/// Cells of a map, at most.
pub(crate) const MOST_CELLS: f64 = 4e6;

impl Setup {
    /// The tool of a number; none: of a program that gives none.
    pub fn mill(&self, tool: Option<u32>, line: u32) -> Result<&Mill, CuttingError> {
        let named = tool.and_then(|tool| self.tools.get(&tool));
        let mill = named.or(self.tool.as_ref()).ok_or(CuttingError::UnknownTool { tool, line })?;
        match mill {
            Mill { diameter: None, .. } => Err(CuttingError::NoDiameter { tool, line }),
            Mill { teeth: None, .. } => Err(CuttingError::NoTeeth { tool, line }),
            _ => Ok(mill),
        }
    }

    /// Side of a cell, mm: as chosen, or a fiftieth of the least radius, or what the stock bears.
    pub fn resolution(&self, stock: &StockBox) -> f64 {
        let mills = self.tools.values().chain(&self.tool);
        let least = mills.filter_map(|mill| mill.diameter).fold(f64::INFINITY, f64::min);
        let by_tool = 0.5 * least / CELLS_A_RADIUS;
        self.resolution.unwrap_or(by_tool.max(1.1 * stock.finest()))
    }
}

impl StockBox {
    /// The finest resolution its map can have, mm.
    pub fn finest(&self) -> f64 {
        let [x, y] = [0, 1].map(|axis: usize| self.max[axis] - self.min[axis]);
        (x * y / MOST_CELLS).sqrt()
    }
}

impl Mill {
    /// Radius, mm; 0 where no diameter is given.
    pub fn radius(&self) -> f64 {
        0.5 * self.diameter.unwrap_or(0.0)
    }

    /// Height of its bottom above the tip at a distance from the axis, mm.
    pub fn rise(&self, distance: f64) -> f64 {
        let corner = self.corner_radius.min(self.radius());
        let beyond = (distance - (self.radius() - corner)).clamp(0.0, corner);
        corner - (corner * corner - beyond * beyond).sqrt()
    }
}
