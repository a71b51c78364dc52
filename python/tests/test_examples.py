"""The examples of the package run, and show what they say."""

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


def test_the_script_shakes_a_wet_cloth(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["shake_cloth.py", "--until", "0.5", "--csv", str(tmp_path / "force.csv")])
    runpy.run_path(str(EXAMPLES / "shake_cloth.py"), run_name="__main__")
    rows = (tmp_path / "force.csv").read_text().splitlines()
    assert rows[0] == "time,height,force_x,force_y,force_z" and len(rows) > 100
    assert "largest force" in capsys.readouterr().out


def test_the_gripper_carries_the_wet_towel(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["dip_towel.py", "--csv", str(tmp_path / "wrench.csv")])
    runpy.run_path(str(EXAMPLES / "dip_towel.py"), run_name="__main__")
    assert "wet: the gripper carries" in capsys.readouterr().out
    data = np.loadtxt(tmp_path / "wrench.csv", delimiter=",", skiprows=1)
    at_rest = data[data[:, 0] > 4.0].mean(axis=0)
    assert at_rest[4] > 2 * data[0, 4]  # it has taken up water
    assert -at_rest[2] == pytest.approx(at_rest[4], rel=0.01)


def test_mujocos_motor_carries_the_wet_towel(capsys):
    pytest.importorskip("mujoco")
    pytest.importorskip("gymnasium")
    runpy.run_path(str(EXAMPLES / "mujoco_dip.py"), run_name="__main__")
    dry, wet = ([float(word) for word in line.split() if word.replace(".", "").isdigit()]
                for line in capsys.readouterr().out.splitlines())
    assert dry[0] == pytest.approx(dry[1], rel=0.01) and wet[0] == pytest.approx(wet[1], rel=0.01)
    assert wet[1] > dry[1] + 0.05


def test_newtons_arm_carries_the_wet_towel(capsys):
    pytest.importorskip("newton")
    pytest.importorskip("gymnasium")
    runpy.run_path(str(EXAMPLES / "newton_arm.py"), run_name="__main__")
    rows = {}
    for line in capsys.readouterr().out.splitlines():
        name, _, rest = line.partition(":")
        if name in ("dry", "lifted", "turned"):
            words = rest.replace(";", "").replace(",", "").split()
            rows[name] = [float(word) for word in words if word.replace(".", "").isdigit()]
    assert list(rows) == ["dry", "lifted", "turned"]
    for base, weight, drives, towel, _ in rows.values():
        assert base == pytest.approx(weight, rel=1e-3) and drives == pytest.approx(towel, rel=0.01)
    dry, lifted, turned = (row[4] for row in rows.values())
    assert dry == 0 and lifted > 10 and 5 < turned < lifted - 1  # g of water


def test_the_notebook_runs(tmp_path):
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    pytest.importorskip("matplotlib")
    notebook = nbformat.read(EXAMPLES / "sweep.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=600, resources={"metadata": {"path": tmp_path}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert not [output for output in outputs if output.output_type == "error"]
    assert [output for output in outputs if "image/png" in output.get("data", {})]
    assert [output for output in outputs if "drench" in output.get("data", {}).get("text/html", "")]
