//! Faults in texts of machines, jobs and settings.

/// A fault in the text of a machine.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}{}{message}", line_and_column(.place), .key.as_ref().map(|key| format!("{key}: ")).unwrap_or_default())]
pub struct TextFault {
    /// Line and column in the text, 1-based, if there is a text.
    pub place: Option<(usize, usize)>,
    /// Key, if the fault concerns one.
    pub key: Option<String>,
    /// Description of the fault and of a valid value.
    pub message: String,
}

fn line_and_column(place: &Option<(usize, usize)>) -> String {
    place.map(|(line, column)| format!("line {line}, column {column}: ")).unwrap_or_default()
}

impl TextFault {
    /// Returns a fault in the value of a parameter.
    pub(in crate::project) fn at_key(key: &str, message: String) -> TextFault {
        TextFault { place: None, key: Some(key.to_string()), message }
    }
}
