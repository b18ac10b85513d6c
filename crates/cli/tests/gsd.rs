//! Three independent parsers accept the GSD file of every device and read the values of the tables.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common::{Folder, run};
use gsd_parser::GenericStationDescription;
use profivac_devices::catalog::MODELS;
use profivac_devices::model::Model;
use std::path::Path;
use std::process::Command;

fn printed(device: &str) -> String {
    let output = run(&["gsd", device]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The modules of the one manual that has modules. IF300P/IF301P manual 3.2.1.2, errata-bpg-bcg-tpg 122.
const MODULES: [&[u8]; 5] = [&[0x97], &[0xA7], &[0xA0], &[0x94], &[0x93]];

/// The reference numbers of all modules: with GSD_Revision 3, one after the other.
fn numbers(model: &Model) -> impl Iterator<Item = Option<u32>> {
    let modular = if model.name.starts_with("tpg") { MODULES.len() } else { 0 };
    let (is_numbered, count) = (model.features.dpv1, model.configurations.len() + modular);
    (1..).take(count).map(move |number| is_numbered.then_some(number))
}

/// Compares what an engineering tool would send, one module and its user parameters, with the tables.
fn agrees(file: &GenericStationDescription, model: &Model) {
    assert_eq!((file.ident_number, file.model.as_str()), (model.ident, model.title));
    let modules: Vec<_> = file.available_modules.iter().map(|module| module.config.as_slice()).collect();
    let configurations: Vec<_> = model.configurations.iter().map(|configuration| configuration.octets).collect();
    let (whole, single) = modules.split_at(configurations.len());
    assert_eq!(whole, configurations, "{}", model.name);
    let manual: (u8, &[&[u8]]) = if model.name.starts_with("tpg") { (7, &MODULES) } else { (1, &[]) };
    assert_eq!((file.max_modules, single), manual, "{}", model.name);
    let references = file.available_modules.iter().map(|module| module.reference);
    assert!(references.eq(numbers(model)), "{}", model.name);
    assert!(file.available_modules.iter().all(|module| module.info_text.is_some() == model.features.dpv1));
    let user = gsd_parser::PrmBuilder::new(&file.user_prm_data).into_bytes();
    assert!(model.user_prm(&user).is_some(), "{}: {user:02X?}", model.name);
    for unit in file.user_prm_data.data_ref.iter().flat_map(|(_, definition)| &definition.text_ref) {
        for name in unit.keys() {
            let user =
                gsd_parser::PrmBuilder::new(&file.user_prm_data).set_prm_from_text("Unit", name).as_bytes().to_vec();
            assert_eq!(model.user_prm(&user).unwrap().name, name, "{}", model.name);
        }
    }
}

/// profibus-wire 7.1, 7.2
#[test]
fn gsd_parser_reads_the_values_of_the_tables() {
    for model in MODELS {
        let file = gsd_parser::parser::parse(Path::new(model.name), &printed(model.name))
            .unwrap_or_else(|error| panic!("{}: {error}", model.name));
        agrees(&file, model);
    }
}

/// pyprofibus in its debug mode, in which it reports every line that it does not know.
const PYTHON: &str = "
import sys
from pyprofibus.gsd.interp import GsdInterp
for path in sys.argv[1:]:
    gsd = GsdInterp.fromFile(path, debug=True)
    names = [module.name for module in gsd.getField('Module')]
    configurations = []
    for name in names:
        gsd.clearConfiguredModules()
        gsd.setConfiguredModule(name)
        configurations.append(b''.join(bytes(part.getDU()) for part in gsd.getCfgDataElements()).hex())
    print('read', '%04x' % gsd.getIdentNumber(), bytes(gsd.getUserPrmData()).hex(), ','.join(configurations))
";

/// What a script prints about the files of all devices, whose paths are its arguments.
fn python(script: &str) -> String {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/venv/bin/python");
    assert!(python.exists(), "there is no {}: ./test makes it", python.display());
    let folder = Folder::new();
    let paths = MODELS.iter().map(|model| {
        let path = folder.path(model.name);
        std::fs::write(&path, printed(model.name)).unwrap();
        path
    });
    let output = Command::new(python).args(["-c", script]).args(paths).output().unwrap();
    let message = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{message}{}", String::from_utf8_lossy(&output.stderr));
    message
}

/// Keywords of DP-V1, which pyprofibus does not have, FMS, and texts and the types of user parameters, which it ignores. It ignores the lines
/// with the numbers of modules too.
const NEW: [&str; 7] =
    ["FMS_supp", "C1_", "C2_", "Max_Initiate_PDU_Length", "WD_Base_1ms_supp", "Unsigned16", "Info_Text"];

/// profibus-wire 7.3
#[test]
fn pyprofibus_reads_the_values_of_the_tables() {
    let message = python(PYTHON);
    let warned =
        message.lines().zip(message.lines().skip(1)).filter(|(line, _)| line.starts_with("GSD parser warning"));
    for (_, line) in warned {
        let is_known = NEW.iter().any(|keyword| line.starts_with(keyword)) || line.parse::<u16>().is_ok();
        assert!(is_known, "pyprofibus does not know: {line}");
    }
    let read = message.lines().filter_map(|line| line.strip_prefix("read "));
    let hex = |octets: &[u8]| octets.iter().map(|octet| format!("{octet:02x}")).collect::<String>();
    assert_eq!(read.clone().count(), MODELS.len(), "{message}");
    for (line, model) in read.zip(MODELS) {
        let modular: &[&[u8]] = if model.name.starts_with("tpg") { &MODULES } else { &[] };
        let whole = model.configurations.iter().map(|one| one.octets);
        let configurations: Vec<_> = whole.chain(modular.iter().copied()).map(hex).collect();
        let fields: Vec<_> = line.split(' ').collect();
        let [ident, user, read] = fields[..] else { panic!("{line}") };
        assert_eq!((ident, read), (format!("{:04x}", model.ident).as_str(), configurations.join(",").as_str()));
        assert!(model.user_prm.iter().any(|prm| hex(prm.octets).get(2..) == user.get(2..)), "{line}");
    }
}

/// The reader of industriagents-profibus-mcp, without the server of the package, which needs much else.
const INDUSTRIAGENTS: &str = "
import importlib.util, json, pathlib, sys
path = pathlib.Path(sys.prefix).parent / 'tools/gsd_reader/profibus_mcp/gsd_parser.py'
spec = importlib.util.spec_from_file_location('gsd_parser', path)
reader = sys.modules['gsd_parser'] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(reader)
for path in sys.argv[1:]:
    file = reader.GSDParser().load(path)
    names = 'config_hex', 'input_length', 'output_length', 'reference'
    modules = [[module[name] for name in names] for module in file['modules']]
    metadata = file['metadata']
    print(json.dumps([metadata['ident_number'], metadata['model_name'], len(file['baud_rates']), modules, file['warnings']]))
";

/// profibus-wire 7.2
#[test]
fn industriagents_reads_the_values_of_the_tables() {
    let message = python(INDUSTRIAGENTS);
    let hex = |octets: &[u8]| octets.iter().map(|octet| format!("{octet:02x}")).collect::<String>();
    assert_eq!(message.lines().count(), MODELS.len(), "{message}");
    for (line, model) in message.lines().zip(MODELS) {
        let read: serde_json::Value = serde_json::from_str(line).unwrap();
        let whole = model.configurations.iter().map(|one| (hex(one.octets), one.input_octets(), one.output_octets()));
        // IF300P/IF301P manual 3.2.1.2
        let single = [("97", 8, 0), ("a7", 0, 8), ("a0", 0, 1), ("94", 5, 0), ("93", 4, 0)];
        let single = single.into_iter().filter(|_| model.name.starts_with("tpg"));
        let all = whole.chain(single.map(|(octets, inputs, outputs)| (octets.to_owned(), inputs, outputs)));
        let modules: Vec<_> = all
            .zip(numbers(model))
            .map(|((octets, inputs, outputs), number)| serde_json::json!([octets, inputs, outputs, number]))
            .collect();
        let expected = serde_json::json!([format!("0x{:04X}", model.ident), model.title, 10, modules, []]);
        assert_eq!(read, expected);
    }
}

#[test]
fn the_error_for_an_unknown_device_lists_the_known_ones() {
    let failed = run(&["gsd", "bcg451"]);
    assert_eq!(failed.status.code(), Some(2));
    let message = String::from_utf8(failed.stderr).unwrap();
    assert!(message.starts_with("profivac: unknown device \"bcg451\"; known: pcg550, "), "{message}");
}

#[test]
fn check_reads_a_folder_with_its_folders() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("top/inner")).unwrap();
    let file = "#Profibus_DP\nIdent_Number = 0x1234\nModule = \"m\" 0x10\nEndModule\n";
    std::fs::write(folder.path("top/inner/A.GSD"), file).unwrap();
    let output = run(&["gsd", "check", &folder.name("top")]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("A.GSD: ") && text.contains("1 module, 0 faults"), "{text}");
}

/// A folder can have thousands of files.
#[test]
fn of_many_files_check_lists_the_first_hundred_of_each_kind_and_counts_the_others() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("many")).unwrap();
    let write = |name: String, lines: &str| {
        let text = format!("#Profibus_DP\nIdent_Number = 0x1234\n{lines}Module = \"m\" 0x10\nEndModule\n");
        std::fs::write(folder.path("many").join(name), text).unwrap();
    };
    (0..103).for_each(|number| write(format!("a{number}.gsd"), ""));
    write("z.gsd".to_owned(), "Max_Module = none\n");
    let checked = |options: &[&str]| {
        let output = run(&[&["gsd", "check", &folder.name("many")], options].concat());
        assert_eq!(output.status.code(), Some(2));
        let text = String::from_utf8(output.stdout).unwrap();
        let listed = text.lines().filter(|line| line.contains(".gsd: ")).count();
        assert!(text.contains("z.gsd: ASCII, 1 module, 1 fault"), "a fault is listed behind many right files: {text}");
        (listed, text.lines().last().unwrap_or_default().to_owned())
    };
    let (listed, last) = checked(&[]);
    assert_eq!(listed, 101);
    assert_eq!(last, "not listed: 0 files with faults or not readable, 3 files without faults; --all lists them");
    let (listed, last) = checked(&["--all"]);
    assert_eq!(listed, 104);
    assert!(last.starts_with("  fault, line 3: "), "{last}");
}
