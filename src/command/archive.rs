//! `truefeed predict --ndjson`: many programs, one line of JSON each, on all processors.
//!
//! Lines appear in the order in which programs finish; the content of a line depends only on its program and
//! the request. With `--out` a run continues an earlier one, even one that was killed ([`ArchiveFile`]): a
//! program is skipped while its line is current ([`ArchiveKeys`]).

use std::any::Any;
use std::collections::{HashMap, HashSet};
use std::io::{IsTerminal, Write, stderr};
use std::num::NonZero;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::{available_parallelism, scope};
use std::time::{Duration, Instant};

use truefeed::machine::Machine;
use truefeed::project::{ArchiveKeys, ArchiveLine, LineOwner, Prediction};
use truefeed::quote::{programmed_time, quote};
use truefeed::simulation::feed::Tolerances;
use truefeed::simulation::gcode::Options;
use truefeed::simulation::interpreter::trace_text;
use truefeed::simulation::simulate;

use crate::command::archive_file::{Earlier, Sink, open};
use crate::command::input::bytes_of;
use crate::command::programs::{FoundProgram, programs};
use crate::command::{CommandError, declined, print};

/// Exit status if all programs were processed and some line contains an error.
const STATUS_WITH_ERRORS: u8 = 1;

/// A request for an archive.
pub struct ArchiveRequest {
    /// Programs, and folders of programs.
    pub paths: Vec<PathBuf>,
    /// Machine.
    pub machine: Machine,
    /// Machine file.
    pub machine_path: PathBuf,
    /// Contour tolerances, mm; if empty, those of the program.
    pub tolerances: Vec<f64>,
    /// Reading options, such as the dialect of all programs.
    pub options: Options,
    /// File to append lines to; `None` for standard output.
    pub out: Option<PathBuf>,
    /// `true` to list the outstanding programs instead.
    pub is_list: bool,
    /// Number of programs processed at a time; `None` for one per processor.
    pub jobs: Option<NonZero<usize>>,
}

impl ArchiveRequest {
    /// Runs the request; returns the exit status.
    pub fn run(&self) -> Result<ExitCode, CommandError> {
        if self.paths.iter().any(|path| path == Path::new("-")) {
            return Err("--ndjson takes files and folders; standard input has no name".to_string());
        }
        let found = programs(&self.paths);
        let keys = ArchiveKeys::new(&self.machine, &self.tolerances, &self.options);
        let asked: HashMap<String, &PathBuf> =
            found.iter().flatten().map(|program| (name(program), program)).collect();
        let key_of = |program: &Path| bytes_of(program).ok().map(|bytes| keys.of(&bytes));
        let state = |owner: &LineOwner| match asked.get(&owner.path) {
            None => Earlier::Other,
            Some(program) if owner.key.is_some() && key_of(program) == owner.key => Earlier::Current,
            Some(_) => Earlier::Outdated,
        };
        let (mut sink, current) = match &self.out {
            None => (Sink::Standard, HashSet::new()),
            Some(out) => {
                let programs = found.iter().flatten().map(PathBuf::as_path);
                let inputs: Vec<&Path> = programs.chain([&*self.machine_path]).collect();
                open(out, &inputs, &state)?
            }
        };
        let to_do: Vec<FoundProgram> =
            found.into_iter().filter(|found| !current.contains(&name(place(found)))).collect();
        if self.is_list {
            return list(&to_do).map(|()| ExitCode::SUCCESS);
        }
        let errors = self.work(&to_do, &keys, &mut sink)?;
        Ok(if errors == 0 { ExitCode::SUCCESS } else { ExitCode::from(STATUS_WITH_ERRORS) })
    }

    /// Predicts all programs on all processors; returns the number of lines with an error.
    fn work(
        &self,
        to_do: &[FoundProgram],
        keys: &ArchiveKeys,
        sink: &mut Sink,
    ) -> Result<usize, CommandError> {
        let jobs = self.jobs.map_or_else(available_parallelism, Ok);
        let threads = jobs.map_or(1, NonZero::get).min(to_do.len());
        let (next, is_over) = (AtomicUsize::new(0), AtomicBool::new(false));
        let (sender, lines) = channel();
        scope(|scope| {
            for _ in 0..threads {
                let (sender, next, is_over) = (sender.clone(), &next, &is_over);
                scope.spawn(move || {
                    while let Some(found) = to_do.get(next.fetch_add(1, Ordering::Relaxed)) {
                        if is_over.load(Ordering::Relaxed) || sender.send(self.line(found, keys)).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(sender);
            let outcome = collect(&lines, to_do.len(), sink);
            is_over.store(true, Ordering::Relaxed);
            outcome
        })
    }

    /// Returns the line of a program, and `true` if it contains an error.
    fn line(&self, found: &FoundProgram, keys: &ArchiveKeys) -> (String, bool) {
        let path = name(place(found));
        let failed = |key: Option<&str>, error: &str| {
            (ArchiveLine { path: &path, key, prediction: None, error: Some(error) }.to_line(), true)
        };
        let file = match found {
            Ok(file) => file,
            Err((_, error)) => return failed(None, error),
        };
        let bytes = match bytes_of(file) {
            Ok(bytes) => bytes,
            Err(refusal) => return failed(None, &refusal),
        };
        let key = keys.of(&bytes);
        match catch_unwind(AssertUnwindSafe(|| self.prediction(file, bytes))) {
            Ok(Err(refusal)) => failed(Some(&key), &refusal),
            Ok(Ok(prediction)) => {
                let line =
                    ArchiveLine { path: &path, key: Some(&key), prediction: Some(&prediction), error: None };
                (line.to_line(), false)
            }
            Err(panic) => failed(
                Some(&key),
                &format!("a fault of truefeed, please report it: {}", panic_message(&*panic)),
            ),
        }
    }

    /// Returns the prediction of a program; its tolerances are simulated one after another.
    fn prediction(&self, file: &Path, bytes: Vec<u8>) -> Result<Prediction, CommandError> {
        let toolpath = trace_text(bytes, &self.options, &self.machine);
        if let Some(reason) = declined(&toolpath) {
            return Err(reason);
        }
        let own = [Tolerances::Programmed];
        let given: Vec<Tolerances> = self.tolerances.iter().copied().map(Tolerances::One).collect();
        let tolerances = if given.is_empty() { &own[..] } else { &given };
        let quotes: Vec<_> = tolerances
            .iter()
            .map(|&tolerance| {
                let (plan, errors) = simulate::within(&toolpath, &self.machine, tolerance, &mut |_| {});
                quote(&toolpath, &self.machine, &plan, tolerance, &errors)
            })
            .collect();
        let called = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
        Ok(Prediction::new(&called, &toolpath, programmed_time(&toolpath, &self.machine), &quotes))
    }
}

/// Writes lines as they arrive, and reports progress; returns the number of lines with an error.
fn collect(lines: &Receiver<(String, bool)>, all: usize, sink: &mut Sink) -> Result<usize, CommandError> {
    let mut progress = Progress::new(all);
    loop {
        match lines.recv_timeout(progress.patience()) {
            Ok((line, is_error)) => {
                sink.put(&line)?;
                progress.done += 1;
                progress.errors += usize::from(is_error);
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        progress.say(false);
    }
    progress.say(true);
    Ok(progress.errors)
}

/// The progress of a run.
struct Progress {
    all: usize,
    done: usize,
    errors: usize,
    start: Instant,
    said: Instant,
    is_terminal: bool,
}

impl Progress {
    fn new(all: usize) -> Progress {
        let now = Instant::now();
        Progress { all, done: 0, errors: 0, start: now, said: now, is_terminal: stderr().is_terminal() }
    }

    /// Returns the time between two reports: a terminal shows one changing line, a file one line each.
    fn patience(&self) -> Duration {
        if self.is_terminal { Duration::from_millis(200) } else { Duration::from_secs(10) }
    }

    /// Reports progress if it is due; a closed standard error does not stop the run.
    fn say(&mut self, is_last: bool) {
        if !is_last && self.said.elapsed() < self.patience() {
            return;
        }
        self.said = Instant::now();
        let seconds = self.start.elapsed().as_secs_f64();
        let left = match self.done {
            0 => String::new(),
            done => format!(", {:.0} s left", seconds * (self.all - done) as f64 / done as f64),
        };
        let left = if is_last { format!(" in {seconds:.1} s") } else { left };
        let text = format!("{} of {} programs, {} with an error{left}", self.done, self.all, self.errors);
        let _ = match (self.is_terminal, is_last) {
            (true, false) => write!(stderr(), "\r\x1b[K{text}"),
            (true, true) => writeln!(stderr(), "\r\x1b[K{text}"),
            (false, _) => writeln!(stderr(), "{text}"),
        };
    }
}

/// Prints the programs, each as a line of JSON.
fn list(to_do: &[FoundProgram]) -> Result<(), CommandError> {
    let line = |found: &FoundProgram| {
        let path = name(place(found));
        ArchiveLine { path: &path, key: None, prediction: None, error: None }.to_line()
    };
    let lines: String = to_do.iter().map(line).collect();
    if lines.is_empty() { Ok(()) } else { print(lines.trim_end()) }
}

fn place(found: &FoundProgram) -> &Path {
    match found {
        Ok(path) | Err((path, _)) => path,
    }
}

/// Returns a path as unique text; bytes that are not UTF-8 as `\xFF`.
fn name(path: &Path) -> String {
    let mut name = String::new();
    for chunk in path.as_os_str().as_encoded_bytes().utf8_chunks() {
        name += chunk.valid();
        name.extend(chunk.invalid().iter().map(|byte| format!("\\x{byte:02X}")));
    }
    name
}

/// Returns the message of a panic.
fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".to_string())
}
