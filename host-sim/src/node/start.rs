//! From the command line to a node that runs, one function for each role.

use super::{
    NodeError,
    actuator::ActuatorNode,
    carrier,
    clock::WallTime,
    controller::{ControllerNode, uncertain},
    event_loop::Channel,
    loaded::Loaded,
    options::{Actuator, Controller, Link, Options, Phases, Plant, Relay, Role},
    plant::PlantNode,
    relay::{Fates, RelayNode},
    transport::udp::Udp,
};
use crate::{
    contender::Contender,
    fitted::Fitted,
    lent::Lent,
    objective::Objective,
    plant::TruePlant,
    random::{Purpose, stream},
    size_class::InSizeClass,
};
use gain_gen::design::{self, Acknowledgement};
use nalgebra::{DVector, SVector};
use slqg::{Scalar, controller, wire};
use std::time::Duration;

/// Scale of the initial covariance where a controller begins anew, at least.
const AGAIN: f64 = 2.0;

/// Runs a node until its limit or a signal; what comes back is to be printed.
///
/// # Errors
/// If the design, an option or the network does not allow it to begin.
pub fn run(options: &Options) -> Result<String, NodeError> {
    in_role(&options.role)
}

fn in_role(role: &Role) -> Result<String, NodeError> {
    match role {
        Role::Controller(options) => run_controller(options),
        Role::Actuator(options) => run_actuator(options),
        Role::Plant(options) => run_plant(options),
        Role::Relay(options) => run_relay(options),
    }
}

fn check(phases: &Phases) -> Result<(), NodeError> {
    let Phases { controller_at, actuator_at } = phases;
    if controller_at < actuator_at {
        return Ok(());
    }
    Err(NodeError::Input(format!(
        "--controller-at: found {controller_at}, and --actuator-at {actuator_at}; the controller must act first"
    )))
}

fn run_controller(options: &Controller) -> Result<String, NodeError> {
    struct Work<'w> {
        loaded: &'w Loaded<'w>,
        contender: &'w Contender,
        options: &'w Controller,
    }
    impl InSizeClass for Work<'_> {
        type Output = Result<String, NodeError>;
        fn run<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(self) -> Self::Output {
            let fitted = Fitted::<T, NX, NU, NY>::new(&self.loaded.design, self.contender);
            self.with_room(&fitted)
        }
    }
    impl Work<'_> {
        fn with_room<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
            &self,
            fitted: &Fitted<T, NX, NU, NY>,
        ) -> Result<String, NodeError> {
            let (loaded, options) = (self.loaded, self.options);
            let unfit = |error: &dyn std::fmt::Display| {
                loaded.wrong(format_args!("controller.scalar: {error}; compute in f64"))
            };
            let design = fitted.design().map_err(|error| unfit(&error))?;
            let model = uncertain(design.model, T::nearest(options.initial_covariance_scale - 1.0));
            let again =
                uncertain(design.model, T::nearest(AGAIN.max(options.initial_covariance_scale) - 1.0));
            let length = design.gains.length();
            let again = controller::Design { model: &again, ..design };
            let design = controller::Design { model: &model, ..design };
            let (pacer, punctuality) = loaded.paced(options.phases.controller_at, &options.pace)?;
            let mut memory = Lent::for_ends(fitted).map_err(|error| unfit(&error))?;
            let (memory, ..) = memory.lend();
            let mut node = ControllerNode::new(fitted, design, again, pacer, punctuality, memory)
                .map_err(|error| loaded.wrong(format_args!("does not fit the controller: {error:?}")))?;
            let transport = carrier::open(
                &options.common,
                &options.carrier,
                &[Channel::Measurement, Channel::Acknowledgement],
                (Channel::Control, options.actuator),
                None,
                wire::control_len(NU, length, T::BYTES).max(wire::measurement_len(NY, T::BYTES)),
            )?;
            loaded.run("controller", &mut node, transport)
        }
    }
    check(&options.phases)?;
    let loaded = Loaded::new(&options.common)?;
    let contender = loaded.contender()?;
    loaded.dispatch(Work { loaded: &loaded, contender: &contender, options })
}

fn run_actuator(options: &Actuator) -> Result<String, NodeError> {
    struct Work<'w> {
        loaded: &'w Loaded<'w>,
        contender: &'w Contender,
        options: &'w Actuator,
    }
    impl InSizeClass for Work<'_> {
        type Output = Result<String, NodeError>;
        fn run<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(self) -> Self::Output {
            let Self { loaded, contender, options } = self;
            let fitted = Fitted::<T, NX, NU, NY>::new(&loaded.design, contender);
            let design = fitted
                .design()
                .map_err(|error| loaded.wrong(format_args!("controller.scalar: {error}; compute in f64")))?;
            let network = &loaded.design.network;
            let told = match network.acknowledgement {
                Acknowledgement::None => 0,
                Acknowledgement::Instant | Acknowledgement::Over(_) => network.acknowledged_cycles,
            };
            let (pacer, punctuality) = loaded.paced(options.phases.actuator_at, &options.pace)?;
            let inputs = loaded.design.plant.inputs();
            let mut memory = vec![SVector::zeros(); slqg::actuator::memory_len(design.gains.length())];
            let mut node = ActuatorNode::new(design.actuator, inputs, told, pacer, punctuality, &mut memory);
            let transport = carrier::open(
                &options.common,
                &options.carrier,
                &[Channel::Control],
                (Channel::Acknowledgement, options.controller),
                options.plant,
                wire::control_len(NU, design.gains.length(), T::BYTES),
            )?;
            loaded.run("actuator", &mut node, transport)
        }
    }
    check(&options.phases)?;
    let loaded = Loaded::new(&options.common)?;
    let contender = loaded.contender()?;
    loaded.dispatch(Work { loaded: &loaded, contender: &contender, options })
}

fn run_plant(options: &Plant) -> Result<String, NodeError> {
    struct Work<'w> {
        loaded: &'w Loaded<'w>,
        options: &'w Plant,
    }
    impl InSizeClass for Work<'_> {
        type Output = Result<String, NodeError>;
        fn run<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(self) -> Self::Output {
            let Self { loaded, options } = self;
            let design = &loaded.design;
            let set_point = design.tracking.as_ref();
            let set_point = set_point.and_then(|tracking| tracking.reference(0, design.plant.sample_time));
            let reference: Vec<DVector<f64>> = set_point.into_iter().collect();
            let plant = TruePlant::<NX, NU, NY>::new(&design.plant);
            let objective = Objective::new(design, &reference);
            let (pacer, punctuality) = loaded.paced(0.0, &options.pace)?;
            let inputs = design.plant.inputs();
            let mut node =
                PlantNode::<T, NX, NU, NY>::new(&plant, &objective, inputs, options.seed, pacer, punctuality);
            let mut also = options.common.from.clone();
            also.push(options.actuator.ip());
            let transport = Udp::bind(options.udp, vec![(Channel::Measurement, options.controller)], &also)?;
            loaded.run("plant", &mut node, Box::new(transport))
        }
    }
    let loaded = Loaded::new(&options.common)?;
    loaded.dispatch(Work { loaded: &loaded, options })
}

fn run_relay(options: &Relay) -> Result<String, NodeError> {
    let loaded = Loaded::new(&options.common)?;
    let sample_time = loaded.timetable(0.0)?.sample_time();
    let purpose = match options.link {
        Link::ControllerToActuator => Purpose::ActuatorLink,
        Link::SensorToController => Purpose::SensorLink,
        Link::Acknowledgement => Purpose::AcknowledgementLink,
    };
    let fates = match (options.loss, &options.delay_ms) {
        (None, None) => {
            Fates::of(&link(&loaded, options.link)?, sample_time, stream(options.seed, 0, purpose))
        }
        (loss, delay) => {
            let at_once = Duration::ZERO..=Duration::ZERO;
            Fates::Uniform { loss: loss.unwrap_or(0.0), delay: delay.clone().unwrap_or(at_once) }
        }
    };
    let random = stream(options.seed, 0, purpose);
    let mut node = RelayNode::new(fates, options.duplicate, sample_time, random, WallTime::now());
    let transport = Udp::bind(options.udp, vec![(Channel::Relayed, options.to)], &options.common.from)?;
    loaded.run("relay", &mut node, Box::new(transport))
}

fn link(loaded: &Loaded<'_>, link: Link) -> Result<design::Link, NodeError> {
    let network = &loaded.design.network;
    Ok(match link {
        Link::ControllerToActuator => network.controller_to_actuator.clone(),
        Link::SensorToController => network.sensor_to_controller.clone(),
        Link::Acknowledgement => match &network.acknowledgement {
            Acknowledgement::Instant => design::Link::perfect(),
            Acknowledgement::Over(link) => link.clone(),
            Acknowledgement::None => {
                return Err(loaded.wrong(
                    "network.acknowledgement: found \"none\", so there is nothing to pass on; give delays, or leave this relay out",
                ));
            }
        },
    })
}
