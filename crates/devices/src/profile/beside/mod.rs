//! A device that works beside its slave, for a microcontroller: no computation and no memory delays an answer on the bus.
//!
//! [`BusSide`] is the device of the slave. It answers from the tables and from its copy of the inputs, and notes the requests of masters.
//! [`Application`] has the measurement, the parameters and the nonvolatile memory. Each has a context of its own: the slave an
//! interrupt, the application the main loop. Two short copies join them, the only moments in which one must not interrupt the other:
//!
//! | Copy | From | To | Contents |
//! |---|---|---|---|
//! | [`Tasks`] | [`BusSide::take_tasks`] | [`Application::adopt`] | user parameters, configuration, outputs, one acyclic access |
//! | [`Snapshot`] | [`Application::snapshot`] | [`BusSide::publish`] | inputs, the result of the access, the parameter that the channel reads |
//!
//! What a master sees: Set_Prm and Chk_Cfg are decided from the tables at once; until the first inputs of the new configuration are
//! there, the diagnosis has Stat_Diag. The slave acknowledges a poll for an acyclic response that is not there yet, and the parameter
//! channel answers with AK 0. A write is answered when its values are durable.
//!
//! ```
//! use profivac_devices::SimulatedDevice;
//! use profivac_devices::bcg450::Bcg450;
//! use profivac_devices::profile::Setup;
//! use profivac_devices::profile::beside::{Application, BusSide};
//! use profivac_devices::store::RamStore;
//! use profivac_dp::slave::{Device, Dpv1Error, Relation};
//!
//! let mut gauge: Bcg450<RamStore> = Bcg450::new(RamStore::default(), Setup::new(5));
//! let mut bus = BusSide::new(&gauge);
//! let mut application = Application::new(&mut gauge);
//! // A master reads Device State; the application finds the value later.
//! let mut record = [0; 240];
//! let _ = bus.read(Relation::Ms2(0), 0, 25, &mut record);
//! assert!(bus.is_executing(Relation::Ms2(0)));
//!
//! application.device_mut().advance(0.5);
//! let tasks = bus.take_tasks();
//! application.adopt(&tasks);
//! bus.publish(&application.snapshot());
//! assert_eq!(bus.complete(Relation::Ms2(0), &mut record), Ok(1));
//! assert_eq!(record[0], 2, "IDLE");
//! # Ok::<(), Dpv1Error>(())
//! ```

mod application;
mod bus_side;
mod exchanged;

pub use application::Application;
pub use bus_side::BusSide;
pub use exchanged::{Snapshot, Tasks};
