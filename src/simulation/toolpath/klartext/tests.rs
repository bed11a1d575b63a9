//! Laws of running Klartext programs.
