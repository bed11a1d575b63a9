//! The demands of the cut on tool and spindle: toolpath and profile → engagement → forces.
//!
//! ```text
//! toolpath, stock, tool  →  engagement: where the teeth are in the material, and the removed volume
//! engagement, feed       →  load: force, torque, power and removal rate along the path
//! ```
//!
//! Forces are optional and off by default, and change no other result. If they cannot be computed, the
//! request returns a [`CuttingError`], and the quote is unaffected.

mod engagement;
mod force;
mod headroom;
mod limits;
mod load;
mod materials;
mod setup;
mod stock;

pub use engagement::{Collision, CutPlace, Engagement, Sector, engagement, engagement_with_progress};
pub use force::{Force, Revolution, Rotor};
pub use headroom::Headroom;
pub use limits::LimitKind;
pub use load::{
    CutLoad, ExceededLimit, LoadCurve, OperationLoad, Peak, loads, programmed_and_predicted,
    programmed_feedrates,
};
pub use materials::{Coefficients, MATERIALS, Material, material};
pub use setup::{CuttingError, LoadLimits, Mill, Setup, StockBox, compliance};
pub use stock::HeightMap;
