//! The results of all seeds ever scored → the page that sums them up, `docs/seeds.md`.
//!
//! ```text
//! cargo run --release --example controller -- pool docs/diagnosis > docs/seeds.md
//! ```
//!
//! A file `controller-SEED-CONTROL.json` contains the results of one seed on one control; LinuxCNC has no suffix. The page adds
//! up their rates and states the interval of each sum. Seeds come in the order in which builds scored them.

use std::fmt::Write;
use std::path::Path;

use serde_json::Value;

use crate::Refusal;
use crate::figures::{brier, judged, rate, rate_text};
use crate::machine::Family;

/// Suffix of the files of long programs.
const LONG_PROGRAMS_SUFFIX: &str = "-long";
/// Number of seeds that count as the newest ones.
const NEWEST_SEEDS_COUNT: usize = 10;
/// Number of cases from which on an interval has decimals.
const MIN_CASES_OF_DECIMALS: usize = 200;
/// Edges of the bins of confidence.
const CONFIDENCE_EDGES: [f64; 6] = [0.0, 0.4, 0.6, 0.9, 0.99, 1.0 + 1e-9];
/// Edges of the bins of a change by its time, s.
const CHANGE_TIME_EDGES_S: [f64; 7] = [0.03, 0.1, 0.2, 0.5, 1.0, 3.0, f64::INFINITY];
/// Edges of the bins of a change by its largest deviation from the path, mm.
const CHANGE_DEVIATION_EDGES_MM: [f64; 5] = [0.003, 0.01, 0.03, 0.1, f64::INFINITY];
/// Time below which a change counts by its deviation from the path, s.
const MIN_CHANGE_TIME_S: f64 = 0.03;

/// The results of one seed on one control.
struct Scored {
    seed: u64,
    control: Family,
    /// Number of commits before the build that scored it.
    build: u64,
    file: String,
    results: Value,
}

impl Scored {
    fn name(&self) -> String {
        let is_long = self.file.contains(LONG_PROGRAMS_SUFFIX);
        let title = self.control.title();
        if is_long { format!("{title}, long programs") } else { title.to_string() }
    }
}

/// Cases of one kind among all of them.
#[derive(Clone, Copy, Default)]
struct Rate {
    hits: usize,
    of: usize,
}

impl Rate {
    /// Counts those of `all` that are `right`.
    fn count<T>(all: impl Iterator<Item = T>, right: impl Fn(&T) -> bool) -> Rate {
        Rate::sum(all.map(|one| Rate { hits: usize::from(right(&one)), of: 1 }))
    }

    /// Adds up the rates at a place of some results.
    fn at(some: &[&Scored], place: &str) -> Rate {
        let number = |value: &Value| value.as_u64().unwrap_or(0) as usize;
        let rates = some.iter().filter_map(|one| one.results.pointer(place));
        Rate::sum(rates.map(|rate| Rate { hits: number(&rate["hits"]), of: number(&rate["of"]) }))
    }

    fn sum(rates: impl Iterator<Item = Rate>) -> Rate {
        rates.fold(Rate::default(), |sum, next| Rate { hits: sum.hits + next.hits, of: sum.of + next.of })
    }

    fn text(self) -> String {
        rate_text(&rate(self.hits, self.of), usize::from(MIN_CASES_OF_DECIMALS <= self.of))
    }
}

/// Returns the page of all results in a folder, and the names of its files that belong to no control.
pub fn page(folder: &Path) -> Result<(String, Vec<String>), Refusal> {
    let (all, others) = scored(folder)?;
    let mut seeds: Vec<u64> = Vec::new();
    for one in &all {
        if !seeds.contains(&one.seed) {
            seeds.push(one.seed);
        }
    }
    let newest = &seeds[seeds.len().saturating_sub(NEWEST_SEEDS_COUNT)..];
    let of_newest: Vec<&Scored> = all.iter().filter(|one| newest.contains(&one.seed)).collect();
    let of_all: Vec<&Scored> = all.iter().collect();
    let mut text = INTRODUCTION.to_string();
    writeln!(text, "\n## The newest {} of {} seeds\n", newest.len(), seeds.len())?;
    text += &by_control(&of_newest);
    text += "\n## All seeds\n\nEarlier versions of Truefeed scored the older ones, and many of their errors are corrected.\n\n";
    text += &by_control(&of_all);
    text += SURENESS;
    text += &sureness(&of_newest, &of_all);
    text += RECALL;
    text += &recall(&of_newest, &of_all);
    text += "\n## Every seed\n\n";
    text += &every_seed(&seeds, &all);
    Ok((text, others))
}

/// Returns the results in a folder in the order in which they were scored, and the names of other results.
fn scored(folder: &Path) -> Result<(Vec<Scored>, Vec<String>), Refusal> {
    let mut files: Vec<String> = std::fs::read_dir(folder)?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.starts_with("controller-") && name.ends_with(".json"))
        .collect();
    files.sort();
    let (mut all, mut others) = (Vec::new(), Vec::new());
    for file in files {
        let name = file.trim_start_matches("controller-").trim_end_matches(".json");
        let (seed, suffix) = name.split_once('-').unwrap_or((name, ""));
        let suffix = suffix.trim_end_matches(LONG_PROGRAMS_SUFFIX);
        let control = if suffix.is_empty() { Some(Family::LinuxCnc) } else { Family::named(suffix) };
        let Some(control) = control else {
            others.push(file);
            continue;
        };
        let results: Value = serde_json::from_str(&std::fs::read_to_string(folder.join(&file))?)?;
        let build = results["truefeed"].as_str().and_then(|build| build.split_once('+')?.1.split('.').next());
        let build = build.and_then(|build| build.parse().ok()).ok_or_else(|| format!("{file}: no build"))?;
        all.push(Scored { seed: seed.parse()?, control, build, file, results });
    }
    let place = |control: Family| Family::NAMES.iter().position(|(_, own)| *own == control);
    all.sort_by_key(|one| (one.build, one.seed, place(one.control)));
    Ok((all, others))
}

/// The text of a figure of some results.
type Figure = fn(&[&Scored]) -> String;

/// Returns the rates of each control, and of all of them.
fn by_control(all: &[&Scored]) -> String {
    let rows: [(&str, Figure); 9] = [
        ("programs", |some| programs(some).to_string()),
        ("clean runs in which a cause was named", |some| clean(some).text()),
        ("visible changes whose cause was named first", |some| visible(some, "first").text()),
        ("the right cause was named among several, another one first", |some| visible(some, "later").text()),
        ("wrong causes alone were named", |some| visible(some, "wrong").text()),
        ("changes called unknown, or not seen", |some| {
            let missed = ["unknown", "silent", "refused"].map(|outcome| visible(some, outcome).hits);
            Rate { hits: missed.iter().sum(), of: visible(some, "first").of }.text()
        }),
        ("right causes with another one beside", |some| Rate::at(some, "/false_second_causes").text()),
        ("times of other programs within the stated range", |some| Rate::at(some, "/range/held").text()),
        ("limits of axes within their 90 % interval", |some| Rate::at(some, "/limits_within").text()),
    ];
    let on = |control: Family| -> Vec<&Scored> {
        all.iter().filter(|one| one.control == control).copied().collect()
    };
    let columns: Vec<(&str, Vec<&Scored>)> = Family::NAMES
        .into_iter()
        .map(|(_, control)| (control.title(), on(control)))
        .filter(|(_, of)| !of.is_empty())
        .chain([("all", all.to_vec())])
        .collect();
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let mut text = format!("| | {} |\n|---|{}\n", names.join(" | "), "---:|".repeat(names.len()));
    for (what, value) in rows {
        let cells: Vec<String> = columns.iter().map(|(_, of)| value(of)).collect();
        text += &format!("| {what} | {} |\n", cells.join(" | "));
    }
    text
}

fn cases<'a>(all: &'a [&Scored]) -> impl Iterator<Item = &'a Value> {
    all.iter().flat_map(|one| one.results["cases"].as_array().into_iter().flatten())
}

/// Returns the number of programs but for the probe; each has one clean run by its own file.
fn programs(all: &[&Scored]) -> usize {
    cases(all).filter(|case| case["role"] == "clean" && case["program_kind"] != "probe").count()
}

/// Returns the rate of clean runs of all kinds with a cause.
fn clean(all: &[&Scored]) -> Rate {
    let roles = ["clean", "other_clean", "preset", "probed"];
    Rate::sum(roles.iter().map(|role| Rate::at(all, &format!("/{role}_with_a_name"))))
}

fn visible(all: &[&Scored], outcome: &str) -> Rate {
    Rate::at(all, &format!("/changes_visible/{outcome}"))
}

/// Returns how often causes of each confidence are right.
fn sureness(newest: &[&Scored], all: &[&Scored]) -> String {
    let sets = [newest, all].map(|some| judged(cases(some)));
    let mut text = "| said | right, newest seeds | right, all seeds |\n|---|---:|---:|\n".to_string();
    for edges in CONFIDENCE_EDGES.windows(2) {
        let cells = sets.each_ref().map(|set| {
            let inside: Vec<_> =
                set.iter().filter(|(sure, _)| edges[0] <= *sure && *sure < edges[1]).collect();
            let mean = inside.iter().map(|(sure, _)| sure).sum::<f64>() / inside.len() as f64;
            let rate = Rate::count(inside.iter(), |(_, right)| *right);
            if inside.is_empty() {
                rate.text()
            } else {
                format!("{}; said {:.1} %", rate.text(), 100.0 * mean)
            }
        });
        let [from, to] = [edges[0], edges[1]].map(|edge| (100.0 * edge).round());
        text += &format!("| {from} to {to} % sure | {} |\n", cells.join(" | "));
    }
    let scores = sets.each_ref().map(|set| format!("{:.3} of {} causes", brier(set), set.len()));
    let slopes = sets.each_ref().map(|set| format!("{:.2}", slope(set)));
    text += &format!(
        "| Brier score | {} |\n| slope of right over said | {} |\n",
        scores.join(" | "),
        slopes.join(" | ")
    );
    text
}

/// Returns the slope of the line by least squares through "right" (0 or 1) over the confidence; 1 is right.
fn slope(judged: &[(f64, bool)]) -> f64 {
    let count = judged.len() as f64;
    let value = |right: bool| f64::from(u8::from(right));
    let mean_said = judged.iter().map(|(sure, _)| sure).sum::<f64>() / count;
    let mean_right = judged.iter().map(|(_, right)| value(*right)).sum::<f64>() / count;
    let both =
        judged.iter().map(|(sure, right)| (sure - mean_said) * (value(*right) - mean_right)).sum::<f64>();
    both / judged.iter().map(|(sure, _)| (sure - mean_said).powi(2)).sum::<f64>()
}

/// Returns how many changes of each size are right first.
fn recall(newest: &[&Scored], all: &[&Scored]) -> String {
    let size = |case: &Value, key: &str| case[key].as_f64().map_or(0.0, f64::abs);
    let of_time = |case: &Value| Some(size(case, "effect_s")).filter(|seconds| MIN_CHANGE_TIME_S <= *seconds);
    let of_path = |case: &Value| of_time(case).is_none().then(|| size(case, "effect_mm"));
    let mut text =
        "| size of the change | right first, newest seeds | right first, all seeds |\n|---|---:|---:|\n"
            .to_string();
    let mut rows = |edges: &[f64], unit: &str, of: &dyn Fn(&Value) -> Option<f64>| {
        for edges in edges.windows(2) {
            let cells = [newest, all].map(|some| {
                let changes = cases(some).filter(|case| case["role"] == "change");
                let inside =
                    changes.filter(|case| of(case).is_some_and(|size| edges[0] <= size && size < edges[1]));
                Rate::count(inside, |case| case["outcome"] == "first").text()
            });
            let what = match edges[1].is_finite() {
                true => format!("{} to {} {unit}", edges[0], edges[1]),
                false => format!("{} {unit} and more", edges[0]),
            };
            text += &format!("| {what} | {} |\n", cells.join(" | "));
        }
    };
    rows(&CHANGE_TIME_EDGES_S, "s", &of_time);
    rows(&CHANGE_DEVIATION_EDGES_MM, "mm", &of_path);
    text
}

/// Returns a row for each seed, the newest one first.
fn every_seed(seeds: &[u64], all: &[Scored]) -> String {
    let mut text = "| seed | drawn from | results | programs | clean, named | visible, first | wrong alone | in range |\n|---|---|---|---:|---:|---:|---:|---:|\n".to_string();
    for seed in seeds.iter().rev() {
        let of: Vec<&Scored> = all.iter().filter(|one| one.seed == *seed).collect();
        let links: Vec<String> =
            of.iter().map(|one| format!("[{}](diagnosis/{})", one.name(), one.file)).collect();
        let counts = [clean(&of), visible(&of, "first"), visible(&of, "wrong"), Rate::at(&of, "/range/held")];
        let counts = counts.map(|rate| format!("{} of {}", rate.hits, rate.of));
        text += &format!(
            "| {seed} | {seed:07x} | {} | {} | {} |\n",
            links.join(", "),
            programs(&of),
            counts.join(" | ")
        );
    }
    text
}

const INTRODUCTION: &str = "# Seeds scored

`examples/controller` draws programs of the kinds that shops run. It records each of them on a control, first unchanged and then with a single
change to the machine, and scores the diagnoses by `truefeed`. LinuxCNC is the real control; the other controls have planners written after their
software, which share no code with Truefeed ([recordings](recordings.md)). A seed is the hash of a commit that changed the identification, and
the build of that commit scores it once. Later versions may use its recordings for development, so each seed is fresh only once. Every calibration
begins with a machine file that knows nothing of the control (`tests/data/machines/generic.toml`).

```
cargo run --release --example controller -- record --seed 137719630 --programs 4 --changes 2 --out target/controller
cargo run --release --example controller -- score target/controller --out target/controller-reports --preset tests/data/machines/generic.toml
```

`record` accepts `--control grbl`, `klipper`, `marlin`, `marlin-deviation` and `tinyg`; these need no recorder. This page is made from the result
files by `cargo run --release --example controller -- pool docs/diagnosis`, and a test holds it.

- *Clean runs* are diagnosed by the file calibrated on the same program, on another program, on the probe, or not at all.
- A change is *visible* if it changes the time by 0.3 % and by 0.1 s, or bends the path by 0.01 mm: this limit was set before any run.
- *Named first* means that the first cause is the one that was changed; *wrong alone* means that only others were named.
- Intervals contain the true rate nine times in ten (Clopper and Pearson).
";

const SURENESS: &str = "
## How far \"x % sure\" holds

All causes named in all runs count, clean ones included, where every cause is false. Causes of the same trace share their probability, so two that a
recording cannot separate are 50 % sure each. A slope of 1 would be right. Before 8293b16 the odds left no room for causes
that Truefeed does not know; since then no cause is surer than 96.7 %.

";

const RECALL: &str = "
## How large a change must be

A change counts by the time that it adds to the run or saves. Below 0.03 s, it counts by its largest deviation from the path. A diagnosis should
be silent on a change that is not visible.

";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_of_seeds_is_made_from_their_results() {
        let (text, _) = page(Path::new("docs/diagnosis")).expect("the results can be read");
        let kept = include_str!("../../docs/seeds.md");
        assert!(text == kept, "docs/seeds.md is not what `controller pool docs/diagnosis` writes");
    }

    #[test]
    fn a_slope_of_one_is_right() {
        // Of four causes 50 % sure two are right, of two 100 % sure both.
        let half = [(0.5, true), (0.5, false), (0.5, true), (0.5, false)];
        let judged = [&half[..], &[(1.0, true), (1.0, true)]].concat();
        assert!((slope(&judged) - 1.0).abs() < 1e-12);
        assert_eq!(Rate { hits: 0, of: 10 }.text(), "0 of 10 (0 to 26 %)");
        assert_eq!(Rate::default().text(), "–");
    }
}
