#!/usr/bin/env python3
"""Reads the function blocks of every device, in both dialects, with three parsers of structured text.

    target/venv/bin/python ci/structured_text.py target/debug/profivac target/iec61131/debug/names-of-blocks

The devices are those of the program, those of docs/devices/files, and one whose name is no identifier. tree-sitter and iec61131
(ci/iec61131) read every file. blark needs two seconds for a block of 200 lines, so it reads every block in pieces and each piece once: the
declarations with the head, each statement, each name. The pieces are the whole text. The blocks of one device it reads as a whole too. No
parser knows the heads of the dialect for TIA Portal: these are compared with the rule and replaced, and the rest is the text that the
parsers have read.
"""

import re
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
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
    return subprocess.run([program, *arguments], check=True, stdout=subprocess.PIPE, text=True).stdout


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


def iec61131_reads(reader, texts, folder):
    """A file that ends too early for the parser has fewer blocks there, not an error."""
    paths = []
    for name, text in texts.items():
        paths.append(folder / f"{name}.st")
        paths[-1].write_text(text)
    read = printed(reader, *paths).splitlines()
    for (name, text), names in zip(texts.items(), read, strict=True):
        if names.split() != re.findall(r"^FUNCTION_BLOCK (\w+)$", text, re.M):
            sys.exit(f"{name}: iec61131 has read the blocks {names}")


def blocks(text):
    return re.findall(r"^FUNCTION_BLOCK .*?^END_FUNCTION_BLOCK\n", text, re.M | re.S)


def pieces(block):
    """The name of the block, its head with the declarations, and its statements."""
    first, rest = block.split("\n", 1)
    declarations, body = rest.rsplit("END_VAR\n", 1)
    # A statement begins in the first column, but for the branches and the end of one that is open.
    statements = re.split(r"^(?=[A-Z])(?!ELSE$|ELSIF |END_)", body, flags=re.M)
    statements[-1] = statements[-1].removesuffix("END_FUNCTION_BLOCK\n")
    if f"{first}\n{declarations}END_VAR\n{''.join(statements)}END_FUNCTION_BLOCK\n" != block:
        sys.exit(f"{first}: the pieces are not the block")
    return first.removeprefix("FUNCTION_BLOCK "), declarations, [one for one in statements if one.strip()]


def sources(texts, whole):
    """What blark reads, each once: its rule, and a text that this rule reads."""
    found = {("function_block_type_declaration", block) for block in blocks(texts[whole])}
    for text in texts.values():
        for block in blocks(text):
            name, declarations, statements = pieces(block)
            found.add(("function_block_type_declaration", f"FUNCTION_BLOCK {name}\nVAR\nA : INT;\nEND_VAR\nA := 1;\nEND_FUNCTION_BLOCK\n"))
            found.add(("function_block_type_declaration", f"FUNCTION_BLOCK A\n{declarations}END_VAR\nA := 1;\nEND_FUNCTION_BLOCK\n"))
            found |= {("statement_list", statement) for statement in statements}
    # The longest first, so that no process is left with one of them.
    return sorted(found, key=lambda one: -len(one[1]))


def blark_fault(source):
    rule, text = source
    error = blark.parse.parse_source_code(text, starting_rule=rule).exception
    return error and f"blark does not read:\n{text}\n{error}"


def blark_reads(texts, whole):
    todo = sources(texts, whole)
    with ProcessPoolExecutor() as processes:
        for fault in processes.map(blark_fault, todo):
            if fault:
                sys.exit(fault)
    return len(todo)


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
    program, reader = sys.argv[1:]
    texts = {}
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        printed(program, "gsd", "--out", folder)
        devices = sorted(path.stem.lower() for path in folder.glob("*.GSD"))
        awkward = folder / "awkward.toml"
        awkward.write_text(AWKWARD)
        files = [path for path in sorted(FILES.glob("*.toml")) if path.stem not in WITHOUT_PRESSURE]
        for device in [*devices, *files, awkward]:
            name = Path(device).stem
            texts[name] = printed(program, "st", device)
            tree_sitter_reads(name, texts[name])
            if without_heads(name, printed(program, "st", device, "--dialect", "tia")) != texts[name]:
                sys.exit(f"{name}: the dialects differ in more than their heads")
        iec61131_reads(reader, texts, folder)
    read = blark_reads(texts, "bcg450")
    count = sum(len(blocks(text)) for text in texts.values())
    print(f"{len(texts)} devices, {count} blocks in both dialects; tree-sitter and iec61131 have read all files, blark all text in {read} pieces")


if __name__ == "__main__":
    main()
