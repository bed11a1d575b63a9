//! Laws of reading Klartext lines.
