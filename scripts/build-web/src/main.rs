//! The build command: crate → WebAssembly module → JavaScript bindings → optimised package.
//!
//! Settings stand in `wasm-pack.toml` of the current directory ([`Settings`]). Three tools do the
//! work: Cargo compiles, `wasm-bindgen-cli-support` writes the bindings, and `wasm-opt` of npm's
//! `binaryen` optimises. (Debian's `wasm-opt` 108 reports success and writes a module that
//! browsers refuse.) The package has two modules, each with a script of its own: what a first visit needs, made small, and
//! the whole, made quick. Beside them are the licences of what they carry ([`notices`]). In the end each file is compressed
//! once, as well as it can be (`scripts/compress.mjs`).
//!
//! The package is made beside its place and then moved there, so that a failed build leaves the
//! previous one, and no file of the previous one stays. In the end the list of the page's files is
//! written, from which it works without a network ([`files`]).
//!
//! With `--quick` the build skips `wasm-opt`, which takes minutes. The modules compute the same results but are larger, so this
//! package is for tests only. It contains the file [`QUICK`], and the scripts that publish a package refuse one with this file.

mod files;
mod notices;

use std::env;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::Write;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::thread;

use anyhow::{Context, Result, bail, ensure};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Deserialize;
use wasm_bindgen_cli_support::Bindgen;

const SETTINGS: &str = "wasm-pack.toml";
const WASM_TARGET: &str = "wasm32-unknown-unknown";
const WASM_OPT: &str = "node_modules/binaryen/bin/wasm-opt";
const COMPRESS: &str = "scripts/compress.mjs";
/// The file that marks the package of a quick build.
const QUICK: &str = "quick-build";

/// What `wasm-pack.toml` says; every key is required and no other is known.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Settings {
    /// How JavaScript loads the package.
    target: Target,
    /// Where the package goes; its previous content is replaced.
    out_dir: PathBuf,
    /// The modules of the package.
    module: Vec<Module>,
}

/// One module with its script.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Module {
    /// File name, without extension.
    out_name: String,
    /// Cargo profile.
    profile: String,
    /// What the crate is told by `--cfg`, and no other crate.
    cfg: Vec<String>,
    /// Flags for rustc, applied to the crate and its dependencies. They replace the flags in the environment.
    rustflags: Vec<String>,
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
    let options: Vec<String> = env::args().skip(1).collect();
    let is_quick = options == ["--quick"];
    if !is_quick && !options.is_empty() {
        eprintln!("unknown options {options:?}; there is: --quick");
        return ExitCode::FAILURE;
    }
    match build(is_quick) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("the page was not built: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Runs the steps in order and says what each one does.
fn build(is_quick: bool) -> Result<()> {
    let kind =
        if is_quick { "quick build, without wasm-opt: for tests only" } else { "build that is delivered" };
    println!("{kind}");
    let text = fs::read_to_string(SETTINGS).with_context(|| format!("cannot read {SETTINGS}"))?;
    let mut settings: Settings = toml::from_str(&text).context(SETTINGS)?;
    if is_quick {
        settings.module.iter_mut().for_each(|module| module.wasm_opt.clear());
    }

    let package = settings.out_dir.with_extension("new");
    remove_if_there(&package)?;
    // Each module is compiled whole, on one core for most of the time: they are made side by side.
    thread::scope(|scope| {
        let made: Vec<_> =
            settings.module.iter().map(|module| scope.spawn(|| make(&settings, module, &package))).collect();
        made.into_iter().try_for_each(|made| made.join().unwrap_or_else(|panic| resume_unwind(panic)))
    })?;
    notices::write(&package)?;
    if is_quick {
        fs::write(package.join(QUICK), "of scripts/build --quick, for tests only\n")
            .with_context(|| format!("cannot write {QUICK}"))?;
    }
    println!("compressing");
    run_node(COMPRESS, [&package])?;

    remove_if_there(&settings.out_dir)?;
    fs::rename(&package, &settings.out_dir)
        .with_context(|| format!("cannot move the package to {}", settings.out_dir.display()))?;
    println!("the package is in {} ({kind})", settings.out_dir.display());
    files::write(&settings.out_dir)?;
    Ok(())
}

/// Compiles one module and puts it into the folder `package`, optimised and with its script.
fn make(settings: &Settings, module: &Module, package: &Path) -> Result<()> {
    let name = &module.out_name;
    println!("{name}: compiling for {WASM_TARGET}, profile {}", module.profile);
    let compiled = compile(module)?;
    println!("{name}: writing the bindings");
    write_bindings(settings, module, &compiled, package)?;
    let wasm = package.join(format!("{name}_bg.wasm"));
    println!("{name}: {}", size(&wasm)?);
    if !module.wasm_opt.is_empty() {
        println!("{name}: optimising: wasm-opt {}", module.wasm_opt.join(" "));
        optimise(&wasm, &module.wasm_opt)?;
        println!("{name}: {}", size(&wasm)?);
    }
    leave_out_comments(&package.join(format!("{name}.js")))
}

/// Compiles the library and returns the path of its WebAssembly module, as Cargo reports it.
fn compile(module: &Module) -> Result<PathBuf> {
    let output = cargo()
        .args(["rustc", "--lib", "--crate-type", "cdylib", "--target", WASM_TARGET])
        .args(["--profile", &module.profile])
        .arg("--message-format=json-render-diagnostics")
        .arg("--")
        .args(module.cfg.iter().flat_map(|cfg| ["--cfg", cfg]))
        .env("CARGO_ENCODED_RUSTFLAGS", module.rustflags.join("\x1f"))
        .stderr(Stdio::inherit())
        .output()
        .context("cannot run cargo")?;
    ensure!(output.status.success(), "cargo failed");

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

/// The Cargo that runs this command.
fn cargo() -> Command {
    Command::new(env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo")))
}

/// Writes the module and its JavaScript and TypeScript sides into the folder `package`.
fn write_bindings(settings: &Settings, module: &Module, compiled: &Path, package: &Path) -> Result<()> {
    let mut bindgen = Bindgen::new();
    match settings.target {
        Target::Web => bindgen.web(true)?,
    };
    bindgen
        .input_path(compiled)
        .out_name(&module.out_name)
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
    let paths = [wasm.as_os_str(), "-o".as_ref(), optimised.as_os_str()];
    run_node(WASM_OPT, arguments.iter().map(|argument| argument.as_ref()).chain(paths))?;
    fs::rename(&optimised, wasm).context("cannot replace the module")
}

/// Runs a script with Node.
fn run_node<A: AsRef<OsStr>>(script: &str, arguments: impl IntoIterator<Item = A>) -> Result<()> {
    let status = Command::new("node").arg(script).args(arguments).status().context("cannot run node")?;
    ensure!(status.success(), "{script} failed");
    Ok(())
}

/// Leaves the comments out of a script of wasm-bindgen, which has the same ones in the types beside it.
fn leave_out_comments(script: &Path) -> Result<()> {
    let text = fs::read_to_string(script).with_context(|| format!("cannot read {}", script.display()))?;
    let mut kept = String::with_capacity(text.len());
    let mut is_inside = false;
    for line in text.lines() {
        let code = line.trim_start();
        is_inside |= code.starts_with("/**");
        if !is_inside && !code.is_empty() {
            kept.push_str(code);
            kept.push('\n');
        }
        is_inside &= !code.ends_with("*/");
    }
    fs::write(script, kept).with_context(|| format!("cannot write {}", script.display()))
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
