"""Optional packages, imported when they are needed."""

import importlib
from typing import Any

from pigbench.errors import UserError


def required(*modules: str, extra: str) -> tuple[Any, ...]:
    """The modules. Raises UserError, naming the extra to install, if one is not installed."""
    try:
        return tuple(importlib.import_module(module) for module in modules)
    except ImportError as error:
        missing = (error.name or modules[0]).partition(".")[0]
        raise UserError(
            f"this needs the package {missing}: pip install 'pigbench[{extra}]'"
        ) from None
