"""Fields of the backend, seen without a copy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

if TYPE_CHECKING:
    from . import _core


#: Methods of NumPy's arrays that a view has too.
REDUCTIONS = ("all", "any", "argmax", "argmin", "max", "mean", "min", "std", "sum", "var")


class FieldView(NDArrayOperatorsMixin):
    """A read-only view of a field in the backend's memory, valid until the run's next step.

    In host memory it acts as a NumPy array: it can be indexed, used in expressions and passed to NumPy's functions. After the
    next step every use raises StaleView; `run.fields[name]` returns a new view. `copy()` returns an independent array.
    In GPU memory, CuPy and torch read the view by `from_dlpack` without a copy, and `copy()` transfers it to the host.
    """

    def __init__(self, core: _core.Field):
        self._core = core

    @property
    def name(self) -> str:
        return self._core.name

    @property
    def unit(self) -> str:
        """Unit as in the table of fields: "m", "quanta", "1", …"""
        return self._core.unit

    @property
    def shape(self) -> tuple[int, ...]:
        return self._core.shape

    @property
    def ndim(self) -> int:
        return len(self.shape)

    @property
    def size(self) -> int:
        return int(np.prod(self.shape))

    @property
    def dtype(self) -> np.dtype:
        return np.dtype(self._core.dtype_name)

    @property
    def memory(self) -> str:
        """Memory that contains the field: "host" or "cuda"."""
        return self._core.memory

    @property
    def address(self) -> int:
        """Address of the backend's own array."""
        return self._core.address

    @property
    def generation(self) -> int:
        """Counter of the run at the time when the view was created."""
        return self._core.generation

    @property
    def current(self) -> bool:
        """True until the run's next step."""
        return self._core.current

    def numpy(self) -> np.ndarray:
        """The backend's own array, read-only and without a copy.

        The array keeps the memory alive, but later steps may overwrite its values without notice. Raises StaleView, and
        TypeError if the field is on a GPU.
        """
        self._core.require_current()
        if self.memory != "host":
            raise TypeError(f"{self.name} is in the memory of a GPU: copy() fetches it, from_dlpack of CuPy and torch reads it there")
        return self._core.array()

    def copy(self) -> np.ndarray:
        """An independent copy in host memory."""
        return self._core.copy()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        array = self.numpy()
        if dtype is not None and np.dtype(dtype) != array.dtype:
            if copy is False:
                raise ValueError(f"{self.name} is of {array.dtype}: another type needs a copy")
            return array.astype(dtype)
        return array.copy() if copy else array

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if any(isinstance(out, FieldView) for out in kwargs.get("out", ())):
            raise TypeError("a field is read-only")
        return getattr(ufunc, method)(*(x.numpy() if isinstance(x, FieldView) else x for x in inputs), **kwargs)

    def __dlpack__(self, **kwargs: Any) -> Any:
        # Older libraries ask without a version, and know no read-only memory.
        return self._core.exchange(kwargs.get("max_version") is not None).__dlpack__(**kwargs)

    def __dlpack_device__(self) -> tuple[int, int]:
        return (1, 0) if self.memory == "host" else (2, 0)  # kDLCPU, kDLCUDA

    def __getitem__(self, key: Any) -> Any:
        return self.numpy()[key]

    def __getattr__(self, name: str) -> Any:
        if name in REDUCTIONS:
            return getattr(self.numpy(), name)
        hint = f": use numpy().{name}" if hasattr(np.ndarray, name) else ""
        raise AttributeError(f"a view of a field has no attribute {name!r}{hint}")

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[Any]:
        return iter(self.numpy())

    def __repr__(self) -> str:
        state = "" if self.current else ", stale"
        return f"<drench.FieldView {self.name} [{self.unit}] {self.dtype}{list(self.shape)} in {self.memory} memory{state}>"


class Fields(Mapping):
    """The fields of a run by name. Each access returns a current view."""

    def __init__(self, run: _core.Run):
        self._run = run

    def __getitem__(self, name: str) -> FieldView:
        return FieldView(self._run.field(name))

    def __iter__(self) -> Iterator[str]:
        return iter([field.name for field in self._run.fields()])

    def __len__(self) -> int:
        return len(self._run.fields())

    def __repr__(self) -> str:
        return "\n".join(repr(FieldView(field)) for field in self._run.fields())
