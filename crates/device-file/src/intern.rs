//! The models of this process: one for each content of a file.

use super::device::Device;
use profivac_devices::catalog::KnownDevices;
use profivac_devices::described::Description;
use profivac_devices::model::Model;
use std::collections::HashMap;
use std::fmt;
use std::sync::{LazyLock, Mutex, PoisonError};

/// The most different contents that a process loads. chosen: five times the files of the largest station that was tried; a program
/// that loads a file whenever it changes then says so instead of filling the memory.
pub const MAX_MODELS: usize = 256;

/// The process has loaded [`MAX_MODELS`] different device files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooManyModels;

impl fmt::Display for TooManyModels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "expected at most {MAX_MODELS} different device files in one run of the program; start it again")
    }
}

impl std::error::Error for TooManyModels {}

/// A model, the built-in device whose behaviour it has, and what that leaves out.
#[derive(Clone, Copy)]
struct Made {
    model: &'static Model,
    like: Option<&'static Model>,
    left_out: &'static str,
    description: Option<&'static Description>,
}

static MODELS: LazyLock<Mutex<HashMap<String, Made>>> = LazyLock::new(Mutex::default);

fn made(model: &Model) -> Option<Made> {
    let models = MODELS.lock().unwrap_or_else(PoisonError::into_inner);
    models.values().find(|made| made.model == model).copied()
}

/// The built-in device whose behaviour the device of a file has: the one that it names, or is like, directly or through other files.
/// `None` for a device without behaviour, and for a built-in one.
#[must_use]
pub fn built_in_like(model: &Model) -> Option<&'static Model> {
    made(model)?.like
}

/// What the behaviour of the device of a file leaves out; empty if its file says nothing.
#[must_use]
pub fn left_out(model: &Model) -> &'static str {
    made(model).map_or("", |made| made.left_out)
}

/// The behaviours that the blocks of the device of a file name. `None` if they name none.
#[must_use]
pub fn description(model: &Model) -> Option<&'static Description> {
    made(model)?.description
}

static LISTS: Mutex<Vec<&'static [&'static Model]>> = Mutex::new(Vec::new());

/// These models beside the built-in ones. A program has few lists: one for each set of files that a command or a station names.
pub fn of_models(models: Vec<&'static Model>) -> KnownDevices {
    let mut lists = LISTS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(list) = lists.iter().find(|list| **list == models) {
        return KnownDevices::with(list);
    }
    let list: &'static [&'static Model] = Vec::leak(models);
    lists.push(list);
    KnownDevices::with(list)
}

/// The model of these texts: the one that the process has, or the tables as a new one.
pub fn model(texts: String, mut device: Device) -> Result<&'static Model, TooManyModels> {
    let mut models = MODELS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(made) = models.get(&texts) {
        return Ok(made.model);
    }
    if models.len() >= MAX_MODELS {
        return Err(TooManyModels);
    }
    let (like, left_out) = (device.behaviour, std::mem::take(&mut device.left_out).leak());
    let behaviours: Vec<_> = device.blocks.iter().map(|block| block.behaviour).collect();
    let thresholds = device.thresholds();
    let model = device.leak();
    let description = behaviours.iter().any(Option::is_some).then(|| {
        let (blocks, thresholds) = (behaviours.leak(), Box::leak(Box::new(thresholds)));
        &*Box::leak(Box::new(Description { model, blocks, thresholds }))
    });
    models.insert(texts, Made { model, like, left_out, description });
    Ok(model)
}
