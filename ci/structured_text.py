#!/usr/bin/env python3
"""Reads the function blocks of every device, in both dialects, with the parsers of structured text that are on PyPI.

    target/venv/bin/python ci/structured_text.py target/debug/profivac

The devices are those of the program, those of docs/devices/files, and one whose name is no identifier. tree-sitter reads every file. blark
takes seconds for a block, so it reads a block only if it has a line that no block before has, apart from numbers and comments. No parser
knows the heads of the dialect for TIA Portal: these are compared with the rule and replaced, and the rest is the text that the parsers have
read.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import blark.parse
import tree_sitter
import tree_sitter_iec61131_3_st

FILES = Path(__file__).parent.parent / "docs" / "devices" / "files"

# Two hyphens, and letters beyond the longest name of a block.
AWKWARD = """format = 1
name = "an-awkward--name-of-a-device-450"
title = "Awkward"
like = "bcg450"
ident = 0xFFFF
"""

TREE_SITTER = tree_sitter.Parser(tree_sitter.Language(tree_sitter_iec61131_3_st.language()))


def printed(program, *arguments):
    return subprocess.run([program, *arguments], check=True, capture_output=True, text=True).stdout


# The program refuses to make blocks for these devices.
WITHOUT_PRESSURE = {"tic253"}


def faults(node):
    """The places that tree-sitter skips or adds."""
    if node.type == "ERROR" or node.is_missing:
        yield node
    elif node.has_error:
        for child in node.children:
            yield from faults(child)


def tree_sitter_reads(name, text):
    root = TREE_SITTER.parse(text.encode()).root_node
    if root.has_error:
        line = next(faults(root), root).start_point[0]
        sys.exit(f"{name}:{line + 1}: tree-sitter does not read: {text.splitlines()[line].strip()}")


def blark_reads(name, block):
    with tempfile.NamedTemporaryFile("w", suffix=".st") as file:
        file.write(block)
        file.flush()
        for result in blark.parse.parse(file.name):
            if result.exception is not None:
                sys.exit(f"{name}: blark does not read:\n{result.exception}")


def lines(block):
    """The lines of the block with one name, one number and no comment."""
    block = re.sub(r"\(\*.*?\*\)", "", re.sub(r"PV_\w+", "PV", block), flags=re.S)
    return set(re.sub(r"[\d.]+(E[+-]\d+)?", "1", block).splitlines())


def without_heads(name, text):
    """The text for TIA Portal in the standard dialect: `FUNCTION_BLOCK "NAME"`, `VERSION : 0.1` and `BEGIN` are its heads."""
    head = re.compile(r'^FUNCTION_BLOCK "(\w+)"\nVERSION : 0\.1$', re.M)
    blocks = text.count("FUNCTION_BLOCK \"")
    text, heads = head.subn(r"FUNCTION_BLOCK \1", text)
    text, begins = re.subn(r"^BEGIN$", "", text, flags=re.M)
    if not blocks == heads == begins > 0:
        sys.exit(f"{name}: {blocks} blocks have {heads} heads and {begins} times BEGIN")
    return text


def main():
    (program,) = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        printed(program, "gsd", "--out", folder)
        devices = sorted(path.stem.lower() for path in Path(folder).glob("*.GSD"))
        awkward = Path(folder) / "awkward.toml"
        awkward.write_text(AWKWARD)
        files = [path for path in sorted(FILES.glob("*.toml")) if path.stem not in WITHOUT_PRESSURE]
        devices += [str(path) for path in [*files, awkward]]
        read, read_by_blark, known = 0, 0, set()
        for device in devices:
            name = Path(device).stem
            text = printed(program, "st", device)
            tree_sitter_reads(name, text)
            if without_heads(name, printed(program, "st", device, "--dialect", "tia")) != text:
                sys.exit(f"{name}: the dialects differ in more than their heads")
            for block in re.findall(r"^FUNCTION_BLOCK .*?^END_FUNCTION_BLOCK$", text, re.M | re.S):
                read += 1
                if not lines(block) <= known:
                    known |= lines(block)
                    blark_reads(name, block)
                    read_by_blark += 1
    print(f"{len(devices)} devices, {read} blocks in both dialects; tree-sitter has read all, blark {read_by_blark} that differ")


if __name__ == "__main__":
    main()
