"""Layers of the sources: no file imports, directly or by way of others, a file that imports it."""

import ast
import re
from collections.abc import Collection, Iterable, Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PYTHON, RUST = ROOT / "python" / "footnav", ROOT / "rust" / "src"

Graph = dict[str, set[str]]
"""Imported files of each file, by module."""


@cache
def python_graph() -> Graph:
    """Return the imports of the package, also those in functions and for type checkers alone."""
    files = [*PYTHON.rglob("*.py"), *PYTHON.rglob("*.pyi")]
    trees = {python_module(file): ast.parse(file.read_text("utf-8")) for file in sorted(files)}
    names = {module: imported_names(tree) for module, tree in trees.items()}
    return {module: known_files(module, names[module], ".", trees) for module in trees}


def python_module(file: Path) -> str:
    parts = file.relative_to(PYTHON.parent).with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


def imported_names(tree: ast.AST) -> Iterator[str]:
    """Full names of the imports; the package has no relative ones outside of its stub."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            module = f"footnav.{node.module}" if node.level else node.module
            yield from (f"{module}.{alias.name}" for alias in node.names)


@cache
def rust_graph() -> Graph:
    """Return the paths of the crate in each file, without its unit tests."""
    files = {rust_module(file): file for file in sorted(RUST.rglob("*.rs"))}
    paths = {module: rust_paths(module, rust_code(file)) for module, file in files.items()}
    return {module: known_files(module, paths[module], "::", files) for module in files}


def rust_module(file: Path) -> str:
    parts = file.relative_to(RUST).with_suffix("").parts
    return "::".join(("crate", *(part for part in parts if part != "lib")))


def rust_code(file: Path) -> str:
    """Text of a file without comments and without the unit tests at its end."""
    text = re.sub(r"//.*", "", file.read_text("utf-8"))
    return re.split(r"#\[cfg\(test\)\]\s*mod \w+ \{", text)[0]


def rust_paths(module: str, code: str) -> Iterator[str]:
    """Full paths that start at the crate, at the module above, or at a child of the module."""
    children = re.findall(r"\bmod (\w+);", code)
    starts = {"crate": "crate", "super": module.rpartition("::")[0]}
    starts |= {child: f"{module}::{child}" for child in children}
    for start, full in starts.items():
        for match in re.finditer(rf"(?<![\w:]){start}::", code):
            yield from (f"{full}::{path}" for path in expanded(code[match.end() :]))


def expanded(text: str) -> Iterator[str]:
    """Paths at the start of a text: `a::{b, c::D}` stands for `a::b` and `a::c::D`."""
    head = re.match(r"[\w:]*", text)
    assert head is not None
    if text[head.end() : head.end() + 1] != "{":
        yield head[0]
        return
    depth, item = 0, head.end() + 1
    for place in range(head.end(), len(text)):
        depth += {"{": 1, "}": -1}.get(text[place], 0)
        if depth == 0 or (depth == 1 and text[place] == ","):
            yield from (head[0] + path for path in expanded(text[item:place].strip()))
            item = place + 1
        if depth == 0:
            return


def known_files(
    module: str, names: Iterable[str], separator: str, known: Collection[str]
) -> set[str]:
    """Files other than the module's own in which names lie: the longest parts that are modules."""
    files = set()
    for name in names:
        while name and name not in known:
            name = name.rpartition(separator)[0]
        files.add(name)
    return files - {"", module}


def circles(graph: Graph) -> list[list[str]]:
    """Circles of imports, in the direction of import.

    Each is cut before the search for the next.
    """
    graph = {module: set(imports) for module, imports in graph.items()}
    found = []
    while True:
        try:
            TopologicalSorter(graph).prepare()
        except CycleError as error:
            circle = error.args[1][::-1]
            found.append(circle)
            graph[circle[0]].discard(circle[1])
        else:
            return found


@pytest.mark.parametrize("graph", [python_graph, rust_graph], ids=["Python", "Rust"])
def test_no_circle_of_imports(graph):
    assert len(graph()) > 50
    found = [" -> ".join(circle) for circle in circles(graph())]
    assert not found, "\n".join(["circles of imports:", *found])


@pytest.mark.parametrize("graph", [python_graph, rust_graph], ids=["Python", "Rust"])
def test_no_file_imports_the_facade(graph):
    (facade,) = {"footnav", "crate"} & graph().keys()
    assert [module for module, imports in graph().items() if facade in imports] == []


def test_circles_are_found():
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) in (
        [["a", "b", "c", "a"]],
        [["b", "c", "a", "b"]],
        [["c", "a", "b", "c"]],
    )


def test_paths_of_rust_are_expanded():
    code = "mod child; use crate::a::{b::C, d::{E, F}}; use super::g; child::h(crate::i::J);"
    assert sorted(rust_paths("crate::k::l", code)) == [
        "crate::a::b::C",
        "crate::a::d::E",
        "crate::a::d::F",
        "crate::i::J",
        "crate::k::g",
        "crate::k::l::child::h",
    ]
