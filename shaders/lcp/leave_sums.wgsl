// One partial sum a workgroup and reduction.
fn leave_sums(group: u32, local: u32) {
    if parameters.reductions == 0u { return; }
    reduce(local, parameters.kinds);
    if local >= parameters.reduction && local < parameters.reduction + parameters.reductions {
        partial[local * parameters.groups + group] = total(local, parameters.kinds);
    }
}
