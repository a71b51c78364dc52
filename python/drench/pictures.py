"""A run as a table in a notebook, and as grids for pyvista."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from .simulation import Simulation


def _rows(run: Simulation) -> list[tuple[str, str]]:
    step = run.last
    rows = [("time", f"{run.time:.6g} of {run.scene.end:g} s"), ("steps", str(run.steps))]
    fields = {name: len(run.fields[name]) for name in run.fields}
    for owner, title in (("fluid", "particles"), ("node", "cloth nodes"), ("body", "bodies")):
        if f"{owner}_position" in fields:
            rows.append((title, f"{fields[owner + '_position']:,}"))
    if step is not None:
        kilograms = {name: step[f"mass_{name}"] * run.quantum for name in ("fluid", "cloth", "drained")}
        rows.append(("liquid", ", ".join(f"{value:.4g} kg {name}" for name, value in kilograms.items())))
        if "node_liquid" in fields:
            rows.append(("wettest node", f"saturation {step.saturation_max:.3g}"))
        rows.append(("last step", f"{step.dt:.3g} s, {step.density_iterations} iterations of the density solve, "
                                  f"compression {step.density_error:.2g}"))
    return rows


def to_html(run: Simulation) -> str:
    """A table with a bar for the time."""
    part = min(1.0, run.time / run.scene.end) if run.scene.end > 0 else 1.0
    cells = "".join(f"<tr><th style='text-align:left'>{escape(name)}</th><td style='text-align:left'>{escape(text)}</td></tr>"
                    for name, text in _rows(run))
    notes = "".join(f"<li>{escape(text)}</li>" for text in run.warnings)
    return (f"<div><strong>drench</strong> {escape(run.scene.path)}"
            f"<div style='width:20em;height:.5em;background:#ddd'><div style='width:{100 * part:.1f}%;height:100%;background:#27c'>"
            f"</div></div><table>{cells}</table>" + (f"<ul>{notes}</ul>" if notes else "") + "</div>")


def _add(grid: Any, run: Simulation, owner: str) -> None:
    for name in run.fields:
        if name.startswith(owner + "_") and not name.endswith("_position"):
            grid.point_data[name[len(owner) + 1:]] = run.fields[name].copy()


def to_pyvista(run: Simulation) -> Any:
    """The liquid's particles, the cloths' triangles, and the samples of the bodies, each with its fields."""
    try:
        import pyvista
    except ImportError:
        raise ImportError("to_pyvista needs pyvista: pip install pyvista") from None
    blocks = pyvista.MultiBlock()
    if "fluid_position" in run.fields:
        fluid = pyvista.PolyData(run.fields["fluid_position"].copy())
        _add(fluid, run, "fluid")
        fluid.point_data["radius"] = np.full(fluid.n_points, 0.5 * run.scene.particle_diameter, np.float32)
        blocks["fluid"] = fluid
    if "node_position" in run.fields:
        triangles = run.triangles
        faces = np.column_stack([np.full(len(triangles), 3, triangles.dtype), triangles]).ravel()
        cloth = pyvista.PolyData(run.fields["node_position"].copy(), faces)
        _add(cloth, run, "node")
        cloth.point_data["saturation"] = run.saturation()
        blocks["cloth"] = cloth
    if "boundary_position" in run.fields:
        boundary = pyvista.PolyData(run.fields["boundary_position"].copy())
        _add(boundary, run, "boundary")
        blocks["boundary"] = boundary
    return blocks
