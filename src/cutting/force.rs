//! Force of a helical end mill over one revolution.
//!
//! ```text
//! φ_j(z) = θ + 2π j / N − z tan β / R                    angle of tooth j at height z
//! h_j    = f sin φ_j                                      chip thickness, f feed per tooth
//! dF_t, dF_r, dF_a                                        by the edge force model, see materials
//! dF_x = −dF_t cos φ − dF_r sin φ                         along the feed
//! dF_y =  dF_t sin φ − dF_r cos φ                         towards φ = 0
//! dF_z =  dF_a,   dM = R dF_t
//! ```
//!
//! θ rotation, N number of teeth, β helix angle, R radius; mm, N, N·mm. Along z each integral over a tooth
//! has a closed form: with φ_m the angle in the middle of the part in material and w half of its turn, ∫ sin
//! aφ dz = Δz sin aφ_m · sin(aw)/(aw), which is valid without helix too. The mean over a revolution is an
//! integral over φ by the same formula, and does not depend on the helix. The peak is searched for in steps
//! of three degrees and wherever an end of an edge enters or leaves.
//!
//! With run-out ρ the teeth lie on unequal radii r_j = ρ cos(2π j / N − z tan β / R), a chip is the material
//! that the teeth before have left, h_j = max(0, min over m of m f sin φ + r_j − r_(j+m)), and the integrals
//! are sums over slices.
//!
//! Source: Altintas, Manufacturing Automation, 2nd ed. 2012, Sect. 2.8; run-out: Kline and DeVor 1983.
//! Limits: the deflection of the tool, the trochoidal path of a tooth (f ≪ R), and cutting by the bottom are
//! ignored.

use std::f64::consts::{PI, TAU};

use crate::cutting::engagement::Sector;
use crate::cutting::materials::Coefficients;
use crate::cutting::setup::Mill;

/// The values of a mill from which its force is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotor {
    /// Radius R, mm.
    pub radius: f64,
    /// Number of teeth N.
    pub teeth: u32,
    /// tan β / R, rad/mm.
    pub lag: f64,
    /// Run-out ρ, mm.
    pub runout: f64,
    /// Coefficients of tool and material.
    pub coefficients: Coefficients,
}

/// The forces on a mill over one revolution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Force {
    /// Mean along the feed, towards φ = 0 and along the axis, N.
    pub mean: [f64; 3],
    /// Largest resultant, N.
    pub peak: f64,
    /// Mean torque, N·mm.
    pub mean_torque: f64,
    /// Largest torque, N·mm.
    pub peak_torque: f64,
    /// Thickest chip, mm; without run-out.
    pub chip: f64,
}

/// Along the feed, towards φ = 0, along the axis (N), and torque (N·mm).
type ForceAction = [f64; 4];

/// The action at one rotation: a part per mm of feed per tooth, and a constant part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct EdgeAction {
    cutting: ForceAction,
    edge: ForceAction,
}

/// One revolution, ready for any feed.
#[derive(Clone, Debug, Default)]
pub struct Revolution {
    mean: EdgeAction,
    /// At each sampled rotation.
    shares: Vec<EdgeAction>,
    /// Largest sin φ.
    steepest: f64,
}

/// A slice of an edge in a sector, if there is run-out.
struct EdgeSlice {
    entry: f64,
    exit: f64,
    height: f64,
    /// Angle of the edge behind its tip, rad.
    back: f64,
    /// Leads of each tooth, mm.
    leads: Vec<Vec<f64>>,
}

/// Step between sampled rotations, rad.
const ROTATION_STEP_RAD: f64 = PI / 60.0;

/// Slices along the depth of a sector, if there is run-out.
const SLICES_PER_SECTOR: usize = 24;

impl Rotor {
    /// Returns the mill on a material; `None` without diameter or teeth.
    pub fn new(mill: &Mill, coefficients: Coefficients) -> Option<Rotor> {
        let (radius, teeth) = (0.5 * mill.diameter?, mill.teeth?);
        let is_real = 0.0 < radius && 0 < teeth;
        let lag = mill.helix.tan() / radius;
        is_real.then_some(Rotor { radius, teeth, lag, runout: mill.runout, coefficients })
    }

    /// Returns the forces in these sectors at each feed per tooth, mm.
    pub fn forces(&self, sectors: &[Sector], feeds: &[f64]) -> Vec<Force> {
        if self.runout != 0.0 {
            return self.with_runout(sectors, feeds);
        }
        let revolution = self.revolution(sectors);
        feeds.iter().map(|feed| revolution.at(*feed)).collect()
    }

    /// Returns one revolution in these sectors, without run-out.
    pub fn revolution(&self, sectors: &[Sector]) -> Revolution {
        let mut mean = EdgeAction::default();
        for sector in sectors {
            let half = 0.5 * (sector.exit - sector.entry);
            let turns = f64::from(self.teeth) * sector.depth * 2.0 * half / TAU;
            mean.add(self, turns, 0.5 * (sector.entry + sector.exit), half);
        }
        let mut shares = Vec::new();
        if !sectors.is_empty() {
            let pitch = TAU / f64::from(self.teeth);
            let steps = (pitch / ROTATION_STEP_RAD).ceil() as usize;
            let regular = (0..steps).map(|step| pitch * step as f64 / steps as f64);
            let ends = sectors.iter().flat_map(|sector| {
                let turned = self.lag * sector.depth;
                [sector.entry, sector.exit, sector.entry + turned, sector.exit + turned]
            });
            shares.extend(regular.chain(ends).map(|rotation| self.share(sectors, rotation)));
        }
        Revolution { mean, shares, steepest: self.steepest(sectors) }
    }

    /// Returns the action of all teeth at a rotation, rad.
    fn share(&self, sectors: &[Sector], rotation: f64) -> EdgeAction {
        let mut share = EdgeAction::default();
        for tooth in 0..self.teeth {
            let tip = (rotation + TAU * f64::from(tooth) / f64::from(self.teeth)).rem_euclid(TAU);
            for sector in sectors {
                let turned = self.lag * sector.depth;
                // A long edge may pass through the same sector again one turn further back.
                let turns = (turned.abs() / TAU).ceil() as i32 + 1;
                for turn in -turns..=turns {
                    let tip = tip + TAU * f64::from(turn);
                    let Some((from, to)) = self.in_sector(tip, sector) else { continue };
                    let middle = tip - 0.5 * self.lag * (from + to);
                    share.add(self, to - from, middle, 0.5 * self.lag * (to - from));
                }
            }
        }
        share
    }

    /// Returns the heights between which an edge with its tip at an angle lies in a sector, mm.
    fn in_sector(&self, tip: f64, sector: &Sector) -> Option<(f64, f64)> {
        // Without helix the whole edge enters at once; the angle may have lost its last digits.
        if self.lag.abs() * sector.depth < 1e-9 {
            let is_in = sector.entry - 1e-9 <= tip && tip <= sector.exit + 1e-9;
            return is_in.then_some((0.0, sector.depth));
        }
        let (a, b) = ((tip - sector.exit) / self.lag, (tip - sector.entry) / self.lag);
        let (from, to) = (a.min(b).max(0.0), a.max(b).min(sector.depth));
        (from < to).then_some((from, to))
    }

    /// Returns the forces with run-out at each feed per tooth, mm: sums over slices of the edges.
    fn with_runout(&self, sectors: &[Sector], feeds: &[f64]) -> Vec<Force> {
        let mut forces = vec![Force::default(); feeds.len()];
        let mut actions = vec![ForceAction::default(); feeds.len()];
        let steps = (TAU / ROTATION_STEP_RAD).ceil() as usize;
        let pitch = TAU / f64::from(self.teeth);
        let slices: Vec<EdgeSlice> = sectors
            .iter()
            .flat_map(|sector| {
                let height = sector.depth / SLICES_PER_SECTOR as f64;
                (0..SLICES_PER_SECTOR).map(move |index| (sector, height, height * (index as f64 + 0.5)))
            })
            .map(|(sector, height, z)| {
                let back = self.lag * z;
                let leads = (0..self.teeth).map(|tooth| self.leads(tooth, back)).collect();
                EdgeSlice { entry: sector.entry, exit: sector.exit, height, back, leads }
            })
            .collect();
        for step in 0..steps {
            let rotation = TAU * step as f64 / steps as f64;
            actions.fill(ForceAction::default());
            for slice in &slices {
                for (tooth, leads) in slice.leads.iter().enumerate() {
                    let angle = (rotation + pitch * tooth as f64 - slice.back).rem_euclid(TAU);
                    if angle < slice.entry || slice.exit <= angle {
                        continue;
                    }
                    let (sin, cos) = angle.sin_cos();
                    for (action, feed) in actions.iter_mut().zip(feeds) {
                        let chip = thickness(leads, feed * sin);
                        if 0.0 < chip {
                            self.element(action, chip, slice.height, (sin, cos));
                        }
                    }
                }
            }
            for (force, action) in forces.iter_mut().zip(&actions) {
                for (mean, action) in force.mean.iter_mut().zip(action) {
                    *mean += action / steps as f64;
                }
                force.mean_torque += action[3] / steps as f64;
                force.peak = force.peak.max(resultant(action));
                force.peak_torque = force.peak_torque.max(action[3]);
            }
        }
        let steepest = self.steepest(sectors);
        for (force, feed) in forces.iter_mut().zip(feeds) {
            force.chip = feed * steepest;
        }
        forces
    }

    /// Returns the largest sin φ in sectors.
    fn steepest(&self, sectors: &[Sector]) -> f64 {
        let top = |sector: &Sector| (0.5 * PI).clamp(sector.entry, sector.exit).sin();
        sectors.iter().map(top).fold(0.0, f64::max)
    }

    /// Returns the excess of the radius of a tooth over the radius of each tooth before it, the nearest first, mm,
    /// at a height where the edge lies `back` (rad) behind its tip.
    fn leads(&self, tooth: u32, back: f64) -> Vec<f64> {
        let pitch = TAU / f64::from(self.teeth);
        let radius = |tooth: u32| self.runout * (pitch * f64::from(tooth) - back).cos();
        (1..=self.teeth).map(|passes| radius(tooth) - radius(tooth + passes)).collect()
    }

    /// Returns the chip of a tooth with run-out, mm, at a height where the edge lies `back` (rad) behind its
    /// tip and an even tooth would cut `even` (mm). A tooth with a chip of 0 or less cuts nothing.
    pub fn chip(&self, tooth: u32, back: f64, even: f64) -> f64 {
        thickness(&self.leads(tooth, back), even)
    }

    /// Adds an element of an edge at the sine and cosine of its angle, `height` (mm) long.
    fn element(&self, action: &mut ForceAction, chip: f64, height: f64, (sin, cos): (f64, f64)) {
        let Coefficients { cutting, edge } = &self.coefficients;
        let [t, r, a] = [0, 1, 2].map(|k: usize| (cutting[k] * chip + edge[k]) * height);
        let more = [-t * cos - r * sin, t * sin - r * cos, a, t * self.radius];
        action.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
    }
}

impl EdgeAction {
    /// Adds an edge of this length (mm) that turns by twice `half` (rad) around `middle` (rad).
    fn add(&mut self, rotor: &Rotor, length: f64, middle: f64, half: f64) {
        let spread = |multiple: f64| {
            let w = multiple * half;
            // The series is exact to the last digit where the quotient is undefined.
            length * if w.abs() < 1e-4 { 1.0 - w * w / 6.0 } else { w.sin() / w }
        };
        let (sin, cos) = middle.sin_cos();
        let (once, twice) = (spread(1.0), spread(2.0));
        let (sin_1, cos_1) = (sin * once, cos * once);
        let (sin_cos, sin_sin) = (sin * cos * twice, 0.5 * (length - (cos * cos - sin * sin) * twice));
        let Coefficients { cutting: [tc, rc, ac], edge: [te, re, ae] } = rotor.coefficients;
        let cutting = [
            -tc * sin_cos - rc * sin_sin,
            tc * sin_sin - rc * sin_cos,
            ac * sin_1,
            rotor.radius * tc * sin_1,
        ];
        let edge =
            [-te * cos_1 - re * sin_1, te * sin_1 - re * cos_1, ae * length, rotor.radius * te * length];
        for axis in 0..4 {
            self.cutting[axis] += cutting[axis];
            self.edge[axis] += edge[axis];
        }
    }

    fn at(&self, feed: f64) -> ForceAction {
        [0, 1, 2, 3].map(|axis: usize| feed * self.cutting[axis] + self.edge[axis])
    }
}

impl Revolution {
    /// Returns the force at a feed per tooth, mm; a tool at rest cuts nothing.
    pub fn at(&self, feed: f64) -> Force {
        if feed <= 0.0 {
            return Force::default();
        }
        let [x, y, z, mean_torque] = self.mean.at(feed);
        let mut force =
            Force { mean: [x, y, z], mean_torque, chip: feed * self.steepest, ..Force::default() };
        for share in &self.shares {
            let action = share.at(feed);
            force.peak = force.peak.max(resultant(&action));
            force.peak_torque = force.peak_torque.max(action[3]);
        }
        force
    }
}

/// Returns the chip of a tooth with these leads, mm, where an even one would cut `even` (mm).
fn thickness(leads: &[f64], even: f64) -> f64 {
    let left = |(passes, lead): (usize, &f64)| (passes + 1) as f64 * even + lead;
    leads.iter().enumerate().map(left).fold(f64::INFINITY, f64::min).max(0.0)
}

fn resultant(action: &ForceAction) -> f64 {
    action[0].hypot(action[1]).hypot(action[2])
}
