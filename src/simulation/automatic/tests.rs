//! The chooser, with machines and a clock that are played: what it chose, when, and how long the run took against the
//! better of the two machines alone. Times are those of the played clock.

use super::chooser::Chooser;
use super::machines::Machines;
use super::{Leg, Machine, Reason, Settings};
use crate::gpu::GpuError;
use crate::step::{Fault, StepReport};

/// Seconds to open the played device, and to hand a state over.
const OPENING: f64 = 2.5;
const MOVE: f64 = 0.02;

type Cost = Box<dyn Fn(u64, f64) -> f64>;

/// A run with a played clock. The costs are seconds of a step by its number and the bodies.
struct Played {
    bodies: Box<dyn Fn(u64) -> f64>,
    cpu: Cost,
    gpu: Cost,
    /// What opening the device says.
    opens: Result<(), GpuError>,
    /// The step that the device cannot take, and whether its state can be read then.
    fails_at: Option<(u64, bool)>,
    opening: f64,
    opened: bool,
    on: Machine,
    steps: u64,
    kept: u64,
    now: f64,
    legs: Vec<Leg>,
}

impl Played {
    fn new(bodies: impl Fn(u64) -> f64 + 'static, gpu: impl Fn(u64, f64) -> f64 + 'static) -> Self {
        Played {
            bodies: Box::new(bodies),
            cpu: Box::new(|_, bodies| cpu(bodies)),
            gpu: Box::new(gpu),
            opens: Ok(()),
            fails_at: None,
            opening: OPENING,
            opened: false,
            on: Machine::Cpu,
            steps: 0,
            kept: 0,
            now: 0.0,
            legs: Vec::new(),
        }
    }

    fn cost(&self, on: Machine, step: u64) -> f64 {
        let bodies = (self.bodies)(step);
        if on == Machine::Cpu { (self.cpu)(step, bodies) } else { (self.gpu)(step, bodies) }
    }

    /// Takes so many steps, and gives the seconds that they took, and that each machine alone would have taken.
    fn run(&mut self, steps: u64) -> [f64; 3] {
        let mut chooser = Chooser::new(Settings::default());
        for step in 1..=steps {
            assert_eq!(chooser.step(self).unwrap().step, step);
        }
        let alone = |on| (0..steps).map(|step| self.cost(on, step)).sum::<f64>();
        let [cpu, gpu] = [alone(Machine::Cpu), self.opening + alone(Machine::Gpu)];
        println!(
            "{:.1} s, CPU alone {cpu:.1} s, device alone {gpu:.1} s: {:.4} of the better",
            self.now,
            self.now / cpu.min(gpu)
        );
        for leg in &self.legs {
            println!("  at {:.0} bodies: {leg}; {:.1} s lost", (self.bodies)(leg.from_step), leg.lost_seconds);
        }
        [self.now, cpu, gpu]
    }

    fn reasons(&self) -> Vec<Reason> {
        self.legs.iter().map(|leg| leg.reason).collect()
    }
}

impl Machines for Played {
    fn now(&self) -> f64 {
        self.now
    }

    fn steps(&self) -> u64 {
        self.steps
    }

    fn bodies(&self) -> usize {
        (self.bodies)(self.steps) as usize
    }

    fn step(&mut self) -> Result<StepReport, Fault> {
        self.now += self.cost(self.on, self.steps);
        if self.on == Machine::Gpu && self.fails_at.is_some_and(|(step, _)| step <= self.steps + 1) {
            return Err(Fault::Device(GpuError::OutOfMemory { what: "rows".into() }));
        }
        self.steps += 1;
        Ok(StepReport { step: self.steps, ..StepReport::default() })
    }

    fn finish(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    fn keep(&mut self) -> Result<(), Fault> {
        self.kept = self.steps;
        self.now += MOVE;
        Ok(())
    }

    fn go_to(&mut self, machine: Machine) -> Result<(), Fault> {
        if machine == Machine::Gpu && !self.opened {
            self.now += self.opening;
            self.opens.clone()?;
            self.opened = true;
        }
        self.now += MOVE;
        (self.on, self.kept) = (machine, self.steps);
        Ok(())
    }

    fn fall_back(&mut self, steps: u64) -> Result<(), Fault> {
        assert_eq!(steps, self.steps);
        let readable = self.fails_at.is_some_and(|(_, readable)| readable);
        if self.kept != steps && !readable {
            return Err(Fault::Device(GpuError::Lost { reason: "played".into() }));
        }
        self.on = Machine::Cpu;
        Ok(())
    }

    fn record(&mut self, leg: Leg) {
        assert_eq!(leg.machine, self.on);
        self.legs.push(Leg { from_step: self.steps + 1, bodies: self.bodies(), ..leg });
    }
}

/// The CPU's step: 1.4 microseconds a body.
fn cpu(bodies: f64) -> f64 {
    1.4e-6 * bodies
}

/// A device with a fixed cost of 20 ms and a tenth of the CPU's work a body.
fn large_device(_: u64, bodies: f64) -> f64 {
    0.02 + 0.1 * cpu(bodies)
}

/// A colony from one cell, which doubles every 700 steps.
fn colony(step: u64) -> f64 {
    (step as f64 / 700.0).exp2()
}

#[test]
fn wherever_a_colony_on_a_slower_device_ends_it_has_lost_under_five_percent() {
    for slowness in [1.0, 1.5, 3.0, 10.0] {
        let mut run = Played::new(colony, move |_, bodies| slowness * cpu(bodies));
        let mut chooser = Chooser::new(Settings::default());
        let (mut alone, mut worst) = (0.0, 1.0f64);
        for step in 0..14_000 {
            alone += run.cost(Machine::Cpu, step);
            chooser.step(&mut run).unwrap();
            worst = worst.max(run.now / alone);
        }
        println!("{slowness} times slower: {worst:.4} of the CPU alone at most, {:.4} at last", run.now / alone);
        assert!(worst <= 1.05 && run.on == Machine::Cpu, "{worst} with a device {slowness} times slower");
        assert!(run.reasons().contains(&Reason::NotSlower));
    }
}

#[test]
fn below_its_least_size_a_run_never_opens_the_device() {
    let mut run = Played::new(|_| 1000.0, |_, _| 1e-9);
    let [taken, cpu, _] = run.run(200_000);
    assert!(!run.opened && taken == cpu && run.legs.is_empty());
}

#[test]
fn a_colony_goes_over_to_a_device_that_is_faster_beyond_some_size() {
    let mut run = Played::new(colony, large_device);
    let [taken, cpu, gpu] = run.run(13_000);
    assert!(taken < 0.4 * cpu && taken < 0.7 * gpu, "{taken} s, {cpu} s, {gpu} s");
    assert_eq!(run.on, Machine::Gpu);
    // The two are equal at 15,900 bodies; a first trial may cost a twentieth of the run at 65,000.
    let taken_over = run.legs.iter().find(|leg| leg.reason == Reason::Faster).unwrap();
    assert!((60_000..80_000).contains(&taken_over.bodies), "{taken_over}");
}

#[test]
fn many_bodies_go_over_to_a_device_that_is_ten_times_faster_once_its_opening_is_a_twentieth() {
    let mut run = Played::new(|_| 100_000.0, |_, bodies| 0.1 * cpu(bodies));
    let [taken, cpu, _] = run.run(10_000);
    assert_eq!(run.reasons()[..2], [Reason::FirstTrial, Reason::Faster]);
    // A twentieth of 120 s is what opening, and two steps of the slowest expected kind, are taken to cost.
    assert!(taken < 120.0 + 0.12 * cpu, "{taken} s of {cpu} s");
}

#[test]
fn a_device_that_becomes_slow_hands_the_run_back() {
    let cost = |step: u64, bodies: f64| if step < 6_000 { 0.2 * cpu(bodies) } else { 5.0 * cpu(bodies) };
    let mut run = Played::new(|_| 50_000.0, cost);
    let [taken, cpu, gpu] = run.run(12_000);
    assert!(taken < 0.75 * cpu && taken < gpu, "{taken} s, {cpu} s, {gpu} s");
    let back = run.legs.iter().position(|leg| leg.reason == Reason::OtherWasFaster).unwrap();
    assert_eq!((run.legs[back + 1].reason, run.legs[back + 1].machine), (Reason::Faster, Machine::Cpu));
    assert!((6_000..6_020).contains(&run.legs[back].from_step), "{}", run.legs[back]);
    assert_eq!(run.on, Machine::Cpu);
}

#[test]
fn a_device_that_becomes_slow_at_once_costs_little_of_a_longer_run() {
    let cost = |step: u64, bodies: f64| if step < 1_600 { 0.2 * cpu(bodies) } else { 10.0 * cpu(bodies) };
    let mut run = Played::new(|_| 50_000.0, cost);
    let [taken, cpu, _] = run.run(12_000);
    assert!(taken < 1.05 * cpu, "{taken} s of {cpu} s");
    assert_eq!(run.on, Machine::Cpu);
}

#[test]
fn steps_that_become_cheap_go_back_to_the_cpu() {
    // The device takes 20 ms at least; the bodies drift apart, and a step of the CPU takes 2 ms.
    let work = |step: u64| if step < 3_000 { 0.1 } else { 0.002 };
    let mut run = Played::new(|_| 20_000.0, move |step, _| 0.02 + 0.1 * work(step));
    run.cpu = Box::new(move |step, _| work(step));
    run.run(20_000);
    assert_eq!(run.on, Machine::Cpu);
    let back = run.legs.iter().position(|leg| leg.reason == Reason::FasterSteps || leg.reason == Reason::Later);
    assert!(back.is_some(), "{:?}", run.reasons());
}

#[test]
fn a_scene_of_constant_size_is_measured_once_more_later() {
    // Its first steps are slow on the device.
    let cost = |step: u64, bodies: f64| if step < 3_000 { 2.0 * cpu(bodies) } else { 0.2 * cpu(bodies) };
    let mut run = Played::new(|_| 50_000.0, cost);
    let [taken, cpu, _] = run.run(40_000);
    assert_eq!(run.reasons()[..4], [Reason::FirstTrial, Reason::NotSlower, Reason::Later, Reason::Faster]);
    assert!(taken < 0.4 * cpu, "{taken} s of {cpu} s");
}

#[test]
fn equal_machines_do_not_take_turns() {
    let mut run = Played::new(|_| 50_000.0, |step, bodies| (0.97 + 0.06 * (step % 2) as f64) * cpu(bodies));
    let [taken, cpu, _] = run.run(40_000);
    assert!(taken < 1.05 * cpu && run.legs.len() <= 8, "{} legs", run.legs.len());
}

#[test]
fn a_device_that_cannot_be_opened_is_tried_once_and_named() {
    let mut run = Played::new(colony, large_device);
    run.opens = Err(GpuError::OutOfMemory { what: "the device".into() });
    let [taken, cpu, _] = run.run(12_000);
    assert!(taken <= 1.02 * cpu && run.reasons() == [Reason::Failed], "{taken} s of {cpu} s");
    assert!(run.legs[0].message.as_deref().unwrap().contains("out of memory"));
}

#[test]
fn a_machine_without_a_device_computes_on_the_cpu_without_a_word() {
    let mut run = Played::new(colony, large_device);
    (run.opens, run.opening) = (Err(GpuError::NoAdapter { wanted: String::new(), found: "none".into() }), 0.3);
    let [taken, cpu, _] = run.run(12_000);
    assert!(taken <= 1.01 * cpu && run.legs.is_empty(), "{taken} s of {cpu} s");
}

#[test]
fn a_device_that_fails_leaves_the_run_to_the_cpu_where_its_state_is_known() {
    let begins = {
        let mut run = Played::new(colony, large_device);
        run.run(13_000);
        run.legs.iter().find(|leg| leg.is_trial()).unwrap().from_step
    };
    // In the first trial every state is kept; later it has to be read.
    for (step, readable) in [(begins, false), (begins + 1, false), (12_900, true)] {
        let mut run = Played::new(colony, large_device);
        run.fails_at = Some((step, readable));
        run.run(13_000);
        assert_eq!((run.on, run.legs.last().unwrap().reason), (Machine::Cpu, Reason::Failed));
    }
    let mut lost = Played::new(colony, large_device);
    lost.fails_at = Some((12_900, false));
    let mut chooser = Chooser::new(Settings::default());
    let fault = (0..13_000).find_map(|_| chooser.step(&mut lost).err());
    assert_eq!(fault, Some(Fault::Device(GpuError::OutOfMemory { what: "rows".into() })));
    assert_eq!(lost.steps, 12_899);
}

#[test]
fn a_run_that_is_resumed_need_not_earn_its_trial_anew() {
    let mut run = Played::new(|_| 100_000.0, |_, bodies| 0.1 * cpu(bodies));
    let mut chooser = Chooser::new(Settings::default());
    chooser.resume(1000.0, 10.0);
    for _ in 0..100 {
        chooser.step(&mut run).unwrap();
    }
    assert_eq!((run.on, run.legs[0].from_step), (Machine::Gpu, 17));
}

#[test]
fn a_device_that_takes_longer_to_open_than_expected_is_not_tried_soon_again() {
    let mut run = Played::new(colony, |_, bodies| 10.0 * cpu(bodies));
    run.opening = 30.0;
    let [taken, cpu, _] = run.run(14_000);
    let trials: Vec<f64> =
        run.legs.iter().filter(|leg| leg.reason == Reason::NotSlower).map(|l| l.lost_seconds).collect();
    assert!(trials[0] > 30.0, "{trials:?}");
    assert!(taken <= 1.05 * cpu, "{taken} s of {cpu} s");
}
