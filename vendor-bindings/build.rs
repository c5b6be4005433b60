//! Does nothing by default: the checked-in declarations are used. With feature `bindgen` it writes
//! fresh ones from the headers in `EMBREE_DIR/include` and compiles a C probe of their layout.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    #[cfg(feature = "bindgen")]
    regenerate::run();
}

#[cfg(feature = "bindgen")]
mod regenerate {
    use std::{env, path::PathBuf};

    /// What lightshaft calls; everything else of Embree stays undeclared. All of it is in 4.3.0.
    const FUNCTIONS: &[&str] = &[
        "rtcNewDevice",
        "rtcReleaseDevice",
        "rtcGetDeviceProperty",
        "rtcGetDeviceError",
        "rtcSetDeviceErrorFunction",
        "rtcSetDeviceMemoryMonitorFunction",
        "rtcNewScene",
        "rtcReleaseScene",
        "rtcSetSceneFlags",
        "rtcJoinCommitScene",
        "rtcGetSceneBounds",
        "rtcNewGeometry",
        "rtcReleaseGeometry",
        "rtcCommitGeometry",
        "rtcSetSharedGeometryBuffer",
        "rtcAttachGeometryByID",
        "rtcIntersect1",
        "rtcIntersect16",
        "rtcOccluded1",
        "rtcOccluded16",
    ];

    /// Types that no function above names: the blocks behind the opaque pointers of the filter.
    const TYPES: &[&str] = &["RTCHit16", "RTCFilterFunctionNArguments"];

    pub(crate) fn run() {
        println!("cargo:rerun-if-env-changed=EMBREE_DIR");
        println!("cargo:rerun-if-changed=native");
        let embree = env::var_os("EMBREE_DIR").map(PathBuf::from).unwrap_or_else(|| "/usr".into());
        let include = embree.join("include");
        assert!(
            include.join("embree4/rtcore.h").is_file(),
            "feature `bindgen` needs EMBREE_DIR/include/embree4/rtcore.h of Embree 4.3 or later; \
             there is none in {}",
            include.display()
        );

        let mut builder = bindgen::Builder::default()
            .header("native/embree.h")
            .clang_arg(format!("-I{}", include.display()))
            .generate_comments(false)
            .prepend_enum_name(false)
            // C may return a value that the header does not list, so never a Rust enum.
            .default_enum_style(bindgen::EnumVariation::NewType { is_bitfield: false, is_global: false })
            .bitfield_enum("RTC(Scene|RayQuery|Feature)Flags")
            .allowlist_recursively(true)
            .dynamic_library_name("Embree")
            .dynamic_link_require_all(true)
            .layout_tests(true)
            .size_t_is_usize(true)
            .merge_extern_blocks(true)
            .parse_callbacks(Box::new(bindgen::CargoCallbacks::new()));
        for function in FUNCTIONS {
            builder = builder.allowlist_function(format!("^{function}$"));
        }
        for kind in TYPES {
            builder = builder.allowlist_type(format!("^{kind}$"));
        }
        let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
        builder
            .generate()
            .expect("bindgen could not read the Embree headers")
            .write_to_file(out.join("bindings.rs"))
            .expect("OUT_DIR is writable");

        cc::Build::new()
            .file("native/layout_probe.c")
            .include(&include)
            .warnings(true)
            .compile("embree4_layout_probe");
    }
}
