"""The rows of Python code: its transfer functions, as far as they are known without executing it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence

from nrp_bibi.diagram.rows import Device, Row, Topic, wrapped
from nrp_bibi.generation.part import CodePart
from nrp_bibi.model.functions import PythonTransferFunction
from nrp_core.dsl import Listing, MapSpikeSink, MapSpikeSource, MonitoringFunction, PythonSource
from nrp_core.dsl.declared import Declared, declared_functions
from nrp_core.errors import TransferFunctionError
from nrp_core.messages.base import type_name

_CODE_LINES = 12
_POPULATION = re.compile(r"""\bbrain\.(?:group\[['"](.+?)['"]\]|(\w+))""")


def rows_of_python(found: Sequence[tuple[PythonTransferFunction, CodePart]]) -> Iterator[Row]:
    """Yield the rows of pieces of Python; for a piece that is not valid Python, only its text.

    Args:
        found: the pieces and their code, in the order of the model: they share their names.
    """
    sources = [_source(part) for _, part in found]
    declared = declared_functions(Listing(tuple(source for source in sources if source is not None)))
    for (function, _), source in zip(found, sources, strict=True):
        own = [one for one in declared if one.source is source]
        yield Row(
            f"Python: {function.src}" if function.src else "Python",
            [line for one in own for line in _signature(one)] if function.src else _cut(function.code),
            [device for one in own for device in _devices(one)],
            [topic for one in own for topic in _topics(one)],
        )


def _source(part: CodePart) -> PythonSource | None:
    try:
        return part.source()
    except TransferFunctionError:
        return None


def _signature(declared: Declared) -> list[str]:
    text = f"{declared.function.name}({', '.join(('t', *declared.function.parameters))})"
    return wrapped(text)


def _cut(code: str) -> list[str]:
    lines = code.split("\n") if code else []
    return lines if len(lines) <= _CODE_LINES else [*lines[: _CODE_LINES - 1], "..."]


def _devices(declared: Declared) -> Iterator[Device]:
    function = declared.function
    mapped = {name: function.mappings[name] for name in function.parameters if name in function.mappings}
    if isinstance(function, MonitoringFunction):
        mapped[function.name] = function.sink
    for name, mapping in mapped.items():
        if isinstance(mapping, (MapSpikeSink, MapSpikeSource)):
            written = _neurons(mapping, declared.decorators.get(name))
            names = dict.fromkeys(group or name for group, name in _POPULATION.findall(written))
            population = ", ".join(names)
            shown = written.replace("nrp.", "").replace("brain.", "")
            yield Device(name, str(mapping.kind), shown, population, mapping.drives)


def _neurons(mapping: MapSpikeSink | MapSpikeSource, decorator: ast.expr | None) -> str:
    """Return the neurons of a mapping: the source text, if it names a population."""
    if isinstance(decorator, ast.Call):
        named = [keyword.value for keyword in decorator.keywords if keyword.arg == "value"]
        for node in (*decorator.args[1:2], *named):
            if _POPULATION.search(text := ast.unparse(node)):
                return text
    return repr(mapping.selector)


def _topics(declared: Declared) -> Iterator[Topic]:
    function = declared.function
    for topics, is_written in ((function.subscribed, False), (function.published, True)):
        for topic in topics:
            kind = "" if topic.topic_type is None else type_name(topic.topic_type).replace("/msg/", "/")
            yield Topic(topic.name, kind, is_written)
