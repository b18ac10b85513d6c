//! A file and the devices that it is like: their texts, and the tables of both together.

use super::check::{check, device_name, known_names};
use super::conditions;
use super::device::Device;
use super::error::{DeviceFileError, Located, problem};
use super::show::show;
use super::toml_file::{BlockToml, DeviceToml, FORMAT, FormatToml};
use super::words::unknown;
use profivac_client::suggestion::with_suggestion;
use profivac_devices::catalog::model_named;
use profivac_host::text_file::line_and_column;
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The most devices of which each is like the next. chosen.
const MAX_DEPTH: usize = 8;

/// Reads the text of a file, with a path that is the same for every way to name the file.
pub type ReadFile<'a> = &'a dyn Fn(&Path) -> Result<(PathBuf, String), String>;

/// The text of a file, or of a device that profivac has.
struct Layer {
    /// The file as the user named it, or the name of the device.
    label: String,
    /// The path of the file.
    path: Option<PathBuf>,
    text: String,
    /// The octets of the layers before.
    start: usize,
    /// The value of `like`.
    like: Range<usize>,
}

/// A file and the devices that it is like, each followed by the one that it is like.
pub struct Chain<'a> {
    layers: Vec<Layer>,
    read: ReadFile<'a>,
}

impl<'a> Chain<'a> {
    pub const fn new(read: ReadFile<'a>) -> Self {
        Self { layers: Vec::new(), read }
    }

    /// The tables of the file with this text.
    pub fn device(&mut self, label: &str, path: Option<PathBuf>, text: String) -> Result<Device, DeviceFileError> {
        self.push(label.to_owned(), path, text);
        let (_, device, _) = self.top().map_err(|located| self.error(located))?;
        Ok(device)
    }

    /// All texts: files with the same ones describe the same device.
    pub fn texts(&self) -> String {
        self.layers.iter().map(|layer| layer.text.as_str()).collect::<Vec<_>>().join("\0")
    }

    /// The devices that the file is like, the nearest first.
    pub fn parents(&self) -> impl Iterator<Item = &str> {
        self.layers.iter().skip(1).map(|layer| layer.label.as_str())
    }

    fn push(&mut self, label: String, path: Option<PathBuf>, text: String) {
        let start =
            self.layers.last().map_or(0, |layer| layer.start.saturating_add(layer.text.len()).saturating_add(1));
        self.layers.push(Layer { label, path, text, start, like: start..start });
    }

    /// The tables of the last layer as TOML, with those of the devices that it is like, and checked; then those devices.
    fn top(&mut self) -> Result<(DeviceToml, Device, Vec<Device>), Located> {
        let Some(layer) = self.layers.last() else { return problem(0..0, "no file") };
        let is_file = layer.path.is_some() || self.layers.len() == 1;
        let mut toml = parse(layer)?;
        if is_file {
            device_name(&toml.name)?;
        }
        unique_blocks(&toml.block)?;
        let Some(like) = toml.like.take() else {
            no_differences(&toml)?;
            let device = check(&toml)?;
            return Ok((toml, device, Vec::new()));
        };
        if let Some(layer) = self.layers.last_mut() {
            layer.like = like.span();
        }
        self.push_parent(&like)?;
        let (parent_toml, parent, mut ancestors) = self.top()?;
        ancestors.push(parent);
        let toml = merge(toml, parent_toml)?;
        let device = check(&toml)?;
        // A file in the middle may leave out the row that has the condition.
        ancestors.iter().try_for_each(|ancestor| conditions::check_inherited(&device, ancestor, &like))?;
        Ok((toml, device, ancestors))
    }

    /// Adds the layer of the device that `like` names.
    fn push_parent(&mut self, like: &Spanned<String>) -> Result<(), Located> {
        let text = like.get_ref();
        if self.layers.len() >= MAX_DEPTH {
            return problem(
                like.span(),
                format!("expected at most {MAX_DEPTH} devices of which each is like the next"),
            );
        }
        if Path::new(text).extension().is_none_or(|ending| ending != "toml") {
            let known = || known_names().collect::<Vec<_>>().join(", ");
            let expected =
                || format!("a device that profivac has, one of: {}, or a device file like \"my.toml\"", known());
            let model = model_named(text).ok_or_else(|| unknown(like, &expected(), known_names()))?;
            self.push(model.name.to_owned(), None, show(model));
            return Ok(());
        }
        let folder = self.layers.last().and_then(|layer| layer.path.as_deref()).and_then(Path::parent);
        let file = folder.unwrap_or(Path::new("")).join(text);
        let (path, contents) =
            (self.read)(&file).or_else(|error| problem(like.span(), format!("{}: {error}", file.display())))?;
        if self.layers.iter().any(|layer| layer.path.as_ref() == Some(&path)) {
            let way: Vec<_> = self.layers.iter().map(|layer| layer.label.as_str()).collect();
            return problem(
                like.span(),
                format!("the devices are like each other in a circle: {}, {text}; delete one like", way.join(", ")),
            );
        }
        self.push(file.display().to_string(), Some(path), contents);
        Ok(())
    }

    /// The error at its position: in its file, or at the `like` that names the device.
    fn error(&self, Located { span, text }: Located) -> DeviceFileError {
        let number = self.layers.iter().rposition(|layer| layer.start <= span.start).unwrap_or_default();
        let at = |layer: &Layer, offset: usize| line_and_column(&layer.text, offset.saturating_sub(layer.start));
        match (self.layers.get(number), number.checked_sub(1).and_then(|child| self.layers.get(child))) {
            (Some(layer), Some(child)) if layer.path.is_none() => {
                let (name, (line, _)) = (&layer.label, at(layer, span.start));
                DeviceFileError {
                    file: child.label.clone(),
                    position: Some(at(child, child.like.start)),
                    text: format!("line {line} of `profivac device show {name}` does not fit this file: {text}"),
                }
            }
            (Some(layer), _) => {
                DeviceFileError { file: layer.label.clone(), position: Some(at(layer, span.start)), text }
            }
            (None, _) => DeviceFileError { file: String::new(), position: None, text },
        }
    }
}

/// The tables of one text. Blanks before it make positions count from the first layer.
fn parse(layer: &Layer) -> Result<DeviceToml, Located> {
    let mut text = " ".repeat(layer.start);
    text.push_str(&layer.text);
    let syntax = |error: toml::de::Error| Located {
        span: error.span().unwrap_or(layer.start..layer.start),
        text: with_suggestion(error.message()),
    };
    let FormatToml { format } = toml::from_str(&text).map_err(syntax)?;
    match format {
        Some(format) if *format.get_ref() == FORMAT => toml::from_str(&text).map_err(syntax),
        Some(format) if *format.get_ref() > FORMAT => problem(
            format.span(),
            format!("this profivac reads format {FORMAT}, found {}: use a newer profivac", format.get_ref()),
        ),
        Some(format) => problem(format.span(), format!("expected format = {FORMAT}, found {}", format.get_ref())),
        None => {
            problem(layer.start..layer.start, format!("expected the key format = {FORMAT}; add it as the first line"))
        }
    }
}

fn unique_blocks(blocks: &[BlockToml]) -> Result<(), Located> {
    let mut names = BTreeSet::new();
    for block in blocks {
        if !names.insert(block.name.get_ref()) {
            return problem(
                block.name.span(),
                format!("the block {:?} is here twice; give each a name of its own", block.name.get_ref()),
            );
        }
    }
    Ok(())
}

/// Only a file that is like another device has blocks without something.
fn no_differences(toml: &DeviceToml) -> Result<(), Located> {
    match toml.block.iter().find_map(|block| block.without.first()) {
        Some(index) => problem(index.span(), "without is for a file with like; delete it"),
        None => Ok(()),
    }
}

/// The tables of a device that is like `parent`: what `own` does not have, `parent` has. Telegrams, codes, blocks and the rows of a
/// block are taken one by one.
fn merge(own: DeviceToml, parent: DeviceToml) -> Result<DeviceToml, Located> {
    let mut merged = DeviceToml {
        behaviour: own.behaviour.or(parent.behaviour),
        left_out: own.left_out.or(parent.left_out),
        vendor: own.vendor.or(parent.vendor),
        manual: own.manual.or(parent.manual),
        errata: own.errata.or(parent.errata),
        ident: own.ident.or(parent.ident),
        services: own.services.or(parent.services),
        units: own.units.or(parent.units),
        max_integer: own.max_integer.or(parent.max_integer),
        user_parameters: own.user_parameters.or(parent.user_parameters),
        free_bits: own.free_bits.or(parent.free_bits),
        outputs: parent.outputs,
        inputs: parent.inputs,
        // The default of a list of configurations belongs to it.
        default_configuration: match (own.default_configuration, &own.configurations) {
            (None, None) => parent.default_configuration,
            (default, _) => default,
        },
        configurations: own.configurations.or(parent.configurations),
        values: own.values.or(parent.values),
        parts: own.parts.or(parent.parts),
        parameter_channel: own.parameter_channel.or(parent.parameter_channel),
        alarms: own.alarms.or(parent.alarms),
        faults: own.faults.or(parent.faults),
        gsd: own.gsd.or(parent.gsd),
        block: parent.block,
        codes: parent.codes,
        ..own
    };
    merged.outputs.extend(own.outputs);
    merged.inputs.extend(own.inputs);
    merged.codes.extend(own.codes);
    for block in own.block {
        match merged.block.iter_mut().find(|other| other.name.get_ref() == block.name.get_ref()) {
            Some(other) => change(other, block)?,
            None if block.without.is_empty() => merged.block.push(block),
            None => {
                let known: Vec<_> = merged.block.iter().map(|other| other.name.get_ref().as_str()).collect();
                let expected = format!("the name of an inherited block, one of: {}", known.join(", "));
                return Err(unknown(&block.name, &expected, known));
            }
        }
    }
    Ok(merged)
}

/// Changes an inherited block.
fn change(inherited: &mut BlockToml, own: BlockToml) -> Result<(), Located> {
    for index in &own.without {
        let before = inherited.parameters.len();
        inherited.parameters.retain(|row| row.get_ref().index != *index.get_ref());
        if inherited.parameters.len() == before {
            return problem(
                index.span(),
                format!("the inherited block has no index {}; delete it here", index.get_ref()),
            );
        }
    }
    // Only inherited rows are replaced: an index that is twice in the file is found later.
    let own_indices: BTreeSet<u8> = own.parameters.iter().map(|row| row.get_ref().index).collect();
    inherited.parameters.retain(|row| !own_indices.contains(&row.get_ref().index));
    inherited.parameters.extend(own.parameters);
    inherited.block_type = own.block_type.or(inherited.block_type);
    if own.behaviour.is_some() {
        inherited.behaviour = own.behaviour;
    }
    if let Some(at) = own.at {
        inherited.at = Some(at);
    }
    inherited.name = own.name;
    Ok(())
}
