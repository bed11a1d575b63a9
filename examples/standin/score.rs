//! x
pub fn page(_: &std::path::Path, _: &std::path::Path) -> Result<String, Box<dyn std::error::Error>> { Ok(String::new()) }
