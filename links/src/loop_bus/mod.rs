//! The links of a control loop over one CAN bus: what is sent in which cycle, and in which it is taken.
//!
//! Within each control cycle of length T the sensor sends at its begin, the controller takes what has arrived and sends
//! at `controller_at`, and the actuator takes what has arrived, applies its input and acknowledges at `actuator_at`. A frame
//! that misses the taking of its own cycle is a cycle late, and so on. What frames carry is not known here.
//!
//! | file | what lives there |
//! |---|---|
//! | `mod` | [`LoopBus`]: a loop's frames on a bus, cycle by cycle |
//! | [`plan`] | [`LoopPlan`]: how the loop uses the bus |
//! | [`observed`] | the delays that frames of given sizes meet, to design gains with |

pub mod observed;
pub mod plan;

pub use plan::{LoopPlan, Message, Role};

use crate::can::{Bus, Event, Fate, Frame, Log, Origin, SettingsError, Statistics, Time, What};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// A bus on which a control loop runs.
#[derive(Debug, Clone)]
pub struct LoopBus {
    plan: LoopPlan,
    bus: Bus,
    /// When cycle 0 begins: the other traffic has been there for a while.
    origin: Time,
    cycle: u64,
    /// Frames that are neither delivered nor lost, by tag.
    under_way: BTreeMap<u64, Vec<u8>>,
    /// Frames that were delivered and not yet taken, by role.
    arrived: [Vec<Vec<u8>>; Role::COUNT],
    /// What became of the frames of each role, by the cycle they were sent in; `None` as long as it is open, or for ever if
    /// none was sent.
    fates: [Vec<Option<Option<usize>>>; Role::COUNT],
}

impl LoopBus {
    /// A bus on which the other traffic has been running for a random time: two of the longest periods there are at most, so
    /// that the loop meets it in any phase.
    ///
    /// # Errors
    /// Settings with which no bus can run.
    pub fn new(plan: &LoopPlan, mut random: ChaCha8Rng) -> Result<Self, SettingsError> {
        let settled = plan.longest_period().max(plan.sample_time);
        let origin = settled + random.random_range(0..settled);
        let bus = Bus::new(plan.settings.clone(), ChaCha8Rng::from_rng(&mut random))?;
        Ok(Self {
            plan: plan.clone(),
            bus,
            origin,
            cycle: 0,
            under_way: BTreeMap::new(),
            arrived: Default::default(),
            fates: Default::default(),
        })
    }

    /// Whether frames of a role go over this bus.
    pub fn carries(&self, role: Role) -> bool {
        self.plan.message(role).is_some()
    }

    /// How the loop uses the bus.
    pub fn plan(&self) -> &LoopPlan {
        &self.plan
    }

    /// Sends a frame in the current cycle, at the time its role does so: `payload` is on the bus, padding included, and
    /// `bytes` is what its receiver makes of it.
    ///
    /// # Panics
    /// If the bus does not carry the role, or its format no payload of that length.
    pub fn send(&mut self, role: Role, payload: &[u8], bytes: &[u8]) {
        let message = *self.plan.message(role).expect("the bus carries the role");
        let at = self.time(self.cycle, self.plan.sent_at(role));
        self.run_to(at);
        if self.plan.replaces {
            let waiting = self.under_way.keys().copied().filter(|tag| Role::of(*tag) == role);
            for tag in waiting.collect::<Vec<_>>() {
                if self.bus.withdraw(tag) {
                    self.under_way.remove(&tag);
                    self.decide(tag, None);
                }
            }
        }
        let frame = Frame::new(message.id, self.plan.format, payload).expect("frames fit the plan's format");
        let tag = role.tag(self.cycle);
        self.under_way.insert(tag, bytes.to_vec());
        let offered = self.bus.offer(at, role.node(), frame.with_attempts(self.plan.attempts), tag);
        offered.expect("identifiers and times are the plan's");
    }

    /// Takes the frames of a role that have arrived by the time its receiver takes them in the current cycle.
    pub fn take(&mut self, role: Role) -> Vec<Vec<u8>> {
        self.run_to(self.time(self.cycle, self.plan.taken_at(role)));
        std::mem::take(&mut self.arrived[role as usize])
    }

    /// Ends the current cycle.
    pub fn next_cycle(&mut self) {
        self.cycle += 1;
    }

    /// Load, fates and response times of all messages so far.
    pub fn statistics(&self) -> Statistics {
        self.bus.statistics()
    }

    /// Every frame so far, if the settings ask for a log.
    pub fn log(&self) -> Option<&Log> {
        self.bus.log()
    }

    /// What became of the frames of a role, by the cycle they were sent in: the delay in cycles, or lost. `None`: none was
    /// sent, or it is still under way.
    pub fn fates(&self, role: Role) -> &[Option<Option<usize>>] {
        &self.fates[role as usize]
    }

    fn time(&self, cycle: u64, phase: Time) -> Time {
        self.origin + cycle * self.plan.sample_time + phase
    }

    fn run_to(&mut self, at: Time) {
        for Event { at, what } in self.bus.run_until(at) {
            match what {
                What::Fate { origin: Origin::Offered(tag), fate } => {
                    let bytes = self.under_way.remove(&tag).unwrap_or_default();
                    let role = Role::of(tag);
                    match fate {
                        Fate::Delivered => {
                            self.decide(tag, Some(self.delay(tag, at)));
                            self.arrived[role as usize].push(bytes);
                        }
                        Fate::Refused | Fate::Aborted | Fate::Withdrawn => self.decide(tag, None),
                    }
                }
                // A repetition tells its receiver nothing new, and the bytes are gone.
                What::Duplicate { .. } | What::Fate { .. } | What::BusOff { .. } | What::Recovered { .. } => {
                }
            }
        }
    }

    fn decide(&mut self, tag: u64, delay: Option<usize>) {
        let fates = &mut self.fates[Role::of(tag) as usize];
        let cycle = Role::cycle(tag) as usize;
        fates.resize(fates.len().max(cycle + 1), None);
        fates[cycle] = Some(delay);
    }

    /// Cycles between the first taking that could have had the frame and the one that has it, delivered at `at`.
    fn delay(&self, tag: u64, at: Time) -> usize {
        let (role, cycle) = (Role::of(tag), Role::cycle(tag));
        let first = self.time(cycle + role.first_taken_after(), self.plan.taken_at(role));
        at.saturating_sub(first).div_ceil(self.plan.sample_time) as usize
    }
}
