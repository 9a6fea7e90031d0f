"""The functions that a model defines, as texts that replace their calls."""

from __future__ import annotations

from typing import Any

from nrp_nestml.bodies import small
from nrp_nestml.errors import NestmlError, at
from nrp_nestml.expressions import Writer, plain, substituted


def read_functions(functions: list[Any], writer: Writer) -> None:
    """Register functions with a writer, called ones before their callers.

    Raises:
        NestmlError: a function calls itself, or has more than local values and a result.
    """
    while functions:
        names = {function.get_name() for function in functions}
        later = [function for function in functions if _called(function) & names]
        if len(later) == len(functions):
            raise NestmlError(f"{at(later[0])}: function '{later[0].get_name()}' calls itself")
        for function in functions:
            if function not in later:
                writer.functions[function.get_name()] = _function(function, writer)
        functions = later


def _called(function: Any) -> set[str]:
    """Return the names of the functions that a function calls."""
    found: set[str] = set()
    for one in small(function.get_stmts_body()):
        holder = one.get_declaration() if one.is_declaration() else one.get_return_stmt()
        if holder is not None and holder.get_expression() is not None:
            found |= {call.get_name() for call in holder.get_expression().get_function_calls()}
    return found


def _function(function: Any, writer: Writer) -> tuple[list[str], str]:
    """Return the arguments of a function, and its result with local values written out."""
    parameters = [plain(one.get_name()) for one in function.get_parameters()]
    before, local = set(writer.names), dict[str, str]()
    writer.names |= set(parameters)
    for one in small(function.get_stmts_body()):
        if one.is_declaration():
            declaration = one.get_declaration()
            text = substituted(writer.text(declaration.get_expression()), local)
            local.update({plain(each.get_complete_name()): text for each in declaration.get_variables()})
            writer.names |= local.keys()
        elif one.is_return_stmt():
            result = substituted(writer.text(one.get_return_stmt().get_expression()), local)
            writer.names.intersection_update(before)
            return parameters, result
        else:
            raise NestmlError(f"{at(one)}: a function only declares values and returns one")
    raise NestmlError(f"{at(function)}: function '{function.get_name()}' returns nothing")
