//! The module of a first visit: the whole one without the exports that are asked for later, and without what only they need.
//!
//! Both are of one compilation and one script: an export has the same name and does the same in both, so that the script works
//! with either. Where a class `Name` is asked for later, so are its exports `name_…`, `__wbg_name_free`, `__wbg_get_name_…` and
//! `__wbg_set_name_…`, as wasm-bindgen names them. What can be called through a table stays, since a table does not say by whom.

use std::path::Path;

use anyhow::{Result, anyhow, ensure};
use walrus::Module;

/// Writes the module without what these names say.
pub fn leave_out(whole: &Path, first: &Path, names: &[String]) -> Result<()> {
    let mut module = Module::from_file(whole).map_err(|error| anyhow!("{}: {error:#}", whole.display()))?;
    for name in names {
        let exports: Vec<_> = module
            .exports
            .iter()
            .filter(|export| is_of(&export.name, name))
            .map(|export| export.id())
            .collect();
        ensure!(!exports.is_empty(), "no export is of `{name}`, which is to be left out");
        exports.into_iter().for_each(|export| module.exports.delete(export));
    }
    walrus::passes::gc::run(&mut module);
    module.emit_wasm_file(first).map_err(|error| anyhow!("{}: {error:#}", first.display()))
}

/// Whether an export is the function of this name, or of the class of this name.
fn is_of(export: &str, name: &str) -> bool {
    let class = format!("{}_", name.to_lowercase());
    let own = ["__wbg_get_", "__wbg_set_", "__wbg_"].iter().find_map(|prefix| export.strip_prefix(prefix));
    export == name || own.unwrap_or(export).starts_with(&class)
}
