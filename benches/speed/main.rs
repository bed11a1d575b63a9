//! Time and memory of quoting programs, as multiples of yardsticks of the same run.
//!
//! ```text
//! cargo bench --bench speed                 a million lines and less, prints the table
//! cargo bench --bench speed -- write        ten million lines as well, writes docs/speed.md
//! cargo bench --bench speed -- recordings   the table of recordings alone
//! ```
//!
//! One yardstick reads the bytes once; the other is the crate `async-gcode`, which splits the same bytes into
//! words and keeps none of them. Each measurement runs in its own process, whose greatest size (VmHWM of
//! Linux) is its peak memory, including the file. Each round runs all measurements in turn, so that other
//! load on the computer affects them alike; each number is the best of all rounds.

mod programs;
mod recordings;

use std::hint::black_box;
use std::num::NonZero;
use std::pin::{Pin, pin};
use std::process::Command;
use std::task::{Context, Poll, Waker};
use std::thread::{available_parallelism, scope};
use std::time::Instant;

use futures::Stream;
use programs::Made;
use recordings::LogWork;
use truefeed::machine::Machine;
use truefeed::plot::Programmed;
use truefeed::plot::path::{SteppedCurve, Trail};
use truefeed::quote::quote;
use truefeed::simulation::feed::{CornerPolicy, Tolerances};
use truefeed::simulation::gcode::{Options, Parts, Scope};
use truefeed::simulation::interpreter::trace_text;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

/// Contour tolerances, mm.
static TOLERANCES: [f64; 4] = [0.005, 0.010, 0.020, 0.050];

/// Number of rounds, of which the best counts.
const ROUNDS: usize = 2;

/// The work of a measurement on a program.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Work {
    /// Reads every byte once.
    Bytes,
    /// Parses the program by `async-gcode`.
    Yardstick,
    /// Reads the program, part by part.
    Read,
    /// Reads and traces the program.
    Trace,
    /// Reads, traces and plans the program for one tolerance.
    Plan,
    /// The same for four tolerances.
    PlanFour,
    /// The same on as many threads as there are processors.
    PlanFourAtOnce,
    /// Plans the program, measures its contour errors, and quotes it.
    Quote,
    /// The same for four tolerances.
    QuoteFour,
    /// The same on as many threads as there are processors, as the command does it.
    QuoteFourAtOnce,
    /// Quotes the program and computes the data of charts, as the worker of the page does.
    Chart,
}

impl Work {
    const ALL: [Work; 11] = [
        Work::Bytes,
        Work::Yardstick,
        Work::Read,
        Work::Trace,
        Work::Plan,
        Work::PlanFour,
        Work::PlanFourAtOnce,
        Work::Quote,
        Work::QuoteFour,
        Work::QuoteFourAtOnce,
        Work::Chart,
    ];

    fn word(self) -> &'static str {
        match self {
            Work::Bytes => "bytes",
            Work::Yardstick => "async-gcode",
            Work::Read => "read",
            Work::Trace => "trace",
            Work::Plan => "plan",
            Work::PlanFour => "plan four",
            Work::PlanFourAtOnce => "plan four at once",
            Work::Quote => "quote",
            Work::QuoteFour => "quote four",
            Work::QuoteFourAtOnce => "quote four at once",
            Work::Chart => "chart",
        }
    }

    /// Does the work once. Returns a number that keeps the compiler from removing the work.
    fn run(self, text: Vec<u8>) -> f64 {
        let machine = Machine::default();
        let toolpath = |text: Vec<u8>| trace_text(text, &Options::default(), &machine);
        let quoted = |toolpath: &Toolpath, tolerance: f64| {
            let tolerances = Tolerances::One(tolerance);
            let (plan, errors) = simulate::within(toolpath, &machine, tolerances, &mut |_| {});
            let time = quote(toolpath, &machine, &plan, tolerances, &errors).cycle_time;
            (time, plan, errors)
        };
        match self {
            Work::Bytes => text.iter().map(|byte| u64::from(*byte)).sum::<u64>() as f64,
            Work::Yardstick => parsed_elsewhere(&text) as f64,
            Work::Read => {
                let (options, mut blocks) = (Options::default(), 0);
                let mut parts = Parts::new(&text, &options, Scope::STRAIGHT).expect("an ISO program");
                while parts.next_part(1_000) {
                    blocks += parts.part().blocks.len();
                }
                blocks as f64
            }
            Work::Trace => toolpath(text).segments.len() as f64,
            Work::Plan | Work::PlanFour | Work::PlanFourAtOnce => {
                let toolpath = toolpath(text);
                let one = |tolerance: f64| {
                    simulate::with_policy(&toolpath, &machine, CornerPolicy::Isolated(tolerance)).cycle_time()
                };
                match self {
                    Work::Plan => one(TOLERANCES[1]),
                    Work::PlanFour => TOLERANCES.map(one).iter().sum(),
                    _ => at_once(one),
                }
            }
            Work::Chart => {
                let toolpath = toolpath(text);
                let shown = (Programmed::of(&toolpath, &machine), Trail::of(&toolpath));
                let (time, plan, errors) = quoted(&toolpath, TOLERANCES[1]);
                let curve = Profile::new(&toolpath, &plan).drawn();
                black_box((shown, errors, SteppedCurve::of(&curve)));
                time
            }
            Work::Quote | Work::QuoteFour | Work::QuoteFourAtOnce => {
                let toolpath = toolpath(text);
                let one = |tolerance: f64| quoted(&toolpath, tolerance).0;
                match self {
                    Work::Quote => one(TOLERANCES[1]),
                    Work::QuoteFour => TOLERANCES.map(one).iter().sum(),
                    _ => at_once(one),
                }
            }
        }
    }

    /// Returns `true` if several processors work, so that the clock is measured.
    fn is_at_once(self) -> bool {
        matches!(self, Work::PlanFourAtOnce | Work::QuoteFourAtOnce)
    }

    /// Returns `true` if the work is measured only on the first program.
    fn is_of_first(self) -> bool {
        self.is_at_once() || self == Work::QuoteFour
    }
}

/// Returns the sum over all tolerances, computed on as many threads as there are processors.
fn at_once(one: impl Fn(f64) -> f64 + Copy + Send + Sync) -> f64 {
    scope(|scope| {
        let parts = TOLERANCES.chunks(TOLERANCES.len().div_ceil(processors()));
        let sum = |part: &'static [f64]| scope.spawn(move || part.iter().copied().map(one).sum::<f64>());
        let threads: Vec<_> = parts.map(sum).collect();
        threads.into_iter().map(|thread| thread.join().expect("a tolerance")).sum()
    })
}

/// Bytes as the stream that `async-gcode` reads from.
struct Bytes<'a>(std::slice::Iter<'a, u8>);

impl Stream for Bytes<'_> {
    type Item = Result<u8, async_gcode::Error>;

    fn poll_next(mut self: Pin<&mut Self>, _: &mut Context) -> Poll<Option<Self::Item>> {
        Poll::Ready(self.0.next().map(|byte| Ok(*byte)))
    }
}

/// Returns the number of words that `async-gcode` finds. All bytes are in memory, so that it never waits.
fn parsed_elsewhere(text: &[u8]) -> usize {
    let words = async {
        let mut parser = async_gcode::Parser::new(Bytes(text.iter()));
        let mut words = 0;
        while let Some(parsed) = parser.next().await {
            words += usize::from(black_box(parsed).is_ok());
        }
        words
    };
    match pin!(words).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(words) => words,
        Poll::Pending => unreachable!("all bytes are there"),
    }
}

/// One measurement: time (s), peak memory and file size (bytes).
#[derive(Clone, Copy)]
struct Measured {
    time: f64,
    peak: f64,
    size: f64,
}

/// Measures in this process, and prints the result for the parent process.
fn measure(work: Work, made: Made, lines: usize) {
    let text = made.text(lines);
    let size = text.len();
    let began = processor_time();
    let begin = Instant::now();
    black_box(work.run(black_box(text)));
    let elapsed = begin.elapsed().as_secs_f64();
    let worked = processor_time().zip(began).map(|(end, begin)| end - begin);
    let worked = if work.is_at_once() { Some(elapsed) } else { worked };
    let peak = peak_memory();
    let time = worked.filter(|time| LONG_ENOUGH < *time).unwrap_or_else(|| {
        let text = made.text(lines);
        let again = |_| {
            let text = text.clone();
            let begin = Instant::now();
            black_box(work.run(black_box(text)));
            begin.elapsed().as_secs_f64()
        };
        (0..5).map(again).fold(elapsed, f64::min)
    });
    println!("{time} {peak} {size}");
}

/// Duration below which the clock replaces the time of the processor, which the system gives in ticks, s; the
/// least of several measurements counts.
const LONG_ENOUGH: f64 = 0.1;

fn processors() -> usize {
    available_parallelism().map_or(1, NonZero::get)
}

/// Returns the time for which this thread has had a processor, s, without the time of other processes; `None`
/// if the system does not give it.
fn processor_time() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(1e-9 * text.split_whitespace().next()?.parse::<f64>().ok()?)
}

/// Returns the greatest size of this process so far, bytes; NaN if the system does not give it.
fn peak_memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok());
    kilobytes.map_or(f64::NAN, |kilobytes| 1024.0 * kilobytes)
}

/// Measures in a separate process.
fn measured(work: Work, made: Made, lines: usize) -> Measured {
    let [time, peak, size] = numbers_of(["measure", work.word(), made.word(), &lines.to_string()]);
    Measured { time, peak, size }
}

/// Returns the numbers that this program prints when it is started with these arguments.
fn numbers_of<const N: usize, const M: usize>(arguments: [&str; N]) -> [f64; M] {
    let own = std::env::current_exe().expect("this program has a path");
    let output = Command::new(own).args(arguments).output().expect("this program can be started");
    let text = String::from_utf8_lossy(&output.stdout);
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|number| number.parse().ok()).collect();
    numbers.try_into().unwrap_or_else(|_| {
        panic!("{} did not end: {}", arguments.join(" "), String::from_utf8_lossy(&output.stderr))
    })
}

/// Returns the table of the work on recordings of an hour.
fn recordings_table() -> String {
    let mut text = "\n## The recording of an hour\n
Another machine than the preset, a planner with junction deviation, runs the roughing program for an hour; its positions are recorded every
10 ms. Seconds that pass, on all processors; `calibrate by two` has an hour of arcs as well.\n
| work | s | × aligning |\n|---|---:|---:|\n"
        .to_string();
    let found = LogWork::ALL.map(|work| numbers_of::<2, 1>(["measure-log", work.word()])[0]);
    for (work, seconds) in LogWork::ALL.iter().zip(found) {
        text += &format!("| {} | {seconds:.1} | {:.1} |\n", work.word(), seconds / found[0]);
    }
    text
}

/// Returns the best of all rounds for each work.
fn best(works: &[Work], made: Made, lines: usize, rounds: usize) -> Vec<Measured> {
    let round = || works.iter().map(|work| measured(*work, made, lines)).collect::<Vec<_>>();
    (1..rounds).fold(round(), |best, _| {
        let better = |(a, b): (Measured, Measured)| if b.time < a.time { b } else { a };
        best.into_iter().zip(round()).map(better).collect()
    })
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["measure", work, made, lines] => {
            let work = Work::ALL.into_iter().find(|known| known.word() == work).expect("a work");
            measure(work, Made::from_word(made).expect("a program"), lines.parse().expect("a number"));
        }
        ["measure-log", work] => {
            let work = LogWork::ALL.into_iter().find(|known| known.word() == work).expect("a work");
            println!("{}", work.seconds());
        }
        ["write", made, lines] => {
            let made = Made::from_word(made).expect("a program");
            let text = made.text(lines.parse().expect("a number"));
            std::io::Write::write_all(&mut std::io::stdout(), &text).expect("text can be written");
        }
        ["recordings"] => print!("{}", recordings_table()),
        ["write"] => {
            let page = page(true);
            print!("{page}");
            std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/speed.md"), page)
                .expect("the page can be written");
        }
        _ => print!("{}", page(false)),
    }
}

/// Returns all tables as Markdown; with ten million lines if `is_whole`.
fn page(is_whole: bool) -> String {
    const MILLION: usize = 1_000_000;
    let mut text = HEAD.to_string();
    let mut finishing = Vec::new();
    for (made, lines) in
        [(Made::Finishing, MILLION), (Made::Arcs, 100_000), (Made::Roughing, 200_000), (Made::Cycles, 30_000)]
    {
        let is_first = made == Made::Finishing;
        let works: Vec<Work> = Work::ALL.into_iter().filter(|work| is_first || !work.is_of_first()).collect();
        let found = best(&works, made, lines, ROUNDS);
        let yardstick = found[Work::Yardstick as usize].time;
        text += &format!(
            "\n## {} lines of {} ({:.0} MB)\n\n| work | ns a line | × async-gcode | × reading the bytes | peak × file |\n|---|---:|---:|---:|---:|\n",
            lines,
            made.word(),
            1e-6 * found[0].size
        );
        for (work, one) in works.iter().zip(&found) {
            text += &format!(
                "| {} | {:.0} | {:.2} | {:.0} | {:.1} |\n",
                work.word(),
                1e9 * one.time / lines as f64,
                one.time / yardstick,
                one.time / found[0].time,
                one.peak / one.size
            );
        }
        if is_first {
            finishing = found;
        }
    }
    let of = |work: Work| finishing[work as usize];
    let planned_at_once = format!("four tolerances, planned on {} processors at once, × one", processors());
    let quoted_at_once = format!("the same on {} processors at once, × one", processors());
    let mut targets = vec![
        (
            "read, trace and plan a million lines, × async-gcode parsing them",
            of(Work::Plan).time / of(Work::Yardstick).time,
            1.0,
        ),
        (
            "four tolerances, planned one after the other, × one",
            of(Work::PlanFour).time / of(Work::Plan).time,
            1.6,
        ),
        (&planned_at_once, of(Work::PlanFourAtOnce).time / of(Work::Plan).time, 1.6),
        (
            "one after the other with contour errors and quote, × one",
            of(Work::QuoteFour).time / of(Work::Quote).time,
            1.6,
        ),
        (&quoted_at_once, of(Work::QuoteFourAtOnce).time / of(Work::Quote).time, 1.6),
        ("peak memory of a plan, × file", of(Work::Plan).peak / of(Work::Plan).size, 3.0),
        ("peak memory of a quote, × file", of(Work::Quote).peak / of(Work::Quote).size, 3.0),
    ];
    if is_whole {
        let long = best(&[Work::Plan], Made::Finishing, 10 * MILLION, 1)[0];
        targets.push(("ten million lines planned, × one million", long.time / of(Work::Plan).time, 10.5));
        targets.push(("peak memory of that plan, × file", long.peak / long.size, 3.0));
    }
    text += &recordings_table();
    text += "\n## Against the targets\n\n| what | found | target | |\n|---|---:|---:|---|\n";
    for (what, found, target) in targets {
        let is_met = if found <= target { "met" } else { "missed" };
        text += &format!("| {what} | {found:.2} | {target} | {is_met} |\n");
    }
    text + &std::fs::read_to_string(NOTES).expect("the notes are beside this program")
}

const HEAD: &str = "# Speed and size\n
The cost of quoting programs, in multiples of two yardsticks of the same run: reading each byte once, and parsing the same file with the
crate `async-gcode`. `cargo bench --bench speed -- write` writes this page, on one core. Times are processor times, so that other work on the
machine does not count. The peak is the memory of the process, including the file.\n";

/// The text below the figures.
const NOTES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/speed/notes.md");
