//! Errors in `[[segment.slave]]`.

use profivac_gsd_slave::{CatalogError, SlaveError, listed};
use profivac_station::config::PointType;
use std::path::PathBuf;

/// A problem of a slave by its GSD file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SlaveProblem {
    /// The GSD file cannot be read.
    #[error("{0}")]
    File(CatalogError),
    /// The folder has no GSD file, or those of several devices.
    #[error("expected the GSD file of one device, {} has {}; name one file", path.display(), listed(found.iter().cloned()))]
    SeveralFiles {
        /// The folder.
        path: PathBuf,
        /// The files with their devices.
        found: Vec<String>,
    },
    /// The slave has no description, or two.
    #[error("expected either gsd (the GSD file of the slave) or device (its device file)")]
    GsdOrDevice,
    /// Modules or parameters do not fit the GSD file.
    #[error("{0}")]
    Selection(SlaveError),
    /// The station cannot own a slave on a segment on which it only listens.
    #[error("own = true needs a master of the station, and the segment has listen-only = true: delete own")]
    OwnedByListener,
    /// The station owns a slave with outputs, and the file does not say which.
    #[error(
        "the station sends outputs to the slave with own = true, and zeros can stop a pump or close a valve: {modules}; set outputs to \
         {octets} octets in hexadecimal, or to a table {{ SLOT = \"OCTETS\" }}; or delete own, and the station only reads the slave"
    )]
    OutputsNeeded {
        /// The modules with outputs.
        modules: String,
        /// The length of all outputs.
        octets: usize,
    },
    /// Outputs of a slave that the station does not own.
    #[error(
        "outputs need own = true: the station sends nothing to a slave that it does not own; set own, or delete outputs"
    )]
    OutputsWithoutOwn,
    /// The outputs are no octets.
    #[error("expected octets in hexadecimal like \"01 00\", found {0:?}")]
    OutputOctets(String),
    /// The outputs have another length.
    #[error("expected {expected} octets of outputs for {of}, found {found}")]
    OutputLength {
        /// The modules.
        of: String,
        /// The length.
        expected: usize,
        /// The number of octets.
        found: usize,
    },
    /// No module with outputs is in this slot.
    #[error("slot {slot} has no module with outputs; modules with outputs: {possible}")]
    OutputSlot {
        /// The slot.
        slot: String,
        /// The modules with outputs.
        possible: String,
    },
    /// A module with outputs has none in the file.
    #[error(
        "the outputs of {0} are missing: zeros can stop a pump or close a valve, so each module with outputs needs its own"
    )]
    OutputMissing(String),
    /// Octets or bits of the outputs have no value.
    #[error(
        "these outputs have no value: {missing}; zeros can stop a pump or close a valve, so each bit needs one: add \
         [[segment.slave.output]] for them, or set outputs to all octets, which the named outputs then change"
    )]
    OutputsWithoutValue {
        /// The octets.
        missing: String,
    },
    /// Two outputs take the same bits.
    #[error("the output {output:?} takes bits that another output has; correct octet, bit or type")]
    OutputTwice {
        /// The output.
        output: String,
    },
    /// A value is none of the output.
    #[error("the output {output:?}: expected {expected}, found {found}")]
    OutputValue {
        /// The output.
        output: String,
        /// The possible values.
        expected: String,
        /// The value.
        found: String,
    },
    /// The module of a point does not exist, or has no inputs; of an output no outputs.
    #[error("the point {point:?}: {problem}; modules with {what}: {possible}")]
    PointModule {
        /// The point.
        point: String,
        /// What is wrong.
        problem: String,
        /// `inputs` or `outputs`.
        what: &'static str,
        /// The modules with them.
        possible: String,
    },
    /// A point is not within the inputs of its module.
    #[error("the point {point:?} needs {needed}, and {module} has the octets 0 to {last}")]
    PointBeyond {
        /// The point.
        point: String,
        /// The octets of the point.
        needed: String,
        /// The module.
        module: String,
        /// The last octet of the module.
        last: usize,
    },
    /// The type of a point does not exist.
    #[error("expected a type, one of {}, found {found:?}", types())]
    PointType {
        /// The word.
        found: String,
    },
    /// A point never has the text of its alarm.
    #[error("the point {point:?} never is {found:?}; its texts: {}", listed(known.iter().cloned()))]
    PointText {
        /// The point.
        point: String,
        /// The text.
        found: String,
        /// The texts that it may have.
        known: Vec<String>,
    },
    /// A value of a point.
    #[error("the point {point:?}: expected {expected}, found {found}")]
    PointValue {
        /// The point.
        point: String,
        /// The expected value.
        expected: &'static str,
        /// The value.
        found: String,
    },
}

fn types() -> String {
    PointType::ALL.map(|(word, _)| word).join(", ")
}
