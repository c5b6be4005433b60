/* Sizes, alignments and offsets as the C compiler sees them in the installed Embree headers.
 * tests/layout.rs asks for them by name and compares them with the Rust declarations. */
#include <embree4/rtcore.h>
#include <stdalign.h>
#include <stddef.h>
#include <string.h>

struct fact {
  const char *name;
  size_t value;
};

#define SIZE(type) {"size " #type, sizeof(struct type)}, {"align " #type, alignof(struct type)}
#define OFFSET(type, field) {"offset " #type "." #field, offsetof(struct type, field)}

#define VALUE(constant) {"value " #constant, (size_t)(unsigned)constant}

#define RAY(type)                                                                                  \
  SIZE(type), OFFSET(type, org_x), OFFSET(type, org_y), OFFSET(type, org_z), OFFSET(type, tnear),  \
      OFFSET(type, dir_x), OFFSET(type, dir_y), OFFSET(type, dir_z), OFFSET(type, time),           \
      OFFSET(type, tfar), OFFSET(type, mask), OFFSET(type, id), OFFSET(type, flags)

#define HIT(type)                                                                                  \
  SIZE(type), OFFSET(type, Ng_x), OFFSET(type, Ng_y), OFFSET(type, Ng_z), OFFSET(type, u),         \
      OFFSET(type, v), OFFSET(type, primID), OFFSET(type, geomID), OFFSET(type, instID),           \
      OFFSET(type, instPrimID)

static const struct fact facts[] = {
    RAY(RTCRay),
    RAY(RTCRay16),
    HIT(RTCHit),
    HIT(RTCHit16),
    SIZE(RTCRayHit),
    OFFSET(RTCRayHit, ray),
    OFFSET(RTCRayHit, hit),
    SIZE(RTCRayHit16),
    OFFSET(RTCRayHit16, ray),
    OFFSET(RTCRayHit16, hit),
    SIZE(RTCRayQueryContext),
    OFFSET(RTCRayQueryContext, instID),
    OFFSET(RTCRayQueryContext, instPrimID),
    SIZE(RTCFilterFunctionNArguments),
    OFFSET(RTCFilterFunctionNArguments, valid),
    OFFSET(RTCFilterFunctionNArguments, geometryUserPtr),
    OFFSET(RTCFilterFunctionNArguments, context),
    OFFSET(RTCFilterFunctionNArguments, ray),
    OFFSET(RTCFilterFunctionNArguments, hit),
    OFFSET(RTCFilterFunctionNArguments, N),
    SIZE(RTCIntersectArguments),
    OFFSET(RTCIntersectArguments, flags),
    OFFSET(RTCIntersectArguments, feature_mask),
    OFFSET(RTCIntersectArguments, context),
    OFFSET(RTCIntersectArguments, filter),
    OFFSET(RTCIntersectArguments, intersect),
    SIZE(RTCOccludedArguments),
    OFFSET(RTCOccludedArguments, flags),
    OFFSET(RTCOccludedArguments, feature_mask),
    OFFSET(RTCOccludedArguments, context),
    OFFSET(RTCOccludedArguments, filter),
    OFFSET(RTCOccludedArguments, occluded),
    SIZE(RTCBounds),
    OFFSET(RTCBounds, lower_x),
    OFFSET(RTCBounds, lower_y),
    OFFSET(RTCBounds, lower_z),
    OFFSET(RTCBounds, align0),
    OFFSET(RTCBounds, upper_x),
    OFFSET(RTCBounds, upper_y),
    OFFSET(RTCBounds, upper_z),
    OFFSET(RTCBounds, align1),
    /* Constants that a wrong header would change without changing any size. */
    VALUE(RTC_DEVICE_PROPERTY_VERSION_MAJOR),
    VALUE(RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED),
    VALUE(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED),
    VALUE(RTC_DEVICE_PROPERTY_TASKING_SYSTEM),
    VALUE(RTC_SCENE_FLAG_ROBUST),
    VALUE(RTC_SCENE_FLAG_COMPACT),
    VALUE(RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS),
    VALUE(RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER),
    VALUE(RTC_RAY_QUERY_FLAG_COHERENT),
    VALUE(RTC_FEATURE_FLAG_ALL),
    VALUE(RTC_FORMAT_FLOAT3),
    VALUE(RTC_FORMAT_UINT3),
    VALUE(RTC_BUFFER_TYPE_INDEX),
    VALUE(RTC_BUFFER_TYPE_VERTEX),
    VALUE(RTC_GEOMETRY_TYPE_TRIANGLE),
};

size_t embree4_layout_count(void) { return sizeof(facts) / sizeof(facts[0]); }

/* The fact of that name, or (size_t)-1 when the probe does not know it. */
size_t embree4_layout_fact(const char *name) {
  for (size_t i = 0; i < embree4_layout_count(); ++i)
    if (strcmp(facts[i].name, name) == 0) return facts[i].value;
  return (size_t)-1;
}
