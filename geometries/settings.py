"""Parameters of a case's ``build``, read from its signature and docstring, and values from text.

``--set radius=2.5`` on a command line gives texts; the annotation of the parameter gives their type.
"""

from __future__ import annotations

import ast
import inspect
import re
import types
import typing
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Union

from bsm_mesh.geometries.errors import GeometryError

_TRUE = ("true", "yes", "on", "1")
_FALSE = ("false", "no", "off", "0")
_IN_WORDS = {float: "a number in SI units", int: "a whole number", bool: "true or false", str: "a text"}
_BY_KEYWORD = (inspect.Parameter.KEYWORD_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """One parameter of a case.

    Attributes
    ----------
    name : str
        Its name.
    default : object
        Its default; None where `required`.
    required : bool
        Whether it has no default.
    annotation : object
        Its type, or that of the default where the signature names none.
    summary : str
        Text of the docstring of ``build`` says of it, in one line; may be empty.
    """

    name: str
    default: object
    required: bool
    annotation: Any
    summary: str

    @property
    def kind(self) -> str:
        """The type in words, for example ``a number in SI units or none``."""
        return _type_in_words(self.annotation)

    def parse(self, text: str) -> object:
        """Return the value that `text` represents, of the parameter's type.

        Raises
        ------
        GeometryError
            Where `text` does not fit the type.
        """
        try:
            return _parse(text.strip(), self.annotation)
        except ValueError as fault:
            raise GeometryError(f"{self.name} = {text!r} does not fit; give {self.kind}") from fault


def read_parameters(build: Callable[..., object]) -> dict[str, Parameter]:
    """Return the parameters that `build` takes after the path, by name, in the order of its signature."""
    try:
        hints = typing.get_type_hints(build)
    except (AttributeError, NameError, TypeError):  # a user's annotations need not be importable
        hints = {}
    summaries = _documented_parameters(inspect.getdoc(build) or "")
    parameters = {}
    for given in list(inspect.signature(build).parameters.values())[1:]:
        if given.kind not in _BY_KEYWORD:
            continue
        required = given.default is inspect.Parameter.empty
        default = None if required else given.default
        parameters[given.name] = Parameter(
            name=given.name,
            default=default,
            required=required,
            annotation=hints.get(given.name, Any if default is None else type(default)),
            summary=summaries.get(given.name, ""),
        )
    return parameters


def accepts_any(build: Callable[..., object]) -> bool:
    """Return whether `build` takes parameters of any name."""
    return any(given.kind is given.VAR_KEYWORD for given in inspect.signature(build).parameters.values())


def parse_literal(text: str) -> object:
    """Return the number, list or other Python literal that `text` is, else `text` itself."""
    try:
        value: object = ast.literal_eval(text)
    except (SyntaxError, ValueError):
        return text
    return value


def _documented_parameters(document: str) -> dict[str, str]:
    """Return one line a parameter from a numpydoc ``Parameters`` section."""
    found = re.search(r"^Parameters\n-+\n(.*?)(?=^\S[^\n]*\n---|\Z)", document, re.MULTILINE | re.DOTALL)
    section = found[1] if found else ""
    entries = re.findall(r"^(\w+) *:[^\n]*\n((?:[ \t]+[^\n]*\n?)+)", section, re.MULTILINE)
    return {name: " ".join(lines.split()) for name, lines in entries}


def _is_union(annotation: Any) -> bool:
    return typing.get_origin(annotation) in (Union, types.UnionType)


def _type_in_words(annotation: Any) -> str:
    if annotation is type(None):
        return "none"
    if _is_union(annotation):
        return " or ".join(_type_in_words(part) for part in typing.get_args(annotation))
    if typing.get_origin(annotation) is Literal:
        return "one of " + ", ".join(str(choice) for choice in typing.get_args(annotation))
    return _IN_WORDS.get(annotation, "a Python literal, such as [1, 2]")


def _parse(text: str, annotation: Any) -> object:
    if _is_union(annotation):
        return _parse_union(text, typing.get_args(annotation))
    if typing.get_origin(annotation) is Literal:
        for choice in typing.get_args(annotation):
            if text == str(choice):
                return choice
        raise ValueError(text)
    if annotation is type(None):
        if text.lower() == "none":
            return None
        raise ValueError(text)
    if annotation is bool:
        if text.lower() not in _TRUE + _FALSE:
            raise ValueError(text)
        return text.lower() in _TRUE
    if annotation in (float, int, str):
        return annotation(text)
    return parse_literal(text)


def _parse_union(text: str, parts: tuple[Any, ...]) -> object:
    # A text fits anything, so it comes last: "none" is None, "2" a number.
    for part in sorted(parts, key=lambda part: part is str):
        try:
            return _parse(text, part)
        except ValueError:
            continue
    raise ValueError(text)
