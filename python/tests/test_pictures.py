"""The table in a notebook, and grids for pyvista."""

import numpy as np
import pytest

import drench


def test_the_table_tells_of_the_run(scene):
    run = drench.Simulation(scene)
    assert "0 of 0.3 s" in run._repr_html_()
    run.run_until(0.05)
    html = run._repr_html_()
    assert "0.05 of 0.3 s" in html and "particles" in html and "saturation" in html
    assert html.count("<table>") == html.count("</table>") == 1
    assert "<drench.Simulation scene: t = 0.05" in repr(run)
    assert "fluid_position [m] float" in repr(run.fields)
    named = drench.Simulation(drench.Scene(scene, name="<b>x</b>"))
    assert "<b>" not in named._repr_html_()


def test_pyvista_gets_every_field(scene):
    pytest.importorskip("pyvista")
    run = drench.Simulation(scene)
    run.run_until(0.05)
    blocks = run.to_pyvista()
    assert set(blocks.keys()) == {"fluid", "cloth", "boundary"}
    assert np.array_equal(blocks["fluid"].points, run.fields["fluid_position"])
    assert np.array_equal(blocks["fluid"].point_data["id"], run.fields["fluid_id"])
    cloth = blocks["cloth"]
    assert cloth.n_cells == len(run.triangles) == 2 * 16 * 16
    assert cloth.area == pytest.approx(0.16, rel=0.1)
    assert cloth.point_data["saturation"].max() == pytest.approx(run.last.saturation_max, rel=1e-6)
    before = blocks["fluid"].points.copy()
    run.step()
    assert np.array_equal(blocks["fluid"].points, before)  # a copy
