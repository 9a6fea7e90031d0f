"""The value types of models."""

from __future__ import annotations

import ast
import keyword
import re
import textwrap
from collections.abc import Iterator
from dataclasses import replace
from math import isfinite

from nrp_bibi.model.metamodel import Value

_TRUTH = {"true": True, "1": True, "false": False, "0": False}
_NUMBER = r"[\-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][\-+]?[0-9]+)?"
_POINT = rf"{_NUMBER}(\s+{_NUMBER}){{1,2}}"
_NAME = r"[A-Za-z_][A-Za-z0-9_]*"


def number_text(value: float) -> str:
    """Return the shortest text that is read as the same number; integers stay integers."""
    return repr(value).replace("e+", "e")


def _number(text: str) -> float:
    if not re.fullmatch(_NUMBER, text.strip()):
        raise ValueError
    value = float(text)
    if not isfinite(value):
        raise ValueError
    return int(text) if re.fullmatch(r"\s*[\-+]?[0-9]+\s*", text) else value


def _point(text: str) -> tuple[float, ...]:
    if not re.fullmatch(_POINT, text.strip()):
        raise ValueError
    return tuple(map(_number, text.split()))


def _point_text(value: tuple[float, ...]) -> str:
    return " ".join(map(number_text, value))


def _natural(text: str) -> int:
    if not re.fullmatch(r"\s*\+?[0-9]+\s*", text):
        raise ValueError
    return int(text)


def _positive(text: str) -> int:
    value = _natural(text)
    if value < 1:
        raise ValueError
    return value


def _rate(text: str) -> float:
    value = _number(text)
    if value <= 0:
        raise ValueError
    return value


def _truth(text: str) -> bool:
    if text.strip().lower() not in _TRUTH:
        raise ValueError
    return _TRUTH[text.strip().lower()]


def _of_pattern(name: str, pattern: str, expects: str) -> Value:
    def parse(text: str) -> str:
        if not re.fullmatch(pattern, text.strip()):
            raise ValueError
        return text.strip()

    return Value(name, parse, str, expects, (("base", "xs:token"), ("pattern", pattern)))


def _dotted(name: str, expects: str) -> Value:
    """Return the value type of dotted Python names, which cannot contain keywords."""
    plain = _of_pattern(name, rf"{_NAME}(\.{_NAME})*", expects)

    def parse(text: str) -> str:
        if any(map(keyword.iskeyword, text.strip().split("."))):
            raise ValueError
        return str(plain.parse(text))

    return replace(plain, parse=parse)


def _template(text: str) -> str:
    """Return a template expression in canonical form: ``2*i+1`` is ``2 * i + 1``."""
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError) as error:
        raise ValueError from error
    if not all(map(_is_template, ast.walk(tree))):
        raise ValueError
    return ast.unparse(tree)


def _is_template(part: ast.AST) -> bool:
    match part:
        case ast.Name(id=name):
            return name == "i"
        case ast.Constant(value=value):
            return type(value) is int
        case _:
            allowed = (ast.Expression, ast.BinOp, ast.Add, ast.Sub, ast.Mult, ast.Load)
            return isinstance(part, allowed)


def dedented(text: str) -> str:
    """Return code without its common indentation; its first line and comments may be indented differently.

    The first variant that is valid Python is used; other code keeps its relative indentation.
    """
    variants = list(dedented_variants(text))
    return next((code for code in variants if _is_python(code)), variants[0])


def dedented_variants(text: str) -> Iterator[str]:
    """Yield code without its common indentation, of all lines, of all but the first, and of those with code.

    Comments that are less deep than the code become the least deep.
    """
    lines = text.split("\n")
    while lines and not lines[0].strip():
        lines.pop(0)
    yield textwrap.dedent("\n".join(lines)).strip("\n")
    yield "\n".join([line.lstrip() for line in lines[:1]] + [textwrap.dedent("\n".join(lines[1:]))]).strip(
        "\n"
    )
    code = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    depth = min((len(line) - len(line.lstrip()) for line in code), default=0)
    yield "\n".join(line.lstrip() if line[:depth].strip() else line[depth:] for line in lines).strip("\n")


def _is_python(code: str) -> bool:
    try:
        compile(code, "", "exec", ast.PyCF_ONLY_AST, dont_inherit=True)
    except (SyntaxError, ValueError):
        return False
    return True


TEXT = Value("Text", str, str, "a text", (("base", "xs:string"),))
CODE = Value("Code", dedented, str, "Python code", (("base", "xs:string"),))
WORD = Value("Word", str.strip, str, "a text", (("base", "xs:token"),))
FILE = _of_pattern("File", r"[^<>|\n]+", "a file name")
NUMBER = Value(
    "Number", _number, number_text, "a finite number", (("base", "xs:double"), ("pattern", _NUMBER))
)
RATE = Value(
    "Rate",
    _rate,
    number_text,
    "a positive number",
    (("base", "xs:double"), ("pattern", _NUMBER), ("minExclusive", "0")),
)
POINT = Value("Point", _point, _point_text, "2 or 3 numbers", (("base", "xs:token"), ("pattern", _POINT)))
NATURAL = Value("Natural", _natural, str, "a whole number, 0 or more", (("base", "xs:nonNegativeInteger"),))
POSITIVE = Value("Positive", _positive, str, "a whole number, 1 or more", (("base", "xs:positiveInteger"),))
TRUTH = Value("Truth", _truth, lambda value: str(value).lower(), "true or false", (("base", "xs:boolean"),))
NAME = _of_pattern("Name", _NAME, "a name of letters, digits and _ that does not begin with a digit")
DOTTED = _dotted("Dotted", "a name such as geometry_msgs.msg.Twist")
PATH = _dotted("Path", "an attribute name")
TOPIC = _of_pattern("Topic", r"(/[A-Za-z0-9_\-]+)+/?", "a topic name such as /husky/cmd_vel")
TEMPLATE = Value(
    "Template",
    _template,
    str,
    "an expression of i, whole numbers, +, -, * and parentheses",
    (("base", "xs:token"), ("pattern", r"[0-9i+\-*\(\) ]+")),
)
