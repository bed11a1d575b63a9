//! The results of all seeds ever scored → the page that sums them up, `docs/seeds.md`.
//!
//! ```text
//! cargo run --release --example controller -- pool docs/diagnosis > docs/seeds.md
//! ```
//!
//! A file `controller-SEED-CONTROL.json` contains the results of one seed on one control; LinuxCNC has no suffix. Rates are
//! added up over files, each with its interval; the order of files is that of the builds that scored them.

use std::fmt::Write;
use std::path::Path;

use serde_json::Value;

use crate::Refusal;
use crate::interval::clopper_pearson;

/// The controls: the suffix of their files, and their names.
const CONTROLS: [(&str, &str); 6] = [
    ("", "LinuxCNC"),
    ("grbl", "grbl"),
    ("klipper", "Klipper"),
    ("marlin", "Marlin"),
    ("marlin-deviation", "Marlin, junction deviation"),
    ("tinyg", "TinyG"),
];
/// Suffix of the files of long programs.
const LONG: &str = "-long";
/// Number of seeds that count as the newest ones.
const NEWEST: usize = 10;
/// Number of cases from which on an interval has decimals.
const MIN_CASES_OF_DECIMALS: usize = 200;
/// Edges between the bins of confidences.
const SURE: [f64; 6] = [0.0, 0.4, 0.6, 0.9, 0.99, 1.0 + 1e-9];
/// Edges between the bins of the time that a change takes, s.
const SECONDS: [f64; 7] = [0.03, 0.1, 0.2, 0.5, 1.0, 3.0, f64::INFINITY];
/// Edges between the bins of the distance by which a change bends the path, mm.
const MILLIMETRES: [f64; 5] = [0.003, 0.01, 0.03, 0.1, f64::INFINITY];
/// Time below which a change that bends the path counts as one of the path alone, s.
const MAX_SECONDS_OF_PATH: f64 = 0.03;

/// The results of one seed on one control.
struct Scored {
    seed: u64,
    control: &'static str,
    /// Number of commits before the build that scored it.
    build: u64,
    file: String,
    results: Value,
}

impl Scored {
    fn name(&self) -> String {
        let is_long = self.file.contains(LONG);
        if is_long { format!("{}, long programs", self.control) } else { self.control.to_string() }
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
        all.fold(Rate::default(), |sum, one| Rate {
            hits: sum.hits + usize::from(right(&one)),
            of: sum.of + 1,
        })
    }

    /// Adds up the rates at a place of the results of each seed.
    fn at<'a>(all: impl IntoIterator<Item = &'a Scored>, place: &str) -> Rate {
        let number = |value: &Value| value.as_u64().unwrap_or(0) as usize;
        all.into_iter().filter_map(|one| one.results.pointer(place)).fold(Rate::default(), |sum, rate| Rate {
            hits: sum.hits + number(&rate["hits"]),
            of: sum.of + number(&rate["of"]),
        })
    }

    fn plus(self, other: Rate) -> Rate {
        Rate { hits: self.hits + other.hits, of: self.of + other.of }
    }

    /// As in "3 of 95 (1 to 8 %)".
    fn text(self) -> String {
        if self.of == 0 {
            return "–".to_string();
        }
        let (low, high) = clopper_pearson(self.hits, self.of);
        let decimals = usize::from(MIN_CASES_OF_DECIMALS <= self.of);
        let percent = |rate: f64| format!("{:.decimals$}", 100.0 * rate);
        format!("{} of {} ({} to {} %)", self.hits, self.of, percent(low), percent(high))
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
    let newest = &seeds[seeds.len().saturating_sub(NEWEST)..];
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
    text += EVERY_SEED;
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
        let suffix = suffix.trim_end_matches(LONG);
        let Some((_, control)) = CONTROLS.iter().find(|(own, _)| *own == suffix) else {
            others.push(file);
            continue;
        };
        let results: Value = serde_json::from_str(&std::fs::read_to_string(folder.join(&file))?)?;
        let build = results["truefeed"].as_str().and_then(|build| build.split_once('+')?.1.split('.').next());
        let build = build.and_then(|build| build.parse().ok()).ok_or_else(|| format!("{file}: no build"))?;
        all.push(Scored { seed: seed.parse()?, control, build, file, results });
    }
    let place = |control: &str| CONTROLS.iter().position(|(_, own)| *own == control);
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
        ("right causes with another one beside", |some| {
            Rate::at(some.iter().copied(), "/false_second_causes").text()
        }),
        ("times of other programs within the stated range", |some| {
            Rate::at(some.iter().copied(), "/range/held").text()
        }),
        ("limits of axes within their 90 % interval", |some| {
            Rate::at(some.iter().copied(), "/limits_within").text()
        }),
    ];
    let named =
        |name: &str| -> Vec<&Scored> { all.iter().filter(|one| one.control == name).copied().collect() };
    let columns: Vec<(&str, Vec<&Scored>)> = CONTROLS
        .iter()
        .map(|(_, name)| (*name, named(name)))
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
    ["clean", "other_clean", "preset", "probed"]
        .map(|role| Rate::at(all.iter().copied(), &format!("/{role}_with_a_name")))
        .into_iter()
        .fold(Rate::default(), Rate::plus)
}

fn visible(all: &[&Scored], outcome: &str) -> Rate {
    Rate::at(all.iter().copied(), &format!("/changes_visible/{outcome}"))
}

/// Returns how often causes of each confidence are right.
fn sureness(newest: &[&Scored], all: &[&Scored]) -> String {
    let judged = |some: &[&Scored]| -> Vec<(f64, bool)> {
        cases(some)
            .flat_map(|case| case["named"].as_array().into_iter().flatten())
            .filter_map(|cause| Some((cause["confidence"].as_f64()?, cause["right"] == true)))
            .collect()
    };
    let sets = [judged(newest), judged(all)];
    let mut text = "| said | right, newest seeds | right, all seeds |\n|---|---:|---:|\n".to_string();
    for edges in SURE.windows(2) {
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
    let brier = sets.each_ref().map(|set| {
        let squares = set.iter().map(|(sure, right)| (sure - f64::from(u8::from(*right))).powi(2));
        format!("{:.3} of {} causes", squares.sum::<f64>() / set.len() as f64, set.len())
    });
    let slopes = sets.each_ref().map(|set| format!("{:.2}", slope(set)));
    text += &format!(
        "| Brier score | {} |\n| slope of right over said | {} |\n",
        brier.join(" | "),
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
    let of_time =
        |case: &Value| Some(size(case, "effect_s")).filter(|seconds| MAX_SECONDS_OF_PATH <= *seconds);
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
    rows(&SECONDS, "s", &of_time);
    rows(&MILLIMETRES, "mm", &of_path);
    text
}

/// Returns a row for each seed, the newest one first.
fn every_seed(seeds: &[u64], all: &[Scored]) -> String {
    let mut text = "| seed | drawn from | results | programs | clean, named | visible, first | wrong alone | in range |\n|---|---|---|---:|---:|---:|---:|---:|\n".to_string();
    for seed in seeds.iter().rev() {
        let of: Vec<&Scored> = all.iter().filter(|one| one.seed == *seed).collect();
        let links: Vec<String> =
            of.iter().map(|one| format!("[{}](diagnosis/{})", one.name(), one.file)).collect();
        let counts = [
            clean(&of),
            visible(&of, "first"),
            visible(&of, "wrong"),
            Rate::at(of.iter().copied(), "/range/held"),
        ];
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

`examples/controller` draws programs as shops run them, records them on a control, once as it is and again with one thing changed, and scores
what `truefeed` says of the recordings. LinuxCNC is the real control; the other controls have planners written after their software, which share
no code with Truefeed ([recordings](recordings.md)). A seed is the hash of a commit, drawn after the last change of the identification, and the build of
that day scores it once. Later versions may use its recordings for development, so each seed is fresh only once. The calibration of each program
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

The time that a change takes, or where it takes less than 0.03 s, the distance by which it bends the path. Below the limit of a visible change,
silence is right.

";

const EVERY_SEED: &str = "
## Every seed

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
