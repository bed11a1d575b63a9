//! Escaping of text in XML and HTML: pictures, and the reports that contain them.

/// Returns a text with its markup escaped and without the control characters that XML does not allow.
pub fn escaped(text: &str) -> String {
    let is_xml = |letter: &char| !letter.is_control() || matches!(letter, '\t' | '\n' | '\r');
    let text: String = text.chars().filter(is_xml).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
