//! Names of constants and system variables of SINUMERIK controls, and the words beside a move that hold for its
//! block alone.
//!
//! | name | value here |
//! | --- | --- |
//! | `$AA_IW[X]`, `$P_EP[X]`, `$AA_IB[X]` | position in program coordinates |
//! | `$AA_IM[X]`, `$AA_MW[X]` | position in machine coordinates |
//! | `$P_F`, `$P_S`, `$P_TOOLNO`, `$P_TOOLP` | F, S and T in force |
//! | `$P_SEARCH`, `$P_SIM`, `$P_ISTEST`, `$P_DRYRUN` and the like | 0: a plain run |
//! | `$PI`, `TRUE`, `FALSE` | π, 1, 0 |
//! | `_FINISH`, `_ROUGH`, `_ORI_FINISH` … | types of CYCLE832 |
//!
//! FB is the feed of its block alone; SPOS stops and positions the spindle.
//!
//! Source: SINUMERIK 840D sl, Parameter Manual System Variables, 2013.

use crate::simulation::gcode::{Dialect, address};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::state::Interpreter;
use crate::units::mm_per_min;

/// Types of CYCLE832 by name.
const TYPES: [(&str, f64); 11] = [
    ("_off", 0.0),
    ("_finish", 1.0),
    ("_semifin", 2.0),
    ("_rough", 3.0),
    ("_precision", 4.0),
    ("_ori_finish", 11.0),
    ("_ori_semifin", 12.0),
    ("_ori_rough", 13.0),
    ("_ori_precision", 14.0),
    ("_top_surface_smooth_off", 1_000_000.0),
    ("_top_surface_smooth_on", 2_000_000.0),
];

/// Variables that are 0 in a plain run: no block search, no simulation, no test, no skipping.
const PLAIN_RUN: [&str; 10] = [
    "$p_search",
    "$p_searchl",
    "$p_sim",
    "$p_istest",
    "$p_dryrun",
    "$p_simul",
    "$p_sbl",
    "$p_repos",
    "$p_prog_event",
    "$ac_asup",
];

impl Interpreter<'_> {
    /// Returns the value of a name that the program does not define, in lower case.
    pub(crate) fn siemens_variable(&self, name: &str) -> Option<f64> {
        if let Some((_, value)) = TYPES.iter().find(|(known, _)| *known == name) {
            return Some(*value);
        }
        let axis = |variables: &[&str]| {
            let (variable, index) = name.split_once('[')?;
            let axis = ["x]", "y]", "z]"].iter().position(|known| *known == index)?;
            variables.contains(&variable).then_some(axis)
        };
        if let Some(axis) = axis(&["$aa_iw", "$p_ep", "$aa_ib"]) {
            return Some(self.frame.to_program(&self.canonical.position)[axis] / self.modal.unit);
        }
        if let Some(axis) = axis(&["$aa_im", "$aa_mw"]) {
            return Some(self.canonical.position[axis] / self.modal.unit);
        }
        match name {
            "$pi" => Some(std::f64::consts::PI),
            "true" => Some(1.0),
            "false" => Some(0.0),
            "$p_f" => Some(mm_per_min(self.modal.feedrate.unwrap_or(0.0)) / self.unit_of_feeds()),
            "$p_s" => Some(self.functions.speed.unwrap_or(0.0)),
            "$p_toolno" | "$p_toolp" => self.modal.tool.map(f64::from),
            name => PLAIN_RUN.contains(&name).then_some(0.0),
        }
    }

    /// Runs SPOS.
    pub(crate) fn orient_spindle(&mut self, block: Block) {
        if self.dialect == Dialect::Siemens && self.given.get(address::SPINDLE_POSITION).is_some() {
            self.turn_spindle(block, 19);
        }
    }
}
