// A copy of the scalars in workgroup memory, fast for the one invocation that operates on them.
var<workgroup> numbers: array<real, NUMBERS>;

fn number(place: u32) -> real { return numbers[place]; }
fn keep(place: u32, value: real) { numbers[place] = value; }

fn take_up_numbers(local: u32) {
    for (var place = local; place < NUMBERS; place += WORKGROUP) { numbers[place] = scalars[place]; }
}

fn leave_numbers(local: u32) {
    workgroupBarrier();
    for (var place = local; place < NUMBERS; place += WORKGROUP) { scalars[place] = numbers[place]; }
}
