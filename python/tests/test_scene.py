"""Scenes from files, text and dicts, and the errors of the loader."""

import numpy as np
import pytest

import drench
from drench.scene import to_text


def test_a_dict_is_the_same_scene_as_its_file(tmp_path, scene):
    file = tmp_path / "scene.yaml"
    file.write_text(to_text(scene))
    assert drench.Scene(file).to_yaml() == drench.Scene(scene).to_yaml()
    assert drench.Scene.from_yaml(drench.Scene(scene).to_yaml()).to_yaml() == drench.Scene(scene).to_yaml()


def test_numpy_and_infinity_go_into_a_scene(scene):
    scene["fluid"]["spacing"] = np.float64(0.025)
    scene["fluid"]["sources"][1]["jet"]["velocity"] = np.array([0.0, -2.0, 0.0])
    scene["fluid"]["sources"][1]["jet"]["end"] = float("inf")
    text = drench.Scene(scene).to_yaml()
    assert "spacing: 0.025" in text


def test_the_version_may_be_left_out_of_a_dict(scene):
    del scene["drench"]
    assert drench.Scene(scene).end == 0.3


def test_overrides_replace_values(scene):
    assert drench.Scene(scene, {"time.end": 0.5, "cloth.0.stretch": 123}).end == 0.5
    assert "stretch: 123" in drench.Scene(scene, {"cloth.0.stretch": 123}).to_yaml()


def test_every_scene_of_the_package_loads():
    files = sorted(drench.scenes.glob("*.yaml"))
    assert len(files) > 10
    for file in files:
        drench.Scene(file)


@pytest.mark.parametrize("key, value, words", [
    ("spacing", -1, "fluid.spacing: "),
    ("spacin", 0.01, "did you mean 'spacing'?"),
    ("spacing", "wide", "fluid.spacing: "),
    ("spacing", float("nan"), "fluid.spacing: "),
])
def test_a_wrong_value_names_its_key(scene, key, value, words):
    del scene["fluid"]["spacing"]
    scene["fluid"][key] = value
    with pytest.raises(drench.SceneError) as error:
        drench.Scene(scene)
    assert words in str(error.value) and "\n" not in str(error.value)
    assert isinstance(error.value, ValueError) and isinstance(error.value, drench.Error)


def test_the_text_is_the_loaders_own(tmp_path):
    file = tmp_path / "bad.yaml"
    file.write_text("drench: 1\nfluid: {spacing: -1}\n")
    with pytest.raises(drench.SceneError, match=r"bad.yaml:2:18: fluid.spacing: "):
        drench.Simulation(file)
    with pytest.raises(drench.SceneError, match="none.yaml"):
        drench.Simulation(tmp_path / "none.yaml")


def test_a_scene_that_cannot_be_set_up_names_its_line(tmp_path, scene):
    scene["cloth"][0]["mesh"] = {"file": "none.obj"}
    file = tmp_path / "scene.yaml"
    file.write_text(to_text(scene))
    with pytest.raises(drench.Error, match="none.obj"):
        drench.Simulation(file)
    scene["cloth"][0]["mesh"] = {"grid": {"size": [0.4, 0.4], "nodes": [17, 17]}}
    scene["fluid"]["sources"][0]["block"]["max"] = [0.08, 5.0, 0.08]
    file.write_text(to_text(scene))
    with pytest.raises(drench.SetupError, match=r"scene.yaml:\d+:\d+: fluid.sources"):
        drench.Simulation(file)


def test_other_types_are_refused(scene):
    scene["fluid"]["spacing"] = {1, 2}
    with pytest.raises(TypeError, match="set"):
        drench.Scene(scene)
