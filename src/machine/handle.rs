//! Typed handles into the table of machine parameters.

use crate::machine::{Access, Machine, Parameter, parameter};

/// A machine parameter: a row of the parameter table, or an entry of a row that is a table by number.
#[derive(Clone, Copy)]
pub struct Handle {
    row: &'static Parameter,
    entry: Option<u32>,
}

impl Handle {
    /// Returns the handle of the number with this key.
    ///
    /// # Panics
    ///
    /// Panics if the table has no number under the key.
    pub fn number(key: &str) -> Handle {
        let row = parameter(key).filter(|row| matches!(row.access, Access::Number { .. }));
        Handle { row: row.unwrap_or_else(|| panic!("{key} is a number of the table")), entry: None }
    }

    /// Returns the handle of an entry of the table by number with this key.
    ///
    /// # Panics
    ///
    /// Panics if there is no such table under the key.
    pub fn entry(key: &str, number: u32) -> Handle {
        let row = parameter(key).filter(|row| matches!(row.access, Access::Codes { .. }));
        let row = row.unwrap_or_else(|| panic!("{key} is a table by number"));
        Handle { row, entry: Some(number) }
    }

    /// Returns the handle of the row with this key, whatever the type of its value.
    ///
    /// # Panics
    ///
    /// Panics if the table has no such row.
    pub fn row(key: &str) -> Handle {
        Handle { row: parameter(key).unwrap_or_else(|| panic!("{key} is a row of the table")), entry: None }
    }

    /// Returns the key in the machine file; the key of an entry ends with its word, such as
    /// `times.m_codes.M8`.
    pub fn key(&self) -> String {
        match (&self.row.access, self.entry) {
            (Access::Codes { letter, .. }, Some(number)) => format!("{}.{letter}{number}", self.row.key),
            _ => self.row.key.to_string(),
        }
    }

    /// Returns the table of the machine file that contains the parameter, such as `path` or `times`.
    pub fn table(&self) -> &'static str {
        self.row.key.split('.').next().unwrap_or_default()
    }

    /// Returns the parameter's value on a machine, core units; `None` if the machine has none.
    pub fn get(&self, machine: &Machine) -> Option<f64> {
        match (&self.row.access, self.entry) {
            (Access::Number { get, .. }, _) => get(machine),
            (Access::Codes { get, .. }, Some(number)) => get(machine).get(&number).copied(),
            _ => None,
        }
    }

    /// Sets the parameter's value (core units) on a machine.
    pub fn set(&self, machine: &mut Machine, value: f64) {
        match (&self.row.access, self.entry) {
            (Access::Number { set, .. }, _) => set(machine, Some(value)),
            (Access::Codes { get_mut, .. }, Some(number)) => {
                get_mut(machine).insert(number, value);
            }
            _ => {}
        }
    }
}

impl PartialEq for Handle {
    fn eq(&self, other: &Handle) -> bool {
        self.row.key == other.row.key && self.entry == other.entry
    }
}

impl std::fmt::Debug for Handle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.key())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn handles_reach_numbers_and_entries_of_tables() {
        let mut machine = Machine::default();
        for (handle, key) in [
            (Handle::number("path.jerk_mm_s3"), "path.jerk_mm_s3"),
            (Handle::entry("times.m_codes", 8), "times.m_codes.M8"),
            (Handle::entry("halts.waits", 12), "halts.waits.L12"),
        ] {
            assert_eq!((handle.key().as_str(), handle.get(&machine)), (key, None));
            handle.set(&mut machine, 2.5);
            assert_eq!(handle.get(&machine), Some(2.5), "{key}");
        }
        assert_eq!((machine.path.jerk, machine.times.m_codes[&8], machine.halts.waits[&12]), (2.5, 2.5, 2.5));
        assert_eq!(Handle::number("path.jerk_mm_s3").table(), "path");
        assert_ne!(Handle::entry("times.m_codes", 8), Handle::entry("times.m_codes", 9));
        assert_eq!(Handle::row("interpolator.junction_rule").get(&machine), None);
    }
}
