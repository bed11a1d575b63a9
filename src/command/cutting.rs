//! The part of `predict` for `--cutting`: the job, the cut, and the loads at each tolerance.

use std::path::Path;

use truefeed::cutting::{CuttingError, Engagement, LoadCurve, Setup, engagement, programmed_and_predicted};
use truefeed::machine::Machine;
use truefeed::project::{
    Prediction, cutting_from_toml, cutting_refusal, cutting_remarks, cutting_table, loads_csv,
};
use truefeed::simulation::profile::FeedCurve;
use truefeed::simulation::toolpath::Toolpath;

use crate::command::CommandError;
use crate::command::input::settings_of;
use crate::command::output::Output;

/// A cut along a toolpath, with its loads so far, one entry per tolerance.
pub struct CutForces {
    setup: Setup,
    engagement: Result<Engagement, CuttingError>,
    loads: Vec<Result<[LoadCurve; 2], CuttingError>>,
    forces: Option<Output>,
}

impl CutForces {
    /// Returns the cut of a job; the loads at the first tolerance are written to `forces`.
    pub fn new(
        job: &Path,
        forces: Option<Output>,
        machine: &Machine,
        toolpath: &Toolpath,
    ) -> Result<CutForces, CommandError> {
        let setup = cutting_from_toml(&settings_of(job)?, machine);
        let setup = setup.map_err(|fault| format!("{}: {fault}", job.display()))?;
        let engagement = engagement(toolpath, &setup);
        Ok(CutForces { setup, engagement, loads: Vec::new(), forces })
    }

    /// Adds the loads at a tolerance, given its profile.
    pub fn load(&mut self, toolpath: &Toolpath, curve: &FeedCurve) -> Result<(), CommandError> {
        let Ok(engagement) = &self.engagement else { return Ok(()) };
        let both = programmed_and_predicted(engagement, toolpath, &self.setup, curve, &mut |_| {});
        if let (true, Some(forces), Ok(both)) = (self.loads.is_empty(), &self.forces, &both) {
            forces.write(&loads_csv(engagement, both))?;
        }
        self.loads.push(both);
        Ok(())
    }

    /// Returns a prediction with all computed loads.
    pub fn added_to(&self, prediction: Prediction) -> Prediction {
        prediction.with_cutting(&self.setup, &self.engagement, &self.loads)
    }

    /// Returns the peaks at the first tolerance, and remarks, for people.
    pub fn text(&self, toolpath: &Toolpath) -> String {
        let line = |(line, is_error, text): (u32, bool, String)| {
            let severity = if is_error { "error" } else { "warning" };
            let place = if line == 0 { String::new() } else { format!("line {line}: ") };
            format!("\n{severity}: {place}{text}")
        };
        match (&self.engagement, self.loads.first()) {
            (Err(error), _) | (_, Some(Err(error))) => line(cutting_refusal(error)),
            (Ok(engagement), Some(Ok(both))) => {
                let remarks: String =
                    cutting_remarks(engagement, &self.setup, both).into_iter().map(line).collect();
                format!("\n{}{remarks}", cutting_table(&self.setup, toolpath, both))
            }
            (Ok(_), None) => String::new(),
        }
    }
}
