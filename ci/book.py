#!/usr/bin/env python3
"""Builds the book of docs/ below target/book/html, and follows every link between its pages.

ci/book.py [--program FILE] [--mdbook FILE]

Needs mdBook. Without --mdbook it is installed below target/tools, which compiles it for a minute; ./test long runs this, ./test does not.
Without --program it is built with `cargo build`. The pages are those of docs/SUMMARY.md and these, made anew in each run: the commands
from the help of the program, the keys of the files from the types that read them, the HTTP API from crates/station/web/openapi.json, the
metrics and the names of the gateways from the program with an example, the tables of an archive from crates/archive/sql.

Exit code 1: a link leads to no page or to no heading.
"""

import argparse
import html.parser
import json
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.parse
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BOOK = ROOT / "target/book"
PAGES = BOOK / "src"
TOOLS = ROOT / "target/tools"
MDBOOK = "0.5.4"
# Links and pictures of a page that are in this repository.
LINK = re.compile(r"\]\((?!https?:|mailto:|#)([^)#\s]+)")
# The station whose names the book shows.
EXAMPLE = """\
[station]
name = "Hall"

[[segment]]
name = "hall"
port = "/dev/ttyUSB0"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.gauge]]
name = "tpg"
address = 6
device = "tpg300"

[[alarm]]
name = "too high"
gauge = "chamber"
above = "1e-3 mbar"

[epics]
[modbus]
[mqtt]
broker = "mqtt://127.0.0.1"
[mqtt.sparkplug]
group = "Hall"
[prometheus]
"""
GATEWAYS = {"epics": "EPICS", "modbus": "Modbus TCP", "mqtt": "MQTT and Sparkplug"}
METHODS = ("get", "put", "post", "patch", "delete")


def run(*command):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, text=True, cwd=ROOT)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with {done.returncode}")
    return done.stdout


def installed():
    program = TOOLS / "bin/mdbook"
    if not program.is_file() or run(program, "--version").strip() != f"mdbook v{MDBOOK}":
        print(f"mdBook {MDBOOK} is compiled, once", flush=True)
        run("cargo", "install", "--quiet", "--locked", "--no-default-features", "--features", "search", "--root", TOOLS, f"mdbook@{MDBOOK}")
    return program


def built():
    run("cargo", "build", "--quiet", "--workspace", "--bin", "profivac")
    return ROOT / "target/debug/profivac"


def commands(program):
    """The help of each command."""
    text = run(program, "--help")
    names = re.findall(r"^  ([a-z-]+) ", text.split("Commands:")[1].split("\n\n")[0], re.M)
    pages = ["# Commands\n\nThe help of the program and of its commands.\n", f"```text\n{text}```\n"]
    for name in names:
        if name != "help":
            pages.append(f"## {name}\n\n```text\n{run(program, name, '--help')}```\n")
    return "\n".join(pages)


def cell(text):
    return " ".join(str(text or "").split()).replace("|", "\\|")


def kind(schema):
    """A type of the API in words."""
    if "$ref" in schema:
        name = schema["$ref"].rsplit("/", 1)[1]
        return f"[{name}](#{name.lower()})"
    for choice in ("oneOf", "anyOf", "allOf"):
        if choice in schema:
            return " or ".join(kind(one) for one in schema[choice])
    if "enum" in schema:
        return ", ".join(f"`{value}`" for value in schema["enum"])
    if "const" in schema:
        return f"`{schema['const']}`"
    types = schema.get("type", "any")
    types = types if isinstance(types, list) else [types]
    return " or ".join(f"list of {kind(schema.get('items', {}))}" if one == "array" else one for one in types)


def api(document):
    """The paths and the types of the HTTP API."""
    lines = [f"# HTTP API\n\n{document['info'].get('description', '')}\n"]
    for path, methods in document["paths"].items():
        for method, operation in ((one, methods[one]) for one in METHODS if one in methods):
            lines.append(f"## {method.upper()} {path}\n\n{operation.get('summary', '')}. {operation.get('description', '')}\n")
            parameters = operation.get("parameters", [])
            if parameters:
                lines.append("| Parameter | In | Type | Meaning |\n|---|---|---|---|")
                for one in parameters:
                    lines.append(f"| `{one['name']}` | {one['in']} | {kind(one.get('schema', {}))} | {cell(one.get('description'))} |")
                lines.append("")
            for media in operation.get("requestBody", {}).get("content", {}).values():
                lines.append(f"Body: {kind(media.get('schema', {}))}.\n")
            lines.append("| Status | Content | Meaning |\n|---|---|---|")
            for status, answer in operation["responses"].items():
                content = ", ".join(kind(media.get("schema", {})) for media in answer.get("content", {}).values())
                lines.append(f"| {status} | {content} | {cell(answer.get('description'))} |")
            lines.append("")
    for name, schema in document["components"]["schemas"].items():
        lines.append(f"## {name}\n\n{schema.get('description', '')}\n")
        properties = schema.get("properties")
        if not properties:
            lines.append(f"{kind(schema)}\n")
            continue
        lines.append("| Key | Type | Needed | Meaning |\n|---|---|---|---|")
        for key, value in properties.items():
            needed = "yes" if key in schema.get("required", []) else "no"
            lines.append(f"| `{key}` | {kind(value)} | {needed} | {cell(value.get('description'))} |")
        lines.append("")
    return "\n".join(lines)


def tables():
    """The tables of an archive, as PostgreSQL gets them."""
    parts = [path.read_text() for path in sorted((ROOT / "crates/archive/sql").glob("*.sql"))]
    return "# Tables of an archive\n\n" + "\n".join(f"```sql\n{part}```\n" for part in parts)


def table(rows, columns):
    """Rows of `profivac names`: titles of the columns, by key."""
    code = ("name", "topic", "register", "labels", "record")
    lines = [f"| {' | '.join(columns.values())} |\n|{'---|' * len(columns)}"]
    for row in rows:
        cells = [f"`{cell(row[key])}`" if key in code and row[key] else cell(row[key]) for key in columns]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def listed(program, gateway):
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "hall.toml"
        file.write_text(EXAMPLE)
        return json.loads(run(program, "names", file, "--for", gateway, "--json"))


def metrics(program):
    """Each metric once, with the labels of its first series."""
    rows = {row["name"]: row for row in reversed(listed(program, "prometheus"))}
    columns = {"name": "Metric", "kind": "Type", "unit": "Unit", "labels": "Labels, for example", "values": "Values", "description": "Meaning"}
    head = "# Metrics\n\nWhat `/metrics` of the [gateway for Prometheus](../gateways.md) has for a station with a gauge, a controller and an alarm.\n\n"
    return head + table(reversed(rows.values()), columns)


def names(program):
    """What the other gateways publish."""
    parts = [f"# Names of the gateways\n\nWhat [gateways](../gateways.md) publish for this file; `profivac names FILE.toml --for GATEWAY` lists it for any other:\n\n```toml\n{EXAMPLE}```\n"]
    titles = {"name": "Name", "topic": "Topic", "register": "Register", "record": "Record", "type": "Type", "subject": "Of", "unit": "Unit", "values": "Values", "description": "Meaning"}
    for gateway, title in GATEWAYS.items():
        rows = listed(program, gateway)
        columns = {key: titles[key] for key in rows[0] if key in titles}
        parts.append(f"## {title}\n\n{table(rows, columns)}")
    return "\n".join(parts)


def copy(page, copied):
    """Copies a page and, without end, the files of the repository that it links."""
    if page in copied:
        return
    copied.add(page)
    source = ROOT / page
    if source.is_dir():
        return
    (PAGES / page).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(source, PAGES / page)
    if source.suffix == ".md":
        for target in LINK.findall(source.read_text()):
            linked = (source.parent / target).resolve()
            if linked.suffix != ".md" and linked.is_relative_to(ROOT) and linked.is_file():
                copy(linked.relative_to(ROOT), copied)


def assemble(program):
    shutil.rmtree(BOOK, ignore_errors=True)
    PAGES.mkdir(parents=True)
    summary = (ROOT / "docs/SUMMARY.md").read_text()
    summary = re.sub(r"\]\(([^)]+)\)", lambda link: "](" + str((ROOT / "docs" / link[1]).resolve().relative_to(ROOT)) + ")", summary)
    generated = {
        "commands": ("Commands", commands(program)),
        "keys": ("Keys of the files", run("cargo", "xtask", "configuration")),
        "api": ("HTTP API", api(json.loads((ROOT / "crates/station/web/openapi.json").read_text()))),
        "metrics": ("Metrics", metrics(program)),
        "names": ("Names of the gateways", names(program)),
        "tables": ("Tables of an archive", tables()),
    }
    lines = "".join(f"- [{title}](docs/generated/{name}.md)\n" for name, (title, _) in generated.items())
    head, reference = summary.split("# Reference\n\n")
    (PAGES / "SUMMARY.md").write_text(f"{head}# Reference\n\n{lines}{reference}")
    copied = set()
    for page in LINK.findall(summary):
        copy(Path(page), copied)
    (PAGES / "docs/generated").mkdir()
    for name, (_, text) in generated.items():
        (PAGES / f"docs/generated/{name}.md").write_text(text)
    shutil.copy(ROOT / "docs/book.toml", BOOK / "book.toml")
    return len(LINK.findall(summary)) + len(generated)


class Page(html.parser.HTMLParser):
    """The links and the anchors of a page."""

    def __init__(self, path):
        super().__init__()
        self.links, self.anchors = [], set()
        self.feed(path.read_text())

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value)
            elif (name == "href" and tag == "a") or (name == "src" and tag == "img"):
                self.links.append(value or "")


def broken(folder):
    """The links that lead nowhere, the number of all, and the number of those to folders of the repository, which the book does not have."""
    pages = {path: Page(path) for path in folder.rglob("*.html") if path.name not in ("print.html", "404.html", "toc.html")}
    found, count, folders = [], 0, 0
    for path, page in pages.items():
        for link in page.links:
            address = urllib.parse.urlsplit(link)
            if address.scheme or address.netloc:
                continue
            count += 1
            target = path if not address.path else (path.parent / urllib.parse.unquote(address.path)).resolve()
            here = f"{path.relative_to(folder)}: {link}"
            relative = target.relative_to(folder) if target.is_relative_to(folder) else None
            if target.name == "print.html":
                continue
            if not target.exists():
                if relative and (ROOT / relative).is_dir():
                    folders += 1
                else:
                    found.append(f"{here} leads to no page")
            elif address.fragment and target in pages and urllib.parse.unquote(address.fragment) not in pages[target].anchors:
                found.append(f"{here} leads to no heading")
    return found, count, folders


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path)
    parser.add_argument("--mdbook", type=Path)
    arguments = parser.parse_args()
    count = assemble((arguments.program or built()).resolve())
    run((arguments.mdbook or installed()).resolve(), "build", BOOK)
    found, links, folders = broken(BOOK / "html")
    for one in found:
        print(one)
    print(f"{count} pages, {links} links, {len(found)} of them broken, {folders} to folders that only the repository has: {BOOK / 'html/index.html'}")
    if not list((BOOK / "html").glob("searchindex*.js")):
        sys.exit("the book has no search")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
