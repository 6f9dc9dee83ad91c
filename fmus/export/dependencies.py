"""Dependencies of each unknown of a component with their kinds, for the ModelStructure of an FMU;
exact, from the equations.

An output depends on the symbols of its expression. A derivative depends on those of every rate that its mass
matrix couples to it, M x' = f, and on those of that part of the matrix. The kind of a dependency is that of the
slope: `constant`, `fixed` and `tunable` by the parameters in it, else `dependent`.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import sympy
from scipy.sparse.csgraph import connected_components

from fmus.equations.sympy_form import switching
from fmus.export.interface import Interface


@dataclass(frozen=True)
class Dependence:
    """An unknown's name, and the kind of each dependency by name in the order of the value references."""

    unknown: str
    kinds: dict[str, str]


@dataclass(frozen=True)
class _Unknown:
    name: str
    expressions: list[sympy.Expr]
    factors: set[sympy.Symbol]

    @property
    def symbols(self) -> set[sympy.Symbol]:
        return self.factors.union(*(e.free_symbols for e in self.expressions))


def outputs(interface: Interface) -> list[Dependence]:
    """Dependence of every output on time, inputs and states."""
    return [Dependence(u.name, _kinds(interface, u)) for u in _outputs(interface)]


def derivatives(interface: Interface) -> list[Dependence]:
    """Dependence of every derivative on time, inputs and states."""
    kinds: dict[tuple[sympy.Expr, ...], dict[str, str]] = {}  # of a block that the mass matrix couples
    found = []
    for unknown in _derivatives(interface):
        block = tuple(unknown.expressions)
        if block not in kinds:
            kinds[block] = _kinds(interface, unknown)
        found.append(Dependence(unknown.name, kinds[block]))
    return found


def initial_unknowns(interface: Interface) -> list[tuple[str, list[str]]]:
    """(unknown, names of its dependencies) of outputs, derivatives and calculated parameters at initialisation."""
    form = interface.form
    exposed = {v.name for v in interface.of("state")}
    unknowns = [u for u in _outputs(interface) if u.name not in exposed] + _derivatives(interface)
    calculated = zip(interface.component.rows("calculated"), form.calculated, strict=True)
    unknowns += [_Unknown(name, [e], set()) for name, e in calculated]
    known = ("time", "parameter", "input", "state")
    found = [(u.name, _names(interface, u.symbols, known)) for u in unknowns]
    return sorted(found, key=lambda pair: interface.reference(pair[0]))


def _outputs(interface: Interface) -> list[_Unknown]:
    return [_Unknown(n, [e], set()) for n, e in zip(interface.component.outputs, interface.form.outputs, strict=True)]


def _derivatives(interface: Interface) -> list[_Unknown]:
    form, states = interface.form, interface.component.states
    if not states:
        return []
    coupled = np.array([[entry != 0 for entry in row] for row in form.mass.tolist()], int)
    _, block_of = connected_components(coupled, directed=False)
    unknowns = []
    for i, name in enumerate(states):
        block = [j for j in range(len(states)) if block_of[j] == block_of[i]]
        factors = form.mass.extract(block, block).free_symbols
        unknowns.append(_Unknown(f"der({name})", [form.rates[j] for j in block], factors))
    return unknowns


def _names(interface: Interface, symbols: Iterable[sympy.Symbol], roles: tuple[str, ...]) -> list[str]:
    return [v.name for v in interface.of(*roles) if interface.form.symbols.get(v.name) in set(symbols)]


def _kinds(interface: Interface, unknown: _Unknown) -> dict[str, str]:
    """The kinds of an unknown's dependencies on time, inputs and states."""
    kinds = {}
    switches = switching(unknown.expressions)
    for name in _names(interface, unknown.symbols, ("time", "input", "state")):
        symbol = interface.form.symbols[name]
        if symbol in unknown.factors | switches:
            kinds[name] = "dependent"
            continue
        slopes = [e.diff(symbol) for e in unknown.expressions]
        if any(slope != 0 for slope in slopes):
            kinds[name] = _kind(interface, unknown.factors.union(*(s.free_symbols for s in slopes)))
    return kinds


def _kind(interface: Interface, symbols: set[sympy.Symbol]) -> str:
    if _names(interface, symbols, ("time", "input", "state")):
        return "dependent"
    rows = [interface.component.table[n] for n in _names(interface, symbols, ("parameter",))]
    if any(row.tunable for row in rows):
        return "tunable"
    return "fixed" if rows else "constant"
