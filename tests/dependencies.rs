//! What comes with us from elsewhere: licences that we may pass on, and no version with a known vulnerability.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Licences that ask for no more than their text and notice. Weak copyleft, where it is, is named with its package below.
const ALLOWED: [&str; 14] = [
    "MIT",
    "MIT-0",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-1-Clause",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "ISC",
    "Zlib",
    "0BSD",
    "BSL-1.0",
    "CC0-1.0",
    "Unicode-3.0",
    "Unlicense",
];

/// Whether one of the choices that an SPDX expression leaves is allowed as a whole.
fn is_allowed(expression: &str) -> bool {
    // The slash is how Cargo wrote OR before 2016.
    let text = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let words: Vec<&str> = text.split_whitespace().collect();
    let mut rest = &words[..];
    let allowed = any(&mut rest);
    allowed && rest.is_empty()
}

/// `all { OR all }`
fn any(rest: &mut &[&str]) -> bool {
    let mut allowed = all(rest);
    while rest.first() == Some(&"OR") {
        *rest = &rest[1..];
        allowed |= all(rest);
    }
    allowed
}

/// `one { AND one }`
fn all(rest: &mut &[&str]) -> bool {
    let mut allowed = one(rest);
    while rest.first() == Some(&"AND") {
        *rest = &rest[1..];
        allowed &= one(rest);
    }
    allowed
}

/// `"(" any ")"` or a licence with its exception.
fn one(rest: &mut &[&str]) -> bool {
    let Some((first, after)) = rest.split_first() else { return false };
    *rest = after;
    if *first == "(" {
        let allowed = any(rest);
        *rest = rest.get(1..).unwrap_or(&[]);
        return allowed;
    }
    match after {
        ["WITH", exception, others @ ..] => {
            *rest = others;
            ALLOWED.contains(&format!("{first} WITH {exception}").as_str())
        }
        _ => ALLOWED.contains(first),
    }
}

#[test]
fn expressions_of_licences_are_read() {
    for allowed in [
        "MIT",
        "MIT OR GPL-3.0-only",
        "MIT/Apache-2.0",
        "(MIT OR Apache-2.0) AND Unicode-3.0",
        "Apache-2.0 WITH LLVM-exception OR GPL-2.0-only",
    ] {
        assert!(is_allowed(allowed), "{allowed}");
    }
    for refused in [
        "",
        "GPL-3.0-only",
        "MIT AND GPL-3.0-only",
        "(MIT OR Apache-2.0) AND SSPL-1.0",
        "Apache-2.0 WITH Some-exception",
        "MIT MIT",
    ] {
        assert!(!is_allowed(refused), "{refused}");
    }
}

fn cargo(arguments: &[&str], folder: &str) -> Result<Vec<u8>, String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let output = Command::new(env!("CARGO"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("Cargo runs the tests");
    if output.status.success() {
        Ok(output.stdout)
    } else {
        Err(String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

#[test]
fn every_package_may_be_passed_on() {
    for folder in [".", "scripts/build-web"] {
        let asked = ["metadata", "--locked", "--format-version", "1"];
        // What is for other systems may not have been fetched.
        let metadata =
            cargo(&[&asked[..], &["--offline"]].concat(), folder).or_else(|_| cargo(&asked, folder));
        let metadata = match metadata {
            Ok(metadata) => metadata,
            Err(reason) => return println!("skipped: not all packages can be fetched here: {reason}"),
        };
        let metadata: Value = serde_json::from_slice(&metadata).expect("Cargo writes JSON");
        let packages = metadata["packages"].as_array().expect("packages");
        assert!(5 < packages.len(), "{} packages in {folder}", packages.len());
        for package in packages.iter().filter(|package| !package["source"].is_null()) {
            let licence = package["license"].as_str().unwrap_or("");
            assert!(is_allowed(licence), "{} {}: “{licence}”", package["name"], package["version"]);
        }
        println!("{folder}: {} packages", packages.len());
    }
}

#[test]
fn every_tool_from_npm_may_be_used() {
    let lock =
        std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("package-lock.json")).expect("it is there");
    let lock: Value = serde_json::from_slice(&lock).expect("npm writes JSON");
    let packages = lock["packages"].as_object().expect("packages");
    // What only tests is not passed on, so that its users need not pass it on under its licence either.
    let may_be_used = |licence: &str| is_allowed(licence) || licence == "MPL-2.0";
    for (name, package) in packages.iter().filter(|(name, _)| !name.is_empty()) {
        assert!(may_be_used(package["license"].as_str().unwrap_or("")), "{name}: {}", package["license"]);
    }
}

/// Where the database is out of reach this says that it was skipped, and so does scripts/test at its end.
#[test]
fn no_version_has_a_known_vulnerability() {
    if cargo(&["audit", "--version"], ".").is_err() {
        return println!(
            "skipped: cargo audit is not there; scripts/setup installs it where its database can be fetched"
        );
    }
    for folder in [".", "scripts/build-web"] {
        // It exits with an error where it finds something as well as where it cannot look.
        let output = Command::new(env!("CARGO"))
            .args(["audit", "--json"])
            .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(folder))
            .output()
            .expect("it was there");
        let Ok(report) = serde_json::from_slice::<Value>(&output.stdout) else {
            let reason = String::from_utf8_lossy(&output.stderr);
            return println!("skipped: the database of advisories cannot be fetched: {}", reason.trim());
        };
        let found = &report["vulnerabilities"];
        assert_eq!(found["found"], Value::Bool(false), "{folder}: {:#}", found["list"]);
    }
}
