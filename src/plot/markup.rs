//! Text in XML: pictures, and the reports they stand in.

/// A text that is no markup, as XML takes it: without the control characters that it cannot have.
pub fn escaped(text: &str) -> String {
    let is_xml = |letter: &char| !letter.is_control() || matches!(letter, '\t' | '\n' | '\r');
    let text: String = text.chars().filter(is_xml).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
