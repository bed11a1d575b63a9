//! What the cut asks of tool and spindle: toolpath and profile → engagement → forces.
//!
//! ```text
//! toolpath, stock, tool  →  engagement: where the teeth are in the material, and what is removed
//! engagement, feed       →  load: force, torque, power and removal rate along the path
//! ```
//!
//! It stands beside simulation and quote and is switched off by default: nothing of it is run, and
//! no other result changes. What it cannot know it refuses ([`CuttingError`]), and the quote goes on.

mod engagement;
mod force;
mod headroom;
mod limits;
mod load;
mod materials;
mod setup;
mod stock;

pub use engagement::{Collision, Engagement, Place, Sector, engagement, engagement_told};
pub use force::{Force, Revolution, Rotor};
pub use headroom::Headroom;
pub use limits::Limit;
pub use load::{
    Exceeded, Load, Loads, OperationLoad, Peak, loads, programmed_and_predicted, programmed_feedrates,
};
pub use materials::{Coefficients, MATERIALS, Material, material};
pub use setup::{CuttingError, Limits, Mill, Setup, StockBox, compliance};
pub use stock::HeightMap;
