"""Files that functions write themselves, or that two recorders share."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from nrp_core.checks.imported import full_names
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.checks.used import local_names, used_functions
from nrp_core.dsl.functions.mappings import MapCSVRecorder
from nrp_core.findings import Code, Finding, Level

_OPENERS = frozenset({"open", "io.open", "codecs.open", "gzip.open", "bz2.open", "lzma.open"})
_SAVERS = frozenset(
    {"numpy.save", "numpy.savez", "numpy.savez_compressed", "numpy.savetxt", "scipy.io.savemat", "torch.save",
     "cv2.imwrite", "joblib.dump"}
)  # fmt: skip
_METHODS = frozenset({"write_text", "write_bytes", "tofile", "savefig"})
"""Methods that only write files."""
_TABLES = frozenset({"to_csv", "to_excel", "to_hdf", "to_pickle", "to_parquet", "to_feather"})
"""Methods of tables that write a file if they get a first argument."""
_IN_MEMORY = frozenset({"BytesIO", "StringIO"})
_WRITING = frozenset("wax+")


@checks_function(Code.NRP303)
def files_are_left_to_recorders(function: CheckedFunction) -> Iterator[Finding]:
    """Look for calls that write a file."""
    imported = full_names(function.declared.source.tree)
    for used in used_functions(function.declared):
        own = local_names(used)
        if any(getattr(one, "attr", getattr(one, "id", "")) in _IN_MEMORY for one in ast.walk(used)):
            continue
        for node in ast.walk(used):
            if isinstance(node, ast.Call) and _writes(node, own, imported):
                name = excerpt(node)
                message = (
                    f"'{name}' writes a file, which reset, replay and confined runs do not handle: "
                    "record values with the CSV recorder (nrp.MapCSVRecorder)"
                )
                yield function.declared.finding(Code.NRP303, node, message, Level.WARNING)


@checks_experiment(Code.NRP254)
def recorders_of_one_file_have_the_same_columns(static: StaticExperiment) -> Iterator[Finding]:
    """Look for two recorders with different headers whose rows go into one file."""
    first: dict[object, tuple[str, list[str]]] = {}
    for function in static.functions:
        for name, mapping in function.function.mappings.items():
            if not isinstance(mapping, MapCSVRecorder):
                continue
            headers = list(mapping.headers)
            owner, others = first.setdefault(mapping.filename, (function.function.name, headers))
            if headers != others:
                message = (
                    f"the rows of '{name}' have the columns {', '.join(headers)}, and go below those of "
                    f"'{owner}' in '{mapping.filename}', which are {', '.join(others)}"
                )
                node = function.declared.nodes.get(name)
                yield function.declared.finding(Code.NRP254, node, message, Level.WARNING)


def _writes(call: ast.Call, own: set[str], imported: dict[str, str]) -> bool:
    """Return whether a call certainly writes a file."""
    root, dot, rest = ast.unparse(call.func).partition(".")
    called = "" if root in own else imported.get(root, root) + dot + rest
    if called in _OPENERS:
        return _is_for_writing(call, 1)
    if called in _SAVERS:
        return True
    if not isinstance(call.func, ast.Attribute):
        return False
    method = call.func.attr
    if method == "open" and not called.startswith(("os.", "webbrowser.")):
        return _is_for_writing(call, 0)
    return method in _METHODS or (method in _TABLES and bool(call.args))


def _is_for_writing(call: ast.Call, index: int) -> bool:
    """Return whether the mode of an opened file, the argument at ``index``, allows to write."""
    given = [keyword.value for keyword in call.keywords if keyword.arg == "mode"] or call.args[index:][:1]
    mode = given[0].value if given and isinstance(given[0], ast.Constant) else None
    return isinstance(mode, str) and len(mode) < 5 and bool(_WRITING & set(mode))
