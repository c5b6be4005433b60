/* The only header bindgen reads. */
#include <embree4/rtcore.h>
