//! Controller, actuator and sensor behind guards, the same two ends without, and what goes between them.

use crate::plant::{LENGTH, Room, Workshop};
use arbitrary::{Result, Unstructured};
use core::num::NonZeroU64;
use slqg::Tick;
use slqg::actuator::{Actuator, memory_len};
use slqg::authentication::{
    AlarmSettings, Association, Guard, Guarded, HEAD_LEN, HELLO_LEN, Identity, Key, Keys, Nonces, NotTaken,
    Opened, SEALED, Session, Side,
};
use slqg::blob::DesignId;
use slqg::controller::Controller;
use slqg::nalgebra::SVector;
use slqg::wire::{self, Measurement};

const IDENTITY: Identity = Identity { loop_id: 7, design: DesignId(0x1122_3344) };
const BUFFER: usize = 96;
/// Cycles on a clean line after which the ends are in sessions again: an end asks after 64 silent ones, then every 16.
const PATIENCE: u32 = 200;

/// An end of the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Controller,
    Actuator,
    Sensor,
}

/// What was sent, sealed frames and hellos.
#[derive(Debug, Clone)]
pub(super) struct Sent {
    pub(super) to: End,
    pub(super) bytes: Vec<u8>,
    was_taken: bool,
}

/// Everything that was sent.
#[derive(Debug, Default)]
pub(super) struct Line {
    pub(super) sent: Vec<Sent>,
}

impl Line {
    fn put(&mut self, to: End, bytes: &[u8]) {
        self.sent.push(Sent { to, bytes: bytes.into(), was_taken: false });
    }
}

/// Nonces by counting: each end counts from elsewhere.
struct Counter(u64);

impl Nonces for Counter {
    fn next(&mut self) -> NonZeroU64 {
        self.0 += 1;
        NonZeroU64::new(self.0).expect("far from the end")
    }
}

/// The ends behind guards and, for what has been opened, without.
pub(super) struct Loop<'m> {
    controller: Guarded<Controller<'m, f32, 2, 1, 1>, 2>,
    actuator: Guarded<Actuator<'m, f32, 1>, 1>,
    sensor: Guard<1>,
    plain_controller: Controller<'m, f32, 2, 1, 1>,
    plain_actuator: Actuator<'m, f32, 1>,
    nonces: [Counter; 3],
}

fn session(association: Association, side: Side) -> Session {
    let key = |number: u8| Key::new([10 * association as u8 + number; 16]);
    Session::new(association, side, IDENTITY, Keys { downstream: key(0), upstream: key(1) })
}

impl Loop<'_> {
    /// Makes a loop of the script's choice, and plays.
    pub(super) fn played(
        script: &mut Unstructured<'_>,
        play: impl FnOnce(&mut Loop<'_>, &mut Line, &mut Unstructured<'_>) -> Result<()>,
    ) -> Result<()> {
        // One that is wary may be lost, and says nothing then.
        let workshop = Workshop::<f32>::read(script)?.believing();
        let (design, start) = (workshop.design(), Tick(u32::MAX - 3));
        let mut rooms = [Room::new(design.sizes()), Room::new(design.sizes())];
        let [one, other] = &mut rooms;
        let mut memory = [[SVector::zeros(); memory_len(LENGTH)]; 2];
        let [first, second] = &mut memory;
        let controller = |room| Controller::new(design, start, room).expect("a design that fits");
        let of_controller =
            [session(Association::Loop, Side::Upstream), session(Association::Sensing, Side::Downstream)];
        let guard = |session| Guard::new([session], AlarmSettings::default());
        let mut looped = Loop {
            controller: Guarded::new(
                controller(one.lend()),
                Guard::new(of_controller, AlarmSettings::default()),
            ),
            actuator: Guarded::new(
                Actuator::new(workshop.settings, start, first),
                guard(session(Association::Loop, Side::Downstream)),
            ),
            sensor: guard(session(Association::Sensing, Side::Upstream)),
            plain_controller: controller(other.lend()),
            plain_actuator: Actuator::new(workshop.settings, start, second),
            nonces: [Counter(1000), Counter(2000), Counter(3000)],
        };
        play(&mut looped, &mut Line::default(), script)
    }

    pub(super) fn tick(&self) -> Tick {
        self.plain_controller.tick()
    }

    /// Runs a cycle of every end; what they send goes on record, and nothing is delivered.
    pub(super) fn cycle(&mut self, line: &mut Line, output: f32) {
        let (mut buffer, mut plain) = ([0; BUFFER], [0; BUFFER]);
        self.sensor.cycle();
        let measurement = Measurement { tick: self.tick(), output: SVector::from([output]) };
        let frame = wire::encode_measurement(&measurement, &mut plain).expect("there is room");
        if let Ok(sealed) = self.sensor.seal(frame, &mut buffer) {
            line.put(End::Controller, sealed);
        }
        let sealed = self.controller.cycle(&mut buffer).expect("there is room");
        let frame = self.plain_controller.cycle(&mut plain).expect("there is room");
        if let Some(sealed) = sealed {
            assert_eq!(Some(&sealed[HEAD_LEN..]), frame, "the controller without a guard says the same");
            line.put(End::Actuator, sealed);
        }
        let (applied, expected) = (self.actuator.step(), self.plain_actuator.step());
        assert_eq!(applied, expected, "the actuator without a guard does the same");
        if let Some(sealed) = self.actuator.acknowledgement(2, &mut buffer) {
            line.put(End::Controller, sealed);
        }
        let means =
            [self.controller.end(), &self.plain_controller].map(|end| *end.estimator().posterior_mean());
        assert_eq!(means[0], means[1], "the controller without a guard believes the same");
        self.due(line);
    }

    /// Hellos that are due go on record. Whoever they are not for refuses them.
    fn due(&mut self, line: &mut Line) {
        let [of_controller, of_actuator, of_sensor] = &mut self.nonces;
        while let Some(hello) = self.controller.guard_mut().due(of_controller) {
            line.put(End::Actuator, &hello);
            line.put(End::Sensor, &hello);
        }
        for hello in [self.actuator.guard_mut().due(of_actuator), self.sensor.due(of_sensor)] {
            hello.iter().for_each(|hello| line.put(End::Controller, hello));
        }
    }

    /// Hands bytes to an end. What it takes must have been sent to it, and not been taken before.
    pub(super) fn deliver(&mut self, line: &mut Line, to: End, bytes: &[u8]) {
        let [of_controller, of_actuator, of_sensor] = &mut self.nonces;
        let plain = bytes.get(HEAD_LEN..).unwrap_or_default();
        // Whether a frame was opened; and whether the end behind the guard has then taken it.
        let (opened, answer) = match to {
            End::Controller => told(self.controller.receive(bytes, of_controller)),
            End::Actuator => told(self.actuator.receive(bytes, of_actuator)),
            End::Sensor => match self.sensor.open(bytes, of_sensor) {
                Ok(Opened::Frame(_)) => panic!("a sensor takes no frames"),
                Ok(Opened::Hello(answer)) => (None, answer),
                Err(_) => (None, None),
            },
        };
        if let (Some(is_taken), Some(&SEALED)) = (opened, bytes.first()) {
            let sent = line.sent.iter_mut().find(|sent| sent.to == to && sent.bytes == bytes);
            let sent = sent.expect("only what was sealed for this end is opened");
            assert!(!core::mem::replace(&mut sent.was_taken, true), "each is opened once");
            let plain_taken = match to {
                End::Controller => self.plain_controller.receive(plain).is_ok(),
                _ => self.plain_actuator.receive(plain).is_ok(),
            };
            assert_eq!(is_taken, plain_taken, "the end without a guard takes the same");
        }
        if let Some(answer) = answer {
            match to {
                End::Controller => {
                    line.put(End::Actuator, &answer);
                    line.put(End::Sensor, &answer);
                }
                End::Actuator | End::Sensor => line.put(End::Controller, &answer),
            }
        }
    }

    /// Delivers the hellos that are due, and what is answered, until nobody has anything to say.
    pub(super) fn shake(&mut self, line: &mut Line) {
        let next = line.sent.len();
        self.due(line);
        self.deliver_from(line, next);
    }

    /// Delivers what is on record from a place on, and what comes of it.
    fn deliver_from(&mut self, line: &mut Line, mut next: usize) {
        while let Some(Sent { to, bytes, .. }) = line.sent.get(next).cloned() {
            self.deliver(line, to, &bytes);
            next += 1;
        }
    }

    /// On a clean line frames are soon taken again in every direction.
    pub(super) fn recovers(&mut self) {
        let mut line = Line::default();
        for _ in 0..PATIENCE {
            let next = line.sent.len();
            self.cycle(&mut line, 0.5);
            self.deliver_from(&mut line, next);
            let taken =
                |end| line.sent[next..].iter().filter(|sent| sent.to == end && sent.was_taken).count();
            if taken(End::Actuator) == 1 && taken(End::Controller) == 2 {
                return;
            }
        }
        panic!("no sessions after {PATIENCE} cycles on a clean line");
    }
}

/// Whether a frame was opened, and if so whether the end took it; and the answer to a hello.
fn told<R>(
    received: core::result::Result<Option<[u8; HELLO_LEN]>, NotTaken<R>>,
) -> (Option<bool>, Option<[u8; HELLO_LEN]>) {
    match received {
        Ok(answer) => (Some(true), answer),
        Err(NotTaken::Rejected(_)) => (Some(false), None),
        Err(NotTaken::Refused(_)) => (None, None),
    }
}
