"""A function as equations: called once with symbols in the place of numbers.

NumPy does arithmetic on arrays of any objects and asks these for elementary functions, so that a function
that is made of nothing else says what it computes. One that looks at the numbers (a branch, a table, a solver)
raises instead, and stays a function.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np

from ._toml import parameter, quoted, recordings, said

#: What NumPy calls an elementary function, and what expressions call it.
ELEMENTARY = {
    "sin": "sin",
    "cos": "cos",
    "tan": "tan",
    "arcsin": "asin",
    "arccos": "acos",
    "arctan": "atan",
    "sinh": "sinh",
    "cosh": "cosh",
    "tanh": "tanh",
    "exp": "exp",
    "log": "log",
    "sqrt": "sqrt",
    "fabs": "abs",
}
#: Most characters of an expression within another.
LONGEST = 500


class NoEquation(Exception):
    """The function does more than arithmetic and elementary functions."""


class Symbol:
    """A number that is not known: an expression, and those that it is made of."""

    __slots__ = ("parts", "template")

    def __init__(self, template: str, *parts: Symbol) -> None:
        self.template = template
        self.parts = parts

    @staticmethod
    def of(value: Any) -> Symbol:
        """A number, or what is a symbol already."""
        if isinstance(value, Symbol):
            return value
        number = float(value)
        if not np.isfinite(number):
            raise NoEquation
        return Symbol(repr(number) if number >= 0.0 else f"({number!r})")

    def __add__(self, other: Any) -> Symbol:
        return Symbol("({} + {})", self, Symbol.of(other))

    def __radd__(self, other: Any) -> Symbol:
        return Symbol.of(other) + self

    def __sub__(self, other: Any) -> Symbol:
        return Symbol("({} - {})", self, Symbol.of(other))

    def __rsub__(self, other: Any) -> Symbol:
        return Symbol.of(other) - self

    def __mul__(self, other: Any) -> Symbol:
        return Symbol("({} * {})", self, Symbol.of(other))

    def __rmul__(self, other: Any) -> Symbol:
        return Symbol.of(other) * self

    def __truediv__(self, other: Any) -> Symbol:
        return Symbol("({} / {})", self, Symbol.of(other))

    def __rtruediv__(self, other: Any) -> Symbol:
        return Symbol.of(other) / self

    def __pow__(self, other: Any) -> Symbol:
        return Symbol("({} ^ {})", self, Symbol.of(other))

    def __rpow__(self, other: Any) -> Symbol:
        return Symbol.of(other) ** self

    def __neg__(self) -> Symbol:
        return Symbol("(-{})", self)

    def __pos__(self) -> Symbol:
        return self

    def __abs__(self) -> Symbol:
        return Symbol("abs({})", self)

    def arctan2(self, other: Any) -> Symbol:
        return Symbol("atan2({}, {})", self, Symbol.of(other))

    def hypot(self, other: Any) -> Symbol:
        return Symbol("sqrt({})", self * self + Symbol.of(other) ** 2)

    def _unknown(self, *_: Any) -> Any:
        raise NoEquation

    __bool__ = __float__ = __int__ = __index__ = _unknown
    __lt__ = __le__ = __gt__ = __ge__ = __eq__ = __ne__ = _unknown
    __hash__ = object.__hash__


def _elementary(name: str) -> Callable[[Symbol], Symbol]:
    return lambda self: Symbol(name + "({})", self)


for _called, _name in ELEMENTARY.items():
    setattr(Symbol, _called, _elementary(_name))


def _largest(a: Any, b: Any) -> Symbol:
    return Symbol("max({}, {})", Symbol.of(a), Symbol.of(b))


def _smallest(a: Any, b: Any) -> Symbol:
    return Symbol("min({}, {})", Symbol.of(a), Symbol.of(b))


#: Functions for which NumPy would compare the objects.
COMPARING: dict[str, Callable[..., Symbol]] = {
    "maximum": _largest,
    "fmax": _largest,
    "minimum": _smallest,
    "fmin": _smallest,
    "sign": lambda a: Symbol("sign({})", Symbol.of(a)),
    "clip": lambda a, low, high: _smallest(_largest(a, low), high),
}


class Symbols(np.ndarray):
    """An array of symbols, for functions that compare: NumPy would ask which is larger."""

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **kwargs: Any) -> Any:
        plain = [np.asarray(i) if isinstance(i, Symbols) else i for i in inputs]
        if kwargs.get("out"):
            kwargs["out"] = tuple(np.asarray(o) if isinstance(o, Symbols) else o for o in kwargs["out"])
        compared = COMPARING.get(ufunc.__name__)
        if compared is not None and method == "__call__":
            result = np.frompyfunc(compared, ufunc.nin, 1)(*plain)
        else:
            result = getattr(ufunc, method)(*plain, **kwargs)
        return _symbols(result) if isinstance(result, np.ndarray) and result.dtype == object else result


def _symbols(values: Any) -> Symbols:
    return np.asarray(values, dtype=object).view(Symbols)


class Equations:
    """The text of a model of equations that functions compute."""

    def __init__(self, described: dict[str, Any]) -> None:
        self._described = described
        coordinates = described["coordinates"]
        self._names = {
            "z": [c[0] for c in coordinates] + [c[1] for c in coordinates] + [s[0] for s in described["states"]],
            "u": [i[0] for i in described["inputs"]],
            "p": [p[0] for p in described["parameters"]],
            "t": ["t"],
        }
        taken = [name for names in list(self._names.values())[:3] for name in names]
        if "t" in taken:
            raise NoEquation
        self._stem = next(s for s in ("part", "part_", "part__") if not any(t.startswith(s) for t in taken))
        self._defined: dict[str, str] = {}
        self._shared: dict[str, str] = {}

    def text(self, rates: Callable[..., Any], mass: Callable[..., Any] | None, force_units: list[str]) -> str:
        """A model file. The functions give arrays with a row a point.

        Raises
        ------
        Exception
            Whatever a function raises that does more than arithmetic.
        """
        described, n = self._described, len(self._described["coordinates"])
        forces = self._expressions(rates)
        unit = [["1" if i == j else "0" for j in range(n)] for i in range(n)]
        masses = unit if mass is None else np.reshape(self._expressions(mass), (n, n)).tolist()
        lines = [f"name = {quoted(described['name'])}", "[parameters]"]
        lines += [parameter(*p) for p in described["parameters"]]
        if self._defined:
            lines += ["[define]", *(f"{name} = {quoted(text)}" for name, text in self._defined.items())]
        for name, unit_of in described["inputs"]:
            lines += ["[[input]]", *said(name=name, unit=unit_of)]
        for (name, velocity, unit_of, _), force in zip(described["coordinates"], force_units):
            lines += ["[[coordinate]]", *said(name=name, velocity=velocity, unit=unit_of, force_unit=force)]
        if n:
            lines += ["[mechanics]", f"mass = {json.dumps(masses)}", f"force = {json.dumps(forces[:n])}"]
        for (name, unit_of), derivative in zip(described["states"], forces[n:]):
            lines += ["[[state]]", *said(name=name, unit=unit_of, derivative=derivative)]
        lines += recordings(described)
        return "\n".join(lines) + "\n"

    def _expressions(self, function: Callable[..., Any]) -> list[str]:
        """What a function computes of a point. It is asked for two, so that it cannot take one for all."""
        named = [[[Symbol(name) for name in names] for names in self._names.values()] for _ in range(2)]
        z, u, p, t = (_symbols([point[k] for point in named]).reshape(2, -1) for k in range(4))
        given = np.asarray(function(z, u, p, t[:, 0]), dtype=object)
        others = {id(symbol) for names in named[1] for symbol in names}
        return [self._expression(Symbol.of(value), others) for value in given[0].ravel()]

    def _expression(self, top: Symbol, others: set[int]) -> str:
        """A symbol as text. What stands in several places is defined once."""
        uses = _uses(top)
        texts: dict[int, str] = {}
        for symbol in _in_order(top):
            if id(symbol) in others:
                raise NoEquation
            text = symbol.template.format(*(texts[id(part)] for part in symbol.parts))
            # A long one too: what it stands in stays a line that can be read.
            if symbol.parts and (uses[id(symbol)] > 1 or len(text) > LONGEST):
                text = self._define(text)
            texts[id(symbol)] = text
        return texts[id(top)]

    def _define(self, text: str) -> str:
        if text not in self._shared:
            name = f"{self._stem}{len(self._defined) + 1}"
            self._shared[text] = name
            self._defined[name] = text
        return self._shared[text]


def _in_order(top: Symbol) -> list[Symbol]:
    """All symbols that one is made of, parts first."""
    order: list[Symbol] = []
    seen: set[int] = set()
    waiting = [(top, False)]
    while waiting:
        symbol, ready = waiting.pop()
        if ready:
            order.append(symbol)
        elif id(symbol) not in seen:
            seen.add(id(symbol))
            waiting.append((symbol, True))
            waiting.extend((part, False) for part in symbol.parts)
    return order


def _uses(top: Symbol) -> dict[int, int]:
    uses = {id(top): 1}
    for symbol in _in_order(top):
        for part in symbol.parts:
            uses[id(part)] = uses.get(id(part), 0) + 1
    return uses
