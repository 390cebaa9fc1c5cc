//! Rods drawn into a ball, stepped by Rapier.
//!
//! `peers-rapier version=0.36 poses=FILE frames=FILE dt= end= every= radius= half= [settings]`; in place of
//! `radius` and `half`, `sizes=FILE`. Settings: `drag` (a force and a damping of that coefficient; without it each body
//! gets the field's velocity and no spin before every step), `iterations`, `pgs`, `stabilization`, `frequency`,
//! `damping_ratio`, `prediction`, `corrective`, `allowed_error`, `recycling`; `centre` of the field along x, `trap` (a
//! stiffness, in place of the field), `forces` (a file of a force a body, in place of the field), `spin` about z,
//! `repeats` (whole runs, of which the quickest counts). What is not given is the engine's default. Versions
//! `0.36-friction` and `0.36-colony` run other scenes: see [`friction`] and [`colony`].

mod colony;
#[cfg(feature = "f64")]
mod double;
mod friction;
mod run;
mod single;
mod v0_26;

use run::{Fault, Run};

fn main() -> Result<(), Fault> {
    if std::env::args().any(|word| word == "version=0.36-friction") {
        return friction::follow();
    }
    if std::env::args().any(|word| word == "version=0.36-colony") {
        return colony::follow();
    }
    let run = Run::from_arguments()?;
    match run.word("version")? {
        "0.26" => run.follow("0.26.1", v0_26::World::new),
        "0.36" => run.follow("0.36.1", single::v0_36::World::new),
        #[cfg(feature = "f64")]
        "0.36-f64" => run.follow("0.36.1, f64", double::v0_36::World::new),
        other => Err(format!("version {other}: 0.26 or 0.36").into()),
    }
}
