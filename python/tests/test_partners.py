"""drench beside other packages: Gymnasium's checker, a bar of tqdm."""

import numpy as np
import pytest

import drench


def test_the_environment_passes_gymnasiums_checker():
    gymnasium = pytest.importorskip("gymnasium")
    from gymnasium.utils.env_checker import check_env
    env = gymnasium.make("drench.envs:TowelDip-v0", spacing=0.03, seconds=0.2)
    check_env(env.unwrapped, skip_render_check=True)
    env.close()


def test_a_dipped_towel_takes_up_water_and_pulls_at_the_gripper():
    gymnasium = pytest.importorskip("gymnasium")
    env = gymnasium.make("drench.envs:TowelDip-v0", spacing=0.025, seconds=1.2)
    first, _ = env.reset(seed=3)
    rewards, over = [], False
    while not over:
        time = env.unwrapped.run.time
        observation, reward, _, over, info = env.step(np.array([0, -1 if time < 0.5 else 1, 0], np.float32))
        rewards.append(reward)
    assert info["water"] > 0.2 * env.unwrapped.capacity and observation[7] < 0
    assert max(rewards) > rewards[0]
    again, _ = env.reset(seed=3)
    assert np.array_equal(first, again)


def test_write_gives_the_files_of_the_command_with_a_bar(tmp_path, scene, capsys):
    pytest.importorskip("tqdm")
    scene["time"]["end"] = 0.04
    report = drench.Simulation(scene).write(tmp_path / "out", progress=True)
    assert report.exists() and (tmp_path / "out" / "stats.csv").read_text().count("\n") == 21
    assert "100%" in capsys.readouterr().err
