//! Cases of a benchmark: a program, the machine file one believes in, a recording, and the sealed answer.
//!
//! Everything follows from the seed. Case numbers are shuffled over the strata, so that a number says
//! nothing. `answers.json` tells of each case what was concealed, its parameters in the names of the
//! diagnosis, its strength, and the lines whose duration it changed (−1: everywhere).
//!
//! Where what is concealed belongs to the machine, and not to an operator, a recorder or one line, the case
//! has a second program in `transfer/`: the same machine on another part at twice the tolerance. Nobody is
//! fitted to it; it shows what an explanation is worth where it was not found.

use std::path::Path;

use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

use crate::effects::{
    ALL_OR_NOTHING, LIBRARY, OUTSIDE, WRONG_PROGRAM, acts_everywhere, belongs_to_machine, conceal,
};
use crate::physics::{Motion, Physics};
use crate::random::Random;
use crate::reader::{Step, read};
use crate::recorder::Recorder;
use crate::{drive, fir, planner, program};

/// How many cases of each stratum.
#[derive(Clone, Debug)]
pub struct Counts {
    pub singles: usize,
    pub negatives: usize,
    pub doubles: usize,
    pub outside: usize,
    pub ambiguous: usize,
    /// Machines of another family, whose planner is not FIR.
    pub planners: usize,
}

/// One case, as it is written.
pub struct Case {
    pub program: String,
    pub machine: String,
    pub recording: String,
    pub answer: Value,
    /// Another program on the same machine, at [`TRANSFER`] times the tolerance, and its recording.
    pub transfer: Option<(String, String)>,
}

/// The tolerance of the second program, in multiples of the first one's.
const TRANSFER: f64 = 2.0;

/// All cases of a seed.
pub fn cases(seed: u64, counts: &Counts) -> Vec<Case> {
    let single = |i: usize| {
        let id = if i % 24 < 23 { LIBRARY[i % 24] } else { WRONG_PROGRAM };
        ("single", vec![id])
    };
    let mut wanted: Vec<(&str, Vec<&str>)> = (0..counts.singles).map(single).collect();
    wanted.extend((0..counts.negatives).map(|_| ("negative", vec![])));
    let mut random = Random::new(seed, 0);
    let filters = |id: &str| id.contains("filter");
    for _ in 0..counts.doubles {
        let first = random.below(LIBRARY.len());
        let mut second = (first + 1 + random.below(LIBRARY.len() - 1)) % LIBRARY.len();
        // Two statements about the filters contradict each other, and all of theirs stand together.
        while second == first || filters(LIBRARY[first]) && filters(LIBRARY[second]) {
            second = (second + 1) % LIBRARY.len();
        }
        wanted.push(("double", vec![LIBRARY[first], LIBRARY[second]]));
    }
    wanted.extend((0..counts.outside).map(|i| ("outside", vec![OUTSIDE[i % OUTSIDE.len()]])));
    for i in 0..counts.ambiguous {
        let alike = program::AMBIGUOUS[i % program::AMBIGUOUS.len()];
        wanted.push(("ambiguous", vec![random.pick(alike)]));
    }
    wanted.extend((0..counts.planners).map(|_| ("planner", vec![])));
    for i in (1..wanted.len()).rev() {
        wanted.swap(i, random.below(i + 1));
    }
    let draw = |(i, (stratum, ids)): (usize, &(&str, Vec<&str>))| {
        (0..100).find_map(|attempt| {
            case(stratum, ids, i + 1, &mut Random::new(seed, 1 + i as u64 * 1000 + attempt))
        })
    };
    wanted.iter().enumerate().filter_map(draw).collect()
}

/// What a machine does with a program, and the machine file that believes in its base.
struct Machine {
    physics: Physics,
    planner: bool,
}

impl Machine {
    fn run(&self, steps: &[Step]) -> Motion {
        let mut motion = if self.planner {
            planner::command(steps, &self.physics)
        } else {
            fir::command(steps, &self.physics)
        };
        drive::drive(&mut motion.position, &self.physics.drive);
        motion
    }
}

/// One case, or nothing where the program drawn does not show the effect.
fn case(stratum: &str, ids: &[&str], number: usize, random: &mut Random) -> Option<Case> {
    let (text, families) = match stratum {
        "ambiguous" => (program::one_axis(random), vec!["one axis"]),
        _ => program::draw(random),
    };
    let steps = read(&text);
    let constant = (random.uniform(0.018, 0.032) * 1e4).round() / 1e4;
    let base = Physics::base(3, constant, random.pick(&[0.01, 0.02, 0.05]));
    let machine = machine_file(&format!("case {number}"), &base);
    let mut truth = base.clone();
    let drawn = random.log_uniform(0.3, 10.0);
    let strength = match stratum {
        // A weak effect is nothing to be in two minds about.
        "ambiguous" => drawn.max(2.0),
        _ if ids.iter().any(|id| ALL_OR_NOTHING.contains(id)) => 10.0,
        _ => drawn,
    };
    let (mut effects, mut lines, mut shown) = (Map::new(), Map::new(), text.clone());
    let planner = stratum == "planner";
    let clean = Machine { physics: base.clone(), planner: false }.run(&steps);
    let mut accepted = alike(stratum, ids);
    if planner {
        let a = random.log_uniform(600.0, 1500.0);
        truth.axis_acceleration = [a; 3];
        truth.jerk = random.log_uniform(1e4, 5e4);
        effects.insert("axis_acceleration_limit".into(), json!({"axis": "XYZ", "a_mm_s2": a}));
        effects.insert("jerk_limit".into(), json!({"j_mm_s3": truth.jerk}));
        accepted = vec!["axis_acceleration_limit", "path_acceleration_limit", "jerk_limit"];
    }
    for id in ids {
        // Each by itself beside the truth, with the same draws, so that two effects keep their own lines.
        let (mut alone, mut again) = (base.clone(), random.clone());
        if *id == WRONG_PROGRAM {
            shown = program::draw(random).0;
            effects.insert((*id).into(), json!({}));
        } else {
            effects.insert((*id).into(), conceal(id, strength, &steps, &mut truth, random)?);
            conceal(id, strength, &steps, &mut alone, &mut again)?;
        }
        if stratum == "ambiguous" && *id == "feed_override" {
            // Only a slower feed is like a limit, and only on every line.
            truth.feed_override = (1.0 / (1.0 + 0.02 * strength), 1, u32::MAX);
            alone = truth.clone();
            effects[*id] = json!({"ratio": truth.feed_override.0});
        }
        let everywhere = acts_everywhere(id);
        let own = acted(&clean, &Machine { physics: alone, planner: false }.run(&steps));
        if own.is_empty() && !everywhere {
            return None;
        }
        lines.insert((*id).into(), if everywhere { json!([-1]) } else { json!(own) });
    }
    let machine_of_truth = Machine { physics: truth, planner };
    let motion = machine_of_truth.run(&steps);
    if motion.cycle_time > 240.0 {
        return None;
    }
    let recorder = Recorder::draw(random);
    let recording = recorder.record(&motion, machine_of_truth.physics.clock, random);
    let mut answer = json!({
        "stratum": stratum, "strength": strength, "effects": effects, "lines": lines,
        "accepted": accepted,
        "clean_s": thousandths(clean.cycle_time), "true_s": thousandths(motion.cycle_time),
        "rate_hz": recorder.rate.round(), "sections": families,
    });
    let transfer = (stratum != "outside" && ids.iter().all(|id| belongs_to_machine(id))).then(|| {
        let (text, _) = program::draw(random);
        let mut machine = machine_of_truth;
        machine.physics.tolerance *= TRANSFER;
        let motion = machine.run(&read(&text));
        answer["transfer"] = json!({"tolerance": TRANSFER, "true_s": thousandths(motion.cycle_time)});
        (text, Recorder::ideal().record(&motion, 1.0, random))
    });
    Some(Case { program: shown, machine, recording, answer, transfer })
}

/// The causes that the program cannot tell apart, where that is by design.
fn alike(stratum: &str, ids: &[&str]) -> Vec<&'static str> {
    let alike =
        program::AMBIGUOUS.iter().find(|set| stratum == "ambiguous" && ids.iter().all(|id| set.contains(id)));
    alike.map_or(vec![], |set| set.to_vec())
}

fn thousandths(seconds: f64) -> f64 {
    (seconds * 1e3).round() / 1e3
}

/// The lines whose duration differs by more than a fifth of a millisecond.
fn acted(clean: &Motion, real: &Motion) -> Vec<u32> {
    let of = |motion: &Motion, line: u32| motion.line_seconds.get(&line).copied().unwrap_or(0.0);
    let lines = real.line_seconds.keys().copied();
    lines.filter(|line| 2e-4 < (of(clean, *line) - of(real, *line)).abs()).collect()
}

/// The machine file that believes in the base, in which arcs are driven whole.
pub fn machine_file(name: &str, base: &Physics) -> String {
    let (filters, constant) = (base.boxes.len(), base.boxes[0]);
    format!(
        "name = \"{name}\"\n\n[interpolator]\nfilters = {filters}\ntime_constant_s = {constant}\n\
         contour_tolerance_mm = {}\narc_step_deg = 3600\n\n[rapid]\nfeed_mm_min = {}\n\n[times]\ntool_change_s = {:.1}\n",
        base.tolerance,
        60.0 * base.rapid,
        base.tool_change
    )
}

/// Writes all cases below `folder`, and the seal: the SHA-256 of the answers.
pub fn write(cases: &[Case], folder: &Path) -> std::io::Result<String> {
    let mut answers = Map::new();
    for (number, case) in (1..).zip(cases) {
        let name = format!("case-{number:02}");
        let place = folder.join(&name);
        std::fs::create_dir_all(&place)?;
        std::fs::write(place.join("program.nc"), &case.program)?;
        std::fs::write(place.join("machine.toml"), &case.machine)?;
        std::fs::write(place.join("recording.csv"), &case.recording)?;
        if let Some((program, recording)) = &case.transfer {
            let place = place.join("transfer");
            std::fs::create_dir_all(&place)?;
            std::fs::write(place.join("program.nc"), program)?;
            std::fs::write(place.join("recording.csv"), recording)?;
        }
        answers.insert(name, case.answer.clone());
    }
    let answers = serde_json::to_string_pretty(&answers)? + "\n";
    let seal: String = Sha256::digest(answers.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
    std::fs::write(folder.join("answers.json"), answers)?;
    std::fs::write(folder.join("sealed.txt"), format!("{seal}  answers.json\n"))?;
    Ok(seal)
}

/// The pair that the page brings along: a feed override from a line on, recorded at 50 Hz.
pub fn sample() -> Case {
    let mut random = Random::new(2021, 7);
    let program = program::write(&["rect", "zigzag", "drill", "arcs"], &mut random);
    let steps = read(&program);
    let base = Physics::base(3, 0.0255, 0.02);
    let cuts: Vec<u32> = steps
        .iter()
        .filter_map(|step| match step {
            Step::Move { line, rapid: false, .. } => Some(*line),
            _ => None,
        })
        .collect();
    let mut truth = base.clone();
    truth.feed_override = (0.78, cuts[cuts.len() / 3], cuts[cuts.len() - 1]);
    let (ratio, from, to) = truth.feed_override;
    let motion = Machine { physics: truth, planner: false }.run(&steps);
    let clean = Machine { physics: base.clone(), planner: false }.run(&steps);
    let recorder = Recorder {
        rate: 50.0,
        lead: 0.7,
        jitter: 2e-4,
        noise: 3e-4,
        quantum: 1e-3,
        drift: 0.0,
        gaps: 0,
        lines: false,
    };
    Case {
        recording: recorder.record(&motion, 1.0, &mut random),
        machine: machine_file("stand-in machine", &base),
        answer: json!({
            "effects": {"feed_override": {"ratio": ratio, "from_line": from, "to_line": to}},
            "clean_s": thousandths(clean.cycle_time), "true_s": thousandths(motion.cycle_time),
        }),
        program,
        transfer: None,
    }
}
