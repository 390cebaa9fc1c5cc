// Each workgroup writes its partial sums for the next stage.
fn leave_sums(group: u32, local: u32, count: u32, kinds: u32) {
    reduce(local, kinds);
    if local < count {
        partial[parameters.sums_into + local * parameters.groups + group] = total(local, kinds);
    }
}
