"""Who may import whom: held by reading the imports of every module."""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
STDLIB = sys.stdlib_module_names

ALLOWED = {
    "mapping": ("echogrid.mapping", "echogrid.drivers.readings", "numpy"),
    "drivers": ("echogrid.drivers", "can", "cantools", "pymodbus", "serial", "smbus2"),
    "emulation": (
        "echogrid.emulation",
        "echogrid.drivers.bus",
        "echogrid.drivers.clock",
        "echogrid.drivers.errors",
        "numpy",
    ),
}
"""Beside the standard library."""
IMPURE = {"asyncio", "io", "logging", "multiprocessing", "os", "pathlib", "queue", "random", "select"}
IMPURE |= {"selectors", "shutil", "signal", "socket", "subprocess", "tempfile", "threading", "time"}
"""What mathematics has no use for."""
DOTTED = re.compile(r"echogrid(\.\w+)+:\w+")
PACKAGES = ("drivers", "mapping", "runtime", "emulation")


def modules(package: str) -> list[Path]:
    """The files of a package."""
    return sorted((ROOT / package).rglob("*.py"))


def imports(path: Path) -> Iterator[str]:
    """Dotted names of all that a module imports, wherever in it, by statement or by name in a string."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: line {node.lineno}: a relative import"
            yield from (f"{node.module}.{name.name}" for name in node.names)
        elif isinstance(node, ast.Constant) and DOTTED.fullmatch(str(node.value)):
            yield node.value.replace(":", ".")


def within(name: str, package: str) -> bool:
    return f"{name}.".startswith(f"{package}.")


def in_stdlib(name: str) -> bool:
    return name.split(".")[0] in STDLIB


@pytest.mark.parametrize("package", ALLOWED)
def test_a_package_imports_only_what_it_may(package: str) -> None:
    assert modules(package)
    strangers = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in modules(package)
        for name in imports(path)
        if not in_stdlib(name) and not any(within(name, allowed) for allowed in ALLOWED[package])
    ]
    assert strangers == []


def test_mapping_is_pure() -> None:
    impure = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in modules("mapping")
        for name in imports(path)
        if name.split(".")[0] in IMPURE
    ]
    assert impure == []


def test_mapping_opens_and_prints_nothing() -> None:
    calls = [
        f"{path.relative_to(ROOT)}: line {node.lineno}: {node.func.id}()"
        for path in modules("mapping")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        if node.func.id in {"open", "print", "input", "__import__"}
    ]
    assert calls == []


def test_nobody_imports_the_runtime_but_itself_and_the_command() -> None:
    others = [path for package in PACKAGES if package != "runtime" for path in modules(package)]
    others.append(ROOT / "src/echogrid/__init__.py")
    guilty = [path for path in others for name in imports(path) if within(name, "echogrid.runtime")]
    assert guilty == []


def test_the_top_level_folders_are_never_imported_by_their_short_names() -> None:
    guilty = [
        f"{path.relative_to(ROOT)} imports {name}"
        for package in PACKAGES
        for path in modules(package)
        for name in imports(path)
        if name.split(".")[0] in PACKAGES
    ]
    assert guilty == []


def test_the_reader_of_imports_sees_every_kind(tmp_path: Path) -> None:
    module = tmp_path / "module.py"
    module.write_text(
        "import a.b, c as d\n"
        "from e.f import g as h\n"
        "def later():\n    from echogrid import runtime\n"
        "TABLE = {'x': 'echogrid.drivers.srf08:Srf08'}\n"
    )
    expected = ["a.b", "c", "e.f.g", "echogrid.drivers.srf08.Srf08", "echogrid.runtime"]
    assert sorted(imports(module)) == expected
