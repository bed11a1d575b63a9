//! The recorder of a control, run once for each recording.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Refusal;
use crate::machine::Family;
use crate::planners;
use crate::trace::Trace;

/// Which control is recorded, and for LinuxCNC where its recorder is and how it is run.
pub struct Recorder {
    pub family: Family,
    pub script: PathBuf,
    pub nice: i32,
    /// How many times faster than in reality.
    pub speed: f64,
    /// How long the recorder may take for a program, s.
    pub wall_limit_s: f64,
}

/// How long the recorder of LinuxCNC may take for a program of less than two minutes, s.
pub const WALL_LIMIT_S: f64 = 120.0;

/// What came of a recording.
pub enum Outcome {
    Recorded(Trace),
    /// In the words of the recorder, where it says why.
    Refused(String),
}

impl Recorder {
    /// Records `program` with a row every `every` milliseconds. `raw` is written and removed again. The recorder itself
    /// repeats what the host disturbed; what the controller refuses comes back as refused.
    pub fn record(
        &self,
        program: &Path,
        raw: &Path,
        every: usize,
        options: &[String],
    ) -> Result<Outcome, Refusal> {
        if self.family != Family::LinuxCnc {
            return planners::record(self.family, program, every, options);
        }
        let output = Command::new("nice")
            .args(["-n", &self.nice.to_string(), "python3"])
            .arg(&self.script)
            .arg("--gcode")
            .arg(program)
            .arg("--out")
            .arg(raw)
            .args(["--columns", "fb", "--prefill", "200", "--wall-limit", &self.wall_limit_s.to_string()])
            // Without it a program that asks for no path mode has the one of a start-up that is not the same each time.
            .args(["--default-path", "G64"])
            .args(["--every", &every.to_string(), "--speed", &self.speed.to_string()])
            .args(options)
            .output()?;
        let meta = PathBuf::from(format!("{}.meta.json", raw.display()));
        let said =
            String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        self.clear_up(&said);
        let outcome = if output.status.success() {
            Outcome::Recorded(Trace::read(raw)?)
        } else {
            Outcome::Refused(
                said.lines().find(|line| line.contains("FAILED")).unwrap_or(said.trim()).to_string(),
            )
        };
        for file in [raw, &meta] {
            if file.exists() {
                std::fs::remove_file(file)?;
            }
        }
        Ok(outcome)
    }

    /// Removes the folders that the recorder keeps of runs that failed.
    fn clear_up(&self, said: &str) {
        for line in said.lines() {
            let folder = line.split("work directory kept: ").nth(1).map(Path::new);
            if let Some(folder) = folder.filter(|folder| folder.starts_with("/var/tmp")) {
                // A folder left behind harms nothing.
                let _ = std::fs::remove_dir_all(folder);
            }
        }
    }
}
