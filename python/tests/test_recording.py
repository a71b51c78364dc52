"""The files that a run writes from Python: as those of the command, with a report and a picture."""

import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest

import drench


def pixels_of(path):
    """Height × width × 3 bytes of a PNG without interlacing."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlace = struct.unpack_from(">IIBBBBB", data, at + 8)
            assert (depth, color, interlace) == (8, 2, 0)
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + size]
        at += 12 + size
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 3 * width)
    image = np.zeros((height + 1, 3 * width + 3), np.uint8)
    for y, row in enumerate(rows):
        above = image[y]
        for x in range(3 * width):
            left, up, corner = int(image[y + 1, x]), int(above[x + 3]), int(above[x])
            near = (abs(up - corner), abs(left - corner), abs(left + up - 2 * corner))
            paeth = left if near[0] <= near[1] and near[0] <= near[2] else up if near[1] <= near[2] else corner
            image[y + 1, x + 3] = (int(row[1 + x]) + (0, left, up, (left + up) // 2, paeth)[row[0]]) % 256
    return image[1:, 3:].reshape(height, width, 3)


def without_times(path):
    """The rows of stats.csv without the columns of wall time."""
    rows = [line.split(",") for line in path.read_text().splitlines()]
    keep = [k for k, name in enumerate(rows[0]) if not name.startswith("ms_")]
    return [[row[k] for k in keep] for row in rows]


def test_files_are_those_of_the_command(scene, program, tmp_path):
    scene["time"]["end"] = 0.07
    (tmp_path / "scene.yaml").write_text(drench.Scene(scene).to_yaml())
    process = subprocess.run([program, "run", "scene.yaml", "-o", "command", "--quiet"], cwd=tmp_path, capture_output=True, text=True)
    assert process.returncode == 0, process.stderr
    run = drench.Simulation(tmp_path / "scene.yaml")
    with run.record(tmp_path / "python"):
        for _ in run:
            pass
    ours, theirs = tmp_path / "python", tmp_path / "command"
    names = {path.relative_to(theirs) for path in theirs.rglob("*") if path.is_file() and path.suffix != ".drench"}
    assert {path.relative_to(ours) for path in ours.rglob("*") if path.is_file()} == names | {(ours / "report.html").relative_to(ours)}
    for name in sorted(names):
        if name.suffix in (".vtu", ".pvd") or name.name == "energy.csv":
            assert (ours / name).read_bytes() == (theirs / name).read_bytes(), name
    assert without_times(ours / "stats.csv") == without_times(theirs / "stats.csv")


def test_report_and_picture(scene, tmp_path):
    scene["time"]["end"] = 0.06
    run = drench.Simulation(scene)
    recording = run.record(tmp_path / "run")
    with recording:
        run.run_until(0.05)  # between two frames
    recording.close()
    page = (tmp_path / "run/report.html").read_text()
    assert f"{run.steps} steps" in page or str(run.steps) in page
    assert "data:image/jpeg" in page
    assert "0.05" in (tmp_path / "run/fluid.pvd").read_text()
    assert drench.write_report(tmp_path / "run", tmp_path / "page.html") == tmp_path / "page.html"
    image = pixels_of(drench.write_picture(tmp_path / "run", tmp_path / "a.png", size=(160, 120)))
    assert image.shape == (120, 160, 3)
    blue = (image[..., 2].astype(int) - image[..., 0] > 60).mean()
    assert blue > 0.005  # liquid
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 100
    run.step()  # recorded no more
    assert "0.06" not in (tmp_path / "run/fluid.pvd").read_text()


def test_recording_refuses(scene, tmp_path):
    run = drench.Simulation(scene)
    (tmp_path / "full").mkdir()
    (tmp_path / "full/mine.txt").write_text("mine")
    for overwrite in (False, True):
        with pytest.raises(drench.Error, match="is not empty") as error:
            run.record(tmp_path / "full", overwrite=overwrite)
        assert " -" not in str(error.value)  # no options of the command
    with run.record(tmp_path / "run"):
        with pytest.raises(RuntimeError, match="being recorded already"):
            run.record(tmp_path / "other")
        run.save_checkpoint(tmp_path / "c.drench")
        with pytest.raises(RuntimeError, match="being recorded"):
            run.resume(tmp_path / "c.drench")
        run.step()
    with pytest.raises(drench.Error, match="is not empty"):
        run.record(tmp_path / "run")
    with run.record(tmp_path / "run", overwrite=True):
        run.step()
    with pytest.raises(drench.Error, match="no output of a run"):
        drench.write_report(tmp_path / "full")
    with pytest.raises(drench.Error, match="no such folder"):
        drench.write_picture(tmp_path / "none", tmp_path / "a.png")
    with pytest.raises(ValueError, match="16 to 4096"):
        drench.write_picture(tmp_path / "run", tmp_path / "a.png", size=(0, 10))


def test_a_failed_run_has_a_report(scene, tmp_path):
    scene["cloth"][0].update(stretch=1e9, bend=1.0)
    scene["fluid"]["solver"] = {"max_iterations": 2, "min_iterations": 1}
    scene["output"]["every"] = 0
    run = drench.Simulation(scene, {"time.step": 0.2, "time.end": 200.0})
    with pytest.raises(drench.RunFailure) as failure, run.record(tmp_path / "run"):
        for _ in range(1000):
            run.step()
    assert f"at step {failure.value.step} " in (tmp_path / "run/run.log").read_text()
    assert "failed" in (tmp_path / "run/report.html").read_text()


def demo(*words, **options):
    return subprocess.run([sys.executable, "-m", "drench.demo", *words], capture_output=True, text=True, **options)


def test_demo_writes_a_picture_and_a_report(tmp_path):
    process = demo("--until", "0.25", "--steps", "60", "--threads", "1", cwd=tmp_path)
    assert process.returncode == 0 and process.stderr == "", process.stderr
    lines = process.stdout.splitlines()
    assert lines[0].startswith(f"drench {drench.__version__} (")
    assert any("backend" in line for line in lines) and any("threads 1" in line for line in lines)
    assert sum(line.startswith("t = ") for line in lines) >= 5
    folder = tmp_path / "drench_demo"
    assert f"picture in {folder.name}/picture.png" in lines and (folder / "picture.png").stat().st_size > 5000
    assert "data:image/jpeg" in (folder / "report.html").read_text()
    again = demo("--steps", "1", cwd=tmp_path)
    assert again.returncode == 2 and "drench_demo: is not empty" in again.stderr and again.stderr.count("\n") == 1
    assert demo("--steps", "1", "--overwrite", cwd=tmp_path).returncode == 0


@pytest.mark.parametrize("words, said", [
    (["--until", "0"], "--until: '0' is not a time"),
    (["--until", "soon"], "'soon' is not a time"),
    (["--steps", "1.5"], "'1.5' is not a whole number"),
    (["--threads", "-1"], "'-1' is not a whole number"),
    (["--output"], "expected one argument"),
    (["--speed", "2"], "unrecognized arguments: --speed 2"),
    (["-o", "/proc/none"], "/proc/none: cannot be made"),
])
def test_demo_rejects(words, said, tmp_path):
    process = demo(*words, cwd=tmp_path)
    assert process.returncode == 2
    assert said in process.stderr and process.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
