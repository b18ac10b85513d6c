//! The telegrams and the configurations of a device file.

use super::{MAX_DATA_UNIT, entries, only_once, required};
use crate::device::{OwnedConfiguration, TelegramFields};
use crate::error::{Located, problem};
use crate::toml_file::{ConfigurationToml, DeviceToml, List, Telegrams};
use crate::words::{field, octets};
use profivac_client::values::hex;
use profivac_devices::model::{Field, MAX_COMMANDS, MAX_IMAGE, announces, is_short, octets_of};
use profivac_wire::cfg;
use std::collections::BTreeSet;
use toml::Spanned;

pub(super) fn telegrams(telegrams: &Telegrams) -> Result<TelegramFields, Located> {
    let telegram = |(number, fields): (&String, &List<String>)| {
        // Another way to write a number would be another key of the same telegram.
        let plain = number.parse::<u8>().ok().filter(|plain| plain.to_string() == *number);
        let Some(number) = plain else {
            return problem(
                fields.span(),
                format!("expected the number of a telegram from 0 to 255 without leading zeros, found {number:?}"),
            );
        };
        let known = entries(fields, "field")?.iter().map(field).collect::<Result<Vec<_>, _>>()?;
        Ok((number, known))
    };
    telegrams.iter().map(telegram).collect()
}

pub(super) fn configurations(
    file: &DeviceToml,
    outputs: &TelegramFields,
    inputs: &TelegramFields,
) -> Result<Vec<OwnedConfiguration>, Located> {
    let list = required(file, file.configurations.as_ref(), "configurations")?;
    let mut seen = BTreeSet::new();
    let configuration = |entry: &Spanned<ConfigurationToml>| {
        let ConfigurationToml { outputs: output, inputs: input, octets: text } = entry.get_ref();
        let octets = octets(text)?;
        if !(1..=MAX_DATA_UNIT).contains(&octets.len()) {
            return problem(text.span(), format!("expected the 1 to {MAX_DATA_UNIT} octets of Chk_Cfg"));
        }
        only_once(&mut seen, octets.clone(), text.span(), &format!("the configuration {:?}", text.get_ref()))?;
        let out_fields = fields_of(output.as_ref(), outputs, "outputs")?;
        let in_fields = fields_of(input.as_ref(), inputs, "inputs")?;
        check_configuration(text, &octets, out_fields, in_fields)?;
        let [outputs, inputs] = [output, input].map(|number| number.as_ref().map(|number| *number.get_ref()));
        Ok(OwnedConfiguration { outputs, inputs, octets })
    };
    entries(list, "configuration")?.iter().map(configuration).collect()
}

/// The fields of a telegram of a configuration.
fn fields_of<'a>(
    number: Option<&Spanned<u8>>,
    telegrams: &'a TelegramFields,
    table: &str,
) -> Result<&'a [Field], Located> {
    let Some(number) = number else { return Ok(&[]) };
    telegrams.get(number.get_ref()).map_or_else(
        || {
            let known: Vec<_> = telegrams.keys().map(u8::to_string).collect();
            let number_text = number.get_ref();
            problem(
                number.span(),
                format!("expected a telegram of [{table}], one of: {}; found {number_text}", known.join(", ")),
            )
        },
        |fields| Ok(fields.as_slice()),
    )
}

/// Whether the octets announce the fields, and the image is not too long.
fn check_configuration(
    text: &Spanned<String>,
    octets: &[u8],
    outputs: &[Field],
    inputs: &[Field],
) -> Result<(), Located> {
    let [out_octets, in_octets] = [outputs, inputs].map(octets_of);
    if !is_short(outputs, inputs) {
        return problem(
            text.span(),
            format!(
                "expected at most {MAX_IMAGE} octets of inputs and of outputs, {MAX_COMMANDS} of outputs without the parameter channel; \
                 found {in_octets} and {out_octets}"
            ),
        );
    }
    // Octets without a meaning of their own have no type: an identifier has types of the manufacturer there, or none.
    let has_types = outputs.iter().chain(inputs).any(|field| !matches!(field, Field::Ignored(_)));
    let lengths = cfg::lengths(octets).map(|lengths| (usize::from(lengths.outputs), usize::from(lengths.inputs)));
    if announces(octets, outputs, inputs) || (!has_types && lengths == Ok((out_octets, in_octets))) {
        return Ok(());
    }
    let expected = special_format(outputs, inputs)
        .map_or_else(String::new, |octets| format!("; in the special format these fields are {:?}", hex(&octets)));
    problem(
        text.span(),
        format!(
            "the octets do not announce the telegrams, which have {out_octets} octets of outputs and {in_octets} of inputs{expected}; \
             compare octets and fields with the manual"
        ),
    )
}

/// The configuration data of these fields in the special format with data types; none if a field has no type. profibus-wire 2.6.2.
fn special_format(outputs: &[Field], inputs: &[Field]) -> Option<Vec<u8>> {
    let all: Vec<Field> = outputs.iter().chain(inputs).copied().collect();
    if all.iter().any(|field| field.codes().is_empty()) {
        return None;
    }
    let codes: Vec<u8> = all.iter().flat_map(|field| field.codes()).copied().collect();
    let direction = |fields: &[Field], bit: u8| if fields.is_empty() { 0 } else { bit };
    let count = u8::try_from(codes.len()).ok().filter(|count| *count <= 14)?;
    let mut octets = vec![direction(outputs, 0x80) | direction(inputs, 0x40) | count];
    for fields in [outputs, inputs].into_iter().filter(|fields| !fields.is_empty()) {
        octets.push(0x80 | u8::try_from(octets_of(fields).checked_sub(1)?).ok()?);
    }
    octets.extend(codes);
    Some(octets)
}

pub(super) fn default_configuration(file: &DeviceToml, known: &[OwnedConfiguration]) -> Result<usize, Located> {
    let Some(text) = &file.default_configuration else { return Ok(0) };
    let octets = octets(text)?;
    known.iter().position(|one| one.octets == octets).map_or_else(
        || {
            let known = known.iter().map(|one| format!("{:?}", hex(&one.octets))).collect::<Vec<_>>().join(", ");
            problem(text.span(), format!("expected one of the configurations, {known}; found {:?}", text.get_ref()))
        },
        Ok,
    )
}
