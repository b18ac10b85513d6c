//! The extension module of the Python package `profivac`. Its classes return tuples; the package makes named types of them.
//!
//! | Module | Holds |
//! |---|---|
//! | `failure` | errors with the exit code of the program, and the exceptions they become |
//! | `waiting` | waits without the interpreter lock, which Ctrl-C ends |
//! | `values` | values of parameters as Python objects, and the tables of a device |
//! | `settings` | a settings file compared with a gauge and written to it |
//! | `bus` | a bus and its gauges |
//! | `devices` | the devices that a bus knows: the twelve, and those of device files |
//! | `conform` | a slave tested against the rules of PROFIBUS DP |
//! | `cyclic` | cyclic data of a gauge that this program owns |
//! | `segment` | virtual gauges in memory, with their controls |
//! | `decode` | recorded traffic, explained |
//! | `plant` | a plant identified from its record |
//! | `plant_model` | the physics of a plant: volumes, tubes, pumps, leaks, walls, and the gauges on them |
//! | `whole` | whole numbers of users |
//! | `rise` | a rate of rise, separated into leak and outgassing |

mod bus;
mod conform;
mod cyclic;
mod decode;
mod devices;
mod failure;
mod plant;
mod plant_model;
mod rise;
mod segment;
mod settings;
mod values;
mod waiting;
mod whole;

use pyo3::prelude::*;

/// The extension module; the package `profivac` is its public face.
#[pymodule]
mod _profivac {
    use super::{Bound, PyModule, PyModuleMethods, PyResult};
    #[pymodule_export]
    use crate::bus::{Bus, Gauge};
    #[pymodule_export]
    use crate::conform::conform;
    #[pymodule_export]
    use crate::cyclic::Cyclic;
    #[pymodule_export]
    use crate::decode::decode;
    #[pymodule_export]
    use crate::plant::Plant;
    #[pymodule_export]
    use crate::plant_model::PlantModel;
    #[pymodule_export]
    use crate::rise::analyse_rise;
    #[pymodule_export]
    use crate::segment::Segment;
    #[pymodule_export]
    use crate::values::{convert, model_of, parameters_of};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
