//! Provisions Embree when the system has none of version 4.3 or later, so that a machine with only
//! Rust and Python renders with it. Whatever goes wrong here is a warning, never an error: the
//! program then runs on its pure-Rust tracer. `LIGHTSHAFT_NO_PROVISION=1` turns it off.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};

const SCRIPT: &str = "vendor-bindings/provision.py";
const LIBRARIES: [&str; 2] = ["libembree4-4aef3270.so.4", "libtbb-dcf63f8c.so.12"];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed={SCRIPT}");
    println!("cargo:rerun-if-env-changed=LIGHTSHAFT_NO_PROVISION");
    if env::var_os("LIGHTSHAFT_NO_PROVISION").is_some_and(|value| !value.is_empty() && value != "0") {
        return;
    }
    if let Err(reason) = provision() {
        println!(
            "cargo:warning=Embree was not provisioned ({reason}); without one of version 4.3 or later \
             the pure-Rust tracer is used. `touch build.rs` tries again, LIGHTSHAFT_NO_PROVISION=1 \
             silences this"
        );
    }
}

fn provision() -> Result<(), String> {
    let target = |key: &str| env::var(format!("CARGO_CFG_TARGET_{key}")).unwrap_or_default();
    let platform = (target("OS"), target("ARCH"), target("ENV"));
    if platform != ("linux".into(), "x86_64".into(), "gnu".into()) {
        return Err(format!("there is no copy for {} {}: install Embree yourself", platform.0, platform.1));
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?);
    // OUT_DIR is <target>/<profile>/build/<package>/out. The copy is kept beside the profiles, so
    // that the next profile need not download it; where cargo uses another layout, in OUT_DIR.
    let profile = out.ancestors().find(|folder| folder.file_name().is_some_and(|name| name == "build"));
    let profile = profile.and_then(Path::parent);
    let cache = profile.and_then(Path::parent).unwrap_or(&out).join("embree-4.4.0");

    let output = Command::new("python3")
        .arg(SCRIPT)
        .arg(&cache)
        .output()
        .map_err(|error| format!("python3 cannot be run: {error}"))?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr);
        return Err(message.lines().last().unwrap_or("python3 failed").to_owned());
    }
    if String::from_utf8_lossy(&output.stdout).trim() != "provisioned" {
        return Ok(());
    }

    let library = cache.join(LIBRARIES[0]);
    println!("cargo:rustc-env=LIGHTSHAFT_PROVISIONED_EMBREE={}", library.display());
    // Should somebody delete the copy, it is fetched again.
    println!("cargo:rerun-if-changed={}", library.display());
    // Also beside the executable, where it is found when the folder is moved.
    if let Some(profile) = profile {
        for name in LIBRARIES {
            place(&cache.join(name), &profile.join(name));
        }
    }
    Ok(())
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
