"""The size budget of the house: files of at most 400 lines, functions of at most 50 code lines."""

import ast
import sys
from pathlib import Path

MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 50


def code_lines(function: ast.FunctionDef | ast.AsyncFunctionDef, source: list[str]) -> int:
    """Count the lines of a function that are neither its docstring, blank nor comment."""
    first, last = function.lineno, function.end_lineno or function.lineno
    counted = set(range(first, last + 1))
    if ast.get_docstring(function) is not None:
        docstring = function.body[0]
        counted -= set(range(docstring.lineno, (docstring.end_lineno or docstring.lineno) + 1))
    return sum(1 for n in counted if (text := source[n - 1].strip()) and not text.startswith("#"))


def offences(path: Path) -> list[str]:
    """Name what in one file is over the budget."""
    source = path.read_text(encoding="utf-8").splitlines()
    found = [f"{path}: {len(source)} lines, at most {MAX_FILE_LINES}"] if len(source) > MAX_FILE_LINES else []
    for node in ast.walk(ast.parse("\n".join(source))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            length = code_lines(node, source)
            if length > MAX_FUNCTION_LINES:
                found.append(f"{path}:{node.lineno}: {node.name} has {length} code lines, at most {MAX_FUNCTION_LINES}")
    return found


def main() -> int:
    """Print every offence; the exit status says whether there was one."""
    found = [
        line
        for root in ("src", "tests", "tools", "benchmarks")
        for path in sorted(Path(root).rglob("*.py"))
        for line in offences(path)
    ]
    print("\n".join(found) if found else "size budget: kept")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
