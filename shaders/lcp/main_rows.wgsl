// A stage on all rows. What it does is generated.
@group(0) @binding(1) var<storage, read> scalars: array<real>;
@group(0) @binding(2) var<storage, read_write> vectors: array<real>;
@group(0) @binding(3) var<storage, read_write> partial: array<real>;
