//! Generated source of a loop whose later packets are taken to follow a schedule: it compiles to what the library finds, and a
//! controller of it sends what is worth a packet. Packets at fixed times are sent at these times.

use gain_gen::design::{Base, Design, Event, Rule};
use gain_gen::emit::{Format, emit};
use gain_gen::report::{Report, Verdict};
use gain_gen::solve::Method;
use slqg::DefaultInput;
use slqg::Tick;
use slqg::checked::NonNegative;
use slqg::event::{ScheduleTables, Trigger};
use slqg::wire::Acknowledgement;
use std::path::Path;

/// Two inputs, hold, `f32`, a trigger over every third cycle.
#[allow(dead_code, unreachable_pub)]
mod ferry {
    include!("generated/ferry.rs");
}

fn design() -> Design {
    Design::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/ferry.toml")).unwrap()
}

#[test]
fn the_generated_trigger_is_the_librarys_rounded() {
    let report = Report::new(&design(), Method::InFlight);
    let found = report.scheduled.as_ref().unwrap();
    let tables = found.trigger.as_ref().unwrap();
    let [in_flight, decided, phases] = [&tables.in_flight, &tables.decided, &tables.phases]
        .map(|table| table.iter().map(|&value| value as f32).collect::<Vec<f32>>());
    let tables = ScheduleTables::check(3, &in_flight, &decided, &phases).unwrap();
    let trigger =
        Trigger::<f32, 2, 2>::check_schedule(3, DefaultInput::Hold, NonNegative::<f32>::new(0.5), tables);
    assert_eq!(ferry::TRIGGER, trigger.unwrap());
    assert_eq!(ferry::TRIGGER.period(), 3);
}

/// Cycles of a run in which a packet is sent. The state is far away in the first, and packets arrive at once.
fn sent(design: slqg::controller::Design<'static, f32, 2, 2, 1>, cycles: u32) -> Vec<u32> {
    let (mut memory, mut of_actuator) = (ferry::Memory::new(), ferry::ACTUATOR_MEMORY);
    let mut controller =
        ferry::Controller::new(design, Tick(0), memory.lend()).expect("it is made for the design");
    let mut actuator = ferry::Actuator::new(ferry::ACTUATOR, Tick(0), &mut of_actuator);
    let mut frame = [0; 256];
    let mut sent = Vec::new();
    for cycle in 0..cycles {
        if let Some(frame) = controller.cycle(&mut frame).expect("the frame fits") {
            sent.push(cycle);
            actuator.receive(frame).expect("both ends are made for the same design");
        }
        let applied = actuator.step();
        let told = Acknowledgement::of(applied.tick, applied.age);
        controller.acknowledged(&told).expect("what was sent was played");
    }
    sent
}

#[test]
fn a_generated_controller_sends_at_once_what_is_urgent_and_waits_with_what_is_not() {
    let cycles = sent(ferry::DESIGN, 30);
    assert_eq!(cycles[0], 0, "the state is far away");
    assert!(cycles.len() < 10, "rarer than the schedule it counts on: {cycles:?}");
}

#[test]
fn packets_at_fixed_times_are_sent_at_these_times_alone() {
    let send_cost = NonNegative::<f32>::new(0.5);
    let fixed = Trigger::<f32, 2, 2>::fixed(3, DefaultInput::Hold, send_cost, 4);
    let design = slqg::controller::Design { trigger: Some(fixed), ..ferry::DESIGN };
    assert_eq!(sent(design, 17), [0, 4, 8, 12, 16]);
}

#[test]
fn a_trigger_without_room_for_its_numbers_is_refused() {
    let mut memory = ferry::Memory::new();
    let lent = memory.lend();
    let too_little = lent.ages.len() - 1;
    let lent = slqg::controller::Memory { ages: &mut lent.ages[..too_little], ..lent };
    assert!(ferry::Controller::new(ferry::DESIGN, Tick(0), lent).is_err());
}

#[test]
fn the_clock_alone_is_emitted_as_such() {
    let mut design = design();
    let event = design.event.as_mut().unwrap();
    event.rule = Rule::Schedule;
    let mut report = Report::new(&design, Method::InFlight);
    report.accept_undecided_stability();
    let written = emit(&report.emission().unwrap(), "ferry.toml", Format::Rust).unwrap();
    assert!(written.contains("::fixed("), "{written}");
    assert!(!written.contains("phases:"), "{written}");
}

#[test]
fn a_base_of_one_writes_what_a_trigger_without_a_base_writes() {
    let source = |base| {
        let mut design = design();
        design.event.as_mut().unwrap().base = base;
        let mut report = Report::new(&design, Method::InFlight);
        report.accept_undecided_stability();
        emit(&report.emission().unwrap(), "ferry.toml", Format::Rust).unwrap()
    };
    let mut without = design();
    without.event = Some(Event::at(0.5));
    let mut report = Report::new(&without, Method::InFlight);
    report.accept_undecided_stability();
    let written = emit(&report.emission().unwrap(), "ferry.toml", Format::Rust).unwrap();
    assert!(source(Base::Every(1)) == written, "bit for bit");
    assert!(!written.contains("ScheduleTables") && !written.contains("with_numbers"));
    assert!(source(Base::Every(2)) != written);
}

#[test]
fn packets_too_rare_to_stabilise_the_loop_are_refused_by_name() {
    let text = include_str!("../../designs/pendulum_event.toml").to_string() + "base = 20\n";
    let design = Design::parse(&text, "pendulum_event.toml").unwrap();
    let mut report = Report::new(&design, Method::InFlight);
    assert_eq!(report.verdict(), Verdict::Undecided);
    report.accept_undecided_stability();
    let Err(refused) = report.emission() else { panic!("there is no law to write") };
    assert!(refused.to_string().contains("event.base: with a packet in every 20. cycle"), "{refused}");
    let always = text.replace("base = 20", "base = 1");
    let design = Design::parse(&always, "pendulum_event.toml").unwrap();
    assert_eq!(Report::new(&design, Method::InFlight).verdict(), Verdict::Stable);
}
