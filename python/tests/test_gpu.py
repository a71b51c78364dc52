"""Arrays on a GPU, read there by torch and CuPy."""

import numpy as np
import pytest

import drench

pytestmark = pytest.mark.skipif(drench.info()["backend"] != "Cuda", reason="this build computes on a host")


@pytest.fixture
def run(scene):
    run = drench.Simulation(scene)
    run.run_until(0.01)
    return run


def check(run, library, address_of, to_numpy):
    state = run.state()
    order = np.argsort(run.fields["fluid_id"].copy())
    for name in run.fields:
        view = run.fields[name]
        if view.memory == "host":
            continue
        array = library.from_dlpack(view)
        assert address_of(array) == view.address and tuple(array.shape) == view.shape
        values = to_numpy(array)
        values = values[order] if name.startswith("fluid_") else values
        assert np.array_equal(values.astype(state[name].dtype), state[name]), name
        assert np.array_equal(view.copy(), to_numpy(array)), name


def test_torch_reads_a_view_where_it_lies(run):
    torch = pytest.importorskip("torch")
    check(run, torch, lambda a: a.data_ptr(), lambda a: a.cpu().numpy())
    kept = torch.from_dlpack(run.fields["fluid_position"])
    del run
    assert torch.isfinite(kept).all()


def test_cupy_reads_a_view_where_it_lies(run):
    cupy = pytest.importorskip("cupy")
    check(run, cupy, lambda a: a.data.ptr, cupy.asnumpy)


def test_numpy_says_that_a_view_is_on_a_gpu(run):
    view = run.fields["fluid_position"]
    assert view.__dlpack_device__()[0] == 2
    with pytest.raises(TypeError, match="GPU"):
        np.asarray(view)
    assert np.isfinite(view.copy()).all()
    run.step()
    with pytest.raises(drench.StaleView):
        view.copy()
