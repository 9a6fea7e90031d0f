"""Reads a file by NESTML's own parser."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

from nrp_nestml.errors import NestmlError


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
        unit = ModelParser.parse_file(str(path))
        models = unit.get_model_list() if unit is not None else []
        for model in models:
            CoCosManager.check_cocos(model)
    if not models:
        raise NestmlError(f"NESTML cannot read it: {' '.join(said.getvalue().split()) or 'it has no model'}")
    if len(models) > 1:
        raise NestmlError(f"it has {len(models)} models; there must be one in a file")
    for *_, place, message in Logger.get_messages(models[0], LoggingLevel.ERROR):
        line = f"line {place.start_line}: " if place is not None else ""
        raise NestmlError(f"{line}{' '.join(str(message).split())}")
    return models[0]
