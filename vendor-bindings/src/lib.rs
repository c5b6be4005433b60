//! Raw Embree 4.4 declarations.
