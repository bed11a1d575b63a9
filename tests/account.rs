//! The account of a diagnosis adds up, whatever acts together; and what the command prints of it does to the hundredth.

use std::process::Command;

use serde_json::Value;
use truefeed::identification::comparison::{Comparison, compare};
use truefeed::identification::diagnosis::{Account, Candidate, Steps, accounts};
use truefeed::identification::effects::{Hypothesis, library};
use truefeed::identification::fit::{AlignedRun, Run};
use truefeed::machine::{Machine, TimeConstants};
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;

use crate::linuxcnc_runs::MACHINE;
use crate::sceptic::{csv, machine, program, recorded};
use crate::shared::{case_count, corpus, seed_offset};

/// Causes by which a machine is slower wherever they act, or faster wherever they act, whatever else does. A longer
/// filter is none of them: where accelerations are limited behind the filters it may save time.
const OF_ONE_SIGN: [&str; 8] = [
    "axis_acceleration_limit",
    "path_acceleration_limit",
    "axis_velocity_limit",
    "in_position_wait",
    "feed_override",
    "rapid_override",
    "unmodelled_wait",
    "recorder_clock",
];
/// Rounding of the sums of a run that lasts minutes, s.
const ROUNDING_S: f64 = 1e-8;
/// Largest time that a cause may save beside other causes although it costs time alone, or the other way round, s. A limit
/// that has next to no effect still moves the beginning of a ramp. The least time that a diagnosis names is 15 times that.
const MAX_SIGN_REVERSAL_S: f64 = 1e-3;

/// Numbers from 0 to below 1.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / 53f64.exp2()
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }
}

/// A program that is another one each time, with rapids, an arc and a function.
fn some_program(random: &mut Random) -> String {
    let mut text = String::from("G21 G90 G94\nG0 X0 Y0 Z25\nM8\nG1 Z-1 F600\n");
    for _ in 0..12 {
        let (x, y) = (random.between(-40.0, 40.0), random.between(-30.0, 30.0));
        text += &format!("G1 X{x:.3} Y{y:.3} F{:.0}\n", random.between(600.0, 4000.0));
    }
    text + "G0 Z5\nG0 X0 Y0\nG1 Z-1 F900\nG2 X12 Y0 I6 J0 F2400\nG0 Z20\nM30\n"
}

fn some_machine(random: &mut Random) -> Machine {
    let mut machine = machine();
    machine.interpolator.time_constants = TimeConstants::Equal(random.between(0.005, 0.04));
    machine.interpolator.contour_tolerance = random.between(0.005, 0.05);
    machine.rapid.feedrate = random.between(50.0, 300.0);
    machine
}

/// A recording of a program on a machine, by the recorder's clock of that machine, laid on the program.
fn laid(text: &str, truth: &Machine, believed: &Machine) -> AlignedRun {
    let mut rows = recorded(text, truth, 100.0);
    rows.iter_mut().for_each(|row| row[0] *= truth.recorder.clock_ratio);
    let toolpath = trace(&read(text.as_bytes()), believed);
    AlignedRun::new(toolpath, csv(&rows).as_bytes(), believed).expect("it is of this program")
}

/// A number of hypotheses of different effects, at values that were tried first and are not far from believed.
fn some_causes(
    believed: &Machine,
    library: &[Hypothesis],
    count: usize,
    random: &mut Random,
) -> Vec<Candidate> {
    let mut causes: Vec<Candidate> = Vec::new();
    // Blends of another family of controls leave the path, on which the recordings here are.
    let keeps_to_the_path = |hypothesis: &Hypothesis| {
        hypothesis.machine(believed, &hypothesis.trials[0]).interpolator.junction
            == believed.interpolator.junction
    };
    let open: Vec<&Hypothesis> = (library.iter())
        .filter(|hypothesis| OF_ONE_SIGN.contains(&hypothesis.effect.id) && keeps_to_the_path(hypothesis))
        .collect();
    while causes.len() < count {
        let hypothesis = open[random.below(open.len())];
        if causes.iter().any(|cause| cause.hypothesis.effect == hypothesis.effect) {
            continue;
        }
        // Limits are tried from the tightest to the loosest.
        let (first, last) = (hypothesis.trials.len() / 2, hypothesis.trials.len());
        let values = hypothesis.trials[first + random.below(last - first)].clone();
        let deviations = vec![f64::NAN; values.len()];
        causes.push(Candidate {
            hypothesis: hypothesis.clone(),
            values,
            deviations,
            cost: 0.0,
            beside: Vec::new(),
        });
    }
    causes
}

fn with_all(machine: &Machine, causes: &[Candidate]) -> Machine {
    causes.iter().fold(machine.clone(), |machine, cause| cause.hypothesis.machine(&machine, &cause.values))
}

fn against(run: &Run, machine: &Machine) -> Comparison {
    compare(run.toolpath, &run.plan(machine), &run.by_clock(machine))
}

/// The account of a run, or of one that was calibrated first.
fn accounted(believed: &Machine, calibrated: Option<&Machine>, causes: &[Candidate], run: &Run) -> Account {
    let after = against(run, &with_all(calibrated.unwrap_or(believed), causes));
    let steps = Steps { believed, calibrated, causes };
    let mut all = accounts(&steps, std::slice::from_ref(run), std::slice::from_ref(&after));
    assert_eq!(all.len(), 1);
    let account = all.remove(0);
    let left = (after.whole.recorded - after.whole.simulated)
        * with_all(calibrated.unwrap_or(believed), causes).recorder.clock_ratio
        / believed.recorder.clock_ratio;
    assert!((account.unexplained - left).abs() < ROUNDING_S, "{} s is not {left} s", account.unexplained);
    account
}

fn adds_up(account: &Account) {
    let causes: f64 = account.causes.iter().map(|(_, seconds)| seconds).sum();
    let sum = account.simulated + account.calibration.unwrap_or(0.0) + causes + account.unexplained;
    assert!((sum - account.recorded).abs() < 1e-9, "{account:?}");
    assert!(account.unexplained.abs() <= account.unexplained_sum, "{account:?}");
}

/// What each of the causes adds to every set of the others.
fn added(believed: &Machine, causes: &[Candidate], own: usize, run: &Run) -> Vec<f64> {
    let others: Vec<usize> = (0..causes.len()).filter(|other| *other != own).collect();
    let sets = 0..1usize << others.len();
    sets.map(|set| {
        let before: Vec<Candidate> = (others.iter().enumerate())
            .filter(|(bit, _)| set & (1 << bit) != 0)
            .map(|(_, other)| causes[*other].clone())
            .collect();
        let start = with_all(believed, &before);
        accounted(believed, Some(&start), &causes[own..=own], run).causes[0].1
    })
    .collect()
}

/// Two and three causes that act together, on a recording that also has a wait which is none of them.
#[test]
fn causes_that_act_together_add_up_and_keep_their_sign_in_every_order() {
    for case in 0..case_count(60) {
        let random = &mut Random(17 + case as u64 + 1000 * seed_offset());
        let (text, believed) = (some_program(random), some_machine(random));
        let base = laid(&text, &believed, &believed);
        let causes = some_causes(
            &believed,
            &library(&believed, &[base.run_ignoring_overrides()]),
            2 + case % 2,
            random,
        );
        let mut truth = with_all(&believed, &causes);
        truth.times.m_codes.insert(8, truth.times.of_m_code(8) + 0.3);
        let own = laid(&text, &truth, &believed);
        let run = own.run_ignoring_overrides();
        let account = accounted(&believed, None, &causes, &run);
        adds_up(&account);
        let before = against(&run, &believed).whole;
        assert!((account.simulated - before.simulated).abs() < 1e-9);
        assert!((account.recorded - before.recorded).abs() < 1e-9);
        let names: Vec<String> = causes.iter().map(|cause| cause.hypothesis.name()).collect();
        let clock = truth.recorder.clock_ratio;
        assert!((account.unexplained / clock - 0.3).abs() < 0.05, "{names:?}: {account:?}");

        for (at, (_, share)) in account.causes.iter().enumerate() {
            let each = added(&believed, &causes, at, &run);
            let least = each.iter().copied().fold(f64::INFINITY, f64::min);
            let most = each.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            assert!(least - 1e-9 <= *share && *share <= most + 1e-9, "{}: {share} of {each:?}", names[at]);
            assert!(
                -MAX_SIGN_REVERSAL_S <= least || most <= MAX_SIGN_REVERSAL_S,
                "{} of {names:?}: {each:?}",
                names[at]
            );
        }
        let backwards: Vec<Candidate> = causes.iter().rev().cloned().collect();
        let other = accounted(&believed, None, &backwards, &run);
        for ((effect, share), (_, same)) in account.causes.iter().zip(other.causes.iter().rev()) {
            assert!((share - same).abs() < 1e-9, "{effect:?} of {names:?}: {share} s and {same} s");
        }
    }
}

#[test]
fn without_a_cause_all_that_differs_is_unexplained_and_losses_hide_no_gains() {
    let believed = machine();
    let mut truth = believed.clone();
    truth.times.m_codes.insert(8, truth.times.of_m_code(8) + 0.5);
    truth.rapid.feedrate *= 4.0;
    let own = laid(&program(), &truth, &believed);
    let run = own.run_ignoring_overrides();
    let account = accounted(&believed, None, &[], &run);
    adds_up(&account);
    assert!(account.causes.is_empty() && account.calibration.is_none());
    assert_eq!(account.unexplained, account.recorded - account.simulated);
    assert!(account.unexplained + 0.1 < account.unexplained_sum, "{account:?}");
}

#[test]
fn calibrating_first_is_an_entry_and_several_runs_add_up() {
    let believed = machine();
    let mut calibrated = believed.clone();
    calibrated.interpolator.time_constants = TimeConstants::Equal(0.03);
    let mut truth = calibrated.clone();
    truth.axes[0].acceleration = 700.0;
    let all = [laid(&program(), &truth, &believed), laid(&program(), &calibrated, &believed)];
    let each: Vec<Account> = all
        .iter()
        .map(|own| accounted(&believed, Some(&calibrated), &[], &own.run_ignoring_overrides()))
        .collect();
    each.iter().for_each(adds_up);
    assert!(each.iter().all(|account| account.calibration.is_some_and(|seconds| 0.05 < seconds)));
    let apart = each[0].calibration.zip(each[1].calibration).map_or(f64::INFINITY, |(a, b)| (a - b).abs());
    assert!(apart < 5e-3, "the runs are of one program and end less than a sample apart: {apart} s");
    let together = Account::together(&each);
    adds_up(&together);
    assert_eq!(together.recorded, each[0].recorded + each[1].recorded);
}

/// Hundredths of a second; what is printed has no more digits.
fn hundredths(value: &Value) -> i64 {
    let seconds = value.as_f64().expect("a number");
    let whole = (100.0 * seconds).round();
    assert!((whole - 100.0 * seconds).abs() < 1e-6, "{seconds} s");
    whole as i64
}

/// The account as the command prints it: everything of it in hundredths.
fn printed_adds_up(account: &Value) {
    let causes = account["causes_s"].as_array().expect("a list");
    let sizes: Vec<i64> = causes.iter().map(|entry| hundredths(&entry[1])).collect();
    assert!(sizes.windows(2).all(|pair| pair[1].abs() <= pair[0].abs()), "the largest first: {sizes:?}");
    let sum = hundredths(&account["simulated_s"])
        + sizes.iter().sum::<i64>()
        + hundredths(&account["unexplained_s"]);
    assert_eq!(sum, hundredths(&account["recorded_s"]), "{account}");
    assert!(
        hundredths(&account["unexplained_s"]).abs() <= hundredths(&account["unexplained_sum_s"]),
        "{account}"
    );
}

/// Returns the output of `diagnose` for recordings of LinuxCNC.
fn said(more: &[&str]) -> String {
    let work = tempfile::tempdir().expect("a folder");
    let file = work.path().join("machine.toml");
    std::fs::write(&file, MACHINE).expect("a file");
    let mut command = Command::new(env!("CARGO_BIN_EXE_truefeed"));
    command.arg("diagnose").arg("--machine").arg(&file).args(more);
    let output = command.current_dir(corpus::recordings().join("linuxcnc")).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

#[test]
#[ignore = "full suite: two diagnoses of a limit; the account that the command prints of clean runs is checked below"]
fn the_command_prints_an_account_that_adds_up_to_the_hundredth() {
    let report: Value =
        serde_json::from_str(&said(&["program-1.ngc", "run-02.csv", "--json"])).expect("JSON");
    let account = &report["account"];
    printed_adds_up(account);
    let causes = report["causes"].as_array().expect("a list");
    let named: Vec<Value> =
        causes.iter().map(|cause| serde_json::json!([cause["id"], cause["seconds"]])).collect();
    assert_eq!(account["causes_s"], Value::from(named), "the causes say the seconds of the account");
    // Its clean run takes 41.121 s by the control's own word, this one 44.915 s.
    assert_eq!(account["causes_s"][0][0], "axis_acceleration_limit");
    assert!((account["causes_s"][0][1].as_f64().expect("a number") - 3.79).abs() < 0.02, "{account}");
    assert!(account["unexplained_sum_s"].as_f64().expect("a number") < 0.02, "{account}");
    let sentence = report["sentence"].as_str().expect("a text");
    let wanted = "The run took 44.8 s, 3.8 s longer than simulated: axis Y accelerates at 134 mm/s² at most (3.79 s); ";
    assert!(sentence.starts_with(wanted), "{sentence}");
    let text = said(&["program-1.ngc", "run-02.csv"]);
    let shown: Vec<&str> = text.lines().take(6).collect();
    let page = include_str!("../docs/diagnosis.md");
    assert!(
        page.contains(&shown.join("\n")),
        "docs/diagnosis.md shows another account than\n{}",
        shown.join("\n")
    );
}

#[test]
fn the_accounts_of_several_runs_add_up_and_a_clean_run_shows_nothing_missing() {
    let clean = ["program-1.ngc", "run-01.csv", "--run", "program-1.ngc", "run-01.csv"];
    let report: Value = serde_json::from_str(&said(&[&clean[..], &["--json"]].concat())).expect("JSON");
    let account = &report["account"];
    printed_adds_up(account);
    let runs = account["runs"].as_array().expect("two runs");
    runs.iter().for_each(printed_adds_up);
    for key in ["simulated_s", "unexplained_s", "unexplained_sum_s", "recorded_s"] {
        assert_eq!(
            hundredths(&account[key]),
            runs.iter().map(|run| hundredths(&run[key])).sum::<i64>(),
            "{key}"
        );
    }
    let text = said(&clean[..2]);
    assert!(
        text.starts_with("The run took 41.0 s, as long as simulated: this recording shows nothing missing"),
        "{text}"
    );
    assert!(text.contains("\nsimulated    41.0") && text.contains("\nrecorded     41.0"), "{text}");
}
