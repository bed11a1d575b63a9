//! Cutting forces as text: what `predict` adds where a cutting job is given.

use std::fmt::Write;

use serde::Serialize;

use crate::cutting::{
    Collision, CuttingError, Engagement, Exceeded, Headroom, Limit, Loads, MATERIALS, OperationLoad, Peak,
    Setup,
};
use crate::simulation::toolpath::Toolpath;
use crate::units::{mm_per_min, n_m_of_n_mm, watts_of_n_mm_per_s};

/// What the cut asks of tool and spindle at one tolerance.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Cutting {
    /// Side of a cell of the stock.
    resolution_mm: f64,
    /// What the forces are computed with.
    material: OfMaterial,
    /// By the programmed feedrate.
    programmed: Peaks,
    /// By the predicted one.
    predicted: Peaks,
    /// Where the predicted feedrate exceeds limits.
    exceeded: Vec<Beyond>,
    /// Where the programmed feedrate could be higher, what saves most first.
    headroom: Vec<Room>,
    /// Rapid moves through material.
    rapids_through_stock: Vec<Rapid>,
    /// What the numbers rest on.
    assumptions: &'static str,
}

const ASSUMPTIONS: &str = "force is the largest resultant within a revolution, power its mean; engagement on the \
     programmed path in a height map; linear edge force model with a stiff tool; cutting by the bottom is left out";

/// Coefficients, in N/mm² and N/mm, and where they are from.
#[derive(Clone, Debug, Serialize)]
struct OfMaterial {
    name: &'static str,
    source: &'static str,
    /// The numbers were compared with the source named.
    is_checked: bool,
    /// K_tc, K_rc, K_ac.
    cutting_n_mm2: [f64; 3],
    /// K_te, K_re, K_ae.
    edge_n_mm: [f64; 3],
}

/// A material that can be chosen.
#[derive(Serialize)]
struct Choice {
    word: &'static str,
    #[serde(flatten)]
    about: OfMaterial,
}

/// All materials with their coefficients and sources, as JSON.
pub fn materials_json() -> String {
    let all = MATERIALS.map(|material| {
        let of = Setup {
            coefficients: Some(material.coefficients),
            material: crate::cutting::material(material.word),
            ..Setup::default()
        };
        Choice { word: material.word, about: OfMaterial::from(&of) }
    });
    serde_json::to_string(&all).expect("plain structures can be serialized")
}

impl From<&Setup> for OfMaterial {
    fn from(setup: &Setup) -> OfMaterial {
        let coefficients = setup.coefficients.unwrap_or_default();
        let (name, source, is_checked) = match setup.material {
            Some(material) => (material.name, material.source, material.is_checked),
            None => ("of your own", "the cutting job", true),
        };
        let (cutting_n_mm2, edge_n_mm) = (coefficients.cutting, coefficients.edge);
        OfMaterial { name, source, is_checked, cutting_n_mm2, edge_n_mm }
    }
}

/// Where the feedrate could be higher.
#[derive(Clone, Debug, Serialize)]
struct Room {
    lines: [u32; 2],
    distance_mm: [f64; 2],
    cut_mm: f64,
    programmed_mm_min: f64,
    predicted_mm_min: f64,
    factor: f64,
    /// The limit met first beyond that; null where none is.
    limit: Option<&'static str>,
    /// What it would save where the machine reached both feedrates.
    saved_s: f64,
}

impl From<&Headroom> for Room {
    fn from(room: &Headroom) -> Room {
        Room {
            lines: [room.lines.0, room.lines.1],
            distance_mm: [room.distance.0, room.distance.1],
            cut_mm: room.length,
            programmed_mm_min: mm_per_min(room.feedrate),
            predicted_mm_min: mm_per_min(room.predicted),
            factor: room.factor,
            limit: room.limit.map(|limit| limit_row(limit).0),
            saved_s: room.saved(),
        }
    }
}

/// Largest values.
#[derive(Clone, Debug, Serialize)]
struct Peaks {
    force_n: At,
    torque_nm: At,
    power_w: At,
    removal_rate_mm3_min: At,
}

/// A value and where it is.
#[derive(Clone, Debug, Serialize)]
struct At {
    value: f64,
    line: u32,
    distance_mm: f64,
}

#[derive(Clone, Debug, Serialize)]
struct Beyond {
    /// tool_force, tool_torque, tool_power, tool_chip, tool_deflection, spindle_force, spindle_torque or spindle_power.
    limit: &'static str,
    unit: &'static str,
    allowed: f64,
    largest: At,
    lines: [u32; 2],
}

#[derive(Clone, Debug, Serialize)]
struct Rapid {
    line: u32,
    distance_mm: f64,
    removed_mm3: f64,
}

/// What an operation asks of tool and spindle.
#[derive(Clone, Debug, Serialize)]
pub(super) struct OfOperation {
    removed_mm3: f64,
    /// By the predicted feedrate.
    peak_power_w: At,
    /// By the predicted feedrate.
    peak_force_n: At,
}

fn at(peak: &Peak, convert: impl Fn(f64) -> f64) -> At {
    At { value: convert(peak.value), line: peak.line, distance_mm: peak.distance }
}

impl From<&Loads> for Peaks {
    fn from(loads: &Loads) -> Peaks {
        Peaks {
            force_n: at(&loads.force, |force| force),
            torque_nm: at(&loads.torque, n_m_of_n_mm),
            power_w: at(&loads.power, watts_of_n_mm_per_s),
            // As a feedrate over an area.
            removal_rate_mm3_min: at(&loads.removal_rate, mm_per_min),
        }
    }
}

impl From<&OperationLoad> for OfOperation {
    fn from(load: &OperationLoad) -> OfOperation {
        OfOperation {
            removed_mm3: load.removed,
            peak_power_w: at(&load.power, watts_of_n_mm_per_s),
            peak_force_n: at(&load.force, |force| force),
        }
    }
}

/// Word, unit, name, and how a limit is written.
fn limit_row(limit: Limit) -> (&'static str, &'static str, &'static str, fn(f64) -> f64) {
    let same: fn(f64) -> f64 = |force| force;
    match limit {
        Limit::ToolForce => ("tool_force", "N", "force on the tool", same),
        Limit::ToolTorque => ("tool_torque", "N·m", "torque on the tool", n_m_of_n_mm),
        Limit::ToolPower => ("tool_power", "W", "power through the tool", watts_of_n_mm_per_s),
        Limit::ToolChip => ("tool_chip", "mm", "thickness of a chip", same),
        Limit::ToolDeflection => ("tool_deflection", "mm", "bend of the tool", same),
        Limit::SpindleForce => ("spindle_force", "N", "force on the spindle", same),
        Limit::SpindleTorque => ("spindle_torque", "N·m", "torque of the spindle", n_m_of_n_mm),
        Limit::SpindlePower => ("spindle_power", "W", "power of the spindle", watts_of_n_mm_per_s),
    }
}

impl From<&Exceeded> for Beyond {
    fn from(exceeded: &Exceeded) -> Beyond {
        let (limit, unit, _, convert) = limit_row(exceeded.limit);
        Beyond {
            limit,
            unit,
            allowed: convert(exceeded.allowed),
            largest: at(&exceeded.peak, convert),
            lines: [exceeded.lines.0, exceeded.lines.1],
        }
    }
}

impl From<&Collision> for Rapid {
    fn from(collision: &Collision) -> Rapid {
        let Collision { line, distance, removed, .. } = *collision;
        Rapid { line, distance_mm: distance, removed_mm3: removed }
    }
}

impl Cutting {
    /// Programmed and predicted loads of an engagement.
    pub(super) fn new(
        engagement: &Engagement,
        setup: &Setup,
        [programmed, predicted]: &[Loads; 2],
    ) -> Cutting {
        Cutting {
            resolution_mm: engagement.resolution,
            material: OfMaterial::from(setup),
            programmed: Peaks::from(programmed),
            predicted: Peaks::from(predicted),
            exceeded: predicted.exceeded.iter().map(Beyond::from).collect(),
            headroom: programmed.headroom.iter().map(Room::from).collect(),
            rapids_through_stock: engagement.collisions.iter().map(Rapid::from).collect(),
            assumptions: ASSUMPTIONS,
        }
    }
}

/// What there is to say about a cut: line, whether it is an error, sentence.
pub fn cutting_remarks(
    engagement: &Engagement,
    setup: &Setup,
    [programmed, predicted]: &[Loads; 2],
) -> Vec<(u32, bool, String)> {
    let doubted = setup.material.filter(|material| !material.is_checked).map(|material| {
        let text = format!(
            "the coefficients of {} could not be checked against a publication; replace them by measured ones",
            material.name
        );
        (0, false, text)
    });
    let rapids = engagement.collisions.iter().map(|collision| {
        let text = format!("the rapid move goes through {:.1} mm³ of material", collision.removed);
        (collision.line, true, text)
    });
    let beyond = predicted.exceeded.chunk_by(|a, b| a.limit == b.limit).map(|all| {
        let (_, unit, name, convert) = limit_row(all[0].limit);
        let worst = all.iter().max_by(|a, b| a.peak.value.total_cmp(&b.peak.value)).expect("a chunk has one");
        let places = if all.len() == 1 { String::new() } else { format!(", in {} places", all.len()) };
        let text = format!(
            "{name} reaches {} {unit}, {} are allowed{places}",
            short(convert(worst.peak.value)),
            short(convert(worst.allowed)),
        );
        (worst.peak.line, false, text)
    });
    // Where only the programmed feed would be too much, the machine's slowness keeps the tool.
    let spared = programmed.exceeded.chunk_by(|a, b| a.limit == b.limit).filter_map(|all| {
        let is_met = !predicted.exceeded.iter().any(|beyond| beyond.limit == all[0].limit);
        let (_, unit, name, convert) = limit_row(all[0].limit);
        let text = format!(
            "{name} would reach {} {unit} at the programmed feedrate, {} are allowed; the machine runs slower here",
            short(convert(all[0].peak.value)),
            short(convert(all[0].allowed)),
        );
        is_met.then_some((all[0].peak.line, false, text))
    });
    let chips = programmed.at.iter().zip(&engagement.places);
    let thickest =
        chips.max_by(|a, b| a.0.chip.total_cmp(&b.0.chip)).filter(|(load, _)| MOST_CHIP_MM < load.chip);
    let unlikely = thickest.map(|(load, place)| {
        let text = format!(
            "chips in the material would be {} mm thick at the programmed feedrate; no end mill cuts that, and the forces mean \
             nothing: check the speed of the spindle, the feedrate and the number of teeth",
            short(load.chip)
        );
        (place.line, false, text)
    });
    let coarse = predicted.spacing.map(|spacing| {
        let text = format!(
            "the program is long, and its predicted feedrates are taken every {spacing:.3} s: loads of shorter dips are not seen"
        );
        (0, false, text)
    });
    rapids.chain(beyond).chain(spared).chain(doubted).chain(unlikely).chain(coarse).collect()
}

/// Chips thicker than this are a mistake in the job or in the program.
const MOST_CHIP_MM: f64 = 1.0;

/// A number in about three figures.
fn short(value: f64) -> String {
    if value.abs() < 1.0 {
        format!("{value:.4}")
    } else if value.abs() < 100.0 {
        format!("{value:.2}")
    } else {
        format!("{value:.0}")
    }
}

/// Why there are no forces, as a remark.
pub fn cutting_refusal(error: &CuttingError) -> (u32, bool, String) {
    (error.line(), false, error.to_string())
}

/// Peaks of both feedrates, those of each operation, and where there is headroom, for people.
pub fn cutting_table(setup: &Setup, toolpath: &Toolpath, [programmed, predicted]: &[Loads; 2]) -> String {
    let mut text =
        "cutting, largest   force N    line   torque N·m    power W    line   removal cm³/min".to_string();
    for (name, loads) in [("programmed feed", programmed), ("predicted feed", predicted)] {
        write!(
            text,
            "\n{name:16} {:9.1} {:7} {:12.3} {:10.1} {:7} {:17.2}",
            loads.force.value,
            loads.force.line,
            n_m_of_n_mm(loads.torque.value),
            watts_of_n_mm_per_s(loads.power.value),
            loads.power.line,
            1e-3 * mm_per_min(loads.removal_rate.value),
        )
        .expect("writing to a string cannot fail");
    }
    text += "\nby operation      removed cm³    force N    line    power W    line   (predicted feed)";
    for (index, load) in predicted.operations.iter().enumerate() {
        let operation = toolpath.operations.get(index);
        write!(
            text,
            "\n{:16} {:12.3} {:10.1} {:7} {:10.1} {:7}  {}",
            operation.map_or("all".to_string(), |operation| format!("line {}", operation.line.0)),
            1e-3 * load.removed,
            load.force.value,
            load.force.line,
            watts_of_n_mm_per_s(load.power.value),
            load.power.line,
            operation.and_then(|operation| operation.name.as_deref()).unwrap_or(""),
        )
        .expect("writing to a string cannot fail");
        text.truncate(text.trim_end().len());
    }
    for room in programmed.headroom.iter().take(HEADROOM_ROWS) {
        let next = room.limit.map_or(String::new(), |limit| format!(", then {} is met", limit_row(limit).2));
        write!(
            text,
            "\nlines {} to {}: the feedrate of {:.0} mm/min could be {:.2} times as high{next}; saves {:.1} s at most \
             (predicted {:.0} mm/min)",
            room.lines.0,
            room.lines.1,
            mm_per_min(room.feedrate),
            room.factor,
            room.saved(),
            mm_per_min(room.predicted),
        )
        .expect("writing to a string cannot fail");
    }
    let OfMaterial { name, source, .. } = OfMaterial::from(setup);
    write!(text, "\ncoefficients of {name}: {source}\n{ASSUMPTIONS}")
        .expect("writing to a string cannot fail");
    text
}

/// Stretches with headroom that are told people.
const HEADROOM_ROWS: usize = 10;

/// Loads along the path as CSV, one row a place where material is cut.
pub fn loads_csv(engagement: &Engagement, both: &[Loads; 2]) -> String {
    let mut csv = String::from("distance_mm,line,axial_mm,entry_deg,exit_deg,removed_mm3");
    for feed in ["programmed", "predicted"] {
        for column in ["force_n", "torque_nm", "power_w", "removal_rate_mm3_min", "chip_mm"] {
            write!(csv, ",{feed}_{column}").expect("writing to a string cannot fail");
        }
    }
    for (index, place) in engagement.places.iter().enumerate() {
        let sectors = engagement.sectors(place);
        let entry = sectors.first().map_or(0.0, |sector| sector.entry);
        let exit = sectors.last().map_or(0.0, |sector| sector.exit);
        write!(
            csv,
            "\n{:.4},{},{:.4},{:.2},{:.2},{:.5}",
            place.distance,
            place.line,
            engagement.axial(place),
            entry.to_degrees(),
            exit.to_degrees(),
            place.removed
        )
        .expect("writing to a string cannot fail");
        for load in both.iter().map(|loads| &loads.at[index]) {
            write!(
                csv,
                ",{:.3},{:.5},{:.3},{:.2},{:.6}",
                load.force,
                n_m_of_n_mm(load.torque),
                watts_of_n_mm_per_s(load.power),
                mm_per_min(load.removal_rate),
                load.chip
            )
            .expect("writing to a string cannot fail");
        }
    }
    csv.push('\n');
    csv
}
