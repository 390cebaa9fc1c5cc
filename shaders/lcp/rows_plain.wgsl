fn begin_rows(first: u32, step: u32) {}
