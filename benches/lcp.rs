//! The product against memory bandwidth.
fn main() {}
