"""Expressions in xacro files compute what Python computes, and can do nothing else."""

import builtins
import os
import resource
from collections.abc import Callable
from html import escape
from pathlib import Path

import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import SceneError
from nrp_core.scene.urdf.expand import _evaluator, expand_xacro
from nrp_core.scene.urdf.expressions import Budget

xacro = pytest.importorskip("xacro")
yaml = pytest.importorskip("yaml")
PYTHON = {name: getattr(builtins, name) for name in xacro._global_symbols["python"]}
ROBOT = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">{}</robot>'

Expand = Callable[[str], str]


@pytest.fixture
def expand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Expand:
    """Return a function that expands the body of a robot, and returns the name of its last link."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("NRP_SIDE", "left")

    def expanded(body: str) -> str:
        path = tmp_path / "robot.xacro"
        path.write_text(ROBOT.format(body))
        robot = expand_xacro(path, Path)
        return robot.all("link")[-1].attribute("name")

    return expanded


def link(expression: str) -> str:
    return f'<link name="{escape(expression)}"/>'


def value(expression: str) -> object:
    """Return the value of an expression with all functions of xacro and ``n = 3``."""
    evaluator = _evaluator(xacro, Budget(), {})
    return evaluator.evaluate(expression, {**xacro._global_symbols, **PYTHON, "n": 3})


@pytest.mark.parametrize(
    "expression",
    [
        "2 + 3 * n - 1 / 4 // 1 % 7", "-n ** 2", "n << 2 | 1 & 3 ^ 2", "not n or 5", "1 < n <= 3 != 4",
        "'a' if n > 2 else 'b'", "[x * x for x in range(n) if x]", "{k: v for k, v in zip('ab', (1, 2))}",
        "sum([i * j for i in range(n) for j in range(i)])", "sorted({3, 1, 2})", "max(1, n, key=abs)",
        "'{:.3f} {:>5} {}'.format(1.5, 'x', n)", "f'{n:03d} {1.25:.1f} {n!r}'", "'%.2f_%s' % (1.0, n)",
        "'a,b'.split(',')[-1].upper()", "','.join(map(str, range(n)))", "[1, 2, 3][::-1]", "(1, *[2, 3])",
        "dict(a=1, b=2)['b']", "{'a': 1}.get('c', 4)", "len(str(2.50)) + int('7') + float('1e3')",
        "round(2.345, 2)", "abs(-2) + min([3, n])", "list(enumerate('ab'))", "list(filter(None, [0, 1]))",
        "1 in (1, 2) and 'x' not in 'abc'", "(2 + 1j).imag", "isinstance(n, int)", "type(n) == int",
        "all([1, n]) and any([0, n])", "divmod(7, n)", "'abc'[1:]", "list(reversed([1, 2]))",
    ],
)  # fmt: skip
def test_an_expression_has_the_value_that_python_gives_it(expression: str) -> None:
    assert value(expression) == eval(expression, {"n": 3})


@given(st.recursive(
    st.integers(-9, 9).map(str) | st.sampled_from(["n", "1.5"]),
    lambda inner: st.tuples(inner, st.sampled_from("+-*"), inner).map(lambda parts: f"({' '.join(parts)})"),
))  # fmt: skip
def test_arithmetic_is_that_of_python(expression: str) -> None:
    assert value(expression) == eval(expression, {"n": 3})


VALUES = """<xacro:property name="c" value="${xacro.load_yaml('c.yaml')}"/>"""


@pytest.mark.parametrize(
    ("body", "name"),
    [
        (link("${math.sin(0) + pi}"), "3.141592653589793"),
        (link("${radians(180)} ${xacro.tokenize('a;b')}"), "3.141592653589793 ['a', 'b']"),
        ('<xacro:arg name="a" default="4"/>' + link("$(eval a + 1)"), "5"),
        ('<xacro:arg name="a" default="4"/>' + link("$(eval 'x' if a > 3 else 'y')"), "x"),
        ('<xacro:arg name="a" default="4"/>' + link("${xacro.arg('a')}"), "4"),
        (link("$(env NRP_SIDE)_$(optenv NRP_NOWHERE x)"), "left_x"),
        (VALUES + link("${c.arm.l}"), "2.5"),
        (VALUES.replace("xacro.l", "l") + link("${c['arm']['x'] * 2}"), "0.5"),
        (VALUES + link("${c.arm.names[1]} ${list(c.base.items())}"), "b [('l', 2.5)]"),
        ("<xacro:property name='d' value='${xacro.dotify(dict(a=1))}'/>" + link("${d.a}"), "1"),
    ],
)  # fmt: skip
def test_the_functions_of_xacro_are_there(expand: Expand, tmp_path: Path, body: str, name: str) -> None:
    (tmp_path / "c.yaml").write_text(
        "base: &b {l: 2.5}\narm:\n  <<: *b\n  x: !millimeters 250\n  names: [a, b]\n"
    )
    assert expand(body) == name


FINDER = "[c for c in ().__class__.__base__.__subclasses__() if c.__name__=='Popen'][0](['touch','MARK'])"
ESCAPES = [
    f"(lambda: {FINDER})()", FINDER, f"[{FINDER} for x in [1]]", "'{0.__class__.__init__}'.format(1)",
    "[g.gi_frame.f_back.f_globals for g in [(i for i in [1])]]", "(lambda f: f)(1)", "math.__loader__",
    "__import__('os').system('touch MARK')", "(lambda: __import__('os'))()", "python.open('MARK', 'w')",
    "open('MARK', 'w')", "python.vars(math)", "python.type('X', (), {})", "xacro.load_yaml('evil.yaml')",
    "getattr((), '_'+'_class_'+'_')", "str.__subclasses__()", "[].__class__", "''.format.__self__",
    "(x for x in [1]).gi_frame", "math.sin.__self__", "xacro.warning.__globals__", "type(str)('X', (), {})",
    "[x := 1]", "(yield)", "xacro.tokenize.__code__", "python.root", "math.parent", "xacro.update(dict(a=1))",
    "{**math}['sin'].__self__", "[a.b for a.b in [1]]", "[0 for d['x'] in [1]]", "b'a'", "'%s' % (lambda: 1)",
    "f'{().__class__}'", "list(map(python.vars, [math]))", "python.sorted([1], key=python.vars)",
    "max([math, math], key=python.vars)", "__builtins__", "(1).__class__.__mro__", "'{0[a]}'.format(math)",
    "open('MARK', 'w')", "exec('import os')", "globals()", "eval('1')", "compile('1', 'a', 'eval')",
    "dict.fromkeys", "xacro.load_yaml.__globals__['os']",
]  # fmt: skip


@pytest.mark.parametrize("expression", ESCAPES)
def test_no_expression_executes_code(expand: Expand, tmp_path: Path, expression: str) -> None:
    (tmp_path / "evil.yaml").write_text('!!python/object/apply:os.system ["touch MARK"]')
    with pytest.raises((SceneError, NameError, AttributeError, SyntaxError, yaml.YAMLError)):
        value(expression)
    for text in (f"${{{expression}}}", f"$(eval {expression})"):
        with pytest.raises(SceneError):
            expand(f'<xacro:property name="p" value="{escape(text)}"/>{link("x${p}")}')
    assert {path.name for path in tmp_path.iterdir()} == {"evil.yaml", "robot.xacro"}


BOMBS = [
    "len('a'*3000000000)", "len([0]*400000000)", "sum(range(10**9))", "(1<<10**9).bit_length()", "9**9**9",
    "len([0 for i in range(10**5) for j in range(10**5)])", "list(range(10**8))", "'%100000000d' % 1",
    "'%*d' % (10**9, 1)", "'{:>999999999}'.format(1)", "'{:{}}'.format(1, 10**9)", "f'{1:>{10**9}}'",
    "('a'*10**5).replace('a', 'b'*10**5)", "('a'*10**5).join(['b']*10**5)", "'1'.zfill(10**10)",
    "math.factorial(10**7)", "math.comb(10**6, 5*10**5)", "math.prod(range(1, 10**5))", "round(5, -10**9)",
    "xacro.tokenize('a'*40 + '!', '](a+)+$[')", "str([['a'*10**5]*10**3]*10**3)", "sum([[1]*10]*10**5, [])",
    "'%s'*10**4 % tuple(['a'*20]*10**4) * 10**4", "[a.append(a) for a in [[1]] for i in range(10**6)]",
    "str([b.extend([0]*10**4) or b for b in [[]] for i in range(10**3)])",
    "('{0}'*10**5).format('a'*1000)", "xacro.load_yaml('/dev/zero')", "xacro.load_yaml('laughs.yaml')",
    "[[[[0]*99]*99]*99]*99", "math.lcm(*range(1, 10**5))", "xacro.load_yaml('merge.yaml')",
]  # fmt: skip
BODIES = [
    "".join(
        f'<xacro:macro name="m{i}"><xacro:m{i + 1}/><xacro:m{i + 1}/></xacro:macro>' for i in range(40)
    ) + '<xacro:macro name="m40"><link name="l"/></xacro:macro><xacro:m0/>',
    '<xacro:macro name="m"><xacro:if value="false">' + "<a/>" * 5000 + "</xacro:if></xacro:macro>"
    + "<xacro:m/>" * 5000,
    '<xacro:property name="p" value="${\'a\'*200000}"/>' + link("${p}") * 1000,
    link("${" + " + ".join(["len([0]*100000)"] * 1000) + "}"),
    '<xacro:include filename="/*/*/*/*/*.xacro"/>',
]  # fmt: skip


def least_memory_and_time(work: Callable[[], object]) -> None:
    """Check that some work is refused before it takes 1 GB or 30 s."""
    before, peak_kb = os.times().user, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises((SceneError, TypeError)):
        work()
    assert os.times().user - before < 20.0
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak_kb < 800_000


@pytest.mark.one_of(8)
@pytest.mark.parametrize("expression", BOMBS)
def test_no_expression_takes_gigabytes_or_minutes(
    expression: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(xacro, "filestack", ["robot.xacro"])
    levels = [f"b{i}: &b{i}\n  <<: [{', '.join([f'*b{i - 1}'] * 9)}]" for i in range(1, 12)]
    (tmp_path / "merge.yaml").write_text("\n".join(["b0: &b0 {k: 1}", *levels]))
    (tmp_path / "laughs.yaml").write_text(
        "\n".join(
            ["b0: &b0 [x, x]", *(f"b{i}: &b{i} [{', '.join([f'*b{i - 1}'] * 9)}]" for i in range(1, 12))]
        )
    )
    least_memory_and_time(lambda: value(expression))


@pytest.mark.one_of(6)
@pytest.mark.parametrize("body", BODIES)
def test_no_file_takes_gigabytes_or_minutes(expand: Expand, body: str) -> None:
    least_memory_and_time(lambda: expand(body))


@pytest.mark.one_of(3)
@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("${(lambda: 1)()}", "lambda"),
        ("${[].__class__}", "__class__"),
        ("${sum(range(10**9))}", "300000"),
        ("${'%999999d' % 1}", "width"),
        ("${max([max([j * i for j in range(10**4)]) for i in range(10**4)])}", "steps"),
    ],
)
def test_a_refusal_names_the_refused_thing(expand: Expand, golden: Golden, text: str, match: str) -> None:
    with golden.raises(SceneError, match=match):
        expand(link(text))
