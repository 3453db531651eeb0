"""Find the physics that a simulator leaves out.

A model says ``M(q) q'' = F(q, q', u; p)``, the machine obeys ``... + r``, and Lacuna finds r: where it
acts, which physics it is, with numbers and units.

>>> import lacuna
>>> model = lacuna.Model.from_toml("model.toml")                                    # doctest: +SKIP
>>> runs = [lacuna.Recording(df, time="t", units={"q1": "deg"}) for df in frames]   # doctest: +SKIP
>>> d = lacuna.diagnose(model, runs)                                                # doctest: +SKIP
>>> d.verdict, d.findings                                                           # doctest: +SKIP
>>> d.report("report.html")                                                         # doctest: +SKIP
"""

from . import fleet
from ._diagnosis import Diagnosis, Estimate, Finding, Rival, diagnose
from ._difference import Difference, compare_runs
from ._fmu import name_this_interpreter as _name_this_interpreter
from ._identifier import Identifier
from ._lacuna import LacunaError
from ._model import Model, Parameter
from ._recording import Recording
from ._runs import Check, Comparison, Simulation, check, compare, simulate

__all__ = [
    "Check",
    "Comparison",
    "Diagnosis",
    "Difference",
    "Estimate",
    "Finding",
    "Identifier",
    "LacunaError",
    "Model",
    "Parameter",
    "Recording",
    "Rival",
    "Simulation",
    "check",
    "compare",
    "compare_runs",
    "diagnose",
    "fleet",
    "simulate",
]

_name_this_interpreter()
