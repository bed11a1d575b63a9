//! The page: peaks of both sections beside the paper's, and how they depend on what was chosen.

use truefeed::cutting::{Mill, Setup, StockBox, engagement, loads, material, programmed_feedrates};
use truefeed::machine::Machine;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::simulate;
use truefeed::units::mm_per_min;

use super::chart::{Curve, Panel, svg};
use super::path::{CHOICE, Choice, DIAMETER, FEEDRATE, LENGTH, WIDTH, part};

/// Contour tolerance, mm.
const TOLERANCE: f64 = 0.010;

/// Helix of the tool, degrees.
const HELIX: f64 = 30.0;

/// Side of a cell of the stock, mm.
const RESOLUTION: f64 = 0.1;

/// The paper's peaks of a section, N: by the programmed and the predicted feedrate, and measured,
/// from the errors it gives.
#[derive(Clone, Copy)]
pub struct Published {
    pub programmed: f64,
    pub predicted: f64,
    pub measured: f64,
}

pub const TROCHOID: Published = Published { programmed: 673.0, predicted: 380.0, measured: 343.0 };
pub const CORNERS: Published = Published { programmed: 821.0, predicted: 656.0, measured: 598.0 };

/// The load along a section.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// Largest force at the programmed and at the predicted feedrate, N.
    pub programmed: f64,
    pub predicted: f64,
    /// Predicted feedrate at the latter, mm/min.
    pub feedrate: f64,
    /// Largest power at both, W.
    pub power: [f64; 2],
    /// Volume removed, mm³.
    pub removed: f64,
    /// Distance along the path (mm) and force at both feedrates (N).
    points: Vec<(f64, [f64; 2])>,
}

impl Section {
    /// How far the programmed feedrate's peak is above the other.
    pub fn ratio(&self) -> f64 {
        self.programmed / self.predicted
    }
}

/// The case study at one choice.
pub struct Case {
    pub trochoid: Section,
    pub corners: Section,
    /// Length of all feed moves, mm.
    pub length: f64,
    /// Predicted and programmed time of these, s.
    pub time: f64,
}

/// Computes the case study.
pub fn case(choice: &Choice) -> Case {
    let part = part(choice);
    let machine = Machine::default();
    let toolpath = trace(&read(part.program.as_bytes()), &machine);
    let (plan, _) = simulate::within(&toolpath, &machine, TOLERANCE, &mut |_| {});
    let curve = Profile::new(&toolpath, &plan).feed_curve(Resolution::FINE);
    let tool =
        Mill { diameter: Some(DIAMETER), teeth: Some(2), helix: HELIX.to_radians(), ..Mill::default() };
    let setup = Setup {
        stock: Some(StockBox { min: [-10.0, 0.0, -20.0], max: [WIDTH + 10.0, LENGTH + 10.0, 0.0] }),
        resolution: Some(RESOLUTION),
        coefficients: material(choice.material).map(|material| material.coefficients),
        tool: Some(tool),
        ..Setup::default()
    };
    let cut = engagement(&toolpath, &setup).expect("all is given");
    let predicted = curve.feedrates_at(cut.distances());
    let feedrates = [programmed_feedrates(&cut, &toolpath), predicted];
    let both = loads(&cut, &toolpath, &setup, &[&feedrates[0], &feedrates[1]]).expect("all is given");
    let section = |(first, last): (u32, u32)| {
        let mut section = Section::default();
        for (index, place) in cut.places.iter().enumerate() {
            if place.line < first || last < place.line {
                continue;
            }
            let [programmed, predicted] = [0, 1].map(|which: usize| &both[which].at[index]);
            section.programmed = section.programmed.max(programmed.force);
            if section.predicted < predicted.force {
                section.predicted = predicted.force;
                section.feedrate = mm_per_min(feedrates[1][index]);
            }
            for (largest, load) in section.power.iter_mut().zip([programmed, predicted]) {
                *largest = largest.max(1e-3 * load.power);
            }
            section.removed += place.removed;
            section.points.push((place.distance, [programmed.force, predicted.force]));
        }
        section
    };
    let feeds = toolpath.segments.iter().filter(|segment| !segment.motion.is_rapid());
    Case {
        trochoid: section(part.trochoid),
        corners: section(part.corners),
        length: feeds.map(|segment| segment.length).sum(),
        time: plan.cycle_time(),
    }
}

/// The page, its picture, and the case at the choice.
pub struct Page {
    pub text: String,
    pub picture: String,
    pub case: Case,
}

/// Computes and writes the page.
pub fn page() -> Page {
    let case = case(&CHOICE);
    let text = HEAD.to_string() + &chosen() + &peaks(&case) + &variants(&case) + FOOT;
    Page { text, picture: picture(&case), case }
}

const HEAD: &str = "# Cutting forces from the predicted feed

Section 4.3 of Ward, Sencer, Jones, Ozturk (2021), computed again: an open pocket of 40 × 60 × 10 mm in aluminium 7075, a 2-flute end
mill of 12 mm, 3000 mm/min, 10 µm. `cargo run --release --example forces` writes this page; `tests/forces_page.rs` compares it
with what the program computes.

Force means the largest resultant within a revolution. The same engagement is loaded twice, with the programmed feedrate and with the
predicted one (three filters, T1 = 0.0255 s, tolerance by the law of an isolated corner).

";

fn chosen() -> String {
    let material = material(CHOICE.material).expect("it is known");
    let [tc, rc, ac] = material.coefficients.cutting;
    let [te, re, ae] = material.coefficients.edge;
    format!(
        "## What was chosen\n\nThe paper gives no depth, spindle speed, coefficients or path. We chose:\n\n\
         - coefficients of {}: K_tc {tc}, K_rc {rc}, K_ac {ac} N/mm², K_te {te}, K_re {re}, K_ae {ae} N/mm;\n  {};\n\
         - depth {:.0} mm, half of the pocket, and {:.0} rpm (300 m/min); helix {HELIX:.0}°, no run-out;\n\
         - trochoid: loops of radius {:.0} mm, {:.1} mm further on each time, climbing, in chords that turn by {:.0}°, along the left side, the end\n  \
         and the right side; they leave {:.1} mm at the walls;\n\
         - cornering section: one pass along the walls, corners of radius {:.0} mm in chords that turn by {:.0}°;\n\
         - stock in cells of {RESOLUTION} mm.\n\n\
         The paper does not publish the depth, the speed, the path or the move from one loop to the next. We tried many values and\n\
         chose these knowing the paper's forces and ratios, so the agreement proves little. We did not choose the coefficients\n\
         that way. The last table shows how the ratios depend on the choice.\n\n",
        material.name,
        material.source,
        CHOICE.depth,
        CHOICE.speed,
        CHOICE.loops,
        CHOICE.pitch,
        CHOICE.chord,
        CHOICE.allowance,
        CHOICE.corner,
        CHOICE.corner_chord,
    )
}

fn peaks(case: &Case) -> String {
    let mut text = "## Peaks\n\n\
        | section | programmed feed N | predicted feed N | ratio | paper, programmed N | paper, predicted N | paper, ratio | paper, measured N |\n\
        |---|---:|---:|---:|---:|---:|---:|---:|\n"
        .to_string();
    for (name, ours, paper) in [("trochoid", &case.trochoid, TROCHOID), ("cornering", &case.corners, CORNERS)]
    {
        text += &format!(
            "| {name} | {:.0} | {:.0} | {:.2} | {:.0} | {:.0} | {:.2} | {:.0} |\n",
            ours.programmed,
            ours.predicted,
            ours.ratio(),
            paper.programmed,
            paper.predicted,
            paper.programmed / paper.predicted,
            paper.measured,
        );
    }
    text + &format!(
        "\nIn the trochoid the feedrate at the peak is {:.0} of {FEEDRATE:.0} mm/min; the force falls by less than the feedrate, because rubbing of the\n\
         edges does not depend on it. Along the walls the tool is at {:.0} mm/min where the engagement is largest, just where a corner begins.\n\n\
         | section | removed cm³ | peak power, programmed W | peak power, predicted W |\n|---|---:|---:|---:|\n\
         | trochoid | {:.2} | {:.0} | {:.0} |\n| cornering | {:.2} | {:.0} | {:.0} |\n\n\
         Path in feed {:.0} mm, predicted time {:.0} s, at the programmed feedrate {:.0} s.\n\n\
         ![Force along the path](forces.svg)\n\n\
         **Force along the path.** Left two loops of the trochoid, right the first corner.\n\n",
        case.trochoid.feedrate,
        case.corners.feedrate,
        1e-3 * case.trochoid.removed,
        case.trochoid.power[0],
        case.trochoid.power[1],
        1e-3 * case.corners.removed,
        case.corners.power[0],
        case.corners.power[1],
        case.length,
        case.time,
        60.0 * case.length / FEEDRATE,
    )
}

fn variants(base: &Case) -> String {
    let others: [(&str, Choice); 9] = [
        ("depth 10 mm", Choice { depth: 10.0, ..CHOICE }),
        ("depth 2.5 mm", Choice { depth: 2.5, ..CHOICE }),
        ("12000 rpm", Choice { speed: 12000.0, ..CHOICE }),
        ("2 mm from loop to loop", Choice { pitch: 2.0, ..CHOICE }),
        ("chords of 8° in the loops", Choice { chord: 8.0, ..CHOICE }),
        ("chords of 4° in the loops", Choice { chord: 4.0, ..CHOICE }),
        ("corners of radius 6 mm", Choice { corner: 6.0, ..CHOICE }),
        ("0.5 mm left at the walls", Choice { allowance: 0.5, ..CHOICE }),
        ("the other coefficients of 7075", Choice { material: "al7075-sharp", ..CHOICE }),
    ];
    let row = |name: &str, case: &Case| {
        let (trochoid, corners) = (&case.trochoid, &case.corners);
        format!(
            "| {name} | {:.0} | {:.0} | {:.2} | {:.0} | {:.0} | {:.2} |\n",
            trochoid.programmed,
            trochoid.predicted,
            trochoid.ratio(),
            corners.programmed,
            corners.predicted,
            corners.ratio()
        )
    };
    let rows: String = others.iter().map(|(name, choice)| row(name, &case(choice))).collect();
    "## Other choices\n\nOne thing changed at a time; forces in N by the programmed and the predicted feedrate, and their ratio.\n\n\
     | changed | trochoid, programmed | predicted | ratio | cornering, programmed | predicted | ratio |\n|---|---:|---:|---:|---:|---:|---:|\n"
        .to_string()
        + &row("nothing", base)
        + &rows
        + "\n"
}

const FOOT: &str = "The paper's ratios are 1.77 and 1.25. The ratio of the trochoid depends most on the chords, which set the feedrate on the loops, and on
how much of the force is rubbing; that of the cornering section on where the largest engagement meets the slowing down.
";

fn picture(case: &Case) -> String {
    let panel = |title: &str, section: &Section, from: f64, length: f64| {
        let points: Vec<_> =
            section.points.iter().filter(|(distance, _)| (from..from + length).contains(distance)).collect();
        let curve = |name: &str, which: usize| Curve {
            name: name.to_string(),
            points: points.iter().map(|(distance, forces)| (*distance, forces[which])).collect(),
        };
        Panel {
            title: title.to_string(),
            x: "distance mm",
            y: "force N",
            curves: vec![curve("programmed feed", 0), curve("predicted feed", 1)],
        }
    };
    let middle = case.trochoid.points[case.trochoid.points.len() / 4].0;
    let peak = case.corners.points.iter().max_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    let corner = peak.map_or(0.0, |(distance, _)| *distance);
    svg(
        &[
            panel("Trochoid", &case.trochoid, middle, 65.0),
            panel("Cornering", &case.corners, corner - 15.0, 30.0),
        ],
        2,
    )
}
