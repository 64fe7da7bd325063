# SPDX-License-Identifier: Apache-2.0
"""Functions of other packages, named by parameters: so this package need know none of them."""

import importlib
from collections.abc import Callable
from typing import Any


def provider_of(option: str, name: str) -> Callable[..., Any]:
    """Return the function that `name`, a ``module:function``, names.

    Raises
    ------
    ValueError: in one line with the name of the `option`, if there is none.
    """
    module_name, _, function_name = name.partition(':')
    try:
        found: Callable[..., Any] = getattr(importlib.import_module(module_name), function_name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ValueError(f'{option} = {name!r} must be a module:function: {error}') from error
    return found
