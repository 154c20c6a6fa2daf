//! What is computed once for a cloud.
