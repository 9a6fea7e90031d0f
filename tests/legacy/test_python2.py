"""Leftovers of Python 2 become Python 3 and mean what they meant."""

from __future__ import annotations

import ast
import io
from contextlib import redirect_stderr, redirect_stdout

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_legacy.python2 import converted, divide, names


def printed(code: str, **values: object) -> str:
    out = io.StringIO()
    with redirect_stdout(out):
        exec(compile(converted(code).tree, "code", "exec"), {**names(), **values})
    return out.getvalue()


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ('print "a"', "a\n"),
        ('print "a", 1', "a 1\n"),
        ("print", "\n"),
        ('print "%d %s" % (1, "b")', "1 b\n"),
        ('print ("a"), "b"', "a b\n"),
        ('print ("a" + "b") * 2', "abab\n"),
        ('if 1: print "a"; print "b"', "a\nb\n"),
        ('print "a",\nprint "b"', "a b\n"),
        ("print [i for i in (1, 2)][0]", "1\n"),
        ('print "a \\\nb"', "a b\n"),
        ('print {"a": 1}["a"] # print this', "1\n"),
        ('x = 1\nif x <> 2: print "ne"', "ne\n"),
        ("print 0777, 10L", "511 10\n"),
        ('try:\n  raise ValueError, "no"\nexcept (KeyError, ValueError), e:\n  print e', "no\n"),
        ("d = {1: 2}\nprint sorted(d.iteritems()), d.has_key(1)", "[(1, 2)] True\n"),
        ("print 7 / 2, 7.0 / 2, 7 // 2", "3 3.5 3\n"),
        ("from __future__ import division\nprint 7 / 2", "3.5\n"),
        ("print list(xrange(2)), unicode(1), long(2), reduce(max, [1, 3])", "[0, 1] 1 2 3\n"),
        ("if 1:\n\tx = 1\n        print x", "1\n"),
    ],
)
def test_a_leftover_means_what_it_meant(code: str, text: str) -> None:
    assert printed(code) == text


def test_print_to_a_stream_goes_there() -> None:
    error = io.StringIO()
    with redirect_stderr(error):
        printed('import sys\nprint >>sys.stderr, "a", 1')
    assert error.getvalue() == "a 1\n"


def test_code_of_python_3_stays_as_it_is() -> None:
    code = 'print("a", 1 / 2)\nx = {"print": 3}\n'
    result = converted(code)
    assert ast.unparse(result.tree) == ast.unparse(ast.parse(code))
    assert result.changes == ()


def test_lines_keep_their_numbers() -> None:
    tree = converted('x = 1\n\nprint "a"\nprint x').tree
    assert [statement.lineno for statement in tree.body] == [1, 3, 4]


def test_what_is_no_python_at_all_is_refused() -> None:
    with pytest.raises(SyntaxError):
        converted("def f(:\n  pass")


@given(st.integers(-100, 100), st.integers(-100, 100).filter(bool))
def test_integers_divide_downwards_and_anything_else_truly(left: int, right: int) -> None:
    assert divide(left, right) == left // right
    assert divide(float(left), right) == left / right
