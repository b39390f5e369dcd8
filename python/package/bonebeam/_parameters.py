"""Checks keywords, which are the keys of the command's configuration."""

from __future__ import annotations

import difflib
import inspect
import json
import math
import re
import textwrap
from collections.abc import Callable, Iterable, Mapping
from os import PathLike, fspath
from typing import Any, TypeVar

from . import _native

Function = TypeVar("Function", bound=Callable[..., Any])
# The keys of each section of the configuration.
TABLES = json.loads(_native.tables())["sections"]


def documented(section: str, *known: type) -> Callable[[Function], Function]:
    """Adds the keywords of the classes to a function's documentation, from the command's help."""
    wanted = {"phantom"}.union(*map(names, known))

    def add(function: Function) -> Function:
        own = inspect.cleandoc(function.__doc__ or "")
        keys = (key for key in TABLES[section] if key["name"].rpartition(".")[2] in wanted)
        function.__doc__ = "\n".join([own, "", "Keywords:", *map(described, keys), ""])
        return function

    return add


def described(key: Mapping[str, Any]) -> str:
    """A keyword with its help and its choices, in words of Python."""
    help = re.sub(r"--([a-z-]+)", lambda flag: f"``{flag[1].replace('-', '_')}``", key["help"])
    help = re.sub(r"(?<!`)`(?!`)", "``", help)
    choices = ", ".join(f"``{name}`` ({text[0].lower()}{text[1:]})" for name, text in key["choices"])
    text = f"{key['name'].rpartition('.')[2]}: {help}" + (f" One of {choices}." if choices else "")
    return textwrap.fill(text, 118, initial_indent="    ", subsequent_indent="        ", break_on_hyphens=False)


def section(function: str, known: type, parameters: Mapping[str, Any]) -> _native.BeamformParameters:
    """Checks the given keywords as the section of the beamformer."""
    return _native.BeamformParameters(checked(function, names(known), parameters))


def checked(function: str, known: Iterable[str], parameters: Mapping[str, Any]) -> str:
    """The given keywords as JSON; a keyword that is not known is refused."""
    for key in parameters:
        refuse_unknown(function, key, known)
    return as_json(parameters)


def refuse_unknown(function: str, key: str, known: Iterable[str]) -> None:
    """Refuses a keyword that is not known, with the nearest that is."""
    known = set(known)
    if key not in known:
        near = difflib.get_close_matches(key, known, 1)
        hint = f"; did you mean `{near[0]}`?" if near else ""
        raise TypeError(f"{function}() got an unexpected keyword argument '{key}'{hint}")


def as_json(parameters: Mapping[str, Any]) -> str:
    """The given keywords as JSON, for the host."""
    return json.dumps({key: _plain(key, value) for key, value in parameters.items() if value is not None})


def _plain(key: str, value: Any) -> Any:
    # A number of NumPy is one of Python.
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, Mapping):
        return {inner: _plain(inner, of) for inner, of in value.items() if of is not None}
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"`{key}` is {value}; expected a finite number")
    value = fspath(value) if isinstance(value, PathLike) else value
    if not isinstance(value, (int, float, str, list, tuple)):
        raise TypeError(f"`{key}` is {type(value).__name__}; expected a number, a name or a list of them")
    return value


def names(known: type) -> set[str]:
    """The keywords of a class of keywords."""
    return set(known.__annotations__)
