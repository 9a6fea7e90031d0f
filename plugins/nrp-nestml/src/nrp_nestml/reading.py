"""Reads a file by NESTML's own parser."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path
from typing import Any, Final

from nrp_nestml.errors import NestmlError

_REPORT: Final = re.compile(r"ERROR, \[(\d+):\d+;[\d:]+\]\]: (?:Error occurred during parsing: )?([^\n]+)")
_LONE_UNIT: Final = "NO_SOLITARY_PHYSICAL_UNITS"
"""A mistake in NESTML 9, and none in 8: a unit that is a factor by itself, as in ``1000 * ms/s``."""
_CAST: Final = re.compile(r'Implicit casting from \(compatible\) type "(.+)" to "real"')


def read(path: Path) -> Any:
    """Return the model in a file, as NESTML's syntax tree.

    Raises:
        NestmlError: the file is not a model, or NESTML's own checks of names, units and blocks fail.
    """
    from pynestml.cocos.co_cos_manager import CoCosManager
    from pynestml.frontend.pynestml_frontend import init_predefined
    from pynestml.utils.logger import Logger, LoggingLevel
    from pynestml.utils.model_parser import ModelParser

    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        Logger.init_logger(LoggingLevel.ERROR)
        init_predefined()
        try:
            unit = ModelParser.parse_file(str(path))
            models = unit.get_model_list() if unit is not None else []
            for model in models:
                CoCosManager.check_cocos(model)
        except Exception as error:  # NESTML's own, after a mistake that it has reported
            raise NestmlError(_reported(said.getvalue()) or f"NESTML cannot read it: {error}") from error
    if not models:
        raise NestmlError(_reported(said.getvalue()) or "NESTML cannot read it: it has no model")
    if len(models) > 1:
        raise NestmlError(f"it has {len(models)} models; there must be one in a file")
    for *_, code, place, message in Logger.get_messages(models[0], LoggingLevel.ERROR):
        if code.name == _LONE_UNIT:
            continue
        line = f"line {place.start_line}: " if place is not None else ""
        raise NestmlError(f"{line}{' '.join(str(message).split())}")
    _require_units(models[0], Logger.get_messages(models[0], LoggingLevel.WARNING))
    return models[0]


def _reported(said: str) -> str:
    """Return the first mistake that NESTML's parser has reported, with its line, or an empty text."""
    found = _REPORT.search(said)
    if found is None:
        return ""
    message = " ".join(found[2].split())
    return f"line {found[1]}: NESTML cannot read it: {message}" if int(found[1]) else message


def _require_units(model: Any, warnings: list[Any]) -> None:
    """Refuse an equation that adds a number without a unit to a term in the unit of the equation.

    NESTML only warns when it drops a unit, as it does in models that are fitted to measurements. If the unit
    that it drops is that of the equation, the other term lacks it: a parameter is in another unit.
    """
    from astropy.units import Unit

    units = {
        variable.get_name(): str(declaration.get_data_type())
        for block in model.get_state_blocks()
        for declaration in block.get_declarations()
        for variable in declaration.get_variables()
    }
    needed = {
        one.get_source_position().start_line: (name, units[name])
        for block in model.get_equations_blocks()
        for one in block.get_ode_equations()
        if (name := one.get_lhs().get_name()) in units
    }
    for *_, place, message in warnings:
        found = _CAST.match(str(message))
        if place is None or found is None or place.start_line not in needed:
            continue
        name, unit = needed[place.start_line]
        if unit != "real" and Unit(found[1]).is_equivalent(Unit(unit) / Unit("s")):
            raise NestmlError(
                f"line {place.start_line}: the equation of '{name}' adds a number without a unit to one in "
                f"{found[1]}: is a parameter in another unit?"
            )
