"""Allow floats and texts of digits as indices of arrays, which NumPy accepted until version 1.11."""

from __future__ import annotations

import ast

from nrp_legacy.outdated import INDEX, call


class Indices(ast.NodeTransformer):
    """Wraps each index that may be one of them; decorators, which name populations, stay unchanged."""

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.body = [self.visit(statement) for statement in node.body]
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        self.generic_visit(node)
        node.slice = _wrapped(node.slice)
        return node


def _wrapped(index: ast.expr) -> ast.expr:
    match index:
        case ast.Tuple(elements):
            index.elts = [_wrapped(element) for element in elements]
        case ast.Slice(lower, upper, step):
            index.lower, index.upper, index.step = (one and _wrapped(one) for one in (lower, upper, step))
        case ast.Constant(value) | ast.UnaryOp(operand=ast.Constant(value)) if not isinstance(value, float):
            pass
        case ast.JoinedStr() | ast.Starred():
            pass
        case _:
            return call(INDEX, index, index)
    return index
