//! Cutting forces as text: the part of `predict` for a cutting job.

use std::fmt::Write;

use serde::Serialize;

use crate::cutting::{
    Collision, CuttingError, Engagement, ExceededLimit, Headroom, LimitKind, LoadCurve, MATERIALS,
    OperationLoad, Peak, Setup,
};
use crate::simulation::toolpath::Toolpath;
use crate::units::{mm_per_min, n_m_of_n_mm, watts_of_n_mm_per_s};

/// The demands of the cut on tool and spindle at one tolerance.
#[derive(Clone, Debug, Serialize)]
pub(in crate::project) struct Cutting {
    /// Side of a cell of the stock.
    resolution_mm: f64,
    /// Material of the forces.
    material: MaterialRow,
    /// Largest loads at the programmed feedrate.
    programmed: PeakRows,
    /// At the predicted feedrate.
    predicted: PeakRows,
    /// Parts of the path where limits are exceeded at the predicted feedrate.
    exceeded: Vec<ExceededRow>,
    /// Parts of the path where the programmed feedrate could be higher, the largest saving first.
    headroom: Vec<HeadroomRow>,
    /// Rapid moves through material.
    rapids_through_stock: Vec<CollisionRow>,
    /// Assumptions of the model.
    assumptions: &'static str,
}

const ASSUMPTIONS: &str = "force is the largest resultant within a revolution, power the mean; engagement on the programmed path in a height map; linear edge force model with a stiff tool, without cutting at the bottom";

/// A material: its coefficients, in N/mm² and N/mm, and their source.
#[derive(Clone, Debug, Serialize)]
struct MaterialRow {
    name: &'static str,
    source: &'static str,
    /// `true` if the numbers were compared with the source.
    is_checked: bool,
    /// Cutting coefficients K_tc, K_rc, K_ac.
    cutting_n_mm2: [f64; 3],
    /// Edge coefficients K_te, K_re, K_ae.
    edge_n_mm: [f64; 3],
}

/// A material to choose.
#[derive(Serialize)]
struct MaterialChoice {
    word: &'static str,
    #[serde(flatten)]
    about: MaterialRow,
}

/// Returns all materials with their coefficients and sources, as JSON.
pub fn materials_json() -> String {
    let all = MATERIALS.map(|material| {
        let of = Setup {
            coefficients: Some(material.coefficients),
            material: crate::cutting::material(material.word),
            ..Setup::default()
        };
        MaterialChoice { word: material.word, about: MaterialRow::from(&of) }
    });
    serde_json::to_string(&all).expect("plain structures can be serialized")
}

impl From<&Setup> for MaterialRow {
    fn from(setup: &Setup) -> MaterialRow {
        let coefficients = setup.coefficients.unwrap_or_default();
        let (name, source, is_checked) = match setup.material {
            Some(material) => (material.name, material.source, material.is_checked),
            None => ("your own material", "the cutting job", true),
        };
        let (cutting_n_mm2, edge_n_mm) = (coefficients.cutting, coefficients.edge);
        MaterialRow { name, source, is_checked, cutting_n_mm2, edge_n_mm }
    }
}

/// A part of the path where the feedrate could be higher.
#[derive(Clone, Debug, Serialize)]
struct HeadroomRow {
    lines: [u32; 2],
    distance_mm: [f64; 2],
    cut_mm: f64,
    programmed_mm_min: f64,
    predicted_mm_min: f64,
    factor: f64,
    /// The limit that the next factor would exceed; null if there is none.
    limit: Option<&'static str>,
    /// Time saved if the machine reached both feedrates.
    saved_s: f64,
}

impl From<&Headroom> for HeadroomRow {
    fn from(room: &Headroom) -> HeadroomRow {
        HeadroomRow {
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

/// Largest values of the loads.
#[derive(Clone, Debug, Serialize)]
struct PeakRows {
    force_n: LocatedValue,
    torque_nm: LocatedValue,
    power_w: LocatedValue,
    removal_rate_mm3_min: LocatedValue,
}

/// A value with its place.
#[derive(Clone, Debug, Serialize)]
struct LocatedValue {
    value: f64,
    line: u32,
    distance_mm: f64,
}

#[derive(Clone, Debug, Serialize)]
struct ExceededRow {
    /// tool_force, tool_torque, tool_power, tool_chip, tool_deflection, spindle_force, spindle_torque or spindle_power.
    limit: &'static str,
    unit: &'static str,
    allowed: f64,
    largest: LocatedValue,
    lines: [u32; 2],
}

#[derive(Clone, Debug, Serialize)]
struct CollisionRow {
    line: u32,
    distance_mm: f64,
    removed_mm3: f64,
}

/// The demands of an operation on tool and spindle.
#[derive(Clone, Debug, Serialize)]
pub(in crate::project) struct OperationLoadRow {
    removed_mm3: f64,
    /// At the predicted feedrate.
    peak_power_w: LocatedValue,
    /// At the predicted feedrate.
    peak_force_n: LocatedValue,
}

fn at(peak: &Peak, convert: impl Fn(f64) -> f64) -> LocatedValue {
    LocatedValue { value: convert(peak.value), line: peak.line, distance_mm: peak.distance }
}

impl From<&LoadCurve> for PeakRows {
    fn from(loads: &LoadCurve) -> PeakRows {
        PeakRows {
            force_n: at(&loads.force, |force| force),
            torque_nm: at(&loads.torque, n_m_of_n_mm),
            power_w: at(&loads.power, watts_of_n_mm_per_s),
            // Converted like a feedrate times an area.
            removal_rate_mm3_min: at(&loads.removal_rate, mm_per_min),
        }
    }
}

impl From<&OperationLoad> for OperationLoadRow {
    fn from(load: &OperationLoad) -> OperationLoadRow {
        OperationLoadRow {
            removed_mm3: load.removed,
            peak_power_w: at(&load.power, watts_of_n_mm_per_s),
            peak_force_n: at(&load.force, |force| force),
        }
    }
}

/// Returns keyword, unit and name of a limit, and the conversion to its unit.
fn limit_row(limit: LimitKind) -> (&'static str, &'static str, &'static str, fn(f64) -> f64) {
    let same: fn(f64) -> f64 = |force| force;
    match limit {
        LimitKind::ToolForce => ("tool_force", "N", "force on the tool", same),
        LimitKind::ToolTorque => ("tool_torque", "N·m", "torque on the tool", n_m_of_n_mm),
        LimitKind::ToolPower => ("tool_power", "W", "power through the tool", watts_of_n_mm_per_s),
        LimitKind::ToolChip => ("tool_chip", "mm", "thickness of a chip", same),
        LimitKind::ToolDeflection => ("tool_deflection", "mm", "bending of the tool", same),
        LimitKind::SpindleForce => ("spindle_force", "N", "force on the spindle", same),
        LimitKind::SpindleTorque => ("spindle_torque", "N·m", "torque of the spindle", n_m_of_n_mm),
        LimitKind::SpindlePower => ("spindle_power", "W", "power of the spindle", watts_of_n_mm_per_s),
    }
}

impl From<&ExceededLimit> for ExceededRow {
    fn from(exceeded: &ExceededLimit) -> ExceededRow {
        let (limit, unit, _, convert) = limit_row(exceeded.limit);
        ExceededRow {
            limit,
            unit,
            allowed: convert(exceeded.allowed),
            largest: at(&exceeded.peak, convert),
            lines: [exceeded.lines.0, exceeded.lines.1],
        }
    }
}

impl From<&Collision> for CollisionRow {
    fn from(collision: &Collision) -> CollisionRow {
        let Collision { line, distance, removed, .. } = *collision;
        CollisionRow { line, distance_mm: distance, removed_mm3: removed }
    }
}

impl Cutting {
    /// Returns the programmed and predicted loads of an engagement.
    pub(in crate::project) fn new(
        engagement: &Engagement,
        setup: &Setup,
        [programmed, predicted]: &[LoadCurve; 2],
    ) -> Cutting {
        Cutting {
            resolution_mm: engagement.resolution,
            material: MaterialRow::from(setup),
            programmed: PeakRows::from(programmed),
            predicted: PeakRows::from(predicted),
            exceeded: predicted.exceeded.iter().map(ExceededRow::from).collect(),
            headroom: programmed.headroom.iter().map(HeadroomRow::from).collect(),
            rapids_through_stock: engagement.collisions.iter().map(CollisionRow::from).collect(),
            assumptions: ASSUMPTIONS,
        }
    }
}

/// Returns the remarks on a cut: line, `true` for an error, sentence.
pub fn cutting_remarks(
    engagement: &Engagement,
    setup: &Setup,
    [programmed, predicted]: &[LoadCurve; 2],
) -> Vec<(u32, bool, String)> {
    let doubted = setup.material.filter(|material| !material.is_checked).map(|material| {
        let text = format!(
            "the coefficients of {} are not checked against a publication; replace them with measured ones",
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
            "{name} reaches {} {unit}, the limit is {}{places}",
            short(convert(worst.peak.value)),
            short(convert(worst.allowed)),
        );
        (worst.peak.line, false, text)
    });
    // If a limit is exceeded only at the programmed feedrate, the tool is safe because the machine runs more
    // slowly.
    let spared = programmed.exceeded.chunk_by(|a, b| a.limit == b.limit).filter_map(|all| {
        let is_met = !predicted.exceeded.iter().any(|beyond| beyond.limit == all[0].limit);
        let (_, unit, name, convert) = limit_row(all[0].limit);
        let text = format!(
            "{name} would reach {} {unit} at the programmed feedrate, the limit is {}; the machine runs slower here",
            short(convert(all[0].peak.value)),
            short(convert(all[0].allowed)),
        );
        is_met.then_some((all[0].peak.line, false, text))
    });
    let chips = programmed.at.iter().zip(&engagement.places);
    let thickest =
        chips.max_by(|a, b| a.0.chip.total_cmp(&b.0.chip)).filter(|(load, _)| MAX_CHIP_MM < load.chip);
    let unlikely = thickest.map(|(load, place)| {
        let text = format!(
            "chips would be {} mm thick at the programmed feedrate; no end mill cuts that, so the forces mean nothing: check spindle speed, feedrate and number of teeth",
            short(load.chip)
        );
        (place.line, false, text)
    });
    let coarse = predicted.spacing.map(|spacing| {
        let text = format!(
            "the program is long, so loads use the predicted feedrate every {spacing:.3} s and miss shorter dips"
        );
        (0, false, text)
    });
    rapids.chain(beyond).chain(spared).chain(doubted).chain(unlikely).chain(coarse).collect()
}

/// Thickest plausible chip, mm: a thicker one indicates a mistake in the job or in the program.
const MAX_CHIP_MM: f64 = 1.0;

/// Formats a number with about three significant digits.
fn short(value: f64) -> String {
    if value.abs() < 1.0 {
        format!("{value:.4}")
    } else if value.abs() < 100.0 {
        format!("{value:.2}")
    } else {
        format!("{value:.0}")
    }
}

/// Returns the reason for missing forces as a remark: line, `true` for an error, sentence.
pub fn cutting_refusal(error: &CuttingError) -> (u32, bool, String) {
    (error.line(), false, error.to_string())
}

/// Returns the peaks at both feedrates, those of each operation, and the headroom, for people.
pub fn cutting_table(setup: &Setup, toolpath: &Toolpath, [programmed, predicted]: &[LoadCurve; 2]) -> String {
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
    let MaterialRow { name, source, .. } = MaterialRow::from(setup);
    write!(text, "\ncoefficients of {name}: {source}\n{ASSUMPTIONS}")
        .expect("writing to a string cannot fail");
    text
}

/// Most rows of headroom in the table.
const HEADROOM_ROWS: usize = 10;

/// Returns the loads along the path as CSV, one row per place where material is cut.
pub fn loads_csv(engagement: &Engagement, both: &[LoadCurve; 2]) -> String {
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
