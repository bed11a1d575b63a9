//! The offer of one program: its request, and its report as JSON, CSV and HTML.

pub mod csv;
pub mod facts;
pub mod html;
pub mod report;
pub mod request;
