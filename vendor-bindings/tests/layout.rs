//! The declarations have the layout of Embree 4.3 and later with instance arrays. By default they
//! are compared with the published figures; with feature `bindgen` every size, alignment and
//! offset is compared with what the C compiler makes of the installed headers. A failure means
//! that Embree would write outside our structs.

use std::mem::offset_of;

use embree4_sys as raw;

#[test]
fn sizes_are_those_of_embree_4_3_with_instance_arrays() {
    let sizes = [
        ("RTCHit", size_of::<raw::RTCHit>(), 48),
        ("RTCRay", size_of::<raw::RTCRay>(), 48),
        ("RTCRayHit", size_of::<raw::RTCRayHit>(), 96),
        ("RTCRay16", size_of::<raw::RTCRay16>(), 768),
        ("RTCHit16", size_of::<raw::RTCHit16>(), 576),
        ("RTCRayHit16", size_of::<raw::RTCRayHit16>(), 1344),
        ("RTCRayQueryContext", size_of::<raw::RTCRayQueryContext>(), 8),
        ("RTCFilterFunctionNArguments", size_of::<raw::RTCFilterFunctionNArguments>(), 48),
        ("RTCIntersectArguments", size_of::<raw::RTCIntersectArguments>(), 32),
        ("RTCOccludedArguments", size_of::<raw::RTCOccludedArguments>(), 32),
        ("RTCBounds", size_of::<raw::RTCBounds>(), 32),
    ];
    for (name, ours, published) in sizes {
        assert_eq!(ours, published, "size of {name}");
    }
    assert_eq!(align_of::<raw::RTCRay16>(), 64);
    assert_eq!(offset_of!(raw::RTCRayHit, hit), 48);
    assert_eq!(offset_of!(raw::RTCHit, geomID), 24);
    assert_eq!(offset_of!(raw::RTCHit, instPrimID), 32);
}

#[test]
fn error_codes_outside_the_header_are_representable() {
    let unknown = raw::RTCError(12345);
    assert_ne!(unknown, raw::RTCError::RTC_ERROR_NONE);
}

#[cfg(feature = "bindgen")]
mod against_the_headers {
    use std::ffi::{CString, c_char};

    /// The declarations of a build without the feature.
    #[allow(dead_code, missing_docs, nonstandard_style, unreachable_pub, unsafe_op_in_unsafe_fn)]
    #[allow(clippy::all, clippy::undocumented_unsafe_blocks)]
    mod checked_in {
        include!("../src/bindings.rs");
    }

    use super::raw;

    unsafe extern "C" {
        safe fn embree4_layout_count() -> usize;
        fn embree4_layout_fact(name: *const c_char) -> usize;
    }

    /// `(name as in native/layout_probe.c, value in Rust)` for the declarations in one module.
    macro_rules! layout {
        ($module:ident {
            $(struct $kind:ident { $($field:ident),* })*
            $(value $owner:ident { $($constant:ident),* })*
        }) => {
            vec![
                $(
                    (concat!("size ", stringify!($kind)), size_of::<$module::$kind>()),
                    (concat!("align ", stringify!($kind)), align_of::<$module::$kind>()),
                    $((
                        concat!("offset ", stringify!($kind), ".", stringify!($field)),
                        std::mem::offset_of!($module::$kind, $field),
                    ),)*
                )*
                $($((
                    concat!("value ", stringify!($constant)),
                    $module::$owner::$constant.0 as usize,
                ),)*)*
            ]
        };
    }

    macro_rules! everything {
        ($module:ident) => {
            layout!($module {
                struct RTCRay { org_x, org_y, org_z, tnear, dir_x, dir_y, dir_z, time, tfar, mask, id, flags }
                struct RTCRay16 { org_x, org_y, org_z, tnear, dir_x, dir_y, dir_z, time, tfar, mask, id, flags }
                struct RTCHit { Ng_x, Ng_y, Ng_z, u, v, primID, geomID, instID, instPrimID }
                struct RTCHit16 { Ng_x, Ng_y, Ng_z, u, v, primID, geomID, instID, instPrimID }
                struct RTCRayHit { ray, hit }
                struct RTCRayHit16 { ray, hit }
                struct RTCRayQueryContext { instID, instPrimID }
                struct RTCFilterFunctionNArguments { valid, geometryUserPtr, context, ray, hit, N }
                struct RTCIntersectArguments { flags, feature_mask, context, filter, intersect }
                struct RTCOccludedArguments { flags, feature_mask, context, filter, occluded }
                struct RTCBounds { lower_x, lower_y, lower_z, align0, upper_x, upper_y, upper_z, align1 }
                value RTCDeviceProperty {
                    RTC_DEVICE_PROPERTY_VERSION_MAJOR,
                    RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED,
                    RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED,
                    RTC_DEVICE_PROPERTY_TASKING_SYSTEM
                }
                value RTCSceneFlags {
                    RTC_SCENE_FLAG_ROBUST,
                    RTC_SCENE_FLAG_COMPACT,
                    RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS
                }
                value RTCRayQueryFlags {
                    RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER,
                    RTC_RAY_QUERY_FLAG_COHERENT
                }
                value RTCFeatureFlags { RTC_FEATURE_FLAG_ALL }
                value RTCFormat { RTC_FORMAT_FLOAT3, RTC_FORMAT_UINT3 }
                value RTCBufferType { RTC_BUFFER_TYPE_INDEX, RTC_BUFFER_TYPE_VERTEX }
                value RTCGeometryType { RTC_GEOMETRY_TYPE_TRIANGLE }
            })
        };
    }

    fn compare(which: &str, ours: &[(&str, usize)]) {
        assert_eq!(ours.len(), embree4_layout_count(), "the probe and this test list the same facts");
        for &(name, value) in ours {
            let c_name = CString::new(name).expect("no NUL in a literal");
            // SAFETY: the probe only reads the NUL-terminated string.
            let c = unsafe { embree4_layout_fact(c_name.as_ptr()) };
            assert_eq!(value, c, "{which}: {name}: Rust has {value}, C has {c}");
        }
    }

    #[test]
    fn regenerated_declarations_have_the_layout_of_the_headers() {
        compare("regenerated", &everything!(raw));
    }

    #[test]
    fn checked_in_declarations_have_the_layout_of_the_headers() {
        compare("checked in", &everything!(checked_in));
    }
}
