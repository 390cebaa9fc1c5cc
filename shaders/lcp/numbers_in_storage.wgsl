// Scalars in storage: on a processor all memory is equally fast, and a copy of all scalars takes longer than a small
// solve.
fn number(place: u32) -> real { return scalars[place]; }
fn keep(place: u32, value: real) { scalars[place] = value; }
fn take_up_numbers(local: u32) {}
fn leave_numbers(local: u32) {}
