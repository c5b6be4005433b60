//! Provisions what a machine with only Rust and Python lacks: Embree, when the system has none of version 4.3 or later, so
//! that the first render is quick, and three.js for pages to walk through. Whatever goes wrong here is a warning, never an
//! error: the program then runs on its pure-Rust tracer, and asks for a copy of three.js when it needs one.
//! `LIGHTSHAFT_NO_PROVISION=1` turns it off.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};

const EMBREE_SCRIPT: &str = "vendor-bindings/provision.py";
const LIBRARIES: [&str; 2] = ["libembree4-4aef3270.so.4", "libtbb-dcf63f8c.so.12"];
const THREE_SCRIPT: &str = "vendor-bindings/three.py";
const THREE_FILES: [&str; 3] = ["build/three.module.js", "build/three.core.js", "LICENSE"];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed={EMBREE_SCRIPT}");
    println!("cargo:rerun-if-changed={THREE_SCRIPT}");
    println!("cargo:rerun-if-env-changed=LIGHTSHAFT_NO_PROVISION");
    println!("cargo:rustc-check-cfg=cfg(lightshaft_three)");
    if env::var_os("LIGHTSHAFT_NO_PROVISION").is_some_and(|value| !value.is_empty() && value != "0") {
        return;
    }
    let again = "`touch build.rs` tries again, LIGHTSHAFT_NO_PROVISION=1 silences this";
    if let Err(reason) = provision_embree() {
        println!(
            "cargo:warning=Embree was not provisioned ({reason}); without one of version 4.3 or later \
             the pure-Rust tracer is used. {again}"
        );
    }
    if let Err(reason) = provision_three() {
        println!(
            "cargo:warning=three.js was not provisioned ({reason}); `export --html` will ask for a copy. {again}"
        );
    }
}

fn provision_embree() -> Result<(), String> {
    let target = |key: &str| env::var(format!("CARGO_CFG_TARGET_{key}")).unwrap_or_default();
    let platform = (target("OS"), target("ARCH"), target("ENV"));
    if platform != ("linux".into(), "x86_64".into(), "gnu".into()) {
        return Err(format!("there is no copy for {} {}: install Embree yourself", platform.0, platform.1));
    }
    let cache = cache("embree-4.4.0")?;
    if run(EMBREE_SCRIPT, &cache)? != "provisioned" {
        return Ok(());
    }
    let library = cache.join(LIBRARIES[0]);
    println!("cargo:rustc-env=LIGHTSHAFT_PROVISIONED_EMBREE={}", library.display());
    // Should somebody delete the copy, it is fetched again.
    println!("cargo:rerun-if-changed={}", library.display());
    // Also beside the executable, where it is found when the folder is moved.
    if let Some(profile) = profile() {
        for name in LIBRARIES {
            place(&cache.join(name), &profile.join(name));
        }
    }
    Ok(())
}

/// The files become part of the program.
fn provision_three() -> Result<(), String> {
    let cache = cache("three-0.187.0")?;
    run(THREE_SCRIPT, &cache)?;
    println!("cargo:rustc-env=LIGHTSHAFT_PROVISIONED_THREE={}", cache.display());
    println!("cargo:rustc-cfg=lightshaft_three");
    for name in THREE_FILES {
        println!("cargo:rerun-if-changed={}", cache.join(name).display());
    }
    Ok(())
}

/// Where a copy is kept: beside the profiles, so that the next profile need not download it; where cargo uses another
/// layout, in its folder for this build.
fn cache(name: &str) -> Result<PathBuf, String> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?);
    Ok(profile().as_deref().and_then(Path::parent).unwrap_or(&out).join(name))
}

/// `OUT_DIR` is `<target>/<profile>/build/<package>/out`.
fn profile() -> Option<PathBuf> {
    let out = PathBuf::from(env::var_os("OUT_DIR")?);
    let build = out.ancestors().find(|folder| folder.file_name().is_some_and(|name| name == "build"));
    Some(build?.parent()?.to_owned())
}

/// What a script says that fills this folder.
fn run(script: &str, folder: &Path) -> Result<String, String> {
    let output = Command::new("python3")
        .arg(script)
        .arg(folder)
        .output()
        .map_err(|error| format!("python3 cannot be run: {error}"))?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr);
        return Err(message.lines().last().unwrap_or("python3 failed").to_owned());
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Links or copies the file; on failure the copy in the cache still serves.
fn place(from: &Path, to: &Path) {
    if fs::metadata(to).ok().map(|file| file.len()) == fs::metadata(from).ok().map(|file| file.len()) {
        return;
    }
    let _ = fs::remove_file(to);
    if fs::hard_link(from, to).is_err() {
        let _ = fs::copy(from, to);
    }
}
