#!/usr/bin/env python3
"""Writes the examples of the Python package as programs into a folder, so that mypy checks them: those of the README, of the pages in
docs, of the notebooks and of the docstrings.

    ci/python_examples.py FOLDER
"""

from __future__ import annotations

import doctest
import importlib
import json
import pkgutil
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import profivac

ROOT = Path(__file__).resolve().parent.parent


def of_pages() -> Iterator[tuple[str, str]]:
    """The Python blocks that use the package."""
    for page in [ROOT / "python/README.md", ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        blocks = re.findall(r"^```python\n(.*?)^```$", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
        for place, block in enumerate(block for block in blocks if "import profivac" in block or "from profivac" in block):
            yield f"page_{page.parent.name}_{page.stem}_{place}", block


def of_notebooks() -> Iterator[tuple[str, str]]:
    """The code of each notebook. A notebook shows the value of an expression, which is a statement here."""
    for file in sorted((ROOT / "python/notebooks").glob("*.ipynb")):
        cells = json.loads(file.read_text(encoding="utf-8"))["cells"]
        yield f"notebook_{file.stem}", "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")


def of_docstrings() -> Iterator[tuple[str, str]]:
    """The examples of each docstring. They may use the names of their module, as the test runner lets them."""
    modules = [module.name for module in pkgutil.iter_modules(profivac.__path__, "profivac.")]
    for name in ["profivac", *(name for name in modules if name != "profivac._profivac")]:
        loaded = importlib.import_module(name)
        for test in doctest.DocTestFinder(exclude_empty=True).find(loaded):
            if test.examples:
                code = "".join(example.source for example in test.examples)
                yield f"docstring_{test.name.replace('.', '_')}", f"from {name} import *\n{code}"


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.py"):
        old.unlink()
    count = 0
    for examples in (of_pages(), of_notebooks(), of_docstrings()):
        for name, code in examples:
            (folder / f"example_{name}.py").write_text(code, encoding="utf-8")
            count += 1
    print(f"{count} examples")


if __name__ == "__main__":
    main()
