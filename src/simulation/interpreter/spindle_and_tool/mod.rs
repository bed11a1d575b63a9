//! Machine functions: the waits for M, S and T words.
//!
//! S is a speed in rpm that the spindle takes up at M3 or M4, or at once if it runs. An S word alone stops the
//! motion only if the machine has a spindle ramp; otherwise there is no wait. S under G96 is a cutting speed, and
//! beside G4, G10, G50, G65, G66 and G92 it is not the spindle's; M5 and M19 stop the spindle, and so does a tool
//! change.
//!
//! A change to the tool that is in the spindle has no effect, as on most controls; the tool at the beginning is
//! unknown.

mod words;

/// Ten times the numbers of the G words beside which S is not a speed of the spindle.
const OTHER_SPEEDS: [u16; 6] = [40, 100, 500, 650, 660, 920];

/// The state of spindle and tool changer.
#[derive(Default)]
pub(super) struct Functions {
    /// The speed that the next M3 or M4 takes up, rpm.
    pub(super) speed: Option<f64>,
    /// `true` if S is a cutting speed, by G96.
    has_surface_speed: bool,
}

#[cfg(test)]
mod operations_tests;
#[cfg(test)]
mod tests;
