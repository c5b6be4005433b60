//! What pages hold, and that nothing in them comes from elsewhere or from a name.
