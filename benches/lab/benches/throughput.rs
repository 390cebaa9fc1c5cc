//! What a step costs by the number of bodies, on the CPU and on a device: the study `throughput` as a bench.
//!
//! `cargo bench -p relcp-lab --bench throughput` goes up to 4,096 bodies; `RELCP_LARGEST=131072` further,
//! `RELCP_ADAPTER=name` picks the adapter.

use relcp::gpu::{Choice, Gpu, Precision};
use relcp::simulation::Compute;
use relcp_lab::throughput::{Kind, measure, table};
use std::sync::Arc;

/// Steps taken before any is timed, and steps timed, of each size.
const STEPS: [usize; 2] = [2, 5];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let largest: usize = std::env::var("RELCP_LARGEST").ok().and_then(|n| n.parse().ok()).unwrap_or(4_096);
    let mut computes = vec![Compute::Cpu];
    match Gpu::open(&Choice { name: std::env::var("RELCP_ADAPTER").ok(), software: true, ..Choice::default() }) {
        Ok(gpu) => computes.push(Compute::Gpu { gpu: Arc::new(gpu), precision: Precision::F32 }),
        Err(fault) => eprintln!("no device: {fault}"),
    }
    let mut rows = Vec::new();
    for kind in [Kind::Colony, Kind::Compaction] {
        for bodies in kind.sizes(largest) {
            for compute in &computes {
                rows.push(measure(kind, bodies, STEPS, compute)?);
            }
        }
    }
    println!("{}", table(&rows));
    Ok(())
}
