//! The build command: crate → WebAssembly module → JavaScript bindings → optimised package.
//!
//! Settings stand in `wasm-pack.toml` of the current directory ([`Settings`]). Three tools do the
//! work: Cargo compiles, `wasm-bindgen-cli-support` writes the bindings, and `wasm-opt` of npm's
//! `binaryen` optimises. (Debian's `wasm-opt` 108 reports success and writes a module that
//! browsers refuse.) The package has two modules: the whole one, and what a first visit needs of it ([`later`]).
//!
//! The package is made beside its place and then moved there, so that a failed build leaves the
//! previous one, and no file of the previous one stays. In the end the list of the page's files is
//! written, from which it works without a network ([`files`]).

mod files;
mod later;

use std::env;
use std::ffi::OsString;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use anyhow::{Context, Result, bail, ensure};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Deserialize;
use wasm_bindgen_cli_support::Bindgen;

const SETTINGS: &str = "wasm-pack.toml";
const WASM_TARGET: &str = "wasm32-unknown-unknown";
const WASM_OPT: &str = "node_modules/binaryen/bin/wasm-opt";

/// What `wasm-pack.toml` says; every key is required and no other is known.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Settings {
    /// Cargo profile.
    profile: String,
    /// How JavaScript loads the package.
    target: Target,
    /// Where the package goes; its previous content is replaced.
    out_dir: PathBuf,
    /// File name of the package, without extension.
    out_name: String,
    /// Flags for rustc. They replace those of the environment, so that the file says all.
    rustflags: Vec<String>,
    /// Classes and functions that the module of a first visit leaves out.
    later: Vec<String>,
    /// Arguments of `wasm-opt`; none leaves it out.
    wasm_opt: Vec<String>,
}

/// Kinds of package, by the name `wasm-pack --target` gives them.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Target {
    /// An ES module that a page loads without a bundler.
    Web,
}

fn main() -> ExitCode {
    match build() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("the page was not built: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Runs the steps in order and says what each one does.
fn build() -> Result<()> {
    let text = fs::read_to_string(SETTINGS).with_context(|| format!("cannot read {SETTINGS}"))?;
    let settings: Settings = toml::from_str(&text).context(SETTINGS)?;

    println!("compiling for {WASM_TARGET}, profile {}", settings.profile);
    let module = compile(&settings)?;

    println!("writing the bindings");
    let package = settings.out_dir.with_extension("new");
    remove_if_there(&package)?;
    write_bindings(&settings, &module, &package)?;

    let first = package.join(format!("{}_bg.wasm", settings.out_name));
    let whole = package.join(format!("{}_whole_bg.wasm", settings.out_name));
    fs::rename(&first, &whole).context("cannot rename the module")?;
    println!("  {}", size(&whole)?);
    if !settings.wasm_opt.is_empty() {
        println!("optimising: wasm-opt {}", settings.wasm_opt.join(" "));
        optimise(&whole, &settings.wasm_opt)?;
        println!("  {}", size(&whole)?);
    }
    // After the optimiser, which takes long enough once.
    println!("leaving out what is asked for later");
    later::leave_out(&whole, &first, &settings.later)?;
    println!("  {}", size(&first)?);

    remove_if_there(&settings.out_dir)?;
    fs::rename(&package, &settings.out_dir)
        .with_context(|| format!("cannot move the package to {}", settings.out_dir.display()))?;
    println!("the package is in {}", settings.out_dir.display());
    files::write(&settings.out_dir)?;
    Ok(())
}

/// Compiles the library and returns the path of its WebAssembly module, as Cargo reports it.
fn compile(settings: &Settings) -> Result<PathBuf> {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let output = Command::new(cargo)
        .args(["build", "--lib", "--target", WASM_TARGET])
        .args(["--profile", &settings.profile])
        .arg("--message-format=json-render-diagnostics")
        .env("CARGO_ENCODED_RUSTFLAGS", settings.rustflags.join("\x1f"))
        .stderr(Stdio::inherit())
        .output()
        .context("cannot run cargo")?;
    ensure!(output.status.success(), "cargo build failed");

    let messages = String::from_utf8(output.stdout).context("cargo's messages are not UTF-8")?;
    for line in messages.lines() {
        let message: serde_json::Value =
            serde_json::from_str(line).context("a message of cargo is not JSON")?;
        // Among the dependencies only libraries are built, so the one module is the crate's.
        let module = message["filenames"].as_array().into_iter().flatten();
        let mut module = module.filter_map(|name| name.as_str()).filter(|name| name.ends_with(".wasm"));
        if let Some(path) = module.next() {
            return Ok(PathBuf::from(path));
        }
    }
    bail!("cargo built no WebAssembly module; is `cdylib` among the crate types?")
}

/// Writes the module and its JavaScript and TypeScript sides into the folder `package`.
fn write_bindings(settings: &Settings, module: &Path, package: &Path) -> Result<()> {
    let mut bindgen = Bindgen::new();
    match settings.target {
        Target::Web => bindgen.web(true)?,
    };
    bindgen
        .input_path(module)
        .out_name(&settings.out_name)
        .typescript(true)
        // Without an argument, `init()` then finds the module beside the script.
        .omit_default_module_path(false)
        .generate(package)
        .context("wasm-bindgen failed")
}

/// Replaces the module by what `wasm-opt` makes of it.
fn optimise(wasm: &Path, arguments: &[String]) -> Result<()> {
    ensure!(Path::new(WASM_OPT).exists(), "{WASM_OPT} is missing; run scripts/setup first");
    let optimised = wasm.with_extension("optimised");
    let status = Command::new("node")
        .arg(WASM_OPT)
        .args(arguments)
        .arg(wasm)
        .arg("-o")
        .arg(&optimised)
        .status()
        .context("cannot run node")?;
    ensure!(status.success(), "wasm-opt failed");
    fs::rename(&optimised, wasm).context("cannot replace the module")
}

/// Size of a file on disk and on its way to a browser.
fn size(path: &Path) -> Result<String> {
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut gzip = GzEncoder::new(Vec::new(), Compression::best());
    gzip.write_all(&bytes)?;
    let sent = gzip.finish()?.len();
    Ok(format!("{} kB, {} kB with gzip", bytes.len().div_ceil(1000), sent.div_ceil(1000)))
}

/// Removes a folder that may not exist.
fn remove_if_there(folder: &Path) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder).with_context(|| format!("cannot remove {}", folder.display()))?;
    }
    Ok(())
}
