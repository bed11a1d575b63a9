//! One run of the tool under test: what it says, what it refuses, and how long it takes. What was said is kept, and
//! not asked again.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use serde_json::{Value, json};

use crate::Refusal;

/// The longest that anybody waits for an answer, s.
const PATIENCE: &str = "900";

/// Runs `truefeed` with these words, or reads what it said the last time from `kept`. The result has `seconds`, and
/// `report` or `refused`.
pub fn ask(truefeed: &Path, words: &[&str], kept: &Path) -> Result<Value, Refusal> {
    if let Ok(bytes) = std::fs::read(kept) {
        return Ok(serde_json::from_slice(&bytes)?);
    }
    let start = Instant::now();
    let output = Command::new("timeout").arg(PATIENCE).arg(truefeed).args(words).arg("--json").output()?;
    let seconds = start.elapsed().as_secs_f64();
    let answer = if output.status.success() {
        let report: Value = serde_json::from_slice(&output.stdout)?;
        json!({ "seconds": seconds, "report": report })
    } else {
        let said = String::from_utf8_lossy(&output.stderr);
        // Who was ended from outside has said nothing.
        let status = output.status.code().ok_or_else(|| format!("{words:?} was ended by a signal"))?;
        json!({ "seconds": seconds, "refused": said.trim(), "exit_status": status })
    };
    std::fs::write(kept, serde_json::to_string(&answer)?)?;
    Ok(answer)
}
