//! Ends of the loop on boards, with a twin of the core's in this process, to which every frame and input is compared.
//!
//! What the boards say drives the loop. The twin gets the same frames, and loses its memory when a board is killed; it is
//! what the simulator would have done.

use super::{
    difference::Difference,
    emulator::Setup,
    files::Files,
    frames::Dimensions,
    remote::{NodeFailure, Remote},
    replacement::{Replacement, Transfer},
    restart::Restart,
};
use crate::{
    ends::{CoreEnds, Ends, Played},
    fitted::Fitted,
};
use nalgebra::SVector;
use slqg::{
    Age, Scalar, Tick,
    actuator::Applied,
    authentication::HEAD_LEN,
    blob::DesignId,
    controller::Law,
    estimator::Estimate,
    wire::{self, GainsAnswer, Kind, Ran, Role, Status, Tuned, Verdict},
};
use std::collections::HashMap;

/// Rounds after which a handshake has come to an end: three hellos, and those that cross them.
const MOST_ROUNDS: usize = 16;
/// Samples of the reference in one frame, as many as the nodes take.
const SAMPLES: usize = 8;

/// What the boards are, and what happens to them.
pub(super) struct Boards<'a, T, const NX: usize, const NU: usize> {
    /// Of the controller and of the actuator.
    pub(super) setups: &'a [Setup; 2],
    /// For lines and logs.
    pub(super) files: &'a Files,
    /// In order.
    pub(super) restarts: &'a [Restart],
    /// Gains that are sent to the controller, and the law that they are in the size class.
    pub(super) replacement: Option<(&'a Replacement, Law<'a, T, NX, NU>)>,
    /// The design's own dimensions.
    pub(super) dimensions: Dimensions,
    /// Tracked outputs.
    pub(super) tracked: usize,
    /// Whose plant sealed frames are; `None` if they are plain.
    pub(super) sealed: Option<DesignId>,
}

/// Time that the controller's cycles took, in ticks of its node's clock.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Durations {
    pub(super) cycles: u32,
    pub(super) total: u64,
    pub(super) longest: u32,
}

/// Controller and actuator on boards.
pub(super) struct BoardEnds<'f, T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    fitted: &'f Fitted<T, NX, NU, NY>,
    boards: Boards<'f, T, NX, NU>,
    twin: CoreEnds<'f, T, NX, NU, NY>,
    nodes: [Option<Remote>; 2],
    /// Nodes that were started so far.
    starts: u32,
    /// What was before frames that the nodes have sealed in the sessions that stand.
    heads: HashMap<Vec<u8>, [u8; HEAD_LEN]>,
    transfer: Option<Transfer<'f>>,
    cycle: usize,
    /// The first sample of the reference that the controller has not been sent.
    next_sample: usize,
    frame: Vec<u8>,
    pub(super) durations: Durations,
    /// What the controller did that tunes itself, and when.
    pub(super) tuned: Vec<(usize, Tuned)>,
    /// The first one.
    pub(super) difference: Option<Difference>,
}

impl<'f, T: Scalar, const NX: usize, const NU: usize, const NY: usize> BoardEnds<'f, T, NX, NU, NY> {
    /// Starts both boards. The first cycle is 0.
    pub(super) fn start(
        fitted: &'f Fitted<T, NX, NU, NY>,
        twin: CoreEnds<'f, T, NX, NU, NY>,
        boards: Boards<'f, T, NX, NU>,
    ) -> Result<Self, NodeFailure> {
        let transfer = boards.replacement.map(|(replacement, _)| Transfer::new(replacement));
        let mut ends = Self {
            fitted,
            transfer,
            boards,
            twin,
            nodes: [None, None],
            starts: 0,
            heads: HashMap::new(),
            cycle: 0,
            next_sample: 0,
            frame: Vec::new(),
            durations: Durations::default(),
            tuned: Vec::new(),
            difference: None,
        };
        for role in [Role::Controller, Role::Actuator] {
            ends.start_node(role)?;
        }
        Ok(ends)
    }

    fn start_node(&mut self, role: Role) -> Result<(), NodeFailure> {
        self.starts += 1;
        let Boards { setups, files, sealed, .. } = &self.boards;
        let node = Remote::start::<T>(&setups[role as usize], role, files, self.starts, *sealed)?;
        self.nodes[role as usize] = Some(node);
        if sealed.is_some() {
            self.shake_hands()?;
        }
        if let Some(node) = &mut self.nodes[role as usize] {
            node.clock::<T>(Tick(self.cycle as u32), false);
        }
        Ok(())
    }

    /// Lets the nodes say hello, to the simulator and to each other, until nobody has anything to say. Frames that were sealed
    /// before are none of the session that begins.
    fn shake_hands(&mut self) -> Result<(), NodeFailure> {
        self.heads.clear();
        for _ in 0..MOST_ROUNDS {
            for node in self.nodes.iter_mut().flatten() {
                node.status::<T>()?;
            }
            self.pass_hellos_on();
            if !self.nodes.iter().flatten().any(Remote::is_waited_for) {
                break;
            }
        }
        Ok(())
    }

    /// Hands each node the other's hellos. One whose peer is not there speaks to nobody.
    fn pass_hellos_on(&mut self) {
        let hellos = self.nodes.each_mut().map(|node| node.as_mut().map_or_else(Vec::new, Remote::hellos));
        for (hellos, node) in hellos.iter().zip(self.nodes.iter_mut().rev()) {
            let Some(node) = node else { continue };
            hellos.iter().for_each(|hello| node.send_bytes(hello));
        }
    }

    /// Hands a node a frame that the other one has made, as that has sealed it. Whether it could be: one of a session that has
    /// ended is lost.
    fn hand_on(&mut self, role: Role, frame: &[u8]) -> bool {
        let Some(node) = &mut self.nodes[role as usize] else { return false };
        match (self.boards.sealed, self.heads.get(frame)) {
            (None, _) => node.send_bytes(frame),
            (Some(_), Some(head)) => node.send_bytes(&[&head[..], frame].concat()),
            (Some(_), None) => return false,
        }
        true
    }

    /// How both nodes are; one that is not there is started for it.
    pub(super) fn status(&mut self) -> Result<[Status; 2], NodeFailure> {
        let mut status = |role: Role| {
            if self.nodes[role as usize].is_none() {
                self.start_node(role)?;
            }
            let node = self.nodes[role as usize].as_mut().expect("just started");
            node.status::<T>()
        };
        Ok([status(Role::Controller)?, status(Role::Actuator)?])
    }

    /// Sends the samples that the controller does not know yet.
    fn send_reference(&mut self) {
        let Some((reference, ahead)) = self.fitted.reference() else { return };
        let Some(node) = &mut self.nodes[Role::Controller as usize] else { return };
        let first = self.next_sample.max(self.cycle + 1);
        let end = (self.cycle + 1 + ahead).min(reference.len());
        self.next_sample = end.max(first);
        let bytes = |sample: &SVector<T, NX>| -> Vec<u8> {
            sample.iter().take(self.boards.tracked).flat_map(|value| bytes_of(*value)).collect()
        };
        for (index, samples) in reference[first.min(end)..end].chunks(SAMPLES).enumerate() {
            let samples: Vec<_> = samples.iter().map(bytes).collect();
            let tick = (first + index * SAMPLES) as u32;
            node.send(&self.boards.dimensions.reference(tick, self.boards.tracked, &samples));
        }
    }

    /// What became of the gains that were sent, and in which cycle that was said; `None` if none were to be sent.
    pub(super) fn replaced(&self) -> Option<(Verdict, usize)> {
        let transfer = self.transfer.as_ref()?;
        Some(transfer.verdict.unwrap_or((Verdict::Incomplete, self.cycle)))
    }

    /// Sends the next part of the gains. The twin takes the law in the cycle in which the node has all of them.
    fn send_gains(&mut self) {
        let (Some(transfer), Some((replacement, law))) = (&mut self.transfer, self.boards.replacement) else {
            return;
        };
        let Some(node) = &mut self.nodes[Role::Controller as usize] else { return };
        if transfer.send::<T>(self.cycle, node) && replacement.fits {
            self.twin.replace_law(law);
        }
    }

    fn differs(&mut self, difference: Option<Difference>) {
        if self.difference.is_none() {
            self.difference = difference;
        }
    }
}

/// A number as it is on the wire.
fn bytes_of<T: Scalar>(value: T) -> Vec<u8> {
    match T::BYTES {
        // Exact: it was widened from as many bits.
        4 => (value.widen() as f32).to_le_bytes().to_vec(),
        _ => value.widen().to_le_bytes().to_vec(),
    }
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Ends<T, NX, NU>
    for BoardEnds<'_, T, NX, NU, NY>
{
    type Error = NodeFailure;

    fn begin(&mut self, cycle: usize) -> Result<(), NodeFailure> {
        self.cycle = cycle;
        let tick = Tick(cycle as u32);
        let restarts = self.boards.restarts;
        for restart in restarts {
            if restart.away.end == cycle {
                self.start_node(restart.role)?;
                match restart.role {
                    Role::Controller => {
                        self.twin.restart_controller(tick);
                        self.next_sample = 0;
                        self.transfer.iter_mut().for_each(Transfer::restarted);
                    }
                    Role::Actuator => self.twin.restart_actuator(tick),
                }
            }
            if restart.away.start == cycle {
                self.nodes[restart.role as usize] = None;
            }
        }
        Ok(())
    }

    fn to_controller(&mut self, packet: &[u8]) {
        let frame = self.boards.dimensions.for_controller(packet);
        let is_there = match (Kind::of(packet), &mut self.nodes[Role::Controller as usize]) {
            (_, None) => false,
            (Some(Kind::Acknowledgement), _) => self.hand_on(Role::Controller, &frame),
            (_, Some(node)) => {
                node.send(&frame);
                true
            }
        };
        if is_there {
            self.twin.to_controller(packet);
        }
    }

    fn control(
        &mut self,
        cycle: usize,
        channel: impl Iterator<Item = usize>,
    ) -> Result<Option<&[u8]>, NodeFailure> {
        self.send_reference();
        self.send_gains();
        let Some(node) = &mut self.nodes[Role::Controller as usize] else { return Ok(None) };
        let tick = Tick(cycle as u32);
        let Ok(expected) = self.twin.control(cycle, channel);
        let frames = node.step::<T>(tick, Kind::Ran)?;
        self.heads.extend(node.sealed());
        let (mut sent, mut tuned) = (None, None);
        for frame in &frames {
            match Kind::of(frame) {
                Some(Kind::Control) => {
                    sent = Some(node.read(|frame| self.boards.dimensions.of_controller(frame), frame)?);
                }
                Some(Kind::Ran) => {
                    let (_, ran) = node.read(wire::decode_service::<T, Ran>, frame)?;
                    self.durations.cycles += 1;
                    self.durations.total += u64::from(ran.duration);
                    self.durations.longest = self.durations.longest.max(ran.duration);
                }
                Some(Kind::Tuned) => {
                    tuned = Some(node.read(wire::decode_service::<T, Tuned>, frame)?.1);
                }
                Some(Kind::GainsAnswer) => {
                    let (_, answer) = node.read(wire::decode_service::<T, GainsAnswer>, frame)?;
                    self.transfer.iter_mut().for_each(|transfer| transfer.answered(answer, cycle));
                }
                kind => return Err(node.damaged(format!("unexpected frame {kind:?}"))),
            }
        }
        let difference = Difference::of_control::<T, NU>(cycle, expected, sent.as_deref())
            .or_else(|| Difference::of_tuning(cycle, self.twin.tuning().map(Tuned::from), tuned));
        self.differs(difference);
        self.tuned.extend(tuned.map(|tuned| (cycle, tuned)));
        let is_sent = sent.is_some();
        self.frame = sent.unwrap_or_default();
        self.pass_hellos_on();
        Ok(is_sent.then_some(&*self.frame))
    }

    fn to_actuator(&mut self, packet: &[u8]) {
        if self.hand_on(Role::Actuator, &self.boards.dimensions.for_actuator(packet)) {
            self.twin.to_actuator(packet);
        }
    }

    fn play(&mut self) -> Result<Played<'_, T, NU>, NodeFailure> {
        let tick = Tick(self.cycle as u32);
        let Some(node) = &mut self.nodes[Role::Actuator as usize] else {
            // A board without its node drives nothing.
            return Ok((Applied { tick, input: SVector::zeros(), age: Age::Empty }, None));
        };
        let Ok((expected, told)) = self.twin.play();
        let frames = node.step::<T>(tick, Kind::Applied)?;
        self.heads.extend(node.sealed());
        let mut applied = None;
        self.frame.clear();
        for frame in &frames {
            match Kind::of(frame) {
                Some(Kind::Applied) => {
                    let padded = node.read(|frame| self.boards.dimensions.of_actuator(frame), frame)?;
                    applied = Some(node.read(wire::decode_applied::<T, NU>, &padded)?);
                }
                Some(Kind::Acknowledgement) => self.frame.clone_from(frame),
                kind => return Err(node.damaged(format!("unexpected frame {kind:?}"))),
            }
        }
        let applied = applied.ok_or_else(|| node.damaged("nothing was applied".to_owned()))?;
        let difference = Difference::of_applied(self.cycle, &expected, &applied)
            .or_else(|| Difference::of_acknowledgement(self.cycle, told, &self.frame));
        self.differs(difference);
        self.pass_hellos_on();
        Ok((applied, Some(&*self.frame)))
    }

    fn estimate(&self) -> &Estimate<T, NX> {
        self.twin.estimate()
    }

    fn rejected(&self) -> u64 {
        self.twin.rejected()
    }
}
