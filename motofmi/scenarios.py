"""The scenarios of a checkout, whose folder stands beside this package. In a wheel they are the
package `motofmi.scenarios`.

A folder `motofmi/scenarios/` takes precedence over this module, so that the wheel needs no other code.
"""

from pathlib import Path

__path__ = [str(Path(__file__).parent.parent / "scenarios")]
