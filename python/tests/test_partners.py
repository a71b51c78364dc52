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


def test_a_simple_policy_is_rewarded_and_its_episode_is_deterministic():
    gymnasium = pytest.importorskip("gymnasium")
    env = gymnasium.make("drench.envs:TowelDip-v0")
    episodes = []
    for _ in range(2):
        observation, _ = env.reset(seed=1)
        observations, over, lifting = [observation], False, False
        while not over:
            lifting = lifting or observation[10] >= observation[11]  # the towel holds the wanted mass
            observation, reward, _, over, _ = env.step(np.array([0, 1 if lifting else -0.3, 0], np.float32))
            observations.append(observation)
        episodes.append(np.array(observations))
    assert reward > 0.9 and lifting
    assert np.array_equal(*episodes)
    for target in (np.nan, 0, 5):
        with pytest.raises(ValueError, match="target"):
            env.reset(options={"target": target})


def test_environments_run_side_by_side():
    gymnasium = pytest.importorskip("gymnasium")
    env = gymnasium.make_vec("drench.envs:TowelDip-v0", num_envs=2, vectorization_mode="sync", spacing=0.03, seconds=0.08)
    first, _ = env.reset(seed=3)
    assert first.shape == (2, 12) and first[0, 11] != first[1, 11]
    for over in (False, True):
        _, rewards, _, truncated, _ = env.step(np.zeros((2, 3), np.float32))
        assert rewards.shape == (2,) and (truncated == over).all()
    env.close()


def test_write_gives_the_files_of_the_command_with_a_bar(tmp_path, scene, capsys):
    pytest.importorskip("tqdm")
    scene["time"]["end"] = 0.04
    report = drench.Simulation(scene).write(tmp_path / "out", progress=True)
    assert report.exists() and (tmp_path / "out" / "stats.csv").read_text().count("\n") == 21
    assert "100%" in capsys.readouterr().err
